//! Meshes that files can hold.

use crate::shape::Mesh;
use crate::shape::looks::Looks;
use glam::DVec3;
use std::io;

/// Checks that a mesh can be written.
pub(super) fn check(mesh: &Mesh, looks: Option<&Looks>) -> io::Result<()> {
    let vertices = mesh.positions.len();
    let is_known = |corner: &u32| (*corner as usize) < vertices;
    let is_whole = mesh.triangles.as_flattened().iter().all(is_known) && u32::try_from(vertices).is_ok();
    let is_finite = mesh.positions.iter().all(|place| place.is_finite()) && mesh.offset.is_finite();
    let is_looked = looks.is_none_or(|looks| {
        looks.colors.len() == vertices && (looks.normals.is_empty() || looks.normals.len() == vertices)
    });
    if mesh.triangles.is_empty() || !is_whole || !is_finite || !is_looked {
        let reason = "a mesh is written with triangles between its corners, and with finite coordinates";
        return Err(io::Error::new(io::ErrorKind::InvalidInput, reason));
    }
    Ok(())
}

/// Positions with the offset added.
pub(super) fn places(mesh: &Mesh) -> impl Iterator<Item = DVec3> {
    mesh.positions.iter().map(|place| place.as_dvec3() + mesh.offset)
}
