//! NIfTI-1 and NIfTI-2: volumes as .nii, .nii.gz or a pair of .hdr and .img; pairs of Analyze 7.5.

pub(crate) mod header;

use super::data_files::DataFiles;
use super::decompress::{Decompressor, GZIP};
use super::raster::{Compression, Data, MAX_DEFLATE_RATIO, Raster};
use crate::error::ShapeError;
use crate::shape::Shape;
use crate::source::{Source, read_block};
use flate2::bufread::MultiGzDecoder;
use header::{NIFTI1, NIFTI2, NiftiHeader, is_analyze, version};
use std::cell::Cell;
use std::io::{BufReader, Read};
use std::path::Path;

/// Whether the file begins with a header, compressed or not.
pub(crate) fn recognizes(start: &[u8], _len: u64) -> bool {
    let mut unpacked = Vec::new();
    if start.starts_with(&GZIP) {
        // `start` is cut off: the error at its end is expected.
        let _ = MultiGzDecoder::new(start).take(NIFTI2.bytes as u64).read_to_end(&mut unpacked);
    }
    let start = if unpacked.is_empty() { start } else { &unpacked };
    version(start).is_some_and(|(layout, _)| {
        let magic = start.get(layout.magic..).unwrap_or_default();
        magic.starts_with(layout.single) || magic.starts_with(layout.pair) || is_analyze(start)
    })
}

/// Reads a volume of 3 dimensions: integers of 8 to 64 bits, float or double, both byte orders, scaled and then rounded to
/// f32. Extensions and time are ignored.
pub(crate) fn read(source: &mut Source) -> Result<Shape, ShapeError> {
    if !source.peek()?.starts_with(&GZIP) {
        return read_unpacked(source, Compression::None);
    }
    let (file, folder) = (source.file.clone(), source.folder.clone());
    let len = source.remaining().saturating_mul(MAX_DEFLATE_RATIO);
    let padding = Cell::new(0);
    let reader = &mut BufReader::new(Decompressor::gzip(&mut *source.reader, &padding));
    let mut inner = Source::new(file, len, folder, reader);
    let shape = read_unpacked(&mut inner, Compression::Unpacked)?;
    let (notes, others) = (inner.notes, inner.others);
    source.unit.set(inner.unit.get());
    source.notes.borrow_mut().extend(notes.take());
    source.others.borrow_mut().extend(others.take());
    source.note_padding(padding.get());
    Ok(shape)
}

fn read_unpacked(source: &mut Source, compression: Compression) -> Result<Shape, ShapeError> {
    let mut bytes = [0; NIFTI2.bytes];
    let failed = |source: &Source, reason| match compression {
        Compression::Unpacked => source.packed(0, source.offset, reason),
        _ => source.unreadable(reason),
    };
    let mut filled = 0;
    for end in [NIFTI1.bytes, NIFTI2.bytes] {
        if end == NIFTI1.bytes || version(&bytes).is_some_and(|(layout, _)| layout.bytes == end) {
            filled +=
                read_block(&mut source.reader, &mut bytes[filled..end]).map_err(|reason| failed(source, reason))?;
            source.offset = filled as u64;
        }
    }
    let is_whole = source.peek()?.is_empty();
    let header = NiftiHeader::new(source, &bytes[..filled], is_whole)?;
    source.unit.set(header.unit());
    let raster = header.raster(compression)?;
    let (offset, is_pair) = (header.offset(raster.placement.voxels() * raster.kind.bytes())?, header.is_pair());
    if !is_pair {
        let before = Some(offset - source.offset);
        return raster.read(source, &Data { before, ..Data::HERE });
    }
    let own = Path::new(&source.file).file_name().unwrap_or_default();
    let (name, compression, [before, inside]) = match compression {
        Compression::Unpacked => {
            (Path::new(own).with_extension("").with_extension("img.gz"), Compression::Gzip, [0, offset])
        }
        _ => (Path::new(own).with_extension("img"), Compression::None, [offset, 0]),
    };
    let files = Some(DataFiles::Named(vec![name.to_string_lossy().into_owned()]));
    let data = Data { files, lines: 0, before: Some(before), inside: Some(inside) };
    Raster { compression, ..raster }.read(source, &data)
}
