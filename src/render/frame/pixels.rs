//! Pixels of a target: averaged over sub-frames, and checked.

use crate::gpu::Area;
use crate::render::error::RenderError;

/// Mean of pictures; a single picture stays bit for bit.
#[derive(Default)]
pub(crate) struct Mean {
    first: Vec<[f32; 4]>,
    sum: Vec<[f64; 4]>,
    pub(crate) count: u32,
}

impl Mean {
    pub(crate) fn add(&mut self, pixels: Vec<[f32; 4]>) {
        self.count += 1;
        if self.count == 1 {
            self.first = pixels;
            return;
        }
        if self.count == 2 {
            self.sum = self.first.iter().map(|pixel| pixel.map(f64::from)).collect();
        }
        for (sum, pixel) in self.sum.as_flattened_mut().iter_mut().zip(pixels.as_flattened()) {
            *sum += f64::from(*pixel);
        }
    }

    pub(crate) fn of_all(self) -> Vec<[f32; 4]> {
        if self.count < 2 {
            return self.first;
        }
        let count = f64::from(self.count);
        self.sum.iter().map(|pixel| pixel.map(|channel| (channel / count) as f32)).collect()
    }
}

/// Returns an error for non-finite pixels of consecutive areas.
pub(crate) fn check_finite(pixels: &[[f32; 4]], areas: &[Area]) -> Result<(), RenderError> {
    let bad = |pixel: &&[f32; 4]| pixel.iter().any(|value| !value.is_finite());
    // The sum of zeros is NaN where a value is not finite, and is vectorized.
    let sum = |part: &[[f32; 4]]| part.iter().fold([0.0; 4], |sum, own| [0, 1, 2, 3].map(|c| sum[c] + 0.0 * own[c]));
    if pixels.chunks(1024).all(|part| sum(part) == [0.0; 4]) {
        return Ok(());
    }
    match pixels.iter().position(|pixel| bad(&pixel)) {
        None => Ok(()),
        Some(first) => {
            let (count, cause) = (pixels.iter().filter(bad).count(), "please report the scene".into());
            let (mut first, mut place) = (first, [0; 2]);
            for Area { columns, rows } in areas {
                place = [columns.start as usize + first % columns.len(), rows.start as usize + first / columns.len()];
                match first.checked_sub(columns.len() * rows.len()) {
                    Some(behind) => first = behind,
                    None => break,
                }
            }
            Err(RenderError::NotFinite { count, x: place[0], y: place[1], cause })
        }
    }
}

/// Copies the pixels of consecutive areas into a picture of this width.
pub fn paste_areas(pixels: &[[f32; 4]], areas: &[Area], width: u32, into: &mut [[f32; 4]]) {
    let mut left = pixels;
    for Area { columns, rows } in areas {
        for row in rows.clone() {
            let (own, rest) = left.split_at(columns.len());
            let start = row as usize * width as usize + columns.start as usize;
            into[start..start + columns.len()].copy_from_slice(own);
            left = rest;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_picture_is_its_own_mean() {
        let mean = |values: &[f32]| {
            let mut mean = Mean::default();
            values.iter().for_each(|value| mean.add(vec![[*value, 2.0 * value, 0.0, 1.0]]));
            mean.of_all()
        };
        assert_eq!(mean(&[0.1]), [[0.1, 0.2, 0.0, 1.0]]);
        assert_eq!(mean(&[1.0, 2.0, 6.0]), [[3.0, 6.0, 0.0, 1.0]]);
    }

    #[test]
    fn pixels_of_areas_are_put_where_they_belong_and_found_there() {
        let areas = [Area { columns: 1..3, rows: 0..2 }, Area { columns: 0..1, rows: 1..3 }];
        let mut pixels: Vec<[f32; 4]> = (1..=6).map(|index| [index as f32; 4]).collect();
        let mut picture = vec![[0.0; 4]; 9];
        paste_areas(&pixels, &areas, 3, &mut picture);
        let first: Vec<f32> = picture.iter().map(|pixel| pixel[0]).collect();
        assert_eq!(first, [0.0, 1.0, 2.0, 5.0, 3.0, 4.0, 6.0, 0.0, 0.0]);
        assert!(check_finite(&pixels, &areas).is_ok());
        for (index, place) in [[1, 0], [2, 0], [1, 1], [2, 1], [0, 1], [0, 2]].into_iter().enumerate() {
            let before = std::mem::replace(&mut pixels[index], [f32::NAN; 4]);
            let error = check_finite(&pixels, &areas).unwrap_err();
            assert!(matches!(error, RenderError::NotFinite { count: 1, x, y, .. } if [x, y] == place), "{error}");
            pixels[index] = before;
        }
    }
}
