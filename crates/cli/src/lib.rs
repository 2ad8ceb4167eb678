//! The command line: arguments to calls of the library, errors to one line and an exit code.

mod args;
mod bench;
mod brief;
mod compare;
mod convert;
mod depth_map;
#[cfg(all(test, feature = "viewer"))]
mod docs_tests;
pub mod doctor;
mod effects;
mod error_map;
mod explain;
#[cfg(test)]
mod fault_tests;
mod field;
mod flags;
pub mod gallery;
mod info;
#[cfg(all(test, feature = "viewer"))]
mod line_tests;
mod log;
mod manual;
mod merge;
mod mesh;
mod modules;
mod paper;
mod picture;
mod progress;
mod render;
mod scene_arguments;
mod sequence;
mod settings;
mod stress;
mod validity;
mod verify;
#[cfg(feature = "viewer")]
mod view;

use args::{Arguments, Command};
use compare::Failed;
use progress::{announced, with_progress};
use sequence::Interrupted;
#[cfg(feature = "viewer")]
use view::NoWindow;

use clap::error::ErrorKind;
use hypertexture::gpu::{Gpu, GpuError, Options};
use hypertexture::render::RenderError;
use hypertexture::scene::schema::{SETTINGS, Setting};
use hypertexture::scene::{Scene, SceneError, parse_value};
use hypertexture::shader::{Library, compile};
use measure::guard;
use measure::worker::{self, PATIENCE, Start};
use serde::Serialize;
use std::error::Error;
use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;
use std::sync::OnceLock;
use support::words;

/// What is said of an argument that is no number, without the words of Rust.
const NUMBERS: [(&str, &str); 3] = [
    ("invalid float literal", "write a number, such as 1e-3"),
    ("invalid digit found in string", "write a whole number, such as 4"),
    ("number too large to fit in target type", "write a smaller number"),
];
/// Exit code of anything that the person at the keyboard can mend.
const BAD_INPUT: u8 = 2;

/// Exit code of a program that was interrupted, as shells have it: 128 and the number of SIGINT.
pub const INTERRUPTED: u8 = 130;

/// Characters of an error, of those the first and the last where it is longer, and of a word in it.
const LONGEST_LINE: usize = 599;
const KEPT: [usize; 2] = [400, 195];
const KEPT_OF_WORD: [usize; 2] = [50, 30];
/// How the number of an error of the system begins.
const NUMBER_OF_ERROR: &str = " (os error ";
/// Exit code of a report that holds failures.
pub const FAILED: u8 = 1;

/// The program: arguments to calls, errors to one line and an exit code.
pub fn main() -> ExitCode {
    let arguments = match brief::parse() {
        Ok(arguments) => arguments,
        Err(error) if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) => {
            say(&error.render().to_string());
            return ExitCode::SUCCESS;
        }
        Err(error) => {
            let text = match error.kind() {
                ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand | ErrorKind::MissingSubcommand => {
                    "error: no command".into()
                }
                _ => NUMBERS.iter().fold(error.to_string(), |text, (rust, plain)| text.replace(rust, plain)),
            };
            let line = one_line(&text);
            let line = format!("{line}{}", switch_of(&line, std::env::args_os().skip(1)));
            complain(&format!("{line}; see `hypertexture --help`"));
            return ExitCode::from(BAD_INPUT);
        }
    };
    match run(arguments) {
        Ok(()) => match UNSAID.get() {
            None => ExitCode::SUCCESS,
            Some(error) => {
                complain(&format!("error: standard output: {error}; what was to be said there is lost"));
                ExitCode::from(BAD_INPUT)
            }
        },
        Err(error) if error.is::<Interrupted>() => {
            complain(&error.to_string());
            ExitCode::from(INTERRUPTED)
        }
        #[cfg(feature = "viewer")]
        Err(error) if error.is::<NoWindow>() => {
            complain(&format!("error: {error}"));
            ExitCode::from(viewer::NO_WINDOW)
        }
        Err(error) => {
            complain(&format!("error: {error}{}", flag_of(&*error)));
            ExitCode::from(if error.is::<Failed>() { FAILED } else { BAD_INPUT })
        }
    }
}

