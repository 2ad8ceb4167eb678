//! The strategies of noise and turbulence: each against its twin in f64, and what each costs in fetches and errors.

use crate::common::{difference, homogeneous, picture, rays, subject, with_gpu};
use glam::DVec3;
use hypertexture::gpu::Gpu;
use hypertexture::noise::{Lattice, Noise, Weights};
use hypertexture::render::variant::Variant;
use hypertexture::scene::{BlockFormat, ParameterValue, Pass, Projection, Scene, Wrap, preset};
use hypertexture::shader::{self, Library, Linker};

const STRATEGIES: [&str; 8] =
    ["lookups8", "lookups4", "channels", "encoded", "tables", "arrays", "procedural", "hybrid"];

/// The front face of a cube that shows noise and turbulence over three cells to each side.
fn probe() -> (Scene, Library) {
    let mut scene = homogeneous("cube", 1.0, Projection::Parallel);
    (scene.effect.classify, scene.effect.surface) = ("surface".into(), "probe".into());
    scene.image.size = [96, 96];
    (scene, shader::shipped().with_module("surface", "probe", include_str!("../glsl/strategy_probe.glsl")))
}

fn parameter(scene: &mut Scene, name: &str, value: f32) {
    scene.parameters.insert(name.into(), ParameterValue::Number(value));
}

/// Place (cells), noise, turbulence and derivative at each pixel of the face.
fn seen(gpu: &Gpu, library: &Library, scene: &Scene) -> Vec<(DVec3, [f64; 3])> {
    let subject = subject(scene, library);
    let frame = picture(gpu, library, scene, &subject);
    let pixels = rays(scene, &subject).into_iter().zip(&frame.pixels);
    let pixels = pixels.filter(|(ray, _)| ray.from.x.abs().max(ray.from.y.abs()) < 0.98);
    let value = |pixel: &[f32; 4]| {
        let [r, g, b] = [0, 1, 2].map(|c| f64::from(pixel[c]));
        [2.0 * r - 1.0, 2.0 * g, (b - 0.5) / 0.1]
    };
    pixels.map(|(ray, pixel)| (DVec3::new(3.0 * ray.from.x, 3.0 * ray.from.y, 0.37), value(pixel))).collect()
}

/// Root of the mean square.
fn rms(errors: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = errors.fold((0.0, 0.0), |(sum, count), error| (sum + error * error, count + 1.0));
    (sum / f64::max(count, 1.0)).sqrt()
}

