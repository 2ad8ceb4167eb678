//! Soft and hard balls, thin and dense matter, many slices, and formats of the target.

use super::closed_forms::{SoftBall, slab};
use super::lab::{CaseError, Known, Lab, PASSES, Rows, same};
use super::rays::{Ray, rays};
use super::scenes::{SLAB, SLANT, box_subject, homogeneous, slab_scene, sphere};
use hypertexture::render::{Frame, Subject};
use hypertexture::scene::{Integration, Pass, Projection, Scene, TargetFormat};

/// Opacities of the pixels for which `known` returns the truth and its bound.
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

/// Opacity of a chord, and its bound where the chord is measured to a step and blends round.
fn chord(rate: f64, chord: f64, step: f64, samples: u32) -> [f64; 2] {
    let of = |chord: f64| -(-rate * chord.max(0.0)).exp_m1();
    let (truth, off) = (of(chord), SLANT * step);
    [truth, (of(chord + off) - truth).max(truth - of(chord - off)) + 6e-8 * f64::from(samples) * truth + 1e-6 * truth]
}

/// A soft ball becomes a hard one as the width of its soft region goes to 0.
pub(super) fn soft_to_hard(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    const RATE: f64 = 3.0;
    let subject = sphere();
    let mut renderer = lab.renderer(&subject);
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
                let l = (ball.outer.powi(2) - b * b).max(0.0).sqrt();
                let [_, bound] = chord(RATE, 2.0 * l, step, scene.quality.samples);
                Some([ball.beer(b), bound + 1e-6])
            });
            let what = format!("soft ball by {how}");
            rows.worst(&what, format!("width 2^{exponent}"), known).at(2f64.powi(exponent));
        }
        let mut scene = homogeneous("sphere", RATE as f32, Projection::Parallel);
        scene.effect.softness = "quadratic".into();
        (scene.object.inner_iso, scene.object.outer_iso) = (0.0, 0.0);
        (scene.quality.integration, scene.quality.early_termination) = (integration, 0.0);
        let equal = renderer.render(&scene)?;
        scene.effect.softness = "hard".into();
        let hard = renderer.render(&scene)?;
        let bound = if integration == Integration::Point { 0.0 } else { 1e-4 };
        rows.worst(format!("soft ball by {how}"), "equal iso-values: the hard ball", same(&hard, &equal, bound));
    }
    Ok(())
}

/// A negative inner radius means no core, although its square is positive.
pub(super) fn wide(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    let subject = sphere();
    let mut renderer = lab.renderer(&subject);
    for (pass, how) in PASSES {
        for inner in [-0.999f32, -1.0, -1.5, -2.0] {
            let mut scene = homogeneous("sphere", 3.0, Projection::Parallel);
            scene.effect.softness = "quadratic".into();
            (scene.object.inner_iso, scene.object.outer_iso) = (inner, 0.25);
            (scene.quality.pass, scene.quality.early_termination) = (pass, 0.0);
            let frame = renderer.render(&scene)?;
            let ball = SoftBall { inner: (1.0 + f64::from(inner)).max(0.0), outer: 1.25, rate: 3.0 };
            let known = opacities(&scene, &subject, &frame, |ray, step| {
                // Four kinks of the density, at the outer radius and at the core: h^2 / 8 of the slope each.
                let bound = 4.0 * 3.0 * (2.0 / 1.25) * (1.1 * step).powi(2) / 8.0 + 2e-5;
                Some([ball.beer(ray.impact()), bound])
            });
            rows.worst(format!("soft ball by {how}"), format!("inner iso-value {inner}"), known);
        }
    }
    Ok(())
}

/// Extinction from 1e-6 to 1e9.
pub(super) fn rates(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    let subject = sphere();
    let mut renderer = lab.renderer(&subject);
    for (pass, how) in PASSES {
        for decade in -6..=9 {
            let rate = 10f32.powi(decade);
            let mut scene = homogeneous("sphere", rate, Projection::Parallel);
            (scene.quality.pass, scene.quality.early_termination) = (pass, 0.0);
            let frame = renderer.render(&scene)?;
            let known = opacities(&scene, &subject, &frame, |ray, step| {
                let length = 2.0 * (1.0 - ray.impact().powi(2)).max(0.0).sqrt();
                // A ray within a step of the rim may have no sample in the ball.
                (length == 0.0 || length > 2.0 * step).then(|| chord(rate.into(), length, step, scene.quality.samples))
            });
            rows.worst(format!("ball by {how}"), format!("opacity rate 1e{decade}"), known).at(rate);
        }
    }
    Ok(())
}

