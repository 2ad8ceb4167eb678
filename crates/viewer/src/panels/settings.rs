//! Controls of settings, generated from the schema.

use super::context::Pass;
use super::field_menu;
use super::keyframes;
use super::widgets::{self, Field, choice, color, field, number, numbers, switch, text};
use egui::Ui;
use hypertexture::scene::schema::{self, Kind, SETTINGS, Setting, Unit, float};
use hypertexture::scene::{Color, is_movable};
use hypertexture::shader::Library;
use toml::Value;

/// Change per dragged point, as a fraction of the usual range.
const DRAG: f32 = 1.0 / 400.0;

/// Modules of `classify` that follow from other settings.
const NOT_CHOSEN: [&str; 4] = ["objects", "stack", "surface_segment", "soft_segment"];

/// A setting of 32 numbers, which only programs set.
const SET_BY_PROGRAMS: &str = "camera.matrices";

/// Basic settings.
const BASIC: [&str; 28] = [
    "object.input",
    "object.iso",
    "object.up",
    "material.color",
    "material.specular",
    "material.specular_power",
    "light.position",
    "light.color",
    "light.intensity",
    "light.ambient",
    "light.shadows",
    "image.background",
    "image.size",
    "camera.projection",
    "camera.azimuth",
    "camera.elevation",
    "camera.pan",
    "camera.zoom",
    "camera.field_of_view",
    "camera.time",
    "transform.at",
    "transform.turn",
    "transform.scale",
    "animation.loop",
    "quality.samples",
    "quality.supersampling",
    "transfer.curve",
    "transfer.stops",
];

/// Labels that differ from the name of the field.
const WORDS: [(&str, &str); 8] = [
    ("object.input", "object"),
    ("object.iso", "iso-value"),
    ("camera.clip", "clip plane"),
    ("camera.rotation", "rotation"),
    ("camera.field_of_view", "angle of view"),
    ("light.ambient", "ambient light"),
    ("material.specular_power", "sharpness"),
    ("quality.early_termination", "opacity cut-off"),
];

/// The controls of a table, in the order of the schema; `prefix` is that of an additional object.
pub(super) fn table(ui: &mut Ui, pass: &mut Pass<'_>, prefix: &str, table: &str) {
    let own = SETTINGS.iter().filter(|setting| setting.table() == table);
    own.for_each(|setting| control(ui, pass, prefix, setting, &|_| true));
}

/// The control of one setting.
pub(super) fn show(ui: &mut Ui, pass: &mut Pass<'_>, prefix: &str, name: &str) {
    show_some(ui, pass, prefix, name, &|_| true);
}

/// The control of one setting, limited to the `offered` values.
pub(super) fn show_some(ui: &mut Ui, pass: &mut Pass<'_>, prefix: &str, name: &str, offered: &dyn Fn(u32) -> bool) {
    if let Some(setting) = schema::setting(name) {
        control(ui, pass, prefix, setting, offered);
    }
}

fn control(ui: &mut Ui, pass: &mut Pass<'_>, prefix: &str, setting: &Setting, offered: &dyn Fn(u32) -> bool) {
    if (pass.advanced || BASIC.contains(&setting.name)) && setting.name != SET_BY_PROGRAMS {
        let name = format!("{prefix}{}", setting.name);
        field_menu::of_setting(ui, pass, &name, |ui, pass| {
            pass.dimmed(ui, &name, |ui, pass| {
                if !pass.keys || !is_movable(&name) {
                    return rows(ui, pass, prefix, setting, offered);
                }
                ui.horizontal(|ui| {
                    let value = pass.value(&name);
                    keyframes::diamond(ui, pass, &name, value.as_ref());
                    ui.vertical(|ui| rows(ui, pass, prefix, setting, offered));
                });
            });
        });
    }
}

fn rows(ui: &mut Ui, pass: &mut Pass<'_>, prefix: &str, setting: &Setting, offered: &dyn Fn(u32) -> bool) {
    let name = format!("{prefix}{}", setting.name);
    let word = WORDS.iter().find(|(own, _)| *own == setting.name).map(|(_, word)| *word);
    let mut value = pass.value(&name);
    if let (Some(on), false) = (setting.optional, matches!(setting.kind, Kind::Text)) {
        let of = format!("{prefix}{}.has_{}", setting.table(), setting.field());
        let text = word.map_or_else(|| setting.field().replace('_', " "), String::from);
        let row = Field { text: Some(&text), ..field(of, setting.doc) };
        let (had, mut has, mut touch) = (value.is_some(), value.is_some(), None);
        switch(ui, &mut touch, &row, &mut has);
        if has != had {
            pass.set(&name, if has { on } else { "" });
            value = has.then(|| hypertexture::scene::parse_value(on));
        }
    }
    let text = format!("{} (objects)", setting.name);
    let text = match setting.optional {
        Some(_) if !matches!(setting.kind, Kind::Text) => Some(""), // the switch above has the name
        _ => word.or(setting.table().is_empty().then_some(&text)),
    };
    let unit = setting.unit.map_or("", Unit::symbol);
    let row = Field { text, unit, ..field(name.clone(), setting.doc) };
    if let Some(text) = changed(ui, pass, setting, &row, value, offered) {
        pass.set(&name, &text);
    }
}

