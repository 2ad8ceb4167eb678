//! Images: linear filtering at a point, and the range over a box of coordinates.
//!
//! Texel i of n is centered at (i + 0.5) / n. Filter weights are not rounded as in hardware.

use crate::pyramid::{FEW, Pyramid, range};
use hypertexture_noise::{Knots, Lattice, NOISE_BOUND};
use std::sync::OnceLock;

/// Address mode for coordinates outside [0, 1].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// The nearest texel of the edge.
    Clamp,
    /// Repetition.
    Repeat,
    /// Repetition, every other one mirrored.
    Mirror,
}

/// Decoded texels, x fastest. The size of a 1D image is `[n, 1, 1]`, that of a 2D image `[n, m, 1]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Number of texels along each axis.
    pub size: [u32; 3],
    /// RGBA of each texel. Coarser levels may follow, each of half the size.
    pub texels: Vec<[f32; 4]>,
}

/// A bound image.
#[derive(Debug)]
pub struct Image<'a> {
    pub(crate) size: [u32; 3],
    texels: &'a [[f32; 4]],
    pub(crate) wrap: Wrap,
    /// Number of axes: 1, 2 or 3.
    pub(crate) axes: usize,
    /// The next coarser level.
    coarser: Option<Box<Image<'a>>>,
    /// Ranges over boxes, built at the first lookup of a large one.
    pyramid: OnceLock<Pyramid>,
    /// Bound of the difference between a texel and that of a device.
    pub(crate) slack: f64,
    /// Noise in place of texels.
    pub(crate) noise: Option<Lattice>,
}

/// Number of texels of one level.
pub(crate) fn count(size: [u32; 3]) -> usize {
    size.iter().map(|side| *side as usize).product()
}

/// Size of the next coarser level.
pub(crate) fn halved(size: [u32; 3]) -> [u32; 3] {
    size.map(|side| (side / 2).max(1))
}

/// The two texels around a coordinate, and the distance from the first.
fn place(coordinate: f64, count: u32, wrap: Wrap) -> ([usize; 2], f64) {
    let n = f64::from(count);
    let x = coordinate * n - 0.5;
    let x = if wrap == Wrap::Clamp { x.clamp(-1.0, n) } else { x };
    // `floor` would be a function call.
    let low = if x.abs() < 1e15 {
        let whole = (x as i64) as f64;
        if whole > x { whole - 1.0 } else { whole }
    } else {
        x.floor()
    };
    let first = low as i64;
    ([wrapped(first, count, wrap), wrapped(first + 1, count, wrap)], x - low)
}

/// The texel of an index in an address mode.
fn wrapped(index: i64, count: u32, wrap: Wrap) -> usize {
    let n = i64::from(count);
    let index = match wrap {
        _ if 0 <= index && index < n => index,
        Wrap::Clamp => index.clamp(0, n - 1),
        Wrap::Repeat if n & (n - 1) == 0 => index & (n - 1),
        Wrap::Repeat => index.rem_euclid(n),
        Wrap::Mirror => {
            let index = index.rem_euclid(2 * n);
            if index < n { index } else { 2 * n - 1 - index }
        }
    };
    index as usize
}

impl<'a> Image<'a> {
    /// An image from the texels of all its levels.
    pub(crate) fn new(size: [u32; 3], texels: &'a [[f32; 4]], wrap: Wrap, axes: usize, slack: f64) -> Image<'a> {
        let (texels, rest) = texels.split_at(count(size));
        let coarser = (!rest.is_empty()).then(|| Box::new(Image::new(halved(size), rest, wrap, axes, slack)));
        Image { size, texels, wrap, axes, coarser, pyramid: OnceLock::new(), slack, noise: None }
    }

    /// An image of noise; its levels select the knots.
    pub(crate) fn of_noise(noise: Lattice) -> Image<'a> {
        Image { noise: Some(noise), ..Image::new([0; 3], &[], Wrap::Repeat, 3, 0.0) }
    }

