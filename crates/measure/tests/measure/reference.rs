//! The reference: closed forms in every pixel, what it says of its own error, and that the device agrees with it.

use crate::common::{picture, subject, with_gpu};
use glam::DVec3;
use hypertexture::render::Subject;
use hypertexture::scene::{Curve, EFFECTS, Filter, Integration, Pass, Scene, names, parse, preset};
use hypertexture::shader::{self, Library};
use hypertexture_measure::cases::{self, AnalyticCase, rays};
use hypertexture_measure::reference::{TOLERANCE, reference, reference_pixels, truth_of};
use hypertexture_measure::validity::{TRUSTED, validity};

/// Light and estimate of every pixel.
fn found(library: &Library, scene: &Scene, subject: &Subject, tolerance: f64) -> Vec<([f64; 4], f64)> {
    let [width, height] = scene.image.size;
    let pixels: Vec<[u32; 2]> = (0..height).flat_map(|y| (0..width).map(move |x| [x, y])).collect();
    let truth = truth_of(scene, library).expect("modules");
    let reference =
        reference_pixels(library, &truth, subject, &pixels, tolerance, &|_| (), &|| false).expect("a reference");
    reference.pixels.into_iter().zip(reference.estimate).collect()
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, f64::max)
}

#[test]
fn closed_forms_hold_in_every_pixel_to_a_hundred_thousandth() {
    let library = cases::library();
    let cases = [cases::HOMOGENEOUS, cases::COLOR_BY_DEPTH, cases::SOFT_BALLS, cases::PERLIN_BALLS, cases::TWO_TONES];
    for case in cases.concat() {
        let (scene, subject) = case.in_pass(Pass::Slices);
        let AnalyticCase { truth, channel, variant: name, .. } = case;
        let found = found(&library, &scene, &subject, 1e-6);
        let known: Vec<(f64, f64)> = (found.iter().zip(rays(&scene, &subject)))
            .filter_map(|((pixel, estimate), ray)| Some(((pixel[channel] - truth(&ray)?).abs(), *estimate)))
            .collect();
        assert!(known.len() > 100, "{name}: {} pixels are known", known.len());
        let off = largest(known.iter().map(|known| known.0));
        println!("{name}: {off:.1e}, says {:.1e}", largest(known.iter().map(|known| known.1)));
        // The formulas of opacity have a relative error of 5e-7, in whatever precision they are evaluated; and the camera
        // is that of the device, rounded to f32, which a ray sees that grazes the edge of a ball.
        assert!(off < 1e-5, "{name}: {off:e}");
    }
}

#[test]
fn what_it_says_of_its_error_is_true() {
    let library = shader::shipped();
    for (name, object) in [("fire", "sphere"), ("fur", "torus"), ("melting", "torus"), ("fractal_sphere", "sphere")] {
        let mut scene = preset(name).unwrap();
        scene.object.input = object.into();
        scene.image.size = [24, 24];
        let subject = subject(&scene, &library);
        let [coarse, fine] =
            [TOLERANCE, 0.03 * TOLERANCE].map(|tolerance| found(&library, &scene, &subject, tolerance));
        let (mut off, mut beyond, mut said) = (0f64, 0, 0f64);
        for ((a, estimate), (b, finer)) in coarse.iter().zip(&fine) {
            let differs = largest((0..4).map(|c| (a[c] - b[c]).abs()));
            off = off.max(differs);
            said = said.max(*estimate);
            beyond += usize::from(differs > estimate + finer + 1e-7);
        }
        println!("{name}: {off:.1e} off, says {said:.1e}; {beyond} of {} pixels are beyond that", coarse.len());
        assert!(beyond * 100 <= coarse.len(), "{name}: {beyond} pixels are farther off than they say");
    }
}

/// A shell too thin for any sample, which bounds do not prove either: sin² + cos² is 1, and they do not know.
const SHELL: &str = "float shell(float density, Sample s) {
    float a = sin(80.0 * s.x.x), b = cos(80.0 * s.x.x);
    return 1.0 - step(5e-5, abs(length(s.x) - 0.9 + 0.2 * (a * a + b * b - 1.0)));
}";

