//! The program: arguments to calls, errors to one line and an exit code.

mod command_line;
#[cfg(all(test, feature = "viewer"))]
mod docs_tests;
#[cfg(test)]
mod fault_tests;
#[cfg(all(test, feature = "viewer"))]
mod line_tests;
mod manual;
#[cfg(feature = "viewer")]
mod render_job;

#[cfg(feature = "viewer")]
use crate::commands::view::{self, NoWindow};
use crate::commands::{
    bench, compare, convert, doctor, effects, explain, export, field, gallery, groom, info, merge, mesh, paper, render,
    settings, stress, verify, volume,
};
use crate::session::{FAILED, Failed, INTERRUPTED, Interrupted, gpu_error};
use crate::terminal::{UNSAID, complain, say, say_json, start_log};
use clap::Parser;
use clap::error::ErrorKind;
use command_line::{Arguments, Command};
use hypertexture::gpu::{GpuError, Options, ending};
use hypertexture::scene::schema::{SETTINGS, Setting};
use hypertexture::scene::{SceneError, parse_value};
use hypertexture::shader::compile;
use hypertexture_measure::{guard, worker};
use hypertexture_support::jobs::Parent;
use std::error::Error;
use std::ffi::OsString;
use std::process::ExitCode;

/// Messages of Rust about numbers, and plainer ones.
const NUMBERS: [(&str, &str); 3] = [
    ("invalid float literal", "write a number, such as 1e-3"),
    ("invalid digit found in string", "write a whole number, such as 4"),
    ("number too large to fit in target type", "write a smaller number"),
];
/// Exit code of bad input.
const BAD_INPUT: u8 = 2;

/// The program: arguments to calls, errors to one line and an exit code.
pub fn main() -> ExitCode {
    let arguments = match Arguments::try_parse() {
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
                complain(&format!("error: cannot write to standard output: {error}"));
                ExitCode::from(BAD_INPUT)
            }
        },
        Err(error) if error.is::<Interrupted>() || matches!(gpu_error(&*error), Some(GpuError::Interrupted { .. })) => {
            complain(&error.to_string());
            ending::finish(INTERRUPTED);
            ExitCode::from(INTERRUPTED)
        }
        #[cfg(feature = "viewer")]
        Err(error) if error.is::<NoWindow>() => {
            complain(&format!("error: {error}"));
            ExitCode::from(hypertexture_viewer::NO_WINDOW)
        }
        Err(error) => {
            complain(&format!("error: {error}{}", flag_of(&*error)));
            ExitCode::from(if error.is::<Failed>() { FAILED } else { BAD_INPUT })
        }
    }
}

/// Message of clap as one line, without the usage.
fn one_line(text: &str) -> String {
    let is_end = |line: &&str| line.starts_with("Usage:") || line.starts_with("For more information");
    // The tip is wrong: no command takes a value after its input.
    let is_said = |line: &&str| !line.is_empty() && !line.starts_with("tip: to pass '");
    let lines = text.lines().map(str::trim).take_while(|line| !is_end(line)).filter(is_said);
    lines.fold(String::new(), |before, line| match &*before {
        "" => line.into(),
        before if before.ends_with(':') => format!("{before} {line}"),
        before => format!("{before}; {line}"),
    })
}

/// Hint for the end of an error line: the spelling `--flag=value`, if an argument that may stand alone is followed by a value.
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

/// Flag of the field that an error names, for the end of its line.
fn flag_of(error: &(dyn Error + 'static)) -> String {
    let Some(SceneError::Value { field, .. }) = error.downcast_ref() else { return String::new() };
    let flag = SETTINGS.iter().find(|setting| setting.name == field).and_then(|setting| setting.flag);
    flag.map(|flag| format!(" (--{})", flag.name)).unwrap_or_default()
}

/// Runs a command with the options of the program.
fn run(arguments: Arguments) -> Result<(), Box<dyn Error>> {
    start_log(arguments.quiet);
    hypertexture_support::threads::start()?;
    let options = Options {
        device: arguments.device.filter(|name| !name.is_empty()),
        validation: std::env::var_os("HYPERTEXTURE_VALIDATION").is_some_and(|value| value == "1"),
        cache: hypertexture_support::disk_cache::default_folder(),
    };
    carry_out(arguments.command, &options, arguments.quiet)
}

/// Dispatches a command.
fn carry_out(command: Command, options: &Options, quiet: bool) -> Result<(), Box<dyn Error>> {
    match command {
        Command::Render(command) => render::run(&command, options, quiet),
        #[cfg(feature = "viewer")]
        Command::View(command) => view::run(*command, options.clone()),
        Command::Merge(command) => merge::run(&command, quiet),
        Command::Field(command) => field::run(&command, quiet),
        Command::Mesh(command) => mesh::run(&command, quiet),
        Command::Volume(command) => volume::run(&command, options, quiet),
        Command::Groom(command) => groom::run(&command, quiet),
        Command::Web(command) => export::web(&command, options, quiet),
        Command::Export(command) => export::export(&command, quiet),
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
        Command::Man(command) => manual::run(&command, quiet),
        Command::Job => {
            let (job, parent) = Parent::accept()?;
            match &*job {
                compile::JOB => Ok(compile::serve(parent)?),
                guard::JOB => Ok(guard::serve(parent, options)?),
                worker::JOB => Ok(worker::serve(parent, options)?),
                #[cfg(feature = "viewer")]
                hypertexture_viewer::FINAL_JOB => Ok(render_job::serve(parent, options)?),
                job => Err(format!("no job `{job}`").into()),
            }
        }
    }
}
