//! Variants: checked scenes with their minimal programs.
//!
//! Role: scene -> chosen modules -> SPIR-V with its live bindings. Invariant: [`Variant::of`] is pure, and unreached
//! parts are neither in the program nor in its layout; [`Program::left_out`] lists them.

mod bindings;
mod checkable;
mod density;
mod error;
mod linked;
mod named;
mod program;
mod reflect;
mod scene_variant;

pub use crate::scene::FORMULAS;
pub use bindings::{GroomImage, ImageInput, NoiseImage, ObjectImage, PassImage, SamplerInput};
pub use checkable::Checkable;
pub(crate) use density::{as_density, as_extinction, unlit};
pub use error::VariantError;
pub(crate) use program::parts;
pub(crate) use program::why_left_out;
pub use program::{Blocks, OCTAVES_ID, Program};
pub(crate) use reflect::PICTURE_BINDING;
pub use reflect::{Block, Member, ReflectError, Resource, Use};
pub use scene_variant::{Purpose, Variant, slot_of};

#[cfg(test)]
mod tests;
