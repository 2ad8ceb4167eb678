//! The light of a scene.

use super::fields::setting::{choices, settings};
use super::rules::check::within;
use super::{Color, Order, Pass, Proxy, Scene, SceneError};

settings! {
    /// A point light that moves with the camera (MJ 3.2).
    pub struct Light: LightField = "light." {
        /// Position from the center of the object: right, up, toward the camera; object units.
        position: [f32; 3] = [-3.0, 4.0, 5.0]
            => View, numbers(3, -1e6, 1e6), usual(-10.0, 10.0), flag("light"), unit(Unit::ObjectUnits);
        /// Color of the light.
        color: Color = Color([255; 3]) => Picture, Kind::Color;
        /// Brightness of the light.
        intensity: f32 = 1.0 => Picture, number(0.0, 1000.0), usual(0.0, 5.0);
        /// Color of the ambient light.
        ambient: Color = Color([76, 80, 90]) => Picture, Kind::Color;
        /// Whether matter casts shadows.
        shadows: bool = false => Images, Kind::Switch, flag_alone("shadows", "true");
        /// Texels along a side of the shadow volume, at most 256, or of the buffer of half-angle slicing.
        shadow_resolution: u32 = 128 => Picture, whole(8.0, 2048.0), usual(16.0, 256.0), unit(Unit::Texels);
        /// Shadow method.
        method: LightMethod = LightMethod::Volume => Images, Kind::Choice(LightMethod::CHOICES);
        /// Fraction of the light that soft matter scatters forward; needs half_angle.
        translucency: f32 = 0.0 => Images, number(0.0, 1.0);
        /// Fraction of the extinction that scattered light ignores, per channel.
        transport: Color = Color([230, 170, 110]) => Images, Kind::Color;
        /// Standard deviation of the blur of scattered light after one object unit, object units.
        scatter: f32 = 0.2 => Images, number(0.0, 2.0), unit(Unit::ObjectUnits);
    }
}

choices! {
    /// Shadow method.
    #[non_exhaustive]
    pub enum LightMethod {
        /// A shadow volume, rendered before the picture: any light, slices and rays.
        #[default]
        Volume = "volume",
        /// Half-angle slicing (GG 39.5.1): slices only, a light outside of the scene; supports translucency.
        HalfAngle = "half_angle",
    }
}

impl Scene {
    /// Whether the scene uses half-angle slicing.
    pub fn is_half_angle(&self) -> bool {
        self.light.shadows && self.light.method == LightMethod::HalfAngle
    }

    /// Checks the resolution of the shadows.
    pub(super) fn check_light(&self) -> Result<(), SceneError> {
        let finest = if self.is_half_angle() { 2048.0 } else { 256.0 };
        within("light.shadow_resolution", self.light.shadow_resolution as f32, 8.0, finest)
    }

    /// Checks that half-angle slicing has slices in the order of the light.
    pub(super) fn check_half_angle(&self) -> Result<(), SceneError> {
        let (quality, translucency) = (&self.quality, self.light.translucency);
        if !self.is_half_angle() {
            return if self.light.shadows && translucency > 0.0 {
                Err(SceneError::value("light.translucency", translucency, "needs light.method = \"half_angle\""))
            } else {
                Ok(())
            };
        }
        let half_angle = |limit| Err(SceneError::value("light.method", "\"half_angle\"", limit));
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
