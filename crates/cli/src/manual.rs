//! Shell completions and manual pages, generated from the arguments.

use super::brief;
use clap::Command;
use clap_complete::Shell;
use clap_mangen::Man;
use hypertexture::scene::SceneError;
use std::error::Error;

/// Completion script of a shell.
pub fn completions(shell: Shell) -> String {
    let program = brief::command();
    let visible = program.get_subcommands().filter(|command| !command.is_hide_set()).cloned();
    let mut shown = Command::new("hypertexture").args(program.get_arguments().cloned()).subcommands(visible);
    let mut bytes = Vec::new();
    clap_complete::generate(shell, &mut shown, "hypertexture", &mut bytes);
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Manual page of a command, or of the program.
pub fn page(name: Option<&str>) -> Result<String, Box<dyn Error>> {
    let mut program = brief::command();
    program.build();
    let command = match name {
        None => program,
        Some(name) => {
            let visible = || program.get_subcommands().filter(|command| !command.is_hide_set());
            let found = visible().find(|command| command.get_name() == name);
            let known: Vec<&str> = visible().map(|command| command.get_name()).collect();
            found.cloned().ok_or_else(|| format!("man: {}", SceneError::unknown("command", name, &known)))?
        }
    };
    let mut bytes = Vec::new();
    Man::new(command).render(&mut bytes)?;
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}
