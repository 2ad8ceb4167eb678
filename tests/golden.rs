//! Golden pictures: every effect and every debug view, against the picture that was approved.
//!
//! On the driver and the processor that made the goldens (`made_on.txt` beside them), no channel of any pixel may differ
//! by more than 1/255. On any other, a person may not see a difference: the mean of FLIP is held, and what a driver may
//! decide otherwise in a scene is stated in [`FREER`]. A golden that is missing, too large or without a scene fails.
//! `BLESS=<scene>` or `BLESS=all` writes goldens; look at them before committing them.

use hypertexture::gpu::Gpu;
use hypertexture::output::{self, Depth, Provenance};
use hypertexture::render::{Measurements, Subject, render};
use hypertexture::scene::{self, Color, Pass, Scene};
use hypertexture::shader;
use image::{Rgb, RgbImage};
use std::fs;
use std::path::{Path, PathBuf};

/// Goldens of rays; the others are of slices, which draw every sample.
const RAYS: [&str; 3] = ["woven", "flow", "blue_glass_sphere"];

/// Names and scene files of the goldens; every other preset is a golden too.
const SCENES: &[(&str, &str)] = &[
    ("lit_torus", "preset = 'lit'\n object.input = 'torus'"),
    ("solid_torus", "preset = 'solid'\n object.input = 'torus'"),
    ("bump_torus", "preset = 'bump'\n object.input = 'torus'"),
    ("fur_torus", "preset = 'fur'\n object.input = 'torus'"),
    ("melting_torus", "preset = 'melting'\n object.input = 'torus'"),
    ("fire_torus", "preset = 'fire'\n object.input = 'torus'"),
    ("lit_teapot", "preset = 'lit'\n object = { input = 'teapot', resolution = 64 }"),
    ("solid_teapot", "preset = 'solid'\n object = { input = 'teapot', resolution = 64 }"),
    ("bump_teapot", "preset = 'bump'\n object = { input = 'teapot', resolution = 64 }"),
    ("fur_teapot", "preset = 'fur'\n object = { input = 'teapot', resolution = 64 }"),
    ("melting_teapot", "preset = 'melting'\n object = { input = 'teapot', resolution = 64 }"),
    ("fire_teapot", "preset = 'fire'\n object = { input = 'teapot', resolution = 64 }"),
    ("lit_head", "preset = 'lit'\n object = { input = 'head', resolution = 96 }"),
    ("shells_torus", "preset = 'shells'\n object.input = 'torus'\n camera.clip = [0, 0, 1, 0]"),
    ("furry_teapot", "preset = 'furry_teapot'\n object.resolution = 64"),
    ("burning_head", "preset = 'burning_head'\n object.resolution = 64"),
    ("glow", "preset = 'glow'\n object.resolution = 64"),
    ("eroded_cube", "preset = 'eroded_cube'\n light.shadow_resolution = 64"),
    (
        "tank",
        "preset = 'tank'\n object.resolution = 64\n light.shadow_resolution = 64\n \
         parts = { turret.object.resolution = 48, gun.object.resolution = 64, tracks.object.resolution = 96, wheels.object.resolution = 64 }",
    ),
    ("ensemble", "preset = 'ensemble'\n parts.flame.object.resolution = 64\n light.shadow_resolution = 64"),
    ("wax", "preset = 'wax'\n object.resolution = 96"),
    ("blue_glass_sphere", "preset = 'blue_glass'\n object.input = 'sphere'"),
    (
        "lit_shadows_teapot",
        "preset = 'lit'\n object = { input = 'teapot', resolution = 64 }\n \
         light = { shadows = true, position = [5, 1.5, 2] }\n camera = { azimuth = 50, elevation = 15, zoom = 1.3 }",
    ),
    (
        "fur_shadows_teapot",
        "preset = 'fur'\n object = { input = 'teapot', resolution = 64 }\n light = { shadows = true, shadow_resolution = 128, position = [3, 4, 1] }",
    ),
    ("normals", "object.input = 'torus'\n effect.surface = 'normals'"),
    ("tex_coord", "object.input = 'torus'\n effect.surface = 'tex_coord'"),
    (
        "noise",
        "object.input = 'cube'\n effect.surface = 'noise'\n camera = { projection = 'parallel', azimuth = 0, elevation = 0, zoom = 2.1 }",
    ),
    (
        "noise_gradient",
        "object.input = 'cube'\n effect.surface = 'noise_gradient'\n \
         camera = { projection = 'parallel', azimuth = 0, elevation = 0, zoom = 2.1 }",
    ),
    (
        "soft_region",
        "object.input = 'torus'\n \
         effect = { classify = 'soft', softness = 'linear', medium = 'soft_region', opacity_rate = 4.0 }",
    ),
    (
        "slice_stack",
        "object.input = 'torus'\n effect.classify = 'stack'\n camera.slice_stack = true\n quality.samples = 24",
    ),
];

