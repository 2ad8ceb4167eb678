//! The modules of an effect.

use super::widgets::{Field, Touch, choice, field, named, number};
use super::{Pass, own, prefix};
use crate::scene::{Effect, RayPath};
use crate::shader::Library;
use egui::{Button, ComboBox, RichText, Ui};

/// A slot with one module, and what it is for.
type Slot = (&'static str, &'static str, fn(&mut Effect) -> &mut String);

/// Slots that each object fills for itself.
const OWN: [Slot; 5] = [
    ("classify", "How a sample becomes a color.", |effect| &mut effect.classify),
    ("softness", "How the distance becomes a density.", |effect| &mut effect.softness),
    ("surface", "Color of the hard region.", |effect| &mut effect.surface),
    ("medium", "Color of the soft region.", |effect| &mut effect.medium),
    ("project", "How a point finds the surface under it.", |effect| &mut effect.project),
];
/// Slots of the scene: all objects share what fills them.
const SHARED: [Slot; 9] = [
    ("noise", "Where noise comes from.", |effect| &mut effect.noise),
    ("weights", "Weights of the noise: cubic is of 1989, quintic of 2002.", |effect| &mut effect.weights),
    ("turbulence", "Where turbulence comes from: the turbulence strategy.", |effect| &mut effect.turbulence),
    ("bandlimit", "What becomes of octaves that are finer than a sample.", |effect| &mut effect.bandlimit),
    ("gradient", "The normal that soft matter is lit by.", |effect| &mut effect.gradient),
    ("opacity", "How density becomes opacity.", |effect| &mut effect.opacity),
    ("index", "Where the index of refraction comes from.", |effect| &mut effect.index),
    ("absorption", "What takes light from a ray that bends.", |effect| &mut effect.absorption),
    ("environment", "What a ray that bends meets behind the object.", |effect| &mut effect.environment),
];
/// Modules of `classify` that a scene takes by its integration or its objects, never by name.
const NOT_CHOSEN: [&str; 4] = ["objects", "stack", "surface_segment", "soft_segment"];
/// A stack longer than this is a slip of the hand: every module costs at every sample.
const MAX_STACK: usize = 16;

/// Stacks, then every slot.
pub(super) fn show(ui: &mut Ui, pass: &mut Pass<'_>, part: Option<&str>) {
    let library = pass.model.library();
    let prefix = prefix(part);
    let touch = &mut pass.touch;
    let effect = own(&mut pass.draft, part).effect;
    let doc = "Density modulation functions, applied from top to bottom; a mask says where one acts.";
    stack(ui, touch, &field(format!("{prefix}effect.dmf"), doc), &mut effect.dmf, "dmf", "density modulation", library);
    let doc = "Displacements of the position that is looked up, applied from top to bottom.";
    stack(ui, touch, &field(format!("{prefix}effect.warp"), doc), &mut effect.warp, "warp", "displacement", library);
    ui.separator();
    ui.label(RichText::new("from distance to color").strong());
    for slot in OWN {
        match slot.0 {
            "medium" => media(ui, touch, &prefix, effect, slot.1, library),
            _ => single(ui, touch, &prefix, effect, slot, library),
        }
    }
    let doc = "How fast soft matter becomes opaque, per object unit: c of Perlin and Hoffert 3.1.";
    number(ui, touch, &field(format!("{prefix}effect.opacity_rate"), doc), &mut effect.opacity_rate, 0.1..=1000.0);
    if part.is_some() {
        return;
    }
    ui.separator();
    ui.label(RichText::new("noise, light and rays").strong()).on_hover_text("All objects of the scene share these.");
    for slot in SHARED {
        single(ui, touch, "", effect, slot, library);
    }
    let doc = "Octaves of turbulence; an encoded block holds as many as it has texels for.";
    number(ui, touch, &field("effect.octaves", doc), &mut effect.octaves, 1..=10);
    let rays = [
        (RayPath::Straight, "straight", "Rays are straight lines.".into()),
        (RayPath::Refracted, "refracted", "Rays bend where the index of refraction changes; needs pass march.".into()),
    ];
    choice(ui, touch, &field("effect.ray_path", "The path of a ray through the object."), &mut effect.ray_path, &rays);
}

/// The first line of a module: what it computes.
fn about(library: &Library, slot: &str, name: &str) -> String {
    let text = library.source(&format!("{slot}/{name}.glsl")).unwrap_or_default();
    let line = text.lines().next().unwrap_or_default().trim_start_matches("//").trim();
    if line.is_empty() { format!("{slot}/{name}.glsl") } else { line.into() }
}

