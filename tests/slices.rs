//! Guarantees of slices: the picture does not depend on their order, shape or number, only on what is in the scene.

use crate::common::{difference, formula, homogeneous, picture, rays, subject, with_gpu};
use hypertexture::gpu::{Format, Gpu};
use hypertexture::render::{Frame, Renderer, Subject, render};
use hypertexture::scene::{EFFECTS, EmptySpace, FieldEncoding, Jitter, Order, Pass, Projection, Proxy, Scene, preset};
use hypertexture::shader;
use std::path::Path;

/// An irregular octahedron: a closed mesh without symmetry, so that a wrong axis shows.
const CORNERS: [[f32; 3]; 6] =
    [[1.0, 0.1, 0.0], [-0.8, 0.0, 0.1], [0.1, 0.7, 0.0], [0.0, -0.9, 0.2], [0.2, 0.0, 0.6], [0.0, 0.1, -0.9]];
const FACES: [[u32; 3]; 8] = [[1, 3, 5], [3, 2, 5], [2, 4, 5], [4, 1, 5], [3, 1, 6], [2, 3, 6], [4, 2, 6], [1, 4, 6]];

/// Writes the octahedron, turned, into a folder and returns the path.
fn octahedron(folder: &Path, turn: impl Fn([f32; 3]) -> [f32; 3]) -> String {
    let corners = CORNERS.map(|corner| turn(corner).map(|value| value.to_string()).join(" "));
    let faces = FACES.map(|face| face.map(|corner| corner.to_string()).join(" "));
    let text = [corners.map(|v| format!("v {v}\n")).concat(), faces.map(|f| format!("f {f}\n")).concat()].concat();
    let path = folder.join("octahedron.obj");
    std::fs::write(&path, text).expect("the folder is new");
    path.display().to_string()
}

/// An effect, small.
fn effect(name: &str, object: &str, samples: u32) -> Scene {
    let mut scene = preset(name).unwrap_or_else(|error| panic!("{error}"));
    scene.object.input = object.into();
    scene.object.resolution = 32;
    scene.image.size = [64, 64];
    (scene.quality.pass, scene.quality.samples) = (Pass::Slices, samples);
    scene
}

/// The six effects on the torus and on a mesh, each with its subject.
fn effects(samples: u32, test: impl Fn(&str, &Scene, &Subject)) {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let mesh = octahedron(folder.path(), |corner| corner);
    for (label, object) in [("torus", "torus"), ("mesh", mesh.as_str())] {
        for name in EFFECTS {
            let scene = effect(name, object, samples);
            test(&format!("{name} on {label}"), &scene, &subject(&scene, &shader::shipped()));
        }
    }
}

fn shipped(gpu: &Gpu, scene: &Scene, subject: &Subject) -> Frame {
    picture(gpu, &shader::shipped(), scene, subject)
}

/// Pixels that are covered in one picture alone, and the root-mean-square difference of the others.
fn missed_and_rest(a: &Frame, b: &Frame) -> (u32, f64) {
    let (mut missed, mut sum) = (0, 0.0);
    for (a, b) in a.pixels.iter().zip(&b.pixels) {
        match (a[3] - b[3]).abs() > 0.5 {
            true => missed += 1,
            false => sum += a.iter().zip(b).map(|(a, b)| f64::from(a - b).powi(2)).sum::<f64>(),
        }
    }
    (missed, (sum / (4 * a.pixels.len()) as f64).sqrt())
}

/// How many pixels are covered, with one beside them that is not.
fn outline(frame: &Frame) -> f64 {
    let width = frame.size[0] as usize;
    let covered = |index: usize| frame.pixels.get(index).is_some_and(|pixel| pixel[3] > 0.5);
    let on = |i: &usize| covered(*i) && [i + 1, i - 1, i + width, i - width].into_iter().any(|beside| !covered(beside));
    (width..frame.pixels.len()).filter(on).count() as f64
}

