//! Grooms: channels painted in space over an object, which modules read at its skin.
//!
//! Source: MJ 2 and 7, texturing without parameterization. A file is a NRRD of shorts in gzip with the sizes 8 n n n, which other
//! readers of NRRD open.

mod brush;

pub use brush::{Brush, BrushKind};

use crate::error::{Location, ShapeError, shown, unreadable};
use flate2::Compression;
use flate2::read::GzDecoder;
use flate2::write::GzEncoder;
use glam::Vec3;
use half::f16;
use hypertexture_support::open;
use std::io::{self, BufRead, Read, Write};
use std::ops::RangeInclusive;
use std::path::Path;

/// Half the side of the cube that a groom covers, object units: `GROOM_REACH` of `glsl/groom/volume.glsl`.
const REACH: f32 = 1.125;
/// Codes of a file in one unit of a channel.
const UNIT: f32 = 16000.0;
/// Largest file, bytes: all voxels without compression.
const MAX_BYTES: u64 = 18 * 256 * 256 * 256 + (1 << 16);
const KEY: &str = "hypertexture groom";
/// Index of the channel of the amount, which files of eight channels lack.
const AMOUNT: usize = 8;

/// A volume of painted channels over an object.
#[derive(Clone, Debug, PartialEq)]
pub struct Groom {
    /// The object that it was painted on.
    pub object: String,
    side: u32,
    voxels: Vec<[f16; 9]>,
    /// Largest amount so far.
    strongest: f32,
}

impl Groom {
    /// Names of the channels.
    pub const CHANNELS: [&str; 9] = ["length", "density", "red", "green", "blue", "x", "y", "z", "amount"];
    /// Values of the channels where nothing is painted.
    pub const NEUTRAL: [f32; 9] = [1.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0];
    /// Voxels along a side.
    pub const SIDES: RangeInclusive<u32> = 32..=256;

    /// A groom in which nothing is painted.
    pub fn unpainted(object: &str, side: u32) -> Groom {
        let voxels = vec![Groom::NEUTRAL.map(f16::from_f32); (side as usize).pow(3)];
        Groom { object: object.into(), side, voxels, strongest: 1.0 }
    }

    /// Voxels along a side.
    pub fn side(&self) -> u32 {
        self.side
    }

    /// Side of a voxel, object units.
    pub fn step(&self) -> f32 {
        2.0 * REACH / self.side as f32
    }

    /// Number of voxels.
    pub fn voxels(&self) -> usize {
        self.voxels.len()
    }

    /// Place of a voxel, x fastest, in object space.
    pub fn place(&self, index: usize) -> Vec3 {
        let side = self.side as usize;
        let at = [index % side, index / side % side, index / side / side].map(|at| at as f32);
        REACH * ((2.0 * Vec3::from(at) + 1.0) / self.side as f32 - 1.0)
    }

