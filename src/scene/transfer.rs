//! The transfer map of a scene.

use super::Color;
use super::fields::setting::{Leaf, choices, settings};
use serde::{Deserialize, Serialize};

settings! {
    /// The transfer map: color and opacity by density.
    pub struct Transfer: TransferField = "transfer." {
        /// Interpolation between two stops of the transfer map.
        curve: Curve = Curve::Linear => Images, Kind::Choice(Curve::CHOICES);
        /// Stops of the transfer map in the order of their density, 1 to 256: color, density and index of refraction.
        stops: Vec<Stop> = vec![Stop::of(0.0, [0, 0, 0]), Stop::of(1.0, [255, 255, 255])] => Images, Kind::Stops;
    }
}

choices! {
    /// Interpolation between two stops of the transfer map.
    pub enum Curve {
        /// The value of the lower stop.
        Steps = "steps",
        /// Linear.
        #[default]
        Linear = "linear",
        /// A monotone cubic spline (Fritsch and Carlson 1980), which stays between the stops.
        Spline = "spline",
    }
}

impl Transfer {
    /// Whether color and opacity are the same at every density, so that no lookup is needed.
    pub fn is_flat(&self) -> bool {
        self.stops.windows(2).all(|pair| (pair[0].color, pair[0].density) == (pair[1].color, pair[1].density))
    }
}

/// One stop of a transfer map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stop {
    /// Density, 0 to 1.
    pub at: f32,
    /// Color there.
    pub color: Color,
    /// Density for the opacity, 0 to 1; 1 is opaque.
    #[serde(default = "one")]
    pub density: f32,
    /// Index of refraction, 1 to 4; used by bent rays.
    #[serde(default = "one")]
    pub index: f32,
}

impl Leaf for Vec<Stop> {}

impl Stop {
    fn of(at: f32, color: [u8; 3]) -> Stop {
        Stop { at, color: Color(color), density: at, index: 1.0 }
    }
}

fn one() -> f32 {
    1.0
}
