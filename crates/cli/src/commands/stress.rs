//! `stress`: the method at the limits of its ranges on the device at hand, or a scene at the limits of its parameters.

use crate::arguments::{ObjectFlags, SceneArguments};
use crate::session::{Failed, checked, try_in_sandbox};
use crate::terminal::{absolute, announced, say};
use clap::Args;
use hypertexture::gpu::{Gpu, Options};
use hypertexture_measure::cases::{self, Report, Row, Suite};
use hypertexture_measure::sweep::{self, Corner, Sweep};
use hypertexture_support::{quoted, write_whole};
use std::error::Error;
use std::path::PathBuf;

/// Arguments of `stress`.
#[derive(Args)]
pub struct Stress {
    /// Input as `render` takes it, whose parameters are swept; without it, the numbered cases.
    pub input: Option<String>,
    /// Runs only these cases, by their numbers, such as 10,12.
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
    /// The scene.
    #[command(flatten)]
    pub arguments: SceneArguments,
}

/// Stresses the device, or a scene.
pub(crate) fn run(command: &Stress, options: &Options, quiet: bool) -> Result<(), Box<dyn Error>> {
    match &command.input {
        None => device(command, options, quiet),
        Some(input) => scene(command, input, options, quiet),
    }
}

fn device(command: &Stress, options: &Options, quiet: bool) -> Result<(), Box<dyn Error>> {
    let all: Vec<cases::Case> = cases::suite(Suite::Stress).collect();
    if let Some(unknown) = command.cases.iter().find(|number| !all.iter().any(|case| case.number == **number)) {
        return Err(format!("--cases {unknown}: unknown case; the cases are 1 to {}", all.len()).into());
    }
    let chosen = all.into_iter().filter(|case| command.cases.is_empty() || command.cases.contains(&case.number));
    let chosen: Vec<cases::Case> = chosen.collect();
    let written = [("--json", &command.json), ("--html", &command.html)];
    let written = written.into_iter().filter_map(|(flag, file)| Some((flag, file.clone()?)));
    hypertexture::output::check_all(written, [])?;
    let gpus = cases::devices(Gpu::new(options)?, options)?;
    let report = announced(quiet, "stress", |progress| cases::run(&gpus, &cases::library(), &chosen, progress))?;
    let write = |path: &Option<PathBuf>, text: &dyn Fn() -> Result<String, serde_json::Error>| {
        let Some(path) = path else { return Ok(()) };
        write_whole(path, text().map_err(|error| error.to_string())?.as_bytes())
            .map_err(|error| format!("{}: {error}; nothing was written", path.display()))?;
        if !quiet {
            say(&format!("wrote {}\n", absolute(path)));
        }
        Ok::<(), String>(())
    };
    write(&command.json, &|| serde_json::to_string_pretty(&report))?;
    write(&command.html, &|| Ok(cases::chart_page(&report)))?;
    conclude(&report, &gpus[0], quiet)
}

/// Prints the table of a report; an error names the rows that fail.
pub(crate) fn conclude(report: &Report, gpu: &Gpu, quiet: bool) -> Result<(), Box<dyn Error>> {
    let failed: Vec<String> = report.failed().map(Row::title).collect();
    let all = report.rows.len();
    if !quiet {
        let device = gpu.info().title();
        say(&format!("{}{} of {all} rows hold on {device}\n", cases::table(report), all - failed.len()));
    }
    if failed.is_empty() {
        Ok(())
    } else {
        Err(Failed(format!("{} of {all} rows fail: {}", failed.len(), failed.join("; "))).into())
    }
}

fn scene(command: &Stress, input: &str, options: &Options, quiet: bool) -> Result<(), Box<dyn Error>> {
    let scene = command.arguments.scene(input, &command.object)?;
    let (variant, library) = checked(&scene)?;
    try_in_sandbox(&variant, &library, Some(options))?;
    let gpu = Gpu::new(options)?;
    let found = announced(quiet, "sweep", |progress| sweep::sweep(&gpu, &library, &scene, progress))?;
    if !quiet {
        say(&table(&found));
    }
    if let Some(worst) = found.worst.as_ref().filter(|_| !quiet) {
        let words = std::env::args().skip_while(|word| word != "stress").skip(1);
        let side = sweep::SIDE;
        let shown = ["--set".into(), format!("image.size=[{side},{side}]"), "--error-map".into(), "worst.png".into()];
        let words: Vec<String> = words.chain(set(worst)).chain(shown).map(|word| quoted(&word)).collect();
        say(&format!("worst: {}\n  hypertexture render {}\n", verdict(worst), words.join(" ")));
    }
    if found.ok() {
        Ok(())
    } else {
        let corners = found.corners.iter().chain(&found.worst).filter(|corner| !corner.ok);
        let corners = corners.map(|corner| format!("{}: {}", set(corner).collect::<Vec<_>>().join(" "), corner.why));
        let accepted = found.accepted.iter();
        let accepted = accepted.map(|(name, value)| format!("{name} = {value} is out of range, and accepted"));
        let changed = found.equivalences.iter().filter(|row| !row.ok);
        let changed = changed.map(|row| format!("{}: another picture, {}", row.setting, row.what));
        Err(Failed(corners.chain(changed).chain(accepted).collect::<Vec<_>>().join("; ")).into())
    }
}

/// Arguments that change the scene to a corner.
fn set(corner: &Corner) -> impl Iterator<Item = String> + '_ {
    corner.changes.iter().flat_map(|(name, value)| ["--set".to_string(), format!("{name}={value}")])
}

fn verdict(corner: &Corner) -> String {
    let [samples, proof] = corner.reference_error;
    let error = match corner.error {
        Some(error) => format!(
            "error {error:.1e}, estimated error of the reference {samples:.0e}, proven bound {proof:.0e}; jump {:.1e}",
            corner.jump
        ),
        None => String::new(),
    };
    [error, corner.why.clone()].into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>().join("; ")
}

fn table(found: &Sweep) -> String {
    let name = |corner: &Corner| match corner.changes.as_slice() {
        [] => "the scene itself".to_string(),
        changes => changes.iter().map(|(name, value)| format!("{name} = {value}")).collect::<Vec<_>>().join(", "),
    };
    let width = found.corners.iter().map(|corner| name(corner).chars().count()).max().unwrap_or_default();
    let line = |corner: &Corner| {
        let mark = if corner.ok { "" } else { "FAIL " };
        format!("{:<width$}  {mark}{}\n", name(corner), verdict(corner))
    };
    let equivalence = |row: &Row| {
        let mark = if row.ok { "same" } else { "FAIL other" };
        format!(
            "{:<width$}  {mark} picture, {}: off by {:.1e} of {:.0e}\n",
            row.setting, row.what, row.error, row.bound
        )
    };
    found.corners.iter().map(line).chain(found.equivalences.iter().map(equivalence)).collect()
}
