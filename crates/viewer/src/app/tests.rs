//! Keys, strokes and the frame of the picture, by hands on a window without a device.

use super::hand::{Hand, act, agrees, drag, drag_with, loaded, open, said, scene};
use crate::input::Command;
use crate::panels::Question;
use egui::accesskit::{Action, ActionRequest, Role};
use egui::{Event, Key, Modifiers};
use egui_kittest::kittest::{NodeT, Queryable};
use hypertexture::scene::{Ease, Key as Frame, Projection, preset};
use std::fs;
use std::sync::Arc;

#[test]
fn a_key_without_effect_says_why() {
    let mut hand = loaded(scene());
    for (key, modifiers, reason) in [
        (Key::Z, Modifiers::COMMAND, "nothing to undo"),
        (Key::Z, Modifiers::COMMAND | Modifiers::SHIFT, "nothing to redo"),
        (Key::Y, Modifiers::NONE, "nothing to redo"),
        (Key::D, Modifiers::NONE, "nothing to compare"),
        (Key::W, Modifiers::NONE, "once the picture has been refined"),
        (Key::OpenBracket, Modifiers::NONE, "the brush is off"),
        (Key::B, Modifiers::NONE, "a groom needs a scene of one object"),
        (Key::Delete, Modifiers::NONE, "the main object cannot be removed"),
    ] {
        hand.state_mut().message = None;
        hand.key_press_modifiers(modifiers, key);
        hand.run_steps(1);
        assert!(said(&hand).contains(reason), "{key:?}: {}", said(&hand));
    }
    assert!(!hand.state().document.painting.is_on);
    // With matrices, the view cannot be moved.
    let matrices = hypertexture::scene::schema::setting("camera.matrices").unwrap().optional.unwrap();
    hand.state_mut()
        .document
        .model
        .edit("camera.matrices", |scene| scene.set_field("camera.matrices", matrices).unwrap());
    hand.run_steps(2);
    drag(&mut hand, [0.1, 0.1], [0.3, 0.2]);
    assert!(said(&hand).contains("camera.matrices fix the view"), "{}", said(&hand));
}

#[test]
fn a_comparison_pins_the_shown_scene_and_ends() {
    let mut hand = loaded(scene());
    hand.state_mut().validity = true;
    for time in [None, Some(1.5)] {
        hand.state_mut().time.clock = time;
        hand.state_mut().perform(Command::Compare);
        let app = hand.state();
        let (pinned, library) = app.comparison.pinned.as_ref().expect("a pinned scene");
        assert!(**pinned == app.shown() && Arc::ptr_eq(library, &app.library) && !app.validity);
        hand.state_mut().perform(Command::Compare);
        assert!(hand.state().comparison.pinned.is_none());
    }
}

#[test]
fn objects_are_duplicated_and_removed_by_keys() {
    let mut hand = loaded(scene());
    hand.state_mut().document.selection.select(Some("b".into()));
    hand.key_press_modifiers(Modifiers::SHIFT, Key::D);
    hand.run_steps(2);
    let parts = |hand: &Hand| hand.state().document.model.scene().parts.clone();
    assert_eq!(parts(&hand)["object1"].object, parts(&hand)["b"].object);
    assert_eq!(hand.state().document.selection.part(), Some("object1"), "{}", said(&hand));
    assert!(!hand.state().jobs.lacks_object, "a copy loads nothing");
    hand.key_press(Key::Delete);
    hand.run_steps(2);
    assert!(!parts(&hand).contains_key("object1") && said(&hand).contains("Ctrl+Z"), "{}", said(&hand));
    hand.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    hand.run_steps(2);
    assert!(parts(&hand).contains_key("object1"));
    agrees(hand.state());
}

#[test]
fn escape_ends_what_is_on_before_it_asks_to_quit() {
    let mut hand = loaded(scene());
    let escape = |hand: &mut Hand| {
        hand.key_press(Key::Escape);
        hand.run_steps(2);
        (hand.state().objects.places, hand.state().document.painting.is_on, hand.state().panels.is_asking())
    };
    hand.key_press(Key::G);
    hand.state_mut().document.painting.is_on = true;
    hand.run_steps(2);
    assert!(hand.state().objects.places);
    assert_eq!(escape(&mut hand), (false, true, false));
    assert_eq!(escape(&mut hand), (false, false, false));
    assert_eq!(escape(&mut hand), (false, false, true));
}

