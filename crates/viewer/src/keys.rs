//! Table of the keys and of the mouse, for handling and for the help.

use egui::{Context, Event, FocusDirection, Id, Key, Modifiers, Popup};

/// The effect of a key.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Action {
    Help,
    Play,
    Reset,
    Previous,
    Next,
    Screenshot,
    Record,
    Compare,
    Validity,
    Inertia,
    Paint,
    Weaker,
    Stronger,
    Level,
    Lesson,
    Place,
    Side(usize),
    Look,
    Inspect,
    Worst,
    Undo,
    Redo,
    FullScreen,
    Leave,
    Save,
    Open,
    Panels,
    Controls,
    /// A key that has no effect because a text field owns the keys.
    Withheld,
}

/// A key, its label and its effect.
pub(super) struct Binding {
    pub(super) key: Key,
    pub(super) modifiers: Modifiers,
    pub(super) name: &'static str,
    pub(super) action: Action,
    pub(super) what: &'static str,
}

const fn plain(key: Key, name: &'static str, action: Action, what: &'static str) -> Binding {
    Binding { key, modifiers: Modifiers::NONE, name, action, what }
}

const fn command(key: Key, name: &'static str, action: Action, what: &'static str) -> Binding {
    Binding { key, modifiers: Modifiers::COMMAND, name, action, what }
}

/// All keys in the order of the help, which lists the first of several with the same name.
pub(super) const KEYS: &[Binding] = &[
    plain(Key::Questionmark, "? or H", Action::Help, "this list"),
    plain(Key::H, "? or H", Action::Help, ""),
    plain(Key::Space, "Space", Action::Play, "play or pause"),
    plain(Key::R, "R", Action::Reset, "reset the view"),
    plain(Key::ArrowLeft, "Left", Action::Previous, "the previous preset"),
    plain(Key::ArrowRight, "Right", Action::Next, "the next preset"),
    plain(Key::S, "S", Action::Screenshot, "write the picture, in the size of the scene (Picture)"),
    plain(Key::T, "T", Action::Record, "write the pictures of a turntable, or stop"),
    plain(Key::C, "C", Action::Compare, "pin this variant and compare with it, or stop"),
    plain(Key::V, "V", Action::Validity, "color invalid pixels, or stop"),
    plain(Key::D, "D", Action::Look, "display of two variants: wipe, difference, one, the other"),
    plain(Key::P, "P", Action::Inspect, "inspect the pixel under the pointer, or stop"),
    plain(Key::W, "W", Action::Worst, "jump to the next of the worst pixels"),
    plain(Key::I, "I", Action::Inertia, "inertia of the trackball"),
    plain(Key::B, "B", Action::Paint, "paint the groom with the brush, or stop"),
    plain(Key::OpenBracket, "[ and ]", Action::Weaker, "a weaker brush, a stronger one"),
    plain(Key::CloseBracket, "]", Action::Stronger, ""),
    plain(Key::O, "O", Action::Level, "orbit level, or as a trackball"),
    plain(
        Key::G,
        "G",
        Action::Place,
        "place the selected object, or else the light, by drags and typed numbers, or stop",
    ),
    plain(Key::L, "L", Action::Lesson, "how it works: slices, soft regions, turbulence"),
    plain(Key::Num1, "1, 2, 3", Action::Side(0), "look from the front, from the right, from the top"),
    plain(Key::Num2, "2", Action::Side(1), ""),
    plain(Key::Num3, "3", Action::Side(2), ""),
    plain(Key::Z, "Z", Action::Undo, "undo"),
    plain(Key::Y, "Y", Action::Redo, "redo"),
    plain(Key::Tab, "Tab", Action::Panels, "hide the panels, or show them; among controls, the next one"),
    plain(Key::F6, "F6", Action::Controls, "move the focus to the controls: Tab, arrows, Space; Esc leaves them"),
    plain(Key::F, "F", Action::FullScreen, "full screen"),
    plain(Key::Escape, "Esc", Action::Leave, "leave the text field, this list, full screen; then the window"),
    command(Key::S, "Ctrl+S", Action::Save, "save the scene"),
    command(Key::O, "Ctrl+O", Action::Open, "open a scene, a mesh, a scan or a module"),
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

/// Whether a text field owns the keys: it has the focus, or had it last. A click on the picture or Escape ends that;
/// before, letters have no effect outside of the text.
#[derive(Clone, Copy, Default)]
struct Writing(bool);

/// Whether a text field owns the keys. Called at the beginning and at the end of each pass: either may move the
/// focus.
pub(super) fn writes(ctx: &Context) -> bool {
    let (has_focus, is_text) = (ctx.egui_wants_keyboard_input(), ctx.text_edit_focused());
    ctx.data_mut(|data| {
        let writing = data.get_temp_mut_or_default::<Writing>(Id::NULL);
        writing.0 = if has_focus { is_text } else { writing.0 };
        writing.0
    })
}

/// Ends the ownership of the keys by a text field.
pub(super) fn stop_writing(ctx: &Context) {
    ctx.data_mut(|data| data.remove::<Writing>(Id::NULL));
}

/// Actions of the keys since the last frame. If a text field owns the keys or a popup is open, only those of keys
/// that do not type.
pub(super) fn pressed(ctx: &Context) -> Vec<Action> {
    let (writes, is_taken) = (writes(ctx), ctx.egui_wants_keyboard_input() || Popup::is_any_open(ctx));
    let hit = |event: &Event, binding: &Binding| match event {
        Event::Key { key, pressed: true, modifiers, .. } => {
            // The question mark needs Shift on some keyboards only.
            let shift = Modifiers { shift: modifiers.shift, ..binding.modifiers };
            let is_free = !is_taken || binding.modifiers.command;
            is_free && *key == binding.key && modifiers.matches_exact(shift)
        }
        _ => false,
    };
    let mut pressed: Vec<Action> = ctx.input(|input| {
        let pressed = KEYS.iter().filter(|binding| input.events.iter().any(|event| hit(event, binding)));
        let acts = |binding: &Binding| !writes || binding.modifiers.command || binding.action == Action::Leave;
        pressed.map(|binding| if acts(binding) { binding.action } else { Action::Withheld }).collect()
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
    let listed = KEYS.iter().find(|binding| binding.name.eq_ignore_ascii_case(name));
    let plain = || Some((Key::from_name(name)?, Modifiers::NONE));
    listed.map(|binding| (binding.key, binding.modifiers)).or_else(plain)
}
