//! The layers of the code: a file imports from its own folder and from folders with smaller numbers.

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

fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = std::fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let nested = entries.map(|path| if path.is_dir() { files(&path) } else { vec![path] });
    nested.flatten().filter(|path| path.extension().is_some_and(|end| end == "rs")).collect()
}

/// The code of a file without comments and without what is for tests alone.
fn code(path: &Path) -> String {
    let text = std::fs::read_to_string(path).expect("source");
    let text = text.split("\n#[cfg(test)]").next().unwrap_or_default();
    text.lines().map(|line| line.split("//").next().unwrap_or_default()).collect::<Vec<_>>().join("\n")
}

/// Folders that a text names after `crate::`, alone or in braces.
fn imports(code: &str) -> BTreeSet<String> {
    let word = |text: &str| text.trim().chars().take_while(|&c| c.is_alphanumeric() || c == '_').collect::<String>();
    let mut found = BTreeSet::new();
    for rest in code.split("crate::").skip(1) {
        let Some(group) = rest.strip_prefix('{') else {
            found.insert(word(rest));
            continue;
        };
        let (mut depth, mut start) = (1, 0);
        for (at, c) in group.char_indices() {
            match c {
                '{' => depth += 1,
                '}' => depth -= 1,
                _ => {}
            }
            if depth == 0 || (c == ',' && depth == 1) {
                found.insert(word(&group[start..at]));
                start = at + 1;
            }
            if depth == 0 {
                break;
            }
        }
    }
    found.remove("");
    found
}

/// What each layer imports of the others.
fn arrows() -> BTreeMap<String, BTreeSet<String>> {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut arrows: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
    for file in files(&source) {
        let inside = file.strip_prefix(&source).expect("in src");
        let layer = inside.iter().next().expect("a name").to_string_lossy().to_string();
        if layer.ends_with(".rs") {
            continue;
        }
        let mut imports = imports(&code(&file));
        imports.remove(&layer);
        arrows.entry(layer).or_default().append(&mut imports);
    }
    arrows
}

#[test]
fn each_layer_imports_only_what_is_below_it() {
    let number = |name: &str| LAYERS.iter().find(|layer| layer.1 == name).map(|layer| layer.0);
    let arrows = arrows();
    assert_eq!(arrows.len(), LAYERS.len(), "a layer is missing: {:?}", arrows.keys());
    for (layer, imports) in &arrows {
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
fn the_layers_are_drawn_as_they_are() {
    let arrows = arrows();
    let mut drawn = String::from("```text\n");
    for (number, name, holds) in LAYERS.iter().rev() {
        let imports: Vec<&str> = arrows[*name].iter().map(String::as_str).collect();
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
    let code = "use crate::a::b; use crate::{c::{d, e}, f, g::*}; crate::h(1)";
    assert_eq!(imports(code).iter().map(String::as_str).collect::<Vec<_>>(), ["a", "c", "f", "g", "h"]);
}
