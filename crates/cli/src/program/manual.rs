//! Shell completions and manual pages, generated from the arguments.

use super::command_line::{self, Arguments};
use crate::session::check_folder;
use crate::terminal::{absolute, say};
use clap::{Command, CommandFactory};
use clap_complete::Shell;
use clap_mangen::Man;
use hypertexture::scene::SceneError;
use hypertexture_support::write_whole;
use std::error::Error;
use std::fs::create_dir_all;
use std::io;
use std::path::Path;

/// Completion script of a shell.
pub fn completions(shell: Shell) -> String {
    let program = Arguments::command();
    let mut shown =
        Command::new("hypertexture").args(program.get_arguments().cloned()).subcommands(commands(&program).cloned());
    let mut bytes = Vec::new();
    clap_complete::generate(shell, &mut shown, "hypertexture", &mut bytes);
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Prints a manual page, or writes all pages into a folder.
pub fn run(command: &command_line::Man, quiet: bool) -> Result<(), Box<dyn Error>> {
    match &command.all {
        None => say(&page(command.command.as_deref())?),
        Some(folder) => {
            write_pages(folder)?;
            if !quiet {
                say(&format!("wrote {}\n", absolute(folder)));
            }
        }
    }
    Ok(())
}

/// Manual page of a command, or of the program.
fn page(name: Option<&str>) -> Result<String, Box<dyn Error>> {
    let program = program();
    let command = match name {
        None => &program,
        Some(name) => {
            let known: Vec<&str> = commands(&program).map(Command::get_name).collect();
            let unknown = || format!("man: {}", SceneError::unknown("command", name, &known));
            commands(&program).find(|command| command.get_name() == name).ok_or_else(unknown)?
        }
    };
    Ok(String::from_utf8_lossy(&rendered(command)?).into_owned())
}

/// Writes the pages of the program and of its visible commands into a folder, which is created.
fn write_pages(folder: &Path) -> Result<(), Box<dyn Error>> {
    check_folder(folder)?;
    let fails = |path: &Path, error: io::Error| format!("{}: {error}", path.display());
    create_dir_all(folder).map_err(|error| fails(folder, error))?;
    let program = program();
    for command in commands(&program).chain([&program]) {
        let path = folder.join(format!("{}.1", command.get_display_name().unwrap_or(command.get_name())));
        write_whole(&path, &rendered(command)?).map_err(|error| fails(&path, error))?;
    }
    Ok(())
}

/// The command line without clap's command `help`, which prints the same texts.
fn program() -> Command {
    let mut program = Arguments::command().disable_help_subcommand(true);
    program.build();
    program
}

/// The visible commands of a program.
fn commands(program: &Command) -> impl Iterator<Item = &Command> {
    program.get_subcommands().filter(|command| !command.is_hide_set())
}

/// The page of a command, in roff.
fn rendered(command: &Command) -> io::Result<Vec<u8>> {
    let mut bytes = Vec::new();
    Man::new(command.clone()).render(&mut bytes)?;
    Ok(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;
    use std::fs;

    #[test]
    fn every_command_has_a_manual_page() {
        let folder = tempfile::tempdir().unwrap();
        write_pages(&folder.path().join("man/man1")).unwrap();
        let program = Arguments::command();
        let commands: Vec<_> = program.get_subcommands().filter(|command| !command.is_hide_set()).collect();
        assert!(commands.len() >= 15, "only {} commands", commands.len());
        let mut expected: BTreeSet<_> =
            commands.iter().map(|command| format!("hypertexture-{}.1", command.get_name())).collect();
        expected.insert("hypertexture.1".into());
        let entries = fs::read_dir(folder.path().join("man/man1")).unwrap().map(|entry| entry.unwrap());
        let written: BTreeSet<_> = entries.map(|entry| entry.file_name().into_string().unwrap()).collect();
        assert_eq!(written, expected);

        let text = |name: &str| fs::read_to_string(folder.path().join("man/man1").join(name)).unwrap();
        for command in commands {
            let page = text(&format!("hypertexture-{}.1", command.get_name()));
            let flags = command.get_arguments().filter(|flag| !flag.is_hide_set());
            for flag in flags.filter_map(clap::Arg::get_long).map(|flag| flag.replace('-', "\\-")) {
                assert!(page.contains(&format!("\\-\\-{flag}\\fR")), "{}: no --{flag}", command.get_name());
            }
            assert!(page.starts_with(".ie") && page.contains(".SH DESCRIPTION"), "{}: {page}", command.get_name());
            assert!(text("hypertexture.1").contains(&format!("hypertexture\\-{}(1)", command.get_name())));
        }
    }

    #[test]
    fn a_page_of_no_command_is_refused_with_the_nearest() {
        let error = page(Some("rendr")).unwrap_err().to_string();
        assert!(error.contains("`rendr`") && error.contains("render"), "{error}");
        assert_eq!(page(None).unwrap().matches(".TH hypertexture 1").count(), 1);
    }
}
