//! Iso-surface of a scene's density as a closed mesh, for other programs to open, print or cut.
//!
//! Invariant: the density is that of the scene's program, evaluated by [`eval`](crate::eval) in f64, so that no formula
//! is written twice. Blocks of samples are skipped only if bounds prove their side of the surface.

use super::colors::colors;
use super::crossings::crossings;
use super::error::PolygonizeError;
use super::lattice::Lattice;
use super::program::DensityProgram;
use super::signs::Signs;
use crate::field::{LevelSet, Progress};
use crate::render::subject::Subject;
use crate::render::variant::{Checkable, Variant};
use crate::scene::Object;
use crate::shader::Library;
use crate::shape::{Looks, Mesh};
use glam::{DVec3, Vec3};

/// Settings of a mesh.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Polygons {
    /// Samples along the longest side of the box around the soft region; 8 to 512.
    pub grid: u32,
    /// Density of the surface, above 0, up to 1; a hard object has 1 inside and 0 outside.
    pub density: f32,
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
    let lattice = Lattice::around(view.box_min.as_dvec3(), view.box_max.as_dvec3(), grid);
    let signs = Signs::of(&density, &lattice, u64::MAX, &|done| progress(0.5 * done))?;
    let set = LevelSet::of(lattice.size, &signs.blocks);
    let found = crossings(&density, &lattice, &set.edges, &|done| progress(0.5 + 0.5 * done))?;
    let positions = found.iter().map(|[place, _]| world(subject, &variant.scene.object, *place).as_vec3()).collect();
    let mesh = Mesh { positions, triangles: set.triangles, offset: subject.offset, ..Mesh::default() };
    Ok((mesh, found.into_iter().map(|[_, inside]| inside).collect()))
}

/// Converts a place from object space to the world and axes of the object's file.
pub(crate) fn world(subject: &Subject, object: &Object, place: DVec3) -> DVec3 {
    let stretched = place * Vec3::from(object.stretch).as_dvec3() / f64::from(subject.scale);
    object.up.turned_back(subject.center.as_dvec3() + stretched)
}
