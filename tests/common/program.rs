//! The program, run in a folder of its own with a cache of its own.

use std::path::Path;
use std::process::{Command, Output, Stdio};

/// The program with these arguments, split at spaces.
pub fn command(folder: &Path, arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hypertexture"));
    command.args(arguments.split_whitespace()).current_dir(folder).env("HYPERTEXTURE_CACHE", folder.join("cache"));
    command.stdin(Stdio::null());
    command
}

/// What it says and how it ends.
pub fn run(folder: &Path, arguments: &str) -> Output {
    command(folder, arguments).output().expect("the program is built")
}
