//! Noise on the CPU, and blocks of noise for textures.
//!
//! Role: the gradient noises of `glsl/` in f64 with analytic gradients, sums of octaves, tiling blocks, and ranges over boxes.
//! Invariant: [`Lattice`] equals `glsl/lattice_noise.glsl` and [`Noise`] equals `glsl/table_noise.glsl`.
//! The noise is written twice on purpose: programs read their noise from GLSL, while Rust bakes blocks in SIMD and bounds the
//! noise over boxes, which evaluated SPIR-V does a hundred times slower or not as tightly. `tests/formulas` and
//! `tests/pictures` compare the two.
//! Source: PH 2.3, Perlin 2002 (quintic weights), MJ 4.1 and 4.2.

mod bake;
mod blue;
mod knots;
mod lattice;
mod random_block;
mod range;
mod table;
mod weights;

pub use bake::{Bake, Block};
pub use blue::blue_noise;
pub use knots::Knots;
pub use lattice::{Lattice, Period};
pub use random_block::{random_block, random_mean};
pub use range::ROUNDED;
pub use table::{Noise, SEED};
pub use weights::{NOISE_BOUND, NOISE_GRADIENT_BOUND, TURBULENCE_BOUND, TURBULENCE_GRADIENT_BOUND, Weights};
