//! Protection of unsaved work and of files of other programs.

use super::Hand;
use egui::{Event, Key};
use egui_kittest::kittest::Queryable;
use hypertexture::scene::preset;
use hypertexture_viewer::document::author::{State, WATCH};
use hypertexture_viewer::input::Command;
use std::fs;
use std::path::PathBuf;
use std::thread::sleep;
use std::time::{Duration, Instant};

/// The editor keeps the focus while errors appear and disappear around it.
#[test]
fn a_long_broken_text_is_typed_whole_while_errors_come_and_go() {
    let mut hand = Hand::new(preset("fur").unwrap());
    hand.click("author");
    hand.act("author.text", egui::accesskit::Action::Focus, None);
    hand.0.key_press_modifiers(egui::Modifiers::COMMAND, Key::End);
    hand.0.run_steps(1);
    let before = hand.0.state_mut().document.author.text.clone();
    let typed = "\nfloat x = ; for (int i = 0; i < 9; i++) { fhsztv }\nfloat whole() { return 1.0; }\n";
    let (mut verdicts, mut told) = ([0, 0], Vec::new());
    for (index, letter) in typed.chars().enumerate() {
        match letter {
            '\n' => hand.0.key_press(Key::Enter),
            _ => hand.0.event(Event::Text(letter.into())),
        }
        hand.0.run_steps(1);
        if index % 20 == 0 {
            // Waits for the compiler, whose result changes the controls around the text.
            let start = Instant::now();
            sleep(Duration::from_millis(150));
            hand.0.run_steps(2);
            while *hand.0.state_mut().document.author.state() == State::Compiling {
                assert!(start.elapsed() < Duration::from_secs(600)); // a test that fails ends
                sleep(Duration::from_millis(10));
                hand.0.run_steps(1);
            }
            let state = hand.0.state_mut().document.author.state().clone();
            verdicts[usize::from(matches!(state, State::Bad(_)))] += 1;
            told.push(state);
        }
    }
    assert!(verdicts[0] > 0 && verdicts[1] > 0, "good and bad: {verdicts:?}, {told:?}");
    assert_eq!(hand.0.state_mut().document.author.text, format!("{before}{typed}"));
    assert_eq!(hand.0.state().commands, [], "no letter was a shortcut");
}

#[test]
fn a_file_that_others_wrote_is_replaced_once_a_person_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let [scene, picture] = ["scene.toml", "picture.png"].map(|name| folder.path().join(name));
    [&scene, &picture].into_iter().for_each(|path| fs::write(path, "of somebody else").unwrap());
    let mut hand = Hand::open(preset("fur").unwrap());
    hand.write("file.scene", scene.to_str().unwrap());
    let held = || fs::read_to_string(&scene).unwrap();
    hand.click("file.save");
    assert_eq!(held(), "of somebody else");
    hand.click("ask.no");
    assert!(hand.0.query_by_label("ask.yes").is_none() && held() == "of somebody else");
    hand.click("file.save");
    hand.picture("replace");
    hand.click("ask.yes");
    assert!(held().contains("[effect]"), "{}", held());
    // The window overwrites its own file without a question, until another program has written it.
    hand.set("material.specular", 0.75);
    hand.click("file.save");
    assert!(hand.0.query_by_label("ask.yes").is_none() && held().contains("specular = 0.75"));
    fs::write(&scene, "of somebody else").unwrap();
    hand.click("file.save");
    assert_eq!(held(), "of somebody else");
    hand.0.key_press(Key::Escape);
    hand.0.run_steps(2);
    assert!(hand.0.query_by_label("ask.yes").is_none() && held() == "of somebody else");

    hand.write("file.picture", picture.to_str().unwrap());
    hand.click("file.screenshot");
    let shots = |hand: &Hand| {
        let is_shot = |command: &&Command| matches!(command, Command::Screenshot(_));
        hand.0.state().commands.iter().filter(is_shot).count()
    };
    assert_eq!(shots(&hand), 0);
    hand.click("ask.yes");
    assert_eq!(shots(&hand), 1);
    hand.click("file.screenshot");
    assert_eq!(shots(&hand), 2, "it is the window's own now");
}

#[test]
fn a_window_with_unsaved_work_asks_before_it_closes() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    let mut hand = Hand::open(preset("fur").unwrap());
    let quits = |hand: &Hand| hand.0.state().commands.contains(&Command::Quit);
    hand.set("material.specular", 0.75);
    hand.write("file.scene", scene.to_str().unwrap());
    hand.quit();
    assert!(!quits(&hand));
    hand.picture("quit");
    hand.click("ask.no");
    assert!(!quits(&hand) && hand.0.query_by_label("ask.yes").is_none());
    hand.quit();
    hand.click("ask.save");
    assert!(quits(&hand) && fs::read_to_string(&scene).unwrap().contains("specular = 0.75"));
}

