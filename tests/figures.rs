//! The figures are what the papers say of them.
#![expect(clippy::unwrap_used, reason = "a test fails where a preset is not as described")]

mod common;

use common::{picture, subject, with_gpu};
use hypertexture::glsl;
use hypertexture::scene::{KnobValue, Scene, names, preset};

fn number(scene: &Scene, knob: &str) -> f32 {
    match scene.knobs[knob] {
        KnobValue::Number(value) => value,
        KnobValue::Color(_) => f32::NAN,
    }
}

fn small(name: &str) -> Scene {
    let mut scene = preset(name).unwrap();
    scene.object.resolution = 32;
    scene.image.size = [48, 48];
    scene.quality.samples = 64;
    scene.light.shadow_resolution = 16;
    scene
}

#[test]
fn p25_the_other_spheres_are_the_noisy_sphere_with_other_knobs() {
    let [noisy, fine, rough] =
        ["noisy_sphere", "high_frequency_sphere", "high_amplitude_sphere"].map(|name| preset(name).unwrap());
    assert_eq!(number(&fine, "frequency"), 2.0 * number(&noisy, "frequency"));
    assert_eq!(number(&fine, "amplitude"), 0.5 * number(&noisy, "amplitude"));
    assert_eq!(number(&rough, "frequency"), number(&noisy, "frequency"));
    assert!(number(&rough, "amplitude") > number(&noisy, "amplitude"));
    assert!([fine, rough].iter().all(|scene| scene.effect.warp == noisy.effect.warp));
}

#[test]
fn p30_low_densities_of_the_fire_ball_are_red_and_high_ones_yellow() {
    let scene = preset("fire_ball").unwrap();
    assert_eq!(scene.effect.warp, ["turbulent"]);
    let colors: Vec<[f32; 3]> = scene.transfer.stops.iter().map(|stop| stop.color.linear()).collect();
    let (low, high) = (colors[1], colors[colors.len() - 1]);
    assert!(low[0] > 10.0 * low[1], "{low:?} is not red");
    assert!(high[1] > 0.7 * high[0] && high[2] < 0.5 * high[0], "{high:?} is not yellow");
}

#[test]
fn p33_the_hair_of_the_donut_is_as_long_as_its_soft_region_is_wide() {
    let scene = preset("furry_donut").unwrap();
    assert_eq!(scene.object.input, "torus");
    let knobs = scene.check(&glsl::shipped()).unwrap();
    assert_eq!(knobs.outer_iso(), Some(number(&scene, "hair_length")));
}

#[test]
fn p29_the_eroded_cube_is_a_fractal_sphere_and_a_cube_colored_by_turbulence() {
    let scene = preset("eroded_cube").unwrap();
    assert_eq!(
        (scene.combine.as_deref(), scene.effect.warp.as_slice()),
        (Some("main & cube"), &["fractal".into()][..])
    );
    assert_eq!((scene.object.input.as_str(), scene.parts["cube"].object.input.as_str()), ("sphere", "cube"));
    assert_eq!((scene.effect.surface.as_str(), scene.parts["cube"].effect.surface.as_str()), ("solid", "solid"));
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p01_no_figure_has_an_opacity_outside_of_0_to_1_and_each_has_something_to_see() {
    let library = glsl::shipped();
    with_gpu(|gpu| {
        for name in names() {
            let scene = small(name);
            let frame = picture(gpu, &library, &scene, &subject(&scene, &library));
            let alphas = || frame.pixels.iter().map(|pixel| pixel[3]);
            assert!(alphas().all(|alpha| (0.0..=1.000_01).contains(&alpha)), "{name}");
            assert!(alphas().filter(|alpha| *alpha > 0.3).count() > 100, "{name} is hardly there");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn g03_what_moves_changes_with_time_and_what_is_still_does_not() {
    let library = glsl::shipped();
    with_gpu(|gpu| {
        for (name, moves) in [
            ("fire", true),
            ("fire_ball", true),
            ("smoke", true),
            ("flow", true),
            ("noisy_sphere", false),
            ("fur", false),
        ] {
            let mut scene = small(name);
            let subject = subject(&scene, &library);
            let [first, later] = [0.0, 0.7].map(|time| {
                scene.camera.time = time;
                picture(gpu, &library, &scene, &subject).pixels
            });
            assert_eq!(first != later, moves, "{name}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p03_sphere_cube_and_torus_have_soft_versions() {
    let library = glsl::shipped();
    with_gpu(|gpu| {
        for object in ["sphere", "cube", "torus"] {
            let covered = |softness: &str| {
                let mut scene = common::homogeneous(object, 200.0, hypertexture::scene::Projection::Parallel);
                scene.effect.softness = softness.into();
                (scene.object.inner_iso, scene.object.outer_iso) = (0.0, 0.2);
                let frame = picture(gpu, &library, &scene, &subject(&scene, &library));
                frame.pixels.iter().filter(|pixel| pixel[3] > 0.5).count()
            };
            assert!(covered("linear") > covered("hard") && covered("quadratic") > covered("hard"), "{object}");
        }
    });
}
