//! Transfer maps and index maps as rows of texels.

use super::codes::code16;
use crate::scene::{Curve, Stop, Transfer};
use glam::{Vec3, Vec4};

/// Entries of a transfer map on the device. Lower: steps smear over a visible range of density.
const TRANSFER_SIZE: usize = 1024;

/// Transfer map as a row of RGBA, 16 bits each: linear color, and density in A. Entry i is for the density `i / (length
/// - 1)`.
pub fn transfer_map(transfer: &Transfer) -> Vec<u16> {
    let at = |index: usize| index as f32 / (TRANSFER_SIZE - 1) as f32;
    (0..TRANSFER_SIZE).flat_map(|index| evaluate(transfer, at(index)).to_array().map(code16)).collect()
}

/// First texel of a transfer map as a device reads it; equals all texels if [`Transfer::is_flat`]. The bits are those
/// of llvmpipe; other devices may round the conversion differently, by 2^-24.
pub(crate) fn transfer_texel(transfer: &Transfer) -> [f32; 4] {
    evaluate(transfer, 0.0).to_array().map(|value| f32::from(code16(value)) * (1.0 / 65535.0))
}

/// Color (linear RGB) and density of a transfer map at a density in [0, 1].
pub fn evaluate(transfer: &Transfer, density: f32) -> Vec4 {
    let value = |stop: &Stop| Vec3::from(stop.color.linear()).extend(stop.density);
    interpolate(transfer, density, value).clamp(Vec4::ZERO, Vec4::ONE)
}

/// Index map as a row of RGBA floats: index of refraction, its slope by density, number of the layer, 0. Entry i is for
/// the density `i / (length - 1)`; a layer ends where the index or its slope jumps.
pub(crate) fn index_map(transfer: &Transfer) -> Vec<f32> {
    let at = |entry: usize| entry as f32 / (TRANSFER_SIZE - 1) as f32;
    let layer = |density: f32| ends(transfer).filter(|&end| end <= density).count();
    let index = |density: f32| interpolate(transfer, density, |stop| Vec4::splat(stop.index)).x;
    let entry = |entry: usize| {
        let (low, high) = (at(entry.saturating_sub(1)), at((entry + 1).min(TRANSFER_SIZE - 1)));
        let middle = layer(at(entry));
        let (low, high) =
            (if layer(low) == middle { low } else { at(entry) }, if layer(high) == middle { high } else { at(entry) });
        let slope = if high > low { (index(high) - index(low)) / (high - low) } else { 0.0 };
        [index(at(entry)), slope, middle as f32, 0.0]
    };
    (0..TRANSFER_SIZE).flat_map(entry).collect()
}

/// Densities at which the index of refraction or its slope jumps.
fn ends(transfer: &Transfer) -> impl Iterator<Item = f32> + '_ {
    let between = |pair: &[Stop]| pair[0].index != pair[1].index;
    let jumps = move |pair: &[Stop]| between(pair) && (transfer.curve == Curve::Steps || pair[0].at == pair[1].at);
    let jumps = transfer.stops.windows(2).filter(move |pair| jumps(pair)).map(|pair| pair[1].at);
    let kinks = move |three: &[Stop]| transfer.curve == Curve::Linear && (between(three) || between(&three[1..]));
    jumps.chain(transfer.stops.windows(3).filter(move |three| kinks(three)).map(|three| three[1].at))
}

/// Interpolates a value of the stops by the transfer curve.
fn interpolate(transfer: &Transfer, density: f32, value: impl Fn(&Stop) -> Vec4) -> Vec4 {
    let stops = &transfer.stops;
    let above = stops.iter().position(|stop| stop.at > density);
    let (low, high) = match above {
        Some(0) => return value(&stops[0]),
        Some(index) => (index - 1, index),
        None => return stops.last().map(value).unwrap_or_default(),
    };
    if value(&stops[low]) == value(&stops[high]) {
        return value(&stops[low]); // exact, without the rounding of a curve
    }
    let t = (density - stops[low].at) / (stops[high].at - stops[low].at);
    match transfer.curve {
        Curve::Steps => value(&stops[low]),
        Curve::Linear => value(&stops[low]).lerp(value(&stops[high]), t),
        Curve::Spline => {
            let width = stops[high].at - stops[low].at;
            let (m0, m1) = (tangent(stops, low, &value) * width, tangent(stops, high, &value) * width);
            let (t2, t3) = (t * t, t * t * t);
            value(&stops[low]) * (2.0 * t3 - 3.0 * t2 + 1.0)
                + m0 * (t3 - 2.0 * t2 + t)
                + value(&stops[high]) * (3.0 * t2 - 2.0 * t3)
                + m1 * (t3 - t2)
        }
    }
}

