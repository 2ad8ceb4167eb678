//! Table of the keys and of the mouse, for handling and for the help.

use egui::{Context, Event, FocusDirection, Id, Key, Modifiers, Popup};

/// The effect of a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    New,
    Open,
    Save,
    SaveAs,
    Export,
    Quit,
    Undo,
    Redo,
    Duplicate,
    Delete,
    Place,
    Paint,
    Weaker,
    Stronger,
    Frame,
    Reset,
    Side(usize),
    Level,
    Inertia,
    Panels,
    Controls,
    FullScreen,
    Play,
    Previous,
    Next,
    Screenshot,
    Record,
    Compare,
    Look,
    Inspect,
    Worst,
    Validity,
    Help,
    Lesson,
    Leave,
}

/// A key, its name, its effect, its label in a menu and its description.
pub(super) struct Binding {
    pub(super) key: Key,
    pub(super) modifiers: Modifiers,
    pub(super) name: &'static str,
    pub(super) action: Action,
    pub(super) label: &'static str,
    pub(super) what: &'static str,
}

const fn plain(key: Key, name: &'static str, action: Action, label: &'static str, what: &'static str) -> Binding {
    Binding { key, modifiers: Modifiers::NONE, name, action, label, what }
}

const fn command(key: Key, name: &'static str, action: Action, label: &'static str, what: &'static str) -> Binding {
    Binding { modifiers: Modifiers::COMMAND, ..plain(key, name, action, label, what) }
}

/// The same key with Shift.
const fn shifted(binding: Binding) -> Binding {
    let modifiers = Modifiers { shift: true, ..binding.modifiers };
    Binding { modifiers, ..binding }
}

/// All keys. Only the first one of an action has a label and is listed.
pub(super) const KEYS: &[Binding] = &[
    command(Key::N, "Ctrl+N", Action::New, "New", "a new scene"),
    command(Key::O, "Ctrl+O", Action::Open, "Open...", "open a scene, a mesh, a scan or a module"),
    command(Key::S, "Ctrl+S", Action::Save, "Save", "save the scene"),
    shifted(command(Key::S, "Ctrl+Shift+S", Action::SaveAs, "Save as...", "save the scene as another file")),
    command(
        Key::E,
        "Ctrl+E",
        Action::Export,
        "Export...",
        "write a final picture, a sequence, a video, a mesh, a volume or a page",
    ),
    command(Key::Q, "Ctrl+Q", Action::Quit, "Quit", "close the window"),
    command(Key::Z, "Ctrl+Z or Z", Action::Undo, "Undo", "undo"),
    plain(Key::Z, "Z", Action::Undo, "", ""),
    shifted(command(Key::Z, "Ctrl+Shift+Z or Y", Action::Redo, "Redo", "redo")),
    command(Key::Y, "Ctrl+Y", Action::Redo, "", ""),
    plain(Key::Y, "Y", Action::Redo, "", ""),
    shifted(plain(Key::D, "Shift+D", Action::Duplicate, "Duplicate", "duplicate the selected object")),
    plain(Key::Delete, "Delete", Action::Delete, "Delete", "remove the selected keyframe, else the selected object"),
    plain(
        Key::G,
        "G",
        Action::Place,
        "Place",
        "place the selected object, else the light, by drags and typed numbers, or stop",
    ),
    plain(Key::B, "B", Action::Paint, "Brush", "paint the groom with the brush, or stop"),
    plain(Key::OpenBracket, "[ and ]", Action::Weaker, "Weaker brush", "a weaker brush, a stronger one"),
    plain(Key::CloseBracket, "]", Action::Stronger, "", ""),
    plain(Key::Period, ".", Action::Frame, "Frame", "frame the selected object, else all"),
    plain(Key::R, "R or Home", Action::Reset, "Reset", "reset the view"),
    plain(Key::Home, "Home", Action::Reset, "", ""),
    plain(Key::Num1, "1, 2, 3", Action::Side(0), "Front", "look from the front, from the right, from the top"),
    plain(Key::Num2, "2", Action::Side(1), "", ""),
    plain(Key::Num3, "3", Action::Side(2), "", ""),
    plain(Key::O, "O", Action::Level, "Level orbit", "orbit level, or as a trackball"),
    plain(Key::I, "I", Action::Inertia, "Inertia", "inertia of the trackball"),
    plain(
        Key::Tab,
        "Tab",
        Action::Panels,
        "Hide panels",
        "hide the panels, or show them; among controls, the next one",
    ),
    plain(
        Key::F6,
        "F6",
        Action::Controls,
        "Focus controls",
        "move the focus to the controls: Tab, arrows, Space; Esc leaves them",
    ),
    plain(Key::F, "F", Action::FullScreen, "Full screen", "full screen"),
    plain(Key::Space, "Space", Action::Play, "Play", "play or pause"),
    plain(Key::ArrowLeft, "Left", Action::Previous, "Previous preset", "the previous preset"),
    plain(Key::ArrowRight, "Right", Action::Next, "Next preset", "the next preset"),
    plain(Key::S, "S", Action::Screenshot, "Write picture", "write the picture, in the size of the scene (Picture)"),
    plain(Key::T, "T", Action::Record, "Turntable", "write the pictures of a turntable, or stop"),
    plain(Key::C, "C", Action::Compare, "Compare", "pin this variant and compare with it, or stop"),
    plain(Key::D, "D", Action::Look, "Next comparison", "display of two variants: wipe, difference, one, the other"),
    plain(Key::P, "P", Action::Inspect, "Inspect pixel", "inspect the pixel under the pointer, or stop"),
    plain(Key::W, "W", Action::Worst, "Worst pixel", "jump to the next of the worst pixels"),
    plain(Key::V, "V", Action::Validity, "Validity", "color invalid pixels, or stop"),
    plain(Key::Questionmark, "? or H", Action::Help, "Keys", "this list"),
    plain(Key::H, "H", Action::Help, "", ""),
    plain(Key::L, "L", Action::Lesson, "How it works", "how it works: slices, soft regions, turbulence"),
    plain(
        Key::Escape,
        "Esc",
        Action::Leave,
        "Leave",
        "leave the text field, this list, the brush, full screen; then the window",
    ),
];

