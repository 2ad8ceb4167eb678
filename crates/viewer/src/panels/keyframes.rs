//! Keyframes: diamonds beside controls, and the tracks below the timeline.

use super::axis::{Axis, LEFT};
use super::context::Pass;
use super::widgets::{self, brief, button, named, short};
use crate::document::model::Model;
use crate::input::Command;
use crate::input::keys;
use crate::playback::Playback;
use egui::{
    Button, Color32, Key as KeyName, Pos2, Rect, Response, ScrollArea, Sense, Shape, Stroke, Ui, WidgetInfo,
    WidgetType, vec2,
};
use hypertexture::scene::{Ease, Key, Scene, Track, is_movable};
use toml::Value;

/// Height of a track, and width of its buttons, points.
const HEIGHT: f32 = 18.0;
const BUTTON: f32 = 22.0;
/// Half the size of a keyframe, points.
const HALF: f32 = 5.0;
/// Color of keyframes.
const KEY: Color32 = Color32::from_rgb(232, 163, 61);
/// Smallest distance of neighbors, seconds.
const APART: f64 = 1e-3;

/// State of the tracks.
#[derive(Default)]
pub(super) struct Keyframes {
    /// Whether tracks and diamonds are shown.
    pub(super) shown: bool,
    /// Track and number of the selected keyframe.
    selected: Option<(String, usize)>,
    copied: Option<Key>,
    /// Length of the loop in the last pass.
    period: Option<f64>,
}

/// A row of the tracks: the name of its field.
#[derive(Clone, Copy)]
struct Row<'a> {
    name: &'a str,
    model: &'a Model,
    axis: &'a Axis,
}

/// A change of a track.
enum Change {
    Move(usize, f64),
    Ease(usize, Ease),
    Remove(usize),
    Paste,
    Express,
    Write(String),
    Drop,
}

/// A button that sets or removes the keyframe of a field at the present time. `value` is that of the field.
pub(super) fn diamond(ui: &mut Ui, pass: &mut Pass<'_>, name: &str, value: Option<&Value>) {
    let Some(value) = value.filter(|_| pass.keys && is_movable(name)) else { return };
    let (ease, doc) = match (pass.model.key(name), pass.model.scene().animation.tracks.get(name)) {
        (Some(key), _) => (Some(key.ease), "Remove the keyframe at this time."),
        (_, Some(Track::Expressions(_))) => (None, "Replace the expression by a keyframe."),
        (_, Some(_)) => (None, "Set a keyframe at this time; another value does so too."),
        (_, None) => (None, "Set a keyframe at this time."),
    };
    let (place, response) = ui.allocate_exact_size(vec2(2.5 * HALF, HEIGHT), Sense::click());
    let has_track = pass.model.scene().animation.tracks.contains_key(name);
    let color = if has_track || response.hovered() { KEY } else { ui.visuals().weak_text_color() };
    if let Some(ease) = ease {
        paint(ui, place.center(), ease, color);
    } else {
        ui.painter().add(Shape::closed_line(rhombus(place.center()), Stroke::new(1.0, color)));
    }
    response.widget_info(|| WidgetInfo::labeled(WidgetType::Button, true, name));
    if named(ui, &response, &format!("{name}.keyframe")).on_hover_text(doc).clicked() {
        toggle(pass, name, value);
    }
}

/// Sets the keyframe of a field at the present time, or removes it.
pub(super) fn toggle(pass: &mut Pass<'_>, name: &str, value: &Value) {
    let model = pass.model;
    match model.key(name).map(|key| key.time) {
        Some(time) => pass.draft.animation.remove_key(name, time),
        None => model.set_key(&mut pass.draft, name, value),
    }
    pass.touch = Some(format!("keyframe of {name}"));
}

impl Keyframes {
    /// Removes the selected keyframe; returns whether there was one.
    pub(super) fn remove_selected(&mut self, model: &mut Model) -> bool {
        let Some((name, number)) = self.selected.take().filter(|_| self.shown) else { return false };
        let is_there = match model.scene().animation.tracks.get(&name) {
            Some(Track::Keys(keys)) => number < keys.len(),
            _ => false,
        };
        is_there && model.edit(&format!("track {name}"), |scene| apply(scene, &name, Change::Remove(number), None))
    }

    /// The switch of the tracks; a new loop becomes the range of the timeline, from its start on.
    pub(super) fn switch(&mut self, ui: &mut Ui, model: &Model, playback: &mut Playback) {
        let response = ui.toggle_value(&mut self.shown, "keys");
        named(ui, &response, "timeline keyframes").on_hover_text("Show keyframes: a diamond beside each control.");
        let period = model.scene().animation.period;
        if let (true, Some(period)) = (self.period != period, period) {
            let from = playback.range[0];
            (playback.range, playback.repeats) = ([from, from + period], true);
        }
        self.period = period;
    }

