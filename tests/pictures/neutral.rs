//! A parameter of 0 takes its terms with it, and the picture is the same bit for bit.

use crate::common::{is_whole, picture, subject, with_gpu};
use crate::random_scene::SplitMix;
use hypertexture::render::variant::{Program, Variant};
use hypertexture::render::{Frame, Renderer};
use hypertexture::scene::{ParameterValue, Pass, Scene, names, preset};
use hypertexture::shader::{self, Linker, ParameterKind};

/// A transfer map of one color and one opacity.
const FLAT: &str =
    r##"[{ at = 0.0, color = "#c8643c", density = 0.7 }, { at = 1.0, color = "#c8643c", density = 0.7 }]"##;

/// The values of a picture, bit for bit.
fn bits(frame: &Frame) -> Vec<u32> {
    frame.pixels.as_flattened().iter().map(|value| value.to_bits()).collect()
}

/// An example scene with some settings.
fn scene(effect: &str, settings: &[(&str, &str)]) -> Scene {
    let mut scene = preset(effect).expect("a shipped preset");
    for (key, value) in settings {
        scene.set_field(key, value).expect("a setting of the scene");
    }
    scene
}

/// The program of a scene, with the terms that come to nothing or without them.
fn program(scene: &Scene, folds: bool) -> Program {
    let (library, mut scene) = (shader::shipped(), scene.clone());
    scene.quality.fold_zero_terms = folds;
    let variant = Variant::of(&scene, &library).expect("a scene that is valid");
    variant.program(&library, Linker::new).expect("modules that can be linked")
}

