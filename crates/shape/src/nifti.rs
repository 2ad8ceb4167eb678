//! NIfTI-1 and NIfTI-2: volumes as .nii, the same packed by gzip, or a pair of .hdr and .img; such pairs of Analyze 7.5 too.
//!
//! Role: the data behind a header that [`super::nifti_header`] reads. Invariant: coordinates are those of the file, x to the
//! right, y to the front, z up. Read here and not by the nifti crate, which makes room for what a header declares.

use super::Shape;
use super::error::ShapeError;
use super::files::Files;
use super::nifti_header::{FIRST, Header, SECOND, is_analyze, version};
use super::raster::{Data, MAX_DEFLATE_RATIO, Packing, Raster, Skip};
use super::source::{Source, read_block};
use super::unpack::{GZIP, Unpacked};
use flate2::bufread::MultiGzDecoder;
use std::cell::Cell;
use std::io::{BufReader, Read};
use std::path::Path;

/// Whether the file begins with a header, packed or not.
pub(super) fn recognizes(start: &[u8], _len: u64) -> bool {
    let mut unpacked = Vec::new();
    if start.starts_with(&GZIP) {
        // The end of what is there is no end of the file: what came out before it is enough.
        let _ = MultiGzDecoder::new(start).take(SECOND.bytes as u64).read_to_end(&mut unpacked);
    }
    let start = if unpacked.is_empty() { start } else { &unpacked };
    version(start).is_some_and(|(places, _)| {
        let magic = start.get(places.magic..).unwrap_or_default();
        magic.starts_with(places.single) || magic.starts_with(places.pair) || is_analyze(start)
    })
}

/// Reads a volume of 3 dimensions: integers of 8 to 64 bits, float or double, both byte orders, scaled and then rounded to
/// f32. Extensions, units and what is said of time are read over.
pub(super) fn read(source: &mut Source) -> Result<Shape, ShapeError> {
    if !source.peek()?.starts_with(&GZIP) {
        return read_unpacked(source, Packing::None);
    }
    let (file, folder) = (source.file.clone(), source.folder.clone());
    let len = source.remaining().saturating_mul(MAX_DEFLATE_RATIO);
    let padding = Cell::new(0);
    let reader = &mut BufReader::new(Unpacked::gzip(&mut *source.reader, &padding));
    let mut inner = Source::new(file, len, folder, reader);
    let shape = read_unpacked(&mut inner, Packing::Unpacked)?;
    let (notes, others) = (inner.notes.take(), inner.others.take());
    notes.into_iter().for_each(|note| source.note(note));
    source.others.borrow_mut().extend(others);
    source.note_padding(padding.get());
    Ok(shape)
}

fn read_unpacked(source: &mut Source, packing: Packing) -> Result<Shape, ShapeError> {
    let mut bytes = [0; SECOND.bytes];
    let failed = |source: &Source, reason| match packing {
        Packing::Unpacked => {
            ShapeError::Packed { file: source.file.clone(), offset: 0, decoded: source.offset, reason }
        }
        _ => source.unreadable(reason),
    };
    let mut filled = 0;
    for end in [FIRST.bytes, SECOND.bytes] {
        if end == FIRST.bytes || version(&bytes).is_some_and(|(places, _)| places.bytes == end) {
            filled +=
                read_block(&mut source.reader, &mut bytes[filled..end]).map_err(|reason| failed(source, reason))?;
            source.offset = filled as u64;
        }
    }
    let is_whole = source.peek()?.is_empty();
    let header = Header::new(source, &bytes[..filled], is_whole)?;
    let (raster, offset, is_pair) = (header.raster(packing)?, header.offset()?, header.is_pair());
    if !is_pair {
        let before = Skip::Bytes(offset - source.offset);
        return raster.read(source, &Data { before, ..Data::HERE });
    }
    let own = Path::new(&source.file).file_name().unwrap_or_default();
    let (name, packing, [before, inside]) = match packing {
        Packing::Unpacked => (Path::new(own).with_extension("").with_extension("img.gz"), Packing::Gzip, [0, offset]),
        _ => (Path::new(own).with_extension("img"), Packing::None, [offset, 0]),
    };
    let files = Some(Files::Named(vec![name.to_string_lossy().into_owned()]));
    let data = Data { files, lines: 0, before: Skip::Bytes(before), inside };
    Raster { packing, ..raster }.read(source, &data)
}
