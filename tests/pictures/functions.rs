//! GLSL functions against their definitions in f64: each is drawn on the front face of a cube, or of an ellipsoid.

use crate::common::{formula, homogeneous, picture, rays, subject, with_gpu};
use glam::{DMat3, DVec3, Vec3};
use hypertexture::field::{DistanceField, Grid};
use hypertexture::gpu::Gpu;
use hypertexture::noise::{Lattice, Period, Weights};
use hypertexture::render::{Frame, Subject};
use hypertexture::scene::{FieldEncoding, Filter, Projection, Scene};
use hypertexture::shader::{self, Library};
use std::sync::Arc;

/// An opaque cube seen along -z in parallel projection, its face colored by a module.
fn probe(module: &str, text: &str) -> (Scene, Library) {
    let mut scene = homogeneous("cube", 1.0, Projection::Parallel);
    scene.effect.classify = "surface".into();
    scene.effect.surface = module.into();
    (scene, shader::shipped().with_module("surface", module, text))
}

/// Pixels of the front face, with their place on it.
fn face(gpu: &Gpu, library: &Library, scene: &Scene, subject: &Subject) -> Vec<(DVec3, [f64; 3])> {
    let frame: Frame = picture(gpu, library, scene, subject);
    let inside = |p: DVec3| p.x.abs().max(p.y.abs()) < 0.99;
    let pixels = rays(scene, subject).into_iter().zip(&frame.pixels).filter(|(ray, _)| inside(ray.from));
    let seen: Vec<_> = pixels.map(|(ray, pixel)| (ray.from, [0, 1, 2].map(|c| f64::from(pixel[c])))).collect();
    assert!(seen.len() > 400, "only {} pixels show the face", seen.len());
    seen
}

/// The largest error of a channel, where `expected` knows the answer.
fn worst(seen: &[(DVec3, [f64; 3])], channel: usize, expected: impl Fn(DVec3) -> f64) -> f64 {
    seen.iter().map(|(p, color)| (color[channel] - expected(*p)).abs()).fold(0.0, f64::max)
}

