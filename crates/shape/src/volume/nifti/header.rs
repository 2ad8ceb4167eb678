//! Header of a NIfTI file.
//!
//! Invariant: fields that change values or positions are understood or refused. Sources: R. Cox et al., "nifti1.h" and
//! "nifti2.h", nifti.nimh.nih.gov; Mayo Foundation, "ANALYZE 7.5 File Format".

use crate::error::{Location, ShapeError, quoted};
use crate::sample_type::SampleType;
use crate::shape::Content;
use crate::shape::axes::lengths;
use crate::source::Source;
use crate::unit::Unit;
use crate::volume::placement::{self, Placement};
use crate::volume::raster::{Compression, MAX_UNPACKED_SKIP, Raster};
use crate::volume::space::{Space, listed, or_usual};
use glam::{DMat3, DQuat, DVec3};

/// Description of signed distances.
pub(crate) const SIGNED_DISTANCE: &[u8] = b"hypertexture signed distance";
/// Squares of the real part of a quaternion below this are rounding errors of half a turn.
const HALF_TURN: f64 = 4e-7;

/// Offsets of the fields of a header.
pub(crate) struct HeaderLayout {
    /// Bytes of the header, also its first field.
    pub bytes: usize,
    /// Offset of the magic, and its values for data in the same file and in a file of its own.
    pub magic: usize,
    pub single: &'static [u8],
    pub pair: &'static [u8],
    /// Number of dimensions and 7 sizes.
    pub dim: usize,
    pub datatype: usize,
    pub bitpix: usize,
    /// Handedness of the qform, and 7 distances between samples.
    pub pixdim: usize,
    /// `vox_offset`, the start of the data.
    pub offset: usize,
    /// Slope and intercept.
    pub scale: usize,
    /// 80 characters.
    pub description: usize,
    /// Code of the units of space and time.
    pub units: usize,
    /// Codes of qform and sform.
    pub codes: usize,
    /// Quaternion, its shift, and the rows of the sform.
    pub forms: usize,
    /// 16 characters.
    pub intent: usize,
    /// Whether sizes, numbers and codes have 8, 8 and 4 bytes; else 2, 4 and 2.
    pub is_wide: bool,
}

/// NIfTI-1.
pub(crate) const NIFTI1: HeaderLayout = HeaderLayout {
    bytes: 348,
    magic: 344,
    single: b"n+1\0",
    pair: b"ni1\0",
    dim: 40,
    datatype: 70,
    bitpix: 72,
    pixdim: 76,
    offset: 108,
    scale: 112,
    description: 148,
    units: 123,
    codes: 252,
    forms: 256,
    intent: 328,
    is_wide: false,
};

/// NIfTI-2.
pub(crate) const NIFTI2: HeaderLayout = HeaderLayout {
    bytes: 540,
    magic: 4,
    single: b"n+2\0\r\n\x1a\n",
    pair: b"ni2\0\r\n\x1a\n",
    dim: 16,
    datatype: 12,
    bitpix: 14,
    pixdim: 104,
    offset: 168,
    scale: 176,
    description: 240,
    units: 500,
    codes: 344,
    forms: 352,
    intent: 508,
    is_wide: true,
};

impl HeaderLayout {
    /// Bytes of a number, a size and a code.
    pub fn widths(&self) -> (usize, usize, usize) {
        if self.is_wide { (8, 8, 4) } else { (4, 2, 2) }
    }
}

/// Codes of types, with the names of unsupported ones.
const TYPES: [(i64, Result<SampleType, &str>); 17] = [
    (1, Err("bits")),
    (2, Ok(SampleType::U8)),
    (4, Ok(SampleType::I16)),
    (8, Ok(SampleType::I32)),
    (16, Ok(SampleType::F32)),
    (32, Err("complex64")),
    (64, Ok(SampleType::F64)),
    (128, Err("RGB24")),
    (256, Ok(SampleType::I8)),
    (512, Ok(SampleType::U16)),
    (768, Ok(SampleType::U32)),
    (1024, Ok(SampleType::I64)),
    (1280, Ok(SampleType::U64)),
    (1536, Err("float128")),
    (1792, Err("complex128")),
    (2048, Err("complex256")),
    (2304, Err("RGBA32")),
];

/// Axes of Analyze 7.5 by orientation code: transverse, coronal, sagittal, then the three with rows reversed.
const ANALYZE_AXES: [&str; 6] = ["LAS", "LSA", "ASL", "LPS", "LIA", "AIL"];
/// Offset of the orientation code.
const ANALYZE_ORIENTATION: usize = 252;

