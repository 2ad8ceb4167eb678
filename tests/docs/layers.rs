//! The crates as the docs draw them; and within a crate, no file or folder imports what imports it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Imports between files and folders.
type Arrows = BTreeMap<String, BTreeSet<String>>;

fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The folders of the crates.
fn crates() -> Vec<PathBuf> {
    let entries =
        std::fs::read_dir(root().join("crates")).expect("crates").map(|entry| entry.expect("an entry").path());
    entries.chain([root().into()]).collect()
}

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let nested = entries.map(|path| if path.is_dir() { files(&path) } else { vec![path] });
    nested.flatten().filter(|path| path.extension().is_some_and(|end| end == "rs")).collect()
}

/// The code of a file without comments and without its tests.
fn code(path: &Path) -> String {
    if path.ends_with("tests.rs") {
        return String::new();
    }
    let text = std::fs::read_to_string(path).expect("source");
    let text = text.split("\n#[cfg(test)]\nmod tests {").next().unwrap_or_default();
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// The paths that begin with `crate` or `super` in a text, those in braces one by one.
fn imports(code: &str) -> Vec<String> {
    let mut found = Vec::new();
    for (at, _) in code.match_indices("crate::").chain(code.match_indices("super::")) {
        if !code[..at].ends_with("::") {
            read_path("", &code[at..], &mut found);
        }
    }
    found
}

/// Reads a path behind its beginning, with those in its braces; gives the text behind it.
fn read_path<'a>(start: &str, text: &'a str, found: &mut Vec<String>) -> &'a str {
    let text = text.trim_start();
    let end = text.find(|c: char| !c.is_alphanumeric() && c != '_' && c != ':').unwrap_or(text.len());
    let (path, mut rest) = (format!("{start}{}", &text[..end]), &text[end..]);
    if !path.ends_with("::") || !rest.starts_with('{') {
        if end > 0 {
            found.push(path);
        }
        return rest;
    }
    while rest.starts_with(['{', ',']) {
        rest = read_path(&path, &rest[1..], found);
        rest = &rest[rest.find([',', '}']).unwrap_or(rest.len())..];
    }
    rest.get(1..).unwrap_or_default()
}

/// Resolves a path in a module; both are places in `src`.
fn resolve(module: &Path, path: &str) -> PathBuf {
    let mut place = module.to_path_buf();
    for part in path.split("::") {
        match part {
            "crate" => place.clear(),
            "super" => drop(place.pop()),
            part => place.push(part),
        }
    }
    place
}

/// For each folder of the sources of a crate, and for `src` as "", what the files and folders in it import of each other. A
/// `mod.rs` is its folder, so that it and its children may know each other; so is `lib.rs`.
fn arrows(source: &Path) -> BTreeMap<PathBuf, Arrows> {
    let mut arrows: BTreeMap<PathBuf, Arrows> = BTreeMap::new();
    for file in files(source) {
        let mut module = file.strip_prefix(source).expect("in src").with_extension("");
        if ["mod", "lib", "main"].iter().any(|name| module.ends_with(name)) {
            module.pop();
        }
        for import in imports(&code(&file)) {
            let other = resolve(&module, &import);
            let shared: PathBuf = module.iter().zip(&other).take_while(|(a, b)| a == b).map(|(a, _)| a).collect();
            let name = |path: &Path| Some(path.iter().nth(shared.iter().count())?.to_string_lossy().to_string());
            let (Some(from), Some(to)) = (name(&module), name(&other)) else { continue };
            let sibling = source.join(&shared).join(&to);
            if sibling.is_dir() || sibling.with_extension("rs").is_file() {
                arrows.entry(shared).or_default().entry(from).or_default().insert(to);
            }
        }
    }
    arrows
}

