//! Search for the most different pixels.

/// The pixels in which two pictures of the same size differ most, in descending order, with the difference of their
/// worst channel; at most `count`, with more than `apart` pixels between any two in at least one direction.
pub fn worst(a: &[[f32; 4]], b: &[[f32; 4]], size: [u32; 2], count: usize, apart: u32) -> Vec<([u32; 2], f64)> {
    let apart_of = |(a, b): (&[f32; 4], &[f32; 4])| (0..4).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
    let mut differences: Vec<f32> = a.iter().zip(b).map(apart_of).collect();
    let width = size[0].max(1);
    let mut found = Vec::new();
    while found.len() < count {
        let largest = differences.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1));
        let Some((index, difference)) = largest.filter(|(_, difference)| **difference > 0.0) else { break };
        let [x, y] = [index as u32 % width, index as u32 / width];
        found.push(([x, y], f64::from(*difference)));
        for row in y.saturating_sub(apart)..=(y + apart).min(size[1].saturating_sub(1)) {
            for column in x.saturating_sub(apart)..=(x + apart).min(width - 1) {
                differences[(row * width + column) as usize] = 0.0;
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_worst_pixels_come_first_and_are_apart() {
        let size = [40u32, 30];
        let plain = vec![[0.25f32; 4]; 1200];
        let mut other = plain.clone();
        for ([x, y], by) in [([5, 5], 0.5), ([6, 6], 0.4), ([30, 20], 0.3), ([5, 25], -0.6)] {
            other[(y * size[0] + x) as usize][1] += by;
        }
        let found = worst(&plain, &other, size, 8, 4);
        let places: Vec<[u32; 2]> = found.iter().map(|(place, _)| *place).collect();
        assert_eq!(places, [[5, 25], [5, 5], [30, 20]], "the one beside the worst is left out");
        assert!((found[0].1 - 0.6).abs() < 1e-6);
        assert!(worst(&plain, &plain, size, 8, 4).is_empty());
        assert_eq!(worst(&plain, &other, size, 1, 4).len(), 1);
    }
}
