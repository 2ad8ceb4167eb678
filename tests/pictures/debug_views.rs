//! Noise as debug views (MJ Fig. 5), and the normals of bump mapping (MJ Eq. 7), against formulas in f64.

use crate::common::{homogeneous, picture, rays, subject, with_gpu};
use glam::DVec3;
use hypertexture::gpu::Gpu;
use hypertexture::noise::Lattice;
use hypertexture::render::Frame;
use hypertexture::scene::{ParameterValue, Projection, Scene, preset};
use hypertexture::shader::{self, Library};
use hypertexture_measure::compare::metrics::normal_angles;

/// Half the side of the square that is looked at, a little less than the face of the cube.
const SIDE: f64 = 0.99;

/// The front face of a cube under a surface module, with some parameters: places (x, y) and colors.
fn face(gpu: &Gpu, library: &Library, surface: &str, change: impl FnOnce(&mut Scene)) -> Vec<([f64; 2], DVec3)> {
    let mut scene = homogeneous("cube", 1.0, Projection::Parallel);
    (scene.effect.classify, scene.effect.surface) = ("surface".into(), surface.into());
    scene.image.size = [256, 256];
    change(&mut scene);
    let subject = subject(&scene, library);
    let frame = picture(gpu, library, &scene, &subject);
    let pixels = rays(&scene, &subject).into_iter().zip(&frame.pixels);
    let seen: Vec<_> = pixels
        .filter(|(ray, _)| ray.from.x.abs().max(ray.from.y.abs()) < SIDE)
        .map(|(ray, pixel)| ([ray.from.x, ray.from.y], DVec3::from([0, 1, 2].map(|c| f64::from(pixel[c])))))
        .collect();
    assert!(seen.len() > 10_000, "{} points", seen.len());
    seen
}

