//! Sample grids, and fields read at and between samples.

use super::error::FieldError;
use super::request::Request;
use glam::{DVec3, Mat3, Vec3};
use hypertexture_shape::{Bounds, Content, Volume};
use rayon::prelude::*;

/// A regular grid of samples in world space: x fastest, then y, then z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Samples per axis: at least 2 if chosen by [`Grid::covering`], at least 1 in a volume of signed distances.
    pub size: [u32; 3],
    /// World position of sample (0, 0, 0).
    pub origin: Vec3,
    /// Positive world distance between neighboring samples, by axis. Equal on all axes if chosen by [`Grid::covering`].
    pub spacing: Vec3,
}

/// Signed distance to a surface on a [`Grid`]: positive outside, negative inside, world units.
#[derive(Clone, Debug, PartialEq)]
pub struct DistanceField {
    /// The samples' grid.
    pub grid: Grid,
    /// Finite value of each sample.
    pub values: Vec<f32>,
}

/// Conversion between world positions and voxel units of a grid, in f64 before rounding.
pub(super) struct Local {
    origin: DVec3,
    spacing: DVec3,
}

impl Local {
    pub(super) fn new(grid: &Grid) -> Local {
        Local { origin: grid.origin.as_dvec3(), spacing: grid.spacing.as_dvec3() }
    }

    /// A world position in voxels.
    pub(super) fn of_world(&self, p: Vec3) -> Vec3 {
        self.of_f64(p.as_dvec3())
    }

    /// A world position in voxels.
    pub(super) fn of_f64(&self, p: DVec3) -> Vec3 {
        ((p - self.origin) / self.spacing).as_vec3()
    }

    /// World position of a voxel.
    pub(super) fn world(&self, voxel: [usize; 3]) -> DVec3 {
        self.origin + DVec3::from_array(voxel.map(|c| c as f64)) * self.spacing
    }
}

impl Grid {
    /// The grid of cubic voxels around `bounds` with their margin: centered, `resolution` samples along the longest side, as
    /// many as needed along the others, at least 2.
    ///
    /// # Errors
    /// [`FieldError::Resolution`], [`FieldError::Length`] or [`FieldError::Extent`].
    pub fn covering(bounds: &Bounds, request: &Request) -> Result<Grid, FieldError> {
        if !(8..=1024).contains(&request.resolution) {
            return Err(FieldError::Resolution { resolution: request.resolution });
        }
        for (name, value) in [("shell", request.shell), ("margin", request.margin), ("band", request.band)] {
            if !value.is_finite() || value < 0.0 {
                return Err(FieldError::Length { name, value });
            }
        }
        let (min, max) = (bounds.min.as_dvec3(), bounds.max.as_dvec3());
        let sides = max - min + 2.0 * f64::from(request.margin);
        let spacing = (sides.max_element() / f64::from(request.resolution - 1)) as f32;
        // A side that is a whole number of voxels must not gain a sample by rounding.
        let cells = (sides / f64::from(spacing) - 1.0e-4).ceil().max(DVec3::ONE);
        let origin = (0.5 * (min + max) - 0.5 * cells * f64::from(spacing)).as_vec3();
        let grid = Grid { size: cells.to_array().map(|n| n as u32 + 1), origin, spacing: Vec3::splat(spacing) };
        let far = grid.position(grid.size[0] - 1, grid.size[1] - 1, grid.size[2] - 1);
        let magnitude = origin.abs().max(far.abs()).max_element();
        // Positions must tell neighboring samples apart with some bits to spare, and the diagonal must stay finite.
        if !(spacing.is_normal() && (8.0 * magnitude).is_finite() && spacing > magnitude * 1.0e-6) {
            return Err(FieldError::Extent { side: sides.max_element(), magnitude });
        }
        Ok(grid)
    }

    /// Number of samples.
    pub fn samples(&self) -> u64 {
        self.size.iter().map(|&n| u64::from(n)).product()
    }

    /// World position of sample (i, j, k).
    pub fn position(&self, i: u32, j: u32, k: u32) -> Vec3 {
        self.origin + Vec3::new(i as f32, j as f32, k as f32) * self.spacing
    }

    /// Samples per axis, for indexing.
    pub(super) fn size(&self) -> [usize; 3] {
        self.size.map(|n| n as usize)
    }
}

