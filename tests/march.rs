//! The two passes give one picture: rays are sampled where the slices are.

use crate::common::{formula, homogeneous, picture, subject, with_gpu};
use hypertexture::render::{Frame, Renderer, Subject};
use hypertexture::scene::{EFFECTS, EmptySpace, Jitter, LightMethod, Pass, Projection, RayPath, Scene, names, preset};
use hypertexture::shader;

/// Part of the pixels that differ by more than `bound` in a channel, and the largest difference of the others.
fn compare(a: &Frame, b: &Frame, bound: f32) -> (f64, f32) {
    let off = |(a, b): (&[f32; 4], &[f32; 4])| a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    let differences: Vec<f32> = a.pixels.iter().zip(&b.pixels).map(off).collect();
    let beyond = differences.iter().filter(|&&d| d > bound).count();
    let rest = differences.iter().copied().filter(|&d| d <= bound).fold(0.0, f32::max);
    (beyond as f64 / differences.len() as f64, rest)
}

/// A preset on its own object, small.
fn small(name: &str) -> Scene {
    let mut scene = preset(name).expect("a shipped preset");
    scene.object.resolution = 48;
    scene.light.shadow_resolution = 32;
    if scene.is_half_angle() {
        // Light that goes with the slices is not for rays.
        (scene.light.method, scene.light.translucency) = (LightMethod::Volume, 0.0);
    }
    scene.image.size = [80, 80];
    scene.quality.samples = 96;
    scene
}

fn both(scene: &Scene) -> [Scene; 2] {
    [Pass::Slices, Pass::March].map(|pass| {
        let mut scene = scene.clone();
        scene.quality.pass = pass;
        scene.quality.early_termination = 0.0;
        scene
    })
}

