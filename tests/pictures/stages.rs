//! Fragment shaders and compute shaders trace the same rays.

use crate::common::{formula, picture, subject, with_gpu};
use crate::random_scene::{SplitMix, random_scene};
use hypertexture::gpu::{Area, Gpu};
use hypertexture::render::variant::Variant;
use hypertexture::render::{Frame, Renderer, describe_frame};
use hypertexture::scene::{LightMethod, Pass, RayPath, Scene, ShaderStage, TargetFormat, names, preset};
use hypertexture::shader::{self, Library};

/// A scene's pictures by the fragment and the compute stage.
fn by_stages(gpu: &Gpu, library: &Library, scene: &Scene) -> [Frame; 2] {
    let subject = subject(scene, library);
    [ShaderStage::Fragment, ShaderStage::Compute].map(|stage| {
        let mut scene = scene.clone();
        scene.quality.stage = stage;
        picture(gpu, library, &scene, &subject)
    })
}

fn agree(gpu: &Gpu, scene: &Scene, name: &str) {
    let [fragment, compute] = by_stages(gpu, &shader::shipped(), scene);
    let traces = scene.quality.pass == Pass::March;
    assert_eq!([fragment.measurements.is_compute, compute.measurements.is_compute], [false, traces], "{name}");
    assert!(fragment.pixels.iter().any(|pixel| pixel[3] > 0.0), "{name} is empty");
    // The driver computes no neighbors beyond the diagonal at which it cuts the triangle of the picture (Mesa 25).
    let is_cut = |index: usize| {
        let ([width, height], index) = (scene.image.size, index as u32);
        let [x, y] = [(index % width) & !1, (index / width) & !1];
        x * height <= (y + 2) * width && y * width <= (x + 2) * height
    };
    let bends = scene.effect.ray_path == RayPath::Refracted;
    for (index, pixels) in fragment.pixels.iter().zip(&compute.pixels).enumerate() {
        assert!(pixels.0 == pixels.1 || (bends && is_cut(index)), "{name}: pixel {index}: {pixels:?}");
    }
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
        let count = std::env::var("HYPERTEXTURE_SCENES").map_or(24, |count| count.parse().expect("a number"));
        for number in 0..count {
            let scene = random_scene(&mut random);
            if formula(&scene).scale > 0.0 {
                let [fragment, compute] = by_stages(gpu, &shader::shipped(), &scene);
                assert!(compute.measurements.is_compute && fragment.pixels == compute.pixels, "scene {number}");
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn depths_and_faults_of_modules_are_the_same_in_both_stages() {
    with_gpu(|gpu| {
        let shipped = shader::shipped();
        for name in ["lit", "fire", "melting"] {
            let mut scene = preset(name).expect("a shipped preset");
            scene.object.input = "torus".into();
            (scene.quality.samples, scene.image.size) = (96, [61, 47]);
            let [fragment, compute] = [ShaderStage::Fragment, ShaderStage::Compute].map(|stage| {
                scene.quality.stage = stage;
                Renderer::new(gpu, &shipped, &formula(&scene)).render_depth(&scene).expect("a depth")
            });
            assert!(fragment == compute && fragment.iter().any(|depth| depth.is_finite()), "{name}");
        }
        let text = "vec3 surface(Sample s) { return vec3(sqrt(-1.0 - s.x.x * s.x.x)); }\n";
        let custom = shipped.with_module("surface", "odd", text);
        let mut scene = preset("lit").expect("a shipped preset");
        (scene.object.input, scene.effect.surface, scene.image.size) = ("sphere".into(), "odd".into(), [24, 24]);
        let [fragment, compute] = [ShaderStage::Fragment, ShaderStage::Compute].map(|stage| {
            scene.quality.stage = stage;
            let rendered = Renderer::new(gpu, &custom, &subject(&scene, &custom)).render(&scene);
            rendered.map(drop).expect_err("no number").to_string()
        });
        assert!(fragment == compute && fragment.contains("surface/odd.glsl"), "{fragment}\n{compute}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn tiles_without_matter_are_left_out_and_hold_none() {
    with_gpu(|gpu| {
        let library = shader::shipped();
        // By the box around the matter, and by cells.
        for (name, most) in [("lit", 0.9), ("melting", 0.9)] {
            for stage in [ShaderStage::Fragment, ShaderStage::Compute] {
                let mut scene = preset(name).expect("a shipped preset");
                (scene.object.input, scene.quality.stage) = ("torus".into(), stage);
                (scene.quality.samples, scene.image.size) = (256, [250, 170]);
                let mut renderer = Renderer::new(gpu, &library, &formula(&scene));
                let frame = renderer.render(&scene).expect("a picture");
                let seen = frame.pixels.iter().map(|pixel| pixel[3] >= 0.5);
                let depths = renderer.render_depth(&scene).expect("a depth"); // of all pixels
                assert!(seen.eq(depths.iter().map(|depth| depth.is_finite())), "{name} {stage:?}");
                let m = &frame.measurements;
                let part = m.fragments.map(|count| count as f64 / frame.pixels.len() as f64);
                println!("{name} {stage:?} {part:?} of the pixels, {:?}", m.cells);
                assert!(m.is_compute || part.is_none_or(|part| part < most), "{name}: {part:?}");
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
        let text = "vec3 surface(Sample s) { return fract(dFdx(s.x)); }\n";
        let custom = custom.with_module("surface", "derived", text);
        let cases = [
            ("slices", "slices are blended"),
            ("msaa", "quality.msaa"),
            ("target", "float32"),
            ("custom", "surface/columns.glsl:1: error: 'gl_FragCoord'"),
            ("derived", "surface/derived.glsl:1: error: 'dFdx'"),
        ];
        for (name, why) in cases {
            let library = if ["custom", "derived"].contains(&name) { &custom } else { &shipped };
            let mut scene = preset("lit").expect("a shipped preset");
            scene.object.input = "sphere".into();
            (scene.quality.samples, scene.image.size, scene.quality.stage) = (64, [24, 24], ShaderStage::Compute);
            match name {
                "slices" => scene.quality.pass = Pass::Slices,
                "msaa" => scene.quality.msaa = 4,
                "target" => scene.quality.target = TargetFormat::Float16,
                "derived" => scene.effect.surface = "derived".into(),
                _ => scene.effect.surface = "columns".into(),
            }
            let (variant, subject) = (Variant::of(&scene, library).expect("a valid scene"), subject(&scene, library));
            let frame = picture(gpu, library, &scene, &subject);
            let lines = describe_frame(&frame.measurements, &variant, &subject, library);
            assert!(!frame.measurements.is_compute, "{name}");
            assert!(lines.iter().any(|[about, text]| about == "note" && text.contains(why)), "{name}: {lines:?}");
            // In a loop that rays leave one by one, GLSL leaves the derivatives of a module undefined: SwiftShader has others
            // in each draw.
            let is_defined = name != "derived" || gpu.info().name.contains("llvmpipe");
            scene.quality.stage = ShaderStage::Fragment;
            let again = picture(gpu, library, &scene, &subject).pixels;
            assert!(!is_defined || frame.pixels == again, "{name}");
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
