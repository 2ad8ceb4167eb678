//! Shapes: what a person brings, before it becomes a distance field.
//!
//! Role: turn a file, a name or a formula into a [`Shape`]. Invariant: every coordinate and value is finite.
//! This room imports nothing else of the crate and needs no GPU.

mod error;
mod generated;
mod mesh;
mod nrrd;
mod obj;
mod open;
mod phantom;
mod stl;
mod teapot;
mod teapot_data;
mod volume;

pub use error::{Found, Place, ShapeError};
pub use generated::BUILT_IN;
pub use nrrd::write_nrrd;
pub use open::open;

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

impl Shape {
    /// The box around the surface, world units; of a volume, around all its samples.
    pub fn bounds(&self) -> Bounds {
        match self {
            Shape::Solid(solid) => solid.bounds(),
            Shape::Mesh(mesh) => mesh.bounds(),
            Shape::Volume(volume) => volume.bounds(),
        }
    }
}

impl Bounds {
    /// The smallest box around some points; `None` where there are none.
    pub fn around(points: &[Vec3]) -> Option<Bounds> {
        let first = *points.first()?;
        let start = Bounds { min: first, max: first };
        Some(points.iter().fold(start, |box_, &p| Bounds { min: box_.min.min(p), max: box_.max.max(p) }))
    }
}

impl Solid {
    /// The box around the solid, world units.
    pub fn bounds(&self) -> Bounds {
        let half = match *self {
            Solid::Sphere { radius } => Vec3::splat(radius),
            Solid::Cube { half } => Vec3::splat(half),
            Solid::Torus { major, minor } => Vec3::new(major + minor, minor, major + minor),
        };
        Bounds { min: -half, max: half }
    }

    /// Exact signed distance of `p`, positive outside; world units.
    pub fn distance(&self, p: Vec3) -> f32 {
        match *self {
            Solid::Sphere { radius } => p.length() - radius,
            Solid::Cube { half } => {
                let q = p.abs() - half;
                q.max(Vec3::ZERO).length() + q.max_element().min(0.0)
            }
            Solid::Torus { major, minor } => (p.x.hypot(p.z) - major).hypot(p.y) - minor,
        }
    }
}
