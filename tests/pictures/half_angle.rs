//! Half-angle slicing against closed forms and against the shadow volume (GG 39.5.1).

use crate::common::{Level, Ray, box_subject, difference, errors, formula, homogeneous, picture, subject, with_gpu};
use glam::{DVec3, Vec3};
use hypertexture::render::{Renderer, Subject, render};
use hypertexture::scene::{Color, LightMethod, Pass, Projection, Scene, parse, preset};
use hypertexture::shader::{self, Library};

/// The library with a look that shows the light that reaches a place, and a DMF of a blade above a thin veil.
fn library() -> Library {
    let seen = "// The light that reaches a place.\n// Source: -\n// Linear RGB.\n#include <shadow>\n\
                vec3 surface(Sample s) { return shadow(0.0, vec3(0.0)); }\n";
    let blade = "// An opaque blade at x < 0, and a veil below it, one slice thick each.\n// Source: -\n// density: in [0, 1].\n\
                 float blade(float density, Sample s) {\n    \
                 if (abs(s.x.z - 0.5) < 0.5 * step_size) return s.x.x < 0.0 ? 1.0 : 0.0;\n    \
                 return abs(s.x.z + 0.5) < 0.5 * step_size ? 0.9 : 0.0;\n}\n";
    shader::shipped().with_module("surface", "seen", seen).with_module("dmf", "blade", blade)
}

/// Homogeneous matter that shows the light in it.
fn lit(object: &str, rate: f64, light: DVec3) -> Scene {
    let mut scene = homogeneous(object, rate as f32, Projection::Perspective);
    scene.effect.surface = "seen".into();
    (scene.light.shadows, scene.light.method) = (true, LightMethod::HalfAngle);
    scene.quality.pass = Pass::Slices;
    (scene.light.position, scene.light.shadow_resolution) = (light.as_vec3().to_array(), 256);
    scene
}

/// Color of homogeneous matter along a ray; `left` is the light that remains, by depth.
fn seen(
    ray: &Ray,
    rate: f64,
    light: DVec3,
    span: impl Fn(&Ray) -> Option<[f64; 2]>,
    left: impl Fn(f64) -> f64,
) -> Option<f64> {
    const PARTS: u32 = 500;
    let [from, to] = span(ray)?;
    let part = (to - from) / f64::from(PARTS);
    let at = |index| {
        let t = (f64::from(index) + 0.5) * part;
        let x = ray.from + ray.along * (from + t);
        let way = Ray { from: x, along: (light - x).normalize() };
        let inside = span(&way).map_or(0.0, |[_, leaves]| leaves.min(x.distance(light)));
        rate * (-rate * t).exp() * left(rate * inside) * part
    };
    Some((0..PARTS).map(at).sum())
}

/// Where a ray is inside the unit sphere.
fn ball(ray: &Ray) -> Option<[f64; 2]> {
    let (b, c) = (ray.from.dot(ray.along), ray.from.length_squared() - 1.0);
    let root = (b * b - c).max(0.0).sqrt();
    (b * b > c && root > b).then(|| [(-b - root).max(0.0), root - b])
}

/// Where a ray is inside a slab that is wide.
fn slab(ray: &Ray) -> Option<[f64; 2]> {
    let ends = [-1.0, 1.0].map(|side| (side * SLAB.z - ray.from.z) / ray.along.z);
    Some([ends[0].min(ends[1]).max(0.0), ends[0].max(ends[1])])
}

const SLAB: DVec3 = DVec3::new(1.0, 1.0, 0.2);
const FRONT: [f64; 3] = [5.0, 1.0, 3.0];
const BEHIND: [f64; 3] = [4.0, -2.0, -3.0];