impl DistanceField {
    /// The field scaled by `by`.
    pub(super) fn scaled(self, by: f32) -> DistanceField {
        let Grid { size, origin, spacing } = self.grid;
        let grid = Grid { size, origin: by * origin, spacing: by * spacing };
        DistanceField { grid, values: self.values.into_iter().map(|value| by * value).collect() }
    }

    /// Value of sample (i, j, k), in world units.
    ///
    /// # Panics
    /// Where an index is not below `grid.size`.
    pub fn value(&self, i: u32, j: u32, k: u32) -> f32 {
        self.values[self.index([i, j, k])]
    }

    /// Trilinear interpolation at a world position clamped to the grid; NaN at NaN.
    ///
    /// Error besides that of the samples: half the square of the spacing times the curvature of the surface.
    pub fn sample(&self, p: Vec3) -> f32 {
        if p.is_nan() {
            return f32::NAN;
        }
        let last = Vec3::from_array(self.grid.size.map(|n| n as f32 - 1.0));
        let at = ((p - self.grid.origin) / self.grid.spacing).clamp(Vec3::ZERO, last);
        let low = at.floor().min((last - 1.0).max(Vec3::ZERO));
        let t = at - low;
        let [i, j, k] = low.to_array().map(|c| c as u32);
        let next = |c: u32, axis: usize| (c + 1).min(self.grid.size[axis] - 1);
        let [i1, j1, k1] = [next(i, 0), next(j, 1), next(k, 2)];
        let mix = |a: f32, b: f32, t: f32| a + t * (b - a);
        let row = |j, k| mix(self.value(i, j, k), self.value(i1, j, k), t.x);
        mix(mix(row(j, k), row(j1, k), t.y), mix(row(j, k1), row(j1, k1), t.y), t.z)
    }

    /// Smallest and largest value.
    pub fn range(&self) -> (f32, f32) {
        range(&self.values)
    }

    /// Gradient at sample (i, j, k) by central differences, one-sided at the borders, 0 along an axis of one sample. Its length
    /// is 1 in the band away from the medial axis, to second order in the spacing (first at the borders).
    ///
    /// # Panics
    /// Where an index is not below `grid.size`.
    pub fn gradient(&self, i: u32, j: u32, k: u32) -> Vec3 {
        let at = [i, j, k];
        Vec3::from_array(std::array::from_fn(|axis| {
            let (mut low, mut high) = (at, at);
            low[axis] = at[axis].saturating_sub(1);
            high[axis] = (at[axis] + 1).min(self.grid.size[axis] - 1);
            let steps = high[axis] - low[axis];
            if steps == 0 {
                return 0.0;
            }
            let rise = self.values[self.index(high)] - self.values[self.index(low)];
            rise / (steps as f32 * self.grid.spacing[axis])
        }))
    }

    /// [`DistanceField::gradient`] at every sample of the row (j, k), bit for bit, by component.
    ///
    /// # Panics
    /// Where an index is not below `grid.size`.
    pub fn gradients(&self, j: u32, k: u32) -> [Vec<f32>; 3] {
        let [nx, ny, nz] = self.grid.size;
        let row = |j: u32, k: u32| &self.values[self.index([0, j, k])..][..nx as usize];
        // The slope between two rows `length` apart; 0 for a single row.
        let rise = |low: &[f32], high: &[f32], length: f32| -> Vec<f32> {
            let rise = |(low, high): (&f32, &f32)| if length > 0.0 { (high - low) / length } else { 0.0 };
            low.iter().zip(high).map(rise).collect()
        };
        let sides = |at: u32, count: u32| [at.saturating_sub(1), (at + 1).min(count - 1)];
        let length = |[low, high]: [u32; 2], axis: usize| (high - low) as f32 * self.grid.spacing[axis];
        let (ys, zs, own) = (sides(j, ny), sides(k, nz), row(j, k));
        let [dy, dz] =
            [rise(row(ys[0], k), row(ys[1], k), length(ys, 1)), rise(row(j, zs[0]), row(j, zs[1]), length(zs, 2))];
        let inner = rise(&own[..own.len().saturating_sub(2)], &own[2.min(own.len())..], length([0, 2], 0));
        let dx = |i: u32| match sides(i, nx) {
            [low, high] if high - low == 2 => inner[low as usize],
            [low, high] if high > low => (own[high as usize] - own[low as usize]) / length([low, high], 0),
            _ => 0.0,
        };
        [(0..nx).map(dx).collect(), dy, dz]
    }