/// All scenes, by name and text.
fn scenes() -> Vec<(String, String)> {
    let is_in_table = |preset: &str| SCENES.iter().any(|(_, text)| text.contains(&format!("preset = '{preset}'")));
    let presets = scene::names().filter(|name| !is_in_table(name));
    let presets = presets.map(|name| (name.to_string(), format!("preset = '{name}'")));
    SCENES.iter().map(|(name, text)| (name.to_string(), text.to_string())).chain(presets).collect()
}

/// Largest golden, bytes: a repository full of pictures is slow to fetch.
const MAX_BYTES: u64 = 64 << 10;
/// How much brighter the panel of differences is than the differences.
const AMPLIFIED: u8 = 32;

/// Largest mean of FLIP between a picture and its golden on a device that did not make it. Nothing of a picture is seen to
/// differ below 0.01; what rounds another way at outlines and in hair has 0.00003, on Mesa 25 and with wider vectors.
const FLIP: f64 = 0.001;
/// Scenes that need more, the device on which they do, and why.
const FREER: &[(&str, &str, f64)] = &[
    // Rays at the edge of total reflection go one way or the other.
    ("blue_glass_sphere", "", 0.02),
    // Edges of slices, seen from aside, fall on other pixels where a rasterizer has fewer bits below a pixel.
    ("slice_stack", "SwiftShader", 0.005),
];

/// How much a picture may differ from its golden.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Tolerance {
    /// Every channel of every pixel by at most 1/255.
    Exact,
    /// The mean of FLIP by at most this.
    Seen(f64),
}

impl Tolerance {
    /// That of a scene on a device that did not make its golden.
    fn elsewhere(name: &str, device: &str) -> Tolerance {
        let freer = FREER.iter().find(|(scene, on, _)| *scene == name && device.contains(on));
        Tolerance::Seen(freer.map_or(FLIP, |(.., most)| *most))
    }
}

/// Environment that decides the last digits of a picture: device and driver with their versions, the width of vectors, and what the
/// processor can do.
fn key(gpu: &Gpu) -> String {
    let info = gpu.info();
    #[cfg(target_arch = "x86_64")]
    let features = [
        ("avx2", is_x86_feature_detected!("avx2")),
        ("fma", is_x86_feature_detected!("fma")),
        ("avx512f", is_x86_feature_detected!("avx512f")),
    ];
    #[cfg(not(target_arch = "x86_64"))]
    let features: [(&str, bool); 0] = [];
    let features: Vec<&str> = features.iter().filter(|(_, has)| *has).map(|(name, _)| *name).collect();
    format!("{}, {}, {} {}\n", info.name, info.driver, std::env::consts::ARCH, features.join(" "))
}

/// Where it is written which device made the goldens.
fn record() -> PathBuf {
    goldens().join("made_on.txt")
}

/// Why a picture is not its golden; `None` if it is.
fn difference(expected: &RgbImage, actual: &RgbImage, tolerance: Tolerance) -> Option<String> {
    if expected.dimensions() != actual.dimensions() {
        return Some(format!("is {:?} pixels, expected {:?}", actual.dimensions(), expected.dimensions()));
    }
    let steps: Vec<u8> = expected.as_raw().iter().zip(actual.as_raw()).map(|(a, b)| a.abs_diff(*b)).collect();
    match tolerance {
        Tolerance::Exact => {
            let beyond = steps.chunks_exact(3).filter(|pixel| pixel.iter().any(|&step| step > 1)).count();
            let largest = steps.iter().max().copied().unwrap_or_default();
            (beyond > 0).then(|| format!("{beyond} pixels differ by more than 1/255, the largest by {largest}/255"))
        }
        Tolerance::Seen(most) => {
            let mean = flip(expected, actual);
            (mean > most).then(|| format!("differs by a mean FLIP of {mean:.4}, at most {most} is allowed"))
        }
    }
}

/// The mean of FLIP: how much a person sees of the differences, 0 to 1.
fn flip(expected: &RgbImage, actual: &RgbImage) -> f64 {
    let image = |image: &RgbImage| nv_flip::FlipImageRgb8::with_data(image.width(), image.height(), image.as_raw());
    let map = nv_flip::flip(image(expected), image(actual), nv_flip::DEFAULT_PIXELS_PER_DEGREE).to_vec();
    map.iter().map(|error| f64::from(*error)).sum::<f64>() / map.len() as f64
}