fn falls(levels: &[Level], order: f64, mean: f64) {
    let observed = levels[0].order(&levels[levels.len() - 1]);
    println!("order {observed:.2}");
    assert!(observed >= order, "of order {observed}");
    assert!(levels[levels.len() - 1].mean <= mean, "{:?}", levels[levels.len() - 1]);
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_renderer_follows_the_light_to_the_other_side() {
    let library = library();
    with_gpu(|gpu| {
        let mut scene = lit("sphere", 1.0, DVec3::new(0.4, 0.3, 5.0));
        scene.image.size = [32, 32];
        let subject = subject(&scene, &library);
        let mut renderer = Renderer::new(gpu, &library, &subject);
        for depth in [5.0, -5.0, 5.0] {
            scene.light.position[2] = depth;
            let again = renderer.render(&scene).unwrap_or_else(|error| panic!("{error}"));
            assert!(again.pixels == picture(gpu, &library, &scene, &subject).pixels, "light at z = {depth}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn g13_light_that_is_left_is_the_closed_form_of_a_ball() {
    let (library, rate) = (library(), 1.5);
    with_gpu(|gpu| {
        for light in [FRONT, BEHIND].map(DVec3::from) {
            let scene = lit("sphere", rate, light);
            let truth = |ray: &Ray| seen(ray, rate, light, ball, |depth| (-depth).exp());
            let levels = errors(gpu, &library, (&scene, &subject(&scene, &library)), &[16, 32, 64, 128], 0, truth);
            falls(&levels, 0.8, 7e-3);
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn g13_scattered_light_passes_a_slab_by_channel() {
    let (library, rate, light) = (library(), 2.0, DVec3::new(3.0, 0.4, 4.0));
    with_gpu(|gpu| {
        let mut scene = lit("cube", rate, light);
        (scene.light.translucency, scene.light.scatter) = (0.6, 0.0);
        scene.light.transport = Color([255, 188, 0]);
        let subject = box_subject(SLAB.as_vec3());
        let spared = scene.light.transport.linear().map(f64::from);
        for channel in [0, 1, 2] {
            let left = |depth: f64| 0.4 * (-depth).exp() + 0.6 * (-depth * (1.0 - spared[channel])).exp();
            // Not near the edges, where the light comes in from the side.
            let inner = |ray: &Ray| ray.at(0.0).truncate().abs().max_element() < 0.45;
            let truth = |ray: &Ray| inner(ray).then(|| seen(ray, rate, light, slab, left)).flatten();
            let levels = errors(gpu, &library, (&scene, &subject), &[32, 64, 128, 256], channel, truth);
            falls(&levels, 0.8, 5e-3);
        }
    });
}

/// The integral of the normal distribution from -infinity to `x` standard deviations.
fn normal(x: f64) -> f64 {
    let part = x / 2000.0;
    let density = |t: f64| (-0.5 * t * t).exp() / std::f64::consts::TAU.sqrt();
    0.5 + (0..2000).map(|i| density((f64::from(i) + 0.5) * part) * part).sum::<f64>()
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn g13_scattered_light_blurs_by_the_root_of_its_path() {
    let library = library();
    with_gpu(|gpu| {
        for (scatter, samples) in [(0.15, 64), (0.15, 256), (0.3, 128)] {
            let mut scene = homogeneous("cube", 4.0, Projection::Parallel);
            (scene.effect.surface, scene.effect.dmf) = ("seen".into(), vec!["blade".into()]);
            scene.effect.opacity = "perlin".into();
            (scene.light.shadows, scene.light.method) = (true, LightMethod::HalfAngle);
            scene.quality.pass = Pass::Slices;
            (scene.light.position, scene.light.shadow_resolution) = ([0.0, 0.0, 1e4], 128);
            (scene.light.translucency, scene.light.scatter, scene.light.transport) = (1.0, scatter, Color([255; 3]));
            scene.quality.samples = samples;
            let subject = Subject { radius: 1.0, ..box_subject(Vec3::ONE) };
            let frame = render(gpu, &library, &scene, &subject).expect("a picture");
            let rays = crate::common::rays(&scene, &subject);
            let pairs = frame.pixels.iter().zip(&rays).filter(|(_, ray)| {
                (0.05..0.9).contains(&ray.from.x) && ray.from.y.abs() < 0.1 // the blade hides what is left of it
            });
            let off = pairs.map(|(pixel, ray)| {
                assert!(pixel[3] > 0.01, "the veil is there");
                let expected = normal(ray.from.x / f64::from(scatter)); // the veil is 1 below the blade
                (f64::from(pixel[1] / pixel[3]) - expected).abs()
            });
            let off = off.fold(0.0, f64::max);
            println!("scatter {scatter}, {samples} slices: off by {off:.4}");
            assert!(off < 0.03, "scatter {scatter}, {samples} slices: {off}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn g13_slices_give_the_light_of_the_shadow_volume() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        for (effect, medium, input) in
            [("fur", "hair", "torus"), ("clouds", "translucent", "sphere"), ("lit", "material", "torus")]
        {
            for light in [[15.0, 4.5, 6.0], [9.0, 12.0, -9.0]] {
                let mut scene = preset(effect).expect("a shipped preset");
                (scene.effect.medium, scene.object.input) = (medium.into(), input.into());
                scene.drop_foreign_parameters(&library).expect("modules that exist");
                (scene.image.size, scene.quality.samples) = ([96, 96], 128);
                scene.quality.pass = Pass::Slices;
                (scene.light.position, scene.light.shadows, scene.light.shadow_resolution) = (light, true, 128);
                let subject = subject(&scene, &library);
                let volume = picture(gpu, &library, &scene, &subject);
                scene.light.method = LightMethod::HalfAngle;
                let slices = picture(gpu, &library, &scene, &subject);
                let rms = difference(&volume, &slices).1;
                let sum =
                    |frame: &hypertexture::render::Frame| frame.pixels.iter().map(|p| f64::from(p[1])).sum::<f64>();
                let brighter = sum(&slices) / sum(&volume);
                println!("{effect}, {light:?}: {rms:.4} root mean square, {brighter:.3} times as bright");
                assert!(rms < 0.05 && (0.93..1.07).contains(&brighter), "{effect}, {light:?}: {rms}, {brighter}");
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn g13_a_light_in_the_scene_is_refused() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        let mut scene = preset("wax").expect("a shipped preset");
        (scene.object.input, scene.image.size, scene.light.position) = ("sphere".into(), [16, 16], [0.5, 0.2, 0.1]);
        let error = render(gpu, &library, &scene, &formula(&scene)).expect_err("it is refused").to_string();
        let expected =
            "light.method = \"half_angle\": the light is inside of the scene or beside it; move light.position away";
        assert!(error.starts_with(expected), "{error}");
    });
}

#[test]
fn g13_what_cannot_be_had_is_refused() {
    let refusal = |text: &str| {
        let scene = parse(&format!("preset = 'wax'\n{text}"), "test").expect("a scene");
        scene.check(&shader::shipped()).expect_err("it is refused").to_string()
    };
    let rays = refusal("quality.pass = 'march'");
    assert_eq!(rays, "light.method = \"half_angle\": needs quality.pass = \"slices\"; rays take \"volume\"");
    assert!(refusal("quality.proxy = 'quads'").ends_with("needs quality.proxy = \"polygons\""));
    assert!(refusal("quality.order = 'back_to_front'").contains("the order of the slices is that of the light"));
    let volume = refusal("light.method = 'volume'");
    assert_eq!(volume, "light.translucency = 0.85: needs light.method = \"half_angle\"");
}
