//! DMFs in the soft region, in f64: layers, the hair of PH 2.4, kinds of DMFs, and optical properties by noise.

use crate::common::{box_subject, homogeneous, picture, rays, subject, with_gpu};
use crate::lattice::noise;
use crate::seen::{seen, seen_with, set, worst};
use glam::{DVec3, Vec3};
use hypertexture::field::{DistanceField, Grid};
use hypertexture::render::Subject;
use hypertexture::scene::{Filter, ParameterValue, Projection, Scene, preset};
use hypertexture::shader;
use std::sync::Arc;

fn bias(b: f64, t: f64) -> f64 {
    t.clamp(0.0, 1.0).powf(b.ln() / 0.5f64.ln())
}

fn gain(g: f64, t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    if t < 0.5 { 0.5 * bias(1.0 - g, 2.0 * t) } else { 1.0 - 0.5 * bias(1.0 - g, 2.0 - 2.0 * t) }
}

/// Distance to the cube [-1, 1]^3.
fn cube(x: DVec3) -> f64 {
    let q = x.abs() - 1.0;
    q.max(DVec3::ZERO).length() + q.max_element().min(0.0)
}

/// The point of its surface that is nearest to a point outside.
fn project(x: DVec3) -> DVec3 {
    x.clamp(DVec3::NEG_ONE, DVec3::ONE)
}

/// Around an edge and two corners of the cube: what `PLACE` is in GLSL.
fn place(x: DVec3) -> DVec3 {
    DVec3::new(1.4 * x.x, 1.4 * x.y, 1.2 + 0.15 * x.x + 0.25 * x.y)
}

const PLACE: &str = "vec3(1.4 * s.x.x, 1.4 * s.x.y, 1.2 + 0.15 * s.x.x + 0.25 * s.x.y)";

const THIN: &str = "// Thin.\n// Source: a test.\n// @outer thin_width\n\
    // @param thin_width = 0.2 in [0, 2]: Width.\n// Result: the density.\n\
    float thin(float density, Sample s) { return s.density * density; }\n";
const WIDE: &str = "// Wide.\n// Source: a test.\n// @outer wide_width\n\
    // @param wide_width = 0.6 in [0, 2]: Width.\n// Result: half the density.\n\
    float wide(float density, Sample s) { return 0.5 * density; }\n";