    /// The channels at a point; fractional levels are interpolated.
    pub(crate) fn sample_level(&self, at: [f64; 3], level: f64) -> [f64; 4] {
        if let Some(noise) = self.noise {
            let ([x, y, z], value) = noise.sample_of(Knots::of_level(level), at);
            return [x, y, z, value];
        }
        match &self.coarser {
            Some(coarser) if level >= 1.0 => coarser.sample_level(at, level - 1.0),
            Some(coarser) if level > 0.0 => {
                let [fine, coarse] = [self, coarser].map(|image| image.sample(at));
                [0, 1, 2, 3].map(|c| fine[c] + level * (coarse[c] - fine[c]))
            }
            _ => self.sample(at),
        }
    }

    /// Bounds of the wanted channels over a box of coordinates and levels; others may be 0.
    pub(crate) fn range_levels(&self, within: [[f64; 2]; 3], levels: [f64; 2], wanted: [bool; 4]) -> [[f64; 2]; 4] {
        if let Some(noise) = self.noise {
            let ends = |end: usize| within.map(|within| within[end]);
            let knots = (levels[0] == levels[1]).then(|| Knots::of_level(levels[0]));
            let value = match knots {
                Some(knots) if wanted[3] => noise.range(knots, ends(0), ends(1)),
                _ => [-NOISE_BOUND, NOISE_BOUND],
            };
            let steepest = knots.unwrap_or(Knots::Values).steepest();
            let slope = [-steepest, steepest];
            return [slope, slope, slope, value];
        }
        match &self.coarser {
            Some(coarser) if levels[0] >= 1.0 => coarser.range_levels(within, levels.map(|level| level - 1.0), wanted),
            Some(coarser) if levels[1] > 0.0 || levels[1].is_nan() => {
                let mut all = self.range(within, wanted);
                include(&mut all, coarser.range_levels(within, levels.map(|level| level - 1.0), wanted));
                all
            }
            _ => self.range(within, wanted),
        }
    }

    pub(crate) fn texel(&self, at: [usize; 3]) -> [f32; 4] {
        let [x, y, _] = self.size.map(|side| side as usize);
        self.texels[(at[2] * y + at[1]) * x + at[0]]
    }

    /// The channels at a point of the finest level.
    pub(crate) fn sample(&self, at: [f64; 3]) -> [f64; 4] {
        // Offsets and weights of the two texels along each axis.
        let (mut places, mut weights, mut counts) = ([[0; 2]; 3], [[1.0; 2]; 3], [1; 3]);
        let mut stride = 1;
        for axis in 0..self.axes {
            let (texels, part) = place(at[axis], self.size[axis], self.wrap);
            (places[axis], weights[axis], counts[axis]) =
                ([stride * texels[0], stride * texels[1]], [1.0 - part, part], 2);
            stride *= self.size[axis] as usize;
        }
        let mut sum = [0.0; 4];
        for z in 0..counts[2] {
            for y in 0..counts[1] {
                for x in 0..counts[0] {
                    let weight = weights[0][x] * weights[1][y] * weights[2][z];
                    let texel = self.texels[places[0][x] + places[1][y] + places[2][z]];
                    for channel in 0..4 {
                        sum[channel] += weight * f64::from(texel[channel]);
                    }
                }
            }
        }
        sum
    }

    /// Bounds of the wanted channels over a box of coordinates; others may be 0.
    pub(crate) fn range(&self, within: [[f64; 2]; 3], wanted: [bool; 4]) -> [[f64; 2]; 4] {
        let axes = [0, 1, 2].map(|axis| {
            if axis < self.axes { Crossed::of(within[axis], self.size[axis], self.wrap) } else { Some(POINT) }
        });
        if let [Some(x), Some(y), Some(z)] = axes {
            let axes = [x, y, z];
            // A single channel has a faster path.
            return match wanted.map(usize::from) {
                [0, 0, 0, 0] => [[0.0; 2]; 4],
                [r, g, b, a] if r + g + b + a == 1 => {
                    let channel = g + 2 * b + 3 * a;
                    let [found] = self.extremes(&axes, |texel| [texel[channel]]);
                    [0, 1, 2, 3].map(|other| if other == channel { found } else { [0.0; 2] })
                }
                _ => self.extremes(&axes, |texel| texel),
            };
        }
        let mut ranges = [[[0, 0]; 2]; 3];
        let mut counts = [1; 3];
        for axis in 0..self.axes {
            let count = self.size[axis];
            let [from, to] = scaled(within[axis], count).map(f64::floor);
            (ranges[axis], counts[axis]) = self.indices(from, to + 1.0, count);
        }
        let mut all = [[f64::INFINITY, f64::NEG_INFINITY]; 4];
        for choice in 0..counts.iter().product() {
            let pick = [choice % counts[0], choice / counts[0] % counts[1], choice / counts[0] / counts[1]];
            let of = [0, 1, 2].map(|axis| ranges[axis][pick[axis]]);
            include(&mut all, self.texels(of));
        }
        // The rounding of a weighted mean.
        all.map(|[low, high]| {
            let margin = 16.0 * f64::EPSILON * low.abs().max(high.abs());
            [low - margin, high + margin]
        })
    }

