//! NRRD volumes: attached header, raw or gzip data, three axes.
//!
//! Source: the format definition of Teem, <https://teem.sourceforge.net/nrrd/format.html>. A signed distance is marked
//! by the key/value pair `hypertexture content:=signed distance`.

use super::error::{Found, Place, quoted};
use super::{Content, Shape, ShapeError, Volume, volume};
use flate2::Compression;
use flate2::read::MultiGzDecoder;
use flate2::write::GzEncoder;
use glam::Vec3;
use std::collections::HashMap;
use std::io::{self, Read, Write};

/// The largest volume that is read: 2^31 samples.
const MAX_SAMPLES: u64 = 1 << 31;
/// Deflate never makes more than this many bytes out of one.
const MAX_RATIO: u64 = 1032;
/// Key and value that mark a signed distance.
const CONTENT: (&str, &str) = ("hypertexture content", "signed distance");

/// Reads a volume.
pub(super) fn read(file: &str, bytes: Vec<u8>) -> Result<Shape, ShapeError> {
    let header = Header::parse(file, &bytes)?;
    let size = header.sizes()?;
    let kind = header.kind()?;
    let samples = size.iter().try_fold(1u64, |product, &side| product.checked_mul(side));
    let samples = samples.filter(|&samples| samples <= MAX_SAMPLES).ok_or_else(|| ShapeError::TooLarge {
        file: file.into(),
        what: "voxels",
        found: format!("{} x {} x {}", size[0], size[1], size[2]),
        limit: MAX_SAMPLES,
    })?;
    let data = header.data(samples * kind.bytes as u64, &bytes, || {
        format!("{} x {} x {} samples of {} bytes", size[0], size[1], size[2], kind.bytes)
    })?;
    let values = kind.decode(&data, header.big_endian(kind.bytes)?);
    let spacing = header.spacing()?;
    let volume = Volume {
        size: size.map(|side| side as u32),
        origin: header.origin()?,
        spacing,
        values,
        content: match header.pairs.get(CONTENT.0) {
            Some(value) if value == CONTENT.1 => Content::SignedDistance,
            _ => Content::Scalar,
        },
    };
    volume::checked(file, volume).map(Shape::Volume)
}

/// Writes a volume as 32-bit floats, gzip-compressed, little-endian.
///
/// # Errors
/// What `to` fails with.
pub fn write_nrrd(volume: &Volume, mut to: impl Write) -> io::Result<()> {
    let [x, y, z] = volume.size;
    let (o, s) = (volume.origin, volume.spacing);
    writeln!(to, "NRRD0005\ntype: float\ndimension: 3\nspace dimension: 3\nsizes: {x} {y} {z}")?;
    writeln!(to, "space directions: ({},0,0) (0,{},0) (0,0,{})", s.x, s.y, s.z)?;
    writeln!(to, "space origin: ({},{},{})\nendian: little\nencoding: gzip", o.x, o.y, o.z)?;
    if volume.content == Content::SignedDistance {
        writeln!(to, "{}:={}", CONTENT.0, CONTENT.1)?;
    }
    writeln!(to)?;
    let mut gzip = GzEncoder::new(to, Compression::fast());
    for slice in volume.values.chunks(1 << 16) {
        gzip.write_all(&slice.iter().flat_map(|value| value.to_le_bytes()).collect::<Vec<_>>())?;
    }
    gzip.finish()?.flush()
}

/// The type of a sample.
#[derive(Clone, Copy)]
struct Kind {
    bytes: usize,
    convert: fn(&[u8]) -> f32,
}

/// Little-endian readers of every type, by its names.
fn kind_of(name: &str) -> Option<Kind> {
    macro_rules! kind {
        ($t:ty) => {
            Kind {
                bytes: size_of::<$t>(),
                convert: |b| <$t>::from_le_bytes(b.try_into().expect("a chunk has the size of its type")) as f32,
            }
        };
    }
    Some(match name {
        "signed char" | "int8" | "int8_t" => kind!(i8),
        "uchar" | "unsigned char" | "uint8" | "uint8_t" => kind!(u8),
        "short" | "short int" | "signed short" | "signed short int" | "int16" | "int16_t" => kind!(i16),
        "ushort" | "unsigned short" | "unsigned short int" | "uint16" | "uint16_t" => kind!(u16),
        "int" | "signed int" | "int32" | "int32_t" => kind!(i32),
        "uint" | "unsigned int" | "uint32" | "uint32_t" => kind!(u32),
        "float" => kind!(f32),
        "double" => kind!(f64),
        _ => return None,
    })
}

