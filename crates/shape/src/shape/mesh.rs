//! Triangle meshes.
//!
//! Invariant: cleaning removes only triangles of zero area, and moves distant meshes to where f32 resolves their corners.

use super::Bounds;
use super::paint::{Paint, Spot};
use foldhash::{HashMap, HashMapExt};
use glam::{DVec3, Vec3};

/// Most triangles of a mesh: a binary STL file of 2.5 GB.
pub const MAX_TRIANGLES: u64 = 50_000_000;
/// Largest distance from the origin without an offset, in longest sides of the box: f32 then resolves 2^19 steps of the box.
const FAR: f64 = 16.0;

/// A triangle mesh in world units.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Vertex positions, finite.
    pub positions: Vec<Vec3>,
    /// Corner indices into `positions`, all in range; triangles of zero area have been dropped.
    pub triangles: Vec<[u32; 3]>,
    /// Color of each vertex, linear RGB; empty for a mesh without.
    pub colors: Vec<[f32; 3]>,
    /// Colors and textures of its materials, if they were asked for.
    pub paint: Paint,
    /// Offset subtracted from the coordinates of the file before they became f32.
    ///
    /// Zero on each axis along which the mesh reaches at most 16 times the longest side of its box from the origin. On the
    /// others the middle of the box, rounded so that differences of 32-bit floats are exact.
    pub offset: DVec3,
}

/// Edge statistics of a mesh.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edges {
    /// Distinct positions that triangles use.
    pub vertices: usize,
    /// Connected components.
    pub bodies: usize,
    /// Edges of one triangle (boundary).
    pub open: usize,
    /// Edges of more than two triangles (non-manifold).
    pub crowded: usize,
    /// Edges of two triangles with opposite orientations.
    pub turned: usize,
}

impl Mesh {
    /// Bounds of the positions, relative to `offset`. A mesh without positions gives the origin.
    pub fn bounds(&self) -> Bounds {
        Bounds::around(&self.positions).unwrap_or(Bounds { min: Vec3::ZERO, max: Vec3::ZERO })
    }

    /// The corners of triangle `index`, in winding order: counterclockwise seen from outside.
    ///
    /// Panics where `index` is not below `triangles.len()`.
    pub fn corners(&self, index: usize) -> [Vec3; 3] {
        self.triangles[index].map(|corner| self.positions[corner as usize])
    }

    /// The mesh with all coordinates times a factor above 0.
    pub fn scaled(mut self, factor: f64) -> Mesh {
        if factor != 1.0 {
            self.positions.iter_mut().for_each(|place| *place = (place.as_dvec3() * factor).as_vec3());
            self.offset *= factor;
        }
        self
    }

    /// Whether its vertices have colors, or materials that were asked for.
    pub fn is_colored(&self) -> bool {
        !self.colors.is_empty() || !self.paint.spots.is_empty()
    }

    /// Linear RGB of each vertex, materials and textures included; white where a material gives none. Empty without colors.
    pub fn vertex_colors(&self) -> Vec<[f32; 3]> {
        if self.paint.spots.len() != self.positions.len() {
            return self.colors.clone();
        }
        let color = |(index, own): (usize, &[f32; 3])| {
            let painted = self.paint.color([index as u32; 3], |[a, ..]: [f32; 3]| a).unwrap_or([1.0; 3]);
            [0, 1, 2].map(|channel| own[channel] * painted[channel])
        };
        let white = vec![[1.0; 3]; if self.colors.is_empty() { self.positions.len() } else { 0 }];
        self.colors.iter().chain(&white).enumerate().map(color).collect()
    }

