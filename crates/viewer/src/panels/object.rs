//! The objects of a scene.

use super::context::{Pass, prefix};
use super::field_menu;
use super::settings;
use super::widgets::{self, Field, button, choice, field};
use crate::document::Selection;
use crate::input::Command;
use egui::{Button, RichText, Sense, Ui, Vec2, vec2};
use hypertexture::scene::Scene;
use hypertexture::scene::schema::SETTINGS;
use hypertexture::shader::Formula;
use hypertexture::shader::slots::MAIN;
use hypertexture::shape::BUILT_IN;
use std::collections::BTreeSet;

/// Size of eye and lock, points.
const ICON: Vec2 = vec2(18.0, 18.0);

/// An object that is dragged in the list.
struct Dragged(String);

/// The list of objects in the order in which they are combined, each with an eye, a lock and its name, and the formula.
pub(super) fn list(ui: &mut Ui, pass: &mut Pass<'_>, selection: &mut Selection) {
    let Selection { part: selected, locked } = selection;
    let model = pass.model;
    let order: Vec<String> = match chain(model.scene()) {
        Some(chain) => chain.into_iter().map(|(_, name)| name).collect(),
        None => model.scene().parts.keys().cloned().collect(),
    };
    ui.horizontal(|ui| {
        eye(ui, pass, None);
        lock(ui, MAIN, locked);
        label(ui, pass, None, 0, selected);
    });
    for (place, name) in order.iter().map(String::as_str).enumerate() {
        ui.horizontal(|ui| {
            eye(ui, pass, Some(name));
            lock(ui, name, locked);
            field_menu::with_items(
                ui,
                pass,
                &format!("object {name}"),
                |ui, pass| label(ui, pass, Some(name), place, selected),
                |ui, pass, menu| {
                    let doc = "Combine it before the object above it.";
                    if menu.item(ui, place > 0, "Earlier", "earlier", doc) {
                        move_to(pass, name, place - 1);
                    }
                    let doc = "Combine it after the object below it.";
                    if menu.item(ui, place + 1 < order.len(), "Later", "later", doc) {
                        move_to(pass, name, place + 1);
                    }
                },
            );
        });
    }
    ui.horizontal_wrapped(|ui| {
        if button(ui, "+ add", "add object", "Add an object with an effect of its own.").clicked() {
            pass.commands.push(Command::AddPart);
        }
        if button(ui, "duplicate", "duplicate object", "Copy the selected object (Shift+D).").clicked() {
            pass.commands.push(Command::Duplicate);
        }
        ui.add_space(24.0);
        if let Some(name) = &selected
            && button(ui, "remove", "remove object", "Remove the selected object (Delete).").clicked()
        {
            pass.commands.push(Command::RemovePart(name.clone()));
        }
    });
    if pass.model.scene().parts.is_empty() {
        return;
    }
    if let Some(name) = selected {
        operation(ui, pass, name);
    }
    settings::show(ui, pass, "", "combine");
    settings::show(ui, pass, "", "boolean");
    if let Some(name) = selected {
        let mut to = name.clone();
        let row = Field { text: Some("name"), ..field(format!("name of {name}"), "Lower-case letters and digits.") };
        widgets::text(ui, &mut None, &row, &mut to);
        if to != *name {
            pass.commands.push(Command::RenamePart { from: name.clone(), to });
        }
        ui.strong("Transform");
        settings::table(ui, pass, &prefix(Some(name)), "transform");
    }
}

/// The name of an object: a click selects it, and a drag takes it to the place of another one.
fn label(ui: &mut Ui, pass: &mut Pass<'_>, name: Option<&str>, place: usize, selected: &mut Option<String>) {
    let shown = name.unwrap_or(MAIN);
    let is_hidden = name.and_then(|name| pass.model.scene().parts.get(name)).is_some_and(|part| part.hidden);
    let text = if is_hidden { RichText::new(shown).weak() } else { RichText::new(shown) };
    // The main object is the first one of every chain.
    let sense = if name.is_some() { Sense::click_and_drag() } else { Sense::click() };
    let response = ui.add(Button::selectable(selected.as_deref() == name, text).sense(sense));
    let response = widgets::named(ui, &response, &format!("object {shown}"));
    if response.clicked() {
        *selected = name.map(String::from);
    }
    if let Some(name) = name {
        response.dnd_set_drag_payload(Dragged(name.into()));
        response.clone().on_hover_text("A drag, or its menu, changes the order in which objects are combined.");
    }
    if let Some(dragged) = response.dnd_release_payload::<Dragged>() {
        move_to(pass, &dragged.0, place);
    } else if response.dnd_hover_payload::<Dragged>().is_some() {
        response.highlight();
    }
}

