//! Fragment shaders and compute shaders trace the same rays.

use crate::common::{formula, picture, subject, with_gpu};
use crate::random_scene::{SplitMix, random_scene};
use hypertexture::gpu::{Area, Gpu};
use hypertexture::render::variant::Variant;
use hypertexture::render::{Frame, Renderer, describe_frame};
use hypertexture::scene::{LightMethod, Pass, RayPath, Scene, ShaderStage, TargetFormat, names, preset};
use hypertexture::shader::{self, Library};

/// A scene's picture by a stage.
fn by(gpu: &Gpu, library: &Library, scene: &Scene, stage: ShaderStage) -> Frame {
    let mut scene = scene.clone();
    scene.quality.stage = stage;
    picture(gpu, library, &scene, &subject(&scene, library))
}

fn agree(gpu: &Gpu, scene: &Scene, name: &str) {
    let library = shader::shipped();
    let [fragment, compute] =
        [ShaderStage::Fragment, ShaderStage::Compute].map(|stage| by(gpu, &library, scene, stage));
    let traces = scene.quality.pass == Pass::March && scene.effect.ray_path == RayPath::Straight;
    assert_eq!([fragment.measurements.is_compute, compute.measurements.is_compute], [false, traces], "{name}");
    assert!(fragment.pixels.iter().any(|pixel| pixel[3] > 0.0), "{name} is empty");
    assert!(fragment.pixels == compute.pixels, "{name}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn every_preset_has_the_same_bits_in_both_stages() {
    with_gpu(|gpu| {
        for name in names() {
            let mut scene = preset(name).expect("a shipped preset");
            (scene.object.resolution, scene.light.shadow_resolution) = (48, 32);
            if scene.is_half_angle() {
                (scene.light.method, scene.light.translucency) = (LightMethod::Volume, 0.0);
            }
            (scene.quality.pass, scene.quality.samples, scene.image.size) = (Pass::March, 96, [61, 47]);
            agree(gpu, &scene, name);
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn random_scenes_have_the_same_bits_in_both_stages() {
    with_gpu(|gpu| {
        let mut random = SplitMix(54);
        for number in 0..24 {
            let scene = random_scene(&mut random);
            if formula(&scene).scale > 0.0 {
                let library = shader::shipped();
                let [fragment, compute] =
                    [ShaderStage::Fragment, ShaderStage::Compute].map(|stage| by(gpu, &library, &scene, stage));
                assert!(compute.measurements.is_compute && fragment.pixels == compute.pixels, "scene {number}");
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn areas_of_compute_shaders_are_parts_of_the_whole() {
    with_gpu(|gpu| {
        let library = shader::shipped();
        let mut scene = preset("fire_ball").expect("a shipped preset");
        (scene.quality.samples, scene.image.size, scene.quality.stage) = (64, [50, 40], ShaderStage::Compute);
        let mut renderer = Renderer::new(gpu, &library, &formula(&scene));
        let whole = renderer.render(&scene).expect("a picture").pixels;
        let area = Area { columns: 6..33, rows: 12..31 };
        let part = renderer.render_areas(&scene, std::slice::from_ref(&area), None).expect("an area").pixels;
        let rows = area.rows.flat_map(|y| area.columns.clone().map(move |x| (50 * y + x) as usize));
        assert!(rows.map(|index| whole[index]).eq(part));
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn scenes_that_compute_shaders_cannot_draw_say_so_and_are_drawn() {
    with_gpu(|gpu| {
        let shipped = shader::shipped();
        let text = "vec3 surface(Sample s) { return vec3(fract(gl_FragCoord.x)); }\n";
        let custom = shipped.clone().with_module("surface", "columns", text);
        let cases = [
            ("slices", "slices are blended"),
            ("msaa", "quality.msaa"),
            ("target", "float32"),
            ("bent", "bent rays"),
            ("custom", "gl_FragCoord"),
        ];
        for (name, why) in cases {
            let library = if name == "custom" { &custom } else { &shipped };
            let mut scene = preset(if name == "bent" { "blue_glass" } else { "lit" }).expect("a shipped preset");
            scene.object.input = "sphere".into();
            (scene.quality.samples, scene.image.size, scene.quality.stage) = (64, [24, 24], ShaderStage::Compute);
            match name {
                "slices" => scene.quality.pass = Pass::Slices,
                "msaa" => scene.quality.msaa = 4,
                "target" => scene.quality.target = TargetFormat::Float16,
                "bent" => scene.effect.ray_path = RayPath::Refracted,
                _ => scene.effect.surface = "columns".into(),
            }
            let (variant, subject) = (Variant::of(&scene, library).expect("a valid scene"), subject(&scene, library));
            let frame = picture(gpu, library, &scene, &subject);
            let lines = describe_frame(&frame.measurements, &variant, &subject, library);
            assert!(!frame.measurements.is_compute, "{name}");
            assert!(lines.iter().any(|[about, text]| about == "note" && text.contains(why)), "{name}: {lines:?}");
            assert!(frame.pixels == by(gpu, library, &scene, ShaderStage::Fragment).pixels, "{name}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_trial_of_ways_to_draw_changes_no_bit() {
    with_gpu(|gpu| {
        let library = shader::shipped();
        let mut scene = preset("noisy_sphere").expect("a shipped preset");
        (scene.quality.samples, scene.image.size) = (512, [256, 160]); // enough samples for a trial
        let mut renderer = Renderer::new(gpu, &library, &formula(&scene));
        let first = renderer.render(&scene).expect("a picture");
        let next = renderer.render(&scene).expect("a picture");
        assert!(next.measurements.compile_ms < first.measurements.compile_ms);
        scene.quality.stage = ShaderStage::Fragment;
        let fragment = renderer.render(&scene).expect("a picture");
        assert!(first.pixels == fragment.pixels && next.pixels == fragment.pixels);
        assert_eq!(first.measurements.modules, fragment.measurements.modules);
    });
}
