//! The density of a scene: its values, its histogram, its profile along a ray and its iso-surface.

mod colors;
mod error;
mod polygonize;
mod program;

pub use error::PolygonizeError;
pub use polygonize::{Polygons, polygonize, polygonize_with_looks};
pub use program::{Along, densities, density_along, object_along, samples_along};
pub(crate) use program::{DensityProgram, density_at};
