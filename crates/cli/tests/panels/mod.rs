//! The panels, controlled by the accessible names of their controls, without a window.

mod edit;
mod everyone;
mod loss;
mod menu;
mod objects;
mod paint;
mod print;
mod scan;
mod time;
mod wipe;

use egui::accesskit::{Action, ActionData, ActionRequest, Role};
use egui::{Event, PointerButton, Pos2};
use egui_kittest::Harness;
use egui_kittest::kittest::{NodeT, Queryable};
use hypertexture::scene::{self, Color, ParameterValue, Pass, Scene, preset};
use hypertexture::shader;
use hypertexture_viewer::document::Document;
use hypertexture_viewer::document::author::{Author, State};
use hypertexture_viewer::document::model::Model;
use hypertexture_viewer::input::Command;
use hypertexture_viewer::panels::{Panels, Question, Status};
use paint::Painter;
use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::thread::sleep;
use std::time::{Duration, Instant};

const SIZE: [usize; 2] = [1280, 1600];
const SECTIONS: [&str; 9] =
    ["File", "Objects", "Object", "Transfer map", "Material", "Light and background", "Camera", "Accuracy", "Picture"];

/// The state of a window.
struct Desk {
    document: Document,
    panels: Panels,
    status: Status,
    commands: Vec<Command>,
    painter: Painter,
    /// The area left for the picture.
    left: egui::Rect,
}

struct Hand(Harness<'static, Desk>);

impl Hand {
    fn new(scene: Scene) -> Hand {
        let model = Model::new(scene, shader::shipped()).unwrap();
        let program = PathBuf::from(env!("CARGO_BIN_EXE_hypertexture"));
        let (document, panels) = (Document::new(model, program).unwrap(), Panels::default());
        let painter = Painter::default();
        let status = Status { device: "a device".into(), frame_ms: Some([12.0, 0.5]), ..Status::default() };
        let desk =
            Desk { document, panels, status, commands: Vec::new(), painter: painter.clone(), left: egui::Rect::ZERO };
        let size = egui::vec2(SIZE[0] as f32, SIZE[1] as f32);
        let builder = Harness::builder().with_size(size).with_step_dt(1.0 / 60.0).renderer(painter);
        let show = |ui: &mut egui::Ui, desk: &mut Desk| {
            desk.commands.extend(desk.panels.show(ui, &mut desk.document, &desk.status));
            desk.left = ui.available_rect_before_wrap();
        };
        let mut hand = Hand(builder.build_ui_state(show, desk));
        hand.0.run_steps(2);
        hand
    }

    /// Panels with advanced settings.
    fn advanced(scene: Scene) -> Hand {
        let mut hand = Hand::new(scene);
        hand.click("view.advanced");
        hand
    }

    /// Panels with all sections open.
    fn open(scene: Scene) -> Hand {
        let mut hand = Hand::advanced(scene);
        SECTIONS.iter().for_each(|section| drop(hand.click(section)));
        hand
    }

    fn model(&mut self) -> &mut Model {
        &mut self.0.state_mut().document.model
    }

    fn scene(&self) -> Scene {
        self.0.state().document.model.scene().clone()
    }

    /// Performs an action on a control; returns the panels' commands to the system.
    fn act(&mut self, name: &str, action: Action, data: Option<ActionData>) -> Vec<egui::OutputCommand> {
        let (target_node, target_tree) = self.0.get_by_label(name).accesskit_node().locate();
        self.0.event(Event::AccessKitActionRequest(ActionRequest { action, target_node, target_tree, data }));
        self.0.run_steps(1);
        let commands = self.0.output().platform_output.commands.clone();
        self.0.run_steps(1);
        commands
    }

    fn click(&mut self, name: &str) -> Vec<egui::OutputCommand> {
        self.act(name, Action::Click, None)
    }

    /// Asks to quit, as a key and a menu of the window do.
    fn quit(&mut self) {
        let Desk { document, panels, .. } = self.0.state_mut();
        if document.at_stake().is_some() {
            panels.ask(Question::Quit);
        }
        self.0.run_steps(2);
    }

    fn set(&mut self, name: &str, value: f64) {
        self.act(name, Action::SetValue, Some(ActionData::NumericValue(value)));
    }

    fn write(&mut self, name: &str, text: &str) {
        self.act(name, Action::Focus, None);
        self.0.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::A);
        self.0.run_steps(1);
        self.0.event(Event::Text(text.into()));
        self.0.run_steps(1);
        self.0.key_press(egui::Key::Enter);
        self.0.run_steps(2);
    }

    /// Opens a list and chooses an entry: the last control of that name, as lists are on top.
    fn choose(&mut self, list: &str, entry: &str) {
        self.click(list);
        let is_entry = |node: &egui_kittest::Node<'_>| node.accesskit_node().role() == Role::Button;
        let (target_node, target_tree) = {
            let mut entries = self.0.query_all_by_label(entry).filter(is_entry);
            let found = entries.next_back().unwrap_or_else(|| panic!("{list}: no {entry}"));
            found.accesskit_node().locate()
        };
        let action = Action::Click;
        self.0.event(Event::AccessKitActionRequest(ActionRequest { action, target_node, target_tree, data: None }));
        self.0.run_steps(2);
        if egui::Popup::is_any_open(&self.0.ctx) {
            self.0.key_press(egui::Key::Escape);
            self.0.run_steps(2);
        }
    }

    /// Names of the controls of a role that are fields of a scene file.
    fn names(&self, role: Role) -> Vec<String> {
        let nodes = self.0.query_all_by(move |node| node.role() == role);
        nodes.filter_map(|node| node.accesskit_node().label()).filter(|name| name.contains('.')).collect()
    }

    fn rect(&self, name: &str) -> egui::Rect {
        self.0.get_by_label(name).rect()
    }

    fn press(&mut self, pos: Pos2, pressed: bool) {
        let (button, modifiers) = (PointerButton::Primary, egui::Modifiers::NONE);
        self.0.event(Event::PointerMoved(pos));
        self.0.event(Event::PointerButton { pos, button, pressed, modifiers });
        self.0.run_steps(1);
    }

    fn double_click(&mut self, pos: Pos2) {
        for pressed in [true, false, true, false] {
            self.press(pos, pressed);
        }
        self.0.run_steps(1);
    }

    fn drag(&mut self, from: Pos2, to: Pos2) {
        self.press(from, true);
        for part in [0.3, 0.7, 1.0] {
            self.0.event(Event::PointerMoved(from + (to - from) * part));
            self.0.run_steps(1);
        }
        self.press(to, false);
        self.0.run_steps(1);
    }

    fn picture(&self, name: &str) {
        let path = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("panels/{name}.png"));
        self.0.state().painter.write(&self.0.ctx, self.0.output(), SIZE, &path);
    }
}

