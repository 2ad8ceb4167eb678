//! What the README shows is true: its scene file, its module and its table of knobs.
#![expect(clippy::unwrap_used, reason = "a test fails where the README is not as described")]

use hypertexture::glsl::{self, Linker};
use hypertexture::scene::{self, KnobValue, Scene};
use hypertexture::variant::Variant;

const README: &str = include_str!("../README.md");

/// The first block of code in this language.
fn block(language: &str) -> &'static str {
    let start = README.split_once(&format!("```{language}\n")).unwrap().1;
    start.split_once("```").unwrap().0
}

#[test]
fn the_scene_file_of_the_readme_is_valid() {
    let scene = scene::parse(block("toml"), "README.md").unwrap();
    scene.check(&glsl::shipped()).unwrap();
    assert_eq!(scene.effect, scene::preset("fur").unwrap().effect);
}

#[test]
fn the_module_of_the_readme_links_and_declares_its_knobs() {
    let library = glsl::shipped().with_module("dmf", "ripples", block("glsl"));
    let mut scene = Scene::default();
    let effect = &mut scene.effect;
    (effect.classify, effect.softness, effect.medium) = ("soft".into(), "linear".into(), "lit".into());
    effect.dmf = vec!["ripples".into()];
    let variant = Variant::of(&scene, &library).unwrap();
    let knobs: Vec<&str> = variant.knobs.iter().map(|(knob, _)| knob.name.as_str()).collect();
    assert_eq!(knobs, ["ring_width", "rings"]);
    assert_eq!(variant.knobs.outer_iso(), Some(0.3));
    variant.program(&library, Linker::new).unwrap();
}

#[test]
fn the_table_of_the_readme_lists_every_knob_as_it_is() {
    for name in scene::names() {
        assert!(README.contains(&format!("| `{name}` |")), "{name} is not in the table");
        for (knob, value) in scene::preset(name).unwrap().check(&glsl::shipped()).unwrap().iter() {
            let value = match (value, knob.default) {
                (KnobValue::Number(value), glsl::Default::Number(_, [low, high])) => {
                    format!("{value} in [{low}, {high}]")
                }
                (KnobValue::Number(value), glsl::Default::Color(_)) => value.to_string(),
                (KnobValue::Color(color), _) => String::from(*color),
            };
            let row = format!("| `{}` | {value} | {} |", knob.name, knob.doc);
            assert!(README.contains(&row), "the table lacks the row of {name}: {row}");
        }
    }
}