    /// The tracks.
    pub(super) fn show(&mut self, ui: &mut Ui, model: &mut Model, axis: &Axis, commands: &mut Vec<Command>) {
        if !self.shown {
            return;
        }
        let tracks = model.scene().animation.tracks.clone();
        if tracks.is_empty() {
            ui.weak("No keyframes: click the diamond beside a control.");
        }
        let mut change = None;
        // The height is that of the panel: a new track moves no control.
        ScrollArea::vertical().id_salt("tracks").auto_shrink([false, false]).show(ui, |ui| {
            for (name, track) in &tracks {
                let row = Row { name, model, axis };
                let made = ui.horizontal(|ui| self.track(ui, &row, track, commands)).inner;
                change = change.take().or(made.map(|change| (name.clone(), change)));
            }
        });
        // Also while a control has the focus, which then has the keys.
        if ui.input(|input| input.key_pressed(KeyName::Delete)) && !keys::writes(ui.ctx()) {
            self.remove_selected(model);
        }
        if let Some((name, change)) = change {
            let copied = self.copied.clone();
            model.edit(&format!("track {name}"), |scene| apply(scene, &name, change, copied));
        }
    }

    /// One track: its name, then its keyframes or its expression.
    fn track(&mut self, ui: &mut Ui, row: &Row<'_>, track: &Track, commands: &mut Vec<Command>) -> Option<Change> {
        let (name, mut change) = (row.name, None);
        let buttons = 2.0 * (BUTTON + ui.spacing().item_spacing.x);
        let names = LEFT - buttons - ui.spacing().item_spacing.x;
        ui.allocate_ui(vec2(names, HEIGHT), |ui| {
            ui.set_min_width(names);
            ui.set_max_width(names);
            let words = name.strip_prefix("parameters.").unwrap_or(name).replace(['.', '_'], " ");
            ui.add(egui::Label::new(words).truncate()).on_hover_text(name);
        });
        ui.spacing_mut().interact_size.x = BUTTON;
        if button(ui, "\u{2716}", &format!("{name}.drop"), "Remove the motion; the present value stays.").clicked() {
            change = Some(Change::Drop);
        }
        match track {
            Track::Expressions(texts) => {
                let (name, before) = (format!("{name}.expression"), texts.join("; "));
                let text = widgets::field_of_text(ui, &name, &before, ui.available_width().max(60.0));
                text.filter(|text| *text != before).map(Change::Write).or(change)
            }
            Track::Keys(list) => {
                if button(ui, "\u{192}", &format!("{name}.express"), "Use an expression in time instead.").clicked() {
                    change = Some(Change::Express);
                }
                self.keys(ui, row, list, commands).or(change)
            }
        }
    }

    fn keys(&mut self, ui: &mut Ui, row: &Row<'_>, list: &[Key], commands: &mut Vec<Command>) -> Option<Change> {
        let Row { name, model, axis } = *row;
        let mut change = None;
        let (room, _) = ui.allocate_exact_size(vec2(ui.available_width().max(60.0), HEIGHT), Sense::hover());
        let lane = Rect::from_x_y_ranges(axis.span(HALF), room.y_range());
        let response = ui.interact(lane, ui.id().with((name, "lane")), Sense::click());
        let x = |time: f64| axis.x(time);
        let color = ui.visuals().weak_text_color();
        ui.painter().hline(lane.x_range(), lane.center().y, Stroke::new(1.0, color));
        ui.painter().vline(x(model.time()), lane.y_range(), Stroke::new(1.0, ui.visuals().selection.stroke.color));
        named(ui, &response, &format!("{name} track"));
        response.context_menu(|ui| {
            let paste = ui.add_enabled(self.copied.is_some(), Button::new("paste at this time"));
            if named(ui, &paste, "keyframe paste").clicked() {
                change = Some(Change::Paste);
                ui.close();
            }
        });
        for (number, key) in list.iter().enumerate() {
            let center = Pos2::new(x(key.time), lane.center().y);
            let id = ui.id().with((name, number));
            let place = Rect::from_center_size(center, vec2(2.5 * HALF, HEIGHT));
            let response = ui.interact(place, id, Sense::click_and_drag());
            let own = (name.to_string(), number);
            let is_selected = self.selected.as_ref() == Some(&own);
            let is_bright = is_selected || response.hovered();
            paint(ui, center, key.ease, if is_bright { ui.visuals().strong_text_color() } else { KEY });
            named(ui, &response, &format!("{name} key {}", number + 1)).on_hover_text(format!(
                "{} at {} s, {}; drag it to another frame, with Alt to any time",
                brief(&key.value),
                short(key.time),
                key.ease.name()
            ));
            if response.clicked() || response.drag_started() {
                self.selected = Some(own);
            }
            if response.clicked() {
                commands.push(Command::Time(key.time));
            }
            if let Some(at) = response.interact_pointer_pos().filter(|_| response.dragged()) {
                // Frames; with Alt, any time.
                let (time, is_free) = (axis.time(at.x), ui.input(|input| input.modifiers.alt));
                change =
                    Some(Change::Move(number, if is_free { (1e3 * time).round() / 1e3 } else { axis.snapped(time) }));
            }
            change = self.menu(&response, number, key).or(change);
        }
        change
    }

