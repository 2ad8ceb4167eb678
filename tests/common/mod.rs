//! What the tests of pictures share: a device under validation, scenes with a known answer, and the rays of a picture.

#![allow(dead_code, reason = "each file of tests uses its part of this")]

pub mod two_tone;

use glam::{DVec3, Vec3};
use hypertexture::glsl::{self, Library};
use hypertexture::gpu::{Gpu, Options};
use hypertexture::render::{Frame, Subject, render};
use hypertexture::scene::{Color, Projection, Scene};
use std::collections::BTreeMap;

/// The object fills this part of a picture's height at zoom 1.
const FILL: f64 = 0.8;

/// Runs a test on a device with validation, closes the device, and fails on whatever the layer has reported until then.
pub fn with_gpu<T>(test: impl FnOnce(&Gpu) -> T) -> T {
    let device = std::env::var("HYPERTEXTURE_DEVICE").ok();
    let options = Options { device, validation: true, cache: None };
    let gpu =
        Gpu::new(&options).unwrap_or_else(|error| panic!("{error}; HYPERTEXTURE_NO_GPU=1 leaves these tests out"));
    let messages = gpu.messages();
    let result = test(&gpu);
    drop(gpu);
    let said = messages.take();
    assert!(said.is_empty(), "{} validation messages:\n{}", said.len(), said.join("\n"));
    result
}

/// A homogeneous white object with Beer-Lambert opacity, seen along -z: small, unlit, one modulated density.
pub fn homogeneous(object: &str, rate: f32, projection: Projection) -> Scene {
    let mut scene = Scene::default();
    scene.object.input = object.into();
    scene.effect.classify = "soft".into();
    scene.effect.surface = "unlit".into();
    scene.effect.opacity = "beer".into();
    scene.effect.opacity_rate = rate;
    scene.material.color = Color([255; 3]);
    scene.camera.projection = projection;
    scene.camera.azimuth = 0.0;
    scene.camera.elevation = 0.0;
    scene.image.size = [64, 64];
    scene
}

/// The subject of a scene whose object is a formula.
pub fn formula(scene: &Scene) -> Subject {
    subject(scene, &glsl::shipped())
}

/// The subject of a scene.
pub fn subject(scene: &Scene, library: &Library) -> Subject {
    Subject::load(scene, library, &|_| {}).unwrap_or_else(|error| panic!("{error}"))
}

/// A box with these half sides around the origin, of which the cube's formula is the inside.
///
/// The stack of slices spans the box's diagonal: with half sides (2, 2, 1) / 3 it is [-1, 1], so that a face can lie
/// between two slices.
pub fn box_subject(half_size: Vec3) -> Subject {
    let (center, scale, radius) = (Vec3::ZERO, 1.0, 1.0);
    let parts = BTreeMap::new();
    Subject { input: "cube".into(), field: None, closest: None, center, scale, half_size, radius, report: None, parts }
}

/// Renders a scene that must render.
pub fn picture(gpu: &Gpu, library: &Library, scene: &Scene, subject: &Subject) -> Frame {
    render(gpu, library, scene, subject).unwrap_or_else(|error| panic!("{error}"))
}

/// The ray through the center of a pixel: a point, and a unit vector. Object space of azimuth 0 and elevation 0.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    pub from: DVec3,
    pub along: DVec3,
}

impl Ray {
    /// Distance from the origin.
    pub fn impact(&self) -> f64 {
        self.from.cross(self.along).length()
    }

    /// Path length over depth.
    pub fn slant(&self) -> f64 {
        -1.0 / self.along.z
    }

    /// Where the ray crosses a plane of constant z.
    pub fn at(&self, z: f64) -> DVec3 {
        self.from + self.along * ((z - self.from.z) / self.along.z)
    }
}

/// The rays of a picture, in the order of its pixels.
pub fn rays(scene: &Scene, subject: &Subject) -> Vec<Ray> {
    let camera = &scene.camera;
    let [width, height] = scene.image.size.map(f64::from);
    let (aspect, fit) = (width / height, (width / height).min(1.0));
    let half_height = f64::from(subject.radius) / FILL / f64::from(camera.zoom) / fit;
    let half_angle = 0.5 * f64::from(camera.field_of_view).to_radians();
    let pixel = |index: u32| {
        let [columns, _] = scene.image.size;
        let x = 2.0 * (f64::from(index % columns) + 0.5) / width - 1.0;
        let y = 1.0 - 2.0 * (f64::from(index / columns) + 0.5) / height;
        match camera.projection {
            Projection::Parallel => {
                Ray { from: DVec3::new(x * aspect * half_height, y * half_height, 0.0), along: DVec3::NEG_Z }
            }
            Projection::Perspective => {
                let along = DVec3::new(x * aspect * half_angle.tan(), y * half_angle.tan(), -1.0).normalize();
                Ray { from: DVec3::new(0.0, 0.0, half_height / half_angle.sin()), along }
            }
        }
    };
    (0..scene.image.size[0] * scene.image.size[1]).map(pixel).collect()
}

/// Largest and mean absolute error of one rendering.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    pub samples: u32,
    pub step: f64,
    pub max: f64,
    pub mean: f64,
}

/// Renders with each number of samples and compares a channel with what `expected` says of a ray; rays of which it says
/// nothing do not count. Prints the table.
pub fn errors(
    gpu: &Gpu,
    library: &Library,
    (scene, subject): (&Scene, &Subject),
    samples: &[u32],
    channel: usize,
    expected: impl Fn(&Ray) -> Option<f64>,
) -> Vec<Row> {
    let rays = rays(scene, subject);
    let truth: Vec<(usize, f64)> = rays.iter().enumerate().filter_map(|(i, ray)| Some((i, expected(ray)?))).collect();
    assert!(truth.len() > 100, "only {} rays have a known answer", truth.len());
    println!("{:?}\n    N  max error  mean error  order", scene.camera.projection);
    let mut rows: Vec<Row> = Vec::new();
    for &samples in samples {
        let mut scene = scene.clone();
        scene.quality.samples = samples;
        let frame = picture(gpu, library, &scene, subject);
        let off: Vec<f64> =
            truth.iter().map(|(i, truth)| (f64::from(frame.pixels[*i][channel]) - truth).abs()).collect();
        let (max, mean) = (off.iter().copied().fold(0.0, f64::max), off.iter().sum::<f64>() / off.len() as f64);
        let row = Row { samples, step: f64::from(frame.measurements.step), max, mean };
        let above_rounding = rows.last().filter(|_| row.mean > 2e-7);
        let order = above_rounding.map_or(String::new(), |last| format!("{:6.2}", order(last, &row)));
        println!("{samples:5}  {max:.3e}   {mean:.3e}  {order}");
        rows.push(row);
    }
    rows
}

/// The observed order of the mean error between two renderings.
pub fn order(coarse: &Row, fine: &Row) -> f64 {
    (coarse.mean / fine.mean).ln() / (f64::from(fine.samples) / f64::from(coarse.samples)).ln()
}

/// Largest and root-mean-square difference of two pictures, over all channels.
pub fn difference(a: &Frame, b: &Frame) -> (f64, f64) {
    assert_eq!(a.size, b.size);
    let channels = a.pixels.as_flattened().iter().zip(b.pixels.as_flattened());
    let (max, sum) =
        channels.map(|(a, b)| f64::from(a - b).abs()).fold((0.0f64, 0.0), |(m, s), d| (m.max(d), s + d * d));
    (max, (sum / (4 * a.pixels.len()) as f64).sqrt())
}
