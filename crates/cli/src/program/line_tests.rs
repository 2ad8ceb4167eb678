//! The command line that the window copies, read back by the command line.
#![expect(clippy::unwrap_used, reason = "a test fails where a line is not as described")]

use super::command_line::{Arguments, Command};
use crate::commands::gallery;
use clap::Parser;
use hypertexture::scene::{self, Color, Jitter, ParameterValue, Scene, preset};
use hypertexture::shader;
use hypertexture_support::random::SplitMix;
use hypertexture_viewer::document::model::Model;

/// The words of a line, as `sh` reads them.
fn words(line: &str) -> Vec<String> {
    let output = std::process::Command::new("sh").args(["-c", &format!("printf '%s\\0' {line}")]).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    text.trim_end_matches('\0').split('\0').map(String::from).collect()
}

fn read(line: &str) -> Scene {
    let arguments = Arguments::try_parse_from(words(line)).unwrap_or_else(|error| panic!("{line}: {error}"));
    let Command::Render(render) = arguments.command else { panic!("{line}") };
    render.arguments.scene(&render.input, &render.object).unwrap_or_else(|error| panic!("{line}: {error}"))
}

fn check(model: &Model) {
    let line = model.command_line();
    assert_eq!(read(&line), *model.scene(), "{line}");
}

#[test]
fn the_command_line_of_every_preset_is_its_name() {
    for name in scene::names() {
        let model = Model::new(preset(name).unwrap(), shader::shipped()).unwrap();
        assert!(model.command_line().len() <= format!("hypertexture render {name}").len(), "{}", model.command_line());
        check(&model);
    }
}

#[test]
fn command_lines_of_the_gallery_give_its_scenes() {
    let mut scenes = gallery::examples().unwrap();
    scenes.extend(gallery::effects("some where/my box.obj").unwrap());
    for (name, mut scene) in scenes {
        (scene.image.size, scene.quality.samples, scene.quality.msaa) = ([300, 200], 99, 4);
        let line = scene.command_line(&shader::shipped());
        assert_eq!(read(&line), scene, "{name}: {line}");
    }
}

#[test]
fn a_person_would_write_the_same_line() {
    let mut scene = preset("fur").unwrap();
    scene.object.input = "torus".into();
    scene.quality.samples = 100;
    scene.camera.azimuth = -12.5;
    scene.parameters.insert("fineness".into(), ParameterValue::Number(60.0));
    let model = Model::new(scene, shader::shipped()).unwrap();
    let expected = "hypertexture render torus --effect fur --set fineness=60 --samples 100 --camera=-12.5,";
    assert!(model.command_line().starts_with(expected), "{}", model.command_line());
    check(&model);
}

/// Numbers between 0 and 1.
struct Dice(SplitMix);

impl Dice {
    fn roll(&mut self) -> f32 {
        self.0.unit() as f32
    }

    fn below(&mut self, count: usize) -> usize {
        ((self.roll() * count as f32) as usize).min(count - 1)
    }

    fn color(&mut self) -> Color {
        Color([(); 3].map(|()| self.below(256) as u8))
    }
}

/// An edit as the panels make them; some are refused.
fn edit(model: &mut Model, dice: &mut Dice) -> bool {
    let library = model.library().clone();
    let pick = |dice: &mut Dice, slot: &str| {
        let modules = library.modules(slot);
        modules[dice.below(modules.len())].to_string()
    };
    let parameters: Vec<_> = model.parameters(None).iter().map(|(parameter, _)| parameter.clone()).collect();
    let parts: Vec<_> = model.scene().parts.keys().cloned().collect();
    let number = dice.roll();
    match dice.below(16) {
        0 => model.edit("a", |s| s.quality.samples = 1 + (number * 300.0) as u32),
        1 => model.edit("a", |s| {
            s.quality.early_termination = number * 0.5;
            s.quality.jitter = [Jitter::None, Jitter::Hash, Jitter::Blue][dice.below(3)];
        }),
        2 => model.edit("a", |s| (s.camera.azimuth, s.camera.zoom) = (number * 90.0 - 45.0, 0.5 + number)),
        3 => model.edit("a", |s| s.camera.clip = (number > 0.3).then_some([number, -0.5, 0.0, 0.125])),
        4 => model.edit("a", |s| (s.light.color, s.light.position[0]) = (dice.color(), -number)),
        5 => model.edit("a", |s| s.image.background = (number > 0.5).then(|| dice.color())),
        6 => model.edit("a", |s| s.effect.dmf.push(pick(dice, "dmf"))),
        7 => model.edit("a", |s| drop(s.effect.dmf.pop())),
        8 => model.edit("a", |s| (s.effect.medium, s.effect.surface) = (pick(dice, "medium"), pick(dice, "surface"))),
        9 => model.edit("a", |s| s.object.input = ["torus", "it's a \"file\".obj", "fur", "-x"][dice.below(4)].into()),
        10 => model.edit("a", |s| s.transfer.stops[0].density = number),
        11 if !parameters.is_empty() => model.edit("a", |s| {
            let parameter = &parameters[dice.below(parameters.len())];
            let value = match parameter.kind {
                shader::ParameterKind::Number(_, [low, high]) => ParameterValue::Number(low + (high - low) * number),
                shader::ParameterKind::Color(_) => ParameterValue::Color(dice.color()),
            };
            s.parameters.insert(parameter.name.clone(), value);
        }),
        12 => model.add_part("torus").is_some(),
        13 if !parts.is_empty() => model.remove_part(&parts[dice.below(parts.len())]),
        14 if !parts.is_empty() => model.edit("a", |s| {
            let part = s.parts.values_mut().next().unwrap();
            (part.transform.turn[1], part.material.color, part.effect.medium) = (number, dice.color(), "lit".into());
        }),
        15 => model.edit("a", |s| (s.about, s.light.shadows, s.object.iso) = (" it's ".into(), true, Some(-number))),
        _ => model.take_preset(scene::names().nth(dice.below(26)).unwrap_or("fur"), number > 0.5),
    }
}

#[test]
fn the_command_line_of_random_edits_gives_the_same_scene() {
    for seed in 0..24 {
        let mut dice = Dice(SplitMix(seed));
        let name = scene::names().nth(seed as usize % 26).unwrap();
        let mut model = Model::new(preset(name).unwrap(), shader::shipped()).unwrap();
        for _ in 0..10 {
            edit(&mut model, &mut dice);
        }
        check(&model);
    }
}

#[test]
fn every_edit_is_undone_and_done_again() {
    for seed in 100..116 {
        let mut dice = Dice(SplitMix(seed));
        let mut model = Model::new(preset("fur").unwrap(), shader::shipped()).unwrap();
        let mut scenes = vec![model.scene().clone()];
        for _ in 0..40 {
            let good = edit(&mut model, &mut dice);
            model.end_undo_group();
            model.scene().check(model.library()).unwrap();
            if !good {
                assert_eq!(model.scene(), scenes.last().unwrap(), "what is refused changes nothing");
            } else if model.scene() != scenes.last().unwrap() {
                scenes.push(model.scene().clone());
            }
        }
        for scene in scenes.iter().rev().skip(1) {
            assert!(model.undo());
            assert_eq!(model.scene(), scene);
        }
        assert!(!model.undo());
        for scene in &scenes[1..] {
            assert!(model.redo());
            assert_eq!(model.scene(), scene);
        }
        assert!(!model.redo());
        model.undo();
        model.edit("a", |scene| scene.about = "another way".into());
        assert!(!model.redo(), "a new edit ends what could be done again");
    }
}
