//! Ranges of an image over boxes of many texels: a pyramid of minima and maxima.

use rayon::prelude::*;

/// Longest side of a box whose elements are visited one by one.
pub(crate) const FEW: usize = 3;

/// Minima and maxima of cubes with sides of 2, 4, 8 and more texels.
#[derive(Debug)]
pub(crate) struct Pyramid {
    levels: Vec<Level>,
}

#[derive(Debug)]
struct Level {
    size: [usize; 3],
    ranges: Vec<Extremes>,
}

/// Minimum and maximum of each channel.
pub(crate) type Extremes = [[f32; 4]; 2];

/// The extremes of a range of elements of a grid.
pub(crate) fn range(size: [usize; 3], [x, y, z]: [[usize; 2]; 3], at: impl Fn(usize) -> Extremes) -> Extremes {
    let [mut least, mut most] = [[f32::INFINITY; 4], [f32::NEG_INFINITY; 4]];
    for k in z[0]..=z[1] {
        for j in y[0]..=y[1] {
            let row = (k * size[1] + j) * size[0];
            for index in row + x[0]..=row + x[1] {
                let [low, high] = at(index);
                for channel in 0..4 {
                    least[channel] = least[channel].min(low[channel]);
                    most[channel] = most[channel].max(high[channel]);
                }
            }
        }
    }
    [least, most]
}

impl Level {
    /// The level above a grid.
    fn over(size: [usize; 3], at: impl Fn(usize) -> Extremes + Sync) -> Level {
        let of = |index: usize, axis: usize| [2 * index, (2 * index + 1).min(size[axis] - 1)];
        let halved = size.map(|side| side.div_ceil(2));
        let row = |row: usize| {
            let [y, z] = [row % halved[1], row / halved[1]];
            let range = |x| range(size, [of(x, 0), of(y, 1), of(z, 2)], &at);
            (0..halved[0]).map(range).collect::<Vec<_>>()
        };
        let rows: Vec<Vec<Extremes>> = (0..halved[1] * halved[2]).into_par_iter().map(row).collect();
        Level { size: halved, ranges: rows.concat() }
    }
}

impl Pyramid {
    pub(crate) fn new(size: [u32; 3], texels: &[[f32; 4]]) -> Pyramid {
        let mut levels = vec![Level::over(size.map(|side| side as usize), |index| [texels[index]; 2])];
        while let Some(last) = levels.last().filter(|level| level.size.iter().any(|side| *side > 1)) {
            levels.push(Level::over(last.size, |index| last.ranges[index]));
        }
        Pyramid { levels }
    }

    /// The range over a box of texels with this longest side, from one level: at most four cubes along each axis.
    pub(crate) fn range(&self, of: [[usize; 2]; 3], longest: usize) -> Extremes {
        let level = (1..self.levels.len()).find(|level| longest >> level < FEW).unwrap_or(self.levels.len());
        let Level { size, ranges } = &self.levels[level - 1];
        range(*size, of.map(|ends| ends.map(|index| index >> level)), |index| ranges[index])
    }
}