/// The soft region of the cube by DMFs, in place of its hard surface.
fn soft(scene: &mut Scene, dmfs: &[&str]) {
    scene.effect.dmf = dmfs.iter().map(|name| name.to_string()).collect();
    scene.effect.softness = "linear".into();
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m50_layers_have_own_widths_and_following_dmfs() {
    let text = format!(
        "#include <dmf>\nvec3 surface(Sample s) {{\n    Sample at = sample_object({PLACE}), a = at, b = at;\n    \
         float d = at.density > 0.0 ? modulate(at.density, at) : 0.0;\n    \
         return vec3(layer_0(a), layer_1(b), d);\n}}"
    );
    let library = shader::shipped().with_module("dmf", "thin", THIN).with_module("dmf", "wide", WIDE);
    with_gpu(|gpu| {
        let seen = seen_with(gpu, &library, &text, |scene| {
            soft(scene, &["thin", "wide", "biased"]);
            set(scene, &[("density_bias", 0.3)]);
        });
        let off = worst(&seen, |x| {
            let density = |width: f64| ((width - cube(place(x))) / width).clamp(0.0, 1.0);
            let (a, b) =
                (density(f64::from(0.2f32)).powi(2), bias(f64::from(0.3f32), 0.5 * density(f64::from(0.6f32))));
            DVec3::new(a, b, a + b - a * b)
        });
        assert!(off <= 5e-6, "{off:e}");
        assert!(seen.iter().filter(|(_, c)| c.x > 0.0 && c.y < 1.0).count() > 2000);
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m50_fur_and_flames_in_layers_equal_each_alone() {
    let at = format!("#include <dmf>\nvec3 surface(Sample s) {{\n    Sample at = sample_object({PLACE});\n");
    let alone = format!("{at}    return vec3(at.density > 0.0 ? clamp(modulate(at.density, at), 0.0, 1.0) : 0.0);\n}}");
    let parameters = [("hair_length", 0.2), ("fineness", 12.0), ("flame_length", 0.7), ("fury", 1.0)];
    with_gpu(|gpu| {
        let of = |dmfs: &[&str], text: &str| {
            seen(gpu, text, |scene| {
                soft(scene, dmfs);
                let own =
                    |name: &str| dmfs.contains(&if name.contains("fl") || name == "fury" { "fire" } else { "fur" });
                set(scene, &parameters.into_iter().filter(|(name, _)| own(name)).collect::<Vec<_>>());
            })
        };
        let both = of(
            &["fur", "fire"],
            &format!("{at}    Sample b = at;\n    return vec3(layer_0(at), layer_1(b), 0.0);\n}}"),
        );
        let (fur, fire) = (of(&["fur"], &alone), of(&["fire"], &alone));
        let of_both = |channel: usize| both.iter().map(move |(_, color)| color[channel]);
        for (name, channel, alone) in [("fur", 0, &fur), ("fire", 1, &fire)] {
            let off = of_both(channel).zip(alone).map(|(a, (_, b))| (a - b.x).abs()).fold(0.0, f64::max);
            let there = alone.iter().filter(|(_, color)| color.x > 0.05 && color.x < 1.0).count();
            assert!(off <= 2e-4 && there > 1000, "{name}: off by {off:e}, {there} points");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m50_layers_have_own_colors_opacities_and_shadows() {
    let medium = |name: &str, color: &str, rest: &str| {
        glsl_medium(&format!("vec3 medium(Sample s, float density) {{ return vec3({color}); }}\n{rest}"), name)
    };
    let [(_, red), (_, blue)] = [
        medium("red", "1.0, 0.0, 0.0", ""),
        medium("blue", "0.0, 0.0, 1.0", "float extinction(Sample s, float density) { return 0.25; }\n"),
    ];
    let library = shader::shipped()
        .with_module("dmf", "thin", &THIN.replace("s.density * density", "0.5"))
        .with_module("dmf", "wide", WIDE.replace("0.5 * density", "0.25").as_str())
        .with_module("medium", "red", &red)
        .with_module("medium", "blue", &blue);
    with_gpu(|gpu| {
        let mut scene = homogeneous("cube", 1.0, Projection::Parallel);
        scene.effect.opacity = "perlin".into();
        soft(&mut scene, &["thin", "wide"]);
        // A cube that is soft as far as its middle, in which both densities are constant.
        (scene.object.inner_iso, scene.effect.medium) = (-1.0, "red+blue".into());
        scene.object.outer_iso = 0.0;
        set(&mut scene, &[("thin_width", 0.0), ("wide_width", 0.0)]);
        scene.quality.samples = 2000;
        let subject = subject(&scene, &library);
        let frame = picture(gpu, &library, &scene, &subject);
        // Optical depths add, 2 (ln 2 + 0.25 ln 4/3) along a ray through the cube, and colors go by them.
        let depths = [2f64.ln(), 0.25 * (4.0 / 3.0f64).ln()];
        let alpha = 1.0 - (-2.0 * (depths[0] + depths[1])).exp();
        let red = depths[0] / (depths[0] + depths[1]);
        for (ray, pixel) in rays(&scene, &subject).iter().zip(&frame.pixels) {
            if ray.from.x.abs().max(ray.from.y.abs()) < 0.9 {
                let [r, g, b, a] = pixel.map(f64::from);
                assert!((a - alpha).abs() < 5e-3 && g == 0.0, "{pixel:?}, expected {alpha}");
                assert!((r / a - red).abs() < 1e-4 && (b / a - 1.0 + red).abs() < 1e-4, "{pixel:?}");
            }
        }
        scene.effect.medium = "red+blue+red".into();
        let error = scene.check(&library).unwrap_err().to_string();
        assert!(
            error.starts_with("effect.medium = red+blue+red: one medium, or one for each of the 2 DMFs"),
            "{error}"
        );
    });
}

fn glsl_medium(text: &str, name: &str) -> (String, String) {
    (name.into(), format!("// A medium.\n// Source: a test.\n// Result: a color.\n{text}"))
}

#[test]
fn m50_the_soft_region_is_as_wide_as_the_widest_layer() {
    let mut scene = preset("burning_bush").unwrap();
    let outer = |scene: &Scene| scene.check(&shader::shipped()).unwrap().outer_iso();
    let width = |scene: &Scene, parameter: &str| match scene.parameters[parameter] {
        ParameterValue::Number(width) => width,
        ParameterValue::Color(_) => f32::NAN,
    };
    assert_eq!(outer(&scene), Some(width(&scene, "flame_length")));
    scene.effect.dmf.reverse();
    scene.effect.medium = "flame+hair".into();
    assert_eq!(outer(&scene), Some(width(&scene, "flame_length")), "in any order");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn s01_5_fur_grows_only_within_its_mask() {
    let text = format!(
        "#include <dmf>\nvec3 surface(Sample s) {{\n    Sample at = sample_object({PLACE});\n    \
         return vec3(modulate(at.density, at), fur(at.density, at), height(at));\n}}"
    );
    with_gpu(|gpu| {
        let seen = seen(gpu, &text, |scene| {
            soft(scene, &["fur@height"]);
            set(scene, &[("hair_length", 0.8), ("height_from", 0.2), ("height_blend", 0.5)]);
        });
        let off = seen.iter().map(|(x, c)| match cube(place(*x)) {
            d if d <= 0.0 => (c.x - 1.0).abs(),
            _ => (c.x - c.y * c.z).abs(),
        });
        let off = off.fold(0.0, f64::max);
        assert!(off <= 2e-6, "{off:e}");
        let count = |grown: bool| seen.iter().filter(|(_, c)| (c.z > 0.5) == grown && c.y > 0.1 && c.y < 1.0).count();
        assert!(count(true) > 1000 && count(false) > 1000, "hair with the mask and without it");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p31_fur_is_the_formula_of_1989() {
    let text = format!(
        "#include \"dmf/fur.glsl\"\nvec3 surface(Sample s) {{\n    float d = 0.5 + 0.49 * s.x.x;\n    \
         Sample at = sample_object({PLACE});\n    at.density = d;\n    return vec3(fur(d, at));\n}}"
    );
    let parameters = [
        ("fineness", 12.0),
        ("curliness", 0.0),
        ("droop", 0.0),
        ("unevenness", 0.0),
        ("hair_middle", 0.0),
        ("hair_contrast", 1.0),
        ("hair_bias", 0.3),
        ("hair_gain", 0.9),
    ];
    with_gpu(|gpu| {
        let seen: Vec<_> = seen(gpu, &text, |scene| set(scene, &parameters));
        let outside: Vec<_> = seen.into_iter().filter(|(x, _)| cube(place(*x)) > 1e-3).collect();
        let off = worst(&outside, |x| {
            let s = noise(12.0 * project(place(x)));
            DVec3::splat(gain(0.9, bias(0.3, 0.5 + 0.5 * s)) * (0.5 + 0.49 * x.x))
        });
        assert!(off <= 1e-5 && outside.len() > 10_000, "{off:e} at {} points", outside.len());
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p34_tribble_is_the_formula_of_1989_with_straight_roots() {
    let shift = {
        let library = shader::shipped();
        let text = library.source("vector_noise.glsl").unwrap();
        let numbers = text.split_once("NOISE_SHIFT = vec3(").unwrap().1.split_once(')').unwrap().0;
        DVec3::from_slice(&numbers.split(',').map(|number| number.trim().parse().unwrap()).collect::<Vec<f64>>())
    };
    let vector_noise = |p: DVec3| DVec3::new(noise(p - shift), noise(p), noise(p + shift));
    let uncurled = |x: DVec3, d: f64| x + gain(0.8, 1.0 - d) * 0.3 * vector_noise(2.5 * x);
    let density = |x: DVec3| 0.5 + 0.49 * x.x;
    let text = |density: &str, result: &str| {
        format!(
            "#include \"dmf/tribble.glsl\"\nvec3 surface(Sample s) {{\n    float d = {density};\n    \
             Sample at = sample_object({PLACE});\n    at.density = d;\n    return {result};\n}}"
        )
    };
    let parameters =
        [("tribble_fineness", 6.0), ("tribble_curliness", 0.3), ("curl_frequency", 2.5), ("tribble_contrast", 1.0)];
    with_gpu(|gpu| {
        let of = |density: &str, result: &str| seen(gpu, &text(density, result), |scene| set(scene, &parameters));
        let moved = of("0.5 + 0.49 * s.x.x", "0.5 + 0.25 * uncurled(at)");
        let off = worst(&moved, |x| 0.5 + 0.25 * uncurled(place(x), density(x)));
        assert!(off <= 5e-6, "x': {off:e}");
        let root = of("1.0", "uncurled(at) - at.x");
        assert!(root.iter().all(|(_, color)| *color == DVec3::ZERO), "d = 1 gives x' = x");
        let hair = of("0.5 + 0.49 * s.x.x", "vec3(tribble(d, at))");
        let outside: Vec<_> = hair.into_iter().filter(|(x, _)| cube(uncurled(place(*x), density(*x))) > 1e-3).collect();
        let off = worst(&outside, |x| {
            let s = noise(6.0 * project(uncurled(place(x), density(x))));
            DVec3::splat(gain(0.9, bias(0.3, 0.5 + 0.5 * s)) * density(x))
        });
        assert!(off <= 2e-5 && outside.len() > 10_000, "{off:e} at {} points", outside.len());
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn g04_noise_changes_the_opacity_after_the_transfer_map() {
    let half =
        "// Half.\n// Source: a test.\n// Result: density.\nfloat half_full(float density, Sample s) { return 0.5; }\n";
    let library = shader::shipped().with_module("dmf", "half_full", half);
    with_gpu(|gpu| {
        let mut scene = homogeneous("cube", 1.0, Projection::Parallel);
        soft(&mut scene, &["half_full"]);
        (scene.object.inner_iso, scene.object.outer_iso) = (-1.0, 0.0);
        (scene.effect.medium, scene.effect.noise) = ("perturbed".into(), "procedural".into());
        set(&mut scene, &[("irregularity_frequency", 1.5), ("irregularity", 0.0), ("iridescence", 0.0)]);
        (scene.quality.samples, scene.image.size) = (1500, [40, 40]);
        let subject = subject(&scene, &library);
        let mut depths = |patchiness: f32| {
            set(&mut scene, &[("patchiness", patchiness)]);
            let frame = picture(gpu, &library, &scene, &subject);
            let known = rays(&scene, &subject).into_iter().zip(frame.pixels);
            known
                .filter(|(ray, _)| ray.from.x.abs().max(ray.from.y.abs()) < 0.95)
                .map(|(ray, pixel)| {
                    let color = f64::from(pixel[0]) / f64::from(pixel[3]);
                    (ray.from, -(1.0 - f64::from(pixel[3])).ln(), color)
                })
                .collect::<Vec<_>>()
        };
        let (even, patchy) = (depths(0.0), depths(1.5));
        let fourth = |p: DVec3| noise(p + 2.0 * DVec3::new(13.2, 5.82, 7.11));
        let (mut off, mut spread) = (0f64, 0f64);
        for ((from, plain, color), (_, depth, same)) in even.iter().zip(&patchy) {
            let z = |i: i32| (f64::from(i) + 0.5) / 500.0 - 1.0;
            let factor = |i| (1.0 + 1.5 * fourth(1.5 * DVec3::new(from.x, from.y, z(i)))).max(0.0);
            let expected = 0.5 * (0..1000).map(factor).sum::<f64>() / 500.0;
            assert!((plain - 1.0).abs() < 4e-3 && (color - same).abs() < 1e-4, "{plain} {color} {same}");
            off = off.max((depth - expected).abs());
            spread = spread.max((expected - 1.0).abs());
        }
        println!("optical depths that differ by up to {spread:.2} are off by {off:.1e}");
        assert!(off < 4e-3 && spread > 0.2 && even.len() > 200);
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn g04_all_four_channels_of_the_random_block_are_read() {
    let text = "#include \"four_noises.glsl\"\nvec3 surface(Sample s) {\n    vec4 n = four_noises(7.0 * vec3(s.x.xy, 0.37));\n    \
        return 0.5 + 0.5 * (s.x.y < 0.0 ? n.rgb : n.aaa);\n}";
    let block = hypertexture::noise::random_block(1989, 16, 0.7);
    let value = |p: DVec3, channel: usize| {
        let (low, part) = ((p - 0.5).floor(), (p - 0.5) - (p - 0.5).floor());
        let corner = |corner: usize| {
            let side = [corner & 1, corner >> 1 & 1, corner >> 2];
            let at = [0, 1, 2].map(|axis| (low[axis] as i64 + side[axis] as i64).rem_euclid(16) as usize);
            let weight: f64 = (0..3).map(|a| if side[a] == 1 { part[a] } else { 1.0 - part[a] }).product();
            weight * f64::from(block[at[0] + 16 * (at[1] + 16 * at[2])][channel])
        };
        (0..8).map(corner).sum::<f64>()
    };
    with_gpu(|gpu| {
        let seen = seen(gpu, text, |scene| {
            (scene.effect.noise, scene.quality.block_size) = ("random".into(), 16);
        });
        let off = worst(&seen, |x| match x.y < 0.0 {
            true => DVec3::from([0, 1, 2].map(|channel| value(7.0 * x, channel))),
            false => DVec3::splat(value(7.0 * x, 3)),
        });
        // A device filters with weights of 8 bits.
        assert!(off <= 0.01, "{off:e}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p40_gain_lowers_amplitude_and_keeps_the_steepest_slope() {
    let text = "#include \"dmf/traded.glsl\"\nvec3 surface(Sample s) {\n    s.density = 0.5;\n    s.x.z = 0.37;\n    \
        return 0.5 + 0.5 * vec3(traded(0.3, s), traded(0.3, s) - 0.3, 0.0);\n}";
    let formula = |g: f64, x: DVec3| 0.6 * (2.0 * gain(g, 0.5 + 0.5 * noise(3.0 * x)) - 1.0) / -(1.0 - g).log2();
    with_gpu(|gpu| {
        let mut heights = Vec::new();
        for g in [0.5, 0.75, 0.9375] {
            let parameters = [("trade_gain", g as f32), ("trade_frequency", 3.0), ("trade_strength", 0.6)];
            let seen = seen(gpu, text, |scene| set(scene, &parameters));
            let off = worst(&seen, |x| 0.5 + 0.5 * DVec3::new(0.3 + formula(g, x), formula(g, x), 0.0));
            assert!(off <= 2e-5, "gain {g}: {off:e}");
            // The steepest slope by the noise, at 0, from the formula alone.
            let slope = (gain(g, 0.5 + 5e-5) - gain(g, 0.5 - 5e-5)) / 1e-4 / -(1.0 - g).log2();
            assert!((slope - 1.0).abs() < 1e-3, "gain {g}: {slope}");
            heights.push(seen.iter().map(|(_, color)| (color.y - 0.5).abs()).fold(0.0, f64::max));
        }
        assert!(heights.windows(2).all(|pair| pair[1] < 0.8 * pair[0]), "{heights:?}");
    });
}

/// Response of a DMF to a change of a single input.
#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p04_a_dmf_depends_only_on_the_inputs_of_its_kind() {
    const BY_SAMPLE: &str = "// @needs normal\n\
                             vec3 project(vec3 x, Sample s) { return x - (s.distance - iso_value) * s.normal; }\n\
                             float trust(Sample s) { return 1.0; }\n";
    let library = shader::shipped();
    let by_sample = library.clone().with_module("project", "by_sample", BY_SAMPLE);
    with_gpu(|gpu| {
        for dmf in library.modules("dmf") {
            let text = format!(
                "#include \"dmf/{dmf}.glsl\"\nvec3 surface(Sample s) {{\n    Sample at = sample_object({PLACE});\n    \
                 at.density = 0.6;\n    Sample moved = at, turned = at;\n    moved.x += vec3(0.31, 0.17, 0.23);\n    \
                 turned.normal = safe_normalize(at.normal.yzx + vec3(0.3, 0.2, 0.1), at.normal);\n    \
                 turned.distance += 0.13;\n    float d = {dmf}(0.6, at);\n    \
                 return abs(vec3({dmf}(0.6, moved) - d, {dmf}(0.6, turned) - d, 0.0));\n}}"
            );
            // By the sample alone, not by an object that it does not know.
            let seen = seen_with(gpu, &by_sample, &text, |scene| scene.effect.project = "by_sample".into());
            let changes = |channel: usize| seen.iter().filter(|(_, color)| color[channel] > 1e-3).count() > 100;
            let found = match (changes(0), changes(1)) {
                (false, false) => shader::DmfKind::PositionIndependent,
                (true, false) => shader::DmfKind::PositionDependent,
                (_, true) => shader::DmfKind::GeometryDependent,
            };
            assert_eq!(library.kind(dmf).unwrap(), found, "{dmf}");
        }
    });
}

/// Points of a circle, and waves around it that a field of 32 voxels can hold: two voxels a wave.
const CIRCLE: usize = 512;
const HELD: usize = 24;

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn g05_perturbed_lookups_add_detail_to_a_coarse_field() {
    let library =
        shader::shipped().with_module("surface", "depth_probe", "vec3 surface(Sample s) { return vec3(s.x.z); }");
    // Depths along a circle of radius 1/2 on a ball: a field of so many voxels, looked up at places moved so far.
    let depths = |gpu: &hypertexture::gpu::Gpu, resolution: u32, perturbation: f32| {
        let mut scene = homogeneous("sphere", 1.0, Projection::Parallel);
        (scene.effect.classify, scene.effect.surface) = ("surface".into(), "depth_probe".into());
        scene.object.field_encoding = hypertexture::scene::FieldEncoding::Normals16;
        (scene.effect.warp, scene.effect.noise) = (vec!["perturbed".into()], "procedural".into());
        set(
            &mut scene,
            &[("perturbation", perturbation), ("perturbation_frequency", 6.0), ("perturbation_speed", 0.0)],
        );
        scene.quality.integration = hypertexture::scene::Integration::Segment;
        scene.quality.filter = Filter::precise(gpu.info().filters_by_few_bits());
        scene.image.size = [320, 320];
        let grid = Grid {
            size: [resolution; 3],
            origin: Vec3::splat(-1.4),
            spacing: Vec3::splat(2.8 / (resolution - 1) as f32),
        };
        let n = resolution;
        let places = (0..n).flat_map(|k| (0..n).flat_map(move |j| (0..n).map(move |i| (i, j, k))));
        let values = places.map(|(i, j, k)| grid.position(i, j, k).length() - 1.0).collect();
        let subject =
            Subject { field: Some(Arc::new(DistanceField { grid, values })), radius: 1.0, ..box_subject(Vec3::ONE) };
        let frame = picture(gpu, &library, &scene, &subject);
        let rays = rays(&scene, &subject);
        let pixel = rays[1].from.x - rays[0].from.x;
        let depth = |turn: f64| {
            let [x, y] = [0.5 * turn.cos() - rays[0].from.x, rays[0].from.y - 0.5 * turn.sin()].map(|d| d / pixel);
            let at = |i: usize, j: usize| f64::from(frame.pixels[(y as usize + j) * 320 + x as usize + i][0]);
            let row = |j: usize| at(0, j) + x.fract() * (at(1, j) - at(0, j));
            row(0) + y.fract() * (row(1) - row(0))
        };
        (0..CIRCLE).map(|i| depth(std::f64::consts::TAU * i as f64 / CIRCLE as f64)).collect::<Vec<f64>>()
    };
    // Root mean square of all waves that are finer than those that the field can hold.
    let fine = |depths: &[f64]| {
        let power = |wave: usize| {
            let part = |f: fn(f64) -> f64| {
                let turn = |i: usize| f(std::f64::consts::TAU * ((wave * i) % CIRCLE) as f64 / CIRCLE as f64);
                depths.iter().enumerate().map(|(i, depth)| depth * turn(i)).sum::<f64>() / CIRCLE as f64
            };
            2.0 * (part(f64::cos).powi(2) + part(f64::sin).powi(2))
        };
        (HELD + 1..CIRCLE / 4).map(power).sum::<f64>().sqrt()
    };
    with_gpu(|gpu| {
        let [plain, coarse, truth] = [(32, 0.0), (32, 0.15), (128, 0.15)].map(|(n, by)| depths(gpu, n, by));
        let off = plain.iter().map(|depth| (depth - 0.75f64.sqrt()).abs()).fold(0.0, f64::max);
        let rms =
            |a: &[f64], b: &[f64]| (a.iter().zip(b).map(|(a, b)| (a - b).powi(2)).sum::<f64>() / CIRCLE as f64).sqrt();
        let (bare, detail) = (fine(&plain), fine(&coarse));
        println!(
            "waves finer than 2 voxels: {bare:.1e} without, {detail:.1e} with noise; of 128 voxels {:.1e}",
            fine(&truth)
        );
        println!(
            "the detail is {:.1e} high, and off by {:.1e} from that of 128 voxels",
            rms(&coarse, &plain),
            rms(&coarse, &truth)
        );
        assert!(off < 0.02, "the bare ball is off by {off}");
        assert!(detail > 10.0 * bare && (0.7..1.4).contains(&(detail / fine(&truth))));
        assert!(rms(&coarse, &truth) < 0.3 * rms(&coarse, &plain));
    });
}

#[test]
fn s01_5_the_tank_has_five_objects_with_own_parameters() {
    let library = shader::shipped();
    let mut scene = preset("tank").unwrap();
    scene.object.resolution = 64;
    scene.parts.values_mut().for_each(|part| part.object.resolution = 64);
    let whole = subject(&scene, &library);
    let box_of = |name: &str| match name {
        "hull" => (-whole.half_size, whole.half_size),
        name => {
            let (place, half) = (scene.parts[name].transform, whole.parts[name].half_size);
            (Vec3::from(place.at) - place.scale * half, Vec3::from(place.at) + place.scale * half)
        }
    };
    let [hull, turret, gun, tracks, wheels] = ["hull", "turret", "gun", "tracks", "wheels"].map(box_of);
    let near = |a: f32, b: f32| (a - b).abs() < 0.08;
    assert!(near(turret.0.y, hull.1.y) && turret.0.x > hull.0.x && turret.1.x < hull.1.x, "the turret is on the hull");
    assert!(gun.0.x < turret.1.x && gun.1.x > hull.1.x && gun.1.y < turret.1.y, "the gun looks out of the turret");
    assert!(tracks.0.y < hull.0.y - 0.1 && near(tracks.0.z, -tracks.1.z) && tracks.1.z < hull.1.z, "tracks carry it");
    assert!(wheels.0.cmpgt(tracks.0).all() && wheels.1.cmplt(tracks.1).all(), "wheels are in the tracks");
    let variant = hypertexture::render::variant::Variant::of(&scene, &library).unwrap();
    let parameters: Vec<String> = variant.all_parameters().map(|(name, ..)| name).collect();
    for parameter in ["ball_radius", "parts.turret.height_from", "parts.gun.ball_radius", "parts.tracks.bump_scale"] {
        assert!(parameters.iter().any(|name| name == parameter), "{parameter} is none of {parameters:?}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p26_octaves_of_the_fractal_sphere_scale_by_1_over_f() {
    let number = |scene: &Scene, parameter: &str| match scene.parameters[parameter] {
        ParameterValue::Number(value) => f64::from(value),
        ParameterValue::Color(_) => f64::NAN,
    };
    for name in ["noisy_sphere", "high_frequency_sphere"] {
        let scene = preset(name).unwrap();
        assert_eq!(number(&scene, "amplitude") * number(&scene, "frequency"), 1.0, "{name}");
    }
    let scene = preset("fractal_sphere").unwrap();
    let parameters =
        ["fractal_amplitude", "fractal_frequency"].map(|parameter| (parameter, number(&scene, parameter) as f32));
    let f = number(&scene, "fractal_frequency");
    assert_eq!(f, number(&preset("noisy_sphere").unwrap(), "frequency"), "the same sphere again");
    let text = include_str!("../glsl/warp_probe.glsl")
        .replace("MODULE", "fractal")
        .replace("MODE", "0")
        .replace("REACH", "1.0");
    with_gpu(|gpu| {
        let seen = seen(gpu, &text, |scene| {
            set(scene, &parameters);
            scene.effect.octaves = 6;
        });
        let within: Vec<_> = seen.into_iter().filter(|(x, _)| x.length() < 1.15).collect();
        let off = worst(&within, |x| {
            let sum: f64 = (0..6).map(|i| f * f64::from(1 << i)).map(|f| noise(f * x) / f).sum();
            0.5 + 0.1 * x * (1.0 + sum)
        });
        assert!(off <= 5e-6 && within.len() > 10_000, "{off:e} at {} points", within.len());
    });
}
