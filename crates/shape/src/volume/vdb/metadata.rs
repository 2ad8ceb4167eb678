//! Descriptor, metadata and transform of an OpenVDB grid.
//!
//! Invariant: a nonlinear transform is refused; unknown metadata is skipped by its length. Source: OpenVDB 10,
//! `io/GridDescriptor.cc`, `MetaMap.cc`, `math/Maps.h`.

use crate::error::{Location, ShapeError, quoted};
use crate::source::Source;
use glam::{DMat3, DVec3, IVec3};

/// Longest name, in bytes.
const MAX_NAME: u32 = 4096;
/// Metadata keys of files of this program: first and last voxel, and meaning of the values.
pub(crate) const CORNERS: [&str; 2] = ["hypertexture_min", "hypertexture_max"];
pub(crate) const CONTENT: &str = "hypertexture_content";
pub(crate) const SIGNED_DISTANCE: &str = "signed distance";
/// Suffix of the type of a grid stored in 16 bits.
const HALF: &str = "_HalfFloat";

/// Description of a grid before its content.
#[derive(Clone)]
pub(super) struct Descriptor {
    /// Name, with a number in brackets if several grids share it.
    pub name: String,
    /// Length of the name without the number.
    pub base: usize,
    /// Type of the tree.
    pub kind: String,
    /// Whether values are stored in 16 bits.
    pub is_half: bool,
    /// Name with its number as the file has it, and that of the grid whose tree it shares; empty if it has its own.
    pub unique: String,
    pub parent: String,
    /// Offsets of the leaves and of the next grid, and the place of the latter in the file.
    pub blocks: u64,
    pub end: u64,
    pub place: Location,
}

#[derive(Clone, Default)]
pub(super) struct Metadata {
    pub class: String,
    /// Whether values are stored in 16 bits.
    pub is_half: bool,
    /// Whether values are signed distances everywhere.
    pub is_distance: bool,
    /// First and last voxel, in files of this program.
    pub corners: [Option<IVec3>; 2],
}

/// Reads a length and a string.
fn name(source: &mut Source, what: &str) -> Result<String, ShapeError> {
    let place = Location::Byte(source.offset);
    let length = source.u32(what)?;
    if length > MAX_NAME {
        return Err(source.malformed_at(place, "a name of at most 4096 bytes", format!("{length} bytes")));
    }
    Ok(String::from_utf8_lossy(&source.block(u64::from(length), what)?).into_owned())
}

impl Descriptor {
    pub fn read(source: &mut Source) -> Result<Descriptor, ShapeError> {
        let (unique, mut kind) = (name(source, "the name of a grid")?, name(source, "the type of a grid")?);
        let is_half = kind.ends_with(HALF);
        kind.truncate(kind.len() - if is_half { HALF.len() } else { 0 });
        let parent = name(source, "the parent of a grid")?;
        let place = Location::Byte(source.offset);
        let mut offset = || source.array("the offsets of a grid").map(u64::from_le_bytes);
        let [_, blocks, end] = [offset()?, offset()?, offset()?];
        // A separator and a number follow a name that several grids share.
        let (name, base) = match unique.split_once('\u{1e}') {
            Some((base, number)) => (format!("{base}[{number}]"), base.len()),
            None => (unique.clone(), unique.len()),
        };
        Ok(Descriptor { name, base, kind, is_half, unique, parent, blocks, end, place })
    }
}

impl Metadata {
    pub fn read(source: &mut Source) -> Result<Metadata, ShapeError> {
        const WHAT: &str = "metadata";
        let mut metadata = Metadata::default();
        let entries = source.u32(WHAT)?;
        for _ in 0..entries {
            let (key, kind) = (name(source, WHAT)?, name(source, WHAT)?);
            match (&*key, &*kind) {
                ("class", "string") => metadata.class = name(source, WHAT)?,
                ("is_saved_as_half_float", "bool") => {
                    metadata.is_half = source.array::<5>(WHAT)? != [1, 0, 0, 0, 0]; // length and value
                }
                (CONTENT, "string") => metadata.is_distance = name(source, WHAT)? == SIGNED_DISTANCE,
                (key, "vec3i") if CORNERS.contains(&key) => {
                    let mut part = || source.array(WHAT).map(i32::from_le_bytes);
                    let [_, x, y, z] = [part()?, part()?, part()?, part()?]; // after the length
                    metadata.corners[usize::from(key == CORNERS[1])] = Some(IVec3::new(x, y, z));
                }
                _ => {
                    let length = source.u32(WHAT)?;
                    source.skip(u64::from(length), WHAT)?;
                }
            }
        }
        Ok(metadata)
    }
}

/// World position of voxel (0, 0, 0), and the step along each axis.
pub(super) fn transform(source: &mut Source) -> Result<(DVec3, DMat3), ShapeError> {
    const WHAT: &str = "a transform";
    let place = Location::Byte(source.offset);
    let kind = name(source, WHAT)?;
    let mut vector = || {
        let mut part = || source.array(WHAT).map(f64::from_le_bytes);
        Ok(DVec3::new(part()?, part()?, part()?))
    };
    match &*kind {
        "TranslationMap" => Ok((vector()?, DMat3::IDENTITY)),
        "ScaleMap" | "UniformScaleMap" => {
            let scale = vector()?;
            source.skip(4 * 24, WHAT)?; // follows from the scale
            Ok((DVec3::ZERO, DMat3::from_diagonal(scale)))
        }
        "ScaleTranslateMap" | "UniformScaleTranslateMap" => {
            let (origin, scale) = (vector()?, vector()?);
            source.skip(4 * 24, WHAT)?;
            Ok((origin, DMat3::from_diagonal(scale)))
        }
        "AffineMap" | "UnitaryMap" => {
            // Four rows: the three axes and the origin.
            let mut rows = [[0.0; 4]; 4];
            for part in rows.as_flattened_mut() {
                *part = f64::from_le_bytes(source.array(WHAT)?);
            }
            if rows.map(|row| row[3]) != [0.0, 0.0, 0.0, 1.0] {
                let found = format!("{:?}", rows.map(|row| row[3]));
                return Err(source.malformed_at(place, "a transform with 0, 0, 0, 1 in its last column", found));
            }
            let [x, y, z, origin] = rows.map(|row| DVec3::new(row[0], row[1], row[2]));
            Ok((origin, DMat3::from_cols(x, y, z)))
        }
        _ => {
            let remedy = "resample the grid to a linear transform (scale, translation or affine)";
            Err(source.unsupported(place, "the transform", quoted(kind.as_bytes()), remedy))
        }
    }
}