impl Kind {
    fn decode(&self, data: &[u8], big_endian: bool) -> Vec<f32> {
        let samples = data.chunks_exact(self.bytes);
        match big_endian {
            false => samples.map(self.convert).collect(),
            true => samples
                .map(|sample| {
                    let mut swapped = [0; 8];
                    swapped[..self.bytes].copy_from_slice(sample);
                    swapped[..self.bytes].reverse();
                    (self.convert)(&swapped[..self.bytes])
                })
                .collect(),
        }
    }
}

/// The fields of a header, each with its line.
struct Header<'a> {
    file: &'a str,
    fields: HashMap<String, (u64, String)>,
    pairs: HashMap<String, String>,
    data_at: usize,
}

impl Header<'_> {
    fn parse<'a>(file: &'a str, bytes: &[u8]) -> Result<Header<'a>, ShapeError> {
        let mut header = Header { file, fields: HashMap::new(), pairs: HashMap::new(), data_at: 0 };
        for (index, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
            let place = Place::Line(index as u64 + 1);
            header.data_at += line.len() + 1;
            let text = line.strip_suffix(b"\r").unwrap_or(line);
            if text.is_empty() {
                if header.data_at > bytes.len() {
                    break;
                }
                return Ok(header);
            }
            let malformed =
                |expected| ShapeError::Malformed { file: file.into(), place, expected, found: quoted(text) };
            let text = std::str::from_utf8(text).map_err(|_| malformed("a line of text"))?;
            if index == 0 || text.starts_with('#') {
                continue;
            }
            if let Some((key, value)) = text.split_once(":=") {
                header.pairs.insert(key.into(), value.into());
            } else if let Some((key, value)) = text.split_once(": ").or_else(|| text.split_once(':')) {
                header.fields.insert(key.trim().to_lowercase(), (index as u64 + 1, value.trim().into()));
            } else {
                return Err(malformed("`field: value`"));
            }
        }
        let expected = "an empty line between header and data";
        let found = "the end of the file".into();
        Err(ShapeError::Malformed { file: file.into(), place: Place::Header, expected, found })
    }

    fn field(&self, name: &'static str) -> Result<(u64, &str), ShapeError> {
        let found = self.fields.get(name).map(|(line, value)| (*line, value.as_str()));
        found.ok_or_else(|| ShapeError::Malformed {
            file: self.file.into(),
            place: Place::Header,
            expected: name,
            found: "no such field".into(),
        })
    }

    fn malformed(&self, line: u64, expected: &'static str, found: &str) -> ShapeError {
        let (file, place) = (self.file.into(), Place::Line(line));
        ShapeError::Malformed { file, place, expected, found: quoted(found.as_bytes()) }
    }

    fn unsupported(&self, line: u64, what: &'static str, found: &str, remedy: &'static str) -> ShapeError {
        let (file, place) = (self.file.into(), Place::Line(line));
        ShapeError::Unsupported { file, place, what, found: quoted(found.as_bytes()), remedy }
    }

    fn sizes(&self) -> Result<[u64; 3], ShapeError> {
        let (line, dimension) = self.field("dimension")?;
        if dimension != "3" {
            return Err(self.unsupported(line, "dimension", dimension, "save one volume with 3 axes"));
        }
        let (line, text) = self.field("sizes")?;
        let wrong = || self.malformed(line, "three whole numbers", text);
        let sizes: Vec<u64> = text.split_whitespace().map(str::parse).collect::<Result<_, _>>().map_err(|_| wrong())?;
        let size: [u64; 3] = sizes.try_into().map_err(|_| wrong())?;
        match size.contains(&0) {
            true => Err(ShapeError::ZeroSize { file: self.file.into(), line, size }),
            false => Ok(size),
        }
    }

    fn kind(&self) -> Result<Kind, ShapeError> {
        let (line, name) = self.field("type")?;
        kind_of(name)
            .ok_or_else(|| self.unsupported(line, "type", name, "save 8, 16 or 32-bit integers, float or double"))
    }

    fn big_endian(&self, bytes: usize) -> Result<bool, ShapeError> {
        if bytes == 1 {
            return Ok(false);
        }
        match self.field("endian")? {
            (_, "little") => Ok(false),
            (_, "big") => Ok(true),
            (line, other) => Err(self.malformed(line, "`little` or `big`", other)),
        }
    }

    /// The bytes of the data, exactly as many as declared.
    fn data(&self, declared: u64, bytes: &[u8], what: impl Fn() -> String) -> Result<Vec<u8>, ShapeError> {
        if let Some((line, value)) = self.fields.get("data file").or_else(|| self.fields.get("datafile")) {
            return Err(self.unsupported(*line, "data file", value, "save header and data in one .nrrd file"));
        }
        for skip in ["line skip", "lineskip", "byte skip", "byteskip"] {
            if let Some((line, value)) = self.fields.get(skip).filter(|(_, value)| value != "0") {
                return Err(self.unsupported(*line, "skip", value, "save the volume without a skip"));
            }
        }
        let stored = &bytes[self.data_at..];
        let size = |found| ShapeError::DataSize {
            file: self.file.into(),
            offset: self.data_at as u64,
            declared,
            what: what(),
            found,
        };
        match self.field("encoding")? {
            (_, "raw") if stored.len() as u64 == declared => Ok(stored.to_vec()),
            (_, "raw") => Err(size(Found::Bytes(stored.len() as u64))),
            (_, "gzip" | "gz") => {
                let at_most = (stored.len() as u64).saturating_mul(MAX_RATIO);
                if declared > at_most {
                    return Err(size(Found::AtMost(at_most)));
                }
                let mut data = Vec::new();
                data.try_reserve_exact(declared as usize)
                    .map_err(|_| ShapeError::OutOfMemory { file: self.file.into(), bytes: declared })?;
                let mut decoder = MultiGzDecoder::new(stored).take(declared + 1);
                let decoded = decoder.read_to_end(&mut data);
                let so_far = data.len() as u64;
                decoded.map_err(|reason| ShapeError::Gzip {
                    file: self.file.into(),
                    offset: self.data_at as u64,
                    decoded: so_far,
                    reason,
                })?;
                match so_far == declared {
                    true => Ok(data),
                    false if so_far > declared => Err(size(Found::More)),
                    false => Err(size(Found::Bytes(so_far))),
                }
            }
            (line, other) => Err(self.unsupported(line, "encoding", other, "save it as raw or gzip")),
        }
    }

    fn spacing(&self) -> Result<Vec3, ShapeError> {
        if let Some((line, text)) = self.fields.get("space directions") {
            let wrong = || self.malformed(*line, "three vectors such as (1,0,0) (0,1,0) (0,0,2)", text);
            let rows: Vec<Vec3> = text.split_whitespace().map(vector).collect::<Option<_>>().ok_or_else(wrong)?;
            let [x, y, z]: [Vec3; 3] = rows.try_into().map_err(|_| wrong())?;
            let spacing = Vec3::new(x.x, y.y, z.z);
            let oblique = x.y != 0.0 || x.z != 0.0 || y.x != 0.0 || y.z != 0.0 || z.x != 0.0 || z.y != 0.0;
            if oblique || spacing.min_element() <= 0.0 {
                let remedy = "resample the volume to axes along x, y and z, with positive steps";
                return Err(self.unsupported(*line, "space directions", text, remedy));
            }
            return Ok(spacing);
        }
        let Some((line, text)) = self.fields.get("spacings") else { return Ok(Vec3::ONE) };
        let numbers: Option<Vec<f32>> = text.split_whitespace().map(|number| number.parse().ok()).collect();
        let spacing = numbers.and_then(|numbers| <[f32; 3]>::try_from(numbers).ok()).map(Vec3::from);
        spacing
            .map(|s| if s.is_nan() { Vec3::ONE } else { s })
            .filter(|s| s.is_finite() && s.min_element() > 0.0)
            .ok_or_else(|| self.malformed(*line, "three positive numbers", text))
    }

    fn origin(&self) -> Result<Vec3, ShapeError> {
        if let Some((line, text)) = self.fields.get("space origin") {
            return vector(text).ok_or_else(|| self.malformed(*line, "a vector such as (0,0,0)", text));
        }
        let Some((line, text)) = self.fields.get("axis mins") else { return Ok(Vec3::ZERO) };
        let numbers: Option<Vec<f32>> = text.split_whitespace().map(|number| number.parse().ok()).collect();
        let origin = numbers.and_then(|numbers| <[f32; 3]>::try_from(numbers).ok()).map(Vec3::from);
        origin.filter(|o| o.is_finite()).ok_or_else(|| self.malformed(*line, "three numbers", text))
    }
}

