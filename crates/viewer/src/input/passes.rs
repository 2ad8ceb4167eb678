//! Input events, split into passes.

use egui::{Event, Key, RawInput};

/// Splits the events of a frame into passes. egui uses only the last pointer position and the last focus of a pass,
/// and a slow frame has many events. A pass ends with a mouse button, and a key that may move the focus has a pass of
/// its own: text typed before Escape in one pass would be lost.
pub(crate) fn passes(mut input: RawInput) -> Vec<RawInput> {
    let moves_focus = |event: &Event| match event {
        Event::Key { key, pressed, .. } => *pressed && [Key::Escape, Key::Tab, Key::Enter].contains(key),
        _ => false,
    };
    let parts = |pair: &[Event]| {
        moves_focus(&pair[0]) || moves_focus(&pair[1]) || matches!(pair[0], Event::PointerButton { .. })
    };
    let mut passes = Vec::new();
    while let Some(end) = input.events.windows(2).position(parts) {
        let rest = input.events.split_off(end + 1);
        passes.push(input.take());
        input.events = rest;
    }
    passes.push(input);
    passes
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::{Modifiers, PointerButton, Pos2, pos2};

    fn button(pos: Pos2, pressed: bool) -> Event {
        Event::PointerButton { pos, button: PointerButton::Primary, pressed, modifiers: Modifiers::NONE }
    }

    #[test]
    fn buttons_and_focus_keys_end_passes_without_loss() {
        let [a, b, c] = [pos2(1.0, 0.0), pos2(2.0, 0.0), pos2(3.0, 0.0)];
        let key =
            |key| Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers: Modifiers::NONE };
        let events = [
            vec![Event::PointerMoved(a), button(a, true)],
            vec![Event::PointerMoved(b), button(b, false)],
            vec![Event::PointerMoved(c), Event::Text("x".into())],
            vec![key(Key::Escape)],
            vec![key(Key::T)],
        ];
        let split = passes(RawInput { events: events.concat(), ..RawInput::default() });
        assert_eq!(split.into_iter().map(|pass| pass.events).collect::<Vec<_>>(), events);
        // A pass of its own for nothing would be a frame too many.
        assert_eq!(passes(RawInput { events: events[0].clone(), ..RawInput::default() }).len(), 1);
        assert_eq!(passes(RawInput::default()).len(), 1);
    }

    #[test]
    fn a_released_slider_ignores_later_moves_of_its_frame() {
        let context = egui::Context::default();
        let (mut value, mut place) = (0.0, egui::Rect::NOTHING);
        let mut frame = |events: Vec<Event>| {
            for pass in passes(RawInput { events, ..RawInput::default() }) {
                let output = context.run_ui(pass, |ui| {
                    place = ui.add(egui::Slider::new(&mut value, 0.0..=1.0).show_value(false)).rect;
                });
                output.drop_without_applying_deltas();
            }
            (value, place)
        };
        frame(Vec::new());
        let (_, place) = frame(Vec::new());
        let at = |part: f32| pos2(egui::lerp(place.x_range(), part), place.center().y);
        let events = [at(0.1), at(0.5), at(0.9)].map(Event::PointerMoved);
        let [from, to, on] = events;
        let (value, _) = frame(vec![from, button(at(0.1), true), to, button(at(0.5), false), on]);
        assert!((value - 0.5f64).abs() < 0.02, "{value}");
    }
}