/// Takes an object to a place in the order of the formula, with its operation.
fn move_to(pass: &mut Pass<'_>, name: &str, place: usize) {
    let model = pass.model;
    let Some(mut chain) = chain(model.scene()) else {
        pass.refused = Some(format!("{name}: {OWN_FORMULA}"));
        return;
    };
    if let Some(from) = chain.iter().position(|(_, own)| own == name).filter(|from| *from != place) {
        let own = chain.remove(from);
        chain.insert(place.min(chain.len()), own);
        pass.draft.combine = formula(&chain, model.scene());
        pass.touch = Some("combine".into());
    }
}

/// Why a formula has neither buttons nor an order.
const OWN_FORMULA: &str = "the objects are combined by a formula of their own: combine, in Advanced";

/// Operations that combine an object with those before it: sign, name and description.
const OPERATIONS: [(char, &str, &str); 3] = [
    ('|', "union", "The object is added to those before it."),
    ('-', "cut", "The object is cut out of those before it."),
    ('&', "intersect", "Only what the object and those before it share is left."),
];

/// Buttons for the operation of an object.
fn operation(ui: &mut Ui, pass: &mut Pass<'_>, name: &str) {
    let scene = pass.model.scene();
    let Some(chain) = chain(scene) else {
        return drop(ui.weak(OWN_FORMULA));
    };
    let now = chain.iter().find(|(_, own)| own == name).map(|(sign, _)| *sign);
    let row = Field {
        text: Some("operation"),
        ..field("combine.operation", "The way an object is combined with the others.")
    };
    let mut wanted = None;
    widgets::line(ui, &row, |ui| {
        for (sign, text, doc) in OPERATIONS {
            let response = ui.selectable_label(now == Some(sign), text).on_hover_text(doc);
            if widgets::named(ui, &response, &format!("combine.{text}")).clicked() {
                wanted = Some(sign);
            }
        }
    });
    if let Some(sign) = wanted.filter(|sign| now != Some(*sign)) {
        let mut chain = chain;
        match chain.iter_mut().find(|(_, own)| own == name) {
            Some(own) => own.0 = sign,
            None => chain.push((sign, name.into())),
        }
        pass.draft.combine = formula(&chain, scene);
        pass.touch = Some("combine".into());
    }
}

/// The formula of a scene as operations one after another, from the main object on; `None` for any other formula.
fn chain(scene: &Scene) -> Option<Vec<(char, String)>> {
    let union = || scene.parts.keys().map(|name| ('|', name.clone())).collect();
    let Some(text) = scene.combine.as_deref() else { return Some(union()) };
    let plain: String = text.chars().filter(|c| !c.is_whitespace() && !"()".contains(*c)).collect();
    let rest = plain.strip_prefix(MAIN)?;
    let is_sign = |c: char| OPERATIONS.iter().any(|(sign, ..)| *sign == c);
    let mut chain: Vec<(char, String)> = Vec::new();
    for c in rest.chars() {
        match chain.last_mut() {
            _ if is_sign(c) => chain.push((c, String::new())),
            Some((_, name)) => name.push(c),
            None => return None,
        }
    }
    let is_known = chain.iter().all(|(_, name)| scene.parts.contains_key(name));
    // Parentheses may mean another order.
    let same = Formula::parse(text).ok()? == Formula::parse(&written(&chain)).ok()?;
    (is_known && same).then_some(chain)
}

/// The formula of a chain; `None` for the union of all objects by their names, which a scene has without one.
fn formula(chain: &[(char, String)], scene: &Scene) -> Option<String> {
    let is_union = chain.iter().all(|(sign, _)| *sign == '|');
    let is_plain = is_union && chain.iter().map(|(_, name)| name).eq(scene.parts.keys());
    (!is_plain).then(|| written(chain))
}

/// The text of a chain.
fn written(chain: &[(char, String)]) -> String {
    chain.iter().fold(MAIN.to_string(), |before, (sign, name)| {
        let before = if before.contains(' ') { format!("({before})") } else { before };
        format!("{before} {sign} {name}")
    })
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_chain_of_operations_is_that_of_its_formula() {
        let mut scene = Scene::default();
        for name in ["a", "b"] {
            scene.parts.insert(name.into(), Default::default());
        }
        let pairs = |text: Option<&str>, scene: &mut Scene| {
            scene.combine = text.map(String::from);
            chain(scene).map(|all| all.iter().map(|(sign, name)| format!("{sign}{name}")).collect::<Vec<_>>())
        };
        assert_eq!(pairs(None, &mut scene).unwrap(), ["|a", "|b"]);
        assert_eq!(pairs(Some("(main - a) | b"), &mut scene).unwrap(), ["-a", "|b"]);
        assert_eq!(pairs(Some("(main|b)&a"), &mut scene).unwrap(), ["|b", "&a"]);
        assert_eq!(pairs(Some("main - b"), &mut scene).unwrap(), ["-b"]);
        for other in ["a - main", "main - (a | b)", "main - c", "!main | a", "main & a | main & b"] {
            assert_eq!(pairs(Some(other), &mut scene), None, "{other}");
        }
        assert_eq!(written(&[('-', "a".into()), ('|', "b".into())]), "(main - a) | b");
    }
}
