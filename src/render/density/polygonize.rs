//! Iso-surface of a scene's density as a closed mesh, for other programs to open, print or cut.
//!
//! Invariant: the density is that of the scene's program, evaluated by [`eval`](crate::eval) in f64, so that no formula
//! is written twice. Blocks of samples are skipped only if bounds prove their side of the surface.

use super::colors::colors;
use super::error::PolygonizeError;
use super::program::{Density, DensityProgram};
use crate::eval::ExactError;
use crate::field::{LevelSet, Progress};
use crate::render::subject::Subject;
use crate::render::variant::{Checkable, Variant};
use crate::scene::Object;
use crate::shader::Library;
use crate::shape::{Looks, Mesh};
use glam::{DVec3, Vec3};
use rayon::prelude::*;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Samples along a side of a block with common bounds. Lower: more bounds. Higher: looser bounds.
const BLOCK: u32 = 8;
/// Blocks and edges in a batch of a thread.
const BLOCKS: usize = 16;
const EDGES: usize = 1024;
/// Bisections of an edge: 2^-13 of an edge is below the resolution of f32.
const HALVINGS: u32 = 12;

/// Settings of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polygons {
    /// Samples along the longest side of the box around the soft region; 8 to 512.
    pub grid: u32,
    /// Density of the surface, above 0, up to 1; a hard object has 1 inside and 0 outside.
    pub density: f32,
}

/// First and last sample on each axis.
type Block = [[u32; 2]; 3];

/// Sample grid in object space.
struct Samples {
    size: [u32; 3],
    low: DVec3,
    step: f64,
}

impl Samples {
    /// Grid around a box, with one layer outside of it.
    fn around(low: DVec3, high: DVec3, grid: u32) -> Samples {
        let extent = high - low;
        let step = extent.max_element() / f64::from(grid - 3);
        let size = extent.to_array().map(|side| (side / step - 1e-9).ceil().max(1.0) as u32 + 3);
        let spare = DVec3::from_array(size.map(|side| f64::from(side - 1))) * step - extent;
        Samples { size, low: low - 0.5 * spare, step }
    }

    fn place(&self, at: [u32; 3]) -> DVec3 {
        self.low + self.step * DVec3::from_array(at.map(f64::from))
    }

    fn count(&self) -> usize {
        self.size.iter().map(|side| *side as usize).product()
    }

    fn index(&self, [x, y, z]: [u32; 3]) -> u32 {
        (z * self.size[1] + y) * self.size[0] + x
    }

    fn of_index(&self, index: u32) -> [u32; 3] {
        let [x, y, _] = self.size;
        [index % x, index / x % y, index / x / y]
    }

    /// Indices of the samples of a block.
    fn within(&self, [xs, ys, zs]: Block) -> impl Iterator<Item = u32> {
        let all = |[first, last]: [u32; 2]| first..=last;
        all(zs).flat_map(move |z| all(ys).flat_map(move |y| all(xs).map(move |x| self.index([x, y, z]))))
    }

    fn blocks(&self) -> Vec<Block> {
        let spans =
            self.size.map(|side| (0..side).step_by(BLOCK as usize).map(move |at| [at, (at + BLOCK).min(side) - 1]));
        let [xs, ys, zs] = spans.map(|span| span.collect::<Vec<_>>());
        zs.iter().flat_map(|z| ys.iter().flat_map(|y| xs.iter().map(|x| [*x, *y, *z]))).collect()
    }
}

/// Mesh of a scene at its first moment: closed, wound outward, in the world units and axes of its main object.
///
/// Vertices are exact to 2^-13 of the sample distance along an edge; thinner matter than that distance may be missed.
/// `progress` receives the finished share, from any thread.
///
/// # Errors
/// The scene has no program, one that [`eval`](crate::eval) does not cover, or no matter of this density; or a setting
/// is out of range.
pub fn polygonize(
    library: &Library,
    scene: &impl Checkable,
    subject: &Subject,
    polygons: Polygons,
    progress: Progress<'_>,
) -> Result<Mesh, PolygonizeError> {
    Ok(surface(library, &*scene.checked(library)?, subject, polygons, progress)?.0)
}

/// [`polygonize`] with the normals of the mesh, and the colors of the matter at its vertices, which are those of
/// [`VoxelLeaf`](crate::render::VoxelLeaf).
///
/// # Errors
/// As [`polygonize`].
pub fn polygonize_with_looks(
    library: &Library,
    scene: &impl Checkable,
    subject: &Subject,
    polygons: Polygons,
    progress: Progress<'_>,
) -> Result<(Mesh, Looks), PolygonizeError> {
    let variant = scene.checked(library)?;
    let (mesh, inside) = surface(library, &variant, subject, polygons, progress)?;
    let looks = Looks { normals: mesh.vertex_normals(), colors: colors(library, &variant, subject, &inside)? };
    Ok((mesh, looks))
}