    /// Points of its triangles with their colors, at most `spacing` apart, world units; none without colors. The color of a
    /// material is a factor of those of vertices.
    pub fn colored_points(&self, spacing: f32) -> impl Iterator<Item = (Vec3, [f32; 3])> + '_ {
        let [has_colors, is_painted] =
            [self.colors.len(), self.paint.spots.len()].map(|count| count == self.positions.len());
        let colored = self.triangles.iter().enumerate().filter(move |_| has_colors || is_painted);
        colored.flat_map(move |(index, triangle)| {
            let corners @ [a, b, c] = self.corners(index);
            let longest = (b - a).length().max((c - b).length()).max((a - c).length());
            let steps = (longest / spacing).ceil().clamp(1.0, 4096.0) as u32;
            let colors = has_colors.then(|| triangle.map(|corner| Vec3::from(self.colors[corner as usize])));
            let pairs = (0..=steps).flat_map(move |u| (0..=steps - u).map(move |v| [u, v]));
            pairs.filter_map(move |pair| {
                let [u, v] = pair.map(|part| part as f32 / steps as f32);
                let mix = |[a, b, c]: [Vec3; 3]| a + (b - a) * u + (c - a) * v;
                let mut color = colors.map_or(Vec3::ONE, mix);
                if is_painted {
                    let painted = self.paint.color(*triangle, |[a, b, c]| a + (b - a) * u + (c - a) * v)?;
                    color *= Vec3::from(painted);
                }
                Some((mix(corners), color.to_array()))
            })
        })
    }

    /// Edges used by exactly one triangle once vertices at equal positions are one vertex; 0 for a closed mesh.
    ///
    /// Equal means equal numbers, without a tolerance; 0 and -0 are equal. Time and memory grow as the triangles.
    pub fn open_edges(&self) -> usize {
        self.edges().open
    }

    /// Edge statistics after vertices at equal positions are welded.
    pub fn edges(&self) -> Edges {
        let (distinct, welded) = weld(&self.positions);
        // Uses of each edge, forwards and backwards.
        let mut uses: HashMap<(u32, u32), [u32; 2]> = HashMap::with_capacity(self.triangles.len() * 3 / 2);
        let triangles: Vec<[u32; 3]> = self.triangles.iter().map(|t| t.map(|corner| welded[corner as usize])).collect();
        for [a, b, c] in &triangles {
            for (a, b) in [(a, b), (b, c), (c, a)] {
                uses.entry((*a.min(b), *a.max(b))).or_default()[usize::from(a > b)] += 1;
            }
        }
        let mut bodies = Components::of(&triangles, distinct.len());
        let count = |is: fn(&[u32; 2]) -> bool| uses.values().filter(|uses| is(uses)).count();
        let mut used: Vec<bool> = vec![false; distinct.len()];
        triangles.as_flattened().iter().for_each(|corner| used[*corner as usize] = true);
        Edges {
            vertices: used.iter().filter(|used| **used).count(),
            bodies: (0..distinct.len()).filter(|at| used[*at] && bodies.root(*at as u32) == *at as u32).count(),
            open: count(|uses| uses[0] + uses[1] == 1),
            crowded: count(|uses| uses[0] + uses[1] > 2),
            turned: count(|uses| uses[0] + uses[1] == 2 && uses[0] != 1),
        }
    }

    /// Signed volume in cubic world units by the divergence theorem, in f64: positive for a closed mesh wound outward.
    ///
    /// For an open mesh the value depends on where the origin is and means little.
    pub fn signed_volume(&self) -> f64 {
        let volumes = (0..self.triangles.len()).map(|triangle| {
            let [a, b, c] = self.corners(triangle).map(Vec3::as_dvec3);
            a.dot(b.cross(c)) / 6.0
        });
        volumes.sum()
    }

    /// The mesh without triangles of zero area and without unused positions, and the number of dropped triangles.
    ///
    /// Positions become f32 relative to [`Mesh::offset`]. Every index must be below `positions.len()`.
    pub(crate) fn cleaned<P: Copy + Into<DVec3>>(positions: &[P], triangles: Vec<[u32; 3]>) -> (Mesh, usize) {
        Mesh::cleaned_with(positions, &[], &[], triangles)
    }

    /// [`Mesh::cleaned`] with the color and the spot of each position, or without them.
    pub(crate) fn cleaned_with<P: Copy + Into<DVec3>>(
        positions: &[P],
        colors: &[[f32; 3]],
        spots: &[Spot],
        mut triangles: Vec<[u32; 3]>,
    ) -> (Mesh, usize) {
        const UNUSED: u32 = u32::MAX;
        let before = triangles.len();
        let place = |corner: u32| -> DVec3 { positions[corner as usize].into() };
        let offset = offset(triangles.as_flattened().iter().map(|&corner| place(corner)));
        let near = |corner: u32| (place(corner) - offset).as_vec3();
        triangles.retain(|triangle| {
            let [a, b, c] = triangle.map(|corner| near(corner).as_dvec3());
            (b - a).cross(c - a) != DVec3::ZERO
        });
        let mut renumbered = vec![UNUSED; positions.len()];
        let (mut kept, mut kept_colors, mut paint) =
            (Vec::with_capacity(positions.len()), Vec::new(), Paint::default());
        for corner in triangles.iter_mut().flatten() {
            let new = &mut renumbered[*corner as usize];
            if *new == UNUSED {
                *new = kept.len() as u32;
                kept.push(near(*corner));
                kept_colors.extend(colors.get(*corner as usize));
                paint.spots.extend(spots.get(*corner as usize));
            }
            *corner = *new;
        }
        kept.shrink_to_fit();
        let dropped = before - triangles.len();
        (Mesh { positions: kept, triangles, colors: kept_colors, paint, offset }, dropped)
    }

    /// The mesh of triangles given as three corners each; equal corners are welded.
    pub(crate) fn of_corners<P: Copy + Into<DVec3>>(corners: &[P]) -> (Mesh, usize) {
        let (positions, indices) = weld(corners);
        Mesh::cleaned(&positions, indices.as_chunks::<3>().0.to_vec())
    }
}

/// Connected components of vertices, as a union-find forest.
pub(super) struct Components(Vec<u32>);

impl Components {
    /// Components of triangles over `vertices` vertices.
    pub(crate) fn of(triangles: &[[u32; 3]], vertices: usize) -> Components {
        let mut bodies = Components((0..vertices as u32).collect());
        for [a, b, c] in triangles {
            for (a, b) in [(a, b), (b, c)] {
                let (a, b) = (bodies.root(*a), bodies.root(*b));
                bodies.0[a.max(b) as usize] = a.min(b);
            }
        }
        bodies
    }