/// Expected, difference and actual, side by side.
fn panels(expected: &RgbImage, actual: &RgbImage) -> RgbImage {
    let (width, height) = actual.dimensions();
    RgbImage::from_fn(3 * width, height, |x, y| {
        let at = |image: &RgbImage| image.get_pixel_checked(x % width, y).copied().unwrap_or(Rgb([255, 0, 255]));
        let (a, b) = (at(expected), at(actual));
        match x / width {
            0 => a,
            1 => Rgb([0, 1, 2].map(|c| a[c].abs_diff(b[c]).saturating_mul(AMPLIFIED))),
            _ => b,
        }
    })
}

fn goldens() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/golden")
}

/// A scene of the table, at the size of a golden and over a dark background.
fn scene_of(name: &str, text: &str) -> Scene {
    let mut scene = scene::parse(text, name).unwrap();
    if !RAYS.contains(&name) {
        scene.quality.pass = Pass::Slices;
    }
    scene.image.size = [128, 128];
    scene.image.background = Some(Color([24, 26, 31]));
    scene.quality.samples = scene.quality.samples.min(128);
    scene
}

/// Renders a scene as a person gets it: through the writer of pictures.
fn picture(gpu: &Gpu, scene: &Scene) -> RgbImage {
    let library = shader::shipped();
    let subject = Subject::load(scene, &library, &|_| {}).unwrap();
    let frame = render(gpu, &library, scene, &subject).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("actual.png");
    let provenance = Provenance::of(scene, "", &Measurements::default()).unwrap();
    output::write(&frame, scene.image.background, Depth::Eight, &provenance, &path).unwrap();
    image::open(&path).unwrap().to_rgb8()
}

/// Compares a picture with its golden, or makes it the golden; says what is wrong.
fn judge(name: &str, actual: &RgbImage, tolerance: Tolerance, bless: bool) -> Result<(), String> {
    let file = goldens().join(format!("{name}.png"));
    if bless {
        fs::create_dir_all(goldens()).unwrap();
        actual.save(&file).unwrap();
    }
    let advice = format!("approve it with: BLESS={name} cargo test --release --test library golden::");
    let bytes = fs::metadata(&file).map_err(|error| format!("{}: {error}; {advice}", file.display()))?.len();
    if bytes > MAX_BYTES {
        return Err(format!("{}: {bytes} bytes, at most {MAX_BYTES} are allowed", file.display()));
    }
    let expected = image::open(&file).map_err(|error| format!("{}: {error}; {advice}", file.display()))?.to_rgb8();
    println!("{name}: mean FLIP {:.5}", flip(&expected, actual));
    let Some(what) = difference(&expected, actual, tolerance) else { return Ok(()) };
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("target/golden");
    fs::create_dir_all(&folder).unwrap();
    let shown = folder.join(format!("{name}.png"));
    panels(&expected, actual).save(&shown).unwrap();
    Err(format!("{name} {what}; expected | difference x {AMPLIFIED} | actual: {}; {advice}", shown.display()))
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn every_scene_looks_like_its_golden() {
    let bless = std::env::var("BLESS").unwrap_or_default();
    let scenes = scenes();
    let known = |name: &str| name.is_empty() || name == "all" || scenes.iter().any(|(scene, _)| scene == name);
    assert!(known(&bless), "BLESS={bless}: no such scene");
    let mut failures: Vec<String> = Vec::new();
    crate::common::with_gpu(|gpu| {
        let lavapipe = gpu.info().name.contains("llvmpipe");
        assert!(lavapipe || bless.is_empty(), "goldens are made on lavapipe (VK_DRIVER_FILES chooses it)");
        if bless == "all" {
            fs::create_dir_all(goldens()).unwrap();
            fs::write(record(), key(gpu)).unwrap();
        }
        let made_on = fs::read_to_string(record()).unwrap();
        let same = key(gpu) == made_on;
        assert!(same || bless.is_empty(), "the goldens are of {made_on}here is {}bless all of them", key(gpu));
        println!("{}: {}", if same { "exact" } else { "as a person sees it" }, key(gpu).trim_end());
        let outcome = |(name, text): &(String, String)| {
            let bless = bless == "all" || &bless == name;
            let tolerance = if same { Tolerance::Exact } else { Tolerance::elsewhere(name, &gpu.info().name) };
            judge(name, &picture(gpu, &scene_of(name, text)), tolerance, bless).err()
        };
        failures.extend(scenes.iter().filter_map(outcome));
    });
    assert!(failures.is_empty(), "{} of {} scenes\n{}", failures.len(), scenes.len(), failures.join("\n"));
}

#[test]
fn every_golden_belongs_to_a_scene() {
    for entry in fs::read_dir(goldens()).into_iter().flatten() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        let known = scenes().iter().any(|(scene, _)| name == format!("{scene}.png")) || name == "made_on.txt";
        assert!(known, "tests/golden/{name} belongs to no scene of the table");
    }
}

