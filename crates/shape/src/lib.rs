//! Shapes: meshes, volumes and analytic solids, and the files they come from.
//!
//! Invariant: every coordinate and value is finite.
//!
//! [`open`] reads a built-in object or a file, [`open_raw`] a file without a header; [`VolumeFormat`] and [`MeshFormat`] write
//! files. World space is right-handed; built-in objects have y up, files keep their coordinates.
//!
//! Folders, each on those before it: `shape`, the objects; `built_in`; `mesh` and `volume`, the readers of the formats;
//! `write`; `groom`, paint in space over an object.

mod built_in;
mod error;
mod facts;
mod from_memory;
mod groom;
mod mesh;
mod open;
mod sample_type;
mod shape;
mod source;
mod unit;
mod volume;
mod write;

pub use built_in::{BUILT_IN, head, phantom, teapot};
pub use error::{Found, Location, ShapeError};
pub use facts::{Fact, Facts};
pub use from_memory::MEMORY;
pub use groom::{Brush, BrushKind, Groom};
pub use open::{Opened, open, open_painted, read, read_noted, read_painted};
pub use sample_type::{SampleType, UnknownSampleType};
pub use shape::{
    Axes, Body, Bounds, Content, Edges, Enclosed, Histogram, Looks, MAX_COORDINATE, MAX_TRIANGLES, MAX_VOXELS, Mesh,
    Paint, Shape, Solid, Volume,
};
pub use unit::Unit;
pub use volume::{RawLayout, open_raw};
pub use write::{Fog, FogGrid, FogLeaf, MeshFormat, PrintBody, PrintFile, VolumeFormat};
