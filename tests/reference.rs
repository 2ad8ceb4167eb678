//! The reference pictures: closed forms in every pixel, and what they say about their own error.

mod common;

use common::{rays, subject, two_tone};
use hypertexture::glsl;
use hypertexture::reference::{TOLERANCE, reference_pixels};
use hypertexture::scene::{Pass, Projection, Rule, Scene, preset};
use std::time::Instant;

fn all(scene: &Scene) -> Vec<[u32; 2]> {
    let [width, height] = scene.image.size;
    (0..height).flat_map(|y| (0..width).map(move |x| [x, y])).collect()
}

#[test]
fn truth_5_the_two_tone_sphere() {
    let library = two_tone::library();
    for projection in [Projection::Parallel, Projection::Perspective] {
        let scene = two_tone::scene(Rule::Point, Pass::Slices, projection);
        let subject = subject(&scene, &library);
        let start = Instant::now();
        let found = reference_pixels(&library, &scene, &subject, &all(&scene), TOLERANCE, &|_| ()).unwrap();
        println!("{projection:?}: {:.2} s", start.elapsed().as_secs_f64());
        let (mut worst, mut largest) = (0f64, 0f64);
        for ((pixel, estimate), ray) in found.pixels.iter().zip(&found.estimate).zip(rays(&scene, &subject)) {
            let b = ray.impact();
            let t = if b < two_tone::OUTER { two_tone::transmittance(b) } else { 1.0 };
            let core = b < two_tone::INNER;
            let exact = [1.0, 1.0 - t, 1.0 - t, 1.0].map(|v| v);
            let alpha = if core { 1.0 } else { 1.0 - t };
            let exact = if core { exact } else { [1.0 - t; 4] };
            let off = (0..4).map(|c| (pixel[c] - [exact[0], exact[1], exact[2], alpha][c]).abs()).fold(0.0, f64::max);
            worst = worst.max(off);
            largest = largest.max(*estimate);
        }
        println!("worst {worst:e}, largest estimate {largest:e}");
    }
}

#[test]
fn timing() {
    let library = glsl::shipped();
    for name in hypertexture::scene::names() {
        let mut scene = preset(name).unwrap();
        scene.image.size = [128, 128];
        let subject = subject(&scene, &library);
        let start = Instant::now();
        let found = match reference_pixels(&library, &scene, &subject, &all(&scene), TOLERANCE, &|_| ()) {
            Ok(f) => f,
            Err(e) => {
                println!("{name}: {e}");
                continue;
            }
        };
        let rms = (found.estimate.iter().map(|e| e * e).sum::<f64>() / found.estimate.len() as f64).sqrt();
        let max = found.estimate.iter().copied().fold(0.0, f64::max);
        println!("{name}: {:.2} s, estimate rms {rms:.1e} max {max:.1e}", start.elapsed().as_secs_f64());
    }
}

#[test]
fn debug_lit() {
    use hypertexture::render::render;
    let library = glsl::shipped();
    for object in ["torus", "sphere", "cube", "teapot"] {
        let mut scene = preset("lit").unwrap();
        scene.object.input = object.into();
        scene.image.size = [96, 96];
        scene.quality.samples = 1024;
        scene.quality.pass = Pass::March;
        scene.quality.rule = Rule::Segment;
        let subject = subject(&scene, &library);
        let found = reference_pixels(&library, &scene, &subject, &all(&scene), TOLERANCE, &|_| ()).unwrap();
        common::with_gpu(|gpu| {
            let frame = render(gpu, &library, &scene, &subject).unwrap();
            let diff: Vec<f64> = frame
                .pixels
                .iter()
                .zip(&found.pixels)
                .map(|(a, b)| (0..4).map(|c| (f64::from(a[c]) - b[c]).abs()).fold(0.0, f64::max))
                .collect();
            let rms = (diff.iter().map(|d| d * d).sum::<f64>() / diff.len() as f64).sqrt();
            let (i, d) = diff.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).unwrap();
            println!(
                "{object}: rms {rms:e}, worst {d} at {} {}: {:?} {:?}; over 1e-3: {}, 0.1: {}",
                i % 96,
                i / 96,
                frame.pixels[i],
                found.pixels[i],
                diff.iter().filter(|d| **d > 1e-3).count(),
                diff.iter().filter(|d| **d > 0.1).count()
            );
        });
    }
}
