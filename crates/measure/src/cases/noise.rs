//! Gradient noise far from the origin, around 0, beyond integers, and where it repeats.

use super::function::Function;
use super::lab::{CaseError, Lab, Rows, number};
use crate::statistics::largest;
use hypertexture::noise::{Lattice, Weights};

/// Modules of the noise.
pub(super) const SLOTS: &[(&str, &str)] = &[("wrap", "repeat"), ("weights", "quintic")];
/// Mask of the lattice with the longest period.
const LONGEST_MASK: u32 = (1 << 20) - 1;
/// Largest slope of the noise, per cell.
const MAX_SLOPE: f64 = 2.8;
/// Rounding of a sum over eight corners.
const ROUNDING: f64 = 2e-6;

/// Noise on the line of `noise.glsl`: value, and slope along x.
fn truth(t: f64, shift: f64, mask: u32) -> [f64; 2] {
    let ([slope, ..], value) =
        Lattice { weights: Weights::Quintic }.sample([t, 0.5 * t + shift, 0.25 * t + shift], mask + 1);
    [value, slope]
}

fn line<'a>(lab: &Lab<'a>) -> Result<Function<'a>, CaseError> {
    Function::new(lab, include_str!("noise.glsl"), SLOTS)
}

/// Places keep the bits that f32 has for them, and noise is exact for the rounded place.
pub(super) fn far(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    let function = line(lab)?;
    for exponent in [0, 4, 8, 10, 12, 14, 16, 18, 19, 20, 22, 24] {
        let from = 2f64.powi(exponent);
        let seen = function.at([from as f32, (from + 3.0) as f32, LONGEST_MASK as f32, 0.0])?;
        // The exact place; `seen` has it in f32, after an interpolation of four roundings.
        let off = 4.0 * from * 2f64.powi(-24);
        let exact = |place: usize| from + 3.0 * place as f64 / 4096.0;
        let places = seen.iter().enumerate().map(|(place, found)| (exact(place), found[3], off));
        rows.worst("place", format!("cell 2^{exponent}"), places).at(from);
        for (channel, what, bound) in [(0, "noise", ROUNDING), (2, "slope of noise", 8.0 * ROUNDING)] {
            let known =
                seen.iter().map(|found| (truth(found[3], 0.0, LONGEST_MASK)[channel / 2], found[channel], bound));
            rows.worst(what, format!("cell 2^{exponent}"), known).at(from);
        }
    }
    Ok(())
}

/// Negative places, and fractions that round to 1.
pub(super) fn negative(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    let function = line(lab)?;
    for (from, to) in [(-2.0, 2.0), (-1e-9, 1e-9), (-1e-30, 0.0), (-1.000_000_1, -0.999_999_9)] {
        for mask in [255, LONGEST_MASK] {
            let seen = function.at([from, to, mask as f32, 0.0])?;
            let known = seen.iter().flat_map(|[plain, with_slope, slope, t]| {
                let [value, steep] = truth(*t, 0.0, mask);
                [(value, *plain, ROUNDING), (value, *with_slope, ROUNDING), (steep, *slope, 8.0 * ROUNDING)]
            });
            rows.worst("noise and its slope", format!("[{from}, {to}], period {}", mask + 1), known);
        }
    }
    Ok(())
}

/// Places that do not convert to an integer.
pub(super) fn endless(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    let function = line(lab)?;
    for place in [3e9, -3e9, 1e30, f32::MAX, -f32::MAX] {
        let seen = function.at([place, place, LONGEST_MASK as f32, 0.0])?;
        // Places are clamped to the border of the lattice, which is a lattice point.
        let known = seen.iter().flat_map(|[plain, with_slope, slope, _]| {
            let finite = if slope.abs() <= 1.0 { *slope } else { f64::NAN };
            [(0.0, *plain, 0.0), (0.0, *with_slope, 0.0), (finite, finite, 0.0)]
        });
        rows.worst("noise", format!("at {place:e}"), known);
    }
    Ok(())
}

/// A lattice repeats after its period, and agrees with an endless one only before.
pub(super) fn periods(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    let function = line(lab)?;
    for exponent in [2, 4, 8, 12] {
        let period = 2f64.powi(exponent);
        let mask = (period - 1.0) as f32;
        // Steps of about 2^-8 are exact in f32, also after a whole period.
        let ends = |from: f64, to: f64| [from as f32, to as f32];
        let ask = |[from, to]: [f32; 2], mask: f32| function.at([from, to, mask, 0.0]);
        // (t, t / 2, t / 4) repeats after four periods.
        let (here, there) = (ask(ends(0.0, 16.0), mask)?, ask(ends(4.0 * period, 4.0 * period + 16.0), mask)?);
        let pairs = here.iter().zip(&there);
        rows.worst("a period on", format!("period {period}"), pairs.map(|(a, b)| (a[0], b[0], 0.0)));
        let endless = ask(ends(0.0, 16.0), LONGEST_MASK as f32)?;
        let within = here.iter().zip(&endless).filter(|(one, _)| one[3] < period - 1.0);
        rows.worst("within a period", format!("period {period}"), within.map(|(a, b)| (b[0], a[0], 0.0)));
        let beyond = ask(ends(4.0 * period, 4.0 * period + 16.0), LONGEST_MASK as f32)?;
        let apart = largest(here.iter().zip(&beyond).map(|(a, b)| (a[0] - b[0]).abs()));
        let found = format!("apart by {}", number(apart));
        rows.holds("endless noise does not", format!("period {period}"), "apart", found, apart > 0.1);
    }
    Ok(())
}

/// Noise of unit gradients is at most sqrt(3) / 2.
pub(super) fn bounds(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    let function = line(lab)?;
    for (shift, setting) in [(0.0, "4096 cells"), (0.5, "4096 cells, through cell centers")] {
        let mut largest = [0.0f64; 2];
        for part in 0..16 {
            let from = 256.0 * part as f32;
            for [plain, _, slope, _] in function.at([from, from + 256.0, LONGEST_MASK as f32, shift])? {
                largest = [(0, plain.abs()), (1, slope.abs())]
                    .map(|(at, found)| if found.is_nan() { f64::INFINITY } else { largest[at].max(found) });
            }
        }
        for (what, found, bound) in [("noise", largest[0], 0.75f64.sqrt()), ("slope of noise", largest[1], MAX_SLOPE)] {
            let is_within = found <= bound + 1e-6 && found > 0.3;
            rows.holds(what, setting, format!("at most {bound:.4}"), format!("{found:.4}"), is_within);
        }
    }
    Ok(())
}
