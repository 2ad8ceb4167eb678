//! The GLSL editor: completion, search, and errors at their lines.

use super::Hand;
use egui::accesskit::{Action, ActionRequest, Role};
use egui::{Event, Id, Key, Modifiers, Rect, Shape, TextEdit};
use egui_kittest::kittest::{NodeT, Queryable};
use hypertexture::scene::preset;
use hypertexture_viewer::document::author::State;
use std::thread::sleep;
use std::time::{Duration, Instant};

fn editor() -> Hand {
    let mut hand = Hand::new(preset("fur").unwrap());
    hand.click("author");
    hand
}

fn text(hand: &mut Hand) -> String {
    hand.0.state_mut().document.author.text.clone()
}

fn write(hand: &mut Hand, letters: &str) {
    for letter in letters.chars() {
        hand.0.event(Event::Text(letter.into()));
        hand.0.run_steps(1);
    }
}

fn at_end(hand: &mut Hand) {
    hand.act("author.text", Action::Focus, None);
    hand.0.key_press_modifiers(Modifiers::COMMAND, Key::End);
    hand.0.run_steps(1);
}

/// Whether the completion list has a word.
fn offers(hand: &Hand, word: &str) -> bool {
    hand.0.query_all_by_label(word).any(|node| node.accesskit_node().role() == Role::Button)
}

/// Whether there is a label of this text.
fn says(hand: &Hand, text: &str) -> bool {
    hand.0.query_all_by_value(text).next().is_some()
}

/// Waits until the compiler has refused the text.
fn wait_for_faults(hand: &mut Hand) {
    let start = Instant::now();
    while !matches!(hand.0.state_mut().document.author.state(), State::Bad(_)) {
        assert!(start.elapsed() < Duration::from_secs(1800)); // a test that fails ends
        hand.0.run_steps(1);
        sleep(Duration::from_millis(10));
    }
    hand.0.run_steps(2);
}

/// The painted texts with their rectangles and clip rectangles.
fn painted(hand: &Hand) -> Vec<(String, Rect, Rect)> {
    let shapes = hand.0.output().shapes.iter();
    let texts = shapes.filter_map(|clipped| match &clipped.shape {
        Shape::Text(text) => Some((text.galley.text().to_string(), text.visual_bounding_rect(), clipped.clip_rect)),
        _ => None,
    });
    texts.collect()
}

#[test]
fn words_are_completed_by_keys_and_nothing_else_is_changed() {
    let mut hand = editor();
    at_end(&mut hand);
    let before = text(&mut hand);
    write(&mut hand, "float q = smooths");
    assert!(offers(&hand, "smoothstep"), "a function of GLSL");
    hand.picture("completion");
    hand.0.key_press(Key::Tab);
    hand.0.run_steps(2);
    write(&mut hand, "(0.0, fine");
    assert!(offers(&hand, "fineness"), "a parameter of the module");
    hand.0.key_press(Key::Tab);
    hand.0.run_steps(2);
    write(&mut hand, ", 1.0);");
    assert_eq!(text(&mut hand), format!("{before}float q = smoothstep(0.0, fineness, 1.0);"));
    // An explicitly opened list owns the arrow keys and Enter; Escape closes it, and the text keeps the focus.
    write(&mut hand, " m");
    assert!(!offers(&hand, "max"));
    hand.0.key_press_modifiers(Modifiers::COMMAND, Key::Space);
    hand.0.run_steps(2);
    assert!(offers(&hand, "max") && offers(&hand, "min"));
    hand.0.key_press(Key::Escape);
    hand.0.run_steps(2);
    assert!(!offers(&hand, "max"));
    hand.0.key_press_modifiers(Modifiers::COMMAND, Key::Space);
    hand.0.run_steps(2);
    hand.0.key_press(Key::ArrowDown);
    hand.0.run_steps(1);
    hand.0.key_press(Key::Enter);
    hand.0.run_steps(2);
    assert!(text(&mut hand).ends_with(", 1.0); min"), "{}", text(&mut hand));
    // Without a list, Enter inserts a line.
    hand.0.key_press(Key::Enter);
    hand.0.run_steps(2);
    assert!(text(&mut hand).ends_with(", 1.0); min\n"));
    assert_eq!(hand.0.state().commands, [], "no letter was a shortcut");
}

#[test]
fn a_word_is_found_one_place_after_another() {
    let mut hand = editor();
    let whole = text(&mut hand);
    let count = whole.to_lowercase().matches("noise").count();
    hand.0.key_press_modifiers(Modifiers::COMMAND, Key::F);
    hand.0.run_steps(2);
    write(&mut hand, "noise");
    hand.0.run_steps(2);
    // The search field has the focus; the cursor of the text is behind the match.
    let found = |hand: &Hand| {
        let range = TextEdit::load_state(&hand.0.ctx, Id::new("author.text")).unwrap().cursor.char_range().unwrap();
        usize::from(range.primary.index)
    };
    let is_match = |end: usize| whole[..end].to_lowercase().ends_with("noise");
    assert!(says(&hand, &format!("1 of {count}")));
    let first = found(&hand);
    assert!(is_match(first));
    hand.0.key_press(Key::Enter);
    hand.0.run_steps(3);
    assert!(says(&hand, &format!("2 of {count}")));
    let second = found(&hand);
    assert!(second > first && is_match(second));
    hand.click("author.find.previous");
    hand.click("author.find.previous");
    assert!(says(&hand, &format!("{count} of {count}")));
    assert!(found(&hand) > second && is_match(found(&hand)));
    hand.picture("find");
    assert_eq!(text(&mut hand), whole);
}

