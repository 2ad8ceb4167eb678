//! The program, run in a folder of its own with a cache of its own.

use std::path::Path;
use std::process::{Command, Output, Stdio};
use std::time::Duration;

/// The program with these arguments, split at spaces.
pub fn command(folder: &Path, arguments: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_hypertexture"));
    command.args(arguments.split_whitespace()).current_dir(folder).env("HYPERTEXTURE_CACHE", folder.join("cache"));
    command.stdin(Stdio::null());
    command
}

/// Output and exit code.
pub fn run(folder: &Path, arguments: &str) -> Output {
    command(folder, arguments).output().expect("the program is built")
}

/// Standard error without the lines of progress.
pub fn unexpected(output: &Output) -> String {
    let said = String::from_utf8_lossy(&output.stderr);
    said.split_inclusive('\n').filter(|line| !line.starts_with("progress   ")).collect()
}

/// Interrupts a comparison that writes its report into `r`, a second after it has begun to measure. It says so in a line, ends
/// with 130, and has a report.
#[cfg(unix)]
pub fn interrupt(folder: &Path, arguments: &str) {
    let mut started = command(folder, &format!("{arguments} -o r"));
    let mut child = started.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("the program is built");
    while !folder.join("r").is_dir() && child.try_wait().expect("a child").is_none() {
        std::thread::sleep(Duration::from_millis(20));
    }
    std::thread::sleep(Duration::from_secs(1));
    Command::new("sh").args(["-c", &format!("kill -INT {}", child.id())]).status().expect("a signal");
    let output = child.wait_with_output().expect("a child");
    let said = unexpected(&output);
    assert_eq!((output.status.code(), said.lines().count()), (Some(130), 1), "{said}");
    assert!(said.starts_with("interrupted: ") && said.contains("marked as partial"), "{said}");
}