/// What clap says in many lines, up to how the command is used.
fn one_line(text: &str) -> String {
    let is_end = |line: &&str| line.starts_with("Usage:") || line.starts_with("For more information");
    // No command takes such a value behind its input.
    let is_said = |line: &&str| !line.is_empty() && !line.starts_with("tip: to pass '");
    let lines = text.lines().map(str::trim).take_while(|line| !is_end(line)).filter(is_said);
    lines.fold(String::new(), |before, line| match &*before {
        "" => line.into(),
        before if before.ends_with(':') => format!("{before} {line}"),
        before => format!("{before}; {line}"),
    })
}

/// How a value is given to a flag that may stand alone, where one of these arguments is followed by one, for the end of a line.
fn switch_of(line: &str, arguments: impl Iterator<Item = OsString>) -> String {
    let arguments: Vec<String> = arguments.map(|argument| argument.to_string_lossy().into_owned()).collect();
    let found = arguments.windows(2).find_map(|pair| {
        let name = pair[0].strip_prefix("--")?;
        let of_flag = |setting: &&Setting| setting.flag.is_some_and(|flag| flag.name == name && flag.alone.is_some());
        let setting = SETTINGS.iter().find(of_flag)?;
        let takes = setting.check(setting.name, &parse_value(&pair[1])).is_ok()
            || line.contains(&format!("unexpected argument '{}'", pair[1]));
        takes.then(|| format!("; a value is given to --{name} as --{name}={}", pair[1]))
    });
    found.unwrap_or_default()
}