pub(super) struct NiftiHeader<'s, 'a> {
    source: &'s Source<'a>,
    bytes: &'s [u8],
    is_analyze: bool,
    big_endian: bool,
    layout: &'static HeaderLayout,
}

/// Version and byte order by the first field; the flag is `true` for big endian.
pub(crate) fn version(start: &[u8]) -> Option<(&'static HeaderLayout, bool)> {
    let first = *start.first_chunk()?;
    let versions = [&NIFTI1, &NIFTI2].into_iter().flat_map(|layout| [(layout, false), (layout, true)]);
    versions.into_iter().find(|(layout, big_endian)| {
        let size = if *big_endian { u32::from_be_bytes(first) } else { u32::from_le_bytes(first) };
        size as usize == layout.bytes
    })
}

/// Whether a file is a header of Analyze 7.5: as long as that of NIfTI-1, without the magic.
pub(super) fn is_analyze(file: &[u8]) -> bool {
    let is_first = version(file).is_some_and(|(layout, _)| layout.bytes == NIFTI1.bytes);
    is_first && file.len() == NIFTI1.bytes && file[NIFTI1.magic] != b'n'
}

impl<'s, 'a> NiftiHeader<'s, 'a> {
    /// Header at the start of `bytes`; `is_whole` means that nothing follows in the file.
    pub fn new(source: &'s Source<'a>, bytes: &'s [u8], is_whole: bool) -> Result<NiftiHeader<'s, 'a>, ShapeError> {
        let malformed = |at: usize, expected, found| source.malformed_at(Location::Byte(at as u64), expected, found);
        let Some((layout, big_endian)) = version(bytes) else {
            let found = quoted(&bytes[..bytes.len().min(4)]);
            return Err(malformed(0, "348 or 540, the size of a NIfTI header", found));
        };
        if bytes.len() < layout.bytes {
            return Err(malformed(
                bytes.len(),
                "a header of 348 bytes, or 540 of NIfTI-2",
                "the end of the file".into(),
            ));
        }
        let is_analyze = is_whole && is_analyze(bytes);
        let header = NiftiHeader { source, bytes: &bytes[..layout.bytes], is_analyze, big_endian, layout };
        let magic = &bytes[layout.magic..][..layout.single.len()];
        if !is_analyze && magic != layout.single && magic != layout.pair {
            return Err(malformed(layout.magic, "`n+1` or `ni1`, for NIfTI-2 `n+2` or `ni2`", quoted(magic)));
        }
        Ok(header)
    }

    /// The unit of space; files of Analyze have none.
    pub fn unit(&self) -> Option<Unit> {
        match self.integer(self.layout.units, if self.layout.is_wide { 4 } else { 1 }) & 7 {
            _ if self.is_analyze => None,
            1 => Some(Unit::Meter),
            2 => Some(Unit::Millimeter),
            3 => Some(Unit::Micron),
            _ => None,
        }
    }

    /// Whether the data is in a separate file.
    pub(crate) fn is_pair(&self) -> bool {
        self.is_analyze || self.bytes[self.layout.magic..].starts_with(self.layout.pair)
    }

    /// Offset of the data in its file.
    ///
    /// # Parameters
    /// `bytes`: those of the data.
    pub fn offset(&self, bytes: u64) -> Result<u64, ShapeError> {
        let at = self.layout.offset;
        let offset = if self.layout.is_wide { self.integer(at, 8) as f64 } else { self.number(at) };
        // 4 bytes after the header flag extensions.
        let least = if self.is_pair() { 0 } else { self.layout.bytes + 4 };
        if offset == 0.0 && least > 0 {
            self.source.note(format!("vox_offset is 0: its data is read right after the header, from byte {least}"));
            return Ok(least as u64);
        }
        if offset == self.layout.bytes as f64 && least > 0 {
            return Ok(self.without_flag(bytes));
        }
        if offset.fract() != 0.0 || !(least as f64..=MAX_UNPACKED_SKIP as f64).contains(&offset) {
            let expected = "a vox_offset of whole bytes after the header (352, for NIfTI-2 544, or more, up to 2^28)";
            return Err(self.malformed(at, expected, offset.to_string()));
        }
        Ok(offset as u64)
    }

    /// Offset of the data of a file whose header says that no 4 bytes for extensions follow it: the length of the file tells.
    fn without_flag(&self, bytes: u64) -> u64 {
        let header = self.layout.bytes as u64;
        let offset = if self.source.len == header + 4 + bytes { header + 4 } else { header };
        self.source.note(format!("vox_offset is {header}: its data is read from byte {offset}"));
        offset
    }

