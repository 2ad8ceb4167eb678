//! Anisotropic filtering: of what has a footprint, volumes and blocks of noise, and of no table.

use crate::common::{picture, subject, with_gpu};
use hypertexture::gpu::Gpu;
use hypertexture::render::Frame;
use hypertexture::scene::{EFFECTS, Scene, names, preset};
use hypertexture::shader;

/// A scene, tiny, with those anisotropies that the device has.
fn pictures(gpu: &Gpu, scene: &Scene, anisotropies: &[f32]) -> Vec<Frame> {
    let library = shader::shipped();
    let mut scene = scene.clone();
    scene.object.resolution = 16;
    scene.parts.values_mut().for_each(|part| part.object.resolution = 16);
    (scene.light.shadow_resolution, scene.quality.samples) = (16, 12);
    let subject = subject(&scene, &library);
    let allowed = anisotropies.iter().filter(|&&anisotropy| anisotropy <= gpu.info().max_anisotropy);
    allowed
        .map(|&anisotropy| {
            scene.quality.anisotropy = anisotropy;
            picture(gpu, &library, &scene, &subject)
        })
        .collect()
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m57_every_effect_is_drawn_with_any_anisotropy() {
    with_gpu(|gpu| {
        for name in names() {
            let mut scene = preset(name).unwrap_or_else(|error| panic!("{error}"));
            (scene.image.size, scene.object.resolution, scene.light.shadow_resolution) = ([16, 16], 48, 32);
            let all = pictures(gpu, &scene, if EFFECTS.contains(&name) { &[1.0, 2.0, 16.0] } else { &[1.0, 16.0] });
            let matter = |frame: &Frame| frame.pixels.iter().map(|pixel| f64::from(pixel[3])).sum::<f64>();
            for other in &all[1..] {
                // A wider footprint blurs what is drawn, and takes nothing away.
                let (one, other) = (matter(&all[0]), matter(other));
                println!("{name}: {:.3} of the opacity", other / one);
                assert!(one > 1.0 && (other - one).abs() < 0.2 * one, "{name}: opacity {one} and {other}");
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m57_tables_have_no_anisotropy() {
    with_gpu(|gpu| {
        let mut fire = preset("fire").expect("a preset");
        fire.effect.turbulence = "tables".into();
        let mut octaves = fire.clone();
        (octaves.effect.turbulence, octaves.effect.noise) = ("octaves".into(), "tables".into());
        let mut segments = Scene::default();
        (segments.effect.classify, segments.effect.softness) = ("preintegrated".into(), "linear".into());
        // Effects that read tables of one dimension (the transfer map, Perlin's) or two (segments), but no volume or block.
        for mut scene in [fire, octaves, segments] {
            (scene.object.input, scene.image.size) = ("sphere".into(), [12, 12]);
            let all = pictures(gpu, &scene, &[1.0, 16.0]);
            assert!(all.iter().all(|frame| frame.pixels == all[0].pixels), "{:?}", scene.effect);
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m57_located_surfaces_keep_filter_footprints_in_a_step() {
    // Where a lane that is off held a coordinate far away, lavapipe of Mesa 22.3 filtered the whole volume for each sample:
    // more than the minute that a picture may take, in place of a hundredth of a second.
    with_gpu(|gpu| {
        let mut scene = preset("lit").expect("a preset");
        (scene.image.size, scene.quality.samples) = ([100, 100], 32);
        let (library, subject) = (shader::shipped(), subject(&scene, &shader::shipped()));
        for anisotropy in [1.0, 2.0, 8.0] {
            scene.quality.anisotropy = anisotropy;
            let frame = picture(gpu, &library, &scene, &subject);
            assert!(frame.pixels[50 * 100 + 50][3] > 0.9, "anisotropy {anisotropy}: {:?}", frame.pixels[50 * 100 + 50]);
        }
    });
}
