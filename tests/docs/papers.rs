//! The table of `docs/papers.md`: a row for each idea of the papers, in order, with files that exist and with a test that bears
//! its name or stands in it; and a row for each test that bears the name of one.

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

const PAGE: &str = include_str!("../../docs/papers.md");

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// Name, idea, and files and tests of each row.
fn rows() -> Vec<[&'static str; 3]> {
    let lines = PAGE.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| row"));
    let cells = lines.map(|line| line.trim_matches('|').split(" | ").map(str::trim).collect::<Vec<_>>());
    cells.map(|cells| cells.try_into().unwrap_or_else(|cells| panic!("three columns: {cells:?}"))).collect()
}

fn word(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    &text[..end]
}

/// Names of all tests of the project: functions, and rows `name = check` of `tests/formulas`.
fn tests() -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    let mut folders: Vec<PathBuf> = ["src", "tests", "crates"].map(|name| root().join(name)).into();
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|end| end == "rs") {
                let text = std::fs::read_to_string(&path).unwrap();
                let mut is_test = false;
                for line in text.lines() {
                    let name = word(line.trim().strip_prefix("fn ").unwrap_or_default());
                    let row = line.strip_prefix("    ").map(|line| (word(line), line));
                    let row = row.filter(|(name, line)| line[name.len()..].starts_with(" = ")).map(|(name, _)| name);
                    if is_test && !name.is_empty() {
                        found.insert(name.to_owned());
                    } else if let Some(row) = row.filter(|_| path.starts_with(root().join("tests/formulas"))) {
                        found.insert(row.to_owned());
                    }
                    is_test = line.trim() == "#[test]" || (is_test && line.trim().starts_with("#["));
                }
            }
        }
    }
    found
}

/// The rows that a test is named after: `m32_p44_...`.
fn named_after(test: &str) -> Vec<String> {
    let is_id = |word: &&str| {
        let mut letters = word.chars();
        let paper = letters.next().is_some_and(|c| "mpgs".contains(c));
        paper && letters.as_str().len() == 2 && letters.all(|c| c.is_ascii_digit())
    };
    let ids = test.split('_').take_while(is_id).map(|id| match id {
        "p06" | "p07" | "p08" | "p09" => "P06-9".to_owned(),
        "s01" => "S01-5".to_owned(),
        id => id.to_uppercase(),
    });
    ids.collect()
}

#[test]
fn every_row_of_the_papers_is_there_once_and_in_order() {
    let numbered = |paper: char, range: std::ops::RangeInclusive<u32>| range.map(move |n| format!("{paper}{n:02}"));
    let expected: Vec<String> = numbered('M', 1..=64)
        .chain(numbered('P', 1..=5))
        .chain(["P06-9".to_owned()])
        .chain(numbered('P', 10..=58))
        .chain(numbered('G', 1..=14))
        .chain(["S01-5".to_owned()])
        .collect();
    assert_eq!(rows().iter().map(|[id, ..]| *id).collect::<Vec<_>>(), expected);
}

#[test]
fn every_row_has_files_and_a_test_and_every_named_test_a_row() {
    let (tests, mut tested) = (tests(), BTreeSet::new());
    for test in &tests {
        tested.extend(named_after(test));
    }
    for [id, idea, code] in rows() {
        let (files, named): (Vec<&str>, Vec<&str>) =
            code.split('`').skip(1).step_by(2).partition(|word| word.contains('/') || word.contains('.'));
        assert!(!idea.is_empty() && !files.is_empty(), "{id} says nothing");
        for file in files {
            assert!(root().join(file).exists(), "{id}: no file {file}");
        }
        for test in &named {
            assert!(tests.contains(*test), "{id}: no test {test}");
        }
        let is_open = idea.contains("**open**") || idea.contains("**refused**");
        assert!(tested.remove(id) || !named.is_empty() || is_open, "{id} has no test");
    }
    assert!(tested.is_empty(), "docs/papers.md lacks {tested:?}");
}

#[test]
fn the_rows_of_a_test_are_read_from_its_name() {
    assert_eq!(named_after("m32_p44_front_to_back"), ["M32", "P44"]);
    assert_eq!(named_after("p06_to_p09_soft_booleans"), ["P06-9"]);
    assert_eq!(named_after("s01_5_the_tank"), ["S01-5"]);
    assert!(named_after("n0_10_a_crash").is_empty() && named_after("a_mesh").is_empty());
}
