//! Every command line that the README and the pages in `docs` show is one that the program takes.
#![expect(clippy::unwrap_used, reason = "a test fails where a page cannot be read")]

use super::command_line::Arguments;
use clap::Parser;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The README and the pages in `docs`.
fn pages() -> Vec<PathBuf> {
    let root = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."));
    let docs = std::fs::read_dir(root.join("docs")).unwrap().map(|entry| entry.unwrap().path());
    let docs = docs.filter(|path| path.extension().is_some_and(|end| end == "md"));
    std::iter::once(root.join("README.md")).chain(docs).collect()
}

/// Lines of code blocks, and code within the text.
fn code(page: &str) -> Vec<String> {
    let mut code = Vec::new();
    for (index, part) in page.split("```").enumerate() {
        if index % 2 == 1 {
            code.extend(part.lines().skip(1).map(String::from));
        } else {
            code.extend(part.split('`').skip(1).step_by(2).map(|words| words.replace('\n', " ")));
        }
    }
    code
}

/// Arguments of each call of the program in a line.
fn calls(line: &str) -> Vec<&str> {
    let line = line.split_once(" #").map_or(line, |(line, _)| line);
    let commands = line.split("&&").map(|command| command.split(" > ").next().unwrap_or_default().trim());
    let starts = ["hypertexture ", "cargo run --release -- ", "xvfb-run -a hypertexture "];
    commands.filter_map(|command| starts.iter().find_map(|start| command.strip_prefix(start))).collect()
}

/// Words, as `sh` reads them.
fn words(line: &str) -> Vec<String> {
    let output = Command::new("sh").args(["-fc", &format!("printf '%s\\0' {line}")]).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    text.trim_end_matches('\0').split('\0').map(String::from).collect()
}

#[test]
fn every_command_line_of_the_docs_is_taken() {
    let mut count = 0;
    for path in pages() {
        let page = std::fs::read_to_string(&path).unwrap();
        for line in code(&page) {
            for call in calls(&line) {
                let words = std::iter::once("hypertexture".to_owned()).chain(words(call));
                if let Err(error) = Arguments::try_parse_from(words) {
                    assert!(!error.use_stderr(), "{}: `{line}`: {error}", path.display());
                }
                count += 1;
            }
        }
    }
    assert!(count > 60, "only {count} command lines were found");
}

#[test]
fn calls_are_found_where_a_shell_would_find_them() {
    assert_eq!(calls("./setup.sh && cargo run --release -- gallery    # all"), ["gallery"]);
    assert_eq!(calls("hypertexture man > hypertexture.1 && hypertexture effects"), ["man", "effects"]);
    assert_eq!(calls("cargo test --release"), Vec::<&str>::new());
    let page = "a `b c` d\n```sh\ne f\n```\n`g\nh`";
    assert_eq!(code(page), ["b c", "e f", "g h"]);
}
