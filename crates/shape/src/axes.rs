//! From indices of a grid to the world and back.
//!
//! Role: the arithmetic of a grid whose axes stand anyhow, in f64. Invariant: on axes along those of the world nothing is
//! rounded but by one product and one sum, or one difference and one quotient.

use glam::{DMat3, DVec3};

/// Where the samples of a grid are.
pub struct Axes {
    origin: DVec3,
    steps: DMat3,
    /// Lengths of the steps.
    spacing: DVec3,
    /// From the world to lengths along the axes: exact where they are those of the world.
    along: DMat3,
}

impl Axes {
    /// `steps` has a column for each axis of the grid.
    pub fn new(origin: DVec3, steps: DMat3) -> Axes {
        let spacing = lengths(&steps);
        Axes { origin, steps, spacing, along: directions(&steps).inverse() }
    }

    /// World position of what is at `at`, counted in samples.
    pub fn world(&self, at: DVec3) -> DVec3 {
        self.origin + self.steps * at
    }

    /// Where a world position is, counted in samples.
    pub fn index(&self, world: DVec3) -> DVec3 {
        self.along * (world - self.origin) / self.spacing
    }

    /// How much the rounding of each coordinate of a world position moves what is there, in samples over the rounding of 1.
    pub fn sensitivity(&self, world: DVec3) -> DVec3 {
        self.along.abs() * world.abs() / self.spacing
    }
}

/// Lengths of the columns.
pub(super) fn lengths(steps: &DMat3) -> DVec3 {
    DVec3::new(steps.x_axis.length(), steps.y_axis.length(), steps.z_axis.length())
}

/// Unit vectors along the columns.
pub(super) fn directions(steps: &DMat3) -> DMat3 {
    let DVec3 { x, y, z } = lengths(steps);
    DMat3::from_cols(steps.x_axis / x, steps.y_axis / y, steps.z_axis / z)
}
