//! Iso-surface of a scalar volume.
//!
//! Invariant: the sign of [`Scalar::level`] changes exactly across [`Scalar::triangles`], since both use the same tetrahedra.
//! A layer far below the iso-value around the samples closes objects cut by the border, flat to a thousandth of a sample.

use super::grid::Local;
use super::tetra::{self, Triangle};
use glam::DVec3;
use hypertexture_shape::{Axes, Volume};
use rayon::prelude::*;

/// Depth of the layer around the volume, over the largest difference to the iso-value. Lower makes caps wavy; higher
/// degenerates them to slivers.
const BORDER: f64 = 1.0e3;

/// A scalar volume minus its iso-value, with one outside layer around it.
pub(super) struct Scalar<'a> {
    volume: &'a Volume,
    axes: Axes,
    iso: f64,
    border: f64,
}

impl<'a> Scalar<'a> {
    /// A volume with the range of its values.
    pub(super) fn new(volume: &'a Volume, iso: f32, range: (f32, f32)) -> Scalar<'a> {
        let iso = f64::from(iso);
        let spread = (f64::from(range.1) - iso).abs().max((f64::from(range.0) - iso).abs());
        Scalar { volume, axes: volume.axes(), iso, border: -BORDER * spread }
    }

    /// Triangles of the surface in voxel units of `local`.
    pub(super) fn triangles(&self, local: &Local) -> Vec<Triangle> {
        let [nx, ny, nz] = self.volume.size.map(i64::from);
        let slabs = (-1..nz).into_par_iter().map(|z| {
            let mut triangles = Vec::new();
            for y in -1..ny {
                for x in -1..nx {
                    let values = self.cell([x, y, z]);
                    let outside = values.iter().filter(|&&v| v < 0.0).count();
                    if outside == 0 || outside == 8 {
                        continue;
                    }
                    let cell = DVec3::new(x as f64, y as f64, z as f64);
                    let place = |edge| local.of_f64(self.axes.world(cell + tetra::crossing(&values, edge)));
                    let is_inside = |corner: usize| values[corner] >= 0.0;
                    tetra::march(is_inside, |_| true, |triangle| triangles.push(triangle.map(place)));
                }
            }
            triangles
        });
        slabs.collect::<Vec<_>>().concat()
    }

    /// Value minus iso-value at a world position; the border's beyond the volume.
    pub(super) fn level(&self, world: DVec3) -> f64 {
        let at = self.axes.index(world);
        let size = DVec3::from_array(self.volume.size.map(f64::from));
        if !(at.cmpgt(DVec3::splat(-1.0)).all() && at.cmplt(size).all()) {
            return self.border;
        }
        let cell = at.floor();
        let values = self.cell([cell.x as i64, cell.y as i64, cell.z as i64]);
        tetra::interpolate(&values, at - cell)
    }

    /// Values at the corners of the cell from sample `at` to the next on each axis; `at` from -1 to size - 1.
    fn cell(&self, at: [i64; 3]) -> [f64; 8] {
        let size = self.volume.size.map(i64::from);
        std::array::from_fn(|i| {
            let corner = tetra::corner(i);
            let [x, y, z] = std::array::from_fn(|axis| at[axis] + corner[axis] as i64);
            if x < 0 || y < 0 || z < 0 || x >= size[0] || y >= size[1] || z >= size[2] {
                return self.border;
            }
            let index = (z * size[1] + y) * size[0] + x;
            f64::from(self.volume.values[index as usize]) - self.iso
        })
    }
}
