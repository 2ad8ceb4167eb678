//! Reader of glTF and GLB.
//!
//! Role: all triangles of the default scene as one mesh. Invariant: numbers of the file are checked before use. Source: Khronos
//! Group, "glTF 2.0 specification", 2021 (ISO/IEC 12113).

use super::buffer::Data;
use super::material::Materials;
use super::{document, scene};
use crate::error::{Found, Location, ShapeError, quoted};
use crate::shape::{Mesh, Shape};
use crate::source::Source;
use crate::unit::Unit;

/// Most bytes of JSON: 190 MB of data in base64.
const MAX_JSON: u64 = 256 << 20;
const HEADER_BYTES: usize = 12;
const CHUNK_HEADER_BYTES: usize = 8;
/// Noun for messages.
const CHUNK: &str = "a chunk";

/// Whether the file begins as GLB, or as JSON with an `asset`.
pub(crate) fn recognizes(start: &[u8], _len: u64) -> bool {
    let names_asset = || start.windows(7).any(|window| window == b"\"asset\"");
    start.starts_with(b"glTF") || start.trim_ascii_start().starts_with(b"{") && names_asset()
}

/// Reads the triangles of the visible nodes of the default scene (else the first, else of all nodes).
///
/// Cameras, lights and normals are skipped, and materials and textures unless they are asked for. Points, lines and primitives
/// without positions are left out, and skins, morph targets and cut-outs by alphaMode are not applied, with notes. Compressed
/// and instanced geometry is refused.
pub(crate) fn read(source: &mut Source) -> Result<Shape, ShapeError> {
    let (json, binary) =
        if source.peek()?.starts_with(b"glTF") { chunks(source)? } else { (json(source, source.remaining())?, None) };
    source.unit.set(Some(Unit::Meter));
    let document = document::parse(source, &json)?;
    let materials = source.is_painted.then(|| Materials::parse(source, &json)).transpose()?;
    let data = Data::new(source, &document, binary);
    let mut found = scene::read(&data, materials.as_ref())?;
    let materials = materials.map(|materials| materials.used(&data, &mut found.spots)).transpose()?;
    drop(data);
    let holds = if found.notes.is_empty() { "no mesh in the scene".into() } else { found.notes.join("; ") };
    found.notes.into_iter().for_each(|note| source.note(note));
    let (mut mesh, zero_area) = Mesh::cleaned_with(&found.positions, &found.colors, &found.spots, found.triangles);
    mesh.paint.materials = materials.unwrap_or_default();
    source.finish((mesh, zero_area + found.zero_area), holds)
}

fn json(source: &mut Source, bytes: u64) -> Result<Vec<u8>, ShapeError> {
    if bytes > MAX_JSON {
        return Err(source.too_large("bytes of JSON", bytes, MAX_JSON));
    }
    source.block(bytes, "JSON")
}

/// JSON and optional binary chunk of a GLB file; further chunks are ignored.
fn chunks(source: &mut Source) -> Result<(Vec<u8>, Option<Vec<u8>>), ShapeError> {
    let [_, version, length] = words::<HEADER_BYTES, 3>(source, "the header of GLB")?;
    if version != 2 {
        let found = format!("`{version}`");
        return Err(source.unsupported(Location::Byte(4), "version", found, "export it as glTF 2.0"));
    }
    let (declared, held) = (u64::from(length), source.len);
    if declared > held {
        let (file, found) = (source.file.clone(), Found::Bytes(held));
        return Err(ShapeError::DataSize { file, offset: 0, declared, what: "the whole file".into(), found });
    }
    if declared == 0 {
        source.note("its length is declared as 0: the whole file is read".into());
    } else if declared < held {
        source.note(format!("bytes after the declared end of the file are left out: {}", held - declared));
        source.len = declared;
    }
    let (kind, bytes) = chunk(source)?;
    if kind != *b"JSON" {
        return Err(source.malformed_at(Location::Byte(16), "the chunk `JSON` first", quoted(&kind)));
    }
    let json = json(source, bytes)?;
    if source.remaining() > 0 {
        let (kind, bytes) = chunk(source)?;
        if kind == *b"BIN\0" {
            return Ok((json, Some(source.block(bytes, CHUNK)?)));
        }
    }
    Ok((json, None))
}

/// Type and length of the next chunk, which is complete.
fn chunk(source: &mut Source) -> Result<([u8; 4], u64), ShapeError> {
    let at = source.offset;
    let [bytes, kind] = words::<CHUNK_HEADER_BYTES, 2>(source, "the header of a chunk")?;
    if bytes % 4 != 0 {
        let expected = "the length of a chunk as a multiple of 4";
        return Err(source.malformed_at(Location::Byte(at), expected, bytes.to_string()));
    }
    if u64::from(bytes) > source.remaining() {
        return Err(source.data_size(bytes.into(), CHUNK.into(), Found::Bytes(source.remaining())));
    }
    Ok((kind.to_le_bytes(), bytes.into()))
}

/// Next `W` 32-bit integers, `B` bytes.
fn words<const B: usize, const W: usize>(source: &mut Source, what: &str) -> Result<[u32; W], ShapeError> {
    let bytes: [u8; B] = source.array(what)?;
    Ok(std::array::from_fn(|word| u32::from_le_bytes(bytes.as_chunks().0[word])))
}