/// Shows the control; returns a new value in the syntax of scene files.
fn changed(
    ui: &mut Ui,
    pass: &Pass<'_>,
    setting: &Setting,
    row: &Field<'_>,
    value: Option<Value>,
    offered: &dyn Fn(u32) -> bool,
) -> Option<String> {
    let mut touch = None;
    let shown = match (setting.kind, value) {
        (Kind::Text, value) => {
            let mut now = value.as_ref().and_then(Value::as_str).unwrap_or_default().to_string();
            text(ui, &mut touch, row, &mut now);
            if now.trim().is_empty() { String::new() } else { Value::from(now).to_string() }
        }
        (_, None) => return None,
        (Kind::Number(range) | Kind::Whole(range), Some(value)) => {
            let mut now = float(&value)?;
            let [low, high] = range.usual;
            match setting.kind {
                Kind::Whole(_) => {
                    let mut whole = now as u32;
                    number(ui, &mut touch, row, &mut whole, low as u32..=high as u32);
                    whole.to_string()
                }
                _ => {
                    if range.is_all() {
                        widgets::unbounded(ui, &mut touch, row, &mut now);
                    } else {
                        number(ui, &mut touch, row, &mut now, low..=high);
                    }
                    now.to_string()
                }
            }
        }
        (Kind::Numbers(_, range) | Kind::Wholes(_, range), Some(value)) => {
            let mut now: Vec<f32> = value.as_array()?.iter().filter_map(float).collect();
            let speed = f64::from(DRAG * (range.usual[1] - range.usual[0]));
            numbers(ui, &mut touch, row, &mut now, speed);
            format!("[{}]", now.iter().map(f32::to_string).collect::<Vec<_>>().join(", "))
        }
        (Kind::OneOf(all), Some(value)) => {
            let mut now = float(&value)? as u32;
            let names: Vec<_> = all.iter().map(|number| (*number, number.to_string())).collect();
            let options = names.iter().filter(|(number, _)| offered(*number));
            let options: Vec<_> = options.map(|(number, name)| (*number, name.as_str(), setting.doc.into())).collect();
            choice(ui, &mut touch, row, &mut now, &options);
            now.to_string()
        }
        (Kind::Switch, Some(value)) => {
            let mut now = value.as_bool()?;
            switch(ui, &mut touch, row, &mut now);
            now.to_string()
        }
        (Kind::Choice(choices), Some(value)) => {
            let mut now = value.as_str()?.to_string();
            let options: Vec<_> =
                choices.iter().map(|(name, doc)| (name.to_string(), *name, doc.to_string())).collect();
            choice(ui, &mut touch, row, &mut now, &options);
            now
        }
        (Kind::Color, Some(value)) => {
            let mut now = Color::try_from(value.as_str()?.to_string()).ok()?;
            color(ui, &mut touch, row, &mut now);
            String::from(now)
        }
        (Kind::Module(_), Some(value)) => {
            let mut now = value.as_str()?.to_string();
            let mut options = modules(pass.model.library(), setting.field());
            if setting.field() == "project" {
                let doc = "The formula of an analytic object, else its closest points.";
                options.insert(0, ("auto".into(), "auto", doc.into()));
            }
            choice(ui, &mut touch, row, &mut now, &options);
            now
        }
        (Kind::Stack | Kind::Stops, Some(_)) => return None, // they have editors of their own
    };
    touch.map(|_| shown)
}

/// Description of a module: its first line.
fn about(library: &Library, slot: &str, name: &str) -> String {
    let text = library.source(&format!("{slot}/{name}.glsl")).unwrap_or_default();
    let line = text.lines().next().unwrap_or_default().trim_start_matches("//").trim();
    if line.is_empty() { format!("{slot}/{name}.glsl") } else { line.into() }
}

/// The modules of a slot with their descriptions.
pub(super) fn modules<'a>(library: &'a Library, slot: &str) -> Vec<(String, &'a str, String)> {
    let names = library.modules(slot).into_iter().filter(|name| slot != "classify" || !NOT_CHOSEN.contains(name));
    names.map(|name| (name.to_string(), name, about(library, slot, name))).collect()
}