/// Every module of a slot with its first line.
fn modules<'a>(library: &'a Library, slot: &str) -> Vec<(String, &'a str, String)> {
    let names = library.modules(slot).into_iter().filter(|name| slot != "classify" || !NOT_CHOSEN.contains(name));
    names.map(|name| (name.to_string(), name, about(library, slot, name))).collect()
}

fn single(ui: &mut Ui, touch: &mut Touch, prefix: &str, effect: &mut Effect, slot: Slot, library: &Library) {
    let (name, doc, module) = slot;
    let mut options = modules(library, name);
    if name == "project" {
        options.insert(
            0,
            ("auto".into(), "auto", "The formula of an object that is one, else its closest points.".into()),
        );
    }
    choice(ui, touch, &field(format!("{prefix}effect.{name}"), doc), module(effect), &options);
}

/// A medium for each layer of the DMFs; where all are the same, that one.
fn media(ui: &mut Ui, touch: &mut Touch, prefix: &str, effect: &mut Effect, doc: &str, library: &Library) {
    let options = modules(library, "medium");
    let mut media: Vec<String> = effect.medium.split('+').map(String::from).collect();
    let layers = library.layers(&effect.dmf).unwrap_or(1).max(1);
    media.resize(layers, media.last().cloned().unwrap_or_default());
    let before = media.clone();
    for (index, medium) in media.iter_mut().enumerate() {
        let name = if index == 0 { String::new() } else { format!(".{}", index + 1) };
        let mut row = field(format!("{prefix}effect.medium{name}"), doc);
        row.text = (index > 0).then_some("");
        choice(ui, touch, &row, medium, &options);
    }
    if media != before {
        *touch = Some(format!("{prefix}effect.medium"));
        effect.medium = if media.iter().all(|medium| *medium == media[0]) { media[0].clone() } else { media.join("+") };
    }
}

/// A stack: each module with its mask, and how to move and remove it; at the end one to add.
fn stack(
    ui: &mut Ui,
    touch: &mut Touch,
    field: &Field<'_>,
    names: &mut Vec<String>,
    slot: &str,
    title: &str,
    library: &Library,
) {
    ui.label(RichText::new(title).strong()).on_hover_text(format!("{}\n{}", field.doc, field.name));
    let options = modules(library, slot);
    let mut masks = vec![(String::new(), "everywhere", "It acts everywhere.".to_string())];
    if slot == "dmf" {
        masks.extend(modules(library, "mask"));
    }
    let before = names.clone();
    let count = names.len();
    let (mut removed, mut swapped) = (None, None);
    for (index, entry) in names.iter_mut().enumerate() {
        let (mut module, mut mask) =
            entry.split_once('@').map_or((entry.clone(), String::new()), |(a, b)| (a.into(), b.into()));
        ui.horizontal(|ui| {
            let at = |what: &str| format!("{}.{index}{what}", field.name);
            pick(ui, &at(""), &mut module, &options, 112.0);
            if slot == "dmf" {
                pick(ui, &at(".mask"), &mut mask, &masks, 92.0);
            }
            let small = |ui: &mut Ui, on: bool, text: &str, what: &str, doc: &str| {
                let response = ui.add_enabled(on, Button::new(text).small()).on_hover_text(doc);
                named(ui, &response, &at(what)).clicked()
            };
            if small(ui, index > 0, "⏶", ".up", "Apply it earlier.") {
                swapped = Some(index - 1);
            }
            if small(ui, index + 1 < count, "⏷", ".down", "Apply it later.") {
                swapped = Some(index);
            }
            if small(ui, true, "✖", ".remove", "Take it out of the stack.") {
                removed = Some(index);
            }
        });
        *entry = if mask.is_empty() { module } else { format!("{module}@{mask}") };
    }
    if let Some(index) = swapped {
        names.swap(index, index + 1);
    }
    if let Some(index) = removed {
        names.remove(index);
    }
    if count < MAX_STACK {
        let mut new = String::new();
        pick(ui, &format!("{}.add", field.name), &mut new, &options, 112.0);
        names.extend(Some(new).filter(|new| !new.is_empty()));
    }
    if *names != before {
        *touch = Some(field.name.clone());
    }
}

/// A list to choose one name from; `+ add` while there is none.
fn pick(ui: &mut Ui, name: &str, value: &mut String, options: &[(String, &str, String)], width: f32) {
    let now = options.iter().find(|option| option.0 == *value).map_or("+ add", |option| option.1);
    let shown = ComboBox::from_id_salt(name).selected_text(now).width(width).height(360.0).show_ui(ui, |ui| {
        for (option, text, doc) in options {
            ui.selectable_value(value, option.clone(), *text).on_hover_text(doc);
        }
    });
    let doc = options.iter().find(|option| option.0 == *value).map_or("Add a module at the end.", |option| &option.2);
    named(ui, &shown.response, name).on_hover_text(doc);
}
