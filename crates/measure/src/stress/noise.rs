//! Cases 24 to 30: gradient noise far away, around 0, at what is no place, and where it repeats.

use super::function::Function;
use super::{Lab, Row, StressError, power};
use crate::statistics::largest;
use hypertexture::noise::{Lattice, Weights};

/// What the noise is made with.
pub(super) const SLOTS: &[(&str, &str)] = &[("wrap", "repeat"), ("weights", "quintic")];
/// One less than the cells after which the lattice repeats unless it is asked to sooner.
const ENDLESS: u32 = (1 << 20) - 1;
/// Slope of the noise: at most so much for each cell.
const STEEP: f64 = 2.8;
/// Rounding of eight corners.
const ROUNDED: f64 = 2e-6;

/// The noise on the line of `noise.glsl`: value, and slope along x.
fn truth(t: f64, shift: f64, mask: u32) -> [f64; 2] {
    let ([slope, ..], value) =
        Lattice { weights: Weights::Quintic }.sample([t, 0.5 * t + shift, 0.25 * t + shift], mask + 1);
    [value, slope]
}

fn line<'a>(lab: &Lab<'a>) -> Result<Function<'a>, StressError> {
    Function::new(lab, include_str!("noise.glsl"), SLOTS)
}

/// Case 24: a place has as many bits as f32 leaves it, and the noise is that of the place.
pub(super) fn far(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let function = line(lab)?;
    let mut rows = Vec::new();
    for exponent in [0, 4, 8, 10, 12, 14, 16, 18, 19, 20, 22, 24] {
        let from = 2f64.powi(exponent);
        let seen = function.at([from as f32, (from + 3.0) as f32, ENDLESS as f32, 0.0])?;
        // The place that was meant: `seen` has it in f32. Each coordinate is off by half of its last bit, and is made by
        // an interpolation of four roundings.
        let off = 4.0 * from * 2f64.powi(-24);
        let meant = |place: usize| from + 3.0 * place as f64 / 4096.0;
        let places = seen.iter().enumerate().map(|(place, found)| (meant(place), found[3], off));
        rows.push(Row::worst("place", format!("cell {}", power(exponent)), places).at(from));
        for (channel, what, bound) in [(0, "noise", ROUNDED), (2, "slope of noise", 8.0 * ROUNDED)] {
            let known = seen.iter().map(|found| (truth(found[3], 0.0, ENDLESS)[channel / 2], found[channel], bound));
            rows.push(Row::worst(what, format!("cell {}", power(exponent)), known).at(from));
        }
    }
    Ok(rows)
}

/// Case 25: floor of what is negative, and fractions that round to 1.
pub(super) fn negative(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let function = line(lab)?;
    let mut rows = Vec::new();
    for (from, to) in [(-2.0, 2.0), (-1e-9, 1e-9), (-1e-30, 0.0), (-1.000_000_1, -0.999_999_9)] {
        for mask in [255, ENDLESS] {
            let seen = function.at([from, to, mask as f32, 0.0])?;
            let known = seen.iter().flat_map(|[plain, with_slope, slope, t]| {
                let [value, steep] = truth(*t, 0.0, mask);
                [(value, *plain, ROUNDED), (value, *with_slope, ROUNDED), (steep, *slope, 8.0 * ROUNDED)]
            });
            rows.push(Row::worst("noise and its slope", format!("[{from}, {to}], period {}", mask + 1), known));
        }
    }
    Ok(rows)
}

/// Case 26: what cannot be converted to an integer.
pub(super) fn endless(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let function = line(lab)?;
    let mut rows = Vec::new();
    for place in [3e9, -3e9, 1e30, f32::MAX, -f32::MAX] {
        let seen = function.at([place, place, ENDLESS as f32, 0.0])?;
        // The border of the lattice is a lattice point.
        let known = seen.iter().flat_map(|[plain, with_slope, slope, _]| {
            let finite = if slope.abs() <= 1.0 { *slope } else { f64::NAN };
            [(0.0, *plain, 0.0), (0.0, *with_slope, 0.0), (finite, finite, 0.0)]
        });
        rows.push(Row::worst("noise", format!("at {place:e}"), known));
    }
    Ok(rows)
}

/// Case 28: a lattice repeats where it is told to, agrees with an endless one until then, and not beyond.
pub(super) fn periods(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let function = line(lab)?;
    let mut rows = Vec::new();
    for exponent in [2, 4, 8, 12] {
        let period = 2f64.powi(exponent);
        let mask = (period - 1.0) as f32;
        // Steps of 2^-8 or so have no rounding in f32, moved by a period or not.
        let ends = |from: f64, to: f64| [from as f32, to as f32];
        let ask = |[from, to]: [f32; 2], mask: f32| function.at([from, to, mask, 0.0]);
        // (t, t/2, t/4) repeats after four periods.
        let (here, there) = (ask(ends(0.0, 16.0), mask)?, ask(ends(4.0 * period, 4.0 * period + 16.0), mask)?);
        let pairs = here.iter().zip(&there);
        rows.push(Row::worst("a period on", format!("period {period}"), pairs.map(|(a, b)| (a[0], b[0], 0.0))));
        let endless = ask(ends(0.0, 16.0), ENDLESS as f32)?;
        let within = here.iter().zip(&endless).filter(|(one, _)| one[3] < period - 1.0);
        rows.push(Row::worst("within a period", format!("period {period}"), within.map(|(a, b)| (b[0], a[0], 0.0))));
        let beyond = ask(ends(4.0 * period, 4.0 * period + 16.0), ENDLESS as f32)?;
        let apart = largest(here.iter().zip(&beyond).map(|(a, b)| (a[0] - b[0]).abs()));
        let found = report_of(apart);
        rows.push(Row::said("endless noise does not", format!("period {period}"), "apart", found, apart > 0.1));
    }
    Ok(rows)
}

fn report_of(apart: f64) -> String {
    format!("apart by {}", super::report::number(apart))
}

/// Case 30: noise of unit gradients is at most sqrt(3) / 2.
pub(super) fn bounds(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let function = line(lab)?;
    let mut rows = Vec::new();
    for (shift, setting) in [(0.0, "4096 cells"), (0.5, "4096 cells, by their middles")] {
        let mut largest = [0.0f64; 2];
        for part in 0..16 {
            let from = 256.0 * part as f32;
            for [plain, _, slope, _] in function.at([from, from + 256.0, ENDLESS as f32, shift])? {
                // NaN is larger than any bound.
                largest = [(0, plain.abs()), (1, slope.abs())]
                    .map(|(at, found)| if found.is_nan() { f64::INFINITY } else { largest[at].max(found) });
            }
        }
        for (what, found, bound) in [("noise", largest[0], 0.75f64.sqrt()), ("slope of noise", largest[1], STEEP)] {
            let known = format!("at most {bound:.4}");
            rows.push(Row::said(what, setting, known, report_largest(found), found <= bound + 1e-6 && found > 0.3));
        }
    }
    Ok(rows)
}

fn report_largest(found: f64) -> String {
    format!("{found:.4}")
}
