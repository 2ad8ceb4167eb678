//! Cases 6, 7, 11, 14, 15 and 43: soft and hard balls, thin and dense matter, many slices, and what a target holds.

use super::{Known, Lab, Row, StressError, power, with};
use crate::verify::{Ray, SLAB, SoftBall, box_subject, homogeneous, rays, slab};
use hypertexture::render::{Frame, Renderer, Subject};
use hypertexture::scene::{Integration, Pass, Projection, Scene, TargetFormat};

/// Both passes, and how they are told.
pub(super) const PASSES: [(Pass, &str); 2] = [(Pass::March, "rays"), (Pass::Slices, "slices")];
/// Rays of a ball slant by no more.
const SLANT: f64 = 1.036;

/// The built-in sphere.
pub(super) fn sphere() -> Subject {
    Subject { input: "sphere".into(), radius: 1.0, ..box_subject(glam::Vec3::ONE) }
}

/// The opacity of each pixel that `known` has an answer for, with how far off it may be.
fn opacities(
    scene: &Scene,
    subject: &Subject,
    frame: &Frame,
    known: impl Fn(&Ray, f64) -> Option<[f64; 2]>,
) -> Vec<Known> {
    let step = f64::from(frame.measurements.step);
    let pixels = rays(scene, subject).into_iter().zip(&frame.pixels);
    pixels
        .filter_map(|(ray, pixel)| {
            let [truth, bound] = known(&ray, step)?;
            Some((truth, f64::from(pixel[3]), bound))
        })
        .collect()
}

/// What an opacity may be where a chord is measured to a step at each side; blends round.
fn chord(rate: f64, chord: f64, step: f64, samples: u32) -> [f64; 2] {
    let of = |chord: f64| -(-rate * chord.max(0.0)).exp_m1();
    let (truth, off) = (of(chord), SLANT * step);
    [truth, (of(chord + off) - truth).max(truth - of(chord - off)) + 6e-8 * f64::from(samples) * truth + 1e-6 * truth]
}

/// Case 6: a soft ball becomes a hard one as the width of its soft region goes to 0.
pub(super) fn soft_to_hard(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    const RATE: f64 = 3.0;
    let subject = sphere();
    let mut renderer = Renderer::new(lab.bench.gpu, &lab.bench.library, &subject);
    let mut rows = Vec::new();
    for (integration, how) in [(Integration::Point, "points"), (Integration::Segment, "segments")] {
        for exponent in [0, -5, -10, -15, -20, -25, -30, -40] {
            let half = 0.5 * 2f64.powi(exponent);
            let mut scene = homogeneous("sphere", RATE as f32, Projection::Parallel);
            scene.effect.softness = "quadratic".into();
            (scene.object.inner_iso, scene.object.outer_iso) = (-half as f32, half as f32);
            (scene.quality.integration, scene.quality.early_termination) = (integration, 0.0);
            let frame = renderer.render(&scene)?;
            let ball = SoftBall { inner: 1.0 - half, outer: 1.0 + half, rate: RATE };
            let known = opacities(&scene, &subject, &frame, |ray, step| {
                let b = ray.impact();
                // The mean density of a wide one is found better than the chord of a hard one.
                let l = (ball.outer.powi(2) - b * b).max(0.0).sqrt();
                let [_, bound] = chord(RATE, 2.0 * l, step, scene.quality.samples);
                Some([ball.beer(b), bound + 1e-6])
            });
            let what = format!("soft ball by {how}");
            rows.push(Row::worst(&what, format!("width {}", power(exponent)), known).at(2f64.powi(exponent)));
        }
        let equal = with(homogeneous("sphere", RATE as f32, Projection::Parallel), |scene| {
            scene.effect.softness = "quadratic".into();
            (scene.object.inner_iso, scene.object.outer_iso) = (0.0, 0.0);
            (scene.quality.integration, scene.quality.early_termination) = (integration, 0.0);
        });
        let hard = with(equal.clone(), |scene| scene.effect.softness = "hard".into());
        let (equal, hard) = (renderer.render(&equal)?, renderer.render(&hard)?);
        rows.push(Row::worst(
            &format!("soft ball by {how}"),
            "equal iso-values: the hard ball",
            same(&hard, &equal, if integration == Integration::Point { 0.0 } else { 1e-4 }),
        ));
    }
    Ok(rows)
}

