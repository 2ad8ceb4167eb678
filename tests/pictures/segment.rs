//! The segment integration against closed forms in every pixel, with the point integration as the control that must be worse.

use crate::common::{difference, errors, formula, homogeneous, picture, subject, with_gpu};
use hypertexture::scene::{EFFECTS, EmptySpace, Integration, Pass, Projection, preset};
use hypertexture::shader;
use hypertexture_measure::cases::{self, AnalyticCase, Lab, Level, PASSES, TWO_TONE, order, two_tone};

const PROJECTIONS: [Projection; 2] = [Projection::Parallel, Projection::Perspective];
const DOUBLING: [u32; 6] = [32, 64, 128, 256, 512, 1024];

fn overall(rows: &[Level]) -> f64 {
    order(rows).expect("errors above rounding")
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p45_the_two_tone_sphere_is_of_second_order_by_segments() {
    with_gpu(|gpu| {
        let lab = Lab::new(gpu, cases::library()).expect("a GLSL compiler");
        let [points, segments]: [Vec<_>; 2] = ["points", "segments"]
            .map(|integration| cases::TWO_TONES.iter().filter(|case| case.variant == integration).collect());
        for (point, segment) in points.into_iter().zip(segments) {
            let control = levels(point, &lab, Pass::March);
            for (pass, _) in PASSES {
                let segments = levels(segment, &lab, pass);
                let (point, segment) = (&control[1], &segments[1]);
                println!("{pass:?}, {} samples: points {point:?}, segments {segment:?}", segment.samples);
                assert!(segment.samples == 256 && segment.mean <= 4e-5, "{segment:?}");
                assert!(overall(&segments) >= 1.9, "order {}", overall(&segments));
                assert!(point.mean > 50.0 * segment.mean, "points {point:?}, segments {segment:?}");
            }
        }
    });
}

fn levels(case: &AnalyticCase, lab: &Lab<'_>, pass: Pass) -> Vec<Level> {
    case.levels(lab, pass).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p45_a_soft_medium_is_of_second_order_by_segments() {
    with_gpu(|gpu| {
        for projection in PROJECTIONS {
            let mut scene = two_tone(Integration::Segment);
            (scene.quality.pass, scene.camera.projection) = (Pass::March, projection);
            (scene.effect.opacity, scene.effect.surface) = ("beer".into(), "unlit".into());
            let segments = errors(gpu, &shader::shipped(), (&scene, &formula(&scene)), &DOUBLING, 3, |ray| {
                Some(TWO_TONE.beer(ray.impact()))
            });
            assert!(overall(&segments) >= 1.9, "order {}", overall(&segments));
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m30_a_hard_surface_is_found_within_the_step() {
    let place = "// Depth.\n// Source: -\n// Result: 0.5 + 0.5 z.\nvec3 surface(Sample s) { return vec3(0.5 + 0.5 * s.x.z); }\n";
    let library = shader::shipped().with_module("surface", "place", place);
    with_gpu(|gpu| {
        for (projection, (pass, _)) in PROJECTIONS.into_iter().zip(PASSES) {
            let [point, segment] = [Integration::Point, Integration::Segment].map(|integration| {
                let mut scene = homogeneous("sphere", 1.0, projection);
                (scene.effect.classify, scene.effect.surface) = ("surface".into(), "place".into());
                (scene.quality.integration, scene.quality.pass) = (integration, pass);
                println!("{integration:?} {pass:?}");
                let subject = subject(&scene, &library);
                errors(gpu, &library, (&scene, &subject), &[16, 32, 64, 128, 256], 0, |ray| {
                    let (b, nearest) = (ray.impact(), -ray.from.dot(ray.along));
                    // Beyond, depth is so steep that rounding shows.
                    let hit = || ray.from + ray.along * (nearest - (1.0 - b * b).sqrt());
                    (b < 0.99).then(|| 0.5 + 0.5 * hit().z)
                })
            });
            // The step of the coarsest is an eighth of the ball: without a place within it the mean error is near 0.05.
            for level in point.iter().chain(&segment) {
                assert!(level.mean < 1e-5 && level.max < 2e-4, "{level:?}");
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m30_a_cut_is_where_its_plane_is() {
    let place = "// Depth.\n// Source: -\n// Result: 0.5 + 0.5 z.\nvec3 surface(Sample s) { return vec3(0.5 + 0.5 * s.x.z); }\n";
    let library = shader::shipped().with_module("surface", "place", place);
    with_gpu(|gpu| {
        for (classify, softness) in [("surface", "hard"), ("soft", "linear")] {
            for (pass, _) in PASSES {
                let mut scene = homogeneous("cube", 1.0, Projection::Perspective);
                (scene.effect.classify, scene.effect.surface) = (classify.into(), "place".into());
                (scene.effect.softness, scene.effect.opacity) = (softness.into(), "perlin".into());
                (scene.quality.integration, scene.quality.pass, scene.quality.samples) =
                    (Integration::Segment, pass, 40);
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
    let library = shader::shipped();
    with_gpu(|gpu| {
        for effect in EFFECTS {
            let knot = (["solid", "fur"].contains(&effect)).then_some(("knot", Some([0.0, 0.0, 1.0, 0.3])));
            for (object, clip) in [("torus", None)].into_iter().chain(knot) {
                let mut scene = preset(effect).expect("a shipped preset");
                (scene.object.input, scene.object.resolution) = (object.into(), 48);
                scene.object.stretch = [1.0, 1.0, 0.7];
                (scene.image.size, scene.camera.clip) = ([96, 96], clip);
                (scene.quality.integration, scene.quality.samples, scene.quality.early_termination) =
                    (Integration::Segment, 128, 0.0);
                let subject = subject(&scene, &library);
                let [slices, fixed, skip] = [
                    (Pass::Slices, EmptySpace::Sample),
                    (Pass::March, EmptySpace::Sample),
                    (Pass::March, EmptySpace::Skip),
                ]
                .map(|(pass, empty_space)| {
                    (scene.quality.pass, scene.quality.empty_space) = (pass, empty_space);
                    picture(gpu, &library, &scene, &subject)
                });
                // A near end that is the far end before it is the same place rounded otherwise.
                let (_, skipped) = difference(&fixed, &skip);
                let (_, rms) = difference(&slices, &fixed);
                println!("{effect} on {object}: rms {rms:.1e} between passes, {skipped:.1e} by skipping");
                assert!(rms <= 4e-3 && skipped <= 1e-4, "{effect} on {object}: {rms:e} {skipped:e}");
            }
        }
    });
}

#[test]
fn m30_what_has_no_segments_is_refused() {
    let mut scene = preset("shells").expect("a shipped preset");
    scene.effect.classify = "post".into();
    scene.quality.integration = Integration::Segment;
    let error = scene.check(&shader::shipped()).unwrap_err().to_string();
    assert!(error.starts_with("quality.integration = segment: effect.classify = \"post\" has points only"), "{error}");
    scene.effect.classify = "preintegrated".into();
    assert!(scene.check(&shader::shipped()).is_ok(), "a segment integration of its own");
}