/// Reads `(x,y,z)`.
fn vector(text: &str) -> Option<Vec3> {
    let inner = text.trim().strip_prefix('(')?.strip_suffix(')')?;
    let numbers: Vec<f32> = inner.split(',').map(|number| number.trim().parse().ok()).collect::<Option<_>>()?;
    <[f32; 3]>::try_from(numbers).ok().map(Vec3::from).filter(|v| v.is_finite())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn sample() -> Volume {
        let values = (0..24).map(|i| i as f32 * 0.5 - 3.0).collect();
        let (origin, spacing) = (Vec3::new(1.0, -2.0, 0.25), Vec3::new(0.5, 1.0, 2.0));
        Volume { size: [2, 3, 4], origin, spacing, values, content: Content::SignedDistance }
    }

    fn written() -> Vec<u8> {
        let mut bytes = Vec::new();
        write_nrrd(&sample(), &mut bytes).unwrap();
        bytes
    }

    fn text(header: &str, data: &[u8]) -> Vec<u8> {
        [format!("NRRD0004\n{header}\n\n").as_bytes(), data].concat()
    }

    #[test]
    fn what_is_written_reads_back_to_the_bit() {
        let Shape::Volume(volume) = read("a.nrrd", written()).unwrap() else { panic!("a volume") };
        let expected = sample();
        assert_eq!((volume.size, volume.values, volume.content), (expected.size, expected.values, expected.content));
        assert_eq!((volume.origin, volume.spacing), (expected.origin, expected.spacing));
    }

    #[test]
    fn every_type_and_both_byte_orders_give_the_same_values() {
        let cases: [(&str, &str, Vec<u8>); 6] = [
            ("uint8", "little", vec![1, 2]),
            ("short", "big", vec![0, 1, 0, 2]),
            ("ushort", "little", vec![1, 0, 2, 0]),
            ("int", "big", vec![0, 0, 0, 1, 0, 0, 0, 2]),
            ("float", "big", [1f32.to_be_bytes(), 2f32.to_be_bytes()].concat()),
            ("double", "little", [1f64.to_le_bytes(), 2f64.to_le_bytes()].concat()),
        ];
        for (kind, endian, data) in cases {
            let header =
                format!("type: {kind}\ndimension: 3\nsizes: 2 1 1\nendian: {endian}\nencoding: raw\nspacings: 1 2 3");
            let Shape::Volume(volume) = read("a.nrrd", text(&header, &data)).unwrap() else { panic!("a volume") };
            assert_eq!((volume.values, volume.spacing), (vec![1.0, 2.0], Vec3::new(1.0, 2.0, 3.0)), "{kind}");
        }
    }

    #[test]
    fn what_is_wrong_is_named() {
        let good = "type: uint8\ndimension: 3\nsizes: 2 1 1\nencoding: raw";
        let cases = [
            (
                good.replace("2 1 1", "2 1 9"),
                "declares 18 bytes of data (2 x 1 x 9 samples of 1 bytes), the file holds 2",
            ),
            (good.replace("2 1 1", "2 0 1"), "line 4: a volume of 2 x 0 x 1 has no samples"),
            (good.replace("2 1 1", "99999999 99999999 99999999"), "the limit is 2147483648"),
            (good.replace("raw", "bzip2"), "encoding `bzip2` is not supported; save it as raw or gzip"),
            (good.replace("uint8", "block"), "type `block` is not supported"),
            (good.replace("dimension: 3", "dimension: 4"), "dimension `4` is not supported"),
            (good.replace("sizes: 2 1 1\n", ""), "expected sizes, found no such field"),
            (good.replace("raw", "gzip"), "gzip data damaged"),
            (format!("{good}\nspace directions: (1,0.5,0) (0,1,0) (0,0,1)"), "resample the volume"),
        ];
        for (header, expected) in cases {
            let error = read("a.nrrd", text(&header, &[1, 2])).unwrap_err().to_string();
            assert!(error.contains(expected) && !error.contains('\n'), "{error}");
        }
        assert!(read("a.nrrd", b"NRRD0004\ntype: float".to_vec()).unwrap_err().to_string().contains("empty line"));
        let nan = text(
            "type: float\ndimension: 3\nsizes: 2 1 1\nendian: little\nencoding: raw",
            &[0, 0, 0, 0, 0, 0, 192, 127],
        );
        assert!(read("a.nrrd", nan).unwrap_err().to_string().contains("1 of 2 voxels are NaN"));
    }

    proptest! {
        #[test]
        fn a_damaged_file_is_an_error_or_a_volume_and_never_a_panic(at in 0usize..400, byte: u8, cut in 0usize..400) {
            let mut bytes = written();
            let (at, cut) = (at % bytes.len(), cut % bytes.len());
            bytes[at] = byte;
            let _ = read("a.nrrd", bytes.clone());
            bytes.truncate(cut);
            let _ = read("a.nrrd", bytes);
        }
    }
}
