//! Rows of a panel: a label with a tooltip, and a control whose accessible name is that of the field in a scene file.

use egui::{
    Align, Button, Color32, ComboBox, DragValue, Layout, PointerButton, Response, Slider, SliderClamping, TextEdit, Ui,
    vec2,
};
use hypertexture::scene::Color;
use hypertexture_support::significant;
use std::ops::RangeInclusive;
use toml::Value;

/// Maximal width of a label, points.
const LABEL: f32 = 122.0;
/// Width of a row besides its label and slider: a number, a button and gaps, points.
const ROW_REST: f32 = 72.0 + VALUE;
/// Width below which a label is above its control, points.
const NARROW: f32 = 260.0;
/// Width of a small button at the end of a row with its gap, points.
const RESET: f32 = 28.0;
/// Width beside a slider whose label is above it, points.
const SLIDER_REST: f32 = 96.0 + VALUE;
/// Width of a number with its unit, so that what stands behind it is in one column, points.
const VALUE: f32 = 58.0;
/// Significant digits of a number.
const DIGITS: usize = 4;

/// A field of a scene and its description.
#[derive(Clone, Debug)]
pub struct Field<'a> {
    /// Name in a scene file.
    pub name: String,
    /// Label; without one, the last part of the name.
    pub text: Option<&'a str>,
    /// Description with the unit.
    pub doc: &'a str,
    /// Symbol of the unit behind a number, if it has one.
    pub unit: &'static str,
}

/// A field with the default label.
pub fn field(name: impl Into<String>, doc: &str) -> Field<'_> {
    Field { name: name.into(), text: None, doc, unit: "" }
}

/// A number for a label: four significant digits, but all of those before the point.
pub fn short(value: f64) -> String {
    if value.abs() >= 1e3 && value.abs() < 1e9 { format!("{value:.0}") } else { significant(value, DIGITS) }
}

/// A value for a label, with short numbers.
pub fn brief(value: &Value) -> String {
    match value {
        Value::Float(number) => short(*number),
        Value::Array(all) => format!("[{}]", all.iter().map(brief).collect::<Vec<_>>().join(", ")),
        Value::String(text) => text.clone(),
        other => other.to_string(),
    }
}

/// Name of the field that was last changed in this frame.
pub type Touch = Option<String>;

/// Sets the accessible name of a control, and scrolls to it when it gets the focus.
pub fn named(ui: &Ui, response: &Response, name: &str) -> Response {
    ui.ctx().accesskit_node_builder(response.id, |node| node.set_label(name));
    come_into_view(ui, response);
    response.clone()
}

/// Scrolls to a control that gets the focus by the keyboard, unless it is taller than half of the view.
pub fn come_into_view(ui: &Ui, response: &Response) {
    let fits = response.rect.height() < 0.5 * ui.clip_rect().height().max(100.0);
    if fits && response.gained_focus() && !ui.input(|input| input.pointer.any_down()) {
        response.scroll_to_me(None);
    }
}

/// Fits labels and sliders to the available width.
pub fn fit(ui: &mut Ui) {
    let beside = if is_narrow(ui) { SLIDER_REST } else { label_width(ui) + ROW_REST };
    ui.spacing_mut().slider_width = (ui.available_width() - beside).clamp(24.0, 118.0);
}

/// Whether a row is too narrow for a label beside its control.
pub fn is_narrow(ui: &Ui) -> bool {
    ui.available_width() < NARROW
}

fn label_width(ui: &Ui) -> f32 {
    (0.36 * ui.available_width()).clamp(64.0, LABEL)
}

/// A button with an accessible name and a tooltip.
pub fn button(ui: &mut Ui, text: &str, name: &str, doc: &str) -> Response {
    let response = ui.button(text).on_hover_text(doc);
    named(ui, &response, name)
}

/// A framed button that stays pressed while what it opens is open.
pub fn toggle(ui: &mut Ui, on: bool, text: &str, name: &str, doc: &str) -> Response {
    let response = ui.add(Button::new(text).selected(on)).on_hover_text(doc);
    named(ui, &response, name)
}

/// A label with content at its right, or below it in a narrow panel.
pub fn line<R>(ui: &mut Ui, field: &Field<'_>, add: impl FnOnce(&mut Ui) -> R) -> R {
    let last = field.name.rsplit('.').next().unwrap_or_default();
    let text = field.text.map_or_else(|| last.replace('_', " "), String::from);
    let label = egui::Label::new(&text).truncate();
    if is_narrow(ui) {
        let below = |ui: &mut Ui| {
            ui.set_max_width(ui.available_width() - RESET);
            if !text.is_empty() {
                ui.add(label).on_hover_text(tip(field));
            }
            ui.horizontal_wrapped(add).inner
        };
        return ui.vertical(below).inner;
    }
    let width = label_width(ui);
    ui.horizontal(|ui| {
        let height = ui.spacing().interact_size.y;
        let label = ui.allocate_ui_with_layout(vec2(width, height), Layout::left_to_right(Align::Center), |ui| {
            ui.set_min_width(width);
            ui.add(label)
        });
        label.inner.on_hover_text(tip(field));
        add(ui)
    })
    .inner
}

/// A label with a control that has the name of the field.
pub fn row(ui: &mut Ui, field: &Field<'_>, add: impl FnOnce(&mut Ui) -> Response) -> Response {
    line(ui, field, |ui| {
        let response = add(ui);
        named(ui, &response, &field.name).on_hover_text(tip(field))
    })
}

fn tip(field: &Field<'_>) -> String {
    format!("{}\n{}", field.doc, field.name)
}

/// Whether a range has a logarithmic slider: positive, over more than two decades.
fn is_logarithmic(low: f64, high: f64) -> bool {
    low > 0.0 && high / low > 200.0
}