    /// Indices of the voxels within `radius` of a place.
    pub fn around(&self, place: Vec3, radius: f32) -> impl Iterator<Item = usize> + '_ {
        let of = |place: Vec3| (place / REACH + 1.0) * (0.5 * self.side as f32) - 0.5;
        let last = Vec3::splat(self.side as f32 - 1.0);
        let [low, high] = [of(place - radius).ceil(), of(place + radius).floor()];
        let [low, high] = [low.max(Vec3::ZERO), high.min(last) + 1.0].map(|corner| corner.as_uvec3());
        let index = move |x: u32, y: u32, z: u32| ((z * self.side + y) * self.side + x) as usize;
        let row = move |y: u32, z: u32| (low.x..high.x).map(move |x| index(x, y, z));
        let all = (low.z..high.z).flat_map(move |z| (low.y..high.y).flat_map(move |y| row(y, z)));
        all.filter(move |index| self.place(*index).distance_squared(place) <= radius * radius)
    }

    /// The channels of a voxel.
    pub fn at(&self, index: usize) -> [f32; 9] {
        self.voxels[index].map(f16::to_f32)
    }

    /// Least and greatest value of a channel: 0 and 2, or -1 and 1 of the direction.
    pub fn limits(channel: usize) -> [f32; 2] {
        if (5..8).contains(&channel) { [-1.0, 1.0] } else { [0.0, 2.0] }
    }

    /// Sets the channels of a voxel, within their limits.
    pub fn set(&mut self, index: usize, channels: [f32; 9]) {
        for (channel, (stored, value)) in self.voxels[index].iter_mut().zip(channels).enumerate() {
            let [least, greatest] = Groom::limits(channel);
            *stored = f16::from_f32(value.clamp(least, greatest));
        }
        self.strongest = self.strongest.max(self.voxels[index][AMOUNT].to_f32());
    }

    /// Whether the skin of an object, which reaches to 1, may be at a voxel.
    pub fn may_hold_skin(&self, index: usize) -> bool {
        self.place(index).abs().max_element() <= 1.0
    }

    /// Whether a color, a density or an amount is painted.
    pub fn has_factors(&self) -> bool {
        self.voxels.iter().any(|voxel| [1, 2, 3, 4, AMOUNT].iter().any(|channel| voxel[*channel] != f16::ONE))
    }

    /// Bound of the amount, at least 1: the largest since the groom was made or read.
    pub fn strongest(&self) -> f32 {
        self.strongest
    }

    /// Lines about lengths above 1, and about lengths or amounts of 0 everywhere, if it has such.
    pub fn odd_values(&self) -> Vec<String> {
        let none = self.voxels.iter().all(|voxel| voxel[AMOUNT] == f16::ZERO);
        let none = none.then(|| "amounts are 0 everywhere: warps and DMFs do nothing".into());
        self.odd_lengths().into_iter().chain(none).collect()
    }

    fn odd_lengths(&self) -> Option<String> {
        let longest = self.voxels.iter().map(|voxel| voxel[0].to_f32()).fold(0.0, f32::max);
        if longest == 0.0 {
            return Some("lengths are 0 everywhere: there is no hair and no flame".into());
        }
        (longest > 1.0).then(|| {
            format!(
                "lengths reach {longest}, and hair ends with the soft region, at 1; for longer hair, multiply the length of the \
                 effect by {longest} and divide those of the groom by it"
            )
        })
    }

    /// Texels of four halves for a device, of these channels.
    pub fn texels(&self, channels: [usize; 4]) -> Vec<u8> {
        let values = self.voxels.iter().flat_map(|voxel| channels.map(|channel| voxel[channel]));
        values.flat_map(f16::to_ne_bytes).collect()
    }

    /// Texels of one float for a device: the amounts.
    pub fn amounts(&self) -> Vec<u8> {
        self.voxels.iter().flat_map(|voxel| voxel[AMOUNT].to_f32().to_ne_bytes()).collect()
    }

    /// Paints colors of the surface: the voxels that hold points of it, with their mean color, and those up to `grown` voxels
    /// away, with the mean of their painted neighbors. Points are places in object space with linear RGB.
    pub fn color(&mut self, points: impl Iterator<Item = (Vec3, [f32; 3])>, grown: u32) {
        self.paint(points, grown, |voxel, color| voxel[2..5].copy_from_slice(&color.map(|part| 2.0 * part)));
    }

    /// Paints amounts of the surface in the same way: `points` have them in their first number.
    pub fn weight(&mut self, points: impl Iterator<Item = (Vec3, [f32; 3])>, grown: u32) {
        self.paint(points, grown, |voxel, [amount, ..]| voxel[AMOUNT] = amount);
    }

    fn paint(
        &mut self,
        points: impl Iterator<Item = (Vec3, [f32; 3])>,
        grown: u32,
        set: impl Fn(&mut [f32; 9], [f32; 3]),
    ) {
        let side = self.side as usize;
        let mut sums = vec![[0.0_f32; 4]; self.voxels.len()];
        for (place, [r, g, b]) in points {
            let at = ((place / REACH + 1.0) * (0.5 * side as f32)).floor();
            if at.cmpge(Vec3::ZERO).all() && at.cmplt(Vec3::splat(side as f32)).all() {
                let [x, y, z] = at.to_array().map(|axis| axis as usize);
                let sum = &mut sums[(z * side + y) * side + x];
                [r, g, b, 1.0].into_iter().zip(sum).for_each(|(value, sum)| *sum += value);
            }
        }
        for _ in 0..grown {
            let before = sums.clone();
            for (index, sum) in sums.iter_mut().enumerate().filter(|(_, sum)| sum[3] == 0.0) {
                let at = [index % side, index / side % side, index / side / side];
                for (axis, stride) in [1, side, side * side].into_iter().enumerate() {
                    let below = (at[axis] > 0).then(|| before[index - stride]);
                    let above = (at[axis] + 1 < side).then(|| before[index + stride]);
                    for near in [below, above].into_iter().flatten().filter(|near| near[3] > 0.0) {
                        near.into_iter().zip(&mut *sum).for_each(|(value, sum)| *sum += value / near[3]);
                    }
                }
            }
        }
        for (index, [r, g, b, count]) in sums.into_iter().enumerate().filter(|(_, sum)| sum[3] > 0.0) {
            let mut voxel = self.at(index);
            set(&mut voxel, [r, g, b].map(|sum| sum / count));
            self.set(index, voxel);
        }
    }

    /// Reads a file.
    ///
    /// # Errors
    /// The file cannot be read, or is not a groom.
    pub fn read(path: &Path) -> Result<Groom, ShapeError> {
        let file = shown(&path.to_string_lossy());
        let bytes = open::bytes(path, MAX_BYTES).map_err(|error| unreadable(file.clone(), error))?;
        Groom::from_bytes(&file, &bytes)
    }

    /// Reads the bytes of a file, which errors call `file`.
    ///
    /// # Errors
    /// They are not a groom.
    pub fn from_bytes(file: &str, bytes: &[u8]) -> Result<Groom, ShapeError> {
        let (header, mut data) = (GroomHeader::read(bytes, file)?, bytes);
        data.consume(header.length);
        let count = (header.side as usize).pow(3);
        let mut codes = Vec::new();
        let damaged = |decoded: usize, reason| ShapeError::Decompression {
            file: file.into(),
            offset: header.length as u64,
            decoded: decoded as u64,
            reason,
        };
        let size = 2 * header.channels;
        let read = GzDecoder::new(data).take((size * count) as u64 + 1).read_to_end(&mut codes);
        read.map_err(|reason| damaged(codes.len(), reason))?;
        if codes.len() != size * count {
            let reason = io::Error::new(io::ErrorKind::UnexpectedEof, format!("{} bytes are needed", size * count));
            return Err(damaged(codes.len(), reason));
        }
        let mut groom = Groom::unpainted(&header.object, header.side);
        for (index, voxel) in codes.chunks_exact(size).enumerate() {
            let mut channels = Groom::NEUTRAL;
            for (channel, code) in channels.iter_mut().zip(voxel.as_chunks::<2>().0) {
                *channel = f32::from(i16::from_le_bytes(*code)) / UNIT;
            }
            groom.set(index, channels);
        }
        Ok(groom)
    }

    /// Writes a file.
    ///
    /// # Errors
    /// Errors of `to`.
    pub fn write(&self, mut to: impl Write) -> io::Result<()> {
        let (n, step) = (self.side, self.step());
        writeln!(to, "NRRD0005\n# channels {} in units of 1/{UNIT}", Groom::CHANNELS.join(", "))?;
        writeln!(to, "type: short\ndimension: 4\nspace dimension: 3\nsizes: 9 {n} {n} {n}")?;
        writeln!(to, "space directions: none ({step},0,0) (0,{step},0) (0,0,{step})")?;
        let origin = self.place(0).x;
        writeln!(to, "space origin: ({origin},{origin},{origin})\nkinds: vector domain domain domain")?;
        writeln!(to, "endian: little\nencoding: gzip\n{KEY}:={}\n", self.object.replace(char::is_control, " "))?;
        let mut encoder = GzEncoder::new(to, Compression::default());
        for voxel in &self.voxels {
            let codes = voxel.map(|value| ((value.to_f32() * UNIT).round() as i16).to_le_bytes());
            encoder.write_all(codes.as_flattened())?;
        }
        encoder.finish()?.flush()
    }
}