/// A field of a scene; `None` if it has its default.
fn number(scene: &Scene, name: &str) -> Option<f64> {
    let value = scene.value_named(name)?;
    value.as_float().or(value.as_integer().map(|value| value as f64))
}

#[test]
fn m53_sliders_set_the_fields_of_their_names() {
    let mut tried = BTreeSet::new();
    for name in scene::names() {
        let mut hand = Hand::open(preset(name).unwrap());
        let sliders = hand.names(Role::Slider);
        assert!(sliders.len() > 20, "{name}: {sliders:?}");
        let parameters: Vec<String> = hand
            .model()
            .parameters(None)
            .iter()
            .map(|(parameter, _)| format!("parameters.{}", parameter.name))
            .collect();
        for slider in sliders.iter().filter(|slider| !slider.starts_with("max_error")) {
            let node = hand.0.get_by_label(slider);
            let node = node.accesskit_node();
            let (low, high) = (node.min_numeric_value().unwrap(), node.max_numeric_value().unwrap());
            if !tried.insert((slider.clone(), low.to_bits(), high.to_bits())) {
                continue;
            }
            // A value in the range: a whole number unless the range is short.
            let value = low + 0.3 * (high - low);
            let (value, off) = if high > 7.0 { (value.round(), 0.5) } else { (value, 1e-3) };
            hand.set(slider, value);
            if slider.contains("transfer.stop") {
                continue;
            }
            let refused = hand.model().message().is_some_and(|message| message.contains(": "));
            let now = number(&hand.scene(), slider);
            let is_set = now.is_some_and(|now| (now - value).abs() <= off);
            assert!(is_set || refused, "{name}: {slider} = {value}: {now:?}");
            hand.scene().check(&shader::shipped()).unwrap();
            if refused {
                hand.model().edit("about", |scene| scene.about.push('.'));
            }
        }
        let is_there = |parameter: &String| {
            sliders.contains(parameter) || hand.0.query_by_label(&format!("{parameter}.code")).is_some()
        };
        assert!(parameters.iter().all(is_there), "{name}: {parameters:?}");
    }
}

