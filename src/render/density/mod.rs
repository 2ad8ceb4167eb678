//! The density of a scene: its values, its histogram, its profile along a ray and its iso-surface.

mod error;
mod polygonize;
mod program;

pub use error::PolygonizeError;
pub use polygonize::{Polygons, polygonize};
pub use program::{Along, densities, density_along};
