//! Volumes in bricks, of which only the reachable ones are stored.
//!
//! Role: finds the bricks that hold a distance in a band, their places in an atlas, and the index to them;
//! `storage/sparse.glsl` reads it. Invariant: within a stored brick every sample equals the volume's. The index entry
//! of any other brick is a texel, whose distance is the nearest to the band: a lower bound outside, an upper bound
//! inside. Source: GG 39.6.

use crate::field::DistanceField;
use rayon::prelude::*;

/// Cells along a side of a brick. Lower: shared texels and the index outweigh the savings. Higher: more of a brick is
/// out of reach. Must equal the constant in `storage/sparse.glsl`.
pub const BRICK: u32 = 8;
/// Texels along a side; the last ones repeat the first of the next brick.
const SIDE: u32 = BRICK + 1;
/// Alpha of an index entry that refers to a brick; texels have at most 1.
const BRICK_ALPHA: f32 = 2.0;

/// Places of the bricks of a volume.
#[derive(Clone, Debug, PartialEq)]
pub struct Bricks {
    /// Bricks along each axis.
    pub size: [u32; 3],
    /// Entry of each brick, x fastest: its first texel in the atlas and 2, or the constant texel.
    pub index: Vec<[f32; 4]>,
    /// Size of the atlas in texels.
    pub atlas: [u32; 3],
    /// Size of the atlas in bricks.
    places: [u32; 3],
    /// Stored bricks, in the order of their places.
    stored: Vec<[u32; 3]>,
    /// Size of the whole volume in texels.
    whole: [u32; 3],
}

impl Bricks {
    /// Finds the bricks of a field with a distance in `band` (lowest, highest; units of the field). `texel` returns the
    /// channels of a texel of the whole volume by its index.
    pub fn of(field: &DistanceField, band: [f32; 2], texel: impl Fn(usize) -> [f32; 4] + Sync) -> Bricks {
        let whole = field.grid.size;
        let size = whole.map(|texels| (texels - 1).div_ceil(BRICK).max(1));
        let at = |brick: u32| [brick % size[0], brick / size[0] % size[1], brick / (size[0] * size[1])];
        let outcome = |brick: u32| {
            let numbers = || texels_of(whole, at(brick)).map(|number| (number, field.values[number]));
            let lowest = numbers().min_by(|a, b| a.1.total_cmp(&b.1));
            let highest = numbers().max_by(|a, b| a.1.total_cmp(&b.1));
            let stands = match (lowest, highest) {
                (Some((number, low)), _) if low > band[1] => Some(number),
                (_, Some((number, high))) if high < band[0] => Some(number),
                _ => None,
            };
            stands.map(&texel)
        };
        let constant: Vec<Option<[f32; 4]>> = (0..size.iter().product()).into_par_iter().map(outcome).collect();
        let stored: Vec<[u32; 3]> =
            (0..).zip(&constant).filter(|(_, texel)| texel.is_none()).map(|(brick, _)| at(brick)).collect();
        let places = places(stored.len().max(1) as u32);
        let mut place = 0..;
        let entry = |texel: Option<[f32; 4]>| {
            texel.unwrap_or_else(|| {
                let [x, y, z] = first_texel(places, place.next().unwrap_or_default());
                [x as f32, y as f32, z as f32, BRICK_ALPHA]
            })
        };
        let index = constant.into_iter().map(entry).collect();
        Bricks { size, index, atlas: places.map(|count| count * SIDE), places, stored, whole }
    }

    /// Number of stored bricks.
    pub fn stored(&self) -> usize {
        self.stored.len()
    }

    /// Copies the stored bricks from a volume with `bytes` for each texel, x fastest.
    pub fn gather(&self, volume: &[u8], bytes: usize) -> Vec<u8> {
        let [width, height, depth] = self.atlas.map(|side| side as usize);
        let mut atlas = vec![0; width * height * depth * bytes];
        for (place, brick) in (0..).zip(&self.stored) {
            let [x, y, z] = first_texel(self.places, place).map(|c| c as usize);
            for (number, source) in texels_of(self.whole, *brick).enumerate() {
                let side = SIDE as usize;
                let [i, j, k] = [x + number % side, y + number / side % side, z + number / (side * side)];
                let to = ((k * height + j) * width + i) * bytes;
                atlas[to..to + bytes].copy_from_slice(&volume[source * bytes..][..bytes]);
            }
        }
        atlas
    }
}

