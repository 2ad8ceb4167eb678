//! Colors: sRGB in files, linear in computations.

use super::fields::setting::{Leaf, Moment};
use serde::{Deserialize, Serialize};

/// A color, written `#rrggbb` in sRGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Color(pub [u8; 3]);

impl Color {
    /// Linear RGB, each in [0, 1].
    pub fn linear(self) -> [f32; 3] {
        self.0.map(|code| srgb_to_linear(f32::from(code) / 255.0))
    }
}

impl Leaf for Color {
    fn at(moment: Moment<'_>) -> Option<Color> {
        let code = |linear: f64| (linear_to_srgb(linear.clamp(0.0, 1.0) as f32) * 255.0).round() as u8;
        if let Moment::Color(linear) = moment { Some(Color(linear.map(code))) } else { None }
    }
}

impl TryFrom<String> for Color {
    type Error = String;
    fn try_from(text: String) -> Result<Color, String> {
        crate::shader::declare::hex_color(&text)
            .map(Color)
            .ok_or_else(|| format!("`{text}` is not a color; write #rrggbb, such as #d9a05f"))
    }
}

impl From<Color> for String {
    fn from(Color([r, g, b]): Color) -> String {
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}

/// Decodes the sRGB curve (IEC 61966-2-1); both in [0, 1].
pub fn srgb_to_linear(code: f32) -> f32 {
    if code <= 0.04045 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

/// Encodes the sRGB curve (IEC 61966-2-1); both in [0, 1].
pub fn linear_to_srgb(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}
