//! The pixels of a target: read, summed over sub-frames, and checked.

use super::RenderError;
use crate::scene::TargetFormat;

/// Adds a picture to a sum of pictures.
pub(super) fn add(sum: &mut [[f64; 4]], pixels: &[[f32; 4]]) {
    for (sum, pixel) in sum.as_flattened_mut().iter_mut().zip(pixels.as_flattened()) {
        *sum += f64::from(*pixel);
    }
}

/// The mean of the pictures of a sum.
pub(super) fn mean(sum: &[[f64; 4]], count: u32) -> Vec<[f32; 4]> {
    sum.iter().map(|pixel| pixel.map(|channel| (channel / f64::from(count)) as f32)).collect()
}

/// The texels of a target of 32-bit floats.
pub(super) fn floats(bytes: &[u8]) -> Vec<[f32; 4]> {
    let texels = bytes.as_chunks::<16>().0.iter();
    texels.map(|texel| std::array::from_fn(|c| f32::from_ne_bytes([0, 1, 2, 3].map(|b| texel[4 * c + b])))).collect()
}

/// The texels of a target as floats.
pub(super) fn decode(bytes: &[u8], format: TargetFormat) -> Vec<[f32; 4]> {
    match format {
        TargetFormat::Float32 => floats(bytes),
        TargetFormat::Float16 => bytes
            .chunks_exact(8)
            .map(|texel| std::array::from_fn(|c| half::f16::from_ne_bytes([texel[2 * c], texel[2 * c + 1]]).to_f32()))
            .collect(),
        TargetFormat::Unorm8 => {
            bytes.chunks_exact(4).map(|texel| std::array::from_fn(|c| f32::from(texel[c]) / 255.0)).collect()
        }
    }
}

/// Refuses pixels that are no numbers.
pub(super) fn check_finite(pixels: &[[f32; 4]], width: usize) -> Result<(), RenderError> {
    let bad = |pixel: &&[f32; 4]| pixel.iter().any(|value| !value.is_finite());
    match pixels.iter().position(|pixel| bad(&pixel)) {
        None => Ok(()),
        Some(first) => {
            Err(RenderError::NotFinite { count: pixels.iter().filter(bad).count(), x: first % width, y: first / width })
        }
    }
}
