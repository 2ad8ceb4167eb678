//! The order in which the transfer map is applied: before, after, or along with the interpolation.

mod common;

use common::{difference, homogeneous, picture, subject, with_gpu};
use hypertexture::scene::{Color, Curve, Projection, Scene, Source, Stop};
use hypertexture::shader;

/// A soft sphere in a coarse volume, under a transfer map that goes up and down twelve times across the soft region.
fn high_frequency(classify: &str, samples: u32) -> Scene {
    let mut scene = homogeneous("sphere", 12.0, Projection::Perspective);
    scene.object.source = Source::Normals16;
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
fn m04_m05_preintegration_beats_post_classification_beats_pre_classification() {
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
