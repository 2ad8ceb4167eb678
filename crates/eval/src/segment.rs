//! What bounds say of a segment.

use super::interval::Interval;
use super::number::Number;

/// What is known of a number along a segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentBounds {
    /// Bounds of it everywhere on the segment.
    pub all: Interval,
    /// Bounds of its mean: narrower, since what is linear along the segment has no part in it.
    pub mean: Interval,
}

impl SegmentBounds {
    pub(super) fn of(all: Interval) -> SegmentBounds {
        SegmentBounds { all, mean: all }
    }

    /// Of a segment in parts; those of parts that overlap are not weighed.
    pub(super) fn join(self, other: SegmentBounds) -> SegmentBounds {
        SegmentBounds::of(self.all.join(other.all))
    }
}
