//! A working folder in which the program is run.

use crate::program::{share, unexpected, warm};
use std::collections::BTreeMap;
use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};

pub const SMALL: &str = "--size 64x64 --samples 32";

/// A working folder with a cache beside it; both vanish with the test.
pub struct Desk {
    root: tempfile::TempDir,
    is_cold: bool,
}

impl Desk {
    /// A desk whose cache begins with the programs and fields of other tests.
    pub fn new() -> Desk {
        let mut desk = Desk::cold();
        desk.is_cold = false;
        warm(&desk.cache());
        desk
    }

    /// A desk with an empty cache.
    pub fn cold() -> Desk {
        let root = tempfile::tempdir_in(env!("CARGO_TARGET_TMPDIR")).unwrap();
        fs::create_dir(root.path().join("work")).unwrap();
        Desk { root, is_cold: true }
    }

    pub fn cache(&self) -> PathBuf {
        self.root.path().join("cache")
    }

    pub fn work(&self) -> PathBuf {
        self.root.path().join("work")
    }

    pub fn file(&self, name: &str) -> PathBuf {
        self.work().join(name)
    }

    pub fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hypertexture"));
        command.args(arguments.split_whitespace()).current_dir(self.work());
        command.env("HYPERTEXTURE_CACHE", self.cache());
        command.env_remove("SLURM_ARRAY_TASK_ID").env_remove("JOB_COMPLETION_INDEX");
        command.env_remove("HYPERTEXTURE_LOG").env_remove("HYPERTEXTURE_VALIDATION");
        command.stdin(Stdio::null());
        command
    }

    /// A line for `sh`, which runs in the working folder as the program does.
    pub fn shell(&self, line: &str) -> Command {
        let mut command = Command::new("sh");
        command.args(["-c", line]).current_dir(self.work()).env("HYPERTEXTURE_CACHE", self.cache());
        command
    }

    pub fn run(&self, arguments: &str) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// Runs what must succeed without a word on standard error but how far it is; gives standard output.
    pub fn good(&self, arguments: &str) -> String {
        let output = self.run(arguments);
        let (out, err) = (text(&output.stdout), unexpected(&output));
        assert!(output.status.success() && err.is_empty(), "`{arguments}`: {}\n{out}\n{err}", output.status);
        out
    }

    /// Every file below the working folder with its content.
    pub fn files(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let mut folders = vec![self.work()];
        let mut files = BTreeMap::new();
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                match path.is_dir() {
                    true => folders.push(path),
                    false => drop(files.insert(path.clone(), fs::read(&path).unwrap())),
                }
            }
        }
        files
    }

    pub fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.file(name), content).unwrap();
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        if !self.is_cold {
            share(&self.cache());
        }
    }
}

pub fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Checks rows of arguments and what the one line on standard error must hold, on a desk that `prepare` has laid out.
/// A `DEVICE=name` before the arguments chooses a device.
pub fn refused(prepare: impl Fn(&Desk), rows: &[(&str, &[&str])]) {
    let mut failures = Vec::new();
    for (arguments, parts) in rows {
        let desk = Desk::new();
        desk.write("out.png", "an older picture");
        prepare(&desk);
        let before = desk.files();
        let output = match arguments.strip_prefix("DEVICE=").and_then(|rest| rest.split_once(' ')) {
            Some((device, rest)) => desk.command(rest).env("HYPERTEXTURE_DEVICE", device).output().unwrap(),
            None => desk.run(arguments),
        };
        let err = unexpected(&output);
        let mut fail = |what: String| failures.push(format!("`{arguments}`: {what}\n    {}", err.trim_end()));
        if output.status.code() != Some(2) {
            fail(format!("{}, expected exit status 2", output.status));
        }
        if err.lines().count() != 1 || err.contains("panicked") {
            fail(format!("{} lines on standard error, expected 1", err.lines().count()));
        }
        for part in parts.iter().filter(|part| !err.contains(**part)) {
            fail(format!("the line does not say `{part}`"));
        }
        if !output.stdout.is_empty() {
            fail(format!("standard output is not empty: {}", text(&output.stdout)));
        }
        if desk.files() != before {
            fail("files were written or changed".into());
        }
    }
    assert!(failures.is_empty(), "{} failures\n{}", failures.len(), failures.join("\n"));
}