/// Part of the pixels that differ by more than `limit` in a channel.
fn part_beyond(a: &Frame, b: &Frame, limit: f32) -> f64 {
    let beyond = |(a, b): &(&[f32; 4], &[f32; 4])| a.iter().zip(*b).any(|(a, b)| (a - b).abs() > limit);
    a.pixels.iter().zip(&b.pixels).filter(beyond).count() as f64 / a.pixels.len() as f64
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m32_p44_front_to_back_equals_back_to_front() {
    with_gpu(|gpu| {
        effects(64, |name, scene, subject| {
            let [front, back] = [Order::FrontToBack, Order::BackToFront].map(|order| {
                let mut scene = scene.clone();
                (scene.quality.order, scene.quality.early_termination) = (order, 0.0);
                shipped(gpu, &scene, subject)
            });
            // 64 blends, each rounded to half an ulp of a value of at most 2: 64 ulp of 1 at the very worst.
            let (max, rms) = difference(&front, &back);
            println!("{name}: max {:.1} ulp, rms {:.2} ulp", max / 2f64.powi(-23), rms / 2f64.powi(-23));
            assert!(max <= 16.0 * 2f64.powi(-23), "{name}: {max:e}");
        });
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn polygons_show_what_quads_show() {
    with_gpu(|gpu| {
        effects(64, |name, scene, subject| {
            let [polygons, quads] = [Proxy::Polygons, Proxy::Quads].map(|proxy| {
                let mut scene = scene.clone();
                scene.quality.proxy = proxy;
                shipped(gpu, &scene, subject)
            });
            // The positions differ in their last bits: a sample on a hard edge may fall to the other side.
            let (max, rms) = difference(&polygons, &quads);
            let beyond = part_beyond(&polygons, &quads, 1e-3);
            println!("{name}: max {max:.1e}, rms {rms:.1e}, {:.2} % beyond 1e-3", 100.0 * beyond);
            assert!(beyond <= 0.005, "{name}: {beyond}");
        });
    });
}

/// Every fragment lets 15/16 of the light through: how many lie before each other is in the opacity of the picture.
const VEIL: &str = "vec4 classify(vec3 x, float path) { return vec4(1.0 / 16.0); }\n";

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn polygons_shade_less_than_half_the_fragments_of_quads() {
    with_gpu(|gpu| {
        let library = shader::shipped().with_module("classify", "veil", VEIL);
        // Of a ball nearly all of the box is in the quads; of a ring it is flat.
        let mut scene = effect("lit", "torus", 64);
        let ring = formula(&scene);
        scene.effect.classify = "veil".into();
        // Counted in what is drawn: what a driver counts as a fragment that is shaded is its own affair.
        let [polygons, quads] = [Proxy::Polygons, Proxy::Quads].map(|proxy| {
            scene.quality.proxy = proxy;
            let frame = picture(gpu, &library, &scene, &ring);
            let before = |pixel: &[f32; 4]| ((1.0 - f64::from(pixel[3])).ln() / (15f64 / 16.0).ln()).round();
            frame.pixels.iter().map(before).sum::<f64>()
        });
        println!("{polygons} fragments in polygons, {quads} in quads: {:.2} x", quads / polygons);
        assert!(polygons > 0.0 && 2.0 * polygons <= quads, "{polygons} against {quads}");
        assert!(quads <= 64.0 * 64.0 * 64.0, "no pixel lies in a slice twice, and {quads} fragments do");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m61_slices_in_tiles_of_cells_give_the_same_picture() {
    type Way = (&'static str, fn(&mut Scene));
    let changes: [Way; 8] = [
        ("as it is", |_| ()),
        ("back to front", |scene| scene.quality.order = Order::BackToFront),
        ("parallel, turned, moved", |scene| {
            scene.camera.projection = Projection::Parallel;
            (scene.camera.azimuth, scene.camera.elevation, scene.camera.pan) = (130.0, 50.0, [0.3, -0.2]);
        }),
        ("an eye in the matter", |scene| scene.camera.zoom = 30.0),
        ("many moments, shifted", |scene| {
            (scene.quality.supersampling, scene.quality.jitter, scene.camera.shutter) = (2, Jitter::Hash, 0.2);
        }),
        ("quads", |scene| scene.quality.proxy = Proxy::Quads),
        ("taken apart", |scene| scene.camera.slice_stack = true),
        ("four samples a pixel", |scene| scene.quality.msaa = 4),
    ];
    with_gpu(|gpu| {
        effects(192, |name, scene, subject| {
            let library = shader::shipped();
            // One with a hard surface, and one that moves it, in every way.
            let ways = if name.starts_with("solid") || name.starts_with("melting") { changes.len() } else { 1 };
            for (what, change) in &changes[..ways] {
                let mut scene = scene.clone();
                scene.image.size = [200, 160];
                let mut renderer = Renderer::new(gpu, &library, subject);
                let mut draw = |scene: &Scene| renderer.render(scene).unwrap_or_else(|error| panic!("{error}"));
                scene.quality.empty_space = EmptySpace::Skip;
                // Results for this picture must not serve another; the second picture of a program finds cells anyway.
                draw(&scene);
                change(&mut scene);
                draw(&scene);
                let skipped = draw(&scene);
                scene.quality.empty_space = EmptySpace::Sample;
                let every = shipped(gpu, &scene, subject);
                let bits = |frame: &Frame| bytemuck::cast_slice::<_, u32>(&frame.pixels).to_vec();
                assert!(bits(&skipped) == bits(&every), "{name}, {what}");
                let serve = !["taken apart", "four samples a pixel"].contains(what);
                assert_eq!((skipped.measurements.cells.is_some(), every.measurements.cells.is_some()), (serve, false));
            }
        });
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p45_halving_the_step_changes_a_picture_by_its_stated_error() {
    with_gpu(|gpu| {
        effects(192, |name, scene, subject| {
            let frames = [1, 2, 4].map(|factor| {
                let mut scene = scene.clone();
                scene.quality.samples *= factor;
                shipped(gpu, &scene, subject)
            });
            // A ray may cross less matter than a step just inside an outline: where the two sides of the object meet
            // there at a right angle or less, at most half a step from the outline, half of the rays on average.
            let pixels = rays(scene, subject);
            let pixel = (pixels[1].at(0.0) - pixels[0].at(0.0)).length();
            let outline = outline(&frames[2]);
            for ([a, b], step) in [([0, 1], frames[0].measurements.step), ([1, 2], frames[1].measurements.step)] {
                let (missed, rms) = missed_and_rest(&frames[a], &frames[b]);
                let (step, allowed) = (f64::from(step), outline * f64::from(step) / (2.0 * pixel));
                println!(
                    "{name}: step {step:.4}, {missed} of {outline} on the outline missed, rms of the rest {rms:.2e}"
                );
                assert!(f64::from(missed) <= allowed, "{name}: {missed} at step {step}, {allowed} allowed");
                // First order: shading changes by a few units per object unit. The stated error of a picture is an RMS
                // of 2 per object unit of the step, and half the step has half of it.
                assert!(rms <= 2.0 * step, "{name}: {rms:e} at step {step}");
            }
        });
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m01_turning_the_camera_equals_turning_the_object() {
    with_gpu(|gpu| {
        let [still, turned] = [(); 2].map(|()| tempfile::tempdir().expect("a temporary folder"));
        // A quarter turn around y brings what looks at +x to +z.
        let objects = [octahedron(still.path(), |corner| corner), octahedron(turned.path(), |[x, y, z]| [-z, y, x])];
        let [by_camera, by_object] = [(&objects[0], 90.0), (&objects[1], 0.0)].map(|(object, azimuth)| {
            let mut scene = effect("lit", object, 64);
            scene.camera.azimuth = azimuth;
            shipped(gpu, &scene, &subject(&scene, &shader::shipped()))
        });
        let unturned = effect("lit", &objects[0], 64);
        let other = shipped(gpu, &unturned, &subject(&unturned, &shader::shipped()));
        let beyond = part_beyond(&by_camera, &by_object, 1e-2);
        println!(
            "{:.2} % of the pixels differ; without the turn {:.0} %",
            100.0 * beyond,
            100.0 * part_beyond(&by_camera, &other, 1e-2)
        );
        assert!(beyond < 0.01, "{beyond}");
        assert!(part_beyond(&by_camera, &other, 1e-2) > 0.1);
        assert_eq!(by_camera.measurements.slices, by_object.measurements.slices);

        // Around the axis of a torus, every turn is the same picture; around that of a cube, every quarter.
        for (object, azimuths) in [("torus", [0.0, 77.0]), ("cube", [10.0, 100.0])] {
            let frames = azimuths.map(|azimuth| {
                let mut scene = effect("lit", object, 64);
                scene.camera.azimuth = azimuth;
                shipped(gpu, &scene, &formula(&scene))
            });
            assert!(part_beyond(&frames[0], &frames[1], 1e-3) < 0.01, "{object}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m30_hard_objects_of_a_slice_thickness_have_no_holes() {
    with_gpu(|gpu| {
        let mut scene = homogeneous("sphere", 1.0, Projection::Parallel);
        scene.effect.classify = "surface".into();
        scene.camera.azimuth = 30.0;
        let equality = "float soften(float distance) { return abs(distance - iso_value) < 0.01 ? 1.0 : 0.0; }\n";
        for samples in [4, 16, 64] {
            scene.quality.samples = samples;
            let subject = formula(&scene);
            let frame = shipped(gpu, &scene, &subject);
            let step = f64::from(frame.measurements.step);
            let chord = |b: f64| 2.0 * (1.0 - b * b).max(0.0).sqrt();
            let mut thick = 0;
            for (ray, pixel) in rays(&scene, &subject).iter().zip(&frame.pixels) {
                // Slices at equal distances cannot miss a chord that is longer than their distance.
                if chord(ray.impact()) > step * 1.001 {
                    thick += 1;
                    assert_eq!(pixel[3], 1.0, "{samples} slices: a hole at {ray:?}");
                }
                if ray.impact() > 1.001 {
                    assert_eq!(pixel[3], 0.0, "{samples} slices: matter at {ray:?}");
                }
            }
            // The negative control: a test for equality, as MJ 3.5 warns, has holes, where no sample stands for its step.
            let library = shader::shipped().with_module("softness", "hard", equality);
            let mut control = scene.clone();
            (control.effect.classify, control.effect.opacity) = ("soft".into(), "perlin".into());
            let covered = picture(gpu, &library, &control, &subject).pixels.iter().filter(|p| p[3] > 0.0).count();
            println!("{samples} slices: {thick} thick pixels, all covered; equality covers {covered}");
            assert!(covered < thick);
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_clipping_plane_keeps_exactly_one_side() {
    with_gpu(|gpu| {
        let mut scene = homogeneous("sphere", 3.0, Projection::Parallel);
        let subject = formula(&scene);
        let whole = shipped(gpu, &scene, &subject);
        let [left, right] = [1.0, -1.0].map(|sign| {
            scene.camera.clip = Some([2.0 * sign, 0.0, 0.0, 0.0]);
            shipped(gpu, &scene, &subject)
        });
        let mut kept = [0, 0];
        for (index, ray) in rays(&scene, &subject).iter().enumerate() {
            // The x of an object seen along -z is that of the picture; no pixel center lies on the plane.
            let side = usize::from(ray.from.x > 0.0);
            let [there, gone] = if side == 0 { [&left, &right] } else { [&right, &left] };
            assert_eq!(there.pixels[index], whole.pixels[index], "{ray:?}");
            assert_eq!(gone.pixels[index], [0.0; 4], "{ray:?}");
            kept[side] += usize::from(there.pixels[index][3] > 0.0);
        }
        assert!(kept[0] > 500 && kept[0] == kept[1], "{kept:?}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m57_four_samples_change_the_pixels_of_an_edge_and_no_other() {
    with_gpu(|gpu| {
        let mut scene = homogeneous("sphere", 1.0, Projection::Perspective);
        scene.effect.classify = "surface".into();
        let subject = formula(&scene);
        let one = shipped(gpu, &scene, &subject);
        scene.quality.msaa = 4;
        let four = shipped(gpu, &scene, &subject);
        let mut fractions = 0;
        let alpha = |x: u32, y: u32| one.pixels[(y * 64 + x) as usize][3];
        for (x, y) in (1..63).flat_map(|y| (1..63).map(move |x| (x, y))) {
            let around = (y - 1..=y + 1).flat_map(|y| (x - 1..=x + 1).map(move |x| (x, y)));
            let inside = around.clone().all(|(i, j)| alpha(i, j) == alpha(x, y));
            let found = four.pixels[(y * 64 + x) as usize][3];
            assert!(!inside || found == alpha(x, y), "pixel {x}, {y}: {found}");
            fractions += usize::from(found > 0.0 && found < 1.0);
        }
        println!("{fractions} pixels of the edge are partly covered");
        assert!(fractions > 50, "{fractions}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m57_unsupported_sample_counts_name_the_supported_ones() {
    with_gpu(|gpu| {
        let mut scene = homogeneous("sphere", 1.0, Projection::Perspective);
        let counts = gpu.sample_counts(Format::Rgba32Float);
        for msaa in [2, 4, 8] {
            scene.quality.msaa = msaa;
            let result = render(gpu, &shader::shipped(), &scene, &formula(&scene));
            match result {
                Ok(_) => assert!(counts.contains(&msaa), "{msaa} rendered, and the device has {counts:?}"),
                Err(error) => {
                    let error = error.to_string();
                    assert!(!counts.contains(&msaa), "{error}");
                    assert!(error.contains(&format!("cannot do {msaa} samples per pixel in Rgba32Float")), "{error}");
                    assert!(error.ends_with(&format!("use quality.msaa = one of {counts:?}")), "{error}");
                }
            }
        }
        // The software driver that the tests are pinned to, whose newer versions have 8 too.
        assert!(!gpu.info().name.contains("llvmpipe") || counts.starts_with(&[1, 4]), "{counts:?}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m57_anisotropy_is_accepted_up_to_what_the_device_has() {
    with_gpu(|gpu| {
        let mut scene = effect("lit", "sphere", 64);
        scene.object.field_encoding = FieldEncoding::Normals16;
        let subject = subject(&scene, &shader::shipped());
        let isotropic = shipped(gpu, &scene, &subject);
        scene.quality.anisotropy = gpu.info().max_anisotropy;
        let anisotropic = shipped(gpu, &scene, &subject);
        // How a driver filters a volume is its own affair, but a filter of one level reaches no further than a voxel.
        let voxel = f64::from(subject.field.as_ref().expect("a volume").grid.spacing.max_element() * subject.scale);
        let mut differ = 0;
        for ((ray, a), b) in rays(&scene, &subject).iter().zip(&isotropic.pixels).zip(&anisotropic.pixels) {
            differ += usize::from(a[3] != b[3]);
            assert!((ray.impact() - 1.0).abs() <= 1.5 * voxel || a[3] == b[3], "{ray:?}: {a:?} against {b:?}");
        }
        println!("anisotropy {}: {differ} pixels at the edge differ", scene.quality.anisotropy);
    });
}
