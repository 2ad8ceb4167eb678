//! Images: exact linear filtering at a point, and the range of an image over a box of coordinates.
//!
//! Texel i of n is centered at (i + 0.5) / n. Between texels values change linearly along each axis; no rounding of
//! weights as in hardware.

use super::pyramid::{FEW, Pyramid, range};
use noise::{Knots, Lattice, NOISE_BOUND};
use std::sync::OnceLock;

/// How coordinates outside of [0, 1] are taken.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// As the nearest texel of the edge.
    Clamp,
    /// The image is repeated.
    Repeat,
    /// The image is repeated, every other time mirrored.
    Mirror,
}

/// An image: decoded texels, x fastest. A line is `[n, 1, 1]`, a plane `[n, m, 1]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    /// Number of texels along each axis.
    pub size: [u32; 3],
    /// Red, green, blue and alpha of each texel. Behind those of the image, those of ever coarser levels may follow, each
    /// with half as many along every axis.
    pub texels: Vec<[f32; 4]>,
}

/// An image as a program reads it.
#[derive(Debug)]
pub struct Image<'a> {
    pub(super) size: [u32; 3],
    texels: &'a [[f32; 4]],
    pub(super) wrap: Wrap,
    /// 1, 2 or 3.
    pub(super) axes: usize,
    /// The next level, where there is one.
    coarser: Option<Box<Image<'a>>>,
    /// Ranges of ever larger boxes: made when an interval is first looked up.
    pyramid: OnceLock<Pyramid>,
    /// What stands in place of the texels.
    pub(super) noise: Option<Lattice>,
}

/// Texels of an image, without those of coarser levels.
pub(super) fn count(size: [u32; 3]) -> usize {
    size.iter().map(|side| *side as usize).product()
}

/// Size of the next level.
pub(super) fn halved(size: [u32; 3]) -> [u32; 3] {
    size.map(|side| (side / 2).max(1))
}

/// Which two texels a coordinate lies between, and how far from the first.
fn place(coordinate: f64, count: u32, wrap: Wrap) -> ([usize; 2], f64) {
    let n = f64::from(count);
    let x = coordinate * n - 0.5;
    let x = if wrap == Wrap::Clamp { x.clamp(-1.0, n) } else { x };
    // As `floor`, which is a call for each coordinate.
    let low = if x.abs() < 1e15 {
        let whole = (x as i64) as f64;
        if whole > x { whole - 1.0 } else { whole }
    } else {
        x.floor()
    };
    let first = low as i64;
    ([wrapped(first, count, wrap), wrapped(first + 1, count, wrap)], x - low)
}

