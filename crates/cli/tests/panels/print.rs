//! Prints from the dialog for final pictures.

use super::Hand;
use egui_kittest::kittest::{NodeT, Queryable};
use hypertexture::scene::preset;
use hypertexture_viewer::input::Command;
use hypertexture_viewer::panels::Question;
use std::thread::sleep;
use std::time::{Duration, Instant};

fn says(hand: &Hand, part: &'static str) -> bool {
    hand.0.query_all_by(move |node| node.value().is_some_and(|text| text.contains(part))).next().is_some()
}

#[test]
fn a_written_print_tells_its_facts_and_is_looked_at() {
    let folder = tempfile::tempdir().unwrap();
    let mut scene = preset("lit").unwrap();
    scene.object.input = "sphere".into();
    let mut hand = Hand::new(scene);
    hand.click("final");
    hand.click("final.print");
    assert_eq!(hand.0.get_by_label("final.scale_to").accesskit_node().numeric_value(), Some(60.0));
    hand.write("final.file", folder.path().join("a.3mf").to_str().unwrap());
    hand.set("final.scale_to", 20.0);
    hand.set("final.tolerance", 0.5);
    hand.click("final.render");
    let start = Instant::now();
    while hand.0.query_by_label("final.stop").is_some() {
        assert!(start.elapsed() < Duration::from_secs(600)); // a test that fails ends
        sleep(Duration::from_millis(20));
        hand.0.run_steps(1);
    }
    hand.0.run_steps(2);
    hand.picture("print");
    for part in ["within 0.5 mm of ", " triangles of ", " cm3, by `scale to`", "thinnest ", " of the area hangs over "]
    {
        assert!(says(&hand, part), "{part}");
    }
    hand.click("final.look");
    hand.0.state_mut().panels.ask(Question::Look);
    hand.0.run_steps(2);
    hand.click("ask.yes");
    assert_eq!(hand.0.state().commands, [Command::AskToLook, Command::Look]);
    hand.click("final.mesh");
    assert!(!says(&hand, "within 0.5 mm of "));
}
