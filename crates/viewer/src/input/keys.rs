//! Table of the keys and of the mouse, for handling and for the help.

use super::command::Command;
use egui::{Context, Event, FocusDirection, Id, Key, Modifiers, Popup};

/// A key, its name, its command, its label in a menu and its description.
pub(crate) struct Binding {
    pub(crate) key: Key,
    pub(crate) modifiers: Modifiers,
    pub(crate) name: &'static str,
    pub(crate) command: Command,
    pub(crate) label: &'static str,
    pub(crate) doc: &'static str,
}

const NONE: Modifiers = Modifiers::NONE;
const SHIFT: Modifiers = Modifiers::SHIFT;
const CTRL: Modifiers = Modifiers::COMMAND;
const CTRL_SHIFT: Modifiers = Modifiers { shift: true, ..CTRL };

/// A listed key.
const fn key(
    modifiers: Modifiers,
    key: Key,
    name: &'static str,
    command: Command,
    label: &'static str,
    doc: &'static str,
) -> Binding {
    Binding { key, modifiers, name, command, label, doc }
}

/// Another key of a command, which is not listed.
const fn alias(modifiers: Modifiers, key: Key, name: &'static str, command: Command) -> Binding {
    Binding { key, modifiers, name, command, label: "", doc: "" }
}

/// All keys. Only the first one of a command has a label and is listed.
pub(crate) const KEYS: &[Binding] = &[
    key(CTRL, Key::N, "Ctrl+N", Command::New, "New", "a new scene"),
    key(CTRL, Key::O, "Ctrl+O", Command::ChooseFile, "Open...", "open a scene, a mesh, a scan or a module"),
    key(CTRL, Key::S, "Ctrl+S", Command::Save, "Save", "save the scene"),
    key(CTRL_SHIFT, Key::S, "Ctrl+Shift+S", Command::SaveAs, "Save as...", "save the scene as another file"),
    key(
        CTRL,
        Key::E,
        "Ctrl+E",
        Command::Export,
        "Export...",
        "write a final picture, a sequence, a video, a mesh, a volume or a page",
    ),
    key(CTRL, Key::Q, "Ctrl+Q", Command::AskToQuit, "Quit", "close the window"),
    key(CTRL, Key::Z, "Ctrl+Z or Z", Command::Undo, "Undo", "undo"),
    alias(NONE, Key::Z, "Z", Command::Undo),
    key(CTRL_SHIFT, Key::Z, "Ctrl+Shift+Z or Y", Command::Redo, "Redo", "redo"),
    alias(CTRL, Key::Y, "Ctrl+Y", Command::Redo),
    alias(NONE, Key::Y, "Y", Command::Redo),
    key(SHIFT, Key::D, "Shift+D", Command::Duplicate, "Duplicate", "duplicate the selected object"),
    key(
        NONE,
        Key::Delete,
        "Delete",
        Command::Delete,
        "Delete",
        "remove the selected keyframe, else the selected object",
    ),
    key(
        NONE,
        Key::G,
        "G",
        Command::Place,
        "Place",
        "place the selected object, else the light, by drags and typed numbers, or stop",
    ),
    key(NONE, Key::B, "B", Command::Paint, "Brush", "paint the groom with the brush, or stop"),
    key(NONE, Key::OpenBracket, "[ and ]", Command::WeakerBrush, "Weaker brush", "a weaker brush, a stronger one"),
    alias(NONE, Key::CloseBracket, "]", Command::StrongerBrush),
    key(NONE, Key::Period, ".", Command::Frame, "Frame", "frame the selected object, else all"),
    key(NONE, Key::R, "R or Home", Command::ResetCamera, "Reset", "reset the view"),
    alias(NONE, Key::Home, "Home", Command::ResetCamera),
    key(NONE, Key::Num1, "1, 2, 3", Command::Side(0), "Front", "look from the front, from the right, from the top"),
    alias(NONE, Key::Num2, "2", Command::Side(1)),
    alias(NONE, Key::Num3, "3", Command::Side(2)),
    key(NONE, Key::O, "O", Command::LevelOrbit, "Level orbit", "orbit level, or as a trackball"),
    key(NONE, Key::I, "I", Command::Inertia, "Inertia", "inertia of the trackball"),
    key(
        NONE,
        Key::Tab,
        "Tab",
        Command::Panels,
        "Hide panels",
        "hide the panels, or show them; among controls, the next one",
    ),
    key(
        NONE,
        Key::F6,
        "F6",
        Command::FocusControls,
        "Focus controls",
        "move the focus to the controls: Tab, arrows, Space; Esc leaves them",
    ),
    key(NONE, Key::F, "F", Command::FullScreen, "Full screen", "full screen"),
    key(NONE, Key::Space, "Space", Command::Play, "Play", "play or pause"),
    key(NONE, Key::ArrowLeft, "Left", Command::PreviousPreset, "Previous preset", "the previous preset"),
    key(NONE, Key::ArrowRight, "Right", Command::NextPreset, "Next preset", "the next preset"),
    key(
        NONE,
        Key::S,
        "S",
        Command::WritePicture,
        "Write picture",
        "write the picture, in the size of the scene (Picture)",
    ),
    key(NONE, Key::T, "T", Command::Turntable, "Turntable", "write the pictures of a turntable, or stop"),
    key(NONE, Key::C, "C", Command::Compare, "Compare", "pin this variant and compare with it, or stop"),
    key(
        NONE,
        Key::D,
        "D",
        Command::NextComparison,
        "Next comparison",
        "display of two variants: wipe, difference, one, the other",
    ),
    key(NONE, Key::P, "P", Command::InspectPixel, "Inspect pixel", "inspect the pixel under the pointer, or stop"),
    key(NONE, Key::W, "W", Command::WorstPixel, "Worst pixel", "jump to the next of the worst pixels"),
    key(NONE, Key::V, "V", Command::Validity, "Validity", "color invalid pixels, or stop"),
    key(NONE, Key::Questionmark, "? or H", Command::Help, "Keys", "this list"),
    alias(NONE, Key::H, "H", Command::Help),
    key(NONE, Key::L, "L", Command::Lesson, "How it works", "how it works: slices, soft regions, turbulence"),
    key(
        NONE,
        Key::Escape,
        "Esc",
        Command::Leave,
        "Leave",
        "leave the text field, this list, the brush, full screen; then the window",
    ),
];

