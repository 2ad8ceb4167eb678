//! Beginners: presets, terms, keyboard control, small windows.

use super::Hand;
use egui::Key;
use egui::accesskit::{Action, Role};
use egui_kittest::kittest::{NodeT, Queryable};
use hypertexture::scene::{self, preset};
use hypertexture::shader;
use hypertexture_viewer::document::model::Model;
use hypertexture_viewer::message::Message;
use std::collections::BTreeSet;
use std::fs;
use std::thread::sleep;
use std::time::{Duration, Instant};

fn has(hand: &Hand, name: &str) -> bool {
    hand.0.query_all_by_label(name).next().is_some()
}

#[test]
fn every_preset_is_taken_on_the_object_of_every_other() {
    let names: Vec<&str> = scene::names().collect();
    for from in &names {
        for pass in [scene::Pass::March, scene::Pass::Slices] {
            let mut start = preset(from).unwrap();
            start.quality.pass = pass;
            // Some presets do not support slices.
            let Ok(mut model) = Model::new(start, shader::shipped()) else { continue };
            for name in &names {
                let before = model.scene().clone();
                assert!(model.take_preset(name, true), "{from}, {name}: {:?}", model.message());
                let (now, own) = (model.scene(), preset(name).unwrap());
                assert_eq!((&now.effect, &now.parameters), (&own.effect, &own.parameters), "{from}, {name}");
                assert_eq!(now.object.without_look(), before.object.without_look(), "{from}, {name}");
                assert_eq!((&now.camera, &now.image), (&before.camera, &before.image), "{from}, {name}");
                assert_eq!(model.preset(), Some(*name));
            }
        }
    }
}

#[test]
fn a_preset_keeps_object_and_view_unless_its_own_are_asked_for() {
    let mut start = preset("fur").unwrap();
    (start.object.input, start.camera.azimuth) = ("torus".into(), 75.0);
    let mut hand = Hand::new(start);
    hand.click("preset blue_glass");
    let scene = hand.scene();
    assert_eq!((scene.object.input.as_str(), scene.camera.azimuth), ("torus", 75.0));
    assert_eq!(scene.effect, preset("blue_glass").unwrap().effect);
    hand.click("presets.own");
    hand.click("preset fire_ball");
    assert_eq!((hand.scene().object, hand.scene().camera), {
        let own = preset("fire_ball").unwrap();
        (own.object, own.camera)
    });
}

#[test]
fn a_parameter_goes_back_to_what_the_preset_says() {
    let own = preset("fur").unwrap().parameters;
    let mut hand = Hand::new(preset("fur").unwrap());
    hand.set("parameters.fineness", 70.0);
    hand.write("parameters.tip_color.code", "#ff0000");
    for name in ["fineness", "tip_color"] {
        hand.click(&format!("parameters.{name}.reset"));
        assert_eq!(hand.scene().parameters[name], own[name]);
    }
    // The default of a parameter that the preset does not set is that of its module.
    let model = hand.model();
    let (parameter, before) = model.parameters(None).iter().find(|(own, _)| own.name == "sheen").unwrap();
    let (parameter, before) = (parameter.clone(), before.clone());
    assert_eq!(model.parameter_in_preset(None, &parameter), before);
    hand.set("parameters.sheen", 0.75);
    hand.click("parameters.sheen.reset");
    assert_eq!(hand.model().parameters(None).iter().find(|(own, _)| own.name == "sheen").unwrap().1, &before);
}

#[test]
fn commands_of_the_toolbar_have_frames() {
    let hand = Hand::new(preset("lit").unwrap());
    for name in ["copy", "author", "pause", "record", "compare", "lesson", "final"] {
        let place = hand.rect(name);
        let is_framed = hand.0.output().shapes.iter().any(|clipped| match &clipped.shape {
            egui::Shape::Rect(shape) => {
                let is_own = shape.rect.contains_rect(place.shrink(2.0)) && shape.rect.area() < 1.5 * place.area();
                is_own && shape.fill.a() > 0
            }
            _ => false,
        });
        assert!(is_framed, "{name}");
    }
    assert!(!has(&hand, "quit"), "a menu and a key do it");
}

