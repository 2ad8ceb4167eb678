//! How a picture gets on the screen: its colors and its place.

use crate::scene::{Color, linear_to_srgb};
use egui::{Align2, Color32, ColorImage, FontId, Pos2, Rect, Stroke, TextureHandle, TextureOptions, Ui, Vec2};
use rayon::prelude::*;
use std::sync::LazyLock;

/// What is behind a picture without a background.
const BEHIND: [u8; 3] = [22, 23, 26];
/// How many times the difference of two variants is enlarged to be seen.
const GAIN: f32 = 8.0;
/// Entries of the table of codes, by the square root of the light: the darkest codes are the closest.
const TABLE: usize = 4096;

/// Codes of linear light, by its square root.
static CODES: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let code = |index: usize| {
        let root = (index as f32 + 0.5) / TABLE as f32;
        (linear_to_srgb(root * root) * 255.0).round() as u8
    };
    (0..TABLE).map(code).collect()
});

fn code(linear: f32) -> u8 {
    CODES[((linear.clamp(0.0, 1.0).sqrt() * TABLE as f32) as usize).min(TABLE - 1)]
}

/// Pictures over their backgrounds as codes; of two, also what lies between them, enlarged, and its root mean square.
pub(super) fn encode_srgb(
    frames: &[&[[f32; 4]]],
    backgrounds: &[Option<Color>],
    size: [u32; 2],
) -> (Vec<ColorImage>, Option<f64>) {
    let size = size.map(|side| side as usize);
    let opaque = |frame: &[[f32; 4]], background: Option<Color>| -> Vec<[f32; 3]> {
        let behind = background.unwrap_or(Color(BEHIND)).linear();
        let over = |pixel: &[f32; 4]| [0, 1, 2].map(|c| pixel[c] + (1.0 - pixel[3]) * behind[c]);
        frame.par_iter().map(over).collect()
    };
    let image = |light: &[[f32; 3]]| {
        let pixels = light.par_iter().map(|&[r, g, b]| Color32::from_rgb(code(r), code(g), code(b)));
        ColorImage::new(size, pixels.collect())
    };
    let lights: Vec<_> = frames.iter().zip(backgrounds).map(|(frame, behind)| opaque(frame, *behind)).collect();
    let mut images: Vec<ColorImage> = lights.iter().map(|light| image(light)).collect();
    let [a, b] = lights.as_slice() else { return (images, None) };
    let apart: Vec<[f32; 3]> =
        a.par_iter().zip(b).map(|(a, b)| [0, 1, 2].map(|c| GAIN * (a[c] - b[c]).abs())).collect();
    images.push(image(&apart));
    (images, Some(crate::measure::statistics::rms_difference(frames[0], frames[1])))
}

/// The pictures on the screen.
#[derive(Default)]
pub(super) struct Screen {
    textures: Vec<TextureHandle>,
    /// What came and is not a texture yet, or was one of a device that is gone.
    images: Vec<ColorImage>,
    fresh: bool,
}

impl Screen {
    /// Takes the images of a picture.
    pub(super) fn take(&mut self, images: Vec<ColorImage>) {
        self.images = images;
        self.fresh = true;
    }

    /// Forgets the textures: their device is gone.
    pub(super) fn forget(&mut self) {
        self.textures.clear();
        self.fresh = true;
    }

    /// Width and height in points of one of so many pictures in a place.
    pub(super) fn pane(place: Rect, compared: bool) -> Vec2 {
        Vec2::new(if compared { (place.width() / 3.0).floor() } else { place.width() }, place.height())
    }

    /// Draws the pictures; two have these titles.
    pub(super) fn draw(&mut self, ui: &Ui, place: Rect, difference: Option<f64>, titles: &[String; 2]) {
        if std::mem::take(&mut self.fresh) {
            for (index, image) in self.images.iter().enumerate() {
                match self.textures.get_mut(index) {
                    Some(texture) => texture.set(image.clone(), TextureOptions::LINEAR),
                    None => {
                        let name = format!("picture {index}");
                        self.textures.push(ui.ctx().load_texture(name, image.clone(), TextureOptions::LINEAR));
                    }
                }
            }
            self.textures.truncate(self.images.len());
        }
        let painter = ui.painter_at(place);
        painter.rect_filled(place, 0.0, Color32::from_rgb(BEHIND[0], BEHIND[1], BEHIND[2]));
        let compared = self.textures.len() > 1;
        let pane = Screen::pane(place, compared);
        let whole = Rect::from_min_max(Pos2::ZERO, Pos2::new(1.0, 1.0));
        for (index, texture) in self.textures.iter().enumerate() {
            let corner = place.min + Vec2::new(index as f32 * pane.x, 0.0);
            let rect = Rect::from_min_size(corner, pane);
            painter.image(texture.id(), rect, whole, Color32::WHITE);
            if compared {
                let rms = difference.map_or(String::new(), |rms| format!(", RMS {}", scientific(rms)));
                let title = titles.get(index).cloned();
                let title = title.unwrap_or_else(|| format!("difference \u{d7} {GAIN}{rms}"));
                let at = rect.left_top() + Vec2::new(10.0, 10.0);
                painter.text(at, Align2::LEFT_TOP, title, FontId::proportional(13.0), Color32::from_gray(210));
                painter.line_segment([rect.right_top(), rect.right_bottom()], Stroke::new(1.0, Color32::from_gray(60)));
            }
        }
    }
}

/// A number with one digit before the point and one behind it.
fn scientific(value: f64) -> String {
    format!("{value:.1e}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_table_of_codes_is_right_to_a_code() {
        for step in 0..=10_000 {
            let linear = step as f32 / 10_000.0;
            let exact = (linear_to_srgb(linear) * 255.0).round();
            assert!((f32::from(code(linear)) - exact).abs() <= 1.0, "{linear}");
        }
        assert_eq!([code(-1.0), code(0.0), code(1.0), code(9.0)], [0, 0, 255, 255]);
    }

    #[test]
    fn two_variants_have_a_difference_and_one_has_none() {
        let (a, b) = (vec![[0.5, 0.5, 0.5, 1.0]; 4], vec![[0.5, 0.5, 0.6, 1.0]; 4]);
        let (one, none) = encode_srgb(&[&a], &[None], [2, 2]);
        assert_eq!((one.len(), none), (1, None));
        let (three, rms) = encode_srgb(&[&a, &b], &[None, None], [2, 2]);
        assert_eq!(three.len(), 3);
        assert_eq!(three[2].pixels[0], Color32::from_rgb(0, 0, code(0.8)));
        assert!((rms.unwrap() - 0.05).abs() < 1e-6);
    }
}
