//! The files that `release/manuals` adds to a package.

use super::desk::{Desk, text};
use std::collections::BTreeSet;
use std::path::Path;
use std::process::Command;

/// Manual pages that the page of the program refers to.
fn referred(page: &str) -> BTreeSet<String> {
    let lines = page.lines().map(|line| line.replace('\\', ""));
    lines.filter_map(|line| Some(format!("man/{}.1", line.strip_suffix("(1)")?))).collect()
}

/// Names of the assets of the package in these folders, from the manifest.
fn assets() -> Vec<String> {
    let manifest: toml::Table = include_str!("../../Cargo.toml").parse().unwrap();
    let assets = manifest["package"]["metadata"]["deb"]["assets"].as_array().unwrap();
    let sources = assets.iter().map(|asset| asset[0].as_str().unwrap());
    sources.filter_map(|source| source.strip_prefix("target/release/package/").map(String::from)).collect()
}

#[test]
fn a_package_has_the_man_page_of_every_command() {
    let desk = Desk::new();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../release/manuals");
    let mut command = Command::new(script);
    let output =
        command.args([env!("CARGO_BIN_EXE_hypertexture"), "package"]).current_dir(desk.work()).output().unwrap();
    assert!(output.status.success() && output.stdout.is_empty(), "{}", text(&output.stderr));
    let files = desk.files().into_iter();
    let files = files.map(|(path, bytes)| {
        (path.strip_prefix(desk.file("package")).unwrap().to_str().unwrap().to_owned(), text(&bytes))
    });
    let (mut pages, completions): (Vec<_>, Vec<_>) = files.partition(|(name, _)| name.starts_with("man/"));

    let main = pages.iter().position(|(name, _)| name == "man/hypertexture.1").unwrap();
    let (_, main) = pages.remove(main);
    let commands: BTreeSet<String> = pages.iter().map(|(name, _)| name.clone()).collect();
    assert_eq!(commands, referred(&main));
    for (name, page) in &pages {
        let command = name.trim_start_matches("man/hypertexture-").trim_end_matches(".1");
        assert_eq!(*page, desk.good(&format!("man {command}")));
        for (file, script) in &completions {
            assert!(script.contains(command), "{file} lacks {command}");
        }
    }
    assert!(commands.contains("man/hypertexture-render.1") && commands.len() >= 15, "{commands:?}");

    for asset in assets().iter().filter(|asset| *asset != "licenses.txt") {
        let is_there = completions.iter().any(|(name, _)| name == asset) || asset == "man/*.1";
        assert!(is_there, "release/manuals does not write {asset}");
    }
}
