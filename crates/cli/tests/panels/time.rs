//! The timeline, and the bookmarks of the camera.

use super::Hand;
use egui::Key;
use egui::accesskit::Action;
use egui_kittest::kittest::{NodeT, Queryable};
use hypertexture::scene::preset;
use viewer::panels::Request;
use viewer::playback::Playback;

#[test]
fn the_timeline_plays_scrubs_and_repeats_by_mouse_and_keys() {
    let mut hand = Hand::new(preset("fire").unwrap());
    hand.click("timeline play");
    hand.set("timeline", 2.5);
    hand.click("timeline start");
    hand.click("timeline loop");
    hand.set("timeline speed", 0.5);
    hand.set("timeline to", 4.0);
    let asked = std::mem::take(&mut hand.0.state_mut().requests);
    let playback = Playback::default();
    let expected = [
        Request::Pause(true),
        Request::Time(2.5),
        Request::Time(0.0),
        Request::Playback(Playback { repeats: true, ..playback }),
        Request::Playback(Playback { speed: 0.5, ..playback }),
        Request::Playback(Playback { range: [0.0, 4.0], ..playback }),
    ];
    assert_eq!(asked, expected);
    // The slider also responds to keys.
    hand.act("timeline", Action::Focus, None);
    hand.0.key_press(Key::ArrowRight);
    hand.0.run_steps(2);
    let asked = std::mem::take(&mut hand.0.state_mut().requests);
    assert!(matches!(asked.as_slice(), [Request::Time(time)] if *time > 0.0), "{asked:?}");
    // The slider follows the running time.
    (hand.0.state_mut().status.time, hand.0.state_mut().status.paused) = (Some(7.25), false);
    hand.0.run_steps(2);
    assert_eq!(hand.0.get_by_label("timeline").accesskit_node().numeric_value(), Some(7.25));
    hand.picture("timeline");
}

#[test]
fn the_object_is_looked_at_from_its_sides_and_from_views_that_were_kept() {
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
    assert_eq!(hand.0.state().requests, [Request::Level(true)]);
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
