//! The program, run in a folder of its own with a cache of its own, which begins with what other tests have computed.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};
use std::sync::LazyLock;
use std::time::{Duration, UNIX_EPOCH};

/// Extensions of cached files that tests share: programs, fields, blocks and cells, which depend on the program alone.
const SHARED: [&str; 5] = ["program", "field", "closest", "block", "cells"];

/// Folder of the shared files, one for each build of the program, so that no test reads what another build computed.
static COMPUTED: LazyLock<PathBuf> = LazyLock::new(|| {
    let about = fs::metadata(env!("CARGO_BIN_EXE_hypertexture")).expect("the program is built");
    let built = about.modified().ok().and_then(|time| time.duration_since(UNIX_EPOCH).ok()).unwrap_or_default();
    let all = Path::new(env!("CARGO_TARGET_TMPDIR")).join("computed");
    let own = all.join(format!("{}-{}", about.len(), built.as_nanos()));
    for entry in fs::read_dir(&all).into_iter().flatten().flatten().filter(|entry| entry.path() != own) {
        let _ = fs::remove_dir_all(entry.path());
    }
    fs::create_dir_all(&own).expect("a folder of tests can be written");
    own
});

/// Links the shared files of one folder into another.
fn link(from: &Path, to: &Path) {
    for path in fs::read_dir(from).into_iter().flatten().flatten().map(|entry| entry.path()) {
        if path.extension().is_some_and(|end| SHARED.iter().any(|shared| end == *shared)) {
            // The file is there already, or the folders are on two disks.
            let _ = fs::hard_link(&path, to.join(path.file_name().expect("an entry has a name")));
        }
    }
}

/// Fills a cache with what other tests have computed.
pub fn warm(cache: &Path) {
    fs::create_dir_all(cache).expect("a folder of tests can be written");
    link(&COMPUTED, cache);
}

/// Gives other tests what a cache holds.
pub fn share(cache: &Path) {
    link(cache, &COMPUTED);
}

/// The program with these arguments, split at spaces.
pub fn command(folder: &Path, arguments: &str) -> Command {
    let cache = folder.join("cache");
    match cache.is_dir() {
        true => share(&cache),
        false => warm(&cache),
    }
    let mut command = Command::new(env!("CARGO_BIN_EXE_hypertexture"));
    command.args(arguments.split_whitespace()).current_dir(folder).env("HYPERTEXTURE_CACHE", cache);
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
