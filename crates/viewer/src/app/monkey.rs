//! A monkey that types into every field, and objects under other names.

use super::hand::{Hand, act, agrees, open, scene, window};
use egui::accesskit::{Action, Role};
use egui::{Event, Key, Modifiers};
use egui_kittest::kittest::{NodeT, Queryable};
use hypertexture_support::random::SplitMix;
use std::collections::BTreeSet;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// Texts of names, numbers, formulas and nonsense.
const TEXTS: [&str; 16] = [
    "b", "c", "zz9", "a1", "main", "B 2", "", "-1", "0.3", "1e9", "main - b", "c & main", "torus", "sphere", "#ff8800",
    "é; time",
];
/// Fields that are typed into by one monkey.
const STEPS: usize = 20;
/// Fields of paths, whose files the monkey leaves alone.
const PATHS: [&str; 3] = ["file.", "author.", "final."];

fn names(hand: &Hand, role: Role) -> Vec<String> {
    let nodes = hand.query_all_by(move |node| node.role() == role);
    let mut names: Vec<String> = nodes.filter_map(|node| node.accesskit_node().label()).collect();
    names.retain(|name| !PATHS.iter().any(|path| name.starts_with(path)) && !name.is_empty());
    names
}

fn write(hand: &mut Hand, role: Role, name: &str, text: &str, end: Key) {
    assert!(act(hand, Some(role), name, Action::Focus), "{role:?} {name}");
    // Each event is a frame: this one is without those of the modifiers.
    let (key, modifiers) = (Key::A, Modifiers::COMMAND);
    hand.event(Event::Key { key, physical_key: None, pressed: true, repeat: false, modifiers });
    hand.event(Event::Text(text.into()));
    hand.key_press(end);
    hand.run_steps(2);
    agrees(hand.state());
}

#[test]
fn a_renamed_object_goes_on_while_it_loads_and_after() {
    let mut hand = window(scene());
    hand.run_steps(3);
    let start = Instant::now();
    while hand.state().jobs.submitted.is_none() {
        assert!(start.elapsed() < Duration::from_secs(600)); // a test that fails ends
        sleep(Duration::from_millis(5));
        hand.run_steps(1);
    }
    for (from, to) in [("b", "bite"), ("c", "a"), ("bite", "zz"), ("a", "b"), ("zz", "c")] {
        assert!(hand.state_mut().document.model.rename_part(from, to), "{:?}", hand.state().document.model.message());
        hand.run_steps(2);
        agrees(hand.state());
        assert!(!hand.state().jobs.lacks_object, "nothing loads for a name");
    }
    // A used name is refused; removal, a copy and undo keep objects and names together.
    assert!(
        !hand.state_mut().document.model.rename_part("b", "c")
            && !hand.state_mut().document.model.rename_part("b", "main")
    );
    hand.state_mut().document.model.remove_part("b");
    hand.run_steps(2);
    assert_eq!(hand.state_mut().document.model.duplicate_part(Some("c")).as_deref(), Some("object1"));
    hand.run_steps(2);
    agrees(hand.state());
    for _ in 0..9 {
        hand.state_mut().document.model.undo();
        hand.run_steps(2);
        agrees(hand.state());
    }
}

#[test]
fn a_monkey_types_into_every_field() {
    // The fields that it has typed into.
    let mut typed = BTreeSet::new();
    for seed in 0..2 {
        let mut random = SplitMix(seed);
        let mut hand = window(scene());
        open(&mut hand);
        assert!(act(&mut hand, Some(Role::Button), "object b", Action::Click));
        write(&mut hand, Role::TextInput, "name of b", "bite", Key::Enter);
        assert!(
            hand.state().document.model.scene().parts.contains_key("bite"),
            "{:?}",
            hand.state().document.model.message()
        );
        for _ in 0..STEPS {
            let mut pick = |count: usize| (random.unit() * count as f64) as usize % count.max(1);
            let objects: Vec<String> =
                names(&hand, Role::Button).into_iter().filter(|name| name.starts_with("object ")).collect();
            if !objects.is_empty() && pick(3) == 0 {
                let object = &objects[pick(objects.len())];
                act(&mut hand, Some(Role::Button), object, Action::Click);
            }
            let role = [Role::TextInput, Role::TextInput, Role::SpinButton][pick(3)];
            let fields = names(&hand, role);
            assert!(!fields.is_empty(), "no {role:?}");
            let name = fields[pick(fields.len())].clone();
            let (text, end) = (TEXTS[pick(TEXTS.len())], [Key::Enter, Key::Tab][pick(2)]);
            write(&mut hand, role, &name, text, end);
            typed.insert(name);
            match pick(12) {
                0 => drop(hand.state_mut().document.model.undo()),
                1 => drop(hand.state_mut().document.model.redo()),
                2 => drop(act(&mut hand, Some(Role::Button), "add object", Action::Click)),
                3 => drop(act(&mut hand, Some(Role::Button), "remove object", Action::Click)),
                _ => {}
            }
            hand.run_steps(1);
            agrees(hand.state());
        }
        hand.state().document.model.scene().check(hand.state().document.model.library()).unwrap();
    }
    assert!(typed.len() > STEPS / 2, "{typed:?}");
}
