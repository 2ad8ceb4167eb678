//! The order in which the transfer map is applied: before, after, or along with the interpolation.

use crate::common::{difference, homogeneous, picture, subject, with_gpu};
use hypertexture::render::Renderer;
use hypertexture::scene::{Color, Curve, FieldEncoding, ParameterValue, Projection, Scene, Stop};
use hypertexture::shader;

/// A soft sphere in a coarse volume, under a transfer map that goes up and down twelve times across the soft region.
fn high_frequency(classify: &str, samples: u32) -> Scene {
    let mut scene = homogeneous("sphere", 12.0, Projection::Perspective);
    scene.object.field_encoding = FieldEncoding::Normals16;
    scene.object.resolution = 32;
    scene.object.outer_iso = 0.4;
    scene.effect.classify = classify.into();
    scene.effect.softness = "linear".into();
    scene.transfer.curve = Curve::Linear;
    scene.transfer.stops = (0..=24)
        .map(|i| {
            let color = if i % 4 == 1 { [255, 60, 20] } else { [20, 90, 255] };
            Stop { at: i as f32 / 24.0, color: Color(color), density: if i % 2 == 1 { 0.6 } else { 0.0 }, index: 1.0 }
        })
        .collect();
    scene.quality.samples = samples;
    scene
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m04_m05_preintegration_beats_post_beats_pre() {
    with_gpu(|gpu| {
        let library = shader::shipped();
        let subject = subject(&high_frequency("post", 1), &library);
        let frame = |classify: &str, samples| picture(gpu, &library, &high_frequency(classify, samples), &subject);
        let reference = frame("post", 2048);
        println!("samples       pre      post  preintegrated (rms against post with 2048)");
        // Slices at most half a voxel apart: with fewer, post-classification skips whole peaks of the map.
        let mut floors = Vec::new();
        for samples in [128, 256] {
            let [pre, post, preintegrated] =
                ["pre", "post", "preintegrated"].map(|classify| difference(&frame(classify, samples), &reference).1);
            println!("{samples:7}  {pre:.2e}  {post:.2e}  {preintegrated:.2e}");
            assert!(pre > 2.0 * post && post > 2.0 * preintegrated, "{samples} samples");
            floors.push(pre);
        }
        // Colors that the voxels never saw cannot be sampled back: more slices do not help.
        assert!(floors[1] > 0.9 * floors[0], "{floors:?}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m05_the_three_agree_where_the_transfer_map_is_smooth() {
    with_gpu(|gpu| {
        let library = shader::shipped();
        let smooth = |classify: &str, resolution| {
            let mut scene = high_frequency(classify, 256);
            let stop = |at, density| Stop { at, color: Color([255; 3]), density, index: 1.0 };
            scene.transfer.stops = vec![stop(0.0, 0.0), stop(1.0, 0.5)];
            scene.object.resolution = resolution;
            scene
        };
        println!("voxels      pre  preintegrated (rms against post)");
        let mut pres = Vec::new();
        for resolution in [32, 64] {
            let subject = subject(&smooth("post", resolution), &library);
            let frame = |classify| picture(gpu, &library, &smooth(classify, resolution), &subject);
            let post = frame("post");
            let (pre, preintegrated) =
                (difference(&frame("pre"), &post).1, difference(&frame("preintegrated"), &post).1);
            println!("{resolution:6}  {pre:.1e}  {preintegrated:.1e}");
            assert!(preintegrated < 1e-3, "{preintegrated:e}");
            pres.push(pre);
        }
        // The two interpolations differ at the kinks of the soft region, by the square of a voxel.
        assert!(pres[0] < 3e-2 && pres[0] / pres[1] > 2.8, "{pres:?}");
    });
}

/// Tables hold the values of the modules, custom ones included.
#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m05_tables_hold_what_modules_of_opacity_and_softness_say() {
    let thin = "// @param thinness = 1 in [0, 10]: Factor of the optical depth.\n\
                float opacity(float density, float amount) { return 1.0 - exp(-thinness * amount * density); }\n\
                float segment_opacity(float d0, float d1, float amount) { return opacity(0.5 * (d0 + d1), amount); }\n";
    let ramp = shader::shipped().source("softness/linear.glsl").expect("a module that ships").to_string();
    let library = shader::shipped().with_module("opacity", "thin", thin).with_module("softness", "ramp", &ramp);
    with_gpu(|gpu| {
        let mut scene = high_frequency("preintegrated", 64);
        let subject = subject(&scene, &library);
        let mut renderer = Renderer::new(gpu, &library, &subject);
        let mut draw = |scene: &Scene| renderer.render(scene).expect("a picture");
        let own = |scene: &Scene, thinness: f32| {
            let mut own = scene.clone();
            own.effect.opacity = "thin".into();
            own.parameters.insert("thinness".into(), ParameterValue::Number(thinness));
            own
        };
        scene.effect.opacity = "beer".into();
        let rate = scene.effect.opacity_rate;
        for factor in [1.0, 0.25] {
            scene.effect.opacity_rate = factor * rate;
            let shipped = draw(&scene);
            let mut own = own(&scene, factor);
            own.effect.opacity_rate = rate;
            let off = difference(&shipped, &draw(&own)).0;
            println!("opacity, {factor} of the rate: {off:.1e}");
            assert!(off < 1e-5, "{factor}: {off:e}");
        }
        let mut scene = high_frequency("pre", 64);
        let linear = draw(&scene);
        scene.effect.softness = "ramp".into();
        assert_eq!(difference(&linear, &draw(&scene)).0, 0.0);
        scene.effect.softness = "quadratic".into();
        assert!(difference(&linear, &draw(&scene)).0 > 0.01, "another softness");
        // A table is made once: it does not follow what changes from moment to moment.
        let moving = "float soften(float distance, float outer) { return time; }\n\
                      float soften(float distance) { return time; }\n";
        let library = library.clone().with_module("softness", "moving", moving);
        scene.effect.softness = "moving".into();
        let refused = Renderer::new(gpu, &library, &subject).render(&scene).expect_err("it moves").to_string();
        assert!(refused.starts_with("tabulated modules of opacity and softness"), "{refused}");
    });
}
