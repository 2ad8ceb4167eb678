//! The objects of a scene.

use super::context::{Act, Pass, prefix};
use super::field_menu;
use super::settings;
use super::widgets::{self, Field, button, choice, field};
use egui::{Button, RichText, Sense, Ui, Vec2, vec2};
use hypertexture::scene::schema::SETTINGS;
use hypertexture::shader::slots::MAIN;
use hypertexture::shape::BUILT_IN;
use std::collections::BTreeSet;

/// Size of eye and lock, points.
const ICON: Vec2 = vec2(18.0, 18.0);

/// The list of objects, each with an eye, a lock and its name, and the formula that combines them.
pub(super) fn list(ui: &mut Ui, pass: &mut Pass<'_>, selected: &mut Option<String>, locked: &mut BTreeSet<String>) {
    let names = [None].into_iter().chain(pass.model.scene().parts.keys().cloned().map(Some));
    for name in names {
        ui.horizontal(|ui| {
            eye(ui, pass, name.as_deref());
            let shown = name.as_deref().unwrap_or(MAIN);
            lock(ui, shown, locked);
            let part = name.as_ref().and_then(|name| pass.model.scene().parts.get(name));
            let is_hidden = part.is_some_and(|part| part.hidden);
            let text = if is_hidden { RichText::new(shown).weak() } else { RichText::new(shown) };
            let response = ui.selectable_label(*selected == name, text);
            if widgets::named(ui, &response, &format!("object {shown}")).clicked() {
                selected.clone_from(&name);
            }
        });
    }
    ui.horizontal_wrapped(|ui| {
        if button(ui, "+", "add object", "Add an object with an effect of its own.").clicked() {
            pass.acts.push(Act::AddPart);
        }
        if let Some(name) = &selected
            && button(ui, "remove", "remove object", "Remove the selected object.").clicked()
        {
            pass.acts.push(Act::RemovePart(name.clone()));
        }
    });
    if pass.model.scene().parts.is_empty() {
        return;
    }
    settings::show(ui, pass, "", "combine");
    settings::show(ui, pass, "", "boolean");
    if let Some(name) = selected {
        let mut to = name.clone();
        let row = Field { text: Some("name"), ..field(format!("name of {name}"), "Lower-case letters and digits.") };
        widgets::text(ui, &mut None, &row, &mut to);
        if to != *name {
            pass.acts.push(Act::RenamePart { from: name.clone(), to });
        }
        ui.strong("Transform");
        settings::table(ui, pass, &prefix(Some(name)), "transform");
    }
}

/// The switch that hides an additional object; the main one cannot be hidden.
fn eye(ui: &mut Ui, pass: &mut Pass<'_>, part: Option<&str>) {
    let Some(part) = part else {
        return drop(ui.allocate_exact_size(ICON, Sense::hover()));
    };
    let field = format!("parts.{part}.hidden");
    field_menu::of_setting(ui, pass, &field, |ui, pass| {
        let is_hidden = pass.model.scene().parts.get(part).is_some_and(|part| part.hidden);
        let doc = "Hide the object, or show it. A hidden object costs no time.";
        if icon(ui, "\u{1f441}", is_hidden, &field, doc) {
            pass.set(&field, if is_hidden { "" } else { "true" });
        }
    });
}

/// The switch that locks an object.
fn lock(ui: &mut Ui, name: &str, locked: &mut BTreeSet<String>) {
    let is_locked = locked.contains(name);
    let text = if is_locked { "\u{1f512}" } else { "\u{1f513}" };
    let doc = "Lock the object: a click in the picture does not select it, and drags do not place it.";
    if icon(ui, text, !is_locked, &format!("lock {name}"), doc) && !locked.remove(name) {
        locked.insert(name.into());
    }
}

/// A switch without a frame; whether it was pressed.
fn icon(ui: &mut Ui, text: &str, is_weak: bool, name: &str, doc: &str) -> bool {
    let color = if is_weak { ui.visuals().weak_text_color().gamma_multiply(0.5) } else { ui.visuals().text_color() };
    let response = ui.add(Button::new(RichText::new(text).color(color)).frame(false).min_size(ICON));
    widgets::named(ui, &response, name).on_hover_text(doc).clicked()
}

/// Input and soft region of one object. Only the main object has a stretch.
pub(super) fn show(ui: &mut Ui, pass: &mut Pass<'_>, part: Option<&str>) {
    built_in(ui, pass, part);
    let own = SETTINGS.iter().filter(|setting| setting.table() == "object");
    for setting in own.filter(|setting| part.is_none() || setting.name != "object.stretch") {
        settings::show(ui, pass, &prefix(part), setting.name);
    }
}

/// The list of built-in objects.
fn built_in(ui: &mut Ui, pass: &mut Pass<'_>, part: Option<&str>) {
    let object = part.and_then(|part| pass.draft.parts.get(part)).map_or(&pass.draft.object, |part| &part.object);
    let name = format!("{}object.input", prefix(part));
    let row = Field { text: Some("built-in"), ..field(format!("{name}.list"), "Built-in objects.") };
    let mut options: Vec<_> = BUILT_IN.iter().map(|name| (name.to_string(), *name, String::new())).collect();
    let mut now = object.input.clone();
    if !BUILT_IN.contains(&now.as_str()) {
        options.insert(0, (now.clone(), "of a file", now.clone()));
    }
    let mut touch = None;
    choice(ui, &mut touch, &row, &mut now, &options);
    if touch.is_some() {
        match part {
            // Also realigns the inputs that are aligned with the main object.
            None => pass.draft.replace_object(&now),
            Some(part) => drop(pass.draft.parts.get_mut(part).map(|part| part.object.input.clone_from(&now))),
        }
        pass.touch = Some(name);
    }
}
