//! Axis-aligned boxes.

use glam::Vec3;

/// Largest magnitude of a coordinate in world units.
///
/// Higher: the squared length of a diagonal comes near the end of f32 (3.4e38).
pub const MAX_COORDINATE: f32 = 1e18;

/// An axis-aligned box in world units; `min <= max` on every axis.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// Corner with the smallest coordinates.
    pub min: Vec3,
    /// Corner with the largest coordinates.
    pub max: Vec3,
}

impl Bounds {
    /// Smallest box around `positions`; `None` for an empty slice.
    pub fn around(positions: &[Vec3]) -> Option<Bounds> {
        let first = *positions.first()?;
        let start = Bounds { min: first, max: first };
        Some(positions.iter().fold(start, |b, &p| Bounds { min: b.min.min(p), max: b.max.max(p) }))
    }

    /// Middle of the box.
    pub fn center(&self) -> Vec3 {
        self.min + 0.5 * self.size()
    }

    /// Edge lengths, each at least 0.
    pub fn size(&self) -> Vec3 {
        self.max - self.min
    }
}