#[test]
fn basic_settings_are_fewer() {
    let sections = ["Object", "Material", "Light and background", "Camera", "Accuracy", "Picture"];
    let mut hand = Hand::new(preset("lit").unwrap());
    sections.iter().for_each(|section| drop(hand.click(section)));
    for basic in
        ["camera.azimuth", "quality.samples", "image.size.x", "camera.pan.x", "light.intensity", "max_error.on"]
    {
        assert!(has(&hand, basic), "{basic}");
    }
    for advanced in ["effect.turbulence", "quality.block_size", "camera.rotation.x", "object.storage", "validity"] {
        assert!(!has(&hand, advanced), "{advanced}");
    }
    let basic = hand.names(Role::Slider).len();
    hand.click("view.advanced");
    hand.0.run_steps(2);
    assert!(!has(&hand, "camera.has_matrices"), "32 numbers");
    for advanced in ["effect.turbulence", "quality.block_size", "camera.has_rotation", "object.storage", "validity"] {
        assert!(has(&hand, advanced), "{advanced}");
    }
    assert!(hand.names(Role::Slider).len() > basic + 5);
}

#[test]
fn words_are_those_of_the_field_and_numbers_have_their_units() {
    let mut hand = Hand::open(preset("fur").unwrap());
    let shown = |hand: &Hand, text: &str| hand.0.query_all_by_value(text).next().is_some() || has(hand, text);
    for word in ["clip plane", "opacity cut-off", "Error target", "iso-value", "angle of view", "ambient light"] {
        assert!(shown(&hand, word), "{word}");
    }
    hand.set("camera.elevation", 25.0);
    hand.click("add object");
    assert!(shown(&hand, "Transform"));
    let of = |name: &str| scene::schema::setting(name).unwrap().unit.map_or("", scene::schema::Unit::symbol);
    for (unit, names) in [
        ("\u{b0}", &["camera.azimuth", "camera.elevation", "camera.field_of_view", "transform.turn"][..]),
        (" s", &["camera.time", "camera.shutter"]),
        (" px", &["image.size"]),
        (" u", &["object.shell", "object.inner_iso", "light.position", "camera.pan", "light.scatter"]),
        (" tx", &["quality.block_blur"]),
        ("", &["camera.zoom", "light.intensity", "quality.samples", "effect.opacity_rate", "material.specular"]),
    ] {
        names.iter().for_each(|name| assert_eq!(of(name), unit, "{name}"));
    }
}

#[test]
fn azimuth_and_elevation_follow_the_rotation() {
    let mut hand = Hand::open(preset("lit").unwrap());
    let mut turned = hand.scene().camera;
    (turned.azimuth, turned.elevation) = (-50.0, 35.0);
    let rotation = turned.turn().to_array();
    hand.model().edit("camera", |scene| scene.camera.rotation = Some(rotation));
    hand.0.run_steps(2);
    // Both are idle, and still have controls.
    hand.0.state_mut().status.idle = vec!["camera.azimuth".into(), "camera.elevation".into()];
    hand.0.run_steps(2);
    let value = |hand: &Hand, name: &str| hand.0.get_by_label(name).accesskit_node().numeric_value().unwrap();
    assert_eq!([value(&hand, "camera.azimuth"), value(&hand, "camera.elevation")], [-50.0, 35.0]);
    hand.set("camera.azimuth", 20.0);
    let camera = hand.scene().camera;
    assert_eq!((camera.azimuth, camera.elevation, camera.rotation), (20.0, 35.0, None));
}

#[test]
fn an_object_is_chosen_from_a_list() {
    let mut hand = Hand::open(preset("fur").unwrap());
    hand.choose("object.input.list", "knot");
    assert_eq!(hand.scene().object.input, "knot");
    hand.click("undo");
    assert_eq!(hand.scene().object.input, preset("fur").unwrap().object.input);
}

#[test]
fn opening_a_picture_loads_the_scene_inside_it() {
    let folder = tempfile::tempdir().unwrap();
    let [own, other] = ["own.png", "other.png"].map(|name| folder.path().join(name));
    let mut model = Model::new(preset("fur").unwrap(), shader::shipped()).unwrap();
    image::RgbImage::from_pixel(8, 8, image::Rgb([9, 9, 9])).save(&other).unwrap();
    let before = model.scene().clone();
    assert!(!model.open(&other));
    assert!(model.message().unwrap().contains("does not say which scene"), "{:?}", model.message());
    assert_eq!((model.scene(), model.notice().unwrap().is_error), (&before, true));

    if cfg!(no_gpu) {
        return println!("no picture is rendered: HYPERTEXTURE_NO_GPU is set");
    }
    let status = std::process::Command::new(env!("CARGO_BIN_EXE_hypertexture"))
        .args(["render", "torus", "--effect", "fire", "--size", "8x6", "--samples", "8", "--output"])
        .arg(&own)
        .output()
        .unwrap();
    assert!(status.status.success(), "{status:?}");
    assert!(model.open(&own), "{:?}", model.message());
    assert_eq!((model.scene().object.input.as_str(), model.scene().quality.samples), ("torus", 8));
    assert_eq!((model.scene().effect.clone(), model.file()), (preset("fire").unwrap().effect, None));
    assert!(!model.is_dirty());
}