#[test]
fn drafts_are_restored_and_recent_files_remembered() {
    let folder = tempfile::tempdir().unwrap();
    let kept = folder.path().join("unsaved").join("1");
    fs::create_dir_all(kept.join("dmf")).unwrap();
    let mut scene = preset("fire").unwrap();
    scene.material.specular = 0.125;
    fs::write(kept.join("scene.toml"), hypertexture::scene::to_text(&scene)).unwrap();
    let own = "// Half.\nfloat half_of(float density, Sample s) { return 0.5 * density; }\n";
    fs::write(kept.join("dmf").join("half_of.glsl"), own).unwrap();

    let mut hand = Hand::new(preset("fur").unwrap());
    let cache: Option<PathBuf> = Some(folder.path().into());
    hand.0.state_mut().panels.remember(vec![kept.clone()], cache.clone());
    hand.0.run_steps(2);
    hand.picture("kept");
    hand.click("kept.open");
    assert_eq!(hand.scene(), scene);
    assert_eq!(hand.0.state_mut().document.author.text, own);
    assert!(hand.0.query_by_label("kept.open").is_none() && kept.join("scene.toml").exists());
    // It stays unsaved, of no file, until it is saved.
    assert!(hand.model().is_dirty() && hand.model().file().is_none());
    let saved = folder.path().join("saved.toml");
    assert!(hand.model().save(&saved));
    hand.0.run_steps(2);
    // The next window lists the file.
    let mut next = Hand::new(preset("fur").unwrap());
    next.0.state_mut().panels.remember(Vec::new(), cache);
    next.click("File");
    next.click(&format!("recent {}", saved.display()));
    assert_eq!(next.scene(), scene);
}

#[test]
fn a_text_that_no_file_holds_is_unsaved_work_too() {
    let mut hand = Hand::new(preset("fur").unwrap());
    hand.0.state_mut().document.author.text.push_str("// mine\n");
    hand.quit();
    assert_eq!(hand.0.state().commands, []);
    hand.click("ask.yes");
    assert_eq!(hand.0.state().commands, [Command::Quit]);
}

#[test]
fn a_scene_without_a_file_is_saved_where_a_name_is_given() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("scene.toml");
    let mut hand = Hand::new(preset("fur").unwrap());
    hand.model().edit("material.specular", |scene| scene.material.specular = 0.75);
    let save = |hand: &mut Hand| {
        let desk = hand.0.state_mut();
        desk.panels.perform(Command::Save, &mut desk.document);
        let asks = desk.panels.is_asking();
        hand.0.run_steps(3);
        asks
    };
    assert!(save(&mut hand) && hand.model().is_dirty());
    hand.picture("save");
    for _ in 0..2 {
        hand.0.key_press(Key::Escape); // it leaves the name, then the dialog
        hand.0.run_steps(3);
    }
    assert!(!hand.0.state().panels.is_asking() && hand.model().is_dirty() && hand.model().file().is_none());
    assert!(hand.model().save(&scene));
    hand.model().edit("material.specular", |scene| scene.material.specular = 0.25);
    assert!(!save(&mut hand) && !hand.model().is_dirty());
    assert!(fs::read_to_string(&scene).unwrap().contains("specular = 0.25"));
}

/// Runs frames until a watched file has an effect.
fn wait(hand: &mut Hand, is_there: impl Fn(&mut Hand) -> bool) {
    let start = Instant::now();
    while !is_there(hand) {
        assert!(start.elapsed() < Duration::from_secs(1800)); // a test that fails ends
        sleep(Duration::from_millis(10));
        hand.0.run_steps(1);
    }
}

#[test]
fn a_file_is_watched_with_the_editor_closed() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("half_of.glsl");
    let text =
        |part: &str| format!("// Half.\nfloat half_of(float density, Sample s) {{ return {part} * density; }}\n");
    fs::write(&file, text("0.5")).unwrap();
    let mut hand = Hand::new(preset("fur").unwrap());
    // Repaint delay without input.
    let rests = |hand: &Hand| hand.0.output().viewport_output[&egui::ViewportId::ROOT].repaint_delay;
    hand.0.run_steps(60);
    assert!(rests(&hand) > WATCH);
    let desk = hand.0.state_mut();
    desk.document.author.watch(desk.document.model.library(), &file).unwrap();
    let has =
        |text: String| move |hand: &mut Hand| hand.model().library().source("dmf/half_of.glsl") == Some(text.as_str());
    wait(&mut hand, has(text("0.5")));
    hand.0.run_steps(60);
    assert!(rests(&hand) <= WATCH, "{:?}", rests(&hand));
    fs::write(&file, text("0.25")).unwrap();
    wait(&mut hand, has(text("0.25")));
    fs::remove_file(&file).unwrap();
    let says = |hand: &mut Hand| {
        let is_it = |text: &String| text.contains("half_of.glsl was deleted");
        hand.0.query_all_by(move |node| node.value().as_ref().is_some_and(is_it)).count() == 1
    };
    wait(&mut hand, says);
    fs::write(&file, text("0.125")).unwrap();
    wait(&mut hand, has(text("0.125")));
    assert!(!says(&mut hand));
}
