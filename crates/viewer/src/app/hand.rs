//! Hands on a window without a device, for tests.

use super::{App, Start};
use egui::accesskit::{Action, ActionRequest, Role};
use egui::{Event, Modifiers};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use hypertexture::gpu::Options;
use hypertexture::scene::{Part, Scene, preset};
use hypertexture::shader::shipped;
use std::sync::Arc;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// A window without a device, under hands.
pub(super) type Hand = Harness<'static, App>;

/// A scene of three objects without fields, so that nothing loads for long.
pub(super) fn scene() -> Scene {
    let mut scene = preset("lit").unwrap();
    scene.object.input = "sphere".into();
    for (name, input) in [("b", "cube"), ("c", "torus")] {
        let mut part = Part::default();
        part.object.input = input.into();
        part.transform.scale = 0.5;
        scene.parts.insert(name.into(), part);
    }
    scene
}

/// A window without a device.
pub(super) fn window(scene: Scene) -> Hand {
    let (library, options) = (shipped(), Options::from_env());
    let (window, began) = ([1280, 1600], Instant::now());
    let (max_error, play, frames, screenshot, file, script) = (None, false, None, None, None, None);
    let start = Start { scene, library, options, max_error, play, window, frames, screenshot, file, script, began };
    let app = App::new(&start, Arc::new(|| ())).unwrap();
    let builder = Harness::builder().with_size(egui::vec2(1280.0, 1600.0)).with_step_dt(1.0 / 60.0);
    builder.build_ui_state(
        |ui, app: &mut App| {
            app.receive();
            app.ui(ui);
        },
        app,
    )
}

/// Performs an action on the first control of a name, and of a role if one is given; returns whether it is there.
pub(super) fn act(hand: &mut Hand, role: Option<Role>, name: &str, action: Action) -> bool {
    let found = {
        let mut nodes = hand
            .query_all_by(|node| role.is_none_or(|role| node.role() == role) && node.label().as_deref() == Some(name));
        nodes.next().map(|node| node.accesskit_node().locate())
    };
    let Some((target_node, target_tree)) = found else { return false };
    hand.event(Event::AccessKitActionRequest(ActionRequest { action, target_node, target_tree, data: None }));
    hand.run_steps(2);
    true
}

/// Every job shows objects under the names of its scene.
pub(super) fn agrees(app: &App) {
    for variant in app.jobs.submitted.iter().flat_map(|job| &job.variants) {
        let scene = variant.scene.moment().unwrap();
        assert!(scene.parts.keys().all(|name| variant.subject.parts.contains_key(name)), "{:?}", scene.parts.keys());
        crate::worker::pose_of(variant).unwrap();
    }
}

/// Opens advanced settings and the sections with text fields.
pub(super) fn open(hand: &mut Hand) {
    for name in ["view.advanced", "Objects", "Object", "Material", "Camera", "Picture"] {
        assert!(act(hand, None, name, Action::Click), "{name}");
    }
    hand.run_steps(30); // they open smoothly
}

/// Runs frames until the objects are there.
pub(super) fn loaded(scene: Scene) -> Hand {
    let mut hand = window(scene);
    let start = Instant::now();
    while hand.state().jobs.submitted.is_none() || hand.state().jobs.lacks_object {
        assert!(start.elapsed() < Duration::from_secs(600)); // a test that fails ends
        sleep(Duration::from_millis(5));
        hand.run_steps(1);
    }
    hand.run_steps(2);
    hand
}

pub(super) fn said(hand: &Hand) -> String {
    hand.state().message.as_ref().map(|message| message.text.clone()).unwrap_or_default()
}

/// Drags over the picture, between parts of its width and height from the upper left.
pub(super) fn drag(hand: &mut Hand, from: [f32; 2], to: [f32; 2]) {
    drag_with(hand, Modifiers::NONE, from, to);
}

/// As [`drag`], with modifiers.
pub(super) fn drag_with(hand: &mut Hand, modifiers: Modifiers, from: [f32; 2], to: [f32; 2]) {
    let place = hand.state().place;
    let at = |[x, y]: [f32; 2]| place.min + egui::vec2(x, y) * place.size();
    let button = |pos, pressed| Event::PointerButton { pos, button: egui::PointerButton::Primary, pressed, modifiers };
    let (from, to) = (at(from), at(to));
    for events in [
        vec![Event::ModifiersChanged(modifiers), Event::PointerMoved(from)],
        vec![button(from, true)],
        vec![Event::PointerMoved(from + 0.3 * (to - from))],
        vec![Event::PointerMoved(to)],
        vec![button(to, false), Event::ModifiersChanged(Modifiers::NONE)],
    ] {
        events.into_iter().for_each(|event| hand.event(event));
        hand.run_steps(1);
    }
    hand.run_steps(1);
}