/// The texel that an index means.
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
    /// An image whose texels are those of its levels.
    pub(super) fn new(size: [u32; 3], texels: &'a [[f32; 4]], wrap: Wrap, axes: usize) -> Image<'a> {
        let (texels, rest) = texels.split_at(count(size));
        let coarser = (!rest.is_empty()).then(|| Box::new(Image::new(halved(size), rest, wrap, axes)));
        Image { size, texels, wrap, axes, coarser, pyramid: OnceLock::new(), noise: None }
    }

    /// Noise, whose levels are its knots.
    pub(super) fn of_noise(noise: Lattice) -> Image<'a> {
        Image { noise: Some(noise), ..Image::new([0; 3], &[], Wrap::Repeat, 3) }
    }

    /// The channels at a point of a level, which lies between two where it is no whole number.
    pub(super) fn sample_level(&self, at: [f64; 3], level: f64) -> [f64; 4] {
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

    /// Lower and upper bounds of the channels over a box of coordinates and levels; those that are not wanted may be 0.
    pub(super) fn range_levels(&self, within: [[f64; 2]; 3], levels: [f64; 2], wanted: [bool; 4]) -> [[f64; 2]; 4] {
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

    pub(super) fn texel(&self, at: [usize; 3]) -> [f32; 4] {
        let [x, y, _] = self.size.map(|side| side as usize);
        self.texels[(at[2] * y + at[1]) * x + at[0]]
    }

    /// The channels at a point.
    pub(super) fn sample(&self, at: [f64; 3]) -> [f64; 4] {
        // Of the two texels along each axis, where they are among all, and their weights.
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

    /// Lower and upper bounds of the channels over a box of coordinates; those that are not wanted may be 0.
    pub(super) fn range(&self, within: [[f64; 2]; 3], wanted: [bool; 4]) -> [[f64; 2]; 4] {
        let axes = [0, 1, 2].map(|axis| {
            if axis < self.axes { Crossed::of(within[axis], self.size[axis], self.wrap) } else { Some(POINT) }
        });
        if let [Some(x), Some(y), Some(z)] = axes {
            let axes = [x, y, z];
            // One alone costs less by itself.
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
        // A mean of texels is rounded.
        all.map(|[low, high]| {
            let margin = 16.0 * f64::EPSILON * low.abs().max(high.abs());
            [low - margin, high + margin]
        })
    }

    /// The cell that a box of coordinates lies in, if it is one: places of its first texel, and the texels at its corners,
    /// x fastest.
    pub(super) fn cell(&self, within: [[f64; 2]; 3]) -> Option<([f64; 3], [[f32; 4]; 8])> {
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

    /// Least and greatest slopes of each channel over a box of coordinates, along each axis: what two texels beside each other
    /// differ by, where what is between them is met. `None` where the box is of many cells.
    pub(super) fn slopes(&self, within: [[f64; 2]; 3]) -> Option<[[[f64; 2]; 3]; 4]> {
        let mut axes = [POINT; 3];
        for axis in 0..self.axes {
            axes[axis] = Crossed::of(within[axis], self.size[axis], self.wrap)?;
        }
        let counts = [0, 1, 2].map(|axis| axes[axis].count);
        let texel = |at: [usize; 3]| self.texel([0, 1, 2].map(|axis| axes[axis].texels[at[axis]]));
        let mut all = [counts.map(|count| if count > 1 { [f64::INFINITY, f64::NEG_INFINITY] } else { [0.0; 2] }); 4];
        for axis in (0..3).filter(|axis| counts[*axis] > 1) {
            let ends = [0, 1, 2].map(|other| counts[other] - usize::from(other == axis));
            for place in 0..ends.iter().product() {
                let at = [place % ends[0], place / ends[0] % ends[1], place / ends[0] / ends[1]];
                let next = [0, 1, 2].map(|other| at[other] + usize::from(other == axis));
                for (channel, (from, to)) in texel(at).into_iter().zip(texel(next)).enumerate() {
                    let slope = (f64::from(to) - f64::from(from)) * f64::from(self.size[axis]);
                    let [least, most] = &mut all[channel][axis];
                    (*least, *most) = (least.min(slope), most.max(slope));
                }
            }
        }
        Some(all)
    }

    /// The ranges of some channels over a box of few cells: multilinear within each, so that the extremes are at corners of
    /// their parts.
    #[inline(always)] // the channels beside each other
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
            let margin = 32.0 * f64::EPSILON * largest[c];
            [low[c] - margin, high[c] + margin]
        })
    }

    /// Lower and upper bounds of the channels over a box of texels.
    pub(super) fn texels(&self, of: [[usize; 2]; 3]) -> [[f64; 2]; 4] {
        let longest = of.iter().map(|[first, last]| last - first).max().unwrap_or(0);
        let [least, most] = match longest {
            ..FEW => range(self.size.map(|side| side as usize), of, |index| [self.texels[index]; 2]),
            _ => self.pyramid.get_or_init(|| Pyramid::new(self.size, self.texels)).range(of, longest),
        };
        [0, 1, 2, 3].map(|channel| [least[channel], most[channel]].map(f64::from))
    }

    /// The texels that indices from one to another mean: one range or two, first and last.
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

/// Places between texels, of a range of coordinates: with twice the rounding of a product of this size.
fn scaled([low, high]: [f64; 2], count: u32) -> [f64; 2] {
    let n = f64::from(count);
    let margin = (low.abs().max(high.abs()) * n + 1.0) * 4.0 * f64::EPSILON;
    [low * n - 0.5 - margin, high * n - 0.5 + margin]
}

/// Ends of a range of coordinates and the texels between them, at most.
const MOST_POINTS: usize = 4;

/// A range of coordinates that crosses few texels.
struct Crossed {
    /// From the one before the range to the one behind it.
    texels: [usize; MOST_POINTS],
    /// Its ends and the texels in it: how far behind the first texel.
    points: [f64; MOST_POINTS],
    count: usize,
}

/// Along an axis that an image has not.
const POINT: Crossed = Crossed { texels: [0; MOST_POINTS], points: [0.0; MOST_POINTS], count: 1 };

impl Crossed {
    /// `None`, where it crosses many.
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

    /// The texel before each point, and how far from it.
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
