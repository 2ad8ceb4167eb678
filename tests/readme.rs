//! What the README shows is true: its scene file, its module and its table of parameters.
#![expect(clippy::unwrap_used, reason = "a test fails where the README is not as described")]

use hypertexture::render::variant::Variant;
use hypertexture::scene::{self, ParameterValue, Scene};
use hypertexture::shader::{self, Linker};
use std::fmt::Write;

const README: &str = include_str!("../README.md");

/// The first block of code in this language.
fn block(language: &str) -> &'static str {
    let start = README.split_once(&format!("```{language}\n")).unwrap().1;
    start.split_once("```").unwrap().0
}

#[test]
fn the_scene_file_of_the_readme_is_valid() {
    let scene = scene::parse(block("toml"), "README.md").unwrap();
    scene.check(&shader::shipped()).unwrap();
    assert_eq!(scene.effect, scene::preset("fur").unwrap().effect);
}

#[test]
fn the_module_of_the_readme_links_and_declares_its_parameters() {
    let library = shader::shipped().with_module("dmf", "ripples", block("glsl"));
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

/// The list of effects and figures, as `docs/effects.md` must have it.
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
        "docs/effects.md is out of date; `BLESS=effects cargo test --release --test readme` writes it"
    );
    for name in scene::names() {
        assert!(README.contains(&format!("`{name}`")), "the README does not name {name}");
    }
}
