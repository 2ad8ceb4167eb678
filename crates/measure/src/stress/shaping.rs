//! Cases 1 to 5: bias and gain, where an exponent is 0 or has no end.

use super::function::Function;
use super::{Lab, Row, StressError, power};

/// What the functions hold their parameter in.
const HELD: f64 = 1.0 / 1024.0;
/// As far as f32 has a power of two logarithms.
const NEAR: f64 = 4e-6;

/// PH 2.3.
fn bias(b: f64, t: f64) -> f64 {
    match t {
        ..=0.0 => 0.0,
        1.0.. => 1.0,
        _ => t.powf(b.clamp(HELD, 1.0 - HELD).ln() / 0.5f64.ln()),
    }
}

fn gain(g: f64, t: f64) -> f64 {
    match t < 0.5 {
        true => 0.5 * bias(1.0 - g, 2.0 * t),
        false => 1.0 - 0.5 * bias(1.0 - g, 2.0 - 2.0 * t),
    }
}

fn shaping<'a>(lab: &Lab<'a>) -> Result<Function<'a>, StressError> {
    Function::new(lab, include_str!("shaping.glsl"), &[])
}

/// Parameters that go to 0 or 1, and how they are told.
fn toward(end: f64) -> Vec<(f64, String, f64)> {
    let near = [2, 5, 10, 20].map(|exponent| {
        let gap = 2f64.powi(-exponent);
        let told = if end == 0.0 { power(-exponent) } else { format!("1 - {}", power(-exponent)) };
        ((end - gap).abs(), told, gap)
    });
    near.into_iter().chain([(end, format!("{end}"), 0.0)]).collect()
}

fn biased(lab: &Lab<'_>, end: f64) -> Result<Vec<Row>, StressError> {
    let function = shaping(lab)?;
    let mut rows = Vec::new();
    for (b, told, gap) in toward(end) {
        let mut seen = function.at([0.0, 1.0, b as f32, 0.0])?;
        seen.push(function.at([1.0, 1.0, b as f32, 0.0])?[0]);
        let known = |exact: bool| {
            let ends = move |t: f64| !exact || t == 0.0 || t == 1.0;
            let bound = if exact { 0.0 } else { NEAR };
            seen.iter().filter(move |[.., t]| ends(*t)).map(move |[found, .., t]| (bias(b, *t), *found, bound))
        };
        let what = if end == 0.0 { "bias, b to 0" } else { "bias, b to 1" };
        rows.push(Row::worst(what, format!("b = {told}"), known(false)).at(gap.max(HELD / 2048.0)));
        rows.push(Row::worst("0 and 1 stay what they are", format!("b = {told}"), known(true)));
        let falls = seen.windows(2).map(|pair| (pair[0][0] - pair[1][0]).max(0.0));
        rows.push(Row::worst("bias rises", format!("b = {told}"), falls.map(|fall| (0.0, fall, NEAR))));
    }
    Ok(rows)
}

pub(super) fn bias_near_1(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    biased(lab, 1.0)
}

pub(super) fn bias_near_0(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    biased(lab, 0.0)
}

pub(super) fn gain_at_ends(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let function = shaping(lab)?;
    let mut rows = Vec::new();
    for (end, what) in [(0.0, "gain, g to 0"), (1.0, "gain, g to 1")] {
        for (g, told, gap) in toward(end) {
            let seen = function.at([0.0, 1.0, g as f32, 0.0])?;
            let setting = format!("g = {told}");
            let known = seen.iter().map(|[_, found, _, t]| (gain(g, *t), *found, NEAR));
            rows.push(Row::worst(what, &setting, known).at(gap.max(HELD / 2048.0)));
            let sums = seen.iter().map(|[_, one, other, _]| (1.0, one + other, NEAR));
            rows.push(Row::worst("gain is symmetric", &setting, sums));
            let middle = function.at([0.5, 0.5, g as f32, 0.0])?;
            rows.push(Row::worst("gain of 1/2", &setting, middle.iter().map(|[_, found, ..]| (0.5, *found, 0.0))));
        }
    }
    Ok(rows)
}

pub(super) fn beyond(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let function = shaping(lab)?;
    let mut rows = Vec::new();
    for (from, to) in [(-10.0, 0.0), (1.0, 10.0), (-1e30, 1e30)] {
        let seen = function.at([from, to, 0.3, 0.0])?;
        let known = seen.iter().flat_map(|[biased, gained, _, t]| {
            let end = if *t <= 0.0 { 0.0 } else { 1.0 };
            [(end, *biased, 0.0), (end, *gained, 0.0)]
        });
        rows.push(Row::worst("bias and gain", format!("t in [{from}, {to}]"), known));
    }
    Ok(rows)
}
