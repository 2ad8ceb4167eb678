//! Grooms: a scene without one has none of it, and what is painted is what is drawn, by each way to a picture.

use crate::common::{picture, with_gpu};
use hypertexture::render::variant::Variant;
use hypertexture::render::{Renderer, Subject};
use hypertexture::scene::{EmptySpace, Scene, preset};
use hypertexture::shader::{self, Linker};
use hypertexture::shape::Groom;
use hypertexture_measure::reference::reference_pixels;
use std::path::Path;
use std::sync::Arc;

/// Effects that read a groom.
const EFFECTS: [&str; 8] = ["fur", "tribble", "melting", "fire", "shells", "woven", "solid", "bump"];

/// An effect on a torus, painted by a function of the place, in a file.
fn groomed(effect: &str, file: &Path, paint: impl Fn(glam::Vec3) -> [f32; 9]) -> Scene {
    let mut scene = preset(effect).unwrap();
    (scene.object.input, scene.image.size) = ("torus".into(), [48, 40]);
    scene.quality.samples = scene.quality.samples.min(160);
    let mut groom = Groom::unpainted("torus", 32);
    (0..groom.voxels()).for_each(|index| groom.set(index, paint(groom.place(index))));
    let mut bytes = Vec::new();
    groom.write(&mut bytes).unwrap();
    std::fs::write(file, bytes).unwrap();
    scene.groom = Some(file.display().to_string());
    scene
}

/// Shorter to the right, white at the top, combed around, thinner to the front.
fn painted(x: glam::Vec3) -> [f32; 9] {
    let along = glam::Vec3::new(-x.z, 0.0, x.x).normalize_or_zero();
    [0.6 - 0.4 * x.x, 0.9 - 0.3 * x.z, 1.0 + x.y, 1.0 + x.y, 1.0, 0.7 * along.x, 0.0, 0.7 * along.z, 1.0]
}

#[test]
fn a_scene_without_a_groom_links_no_line_and_no_image_of_it() {
    let library = shader::shipped();
    for effect in EFFECTS {
        let scene = preset(effect).unwrap();
        let program =
            |scene: &Scene, library| Variant::of(scene, library).unwrap().program(library, Linker::new).unwrap();
        // With other text where a groom is read, the program is the same word for word.
        let other = shader::shipped().with_module("groom", "volume", "#define groomed(code) refused\n");
        let (own, without) = (program(&scene, &library), program(&scene, &other));
        assert_eq!((own.vertex, &own.fragment), (without.vertex, &without.fragment), "{effect}");
        let reads = |scene: &Scene| program(scene, &library).resources.iter().any(|own| own.name.starts_with("groom_"));
        assert!(!reads(&scene) && reads(&Scene { groom: Some("a.nrrd".into()), ..scene.clone() }), "{effect}");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn nothing_painted_changes_nothing_and_what_is_painted_does() {
    let (library, folder) = (shader::shipped(), tempfile::tempdir().unwrap());
    with_gpu(|gpu| {
        for effect in EFFECTS {
            let draw = |scene: &Scene| {
                let subject = Subject::load(scene, &library, &|_| ()).unwrap();
                picture(gpu, &library, scene, &subject).pixels
            };
            let scene = groomed(effect, &folder.path().join("a.nrrd"), |_| Groom::NEUTRAL);
            let bare = draw(&Scene { groom: None, ..scene.clone() });
            let apart = |other: Vec<[f32; 4]>| {
                let sum: f32 = bare.as_flattened().iter().zip(other.as_flattened()).map(|(a, b)| (a - b).powi(2)).sum();
                (sum / bare.as_flattened().len() as f32).sqrt()
            };
            let unpainted = apart(draw(&scene));
            assert!(unpainted < 1e-3, "{effect}: {unpainted}");
            let changed = apart(draw(&groomed(effect, &folder.path().join("b.nrrd"), painted)));
            assert!(changed > 5e-3, "{effect}: {changed}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_groom_is_known_to_cells_and_to_the_reference() {
    let (library, folder) = (shader::shipped(), tempfile::tempdir().unwrap());
    with_gpu(|gpu| {
        let mut scene = groomed("fur", &folder.path().join("a.nrrd"), painted);
        (scene.object.input, scene.light.shadows) = ("sphere".into(), false);
        (scene.image.size, scene.quality.samples) = ([160, 120], 512);
        (scene.quality.block_size, scene.quality.turbulence_cells) = (32, 16); // fewer texels than samples
        let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
        let frame = picture(gpu, &library, &scene, &subject);
        assert!(
            frame.measurements.cells.as_ref().is_some_and(|cells| cells.empty > 0.05),
            "{:?}",
            frame.measurements.cells
        );
        let mut every = scene.clone();
        every.quality.empty_space = EmptySpace::Sample;
        assert!(picture(gpu, &library, &every, &subject).pixels == frame.pixels, "a skipped sample held matter");
        let pixels: Vec<[u32; 2]> = (0..24).map(|index| [20 + 5 * index, 30 + 2 * index]).collect();
        let exact = reference_pixels(&library, &scene, &subject, &pixels, 1e-3, &|_| (), &|| false).unwrap();
        let mut worst = 0.0f64;
        for (pixel, exact) in pixels.iter().zip(&exact.pixels) {
            let drawn = frame.pixels[(pixel[1] * 160 + pixel[0]) as usize];
            worst = (0..4).map(|c| (f64::from(drawn[c]) - exact[c]).abs()).fold(worst, f64::max);
        }
        assert!(worst < 0.05, "{worst}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_renderer_draws_what_is_painted_meanwhile_as_a_new_one_does() {
    let (library, folder) = (shader::shipped(), tempfile::tempdir().unwrap());
    with_gpu(|gpu| {
        let scene = groomed("fur", &folder.path().join("a.nrrd"), |_| Groom::NEUTRAL);
        let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
        let mut renderer = Renderer::new(gpu, &library, &subject);
        renderer.render(&scene).unwrap();
        let later = groomed("fur", &folder.path().join("b.nrrd"), painted);
        let groom = Some(Arc::new(Groom::read(&folder.path().join("b.nrrd")).unwrap()));
        let fresh = Subject { groom: groom.clone(), ..subject.clone() };
        let expected = picture(gpu, &library, &later, &fresh).pixels;
        for stroke in [true, false] {
            renderer.paint(&groom, stroke).unwrap();
            assert!(renderer.render(&later).unwrap().pixels == expected, "stroke: {stroke}");
        }
    });
}