#[test]
fn lists_switches_and_texts_set_their_fields() {
    let mut hand = Hand::open(preset("fur").unwrap());
    hand.click("light.shadows");
    hand.set("quality.samples", 100.0);
    hand.choose("quality.pass", "march");
    hand.choose("quality.integration", "segment");
    hand.choose("quality.empty_space", "sample");
    hand.choose("quality.target", "float16");
    hand.choose("effect.turbulence", "procedural");
    hand.choose("quality.jitter", "hash");
    hand.click("image.has_background");
    hand.click("camera.has_clip");
    hand.set("camera.clip.w", 0.25);
    hand.set("light.position.x", 2.5);
    hand.write("image.background.code", "#102030");
    hand.write("parameters.tip_color.code", "#ff0000");
    hand.write("object.input", "torus");
    let scene = hand.scene();
    assert_eq!((scene.quality.pass, scene.quality.integration), (Pass::March, scene::Integration::Segment));
    assert_eq!(
        (scene.quality.empty_space, scene.quality.target),
        (scene::EmptySpace::Sample, scene::TargetFormat::Float16)
    );
    assert_eq!((scene.effect.turbulence.as_str(), scene.object.input.as_str()), ("procedural", "torus"));
    assert_eq!((scene.quality.jitter, scene.light.position[0]), (scene::Jitter::Hash, 2.5));
    assert_ne!(scene.light.shadows, preset("fur").unwrap().light.shadows);
    assert_eq!((scene.image.background, scene.camera.clip), (Some(Color([16, 32, 48])), Some([0.0, 0.0, 1.0, 0.25])));
    assert_eq!(scene.parameters["tip_color"], ParameterValue::Color(Color([255, 0, 0])));
    hand.click("parameters.tip_color.reset");
    assert_ne!(hand.scene().parameters["tip_color"], ParameterValue::Color(Color([255, 0, 0])));
}

#[test]
fn what_changes_nothing_is_said_below_the_picture() {
    let mut hand = Hand::new(scene::preset("fire").unwrap());
    assert!(hand.0.query_all_by_value("ignored: quality.seed = 7").next().is_none());
    hand.0.state_mut().status.ignored = vec!["quality.seed = 7".into()];
    hand.0.run_steps(2);
    assert!(hand.0.query_all_by_value("ignored: quality.seed = 7").next().is_some());
}

/// Opacity of the label of a row, 0 to 255.
fn opacity(hand: &Hand, label: &str) -> u8 {
    let alphas = hand.0.output().shapes.iter().filter_map(|clipped| match &clipped.shape {
        egui::Shape::Text(text) if text.galley.text() == label => {
            Some(text.override_text_color.unwrap_or(text.fallback_color).a())
        }
        _ => None,
    });
    alphas.max().unwrap()
}

#[test]
fn unused_settings_are_dimmed_in_place() {
    let mut hand = Hand::open(scene::preset("lit").unwrap());
    let names = ["effect.medium", "effect.surface", "effect.turbulence", "quality.samples", "image.size.x"];
    let places = |hand: &Hand| names.map(|name| hand.rect(name));
    let (before, bright) = (places(&hand), opacity(&hand, "turbulence"));
    hand.0.state_mut().status.idle = vec!["effect.turbulence".into(), "effect.medium".into()];
    hand.0.run_steps(2);
    assert_eq!(places(&hand), before);
    assert!(opacity(&hand, "turbulence") < bright / 2 + 10 && opacity(&hand, "surface") == bright);
    hand.picture("dimmed");
    hand.choose("effect.turbulence", "procedural");
    assert_eq!(hand.scene().effect.turbulence, "procedural", "it can be set all the same");
}

#[test]
fn a_change_of_medium_keeps_its_control_in_place() {
    let mut hand = Hand::advanced(preset("fire").unwrap());
    let (before, parameters) = (hand.rect("effect.medium"), hand.model().parameters(None).iter().count());
    hand.choose("effect.medium", "lit");
    assert_ne!(hand.model().parameters(None).iter().count(), parameters);
    assert_eq!(hand.rect("effect.medium"), before);
}