/// Values of two pictures that must be alike.
pub(super) fn same(one: &Frame, other: &Frame, bound: f64) -> Vec<Known> {
    let channels = one.pixels.as_flattened().iter().zip(other.pixels.as_flattened());
    channels.map(|(one, other)| (f64::from(*one), f64::from(*other), bound)).collect()
}

/// Case 7: an inner radius below 0 is none; squared it would come back as a core.
pub(super) fn wide(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let subject = sphere();
    let mut renderer = Renderer::new(lab.bench.gpu, &lab.bench.library, &subject);
    let mut rows = Vec::new();
    for (pass, how) in PASSES {
        for inner in [-0.999f32, -1.0, -1.5, -2.0] {
            let mut scene = homogeneous("sphere", 3.0, Projection::Parallel);
            scene.effect.softness = "quadratic".into();
            (scene.object.inner_iso, scene.object.outer_iso) = (inner, 0.25);
            (scene.quality.pass, scene.quality.early_termination) = (pass, 0.0);
            let frame = renderer.render(&scene)?;
            let ball = SoftBall { inner: (1.0 + f64::from(inner)).max(0.0), outer: 1.25, rate: 3.0 };
            let known = opacities(&scene, &subject, &frame, |ray, step| {
                // The kink of the density at the outer radius, and of its core: h^2 / 8 of the slope of each, four times.
                let bound = 4.0 * 3.0 * (2.0 / 1.25) * (1.1 * step).powi(2) / 8.0 + 2e-5;
                Some([ball.beer(ray.impact()), bound])
            });
            rows.push(Row::worst(&format!("soft ball by {how}"), format!("inner iso-value {inner}"), known));
        }
    }
    Ok(rows)
}

/// Case 11: extinction from nothing to what no f32 holds.
pub(super) fn rates(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let subject = sphere();
    let mut renderer = Renderer::new(lab.bench.gpu, &lab.bench.library, &subject);
    let mut rows = Vec::new();
    for (pass, how) in PASSES {
        for decade in -6..=9 {
            let rate = 10f32.powi(decade);
            let mut scene = homogeneous("sphere", rate, Projection::Parallel);
            (scene.quality.pass, scene.quality.early_termination) = (pass, 0.0);
            let frame = renderer.render(&scene)?;
            let known = opacities(&scene, &subject, &frame, |ray, step| {
                let length = 2.0 * (1.0 - ray.impact().powi(2)).max(0.0).sqrt();
                // Within a step of the rim a ray may have no sample in the ball at all.
                (length == 0.0 || length > 2.0 * step).then(|| chord(rate.into(), length, step, scene.quality.samples))
            });
            rows.push(Row::worst(&format!("ball by {how}"), format!("opacity rate 1e{decade}"), known).at(rate.into()));
        }
    }
    Ok(rows)
}

/// Case 14: one slice to all that a scene may have, in f32.
pub(super) fn slices(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    const RATE: f64 = 3.0;
    /// By rays: more are refused, since a device may cut their loop, case 17. A multiple of 12.
    const MOST: u32 = 59_616;
    let subject = box_subject(SLAB);
    let mut renderer = Renderer::new(lab.bench.gpu, &lab.bench.library, &subject);
    let mut rows = Vec::new();
    for (pass, how) in PASSES {
        for samples in [1, 2, 3, 12, 60, 600, 6_000, MOST, 99_996] {
            if pass == Pass::March && samples > MOST {
                continue;
            }
            let mut scene = homogeneous("cube", RATE as f32, Projection::Parallel);
            (scene.image.size, scene.camera.zoom, scene.quality.pass) = ([8, 8], 4.0, pass);
            (scene.quality.samples, scene.quality.early_termination) = (samples, 0.0);
            let frame = renderer.render(&scene)?;
            let step = 2.0 / f64::from(samples);
            // Samples stand in the middle of their steps: those in the slab count, and what is left is rounding.
            let inside = (0..samples).filter(|&i| ((f64::from(i) + 0.5) * step - 1.0).abs() < 1.0 / 3.0).count();
            let truth = slab(RATE, RATE, inside as f64 * step);
            let off = 2e-6 + 6e-8 * f64::from(samples).sqrt() + 6e-9 * f64::from(samples);
            let known = frame.pixels.iter().map(|pixel| (truth, f64::from(pixel[3]), off));
            rows.push(Row::worst(&format!("slab by {how}"), format!("{samples}"), known).at(samples.into()));
        }
    }
    Ok(rows)
}

