//! Values at the end of what a scene may say: every picture is finite, and where the answer is known it is that.

mod common;

use common::{difference, formula, homogeneous, picture, with_gpu};
use hypertexture::gpu::Gpu;
use hypertexture::render::{Frame, render};
use hypertexture::scene::{EFFECTS, ParameterValue, Pass, Projection, Proxy, Scene, preset};
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