#[test]
fn messages_do_not_resize_the_picture() {
    let mut hand = Hand::new(preset("fur").unwrap());
    let line = hand.rect("undo");
    hand.model().say("something went wrong");
    hand.0.state_mut().status.message = Some(Message::note("something was done"));
    hand.0.run_steps(2);
    for text in ["something went wrong", "something was done"] {
        assert!(hand.0.query_all_by_value(text).next().is_some(), "{text}");
    }
    assert_eq!(hand.rect("undo"), line);
    hand.picture("messages");
    // The next change is accepted, which ends the error.
    hand.set("parameters.sheen", 0.5);
    assert!(hand.0.query_all_by_value("something went wrong").next().is_none());
}

#[test]
fn of_a_small_window_the_picture_keeps_most_and_panels_hide() {
    let mut hand = Hand::new(preset("fur").unwrap());
    hand.0.set_size(egui::vec2(500.0, 400.0));
    hand.0.run_steps(4);
    let left = hand.0.state().left;
    assert!(left.area() > 0.5 * 500.0 * 400.0, "{left:?}");
    hand.0.state_mut().panels.hidden = true;
    hand.0.run_steps(2);
    let left = hand.0.state().left;
    assert!(left.width() > 480.0 && left.area() > 0.85 * 500.0 * 400.0, "{left:?}");
    assert!(!has(&hand, "undo"));
    hand.0.state_mut().panels.hidden = false;
    hand.0.run_steps(2);
    assert!(has(&hand, "undo"));
}

/// Presses Tab until each of the controls had the focus, or none new for long; returns those that had it.
fn by_tab(hand: &mut Hand, all: &BTreeSet<String>) -> BTreeSet<String> {
    let mut reached = BTreeSet::new();
    let mut fresh = 0;
    while fresh < 60 && !all.is_subset(&reached) {
        hand.0.key_down(Key::Tab);
        hand.0.run_steps(1);
        let focused = hand.0.query_all_by(|node| node.is_focused()).next();
        let name = focused.and_then(|node| node.accesskit_node().label()).unwrap_or_default();
        fresh = if reached.insert(name) { 0 } else { fresh + 1 };
    }
    reached
}

#[test]
fn every_control_is_reached_by_the_keyboard_alone() {
    for name in ["fire", "ensemble"] {
        let mut hand = Hand::open(preset(name).unwrap());
        hand.click("final");
        let is_control = |node: &egui_kittest::Node<'_>| {
            let node = node.accesskit_node();
            !node.is_disabled() && node.data().supports_action(Action::Focus)
        };
        let all: BTreeSet<String> =
            hand.0.query_all_by(|_| true).filter(is_control).filter_map(|node| node.accesskit_node().label()).collect();
        assert!(all.len() > 100, "{}", all.len());
        let reached = by_tab(&mut hand, &all);
        let missed: Vec<&String> = all.difference(&reached).collect();
        assert!(missed.is_empty(), "{name}: {missed:?}");
    }
}

#[test]
fn controls_are_used_by_the_keyboard_alone() {
    let mut hand = Hand::open(preset("fur").unwrap());
    let before = hand.scene();
    let go = |hand: &mut Hand, name: &str, key: Key| {
        hand.act(name, Action::Focus, None);
        hand.0.key_press(key);
        hand.0.run_steps(2);
    };
    go(&mut hand, "light.shadows", Key::Space);
    assert_ne!(hand.scene().light.shadows, before.light.shadows);
    go(&mut hand, "parameters.fineness", Key::ArrowRight);
    assert_ne!(hand.scene().parameters["fineness"], before.parameters["fineness"]);
    go(&mut hand, "preset lit", Key::Enter);
    assert_eq!(hand.scene().effect, preset("lit").unwrap().effect);
    go(&mut hand, "quality.pass", Key::Enter);
    assert!(egui::Popup::is_any_open(&hand.0.ctx));
    hand.0.key_press(Key::Escape);
    hand.0.run_steps(2);
    go(&mut hand, "image.has_background", Key::Space);
    hand.write("image.background.code", "#102030");
    assert!(hand.scene().image.background.is_some_and(|color| String::from(color) == "#102030"));
    go(&mut hand, "theme light", Key::Space);
    assert_eq!(hand.0.ctx.theme(), egui::Theme::Light);
    hand.picture("light");
}