    /// The menu of a keyframe.
    fn menu(&mut self, response: &Response, number: usize, key: &Key) -> Option<Change> {
        let mut change = None;
        response.context_menu(|ui| {
            for (name, ease, doc) in [
                ("linear", Ease::Linear, "Go evenly to the next keyframe."),
                ("smooth", Ease::Smooth, "Go to the next keyframe without a jump of the speed."),
                ("hold", Ease::Hold, "Stay until the next keyframe."),
            ] {
                let choice = ui.selectable_label(key.ease == ease, name).on_hover_text(doc);
                if named(ui, &choice, &format!("keyframe {name}")).clicked() {
                    change = Some(Change::Ease(number, ease));
                    ui.close();
                }
            }
            if button(ui, "copy", "keyframe copy", "Copy value and way.").clicked() {
                self.copied = Some(key.clone());
                ui.close();
            }
            if button(ui, "delete", "keyframe delete", "Delete it (Delete).").clicked() {
                change = Some(Change::Remove(number));
                ui.close();
            }
        });
        change
    }
}

/// Paints a keyframe: a diamond, a disk if the way from it is smooth, a square if it holds.
fn paint(ui: &Ui, center: Pos2, ease: Ease, fill: Color32) {
    ui.painter().add(match ease {
        Ease::Linear => Shape::convex_polygon(rhombus(center), fill, Stroke::NONE),
        Ease::Smooth => Shape::circle_filled(center, 0.9 * HALF, fill),
        Ease::Hold => Shape::rect_filled(Rect::from_center_size(center, vec2(1.6, 1.6) * HALF), 0.0, fill),
    });
}

fn rhombus(center: Pos2) -> Vec<Pos2> {
    [(0.0, -1.0), (1.0, 0.0), (0.0, 1.0), (-1.0, 0.0)].map(|(x, y)| center + HALF * vec2(x, y)).into()
}

fn apply(scene: &mut Scene, name: &str, change: Change, copied: Option<Key>) {
    let time = scene.animation.wrapped(scene.camera.time);
    let period = scene.animation.period;
    let value = scene.value_named(name);
    let Some(track) = scene.animation.tracks.get_mut(name) else { return };
    match (change, &mut *track) {
        (Change::Move(number, wanted), Track::Keys(keys)) => {
            let before = number.checked_sub(1).map(|before| keys[before].time + APART);
            let after = keys.get(number + 1).map(|after| after.time - APART);
            let low = before.or(period.map(|_| 0.0)).unwrap_or(f64::MIN);
            let high = after.or(period).unwrap_or(f64::MAX);
            keys[number].time = wanted.clamp(low, high.max(low));
        }
        (Change::Ease(number, ease), Track::Keys(keys)) => keys[number].ease = ease,
        (Change::Remove(number), Track::Keys(keys)) if number < keys.len() => {
            let time = keys[number].time;
            scene.animation.remove_key(name, time);
        }
        (Change::Paste, _) => {
            if let Some(key) = copied {
                scene.animation.set_key(name, Key { time, ..key });
            }
        }
        (Change::Express, _) => {
            let texts = match value {
                Some(Value::Array(all)) => all.iter().map(Value::to_string).collect(),
                Some(value) if !value.is_str() => vec![value.to_string()],
                _ => return,
            };
            *track = Track::Expressions(texts);
        }
        (Change::Write(text), _) => {
            *track = Track::Expressions(text.split(';').map(|part| part.trim().to_string()).collect());
        }
        (Change::Drop, _) => drop(scene.animation.tracks.remove(name)),
        _ => {}
    }
}
