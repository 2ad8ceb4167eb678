//! Values of modules at more than 10^4 points, as colors of a picture.

#![allow(dead_code, reason = "each file of tests uses its part of this")]

use super::common::{homogeneous, picture, rays, subject};
use glam::DVec3;
use hypertexture::gpu::Gpu;
use hypertexture::render::variant::Variant;
use hypertexture::scene::{ParameterValue, Projection, Scene};
use hypertexture::shader::{self, Library};

/// Half the side of the square that a probe shows.
const SIDE: f64 = 0.99;

/// Colors of a surface module on the front face of a cube, at more than 10^4 points (x, y); the face is found to one
/// slice, so that probes put a z of their own, 0.37, in its place.
pub fn seen(gpu: &Gpu, text: &str, change: impl FnOnce(&mut Scene)) -> Vec<(DVec3, DVec3)> {
    seen_with(gpu, &shader::shipped(), text, change)
}

/// The same with modules of a library.
pub fn seen_with(gpu: &Gpu, library: &Library, text: &str, change: impl FnOnce(&mut Scene)) -> Vec<(DVec3, DVec3)> {
    let mut scene = homogeneous("cube", 1.0, Projection::Parallel);
    scene.effect.classify = "surface".into();
    scene.effect.surface = "probe".into();
    scene.effect.noise = "procedural".into();
    scene.effect.turbulence = "procedural".into();
    scene.image.size = [256, 256];
    change(&mut scene);
    let library = library.clone().with_module("surface", "probe", text);
    let subject = subject(&scene, &library);
    // The camera fits the soft region; nearer, every scene shows the same square.
    let outer = Variant::of(&scene, &library).expect("a valid scene").parameters.outer_iso();
    scene.object.outer_iso = outer.unwrap_or(scene.object.outer_iso);
    if scene.effect.softness != "hard" {
        scene.camera.zoom *= (0.8 / 0.97 * (subject.radius + scene.object.outer_iso) / subject.radius).max(1.0);
    }
    let frame = picture(gpu, &library, &scene, &subject);
    let pixels = rays(&scene, &subject).into_iter().zip(&frame.pixels);
    let pixels = pixels.filter(|(ray, _)| ray.from.x.abs().max(ray.from.y.abs()) < SIDE);
    let seen: Vec<_> = pixels
        .map(|(ray, pixel)| {
            let place = DVec3::new(ray.from.x, ray.from.y, 0.37);
            (place, DVec3::from([0, 1, 2].map(|c| f64::from(pixel[c]))))
        })
        .collect();
    assert!(seen.len() > 10_000, "{} points", seen.len());
    seen
}

pub fn set(scene: &mut Scene, parameters: &[(&str, f32)]) {
    scene.parameters.extend(parameters.iter().map(|(name, value)| (name.to_string(), ParameterValue::Number(*value))));
}

/// The largest error of any channel.
pub fn worst(seen: &[(DVec3, DVec3)], expected: impl Fn(DVec3) -> DVec3) -> f64 {
    seen.iter().map(|(x, color)| (*color - expected(*x)).abs().max_element()).fold(0.0, f64::max)
}
