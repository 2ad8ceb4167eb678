//! The density of a scene: its values, its histogram, its profile along a ray and its iso-surface.

mod colors;
mod crossings;
mod error;
mod lattice;
mod polygonize;
mod program;
mod signs;

pub(super) use colors::colors;
pub(super) use crossings::crossings;
pub use error::PolygonizeError;
pub(super) use lattice::Lattice;
pub(super) use polygonize::world;
pub use polygonize::{Polygons, polygonize, polygonize_with_looks};
pub(crate) use program::density_at;
pub use program::{Along, densities, density_along, object_along, samples_along};
pub(super) use program::{Density, DensityProgram};
pub(super) use signs::Signs;