#[test]
fn a_stroke_that_is_refused_turns_nothing() {
    let mut hand = loaded(scene());
    hand.state_mut().document.painting.is_on = true;
    let before = hand.state().document.model.scene().clone();
    drag(&mut hand, [0.5, 0.5], [0.6, 0.5]);
    assert_eq!(hand.state().document.model.scene(), &before, "{}", said(&hand));
    assert!(said(&hand).contains("a groom needs a scene of one object"), "{}", said(&hand));
    // Beside the objects, a drag turns the view.
    drag(&mut hand, [0.02, 0.02], [0.1, 0.05]);
    assert_ne!(hand.state().document.model.scene().camera, before.camera);
}

#[test]
fn a_stroke_begins_on_fur_beside_the_skin_and_each_is_one_step() {
    let mut fur = preset("fur").unwrap();
    (fur.object.input, fur.camera.azimuth, fur.camera.elevation) = ("sphere".into(), 0.0, 0.0);
    let mut hand = loaded(fur);
    let app = hand.state();
    // The silhouette of the ball, right of the middle, and the outer end of its fur.
    let pose = app.jobs.current_view.unwrap();
    let place = |x: f32| 0.5 + 0.5 * pose.place(glam::Vec3::new(x, 0.0, 0.0))[0];
    let outer = app.document.model.parameters(None).outer_iso().unwrap();
    let (skin, end) = (place(1.05), place(1.0 + outer));
    hand.state_mut().document.painting.is_on = true;
    let camera = hand.state().document.model.scene().camera.clone();
    for number in 1..=3 {
        drag(&mut hand, [skin + 0.5 * (end - skin), 0.5], [skin, 0.52]);
        assert_eq!(hand.state().document.model.scene().camera, camera, "stroke {number} turned the view");
        assert!(hand.state().document.model.scene().groom.is_some(), "{}", said(&hand));
    }
    for _ in 0..3 {
        assert!(hand.state_mut().document.model.undo());
    }
    assert!(
        hand.state().document.model.scene().groom.is_none() && !hand.state_mut().document.model.undo(),
        "one step each"
    );
    drag(&mut hand, [0.02, 0.02], [0.1, 0.05]);
    assert_ne!(hand.state().document.model.scene().camera, camera);
    assert!(hand.state().document.model.undoes().is_none(), "the view is no step");
}

#[test]
fn the_frame_is_held_while_an_object_moves() {
    let mut hand = loaded(scene());
    open(&mut hand);
    act(&mut hand, Some(Role::Button), "object b", Action::Click);
    let middle = |hand: &Hand| hand.state().jobs.current_view.unwrap().place(glam::Vec3::ZERO);
    let before = middle(&hand);
    let steps = hand.state().document.model.undoes().map(String::from);
    for at in [0.5, 1.5, 3.0] {
        let (target_node, target_tree) = {
            let name = "parts.b.transform.at.x";
            let mut nodes = hand.query_all_by(|node| node.label().as_deref() == Some(name));
            nodes.next().unwrap().accesskit_node().locate()
        };
        let data = Some(egui::accesskit::ActionData::NumericValue(at));
        let action = Action::SetValue;
        hand.event(Event::AccessKitActionRequest(ActionRequest { action, target_node, target_tree, data }));
        hand.run_steps(3);
        assert_eq!(hand.state().document.model.scene().parts["b"].transform.at[0], at as f32);
        let after = middle(&hand);
        let moved = (after[0] - before[0]).hypot(after[1] - before[1]);
        assert!(moved < 0.02, "{at}: {before:?} {after:?}");
    }
    let held = hand.state().document.model.scene().camera.clone();
    while hand.state().document.model.undoes().map(String::from) != steps {
        hand.key_press_modifiers(Modifiers::COMMAND, Key::Z);
        hand.run_steps(2);
    }
    let back = middle(&hand);
    assert!((back[0] - before[0]).hypot(back[1] - before[1]) < 0.02, "undo holds it too: {before:?} {back:?}");
    hand.state_mut().document.selection.select(None);
    hand.key_press(Key::Period);
    hand.run_steps(2);
    let camera = hand.state().document.model.scene().camera.clone();
    assert!(camera != held && (camera.pan, camera.zoom) == ([0.0; 2], 1.0), "{camera:?}");
    // A selected object is in the middle.
    hand.state_mut().document.selection.select(Some("c".into()));
    hand.state_mut().document.model.edit("c", |scene| scene.parts.get_mut("c").unwrap().transform.at = [2.0, 1.0, 0.0]);
    hand.run_steps(3);
    hand.key_press(Key::Period);
    hand.run_steps(3);
    let at = hand.state().jobs.current_view.unwrap().place(glam::Vec3::new(2.0, 1.0, 0.0));
    assert!(at[0].abs() < 0.05 && at[1].abs() < 0.05, "{at:?}: {}", said(&hand));
}