    /// The field with its axes permuted and reversed: for each new axis the old one, and whether it is reversed. Each old axis
    /// occurs once.
    pub fn turned(self, axes: [(usize, bool); 3]) -> DistanceField {
        if is_identity(axes) {
            return self;
        }
        let (grid, values) = turned(&self.grid, &self.values, axes);
        DistanceField { grid, values }
    }

    /// Converts to a volume of [`Content::SignedDistance`].
    pub fn into_volume(self) -> Volume {
        Volume {
            size: self.grid.size,
            origin: self.grid.origin,
            steps: Mat3::from_diagonal(self.grid.spacing),
            values: self.values,
            content: Content::SignedDistance,
        }
    }

    /// Converts from a volume of [`Content::SignedDistance`].
    ///
    /// # Errors
    /// [`FieldError::Content`] for other content, [`FieldError::Samples`] if size and values disagree, [`FieldError::Oblique`] if
    /// the grid is not axis-aligned.
    pub fn from_volume(volume: &Volume) -> Result<DistanceField, FieldError> {
        if volume.content != Content::SignedDistance {
            return Err(FieldError::Content);
        }
        check_samples(volume)?;
        if !volume.is_aligned() {
            return Err(FieldError::Oblique);
        }
        let grid = Grid { size: volume.size, origin: volume.origin, spacing: volume.spacing() };
        Ok(DistanceField { grid, values: volume.values.clone() })
    }

    fn index(&self, [i, j, k]: [u32; 3]) -> usize {
        let [nx, ny, nz] = self.grid.size;
        assert!(i < nx && j < ny && k < nz, "sample ({i}, {j}, {k}) of a grid of {nx} x {ny} x {nz}");
        (k as usize * ny as usize + j as usize) * nx as usize + i as usize
    }
}

/// Whether a permutation of axes changes nothing.
pub(super) fn is_identity(axes: [(usize, bool); 3]) -> bool {
    axes == [(0, false), (1, false), (2, false)]
}

/// A grid and its samples with permuted axes: see [`DistanceField::turned`].
pub(super) fn turned<T: Copy>(from: &Grid, samples: &[T], axes: [(usize, bool); 3]) -> (Grid, Vec<T>) {
    let to = |vector: Vec3| Vec3::from(axes.map(|(axis, _)| vector[axis]));
    let size = axes.map(|(axis, _)| from.size[axis]);
    let far = from.position(from.size[0] - 1, from.size[1] - 1, from.size[2] - 1);
    let origin = Vec3::from(axes.map(|(axis, reversed)| if reversed { -far[axis] } else { from.origin[axis] }));
    let strides = [1, from.size[0] as usize, from.size[0] as usize * from.size[1] as usize];
    let old = |axis: usize, index: usize| {
        let (source, reversed) = axes[axis];
        strides[source] * if reversed { from.size[source] as usize - 1 - index } else { index }
    };
    let [nx, ny, nz] = size.map(|side| side as usize);
    let mut turned = Vec::with_capacity(samples.len());
    for k in 0..nz {
        for j in 0..ny {
            turned.extend((0..nx).map(|i| samples[old(0, i) + old(1, j) + old(2, k)]));
        }
    }
    (Grid { size, origin, spacing: to(from.spacing) }, turned)
}

/// Checks that the number of values matches the size.
pub(super) fn check_samples(volume: &Volume) -> Result<(), FieldError> {
    let expected = volume.size.iter().try_fold(1u64, |a, &n| a.checked_mul(u64::from(n))).unwrap_or(u64::MAX);
    let found = volume.values.len() as u64;
    if expected == 0 || expected != found {
        return Err(FieldError::Samples { size: volume.size, expected, found });
    }
    Ok(())
}

/// Smallest and largest value.
pub(super) fn range(values: &[f32]) -> (f32, f32) {
    let none = || (f32::INFINITY, f32::NEG_INFINITY);
    let both = |a: (f32, f32), b: (f32, f32)| (a.0.min(b.0), a.1.max(b.1));
    values.par_iter().fold(none, |a, &v| both(a, (v, v))).reduce(none, both)
}