/// Case 15: a ray that ends early leaves out no more than it was allowed to.
pub(super) fn termination(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let subject = sphere();
    let mut renderer = Renderer::new(lab.bench.gpu, &lab.bench.library, &subject);
    let mut rows = Vec::new();
    for (pass, how) in PASSES {
        let scene = |allowed: f32| {
            with(homogeneous("sphere", 6.0, Projection::Perspective), |scene| {
                (scene.quality.pass, scene.quality.early_termination) = (pass, allowed);
            })
        };
        let whole = renderer.render(&scene(0.0))?;
        for exponent in [-1, -2, -4, -6] {
            let allowed = 10f32.powi(exponent);
            let frame = renderer.render(&scene(allowed))?;
            let known = same(&whole, &frame, f64::from(allowed) + 2e-5);
            rows.push(Row::worst(&format!("ball by {how}"), format!("1e{exponent}"), known).at(allowed.into()));
        }
    }
    Ok(rows)
}

/// Case 43: a target loses at most what its bits say, and holds no more light than it can.
pub(super) fn formats(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let subject = box_subject(SLAB);
    let mut renderer = Renderer::new(lab.bench.gpu, &lab.bench.library, &subject);
    let truth = slab(3.0, 3.0, 2.0 / 3.0);
    let formats = [
        (TargetFormat::Unorm8, "unorm8", 1.0 / 510.0),
        (TargetFormat::Float16, "float16", 2f64.powi(-11)),
        (TargetFormat::Float32, "float32", 2f64.powi(-24)),
    ];
    let mut rows = Vec::new();
    for (format, name, unit) in formats {
        for slices in [12, 60, 240, 1020, 10_020] {
            let mut scene = homogeneous("cube", 3.0, Projection::Parallel);
            (scene.image.size, scene.camera.zoom, scene.quality.pass) = ([8, 8], 4.0, Pass::Slices);
            (scene.quality.target, scene.quality.samples, scene.quality.early_termination) = (format, 3 * slices, 0.0);
            let frame = renderer.render(&scene)?;
            // Every slice is rounded once.
            let bound = unit * f64::from(slices) + 2e-6;
            if bound >= 0.8 {
                continue; // nothing is left to hold it against
            }
            let known = frame.pixels.iter().map(|pixel| (truth, f64::from(pixel[3]), bound));
            rows.push(Row::worst(&format!("slab in {name}"), format!("{slices} slices"), known).at(slices.into()));
        }
        let mut scene = homogeneous("sphere", 50.0, Projection::Parallel);
        (scene.effect.surface, scene.quality.target, scene.quality.pass) = ("lit".into(), format, Pass::Slices);
        (scene.light.intensity, scene.material.specular_power) = (1000.0, 1.0);
        let ball = sphere();
        let frame = Renderer::new(lab.bench.gpu, &lab.bench.library, &ball).render(&scene)?;
        let opaque = |pixel: &[f32; 4]| (f64::from(pixel[3]), f64::from(pixel[3].clamp(0.0, 1.0)), 2e-3);
        rows.push(Row::worst(&format!("blinding light in {name}"), "intensity 1000", frame.pixels.iter().map(opaque)));
    }
    Ok(rows)
}
