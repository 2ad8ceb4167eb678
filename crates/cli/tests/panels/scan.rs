//! The panel of file information.

use super::Hand;
use egui_kittest::kittest::Queryable;
use hypertexture::scene::preset;
use hypertexture::shape::Facts;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// A file is read when its panel is open, and a click applies a proposed iso-value.
#[test]
fn what_a_scan_holds_is_shown_and_its_iso_values_are_offered() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("ball.nrrd");
    let size = 24u32;
    let value = |index: u32| {
        let [x, y, z] = [index % size, index / size % size, index / size / size].map(|n| n as f32 - 11.5);
        100.0 * (8.0 - (x * x + y * y + z * z).sqrt()).clamp(-1.0, 1.0) + 100.0
    };
    let header = "NRRD0004\ntype: float\ndimension: 3\nsizes: 24 24 24\nencoding: raw\nendian: little\n\n";
    let values = (0..size * size * size).flat_map(|index| value(index).to_le_bytes());
    std::fs::write(&path, header.bytes().chain(values).collect::<Vec<u8>>()).unwrap();
    let mut scene = preset("lit").unwrap();
    scene.object.input = path.to_str().unwrap().into();

    let told = Facts::of(&scene.object.input, None).unwrap();
    let [iso] = told.iso_values[..] else { panic!("one boundary: {:?}", told.iso_values) };
    assert!((50.0..150.0).contains(&iso), "{iso}");
    let mut hand = Hand::advanced(scene);
    hand.click("Contents");
    let offered = format!("object.iso={iso}");
    let start = Instant::now();
    while hand.0.query_by_label(&offered).is_none() {
        assert!(start.elapsed() < Duration::from_secs(600)); // a test that fails ends
        sleep(Duration::from_millis(10));
        hand.0.run_steps(2);
    }
    hand.0.get_by_label("object.histogram");
    hand.0.get_by_label("24 x 24 x 24, spacing 1 x 1 x 1");
    hand.click(&offered);
    hand.picture("scan");
    assert_eq!(hand.scene().object.iso, Some(iso));

    // A drag in the histogram sets the value under the pointer, as one step.
    let (range, rect) = (told.histogram.as_ref().unwrap().range, hand.rect("object.histogram"));
    let at = |part: f32| egui::pos2(egui::lerp(rect.x_range(), part), rect.center().y);
    hand.drag(at(0.9), at(0.3));
    let dragged = hand.scene().object.iso.unwrap();
    let expected = egui::lerp(range.0..=range.1, 0.3);
    assert!((dragged - expected).abs() < 2e-3 * (range.1 - range.0), "{dragged} for {expected}");
    hand.act("object.histogram", egui::accesskit::Action::Focus, None);
    hand.0.key_press(egui::Key::ArrowRight);
    hand.0.run_steps(2);
    assert!(hand.scene().object.iso.unwrap() > dragged, "a step to the right");
    hand.click("undo");
    hand.click("undo");
    assert_eq!(hand.scene().object.iso, Some(iso));

    // Another object has another file; a read error is shown.
    hand.model().edit("object.input", |scene| scene.object.input = "nowhere.obj".into());
    hand.0.run_steps(2);
    assert!(hand.0.query_by_label("object.histogram").is_none());
    let start = Instant::now();
    while hand.0.query_by_label_contains("nowhere.obj: ").is_none() {
        assert!(start.elapsed() < Duration::from_secs(600));
        sleep(Duration::from_millis(10));
        hand.0.run_steps(2);
    }
}
