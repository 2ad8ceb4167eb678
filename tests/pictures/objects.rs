//! Several objects in one scene: soft booleans, places, masks, and modules that are used more than once.

use crate::common::{difference, homogeneous, picture, rays, with_gpu};
use glam::DVec3;
use hypertexture::gpu::Gpu;
use hypertexture::render::variant::Variant;
use hypertexture::scene::{self, Boolean, EmptySpace, ParameterValue, Part, Pass, Projection, Scene, Transform};
use hypertexture::shader::{self, Library};

fn library() -> Library {
    let modules = [("level", include_str!("../glsl/level.glsl")), ("halve", include_str!("../glsl/halve.glsl"))];
    modules.into_iter().fold(shader::shipped(), |library, (name, text)| library.with_module("dmf", name, text))
}

/// Cubes that fill the same place with one density each, combined.
fn levels(formula: &str, boolean: Boolean, levels: &[(&str, f32)]) -> Scene {
    let mut scene = homogeneous("cube", 1.0, Projection::Parallel);
    scene.image.size = [9, 9];
    scene.effect.dmf = vec!["level".into()];
    let parameter = |level| [("amount".to_string(), ParameterValue::Number(level))].into();
    for (name, level) in levels {
        match *name {
            "main" => scene.parameters = parameter(*level),
            name => {
                let part = Part {
                    object: scene.object.clone(),
                    effect: scene.effect.clone(),
                    parameters: parameter(*level),
                    material: scene.material.clone(),
                    ..Part::default()
                };
                scene.parts.insert(name.into(), part);
            }
        }
    }
    (scene.combine, scene.boolean) = (Some(formula.into()), boolean);
    scene
}

