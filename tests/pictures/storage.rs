//! Volumes in bricks: the picture of the whole volume, with less memory (GG 39.6).

use crate::common::{difference, picture, subject, with_gpu};
use hypertexture::gpu::Gpu;
use hypertexture::render::{Frame, Subject};
use hypertexture::scene::{EmptySpace, FieldEncoding, Integration, Pass, Scene, Storage, parse, preset};
use hypertexture::shader::{self, Library};

fn scene(effect: &str, input: &str) -> Scene {
    let mut scene = preset(effect).expect("a shipped preset");
    (scene.object.input, scene.object.resolution, scene.object.field_encoding) =
        (input.into(), 64, FieldEncoding::Normals16);
    (scene.image.size, scene.quality.samples) = ([96, 96], 128);
    (scene.light.shadow_resolution, scene.light.position) = (32, [5.0, 1.5, 2.0]);
    scene
}

/// The pictures of a scene out of the whole volume and out of bricks.
fn both(gpu: &Gpu, library: &Library, scene: &Scene, subject: &Subject) -> [Frame; 2] {
    [Storage::Dense, Storage::Sparse].map(|storage| {
        let mut scene = scene.clone();
        scene.object.storage = storage;
        picture(gpu, library, &scene, subject)
    })
}

/// Parts of the pixels that differ by more than rounding, and of the bytes that are stored.
fn compare([dense, sparse]: &[Frame; 2]) -> (f64, f64) {
    let off = |(a, b): (&[f32; 4], &[f32; 4])| a.iter().zip(b).any(|(a, b)| (a - b).abs() > 1e-3);
    let pixels = dense.pixels.iter().zip(&sparse.pixels);
    assert!(dense.pixels.iter().filter(|pixel| pixel[3] > 0.5).count() > 300, "there is an object");
    let (flipped, stored) = (pixels.filter(|pair| off(*pair)).count(), sparse.measurements.sparse.expect("bricks"));
    assert!(dense.measurements.sparse.is_none());
    let saved = dense.measurements.device_bytes as i64 - sparse.measurements.device_bytes as i64;
    let stated = stored.dense_bytes as i64 - stored.bytes as i64;
    // A device pads the rows of an image and their number, lavapipe to 64 bytes and to 4: up to a seventh of one whose
    // sides are 45 texels.
    let padding = (stored.dense_bytes + stored.bytes) as i64 / 7;
    assert!((saved - stated).abs() < padding, "{saved} bytes were saved, {stated} are stated");
    (flipped as f64 / dense.pixels.len() as f64, stored.bytes as f64 / stored.dense_bytes as f64)
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn g14_bricks_give_the_picture_of_the_whole_volume() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        for effect in ["lit", "fur", "melting", "fire", "clouds"] {
            let mut scene = scene(effect, "teapot");
            let subject = subject(&scene, &library);
            for (pass, integration) in [
                (Pass::Slices, Integration::Point),
                (Pass::March, Integration::Point),
                (Pass::March, Integration::Segment),
            ] {
                (scene.quality.pass, scene.quality.integration) = (pass, integration);
                let frames = both(gpu, &library, &scene, &subject);
                let (flipped, stored) = compare(&frames);
                let max = difference(&frames[0], &frames[1]).0;
                println!(
                    "{effect}, {pass:?}, {integration:?}: {flipped:.5} of the pixels differ, {max:.1e} at most; {stored:.2} of the bytes"
                );
                // A sample within a rounding of the surface falls on either side of it.
                assert!(flipped <= 1e-3, "{effect}, {pass:?}, {integration:?}: {flipped}");
            }
        }
    });
}

/// A ray that bends goes through the object: the bricks deep inside are there.
#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn g14_glass_is_seen_through_in_bricks() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        for input in ["sphere", "torus"] {
            let scene = scene("blue_glass", input);
            let subject = subject(&scene, &library);
            let (flipped, stored) = compare(&both(gpu, &library, &scene, &subject));
            println!("{input}: {flipped:.5} of the pixels differ, {stored:.2} of the bytes");
            assert!(flipped <= 1e-2, "{input}: {flipped}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn g14_every_encoding_is_read_out_of_bricks() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        for source in
            [FieldEncoding::Normals16, FieldEncoding::Normals8, FieldEncoding::Distance16, FieldEncoding::Distance32]
        {
            let mut scene = scene("lit", "torus");
            scene.object.field_encoding = source;
            let subject = subject(&scene, &library);
            let (flipped, stored) = compare(&both(gpu, &library, &scene, &subject));
            println!("{source:?}: {flipped:.5} of the pixels differ, {stored:.2} of the bytes");
            assert!(flipped <= 3e-3, "{source:?}: {flipped}");
        }
    });
}

