//! Pictures on disk.
//!
//! Role: writes and reads PNG files (8 or 16 bits, straight alpha, sRGB) and OpenEXR files (32-bit floats, premultiplied,
//! linear) with their [`Provenance`]. Invariant: a file appears whole or not at all; it is written next to its place under a
//! temporary name, synced and renamed.

mod animated;
mod check;
mod error;
mod format;
mod identity;
mod map;
mod provenance;
mod read;
pub mod sequence;
pub mod shard;
mod write;

pub use animated::{Animated, Sheet};
pub use check::{check, check_all, check_folder};
pub use error::OutputError;
pub use identity::{identity, identity_of_texts};
pub use map::write_map;
pub use provenance::{PROGRAM, Provenance, ProvenanceError};
pub use read::{Encoding, Stored, read, read_provenance, size};
pub use write::{Depth, encode_png, write};
