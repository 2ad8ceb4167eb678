//! What rays cost: run with `cargo bench --bench march`, a minute or so on two cores.
//!
//! What is compared is measured in turns, so that a change of the machine's speed meets all sides. Times are
//! milliseconds on the device, median (lowest-highest). Rays against slices are in `slices.rs`.
#![expect(clippy::unwrap_used, reason = "a bench stops where something is not as described")]

#[path = "common/mod.rs"]
mod bench;
#[path = "../tests/common/mod.rs"]
mod common;
#[path = "march/peer.rs"]
mod peer;

use bench::Spread;
use hypertexture::gpu::Gpu;
use hypertexture::measure::verify;
use hypertexture::render::{Frame, Renderer, Subject};
use hypertexture::scene::{self, EmptySpace, Integration, Pass, Projection, Scene};
use hypertexture::shader::{self, Library};
use std::time::Instant;

const REPEATS: usize = 5;
const SIZE: u32 = 256;
const SAMPLES: u32 = 128;
const RESOLUTION: u32 = 128;

/// An effect as rays.
fn scene_of(effect: &str, object: &str) -> Scene {
    let mut scene = scene::preset(effect).unwrap();
    (scene.object.input, scene.object.resolution) = (object.into(), RESOLUTION);
    scene.image.size = [SIZE; 2];
    (scene.quality.pass, scene.quality.samples) = (Pass::March, SAMPLES);
    scene
}

/// Milliseconds of each scene, in turns, and the first frame of each.
fn measure(gpu: &Gpu, library: &Library, cases: &[(Scene, &Subject)]) -> (Vec<Vec<f64>>, Vec<Frame>) {
    let mut renderers: Vec<Renderer> = cases.iter().map(|(_, subject)| Renderer::new(gpu, library, subject)).collect();
    let mut times = vec![Vec::new(); cases.len()];
    let mut frames = Vec::new();
    for repeat in 0..REPEATS {
        for ((renderer, (scene, _)), times) in renderers.iter_mut().zip(cases).zip(&mut times) {
            let frame = renderer.render(scene).unwrap();
            times.push(frame.measurements.gpu_ms);
            if repeat == 0 {
                frames.push(frame);
            }
        }
    }
    (times, frames)
}

/// The samples that the distance shows to be empty, left out or not.
fn skipping(gpu: &Gpu, library: &Library) {
    println!("\nEvery step against skipping on the teapot, ms: equal error, for every bit of the pictures is the same");
    println!("{:<6} {:>6} {:>24} {:>24} {:>18}", "", "steps", "every step", "skipping", "every/skipping");
    for effect in ["lit", "fur", "fire"] {
        let mut scene = scene_of(effect, "teapot");
        scene.light.shadows = false; // the volume of shadows is the same for both, and not of the rays
        let subject = common::subject(&scene, library);
        for samples in [128, 256, 512] {
            let cases = [EmptySpace::Sample, EmptySpace::Skip].map(|empty_space| {
                let mut scene = scene.clone();
                (scene.quality.empty_space, scene.quality.samples) = (empty_space, samples);
                (scene, &subject)
            });
            let (times, frames) = measure(gpu, library, &cases);
            let bits = |frame: &Frame| frame.pixels.as_flattened().iter().map(|c| c.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&frames[0]), bits(&frames[1]), "{effect}, {samples} steps: skipping changes the picture");
            let ratio = Spread::ratio(&times[0], &times[1]);
            let [fixed, skip] = [0, 1].map(|side: usize| Spread::of(times[side].clone()));
            println!("{effect:<6} {samples:>6} {fixed:>24.1} {skip:>24.1} {ratio:>18.2}");
        }
    }
}

/// The value at `x` of a curve that is straight in logarithms between points of falling `xs`; none beyond its ends.
fn interpolate(xs: &[f64], ys: &[f64], x: f64) -> Option<f64> {
    let after = xs.windows(2).position(|pair| pair[0] >= x && x >= pair[1])?;
    let part = (xs[after] / x).ln() / (xs[after] / xs[after + 1]).ln();
    Some(ys[after] * (ys[after + 1] / ys[after]).powf(part))
}

