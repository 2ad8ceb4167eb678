//! Distance fields: a shape sampled on a grid, signed, positive outside, in world units.

use crate::shape::Shape;
use glam::Vec3;

/// A regular grid of sample points in world space; x fastest, then y, then z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Samples per axis, each at least 2.
    pub size: [u32; 3],
    /// World position of sample (0, 0, 0).
    pub origin: Vec3,
    /// World distance between neighboring samples on each axis, positive.
    pub spacing: Vec3,
}

/// Signed distance to a surface, sampled on a [`Grid`]: positive outside, negative inside, world units.
#[derive(Clone, Debug)]
pub struct DistanceField {
    /// Where the samples are.
    pub grid: Grid,
    /// One finite value for each sample of `grid`, x fastest.
    pub values: Vec<f32>,
}

/// What to sample: see [`transform`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Request {
    /// Samples along the longest side of the grid, margin included; 8 to 1024.
    pub resolution: u32,
    /// World distance beyond the bounds of the shape that the grid also covers.
    pub margin: f32,
    /// The field is exact where its magnitude is at most this (world units); outside it is a safe lower bound.
    pub band: f32,
    /// Iso-value of the surface of a scalar volume; unused by other shapes.
    pub iso: f32,
}

/// What [`transform`] did, to be shown to the user.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Report {
    /// Triangles of the surface.
    pub triangles: usize,
    /// Edges of the input mesh with one triangle: 0 for a closed mesh.
    pub open_edges: usize,
    /// Triangles added where the winding number had to close a hole.
    pub closing_triangles: usize,
    /// Wall-clock milliseconds.
    pub ms: f64,
}

/// Progress of a long computation, called with a fraction in [0, 1] from any thread.
pub type Progress<'a> = &'a (dyn Fn(f32) + Sync);

/// Why a field cannot be computed.
#[derive(Debug, thiserror::Error)]
pub enum FieldError {}

/// Distance field of `shape`.
pub fn transform(_shape: &Shape, _request: &Request, _progress: Progress) -> Result<(DistanceField, Report), FieldError> {
    todo!()
}
