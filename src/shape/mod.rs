//! Shapes: what a person brings, before it becomes a distance field.
//!
//! Role: turn a file, a name or a formula into a [`Shape`]. Invariant: every coordinate and value is finite.
//! This room imports nothing else of the crate and needs no GPU.

use glam::Vec3;

/// Something that has a surface.
#[derive(Clone, Debug)]
pub enum Shape {
    /// An analytic solid with an exact distance everywhere.
    Solid(Solid),
    /// Triangles: may be open, self-intersecting or non-manifold.
    Mesh(Mesh),
    /// Samples on a regular grid: a scan, or a distance field read back from a file.
    Volume(Volume),
}

/// An axis-aligned box in world units; `min <= max` on every axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Corner with the smallest coordinates.
    pub min: Vec3,
    /// Corner with the largest coordinates.
    pub max: Vec3,
}

/// A solid given by a formula, centered at the origin, in world units.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Solid {
    /// All points within `radius` of the origin.
    Sphere {
        /// Radius.
        radius: f32,
    },
    /// An axis-aligned cube.
    Cube {
        /// Half of the edge length.
        half: f32,
    },
    /// A torus around the y axis.
    Torus {
        /// Distance from the axis to the center of the tube.
        major: f32,
        /// Radius of the tube.
        minor: f32,
    },
}

/// A triangle mesh in world units.
#[derive(Clone, Debug, Default)]
pub struct Mesh {
    /// Vertex positions, finite.
    pub positions: Vec<Vec3>,
    /// Corner indices into `positions`, all in range; triangles of zero area have been dropped.
    pub triangles: Vec<[u32; 3]>,
}

/// Samples on a regular grid, x fastest, then y, then z.
#[derive(Clone, Debug)]
pub struct Volume {
    /// Samples per axis, each at least 1.
    pub size: [u32; 3],
    /// World position of sample (0, 0, 0).
    pub origin: Vec3,
    /// World distance between neighboring samples on each axis, positive.
    pub spacing: Vec3,
    /// `size[0] * size[1] * size[2]` finite values.
    pub values: Vec<f32>,
    /// What the values mean.
    pub content: Content,
}

/// What the values of a [`Volume`] mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// A measured or computed scalar: the object is where `value >= iso`.
    Scalar,
    /// A signed distance in world units, positive outside.
    SignedDistance,
}