#[test]
fn what_a_zero_takes_away_is_not_in_the_program() {
    for (effect, settings, idle) in [
        ("melting", &[("parameters.melt_time", "0")][..], &["noise_"][..]),
        ("fractal_sphere", &[("parameters.fractal_amplitude", "0")], &["noise_"]),
        ("noisy_sphere", &[("parameters.amplitude", "0")], &["noise_"]),
        ("fire", &[("parameters.relief", "0"), ("parameters.fury", "0")], &["noise_", "turbulence_"]),
        ("fur", &[("light.intensity", "0")], &["shadow_image"]),
        ("lit", &[("light.shadows", "true"), ("light.intensity", "0")], &["shadow_image"]),
        ("flow", &[("transfer.stops", FLAT)], &["transfer_image"]),
        ("solid", &[("transfer.stops", FLAT)], &["transfer_image"]),
        ("tank", &[("parts.turret.transfer.stops", FLAT)], &["transfer_image_turret"]),
    ] {
        let mut scene = scene(effect, settings);
        for pass in [Pass::Slices, Pass::March] {
            scene.quality.pass = pass;
            let [kept, left] = [false, true].map(|folds| program(&scene, folds));
            let reads =
                |of: &Program| of.resources.iter().any(|own| idle.iter().any(|name| own.name.starts_with(name)));
            assert!(reads(&kept) && !reads(&left), "{effect} {settings:?}");
            assert!(left.fragment.len() < kept.fragment.len(), "{effect} {settings:?}");
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_picture_without_what_comes_to_nothing_is_the_same() {
    // HYPERTEXTURE_SCENES=200 asks for as many scenes in which some parameters are 0.
    let count = std::env::var("HYPERTEXTURE_SCENES")
        .ok()
        .and_then(|count| count.parse().ok())
        .unwrap_or(if is_whole() { 24 } else { 8 });
    let (library, mut random) = (shader::shipped(), SplitMix(14));
    // Its programs take lavapipe seconds each.
    let presets: Vec<&str> = names().filter(|name| *name != "tank").collect();
    let (mut drawn, mut wrong) = (0, Vec::new());
    with_gpu(|gpu| {
        let mut index = 0;
        while drawn < count {
            let name = presets[index % presets.len()];
            let mut scene = preset(name).unwrap();
            let variant = Variant::of(&scene, &library).unwrap();
            let all: Vec<String> = variant
                .all_parameters()
                .filter_map(|(name, parameter, _)| match parameter.kind {
                    ParameterKind::Number(_, [low, high]) if low <= 0.0 && 0.0 <= high => Some(name),
                    _ => None,
                })
                .collect();
            if random.bits().is_multiple_of(3) {
                scene.set_field("transfer.stops", FLAT).expect("stops of a transfer map");
            }
            for name in &all {
                let key = match name.rsplit_once('.') {
                    Some((part, own)) => format!("{part}.parameters.{own}"),
                    None => format!("parameters.{name}"),
                };
                let mut other = scene.clone();
                let taken = random.bits() % 8 < if index < presets.len() { 7 } else { 3 };
                if taken && other.set_field(&key, "0").is_ok() && other.check(&library).is_ok() {
                    scene = other;
                }
            }
            index += 1;
            if scene.quality.pass == Pass::Slices && random.bits().is_multiple_of(2) {
                scene.quality.pass = Pass::March;
            }
            (scene.image.size, scene.quality.samples) = ([32, 32], 48);
            scene.object.resolution = scene.object.resolution.min(32);
            (scene.quality.supersampling, scene.light.shadow_resolution) = (1, 16);
            let is_less =
                |variant: &Variant| ["zero=", "transfer=flat"].iter().any(|part| variant.key().contains(part));
            if scene.check(&library).is_err() || !is_less(&Variant::of(&scene, &library).unwrap()) {
                continue;
            }
            let subject = subject(&scene, &library);
            let [kept, left] = [false, true].map(|folds| {
                scene.quality.fold_zero_terms = folds;
                picture(gpu, &library, &scene, &subject)
            });
            drawn += 1;
            let both = bits(&kept).into_iter().zip(bits(&left));
            let differ = both.filter(|(kept, left)| kept != left).count();
            if differ > 0 {
                wrong.push(format!("{name}: {differ} values, {}", left.measurements.modules));
            }
        }
    });
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_value_that_is_pulled_to_zero_keeps_its_program() {
    let library = shader::shipped();
    for (effect, parameter, value) in [("melting", "melt_time", 1.0), ("nebula", "turbulence_strength", 1.0)] {
        let mut scene = scene(effect, &[("effect.noise", "block"), ("quality.block_size", "16")]);
        (scene.quality.samples, scene.object.resolution) = (64, 32);
        let subject = subject(&scene, &library);
        with_gpu(|gpu| {
            let mut draw = |renderer: &mut Renderer, value: f32, side: u32| {
                scene.parameters.insert(parameter.into(), ParameterValue::Number(value));
                scene.image.size = [side; 2];
                let frame = renderer.render(&scene).expect("a picture");
                let anew = picture(gpu, &library, &scene, &subject);
                assert!(bits(&frame) == bits(&anew), "{effect}, {parameter} = {value}");
                frame.measurements
            };
            // The first picture is too small for cells: they are made for the one where the value is 0, and serve the next.
            let mut renderer = Renderer::new(gpu, &library, &subject);
            let pictures = [(value, 8), (0.0, 128), (value, 128)].map(|(value, side)| draw(&mut renderer, value, side));
            assert!(pictures.iter().all(|own| own.modules == pictures[0].modules), "{effect}");
            assert!(!pictures[0].modules.contains(parameter), "{effect}");
            let cells = pictures[1].cells.as_ref().expect("a program that reads cells");
            assert!(effect == "melting" || cells.side > 0, "{effect}: {cells:?}");
            // A program linked without the terms does not serve a scene with them.
            let mut renderer = Renderer::new(gpu, &library, &subject);
            let modules = [(0.0, 16), (value, 16)].map(|(value, side)| draw(&mut renderer, value, side).modules);
            assert!(modules[0].contains(parameter) && !modules[1].contains(parameter), "{modules:?}");
        });
    }
}
