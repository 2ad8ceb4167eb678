//! `bench`: run times of effects, scenes and fields on this device, and changes since a saved run.

use crate::session::{Failed, Interrupted, stop_flag};
use crate::terminal::{absolute, announced, say, say_json};
use clap::Args;
use hypertexture::gpu::{Gpu, Options};
use hypertexture_measure::bench::{self, Change};
use hypertexture_support::{open, write_whole};
use std::error::Error;
use std::path::{Path, PathBuf};
use std::sync::atomic::Ordering;

/// Timed runs of a row by default, and with `--quick`.
const REPEAT: [usize; 2] = [7, 3];
/// Largest saved run, bytes.
const MAX_BYTES: u64 = 16 << 20;

/// Arguments of `bench`.
#[derive(Args)]
pub struct Bench {
    /// Only rows whose name contains one of these, such as effects, fur or "growth/".
    ///
    /// By default all.
    #[arg(value_name = "ROWS")]
    rows: Vec<String>,
    /// Fewer runs, and no picture above 300 x 300: a minute or two on two cores.
    #[arg(long)]
    quick: bool,
    /// Time rays by each shader stage instead, up to 1920 x 1080 pixels.
    #[arg(long)]
    stages: bool,
    /// Timed runs of each row, 1 to 1000 [default: 7; quick: 3].
    #[arg(long, value_name = "RUNS")]
    repeat: Option<usize>,
    /// Also writes all times into this file.
    ///
    /// Without a file, prints them in place of the table.
    #[arg(long, value_name = "FILE", num_args = 0..=1, default_missing_value = "-")]
    json: Option<PathBuf>,
    /// Compare with this file, written by --json on the same device.
    ///
    /// The exit code is 1 if a row got slower.
    #[arg(long, value_name = "FILE")]
    baseline: Option<PathBuf>,
}

/// Times the rows, prints the table, and compares it with a saved run.
pub(crate) fn run(command: &Bench, options: &Options, quiet: bool) -> Result<(), Box<dyn Error>> {
    let repeats = command.repeat.unwrap_or(REPEAT[usize::from(command.quick)]);
    if !(1..=1000).contains(&repeats) {
        return Err(format!("--repeat {repeats}: must be from 1 to 1000").into());
    }
    let (is_printed, file) = (command.json.as_deref() == Some(Path::new("-")), command.json.as_deref());
    let file = file.filter(|_| !is_printed);
    if let Some(path) = file {
        hypertexture::output::check_all([("--json", path.into())], command.baseline.clone())?;
    }
    let saved = command.baseline.as_deref().map(read).transpose()?;
    let library = bench::library();
    let groups = if command.stages {
        bench::stages(command.quick, &command.rows)?
    } else {
        bench::suite(&library, command.quick, &command.rows)?
    };
    if groups.is_empty() {
        return Err(format!(
            "{}: no row has such a name; try effects, scenes, growth, encodings or proxies",
            command.rows.join(", ")
        )
        .into());
    }
    let gpu = Gpu::new(options)?;
    let changes = |now: &bench::Bench| match (&saved, &command.baseline) {
        (Some(saved), Some(path)) => bench::changes(saved, now).map_err(|error| format!("{}: {error}", path.display())),
        _ => Ok(Vec::new()),
    };
    changes(&bench::Bench::here(&gpu))?; // an error before anything is timed
    let flag = stop_flag()?;
    let stop = || flag.load(Ordering::Relaxed);
    let found = announced(quiet, "bench", |progress| {
        progress(0.0);
        bench::measure(gpu, &|| Gpu::new(options), &library, &groups, repeats, &|part| progress(part), &stop)
    });
    if is_printed {
        say_json(&found)?;
    } else {
        say(&bench::table(&found));
    }
    if let Some(path) = file {
        write_whole(path, serde_json::to_string_pretty(&found)?.as_bytes())
            .map_err(|error| format!("{}: {error}; nothing was written", path.display()))?;
        if !quiet {
            say(&format!("\nwrote {}\n", absolute(path)));
        }
    }
    let changes = changes(&found)?;
    if saved.is_some() && !is_printed {
        say(&format_changes(&changes));
    }
    if found.partial {
        return Err(Interrupted("interrupted: the rows that were timed are above".into()).into());
    }
    if let [first, ..] = found.failures.as_slice() {
        let count = found.failures.len();
        return Err(Failed(format!("{count} rows could not be timed; the first, {first}")).into());
    }
    match changes.iter().filter(|change| change.times > 1.0).count() {
        0 => Ok(()),
        slower => Err(Failed(format!("{slower} rows are slower than the baseline, beyond the spread")).into()),
    }
}

/// A saved run.
fn read(path: &Path) -> Result<bench::Bench, Box<dyn Error>> {
    let fails = |reason: &dyn std::fmt::Display| format!("{}: {reason}", path.display());
    let text = open::text(path, MAX_BYTES).map_err(|error| fails(&error))?;
    serde_json::from_str(&text).map_err(|error| fails(&format!("no file that `bench --json` wrote: {error}")).into())
}

/// One line for each change.
fn format_changes(changes: &[Change]) -> String {
    let line = |change: &Change| {
        let (how, factor) = if change.times > 1.0 { ("slower", change.times) } else { ("faster", 1.0 / change.times) };
        format!("{how}     {factor:.2} times: {}\n", change.name)
    };
    match changes {
        [] => "\nno row is slower or faster than the baseline, beyond the spread\n".into(),
        changes => format!("\n{}", changes.iter().map(line).collect::<String>()),
    }
}
