//! Shapes: what a person brings, before it becomes a distance field.
//!
//! Role: turn a file, a name or a formula into a [`Shape`]. Invariant: every coordinate and value is finite.
//! This layer imports nothing else of the crate and needs no GPU.
//!
//! [`open`] is the way in, [`open_raw`] where a file does not say what it holds; [`VolumeFormat`] and [`MeshFormat`] are the
//! ways back out. World space is right-handed with y up for the built-in objects; files keep the coordinates they have. Sources
//! are named where they are used: Newell's teapot in [`teapot`], the head in [`head`], the Shepp-Logan head in [`phantom`],
//! the file formats in `obj`, `ply`, `stl`, `gltf`, `nrrd`, `meta`, `nifti`, `dicom` and `vdb`.

mod axes;
mod dicom;
mod enclosed;
mod error;
mod facts;
mod files;
mod generated;
mod gltf;
pub mod head;
mod iso_values;
mod memory;
mod mesh;
mod meta;
mod nifti;
mod nifti_header;
mod nrrd;
mod nrrd_header;
mod obj;
mod open;
pub mod phantom;
mod placement;
mod ply;
mod polygon;
mod raster;
mod raw;
mod sample_type;
mod solid;
mod source;
mod space;
mod stl;
mod tank;
pub mod teapot;
mod teapot_data;
mod unpack;
mod values;
mod vdb;
mod volume;
mod wound;
mod write_mesh;
mod write_nifti;
mod write_volume;

pub use axes::Axes;
pub use enclosed::Enclosed;
pub use error::{Found, Location, ShapeError};
pub use facts::{Fact, Facts};
pub use generated::BUILT_IN;
pub use iso_values::Histogram;
pub use memory::MEMORY;
pub use mesh::Edges;
pub use nrrd::write_nrrd;
pub use open::{Opened, open, read, read_noted};
pub use raw::{RawLayout, open_raw};
pub use sample_type::{SampleType, UnknownSampleType};
pub use write_mesh::MeshFormat;
pub use write_volume::VolumeFormat;

use glam::{DVec3, Mat3, Vec3};

/// Largest magnitude of a coordinate in world units.
///
/// Ten times larger and the squared length of a diagonal comes near the end of f32 (3.4e38); no real object is there.
pub const MAX_COORDINATE: f32 = 1e18;
/// Most triangles of a mesh: a binary STL file of 2.5 GB.
pub const MAX_TRIANGLES: u64 = 50_000_000;
/// Most voxels of a volume: 8 GiB of f32.
pub const MAX_VOXELS: u64 = 1 << 31;

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
    /// What was taken from the coordinates of the file before they became f32.
    ///
    /// Zero on each axis along which the mesh reaches at most 16 times the longest side of its box from the origin. On the
    /// others the middle of the box, rounded so that the difference is exact where the file has 32-bit floats.
    pub offset: DVec3,
}

/// Samples on a regular grid, x fastest, then y, then z.
#[derive(Clone, Debug)]
pub struct Volume {
    /// Samples per axis, each at least 1.
    pub size: [u32; 3],
    /// World position of sample (0, 0, 0).
    pub origin: Vec3,
    /// World steps from a sample to the next, one column for each axis of the grid; not singular. Diagonal and positive
    /// where the grid stands along the axes of the world.
    pub steps: Mat3,
    /// `size[0] * size[1] * size[2]` finite values.
    pub values: Vec<f32>,
    /// What the values mean.
    pub content: Content,
}

/// What the values of a [`Volume`] mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Content {
    /// A measured or computed scalar: the object is where `value >= iso`.
    Scalar,
    /// A signed distance in world units, positive outside.
    SignedDistance,
    /// Negative inside and zero on the surface; what lies far from it says nothing but its side.
    LevelSet,
}

impl Shape {
    /// A box that contains the object, in world units; that of a mesh is less its offset.
    ///
    /// Tight for a solid and a mesh. For a volume, scalar or distance, its whole extent from first to last sample:
    /// where the object ends in there depends on the iso-value.
    pub fn bounds(&self) -> Bounds {
        match self {
            Shape::Solid(solid) => solid.bounds(),
            Shape::Mesh(mesh) => mesh.bounds(),
            Shape::Volume(volume) => volume.bounds(),
        }
    }

    /// The same `by` times as large, from the origin of the world on; a solid stays as it is.
    pub fn scaled(&self, by: f32) -> Shape {
        let mut scaled = self.clone();
        match &mut scaled {
            Shape::Solid(_) => {}
            Shape::Mesh(mesh) => {
                mesh.positions.iter_mut().for_each(|position| *position *= by);
                mesh.offset *= f64::from(by);
            }
            Shape::Volume(volume) => {
                (volume.origin, volume.steps) = (by * volume.origin, by * volume.steps);
                if volume.content != Content::Scalar {
                    volume.values.iter_mut().for_each(|distance| *distance *= by);
                }
            }
        }
        scaled
    }
}

impl Bounds {
    /// The smallest box around `positions`; `None` if there are none.
    pub fn around(positions: &[Vec3]) -> Option<Bounds> {
        let first = *positions.first()?;
        let start = Bounds { min: first, max: first };
        Some(positions.iter().fold(start, |b, &p| Bounds { min: b.min.min(p), max: b.max.max(p) }))
    }

    /// Middle of the box.
    pub fn center(&self) -> Vec3 {
        self.min + 0.5 * self.size()
    }

    /// Edge lengths, each at least 0.
    pub fn size(&self) -> Vec3 {
        self.max - self.min
    }
}
