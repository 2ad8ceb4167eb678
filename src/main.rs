//! The command line of hypertexture: arguments to calls, errors to one line and an exit code.

mod cli;

use clap::Parser;
use clap::error::ErrorKind;
use std::process::ExitCode;

/// Exit code of anything that the person at the keyboard can mend.
const BAD_INPUT: u8 = 2;

fn main() -> ExitCode {
    let arguments = match cli::Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) => {
            cli::say(&error.render().to_string());
            return ExitCode::SUCCESS;
        }
        Err(error) => {
            let text = error.to_string();
            let lines = text.lines().map(str::trim).take_while(|line| !line.starts_with("Usage:"));
            let line = lines.filter(|line| !line.is_empty()).collect::<Vec<_>>().join("; ");
            let line = if line.is_empty() { "error: no command".into() } else { line };
            eprintln!("{line}; see `hypertexture --help`");
            return ExitCode::from(BAD_INPUT);
        }
    };
    match cli::run(arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("error: {}", error.to_string().replace('\n', " "));
            ExitCode::from(BAD_INPUT)
        }
    }
}