fn bias(b: f64, t: f64) -> f64 {
    t.powf(b.ln() / 0.5f64.ln())
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m15_bias_and_gain_are_their_definitions() {
    with_gpu(|gpu| {
        let (scene, library) = probe("shaping_probe", include_str!("../glsl/shaping_probe.glsl"));
        let seen = face(gpu, &library, &scene, &subject(&scene, &library));
        let off = worst(&seen, 0, |p| bias(0.5 + 0.5 * p.y, 0.5 + 0.5 * p.x));
        assert!(off <= 4e-6, "bias: {off:e}");
        let gain = |g: f64, t: f64| match t < 0.5 {
            true => 0.5 * bias(1.0 - g, 2.0 * t),
            false => 1.0 - 0.5 * bias(1.0 - g, 2.0 - 2.0 * t),
        };
        let off = worst(&seen, 1, |p| gain(0.5 + 0.5 * p.y, 0.5 + 0.5 * p.x));
        assert!(off <= 4e-6, "gain: {off:e}");
        let off = worst(&seen, 2, |p| 0.5 + 0.5 * p.x);
        assert!(off <= 1e-6, "the place itself: {off:e}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m14_the_blocks_hold_the_noise_and_turbulence_of_the_cpu() {
    with_gpu(|gpu| {
        for (size, bounds, weights, name) in [
            (64, [0.08, 0.09], Weights::Quintic, "quintic"),
            (128, [0.08, 0.05], Weights::Quintic, "quintic"),
            (64, [0.08, 0.09], Weights::Cubic, "cubic"),
        ] {
            let noise = Lattice { weights };
            let (mut scene, library) = probe("noise_probe", include_str!("../glsl/noise_probe.glsl"));
            scene.quality.block_size = size;
            scene.effect.weights = name.into();
            let seen = face(gpu, &library, &scene, &subject(&scene, &library));
            let at = |p: DVec3| [3.0 * p.x, 3.0 * p.y, 0.37];
            // Four texels hold a cell of the noise, so the trilinear filter is off by some percent of its bend; the
            // turbulence has creases, but more texels for its first octaves.
            let off = worst(&seen, 0, |p| 0.5 + 0.5 * noise.sample(at(p), size / 4).1);
            assert!(off <= 0.5 * bounds[0], "noise of {size}^3: {off:e}");
            let octaves = (0..8u32).take_while(|octave| (4 << octave) * 2 <= size).count() as u32;
            let off = worst(&seen, 1, |p| 0.5 * noise.turbulence(at(p), Period::growing(4), octaves).1);
            assert!(off <= 0.5 * bounds[1], "turbulence of {size}^3: {off:e}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m12_a_stack_of_three_dmfs_is_their_composition() {
    let dmfs = [
        ("halve", include_str!("../glsl/halve.glsl")),
        ("raise", include_str!("../glsl/raise.glsl")),
        ("square", include_str!("../glsl/square.glsl")),
    ];
    let library =
        dmfs.into_iter().fold(shader::shipped(), |library, (name, text)| library.with_module("dmf", name, text));
    let apply = |name: &str, density: f64| match name {
        "halve" => 0.5 * density,
        "raise" => density + 0.3,
        _ => density * density,
    };
    with_gpu(|gpu| {
        for order in [["halve", "raise", "square"], ["square", "raise", "halve"], ["raise", "halve", "square"]] {
            let mut scene = homogeneous("cube", 0.7, Projection::Parallel);
            scene.effect.dmf = order.map(String::from).to_vec();
            let density = order.iter().fold(1.0, |density, name| apply(name, density)).min(1.0);
            let subject = subject(&scene, &library);
            let frame = picture(gpu, &library, &scene, &subject);
            let rays = rays(&scene, &subject);
            let center = rays.iter().position(|ray| ray.from.length() < 0.1).expect("a ray through the middle");
            let expected = 1.0 - (-0.7 * density * 2.0f64).exp();
            let bound = 2.0 * 0.7 * f64::from(frame.measurements.step); // a face is found to one slice
            assert!((f64::from(frame.pixels[center][3]) - expected).abs() <= bound, "{order:?}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn centered_texels_reproduce_a_linear_field_at_any_size() {
    with_gpu(|gpu| {
        let sizes = [[2, 2, 2], [3, 5, 7], [63, 64, 65], [17, 2, 33]];
        for (size, source) in
            sizes.into_iter().flat_map(|size| [(size, FieldEncoding::Distance32), (size, FieldEncoding::Normals16)])
        {
            let (mut scene, library) = probe("distance_probe", include_str!("../glsl/distance_probe.glsl"));
            scene.object.field_encoding = source;
            scene.quality.filter = Filter::precise(gpu.info().filters_by_few_bits());
            scene.object.inner_iso = 1.9;
            scene.object.outer_iso = 1.9;
            scene.camera.zoom = 2.0; // the surface is far beyond the face
            // The grid spans the cube of the formula from sample to sample.
            let spacing = 2.0 / (glam::UVec3::from(size).as_vec3() - 1.0);
            let grid = Grid { size, origin: Vec3::splat(-1.0), spacing };
            let linear = |p: Vec3| 0.6 * p.x - 0.3 * p.y;
            let places =
                (0..size[2]).flat_map(|k| (0..size[1]).flat_map(move |j| (0..size[0]).map(move |i| (i, j, k))));
            let values = places.map(|(i, j, k)| linear(grid.position(i, j, k))).collect();
            let subject = Subject {
                field: Some(Arc::new(DistanceField { grid, values })),
                ..formula(&homogeneous("cube", 1.0, Projection::Parallel))
            };
            let seen = face(gpu, &library, &scene, &subject);
            let off = worst(&seen, 0, |p| 0.5 + 0.25 * f64::from(linear(p.as_vec3())));
            let bound = if source == FieldEncoding::Distance32 { 1e-6 } else { 1e-5 };
            assert!(off <= bound, "{size:?} {source:?}: {off:e}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m26_normals_of_stretched_objects_use_inverse_transposes() {
    with_gpu(|gpu| {
        let (mut scene, library) = probe("eye_normal", include_str!("../glsl/eye_normal.glsl"));
        scene.object.input = "sphere".into();
        scene.object.stretch = [1.0, 0.5, 2.0];
        scene.camera.azimuth = 40.0;
        scene.camera.elevation = 25.0;
        scene.quality.samples = 2048;
        let subject = subject(&scene, &library);
        let frame = picture(gpu, &library, &scene, &subject);
        // The ellipsoid in eye space: |S^-1 R^-1 p| = 1, with the normal along R S^-2 R^-1 p.
        let turn = DMat3::from_rotation_x(25f64.to_radians()) * DMat3::from_rotation_y(-40f64.to_radians());
        let shrink = DMat3::from_diagonal(1.0 / DVec3::new(1.0, 0.5, 2.0));
        let quadric = turn * shrink * shrink * turn.transpose();
        let mut rays = rays(&scene, &subject);
        rays.iter_mut().for_each(|ray| ray.from *= 2.0); // framed by its longest stretch
        let mut compared = 0;
        for (ray, pixel) in rays.iter().zip(&frame.pixels) {
            let (from, along) = (ray.from, DVec3::NEG_Z);
            let (a, b, c) = (along.dot(quadric * along), from.dot(quadric * along), from.dot(quadric * from) - 1.0);
            let discriminant = b * b - a * c;
            if discriminant < 0.05 {
                continue; // the silhouette and beyond
            }
            let hit = from + along * ((-b - discriminant.sqrt()) / a);
            let normal = (quadric * hit).normalize();
            let seen = DVec3::from_array([0, 1, 2].map(|c| 2.0 * f64::from(pixel[c]) - 1.0));
            assert!(normal.dot(seen) > 0.9998, "{normal} against {seen}");
            compared += 1;
        }
        assert!(compared > 300, "{compared} pixels");
    });
}
