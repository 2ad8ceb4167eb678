//! The segment rule against closed forms in every pixel, with the point rule as the control that must be worse.

mod common;

use common::two_tone::{self, INNER, OUTER, RATE, transmittance};
use common::{Row, difference, errors, formula, homogeneous, order, picture, subject, with_gpu};
use hypertexture::glsl;
use hypertexture::gpu::Gpu;
use hypertexture::scene::{EFFECTS, Pass, Projection, Rule, Scene, Traverse, preset};

const PROJECTIONS: [Projection; 2] = [Projection::Parallel, Projection::Perspective];
const PASSES: [Pass; 2] = [Pass::Slices, Pass::March];
const DOUBLING: [u32; 6] = [32, 64, 128, 256, 512, 1024];

fn overall(rows: &[Row]) -> f64 {
    let above: Vec<&Row> = rows.iter().filter(|row| row.mean > 1e-6).collect();
    order(above[0], above[above.len() - 1])
}

fn rows(gpu: &Gpu, scene: &Scene) -> Vec<Row> {
    let library = two_tone::library();
    println!("{:?} {:?}", scene.quality.rule, scene.quality.pass);
    errors(gpu, &library, (scene, &subject(scene, &library)), &DOUBLING, 1, |ray| {
        Some(match ray.impact() {
            b if b < OUTER => 1.0 - transmittance(b),
            _ => 0.0,
        })
    })
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p45_the_two_tone_sphere_is_of_second_order_by_segments() {
    assert!((-(transmittance(1.0).ln()) - 2.268_715_928_011_75).abs() < 1e-13, "truth 4 itself");
    with_gpu(|gpu| {
        for projection in PROJECTIONS {
            let control = rows(gpu, &two_tone::scene(Rule::Point, Pass::March, projection));
            for pass in PASSES {
                let segments = rows(gpu, &two_tone::scene(Rule::Segment, pass, projection));
                let (point, segment) = (&control[3], &segments[3]);
                assert!(segment.mean <= 4e-5, "{segment:?}");
                assert!(overall(&segments) >= 1.9, "order {}", overall(&segments));
                assert!(point.mean > 50.0 * segment.mean, "points {point:?}, segments {segment:?}");
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p45_a_soft_medium_is_of_second_order_by_segments() {
    with_gpu(|gpu| {
        for projection in PROJECTIONS {
            let mut scene = two_tone::scene(Rule::Segment, Pass::March, projection);
            (scene.effect.opacity, scene.effect.surface) = ("beer".into(), "unlit".into());
            // Truth 3: extinction k D, and k in the core.
            let segments = errors(gpu, &glsl::shipped(), (&scene, &formula(&scene)), &DOUBLING, 3, |ray| {
                let b2 = ray.impact().powi(2);
                let (l0, l1) = ((OUTER * OUTER - b2).max(0.0).sqrt(), (INNER * INNER - b2).max(0.0).sqrt());
                let soft = (OUTER * OUTER - b2) * (l0 - l1) - (l0.powi(3) - l1.powi(3)) / 3.0;
                Some(1.0 - (-2.0 * RATE * (soft / (OUTER * OUTER - INNER * INNER) + l1)).exp())
            });
            assert!(overall(&segments) >= 1.9, "order {}", overall(&segments));
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m31_a_hard_surface_is_found_within_the_step() {
    let place = "// Depth.\n// Source: -\n// Result: 0.5 + 0.5 z.\nvec3 surface(Sample s) { return vec3(0.5 + 0.5 * s.x.z); }\n";
    let library = glsl::shipped().with_module("surface", "place", place);
    with_gpu(|gpu| {
        for (projection, pass) in PROJECTIONS.into_iter().zip(PASSES) {
            let [point, segment] = [Rule::Point, Rule::Segment].map(|rule| {
                let mut scene = homogeneous("sphere", 1.0, projection);
                (scene.effect.classify, scene.effect.surface) = ("surface".into(), "place".into());
                (scene.quality.rule, scene.quality.pass) = (rule, pass);
                println!("{rule:?} {pass:?}");
                let subject = subject(&scene, &library);
                errors(gpu, &library, (&scene, &subject), &[16, 32, 64, 128, 256], 0, |ray| {
                    let (b, nearest) = (ray.impact(), -ray.from.dot(ray.along));
                    // A ray that grazes the sphere may pass it between two ends of segments.
                    let hit = || ray.from + ray.along * (nearest - (1.0 - b * b).sqrt());
                    (b < 0.9).then(|| 0.5 + 0.5 * hit().z)
                })
            });
            assert!(overall(&point) < 1.2 && overall(&segment) > 2.5, "{} {}", overall(&point), overall(&segment));
            assert!(segment[2].mean < 1e-5 && point[2].mean > 1e-2, "{:?} {:?}", segment[2], point[2]);
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m31_a_cut_is_where_its_plane_is() {
    let place = "// Depth.\n// Source: -\n// Result: 0.5 + 0.5 z.\nvec3 surface(Sample s) { return vec3(0.5 + 0.5 * s.x.z); }\n";
    let library = glsl::shipped().with_module("surface", "place", place);
    with_gpu(|gpu| {
        for (classify, softness) in [("surface", "hard"), ("soft", "linear")] {
            for pass in PASSES {
                let mut scene = homogeneous("cube", 1.0, Projection::Perspective);
                (scene.effect.classify, scene.effect.surface) = (classify.into(), "place".into());
                (scene.effect.softness, scene.effect.opacity) = (softness.into(), "perlin".into());
                (scene.quality.rule, scene.quality.pass, scene.quality.samples) = (Rule::Segment, pass, 40);
                scene.camera.clip = Some([0.0, 0.0, 2.0, 0.4]);
                let pixel = picture(gpu, &library, &scene, &subject(&scene, &library)).pixels[32 * 64 + 30];
                assert!((pixel[0] - 0.6).abs() < 1e-5 && pixel[3] == 1.0, "{classify} {pass:?}: {pixel:?}");
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m61_segments_give_one_picture_in_both_passes_leaping_or_not() {
    let library = glsl::shipped();
    with_gpu(|gpu| {
        for effect in EFFECTS {
            let knot = (["solid", "fur"].contains(&effect)).then_some(("knot", Some([0.0, 0.0, 1.0, 0.3])));
            for (object, clip) in [("torus", None)].into_iter().chain(knot) {
                let mut scene = preset(effect).expect("a shipped preset");
                (scene.object.input, scene.object.resolution) = (object.into(), 48);
                scene.object.stretch = [1.0, 1.0, 0.7];
                (scene.image.size, scene.camera.clip) = ([96, 96], clip);
                (scene.quality.rule, scene.quality.samples, scene.quality.stop) = (Rule::Segment, 128, 0.0);
                let subject = subject(&scene, &library);
                let [slices, fixed, leap] =
                    [(Pass::Slices, Traverse::Fixed), (Pass::March, Traverse::Fixed), (Pass::March, Traverse::Leap)]
                        .map(|(pass, traverse)| {
                            (scene.quality.pass, scene.quality.traverse) = (pass, traverse);
                            picture(gpu, &library, &scene, &subject)
                        });
                // A near end that is the far end before it is the same place rounded otherwise.
                let (_, leapt) = difference(&fixed, &leap);
                let (_, rms) = difference(&slices, &fixed);
                println!("{effect} on {object}: rms {rms:.1e} between passes, {leapt:.1e} by leaping");
                assert!(rms <= 4e-3 && leapt <= 1e-4, "{effect} on {object}: {rms:e} {leapt:e}");
            }
        }
    });
}

#[test]
fn m31_what_has_no_segments_is_refused() {
    let mut scene = preset("shells").expect("a shipped preset");
    scene.quality.rule = Rule::Segment;
    let error = scene.check(&glsl::shipped()).unwrap_err().to_string();
    assert!(error.starts_with("quality.rule = segment: effect.classify = \"post\" has points only"), "{error}");
    scene.effect.classify = "preintegrated".into();
    assert!(scene.check(&glsl::shipped()).is_ok(), "a segment rule of its own");
}