    /// Representative of a component: its lowest vertex.
    pub(crate) fn root(&mut self, mut at: u32) -> u32 {
        while self.0[at as usize] != at {
            self.0[at as usize] = self.0[self.0[at as usize] as usize];
            at = self.0[at as usize];
        }
        at
    }
}

/// Offset of a mesh: on each axis along which the box of `corners` reaches more than [`FAR`] times its longest side from the
/// origin, its middle, rounded to a multiple of a power of two of about that side.
///
/// f32 coordinates there differ from the offset by a multiple of their last digit, so the difference is exact.
fn offset(corners: impl Iterator<Item = DVec3>) -> DVec3 {
    let nothing = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (min, max) = corners.fold(nothing, |(min, max), corner| (min.min(corner), max.max(corner)));
    let (longest, far) = ((max - min).max_element(), min.abs().max(max.abs()));
    if longest.is_nan() || longest <= 0.0 {
        return DVec3::ZERO;
    }
    // Clears the fraction bits: a power of two.
    let step = f64::from_bits(longest.max(far.max_element() * f64::EPSILON).to_bits() & f64::INFINITY.to_bits());
    let middle = (0.5 * (min + max) / step).round() * step;
    DVec3::select(far.cmpgt(DVec3::splat(FAR * longest)), middle, DVec3::ZERO)
}

/// Distinct positions in order of first use, and the index of each position among them.
pub(super) fn weld<P: Copy + Into<DVec3>>(positions: &[P]) -> (Vec<P>, Vec<u32>) {
    let mut distinct = Vec::new();
    let mut seen = HashMap::with_capacity(positions.len() / 4);
    let indices = positions.iter().map(|position| {
        // Adding zero turns -0 into 0, so that equal numbers have equal bits.
        let bits = (*position).into().to_array().map(|x| (x + 0.0).to_bits());
        *seen.entry(bits).or_insert_with(|| {
            distinct.push(*position);
            distinct.len() as u32 - 1
        })
    });
    let indices = indices.collect();
    (distinct, indices)
}

/// Corners of the triangles of a parametric surface over `nu` x `nv` cells; counterclockwise seen from the side of
/// dP/du x dP/dv. `point` takes the grid indices 0..=nu and 0..=nv.
pub(crate) fn tessellate(nu: usize, nv: usize, point: impl Fn(usize, usize) -> Vec3) -> Vec<Vec3> {
    let rows: Vec<Vec<Vec3>> = (0..=nu).map(|u| (0..=nv).map(|v| point(u, v)).collect()).collect();
    let cells = (0..nu).flat_map(|u| (0..nv).map(move |v| (u, v)));
    let corners = cells.flat_map(|(u, v)| {
        let [a, b, c, d] = [rows[u][v], rows[u + 1][v], rows[u + 1][v + 1], rows[u][v + 1]];
        [a, b, c, a, c, d]
    });
    corners.collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> Mesh {
        Mesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            ..Mesh::default()
        }
    }

    #[test]
    fn bodies_turned_and_crowded_edges_are_counted() {
        let edges = square().edges();
        assert_eq!(edges, Edges { vertices: 4, bodies: 1, open: 4, crowded: 0, turned: 0 });
        let mut turned = square();
        turned.triangles[1].reverse();
        assert_eq!(turned.edges().turned, 1);
        let mut fin = square();
        fin.positions.extend([Vec3::Z, Vec3::splat(9.0), Vec3::splat(8.0), Vec3::new(7.0, 8.0, 9.0)]);
        fin.triangles.extend([[0, 2, 4], [5, 6, 7]]); // one on the diagonal, and one far away
        assert_eq!(fin.edges(), Edges { vertices: 8, bodies: 2, open: 9, crowded: 1, turned: 0 });
    }

    #[test]
    fn open_edges_are_counted_after_equal_positions_are_welded() {
        let mesh = square();
        let split: Vec<Vec3> = (0..2).flat_map(|triangle| mesh.corners(triangle)).collect();
        let split = Mesh { positions: split, triangles: vec![[0, 1, 2], [3, 4, 5]], ..Mesh::default() };
        assert_eq!(split.open_edges(), 4);
    }

    #[test]
    fn zero_and_minus_zero_are_the_same_position() {
        let mut mesh = square();
        mesh.positions.push(Vec3::new(-0.0, 0.0, -0.0));
        mesh.triangles[1][0] = 4;
        assert_eq!(mesh.open_edges(), 4);
    }

    #[test]
    fn cleaning_drops_flat_triangles_and_unused_positions_only() {
        let mut mesh = square();
        mesh.positions.insert(0, Vec3::splat(9.0));
        let mut triangles: Vec<_> = mesh.triangles.iter().map(|t| t.map(|corner| corner + 1)).collect();
        triangles.push([1, 1, 2]);
        triangles.push([1, 2, 2]);
        let (cleaned, dropped) = Mesh::cleaned(&mesh.positions, triangles);
        assert_eq!((cleaned.positions.len(), cleaned.triangles.len(), dropped), (4, 2, 2));
        assert_eq!(cleaned.bounds(), square().bounds());
    }
}
