//! Texturing and hypertexturing of volumetric objects.

pub mod field;
pub mod glsl;
pub mod gpu;
pub mod shape;
