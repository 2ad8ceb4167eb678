//! Frequency clamping reaches every sum of octaves: nearer to the truth where samples are far apart, the same picture
//! where they are near.

use crate::common::{difference, homogeneous, picture, subject, with_gpu};
use hypertexture::gpu::Gpu;
use hypertexture::render::variant::Variant;
use hypertexture::render::{Frame, Subject, half_height};
use hypertexture::scene::{Integration, ParameterValue, Part, Pass, Projection, Scene, Transform, preset};
use hypertexture::shader::{self, Library};
use hypertexture_measure::reference::{converged_settings, reference_pixels};

/// Modules that sum octaves: slot, and the frequency parameter of the first octave, for coarse and fine samples.
struct Sum {
    name: &'static str,
    put: fn(&mut Scene),
    parameter: &'static str,
    frequency: [f32; 2],
}

/// A thin soft ball, whose light is about linear in its density.
fn ball() -> Scene {
    let mut scene = homogeneous("sphere", 0.5, Projection::Parallel);
    (scene.effect.classify, scene.effect.softness) = ("soft".into(), "linear".into());
    (scene.object.inner_iso, scene.object.outer_iso) = (-0.9, 0.0);
    (scene.effect.noise, scene.effect.turbulence) = ("procedural".into(), "procedural".into());
    scene.effect.octaves = 3;
    scene.quality.pass = Pass::March;
    (scene.camera.azimuth, scene.camera.elevation) = (17.0, 9.0); // along no axis of the lattice
    scene
}

fn turbulent(scene: &mut Scene, strategy: &str) {
    scene.effect.dmf = vec!["turbulent".into()];
    scene.effect.turbulence = strategy.into();
}

fn parameter(scene: &mut Scene, name: &str, value: f32) {
    scene.parameters.insert(name.into(), ParameterValue::Number(value));
}

/// The face of a cube, without its edges.
fn hard(scene: &mut Scene, surface: &str) {
    (scene.object.input, scene.camera.zoom, scene.quality.integration) = ("cube".into(), 3.0, Integration::Segment);
    (scene.object.inner_iso, scene.effect.softness) = (0.0, "hard".into());
    (scene.effect.classify, scene.effect.surface) = ("surface".into(), surface.into());
}

fn warped(scene: &mut Scene, warp: &str) {
    scene.effect.warp = vec![warp.into()];
}

const SUMS: [Sum; 12] = [
    Sum {
        name: "warp/turbulent",
        put: |s| {
            warped(s, "turbulent");
            parameter(s, "turbulence_amplitude", 0.5);
        },
        parameter: "turbulence_frequency",
        frequency: [13.7, 1.0],
    },
    Sum {
        name: "warp/fractal",
        put: |s| {
            // Of matter, the mean would be that of no noise: here the noise turns the normals.
            warped(s, "fractal");
            parameter(s, "fractal_amplitude", 0.01);
            hard(s, "lit");
        },
        parameter: "fractal_frequency",
        frequency: [13.7, 1.0],
    },
    Sum {
        name: "warp/perturbed",
        put: |s| {
            warped(s, "perturbed");
            parameter(s, "perturbation", 0.4);
        },
        parameter: "perturbation_frequency",
        frequency: [13.7, 1.0],
    },
    Sum {
        name: "dmf/turbulent",
        put: |s| turbulent(s, "procedural"),
        parameter: "turbulence_scale",
        frequency: [13.7, 1.0],
    },
    Sum {
        name: "dmf/fractal",
        put: |s| s.effect.dmf = vec!["fractal".into()],
        parameter: "fractal_scale",
        frequency: [13.7, 1.0],
    },
    Sum {
        name: "dmf/fire",
        put: |s| s.effect.dmf = vec!["fire".into()],
        parameter: "flame_scale",
        frequency: [13.7, 1.0],
    },
    Sum {
        name: "surface/solid",
        put: |s| {
            hard(s, "solid_unlit");
            parameter(s, "veins", 0.0);
        },
        parameter: "grain",
        frequency: [13.7, 1.0],
    },
    Sum { name: "encoded", put: |s| turbulent(s, "encoded"), parameter: "turbulence_scale", frequency: [13.7, 1.0] },
    Sum { name: "hybrid", put: |s| turbulent(s, "hybrid"), parameter: "turbulence_scale", frequency: [13.7, 1.0] },
    Sum { name: "channels", put: |s| turbulent(s, "channels"), parameter: "turbulence_scale", frequency: [13.7, 1.0] },
    Sum { name: "lookups8", put: |s| turbulent(s, "lookups8"), parameter: "turbulence_scale", frequency: [13.7, 1.0] },
    Sum { name: "lookups4", put: |s| turbulent(s, "lookups4"), parameter: "turbulence_scale", frequency: [13.7, 1.0] },
];

