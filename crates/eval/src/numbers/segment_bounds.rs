//! Bounds of a number along a segment.

use super::interval::Interval;
use crate::number::Domain;

/// Bounds of a number along a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentBounds {
    /// Bounds everywhere on the segment.
    pub all: Interval,
    /// Bounds of the mean, which linear terms do not widen.
    pub mean: Interval,
}

impl SegmentBounds {
    pub(crate) fn of(all: Interval) -> SegmentBounds {
        SegmentBounds { all, mean: all }
    }

    /// Bounds of the union of two parts, which may overlap; so the mean is only within the bounds.
    pub(crate) fn join(self, other: SegmentBounds) -> SegmentBounds {
        SegmentBounds::of(self.all.join(other.all))
    }
}