#[test]
fn a_theme_is_kept_for_the_next_window() {
    let folder = tempfile::tempdir().unwrap();
    let mut hand = Hand::new(preset("fur").unwrap());
    hand.0.state_mut().panels.remember(Vec::new(), Some(folder.path().into()));
    hand.0.run_steps(1);
    assert_eq!(hand.0.ctx.theme(), egui::Theme::Dark, "without a system that says otherwise");
    hand.click("theme light");
    let mut next = Hand::new(preset("fur").unwrap());
    next.0.state_mut().panels.remember(Vec::new(), Some(folder.path().into()));
    next.0.run_steps(2);
    assert_eq!(next.0.ctx.theme(), egui::Theme::Light);
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn final_pictures_are_rendered_beside_the_window() {
    let folder = tempfile::tempdir().unwrap();
    let [picture, frames] = ["final.png", "frame_##.png"].map(|name| folder.path().join(name));
    let mut start = preset("lit").unwrap();
    (start.object.input, start.quality.samples) = ("cube".into(), 16);
    let mut hand = Hand::new(start);
    let wait = |hand: &mut Hand| {
        let start = Instant::now();
        while has(hand, "final.stop") {
            assert!(start.elapsed() < Duration::from_secs(600)); // a test that fails ends
            sleep(Duration::from_millis(20));
            hand.0.run_steps(1);
        }
    };
    hand.click("final");
    hand.write("final.file", picture.to_str().unwrap());
    hand.set("final.size.x", 24.0);
    hand.set("final.size.y", 16.0);
    hand.set("final.supersampling", 1.0);
    hand.picture("final");
    hand.click("final.render");
    // The process ends with the window, which asks first.
    hand.quit();
    assert_eq!(hand.0.state().commands, []);
    hand.click("ask.no");
    wait(&mut hand);
    let line = |hand: &Hand, text: &str| hand.0.query_all_by_value(text).next().is_some();
    assert_eq!(image::open(&picture).unwrap().to_rgba8().dimensions(), (24, 16));
    let shown = hypertexture::output::read_provenance(&picture).unwrap();
    assert_eq!(shown.scene(&picture, scene::Reach::Anywhere).unwrap().quality.samples, 16);
    assert!(!line(&hand, &format!("{} exists", picture.display())), "it is the window's own");

    hand.click("final.sequence");
    hand.write("final.file", frames.to_str().unwrap());
    hand.set("final.frames", 3.0);
    fs::write(folder.path().join("frame_00.png"), "of somebody else").unwrap();
    hand.0.run_steps(2);
    assert!(line(&hand, &format!("{} exists", folder.path().join("frame_00.png").display())));
    hand.click("final.render");
    wait(&mut hand);
    let all: Vec<_> = (0..3).map(|n| image::open(folder.path().join(format!("frame_0{n}.png"))).unwrap()).collect();
    assert!(all[0] != all[1] && all[1] != all[2], "the camera goes around");

    hand.click("final.picture");
    hand.write("final.file", folder.path().join("missing/final.png").to_str().unwrap());
    hand.click("final.render");
    wait(&mut hand);
    let is_said = |text: String| text.starts_with("final picture: ");
    assert!(hand.0.query_all_by(|node| node.value().is_some_and(is_said)).next().is_some());
}

#[test]
fn nothing_is_wider_than_the_panel_however_narrow_the_window_is() {
    let cut = |name: &str, width: f32| {
        let mut hand = Hand::open(preset(name).unwrap());
        hand.0.state_mut().status.made = vec![["left out".into(), "noise block: nothing reads it, as it seems".into()]];
        hand.0.run_steps(2);
        hand.click("Made with");
        hand.0.set_size(egui::vec2(width, 7000.0));
        hand.0.run_steps(8);
        // The panel is at the right of the picture.
        let left = hand.0.state().left;
        let is_control = |role| ![Role::GenericContainer, Role::Window, Role::TextRun, Role::Unknown].contains(&role);
        let all = hand.0.query_all_by(|node| is_control(node.role()));
        let beside =
            |rect: egui::Rect| rect.right() > left.right() && rect.top() > left.top() && rect.top() < left.bottom();
        let inside = all.filter(|node| beside(node.rect()));
        let cut = inside.filter(|node| node.rect().left() < left.right() || node.rect().right() > width);
        let say = |node: egui_kittest::Node<'_>| {
            let (role, label) = (node.accesskit_node().role(), node.accesskit_node().label());
            format!("{width} {name}: {role:?} {label:?} {}", node.rect())
        };
        cut.map(say).collect::<Vec<_>>()
    };
    let widths = [400.0, 450.0, 640.0, 760.0, 1280.0].map(|width| ("ensemble", width));
    let all = widths.into_iter().chain(scene::names().map(|name| (name, 500.0)));
    let all: Vec<String> = all.flat_map(|(name, width)| cut(name, width)).collect();
    assert!(all.is_empty(), "{}", all.join("\n"));
}

