//! Writer of OpenVDB: a dense volume as one grid of floats of version 224, in zip.
//!
//! Invariant: voxels that differ from the background are active, and the box of the volume is in the metadata, so that the
//! volume is read back bit for bit.

mod fog;
mod grid;
mod tree;

pub use fog::{Fog, FogGrid, FogLeaf};

use super::values::LEVEL;
use crate::shape::{Content, Volume};
use crate::volume::vdb::metadata::{CONTENT, CORNERS, SIGNED_DISTANCE};
use flate2::Compress;
use grid::{Grid, write_file};
use rayon::prelude::*;
use std::io::{self, Write};
use tree::{LEAF, Place, leaf, order, place_in_leaf, topology};

/// Writes a volume whose number of values has been checked. Takes memory for the compressed values.
pub(crate) fn write(volume: &Volume, to: &mut dyn Write) -> io::Result<()> {
    let background = background(volume);
    let mut corners: Vec<_> = boxes(volume.size).collect();
    corners.sort_unstable_by_key(|corner| order(*corner));
    let leaves: Vec<(Place, Vec<u8>)> = corners
        .into_par_iter()
        .map_init(|| Compress::new(LEVEL, true), |packer, corner| encoded(volume, background, corner, packer))
        .filter_map(Result::transpose)
        .collect::<io::Result<_>>()?;
    let places: Vec<Place> = leaves.iter().map(|(place, _)| *place).collect();
    let (class, name) = match volume.content {
        Content::Scalar => ("fog volume", "density"),
        _ => ("level set", "surface"),
    };
    let text = |key, text: &str| (key, "string", text.as_bytes().to_vec());
    let mut metadata = vec![text("class", class)];
    if volume.content == Content::SignedDistance {
        metadata.push(text(CONTENT, SIGNED_DISTANCE));
    }
    for (key, corner) in CORNERS.iter().zip([[0; 3], volume.size.map(|n| n.saturating_sub(1))]) {
        metadata.push((key, "vec3i", corner.map(u32::to_le_bytes).concat()));
    }
    metadata.extend([("is_saved_as_half_float", "bool", vec![0]), text("name", name)]);
    let grid = Grid {
        name,
        kind: "Tree_float_5_4_3".into(),
        metadata,
        origin: volume.origin.as_dvec3(),
        steps: volume.steps.as_dmat3(),
        topology: topology(&background.to_le_bytes(), &places, false),
        leaves: leaves.iter().map(|(_, bytes)| &bytes[..]).collect(),
    };
    write_file(&[grid], to)
}

/// Background: the largest distance, at least a voxel; for scalars the first value.
fn background(volume: &Volume) -> f32 {
    match volume.content {
        Content::Scalar => volume.values.first().copied().unwrap_or_default(),
        _ => volume.values.iter().copied().fold(volume.spacing().max_element(), f32::max),
    }
}

/// First voxels of the leaves of a volume.
fn boxes(size: [u32; 3]) -> impl Iterator<Item = [u32; 3]> {
    let [x, y, z] = size.map(|side| (0..side).step_by(LEAF as usize));
    x.flat_map(move |x| {
        let z = z.clone();
        y.clone().flat_map(move |y| z.clone().map(move |z| [x, y, z]))
    })
}

/// A leaf; `None` if all voxels are background.
fn encoded(
    volume: &Volume,
    background: f32,
    corner: [u32; 3],
    packer: &mut Compress,
) -> io::Result<Option<(Place, Vec<u8>)>> {
    let [nx, ny, nz] = volume.size;
    let (mut mask, mut values) = ([0; 64], Vec::with_capacity(2048));
    let ends = [nx, ny, nz].iter().zip(corner).map(|(side, from)| LEAF.min(side - from)).collect::<Vec<_>>();
    for x in 0..ends[0] {
        for y in 0..ends[1] {
            for z in 0..ends[2] {
                let [i, j, k] = [x + corner[0], y + corner[1], z + corner[2]].map(|part| part as usize);
                let value = volume.values[(k * ny as usize + j) * nx as usize + i];
                if value.to_bits() != background.to_bits() {
                    let place = place_in_leaf([x, y, z]);
                    mask[place / 8] |= 1 << (place % 8);
                    values.extend(value.to_le_bytes());
                }
            }
        }
    }
    let packed = (!values.is_empty()).then(|| Ok(((corner, mask), leaf(&mask, &values, packer)?)));
    packed.transpose()
}
