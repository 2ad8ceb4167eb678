//! Contents of the README and of the pages in `docs` are true: scene files, the custom module, the list of effects, links.

use hypertexture::render::variant::Variant;
use hypertexture::scene::{self, ParameterValue, Scene};
use hypertexture::shader::{self, Linker};
use std::fmt::Write;
use std::path::{Path, PathBuf};

const README: &str = include_str!("../../README.md");
const GUIDE: &str = include_str!("../../docs/guide.md");
const MODULES: &str = include_str!("../../docs/modules.md");

/// The blocks of code in this language.
fn blocks<'a>(page: &'a str, language: &str) -> Vec<&'a str> {
    page.split(&format!("```{language}\n")).skip(1).map(|rest| rest.split_once("```").unwrap().0).collect()
}

/// The README and the pages in `docs`.
fn pages() -> Vec<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let docs = std::fs::read_dir(root.join("docs")).unwrap().map(|entry| entry.unwrap().path());
    let docs = docs.filter(|path| path.extension().is_some_and(|end| end == "md"));
    std::iter::once(root.join("README.md")).chain(docs).collect()
}

/// The anchor that a heading has, as GitHub makes it.
fn anchor(heading: &str) -> String {
    let kept = heading.trim().to_lowercase();
    kept.chars().filter(|&c| c.is_alphanumeric() || " -_".contains(c)).collect::<String>().replace(' ', "-")
}

#[test]
fn the_readme_is_short() {
    let lines = README.lines().count();
    assert!(lines <= 150, "{lines} lines: move something to docs");
    for command in
        ["cargo run --release -- gallery ", "HYPERTEXTURE_DEVICE=llvmpipe GALLIVM_PERF=nopt cargo test --release "]
    {
        assert!(README.contains(&format!("\n./setup.sh && {command}")), "{command}");
    }
}

#[test]
fn every_link_between_pages_leads_somewhere() {
    let mut count = 0;
    let others =
        ["CHANGELOG.md", "CONTRIBUTING.md", "SECURITY.md"].map(|name| Path::new(env!("CARGO_MANIFEST_DIR")).join(name));
    for path in pages().into_iter().chain(others) {
        let page = std::fs::read_to_string(&path).unwrap();
        let text: String = page.split("```").step_by(2).collect();
        for link in text.split("](").skip(1).map(|rest| rest.split_once(')').unwrap().0) {
            if link.contains("://") {
                continue;
            }
            let (file, place) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() { path.clone() } else { path.parent().unwrap().join(file) };
            assert!(target.exists(), "{}: no file {link}", path.display());
            if !place.is_empty() {
                let page = std::fs::read_to_string(&target).unwrap();
                let mut headings = page.lines().filter(|line| line.starts_with('#'));
                let found = headings.any(|line| anchor(line.trim_start_matches('#')) == place);
                assert!(found, "{}: no heading {link}", path.display());
            }
            count += 1;
        }
    }
    assert!(count > 10, "only {count} links were found");
}

#[test]
fn every_page_is_found_from_the_readme() {
    for path in pages() {
        let name = path.file_name().unwrap().to_str().unwrap();
        assert!(name == "README.md" || README.contains(&format!("(docs/{name})")), "the README does not link {name}");
    }
}

#[test]
fn the_scene_files_of_the_guide_are_valid() {
    let scenes = blocks(GUIDE, "toml").into_iter().map(|text| scene::parse(text, "guide.md").unwrap());
    let scenes: Vec<Scene> = scenes.collect();
    assert_eq!(scenes.len(), 3);
    for scene in &scenes {
        scene.check(&shader::shipped()).unwrap();
    }
    assert_eq!(scenes[0].effect, scene::preset("fur").unwrap().effect);
    assert_eq!((scenes[1].parts.len(), scenes[2].animation.tracks.len()), (2, 3));
}

#[test]
fn the_custom_module_links_and_declares_its_parameters() {
    let module = include_str!("../../examples/ripples.glsl");
    assert_eq!([README, MODULES].map(|page| blocks(page, "glsl")[0]), [module; 2]);
    let library = shader::shipped().with_module("dmf", "ripples", module);
    let mut scene = Scene::default();
    let effect = &mut scene.effect;
    (effect.classify, effect.softness, effect.medium) = ("soft".into(), "linear".into(), "lit".into());
    effect.dmf = vec!["ripples".into()];
    let variant = Variant::of(&scene, &library).unwrap();
    let parameters: Vec<&str> = variant.parameters.iter().map(|(parameter, _)| parameter.name.as_str()).collect();
    assert_eq!(parameters, ["ring_width", "rings"]);
    assert_eq!(variant.parameters.outer_iso(), Some(0.3));
    variant.program(&library, Linker::new).unwrap();
}

/// The list of effects and example scenes, as `docs/effects.md` must have it.
fn effects() -> String {
    let mut text = String::from(
        "# Effects, example scenes and their parameters\n\n`--set PARAMETER=VALUE`, or `[parameters]` in a scene file, changes one.\n",
    );
    let library = shader::shipped();
    for name in scene::names() {
        let scene = scene::preset(name).unwrap();
        let variant = Variant::of(&scene, &library).unwrap();
        let about = format!("{} {}", scene.about, library.kinds(scene.dmfs()).unwrap());
        writeln!(text, "\n## {name}\n\n{}", about.trim_end()).unwrap();
        let mut rows = String::new();
        for (name, parameter, value) in variant.all_parameters() {
            let value = match (value, parameter.kind) {
                (ParameterValue::Number(value), shader::ParameterKind::Number(_, [low, high])) => {
                    format!("{value} in [{low}, {high}]")
                }
                (ParameterValue::Number(value), shader::ParameterKind::Color(_)) => value.to_string(),
                (ParameterValue::Color(color), _) => String::from(*color),
            };
            writeln!(rows, "| `{name}` | {value} | {} |", parameter.doc).unwrap();
        }
        if !rows.is_empty() {
            write!(text, "\n| parameter | value and range | what it does |\n|---|---|---|\n{rows}").unwrap();
        }
    }
    text
}

#[test]
fn the_list_of_effects_is_that_of_the_presets() {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/docs/effects.md");
    if std::env::var("BLESS").is_ok_and(|name| name == "effects" || name == "all") {
        std::fs::write(path, effects()).unwrap();
    }
    let written = std::fs::read_to_string(path).unwrap_or_default();
    assert!(
        written == effects(),
        "docs/effects.md is out of date; `BLESS=effects cargo test --release --test library` writes it"
    );
    for name in scene::names() {
        assert!(README.contains(&format!("`{name}`")), "the README does not name {name}");
    }
}