    /// The only cell that a box of coordinates meets: index of its first texel, and its corners, x fastest.
    pub(crate) fn cell(&self, within: [[f64; 2]; 3]) -> Option<([f64; 3], [[f32; 4]; 8])> {
        let mut base = [0.0; 3];
        let mut ends = [[0; 2]; 3];
        for axis in 0..self.axes {
            let [from, to] = scaled(within[axis], self.size[axis]).map(f64::floor);
            if from != to || from.abs() >= 1e15 {
                return None;
            }
            base[axis] = from;
            ends[axis] = [0, 1].map(|step| wrapped(from as i64 + step, self.size[axis], self.wrap));
        }
        let corner = |corner: usize| self.texel([0, 1, 2].map(|axis| ends[axis][corner >> axis & 1]));
        Some((base, [0, 1, 2, 3, 4, 5, 6, 7].map(corner)))
    }

    /// Ranges of channels over a box of few cells. Filtering is multilinear in each, so the extremes are at corners of the
    /// parts of the box in the cells.
    #[inline(always)] // vectorizes over the channels
    fn extremes<const N: usize>(&self, [x, y, z]: &[Crossed; 3], of: impl Fn([f32; 4]) -> [f32; N]) -> [[f64; 2]; N] {
        let mix =
            |a: [f64; N], b: [f64; N], part: f64| -> [f64; N] { std::array::from_fn(|c| a[c] + part * (b[c] - a[c])) };
        let mut rows = [[[0.0; N]; MOST_POINTS]; MOST_POINTS]; // by y of texels and x of points
        let mut layers = [[[[0.0; N]; MOST_POINTS]; MOST_POINTS]; MOST_POINTS]; // by z of texels, y and x of points
        let mut largest = [0f64; N];
        for (layer, &k) in layers.iter_mut().zip(z.texels()) {
            for (row, &j) in rows.iter_mut().zip(y.texels()) {
                let mut texels = [[0.0; N]; MOST_POINTS];
                for (texel, &i) in texels.iter_mut().zip(x.texels()) {
                    *texel = of(self.texel([i, j, k])).map(f64::from);
                    largest = std::array::from_fn(|c| largest[c].max(texel[c].abs()));
                }
                for (value, (first, part)) in row.iter_mut().zip(x.points()) {
                    *value = mix(texels[first], texels[first + 1], part);
                }
            }
            for (row, (first, part)) in layer.iter_mut().zip(y.points()) {
                for at in 0..x.count {
                    row[at] = mix(rows[first][at], rows[first + 1][at], part);
                }
            }
        }
        let (mut low, mut high) = ([f64::INFINITY; N], [f64::NEG_INFINITY; N]);
        for (first, part) in z.points() {
            for (near, far) in layers[first].iter().zip(&layers[first + 1]).take(y.count) {
                for (near, far) in near.iter().zip(far).take(x.count) {
                    let value = mix(*near, *far, part);
                    low = std::array::from_fn(|c| low[c].min(value[c]));
                    high = std::array::from_fn(|c| high[c].max(value[c]));
                }
            }
        }
        std::array::from_fn(|c| {
            let margin = self.slack + 32.0 * f64::EPSILON * largest[c];
            [low[c] - margin, high[c] + margin]
        })
    }