/// The mesh, and the place of each vertex in object space, moved inside.
fn surface(
    library: &Library,
    variant: &Variant,
    subject: &Subject,
    polygons: Polygons,
    progress: Progress<'_>,
) -> Result<(Mesh, Vec<DVec3>), PolygonizeError> {
    let Polygons { grid, density } = polygons;
    if !(8..=512).contains(&grid) {
        return Err(PolygonizeError::Grid(grid));
    }
    if !(density > 0.0 && density <= 1.0) {
        return Err(PolygonizeError::Density(density));
    }
    let program = DensityProgram::of(library, variant, subject)?;
    let (density, view) = (program.bound(f64::from(density))?, &program.view);
    let samples = Samples::around(view.box_min.as_dvec3(), view.box_max.as_dvec3(), grid);

    let inside = inside(&density, &samples, &|done| progress(0.5 * done))?;
    let set = LevelSet::of(samples.size, |index| inside[index as usize]);
    let done = AtomicUsize::new(0);
    let chunks = set.edges.par_chunks(EDGES).map(|edges| {
        let found = crossings(&density, &samples, edges)?;
        let done = done.fetch_add(edges.len(), Ordering::Relaxed) + edges.len();
        progress(0.5 + 0.5 * done as f32 / set.edges.len() as f32);
        Ok(found)
    });
    let found: Vec<[DVec3; 2]> = chunks.collect::<Result<Vec<_>, ExactError>>()?.concat();
    let positions = found.iter().map(|[place, _]| world(subject, &variant.scene.object, *place)).collect();
    let mesh = Mesh { positions, triangles: set.triangles, offset: subject.offset, ..Mesh::default() };
    Ok((mesh, found.into_iter().map(|[_, inside]| inside).collect()))
}

/// Finds the samples inside the surface.
fn inside(density: &Density<'_>, samples: &Samples, progress: Progress<'_>) -> Result<Vec<bool>, PolygonizeError> {
    let blocks = samples.blocks();
    let (blocks_in_all, done) = (blocks.len() as f32, AtomicUsize::new(0));
    let decided = blocks.par_chunks(BLOCKS).map(|blocks| {
        let corners = |block: &Block| [0, 1].map(|end| samples.place(block.map(|span| span[end])));
        let sides = density.sides(&blocks.iter().map(corners).collect::<Vec<_>>())?;
        let open: Vec<u32> = (blocks.iter().zip(&sides).filter(|(_, side)| side.is_none()))
            .flat_map(|(block, _)| samples.within(*block))
            .collect();
        let places: Vec<DVec3> = open.iter().map(|index| samples.place(samples.of_index(*index))).collect();
        let densities = density.at(&places)?;
        progress((done.fetch_add(blocks.len(), Ordering::Relaxed) + blocks.len()) as f32 / blocks_in_all);
        let full = blocks.iter().zip(&sides).filter(|(_, side)| **side == Some(true));
        let full = full.flat_map(|(block, _)| samples.within(*block));
        let dense = open.iter().zip(&densities).filter(|(_, found)| **found >= density.level);
        let inside: Vec<u32> = full.chain(dense.map(|(index, _)| *index)).collect();
        Ok((inside, densities.into_iter().fold(0.0, f64::max)))
    });
    let decided: Vec<(Vec<u32>, f64)> = decided.collect::<Result<_, ExactError>>()?;
    if decided.iter().all(|(inside, _)| inside.is_empty()) {
        let largest = decided.iter().map(|(_, largest)| *largest).fold(0.0, f64::max);
        return Err(PolygonizeError::NoSurface { level: density.level, largest });
    }
    let mut inside = vec![false; samples.count()];
    decided.into_iter().flat_map(|(indices, _)| indices).for_each(|index| inside[index as usize] = true);
    Ok(inside)
}

/// Finds the crossings of edges by bisection, and the nearest places known to be inside, object space.
fn crossings(density: &Density<'_>, samples: &Samples, edges: &[[u32; 2]]) -> Result<Vec<[DVec3; 2]>, ExactError> {
    let ends: Vec<[DVec3; 2]> = edges.iter().map(|edge| edge.map(|end| samples.place(samples.of_index(end)))).collect();
    let mut spans = vec![[0.0, 1.0]; edges.len()];
    let middle = |ends: &[DVec3; 2], [from, to]: &[f64; 2]| ends[0].lerp(ends[1], 0.5 * (from + to));
    for _ in 0..HALVINGS {
        let places: Vec<DVec3> = ends.iter().zip(&spans).map(|(ends, span)| middle(ends, span)).collect();
        for (span, found) in spans.iter_mut().zip(density.at(&places)?) {
            span[usize::from(found < density.level)] = 0.5 * (span[0] + span[1]);
        }
    }
    Ok(ends.iter().zip(&spans).map(|(ends, span)| [middle(ends, span), ends[0].lerp(ends[1], span[0])]).collect())
}

/// Converts a place from object space to the world and axes of the object's file.
fn world(subject: &Subject, object: &Object, place: DVec3) -> Vec3 {
    let stretched = place * Vec3::from(object.stretch).as_dvec3() / f64::from(subject.scale);
    object.up.turned_back(subject.center.as_dvec3() + stretched).as_vec3()
}