/// The part of a file before its data.
struct GroomHeader {
    object: String,
    side: u32,
    channels: usize,
    /// Its bytes.
    length: usize,
}

impl GroomHeader {
    fn read(bytes: &[u8], file: &str) -> Result<GroomHeader, ShapeError> {
        let malformed = |line: usize, expected: &'static str, found: &str| ShapeError::Malformed {
            file: file.into(),
            place: Location::Line(line as u64),
            expected,
            found: shown(&found.chars().take(80).collect::<String>()),
        };
        if !bytes.starts_with(b"NRRD000") {
            return Err(malformed(1, "`NRRD0005`, as `hypertexture groom` writes it", "another format"));
        }
        let end = bytes.windows(2).position(|pair| pair == b"\n\n").unwrap_or_default();
        let text = String::from_utf8_lossy(&bytes[..end]);
        if !text.contains(KEY) {
            return Err(malformed(1, "a groom, which `hypertexture groom` and the window write", "another NRRD"));
        }
        let mut found = GroomHeader { object: String::new(), side: 0, channels: 0, length: end + 2 };
        for (line, (name, value)) in
            text.lines().enumerate().filter_map(|(number, line)| Some((number + 1, line.split_once(':')?)))
        {
            let value = value.trim();
            let must = |is: bool, expected| if is { Ok(()) } else { Err(malformed(line, expected, value)) };
            match name {
                "type" => must(value == "short", "`type: short`")?,
                "encoding" => must(value == "gzip", "`encoding: gzip`")?,
                "endian" => must(value == "little", "`endian: little`")?,
                "sizes" => {
                    let sizes: Vec<u32> = value.split(' ').filter_map(|size| size.parse().ok()).collect();
                    let is_cube =
                        matches!(sizes[..], [8 | 9, a, b, c] if a == b && b == c && Groom::SIDES.contains(&a));
                    must(is_cube, "`sizes: 9 n n n` with n from 32 to 256, or 8 channels without amounts")?;
                    (found.channels, found.side) = (sizes[0] as usize, sizes[1]);
                }
                KEY => found.object = value.trim_start_matches('=').into(),
                _ => {}
            }
        }
        if found.side == 0 {
            return Err(malformed(1, "a line `sizes: 9 n n n`", "none"));
        }
        Ok(found)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shape::Mesh;