#[test]
fn the_panel_regains_its_width_in_a_wider_window() {
    let mut hand = Hand::new(preset("fire").unwrap());
    let resize = |hand: &mut Hand, width: f32| {
        hand.0.set_size(egui::vec2(width, 800.0));
        hand.0.run_steps(3);
        width - hand.0.state().left.right()
    };
    let wide = resize(&mut hand, 1280.0);
    assert!(resize(&mut hand, 420.0) < 0.6 * wide);
    assert_eq!(resize(&mut hand, 1280.0), wide);
    // The chosen width.
    let edge = egui::pos2(1280.0 - wide, 400.0);
    hand.drag(edge, edge + egui::vec2(60.0, 0.0));
    let chosen = resize(&mut hand, 1280.0);
    assert!((wide - chosen - 60.0).abs() < 8.0, "{wide} {chosen}");
    resize(&mut hand, 420.0);
    assert_eq!(resize(&mut hand, 1280.0), chosen);
}

#[test]
fn what_a_picture_is_made_with_is_a_section_once_there_is_one() {
    let mut hand = Hand::advanced(scene::preset("lit").unwrap());
    assert!(hand.0.query_all_by_label("Made with").next().is_none());
    hand.0.state_mut().status.made = vec![["left out".into(), "noise block: nothing reads it".into()]];
    hand.0.run_steps(2);
    hand.click("Made with");
    assert!(hand.0.query_all_by_value("noise block: nothing reads it").next().is_some());
}

#[test]
fn what_the_check_refuses_is_one_line_and_changes_nothing() {
    let mut hand = Hand::open(preset("fur").unwrap());
    hand.choose("quality.pass", "slices");
    let before = hand.scene();
    hand.choose("effect.ray_path", "refracted");
    assert_eq!(hand.scene(), before);
    let message = hand.model().message().unwrap().to_string();
    assert!(message.starts_with("effect.ray_path = \"refracted\": needs quality.pass"), "{message}");
    assert!(hand.0.query_all_by_value(&message).next().is_some());
    hand.choose("quality.pass", "march");
    hand.choose("effect.ray_path", "refracted");
    assert_eq!(hand.scene().effect.ray_path, scene::RayPath::Refracted);
}

#[test]
fn s01_5_a_stack_grows_shrinks_changes_its_order_and_has_masks() {
    let mut hand = Hand::advanced(preset("fur").unwrap());
    hand.choose("effect.dmf.add", "noisy");
    hand.choose("effect.dmf.add", "biased");
    assert_eq!(hand.scene().effect.dmf, ["fur", "noisy", "biased"]);
    hand.click("effect.dmf.2.up");
    hand.click("effect.dmf.0.down");
    assert_eq!(hand.scene().effect.dmf, ["biased", "fur", "noisy"]);
    hand.choose("effect.dmf.1.mask", "height");
    hand.choose("effect.dmf.2", "fire");
    assert_eq!(hand.scene().effect.dmf, ["biased", "fur@height", "fire"]);
    let parameters: Vec<String> =
        hand.model().parameters(None).iter().map(|(parameter, _)| parameter.name.clone()).collect();
    assert!(parameters.iter().any(|name| name.starts_with("height_")), "{parameters:?}");
    assert!(
        parameters.iter().all(|name| hand.0.query_by_label(&format!("parameters.{name}")).is_some()),
        "{parameters:?}"
    );
    hand.click("effect.dmf.0.remove");
    hand.choose("effect.dmf.0.mask", "everywhere");
    hand.choose("effect.warp.add", "swirl");
    assert_eq!(
        (hand.scene().effect.dmf, hand.scene().effect.warp),
        (vec!["fur".into(), "fire".into()], vec!["swirl".into()])
    );
    (0..8).for_each(|_| drop(hand.click("undo")));
    assert_eq!(hand.scene().effect.dmf, ["fur", "noisy"]);
}

#[test]
fn a_drag_is_one_step_back() {
    let mut hand = Hand::new(preset("fur").unwrap());
    let before = hand.scene();
    let rect = hand.rect("parameters.fineness");
    hand.drag(rect.left_center() + egui::vec2(20.0, 0.0), rect.left_center() + egui::vec2(80.0, 0.0));
    let after = hand.scene();
    assert_ne!(after, before);
    assert_eq!(hand.model().undoes(), Some("parameters.fineness"));
    hand.click("undo");
    assert_eq!(hand.scene(), before);
    hand.click("redo");
    assert_eq!(hand.scene(), after);
}