/// Help on the mouse.
pub(crate) const MOUSE: &[(&str, &str)] = &[
    ("drag", "turn the object, like a ball or level"),
    ("right or middle drag, or Shift", "move it"),
    ("Ctrl and drag", "move the light"),
    ("wheel or pinch", "zoom to the pointer; of a brush, its radius"),
    ("click", "select an object; of an open inspector, its pixel"),
    ("right click on a control, Shift+F10", "copy, paste, reset or animate its value, copy it as a flag"),
    ("drop a file", "show a mesh, a scan or a scene"),
];

/// Whether a text field had the focus at the end of the last pass. egui takes the focus away at the beginning of a pass
/// with Escape, which then still belongs to the field.
#[derive(Clone, Copy, Default)]
struct Writing(bool);

/// Whether a text field has the focus, or had it at the end of the last pass.
pub(crate) fn writes(ctx: &Context) -> bool {
    ctx.text_edit_focused() || ctx.data(|data| data.get_temp::<Writing>(Id::NULL)).unwrap_or_default().0
}

/// Notes at the end of a pass whether a text field has the focus.
pub(crate) fn note_writing(ctx: &Context) {
    let is_text = ctx.text_edit_focused();
    ctx.data_mut(|data| data.insert_temp(Id::NULL, Writing(is_text)));
}

/// Ends the ownership of the keys by a text field.
pub(crate) fn stop_writing(ctx: &Context) {
    ctx.data_mut(|data| data.remove::<Writing>(Id::NULL));
}

/// Whether an event presses the key of a binding. Shift counts where another binding has it; it is needed for some
/// signs and digits on some keyboards.
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

