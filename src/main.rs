//! The command line of hypertexture: arguments to calls, errors to one line and an exit code.

mod cli;

use clap::Parser;
use clap::error::ErrorKind;
use std::process::ExitCode;

/// Exit code of anything that the person at the keyboard can mend.
const BAD_INPUT: u8 = 2;
/// Exit code of a window that could not be shown, or not be shown on.
#[cfg(feature = "view")]
const NO_WINDOW: u8 = 1;
/// Exit code of `verify` where a device or a picture is not as it must be.
const DISAGREES: u8 = 1;

fn main() -> ExitCode {
    let arguments = match cli::Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) => {
            cli::say(&error.render().to_string());
            return ExitCode::SUCCESS;
        }
        Err(error) => {
            let text = match error.kind() {
                ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand => "error: no command".into(),
                _ => error.to_string(),
            };
            let is_end = |line: &&str| line.starts_with("Usage:") || line.starts_with("For more information");
            let lines = text.lines().map(str::trim).take_while(|line| !is_end(line));
            let line = lines.filter(|line| !line.is_empty()).collect::<Vec<_>>().join("; ");
            eprintln!("{line}; see `hypertexture --help`");
            return ExitCode::from(BAD_INPUT);
        }
    };
    match cli::run(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) if error.is::<cli::Interrupted>() => {
            eprintln!("{error}");
            ExitCode::from(cli::INTERRUPTED)
        }
        #[cfg(feature = "view")]
        Err(error) if error.is::<cli::NoWindow>() => {
            eprintln!("error: {}", error.to_string().replace('\n', " "));
            ExitCode::from(NO_WINDOW)
        }
        Err(error) if error.is::<cli::Disagreement>() => {
            eprintln!("{error}");
            ExitCode::from(DISAGREES)
        }
        Err(error) => {
            eprintln!("error: {}", error.to_string().replace('\n', " "));
            ExitCode::from(if error.is::<cli::Failed>() { cli::FAILED } else { BAD_INPUT })
        }
    }
}
