//! The menu of a control: copy, paste, reset, keyframe, flag.
//!
//! A right click on the control opens it, or Shift+F10 if the control has the focus.

use super::context::Pass;
use super::keyframes;
use super::widgets::named;
use egui::{Button, Event, Id, Key, Modifiers, Popup, Rect, Sense, SetOpenCommand, Ui, ViewportCommand};
use hypertexture::scene::{is_movable, option_text, value_text};
use toml::Value;

/// Longest value that is pasted, bytes: more than a path.
const MAX_PASTE: usize = 8192;

/// A field of a scene and its values.
pub(super) struct Of<'a> {
    pub(super) name: &'a str,
    /// The value now; `None` if the field has none.
    pub(super) value: Option<Value>,
    /// The value of the preset, or the default.
    pub(super) home: &'a dyn Fn() -> Option<Value>,
}

/// Shows the controls of a setting with their menu.
pub(super) fn of_setting(ui: &mut Ui, pass: &mut Pass<'_>, name: &str, add: impl FnOnce(&mut Ui, &mut Pass<'_>)) {
    let (model, value) = (pass.model, pass.value(name));
    with_menu(ui, pass, &Of { name, value, home: &|| model.field_in_preset(name) }, add);
}

/// Shows the controls of a field with their menu.
pub(super) fn with_menu(ui: &mut Ui, pass: &mut Pass<'_>, of: &Of<'_>, add: impl FnOnce(&mut Ui, &mut Pass<'_>)) {
    with_items(ui, pass, of.name, add, |ui, pass, menu| items(ui, pass, of, menu));
}

/// Shows controls with a menu of any items.
pub(super) fn with_items(
    ui: &mut Ui,
    pass: &mut Pass<'_>,
    name: &str,
    add: impl FnOnce(&mut Ui, &mut Pass<'_>),
    items: impl FnOnce(&mut Ui, &mut Pass<'_>, &mut Menu<'_>),
) {
    let rect = ui.scope(|ui| add(ui, pass)).response.rect;
    let id = Id::new(("menu", name));
    let is_clicked = ui.input(|input| input.pointer.secondary_clicked()) && ui.rect_contains_pointer(rect);
    let focused = by_key(ui, rect);
    if let Some(control) = focused {
        ui.data_mut(|data| data.insert_temp(id, Some(control)));
    }
    let is_opened = is_clicked || focused.is_some();
    if !is_opened && !Popup::is_id_open(ui.ctx(), id) {
        // The focus goes back to the control.
        if let Some(control) = ui.data_mut(|data| data.remove_temp::<Option<Id>>(id)).flatten() {
            ui.memory_mut(|memory| memory.request_focus(control));
        }
        return;
    }
    let response = ui.interact(rect, id.with("place"), Sense::hover());
    let popup = Popup::context_menu(&response).id(id).open_memory(is_opened.then_some(SetOpenCommand::Bool(true)));
    let control = ui.data(|data| data.get_temp::<Option<Id>>(id)).flatten();
    let popup = if control.is_some() { popup.at_position(rect.left_bottom()) } else { popup };
    popup.show(|ui| {
        // Opened by the keyboard, the menu takes the focus of the control.
        let takes_focus = control.is_some() && ui.memory(|memory| memory.focused()) == control;
        items(ui, pass, &mut Menu { name, takes_focus });
    });
}

/// An open menu.
pub(super) struct Menu<'a> {
    /// Name of the controls.
    name: &'a str,
    /// Whether the next item takes the focus.
    takes_focus: bool,
}

impl Menu<'_> {
    /// Shows an item; returns whether it was chosen.
    pub(super) fn item(&mut self, ui: &mut Ui, on: bool, text: &str, what: &str, doc: &str) -> bool {
        let response = ui.add_enabled(on, Button::new(text)).on_hover_text(doc);
        named(ui, &response, &format!("{} {what}", self.name));
        if response.enabled() && std::mem::take(&mut self.takes_focus) {
            response.request_focus();
        }
        if response.clicked() {
            ui.close();
        }
        response.clicked()
    }
}

/// The control within `rect` that has the focus, if its menu is asked for by the keyboard.
fn by_key(ui: &Ui, rect: Rect) -> Option<Id> {
    let control = ui.memory(|memory| memory.focused()).filter(|_| ui.input(|input| input.key_pressed(Key::F10)))?;
    let place = ui.ctx().read_response(control).filter(|place| place.layer_id == ui.layer_id())?;
    let is_own = rect.contains(place.rect.center());
    (is_own && ui.input_mut(|input| input.consume_key(Modifiers::SHIFT, Key::F10))).then_some(control)
}

fn items(ui: &mut Ui, pass: &mut Pass<'_>, of: &Of<'_>, menu: &mut Menu<'_>) {
    let text = of.value.as_ref().map(value_text);
    if menu.item(ui, text.is_some(), "Copy", "copy", "Copy the value as a scene file has it.") {
        ui.copy_text(text.unwrap_or_default());
    }
    if menu.item(ui, true, "Paste", "paste", "Take the value of the clipboard.") {
        ui.data_mut(|data| data.insert_temp(waiting(), of.name.to_string()));
        ui.send_viewport_cmd(ViewportCommand::RequestPaste);
    }
    let home = (of.home)();
    let shown = home.as_ref().map_or("none".into(), value_text);
    let doc = format!("Reset to {shown}, the value of the preset or the default.");
    if menu.item(ui, home != of.value, "Reset", "reset", &doc) {
        pass.set(of.name, &home.as_ref().map(value_text).unwrap_or_default());
    }
    if let Some(value) = of.value.as_ref().filter(|_| is_movable(of.name)) {
        let (text, what) = match pass.model.key(of.name) {
            Some(_) => ("Remove the keyframe", "keyframe remove"),
            None => ("Animate", "animate"),
        };
        if menu.item(ui, true, text, what, "A keyframe at the present time, as by the diamond of the control.") {
            pass.keys = true;
            keyframes::toggle(pass, of.name, value);
        }
    }
    if menu.item(ui, true, "Copy as flag", "flag", "Copy the option of the command line.") {
        ui.copy_text(option_text(of.name, of.value.as_ref()));
    }
}

/// Where the name of the field is kept that takes the next text of the clipboard.
fn waiting() -> Id {
    Id::new("pasted into")
}

/// Sets the field whose menu has asked for the clipboard.
pub(super) fn take_pasted(ui: &Ui, pass: &mut Pass<'_>) {
    let Some(name) = ui.data(|data| data.get_temp::<String>(waiting())) else { return };
    let text = ui.input_mut(|input| {
        let at = input.events.iter().position(|event| matches!(event, Event::Paste(_)))?;
        match input.events.remove(at) {
            Event::Paste(text) => Some(text),
            _ => None,
        }
    });
    let Some(text) = text else { return };
    ui.data_mut(|data| data.remove::<String>(waiting()));
    match text.trim() {
        "" => pass.refused = Some(format!("{name}: the clipboard holds no text; copy a value first")),
        text if text.len() > MAX_PASTE => {
            let length = text.len();
            pass.refused = Some(format!("{name}: the clipboard holds {length} bytes; a value has at most {MAX_PASTE}"));
        }
        text => pass.set(&name, &text.lines().collect::<Vec<_>>().join(" ")),
    }
}
