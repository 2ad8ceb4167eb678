//! The surface between inside and outside samples of a grid, as a mesh.
//!
//! Role: the crossed edges and the triangles on them; the caller places the vertices on the edges. Invariant: the surface is
//! closed and consistently wound, whatever the number of threads.
//! Source: Doi & Koide 1991 (marching tetrahedra), by the tetrahedra of [`super::tetra`].

use super::tetra;
use rayon::prelude::*;

/// A closed surface on the edges of a grid.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LevelSet {
    /// The edge of each vertex: indices of a sample inside and of one outside, x fastest.
    pub edges: Vec<[u32; 2]>,
    /// Vertices of each triangle, counterclockwise as seen from outside.
    pub triangles: Vec<[u32; 3]>,
}

/// Cells along a side of a [`SignBlock`]: its 5^3 samples fit 128 bits.
pub const BLOCK: u32 = 4;

/// Signs of the samples of a cube of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct SignBlock {
    /// First sample on each axis.
    pub low: [u32; 3],
    /// Bit x + 5 y + 25 z is set where the sample at this distance from `low` is inside.
    pub inside: u128,
}

impl SignBlock {
    /// The bit of a sample by its distance from the first one, each from 0 to 4.
    pub fn bit([x, y, z]: [u32; 3]) -> u128 {
        1 << (x + (BLOCK + 1) * (y + (BLOCK + 1) * z))
    }

    /// Emits the triangles by their edges, outward.
    fn march(&self, mut emit: impl FnMut([[[u32; 3]; 2]; 3])) {
        if self.inside == 0 || self.inside == (1 << (BLOCK + 1).pow(3)) - 1 {
            return;
        }
        for cell in 0..BLOCK.pow(3) {
            let cell = [cell % BLOCK, cell / BLOCK % BLOCK, cell / BLOCK / BLOCK];
            let corner = |i: usize| {
                let step = tetra::corner(i);
                [0, 1, 2].map(|axis| cell[axis] + step[axis] as u32)
            };
            let inside: [bool; 8] = std::array::from_fn(|i| self.inside & SignBlock::bit(corner(i)) != 0);
            if inside == [inside[0]; 8] {
                continue;
            }
            let sample = |i: usize| {
                let at = corner(i);
                [0, 1, 2].map(|axis| self.low[axis] + at[axis])
            };
            let of_edge = |edge: tetra::Edge| edge.map(sample);
            tetra::march(|i| inside[i], |_| true, |triangle| emit(tetra::outward(triangle).map(of_edge)));
        }
    }
}