/// Help on the mouse.
pub(super) const MOUSE: &[(&str, &str)] = &[
    ("drag", "turn the object, like a ball or level"),
    ("right or middle drag, or Shift", "move it"),
    ("Ctrl and drag", "move the light"),
    ("wheel or pinch", "zoom to the pointer; of a brush, its radius"),
    ("click", "select an object; of an open inspector, its pixel"),
    ("right click on a control, Shift+F10", "copy, paste, reset or animate its value, copy it as a flag"),
    ("drop a file", "show a mesh, a scan or a scene"),
];

/// Whether a text field had the focus at the end of the last pass. egui takes the focus away at the beginning of a pass with
/// Escape, which then still belongs to the field.
#[derive(Clone, Copy, Default)]
struct Writing(bool);

/// Whether a text field has the focus, or had it at the end of the last pass.
pub(super) fn writes(ctx: &Context) -> bool {
    ctx.text_edit_focused() || ctx.data(|data| data.get_temp::<Writing>(Id::NULL)).unwrap_or_default().0
}

/// Notes at the end of a pass whether a text field has the focus.
pub(super) fn note_writing(ctx: &Context) {
    let is_text = ctx.text_edit_focused();
    ctx.data_mut(|data| data.insert_temp(Id::NULL, Writing(is_text)));
}

/// Ends the ownership of the keys by a text field.
pub(super) fn stop_writing(ctx: &Context) {
    ctx.data_mut(|data| data.remove::<Writing>(Id::NULL));
}

/// Whether an event presses the key of a binding. Shift counts where another binding has it; it is needed for some signs and
/// digits on some keyboards.
fn hits(event: &Event, binding: &Binding) -> bool {
    let Event::Key { key, pressed: true, modifiers, .. } = event else { return false };
    let same = |own: &Binding| own.key == *key && own.modifiers.command == binding.modifiers.command;
    let counts = KEYS.iter().any(|own| same(own) && own.modifiers.shift != binding.modifiers.shift);
    let shift = if counts { binding.modifiers.shift } else { modifiers.shift };
    *key == binding.key && modifiers.matches_exact(Modifiers { shift, ..binding.modifiers })
}

/// Whether the control with the focus uses the key itself: arrows, Space and the keys that move the focus.
fn is_of_control(binding: &Binding) -> bool {
    let own = [Key::Space, Key::Tab, Key::ArrowLeft, Key::ArrowRight, Key::Home, Key::Delete];
    own.contains(&binding.key) && !binding.modifiers.command
}