#[test]
fn while_another_object_loads_the_one_before_it_turns() {
    let mut scene = preset("lit").unwrap();
    scene.object.input = "sphere".into();
    let mut hand = loaded(scene);
    let before = hand.state().jobs.submitted.clone().unwrap();
    hand.state_mut().document.model.edit("object", |scene| {
        (scene.object.input, scene.object.resolution) = ("teapot".into(), 333); // in no cache
    });
    hand.run_steps(2);
    assert!(hand.state().jobs.lacks_object && hand.state().loading().is_some());
    drag(&mut hand, [0.1, 0.1], [0.3, 0.2]);
    let now = hand.state().jobs.submitted.clone().unwrap();
    assert!(Arc::ptr_eq(&now.variants[0].subject, &before.variants[0].subject) && now.number > before.number);
    assert_eq!(now.variants[0].scene.camera, hand.state().shown().camera, "it is seen by the camera of now");
    hand.state_mut().loader.cancel();
}

#[test]
fn a_reset_of_the_view_is_one_step_back() {
    let mut hand = loaded(scene());
    let moved = |hand: &mut Hand, angle: f32| {
        let model = &mut hand.state_mut().document.model;
        model.look(|camera| (camera.azimuth, camera.zoom, camera.rotation) = (angle, 2.0, None));
        model.scene().camera.clone()
    };
    hand.state_mut().document.model.edit("camera.projection", |scene| scene.camera.projection = Projection::Parallel);
    let own = moved(&mut hand, 33.0);
    hand.key_press(Key::R);
    hand.run_steps(2);
    let home = hand.state().document.model.home().clone();
    assert_eq!(hand.state().document.model.scene().camera, home);
    hand.key_press_modifiers(Modifiers::COMMAND, Key::Z);
    hand.run_steps(2);
    assert_eq!(hand.state().document.model.scene().camera, own);
    hand.key_press(Key::Y);
    hand.run_steps(2);
    assert_eq!(hand.state().document.model.scene().camera, home);
}

#[test]
fn a_drag_of_the_light_speaks_of_no_view() {
    let mut hand = loaded(scene());
    let matrices = hypertexture::scene::schema::setting("camera.matrices").unwrap().optional.unwrap();
    hand.state_mut()
        .document
        .model
        .edit("camera.matrices", |scene| scene.set_field("camera.matrices", matrices).unwrap());
    hand.run_steps(2);
    let before = hand.state().document.model.scene().light.position;
    hand.state_mut().message = None;
    drag_with(&mut hand, Modifiers::COMMAND, [0.3, 0.3], [0.5, 0.4]);
    assert_ne!(hand.state().document.model.scene().light.position, before);
    assert_eq!(said(&hand), "");
}

