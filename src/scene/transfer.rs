//! The transfer map of a scene.

use super::Color;
use serde::{Deserialize, Serialize};

/// The transfer map: color and opacity by density.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Transfer {
    /// What lies between two stops.
    pub curve: Curve,
    /// At least one stop, by rising density.
    pub stops: Vec<Stop>,
}

impl Transfer {
    /// Whether it has one color and one opacity at every density, and so need not be looked up.
    pub fn is_flat(&self) -> bool {
        self.stops.windows(2).all(|pair| (pair[0].color, pair[0].density) == (pair[1].color, pair[1].density))
    }
}

impl std::default::Default for Transfer {
    fn default() -> Transfer {
        let stop = |at, color| Stop { at, color: Color(color), density: at, index: 1.0 };
        Transfer { curve: Curve::Linear, stops: vec![stop(0.0, [0, 0, 0]), stop(1.0, [255, 255, 255])] }
    }
}

/// What lies between two stops of a transfer map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Curve {
    /// The value of the lower stop.
    Steps,
    /// A straight line.
    #[default]
    Linear,
    /// A monotone cubic (Fritsch and Carlson 1980): smooth, and never beyond the stops.
    Spline,
}

/// One stop of a transfer map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stop {
    /// Density, 0 to 1.
    pub at: f32,
    /// Color there.
    pub color: Color,
    /// Density that the opacity is made of, 0 to 1; 1 is opaque.
    #[serde(default = "one")]
    pub density: f32,
    /// Index of refraction, 1 to 4; read where rays bend.
    #[serde(default = "one")]
    pub index: f32,
}

fn one() -> f32 {
    1.0
}
