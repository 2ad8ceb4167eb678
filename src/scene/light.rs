//! The light of a scene.

use super::check::within;
use super::{Color, Order, Pass, Proxy, Scene, SceneError};
use serde::{Deserialize, Serialize};

/// A point light that moves with the camera (MJ 3.2).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Light {
    /// Position from the center of the object: right, up, toward the camera; object units.
    pub position: [f32; 3],
    /// Color.
    pub color: Color,
    /// Brightness of the color.
    pub intensity: f32,
    /// Color of what comes from all sides.
    pub ambient: Color,
    /// Whether matter keeps the light from what is behind it.
    pub shadows: bool,
    /// Texels along a side of the volume of shadows, 16 to 256; or of the buffer of half-angle slicing, 16 to 2048.
    pub shadow_resolution: u32,
    /// How the light that reaches a place is found.
    pub method: LightMethod,
    /// Part of the light that soft matter scatters forward, 0 to 1: it is blurred and colored on its way. Needs
    /// `method = "half_angle"`.
    pub translucency: f32,
    /// Part of the optical depth that scattered light is spared, by channel.
    pub transport: Color,
    /// Standard deviation of the blur of scattered light after one object unit, object units, 0 to 2.
    pub scatter: f32,
}

/// How the light that reaches a place of the scene is found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum LightMethod {
    /// From a volume, rendered before the picture: any light, slices and rays.
    #[default]
    Volume,
    /// Slice by slice with the picture, in slices half way between the camera and the light (GG 39.5.1): slices alone, and a
    /// light outside of the scene. Knows translucency.
    HalfAngle,
}

impl std::default::Default for Light {
    fn default() -> Light {
        Light {
            position: [-3.0, 4.0, 5.0],
            color: Color([255; 3]),
            intensity: 1.0,
            ambient: Color([76, 80, 90]),
            shadows: false,
            shadow_resolution: 128,
            method: LightMethod::Volume,
            translucency: 0.0,
            transport: Color([230, 170, 110]),
            scatter: 0.2,
        }
    }
}

impl Scene {
    /// Whether the slices lie half way between the camera and the light.
    pub fn is_half_angle(&self) -> bool {
        self.light.shadows && self.light.method == LightMethod::HalfAngle
    }

    /// Checks the values of the light.
    pub(super) fn check_light(&self) -> Result<(), SceneError> {
        let finest = if self.is_half_angle() { 2048.0 } else { 256.0 };
        within("light.shadow_resolution", self.light.shadow_resolution as f32, 8.0, finest)
    }

    /// Light that goes from slice to slice needs slices, in its own order.
    pub(super) fn check_half_angle(&self) -> Result<(), SceneError> {
        let wrong = |field: &str, value: String, limit: &str| {
            Err(SceneError::Value { field: field.into(), value, limit: limit.into() })
        };
        let quality = &self.quality;
        if !self.is_half_angle() {
            return match self.light.shadows && self.light.translucency > 0.0 {
                true => wrong(
                    "light.translucency",
                    self.light.translucency.to_string(),
                    "needs light.method = \"half_angle\"",
                ),
                false => Ok(()),
            };
        }
        let half_angle = |limit| wrong("light.method", "\"half_angle\"".into(), limit);
        match quality {
            _ if quality.pass == Pass::March => half_angle("needs quality.pass = \"slices\"; rays take \"volume\""),
            _ if quality.proxy == Proxy::Quads => half_angle("needs quality.proxy = \"polygons\""),
            _ if quality.order == Order::BackToFront => {
                half_angle("needs quality.order = \"front_to_back\": the order of the slices is that of the light")
            }
            _ if self.camera.slice_stack => half_angle("needs camera.slice_stack = false"),
            _ => Ok(()),
        }
    }
}
