//! NRRD, "nearly raw raster data": volumes in and out.
//!
//! Role: the data behind a header that [`super::nrrd_header`] has checked, or in a file beside it, and a writer. Invariant:
//! what is written is read back bit for bit. Source: G. Kindlmann, "Definition of NRRD file format",
//! teem.sourceforge.net/nrrd/format.html.

use super::error::ShapeError;
use super::nrrd_header::{CONTENT_KEY, Header, SIGNED_DISTANCE};
use super::source::Source;
use super::values::{LEVEL, check, write_values};
use super::{Content, Shape, Volume};
use flate2::write::GzEncoder;
use std::io::{self, Write};

/// Whether the file begins with the magic number of versions 1 to 5.
pub(super) fn recognizes(start: &[u8], _len: u64) -> bool {
    start.starts_with(b"NRRD000") && matches!(start.get(7), Some(b'1'..=b'5'))
}

/// Reads a volume: raw, gzip, bzip2 or text, attached or in files beside it; integers of 8 to 64 bits, float or double,
/// both byte orders, converted to f32 (integers above 2^24 and doubles are rounded).
pub(super) fn read(source: &mut Source) -> Result<Shape, ShapeError> {
    if !recognizes(source.peek()?, 0) {
        let start = source.peek()?.to_vec();
        source.line = 1;
        return Err(source.malformed("`NRRD0001` to `NRRD0005`", &start));
    }
    let Header { raster, data } = Header::read(source)?;
    raster.read(source, &data)
}

/// Writes `volume` as an attached NRRD: float, little endian, gzip. [`open`](super::open) reads it back bit for bit if
/// the values are finite and the samples within 131072 voxels of the origin.
///
/// x runs fastest. A signed distance is marked by the line `hypertexture content:=signed distance`.
///
/// # Errors
/// What `to` returns, and `InvalidInput` where the number of values is not the product of the sizes.
pub fn write_nrrd(volume: &Volume, mut to: impl Write) -> io::Result<()> {
    check(volume)?;
    let ([x, y, z], steps, origin) = (volume.size, volume.steps, volume.origin);
    writeln!(
        to,
        "NRRD0005\n# written by hypertexture\ntype: float\ndimension: 3\nspace: right-anterior-superior\nsizes: {x} {y} {z}"
    )?;
    let [a, b, c] =
        [steps.x_axis, steps.y_axis, steps.z_axis].map(|step| format!("({},{},{})", step.x, step.y, step.z));
    writeln!(to, "space directions: {a} {b} {c}")?;
    writeln!(to, "space origin: ({},{},{})", origin.x, origin.y, origin.z)?;
    writeln!(to, "kinds: domain domain domain\nendian: little\nencoding: gzip")?;
    if volume.content == Content::SignedDistance {
        writeln!(to, "{CONTENT_KEY}:={SIGNED_DISTANCE}")?;
    }
    writeln!(to)?;
    let mut encoder = GzEncoder::new(to, LEVEL);
    write_values(volume, &mut encoder)?;
    encoder.finish()?.flush()
}