/// Actions of the keys since the last frame. If a text field has the focus or a popup is open, only those of keys
/// that do not type.
pub(super) fn pressed(ctx: &Context) -> Vec<Action> {
    // All that asks the context comes before the look at its input, which holds its lock.
    let (writes, has_focus, is_text) = (writes(ctx), ctx.egui_wants_keyboard_input(), ctx.text_edit_focused());
    let is_popup = Popup::is_any_open(ctx);
    // A text field has an undo of its own.
    let is_of_text = |action| writes && [Action::Undo, Action::Redo].contains(&action);
    let hit = |event: &Event, binding: &Binding| {
        let is_taken = is_popup || has_focus && (is_of_control(binding) || is_text);
        hits(event, binding) && (!is_taken || binding.modifiers.command)
    };
    let mut pressed: Vec<Action> = ctx.input(|input| {
        let pressed = KEYS.iter().filter(|binding| input.events.iter().any(|event| hit(event, binding)));
        let acts = |binding: &Binding| !writes || binding.modifiers.command || binding.action == Action::Leave;
        let pressed = pressed.filter(|binding| acts(binding) && !is_of_text(binding.action));
        pressed.map(|binding| binding.action).collect()
    });
    if writes && pressed.contains(&Action::Leave) {
        stop_writing(ctx);
        pressed.retain(|action| *action != Action::Leave);
    }
    // Without a focus, Tab would move it to the first control, which is the effect of F6.
    for action in &pressed {
        match action {
            Action::Panels => ctx.memory_mut(|memory| memory.move_focus(FocusDirection::None)),
            Action::Controls => ctx.memory_mut(|memory| memory.move_focus(FocusDirection::Next)),
            _ => {}
        }
    }
    pressed
}

/// The key of a name and its modifiers: a listed one, or any key of egui.
pub(super) fn named(name: &str) -> Option<(Key, Modifiers)> {
    let listed = KEYS.iter().find(|binding| binding.name.split(" or ").any(|own| own.eq_ignore_ascii_case(name)));
    let plain = || Some((Key::from_name(name)?, Modifiers::NONE));
    listed.map(|binding| (binding.key, binding.modifiers)).or_else(plain)
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::RawInput;

    fn key(key: Key, modifiers: Modifiers) -> Event {
        Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers }
    }

    /// Actions of a key in a frame of `show`, which runs in two frames before.
    fn actions(context: &Context, event: Event, mut show: impl FnMut(&mut egui::Ui)) -> Vec<Action> {
        let mut found = Vec::new();
        for events in [Vec::new(), vec![event], Vec::new()] {
            let output = context.run_ui(RawInput { events, ..RawInput::default() }, |ui| {
                found.extend(pressed(ui.ctx()));
                show(ui);
                note_writing(ui.ctx());
            });
            output.drop_without_applying_deltas();
        }
        found
    }

    #[test]
    fn shift_makes_another_key_where_one_is_bound() {
        let (ctrl, shift) = (Modifiers::COMMAND | Modifiers::CTRL, Modifiers::SHIFT);
        for (name, modifiers, action) in [
            (Key::Z, ctrl, Action::Undo),
            (Key::Z, ctrl | shift, Action::Redo),
            (Key::Y, ctrl, Action::Redo),
            (Key::Z, Modifiers::NONE, Action::Undo),
            (Key::D, Modifiers::NONE, Action::Look),
            (Key::D, shift, Action::Duplicate),
            (Key::S, ctrl | shift, Action::SaveAs),
            (Key::S, ctrl, Action::Save),
            (Key::Q, ctrl, Action::Quit),
            (Key::Questionmark, shift, Action::Help),
            (Key::Num1, shift, Action::Side(0)),
        ] {
            assert_eq!(actions(&Context::default(), key(name, modifiers), |_| ()), [action], "{name:?} {modifiers:?}");
        }
    }

    #[test]
    fn a_number_that_was_typed_gives_the_keys_back() {
        for end in [Key::Enter, Key::Tab] {
            let (context, mut value) = (Context::default(), 10.0);
            let mut show = |ui: &mut egui::Ui| {
                ui.add(egui::DragValue::new(&mut value));
                drop(ui.button("next"));
            };
            // The first control is the number.
            assert_eq!(actions(&context, key(Key::F6, Modifiers::NONE), &mut show), [Action::Controls]);
            actions(&context, Event::Text("4".into()), &mut show);
            let played = actions(&context, key(Key::S, Modifiers::NONE), &mut show);
            assert_eq!(played, [], "the number is being typed");
            actions(&context, key(end, Modifiers::NONE), &mut show);
            let played = actions(&context, key(Key::S, Modifiers::NONE), &mut show);
            assert_eq!(played, [Action::Screenshot], "{end:?}");
        }
    }

    #[test]
    fn escape_in_a_text_field_leaves_the_field_only() {
        let (context, mut text) = (Context::default(), String::new());
        let mut show = |ui: &mut egui::Ui| {
            ui.add(egui::TextEdit::singleline(&mut text).id(Id::new("field")));
        };
        actions(&context, Event::Text(String::new()), &mut show);
        context.memory_mut(|memory| memory.request_focus(Id::new("field")));
        actions(&context, Event::Text("x".into()), &mut show);
        assert_eq!(actions(&context, key(Key::Escape, Modifiers::NONE), &mut show), []);
        assert_eq!(actions(&context, key(Key::Escape, Modifiers::NONE), &mut show), [Action::Leave]);
    }
}