#[test]
fn the_transfer_map_is_edited_by_hand() {
    let mut hand = Hand::new(preset("fire").unwrap());
    hand.click("Transfer map");
    let before = hand.scene().transfer.stops;
    let area = hand.rect("transfer.curve_editor").shrink(5.5);
    let gap = before.windows(2).map(|two| 0.5 * (two[0].at + two[1].at)).next().unwrap();
    let at = |x: f32, y: f32| egui::pos2(egui::lerp(area.x_range(), x), egui::lerp(area.bottom()..=area.top(), y));
    hand.double_click(at(gap, 0.9));
    let stops = hand.scene().transfer.stops;
    assert_eq!(stops.len(), before.len() + 1);
    assert!((stops[1].at - gap).abs() < 0.02 && (stops[1].density - 0.9).abs() < 0.02, "{:?}", stops[1]);
    hand.drag(at(stops[1].at, stops[1].density), at(gap, 0.35));
    let moved = hand.scene().transfer.stops[1];
    assert!((moved.density - 0.35).abs() < 0.03, "{moved:?}");
    hand.write("transfer.stop.color.code", "#00ff00");
    assert_eq!(hand.scene().transfer.stops[1].color, Color([0, 255, 0]));
    assert!(hand.0.state().commands.contains(&Command::Densities));
    hand.0.state_mut().status.densities = Some((0..64).map(|bar| 64 - bar).collect());
    hand.0.run_steps(2);
    hand.picture("transfer");
    let bar = hand.rect("transfer.bar.1").center();
    hand.drag(bar, bar - egui::vec2(1000.0, 0.0));
    assert_eq!(hand.scene().transfer.stops[1].at, before[0].at, "it stops at its neighbor");
    hand.click("transfer.remove");
    hand.click("transfer.add");
    assert_eq!(hand.scene().transfer.stops.len(), before.len() + 1);
    (0..2).for_each(|_| drop(hand.click("undo")));
    let point = hand.scene().transfer.stops[1];
    hand.double_click(at(point.at, point.density));
    assert_eq!(hand.scene().transfer.stops.len(), before.len());
    hand.scene().check(&shader::shipped()).unwrap();
}

#[test]
fn objects_come_and_go_with_effects_of_their_own() {
    let mut hand = Hand::open(preset("solid").unwrap());
    hand.click("add object");
    assert_eq!(hand.scene().parts.len(), 1);
    hand.set("parts.object1.transform.scale", 0.75);
    hand.write("parts.object1.object.input", "torus");
    hand.choose("parts.object1.effect.classify", "soft");
    hand.choose("parts.object1.effect.softness", "linear");
    hand.choose("parts.object1.effect.dmf.add", "noisy");
    hand.write("combine", "main - object1");
    hand.choose("boolean", "minmax");
    let parameter = hand.model().parameters(Some("object1")).iter().next().unwrap().0.name.clone();
    let slider = format!("parts.object1.parameters.{parameter}");
    hand.set(&slider, hand.0.get_by_label(&slider).accesskit_node().max_numeric_value().unwrap());
    let scene = hand.scene();
    let part = &scene.parts["object1"];
    assert_eq!((part.object.input.as_str(), part.transform.scale, part.parameters.len()), ("torus", 0.75, 1));
    assert_eq!((scene.combine.as_deref(), scene.boolean), (Some("main - object1"), scene::Boolean::Minmax));
    hand.picture("objects");
    hand.click("remove object");
    assert_eq!((hand.scene().parts.len(), hand.scene().combine), (0, None));
    hand.click("undo");
    assert_eq!(hand.scene(), scene);
}

