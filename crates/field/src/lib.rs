//! Distance fields: a shape sampled on a grid, signed, positive outside, in world units.
//!
//! Role: [`transform`] computes a [`DistanceField`] from any [`Shape`]; [`load_or_compute`] does it once per shape and
//! request and keeps the result on disk. Invariant: every value is finite, has the sign of its side, and its
//! magnitude never exceeds the distance to the surface, so that later layers may skip through space by it.
//!
//! [`Shape`]: shape::Shape

mod bvh;
mod cache;
mod closest;
mod distance;
mod face;
mod grid;
mod iso_surface;
mod level_set;
mod overlap;
mod seal;
mod search;
mod sign;
mod soup;
mod stage;
#[cfg(test)]
mod tests;
mod tetra;
mod transform;
mod winding;

pub use cache::{Key, cached, cached_with_closest, load_or_compute, load_or_compute_closest};
pub use closest::ClosestPoints;
pub use level_set::LevelSet;
pub use transform::{transform, transform_with_closest};

use glam::Vec3;

/// A regular grid of sample points in world space; x fastest, then y, then z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Samples per axis: at least 2 where [`transform`] chose them, at least 1 in a volume of signed distances.
    pub size: [u32; 3],
    /// World position of sample (0, 0, 0).
    pub origin: Vec3,
    /// World distance between neighboring samples on each axis, positive; equal on all axes where [`transform`]
    /// chose it.
    pub spacing: Vec3,
}

/// Signed distance to a surface, sampled on a [`Grid`]: positive outside, negative inside, world units.
#[derive(Clone, Debug, PartialEq)]
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
    /// World distance beyond the bounds of the shape that the grid also covers; at least 0.
    pub margin: f32,
    /// The field is exact where its magnitude is at most this (world units, at least 0); outside it is a safe lower
    /// bound, less than the distance by at most a quarter of a voxel.
    pub band: f32,
    /// Iso-value of the surface of a scalar volume; unused by other shapes.
    pub iso: f32,
    /// Thickness of the shell that the surface is made into, half of it to each side (world units, at least 0); 0 makes what
    /// the surface encloses solid. A shell needs no inside.
    pub shell: f32,
}

/// What [`transform`] did, to be shown to the user.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub struct FieldReport {
    /// Triangles of the surface: of the mesh, or extracted from the volume; 0 for a formula.
    pub triangles: usize,
    /// Edges of the input mesh with one triangle: 0 for a closed mesh. Corners at equal positions count as one.
    pub open_edges: usize,
    /// Triangles turned around because their neighbors were wound the other way.
    pub turned_triangles: usize,
    /// Whether solids overlap, so that surfaces inside of them were dropped.
    pub buried: bool,
    /// Whether they overlap in so many places that some of those surfaces were kept: distances inside are too short there.
    pub tangled: bool,
    /// Triangles added where the winding number had to close a hole.
    pub closing_triangles: usize,
    /// Samples with exact distances, near the surface and where a lower bound would have been loose.
    pub exact: u64,
    /// Whether the field was read from the cache; the counts are then those of its computation.
    pub from_cache: bool,
    /// Wall-clock milliseconds.
    pub ms: f64,
}

/// Progress of a long computation, called with a fraction in [0, 1] from any thread.
pub type Progress<'a> = &'a (dyn Fn(f32) + Sync);

/// Why a field cannot be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum FieldError {
    /// The iso-value separates nothing.
    #[error("no surface at iso-value {iso}: {}", match min < max {
        true => format!("the values range from {min} to {max}; choose one above {min}, up to {max}"),
        false => format!("all values are {min}, and no other iso-value has one; is it the right file?"),
    })]
    NoSurface {
        /// The requested iso-value.
        iso: f32,
        /// Smallest value.
        min: f32,
        /// Largest value.
        max: f32,
    },
    /// The resolution is out of range.
    #[error("resolution {resolution} is not in 8 to 1024; 64 to 256 suit most shapes")]
    Resolution {
        /// Samples along the longest side.
        resolution: u32,
    },
    /// A margin or band is negative or not finite.
    #[error("{name} {value} is not a length; give a finite number of at least 0 (world units)")]
    Length {
        /// Which length.
        name: &'static str,
        /// What was asked.
        value: f32,
    },
    /// The shape is too small, too large or too far from the origin for its samples to be told apart.
    #[error(
        "samples over a side of {side:e} at coordinates up to {magnitude:e} cannot be told apart in 32 bits; \
         move the shape to the origin, scale it, or widen the margin"
    )]
    Extent {
        /// Longest side of the grid, world units.
        side: f64,
        /// Largest coordinate of the grid.
        magnitude: f32,
    },
    /// There is no triangle.
    #[error("the mesh has 0 triangles with an area, at least 1 is needed; check the file's faces")]
    EmptyMesh,
    /// A triangle names a vertex that does not exist.
    #[error("a triangle has corner {index} but there are {vertices} vertices; check the file's faces")]
    Corner {
        /// The index.
        index: u32,
        /// Vertices of the mesh.
        vertices: usize,
    },
    /// A volume does not hold the values that its size calls for.
    #[error("a volume of {size:?} samples needs {expected} values, at least 1, got {found}; check the file's header")]
    Samples {
        /// Samples per axis.
        size: [u32; 3],
        /// Their product.
        expected: u64,
        /// Values present.
        found: u64,
    },
    /// A volume of scalars was taken for one of signed distances.
    #[error("the volume holds scalars, signed distances are needed; compute them with an iso-value")]
    Content,
    /// Signed distances on a grid that is not along the axes of the world.
    #[error("the axes of the signed distances are not those of the world; resample them onto these")]
    Oblique,
    /// The computation would take too much memory.
    #[error("a grid of {size:?} needs {bytes} bytes, the limit is {limit}; lower the resolution")]
    Memory {
        /// Predicted need.
        bytes: u64,
        /// What is allowed.
        limit: u64,
        /// Samples per axis.
        size: [u32; 3],
    },
}
