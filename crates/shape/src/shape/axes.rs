//! Transform between grid indices and the world.
//!
//! Invariant: on aligned axes the only roundings are one product and one sum, or one difference and one quotient.

use glam::{DMat3, DVec3};

/// Position and axes of a grid, in f64.
pub struct Axes {
    origin: DVec3,
    steps: DMat3,
    /// Lengths of the steps.
    spacing: DVec3,
    /// World offsets to lengths along the axes; exact for aligned axes.
    along: DMat3,
}

impl Axes {
    /// `steps` has one column per grid axis.
    pub fn new(origin: DVec3, steps: DMat3) -> Axes {
        let spacing = lengths(&steps);
        Axes { origin, steps, spacing, along: directions(&steps).inverse() }
    }

    /// World position of a grid position in samples.
    pub fn world(&self, at: DVec3) -> DVec3 {
        self.origin + self.steps * at
    }

    /// Grid position in samples of a world position.
    pub fn index(&self, world: DVec3) -> DVec3 {
        self.along * (world - self.origin) / self.spacing
    }

    /// Shift in samples, per unit of relative rounding of the coordinates of a world position.
    pub(crate) fn sensitivity(&self, world: DVec3) -> DVec3 {
        self.along.abs() * world.abs() / self.spacing
    }
}

/// Lengths of the columns.
pub(crate) fn lengths(steps: &DMat3) -> DVec3 {
    DVec3::new(steps.x_axis.length(), steps.y_axis.length(), steps.z_axis.length())
}

/// Unit vectors along the columns.
pub(crate) fn directions(steps: &DMat3) -> DMat3 {
    let DVec3 { x, y, z } = lengths(steps);
    DMat3::from_cols(steps.x_axis / x, steps.y_axis / y, steps.z_axis / z)
}