#[test]
fn presets_files_and_commands() {
    let mut hand = Hand::new(preset("lit").unwrap());
    ["view.advanced", "File", "Accuracy", "Camera"].iter().for_each(|section| drop(hand.click(section)));
    hand.click("presets.own");
    hand.click("preset smoke");
    hand.click("presets.own");
    assert_eq!(hand.scene().effect, preset("smoke").unwrap().effect);
    hand.write("parameters.vapor_color.code", "#808080");
    hand.click("preset fur");
    let scene = hand.scene();
    assert_eq!((&scene.effect, scene.object.input.as_str()), (&preset("fur").unwrap().effect, "torus"));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scene.toml");
    hand.write("file.scene", path.to_str().unwrap());
    assert!(hand.model().is_dirty());
    hand.click("file.save");
    assert!(!hand.model().is_dirty());
    hand.click("preset lit");
    hand.click("file.open");
    assert_eq!(hand.scene(), scene);
    for name in ["pause", "record", "compare", "file.screenshot", "camera.reset", "max_error.on", "validity"] {
        hand.click(name);
    }
    let Desk { commands, .. } = hand.0.state();
    let error = Command::MaxError(Some(1.0 / 255.0));
    let shot = Command::Screenshot("picture.png".into());
    let all =
        [Command::Play, Command::Turntable, Command::Compare, shot, Command::ResetCamera, error, Command::Validity];
    // The open transfer map asks for its histogram in each frame.
    let asked: Vec<&Command> = commands.iter().filter(|command| **command != Command::Densities).collect();
    assert_eq!(asked, all.iter().collect::<Vec<_>>());
    let line = hand.model().command_line();
    let copied = hand.click("copy");
    assert!(copied.iter().any(|command| matches!(command, egui::OutputCommand::CopyText(text) if *text == line)));
}

#[test]
fn m52_typed_modules_compile_and_parameters_get_sliders() {
    let mut hand = Hand::new(preset("fur").unwrap());
    hand.click("author");
    let old = hand.0.state_mut().document.author.text.clone();
    let wait = |hand: &mut Hand, done: &dyn Fn(&Author) -> bool| {
        let start = Instant::now();
        while !done(&hand.0.state().document.author) {
            // Timeout, generous for busy machines.
            assert!(start.elapsed() < Duration::from_secs(1800), "{:?}", hand.0.state_mut().document.author.state());
            hand.0.run_steps(1);
            sleep(Duration::from_millis(10));
        }
        hand.0.run_steps(2);
    };
    let is_good = |author: &Author| *author.state() == State::Good;
    hand.act("author.text", Action::Focus, None);
    hand.0.key_press_modifiers(egui::Modifiers::COMMAND, egui::Key::Home);
    hand.0.event(Event::Text("// @param zest = 0.5 in [0, 2]: New.\n".into()));
    hand.0.run_steps(2);
    wait(&mut hand, &|author| *author.state() != State::Good);
    wait(&mut hand, &is_good);
    hand.set("parameters.zest", 1.5);
    assert_eq!(hand.scene().parameters["zest"], ParameterValue::Number(1.5));
    hand.act("author.text", Action::Focus, None);
    hand.0.event(Event::Text("float qq = tangled;\n".into()));
    hand.0.run_steps(2);
    let faults = |author: &Author| match author.state() {
        State::Bad(faults) => faults.clone(),
        _ => Vec::new(),
    };
    wait(&mut hand, &|author| !faults(author).is_empty());
    let first = faults(&hand.0.state().document.author).remove(0);
    let (path, line) = first.at.unwrap();
    let text = hand.0.state_mut().document.author.text.clone();
    assert_eq!((path.as_str(), text.lines().nth(line - 1)), ("dmf/fur.glsl", Some("float qq = tangled;")));
    let shown = format!("{path}:{line}: {}", first.text);
    assert!(hand.0.query_all_by_value(&shown).next().is_some(), "{shown}");
    assert!(hand.0.query_by_label("parameters.zest").is_some(), "the last good text stays");
    hand.picture("editor");
    hand.click("author.reset");
    wait(&mut hand, &|author| faults(author).is_empty() && author.text == old);
    wait(&mut hand, &is_good);
    assert!(hand.0.query_by_label("parameters.zest").is_none() && !hand.scene().parameters.contains_key("zest"));
}

#[test]
fn the_panels_are_painted() {
    for name in ["fur", "blue_glass", "ensemble"] {
        let mut hand = Hand::advanced(preset(name).unwrap());
        ["Effect", "File"].iter().for_each(|section| drop(hand.click(section)));
        hand.picture(&format!("{name}_presets"));
        ["Effect", "Presets", "File", "Objects", "Object", "Material"]
            .iter()
            .for_each(|section| drop(hand.click(section)));
        hand.picture(&format!("{name}_effect"));
        ["Effect", "Objects", "Object", "Transfer map", "Light and background", "Camera", "Accuracy"]
            .iter()
            .for_each(|section| drop(hand.click(section)));
        hand.picture(&format!("{name}_accuracy"));
    }
}