/// Optical depth of the middle of a picture.
fn depth(gpu: &Gpu, library: &Library, scene: &Scene) -> f64 {
    let frame = picture(gpu, library, scene, &crate::common::subject(scene, library));
    -(1.0 - f64::from(frame.pixels[frame.pixels.len() / 2][3])).ln()
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p06_to_p09_soft_booleans_of_any_depth_are_their_formulas() {
    let library = library();
    let (a, b, c) = (0.75f64, 0.4f64, 0.1f64);
    let given = [("main", a as f32), ("b", b as f32), ("c", c as f32)];
    let or = |a: f64, b: f64| a + b - a * b;
    let (low, high) = (f64::min, f64::max);
    let cases: [(&str, f64, f64); 6] = [
        ("main & b & c", a * b * c, low(low(a, b), c)),
        ("main | b | c", or(or(a, b), c), high(high(a, b), c)),
        ("main - b - c", a * (1.0 - b) * (1.0 - c), low(low(a, 1.0 - b), 1.0 - c)),
        (
            "main & !b | !main & b | c",
            or(or(a * (1.0 - b), (1.0 - a) * b), c),
            high(high(low(a, 1.0 - b), low(1.0 - a, b)), c),
        ),
        ("main - (b - !(c & main))", a * (1.0 - b * c * a), low(a, 1.0 - low(b, low(c, a)))),
        ("(main & !main) | (b & c & b)", or(a * (1.0 - a), b * c * b), high(low(a, 1.0 - a), low(b, c))),
    ];
    with_gpu(|gpu| {
        let full =
            depth(gpu, &library, &levels("main | b | c", Boolean::Minmax, &[("main", 1.0), ("b", 0.0), ("c", 0.0)]));
        for (text, algebraic, minmax) in cases {
            for (boolean, expected) in [(Boolean::Algebraic, algebraic), (Boolean::Minmax, minmax)] {
                let found = depth(gpu, &library, &levels(text, boolean, &given)) / full;
                assert!((found - expected).abs() < 2e-6, "{text}, {boolean:?}: {found} instead of {expected}");
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p11_soft_booleans_are_no_boolean_algebra() {
    let library = library();
    with_gpu(|gpu| {
        let at = |text: &str, level: f32| {
            let full = depth(gpu, &library, &levels("main | b", Boolean::Algebraic, &[("main", 1.0), ("b", 0.0)]));
            depth(gpu, &library, &levels(text, Boolean::Algebraic, &[("main", level), ("b", 0.0)])) / full
        };
        assert!((at("main & main | b", 0.5) - 0.5).abs() > 0.2, "a and a is a");
        assert!(at("main & !main | b", 0.5) > 0.2, "a and not a is nothing");
        // In the hard region and outside they are one.
        assert!((at("main & main | b", 1.0) - 1.0).abs() < 1e-6);
        assert!(at("main & !main | b", 1.0) < 1e-6);
    });
}

/// Two soft spheres side by side, which touch at the origin.
fn pair(softness: f32, boolean: Boolean) -> Scene {
    let mut scene = homogeneous("sphere", 2.0, Projection::Parallel);
    scene.effect.softness = "linear".into();
    (scene.object.inner_iso, scene.object.outer_iso) = (-0.5 * softness, 0.5 * softness);
    let part = Part {
        object: scene.object.clone(),
        effect: scene.effect.clone(),
        material: scene.material.clone(),
        transform: Transform { at: [2.0, 0.0, 0.0], ..Transform::default() },
        ..Part::default()
    };
    scene.parts.insert("b".into(), part);
    scene.boolean = boolean;
    scene.quality.samples = 512;
    scene
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p10_a_fillet_is_as_wide_as_the_soft_regions() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        // Matter that the product adds to the maximum, summed over the picture: a band whose width, height and depth
        // all grow with the softness.
        let added = [0.1, 0.2, 0.4].map(|softness| {
            let [product, maximum] = [Boolean::Algebraic, Boolean::Minmax].map(|boolean| {
                let scene = pair(softness, boolean);
                picture(gpu, &library, &scene, &crate::common::subject(&scene, &library))
            });
            let sum = |frame: &hypertexture::render::Frame| frame.pixels.iter().map(|p| f64::from(p[3])).sum::<f64>();
            (sum(&product) - sum(&maximum)) / product.pixels.len() as f64
        });
        println!("matter in the fillet: {added:?}");
        assert!(added[0] > 0.0 && added[1] > 1.8 * added[0] && added[2] > 1.8 * added[1], "{added:?}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m63_a_placed_object_is_where_and_as_large_as_its_place_says() {
    let library = shader::shipped();
    let (center, radius, rate) = (DVec3::new(0.3, -0.2, 0.1), 0.3, 3.0);
    let mut scene = homogeneous("cube", rate as f32, Projection::Parallel);
    let mut part = Part {
        effect: scene.effect.clone(),
        material: scene.material.clone(),
        transform: Transform {
            at: center.as_vec3().to_array(),
            turn: [30.0, -50.0, 70.0],
            scale: radius as f32,
            aligned: false,
        },
        ..Part::default()
    };
    part.object.input = "sphere".into();
    scene.parts.insert("ball".into(), part);
    // The cube adds nothing but the room that the rays of the test know.
    scene.combine = Some("ball | main & !main".into());
    with_gpu(|gpu| {
        let subject = crate::common::subject(&scene, &library);
        let rows = [64u32, 512].map(|samples| {
            let mut scene = scene.clone();
            scene.quality.samples = samples;
            let frame = picture(gpu, &library, &scene, &subject);
            let rays = rays(&scene, &subject);
            let off = rays.iter().zip(&frame.pixels).map(|(ray, pixel)| {
                let b = (ray.from - center).cross(ray.along).length();
                let chord = 2.0 * (radius * radius - b * b).max(0.0).sqrt();
                (f64::from(pixel[3]) - (1.0 - (-rate * chord).exp())).abs()
            });
            crate::common::Level::of(samples, f64::from(frame.measurements.step), off)
        });
        println!("{rows:?}");
        assert!(rows[1].mean < 1e-3 && rows[0].order(&rows[1]) > 0.8);
    });
}

/// A scene with an effect of its own on each of three objects.
fn ensemble() -> Scene {
    let text = "preset = 'fur'\n object.input = 'torus'\n combine = 'main | flame - bite | stone'\n
        [parts.flame]\n preset = 'fire'\n object.input = 'sphere'\n transform = { at = [1.5, 0.4, 0], scale = 0.6 }\n
        [parts.stone]\n preset = 'solid'\n object.input = 'cube'\n transform = { at = [-1.6, 0, 0], scale = 0.5, turn = [0, 40, 0] }\n
        [parts.bite]\n object = { input = 'sphere', outer_iso = 0.05 }\n effect = { classify = 'soft', softness = 'linear' }\n
        transform = { at = [0.4, 0.3, 0.8], scale = 0.6 }\n";
    let mut scene = scene::parse(text, "ensemble").expect("a scene");
    scene.image.size = [96, 72];
    scene.quality.samples = 160;
    scene
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m63_objects_with_own_effects_look_equal_in_both_passes() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        for boolean in [Boolean::Algebraic, Boolean::Minmax] {
            let mut scene = ensemble();
            scene.boolean = boolean;
            scene.quality.early_termination = 0.0;
            let subject = crate::common::subject(&scene, &library);
            let slices = picture(gpu, &library, &scene, &subject);
            scene.quality.pass = Pass::March;
            let skipped = picture(gpu, &library, &scene, &subject);
            scene.quality.empty_space = EmptySpace::Sample;
            let all = picture(gpu, &library, &scene, &subject);
            assert!(all.pixels == skipped.pixels, "{boolean:?}");
            let (_, rms) = difference(&slices, &skipped);
            println!("{boolean:?}: slices and rays differ by {rms:.1e} root mean square");
            assert!(rms < 2e-3, "{boolean:?}: {rms:e}");
            assert!(skipped.pixels.iter().filter(|pixel| pixel[3] > 0.5).count() > 500, "there is little to see");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m50_a_module_repeats_with_own_parameters_and_mask() {
    let library = library();
    with_gpu(|gpu| {
        let mut scene = homogeneous("cube", 1.0, Projection::Parallel);
        scene.image.size = [9, 9];
        let full = depth(gpu, &library, &scene);
        let mut with = |dmf: &[&str], parameters: &[(&str, f32)]| {
            scene.effect.dmf = dmf.iter().map(|name| name.to_string()).collect();
            scene.parameters =
                parameters.iter().map(|(name, value)| (name.to_string(), ParameterValue::Number(*value))).collect();
            depth(gpu, &library, &scene) / full
        };
        let close = |found: f64, expected: f64| assert!((found - expected).abs() < 2e-6, "{found}, not {expected}");
        close(with(&["halve", "halve", "halve"], &[]), 0.125);
        close(with(&["level", "halve", "level"], &[("amount", 0.3), ("amount_2", 0.9)]), 0.9);
        // The density of a hard object is 1: the band of depths up to 1/2 does not reach it, the band up to 1 does.
        close(with(&["level@band"], &[("amount", 0.25), ("band_to", 0.5)]), 1.0);
        close(
            with(
                &["level@band", "halve@band"],
                &[("amount", 0.25), ("band_to", 0.5), ("band_from_2", 0.0), ("band_to_2", 0.5)],
            ),
            1.0,
        );
        close(with(&["level@ball"], &[("amount", 0.25), ("ball_y", 0.0), ("ball_radius", 8.0)]), 0.25);
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m49_a_dmf_acts_where_its_mask_says() {
    let library = library();
    with_gpu(|gpu| {
        let mut scene = homogeneous("cube", 1.0, Projection::Parallel);
        scene.effect.dmf = vec!["level@height".into()];
        for (name, value) in [("amount", 0.0), ("height_from", 0.25), ("height_blend", 0.001)] {
            scene.parameters.insert(name.into(), ParameterValue::Number(value));
        }
        let subject = crate::common::subject(&scene, &library);
        let frame = picture(gpu, &library, &scene, &subject);
        for (ray, pixel) in rays(&scene, &subject).iter().zip(&frame.pixels) {
            let inside = ray.from.x.abs() < 0.98 && ray.from.y.abs() < 0.98;
            if inside && (ray.from.y - 0.25).abs() > 0.01 {
                assert_eq!(pixel[3] > 0.0, ray.from.y < 0.25, "at height {}", ray.from.y);
            }
        }
    });
}

#[test]
fn errors_of_further_modules_name_object_module_and_line() {
    let library =
        shader::shipped().with_module("dmf", "bad", "float bad(float density, Sample s) {\n    return qq;\n}");
    let mut scene = levels("main | b", Boolean::Algebraic, &[("main", 1.0), ("b", 1.0)]);
    scene.effect.dmf.clear();
    scene.parameters.clear();
    let part = scene.parts.get_mut("b").expect("it was made");
    part.effect.dmf = vec!["bad".into()];
    part.parameters.clear();
    let variant = hypertexture::render::variant::Variant::of(&scene, &library).expect("the modules exist");
    let error = variant.program(&library, hypertexture::shader::Linker::new).expect_err("qq is nothing").to_string();
    assert!(error.contains("b:dmf/bad.glsl:2: error: 'qq'"), "{error}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_hidden_object_is_out_of_the_picture_and_of_the_program() {
    let library = library();
    let whole = levels("main - b | c", Boolean::Algebraic, &[("main", 0.75), ("b", 0.4), ("c", 0.1)]);
    with_gpu(|gpu| {
        for (hidden, formula) in
            [(&["b"][..], Some("main | c")), (&["c"][..], Some("main - b")), (&["b", "c"][..], None)]
        {
            let (mut scene, mut without) = (whole.clone(), whole.clone());
            for name in hidden {
                scene.set_field(&format!("parts.{name}.hidden"), "true").unwrap();
                without.parts.remove(*name);
            }
            without.combine = formula.map(String::from);
            let [a, b] = [&scene, &without].map(|scene| Variant::of(scene, &library).unwrap());
            assert_eq!((&a.slots, &a.entries), (&b.slots, &b.entries), "{hidden:?}");
            let pixels = |scene| picture(gpu, &library, scene, &crate::common::subject(scene, &library)).pixels;
            assert_eq!(pixels(&scene), pixels(&without), "{hidden:?}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn the_front_of_a_thin_difference_is_that_of_the_object() {
    with_gpu(|gpu| {
        let library = library();
        let scene = |boolean: &str, more: &str| {
            let text =
                format!("boolean = \"{boolean}\"\n{more}[image]\nsize = [48, 48]\n[object]\ninput = \"sphere\"\n");
            scene::parse(&text, "a scene").expect("a scene")
        };
        let draw = |scene: &Scene| picture(gpu, &library, scene, &crate::common::subject(scene, &library));
        let part = |formula: &str, place: &str| {
            format!(
                "combine = \"{formula}\"\n[parts.b]\nobject = {{ input = \"sphere\" }}\ntransform = {{ {place} }}\n"
            )
        };
        for boolean in ["algebraic", "minmax"] {
            let ball = draw(&scene(boolean, &part("main | b", "scale = 0.5")));
            for (formula, place) in [
                ("main - b", "scale = 0.99"),
                ("main - b", "scale = 0.999"),
                ("main - b", "scale = 0.9999"),
                ("main - b", "scale = 0.99999"),
                ("main & !b", "scale = 0.9999"),
            ] {
                let hollow = draw(&scene(boolean, &part(formula, place)));
                let off = |(a, b): (&[f32; 4], &[f32; 4])| (0..4).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
                let off: Vec<f32> = ball.pixels.iter().zip(&hollow.pixels).map(off).collect();
                let wrong = off.iter().filter(|off| **off > 0.02).count();
                let covered = ball.pixels.iter().filter(|pixel| pixel[3] > 0.5).count();
                println!("{boolean}, {formula}, {place}: {wrong} of {covered} pixels");
                assert!(wrong * 200 <= covered, "{boolean}, {formula}, {place}: {wrong} pixels of {covered}");
            }
        }
    });
}
