//! Signed distance fields: positive outside, in world units, sampled on a grid.
//!
//! Role: [`transform`] computes a [`DistanceField`] from any [`hypertexture_shape::Shape`]; [`load_or_compute`] caches the result on disk.
//! Invariant: every value is finite, has the sign of its side, and does not exceed the distance to the surface in magnitude,
//! so that rays may skip space by it.

mod bvh;
mod cache;
mod closest;
mod distance;
mod error;
mod face;
mod grid;
mod iso_surface;
mod level_set;
mod overlap;
mod request;
mod seal;
mod search;
mod sign;
mod soup;
mod stage;
#[cfg(test)]
mod tests;
mod tetra;
mod transform;
mod winding;

pub use cache::{Key, load_or_compute};
pub use closest::ClosestPoints;
pub use error::FieldError;
pub use grid::{DistanceField, Grid};
pub use level_set::{BLOCK, LevelSet, SignBlock};
pub use request::{FieldReport, Progress, Request};
pub use transform::{transform, transform_with_closest};
