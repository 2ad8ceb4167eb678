//! Role of a medium's color in other renderers: light that it emits, or light that it scatters.

use crate::render::variant::Variant;
use crate::shader::{Library, find_word};
use std::collections::BTreeMap;

/// Media of a scene and of its additional objects, with whether lights of the scene shade the color: it is then an albedo, and else
/// an emission.
///
/// The program decides: a medium is lit if it reads the ambient light. Hard objects have the name of their surface.
pub fn lit_media(library: &Library, variant: &Variant) -> BTreeMap<String, bool> {
    let scene = &variant.scene;
    let all = [scene.clone()].into_iter().chain(scene.parts.keys().map(|name| scene.part_as_scene(name)));
    let of_scene = |scene: crate::scene::Scene| {
        let effect = scene.effect;
        let (slot, names) = match effect.classify.as_str() {
            "surface" => ("surface", effect.surface),
            "post" | "pre" | "preintegrated" => ("transfer", "transfer".into()),
            _ => ("medium", effect.medium),
        };
        let names_light = |text: &str| find_word(text, |word| word == "ambient_color").is_some();
        let is_lit = |name: &str| {
            let entry = format!("{slot}/{name}.glsl");
            let files = library.files_reached(&[&entry], &variant.slots).unwrap_or_default();
            let reads = |file: &String| library.source(file).is_some_and(names_light);
            slot != "transfer" && files.iter().chain([&entry]).any(reads)
        };
        names.split('+').map(str::trim).map(|name| (name.to_string(), is_lit(name))).collect::<Vec<_>>()
    };
    all.flat_map(of_scene).collect()
}
