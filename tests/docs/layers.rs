//! The layers of the code: a file imports from its own folder and from folders with smaller numbers, and within a folder
//! none imports what imports it.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

/// Each folder of `src`, from the bottom up, with what it holds. Folders of one number do not know each other.
const LAYERS: &[(usize, &str, &str)] = &[
    (0, "support", "random numbers, files that appear whole, a cache on disk, child processes"),
    (1, "gpu", "Vulkan, the only unsafe code"),
    (1, "shape", "meshes, scans, formulas"),
    (2, "field", "signed distance fields"),
    (2, "noise", "lattices and baked blocks"),
    (3, "shader", "GLSL modules and how they are linked"),
    (3, "exact", "SPIR-V in f64 and in intervals"),
    (4, "scene", "schema, files, presets, checks"),
    (5, "render", "variants, textures, passes, shadows, a frame"),
    (6, "output", "image files, provenance, sequences, shards"),
    (7, "measure", "references, metrics, comparisons, fastest settings, checks, predictions"),
    (8, "viewer", "the window"),
    (9, "cli", "commands"),
];

/// What each of some files and folders imports of the others.
type Arrows = BTreeMap<String, BTreeSet<String>>;

fn source() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
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

/// What a path means in a module, both as places in `src`.
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

/// For each folder of `src`, and for `src` as "", what the files and folders in it import of each other. A `mod.rs` is its
/// folder, so that it and its children may know each other.
fn arrows() -> BTreeMap<PathBuf, Arrows> {
    let source = source();
    let mut arrows: BTreeMap<PathBuf, Arrows> = BTreeMap::new();
    for file in files(&source) {
        let mut module = file.strip_prefix(&source).expect("in src").with_extension("");
        if module.ends_with("mod") {
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

/// What is left when, again and again, all go that import none of those left, or that none of those left imports: circles.
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

#[test]
fn each_layer_imports_only_what_is_below_it() {
    let number = |name: &str| LAYERS.iter().find(|layer| layer.1 == name).map(|layer| layer.0);
    for folder in std::fs::read_dir(source()).expect("src").map(|entry| entry.expect("an entry")) {
        let name = folder.file_name().to_string_lossy().to_string();
        assert!(folder.path().is_file() || number(&name).is_some(), "{name} is in no layer");
    }
    for (layer, imports) in &arrows()[Path::new("")] {
        for import in imports {
            let (above, below) = (number(layer), number(import));
            assert!(
                above.is_some() && below.is_some() && above > below,
                "{layer} {above:?} imports {import} {below:?}"
            );
        }
    }
}

#[test]
fn within_a_folder_nothing_imports_what_imports_it() {
    let found = arrows().into_iter().map(|(folder, arrows)| (folder, circles(arrows)));
    let found: Vec<_> = found.filter(|(_, circles)| !circles.is_empty()).collect();
    assert!(found.is_empty(), "{found:#?}");
}

#[test]
fn the_layers_are_drawn_as_they_are() {
    let arrows = &arrows()[Path::new("")];
    let mut drawn = String::from("```text\n");
    for (number, name, holds) in LAYERS.iter().rev() {
        let imports: Vec<&str> = arrows.get(*name).into_iter().flatten().map(String::as_str).collect();
        let imports = if imports.is_empty() { "-".into() } else { imports.join(" ") };
        drawn += &format!("{number}  {name:<8} {holds}\n            imports {imports}\n");
    }
    drawn += "```\n";
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/architecture.md");
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
