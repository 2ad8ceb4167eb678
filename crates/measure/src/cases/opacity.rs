//! Opacity of a step, from nearly transparent to opaque matter.

use super::analytic::{levels, order};
use super::analytic_scenes::{TWO_TONE, two_tone};
use super::closed_forms::SoftBall;
use super::function::Function;
use super::lab::{CaseError, Known, Lab, Rows};
use super::rays::Ray;
use super::scenes::sphere;
use hypertexture::scene::{Integration, Pass};

/// Modules of opacity.
const MODULES: [&str; 2] = ["perlin", "beer"];
/// Decades of the rate times the path.
const AMOUNTS: std::ops::RangeInclusive<i32> = -6..=9;
/// Densities: over [0, 1], toward 0, and toward 1.
const DENSITIES: [([f32; 2], f32); 3] = [([0.0, 1.0], 0.0), ([-60.0, 0.0], 1.0), ([-24.0, -1.0], 2.0)];

/// Extinction of a density, for a rate of 1.
fn extinction(module: &str, density: f64) -> f64 {
    if module == "beer" { density } else { -(-density).ln_1p() }
}

/// Mean extinction of a segment along which the density is linear.
fn mean_extinction(module: &str, [a, b]: [f64; 2]) -> f64 {
    if module == "beer" {
        return 0.5 * (a + b);
    }
    const PARTS: u32 = 4000;
    let width = (a - b) / f64::from(PARTS);
    let mean = |part: u32| {
        let (low, high) = (b + width * f64::from(part), b + width * f64::from(part + 1));
        // Gauss quadrature of two points; the closed form where the logarithm bends more than it resolves.
        let (u, v) = (1.0 - low, 1.0 - high);
        if u - v > 0.01 * v {
            let whole = |x: f64| if x > 0.0 { x * x.ln() - x } else { 0.0 };
            return -(whole(u) - whole(v)) / (u - v);
        }
        let (middle, off) = (0.5 * (low + high), 0.5 * (high - low) / 3f64.sqrt());
        0.5 * (extinction(module, middle - off) + extinction(module, middle + off))
    };
    (0..PARTS).map(mean).sum::<f64>() / f64::from(PARTS)
}

/// Opacities are right to a relative error, down to the smallest normal number of f32.
fn known(optical: f64, amount: f64, found: f64, part: f64) -> Known {
    // Infinite extinction over a path of 0 is transparent.
    let truth = if amount == 0.0 { 0.0 } else { -(-amount * optical).exp_m1() };
    (truth, found, part * truth + f64::from(f32::MIN_POSITIVE))
}

fn compare(
    lab: &Lab<'_>,
    rows: &mut Rows,
    what: &str,
    part: f64,
    of: impl Fn(&str, f64, &[f64; 4]) -> Known,
) -> Result<(), CaseError> {
    for module in MODULES {
        let function = Function::new(lab, include_str!("opacity.glsl"), &[("opacity", module)])?;
        for decade in AMOUNTS {
            let amount = 10f32.powi(decade);
            let mut all = Vec::new();
            for ([from, to], kind) in DENSITIES {
                let seen = function.at([from, to, amount, kind])?;
                // The truth of a segment is slow: fewer places.
                let every = if part > 2e-6 { 16 } else { 1 };
                all.extend(seen.iter().step_by(every).map(|seen| of(module, amount.into(), seen)));
            }
            rows.worst(format!("{what}, {module}"), format!("c ds = 1e{decade}"), all).at(amount);
        }
    }
    Ok(())
}

pub(super) fn points(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    compare(lab, rows, "opacity of a point", 1e-6, |module, amount, [found, _, density, _]| {
        known(extinction(module, *density), amount, *found, 1e-6)
    })
}

pub(super) fn segments(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    compare(lab, rows, "opacity of a segment", 5e-6, |module, amount, [_, found, from, to]| {
        known(mean_extinction(module, [*from, *to]), amount, *found, 5e-6)
    })?;
    stiff(lab, rows)
}

/// A ball whose extinction is infinite at its core (MJ 6, PH 3.1): points lose their second order, segments keep it.
fn stiff(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    const SAMPLES: [u32; 5] = [64, 128, 256, 512, 1024];
    let subject = sphere();
    for rate in [1.0, 3.0, 9.0] {
        let ball = SoftBall { rate, ..TWO_TONE };
        // Mean errors for a step of h, twice as measured: points c h, segments c h^2.
        for (integration, what, expected, order_bound) in
            [(Integration::Point, "points", 1.0, 0.25), (Integration::Segment, "segments", 2.0, 0.1)]
        {
            let mut scene = two_tone(integration);
            (scene.quality.pass, scene.effect.opacity_rate) = (Pass::March, rate as f32);
            let light = |ray: &Ray| Some(1.0 - ball.perlin(ray.impact().min(ball.outer)));
            let levels = levels(lab.gpu, &lab.library, &scene, &subject, &SAMPLES, 1, light)?;
            let what = format!("stiff ball, rate {rate}, {what}");
            for level in &levels {
                let bound = if expected == 1.0 { 2.0 * level.step } else { 2.0 * level.step.powi(2) + 1e-6 };
                let setting = format!("{} samples", level.samples);
                rows.worst(&what, setting, [(0.0, level.mean, bound)]).at(level.step);
            }
            let found = order(&levels).unwrap_or(f64::NAN);
            rows.worst(&what, "observed order", [(expected, found, order_bound)]);
        }
    }
    Ok(())
}

pub(super) fn ends(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    for module in MODULES {
        let function = Function::new(lab, include_str!("opacity.glsl"), &[("opacity", module)])?;
        let full = |amount: f64| if module == "beer" { -(-amount).exp_m1() } else { f64::from(amount > 0.0) };
        for (density, amount, expected) in [
            (1.0, 0.0, 0.0),
            (1.0, 1e-30, full(1e-30)),
            (0.0, 1e30, 0.0),
            (0.0, 0.0, 0.0),
            (1.0, 3e38, 1.0),
            (0.5, 3e38, 1.0),
        ] {
            let seen = function.at([density, density, amount, 0.0])?;
            let known = seen.iter().map(|[found, ..]| (expected, *found, 1e-6 * expected));
            let setting = format!("density {density}, c ds = {amount:e}");
            rows.worst(format!("opacity, {module}"), setting, known);
        }
    }
    Ok(())
}
