//! The modules of an effect.

use super::context::{Pass, object_fields, prefix};
use super::field_menu;
use super::settings::{self, modules};
use super::widgets::{Field, Touch, choice, field, is_narrow, named};
use egui::{Button, ComboBox, RichText, Ui};
use hypertexture::scene::schema::{self, Filled, Kind, SETTINGS, Setting};
use hypertexture::shader::Library;

/// Limit for a stack: every module costs time at every sample.
const MAX_STACK: usize = 16;

/// The stacks, then the other slots.
pub(super) fn show(ui: &mut Ui, pass: &mut Pass<'_>, part: Option<&str>) {
    let (library, prefix) = (pass.model.library(), prefix(part));
    for (slot, title) in [("dmf", "density modulation"), ("warp", "displacement")] {
        let name = format!("{prefix}effect.{slot}");
        let doc = schema::setting(&name).map_or("", |setting| setting.doc);
        field_menu::of_setting(ui, pass, &name, |ui, pass| {
            let effect = object_fields(&mut pass.draft, part).effect;
            let names = if slot == "dmf" { &mut effect.dmf } else { &mut effect.warp };
            stack(ui, &mut pass.touch, &field(&name, doc), names, slot, title, library);
        });
    }
    let (shared, own): (Vec<&Setting>, Vec<&Setting>) = SETTINGS
        .iter()
        .filter(|setting| setting.table() == "effect")
        .partition(|setting| setting.field() != "opacity_rate" && !is_own(setting.kind));
    ui.separator();
    ui.label(RichText::new("from distance to color").strong());
    for setting in own {
        match setting.name {
            "effect.medium" => {
                let name = format!("{prefix}effect.medium");
                field_menu::of_setting(ui, pass, &name, |ui, pass| {
                    pass.dimmed(ui, &name, |ui, pass| media(ui, pass, part, setting.doc));
                });
            }
            name => settings::show(ui, pass, &prefix, name),
        }
    }
    if part.is_none() {
        ui.separator();
        let title = RichText::new("noise, light and rays").strong();
        ui.label(title).on_hover_text("Shared by all objects of the scene.");
        shared.iter().for_each(|setting| settings::show(ui, pass, "", setting.name));
    }
}

/// Whether each object has its own value.
fn is_own(kind: Kind) -> bool {
    matches!(kind, Kind::Module(Filled::ByObject) | Kind::Stack)
}

/// A medium for each layer of the DMFs; a single name if all are equal.
fn media(ui: &mut Ui, pass: &mut Pass<'_>, part: Option<&str>, doc: &str) {
    let (library, prefix, touch) = (pass.model.library(), prefix(part), &mut pass.touch);
    let effect = object_fields(&mut pass.draft, part).effect;
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

/// A stack: its modules with masks and buttons, and a list to add one.
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
    let mut masks = vec![(String::new(), "everywhere", "Acts everywhere.".to_string())];
    if slot == "dmf" {
        masks.extend(modules(library, "mask"));
    }
    let before = names.clone();
    let count = names.len();
    let (mut removed, mut swapped) = (None, None);
    for (index, entry) in names.iter_mut().enumerate() {
        let (mut module, mut mask) =
            entry.split_once('@').map_or((entry.clone(), String::new()), |(a, b)| (a.into(), b.into()));
        ui.horizontal_wrapped(|ui| {
            let at = |what: &str| format!("{}.{index}{what}", field.name);
            let is_narrow = is_narrow(ui);
            pick(ui, &at(""), &mut module, &options, 112.0);
            if is_narrow {
                ui.end_row();
            }
            if slot == "dmf" {
                pick(ui, &at(".mask"), &mut mask, &masks, if is_narrow { 64.0 } else { 92.0 });
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
            if small(ui, true, "✖", ".remove", "Remove it from the stack.") {
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

/// A list of names; `+ add` if none is chosen.
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
