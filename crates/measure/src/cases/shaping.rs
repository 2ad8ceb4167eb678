//! Bias and gain, where an exponent is 0 or infinite.

use super::function::Function;
use super::lab::{CaseError, Lab, Rows};

/// Distance of the clamped parameter from 0 and 1.
const CLAMP: f64 = 1.0 / 1024.0;
/// Rounding of a power by two logarithms in f32.
const ROUNDING: f64 = 4e-6;

/// Bias in f64: `b` is the value at 1/2 (PH 2.3, MJ Eq. 5).
pub fn bias(b: f64, t: f64) -> f64 {
    match t {
        ..=0.0 => 0.0,
        1.0.. => 1.0,
        _ => t.powf(b.clamp(CLAMP, 1.0 - CLAMP).ln() / 0.5f64.ln()),
    }
}

/// Gain in f64 (PH 2.3, MJ Eq. 6).
pub fn gain(g: f64, t: f64) -> f64 {
    if t < 0.5 { 0.5 * bias(1.0 - g, 2.0 * t) } else { 1.0 - 0.5 * bias(1.0 - g, 2.0 - 2.0 * t) }
}

fn shaping<'a>(lab: &Lab<'a>) -> Result<Function<'a>, CaseError> {
    Function::new(lab, include_str!("shaping.glsl"), &[])
}

/// Parameters that approach 0 or 1, their names, and their distances from it.
fn toward(end: f64) -> Vec<(f64, String, f64)> {
    let near = [2, 5, 10, 20].map(|exponent| {
        let gap = 2f64.powi(-exponent);
        let name = if end == 0.0 { format!("2^-{exponent}") } else { format!("1 - 2^-{exponent}") };
        ((end - gap).abs(), name, gap)
    });
    near.into_iter().chain([(end, format!("{end}"), 0.0)]).collect()
}

fn biased(lab: &Lab<'_>, rows: &mut Rows, end: f64) -> Result<(), CaseError> {
    let function = shaping(lab)?;
    for (b, name, gap) in toward(end) {
        let mut values = function.at([0.0, 1.0, b as f32, 0.0])?;
        values.push(function.at([1.0, 1.0, b as f32, 0.0])?[0]);
        let known = |exact: bool| {
            let ends = move |t: f64| !exact || t == 0.0 || t == 1.0;
            let bound = if exact { 0.0 } else { ROUNDING };
            values.iter().filter(move |[.., t]| ends(*t)).map(move |[found, .., t]| (bias(b, *t), *found, bound))
        };
        let what = if end == 0.0 { "bias, b to 0" } else { "bias, b to 1" };
        rows.worst(what, format!("b = {name}"), known(false)).at(gap.max(CLAMP / 2048.0));
        rows.worst("0 and 1 are fixed points", format!("b = {name}"), known(true));
        let falls = values.windows(2).map(|pair| (pair[0][0] - pair[1][0]).max(0.0));
        rows.worst("bias is monotonic", format!("b = {name}"), falls.map(|fall| (0.0, fall, ROUNDING)));
    }
    Ok(())
}

pub(super) fn bias_near_1(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    biased(lab, rows, 1.0)
}

pub(super) fn bias_near_0(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    biased(lab, rows, 0.0)
}

pub(super) fn gain_at_ends(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    let function = shaping(lab)?;
    for (end, what) in [(0.0, "gain, g to 0"), (1.0, "gain, g to 1")] {
        for (g, name, gap) in toward(end) {
            let values = function.at([0.0, 1.0, g as f32, 0.0])?;
            let setting = format!("g = {name}");
            let known = values.iter().map(|[_, found, _, t]| (gain(g, *t), *found, ROUNDING));
            rows.worst(what, &setting, known).at(gap.max(CLAMP / 2048.0));
            let sums = values.iter().map(|[_, one, other, _]| (1.0, one + other, ROUNDING));
            rows.worst("gain is symmetric", &setting, sums);
            let middle = function.at([0.5, 0.5, g as f32, 0.0])?;
            rows.worst("gain of 1/2", &setting, middle.iter().map(|[_, found, ..]| (0.5, *found, 0.0)));
        }
    }
    Ok(())
}

pub(super) fn beyond(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    let function = shaping(lab)?;
    for (from, to) in [(-10.0, 0.0), (1.0, 10.0), (-1e30, 1e30)] {
        let values = function.at([from, to, 0.3, 0.0])?;
        let known = values.iter().flat_map(|[biased, gained, _, t]| {
            let end = if *t <= 0.0 { 0.0 } else { 1.0 };
            [(end, *biased, 0.0), (end, *gained, 0.0)]
        });
        rows.worst("bias and gain", format!("t in [{from}, {to}]"), known);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shaping_curves_have_the_values_of_the_paper() {
        for amount in [0.1, 0.5, 0.8] {
            assert!((bias(amount, 0.5) - amount).abs() < 1e-12);
            assert!((gain(amount, 0.25) - 0.5 * (1.0 - amount)).abs() < 1e-12);
            assert_eq!((gain(amount, 0.5), bias(amount, 0.0), gain(amount, 1.0)), (0.5, 0.0, 1.0));
        }
    }
}
