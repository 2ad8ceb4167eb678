//! Values at the end of what a scene may say: every picture is finite, and where the answer is known it is that.

use crate::common::{difference, formula, homogeneous, is_whole, picture, with_gpu};
use hypertexture::gpu::Gpu;
use hypertexture::render::{Frame, RenderError, Subject, render};
use hypertexture::scene::{self, EFFECTS, ParameterValue, Pass, Projection, Proxy, Scene, preset};
use hypertexture::shader::{self, ParameterKind};

/// Renders a scene whose object is a formula, by slices as well; a value that is not finite is an error of the renderer.
fn finite(gpu: &Gpu, scene: &Scene) -> Frame {
    let (library, subject) = (shader::shipped(), formula(scene));
    let mut slices = scene.clone();
    slices.quality.pass = Pass::Slices;
    if slices.check(&library).is_ok() {
        picture(gpu, &library, &slices, &subject);
    }
    picture(gpu, &library, scene, &subject)
}

fn soft(softness: &str, inner: f32, outer: f32) -> Scene {
    let mut scene = homogeneous("sphere", 3.0, Projection::Perspective);
    scene.effect.softness = softness.into();
    (scene.object.inner_iso, scene.object.outer_iso) = (inner, outer);
    scene.quality.samples = 64;
    scene
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p45_opacity_is_all_or_nothing_at_the_ends_of_its_rate() {
    with_gpu(|gpu| {
        for opacity in ["beer", "perlin"] {
            for (rate, expected) in [(0.0, 0.0), (1e9, 1.0)] {
                let mut scene = soft("linear", -0.2, 0.2);
                scene.effect.opacity = opacity.into();
                scene.effect.opacity_rate = rate;
                let frame = finite(gpu, &scene);
                assert_eq!(frame.pixels[32 * 64 + 32][3], expected, "{opacity} at {rate}");
                assert_eq!(frame.pixels[0][3], 0.0, "{opacity} at {rate}: outside");
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m47_equal_iso_values_give_the_hard_object() {
    with_gpu(|gpu| {
        let hard = finite(gpu, &soft("hard", 0.1, 0.1));
        for softness in ["linear", "quadratic"] {
            let (max, _) = difference(&hard, &finite(gpu, &soft(softness, 0.1, 0.1)));
            assert_eq!(max, 0.0, "{softness}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p02_a_soft_region_wider_than_the_sphere_has_no_false_core() {
    with_gpu(|gpu| {
        // The inner radius would be -0.5; squared it would come back as 0.5 and bring a solid core.
        let wide = finite(gpu, &soft("quadratic", -1.5, 0.5));
        let held = finite(gpu, &soft("quadratic", -1.0, 0.5));
        assert_eq!(difference(&wide, &held).0, 0.0);
        let column: Vec<f32> = (8..=32).map(|y| wide.pixels[y * 64 + 32][3]).collect();
        assert!(column.windows(2).all(|pair| pair[0] <= pair[1]), "opacity grows towards the middle: {column:?}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn one_slice_and_pictures_of_one_pixel_or_one_column_are_finite() {
    with_gpu(|gpu| {
        for name in EFFECTS {
            let mut scene = preset(name).unwrap_or_else(|error| panic!("{error}"));
            scene.object.input = "torus".into();
            for (size, samples) in [([1, 1], 16), ([1, 37], 16), ([37, 1], 16), ([16, 16], 1)] {
                (scene.image.size, scene.quality.samples) = (size, samples);
                let frame = finite(gpu, &scene);
                assert_eq!(frame.pixels.len() as u32, size[0] * size[1], "{name}");
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn the_eye_may_be_inside_the_object() {
    with_gpu(|gpu| {
        for name in EFFECTS {
            for (projection, proxy) in [
                (Projection::Perspective, Proxy::Polygons),
                (Projection::Perspective, Proxy::Quads),
                (Projection::Parallel, Proxy::Polygons),
            ] {
                let mut scene = preset(name).unwrap_or_else(|error| panic!("{error}"));
                scene.object.input = "sphere".into();
                scene.camera.zoom = 100.0;
                (scene.camera.projection, scene.quality.proxy) = (projection, proxy);
                scene.image.size = [16, 16];
                scene.quality.samples = 64;
                let frame = finite(gpu, &scene);
                assert!(frame.pixels.iter().all(|pixel| pixel[3] > 0.99), "{name}: full of matter on all sides");
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p36_every_parameter_may_stand_at_either_end() {
    with_gpu(|gpu| {
        let library = shader::shipped();
        let mut tried = 0;
        for name in EFFECTS {
            let mut scene = preset(name).unwrap_or_else(|error| panic!("{error}"));
            scene.object.input = "torus".into();
            scene.image.size = [16, 16];
            scene.quality.samples = 16;
            let parameters = scene.check(&library).unwrap_or_else(|error| panic!("{error}"));
            for (parameter, _) in parameters.iter() {
                let ParameterKind::Number(_, ends) = parameter.kind else { continue };
                for end in ends {
                    let mut scene = scene.clone();
                    scene.parameters.insert(parameter.name.clone(), ParameterValue::Number(end));
                    let result = render(gpu, &library, &scene, &formula(&scene));
                    assert!(
                        result.is_ok(),
                        "{name}, {} = {end}: {}",
                        parameter.name,
                        result.err().map_or_else(String::new, |e| e.to_string())
                    );
                    tried += 1;
                }
            }
        }
        println!("{tried} pictures");
        assert!(tried > 20);
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn far_times_lights_and_views_are_finite() {
    type Change = (&'static str, fn(&mut Scene));
    let changes: [Change; 7] = [
        ("a time of 30 years", |s| s.camera.time = 1e9),
        ("a light in the middle", |s| s.light.position = [0.0; 3]),
        ("a light far away", |s| s.light.position = [1e6, -1e6, 1e6]),
        ("a blinding light", |s| (s.light.intensity, s.material.specular_power) = (1000.0, 1000.0)),
        ("from straight above", |s| (s.camera.elevation, s.camera.azimuth) = (90.0, 1e6)),
        ("a wide view", |s| s.camera.field_of_view = 120.0),
        ("everything clipped", |s| s.camera.clip = Some([1e-3, 0.0, 0.0, -1e6])),
    ];
    with_gpu(|gpu| {
        for name in EFFECTS {
            for (what, change) in changes {
                let mut scene = preset(name).unwrap_or_else(|error| panic!("{error}"));
                scene.object.input = "cube".into();
                scene.image.size = [16, 16];
                scene.quality.samples = 32;
                change(&mut scene);
                let result = render(gpu, &shader::shipped(), &scene, &formula(&scene));
                assert!(result.is_ok(), "{name}, {what}: {}", result.err().map_or_else(String::new, |e| e.to_string()));
            }
        }
    });
}

/// Scenes at random: any example, other modules in its stacks, each parameter anywhere in its range or at an end of it.
fn random(library: &shader::Library, random: &mut impl FnMut() -> f64) -> Scene {
    fn pick<'a>(all: &[&'a str], at: f64) -> &'a str {
        all[((at * all.len() as f64) as usize).min(all.len() - 1)]
    }
    let examples: Vec<&str> = scene::names().collect();
    let mut scene = preset(pick(&examples, random())).unwrap_or_else(|error| panic!("{error}"));
    if scene.parts.is_empty() {
        scene.object.input = pick(&["sphere", "cube", "torus"], random()).into();
    }
    for (slot, stack) in [("dmf", &mut scene.effect.dmf), ("warp", &mut scene.effect.warp)] {
        let module = pick(&library.modules(slot), random());
        if random() < 0.4 && !stack.iter().any(|other| other == module) {
            stack.push(module.into());
        }
    }
    (scene.image.size, scene.quality.samples) = ([64, 64], 64);
    scene.effect.opacity_rate = 10f32.powf((8.0 * random() - 3.0) as f32);
    (scene.camera.azimuth, scene.camera.elevation) = (360.0 * random() as f32, 160.0 * random() as f32 - 80.0);
    (scene.camera.zoom, scene.camera.time) = (10f32.powf((2.0 * random() - 0.7) as f32), 1e6 * random().powi(4));
    if let Ok(parameters) = scene.check(library) {
        let values: Vec<(String, f32)> = parameters
            .iter()
            .filter_map(|(parameter, _)| match parameter.kind {
                ParameterKind::Number(_, [low, high]) => {
                    let place = (2.0 * random() - 0.5).clamp(0.0, 1.0) as f32; // a quarter at each end
                    Some((parameter.name.clone(), low + place * (high - low)))
                }
                ParameterKind::Color(_) => None,
            })
            .collect();
        scene.parameters.extend(values.into_iter().map(|(name, value)| (name, ParameterValue::Number(value))));
    }
    scene
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn random_scenes_are_finite_or_refused() {
    let count = std::env::var("HYPERTEXTURE_SCENES").ok().and_then(|count| count.parse().ok());
    let count = count.unwrap_or(if is_whole() { 24 } else { 8 });
    with_gpu(|gpu| {
        let library = shader::shipped();
        let mut state = 0x2005_1989u64;
        let mut draw = || {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (state >> 11) as f64 / (1u64 << 53) as f64
        };
        let (mut drawn, mut refused, mut wrong) = (0u64, 0, Vec::new());
        for number in 0..count {
            let scene = random(&library, &mut draw);
            if let Err(error) = scene.check(&library) {
                assert!(!error.to_string().contains('\n'), "{error}");
                refused += 1;
                continue;
            }
            let done =
                Subject::load(&scene, &library, &|_| ()).and_then(|subject| render(gpu, &library, &scene, &subject));
            match done {
                Ok(_) => drawn += 1,
                Err(error @ RenderError::NotFinite { .. }) => {
                    wrong.push(format!("{number}: {error}\n{}", scene::to_text(&scene)))
                }
                Err(_) => refused += 1,
            }
        }
        println!("{drawn} pictures of 64 x 64 pixels and 64 samples, {refused} refused");
        assert!(wrong.is_empty(), "{} of {count}: {}", wrong.len(), wrong.join("\n"));
        assert!(2 * drawn > count, "{drawn} of {count} were drawn");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn an_eye_far_away_sees_what_parallel_rays_do() {
    // Numbers of `camera.matrices`: an eye at a distance, and the same height of the view at the object.
    let seen = |distance: Option<f32>, aside: f32| {
        let mut scene = soft("linear", -0.2, 0.2);
        scene.image.size = [48, 48];
        let (kind, depth) = distance.map_or((Projection::Parallel, 4.0), |far| (Projection::Perspective, far));
        let unit = distance.map_or(0.5, |far| far / 2.0);
        let mut numbers = [0.0; 32];
        for (at, value) in [(0, 1.0), (5, 1.0), (10, 1.0), (12, aside), (14, -depth), (15, 1.0), (16, unit), (21, unit)]
        {
            numbers[at] = value;
        }
        match distance {
            None => (numbers[26], numbers[31]) = (-0.1, 1.0),
            Some(_) => (numbers[27], numbers[30]) = (-1.0, 0.1),
        }
        (scene.camera.projection, scene.camera.matrices) = (kind, Some(numbers));
        scene
    };
    with_gpu(|gpu| {
        for aside in [0.0, 0.4] {
            let parallel = finite(gpu, &seen(None, aside));
            assert!(parallel.pixels.iter().filter(|pixel| pixel[3] > 0.1).count() > 300);
            for exponent in 3..=30 {
                let distance = 10f32.powi(exponent);
                let (max, _) = difference(&parallel, &finite(gpu, &seen(Some(distance), aside)));
                assert!(max < f64::max(3e-3, 3.0 / f64::from(distance)), "{aside} aside of 1e{exponent}: {max}");
            }
        }
    });
    // Far away, and beside the axis of view.
    let refused = seen(Some(1e6), 1e5).check(&shader::shipped()).expect_err("no rays").to_string();
    assert!(refused.contains("camera.matrices") && refused.contains("f32 holds no rays"), "{refused}");
}

#[test]
fn a_view_matrix_of_any_scale_is_one() {
    for scale in [1e-15f32, 1e-12, 1.0, 1e10] {
        let mut scene = Scene::default();
        let mut numbers = [0.0; 32];
        for at in [0, 5, 10] {
            numbers[at] = scale;
        }
        (numbers[14], numbers[15]) = (-4.0 * scale, 1.0);
        for (at, value) in [(16, 2.0), (21, 2.0), (27, -1.0), (30, 0.1)] {
            numbers[at] = value;
        }
        scene.camera.matrices = Some(numbers);
        assert!(scene.check(&shader::shipped()).is_ok(), "{scale:e}");
    }
}
