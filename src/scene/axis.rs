//! Which way is up in a file.

use glam::DVec3;
use serde::{Deserialize, Serialize};

/// A direction along an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// +x.
    X,
    /// +y.
    #[default]
    Y,
    /// +z.
    Z,
    /// -x.
    #[serde(rename = "-x")]
    MinusX,
    /// -y.
    #[serde(rename = "-y")]
    MinusY,
    /// -z.
    #[serde(rename = "-z")]
    MinusZ,
}

impl Axis {
    /// A vector by the axes of a file, by those of the scene.
    pub fn turned(self, vector: DVec3) -> DVec3 {
        self.turn().map(|(axis, reversed)| if reversed { -vector[axis] } else { vector[axis] }).into()
    }

    /// A vector by the axes of the scene, by those of the file.
    pub fn turned_back(self, vector: DVec3) -> DVec3 {
        let mut own = DVec3::ZERO;
        for (axis, (from, reversed)) in self.turn().into_iter().enumerate() {
            own[from] = if reversed { -vector[axis] } else { vector[axis] };
        }
        own
    }

    /// For each axis of a space whose y axis is this direction: the axis it comes from, and whether it is reversed. The
    /// turn is a rotation, so that nothing is mirrored.
    pub fn turn(self) -> [(usize, bool); 3] {
        match self {
            Axis::Y => [(0, false), (1, false), (2, false)],
            Axis::MinusY => [(0, false), (1, true), (2, true)],
            Axis::Z => [(0, false), (2, false), (1, true)],
            Axis::MinusZ => [(0, false), (2, true), (1, false)],
            Axis::X => [(1, true), (0, false), (2, false)],
            Axis::MinusX => [(1, false), (0, true), (2, false)],
        }
    }
}