impl LevelSet {
    /// The surface in these blocks of a grid of fewer than 2^32 samples, without gaps if all samples at other blocks and at
    /// the border of the grid have the same side as their neighbors. Memory grows as the surface.
    pub fn of(size: [u32; 3], blocks: &[SignBlock]) -> LevelSet {
        let index = |at: [u32; 3]| u64::from((at[2] * size[1] + at[1]) * size[0] + at[0]);
        let of_block = |block: &SignBlock| {
            let mut found: Vec<[u64; 3]> = Vec::new();
            block.march(|triangle| found.push(triangle.map(|[inside, outside]| index(inside) << 32 | index(outside))));
            found
        };
        let found: Vec<[u64; 3]> = blocks.par_iter().flat_map_iter(of_block).collect();
        let mut keys: Vec<u64> = found.as_flattened().to_vec();
        keys.par_sort_unstable();
        keys.dedup();
        let vertex = |key: u64| keys.partition_point(|other| *other < key) as u32;
        let triangles = found.into_par_iter().map(|triangle| triangle.map(vertex)).collect();
        LevelSet { edges: keys.iter().map(|key| [(key >> 32) as u32, *key as u32]).collect(), triangles }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;
    use hypertexture_shape::Mesh;
    use hypertexture_support::random::SplitMix;

    /// The level set of a whole grid, whose border is outside.
    fn level_set(size: [u32; 3], is_inside: impl Fn(u32) -> bool) -> LevelSet {
        let is_inside = |at: [u32; 3]| {
            let is_within = (0..3).all(|axis| at[axis] > 0 && at[axis] + 1 < size[axis]);
            is_within && is_inside((at[2] * size[1] + at[1]) * size[0] + at[0])
        };
        let block = |low: [u32; 3]| {
            let samples = (0..125).map(|at| [at % 5, at / 5 % 5, at / 25]);
            let of = |at: [u32; 3]| is_inside([0, 1, 2].map(|axis| low[axis] + at[axis]));
            SignBlock { low, inside: samples.filter(|at| of(*at)).map(SignBlock::bit).sum() }
        };
        let lows = |side: u32| (0..side).step_by(BLOCK as usize);
        let all = lows(size[2]).flat_map(|z| lows(size[1]).flat_map(move |y| lows(size[0]).map(move |x| [x, y, z])));
        LevelSet::of(size, &all.map(block).collect::<Vec<_>>())
    }

    /// The mesh of a level set; `part` gives the place of a vertex on its edge, from the sample inside.
    fn mesh(size: [u32; 3], set: &LevelSet, part: impl Fn([Vec3; 2]) -> f32) -> Mesh {
        let place = |at: u32| {
            Vec3::new((at % size[0]) as f32, (at / size[0] % size[1]) as f32, (at / size[0] / size[1]) as f32)
        };
        let positions = set.edges.iter().map(|edge| {
            let ends = edge.map(place);
            ends[0].lerp(ends[1], part(ends))
        });
        Mesh { positions: positions.collect(), triangles: set.triangles.clone(), ..Mesh::default() }
    }

    #[test]
    fn any_samples_give_a_closed_surface_that_is_wound_outward() {
        let mut random = SplitMix(1991);
        for size in [[6, 5, 7], [3, 3, 3], [9, 4, 3]] {
            for _ in 0..40 {
                let count = size.iter().product::<u32>();
                let inside: Vec<bool> = (0..count).map(|_| random.bits().is_multiple_of(2)).collect();
                let set = level_set(size, |at| inside[at as usize]);
                let mesh = mesh(size, &set, |_| 0.4);
                let edges = mesh.edges();
                assert_eq!((edges.open, edges.crowded, edges.turned), (0, 0, 0), "{size:?}");
                assert!(set.edges.iter().all(|[a, b]| inside[*a as usize] && *a < count && *b < count));
                assert!(set.triangles.is_empty() || mesh.signed_volume() > 0.0);
            }
        }
    }

    #[test]
    fn a_ball_has_its_volume_and_one_body() {
        let (size, center, radius) = ([31; 3], Vec3::splat(15.2), 11.0_f32);
        let far = |p: Vec3| p.distance(center) - radius;
        let at = |index: u32| Vec3::new((index % 31) as f32, (index / 31 % 31) as f32, (index / 961) as f32);
        let set = level_set(size, |index| far(at(index)) <= 0.0);
        let mesh = mesh(size, &set, |[a, b]| far(a) / (far(a) - far(b)));
        let edges = mesh.edges();
        assert_eq!((edges.bodies, edges.open, edges.crowded, edges.turned), (1, 0, 0, 0));
        // Euler's formula of a surface without holes.
        assert_eq!(edges.vertices as i64 - set.triangles.len() as i64 / 2, 2);
        let exact = 4.0 / 3.0 * std::f64::consts::PI * f64::from(radius).powi(3);
        assert!((mesh.signed_volume() / exact - 1.0).abs() < 0.01, "{} {exact}", mesh.signed_volume());
    }

    #[test]
    fn a_grid_without_an_inside_has_no_surface() {
        for size in [[0; 3], [1, 1, 1], [2, 2, 2], [5, 2, 5]] {
            let set = level_set(size, |_| true);
            assert_eq!((set.edges.len(), set.triangles.len()), (0, 0), "{size:?}");
        }
    }
}