/// The flag that sets the field which an error names, for the end of its line.
fn flag_of(error: &(dyn Error + 'static)) -> String {
    let Some(SceneError::Value { field, .. }) = error.downcast_ref() else { return String::new() };
    let flag = SETTINGS.iter().find(|setting| setting.name == field).and_then(|setting| setting.flag);
    flag.map(|flag| format!(" (--{})", flag.name)).unwrap_or_default()
}

/// Runs the command that was asked for.
fn run(arguments: Arguments) -> Result<(), Box<dyn Error>> {
    log::start(arguments.quiet);
    support::threads::start()?;
    let options = Options {
        device: arguments.device.filter(|name| !name.is_empty()),
        validation: std::env::var_os("HYPERTEXTURE_VALIDATION").is_some_and(|value| value == "1"),
        cache: support::disk_cache::default_folder(),
    };
    carry_out(arguments.command, &options, arguments.quiet)
}

/// Carries out a command.
fn carry_out(command: Command, options: &Options, quiet: bool) -> Result<(), Box<dyn Error>> {
    match command {
        Command::Render(command) => render::run(&command, options, quiet),
        #[cfg(feature = "viewer")]
        Command::View(command) => view::run(*command, options.clone()),
        Command::Merge(command) => merge::run(&command, quiet),
        Command::Field(command) => field::run(&command, quiet),
        Command::Mesh(command) => mesh::run(&command, quiet),
        Command::Gallery(command) => gallery::run(&command, options, quiet),
        Command::Compare(command) if command.paper => paper::run(&command, options, quiet),
        Command::Compare(command) => compare::run(&command, options, quiet),
        Command::Bench(command) => bench::run(&command, options, quiet),
        Command::Explain(command) => explain::run(&command, options, quiet),
        Command::Info(command) => info::run(&command),
        Command::Convert(command) => convert::run(&command, quiet),
        Command::Effects => effects::run(),
        Command::Settings => {
            say(&settings::page());
            Ok(())
        }
        Command::Stress(command) => stress::run(&command, options, quiet),
        Command::Verify(command) => verify::run(&command, options, quiet),
        Command::Doctor(command) => {
            let report = doctor::examine(options);
            if command.json {
                say_json(&report)?
            } else {
                say(&report.text())
            }
            if report.healthy { Ok(()) } else { Err("the tests above did not all pass".into()) }
        }
        Command::Completions(command) => {
            say(&manual::completions(command.shell));
            Ok(())
        }
        Command::Man(command) => {
            say(&manual::page(command.command.as_deref())?);
            Ok(())
        }
        Command::Draw => Ok(worker::serve(std::io::stdin().lock(), &mut std::io::stdout().lock(), options)?),
        Command::Compile(limits) => {
            compile::limit(limits.seconds, Some(limits.memory_mib))?;
            Ok(compile::serve(std::io::stdin().lock(), &mut std::io::stdout().lock())?)
        }
        Command::Try(limits) => {
            compile::limit(limits.seconds, None)?;
            Ok(guard::serve(std::io::stdin().lock(), &mut std::io::stdout().lock(), options)?)
        }
    }
}

/// Why standard output did not take what was said.
static UNSAID: OnceLock<std::io::Error> = OnceLock::new();

/// Writes lines to standard output, as a terminal may see them. A closed pipe is no error; of others [`main`] speaks at the end.
pub fn say(text: &str) {
    let mut out = std::io::stdout().lock();
    if let Err(error) = out.write_all(words::lines(text).as_bytes()).and_then(|()| out.flush())
        && error.kind() != std::io::ErrorKind::BrokenPipe
    {
        let _ = UNSAID.set(error); // the first says why
    }
}

/// Writes an object of JSON to standard output.
fn say_json(value: &impl Serialize) -> Result<(), serde_json::Error> {
    say(&words::json(&format!("{}\n", serde_json::to_string_pretty(value)?)));
    Ok(())
}

/// Says nothing, in place of [`say`].
fn silent(_: &str) {}

/// Writes lines to standard error, in place of [`say`] where standard output has something else.
fn aside(text: &str) {
    let _ = write!(std::io::stderr().lock(), "{}", words::lines(text));
}

/// Writes a line to standard error, if that takes it, as a terminal may see it; no longer than anybody reads, and without the
/// numbers of errors of the system.
fn complain(line: &str) {
    let mut line = line.replace('\n', " ");
    while let Some(start) = line.find(NUMBER_OF_ERROR)
        && let Some(length) = line[start..].find(')')
    {
        line.replace_range(start..=start + length, "");
    }
    let _ = writeln!(std::io::stderr().lock(), "{}", fitted(&words::line(&line)));
}

/// A line without the middle of its long words where it is too long, and then without its own: it begins with what is wrong
/// and ends with the reason.
fn fitted(line: &str) -> String {
    let length = |text: &str| text.chars().count();
    let without_middle = |text: &str, [first, last]: [usize; 2]| -> String {
        let all = length(text);
        match all > first + last {
            true => text.chars().take(first).chain("...".chars()).chain(text.chars().skip(all - last)).collect(),
            false => text.into(),
        }
    };
    if length(line) <= LONGEST_LINE {
        return line.into();
    }
    let words: Vec<String> = line.split(' ').map(|word| without_middle(word, KEPT_OF_WORD)).collect();
    let line = words.join(" ");
    if length(&line) <= LONGEST_LINE { line } else { without_middle(&line, KEPT) }
}

/// Opens the device for something, and once more where the device is lost meanwhile.
fn with_device<T>(
    options: &Options,
    mut run: impl FnMut(&Gpu) -> Result<T, Box<dyn Error>>,
) -> Result<T, Box<dyn Error>> {
    let done = run(&Gpu::new(options)?);
    let is_lost = |error: &(dyn Error + 'static)| match (error.downcast_ref(), error.downcast_ref()) {
        (Some(RenderError::Gpu(error)), _) | (_, Some(error)) => GpuError::is_lost(error),
        _ => false,
    };
    match done {
        Err(error) if is_lost(&*error) => {
            ::log::warn!("{error}: the device was lost; it is opened once more");
            run(&Gpu::new(options)?)
        }
        done => done,
    }
}

/// How workers are started: as this very program, on the same device.
pub fn start(options: &Options) -> Result<Start, Box<dyn Error>> {
    let program = std::env::current_exe()?;
    Ok(Start { program, device: options.device.clone(), patience: PATIENCE })
}

/// The modules of a scene, which is checked; what a person wrote is compiled in a process of its own.
fn library(scene: &Scene) -> Result<Library, Box<dyn Error>> {
    let library = scene.library()?.compiled_by(&std::env::current_exe()?);
    scene.check(&library)?;
    Ok(library)
}

/// Tries what a person wrote of the modules of a scene: before anything else is done with them, whatever the command. With
/// `options`, it is tried on a device as well.
fn try_modules(scene: &Scene, library: &Library, options: Option<&Options>) -> Result<(), Box<dyn Error>> {
    let device = options.map(|options| options.device.as_deref().unwrap_or_default());
    guard::try_modules(&std::env::current_exe()?, device, (scene, library), &|| false)?;
    Ok(())
}

/// A path from the root, as a line.
fn absolute(path: &std::path::Path) -> String {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    words::line(&path.to_string_lossy()).into_owned()
}