/// The turbulence that a scene is an approximation of, in all its octaves or in those that it has.
fn truth(scene: &Scene, octaves: u32) -> impl Fn(DVec3) -> f64 {
    let twin = scene.unbaked(&shader::shipped()).unwrap();
    let tables = Noise::new(1989, Weights::Quintic);
    move |p: DVec3| match twin.effect.turbulence.as_str() {
        "procedural" => Lattice::default().turbulence(p.to_array(), twin.periods(&shader::shipped())[1], octaves).1,
        "arrays" => tables.turbulence(p.to_array(), 256, octaves).1,
        other => panic!("{other} is no truth"),
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m33_each_strategy_is_its_twin_to_what_its_block_loses() {
    with_gpu(|gpu| {
        let (mut scene, library) = probe();
        for (strategy, own, all) in [
            ("lookups8", 0.05, 0.05),
            ("lookups4", 0.05, 0.08),
            ("channels", 0.06, 0.06),
            ("encoded", 0.04, 0.04),
            ("tables", 2e-6, 2e-6),
            ("arrays", 2e-6, 2e-6),
            ("procedural", 2e-6, 2e-6),
            ("hybrid", 0.02, 0.02),
        ] {
            scene.effect.turbulence = strategy.into();
            let seen = seen(gpu, &library, &scene);
            let off = [scene.octaves_held(&library), 8].map(|octaves| {
                let truth = truth(&scene, octaves);
                rms(seen.iter().map(|(p, value)| value[1] - truth(*p)))
            });
            println!("{strategy:<12} rms {:.2e} of its octaves, {:.2e} of eight", off[0], off[1]);
            assert!(off[0] <= own && off[1] <= all, "{strategy}: {off:?}");
            assert!(own < 1e-3 || off[0] > 1e-4, "{strategy} is better than a block can be: {off:?}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m34_the_error_of_a_block_falls_with_its_size() {
    with_gpu(|gpu| {
        let (mut scene, library) = probe();
        for (strategy, sizes) in [("encoded", [16, 32, 64, 128]), ("hybrid", [32, 64, 128, 256])] {
            scene.effect.turbulence = strategy.into();
            let errors = sizes.map(|size| {
                scene.quality.block_size = size;
                let truth = truth(&scene, 8);
                rms(seen(gpu, &library, &scene).iter().map(|(p, value)| value[1] - truth(*p)))
            });
            println!("{strategy}: {errors:.4?}");
            assert!(errors.windows(2).all(|pair| pair[1] < 0.75 * pair[0]), "{strategy}: {errors:?}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m35_a_block_repeats_and_procedural_noise_does_not() {
    with_gpu(|gpu| {
        let (mut scene, library) = probe();
        for (noise, repeats) in [("block", true), ("procedural", false), ("tables", false)] {
            scene.effect.noise = noise.into();
            let [here, there] = [0.0, 16.0].map(|shift| {
                parameter(&mut scene, "shift", shift);
                seen(gpu, &library, &scene)
            });
            let both = here.iter().zip(&there).map(|((_, a), (_, b))| (a[0], b[0]));
            let (product, square) = both.fold((0.0, 0.0), |(p, s), (a, b)| (p + a * b, s + a * a));
            println!("{noise}: correlation after 16 cells {:.4}", product / square);
            assert_eq!((product / square - 1.0).abs() < 1e-3, repeats, "{noise}: {}", product / square);
            assert!(repeats || (product / square).abs() < 0.5, "{noise}: {}", product / square);
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m33_noise_far_from_the_origin_loses_digits_and_nothing_else() {
    with_gpu(|gpu| {
        let (mut scene, library) = probe();
        (scene.effect.noise, scene.effect.turbulence) = ("procedural".into(), "procedural".into());
        scene.effect.octaves = 1;
        for (shift, bound) in [(4096.0f32, 2e-3), (65_536.0, 3e-2)] {
            parameter(&mut scene, "shift", shift);
            let away = |p: DVec3| [p.x + f64::from(shift), p.y, p.z];
            let off = seen(gpu, &library, &scene).iter().fold(0.0, |worst: f64, (p, value)| {
                worst.max((value[0] - Lattice::default().sample(away(*p), 1 << 20).1).abs())
            });
            println!("{shift}: {off:.1e}");
            assert!(off <= bound, "{shift}: {off}");
        }
        for strategy in STRATEGIES {
            (scene.effect.turbulence, scene.effect.octaves) = (strategy.into(), 8);
            for shift in [-1e9, 1e9] {
                parameter(&mut scene, "shift", shift);
                let inside = |value: &[f64; 3]| value[0].abs() <= 1.001 && (0.0..=2.001).contains(&value[1]);
                assert!(seen(gpu, &library, &scene).iter().all(|(_, value)| inside(value)), "{strategy} at {shift}");
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m36_gradients_change_their_sign_in_the_mirror() {
    with_gpu(|gpu| {
        let (mut scene, library) = probe();
        scene.quality.wrap = Wrap::Mirror;
        scene.image.size = [192, 192];
        for (noise, turbulence) in [("block", "encoded"), ("procedural", "procedural")] {
            (scene.effect.noise, scene.effect.turbulence) = (noise.into(), turbulence.into());
            if noise == "procedural" {
                let mut blocks = scene.clone();
                (blocks.effect.noise, blocks.effect.turbulence) = ("block".into(), "encoded".into());
                scene = blocks.unbaked(&shader::shipped()).unwrap();
            }
            // Within the first period of the noise, and within its mirror image behind 0.
            for (along, shift) in [(1.0, 6.0), (1.0, -6.0), (1.0, 22.0), (2.0, 0.0), (2.0, 3.0)] {
                parameter(&mut scene, "along", along);
                parameter(&mut scene, "shift", shift);
                let seen = seen(gpu, &library, &scene);
                let channel = along as usize - 1;
                let neighbors = seen.windows(3).filter(|three| three[0].0.y == three[2].0.y);
                let (mut agree, mut against) = (0.0, 0.0);
                for three in neighbors {
                    let slope = (three[2].1[channel] - three[0].1[channel]) / (three[2].0.x - three[0].0.x);
                    agree += slope * three[1].1[2];
                    against += slope * slope;
                }
                let cosine = agree / against;
                println!("{noise}, channel {channel}, shift {shift}: {cosine:.3}");
                assert!((0.8..1.2).contains(&cosine), "{noise}, channel {channel}, shift {shift}: {cosine}");
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m36_a_block_and_its_twin_have_the_same_mirror_image() {
    with_gpu(|gpu| {
        let (mut scene, library) = probe();
        scene.quality.wrap = Wrap::Mirror;
        scene.quality.block_size = 128;
        let off = [-3.0, 3.0, 130.0].map(|shift| {
            parameter(&mut scene, "shift", shift);
            let twin = scene.unbaked(&library).unwrap();
            let [mut a, b] = [&scene, &twin].map(|scene| seen(gpu, &library, scene));
            a.iter_mut().zip(&b).for_each(|(a, b)| (0..2).for_each(|c| a.1[c] -= b.1[c]));
            [0, 1].map(|channel| rms(a.iter().map(|(_, value)| value[channel])))
        });
        println!("{off:?}");
        assert!(off.iter().all(|[noise, turbulence]| *noise < 0.03 && *turbulence < 0.06), "{off:?}");
    });
}

#[test]
fn m43_the_fetches_of_each_strategy() {
    let library = shader::shipped().with_module(
        "surface",
        "sum",
        "// Sum.\n// Source: -\n// Result: turbulence.\n#include <turbulence>\n\
         vec3 surface(Sample s) { return vec3(turbulence(s.x)); }\n",
    );
    for (strategy, fetches) in [
        ("lookups8", 8),
        ("lookups4", 4),
        ("channels", 2),
        ("encoded", 1),
        ("tables", 88),
        ("arrays", 0),
        ("procedural", 0),
        ("hybrid", 1),
    ] {
        let mut scene = homogeneous("cube", 1.0, Projection::Parallel);
        (scene.effect.classify, scene.effect.surface) = ("surface".into(), "sum".into());
        scene.effect.turbulence = strategy.into();
        let program = Variant::of(&scene, &library).unwrap().program(&library, Linker::new).unwrap();
        let (mut at, mut samples) = (5, 0);
        while at < program.fragment.len() {
            let word = program.fragment[at];
            samples += u32::from((87..=88).contains(&(word & 0xffff))); // OpImageSampleImplicitLod, ...ExplicitLod
            at += (word >> 16) as usize;
        }
        let rounds = match strategy {
            "encoded" | "hybrid" => 1,
            "channels" => scene.effect.octaves / 4,
            _ => scene.octaves_held(&library),
        };
        assert_eq!(samples * rounds, fetches, "{strategy}: {samples} in each of {rounds} rounds");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m34_the_formats_of_a_block_are_right_to_half_a_code() {
    with_gpu(|gpu| {
        let (mut scene, library) = probe();
        parameter(&mut scene, "along", 2.0);
        let formats = [BlockFormat::Float32, BlockFormat::Unorm16, BlockFormat::Unorm8, BlockFormat::Auto];
        let all = formats.map(|format| {
            scene.quality.block_format = format;
            seen(gpu, &library, &scene)
        });
        let worst = |index: usize, channel: usize| {
            let pairs = all[0].iter().zip(&all[index]);
            pairs.map(|((_, a), (_, b))| (a[channel] - b[channel]).abs()).fold(0.0, f64::max)
        };
        for (index, codes) in [(1, 65535.0), (2, 255.0)] {
            // Of 8 bits the filter of lavapipe has results of 8 bits: two roundings.
            for (channel, range) in [(0, 2.0), (1, 2.0), (2, 48.0)] {
                let off = worst(index, channel);
                println!("{:?}, channel {channel}: {off:.1e}", formats[index]);
                assert!(
                    off <= if codes < 256.0 { 2.1 } else { 1.1 } * range / codes + 1e-5,
                    "{:?}, channel {channel}: {off:e}",
                    formats[index]
                );
            }
        }
        assert!(worst(3, 0) == 0.0 && worst(3, 1) == 0.0 && worst(3, 2) == worst(1, 2));
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn an_end_before_all_octaves_are_summed_changes_no_bit() {
    let patient = |slot: &str, name: &str| {
        let shipped = shader::shipped();
        let text = shipped.source(&format!("{slot}/{name}.glsl")).unwrap().replace(", enough)", ", ALL)");
        assert!(text.contains(", ALL)"), "{slot}/{name} waits anyway");
        shipped.with_module(slot, name, &text)
    };
    with_gpu(|gpu| {
        for (effect, slot, module) in
            [("fire", "dmf", "fire"), ("fire_ball", "warp", "turbulent"), ("smoke", "dmf", "turbulent")]
        {
            let strategies: &[&str] =
                if effect == "fire" { &["procedural", "hybrid", "lookups8", "channels"] } else { &["procedural"] };
            for &strategy in strategies {
                for pass in [Pass::Slices, Pass::March] {
                    let mut scene = preset(effect).unwrap();
                    (scene.object.input, scene.image.size) = ("torus".into(), [48, 48]);
                    if effect == "smoke" {
                        scene.effect.dmf = vec!["turbulent".into()];
                        scene.drop_foreign_parameters(&shader::shipped()).unwrap();
                    }
                    (scene.effect.turbulence, scene.quality.pass, scene.quality.samples) = (strategy.into(), pass, 96);
                    let subject = subject(&scene, &shader::shipped());
                    let frames = [shader::shipped(), patient(slot, module)]
                        .map(|library| picture(gpu, &library, &scene, &subject));
                    assert_eq!(difference(&frames[0], &frames[1]).0, 0.0, "{effect} with {strategy}, {pass:?}");
                    assert!(frames[0].pixels.iter().any(|pixel| pixel[3] > 0.1), "{effect} with {strategy} is empty");
                }
            }
        }
    });
}

/// The mean square of what a trilinear filter shows of a block between its texels, as a part of that at its texels: 1
/// where it shows no texels.
fn g01_roughness(gpu: &Gpu, blur: f32) -> f64 {
    let (mut scene, library) = probe();
    (scene.effect.noise, scene.quality.block_blur) = ("random".into(), blur);
    (scene.quality.block_size, scene.image.size) = (32, [192, 192]);
    let seen = seen(gpu, &library, &scene);
    // The second difference along a row, at a quarter of a texel: creases at texels are what a filter adds.
    let bends = seen.windows(3).filter(|three| three[0].0.y == three[2].0.y);
    let bend = rms(bends.map(|three| three[0].1[0] - 2.0 * three[1].1[0] + three[2].1[0]));
    bend / rms(seen.iter().map(|(_, value)| value[0]))
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn g01_blur_hides_the_texels_of_random_numbers() {
    with_gpu(|gpu| {
        let roughness = [0.0, 0.7, 1.5].map(|blur| g01_roughness(gpu, blur));
        println!("bend over amplitude without blur, with one of 0.7, of 1.5 texels: {roughness:.4?}");
        assert!(roughness[1] < 0.7 * roughness[0] && roughness[2] < 0.6 * roughness[1], "{roughness:?}");
    });
}
