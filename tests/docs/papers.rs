//! The table of `docs/papers.md`: a row for each idea of the papers, in order, whose files and tests exist; and every test
//! that is named after a row is in that row.
#![expect(clippy::unwrap_used, reason = "a test fails where the table is not as described")]

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

const PAGE: &str = include_str!("../../docs/papers.md");

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// A row of the table: what it is, its files, and its tests as pairs of file and name.
struct Row<'a> {
    id: &'a str,
    what: &'a str,
    files: Vec<&'a str>,
    tests: Vec<(&'a str, &'a str)>,
}

fn quoted(cell: &str) -> impl Iterator<Item = &str> {
    cell.split('`').skip(1).step_by(2)
}

fn rows() -> Vec<Row<'static>> {
    let lines = PAGE.lines().filter(|line| line.starts_with("| ") && !line.starts_with("| row"));
    let rows = lines.map(|line| {
        let cells: Vec<&str> = line.trim_matches('|').split(" | ").map(str::trim).collect();
        let [id, what, files, tests] = cells[..] else { panic!("four columns: {line}") };
        let mut file = "";
        let mut named = Vec::new();
        for word in quoted(tests) {
            if word.contains('/') {
                file = word;
            } else {
                named.push((file, word));
            }
        }
        Row { id, what, files: quoted(files).collect(), tests: named }
    });
    rows.collect()
}

/// Every test of the project by its file: functions, and rows of `tests/formulas`.
fn tests() -> BTreeMap<String, BTreeSet<String>> {
    let mut found: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    let mut folders: Vec<PathBuf> = ["src", "tests", "crates"].map(|name| root().join(name)).into();
    while let Some(folder) = folders.pop() {
        for path in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
            } else if path.extension().is_some_and(|end| end == "rs") {
                let name = path.strip_prefix(root()).unwrap().to_str().unwrap().to_owned();
                let text = std::fs::read_to_string(&path).unwrap();
                let names = if name.starts_with("tests/formulas/") { formulas(&text) } else { Vec::new() };
                found.insert(name, names.into_iter().chain(functions(&text)).map(String::from).collect());
            }
        }
    }
    found
}

fn word(text: &str) -> &str {
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len());
    &text[..end]
}

/// The functions that are tests.
fn functions(text: &str) -> Vec<&str> {
    let mut names = Vec::new();
    let mut test = false;
    for line in text.lines().map(str::trim) {
        match line.strip_prefix("fn ") {
            Some(rest) if test => names.push(word(rest)),
            _ => {}
        }
        test = line == "#[test]" || (test && line.starts_with("#["));
    }
    names
}

/// The tests that `rows!` makes: `name = check`.
fn formulas(text: &str) -> Vec<&str> {
    let lines = text.lines().filter_map(|line| line.strip_prefix("    "));
    lines
        .map(|line| (word(line), line))
        .filter(|(name, line)| line[name.len()..].starts_with(" = "))
        .map(|(name, _)| name)
        .collect()
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
    assert_eq!(rows().iter().map(|row| row.id).collect::<Vec<_>>(), expected);
}

#[test]
fn every_file_and_every_test_of_a_row_exists() {
    let known = tests();
    for Row { id, what, files, tests } in rows() {
        assert!(!what.is_empty() && !files.is_empty(), "{id} says nothing");
        for file in files {
            assert!(root().join(file).exists(), "{id}: no file {file}");
        }
        assert!(!tests.is_empty() || what.contains("**open**") || what.contains("**refused**"), "{id} has no test");
        for (file, test) in tests {
            let names = known.get(file).unwrap_or_else(|| panic!("{id}: no file {file}"));
            assert!(names.contains(test), "{id}: no test {test} in {file}");
        }
    }
}

#[test]
fn every_test_that_is_named_after_a_row_is_in_that_row() {
    let rows = rows();
    let mut missing = Vec::new();
    for (file, names) in tests() {
        for name in names {
            for id in named_after(&name) {
                let row = rows.iter().find(|row| row.id == id);
                let listed = row.is_some_and(|row| row.tests.contains(&(file.as_str(), name.as_str())));
                if !listed {
                    missing.push(format!("{id}: {file} {name}"));
                }
            }
        }
    }
    assert!(missing.is_empty(), "docs/papers.md lacks\n{}", missing.join("\n"));
}

#[test]
fn the_rows_of_a_test_are_read_from_its_name() {
    assert_eq!(named_after("m32_p44_front_to_back"), ["M32", "P44"]);
    assert_eq!(named_after("p06_to_p09_soft_booleans"), ["P06-9"]);
    assert_eq!(named_after("s01_5_the_tank"), ["S01-5"]);
    assert!(named_after("n0_10_a_crash").is_empty() && named_after("a_mesh").is_empty());
}
