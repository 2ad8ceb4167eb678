//! `stress`: the method at the ends of what it can be asked, on the device at hand; or a scene at the ends of its ranges.

use super::compare::Failed;
use super::scene_arguments::{ObjectFlags, SceneArguments};
use super::{absolute, announced, say};
use clap::Args;
use hypertexture::gpu::{Gpu, Options};
use measure::stress::{self, CASES, Corner, Row, Swept};
use measure::verify;
use std::error::Error;
use std::path::PathBuf;
use support::{quoted, write_whole};

/// Arguments of `stress`.
#[derive(Args)]
pub struct Stress {
    /// What `render` takes: its own parameters are swept; without it, the cases that are known to go wrong.
    pub input: Option<String>,
    /// Only these cases, by their numbers, such as 10,12.
    #[arg(long, value_delimiter = ',', value_name = "NUMBERS", conflicts_with = "input")]
    pub cases: Vec<u32>,
    /// Writes the rows into this file too, as JSON.
    #[arg(long, value_name = "FILE", conflicts_with = "input")]
    pub json: Option<PathBuf>,
    /// Writes a page into this file too, with error against stiffness.
    #[arg(long, value_name = "FILE", conflicts_with = "input")]
    pub html: Option<PathBuf>,
    /// The object.
    #[command(flatten)]
    pub object: ObjectFlags,
    /// What the picture shows.
    #[command(flatten)]
    pub arguments: SceneArguments,
}

/// Stresses the device, or a scene.
pub(super) fn run(command: &Stress, options: &Options, quiet: bool) -> Result<(), Box<dyn Error>> {
    match &command.input {
        None => cases(command, options, quiet),
        Some(input) => scene(command, input, options, quiet),
    }
}

fn cases(command: &Stress, options: &Options, quiet: bool) -> Result<(), Box<dyn Error>> {
    if let Some(unknown) = command.cases.iter().find(|number| !CASES.iter().any(|case| case.number == **number)) {
        return Err(format!("--cases {unknown}: there is no such case; there are 1 to {}", CASES.len()).into());
    }
    let chosen = CASES.iter().filter(|case| command.cases.is_empty() || command.cases.contains(&case.number));
    let chosen: Vec<stress::Case> = chosen.copied().collect();
    let written = [("--json", &command.json), ("--html", &command.html)];
    let written = written.into_iter().filter_map(|(flag, file)| Some((flag, file.clone()?)));
    hypertexture::output::check_all(written, [])?;
    let gpu = Gpu::new(options)?;
    let found = announced(quiet, "stress", |progress| stress::run(&gpu, verify::library(), &chosen, progress))?;
    let failed: Vec<String> = found.failed().map(Row::title).collect();
    if !quiet {
        let held = found.rows.len() - failed.len();
        say(&format!("{}{held} of {} rows hold on {}\n", stress::table(&found), found.rows.len(), gpu.info().title()));
    }
    let json = command.json.as_ref().map(|path| Ok((path, serde_json::to_string_pretty(&found)?)));
    let html = command.html.as_ref().map(|path| Ok((path, stress::chart_page(&found))));
    for written in json.into_iter().chain(html) {
        let (path, text): (&PathBuf, String) = written.map_err(|error: serde_json::Error| error.to_string())?;
        write_whole(path, text.as_bytes())
            .map_err(|error| format!("{}: {error}; nothing was written", path.display()))?;
        if !quiet {
            say(&format!("wrote {}\n", absolute(path)));
        }
    }
    match failed.is_empty() {
        true => Ok(()),
        false => {
            Err(Failed(format!("{} of {} rows fail: {}", failed.len(), found.rows.len(), failed.join("; "))).into())
        }
    }
}

fn scene(command: &Stress, input: &str, options: &Options, quiet: bool) -> Result<(), Box<dyn Error>> {
    let scene = command.arguments.scene(input, &command.object)?;
    let library = super::library(&scene)?;
    super::try_modules(&scene, &library, Some(options))?;
    let gpu = Gpu::new(options)?;
    let found = announced(quiet, "sweep", |progress| stress::sweep(&gpu, &library, &scene, progress))?;
    if !quiet {
        say(&table(&found));
    }
    if let Some(worst) = found.worst.as_ref().filter(|_| !quiet) {
        let words = std::env::args().skip_while(|word| word != "stress").skip(1);
        let side = stress::SIDE;
        let shown = ["--set".into(), format!("image.size=[{side},{side}]"), "--error-map".into(), "worst.png".into()];
        let words: Vec<String> = words.chain(set(worst)).chain(shown).map(|word| quoted(&word)).collect();
        say(&format!("worst: {}\n  hypertexture render {}\n", verdict(worst), words.join(" ")));
    }
    match found.ok() {
        true => Ok(()),
        false => {
            let corners = found.corners.iter().chain(&found.worst).filter(|corner| !corner.ok);
            let corners =
                corners.map(|corner| format!("{}: {}", set(corner).collect::<Vec<_>>().join(" "), corner.why));
            let taken =
                found.taken.iter().map(|(name, value)| format!("{name} = {value} is beyond its range, and taken"));
            let twins = found.twins.iter().filter(|row| !row.ok());
            let twins = twins.map(|row| format!("{}: another picture, {}", row.setting, row.what));
            Err(Failed(corners.chain(twins).chain(taken).collect::<Vec<_>>().join("; ")).into())
        }
    }
}

/// The words that change a scene to what a corner is of.
fn set(corner: &Corner) -> impl Iterator<Item = String> + '_ {
    corner.changes.iter().flat_map(|(name, value)| ["--set".to_string(), format!("{name}={value}")])
}

fn verdict(corner: &Corner) -> String {
    let [samples, proof] = corner.known_to;
    let error = match corner.error {
        Some(error) => format!(
            "error {error:.1e}, known to {samples:.0e} as samples say, to {proof:.0e} by proof; jump {:.1e}",
            corner.jump
        ),
        None => String::new(),
    };
    [error, corner.why.clone()].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("; ")
}

fn table(found: &Swept) -> String {
    let name = |corner: &Corner| match corner.changes.as_slice() {
        [] => "the scene itself".to_string(),
        changes => changes.iter().map(|(name, value)| format!("{name} = {value}")).collect::<Vec<_>>().join(", "),
    };
    let width = found.corners.iter().map(|corner| name(corner).chars().count()).max().unwrap_or_default();
    let line = |corner: &Corner| {
        let mark = if corner.ok { "" } else { "FAIL " };
        format!("{:<width$}  {mark}{}\n", name(corner), verdict(corner))
    };
    let twin = |row: &Row| {
        let mark = if row.ok() { "same" } else { "FAIL other" };
        format!(
            "{:<width$}  {mark} picture, {}: off by {:.1e} of {:.0e}\n",
            row.setting, row.what, row.error, row.bound
        )
    };
    found.corners.iter().map(line).chain(found.twins.iter().map(twin)).collect()
}
