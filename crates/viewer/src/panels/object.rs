//! The objects of a scene.

use super::context::{Act, Pass, prefix};
use super::settings;
use super::widgets::{self, Field, button, choice, field};
use egui::Ui;
use hypertexture::scene::schema::SETTINGS;
use hypertexture::shape::BUILT_IN;

/// The list of objects, and the formula that combines them.
pub(super) fn list(ui: &mut Ui, pass: &mut Pass<'_>, selected: &mut Option<String>) {
    ui.horizontal_wrapped(|ui| {
        let names = [None].into_iter().chain(pass.model.scene().parts.keys().cloned().map(Some));
        for name in names {
            let shown = name.as_deref().unwrap_or("main");
            let response = ui.selectable_label(*selected == name, shown);
            if widgets::named(ui, &response, &format!("object {shown}")).clicked() {
                selected.clone_from(&name);
            }
        }
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
        ui.strong("Transform");
        settings::table(ui, pass, &prefix(Some(name)), "transform");
    }
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
