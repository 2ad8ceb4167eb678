//! The timeline, and the bookmarks of the camera.

use super::Hand;
use egui::Key;
use egui::accesskit::Action;
use egui_kittest::kittest::{NodeT, Queryable};
use hypertexture::scene::{Camera, Ease, Track, preset};
use hypertexture_viewer::input::Command;
use hypertexture_viewer::playback::Playback;

#[test]
fn the_timeline_plays_scrubs_and_repeats_by_mouse_and_keys() {
    let mut hand = Hand::new(preset("fire").unwrap());
    hand.click("timeline play");
    hand.set("timeline", 2.5);
    hand.click("timeline start");
    hand.click("timeline loop");
    hand.set("timeline speed", 0.5);
    hand.set("timeline to", 4.0);
    let asked = std::mem::take(&mut hand.0.state_mut().commands);
    let playback = Playback::default();
    let expected = [
        Command::Play,
        Command::Time(2.5),
        Command::Time(0.0),
        Command::Playback(Playback { repeats: true, ..playback }),
        Command::Playback(Playback { speed: 0.5, ..playback }),
        Command::Playback(Playback { range: [0.0, 4.0], ..playback }),
    ];
    assert_eq!(asked, expected);
    // The slider also responds to keys.
    hand.act("timeline", Action::Focus, None);
    hand.0.key_press(Key::ArrowRight);
    hand.0.run_steps(2);
    let asked = std::mem::take(&mut hand.0.state_mut().commands);
    assert!(matches!(asked.as_slice(), [Command::Time(time)] if *time > 0.0), "{asked:?}");
    // The slider follows the running time.
    (hand.0.state_mut().status.time, hand.0.state_mut().status.paused) = (Some(7.25), false);
    hand.0.run_steps(2);
    assert_eq!(hand.0.get_by_label("timeline").accesskit_node().numeric_value(), Some(7.25));
    hand.picture("timeline");
}

#[test]
fn the_view_menu_has_sides_and_saved_views() {
    let folder = tempfile::tempdir().unwrap();
    let mut hand = Hand::new(preset("fur").unwrap());
    let cache = Some(folder.path().to_path_buf());
    hand.0.state_mut().panels.remember(Vec::new(), cache.clone());
    hand.click("Camera");
    hand.0.run_steps(30); // it opens smoothly
    let turned = [0.1, 0.2, 0.3, 0.927_361_85];
    hand.model().edit("camera", |scene| scene.camera.rotation = Some(turned));
    hand.0.run_steps(2); // its controls are there now
    hand.set("camera.zoom", 3.0);
    hand.click("camera.bookmark");
    hand.click("camera.top");
    let camera = hand.scene().camera;
    assert_eq!((camera.azimuth, camera.elevation, camera.rotation), (0.0, 90.0, None));
    hand.click("camera.right");
    assert_eq!((hand.scene().camera.azimuth, hand.scene().camera.elevation), (90.0, 0.0));
    hand.click("camera.bookmark");
    hand.set("camera.time", 3.0);
    hand.set("camera.zoom", 5.0);
    hand.click("view 1");
    let camera = hand.scene().camera;
    assert_eq!((camera.rotation, camera.zoom, camera.time), (Some(turned), 3.0, 3.0), "a view has no time");
    hand.picture("views");
    hand.click("camera.level");
    assert_eq!(hand.0.state().commands, [Command::LevelOrbit]);
    // The next window has the bookmarks.
    let mut next = Hand::new(preset("lit").unwrap());
    next.0.state_mut().panels.remember(Vec::new(), cache);
    next.click("Camera");
    next.0.run_steps(30);
    next.click("view 2");
    assert_eq!(next.scene().camera.azimuth, 90.0);
    next.click("forget view 1");
    next.click("view 1");
    assert_eq!(next.scene().camera.azimuth, 90.0);
    assert!(next.0.query_by_label("view 2").is_none());
}

