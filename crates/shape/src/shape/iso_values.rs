//! Iso-values at material boundaries of a volume.
//!
//! Role: values change fast between two materials and slowly within one, so the mean gradient over the voxels of a value peaks
//! at boundaries. Invariant: proposals do not depend on the unit of the values. Source: V. Pekar, R. Wiemker, D. Hempel, "Fast
//! detection of meaningful isosurfaces for volume data visualization", IEEE Visualization 2001.

use super::Volume;
use rayon::prelude::*;

/// Bins of the histogram. Lower: boundaries merge. Higher: bins have too few voxels for a mean.
const BINS: usize = 64;
/// Part of the voxels above the range of the histogram. Without a cut, a few voxels of metal compress all other values.
const ABOVE: f64 = 5e-4;
/// Passes of the smoothing filter 1 4 6 4 1.
const SMOOTHINGS: usize = 2;
/// Least prominence of a peak relative to the highest one. Lower: noise passes for boundaries. Higher: bone inside of tissue is
/// missed.
const PROMINENCE: f64 = 0.12;
/// Most peaks of a histogram: the most prominent ones.
const MAX_PEAKS: usize = 4;
/// Approximate number of voxels sampled: rows of larger volumes are skipped.
const VOXELS: usize = 4 << 20;

/// Histogram of the values of a volume with mean gradients.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// Start of the first bin and end of the last one.
    pub range: (f32, f32),
    /// Sampled voxels in each bin.
    pub counts: Vec<u64>,
    /// Mean gradient in each bin, per sample.
    pub gradients: Vec<f64>,
}

impl Volume {
    /// Histogram of values and gradients; `None` for fewer than 2 samples on a side or a constant volume.
    pub fn histogram(&self) -> Option<Histogram> {
        let [nx, ny, nz] = self.size.map(|n| n as usize);
        let (low, high) = self.range();
        if self.size.iter().any(|n| *n < 2) || high <= low {
            return None;
        }
        let high = self.below_the_few(low, high);
        let every = self.values.len().div_ceil(VOXELS).max(1);
        let at = |x: usize, y: usize, z: usize| f64::from(self.values[(z * ny + y) * nx + x]);
        let rise = |near: f64, far: f64, steps: usize| (far - near) / steps as f64;
        let sides = |at: usize, count: usize| (at.saturating_sub(1), (at + 1).min(count - 1));
        let none = || ([0u64; BINS], [0.0f64; BINS]);
        let row = |mut bins: ([u64; BINS], [f64; BINS]), row: usize| {
            let (y, z) = (row % ny, row / ny);
            let ((y0, y1), (z0, z1)) = (sides(y, ny), sides(z, nz));
            for x in 0..nx {
                let (x0, x1) = sides(x, nx);
                let gradient = [
                    rise(at(x0, y, z), at(x1, y, z), x1 - x0),
                    rise(at(x, y0, z), at(x, y1, z), y1 - y0),
                    rise(at(x, y, z0), at(x, y, z1), z1 - z0),
                ];
                let part = (at(x, y, z) - f64::from(low)) / (f64::from(high) - f64::from(low));
                if part <= 1.0 {
                    let bin = ((part * BINS as f64) as usize).min(BINS - 1);
                    bins.0[bin] += 1;
                    bins.1[bin] += gradient.iter().map(|rise| rise * rise).sum::<f64>().sqrt();
                }
            }
            bins
        };
        // A fixed number of partial sums, added in order: the result does not depend on the number of threads.
        let rows: Vec<usize> = (0..ny * nz).step_by(every).collect();
        let parts: Vec<_> =
            rows.par_chunks(rows.len().div_ceil(64)).map(|rows| rows.iter().copied().fold(none(), row)).collect();
        let (counts, sums) = parts.into_iter().fold(none(), |(mut counts, mut sums), part| {
            counts.iter_mut().zip(part.0).for_each(|(all, own)| *all += own);
            sums.iter_mut().zip(part.1).for_each(|(all, own)| *all += own);
            (counts, sums)
        });
        let mean = |(count, sum): (&u64, f64)| sum / (*count).max(1) as f64;
        let gradients = counts.iter().zip(sums).map(mean).collect();
        Some(Histogram { range: (low, high), counts: counts.into(), gradients })
    }

    /// Value that a part [`ABOVE`] of the voxels exceeds, about.
    fn below_the_few(&self, low: f32, high: f32) -> f32 {
        const FINE: usize = 4096;
        let width = (f64::from(high) - f64::from(low)) / FINE as f64;
        let mut counts = [0u64; FINE];
        for value in &self.values {
            counts[(((f64::from(*value) - f64::from(low)) / width) as usize).min(FINE - 1)] += 1;
        }
        let few = (ABOVE * self.values.len() as f64) as u64;
        let mut above = 0;
        let kept = (1..FINE).rev().find(|bin| {
            above += counts[*bin];
            above > few
        });
        kept.map_or(high, |bin| (f64::from(low) + (bin + 1) as f64 * width) as f32).min(high)
    }

