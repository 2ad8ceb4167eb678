//! `effects`: the effects and their parameters.

use crate::terminal::say;
use hypertexture::render::variant::Variant;
use hypertexture::scene::{self, ParameterValue};
use hypertexture::shader::{self, ParameterKind};
use std::error::Error;

/// Prints the list.
pub(crate) fn run() -> Result<(), Box<dyn Error>> {
    let library = shader::shipped();
    let mut text = String::new();
    for name in scene::names() {
        let scene = scene::preset(name)?;
        text.push_str(&format!("{name}: {}\n", scene.about));
        let kinds = library.kinds(scene.dmfs())?;
        if !kinds.is_empty() {
            text.push_str(&format!("    {kinds}\n"));
        }
        for (name, parameter, value) in Variant::of(&scene, &library)?.all_parameters() {
            let value = match (value, parameter.kind) {
                (ParameterValue::Number(value), ParameterKind::Number(_, [low, high])) => {
                    format!("{value} in [{low}, {high}]")
                }
                (ParameterValue::Number(value), ParameterKind::Color(_)) => value.to_string(),
                (ParameterValue::Color(color), _) => String::from(*color),
            };
            text.push_str(&format!("    {name:<24} {value:<24} {}\n", parameter.doc));
        }
    }
    say(&text);
    Ok(())
}