fn integrations(gpu: &Gpu) {
    const STEPS: [u32; 8] = [8, 16, 32, 64, 128, 256, 512, 1024];
    println!("\nPoints against segments: two-tone soft sphere (truth 5), mean absolute error of a pixel and ms");
    println!(
        "{:>6} {:>12} {:>20} {:>12} {:>20} {:>30}",
        "steps", "points", "ms", "segments", "ms", "points/segments at this error"
    );
    let library = verify::library();
    let scenes = [Integration::Point, Integration::Segment].map(|integration| {
        STEPS.map(|steps| {
            let mut scene = verify::two_tone(integration);
            (scene.quality.pass, scene.camera.projection) = (Pass::March, Projection::Parallel);
            (scene.image.size, scene.quality.samples) = ([SIZE; 2], steps);
            scene
        })
    });
    let subject = common::subject(&scenes[0][0], &library);
    let rays = common::rays(&scenes[0][0], &subject);
    let cases: Vec<(Scene, &Subject)> = scenes.into_iter().flatten().map(|scene| (scene, &subject)).collect();
    let (times, frames) = measure(gpu, &library, &cases);
    let error = |frame: &Frame| {
        let off = rays.iter().zip(&frame.pixels).filter(|(ray, _)| ray.impact() < verify::TWO_TONE.outer);
        let off: Vec<f64> = off
            .map(|(ray, pixel)| (f64::from(pixel[1]) - (1.0 - verify::TWO_TONE.perlin(ray.impact()))).abs())
            .collect();
        off.iter().sum::<f64>() / off.len() as f64
    };
    let errors: Vec<f64> = frames.iter().map(error).collect();
    let (point, segment) = errors.split_at(STEPS.len());
    for (row, steps) in STEPS.iter().enumerate() {
        // In each turn by itself: the time of segments at the error of these points.
        let ratio = |repeat: usize| {
            let curve: Vec<f64> = times[STEPS.len()..].iter().map(|times| times[repeat]).collect();
            Some(times[row][repeat] / interpolate(segment, &curve, point[row])?)
        };
        let ratios: Option<Vec<f64>> = (0..REPEATS).map(ratio).collect();
        let ratio = ratios.map_or("-".into(), |ratios| format!("{:.2}", Spread::of(ratios)));
        let [points, segments] = [row, row + STEPS.len()].map(|row| Spread::of(times[row].clone()));
        println!(
            "{steps:>6} {:>12.2e} {points:>20.1} {:>12.2e} {segments:>20.1} {ratio:>30}",
            point[row], segment[row]
        );
    }
    println!("-: no number of segments in the table has so large an error.");
}

/// A table of what grows with one number.
fn growth(gpu: &Gpu, library: &Library, title: &str, rows: &[(u32, Scene, &Subject)]) {
    println!("\n{title}, ms");
    println!("{:>6} {:>24} {:>22}", "", "ms", "of the row before");
    let cases: Vec<(Scene, &Subject)> = rows.iter().map(|(_, scene, subject)| (scene.clone(), *subject)).collect();
    let (times, _) = measure(gpu, library, &cases);
    for (index, (value, ..)) in rows.iter().enumerate() {
        let before = index.checked_sub(1).map(|before| &times[before]);
        let factor = before.map_or("-".into(), |before| format!("{:.2}", Spread::ratio(&times[index], before)));
        println!("{value:>6} {:>24.1} {factor:>22}", Spread::of(times[index].clone()));
    }
}

fn sweeps(gpu: &Gpu, library: &Library) {
    let fire = scene_of("fire", "teapot");
    let teapot = common::subject(&fire, library);
    let vary = |values: &[u32], change: &dyn Fn(&mut Scene, u32)| {
        let vary = |&value: &u32| {
            let mut scene = fire.clone();
            change(&mut scene, value);
            (value, scene, &teapot)
        };
        values.iter().map(vary).collect::<Vec<_>>()
    };
    let octaves = vary(&[1, 2, 4, 6, 8], &|scene, octaves| {
        (scene.effect.noise, scene.effect.turbulence) = ("procedural".into(), "procedural".into());
        (scene.effect.octaves, scene.image.size) = (octaves, [SIZE / 2; 2]);
    });
    let title = format!("Octaves of procedural turbulence: fire on the teapot, {0} x {0}, {SAMPLES} steps", SIZE / 2);
    growth(gpu, library, &title, &octaves);
    let steps = vary(&[64, 128, 256, 512, 1024], &|scene, steps| {
        (scene.quality.samples, scene.quality.empty_space) = (steps, EmptySpace::Sample);
        scene.image.size = [SIZE / 2; 2];
    });
    growth(gpu, library, &format!("Steps, none skipped over: fire on the teapot, {0} x {0}", SIZE / 2), &steps);
    let sides = vary(&[128, 256, 512, 1024], &|scene, side| {
        (scene.image.size, scene.quality.samples) = ([side; 2], SAMPLES / 2);
    });
    growth(gpu, library, &format!("Pixels along a side: fire on the teapot, {} steps", SAMPLES / 2), &sides);

    let prepared = [32, 64, 128, 256].map(|voxels| {
        let mut scene = scene_of("lit", "knot");
        scene.object.resolution = voxels;
        let subject = common::subject(&scene, library);
        (voxels, scene, subject)
    });
    let voxels: Vec<_> = prepared.iter().map(|(voxels, scene, subject)| (*voxels, scene.clone(), subject)).collect();
    growth(gpu, library, &format!("Voxels along a side: the lit knot, {SIZE} x {SIZE}, {SAMPLES} steps"), &voxels);
}

fn main() {
    let start = Instant::now();
    let gpu = bench::open();
    let library = shader::shipped();
    println!("{SIZE} x {SIZE} pixels, {SAMPLES} steps, {REPEATS} repeats in turns: median (lowest-highest)");
    // `cargo bench --bench march -- peer` measures that alone.
    let chosen: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    let wanted = |part: &str| chosen.is_empty() || chosen.iter().any(|name| name == part);
    let parts: [(&str, &dyn Fn()); 4] = [
        ("skipping", &|| skipping(&gpu, &library)),
        ("integrations", &|| integrations(&gpu)),
        ("sweeps", &|| sweeps(&gpu, &library)),
        ("peer", &|| peer::compare(&gpu)),
    ];
    parts.iter().filter(|(name, _)| wanted(name)).for_each(|(_, part)| part());
    println!("\n{:.0} s in all", start.elapsed().as_secs_f64());
}