    #[test]
    fn colored_points_paint_their_voxels_and_those_around_them() {
        let mut groom = Groom::unpainted("a", 32);
        let at = (16 * 32 + 16) * 32 + 16;
        let mesh = Mesh {
            positions: vec![groom.place(at), groom.place(at + 1), groom.place(at + 32)],
            triangles: vec![[0, 1, 2]],
            colors: vec![[0.25, 0.5, 1.0], [0.25, 0.5, 0.0], [0.25, 0.5, 0.0]],
            ..Mesh::default()
        };
        let points: Vec<_> = mesh.colored_points(0.1 * groom.step()).collect();
        // Linear in between, and nowhere else.
        for (point, [.., blue]) in &points {
            let [u, v, w] = ((*point - mesh.positions[0]) / groom.step()).to_array();
            assert!((blue - (1.0 - u - v)).abs() < 1e-4 && w.abs() < 1e-4 && u + v < 1.0001);
        }
        groom.color(points.into_iter(), 2);
        let color = |index: usize| groom.at(index)[2..5].to_vec();
        assert_eq!(color(at)[..2], [0.5, 1.0]);
        // The means of blue over the parts of the triangle in two voxels are 1/2 and 1/6, and colors are twice that.
        let blue = [at, at + 1].map(|index| color(index)[2]);
        assert!((blue[0] - 1.0).abs() < 0.1 && (blue[1] - 1.0 / 3.0).abs() < 0.1, "{blue:?}");
        assert_eq!(color(at + 2 * 1024)[..2], [0.5, 1.0], "two voxels away");
        assert_eq!(color(at + 3 * 1024), [1.0; 3], "three voxels away");
    }

