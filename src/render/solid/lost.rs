//! Samples that a mesh puts on the wrong side.
//!
//! Role: a ball of matter, or of a gap, whose diameter is the diagonal of a cell holds a sample. If the mesh puts each sample
//! on its side, or passes within a distance of it, no such ball is without the mesh. The sides of the mesh are counted by
//! its crossings of the lines of samples along z, which the construction of the mesh does not use.

use super::tree::Tree;
use crate::render::density::{Lattice, Signs};
use glam::DVec3;
use rayon::prelude::*;

/// Offset of the lines from the samples along x and y, in steps, so that they meet no corner of a mesh on the grid.
const OFF: [f64; 2] = [3.7e-4, 6.1e-4];

/// The samples of the grid farther than `distance` from the mesh, and on its other side.
pub(super) fn lost_samples(tree: &Tree, signs: &Signs, lattice: &Lattice, distance: f64) -> Vec<DVec3> {
    let columns = columns(tree, lattice);
    let lost = signs.samples().filter(|(at, is_inside)| {
        let below = columns.below(lattice, *at);
        (below % 2 == 1) != *is_inside && tree.distance(lattice.place(*at), distance).is_none()
    });
    lost.map(|(at, _)| lattice.place(at)).collect()
}

/// Crossings of the lines of samples along z, by line and height.
struct Columns(Vec<(u32, f32)>);

impl Columns {
    /// Crossings of a line below a sample.
    fn below(&self, lattice: &Lattice, [x, y, z]: [u32; 3]) -> usize {
        let line = y * lattice.size[0] + x;
        let of_line = &self.0[self.0.partition_point(|(other, _)| *other < line)..];
        of_line.iter().take_while(|(other, height)| *other == line && *height < z as f32).count()
    }
}

fn columns(tree: &Tree, lattice: &Lattice) -> Columns {
    let crossings = (0..tree.len() as u32).into_par_iter().flat_map_iter(|number| {
        let corners = tree.corners(number).map(|corner| (corner - lattice.low) / lattice.step);
        let [a, b, c] = corners.map(|corner| corner.truncate() - glam::DVec2::from(OFF));
        let low = a.min(b).min(c).ceil().max(glam::DVec2::ZERO);
        let high = a.max(b).max(c).floor();
        let area = (b - a).perp_dot(c - a);
        let lines = (low.y as u32..=high.y.max(-1.0) as u32)
            .flat_map(move |y| (low.x as u32..=high.x.max(-1.0) as u32).map(move |x| [x, y]));
        lines.filter_map(move |[x, y]| {
            let at = glam::DVec2::new(x.into(), y.into());
            let parts = [(b - at).perp_dot(c - at), (c - at).perp_dot(a - at), (a - at).perp_dot(b - at)];
            let is_within = parts.iter().all(|part| *part > 0.0) || parts.iter().all(|part| *part < 0.0);
            let height = (0..3).map(|corner| parts[corner] / area * corners[corner].z).sum::<f64>();
            is_within.then_some((y * lattice.size[0] + x, height as f32))
        })
    });
    let mut all: Vec<(u32, f32)> = crossings.collect();
    all.par_sort_unstable_by(|a, b| a.0.cmp(&b.0).then(a.1.total_cmp(&b.1)));
    Columns(all)
}