/// A ray that meets a sphere meets its shell, however thin that is: where samples miss it, bounds leave it open, and where
/// drawings miss it, their pixels are not called sound.
#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn what_samples_miss_is_left_open() {
    with_gpu(|gpu| {
        let library = shader::shipped().with_module("dmf", "shell", SHELL);
        let text = "[object]\ninput = \"sphere\"\nouter_iso = 0.2\n[effect]\nclassify = \"soft\"\nsoftness = \"linear\"\n\
                    dmf = [\"shell\"]\n[image]\nsize = [48, 48]\n";
        let scene = parse(text, "scene").expect("a scene");
        let subject = subject(&scene, &library);
        let known = reference(&library, &scene, &subject, TOLERANCE, &|_| (), &|| false).expect("a reference");
        let frame = picture(gpu, &library, &scene, &subject);
        let mut validity = validity(gpu, &library, &scene, &subject, &frame);
        validity.add_open(&frame.pixels, Ok(&known));
        let (mut missed, mut wrong) = (0, 0);
        for (index, ray) in rays(&scene, &subject).iter().enumerate() {
            let impact = ray.impact();
            if (impact - 0.9).abs() < 1e-3 {
                continue; // at its rim
            }
            let truth = f64::from(u8::from(impact < 0.9));
            let off = (known.pixels[index][3] - truth).abs();
            let [estimate, open] = [known.estimate[index], known.open[index]];
            assert!(off <= estimate + open + 1e-6, "{index}: {off} is no part of {estimate} and {open}");
            missed += usize::from(off > estimate + 0.1);
            let is_wrong = (f64::from(frame.pixels[index][3]) - truth).abs() > TRUSTED;
            assert!(!is_wrong || validity.of[index].is_some(), "{index} is wrong, and called sound");
            wrong += usize::from(is_wrong);
        }
        println!("the reference misses the shell in {missed} pixels, the picture in {wrong}");
        assert!(missed > 20 && wrong > 100, "{missed} {wrong}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn the_device_comes_as_near_as_its_steps_allow_in_all_effects() {
    with_gpu(|gpu| {
        let library = shader::shipped();
        for effect in EFFECTS {
            let mut scene = preset(effect).unwrap();
            scene.object.input = "torus".into();
            scene.image.size = [32, 32];
            (scene.quality.pass, scene.quality.samples) = (Pass::March, 2048);
            if scene.check(&library).is_err() {
                scene.quality.pass = Pass::Slices;
            }
            // Of its own noise, block and all: what is left is the steps.
            let truth = truth_of(&scene, &library).unwrap();
            let mut drawn = truth;
            drawn.quality = scene.quality.clone();
            drawn.quality.pass = Pass::Slices;
            drawn.quality.integration = Integration::Segment;
            let subject = subject(&drawn, &library);
            let frame = picture(gpu, &library, &drawn, &subject);
            let found = found(&library, &drawn, &subject, TOLERANCE);
            let squares = frame
                .pixels
                .iter()
                .zip(&found)
                .flat_map(|(a, (b, _))| (0..4).map(|c| (f64::from(a[c]) - b[c]).powi(2)).collect::<Vec<_>>());
            let rmse = (squares.sum::<f64>() / (4 * found.len()) as f64).sqrt();
            println!("{effect}: RMSE {rmse:.1e}");
            assert!(rmse < 2e-3, "{effect}: {rmse:e}");
        }
    });
}

#[test]
fn every_preset_has_a_reference() {
    let library = shader::shipped();
    for name in names() {
        let mut scene = preset(name).unwrap();
        scene.object.resolution = scene.object.resolution.min(48);
        scene.image.size = [6, 6];
        let subject = subject(&scene, &library);
        let pixels: Vec<[u32; 2]> = (0..6).map(|x| [x, 3]).collect();
        let truth = truth_of(&scene, &library).unwrap();
        let found = reference_pixels(&library, &truth, &subject, &pixels, 1e-2, &|_| (), &|| false);
        if scene.light.translucency > 0.0 {
            let error = found.unwrap_err().to_string();
            assert!(error.contains("light.translucency is blurred from slice to slice"), "{name}: {error}");
            continue;
        }
        let found = found.unwrap_or_else(|error| panic!("{name}: {error}"));
        assert!(found.pixels.iter().flatten().all(|value| value.is_finite()), "{name}");
    }
}

#[test]
fn p28_rays_that_bend_are_known_better_than_the_device_can() {
    // In a Luneburg lens, parallel rays meet in a point behind it: in f32 they miss it by 3e-7.
    let library = cases::library();
    let mut scene = cases::clear("sphere", &[(0.0, 1.0), (1.0, 1.0)], Curve::Linear);
    scene.effect.index = "luneburg".into();
    let asked = |probe: &str| {
        let mut scene = scene.clone();
        scene.effect.environment = probe.into();
        let subject = subject(&scene, &library);
        (found(&library, &scene, &subject, 1e-9), rays(&scene, &subject))
    };
    let ((directions, rays), (moments, _)) = (asked("exit_direction"), asked("exit_moment"));
    let vector = |(light, _): &([f64; 4], f64)| DVec3::new(light[0], light[1], light[2]);
    let inside = rays.iter().zip(&directions).zip(&moments).filter(|((ray, _), _)| ray.impact() < 0.95);
    let miss = inside.map(|((ray, d), m)| cases::luneburg_miss(ray.along, [vector(d), vector(m)]));
    let miss = largest(miss);
    println!("miss {miss:.1e}");
    assert!(miss < 1e-7, "{miss:e}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p28_the_device_draws_the_glass_that_the_reference_has() {
    with_gpu(|gpu| {
        let library = shader::shipped();
        let mut scene = preset("blue_glass").unwrap();
        (scene.image.size, scene.quality.samples, scene.quality.msaa) = ([32, 32], 1024, 1);
        scene.quality.filter = Filter::precise(gpu.info().filters_by_few_bits());
        let subject = subject(&scene, &library);
        let frame = picture(gpu, &library, &scene, &subject);
        let found = found(&library, &scene, &subject, TOLERANCE);
        let off = |(a, (b, _)): (&[f32; 4], &([f64; 4], f64))| {
            (0..4).map(|c| (f64::from(a[c]) - b[c]).abs()).fold(0.0, f64::max)
        };
        let mut off: Vec<f64> = frame.pixels.iter().zip(&found).map(off).collect();
        off.sort_by(f64::total_cmp);
        let [median, most] = [0.5, 0.95].map(|part| off[(part * off.len() as f64) as usize]);
        let known = found.iter().filter(|(_, estimate)| *estimate <= TOLERANCE).count();
        println!(
            "half of the pixels within {median:.1e}, 95 % within {most:.1e}; {known} of {} are known",
            found.len()
        );
        // Total reflection makes much of a rounding, so a few pixels go their own way.
        assert!(median < 1e-4 && most < 1e-2 && known * 100 > 99 * found.len());
    });
}
