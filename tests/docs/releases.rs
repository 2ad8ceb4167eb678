//! Parts of a release agree: versions, the CHANGELOG, the scripts of the workflows, and the limits in SECURITY.md.
#![expect(clippy::unwrap_used, reason = "a test fails where a file is not as described")]

use hypertexture_support::jobs::Limits;
use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::path::{Path, PathBuf};
use std::process::Command;

const CHANGELOG: &str = include_str!("../../CHANGELOG.md");
const VERSION: &str = env!("CARGO_PKG_VERSION");
const GROUPS: [&str; 4] = ["Added", "Changed", "Fixed", "Removed"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Exit code and output of `release/notes` for a version.
fn notes(version: &str) -> (i32, String, String) {
    let output = Command::new(root().join("release/notes")).arg(version).output().unwrap();
    let [out, err] = [output.stdout, output.stderr].map(|bytes| String::from_utf8(bytes).unwrap());
    (output.status.code().unwrap(), out, err)
}

#[test]
fn the_changelog_has_a_dated_section_for_the_version() {
    let headings: Vec<_> = CHANGELOG.lines().filter_map(|line| line.strip_prefix("## ")).collect();
    assert_eq!(headings.iter().filter(|heading| **heading == "Unreleased").count(), 1);
    assert_eq!(headings[0], "Unreleased");
    let date = headings[1].strip_prefix(&format!("{VERSION} - ")).unwrap_or_else(|| panic!("{}", headings[1]));
    let parts: Vec<usize> = date.split('-').map(str::len).collect();
    assert!(parts == [4, 2, 2] && date.bytes().all(|byte| byte == b'-' || byte.is_ascii_digit()), "{date}");
    let groups = CHANGELOG.lines().filter_map(|line| line.strip_prefix("### "));
    groups.for_each(|group| assert!(GROUPS.contains(&group), "a group is one of {GROUPS:?}, not {group}"));

    let citation = fs::read_to_string(root().join("CITATION.cff")).unwrap();
    assert!(citation.contains(&format!("\nversion: {VERSION}\ndate-released: {date}\n")), "{citation}");
}

#[test]
fn the_notes_of_a_release_are_its_section() {
    let (code, out, err) = notes(VERSION);
    assert!(code == 0 && err.is_empty(), "{err}");
    assert!(CHANGELOG.contains(out.trim()) && out.contains("### Added") && !out.contains("## Unreleased"), "{out}");
    let (code, out, err) = notes("7.7.7");
    assert_eq!((code, out.as_str()), (1, ""));
    assert!(err.contains("7.7.7") && err.contains(VERSION), "{err}");
}

#[test]
fn the_workflows_call_scripts_that_are_there() {
    let workflows = fs::read_dir(root().join(".github/workflows")).unwrap().map(|entry| entry.unwrap().path());
    let texts: String = workflows.map(|path| fs::read_to_string(path).unwrap()).collect();
    let words = texts.split_whitespace().map(|word| word.trim_start_matches("./"));
    let called: BTreeSet<PathBuf> = words
        .filter(|word| [".ci/", "release/", "setup.sh"].iter().any(|start| word.starts_with(start)))
        .map(|word| root().join(word))
        .collect();
    for name in [".ci/run", "release/build", "release/notes", "setup.sh"] {
        assert!(called.contains(&root().join(name)), "no workflow calls {name}");
    }
    for script in called {
        let mode = fs::metadata(&script).unwrap_or_else(|_| panic!("there is no {}", script.display()));
        assert!(mode.permissions().mode() & 0o111 != 0, "{} cannot be run", script.display());
    }
}

#[test]
fn security_states_the_limits_of_compilation() {
    let page = fs::read_to_string(root().join("SECURITY.md")).unwrap();
    let Limits { time, memory_mib, answer_bytes } = Limits::default();
    let row = format!("| compiling and linking | {} s | {memory_mib} MiB of address space |", time.as_secs());
    assert!(page.contains(&row), "SECURITY.md must hold {row}");
    assert!(page.contains(&format!("longer than {} MiB", answer_bytes >> 20)));
}
