//! Texturing and hypertexturing of volumetric objects.

pub mod field;
pub mod glsl;
pub mod gpu;
pub mod noise;
pub mod scene;
pub mod shape;
pub mod variant;
