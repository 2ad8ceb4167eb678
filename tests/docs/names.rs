//! Settings, files and targets of tests that pages and the source name are there.

use hypertexture::scene::schema::{SETTINGS, setting};
use std::path::{Path, PathBuf};

/// Folders that paths in texts begin with.
const FOLDERS: [&str; 8] = ["src/", "crates/", "tests/", "glsl/", "docs/", "benches/", "presets/", "examples/"];
/// Ends of the files that are read.
const TEXTS: [&str; 6] = ["md", "rs", "glsl", "frag", "vert", "toml"];

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

fn ends(path: &Path, ends: &[&str]) -> bool {
    path.extension().is_some_and(|end| ends.iter().any(|own| end == *own))
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    entries.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

/// Pages and scripts outside of [`FOLDERS`]. The changelog names what is gone.
const OTHERS: [&str; 5] = ["README.md", "CONTRIBUTING.md", "SECURITY.md", ".ci/run", "release/build"];

/// The texts of the folders, and [`OTHERS`].
fn texts() -> Vec<(PathBuf, String)> {
    let all = FOLDERS.iter().flat_map(|folder| files(&root().join(folder)));
    let all = all.filter(|path| ends(path, &TEXTS)).chain(OTHERS.map(|name| root().join(name)));
    all.map(|path| (path.clone(), std::fs::read_to_string(path).expect("text"))).collect()
}

/// The words of a text that begin with `start`, each to the first character that `ends` it.
fn words<'a>(text: &'a str, start: &'a str, ends: fn(char) -> bool) -> impl Iterator<Item = &'a str> {
    let within = |c: char| c.is_alphanumeric() || "_./*-".contains(c);
    let places = text.match_indices(start).filter(move |(at, _)| !text[..*at].ends_with(within));
    places.map(move |(at, _)| text[at..].split(ends).next().unwrap_or_default().trim_end_matches('.'))
}

fn ends_path(c: char) -> bool {
    !(c.is_alphanumeric() || "_./-*".contains(c))
}

fn ends_name(c: char) -> bool {
    !(c.is_alphanumeric() || "_.".contains(c))
}

#[test]
fn every_setting_that_a_page_names_is_one() {
    let mut tables: Vec<String> = SETTINGS.iter().map(|setting| format!("{}.", setting.table())).collect();
    tables.retain(|table| table != ".");
    tables.push("parts.".into());
    tables.sort();
    tables.dedup();
    let pages = texts().into_iter().filter(|(path, _)| ends(path, &["md"]));
    let mut count = 0;
    for (path, page) in pages {
        let named = tables.iter().flat_map(|table| words(&page, table, ends_name));
        for name in named.filter(|name| name.contains('.')) {
            let (page, depth) = (path.display(), name.split('.').count());
            let is_other = name.starts_with("parts.") && (depth < 4 || name.contains(".parameters."));
            let moves =
                name.strip_prefix("animation.").is_some_and(|own| own == "parameters" || setting(own).is_some());
            assert!(setting(name).is_some() || is_other || moves, "{page}: there is no setting `{name}`");
            count += 1;
        }
    }
    assert!(count > 150, "only {count} settings were found");
}

#[test]
fn every_file_and_target_that_a_text_names_is_there() {
    let (mut paths, mut targets) = (0, 0);
    for (path, text) in texts() {
        let own = path.display();
        for name in FOLDERS.iter().flat_map(|folder| words(&text, folder, ends_path)) {
            if ends(Path::new(name), &TEXTS) && !name.contains('*') {
                let mut folders = path.ancestors().filter(|folder| folder.join("Cargo.toml").exists());
                assert!(folders.any(|folder| folder.join(name).exists()), "{own}: there is no {name}");
                paths += 1;
            }
        }
        for (flag, folder) in [("test", "tests"), ("bench", "benches")] {
            let flag = format!("--{flag} ");
            for call in words(&text, &flag, |c| !(c.is_alphanumeric() || "_- ".contains(c))) {
                let name = call[flag.len()..].split(' ').next().unwrap_or_default();
                let files = ["", "crates/cli", "crates/measure", "crates/shape"]
                    .map(|of| root().join(of).join(folder).join(name));
                let is_there = |file: &PathBuf| file.with_extension("rs").exists() || file.join("main.rs").exists();
                let is_there = files.iter().any(is_there);
                assert!(is_there, "{own}: there is no target `{call}`");
                targets += 1;
            }
        }
    }
    assert!(paths > 300 && targets > 4, "only {paths} files and {targets} targets were found");
}