/// Slope at a stop that keeps the cubic monotone: the harmonic mean of both sides, 0 at a turn or an end (Fritsch and
/// Butland 1984).
fn tangent(stops: &[Stop], index: usize, value: impl Fn(&Stop) -> Vec4) -> Vec4 {
    if index == 0 || index + 1 == stops.len() {
        return Vec4::ZERO;
    }
    let slope = |a: &Stop, b: &Stop| (value(b) - value(a)) / (b.at - a.at).max(1e-6);
    let (left, right) = (slope(&stops[index - 1], &stops[index]), slope(&stops[index], &stops[index + 1]));
    let mean = |l: f32, r: f32| if l * r > 0.0 { 2.0 * l * r / (l + r) } else { 0.0 };
    Vec4::new(mean(left.x, right.x), mean(left.y, right.y), mean(left.z, right.z), mean(left.w, right.w))
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::scene::Color;

    #[test]
    fn a_flat_transfer_map_has_one_texel() {
        let stop = |at, color| Stop { at, color, density: 0.3, index: 1.0 + at };
        let color = Color([200, 100, 60]);
        for curve in [Curve::Steps, Curve::Linear, Curve::Spline] {
            let mut transfer = Transfer { curve, stops: [0.0, 0.1, 0.45, 1.0].map(|at| stop(at, color)).into() };
            assert!(transfer.is_flat());
            let texels = transfer_map(&transfer);
            let first = transfer_texel(&transfer).map(|value| (value * 65535.0).round() as u16);
            assert!(texels.chunks(4).all(|texel| texel == first), "{curve:?}");
            transfer.stops[2].density = 0.31;
            assert!(!transfer.is_flat());
        }
    }

    pub(crate) fn ramp(curve: Curve) -> Transfer {
        let stop = |at, density| Stop { at, color: Color([255; 3]), density, index: 1.0 };
        Transfer { curve, stops: vec![stop(0.2, 0.0), stop(0.4, 1.0), stop(0.8, 0.25)] }
    }

    #[test]
    fn p23_steps_hold_and_splines_meet_stops_without_overshoot() {
        assert_eq!(evaluate(&ramp(Curve::Steps), 0.39).w, 0.0);
        assert_eq!(evaluate(&ramp(Curve::Steps), 0.41).w, 1.0);
        for curve in [Curve::Linear, Curve::Spline] {
            let map = ramp(curve);
            for (at, density) in [(0.0, 0.0), (0.2, 0.0), (0.4, 1.0), (0.8, 0.25), (1.0, 0.25)] {
                assert!((evaluate(&map, at).w - density).abs() < 1e-6);
            }
            let rising: Vec<f32> = (0..=20).map(|i| evaluate(&map, 0.2 + 0.01 * i as f32).w).collect();
            assert!(rising.windows(2).all(|pair| pair[0] <= pair[1] + 1e-6), "{curve:?}");
        }
    }

    #[test]
    fn p28_the_index_map_has_a_layer_between_any_two_jumps() {
        let stop = |at, index| Stop { at, color: Color([255; 3]), density: at, index };
        let row = |curve, stops: &[Stop]| index_map(&Transfer { curve, stops: stops.to_vec() });
        let entry = |row: &[f32], i: usize| [row[4 * i], row[4 * i + 1], row[4 * i + 2]];
        let steps = row(Curve::Steps, &[stop(0.0, 1.0), stop(0.25, 1.5), stop(0.75, 1.3)]);
        assert_eq!([100, 500, 1000].map(|i| entry(&steps, i)), [[1.0, 0.0, 0.0], [1.5, 0.0, 1.0], [1.3, 0.0, 2.0]]);
        let linear = row(Curve::Linear, &[stop(0.0, 1.0), stop(0.5, 1.2), stop(0.5, 1.4), stop(1.0, 1.4)]);
        for (i, expected) in
            [(100, [1.0 + 0.4 * 100.0 / 1023.0, 0.4, 0.0]), (511, [1.0 + 0.4 * 511.0 / 1023.0, 0.4, 0.0])]
        {
            let off =
                entry(&linear, i).iter().zip(expected).map(|(a, b): (&f32, f32)| (a - b).abs()).fold(0.0, f32::max);
            assert!(off < 1e-3, "{:?}", entry(&linear, i));
        }
        assert_eq!(entry(&linear, 512)[..2], [1.4, 0.0]);
        assert!(row(Curve::Spline, &[stop(0.0, 1.0), stop(1.0, 1.0)]).chunks(4).all(|e| e[..3] == [1.0, 0.0, 0.0]));
    }
}