    pub fn raster(&self, compression: Compression) -> Result<Raster, ShapeError> {
        let (size, kind, scale) = (self.size()?, self.kind()?, self.scale()?);
        let (space, place) = self.placement()?;
        let description = &self.bytes[self.layout.description..][..80];
        let is_distance = description.strip_prefix(SIGNED_DISTANCE).is_some_and(|rest| rest[0] == 0);
        let content = if is_distance { Content::SignedDistance } else { Content::Scalar };
        let placement = Placement::new(space, size, place, content);
        Ok(Raster { kind, big_endian: self.big_endian, compression, scale, placement })
    }

    /// Signed integer of `bytes` bytes.
    fn integer(&self, at: usize, bytes: usize) -> i64 {
        let mut number = [0; 8];
        for (i, byte) in self.bytes[at..][..bytes].iter().enumerate() {
            number[if self.big_endian { bytes - 1 - i } else { i }] = *byte;
        }
        let unused = 64 - 8 * bytes as u32;
        i64::from_le_bytes(number) << unused >> unused
    }

    /// Float of 4 or 8 bytes.
    fn number(&self, at: usize) -> f64 {
        if self.layout.is_wide {
            f64::from_bits(self.integer(at, 8) as u64)
        } else {
            f64::from(f32::from_bits(self.integer(at, 4) as u32))
        }
    }

    fn numbers<const N: usize>(&self, at: usize) -> [f64; N] {
        let (width, ..) = self.layout.widths();
        std::array::from_fn(|i| self.number(at + i * width))
    }

    fn malformed(&self, at: usize, expected: &'static str, found: String) -> ShapeError {
        self.source.malformed_at(Location::Byte(at as u64), expected, found)
    }

    fn unsupported(&self, at: usize, what: &'static str, found: String, remedy: &'static str) -> ShapeError {
        self.source.unsupported(Location::Byte(at as u64), what, found, remedy)
    }

    fn size(&self) -> Result<[u32; 3], ShapeError> {
        let (at, (_, width, _)) = (self.layout.dim, self.layout.widths());
        let dimensions = self.integer(at, width);
        if !(1..=7).contains(&dimensions) {
            return Err(self.malformed(at, "1 to 7 dimensions", dimensions.to_string()));
        }
        let sizes: Vec<i64> = (1..=dimensions as usize).map(|i| self.integer(at + i * width, width)).collect();
        let shown = || sizes.iter().map(|size| size.to_string()).collect::<Vec<_>>().join(" x ");
        let has_zeros = sizes.iter().skip(3).any(|size| *size == 0);
        if has_zeros {
            self.source.note(format!("it has sizes of {}: those of 0 beyond the third are read as 1", shown()));
        }
        let read = |(axis, size)| if axis > 2 && size == 0 { 1 } else { size };
        let sizes: Vec<i64> = sizes.into_iter().enumerate().map(read).collect();
        let shown = || sizes.iter().map(|size| size.to_string()).collect::<Vec<_>>().join(" x ");
        if sizes.iter().any(|size| *size < 1) {
            return Err(self.malformed(at + width, "sizes of at least 1", shown()));
        }
        match sizes[..] {
            [x, y, z, ref more @ ..] if more.iter().all(|size| *size == 1) => {
                placement::checked(&self.source.file, [x, y, z].map(|n| n as u64))
            }
            _ => {
                let remedy = "extract one volume of 3 dimensions (`fslroi` does, or nibabel's `four_to_three`)";
                Err(self.unsupported(at, "an image of", shown(), remedy))
            }
        }
    }

    fn kind(&self) -> Result<SampleType, ShapeError> {
        let at = self.layout.datatype;
        let code = self.integer(at, 2);
        let known = TYPES.iter().find(|(known, _)| *known == code).map(|(_, kind)| *kind);
        match known {
            Some(Ok(kind)) => {
                let bits = self.integer(self.layout.bitpix, 2);
                if bits != 0 && bits as u64 != 8 * kind.bytes() {
                    let own = 8 * kind.bytes();
                    self.source.note(format!("bitpix is {bits}: the {own} bits of its datatype, {kind}, are read"));
                }
                Ok(kind)
            }
            other => {
                let name = other.and_then(Result::err).map_or(String::new(), |name| format!("{name}, "));
                let remedy = "convert it to one number for each voxel: integers, float or double";
                Err(self.unsupported(at, "the datatype", format!("{name}{code}"), remedy))
            }
        }
    }