/// Indices of a brick's texels in the whole volume, x fastest; clamped at its border.
fn texels_of(whole: [u32; 3], brick: [u32; 3]) -> impl Iterator<Item = usize> {
    let along = move |axis: usize, texel: u32| (brick[axis] * BRICK + texel).min(whole[axis] - 1) as usize;
    let [width, height, _] = whole.map(|side| side as usize);
    let number = move |i, j, k| (along(2, k) * height + along(1, j)) * width + along(0, i);
    (0..SIDE).flat_map(move |k| (0..SIDE).flat_map(move |j| (0..SIDE).map(move |i| number(i, j, k))))
}

/// Size of a nearly cubic atlas for `count` bricks: devices limit the longest side.
fn places(count: u32) -> [u32; 3] {
    let x = f64::from(count).cbrt().ceil() as u32;
    let y = f64::from(count.div_ceil(x)).sqrt().ceil() as u32;
    [x, y, count.div_ceil(x * y)]
}

fn first_texel(places: [u32; 3], place: u32) -> [u32; 3] {
    [place % places[0], place / places[0] % places[1], place / (places[0] * places[1])].map(|c| c * SIDE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::field::Grid;
    use glam::Vec3;

    /// A ball of radius 9 in a grid with incomplete bricks, distances in voxels.
    fn ball() -> DistanceField {
        let grid = Grid { size: [37, 30, 41], origin: Vec3::new(-18.0, -14.5, -20.0), spacing: Vec3::ONE };
        let places = (0..41).flat_map(|k| (0..30).flat_map(move |j| (0..37).map(move |i| (i, j, k))));
        DistanceField { grid, values: places.map(|(i, j, k)| grid.position(i, j, k).length() - 9.0).collect() }
    }

    #[test]
    fn g14_bricks_hold_texels_and_index_entries_bound_the_rest() {
        let field = ball();
        let bytes: Vec<u8> = field.values.iter().flat_map(|value| value.to_ne_bytes()).collect();
        let bricks = Bricks::of(&field, [-2.0, 3.0], |number| [0.0, 0.0, 0.0, field.values[number] / 100.0]);
        let atlas = bricks.gather(&bytes, 4);
        let value = |at: usize| f32::from_ne_bytes(atlas[4 * at..][..4].try_into().unwrap());
        let (mut found, mut within) = (0, 0);
        for (number, entry) in bricks.index.iter().enumerate() {
            let brick = [number % 5, number / 5 % 4, number / 20].map(|c| 8 * c as u32);
            for texel in (0..729).map(|t| [t % 9, t / 9 % 9, t / 81]) {
                let [i, j, k] = [0, 1, 2].map(|axis| (brick[axis] + texel[axis]).min(field.grid.size[axis] - 1));
                let expected = field.value(i, j, k);
                if entry[3] > 1.0 {
                    let [x, y, z] = [0, 1, 2].map(|axis| entry[axis] as usize + texel[axis] as usize);
                    assert_eq!(value((z * bricks.atlas[1] as usize + y) * bricks.atlas[0] as usize + x), expected);
                    found += 1;
                } else {
                    let bound = 100.0 * entry[3];
                    assert!((3.0..=expected + 1e-4).contains(&bound) || (expected - 1e-4..=-2.0).contains(&bound));
                }
                within += usize::from((-2.0..=3.0).contains(&expected) && entry[3] <= 1.0);
            }
        }
        assert_eq!((within, found), (0, 729 * bricks.stored()), "every texel of the band is stored");
        assert!(bricks.stored() < bricks.index.len() && bricks.size == [5, 4, 5]);
    }

    #[test]
    fn bricks_take_a_box_that_is_about_a_cube() {
        for count in [1, 2, 7, 8, 9, 100, 1001] {
            let [x, y, z] = places(count);
            assert!(x * y * z >= count && x * y * z < count + x * y && x.max(y).max(z) <= x, "{count}: {x} {y} {z}");
        }
    }
}
