//! Parts of pictures, pictures of other sizes and pictures that are stopped: what a window makes of one renderer, against
//! whole pictures of new ones. Nothing here depends on how fast the device is.

use crate::common::{picture, subject, with_gpu};
use hypertexture::gpu::Area;
use hypertexture::render::{RenderError, Renderer, Subject, paste_areas};
use hypertexture::scene::{Pass, Scene, preset};
use hypertexture::shader;
use std::sync::Arc;
use std::sync::atomic::{AtomicU32, Ordering};

fn scene(effect: &str, pass: Pass) -> (Scene, Subject) {
    let mut scene = preset(effect).unwrap();
    (scene.object.input, scene.image.size, scene.quality.samples, scene.quality.pass) =
        ("torus".into(), [75, 50], 48, pass);
    let subject = subject(&scene, &shader::shipped());
    (scene, subject)
}

fn area(columns: [u32; 2], rows: [u32; 2]) -> Area {
    Area { columns: columns[0]..columns[1], rows: rows[0]..rows[1] }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn areas_equal_the_whole_picture_bit_for_bit_in_any_order() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        for (effect, pass) in [("fur", Pass::March), ("fire", Pass::Slices)] {
            let (mut scene, subject) = scene(effect, pass);
            scene.light.shadows = true;
            let whole = picture(gpu, &library, &scene, &subject);
            let mut renderer = Renderer::new(gpu, &library, &subject);
            let mut pixels = vec![[f32::NAN; 4]; whole.pixels.len()];
            let (middle, top) = (area([30, 64], [10, 41]), area([0, 75], [0, 10]));
            let left = [area([0, 30], [10, 50]), area([64, 75], [10, 50]), area([30, 64], [41, 50])];
            for areas in [&[middle, top][..], &left[..]] {
                let frame = renderer.render_areas(&scene, areas, None).unwrap();
                paste_areas(&frame.pixels, areas, 75, &mut pixels);
            }
            assert!(pixels == whole.pixels, "{effect} {pass:?}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn the_pictures_of_a_mean_are_those_of_its_numbers() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        let (mut scene, subject) = scene("melting", Pass::March);
        scene.quality.supersampling = 3;
        let whole = picture(gpu, &library, &scene, &subject);
        let mut renderer = Renderer::new(gpu, &library, &subject);
        let all = [Area::whole(scene.image.size)];
        let parts = [0, 1, 2].map(|number| renderer.render_areas(&scene, &all, Some(number)).unwrap().pixels);
        for (index, pixel) in whole.pixels.as_flattened().iter().enumerate() {
            let sum: f64 = parts.iter().map(|part| f64::from(part.as_flattened()[index])).sum();
            assert!((sum / 3.0 - f64::from(*pixel)).abs() < 1e-6);
        }
        assert!(parts[0] != parts[1] && parts[1] != parts[2]);
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn b1_changes_of_size_samples_and_shadows_compile_nothing() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        for (effect, pass) in [("fur", Pass::March), ("melting", Pass::Slices)] {
            let (mut scene, subject) = scene(effect, pass);
            scene.light.shadows = true;
            let mut renderer = Renderer::new(gpu, &library, &subject);
            let first = renderer.render(&scene).unwrap();
            assert!(first.measurements.compile_ms > 0.0 && renderer.is_ready(&scene));
            for (size, samples, rays) in [([20, 14], 32, 16), ([75, 50], 48, 128), ([90, 33], 40, 32)] {
                (scene.image.size, scene.quality.samples, scene.light.shadow_resolution) = (size, samples, rays);
                let frame = renderer.render(&scene).unwrap();
                let fresh = picture(gpu, &library, &scene, &subject);
                assert!(frame.pixels == fresh.pixels && frame.size == size, "{effect} {pass:?} {size:?}");
                assert_eq!(frame.measurements.compile_ms, 0.0, "{effect} {pass:?} {size:?}");
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn what_is_prepared_is_ready_once_its_empty_space_can_be_found() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        let (mut scene, subject) = scene("melting", Pass::March);
        (scene.image.size, scene.quality.samples) = ([256, 256], 256);
        let mut renderer = Renderer::new(gpu, &library, &subject);
        let states = |renderer: &Renderer| [renderer.is_prepared(&scene), renderer.is_ready(&scene)];
        assert_eq!(states(&renderer), [false; 2]);
        renderer.prepare(&scene, &|_| ()).unwrap();
        assert_eq!(states(&renderer), [true, false]);
        let frame = renderer.render(&scene).unwrap();
        assert_eq!(states(&renderer), [true; 2], "{:?}", frame.measurements.cells);
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn what_a_renderer_keeps_is_there_when_its_scene_comes_back() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        let (own, subject) = scene("fire", Pass::March);
        let mut other = own.clone();
        other.quality.pass = Pass::Slices;
        let mut renderer = Renderer::new(gpu, &library, &subject);
        renderer.set_cache_size(2);
        let first = [&own, &other].map(|scene| renderer.render(scene).unwrap());
        assert!(first.iter().all(|frame| frame.measurements.compile_ms > 0.0));
        for (scene, first) in [(&own, &first[0]), (&other, &first[1]), (&own, &first[0])] {
            let again = renderer.render(scene).unwrap();
            assert_eq!(again.measurements.compile_ms, 0.0);
            assert!(again.pixels == first.pixels);
        }
        // A third takes the place of the one that was not used for longest.
        let mut third = own.clone();
        third.quality.block_size = 32;
        renderer.render(&third).unwrap();
        assert!(renderer.is_ready(&own) && renderer.is_ready(&third) && !renderer.is_ready(&other));
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn b1_a_cancelled_picture_leaves_the_next_one_whole() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        for (effect, pass, shadows) in
            [("fur", Pass::March, false), ("fire", Pass::March, true), ("fur", Pass::Slices, true)]
        {
            let (mut scene, subject) = scene(effect, pass);
            (scene.image.size, scene.light.shadows) = ([150, 120], shadows);
            let mut renderer = Renderer::new(gpu, &library, &subject);
            let looks = Arc::new(AtomicU32::new(0));
            let whole = picture(gpu, &library, &scene, &subject);
            let counted = looks.clone();
            renderer.stop_where(move |_| {
                counted.fetch_add(1, Ordering::Relaxed);
                false
            });
            renderer.render(&scene).unwrap();
            let all = looks.swap(0, Ordering::Relaxed);
            assert!(all >= 2, "{effect} {pass:?}: the input is looked at {all} times");
            for last in 1..=all.min(3) {
                let mut renderer = Renderer::new(gpu, &library, &subject);
                let counted = looks.clone();
                renderer.stop_where(move |_| counted.fetch_add(1, Ordering::Relaxed) + 1 >= last);
                let stopped = renderer.render(&scene);
                assert!(matches!(stopped, Err(RenderError::Stopped)), "{effect} {pass:?} {last}");
                assert_eq!(looks.swap(0, Ordering::Relaxed), last, "nothing is asked, or drawn, once it has ended");
                renderer.stop_where(|_| false);
                assert!(renderer.render(&scene).unwrap().pixels == whole.pixels, "{effect} {pass:?} {last}");
            }
        }
    });
}
