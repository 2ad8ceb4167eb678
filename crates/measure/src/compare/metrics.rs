//! Errors of a picture against its reference: of linear light, and of the encoded picture (sRGB over the background) as a
//! person sees it.

use super::ssim::ssim;
use crate::metric::Errors;
use crate::reference::Reference;
use crate::statistics::{mean, quantile};
use hypertexture::scene::{Color, linear_to_srgb};
use nv_flip::{DEFAULT_PIXELS_PER_DEGREE, FlipImageRgb8, flip};
use serde::Serialize;

/// Implementation of FLIP, whose values differ slightly between implementations and platforms.
pub const FLIP: &str = "nv-flip 0.1.2, 67 pixels per degree";
/// Bounds the relative error of dark pixels.
const RELATIVE_EPSILON: f64 = 1e-2;

/// Errors of a picture against its reference.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Metrics {
    /// Errors of premultiplied linear RGBA.
    #[serde(flatten)]
    pub errors: Errors,
    /// Root mean square error against a reference with only the octaves of the candidate's turbulence; `None` without such
    /// a reference.
    pub own_rmse: Option<f64>,
    /// Mean of d^2 / (t^2 + 0.01) over R, G and B, d the error and t the reference.
    pub relative_mse: f64,
    /// Peak signal-to-noise ratio of the encoded picture, dB; infinite for equal pictures.
    pub psnr: f64,
    /// Structural similarity of the lightness of the encoded picture; 1 for equal pictures.
    pub ssim: f64,
    /// Mean of FLIP, 0 to 1.
    pub flip: f64,
    /// 99th percentile of FLIP.
    pub flip_p99: f64,
    /// Number of channels that are NaN or infinite.
    pub not_finite: usize,
}

impl Metrics {
    /// Compares a picture (premultiplied linear RGBA) with a reference of the same size, over a background where encoded.
    pub fn of(pixels: &[[f32; 4]], reference: &Reference, background: Color) -> Metrics {
        let truth = &reference.pixels;
        let errors = Errors::between(pixels, truth);
        let pixels: Vec<[f64; 4]> = pixels.iter().map(|pixel| pixel.map(f64::from)).collect();
        let not_finite = pixels.as_flattened().iter().filter(|value| !value.is_finite()).count();
        let colors = pixels.iter().zip(truth).flat_map(|(a, b)| (0..3).map(|c| (a[c] - b[c], b[c])));
        let encoded = [&pixels, truth].map(|pixels| encode(pixels, background));
        let [found_codes, truth_codes] = &encoded;
        let mse = mean(found_codes.as_flattened().iter().zip(truth_codes.as_flattened()).map(|(a, b)| (a - b).powi(2)));
        let [found_luma, truth_luma] = encoded.each_ref().map(|codes| luma(codes));
        let flips = flips(truth_codes, found_codes, reference.size);
        Metrics {
            errors,
            own_rmse: Some(errors.rmse),
            relative_mse: mean(colors.map(|(d, t)| d * d / (t * t + RELATIVE_EPSILON))),
            psnr: -10.0 * mse.log10(),
            ssim: ssim(&found_luma, &truth_luma, reference.size[0] as usize),
            flip: mean(flips.iter().copied()),
            flip_p99: quantile(flips, 0.99),
            not_finite,
        }
    }
}

/// Angles between the normals of two pictures.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Angles {
    /// Mean angle, degrees.
    pub mean: f64,
    /// 99th percentile of the angle, degrees.
    pub p99: f64,
}

/// Angles between the normals of two pictures (colors 0.5 + 0.5 n) in the pixels where both show a surface; `None` without
/// such pixels.
pub fn normal_angles(found: &[[f32; 4]], truth: &[[f32; 4]]) -> Option<Angles> {
    let normal = |pixel: &[f32; 4]| {
        let opaque = pixel[3] > 0.999;
        opaque.then(|| [0, 1, 2].map(|c| 2.0 * f64::from(pixel[c]) - 1.0))
    };
    let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|c| a[c] * b[c]).sum::<f64>();
    let cross =
        |a: [f64; 3], b: [f64; 3]| [0, 1, 2].map(|c| a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3]);
    // The arc cosine would lose all digits at small angles.
    let angle = |(a, b): ([f64; 3], [f64; 3])| dot(cross(a, b), cross(a, b)).sqrt().atan2(dot(a, b)).to_degrees();
    let angles: Vec<f64> =
        found.iter().zip(truth).filter_map(|(a, b)| Some((normal(a)?, normal(b)?))).map(angle).collect();
    (!angles.is_empty()).then(|| Angles { mean: mean(angles.iter().copied()), p99: quantile(angles, 0.99) })
}

/// sRGB codes in \[0, 1\] of premultiplied linear pixels over a background.
pub fn encode(pixels: &[[f64; 4]], background: Color) -> Vec<[f64; 3]> {
    let behind = background.linear().map(f64::from);
    let code = |linear: f64| f64::from(linear_to_srgb(linear.clamp(0.0, 1.0) as f32));
    pixels.iter().map(|pixel| [0, 1, 2].map(|c| code(pixel[c] + behind[c] * (1.0 - pixel[3])))).collect()
}

