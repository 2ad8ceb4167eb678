//! Which way is up in a file.

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
