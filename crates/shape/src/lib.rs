//! Shapes: meshes, volumes and analytic solids, and the files they come from.
//!
//! Invariant: every coordinate and value is finite.
//!
//! [`open`] reads a built-in object or a file, [`open_raw`] a file without a header; [`VolumeFormat`] and [`MeshFormat`] write
//! files. World space is right-handed; built-in objects have y up, files keep their coordinates.

mod axes;
mod bodies;
mod bounds;
mod brush;
mod built_in;
mod data_files;
mod decompress;
mod dicom;
mod enclosed;
mod error;
mod facts;
mod fields;
mod from_memory;
mod gltf;
mod groom;
pub mod head;
mod iso_values;
mod looks;
mod mesh;
mod meta;
mod mtl;
mod nifti;
mod nifti_header;
mod nrrd;
mod obj;
mod open;
mod orientation;
mod paint;
pub mod phantom;
mod placement;
mod ply;
mod polygon;
mod raster;
mod raw;
mod sample_type;
mod shape;
mod solid;
mod source;
mod space;
mod stl;
mod tank;
pub mod teapot;
mod teapot_data;
mod texture;
mod textures;
mod vdb;
mod volume;
mod write_mesh;
mod write_nifti;
mod write_values;
mod write_volume;

pub use axes::Axes;
pub use bodies::Body;
pub use bounds::{Bounds, MAX_COORDINATE};
pub use brush::{Brush, BrushKind};
pub use built_in::BUILT_IN;
pub use enclosed::Enclosed;
pub use error::{Found, Location, ShapeError};
pub use facts::{Fact, Facts};
pub use from_memory::MEMORY;
pub use groom::Groom;
pub use iso_values::Histogram;
pub use looks::Looks;
pub use mesh::{Edges, MAX_TRIANGLES, Mesh};
pub use open::{Opened, open, open_painted, read, read_noted, read_painted};
pub use paint::Paint;
pub use raw::{RawLayout, open_raw};
pub use sample_type::{SampleType, UnknownSampleType};
pub use shape::Shape;
pub use solid::Solid;
pub use vdb::{Fog, FogGrid, FogLeaf};
pub use volume::{Content, MAX_VOXELS, Volume};
pub use write_mesh::MeshFormat;
pub use write_volume::VolumeFormat;