/// The scene, drawn with each of two modules of the slot.
fn both(gpu: &Gpu, library: &Library, scene: &Scene, subject: &Subject) -> [Frame; 2] {
    ["none", "clamp"].map(|bandlimit| {
        let mut scene = scene.clone();
        scene.effect.bandlimit = bandlimit.into();
        picture(gpu, library, &scene, subject)
    })
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p39_clamping_reaches_every_sum_of_octaves() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        let mut wrong = Vec::new();
        for Sum { name, put, parameter: frequency_parameter, frequency } in SUMS {
            let mut scene = ball();
            put(&mut scene);
            parameter(&mut scene, frequency_parameter, frequency[0]);
            let subject = subject(&scene, &library);
            // The mean of many fine pictures: of what a pixel covers, along its ray and beside it.
            (scene.image.size, scene.quality.samples, scene.quality.supersampling) = ([10, 10], 320, 25);
            let truth = picture(gpu, &library, &scene, &subject);
            (scene.quality.samples, scene.quality.supersampling) = (14, 1);
            let [none, clamp] = both(gpu, &library, &scene, &subject).map(|frame| difference(&frame, &truth).1);
            println!("{name:<16} coarse: {none:.2e}, clamped {clamp:.2e}");
            if clamp >= 0.9 * none {
                wrong.push(format!("{name}: {clamp:e} clamped, {none:e} not"));
            }

            parameter(&mut scene, frequency_parameter, frequency[1]);
            (scene.quality.samples, scene.camera.zoom) = (256, 8.0);
            let frames = both(gpu, &library, &scene, &subject);
            let (worst, _) = difference(&frames[0], &frames[1]);
            println!("{:16} fine: they differ by {worst:.1e}", "");
            if worst > 2e-6 {
                wrong.push(format!("{name}: {worst:e} where samples are near"));
            }
            assert!(frames[0].pixels[55][3] > 0.0, "{name}: there is nothing to see");
        }
        assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p39_the_relief_of_a_flame_is_clamped() {
    // Its frequency is fixed: 2 cells per unit. A relief that is finer than a pixel is noise.
    let library = shader::shipped();
    with_gpu(|gpu| {
        let mut scene = ball();
        (scene.effect.medium, scene.effect.octaves) = ("flame".into(), 8);
        parameter(&mut scene, "relief", 1.0);
        let subject = subject(&scene, &library);
        (scene.image.size, scene.quality.samples, scene.quality.supersampling) = ([8, 8], 256, 25);
        let truth = picture(gpu, &library, &scene, &subject);
        (scene.quality.samples, scene.quality.supersampling) = (6, 1);
        let [none, clamp] = both(gpu, &library, &scene, &subject).map(|frame| difference(&frame, &truth).1);
        println!("coarse: {none:.2e}, clamped {clamp:.2e}");
        assert!(clamp < 0.95 * none, "{clamp:e} clamped, {none:e} not");
    });
}

/// The front face of a cube that shows turbulence, and its gradient, for a width of the samples that is given.
fn face(strategy: &str, width: f32, slope: bool) -> (Scene, Library) {
    let text = "// Turbulence of a given width.\n// Source: -\n// Result: a half of it, and a part of its gradient.\n\
        // @param wide = 0 in [0, 8]: Width of a sample, cells.\n// @param sloped = 0 in [0, 1]: Whether the gradient shows.\n\
        #include <turbulence>\nvec3 surface(Sample s) {\n    vec3 p = 3.0 * s.x + 0.37;\n\
        return sloped > 0.0 ? 0.5 + 0.05 * turbulence_gradient(p, wide).xyz : vec3(0.5 * turbulence(p, wide));\n}\n";
    let mut scene = homogeneous("cube", 1.0, Projection::Parallel);
    (scene.effect.classify, scene.effect.surface) = ("surface".into(), "wide".into());
    (scene.effect.turbulence, scene.effect.bandlimit) = (strategy.into(), "clamp".into());
    (scene.image.size, scene.camera.zoom, scene.quality.integration) = ([40, 40], 2.0, Integration::Segment);
    parameter(&mut scene, "wide", width);
    parameter(&mut scene, "sloped", f32::from(u8::from(slope)));
    (scene, shader::shipped().with_module("surface", "wide", text))
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p39_block_levels_fade_octaves_like_computed_noise() {
    with_gpu(|gpu| {
        for strategy in ["encoded", "hybrid"] {
            for slope in [false, true].into_iter().take(if strategy == "hybrid" { 1 } else { 2 }) {
                // From where nothing fades to where nothing is left, through every octave.
                for width in [0.0, 0.05, 0.13, 0.3, 0.45, 0.7] {
                    let (mut scene, library) = face(strategy, width, slope);
                    let subject = subject(&scene, &library);
                    let found = picture(gpu, &library, &scene, &subject);
                    let held = scene.octaves_held(&library);
                    scene = scene.unbaked(&library).unwrap();
                    scene.effect.octaves = held;
                    let twin = picture(gpu, &library, &scene, &subject);
                    let off = difference(&found, &twin).1;
                    println!("{strategy}, gradient {slope}, width {width}: {off:.4}");
                    assert!(off < 0.03, "{strategy}, {slope}, width {width}: {off}");
                }
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p39_the_evaluator_reads_the_levels_that_the_device_reads() {
    with_gpu(|gpu| {
        for width in [0.0, 0.1, 0.3, 0.7] {
            let (scene, library) = face("encoded", width, false);
            let subject = subject(&scene, &library);
            let found = picture(gpu, &library, &scene, &subject);
            let pixels: Vec<[u32; 2]> = (10..30).map(|at| [at, 40 - at]).collect();
            let truth =
                reference_pixels(&library, &converged_settings(&scene), &subject, &pixels, 1e-3, &|_| (), &|| false)
                    .unwrap();
            for ([x, y], truth) in pixels.iter().zip(&truth.pixels) {
                let off = (f64::from(found.pixels[(y * 40 + x) as usize][0]) - truth[0]).abs();
                assert!(off < 5e-3, "width {width}, pixel {x}, {y}: {off}"); // weights of 8 bits in the filter
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p39_a_sample_is_as_wide_as_it_is_in_the_space_of_its_object() {
    let text = "// Width of a sample.\n// Source: -\n// Result: in units of the object.\n#include <bandlimit>\n\
        vec3 surface(Sample s) { return vec3(sample_width()); }\n";
    let library = shader::shipped().with_module("surface", "width", text);
    with_gpu(|gpu| {
        let mut scene = homogeneous("sphere", 1.0, Projection::Parallel);
        (scene.effect.surface, scene.effect.bandlimit) = ("width".into(), "clamp".into());
        (scene.effect.opacity_rate, scene.image.size) = (1e4, [48, 48]);
        let transform = Transform { at: [2.0, 0.0, 0.0], scale: 0.5, ..Transform::default() };
        let part = Part { object: scene.object.clone(), effect: scene.effect.clone(), transform, ..Part::default() };
        scene.parts.insert("small".into(), part);
        let subject = subject(&scene, &library);
        let frame = picture(gpu, &library, &scene, &subject);
        let widths: Vec<f32> = frame.pixels.iter().filter(|p| p[3] > 0.999).map(|p| p[0]).collect();
        let pixel = 2.0 * half_height(&Variant::of(&scene, &library).unwrap(), &subject) / 48.0;
        let [own, small] = [1.0, 2.0].map(|scale| scale * pixel.max(frame.measurements.step));
        let near = |width: f32| widths.iter().filter(|found| (**found / width - 1.0).abs() < 2e-3).count();
        let counts = [near(own), near(small)];
        println!("{own} and {small}: {counts:?} of {}", widths.len());
        assert!(counts[0] > 100 && counts[1] > 25 && counts[0] + counts[1] == widths.len(), "{counts:?}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p39_matter_that_is_clamped_casts_shadows() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        for (effect, pass) in [("fire", Pass::March), ("clouds", Pass::Slices), ("nebula", Pass::March)] {
            let mut scene = preset(effect).unwrap();
            scene.object.input = "torus".into();
            (scene.effect.bandlimit, scene.light.shadows, scene.effect.medium) = ("clamp".into(), true, "lit".into());
            (scene.quality.pass, scene.quality.samples, scene.image.size) = (pass, 32, [24, 24]);
            scene.light.shadow_resolution = 32;
            scene.drop_foreign_parameters(&library).unwrap();
            let frame = picture(gpu, &library, &scene, &subject(&scene, &library));
            assert!(
                frame.pixels.iter().any(|pixel| pixel[3] > 0.1) && frame.measurements.shadow_ms.is_some(),
                "{effect}"
            );
        }
    });
}
