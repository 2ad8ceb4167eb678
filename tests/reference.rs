//! The reference: closed forms in every pixel, what it says of its own error, and that the device agrees with it.

mod common;

use common::{picture, subject, with_gpu};
use hypertexture::glsl::{self, Library};
use hypertexture::reference::{TOLERANCE, reference_pixels, truth_of};
use hypertexture::render::Subject;
use hypertexture::scene::{EFFECTS, Pass, Rule, Scene, names, preset};
use hypertexture::verify::{self, Known, rays};

/// Light and estimate of every pixel.
fn found(library: &Library, scene: &Scene, subject: &Subject, tolerance: f64) -> Vec<([f64; 4], f64)> {
    let [width, height] = scene.image.size;
    let pixels: Vec<[u32; 2]> = (0..height).flat_map(|y| (0..width).map(move |x| [x, y])).collect();
    let truth = truth_of(scene, library).expect("modules");
    let reference = reference_pixels(library, &truth, subject, &pixels, tolerance, &|_| ()).expect("a reference");
    reference.pixels.into_iter().zip(reference.estimate).collect()
}

fn largest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(0.0, f64::max)
}

#[test]
fn closed_forms_hold_in_every_pixel_to_a_hundred_thousandth() {
    let library = verify::library();
    let cases =
        [verify::HOMOGENEOUS, verify::COLOR_BY_DEPTH, verify::SOFT_BALLS, verify::PERLIN_BALLS, verify::TWO_TONES];
    for case in cases.concat() {
        let (scene, subject) = case.in_pass(Pass::Slices);
        let Known { truth, channel, variant: name, .. } = case;
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
    let library = glsl::shipped();
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

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn the_device_comes_as_near_as_its_steps_allow_in_all_effects() {
    with_gpu(|gpu| {
        let library = glsl::shipped();
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
            drawn.quality.rule = Rule::Segment;
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
fn every_preset_with_straight_rays_has_a_reference() {
    let library = glsl::shipped();
    for name in names() {
        let mut scene = preset(name).unwrap();
        scene.object.resolution = scene.object.resolution.min(48);
        scene.image.size = [6, 6];
        let subject = subject(&scene, &library);
        let pixels: Vec<[u32; 2]> = (0..6).map(|x| [x, 3]).collect();
        match reference_pixels(&library, &truth_of(&scene, &library).unwrap(), &subject, &pixels, 1e-2, &|_| ()) {
            Ok(found) => assert!(found.pixels.iter().flatten().all(|value| value.is_finite()), "{name}"),
            Err(error) => assert!(name == "blue_glass", "{name}: {error}"),
        }
    }
}
