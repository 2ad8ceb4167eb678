//! Points against segments by error and run time, and a hand-written fire ball: run with `cargo bench --bench march`. What
//! effects and scenes cost, `hypertexture bench` says.
//!
//! Alternatives are measured alternately, so that a change of the machine's speed meets all of them. Times are
//! milliseconds on the device, median (lowest-highest).
#![expect(clippy::unwrap_used, reason = "a bench stops where something is not as described")]

#[path = "common/mod.rs"]
mod bench;
#[path = "../tests/common/mod.rs"]
mod common;
#[path = "march/peer.rs"]
mod peer;

use bench::Spread;
use hypertexture::gpu::Gpu;
use hypertexture::render::{Frame, Renderer, Subject};
use hypertexture::scene::{Integration, Pass, Projection, Scene};
use hypertexture::shader::Library;
use measure::verify;
use std::time::Instant;

const REPEATS: usize = 5;
const SIZE: u32 = 256;

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

fn main() {
    let start = Instant::now();
    let gpu = bench::open();
    println!("{SIZE} x {SIZE} pixels, {REPEATS} repeats in turns: median (lowest-highest)");
    // `cargo bench --bench march -- peer` measures that alone.
    let chosen: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    let wanted = |part: &str| chosen.is_empty() || chosen.iter().any(|name| name == part);
    let parts: [(&str, &dyn Fn()); 2] = [("integrations", &|| integrations(&gpu)), ("peer", &|| peer::compare(&gpu))];
    parts.iter().filter(|(name, _)| wanted(name)).for_each(|(_, part)| part());
    println!("\n{:.0} s in all", start.elapsed().as_secs_f64());
}