/// Draws figures by slices, by rays, and by rays that skip empty cells; returns how many have empty cells.
fn figures_agree(of: impl Fn(usize) -> bool) -> usize {
    let library = shader::shipped();
    with_gpu(|gpu| {
        let mut cells = 0;
        for name in names().enumerate().filter(|(index, _)| of(*index)).map(|(_, name)| name) {
            let mut scene = small(name);
            if scene.effect.ray_path == RayPath::Straight {
                (scene.image.size, scene.quality.samples, scene.quality.block_size) = ([96, 96], 192, 32);
            }
            let subject = subject(&scene, &library);
            let [slices, mut rays] = both(&scene);
            let [all, skipped] = [EmptySpace::Sample, EmptySpace::Skip].map(|empty_space| {
                rays.quality.empty_space = empty_space;
                picture(gpu, &library, &rays, &subject)
            });
            cells += usize::from(skipped.measurements.cells.as_ref().is_some_and(|cells| cells.empty > 0.0));
            if scene.effect.ray_path == RayPath::Refracted {
                // Light does not bend from slice to slice. A bent ray adds its steps up, so that a skip rounds them
                // otherwise, and total reflection may amplify that.
                let (beyond, _) = compare(&all, &skipped, 1.0 / 255.0);
                assert!(beyond <= 1e-3, "{name}: {beyond}");
                continue;
            }
            assert!(all.pixels == skipped.pixels, "{name}");
            let (flipped, rest) = compare(&picture(gpu, &library, &slices, &subject), &all, 1e-3);
            println!("{name}: {flipped:.5} flipped, the rest within {rest:.1e}");
            assert!(flipped <= 0.004, "{name}: {flipped}");
        }
        cells
    })
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m61_slices_rays_and_skipping_agree_on_even_figures() {
    let cells = figures_agree(|index| index.is_multiple_of(2));
    println!("{cells} scenes have empty cells");
    assert!(cells >= 5, "{cells} scenes have empty cells");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m61_slices_rays_and_skipping_agree_on_odd_figures() {
    let cells = figures_agree(|index| !index.is_multiple_of(2));
    println!("{cells} scenes have empty cells");
    assert!(cells >= 5, "{cells} scenes have empty cells");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_band_of_rays_that_bend_is_that_of_the_whole_picture() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        let mut scene = small("blue_glass");
        scene.quality.supersampling = 1;
        let subject = subject(&scene, &library);
        let mut renderer = Renderer::new(gpu, &library, &subject);
        let whole = renderer.render(&scene).expect("a picture").pixels;
        for rows in [29..30, 41..52, 30..43] {
            let band = renderer.render_bands(&scene, std::slice::from_ref(&rows)).expect("a band").pixels;
            let span = rows.start as usize * 80..rows.end as usize * 80;
            assert!(band[span.clone()] == whole[span], "{rows:?}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m61_rays_and_slices_give_the_same_picture_of_every_effect() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        for effect in EFFECTS.into_iter().chain(["shells"]) {
            for (object, projection) in
                [("torus", Projection::Perspective), ("torus", Projection::Parallel), ("knot", Projection::Perspective)]
            {
                let mut scene = preset(effect).expect("a shipped preset");
                scene.object.input = object.into();
                scene.object.resolution = 48;
                scene.camera.projection = projection;
                scene.camera.clip = (object == "knot").then_some([0.0, 0.0, 1.0, 0.3]);
                scene.image.size = [96, 96];
                scene.quality.samples = 128;
                let subject = subject(&scene, &library);
                let [slices, rays] = both(&scene).map(|scene| picture(gpu, &library, &scene, &subject));
                let (flipped, rest) = compare(&slices, &rays, 1e-3);
                println!("{effect} on {object}, {projection:?}: {flipped:.5} flipped, the rest within {rest:.1e}");
                // A position rounded the other way crosses a hard edge in a pixel now and then; nothing else differs.
                assert!(flipped <= 0.004, "{effect} on {object}: {flipped}");
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p44_soft_matter_is_the_same_to_the_rounding_of_f32() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        let mut scene = homogeneous("sphere", 3.0, Projection::Perspective);
        scene.effect.softness = "quadratic".into();
        scene.object.inner_iso = -0.6;
        scene.object.outer_iso = 0.3;
        let subject = formula(&scene);
        let [slices, rays] = both(&scene).map(|scene| picture(gpu, &library, &scene, &subject));
        let (beyond, rest) = compare(&slices, &rays, 1e-5);
        assert_eq!(beyond, 0.0, "the rest is within {rest:e}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p46_an_early_end_changes_no_pixel_by_more_than_it_says() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        let mut scene = homogeneous("sphere", 6.0, Projection::Parallel);
        scene.quality.pass = Pass::March;
        scene.quality.early_termination = 0.0;
        let subject = formula(&scene);
        let whole = picture(gpu, &library, &scene, &subject);
        for stop in [1e-3, 0.05, 0.4] {
            scene.quality.early_termination = stop;
            let ended = picture(gpu, &library, &scene, &subject);
            let (beyond, _) = compare(&whole, &ended, stop);
            assert_eq!(beyond, 0.0, "stop {stop}");
            assert!(stop < 0.05 || whole.pixels != ended.pixels, "stop {stop} ends no ray");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn g10_slices_that_end_early_show_what_all_of_them_show() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        let ended = |scene: &Scene, subject: &Subject, stop: f32| {
            let mut scene = scene.clone();
            (scene.quality.pass, scene.quality.early_termination) = (Pass::Slices, stop);
            picture(gpu, &library, &scene, subject)
        };
        for effect in ["lit", "bump", "melting"] {
            let mut scene = preset(effect).unwrap();
            (scene.object.input, scene.image.size, scene.quality.samples) = ("torus".into(), [70, 50], 100);
            let subject = subject(&scene, &library);
            let whole = ended(&scene, &subject, 0.0);
            assert_eq!(ended(&scene, &subject, 1e-4).pixels, whole.pixels, "{effect}: what is behind is hidden");
        }
        let scene = homogeneous("sphere", 6.0, Projection::Parallel);
        let subject = formula(&scene);
        let whole = ended(&scene, &subject, 0.0);
        for stop in [1e-3, 0.05, 0.4] {
            let ended = ended(&scene, &subject, stop);
            let (beyond, _) = compare(&whole, &ended, stop);
            assert_eq!(beyond, 0.0, "stop {stop}");
            assert!(stop < 0.05 || whole.pixels != ended.pixels, "stop {stop} ends no pixel");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p37_rays_start_at_the_eye_when_it_is_inside_the_volume() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        let mut scene = homogeneous("sphere", 1.0, Projection::Perspective);
        scene.camera.zoom = 8.0;
        let subject = formula(&scene);
        let [slices, rays] = both(&scene).map(|scene| picture(gpu, &library, &scene, &subject));
        assert!(slices.pixels.iter().any(|pixel| pixel[3] > 0.1), "the eye sees the medium around it");
        let (beyond, rest) = compare(&slices, &rays, 1e-5);
        assert!(beyond <= 0.004, "{beyond} beyond, the rest within {rest:e}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m61_skipping_changes_no_bit_of_any_picture() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        for effect in EFFECTS.into_iter().chain(["shells"]) {
            for (object, samples) in [("torus", 64), ("torus", 400), ("knot", 128)] {
                let mut scene = preset(effect).expect("a shipped preset");
                scene.object.input = object.into();
                scene.object.resolution = 48;
                scene.object.stretch = [1.0, 1.0, 0.6];
                scene.image.size = [80, 80];
                scene.quality.pass = Pass::March;
                scene.quality.samples = samples;
                let subject = subject(&scene, &library);
                let [all, skipped] = [EmptySpace::Sample, EmptySpace::Skip].map(|empty_space| {
                    scene.quality.empty_space = empty_space;
                    picture(gpu, &library, &scene, &subject)
                });
                assert!(all.pixels == skipped.pixels, "{effect} on {object}, {samples} samples");
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m61_cells_over_time_change_no_bit_of_moving_pictures() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        for name in ["fire", "smoke"] {
            let mut scene = preset(name).expect("a shipped preset");
            (scene.object.resolution, scene.quality.block_size, scene.image.size) = (32, 32, [120, 120]);
            (scene.quality.pass, scene.quality.samples) = (Pass::March, 300);
            let subject = subject(&scene, &library);
            let [mut renderer, mut every] = [(); 2].map(|()| Renderer::new(gpu, &library, &subject));
            let mut sides = Vec::new();
            // Frames of a sequence, the last of them exposed for a while.
            for frame in 0..8 {
                scene.camera.time = 0.3 + 0.04 * f64::from(frame);
                let (shutter, count) = if frame == 7 { (0.2, 6) } else { (0.0, 1) };
                (scene.camera.shutter, scene.quality.supersampling) = (shutter, count);
                scene.quality.empty_space = EmptySpace::Skip;
                let skipped = renderer.render(&scene).unwrap();
                let found = skipped.measurements.cells.clone().unwrap_or_default();
                assert!(found.empty > 0.1, "{name}, frame {frame}: {found:?}");
                sides.push(found.side);
                scene.quality.empty_space = EmptySpace::Sample;
                assert!(every.render(&scene).unwrap().pixels == skipped.pixels, "{name}, frame {frame}");
            }
            assert!(sides[6] > sides[0], "{name}: cells that frames share are finer: {sides:?}");
        }
    });
}

/// A warp that loops 24 times at each place and leaves it where it is.
const SLOW: &str = "// @move 0
void slow(inout vec3 x, inout mat3 jacobian) {
    float same = x.x;
    for (int i = 0; i < int(min(slice_count, 24.0)); ++i) same = 0.5 * (same + x.x);
    x.x = same;
}
";

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn pictures_of_cut_loops_use_rays_without_waits() {
    with_gpu(|gpu| {
        let library = shader::shipped().with_module("warp", "slow", SLOW);
        let mut scene = homogeneous("sphere", 0.1, Projection::Parallel);
        (scene.image.size, scene.quality.pass) = ([24, 24], Pass::March);
        (scene.quality.early_termination, scene.quality.jitter) = (0.0, Jitter::None);
        let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
        let mut renderer = Renderer::new(gpu, &library, &subject);
        // lavapipe of Mesa 22 ends a fragment after 65 535 turns: 26 for each of 2450 samples, and one more for each that is
        // found first. Where more are borne, none is cut.
        let is_short = gpu.info().driver.contains("Mesa 22.");
        for (samples, is_cut) in [(64, false), (2450, is_short), (64, false)] {
            scene.quality.samples = samples;
            scene.effect.warp = Vec::new();
            let whole = picture(gpu, &library, &scene, &subject);
            scene.effect.warp = vec!["slow".into()];
            for _ in 0..2 {
                let frame = renderer.render(&scene).unwrap();
                assert!(frame.pixels == whole.pixels, "{samples} samples");
                let waits = frame.measurements.modules.contains("empty_space=skip");
                assert!(waits != is_cut, "{samples}: {}", frame.measurements.modules);
            }
            assert!(whole.pixels.iter().any(|pixel| pixel[3] > 0.1));
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_negative_module_opacity_is_not_a_cut_ray() {
    with_gpu(|gpu| {
        let negative = "float opacity(float density, float depth) { return -1e5; }\n";
        let library = shader::shipped().with_module("opacity", "negative", negative);
        let mut scene = homogeneous("sphere", 0.1, Projection::Parallel);
        (scene.image.size, scene.quality.samples, scene.effect.opacity) = ([8, 8], 1, "negative".into());
        let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
        scene.quality.pass = Pass::March;
        let [all, rays] = [EmptySpace::Sample, EmptySpace::Skip].map(|empty_space| {
            scene.quality.empty_space = empty_space;
            picture(gpu, &library, &scene, &subject)
        });
        assert!(rays.measurements.modules.contains("empty_space=leap"), "{}", rays.measurements.modules);
        assert!(rays.pixels == all.pixels && rays.pixels.iter().any(|pixel| pixel[3] < -1e4));
    });
}

#[test]
fn rays_do_not_skip_matter_around_the_object() {
    let empty_space = |scene: &Scene| scene.slots(&shader::shipped())["empty_space"][0].clone();
    let mut scene = preset("shells").expect("a shipped preset");
    assert_eq!(empty_space(&scene), "skip");
    scene.transfer.stops[0].density = 0.1;
    assert_eq!(empty_space(&scene), "sample");
    scene.effect.classify = "stack".into();
    assert_eq!(empty_space(&scene), "sample");
}