/// A shaded ball on a dark ground, with a fine pattern: it has edges, gradients and unequal channels.
fn ball() -> RgbImage {
    RgbImage::from_fn(128, 128, |x, y| {
        let (u, v) = ((f64::from(x) - 63.5) / 50.0, (f64::from(y) - 63.5) / 50.0);
        let depth = 1.0 - u * u - v * v;
        if depth < 0.0 {
            return Rgb([24, 26, 31]);
        }
        let light = (0.3 + 0.6 * depth.sqrt() - 0.2 * u - 0.3 * v).clamp(0.0, 1.0);
        let grain = 1.0 + 0.1 * (40.0 * u).sin() * (40.0 * v).sin();
        Rgb([200.0, 150.0, 90.0].map(|c| (c * light * grain).clamp(0.0, 255.0) as u8))
    })
}

/// `image` with every pixel taken from where `from` says, counted around the edges.
fn moved(image: &RgbImage, from: impl Fn(u32, u32) -> (u32, u32)) -> RgbImage {
    RgbImage::from_fn(128, 128, |x, y| {
        let (x, y) = from(x, y);
        *image.get_pixel(x % 128, y % 128)
    })
}

#[test]
fn a_changed_picture_is_not_its_golden() {
    let golden = ball();
    let channels = |order: [usize; 3]| {
        let mut mutant = golden.clone();
        mutant.pixels_mut().for_each(|pixel| *pixel = Rgb(order.map(|c| pixel[c])));
        mutant
    };
    let codes = |change: fn(u8) -> u8| {
        let mut mutant = golden.clone();
        mutant.iter_mut().for_each(|code| *code = change(*code));
        mutant
    };
    let one_pixel = |step: u8| {
        let mut mutant = golden.clone();
        mutant.get_pixel_mut(70, 40)[1] += step;
        mutant
    };
    let mutants = [
        ("red and blue swapped", channels([2, 1, 0]), true),
        ("red and green swapped", channels([1, 0, 2]), true),
        ("shifted to the left", moved(&golden, |x, y| (x + 1, y)), true),
        ("shifted up", moved(&golden, |x, y| (x, y + 1)), true),
        ("mirrored", moved(&golden, |x, y| (127 - x, y)), true),
        ("upside down", moved(&golden, |x, y| (x, 127 - y)), true),
        ("black", codes(|_| 0), true),
        ("sRGB encoded twice", codes(|code| (255.0 * scene::linear_to_srgb(f32::from(code) / 255.0)) as u8), true),
        ("all brighter by 2/255", codes(|code| code.saturating_add(2)), false),
        ("one pixel off by 2/255", one_pixel(2), false),
    ];
    let freest = FREER.iter().map(|(.., most)| *most).fold(FLIP, f64::max);
    for (what, mutant, grave) in &mutants {
        assert!(difference(&golden, mutant, Tolerance::Exact).is_some(), "{what} passes where the golden was made");
        let seen = difference(&golden, mutant, Tolerance::Seen(freest)).is_some();
        assert!(!grave || seen, "{what} passes elsewhere: mean FLIP {}", flip(&golden, mutant));
    }
    for (what, same) in [("itself", golden.clone()), ("one pixel off by 1/255", one_pixel(1))] {
        assert_eq!(difference(&golden, &same, Tolerance::Exact), None, "{what}");
        assert_eq!(difference(&golden, &same, Tolerance::Seen(FLIP)), None, "{what}");
    }
    let narrower = RgbImage::new(64, 128);
    assert!(difference(&golden, &narrower, Tolerance::Exact).is_some_and(|what| what.contains("64")));
}

#[test]
fn a_failure_shows_expected_difference_and_actual() {
    let (expected, mut actual) = (ball(), ball());
    actual.get_pixel_mut(70, 40)[1] += 2;
    let panels = panels(&expected, &actual);
    assert_eq!(panels.dimensions(), (3 * 128, 128));
    assert_eq!(panels.get_pixel(70, 40), expected.get_pixel(70, 40));
    assert_eq!(panels.get_pixel(128 + 70, 40), &Rgb([0, 2 * AMPLIFIED, 0]));
    assert_eq!(panels.get_pixel(256 + 70, 40), actual.get_pixel(70, 40));
}
