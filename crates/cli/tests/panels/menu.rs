//! The menu of a control.

use super::Hand;
use egui::accesskit::{Action, ActionRequest};
use egui::{Event, Key, Modifiers, OutputCommand, PointerButton, ViewportCommand};
use egui_kittest::kittest::{NodeT, Queryable};
use hypertexture::scene::{ParameterValue, Track, preset};

const FURY: &str = "parameters.fury";

fn has(hand: &Hand, name: &str) -> bool {
    hand.0.query_by_label(name).is_some()
}

/// Opens the menu of a control by the right button.
fn open(hand: &mut Hand, name: &str) {
    let (pos, modifiers) = (hand.rect(name).center(), Modifiers::NONE);
    for pressed in [true, false] {
        hand.0.event(Event::PointerMoved(pos));
        hand.0.event(Event::PointerButton { pos, button: PointerButton::Secondary, pressed, modifiers });
        hand.0.run_steps(2);
    }
}

/// Chooses an item of the menu of a control; returns the copied text.
pub(super) fn choose(hand: &mut Hand, name: &str, item: &str) -> Option<String> {
    open(hand, name);
    let commands = hand.click(&format!("{name} {item}"));
    hand.0.run_steps(2);
    commands.into_iter().find_map(|command| match command {
        OutputCommand::CopyText(text) => Some(text),
        _ => None,
    })
}

fn paste(hand: &mut Hand, name: &str, text: &str) {
    open(hand, name);
    let (target_node, target_tree) = hand.0.get_by_label(&format!("{name} paste")).accesskit_node().locate();
    let request = ActionRequest { action: Action::Click, target_node, target_tree, data: None };
    hand.0.event(Event::AccessKitActionRequest(request));
    hand.0.run_steps(1);
    let asks = |hand: &Hand| {
        let mut commands = hand.0.output().viewport_output.values().flat_map(|viewport| &viewport.commands);
        commands.any(|command| *command == ViewportCommand::RequestPaste)
    };
    assert!(asks(hand), "the window is asked for the clipboard");
    hand.0.event(Event::Paste(text.into()));
    hand.0.run_steps(3);
}

#[test]
fn the_context_menu_copies_pastes_resets_and_animates() {
    let mut hand = Hand::new(preset("fire").unwrap());
    let fury = |hand: &Hand| hand.scene().parameters.get("fury").cloned();
    open(&mut hand, FURY);
    assert_eq!(fury(&hand), preset("fire").unwrap().parameters.get("fury").cloned(), "the right button drags nothing");
    hand.picture("menu");
    hand.0.key_press(Key::Escape);
    hand.0.run_steps(2);
    assert!(!has(&hand, &format!("{FURY} copy")));
    assert_eq!(choose(&mut hand, FURY, "copy").as_deref(), Some("1.5"));
    hand.set(FURY, 3.0);
    assert_eq!(choose(&mut hand, FURY, "flag").as_deref(), Some("--set fury=3"));
    paste(&mut hand, FURY, " 2.25\n");
    assert_eq!(fury(&hand), Some(ParameterValue::Number(2.25)));
    for (text, said) in [("many", "parameters.fury"), (" \n", "the clipboard holds no text")] {
        paste(&mut hand, FURY, text);
        assert_eq!(fury(&hand), Some(ParameterValue::Number(2.25)), "{text}");
        let message = hand.model().message().unwrap().to_string();
        assert!(message.contains(said) && !message.contains('\n'), "{message}");
    }
    choose(&mut hand, FURY, "reset");
    assert_eq!(fury(&hand), Some(ParameterValue::Number(1.5)));
    choose(&mut hand, FURY, "animate");
    let keys = |hand: &Hand| hand.scene().animation.tracks.get(FURY).cloned();
    let Some(Track::Keys(all)) = keys(&hand) else { panic!("no keyframe") };
    assert_eq!((all.len(), all[0].time, all[0].value.as_float()), (1, 0.0, Some(1.5)));
    assert!(has(&hand, &format!("{FURY}.keyframe")), "the tracks are shown");
    choose(&mut hand, FURY, "keyframe remove");
    assert_eq!(keys(&hand), None);
}

#[test]
fn settings_of_every_kind_have_the_menu_and_keys_open_it() {
    let mut scene = preset("fire").unwrap();
    scene.parts.insert("b".into(), Default::default());
    let mut hand = Hand::advanced(scene);
    ["Presets", "Effect", "Parameters", "Light and background", "Objects", "Material", "Accuracy", "object b"]
        .iter()
        .for_each(|name| drop(hand.click(name)));
    hand.0.run_steps(30); // sections open smoothly
    let at = "parts.b.transform.at";
    let item = |hand: &mut Hand, control: &str, name: &str, item: &str| {
        open(hand, control);
        let commands = hand.click(&format!("{name} {item}"));
        hand.0.run_steps(2);
        match commands.first() {
            Some(OutputCommand::CopyText(text)) => text.clone(),
            _ => String::new(),
        }
    };
    hand.set(&format!("{at}.y"), 0.1);
    assert_eq!(item(&mut hand, &format!("{at}.x"), at, "copy"), "[0.0, 0.1, 0.0]");
    assert_eq!(item(&mut hand, &format!("{at}.x"), at, "flag"), "--set 'parts.b.transform.at=[0.0, 0.1, 0.0]'");
    item(&mut hand, &format!("{at}.z"), at, "reset");
    assert_eq!(hand.scene().parts["b"].transform.at, [0.0; 3]);
    assert_eq!(item(&mut hand, "boolean", "boolean", "copy"), "\"algebraic\"");
    assert!(hand.0.query_by_label("boolean animate").is_none());
    // By the keyboard, the focus goes to the first item and back to the control.
    let focused = |hand: &Hand| {
        let node = hand.0.query_all_by(|node| node.is_focused()).next();
        node.and_then(|node| node.accesskit_node().label()).unwrap_or_default()
    };
    hand.act("light.intensity", Action::Focus, None);
    hand.0.key_press_modifiers(Modifiers::SHIFT, Key::F10);
    hand.0.run_steps(3);
    assert_eq!(focused(&hand), "light.intensity copy");
    hand.0.key_press(Key::Tab);
    hand.0.run_steps(2);
    assert_eq!(focused(&hand), "light.intensity paste");
    hand.0.key_press(Key::Escape);
    hand.0.run_steps(3);
    assert_eq!(focused(&hand), "light.intensity");
}
