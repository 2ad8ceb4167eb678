//! View-aligned planes at which slices and rays take their samples.
//!
//! Invariant: the planes depend on the camera's distance and on the size of the scene, never on the rotation (MJ 3.3).

/// Bounding sphere of the scene in eye space, its center on the axis of view.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Extent {
    /// Distance of the center from the camera.
    pub distance: f32,
    /// Radius.
    pub radius: f32,
    /// Near distance of the camera.
    pub near: f32,
}

/// Equidistant view-aligned planes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct SlicePlanes {
    /// Depth of the plane nearest to the camera.
    pub first_depth: f32,
    /// Distance between two planes.
    pub step: f32,
    /// Number of planes.
    pub count: u32,
    /// Number of planes left out because they are behind the camera.
    pub skipped: u32,
}

impl SlicePlanes {
    /// Cuts the sphere of `extent` into `samples` slabs of equal thickness, each with a plane through its middle.
    /// Leaves out planes nearer than `extent.near`, so that the camera may be inside.
    pub fn new(extent: Extent, samples: u32) -> SlicePlanes {
        let step = 2.0 * extent.radius / samples as f32;
        let depth = |plane: u32| extent.distance - extent.radius + (plane as f32 + 0.5) * step;
        let skipped = (0..samples).find(|&plane| depth(plane) >= extent.near).unwrap_or(samples);
        SlicePlanes { first_depth: depth(skipped), step, count: samples - skipped, skipped }
    }

    /// Depth of a plane.
    pub fn depth(&self, plane: u32) -> f32 {
        self.first_depth + plane as f32 * self.step
    }
}
