//! Pictures in a page: PNG as text, and heat maps of differences.

use crate::compare::metrics::{bytes, encode};
use crate::statistics::largest;
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use hypertexture::render::Frame;
use hypertexture::scene::Color;

/// The errors at the ends of the scale of heat maps, which is logarithmic.
pub(crate) const HEAT: [f64; 2] = [1e-5, 1.0];

/// Black, purple, orange, pale yellow at equal steps (after the magma of matplotlib): light everywhere means error.
const MAGMA: [[u8; 3]; 9] = [
    [0, 0, 4],
    [28, 16, 68],
    [79, 18, 123],
    [129, 37, 129],
    [181, 54, 122],
    [229, 80, 100],
    [251, 135, 97],
    [254, 194, 135],
    [252, 253, 191],
];

/// Pixels over a background as the address of an `img` element.
pub(crate) fn address_of(pixels: &[[f64; 4]], size: [u32; 2], background: Color) -> String {
    address(size, &bytes(&encode(pixels, background)))
}

/// A picture over a background as the address of an `img` element.
pub fn picture(frame: &Frame, background: Color) -> String {
    let pixels: Vec<[f64; 4]> = frame.pixels.iter().map(|pixel| pixel.map(f64::from)).collect();
    address_of(&pixels, frame.size, background)
}

/// A map of the largest difference of any channel of premultiplied linear RGBA of each pixel.
pub(crate) fn heat_map(found: &Frame, truth: &[[f64; 4]]) -> String {
    address(found.size, &colors(&found.pixels, truth))
}

/// The same of a picture, as a PNG.
pub fn heat_png(found: &[[f32; 4]], truth: &[[f64; 4]], size: [u32; 2]) -> Vec<u8> {
    png_of(size, &colors(found, truth))
}

/// A color for each two pixels.
fn colors(found: &[[f32; 4]], truth: &[[f64; 4]]) -> Vec<u8> {
    let difference = |a: &[f32; 4], b: &[f64; 4]| largest((0..4).map(|c| (f64::from(a[c]) - b[c]).abs()));
    found.iter().zip(truth).flat_map(|(a, b)| heat(difference(a, b))).collect()
}

/// The scale of the heat maps, one pixel high.
pub fn scale() -> String {
    const WIDTH: u32 = 256;
    let [low, high] = HEAT;
    let error = |x: u32| low * (high / low).powf(f64::from(x) / f64::from(WIDTH - 1));
    let colors: Vec<u8> = (0..WIDTH).flat_map(|x| heat(error(x))).collect();
    address([WIDTH, 1], &colors)
}

/// The color of an error; NaN has that of the largest.
fn heat(error: f64) -> [u8; 3] {
    let [low, high] = HEAT;
    let error = if error.is_nan() { high } else { error };
    let share = ((error / low).max(1.0).ln() / (high / low).ln()).clamp(0.0, 1.0) * (MAGMA.len() - 1) as f64;
    let index = (share as usize).min(MAGMA.len() - 2);
    let part = share - index as f64;
    let mix = |c: usize| f64::from(MAGMA[index][c]) * (1.0 - part) + f64::from(MAGMA[index + 1][c]) * part;
    [0, 1, 2].map(|c| mix(c).round() as u8)
}

/// An RGB picture as an address that holds it whole.
fn address(size: [u32; 2], rgb: &[u8]) -> String {
    format!("data:image/png;base64,{}", STANDARD.encode(png_of(size, rgb)))
}

/// An RGB picture as a PNG: three bytes a pixel, sRGB.
pub fn png_of(size: [u32; 2], rgb: &[u8]) -> Vec<u8> {
    let mut file = Vec::new();
    let mut encoder = png::Encoder::new(&mut file, size[0], size[1]);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    let written = encoder.write_header().and_then(|mut writer| writer.write_image_data(rgb));
    written.expect("memory takes every byte, and there are three for each pixel");
    file
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decode(address: &str) -> image::RgbImage {
        let file = STANDARD.decode(address.strip_prefix("data:image/png;base64,").unwrap()).unwrap();
        image::load_from_memory(&file).unwrap().to_rgb8()
    }

    #[test]
    fn a_picture_comes_back_out_of_its_address() {
        let image = decode(&address_of(&[[1.0, 0.0, 0.0, 1.0], [0.0; 4]], [2, 1], Color([10, 20, 30])));
        assert_eq!([image.get_pixel(0, 0).0, image.get_pixel(1, 0).0], [[255, 0, 0], [10, 20, 30]]);
    }

    #[test]
    fn heat_grows_with_the_logarithm_of_the_error() {
        assert_eq!([0.0, HEAT[0], HEAT[1], 7.0].map(heat), [MAGMA[0], MAGMA[0], MAGMA[8], MAGMA[8]]);
        assert_eq!(heat((HEAT[0] * HEAT[1]).sqrt()), MAGMA[4]);
        assert_eq!(colors(&[[0.0, 0.5, 0.0, 1.0]], &[[0.0, 1.5, 0.0, 0.0]]), MAGMA[8]);
        let scale = decode(&scale());
        assert_eq!((scale.get_pixel(0, 0).0, scale.get_pixel(255, 0).0), (MAGMA[0], MAGMA[8]));
    }
}