    #[test]
    fn a_groom_of_eight_channels_has_neutral_amounts() {
        let mut bytes = b"NRRD0005\ntype: short\nsizes: 8 32 32 32\nencoding: gzip\nhypertexture groom:=a\n\n".to_vec();
        let mut encoder = GzEncoder::new(&mut bytes, Compression::default());
        let voxel = [0.5, 1.0, 1.0, 1.0, 1.0, 0.0, 0.25, 0.0].map(|value| ((value * UNIT) as i16).to_le_bytes());
        (0..32 * 32 * 32).for_each(|_| encoder.write_all(voxel.as_flattened()).unwrap());
        encoder.finish().unwrap();
        let groom = Groom::from_bytes("a.nrrd", &bytes).unwrap();
        let expected = [0.5, 1.0, 1.0, 1.0, 1.0, 0.0, 0.25, 0.0, 1.0];
        assert!((0..groom.voxels()).all(|index| groom.at(index) == expected));
        assert_eq!(groom.strongest(), 1.0);
    }

    #[test]
    fn a_groom_is_read_back_and_a_file_of_another_kind_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.nrrd");
        let mut groom = Groom::unpainted("bunny.obj", 32);
        let painted: Vec<usize> = groom.around(Vec3::new(0.5, 0.0, -0.2), 0.2).collect();
        let expected =
            (0..groom.voxels()).filter(|index| (groom.place(*index) - Vec3::new(0.5, 0.0, -0.2)).length() <= 0.2);
        assert_eq!(painted, expected.collect::<Vec<_>>());
        painted.iter().for_each(|index| groom.set(*index, [0.25, 3.0, 0.0, 0.5, 2.0, -2.0, 0.125, 1.0, 0.75]));
        let mut bytes = Vec::new();
        groom.write(&mut bytes).unwrap();
        std::fs::write(&path, &bytes).unwrap();
        let read = Groom::read(&path).unwrap();
        assert_eq!(read, groom);
        assert_eq!(read.at(painted[0]), [0.25, 2.0, 0.0, 0.5, 2.0, -1.0, 0.125, 1.0, 0.75]);
        let text = String::from_utf8_lossy(&bytes).into_owned();
        let end = text.find("\n\n").unwrap();
        for (from, to, said) in [
            (
                "9 32",
                "9 31",
                "line 6: expected `sizes: 9 n n n` with n from 32 to 256, or 8 channels without amounts, found 9 31",
            ),
            ("short", "float", "line 3: expected `type: short`, found float"),
            ("NRRD", "nrrd", "line 1: expected `NRRD0005`"),
            (KEY, "other", "line 1: expected a groom"),
        ] {
            let header = text[..end].replacen(from, to, 1).into_bytes();
            std::fs::write(&path, [&header, &bytes[end..]].concat()).unwrap();
            let error = Groom::read(&path).unwrap_err().to_string();
            assert!(error.contains(said), "{error}");
        }
        std::fs::write(&path, &bytes[..bytes.len() - 20]).unwrap();
        assert!(Groom::read(&path).unwrap_err().to_string().contains("compressed data damaged"));
    }
}