    /// Bounds of the channels over a box of texels.
    pub(crate) fn texels(&self, of: [[usize; 2]; 3]) -> [[f64; 2]; 4] {
        let longest = of.iter().map(|[first, last]| last - first).max().unwrap_or(0);
        let [least, most] = match longest {
            ..FEW => range(self.size.map(|side| side as usize), of, |index| [self.texels[index]; 2]),
            _ => self.pyramid.get_or_init(|| Pyramid::new(self.size, self.texels)).range(of, longest),
        };
        [0, 1, 2, 3].map(|channel| [f64::from(least[channel]) - self.slack, f64::from(most[channel]) + self.slack])
    }

    /// The one or two ranges of texels of a range of indices.
    fn indices(&self, from: f64, to: f64, count: u32) -> ([[usize; 2]; 2], usize) {
        let n = i64::from(count);
        let whole = ([[0, count as usize - 1]; 2], 1);
        let short = to - from < f64::from(count);
        if self.wrap == Wrap::Clamp && !from.is_nan() && !to.is_nan() {
            return ([[wrapped(from as i64, count, Wrap::Clamp), wrapped(to as i64, count, Wrap::Clamp)]; 2], 1);
        }
        if !short || from.abs() > 1e15 || to.abs() > 1e15 {
            return whole;
        }
        let (from, to) = (from as i64, to as i64);
        let [first, last] = [from, to].map(|index| wrapped(index, count, self.wrap));
        match self.wrap {
            Wrap::Repeat if first > last => ([[first, count as usize - 1], [0, last]], 2),
            Wrap::Mirror => {
                let (mut low, mut high) = (first.min(last), first.max(last));
                let fold = from.div_euclid(n) + 1;
                if fold * n <= to {
                    (low, high) = if fold % 2 == 0 { (0, high) } else { (low, count as usize - 1) };
                }
                ([[low, high]; 2], 1)
            }
            _ => ([[first, last]; 2], 1),
        }
    }
}

/// Positions of a range of coordinates in units of texels, widened by twice the rounding.
fn scaled([low, high]: [f64; 2], count: u32) -> [f64; 2] {
    let n = f64::from(count);
    let margin = (low.abs().max(high.abs()) * n + 1.0) * 4.0 * f64::EPSILON;
    [low * n - 0.5 - margin, high * n - 0.5 + margin]
}

/// Most texels that a range of coordinates may meet for [`Crossed`], including its ends.
const MOST_POINTS: usize = 4;

/// A range of coordinates that meets few texels.
struct Crossed {
    /// From the texel before the range to the one behind it.
    texels: [usize; MOST_POINTS],
    /// Ends of the range and the texels in it, relative to the first texel.
    points: [f64; MOST_POINTS],
    count: usize,
}

/// The range along a missing axis.
const POINT: Crossed = Crossed { texels: [0; MOST_POINTS], points: [0.0; MOST_POINTS], count: 1 };

impl Crossed {
    /// `None` if the range meets many texels.
    fn of(within: [f64; 2], count: u32, wrap: Wrap) -> Option<Crossed> {
        let mut ends = scaled(within, count);
        if wrap == Wrap::Clamp {
            ends = ends.map(|x| x.clamp(-1.0, f64::from(count)));
        }
        let [from, to] = ends.map(f64::floor);
        if !(to - from < (MOST_POINTS - 1) as f64 && from.abs() < 1e15) {
            return None;
        }
        let (first, crossed) = (from as i64, (to - from) as usize);
        let texels = [0, 1, 2, 3].map(|k| wrapped(first + k, count, wrap));
        let mut points = [0.0, 1.0, 2.0, 3.0];
        (points[0], points[crossed + 1]) = (ends[0] - from, ends[1] - from);
        Some(Crossed { texels, points, count: crossed + 2 })
    }

    fn texels(&self) -> &[usize] {
        &self.texels[..self.count]
    }

    /// The texel before each point, and the distance from it.
    fn points(&self) -> impl Iterator<Item = (usize, f64)> {
        self.points[..self.count].iter().map(|&point| {
            let first = (point as usize).min(self.count.saturating_sub(2));
            (first, point - first as f64)
        })
    }
}

fn include(all: &mut [[f64; 2]; 4], values: [[f64; 2]; 4]) {
    for (range, [low, high]) in all.iter_mut().zip(values) {
        *range = [range[0].min(low), range[1].max(high)];
    }
}