#[test]
fn errors_stand_at_their_line_and_the_text_stays() {
    let mut hand = editor();
    let place = hand.rect("author.text");
    at_end(&mut hand);
    let long = "a".repeat(160);
    write(&mut hand, &format!("float {long} = tangled;"));
    wait_for_faults(&mut hand);
    assert_eq!(hand.rect("author.text").top(), place.top());
    // The line is wider than the panel, and its error is still visible.
    let (message, rect, clip) = painted(&hand).into_iter().find(|(text, ..)| text.starts_with('◀')).unwrap();
    assert!(message.contains("tangled"), "{message}");
    assert!(rect.left() >= clip.left() && rect.right() <= clip.right(), "{rect:?} in {clip:?}");
    // The text scrolls to the cursor; the line numbers do not scroll sideways.
    let number = |hand: &Hand, text: &str| painted(hand).into_iter().find(|(found, ..)| found == text).unwrap();
    let (_, seven, clip) = number(&hand, "7");
    assert!(seven.left() >= clip.left() && seven.right() < clip.left() + 45.0, "{seven:?} in {clip:?}");
    // It covers no code: neither that of its own line nor that of another one.
    let codes = painted(&hand).into_iter().filter(|(text, ..)| text.contains(&long));
    let galleys: Vec<Rect> = codes.map(|(_, rect, _)| rect).collect();
    assert!(!galleys.is_empty(), "the text is painted");
    assert!(galleys.iter().all(|code| rect.bottom() <= code.bottom() + 1.0), "the row below the last line is its own");
    hand.picture("wrong_line");
    // A wrapped line has one number.
    let row = hand.rect("author.text").height();
    hand.click("author.wrap");
    hand.0.run_steps(3);
    assert!(hand.rect("author.text").height() > row + 8.0 && hand.rect("author.text").width() <= 520.0);
    let lines = text(&mut hand).lines().count();
    number(&hand, &lines.to_string());
    assert!(painted(&hand).iter().all(|(text, ..)| *text != (lines + 1).to_string()));
    hand.picture("wrapped");
}

#[test]
fn a_click_on_a_fault_leads_to_its_line() {
    let mut hand = editor();
    let above = "\n".repeat(200);
    at_end(&mut hand);
    hand.0.event(Event::Text(format!("{above}float x = tangled;")));
    hand.0.run_steps(2);
    hand.0.key_press_modifiers(Modifiers::COMMAND, Key::Home);
    hand.0.run_steps(60); // it scrolls smoothly
    wait_for_faults(&mut hand);
    let State::Bad(faults) = hand.0.state_mut().document.author.state().clone() else { panic!("good") };
    let (path, line) = faults[0].at.clone().unwrap();
    let (target, tree) = {
        let shown = format!("{path}:{line}: {}", faults[0].text);
        let label = hand.0.query_all_by_value(&shown).next().unwrap();
        label.accesskit_node().locate()
    };
    let request = ActionRequest { action: Action::Click, target_node: target, target_tree: tree, data: None };
    hand.0.event(Event::AccessKitActionRequest(request));
    hand.0.run_steps(60);
    let (_, rect, clip) = painted(&hand).into_iter().find(|(text, ..)| text.starts_with('◀')).unwrap();
    assert!(clip.contains(rect.center()), "{rect:?} in {clip:?}");
}

#[test]
fn the_error_of_a_long_line_does_not_cover_the_next_one() {
    let mut hand = editor();
    at_end(&mut hand);
    let (long, next) = ("b".repeat(160), "float unharmed = 1.0;");
    hand.0.event(Event::Text(format!("\nfloat {long} = tangled;\n{next}\n")));
    hand.0.run_steps(2);
    hand.0.key_press(Key::ArrowUp);
    hand.0.key_press(Key::ArrowUp);
    hand.0.run_steps(2);
    wait_for_faults(&mut hand);
    // Rows of the text, of which the last but one is the next line.
    let rows = hand.0.output().shapes.iter().find_map(|clipped| match &clipped.shape {
        Shape::Text(text) if text.galley.text().contains(&long) => {
            let rect = |index: usize| text.galley.rows[index].rect().translate(text.pos.to_vec2());
            let count = text.galley.rows.len();
            Some([rect(count - 3), rect(count - 2)])
        }
        _ => None,
    });
    let [own, next] = rows.unwrap();
    let (_, error, _) = painted(&hand).into_iter().find(|(text, ..)| text.starts_with('◀')).unwrap();
    assert!(error.bottom() <= next.top() + 1.0 && error.top() >= own.top() + 12.0, "{error:?} {own:?} {next:?}");
}
