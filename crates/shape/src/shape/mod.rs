//! Shapes: solids, meshes and volumes, and their geometry.

pub(crate) mod axes;
mod bodies;
mod bounds;
mod enclosed;
mod iso_values;
pub(crate) mod looks;
pub(crate) mod mesh;
mod orientation;
pub(crate) mod paint;
pub(crate) mod solid;
pub(crate) mod texture;
mod volume;

pub use axes::Axes;
pub use bodies::Body;
pub use bounds::{Bounds, MAX_COORDINATE};
pub use enclosed::Enclosed;
pub use iso_values::Histogram;
pub use looks::Looks;
pub use mesh::{Edges, MAX_TRIANGLES, Mesh};
pub use paint::Paint;
pub use solid::Solid;
pub use volume::{Content, MAX_VOXELS, Volume};

/// An object with a surface.
#[derive(Clone, Debug)]
pub enum Shape {
    /// An analytic solid with an exact distance everywhere.
    Solid(Solid),
    /// Triangles: may be open, self-intersecting or non-manifold.
    Mesh(Mesh),
    /// Samples on a regular grid: a scan, or a distance field read back from a file.
    Volume(Volume),
}

impl Shape {
    /// Bounding box in world units; for a mesh, relative to its offset.
    ///
    /// Tight for a solid and a mesh. For a volume, the whole extent from first to last sample.
    pub fn bounds(&self) -> Bounds {
        match self {
            Shape::Solid(solid) => solid.bounds(),
            Shape::Mesh(mesh) => mesh.bounds(),
            Shape::Volume(volume) => volume.bounds(),
        }
    }

    /// The shape scaled about the world origin; a solid is returned unchanged.
    pub fn scaled(&self, by: f32) -> Shape {
        let mut scaled = self.clone();
        match &mut scaled {
            Shape::Solid(_) => {}
            Shape::Mesh(mesh) => {
                mesh.positions.iter_mut().for_each(|position| *position *= by);
                mesh.offset *= f64::from(by);
            }
            Shape::Volume(volume) => {
                (volume.origin, volume.steps) = (by * volume.origin, by * volume.steps);
                if volume.content != Content::Scalar {
                    volume.values.iter_mut().for_each(|distance| *distance *= by);
                }
            }
        }
        scaled
    }
}
