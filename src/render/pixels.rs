//! The pixels of a target: summed over sub-frames, and checked.

use super::RenderError;

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

/// Refuses pixels that are no numbers.
pub(super) fn check_finite(pixels: &[[f32; 4]], width: usize) -> Result<(), RenderError> {
    let bad = |pixel: &&[f32; 4]| pixel.iter().any(|value| !value.is_finite());
    match pixels.iter().position(|pixel| bad(&pixel)) {
        None => Ok(()),
        Some(first) => {
            let (count, cause) = (pixels.iter().filter(bad).count(), "please report the scene".into());
            Err(RenderError::NotFinite { count, x: first % width, y: first / width, cause })
        }
    }
}