#[test]
fn delete_removes_a_visible_keyframe_before_the_object() {
    const TRACK: &str = "light.intensity";
    let mut hand = loaded(scene());
    let keyed = |hand: &mut Hand| {
        hand.state_mut().document.model.edit("keys", |scene| {
            let key = |time: f64, value: f64| Frame { time, value: value.into(), ease: Ease::Linear };
            for (time, value) in [(1.0, 0.5), (2.0, 1.0), (3.0, 1.5)] {
                scene.animation.set_key(TRACK, key(time, value));
            }
        });
        hand.run_steps(2);
    };
    let delete = |hand: &mut Hand, part: &str| {
        hand.state_mut().document.selection.select(Some(part.into()));
        hand.key_press(Key::Delete);
        hand.run_steps(2);
        let scene = hand.state().document.model.scene();
        (scene.parts.contains_key(part), scene.animation.tracks.contains_key(TRACK))
    };
    assert!(act(&mut hand, None, "timeline keyframes", Action::Click));
    keyed(&mut hand);
    for number in [3, 2] {
        assert!(act(&mut hand, None, &format!("{TRACK} key {number}"), Action::Click));
        assert_eq!(delete(&mut hand, "b"), (true, true));
        assert!(hand.query_by_label(&format!("{TRACK} key {number}")).is_none());
    }
    // A keyframe that is gone, and one that is not seen.
    assert!(act(&mut hand, None, &format!("{TRACK} key 1"), Action::Click));
    hand.state_mut().document.model.edit("no keys", |scene| scene.animation.tracks.clear());
    hand.run_steps(2);
    assert_eq!(delete(&mut hand, "b"), (false, false), "{}", said(&hand));
    keyed(&mut hand);
    assert!(act(&mut hand, None, &format!("{TRACK} key 1"), Action::Click));
    hand.state_mut().panels.hidden = true;
    hand.run_steps(2);
    assert_eq!(delete(&mut hand, "c"), (false, true), "{}", said(&hand));
}

#[test]
fn a_new_scene_asks_only_for_a_scene_that_is_not_saved() {
    let mut hand = loaded(scene());
    hand.state_mut().document.author.text.push_str("// mine\n");
    let begins = |hand: &mut Hand| {
        hand.key_press_modifiers(Modifiers::COMMAND, Key::N);
        hand.run_steps(2);
        (hand.state().panels.is_asking(), hand.state().document.model.scene().parts.is_empty())
    };
    assert_eq!(begins(&mut hand), (false, true), "the text of a module stays");
    assert!(hand.state().document.author.text.ends_with("// mine\n"));
    hand.state_mut().document.model.edit("specular", |scene| scene.material.specular = 0.75);
    assert_eq!(begins(&mut hand), (true, true));
    assert_eq!(hand.state().document.model.scene().material.specular, 0.75);
}

#[test]
fn the_key_that_led_to_a_question_does_not_answer_it() {
    let mut hand = loaded(scene());
    let is_begun = |hand: &Hand| hand.state().document.model.scene().parts.is_empty();
    hand.state_mut().panels.ask(Question::New);
    hand.key_press(Key::Enter);
    hand.run_steps(2);
    assert!(hand.state().panels.is_asking() && !is_begun(&hand));
    hand.key_press(Key::Enter);
    hand.run_steps(2);
    assert!(!hand.state().panels.is_asking() && is_begun(&hand));
    // The question takes the focus from the control that led to it.
    assert!(hand.state_mut().document.model.undo() && act(&mut hand, None, "author", Action::Focus));
    hand.state_mut().panels.ask(Question::New);
    hand.run_steps(2);
    hand.key_press(Key::Enter);
    hand.run_steps(2);
    assert!(!hand.state().panels.is_asking() && is_begun(&hand) && !hand.state().panels.author_is_open);
}

#[test]
fn a_loop_is_the_range_from_its_start_on() {
    let mut hand = loaded(scene());
    hand.state_mut().time.playback.range = [2.0, 12.0];
    hand.run_steps(2);
    assert!(act(&mut hand, None, "animation.has_loop", Action::Click));
    hand.run_steps(2);
    assert_eq!(hand.state().document.model.scene().animation.period, Some(10.0));
    let playback = hand.state().time.playback;
    assert_eq!((playback.range, playback.repeats), ([2.0, 12.0], true));
}

#[test]
fn work_that_cannot_be_restored_is_no_work_of_this_window() {
    let folder = tempfile::tempdir().unwrap();
    let kept = ["bad", "good"].map(|name| folder.path().join(name));
    kept.iter().for_each(|own| fs::create_dir(own).unwrap());
    fs::write(kept[0].join("scene.toml"), "[object]\ninput = 7\n").unwrap();
    fs::write(kept[1].join("scene.toml"), hypertexture::scene::to_text(&scene())).unwrap();
    let mut hand = loaded(scene());
    hand.state_mut().panels.remember(kept.clone().into(), None);
    hand.run_steps(2);
    assert!(act(&mut hand, None, "kept.open", Action::Click));
    assert_eq!(hand.state().document.restored, None, "{:?}", hand.state().document.model.message());
    assert!(act(&mut hand, None, "kept.open", Action::Click));
    assert_eq!(hand.state().document.restored.as_ref(), Some(&kept[1]));
}