/// Whether a control was changed by anything but the right button, which opens its menu.
fn is_changed(ui: &Ui, response: &Response) -> bool {
    let right = PointerButton::Secondary;
    response.changed() && !ui.input(|input| input.pointer.button_down(right) || input.pointer.button_released(right))
}

/// A number with a slider. Values outside of the range can be typed; the checks of the scene decide.
pub fn number<N: egui::emath::Numeric>(
    ui: &mut Ui,
    touch: &mut Touch,
    field: &Field<'_>,
    value: &mut N,
    range: RangeInclusive<N>,
) {
    let (low, high, before) = (range.start().to_f64(), range.end().to_f64(), *value);
    let slider = Slider::new(value, range).logarithmic(is_logarithmic(low, high)).clamping(SliderClamping::Never);
    let slider = if N::INTEGRAL { slider } else { slider.custom_formatter(|value, _| short(value)) };
    let slider = slider.suffix(field.unit);
    let response = row(ui, field, |ui| {
        ui.spacing_mut().interact_size.x = VALUE;
        ui.add(slider)
    });
    if is_changed(ui, &response) {
        *touch = Some(field.name.clone());
    } else {
        *value = before;
    }
}

/// A number without a range, dragged in proportion to its value.
pub fn unbounded(ui: &mut Ui, touch: &mut Touch, field: &Field<'_>, value: &mut f32) {
    let speed = 0.01 * f64::from(value.abs()).max(0.1);
    let drag = DragValue::new(value).speed(speed).custom_formatter(|value, _| short(value)).suffix(field.unit);
    let response = row(ui, field, |ui| ui.add(drag));
    if is_changed(ui, &response) {
        *touch = Some(field.name.clone());
    }
}

/// Several numbers: `name.x`, `name.y`, ...
pub fn numbers(ui: &mut Ui, touch: &mut Touch, field: &Field<'_>, values: &mut [f32], speed: f64) {
    const AXES: [&str; 4] = ["x", "y", "z", "w"];
    line(ui, field, |ui| {
        ui.spacing_mut().item_spacing.x = 4.0;
        for (value, axis) in values.iter_mut().zip(AXES) {
            let name = format!("{}.{axis}", field.name);
            let response = ui.add(DragValue::new(value).speed(speed).custom_formatter(|value, _| short(value)));
            let response = named(ui, &response, &name).on_hover_text(tip(field));
            if is_changed(ui, &response) {
                *touch = Some(field.name.clone());
            }
        }
    });
}

/// A checkbox.
pub fn switch(ui: &mut Ui, touch: &mut Touch, field: &Field<'_>, value: &mut bool) {
    if row(ui, field, |ui| ui.checkbox(value, "")).changed() {
        *touch = Some(field.name.clone());
    }
}

/// A list of options with tooltips.
pub fn choice<T: Clone + PartialEq>(
    ui: &mut Ui,
    touch: &mut Touch,
    field: &Field<'_>,
    value: &mut T,
    options: &[(T, &str, String)],
) {
    let now = options.iter().find(|option| option.0 == *value).map(|option| option.1).unwrap_or("?");
    let mut changed = false;
    row(ui, field, |ui| {
        let width = ui.available_width().clamp(60.0, 150.0);
        let combo = ComboBox::from_id_salt(&field.name).selected_text(now).width(width).height(360.0);
        let shown = combo.show_ui(ui, |ui| {
            for (option, name, doc) in options {
                changed |= ui.selectable_value(value, option.clone(), *name).on_hover_text(doc).changed();
            }
        });
        shown.response
    });
    if changed {
        *touch = Some(field.name.clone());
    }
}

/// A color picker and a field for the hexadecimal code.
pub fn color(ui: &mut Ui, touch: &mut Touch, field: &Field<'_>, value: &mut Color) {
    row(ui, field, |ui| {
        let picker = ui.color_edit_button_srgb(&mut value.0);
        if picker.changed() {
            *touch = Some(field.name.clone());
        }
        let code = field_of_text(ui, &format!("{}.code", field.name), &String::from(*value), 72.0);
        if let Some(color) = code.and_then(|text| Color::try_from(text).ok()).filter(|color| color != value) {
            *value = color;
            *touch = Some(field.name.clone());
        }
        picker
    });
}

/// A text field.
pub fn text(ui: &mut Ui, touch: &mut Touch, field: &Field<'_>, value: &mut String) {
    let done = line(ui, field, |ui| field_of_text(ui, &field.name, value, ui.available_width().clamp(60.0, 176.0)));
    if let Some(text) = done.filter(|text| text != value) {
        *value = text;
        *touch = Some(field.name.clone());
    }
}

/// A text field that returns its text when Enter or a change of the focus ends it; Escape restores the old text.
pub fn field_of_text(ui: &mut Ui, name: &str, value: &str, width: f32) -> Option<String> {
    let id = ui.make_persistent_id(name);
    let held: Option<String> = ui.data(|data| data.get_temp(id));
    let mut text = held.unwrap_or_else(|| value.to_string());
    let response = ui.add(TextEdit::singleline(&mut text).id(id).desired_width(width));
    named(ui, &response, name);
    if response.lost_focus() {
        ui.data_mut(|data| data.remove::<String>(id));
        let is_given_up = ui.input(|input| input.key_pressed(egui::Key::Escape));
        return (!is_given_up).then_some(text);
    }
    if response.has_focus() {
        ui.data_mut(|data| data.insert_temp(id, text));
    }
    None
}

/// A color of the scene as an egui color.
pub fn painted(color: Color) -> Color32 {
    let [r, g, b] = color.0;
    Color32::from_rgb(r, g, b)
}
