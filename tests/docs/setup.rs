//! `setup.sh` on machines that lack something: a line that says what, and what to do. And what `cargo` is to build.

use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::Path;
use std::process::Command;

/// Programs of the system that the script needs.
const SYSTEM: [&str; 8] = ["sh", "cat", "dirname", "env", "head", "sed", "sort", "true"];
/// A machine that has everything, as programs of one line each; `calls` takes what is called as root.
const COMPLETE: [(&str, &str); 7] = [
    ("id", "echo 1000"),
    ("sudo", "echo \"$@\" >> calls; exec \"$@\""),
    ("dpkg", "exit 0"),
    ("apt-get", "exit 0"),
    ("apt-cache", "exit 0"),
    ("cargo", "exit 0"),
    ("rustc", "echo rustc 99.0.0"),
];

/// Exit code of the script, its last line, and the calls of root, on a machine with these programs in place of those of
/// [`COMPLETE`]; an empty one is not there.
fn set_up(changes: &[(&str, &str)]) -> (i32, String, String) {
    let folder = tempfile::tempdir().unwrap();
    let bin = folder.path().join("bin");
    fs::create_dir(&bin).unwrap();
    for name in ["setup.sh", "Cargo.toml"] {
        fs::copy(Path::new(env!("CARGO_MANIFEST_DIR")).join(name), folder.path().join(name)).unwrap();
    }
    for name in SYSTEM {
        let path = std::env::var_os("PATH").unwrap();
        let found = std::env::split_paths(&path).map(|folder| folder.join(name)).find(|path| path.exists());
        symlink(found.unwrap(), bin.join(name)).unwrap();
    }
    for (name, line) in COMPLETE.iter().filter(|(name, _)| !changes.iter().any(|(own, _)| own == name)).chain(changes) {
        if !line.is_empty() {
            fs::write(bin.join(name), format!("#!/bin/sh\n{line}\n")).unwrap();
            fs::set_permissions(bin.join(name), fs::Permissions::from_mode(0o755)).unwrap();
        }
    }
    let output = Command::new("/bin/sh").arg("./setup.sh").current_dir(&folder).env("PATH", &bin).output().unwrap();
    let said = String::from_utf8(output.stderr).unwrap();
    let calls = fs::read_to_string(folder.path().join("calls")).unwrap_or_default();
    (output.status.code().unwrap(), said.lines().last().unwrap_or_default().into(), calls)
}

#[test]
fn a_machine_that_has_everything_is_left_alone() {
    assert_eq!(set_up(&[]), (0, String::new(), String::new()));
    assert_eq!(set_up(&[("sudo", ""), ("apt-get", "")]).0, 0);
}

#[test]
fn what_is_missing_is_installed() {
    let (code, said, calls) = set_up(&[("dpkg", "[ \"$2\" != xvfb ] && [ \"$2\" != libshaderc-dev ]")]);
    assert_eq!((code, said), (0, String::new()));
    let last = calls.lines().last().unwrap();
    assert!(last.ends_with("apt-get install -yq --no-install-recommends libshaderc-dev xvfb"), "{calls}");
}

#[test]
fn what_cannot_be_installed_is_named_with_the_reason() {
    const NO_PACKAGE: (&str, &str) = ("dpkg", "exit 1");
    const NO_NETWORK: (&str, &str) = ("apt-get", "exit 100");
    const NO_RUST: (&str, &str) = ("rustc", "");
    const NO_RUSTUP: (&str, &str) = ("apt-cache", "[ \"$2\" != rustup ]");
    for (changes, parts) in [
        (
            &[NO_PACKAGE, ("sudo", "")][..],
            &["only root may install", "apt-get install", " libshaderc-dev ", " xvfb"][..],
        ),
        (
            &[NO_PACKAGE, ("sudo", "exit 1"), NO_RUST],
            &["only root may install", " libshaderc-dev ", "https://rustup.rs"],
        ),
        (&[NO_PACKAGE, NO_NETWORK], &["the download of g++ libshaderc-dev ", " failed", "with a network"]),
        (&[NO_PACKAGE, ("apt-get", "[ $1 = update ]")], &["apt-get could not install g++ "]),
        (&[NO_PACKAGE, ("apt-get", "")], &["there is no apt-get here", " libshaderc-dev ", " libvulkan1 "]),
        (&[NO_RUST, NO_NETWORK], &["the download of the lists of packages failed", "https://rustup.rs"]),
        (&[NO_RUST, ("rustup", "exit 1")], &["the download of Rust by rustup failed", "https://rustup.rs"]),
        (&[NO_RUST, ("sudo", "")], &["and none was found", "https://rustup.rs"]),
        (&[("rustc", "echo rustc 1.63.0"), NO_RUSTUP], &["and 1.63.0 was found", "https://rustup.rs"]),
    ] {
        let (code, said, _) = set_up(changes);
        assert!(code == 1 && said.starts_with("setup.sh: "), "{changes:?}: {code}, {said}");
        parts.iter().for_each(|part| assert!(said.contains(part), "{changes:?}: no `{part}` in: {said}"));
        assert!(!said.contains("none was found") || parts[0].contains("none was found"), "{changes:?}: {said}");
    }
}

/// Where no package of shaderc is, its build takes minutes: build script and program share it.
#[test]
fn shaderc_is_built_once() {
    let elsewhere = tempfile::tempdir().unwrap(); // not in the checkout, which may tell cargo to link a package
    let graph =
        ["build", "--release", "--offline", "--locked", "--unit-graph", "-Zunstable-options", "--manifest-path"];
    let mut cargo = Command::new(env!("CARGO"));
    cargo.args(graph).arg(concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml")).env("RUSTC_BOOTSTRAP", "1");
    let output = cargo.current_dir(&elsewhere).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let graph: serde_json::Value = serde_json::from_slice(&output.stdout).unwrap();
    let is_build = |unit: &&serde_json::Value| {
        unit["mode"] == "run-custom-build" && unit["pkg_id"].as_str().unwrap().contains("#shaderc-sys@")
    };
    assert_eq!(graph["units"].as_array().unwrap().iter().filter(is_build).count(), 1);
}

/// docs.rs has no shaderc; it builds the library by `package.metadata.docs.rs`.
#[test]
fn the_pages_of_docs_rs_need_no_shaderc() {
    let manifest: toml::Table = include_str!("../../Cargo.toml").parse().unwrap();
    let asked = &manifest["package"]["metadata"]["docs"]["rs"];
    assert_eq!(asked["no-default-features"].as_bool(), Some(true));
    let words =
        |name: &str| asked[name].as_array().unwrap().iter().map(|word| word.as_str().unwrap()).collect::<Vec<_>>();
    let packages = |flags: &str| {
        let mut cargo = Command::new(env!("CARGO"));
        cargo.args([
            "tree",
            "--package",
            "hypertexture",
            "--no-default-features",
            "--features",
            &words("features").join(","),
        ]);
        cargo.args(["--edges", "normal,build", "--prefix", "none", "--offline", "--locked"]).env("RUSTFLAGS", flags);
        let output = cargo.current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    };
    assert!(packages("").contains("shaderc-sys v"));
    let there = packages(&words("rustc-args").join(" "));
    assert!(there.contains("hypertexture-glsl v") && !there.contains("shaderc"), "{there}");
}