fn parameter(scene: &mut Scene, name: &str, value: f32) {
    scene.parameters.insert(name.into(), ParameterValue::Number(value));
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m41_noise_planes_show_the_lattice_noise_and_gradient() {
    const Z: f32 = 0.37;
    const CELLS: f32 = 6.0;
    // The lattice in f64, its gradient by differences of it; the block of 64 texels repeats after 16 cells.
    let at = |p: DVec3, period: u32| Lattice::default().sample(p.to_array(), period).1;
    let slope = |p: DVec3, period: u32| {
        let along = |axis: usize| {
            let h = 1e-5 * DVec3::AXES[axis];
            (at(p + h, period) - at(p - h, period)) / 2e-5
        };
        DVec3::new(along(0), along(1), along(2))
    };
    with_gpu(|gpu| {
        let library = shader::shipped();
        // Loss of a block of four texels a cell, and of rounding in computed noise.
        for (noise, period, value, direction) in [("procedural", 1 << 20, 2e-5, 2e-3), ("block", 16, 0.06, 0.35)] {
            let show = |surface: &str| {
                face(gpu, &library, surface, |scene| {
                    scene.effect.noise = noise.into();
                    parameter(scene, "plane_z", Z);
                    parameter(scene, "plane_frequency", CELLS);
                })
            };
            let place = |[x, y]: [f64; 2]| f64::from(CELLS) * DVec3::new(x, y, f64::from(Z));
            let grey = show("noise");
            let off = grey.iter().map(|(xy, c)| {
                (DVec3::from(c.to_array().map(f64::sqrt)) - (0.5 + 0.5 * at(place(*xy), period))).abs().max_element()
            });
            let off = off.fold(0.0, f64::max);
            assert!(off <= value, "{noise}: {off:e}");
            let (low, high) = grey.iter().fold((1.0f64, 0.0f64), |(low, high), (_, c)| (low.min(c.x), high.max(c.x)));
            assert!(low < 0.1 && high > 0.5, "a plane of noise is neither black nor white: {low} to {high}");
            let mut steep = 0;
            for (xy, color) in show("noise_gradient") {
                let gradient = slope(place(xy), period);
                // Where noise is flat its direction is anything; the block's is off by up to 0.32 elsewhere.
                if gradient.length() > 1.0 {
                    steep += 1;
                    let texel = DVec3::from(color.to_array().map(f64::sqrt));
                    let off = (2.0 * texel - 1.0 - gradient.normalize()).length();
                    assert!(off <= direction, "{noise} at {xy:?}: {off:e}");
                }
            }
            assert!(steep > 2500, "{steep}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m46_a_larger_k_softens_bumps_and_opposites_keep_the_normal() {
    // V and B are turned against each other by x from 0 to 180 degrees; k grows with y from 0 to 4.
    let text = "#include \"bump_normal.glsl\"\n\
                const vec3 V = vec3(1.0, 2.0, 2.0) / 3.0, U = vec3(2.0, 1.0, -2.0) / 3.0;\n\
                vec3 surface(Sample s) {\n\
                float turn = 1.5707963267948966 * (1.0 + s.x.x);\n\
                return 0.5 + 0.5 * bumpmap(V, cos(turn) * V + sin(turn) * U, 2.0 + 2.0 * s.x.y);\n}\n";
    // B = -kV exactly, for every k that the parameter may have.
    let opposite = "#include \"bump_normal.glsl\"\n\
                    const vec3 V = vec3(0.375, -0.5, 0.78125);\n\
                    vec3 surface(Sample s) {\n\
                    float k = 10.0 + 10.0 * s.x.y;\n\
                    return 0.5 + 0.5 * bumpmap(V, -(k * V), k);\n}\n";
    let library = shader::shipped().with_module("surface", "probe", text).with_module("surface", "opposite", opposite);
    let (v, u) = (DVec3::new(1.0, 2.0, 2.0) / 3.0, DVec3::new(2.0, 1.0, -2.0) / 3.0);
    with_gpu(|gpu| {
        for ([x, y], color) in face(gpu, &library, "probe", |_| ()) {
            let (turn, k) = (std::f64::consts::FRAC_PI_2 * (1.0 + x), 2.0 + 2.0 * y);
            let sum = k * v + turn.cos() * v + turn.sin() * u;
            if sum.length() < 0.05 {
                continue; // almost opposite: rounding decides
            }
            let found = 2.0 * color - 1.0;
            assert!((found - sum.normalize()).length() < 5e-4, "k {k}, turn {turn}: {found}");
            let angle = turn.sin().atan2(k + turn.cos());
            assert!((found.cross(v).length().atan2(found.dot(v)) - angle).abs() < 1e-3, "k {k}, turn {turn}");
        }
        for (place, color) in face(gpu, &library, "opposite", |_| ()) {
            assert_eq!(2.0 * color - 1.0, DVec3::new(0.375, -0.5, 0.78125), "{place:?}");
        }
        // The sweep on an object: the mean angle falls with every k, as pi / (4 k) in the end.
        let mut scene = preset("bump").unwrap();
        (scene.object.input, scene.image.size) = ("sphere".into(), [64, 64]);
        let subject = subject(&scene, &library);
        let show = |surface: &str, k: Option<f32>| -> Frame {
            let mut scene = scene.clone();
            scene.effect.surface = surface.into();
            scene.drop_foreign_parameters(&library).unwrap();
            k.into_iter().for_each(|k| parameter(&mut scene, "bump_scale", k));
            picture(gpu, &library, &scene, &subject)
        };
        let flat = show("normals", None);
        let angle = |k: f32| normal_angles(&show("bump_normals", Some(k)).pixels, &flat.pixels).unwrap().mean;
        let angles = [0.0, 0.4, 0.8, 1.6, 3.2, 6.4, 12.8, 20.0].map(angle);
        assert!(angles.is_sorted_by(|a, b| a > b), "{angles:?}");
        // The mean of atan(sin t / (k + cos t)) over directions of B that are uniform on the sphere.
        let uniform = |k: f64| {
            let steps = 2000;
            let t = |i: i32| std::f64::consts::PI * (f64::from(i) + 0.5) / f64::from(steps);
            let mean = (0..steps).map(|i| 0.5 * t(i).sin() * t(i).sin().atan2(k + t(i).cos())).sum::<f64>();
            (mean * std::f64::consts::PI / f64::from(steps)).to_degrees()
        };
        for (k, found) in [(0.0, angles[0]), (1.6, angles[3]), (20.0, angles[7])] {
            assert!((found / uniform(k) - 1.0).abs() < 0.15, "k {k}: {found} degrees, {} if uniform", uniform(k));
        }
    });
}