#[test]
fn frames_and_seconds_of_a_sequence_keep_what_was_typed_last() {
    let mut hand = Hand::new(preset("lit").unwrap());
    hand.click("final");
    hand.click("final.sequence");
    let value = |hand: &Hand, name: &str| hand.0.get_by_label(name).accesskit_node().numeric_value().unwrap();
    hand.set("final.frames", 8.0);
    hand.set("final.fps", 2.0);
    assert_eq!(value(&hand, "final.frames"), 8.0);
    assert!(hand.0.query_all_by_value("8 frames = 4 s").next().is_some());
    hand.set("final.seconds", 2.0);
    assert_eq!(value(&hand, "final.frames"), 4.0);
    hand.set("final.fps", 10.0);
    assert_eq!((value(&hand, "final.frames"), value(&hand, "final.seconds")), (20.0, 2.0));
}

#[test]
fn a_scene_that_moves_is_turned_only_if_that_is_asked_for() {
    let is_on = |hand: &Hand, name: &str| {
        let node = hand.0.get_by_label(name);
        node.accesskit_node().toggled() == Some(egui::accesskit::Toggled::True)
    };
    let mut hand = Hand::new(preset("lit").unwrap());
    hand.click("final");
    hand.click("final.sequence");
    assert!(is_on(&hand, "final.turntable"));
    hand.model().edit("animation", |scene| {
        let key = |time: f64, angle: f64| scene::Key { time, value: angle.into(), ease: scene::Ease::Linear };
        scene.animation.set_key("camera.azimuth", key(0.0, 0.0));
        scene.animation.set_key("camera.azimuth", key(4.0, 90.0));
    });
    hand.0.run_steps(2);
    assert!(!is_on(&hand, "final.turntable"));
    let said = |hand: &Hand| {
        let is_it = |text: &String| text.starts_with("azimuth is keyed");
        hand.0.query_all_by(move |node| node.value().as_ref().is_some_and(is_it)).next().is_some()
    };
    assert!(!said(&hand));
    hand.click("final.turntable");
    assert!(is_on(&hand, "final.turntable") && said(&hand));
}

#[test]
fn numbers_have_four_digits_and_all_reset_arrows_one_column() {
    let mut start = preset("fur").unwrap();
    start.camera.azimuth = 17.809_26;
    let mut hand = Hand::new(start);
    hand.click("Camera");
    hand.0.run_steps(30);
    let painted = |hand: &Hand, wanted: &str| {
        hand.0.output().shapes.iter().any(|clipped| match &clipped.shape {
            egui::Shape::Text(text) => text.galley.text() == wanted,
            _ => false,
        })
    };
    assert!(painted(&hand, "17.81"));
    let sliders: Vec<String> =
        hand.names(Role::Slider).into_iter().filter(|name| name.starts_with("parameters.")).collect();
    assert!(sliders.len() > 3 && sliders.contains(&"parameters.hair_length".into()), "{sliders:?}");
    let lefts: BTreeSet<i32> =
        sliders.iter().map(|name| hand.rect(&format!("{name}.reset")).left().round() as i32).collect();
    assert_eq!(lefts.len(), 1, "{lefts:?}");
}