/// A warp looks up as far away as it declares, and a DMF where the soft region ends: there must be no hole.
#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn g14_the_far_end_of_the_reach_is_stored() {
    let away = "// Looks up to the side.\n// Source: -\n// x: object space.\n// @move away\n\
                // @param away = 0.7 in [0, 2]: How far, object units.\n\
                void aside(inout vec3 x, inout mat3 jacobian) { x += away * vec3(0.6, 0.0, 0.8); }\n";
    let all = "// All of the soft region.\n// Source: -\n// density: in [0, 1].\n// @outer thick\n\
               // @param thick = 0.3 in [0, 1]: How thick it is, object units.\n\
               float thick_all(float density, Sample s) { return density > 0.0 ? 0.5 : 0.0; }\n";
    let library = shader::shipped().with_module("warp", "aside", away).with_module("dmf", "thick_all", all);
    with_gpu(|gpu| {
        for (empty_space, pass) in
            [(EmptySpace::Skip, Pass::March), (EmptySpace::Sample, Pass::March), (EmptySpace::Skip, Pass::Slices)]
        {
            let mut scene = scene("glow", "torus");
            (scene.effect.warp, scene.effect.dmf) = (vec!["aside".into()], vec!["thick_all".into()]);
            scene.parameters.clear();
            (scene.quality.empty_space, scene.quality.pass, scene.quality.early_termination) = (empty_space, pass, 0.0);
            let subject = Subject::load(&scene, &library, &|_| {}).expect("a torus");
            let frames = both(gpu, &library, &scene, &subject);
            let (flipped, stored) = compare(&frames);
            println!("{pass:?}, {empty_space:?}: {flipped:.5} of the pixels differ, {stored:.2} of the bytes");
            assert!(flipped <= 1e-3, "{pass:?}, {empty_space:?}: {flipped}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn g14_what_a_body_saves_depends_on_what_it_fills() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        let saved = |input: &str, resolution: u32| {
            let mut scene = scene("lit", input);
            scene.object.resolution = resolution;
            let subject = subject(&scene, &library);
            let (flipped, stored) = compare(&both(gpu, &library, &scene, &subject));
            println!("{input} at {resolution}: {flipped:.5} of the pixels differ, {stored:.3} of the bytes");
            assert!(flipped <= 1e-3);
            stored
        };
        let [coarse, fine] = [64, 128].map(|resolution| saved("teapot", resolution));
        assert!(fine < 0.55 && fine < coarse, "the finer, the less: {coarse} and {fine}");
        // A cube fills its box: bricks hold its faces alone, and of a coarse one nearly every texel, some of them twice.
        assert!(saved("cube", 32) > 0.9 && saved("cube", 128) < 0.75);
    });
}

#[test]
fn g14_bricks_are_refused_where_they_cannot_be_had() {
    let refusal = |text: &str| {
        let scene = parse(text, "test").expect("a scene");
        scene.check(&shader::shipped()).expect_err("it is refused").to_string()
    };
    let sparse = "object.storage = 'sparse'\n";
    let formula = refusal(&format!("preset = 'lit'\n{sparse}object.input = 'torus'"));
    assert!(formula.starts_with("object.storage = \"sparse\": needs a volume; object.field_encoding = "), "{formula}");
    let post = refusal(&format!("preset = 'shells'\n{sparse}object.input = 'teapot'"));
    assert!(
        post.starts_with("object.storage = \"sparse\": needs effect.classify = clear or soft or surface"),
        "{post}"
    );
    let several = refusal(&format!("preset = 'lit'\n{sparse}[parts.a]\nobject.input = 'sphere'"));
    assert!(several.contains("dense, in a scene of several objects"), "{several}");
}
