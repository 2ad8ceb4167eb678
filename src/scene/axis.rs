//! The vertical axis of a file.

use super::fields::setting::choices;
use glam::DVec3;

choices! {
    /// A direction along an axis of a file.
    pub enum Axis {
        /// x of the file points up.
        X = "x",
        /// y of the file points up.
        #[default]
        Y = "y",
        /// z of the file points up.
        Z = "z",
        /// -x of the file points up.
        MinusX = "-x",
        /// -y of the file points up.
        MinusY = "-y",
        /// -z of the file points up.
        MinusZ = "-z",
    }
}

impl Axis {
    /// Converts a vector from the axes of the file to those of the scene.
    pub fn turned(self, vector: DVec3) -> DVec3 {
        self.turn().map(|(axis, reversed)| if reversed { -vector[axis] } else { vector[axis] }).into()
    }

    /// Converts a vector from the axes of the scene to those of the file.
    pub fn turned_back(self, vector: DVec3) -> DVec3 {
        let mut own = DVec3::ZERO;
        for (axis, (from, reversed)) in self.turn().into_iter().enumerate() {
            own[from] = if reversed { -vector[axis] } else { vector[axis] };
        }
        own
    }

    /// Source axis and sign of each axis of a space whose y axis is this direction. The map is a rotation: it mirrors
    /// nothing.
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
