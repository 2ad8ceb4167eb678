//! Iso-values worth looking at, found in the values of a volume.
//!
//! Role: between two materials the values change within a few voxels, inside of one they hardly do; so the mean gradient of
//! the voxels of a value is large where that value is a boundary. Its peaks are proposed. Invariant: the same values give the
//! same proposals, in whatever units they are. Source: V. Pekar, R. Wiemker, D. Hempel, "Fast detection of meaningful
//! isosurfaces for volume data visualization", IEEE Visualization 2001.

use super::Volume;
use rayon::prelude::*;

/// Parts of the range of values. Fewer: boundaries merge. More: each has too few voxels to tell its mean.
const BINS: usize = 64;
/// Of the voxels, how many are above the range that is looked at: a few voxels of metal leave no room for all else.
const ABOVE: f64 = 5e-4;
/// Times that the curve is smoothed by 1 4 6 4 1.
const SMOOTHINGS: usize = 2;
/// How far a peak stands out of the curve on both sides, as a part of the highest peak. Smaller: waves of the curve are taken
/// for boundaries; larger: bone inside of tissue is none.
const PROMINENCE: f64 = 0.12;
/// Most proposals.
const MOST: usize = 4;
/// Voxels that are looked at, about: every so many-th row of a larger volume.
const VOXELS: usize = 4 << 20;

/// What the values of a volume are.
#[derive(Clone, Debug, PartialEq)]
pub struct Histogram {
    /// The values at which the first bin begins and the last one ends.
    pub range: (f32, f32),
    /// Voxels in each part of the range, of those that were looked at.
    pub counts: Vec<u64>,
    /// Mean change of the value from a sample to the next, there.
    pub gradients: Vec<f64>,
}

impl Volume {
    /// The histogram of its values and of how much they change; none for fewer than 2 samples on a side or one value alone.
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
        // One sum for each of a fixed number of parts, added in order: not a bit depends on the number of threads.
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

    /// The value above which there are [`ABOVE`] of the voxels, about.
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

    /// Iso-values between materials, from the lowest; empty where the values have no boundary.
    pub fn iso_values(&self) -> Vec<f32> {
        self.histogram().map(|histogram| histogram.boundaries()).unwrap_or_default()
    }
}

impl Histogram {
    /// The values of the peaks of the mean gradient, from the lowest, at most 4; a peak at an end of the range is none.
    pub fn boundaries(&self) -> Vec<f32> {
        let curve = self.curve();
        let highest = curve.iter().copied().fold(0.0, f64::max);
        let mut peaks: Vec<(usize, f64)> = Vec::new();
        for bin in 1..BINS - 1 {
            let is_peak = curve[bin] > curve[bin - 1] && curve[bin] >= curve[bin + 1];
            // How low the curve gets on each side before it is higher than here, or ends.
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
        peaks.truncate(MOST);
        peaks.sort_by_key(|(bin, _)| *bin);
        let (low, high) = (f64::from(self.range.0), f64::from(self.range.1));
        let value = |bin: usize| low + (bin as f64 + 0.5) * (high - low) / BINS as f64;
        peaks.into_iter().map(|(bin, _)| rounded(value(bin), (high - low) / BINS as f64)).collect()
    }

    /// The mean gradients without their noise; where there are no voxels, between those that there are.
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

/// The shortest decimal within half a `step` of a value: a person reads 780, not 777.3421.
fn rounded(value: f64, step: f64) -> f32 {
    let decade = 10f64.powi(step.log10().floor() as i32);
    ((value / decade).round() * decade) as f32
}

#[cfg(test)]
mod tests {
    use super::super::Content;
    use super::*;
    use glam::{Mat3, Vec3};

    /// Three materials in shells, blurred over two voxels, with noise of `noise`: of values 20, 1000 and 1800.
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