    /// Ascending iso-values between materials; empty without a boundary.
    pub fn iso_values(&self) -> Vec<f32> {
        self.histogram().map(|histogram| histogram.boundaries()).unwrap_or_default()
    }
}

impl Histogram {
    /// Ascending values of the peaks of the mean gradient, at most 4; the ends of the range do not count.
    pub(crate) fn boundaries(&self) -> Vec<f32> {
        let curve = self.curve();
        let highest = curve.iter().copied().fold(0.0, f64::max);
        let mut peaks: Vec<(usize, f64)> = Vec::new();
        for bin in 1..BINS - 1 {
            let is_peak = curve[bin] > curve[bin - 1] && curve[bin] >= curve[bin + 1];
            // Minimum of the curve on each side before it is higher than here, or ends.
            let depth = |side: &mut dyn Iterator<Item = &f64>| {
                side.take_while(|other| **other <= curve[bin]).copied().fold(curve[bin], f64::min)
            };
            let before = depth(&mut curve[..bin].iter().rev());
            let behind = depth(&mut curve[bin + 1..].iter());
            let prominence = curve[bin] - before.max(behind);
            if is_peak && prominence >= PROMINENCE * highest {
                peaks.push((bin, prominence));
            }
        }
        peaks.sort_by(|a, b| b.1.total_cmp(&a.1));
        peaks.truncate(MAX_PEAKS);
        peaks.sort_by_key(|(bin, _)| *bin);
        let (low, high) = (f64::from(self.range.0), f64::from(self.range.1));
        let value = |bin: usize| low + (bin as f64 + 0.5) * (high - low) / BINS as f64;
        peaks.into_iter().map(|(bin, _)| rounded(value(bin), (high - low) / BINS as f64)).collect()
    }

    /// Smoothed mean gradients; empty bins are interpolated.
    fn curve(&self) -> Vec<f64> {
        let mut curve = self.gradients.clone();
        let known: Vec<usize> = (0..BINS).filter(|bin| self.counts[*bin] > 0).collect();
        for pair in known.windows(2) {
            let (a, b) = (pair[0], pair[1]);
            for bin in a + 1..b {
                let part = (bin - a) as f64 / (b - a) as f64;
                curve[bin] = curve[a] + part * (curve[b] - curve[a]);
            }
        }
        for _ in 0..SMOOTHINGS {
            let at = |bin: usize, by: isize| curve[bin.saturating_add_signed(by).min(BINS - 1)];
            curve = (0..BINS)
                .map(|bin| (at(bin, -2) + 4.0 * at(bin, -1) + 6.0 * at(bin, 0) + 4.0 * at(bin, 1) + at(bin, 2)) / 16.0)
                .collect();
        }
        curve
    }
}

/// Shortest decimal within half a `step` of a value: 780 instead of 777.3421.
fn rounded(value: f64, step: f64) -> f32 {
    let decade = 10f64.powi(step.log10().floor() as i32);
    ((value / decade).round() * decade) as f32
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Content;
    use glam::{Mat3, Vec3};

    /// Shells of three materials with values 20, 1000 and 1800, blurred over two voxels, with noise.
    fn shells(noise: f32, scale: f32) -> Volume {
        let size = [48; 3];
        let (origin, spacing) = (Vec3::splat(-23.5), Vec3::ONE);
        let mut volume =
            Volume { size, origin, steps: Mat3::from_diagonal(spacing), values: Vec::new(), content: Content::Scalar };
        let mut state = 1u32;
        for index in 0..48 * 48 * 48 {
            let radius = volume.position([index % 48, index / 48 % 48, index / 2304]).length();
            let step = |at: f32| 0.5 - 0.5 * ((radius - at) / 1.2).clamp(-1.0, 1.0);
            state = state.wrapping_mul(1664525).wrapping_add(1013904223);
            let speckle = noise * (f32::from((state >> 16) as u16) / 32768.0 - 1.0);
            volume.values.push(scale * (20.0 + 980.0 * step(19.0) + 800.0 * step(11.0) + speckle));
        }
        volume
    }

    #[test]
    fn the_boundaries_of_materials_are_proposed_whatever_the_units() {
        for (noise, scale) in [(0.0, 1.0), (25.0, 1.0), (25.0, 1e-6), (10.0, 1e6)] {
            let found: Vec<f32> = shells(noise, scale).iso_values().iter().map(|value| value / scale).collect();
            let [outer, inner] = found[..] else { panic!("{noise} {scale}: {found:?}") };
            assert!((200.0..800.0).contains(&outer) && (1100.0..1700.0).contains(&inner), "{found:?}");
        }
    }

    #[test]
    fn a_volume_of_one_value_or_one_row_has_none() {
        let volume = shells(0.0, 1.0);
        assert!(Volume { values: vec![3.0; volume.values.len()], ..volume.clone() }.iso_values().is_empty());
        assert!(Volume { size: [48 * 48 * 48, 1, 1], ..volume }.iso_values().is_empty());
    }
}