/// One slice to the largest number that a scene may have.
pub(super) fn slices(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    const RATE: f64 = 3.0;
    /// Largest number of samples of a ray that is a multiple of 12; a device may cut longer loops.
    const MAX_SAMPLES: u32 = 59_616;
    let subject = box_subject(SLAB);
    let mut renderer = lab.renderer(&subject);
    for (pass, how) in PASSES {
        for samples in [1, 2, 3, 12, 60, 600, 6_000, MAX_SAMPLES, 99_996] {
            if pass == Pass::March && samples > MAX_SAMPLES {
                continue;
            }
            let mut scene = slab_scene(RATE as f32, pass);
            scene.quality.samples = samples;
            let frame = renderer.render(&scene)?;
            let step = 2.0 / f64::from(samples);
            // Samples lie in the middle of their steps; those in the slab count, and the rest is rounding.
            let inside = (0..samples).filter(|&i| ((f64::from(i) + 0.5) * step - 1.0).abs() < 1.0 / 3.0).count();
            let truth = slab(RATE, RATE, inside as f64 * step);
            let off = 2e-6 + 6e-8 * f64::from(samples).sqrt() + 6e-9 * f64::from(samples);
            let known = frame.pixels.iter().map(|pixel| (truth, f64::from(pixel[3]), off));
            rows.worst(format!("slab by {how}"), format!("{samples}"), known).at(samples);
        }
    }
    Ok(())
}

/// A ray that ends early leaves out at most the allowed transmittance.
pub(super) fn termination(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    let subject = sphere();
    let mut renderer = lab.renderer(&subject);
    for (pass, how) in PASSES {
        let mut scene = homogeneous("sphere", 6.0, Projection::Perspective);
        (scene.quality.pass, scene.quality.early_termination) = (pass, 0.0);
        let whole = renderer.render(&scene)?;
        for exponent in [-1, -2, -4, -6] {
            let allowed = 10f32.powi(exponent);
            scene.quality.early_termination = allowed;
            let frame = renderer.render(&scene)?;
            let known = same(&whole, &frame, f64::from(allowed) + 2e-5);
            rows.worst(format!("ball by {how}"), format!("1e{exponent}"), known).at(allowed);
        }
    }
    Ok(())
}

/// A target loses at most half a unit per slice, and its colors stay at most 1. The target of the paper loses thin matter.
pub(super) fn formats(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    let subject = box_subject(SLAB);
    let mut renderer = lab.renderer(&subject);
    let truth = slab(3.0, 3.0, 2.0 / 3.0);
    type Format = (TargetFormat, &'static str, fn(f64) -> f64);
    let formats: [Format; 3] = [
        (TargetFormat::Unorm8, "unorm8", |slices| slices / 510.0 + 2e-6),
        // The product of transmittance and opacity must exceed half an ulp of the opacity.
        (TargetFormat::Float16, "float16", |slices| 2e-4 * slices),
        (TargetFormat::Float32, "float32", |slices| {
            (slices * 2f64.powi(-24) + 2e-6).min(if slices < 2000.0 { 1e-5 } else { 1e-3 })
        }),
    ];
    for (format, name, bound) in formats {
        for slices in [12, 60, 64, 240, 256, 1020, 1024, 10_020] {
            let mut scene = slab_scene(3.0, Pass::Slices);
            (scene.quality.target, scene.quality.samples) = (format, 3 * slices);
            let frame = renderer.render(&scene)?;
            let bound = bound(f64::from(slices));
            let (what, setting) = (format!("slab in {name}"), format!("{slices} slices"));
            if bound >= 0.8 {
                let off = (f64::from(frame.pixels[0][3]) - truth).abs();
                if format == TargetFormat::Unorm8 {
                    rows.holds(what, setting, "lost matter", format!("off by {off:.2}"), off > 0.4);
                }
                continue;
            }
            let known = frame.pixels.iter().map(|pixel| (truth, f64::from(pixel[3]), bound));
            rows.worst(what, setting, known).at(slices);
        }
        let mut scene = homogeneous("sphere", 50.0, Projection::Parallel);
        (scene.effect.surface, scene.quality.target, scene.quality.pass) = ("lit".into(), format, Pass::Slices);
        (scene.light.intensity, scene.material.specular_power) = (1000.0, 1.0);
        let frame = lab.render(&scene, &sphere())?;
        let opaque = |pixel: &[f32; 4]| (f64::from(pixel[3]), f64::from(pixel[3].clamp(0.0, 1.0)), 2e-3);
        rows.worst(format!("overexposure in {name}"), "intensity 1000", frame.pixels.iter().map(opaque));
    }
    Ok(())
}
