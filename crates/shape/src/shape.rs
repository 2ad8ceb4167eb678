//! Solid, mesh or volume.

use super::{Bounds, Content, Mesh, Solid, Volume};

/// Something that has a surface.
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
    /// A box that contains the object, in world units; that of a mesh is less its offset.
    ///
    /// Tight for a solid and a mesh. For a volume, scalar or distance, its whole extent from first to last sample:
    /// where the object ends in there depends on the iso-value.
    pub fn bounds(&self) -> Bounds {
        match self {
            Shape::Solid(solid) => solid.bounds(),
            Shape::Mesh(mesh) => mesh.bounds(),
            Shape::Volume(volume) => volume.bounds(),
        }
    }

    /// The same `by` times as large, from the origin of the world on; a solid stays as it is.
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