/// Codes as bytes, three for each pixel.
pub fn bytes(codes: &[[f64; 3]]) -> Vec<u8> {
    codes.as_flattened().iter().map(|code| (code * 255.0).round() as u8).collect()
}

/// Luma of encoded pixels with the weights of ITU-R BT.601, as is usual for SSIM.
fn luma(codes: &[[f64; 3]]) -> Vec<f64> {
    codes.iter().map(|[r, g, b]| 0.299 * r + 0.587 * g + 0.114 * b).collect()
}

/// FLIP of each pixel.
fn flips(truth: &[[f64; 3]], found: &[[f64; 3]], [width, height]: [u32; 2]) -> Vec<f64> {
    let image = |codes: &[[f64; 3]]| FlipImageRgb8::with_data(width, height, &bytes(codes));
    let map = flip(image(truth), image(found), DEFAULT_PIXELS_PER_DEGREE);
    map.to_vec().into_iter().map(f64::from).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reference(size: [u32; 2], pixel: impl Fn(u32) -> [f64; 4]) -> Reference {
        let pixels: Vec<_> = (0..size[0] * size[1]).map(pixel).collect();
        Reference { size, estimate: vec![0.0; pixels.len()], open: vec![0.0; pixels.len()], pixels }
    }

    fn single(pixels: &[[f64; 4]]) -> Vec<[f32; 4]> {
        pixels.iter().map(|pixel| pixel.map(|channel| channel as f32)).collect()
    }

    const BLACK: Color = Color([0; 3]);

    #[test]
    fn a_picture_has_no_error_against_itself() {
        let truth = reference([16, 16], |i| [f64::from(i) / 512.0, 0.25, 0.5, 1.0]);
        let m = Metrics::of(&single(&truth.pixels), &truth, BLACK);
        assert_eq!((m.errors, m.flip, m.not_finite), (Errors::default(), 0.0, 0));
        assert!(m.psnr.is_infinite() && (m.ssim - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_shift_has_the_error_of_the_shift() {
        let truth = reference([20, 20], |_| [0.25, 0.25, 0.25, 0.5]);
        let shifted: Vec<_> = truth.pixels.iter().map(|_| [0.375, 0.375, 0.375, 0.75]).collect();
        let m = Metrics::of(&single(&shifted), &truth, BLACK);
        assert_eq!((m.errors.rgb_rmse, m.errors.opacity_rmse, m.errors.max, m.errors.p999), (0.125, 0.25, 0.25, 0.25));
        assert!((m.relative_mse - 0.125f64.powi(2) / (0.0625 + 1e-2)).abs() < 1e-12);
        let codes = [0.25, 0.375].map(|linear| f64::from(linear_to_srgb(linear)));
        assert!((m.psnr + 20.0 * (codes[1] - codes[0]).log10()).abs() < 1e-9);
        let ssim = (2.0 * codes[0] * codes[1] + 1e-4) / (codes[0].powi(2) + codes[1].powi(2) + 1e-4);
        assert!((m.ssim - ssim).abs() < 1e-9);
        assert!(m.flip > 0.05 && m.flip < 0.5, "{}", m.flip);
    }

    #[test]
    fn one_bad_pixel_raises_the_largest_error_not_the_mean() {
        let truth = reference([40, 40], |_| [0.0, 0.0, 0.0, 1.0]);
        let mut pixels = single(&truth.pixels);
        pixels[77] = [1.0, 0.0, 0.0, 1.0];
        let m = Metrics::of(&pixels, &truth, BLACK);
        assert_eq!((m.errors.max, m.errors.p999), (1.0, 0.0)); // one pixel of 1600
        assert!((m.errors.rgb_rmse - (1.0f64 / 4800.0).sqrt()).abs() < 1e-12);
        pixels[78][1] = f32::NAN;
        assert_eq!(Metrics::of(&pixels, &truth, BLACK).not_finite, 1);
    }

    #[test]
    fn the_background_shows_where_a_picture_is_transparent() {
        let codes = encode(&[[0.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0]], Color([51, 102, 255]));
        assert_eq!(bytes(&codes), [51, 102, 255, 0, 0, 0]);
    }

    #[test]
    fn turned_normals_have_the_angle_of_the_turn() {
        let color = |n: [f32; 3], alpha: f32| [0.5 + 0.5 * n[0], 0.5 + 0.5 * n[1], 0.5 + 0.5 * n[2], alpha];
        let turned = 0.5f32.to_radians();
        let truth = [color([0.0, 0.0, 1.0], 1.0), color([1.0, 0.0, 0.0], 1.0), color([0.0; 3], 0.0)];
        let found = [color([turned.sin(), 0.0, turned.cos()], 1.0), color([0.0, 1.0, 0.0], 1.0), truth[0]];
        let angles = normal_angles(&found, &truth).unwrap();
        assert!((angles.mean - 0.5 * (90.0 + 0.5)).abs() < 1e-4 && (angles.p99 - 90.0).abs() < 1e-6, "{angles:?}");
        assert_eq!(normal_angles(&found[2..], &truth[2..]), None);
    }
}