/// Commands of the keys since the last frame. If a text field has the focus or a popup is open, only those of keys
/// that do not type.
pub(crate) fn pressed(ctx: &Context) -> Vec<Command> {
    // All that asks the context comes before the look at its input, which holds its lock.
    let (writes, has_focus, is_text) = (writes(ctx), ctx.egui_wants_keyboard_input(), ctx.text_edit_focused());
    let is_popup = Popup::is_any_open(ctx);
    // A text field has an undo of its own.
    let is_of_text = |command: &Command| writes && [Command::Undo, Command::Redo].contains(command);
    let hit = |event: &Event, binding: &Binding| {
        let is_taken = is_popup || has_focus && (is_of_control(binding) || is_text);
        hits(event, binding) && (!is_taken || binding.modifiers.command)
    };
    let mut pressed: Vec<Command> = ctx.input(|input| {
        let pressed = KEYS.iter().filter(|binding| input.events.iter().any(|event| hit(event, binding)));
        let acts = |binding: &Binding| !writes || binding.modifiers.command || binding.command == Command::Leave;
        let pressed = pressed.filter(|binding| acts(binding) && !is_of_text(&binding.command));
        pressed.map(|binding| binding.command.clone()).collect()
    });
    if writes && pressed.contains(&Command::Leave) {
        stop_writing(ctx);
        pressed.retain(|command| *command != Command::Leave);
    }
    // Without a focus, Tab would move it to the first control, which is the effect of F6.
    for command in &pressed {
        match command {
            Command::Panels => ctx.memory_mut(|memory| memory.move_focus(FocusDirection::None)),
            Command::FocusControls => ctx.memory_mut(|memory| memory.move_focus(FocusDirection::Next)),
            _ => {}
        }
    }
    pressed
}

/// The key of a name and its modifiers: a listed one, or any key of egui.
pub(crate) fn named(name: &str) -> Option<(Key, Modifiers)> {
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

    /// Commands of a key in a frame of `show`, which runs in two frames before.
    fn commands(context: &Context, event: Event, mut show: impl FnMut(&mut egui::Ui)) -> Vec<Command> {
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
        for (name, modifiers, command) in [
            (Key::Z, ctrl, Command::Undo),
            (Key::Z, ctrl | shift, Command::Redo),
            (Key::Y, ctrl, Command::Redo),
            (Key::Z, Modifiers::NONE, Command::Undo),
            (Key::D, Modifiers::NONE, Command::NextComparison),
            (Key::D, shift, Command::Duplicate),
            (Key::S, ctrl | shift, Command::SaveAs),
            (Key::S, ctrl, Command::Save),
            (Key::Q, ctrl, Command::AskToQuit),
            (Key::Questionmark, shift, Command::Help),
            (Key::Num1, shift, Command::Side(0)),
        ] {
            assert_eq!(
                commands(&Context::default(), key(name, modifiers), |_| ()),
                [command],
                "{name:?} {modifiers:?}"
            );
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
            assert_eq!(commands(&context, key(Key::F6, Modifiers::NONE), &mut show), [Command::FocusControls]);
            commands(&context, Event::Text("4".into()), &mut show);
            let played = commands(&context, key(Key::S, Modifiers::NONE), &mut show);
            assert_eq!(played, [], "the number is being typed");
            commands(&context, key(end, Modifiers::NONE), &mut show);
            let played = commands(&context, key(Key::S, Modifiers::NONE), &mut show);
            assert_eq!(played, [Command::WritePicture], "{end:?}");
        }
    }

    #[test]
    fn escape_in_a_text_field_leaves_the_field_only() {
        let (context, mut text) = (Context::default(), String::new());
        let mut show = |ui: &mut egui::Ui| {
            ui.add(egui::TextEdit::singleline(&mut text).id(Id::new("field")));
        };
        commands(&context, Event::Text(String::new()), &mut show);
        context.memory_mut(|memory| memory.request_focus(Id::new("field")));
        commands(&context, Event::Text("x".into()), &mut show);
        assert_eq!(commands(&context, key(Key::Escape, Modifiers::NONE), &mut show), []);
        assert_eq!(commands(&context, key(Key::Escape, Modifiers::NONE), &mut show), [Command::Leave]);
    }
}