/// Circles: the rest after repeated removal of nodes without imports or without importers.
fn circles(mut arrows: Arrows) -> Arrows {
    loop {
        let left: BTreeSet<String> = arrows.keys().cloned().collect();
        arrows.values_mut().for_each(|imports| imports.retain(|import| left.contains(import)));
        let imported: BTreeSet<String> = arrows.values().flatten().cloned().collect();
        arrows.retain(|name, imports| !imports.is_empty() && imported.contains(name));
        if arrows.len() == left.len() {
            return arrows;
        }
    }
}

/// A crate as the docs draw it: its height over those that it uses, its name, and its lines.
fn drawn() -> String {
    let mut uses: BTreeMap<String, (String, BTreeSet<String>)> = BTreeMap::new();
    for folder in crates() {
        let text = std::fs::read_to_string(folder.join("Cargo.toml")).expect("Cargo.toml");
        let manifest: toml::Table = text.parse().expect("TOML");
        let (package, dependencies) =
            (&manifest["package"], manifest.get("dependencies").and_then(toml::Value::as_table));
        let name = |package: &str| package.trim_start_matches("hypertexture-").to_string();
        let own = name(package["name"].as_str().expect("a name"));
        let about = package["description"].as_str().expect("a description");
        uses.insert(own, (about.into(), dependencies.into_iter().flatten().map(|(other, _)| name(other)).collect()));
    }
    let names: BTreeSet<String> = uses.keys().cloned().collect();
    uses.values_mut().for_each(|(_, used)| used.retain(|name| names.contains(name)));
    let (mut levels, mut drawn) = (BTreeMap::<String, usize>::new(), BTreeSet::new());
    while levels.len() < names.len() {
        for (name, (about, used)) in &uses {
            if let Some(level) =
                used.iter().map(|other| levels.get(other).map(|level| level + 1)).collect::<Option<Vec<_>>>()
            {
                let level = level.into_iter().max().unwrap_or_default();
                levels.insert(name.clone(), level);
                let used = if used.is_empty() { "-".into() } else { Vec::from_iter(used.iter().cloned()).join(" ") };
                drawn.insert((
                    usize::MAX - level,
                    format!("{:<14} {about}\n               uses {used}\n", format!("{name}:")),
                ));
            }
        }
    }
    format!("```text\n{}```\n", drawn.into_iter().map(|(_, lines)| lines).collect::<String>())
}

#[test]
fn within_a_crate_nothing_imports_what_imports_it() {
    for folder in crates() {
        let found = arrows(&folder.join("src")).into_iter().map(|(folder, arrows)| (folder, circles(arrows)));
        let found: Vec<_> = found.filter(|(_, circles)| !circles.is_empty()).collect();
        assert!(found.is_empty(), "{}: {found:#?}", folder.display());
    }
}

#[test]
fn the_crates_are_drawn_as_they_are() {
    let (drawn, page) = (drawn(), root().join("docs/architecture.md"));
    let text = std::fs::read_to_string(page).expect("docs/architecture.md");
    assert!(text.contains(&drawn), "docs/architecture.md must hold\n{drawn}");
}

#[test]
fn imports_are_found_in_braces_and_alone() {
    let code = "use crate::a::b; use super::{c::{d, e as f},\n g::*, h,}; super::super::i(crate::j)";
    let expected =
        ["crate::a::b", "crate::j", "super::c::d", "super::c::e", "super::g::", "super::h", "super::super::i"];
    assert_eq!(imports(code), expected);
    assert_eq!(resolve(Path::new("x/y/z"), "super::super::i"), Path::new("x/i"));
}

#[test]
fn a_circle_is_found_and_a_tree_is_none() {
    let arrows = |pairs: &[(&str, &str)]| {
        let mut arrows = Arrows::new();
        for (from, to) in pairs {
            arrows.entry(from.to_string()).or_default().insert(to.to_string());
        }
        arrows
    };
    assert!(circles(arrows(&[("a", "b"), ("a", "c"), ("b", "c")])).is_empty());
    let circle = [("a", "b"), ("b", "c"), ("c", "a")];
    assert_eq!(circles(arrows(&[&circle[..], &[("a", "d"), ("e", "a")]].concat())), arrows(&circle));
}