    fn scale(&self) -> Result<Option<[f64; 2]>, ShapeError> {
        let [slope, rest] = self.numbers(self.layout.scale);
        if slope == 0.0 {
            return Ok(None);
        }
        if slope.is_nan() {
            self.source.note("scl_slope is NaN: its values are read unscaled".into());
            return Ok(None);
        }
        let rest = match rest {
            _ if self.is_analyze => 0.0, // SPM writes a factor alone
            rest if rest.is_nan() => {
                self.source.note("scl_inter is NaN: 0 is used".into());
                0.0
            }
            rest => rest,
        };
        if !slope.is_finite() || !rest.is_finite() {
            let expected = "a finite scl_slope and scl_inter (a slope of 0 for none)";
            return Err(self.malformed(self.layout.scale, expected, format!("{slope} and {rest}")));
        }
        Ok(Some([slope, rest]).filter(|scale| *scale != [1.0, 0.0]))
    }

    /// Space, position of the first sample and steps: from the sform, else the qform, else the spacing alone.
    fn placement(&self) -> Result<(Space, (DVec3, DMat3)), ShapeError> {
        let (layout, (number, _, code)) = (self.layout, self.layout.widths());
        let [qform, sform] =
            if self.is_analyze { [0; 2] } else { [0, 1].map(|i| self.integer(layout.codes + i * code, code)) };
        let rows_at = layout.forms + 6 * number;
        let [x, y, z] = [0, 4, 8].map(|i| self.numbers::<4>(rows_at + i * number));
        let column = |i: usize| DVec3::new(x[i], y[i], z[i]);
        let rows = DMat3::from_cols(column(0), column(1), column(2));
        let is_blank = sform > 0 && rows == DMat3::ZERO;
        if is_blank {
            let other = if qform > 0 { "the qform" } else { "pixdim" };
            self.source.note(format!("its sform has no directions: {other} is read"));
        }
        let (at, origin, steps) = if sform > 0 && !is_blank {
            (rows_at, column(3), rows)
        } else {
            let [side, sizes @ ..]: [f64; 4] = self.numbers(layout.pixdim);
            let sizes = or_usual(self.source, "pixdim", sizes, 0.0, 1.0);
            if sizes.min_element() < 0.0 {
                let text = "their magnitudes are used";
                self.source.note(format!("pixdim is {}: {text}", listed(&sizes.to_array())));
            }
            let sizes = DMat3::from_diagonal(sizes.abs());
            if qform > 0 {
                let side = DVec3::new(1.0, 1.0, if side < 0.0 { -1.0 } else { 1.0 });
                let turn = self.turn()? * DMat3::from_diagonal(side);
                (layout.pixdim, DVec3::from(self.numbers(layout.forms + 3 * number)), turn * sizes)
            } else {
                (layout.pixdim, DVec3::ZERO, sizes)
            }
        };
        if !origin.is_finite() {
            return Err(self.malformed(at, "a finite place of the first sample", shown(&origin.to_array())));
        }
        if !placement::are_lengths(lengths(&steps)) {
            return Err(self.malformed(at, placement::STEPS, shown(&lengths(&steps).to_array())));
        }
        Ok((if self.is_analyze { self.analyze_space()? } else { Space::RAS }, (origin, steps)))
    }

    /// Axes of an Analyze image.
    fn analyze_space(&self) -> Result<Space, ShapeError> {
        let code = self.bytes[ANALYZE_ORIENTATION];
        let letters = ANALYZE_AXES.get(usize::from(code)).copied();
        let Some((letters, space)) = letters.and_then(|letters| Some((letters, Space::of(letters)?))) else {
            let found = code.to_string();
            return Err(self.malformed(ANALYZE_ORIENTATION, "an orientation of Analyze 7.5 from 0 to 5", found));
        };
        let text = "Analyze 7.5 has no origin: the first sample is put at 0, and the axes point to";
        self.source.note(format!("{text} {letters} (orientation {code})"));
        Ok(space)
    }

    /// Rotation of the qform.
    fn turn(&self) -> Result<DMat3, ShapeError> {
        let parts: [f64; 3] = self.numbers(self.layout.forms);
        let vector = DVec3::from(parts);
        let square = 1.0 - vector.length_squared();
        if !square.is_finite() || square < -1e-5 {
            let expected = "a quaternion whose parts have squares of 1 together at most";
            return Err(self.malformed(self.layout.forms, expected, shown(&parts)));
        }
        let real = if square < HALF_TURN { 0.0 } else { square.sqrt() };
        Ok(DMat3::from_quat(DQuat::from_xyzw(vector.x, vector.y, vector.z, real).normalize()))
    }
}

fn shown(numbers: &[f64]) -> String {
    numbers.iter().map(|number| format!("{number:.9}")).collect::<Vec<_>>().join(" ")
}
