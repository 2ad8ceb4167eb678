//! The figures as pictures; `tests/formulas/figures.rs` holds their densities and colors against the papers.

use crate::common::{picture, subject, with_gpu};
use hypertexture::scene::{Scene, names, preset};
use hypertexture::shader;

fn small(name: &str) -> Scene {
    let mut scene = preset(name).unwrap();
    scene.object.resolution = 32;
    scene.image.size = [48, 48];
    scene.quality.samples = 64;
    scene.light.shadow_resolution = 16;
    scene
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p01_figures_are_seen_have_opacities_and_fit_their_pictures() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        let mut cut = Vec::new();
        for name in names() {
            let mut scene = small(name);
            scene.object.resolution = 96; // a voxel of 32 is wider than the margin
            let frame = picture(gpu, &library, &scene, &subject(&scene, &library));
            let alphas = || frame.pixels.iter().map(|pixel| pixel[3]);
            assert!(alphas().all(|alpha| (0.0..=1.000_01).contains(&alpha)), "{name}");
            assert!(alphas().filter(|alpha| *alpha > 0.3).count() > 100, "{name} is hardly there");
            if scene.effect.environment != "none" {
                continue; // the surroundings fill the picture
            }
            let [width, height] = scene.image.size.map(|side| side as usize);
            let border =
                |i: usize| i.is_multiple_of(width) || i % width == width - 1 || i < width || i >= width * (height - 1);
            let at_border = frame.pixels.iter().enumerate().filter(|(i, _)| border(*i));
            let most = at_border.map(|(_, pixel)| pixel[3]).fold(0.0, f32::max);
            if most > 0.0 {
                cut.push(format!("{name}: {most}"));
            }
        }
        assert!(cut.is_empty(), "{cut:?}");
    });
}

/// Root mean square of the differences of two pictures.
fn apart(a: &[[f32; 4]], b: &[[f32; 4]]) -> f64 {
    let squares = a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| f64::from(a - b).powi(2));
    (squares.sum::<f64>() / a.len() as f64).sqrt()
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn g03_what_moves_neither_pops_nor_flickers() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        // Fur stands still: the eye turns around it, as with --turntable.
        for (name, object) in [("fur", "torus"), ("fire", "torus"), ("smoke", "torus"), ("flow", ""), ("fire_ball", "")]
        {
            let mut scene = small(name);
            if !object.is_empty() {
                scene.object.input = object.into();
            }
            scene.quality.samples = 192;
            let subject = subject(&scene, &library);
            let frames: Vec<_> = (0..10)
                .map(|frame| {
                    match name {
                        "fur" => scene.camera.azimuth = 30.0 + 0.25 * frame as f32,
                        _ => scene.camera.time = 0.9 + f64::from(frame) / 50.0,
                    }
                    picture(gpu, &library, &scene, &subject).pixels
                })
                .collect();
            let over = |n: usize| {
                let steps: Vec<f64> = frames.windows(n + 1).map(|w| apart(&w[0], &w[n])).collect();
                (steps.iter().sum::<f64>() / steps.len() as f64, steps.iter().copied().fold(0.0, f64::max))
            };
            let ((one, most), (three, _)) = (over(1), over(3));
            println!("{name}: a frame changes by {one:.4}, at most {most:.4}; three frames by {three:.4}");
            assert!(one > 1e-4, "{name} does not move");
            assert!(most < 1.6 * one, "{name} pops: {most} in one frame, {one} in the mean");
            // Steady motion is farther away after three frames; flicker is not.
            assert!(three > 1.6 * one, "{name} flickers: {three} in three frames, {one} in one");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p29_a_soft_shell_has_the_solid_texture_of_the_surface_below() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        let of = |medium: &str| {
            let mut scene = preset("eroded_cube").unwrap();
            (scene.combine, scene.object.outer_iso) = (None, 0.03);
            (scene.parts, scene.effect.warp) = (Default::default(), Vec::new());
            (scene.effect.medium, scene.light.shadows) = (medium.into(), false);
            (scene.image.size, scene.quality.samples) = ([48, 48], 256);
            for parameter in ["fractal_amplitude", "fractal_frequency"] {
                scene.parameters.remove(parameter);
            }
            let soft = picture(gpu, &library, &scene, &subject(&scene, &library)).pixels;
            (scene.effect.classify, scene.effect.softness) = ("surface".into(), "hard".into());
            (scene.object.inner_iso, scene.effect.medium) = (0.0, "material".into());
            let hard = picture(gpu, &library, &scene, &subject(&scene, &library)).pixels;
            let opaque = soft.iter().zip(&hard).filter(|(a, b)| a[3] > 0.99 && b[3] > 0.99);
            let (sum, count) = opaque.fold((0.0, 0), |(sum, count), (a, b)| (sum + apart(&[*a], &[*b]), count + 1));
            assert!(count > 300, "{count}");
            sum / f64::from(count)
        };
        let (solid, lit) = (of("solid"), of("lit"));
        println!("soft against hard: {solid:.4} with the solid texture, {lit:.4} in one color");
        assert!(solid < 0.03 && lit > 3.0 * solid, "{solid} {lit}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn g03_what_moves_changes_with_time_and_what_is_still_does_not() {
    let library = shader::shipped();
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
    let library = shader::shipped();
    with_gpu(|gpu| {
        for object in ["sphere", "cube", "torus"] {
            let covered = |softness: &str| {
                let mut scene = crate::common::homogeneous(object, 200.0, hypertexture::scene::Projection::Parallel);
                scene.effect.softness = softness.into();
                (scene.object.inner_iso, scene.object.outer_iso) = (0.0, 0.2);
                let frame = picture(gpu, &library, &scene, &subject(&scene, &library));
                frame.pixels.iter().filter(|pixel| pixel[3] > 0.5).count()
            };
            assert!(covered("linear") > covered("hard") && covered("quadratic") > covered("hard"), "{object}");
        }
    });
}
