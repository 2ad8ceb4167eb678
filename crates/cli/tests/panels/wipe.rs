//! Comparison of two variants.

use egui::accesskit::{Action, ActionData, ActionRequest};
use egui::{Event, Key, PointerButton, Pos2, Rect, pos2, vec2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use hypertexture_viewer::screen::{CompareMode, Comparison};

const PLACE: Rect = Rect { min: pos2(20.0, 10.0), max: pos2(620.0, 410.0) };

struct State {
    comparison: Comparison,
    rms: Option<f64>,
}

fn harness() -> Harness<'static, State> {
    let titles = ["now: quality.samples = 64".to_string(), "kept: 256".to_string()];
    let show = move |ui: &mut egui::Ui, state: &mut State| state.comparison.show(ui, PLACE, &titles, state.rms);
    let state = State { comparison: Comparison::default(), rms: None };
    let mut harness = Harness::builder().with_size(vec2(640.0, 420.0)).build_ui_state(show, state);
    harness.run_steps(3);
    harness
}

fn act(harness: &mut Harness<'static, State>, name: &str, action: Action, data: Option<ActionData>) {
    let (target_node, target_tree) = harness.get_by_label(name).accesskit_node().locate();
    harness.event(Event::AccessKitActionRequest(ActionRequest { action, target_node, target_tree, data }));
    harness.run_steps(2);
}

fn press(harness: &mut Harness<'static, State>, pos: Pos2, pressed: bool) {
    harness.event(Event::PointerMoved(pos));
    harness.event(Event::PointerButton {
        pos,
        button: PointerButton::Primary,
        pressed,
        modifiers: egui::Modifiers::NONE,
    });
    harness.run_steps(1);
}

#[test]
fn the_line_of_the_wipe_is_moved_by_mouse_and_keys() {
    let mut harness = harness();
    assert_eq!(harness.state().comparison, Comparison { mode: CompareMode::Wipe, at: 0.5, gain: 8.0 });
    press(&mut harness, pos2(320.0, 300.0), true);
    harness.event(Event::PointerMoved(pos2(140.0, 200.0)));
    harness.run_steps(1);
    assert!((harness.state().comparison.at - 0.2).abs() < 1e-3, "{:?}", harness.state().comparison);
    harness.event(Event::PointerMoved(pos2(-500.0, 200.0)));
    harness.run_steps(1);
    press(&mut harness, pos2(-500.0, 200.0), false);
    assert_eq!(harness.state().comparison.at, 0.0, "it stays in the picture");
    act(&mut harness, "compare.at", Action::Focus, None);
    harness.key_press(Key::ArrowRight);
    harness.run_steps(2);
    assert!(harness.state().comparison.at > 0.0);
}

#[test]
fn the_difference_has_a_gain_and_an_rms_for_equal_sizes() {
    let mut harness = harness();
    assert!(harness.query_by_label("compare.gain").is_none());
    act(&mut harness, "compare.difference", Action::Click, None);
    act(&mut harness, "compare.gain", Action::SetValue, Some(ActionData::NumericValue(64.0)));
    assert_eq!((harness.state().comparison.mode, harness.state().comparison.gain), (CompareMode::Difference, 64.0));
    assert!(harness.query_by_label("compare.at").is_none());
    let says = |harness: &Harness<'static, State>, text: &str| harness.query_all_by_value(text).next().is_some();
    assert!(says(&harness, "RMS: not equally sampled yet"));
    harness.state_mut().rms = Some(0.021);
    harness.run_steps(2);
    assert!(says(&harness, "RMS 2.1e-2"));
    // One key cycles through the display modes.
    let mut seen = Vec::new();
    for _ in 0..4 {
        harness.state_mut().comparison.next();
        seen.push(harness.state().comparison.mode);
    }
    assert_eq!(seen, [CompareMode::Now, CompareMode::Kept, CompareMode::Wipe, CompareMode::Difference]);
}