#[test]
fn keyframes_are_set_beside_controls_and_edited_on_their_track() {
    const FURY: &str = "parameters.fury";
    let mut hand = Hand::new(preset("fire").unwrap());
    let keys = |hand: &mut Hand| match hand.scene().animation.tracks.get(FURY) {
        Some(Track::Keys(keys)) => {
            keys.iter().map(|key| (key.time, key.value.as_float().unwrap(), key.ease)).collect::<Vec<_>>()
        }
        other => panic!("{other:?}"),
    };
    hand.click("timeline keyframes");
    hand.click(&format!("{FURY}.keyframe"));
    assert_eq!(keys(&mut hand), [(0.0, 1.5, Ease::Linear)], "the value of the module");
    hand.model().edit("camera.time", |scene| scene.camera.time = 4.0);
    hand.0.run_steps(2);
    hand.set(FURY, 3.5);
    assert_eq!(keys(&mut hand), [(0.0, 1.5, Ease::Linear), (4.0, 3.5, Ease::Linear)], "a new value is a keyframe");
    hand.model().edit("camera.time", |scene| scene.camera.time = 1.0);
    hand.0.run_steps(2);
    assert_eq!(hand.0.get_by_label(FURY).accesskit_node().numeric_value(), Some(2.0), "between them");
    assert_eq!(keys(&mut hand).len(), 2);
    hand.picture("keyframes");
    // The second is dragged a quarter of the timeline to the right, but not over the end of its neighbors.
    let (lane, key) = (hand.rect(&format!("{FURY} track")), hand.rect(&format!("{FURY} key 2")).center());
    hand.drag(key, key + egui::vec2(0.25 * (lane.width() - 10.0), 0.0));
    assert!((keys(&mut hand)[1].0 - 6.5).abs() < 0.021, "{:?}", keys(&mut hand));
    // Its menu.
    let menu = |hand: &mut Hand, name: &str, entry: &str| {
        let pos = hand.rect(name).center();
        for pressed in [true, false] {
            let (button, modifiers) = (egui::PointerButton::Secondary, egui::Modifiers::NONE);
            hand.0.event(egui::Event::PointerMoved(pos));
            hand.0.event(egui::Event::PointerButton { pos, button, pressed, modifiers });
            hand.0.run_steps(2);
        }
        hand.click(entry);
        hand.0.run_steps(2);
    };
    let (first, second) = (format!("{FURY} key 1"), format!("{FURY} key 2"));
    menu(&mut hand, &first, "keyframe smooth");
    assert_eq!(keys(&mut hand)[0].2, Ease::Smooth);
    menu(&mut hand, &first, "keyframe copy");
    menu(&mut hand, &format!("{FURY} track"), "keyframe paste");
    assert_eq!(keys(&mut hand)[1], (1.0, 1.5, Ease::Smooth), "at the present time");
    hand.click(&second);
    hand.0.key_press(Key::Delete);
    hand.0.run_steps(2);
    assert_eq!(keys(&mut hand).len(), 2);
    hand.click("undo");
    assert_eq!(keys(&mut hand).len(), 3);
    // An expression in place of keyframes.
    hand.click(&format!("{FURY}.express"));
    hand.write(&format!("{FURY}.expression"), "2 + sin(time)");
    assert_eq!(hand.scene().animation.tracks[FURY], Track::Expressions(vec!["2 + sin(time)".into()]));
    hand.write(&format!("{FURY}.expression"), "2 + sin(tme)");
    assert!(hand.model().message().unwrap().contains("`tme` is unknown"));
    hand.click(&format!("{FURY}.drop"));
    assert!(hand.scene().animation.is_empty());
}

#[test]
fn bookmarks_become_a_path_and_a_loop_the_range_of_the_timeline() {
    let folder = tempfile::tempdir().unwrap();
    let mut hand = Hand::new(preset("lit").unwrap());
    hand.0.state_mut().panels.remember(Vec::new(), Some(folder.path().to_path_buf()));
    hand.click("Camera");
    hand.0.run_steps(30);
    for side in ["front", "right", "back"] {
        hand.click(&format!("camera.{side}"));
        hand.click("camera.bookmark");
    }
    hand.click("animation.has_loop");
    assert_eq!(hand.0.state().commands, [Command::Playback(Playback { repeats: true, ..Playback::default() })]);
    hand.click("camera.path");
    let mut scene = hand.scene();
    assert_eq!(scene.animation.period, Some(10.0), "the range of the timeline");
    for (time, azimuth) in [(0.0, 0.0f32), (10.0 / 3.0, 90.0), (20.0 / 3.0, 180.0), (10.0, 0.0)] {
        scene.camera.time = time;
        let expected = Camera { azimuth, elevation: 0.0, rotation: None, ..Camera::default() }.turn();
        let found = scene.moment().unwrap().camera.turn();
        assert!(found.dot(expected).abs() > 0.9999, "{time} s: {found} for {expected}");
    }
}

#[test]
fn a_new_track_moves_no_control_and_keys_stand_below_the_handle() {
    let mut hand = Hand::new(preset("fire").unwrap());
    hand.0.set_size(egui::vec2(1280.0, 800.0));
    hand.click("timeline keyframes");
    hand.0.run_steps(3);
    let names = ["timeline loop", "timeline", "timeline to", "undo"];
    let places = |hand: &Hand| (names.map(|name| hand.rect(name)), hand.0.state().left);
    let before = places(&hand);
    let parameters: Vec<String> = hand.model().parameters(None).iter().map(|(own, _)| own.name.clone()).collect();
    assert!(parameters.len() >= 4, "{parameters:?}");
    for (index, name) in parameters.iter().enumerate() {
        hand.model().look(|camera| camera.time = 2.0 * index as f64);
        hand.0.run_steps(1);
        hand.click(&format!("parameters.{name}.keyframe"));
        assert_eq!(places(&hand), before, "{name}");
    }
    // The handle at the time of a keyframe is above it: a press there moves the handle nowhere.
    let key = hand.rect(&format!("parameters.{} key 1", parameters[1])).center();
    let slider = hand.rect("timeline");
    hand.0.state_mut().commands.clear();
    hand.drag(egui::pos2(key.x, slider.center().y), egui::pos2(key.x, slider.center().y));
    let asked = &hand.0.state().commands;
    let times = asked.iter().filter_map(|command| if let Command::Time(time) = command { Some(*time) } else { None });
    let times: Vec<f64> = times.collect();
    assert!(!times.is_empty() && times.iter().all(|time| (time - 2.0).abs() < 0.02), "{asked:?}");
    hand.picture("axis");
}
