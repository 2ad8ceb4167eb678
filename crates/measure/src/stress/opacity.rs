//! Cases 9 to 12: the opacity of a step, from matter that is all but nothing to such that hides all.

use super::function::Function;
use super::matter::sphere;
use super::{Known, Lab, Row, StressError};
use crate::verify::{Ray, SoftBall, TWO_TONE, levels, order, two_tone};
use hypertexture::scene::{Integration, Pass};

/// Modules of opacity.
const MODULES: [&str; 2] = ["perlin", "beer"];
/// Decades of the rate times the path.
const AMOUNTS: std::ops::RangeInclusive<i32> = -6..=9;
/// Densities: from end to end, thinner and thinner, nearer and nearer to 1.
const DENSITIES: [([f32; 2], f32); 3] = [([0.0, 1.0], 0.0), ([-60.0, 0.0], 1.0), ([-24.0, -1.0], 2.0)];

/// The extinction of a density, for a rate of 1.
fn extinction(module: &str, density: f64) -> f64 {
    if module == "beer" { density } else { -(-density).ln_1p() }
}

/// Its mean over a segment, along which the density is linear.
fn mean_extinction(module: &str, [a, b]: [f64; 2]) -> f64 {
    if module == "beer" {
        return 0.5 * (a + b);
    }
    // The middle of many equal parts, and a correction at the ends: no formula of the GLSL is in it. The end at density 1
    // is integrable: -ln over the last part in closed form.
    const PARTS: u32 = 4000;
    let width = (a - b) / f64::from(PARTS);
    let mean = |part: u32| {
        let (low, high) = (b + width * f64::from(part), b + width * f64::from(part + 1));
        // Gauss of two points; where the logarithm bends more than that sees, its integral.
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

/// Opacities are right to a part of themselves, however small they are; below the normal numbers of f32, to those.
fn known(optical: f64, amount: f64, found: f64, part: f64) -> Known {
    // Infinite matter over no path is none.
    let truth = if amount == 0.0 { 0.0 } else { -(-amount * optical).exp_m1() };
    (truth, found, part * truth + f64::from(f32::MIN_POSITIVE))
}

fn rows(
    lab: &Lab<'_>,
    what: &str,
    part: f64,
    of: impl Fn(&str, f64, &[f64; 4]) -> Known,
) -> Result<Vec<Row>, StressError> {
    let mut rows = Vec::new();
    for module in MODULES {
        let function = Function::new(lab, include_str!("opacity.glsl"), &[("opacity", module)])?;
        for decade in AMOUNTS {
            let amount = 10f32.powi(decade);
            let mut all = Vec::new();
            for ([from, to], kind) in DENSITIES {
                let seen = function.at([from, to, amount, kind])?;
                // The truth of a segment takes its time: as many places as make a curve.
                let every = if part > 2e-6 { 16 } else { 1 };
                all.extend(seen.iter().step_by(every).map(|seen| of(module, amount.into(), seen)));
            }
            rows.push(Row::worst(&format!("{what}, {module}"), format!("c ds = 1e{decade}"), all).at(amount.into()));
        }
    }
    Ok(rows)
}

pub(super) fn points(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    rows(lab, "opacity of a point", 1e-6, |module, amount, [found, _, density, _]| {
        known(extinction(module, *density), amount, *found, 1e-6)
    })
}

pub(super) fn segments(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let mut rows = rows(lab, "opacity of a segment", 5e-6, |module, amount, [_, found, from, to]| {
        known(mean_extinction(module, [*from, *to]), amount, *found, 5e-6)
    })?;
    rows.extend(stiff(lab)?);
    Ok(rows)
}

/// A ball whose extinction has no end at its core (MJ 6, PH 3.1): points lose their second order there, segments keep it.
fn stiff(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    const SAMPLES: [u32; 5] = [64, 128, 256, 512, 1024];
    let subject = sphere();
    let mut rows = Vec::new();
    for rate in [1.0, 3.0, 9.0] {
        let ball = SoftBall { rate, ..TWO_TONE };
        // Means of the error with a step of h, as measured, and twice that: points c h, segments c h^2.
        for (integration, what, expected, order_bound) in
            [(Integration::Point, "points", 1.0, 0.25), (Integration::Segment, "segments", 2.0, 0.1)]
        {
            let mut scene = two_tone(integration);
            (scene.quality.pass, scene.effect.opacity_rate) = (Pass::March, rate as f32);
            let light = |ray: &Ray| Some(1.0 - ball.perlin(ray.impact().min(ball.outer)));
            let levels = levels(lab.bench.gpu, &lab.bench.library, &scene, &subject, &SAMPLES, 1, light)?;
            let what = format!("stiff ball, rate {rate}, {what}");
            for level in &levels {
                let bound = if expected == 1.0 { 2.0 * level.step } else { 2.0 * level.step.powi(2) + 1e-6 };
                let row = Row::worst(&what, format!("{} samples", level.samples), [(0.0, level.mean, bound)]);
                rows.push(row.at(level.step));
            }
            let found = order(&levels).unwrap_or(f64::NAN);
            rows.push(Row::worst(&what, "observed order", [(expected, found, order_bound)]));
        }
    }
    Ok(rows)
}

pub(super) fn ends(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let mut rows = Vec::new();
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
            rows.push(Row::worst(
                &format!("opacity, {module}"),
                format!("density {density}, c ds = {amount:e}"),
                known,
            ));
        }
    }
    Ok(rows)
}
