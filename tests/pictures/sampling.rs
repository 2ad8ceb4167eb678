//! Octaves, phases, sub-frames: what the samples of a picture may and may not change.

use crate::common::{difference, formula, homogeneous, picture, subject, with_gpu};
use hypertexture::render::{Frame, Renderer};
use hypertexture::scene::{EmptySpace, Integration, Jitter, Order, Pass, Projection, Scene, TargetFormat, preset};
use hypertexture::shader;

/// The front face of the cube in turbulence that is clamped by the step.
fn face(bandlimit: &str) -> Scene {
    let mut scene = homogeneous("cube", 1.0, Projection::Parallel);
    (scene.effect.classify, scene.effect.surface) = ("surface".into(), "octaves".into());
    (scene.effect.turbulence, scene.effect.noise) = ("procedural".into(), "procedural".into());
    (scene.effect.bandlimit, scene.quality.integration) = (bandlimit.into(), Integration::Segment);
    scene
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p39_octaves_fade_without_a_jump_as_the_step_grows() {
    let octaves = "// Octaves.\n// Source: -\n// Result: turbulence.\n#include <turbulence>\n\
        vec3 surface(Sample s) { return vec3(turbulence(2.0 * s.x + 0.3, 2.0 * sample_width())); }\n";
    let stop = "// A hard end: the control.\n// Source: PH 3.1.\n// Result: 0 or 1.\n\
        float sample_width() { return step_size * path_scale(); }\n\
        float octave_weight(float cells) { return cells < 0.5 ? 1.0 : 0.0; }\n";
    let library = shader::shipped().with_module("surface", "octaves", octaves).with_module("bandlimit", "stop", stop);
    with_gpu(|gpu| {
        let jumps = ["none", "clamp", "stop"].map(|bandlimit| {
            let mut scene = face(bandlimit);
            (scene.image.size, scene.camera.zoom) = ([24, 24], 4.0);
            let subject = subject(&scene, &library);
            let mut frames: Vec<Frame> = Vec::new();
            for samples in 24..=48 {
                scene.quality.samples = samples;
                frames.push(picture(gpu, &library, &scene, &subject));
            }
            let inside = |pair: &[Frame]| {
                let pixels = pair[0].pixels.iter().zip(&pair[1].pixels).filter(|(a, b)| a[3] == 1.0 && b[3] == 1.0);
                pixels.map(|(a, b)| f64::from(a[0] - b[0]).abs()).fold(0.0, f64::max)
            };
            let largest = frames.windows(2).map(inside).fold(0.0, f64::max);
            let whole = inside(&[frames[0].clone(), frames[24].clone()]);
            println!("{bandlimit}: largest change from one step to the next {largest:.4}, in all {whole:.4}");
            (largest, whole)
        });
        let [none, clamp, stop] = jumps;
        assert!(none.1 < 1e-3, "nothing but the octaves depends on the step: {none:?}");
        // A weight changes by at most 2 per e-fold of the step, and the steps are 4 % apart at most.
        assert!(clamp.1 > 0.1 && clamp.0 < 0.04, "{clamp:?}");
        assert!(stop.0 > 2.0 * clamp.0, "the control: {stop:?}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p39_clamping_reduces_the_error_of_steps_beyond_cells() {
    // A thin cloud: the optical depth along a ray is the mean of the turbulence.
    let cloud = "// Cloud.\n// Source: -\n// @param cells = 8 in [1, 64]: Cells per object unit.\n#include <turbulence>\n\
        float cloud(float density, Sample s) {\n\
            return density * clamp(0.5 * turbulence(cells * s.x, cells * sample_width()), 0.0, 1.0);\n\
        }\n";
    let library = shader::shipped().with_module("dmf", "cloud", cloud);
    with_gpu(|gpu| {
        let mut scene = homogeneous("cube", 0.01, Projection::Parallel);
        scene.effect.dmf = vec!["cloud".into()];
        (scene.effect.turbulence, scene.effect.noise) = ("procedural".into(), "procedural".into());
        (scene.image.size, scene.camera.zoom) = ([32, 32], 16.0); // a pixel is narrower than any step
        let subject = subject(&scene, &library);
        scene.quality.samples = 1536;
        let truth = picture(gpu, &library, &scene, &subject);
        println!("cells per step: rms with all octaves, clamped, of the mean {:.5}", truth.pixels[500][3]);
        let mut table = Vec::new();
        for samples in [6, 12, 24, 48, 96, 192] {
            let mut cells = 0.0;
            let errors = ["none", "clamp"].map(|bandlimit| {
                (scene.quality.samples, scene.effect.bandlimit) = (samples, bandlimit.into());
                let frame = picture(gpu, &library, &scene, &subject);
                cells = 8.0 * frame.measurements.step;
                difference(&frame, &truth).1
            });
            println!("{cells:6.3}: {:.2e} {:.2e}", errors[0], errors[1]);
            table.push(errors);
        }
        // Where a step covers two cells of the first octave or more, its samples are noise that means nothing. Shorter
        // steps would average over more octaves than are left: there, clamping pays by calm and by octaves saved.
        assert!(table[..2].iter().all(|[none, clamp]| *clamp < 0.85 * none), "{table:?}");
        assert!(table[2..].iter().all(|[none, clamp]| *clamp < 4.0 * none), "{table:?}");
        assert!(table.windows(2).all(|pair| pair[1][1] <= pair[0][1]), "{table:?}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p39_the_octaves_are_a_constant_of_the_pipeline() {
    let octaves = "// Octaves.\n// Source: -\n// Result: turbulence.\n#include <turbulence>\n\
        vec3 surface(Sample s) { return vec3(0.5 * turbulence(vec3(0.5))); }\n";
    let library = shader::shipped().with_module("surface", "octaves", octaves);
    with_gpu(|gpu| {
        let mut scene = face("none");
        scene.image.size = [8, 8];
        let subject = subject(&scene, &library);
        let values = [1, 2, 8, 10].map(|octaves| {
            scene.effect.octaves = octaves;
            picture(gpu, &library, &scene, &subject).pixels[27][0]
        });
        // Lattice points of every octave but the first: noise is 0 there.
        assert!(values[0] > 0.0 && values.iter().all(|value| *value == values[0]), "{values:?}");
        let shifted = octaves.replace("vec3(0.5)", "vec3(0.3)");
        let library = shader::shipped().with_module("surface", "octaves", &shifted);
        let values = [1, 2, 8, 10].map(|octaves| {
            scene.effect.octaves = octaves;
            picture(gpu, &library, &scene, &subject).pixels[27][0]
        });
        assert!(values.windows(2).all(|pair| pair[0] < pair[1]), "each octave adds: {values:?}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p48_phases_are_the_same_in_both_passes() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        for effect in ["fur", "fire", "solid", "shells"] {
            for integration in [Integration::Point, Integration::Segment] {
                let mut scene = preset(effect).expect("a shipped preset");
                scene.object.input = "torus".into();
                scene.image.size = [64, 64];
                (scene.quality.samples, scene.quality.early_termination, scene.quality.jitter) =
                    (96, 0.0, Jitter::Hash);
                scene.quality.integration = if effect == "shells" { Integration::Point } else { integration };
                let subject = subject(&scene, &library);
                let [slices, fixed, skip] = [
                    (Pass::Slices, EmptySpace::Sample),
                    (Pass::March, EmptySpace::Sample),
                    (Pass::March, EmptySpace::Skip),
                ]
                .map(|(pass, empty_space)| {
                    (scene.quality.pass, scene.quality.empty_space) = (pass, empty_space);
                    picture(gpu, &library, &scene, &subject)
                });
                let off =
                    slices.pixels.iter().zip(&fixed.pixels).filter(|(a, b)| (0..4).any(|c| (a[c] - b[c]).abs() > 1e-3));
                let off = off.count() as f64 / 4096.0;
                println!("{effect}: {off:.5} of the pixels differ");
                assert!(off <= 0.006, "{effect}: {off}");
                assert!(difference(&fixed, &skip).1 < 1e-4, "{effect}");
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p48_the_mean_over_seeds_converges_to_the_integral() {
    with_gpu(|gpu| {
        // Thin, so that the opacity is linear in the depth; few steps, so that their contours show.
        let mut scene = homogeneous("sphere", 0.02, Projection::Perspective);
        scene.effect.softness = "linear".into();
        (scene.object.inner_iso, scene.object.outer_iso) = (-0.3, -0.1);
        (scene.image.size, scene.quality.early_termination) = ([48, 48], 0.0);
        let subject = formula(&scene);
        let library = shader::shipped();
        scene.quality.samples = 4096;
        let truth = picture(gpu, &library, &scene, &subject);
        scene.quality.samples = 12;
        let off = |sum: &[f64], n: usize| {
            let square = |(sum, truth): (&f64, &[f32; 4])| (sum / n as f64 - f64::from(truth[3])).powi(2);
            (sum.iter().zip(&truth.pixels).map(square).sum::<f64>() / sum.len() as f64).sqrt()
        };
        let even = picture(gpu, &library, &scene, &subject);
        let even: Vec<f64> = even.pixels.iter().map(|pixel| f64::from(pixel[3])).collect();
        let mut sum = vec![0.0; even.len()];
        let mut errors = Vec::new();
        scene.quality.jitter = Jitter::Hash;
        for seed in 0..64 {
            scene.quality.seed = seed;
            for (sum, pixel) in sum.iter_mut().zip(&picture(gpu, &library, &scene, &subject).pixels) {
                *sum += f64::from(pixel[3]);
            }
            if [1, 4, 16, 64].contains(&(seed + 1)) {
                errors.push(off(&sum, seed as usize + 1));
            }
        }
        println!("rms without phases {:.2e}; of the mean of 1, 4, 16, 64 seeds {errors:.6?}", off(&even, 1));
        // Four times the seeds, half the error, down to the last: no bias shows.
        assert!(errors.windows(2).all(|pair| (1.7..2.4).contains(&(pair[0] / pair[1]))), "{errors:?}");
        assert!(errors[3] < 0.2 * off(&even, 1));
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p49_an_edge_covers_the_pixels_that_it_covers() {
    with_gpu(|gpu| {
        for pass in [Pass::Slices, Pass::March] {
            let mut scene = homogeneous("sphere", 1.0, Projection::Parallel);
            scene.effect.classify = "surface".into();
            (scene.quality.integration, scene.quality.pass, scene.image.size) = (Integration::Segment, pass, [48, 48]);
            let subject = formula(&scene);
            // A disk of radius 1 where half the picture's height is 1 / 0.8.
            let pixel = 2.0 / 0.8 / 48.0;
            let covered = |index: usize| {
                let part = |i: usize, k: usize| (i as f64 + (k as f64 + 0.5) / 64.0) * pixel - 1.25;
                let inside = (0..4096).filter(|k| part(index % 48, k % 64).hypot(part(index / 48, k / 64)) < 1.0);
                inside.count() as f64 / 4096.0
            };
            let rms = [1, 16, 64].map(|count| {
                scene.quality.supersampling = count;
                let pixels = picture(gpu, &shader::shipped(), &scene, &subject).pixels;
                let edge = pixels.iter().enumerate().map(|(i, p)| (covered(i), f64::from(p[3])));
                let off: Vec<f64> =
                    edge.filter(|(c, _)| *c > 0.0 && *c < 1.0).map(|(c, found)| (c - found).abs()).collect();
                let (max, sum) = off.iter().fold((0.0f64, 0.0), |(m, s), d| (m.max(*d), s + d * d));
                println!(
                    "{pass:?}, {count} sub-frames: off by {max:.3} at most, rms {:.3}",
                    (sum / off.len() as f64).sqrt()
                );
                assert!(count < 16 || max <= 0.5 / f64::from(count).sqrt(), "{count}: {max}");
                (sum / off.len() as f64).sqrt()
            });
            scene.quality.supersampling = 16;
            let [a, b] = [Pass::Slices, Pass::March].map(|pass| {
                scene.quality.pass = pass;
                picture(gpu, &shader::shipped(), &scene, &subject)
            });
            assert!(difference(&a, &b).1 < 4e-3, "the slices move against the rays");
            assert!(rms[0] > 0.2 && rms[1] < 0.04 && rms[2] < 0.015, "{rms:?}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p49_a_blurred_picture_is_the_mean_of_its_moments() {
    let pulse = "// Pulse.\n// Source: -\n// Result: density by time alone.\n\
        float pulse(float density, Sample s) { return density * clamp(time, 0.0, 1.0); }\n";
    let library = shader::shipped().with_module("dmf", "pulse", pulse);
    with_gpu(|gpu| {
        let mut scene = homogeneous("cube", 1.0, Projection::Parallel);
        scene.effect.dmf = vec!["pulse".into()];
        (scene.image.size, scene.camera.zoom) = ([8, 8], 4.0);
        let subject = subject(&scene, &library);
        let moments: Vec<f64> = (0..4)
            .map(|i| {
                scene.camera.time = 0.2 + 0.5 * (f64::from(i) + 0.5) / 4.0;
                f64::from(picture(gpu, &library, &scene, &subject).pixels[27][3])
            })
            .collect();
        (scene.camera.time, scene.camera.shutter, scene.quality.supersampling) = (0.2, 0.5, 4);
        let blurred = f64::from(picture(gpu, &library, &scene, &subject).pixels[27][3]);
        assert!((blurred - moments.iter().sum::<f64>() / 4.0).abs() < 1e-6, "{blurred} {moments:?}");
        scene.camera.shutter = 0.0;
        let still = f64::from(picture(gpu, &library, &scene, &subject).pixels[27][3]);
        scene.quality.supersampling = 1;
        let one = f64::from(picture(gpu, &library, &scene, &subject).pixels[27][3]);
        assert!((still - one).abs() < 1e-7 && (blurred - one).abs() > 0.05, "{still} {one} {blurred}");
        scene.camera.shutter = 0.5;
        let error = scene.check(&library).unwrap_err().to_string();
        assert!(error.starts_with("camera.shutter = 0.5: needs quality.supersampling"), "{error}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p49_reused_and_new_renderers_give_equal_pictures() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        for (effect, parameter) in [("fire", "fury"), ("melting", "melt_time")] {
            for pass in [Pass::Slices, Pass::March] {
                let mut scene = preset(effect).expect("a shipped preset");
                (scene.object.input, scene.object.resolution, scene.image.size) = ("knot".into(), 48, [48, 48]);
                (scene.quality.pass, scene.quality.samples) = (pass, 64);
                let subject = subject(&scene, &library);
                let mut renderer = Renderer::new(gpu, &library, &subject);
                let mut seen = Vec::new();
                for (azimuth, zoom, time) in [(30.0, 1.0, 0.0), (80.0, 2.5, 1.5), (30.0, 1.0, 0.0)] {
                    (scene.camera.azimuth, scene.camera.zoom, scene.camera.time) = (azimuth, zoom, time);
                    scene
                        .parameters
                        .insert(parameter.into(), hypertexture::scene::ParameterValue::Number(1.0 - 0.2 * time as f32));
                    let again = renderer.render(&scene).unwrap_or_else(|error| panic!("{error}"));
                    assert!(again.pixels == picture(gpu, &library, &scene, &subject).pixels, "{effect} {azimuth}");
                    seen.push(again.pixels);
                }
                assert!(seen[0] != seen[1] && seen[0] == seen[2]);
                type Change = fn(&mut Scene);
                let changes: [(&str, Change); 5] = [
                    ("more samples", |scene| scene.quality.samples = 65),
                    ("another target", |scene| scene.quality.target = TargetFormat::Unorm8),
                    ("another size", |scene| scene.image.size = [40, 30]),
                    ("another order", |scene| scene.quality.order = Order::BackToFront),
                    ("a table of segments", |scene| scene.effect.classify = "preintegrated".into()),
                ];
                for (what, change) in changes {
                    change(&mut scene);
                    for samples in [scene.quality.samples, 48] {
                        scene.quality.samples = samples;
                        if scene.check(&library).is_ok() {
                            let again = renderer.render(&scene).unwrap_or_else(|error| panic!("{error}"));
                            let new = picture(gpu, &library, &scene, &subject);
                            assert!(again.pixels == new.pixels, "{effect}, {what}, {samples} samples");
                        }
                    }
                }
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p48_blue_phases_leave_less_error_after_a_filter() {
    with_gpu(|gpu| {
        const SIDE: usize = 96;
        let mut scene = homogeneous("sphere", 0.5, Projection::Perspective);
        scene.effect.softness = "linear".into();
        (scene.object.inner_iso, scene.object.outer_iso) = (-0.3, -0.1);
        (scene.image.size, scene.quality.early_termination) = ([SIDE as u32; 2], 0.0);
        let (subject, library) = (formula(&scene), shader::shipped());
        scene.quality.samples = 2048;
        let truth = picture(gpu, &library, &scene, &subject);
        scene.quality.samples = 12;
        let mut of = |jitter: Jitter, pass: Pass| {
            (scene.quality.jitter, scene.quality.pass) = (jitter, pass);
            let frame = picture(gpu, &library, &scene, &subject);
            let off: Vec<f64> =
                frame.pixels.iter().zip(&truth.pixels).map(|(a, b)| f64::from(a[3]) - f64::from(b[3])).collect();
            let rms = |values: &[f64]| (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt();
            // The mean of 5 x 5 pixels, inside of the disk.
            let inside = |at: usize| (at as f64 + 0.5 - SIDE as f64 / 2.0).abs() < 0.2 * SIDE as f64;
            let places = (0..SIDE * SIDE).filter(|at| inside(at % SIDE) && inside(at / SIDE));
            let blurred: Vec<f64> = places
                .map(|at| (0..25).map(|k| off[at + k % 5 - 2 + (k / 5) * SIDE - 2 * SIDE]).sum::<f64>() / 25.0)
                .collect();
            [rms(&off), rms(&blurred), blurred.iter().sum::<f64>() / blurred.len() as f64]
        };
        for pass in [Pass::Slices, Pass::March] {
            let [hash, blue] = [Jitter::Hash, Jitter::Blue].map(|jitter| of(jitter, pass));
            println!("{pass:?}: rms, after a filter, and mean: hash {hash:.5?}, blue {blue:.5?}");
            assert!((0.8..1.25).contains(&(blue[0] / hash[0])), "{blue:?} {hash:?}");
            assert!(blue[1] < 0.6 * hash[1] && blue[2].abs() < 0.1 * blue[0], "{blue:?} {hash:?}");
        }
    });
}
