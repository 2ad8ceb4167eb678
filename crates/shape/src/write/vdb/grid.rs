//! Header, metadata and transform of written OpenVDB files.
//!
//! Source: OpenVDB 10, `io/Archive.cc`, `math/Maps.h`.

use crate::volume::vdb::header::{MAGIC, WRITTEN};
use crate::volume::vdb::values::{ACTIVE_ONLY, ZIP};
use glam::{DMat3, DVec3};
use std::io::{self, Write};

/// Buffer of a part of a file.
#[derive(Default)]
pub(super) struct Bytes(pub Vec<u8>);

impl Bytes {
    fn u32(&mut self, number: u32) {
        self.0.extend(number.to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        self.u32(text.len() as u32);
        self.0.extend(text.as_bytes());
    }

    fn doubles(&mut self, numbers: &[f64]) {
        self.0.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    }
}

/// A grid with its tree.
pub(super) struct Grid<'a> {
    pub name: &'a str,
    /// Type of the tree.
    pub kind: String,
    /// Key, type and bytes of each entry.
    pub metadata: Vec<(&'a str, &'a str, Vec<u8>)>,
    pub origin: DVec3,
    pub steps: DMat3,
    pub topology: Vec<u8>,
    pub leaves: Vec<&'a [u8]>,
}

/// Writes a file of grids.
pub(super) fn write_file(grids: &[Grid<'_>], to: &mut dyn Write) -> io::Result<()> {
    let mut file = Bytes(MAGIC.to_vec());
    [WRITTEN, 10, 0].into_iter().for_each(|number| file.u32(number)); // with the version of the library
    file.0.push(1); // with offsets
    file.0.extend(b"00000000-0000-0000-0000-000000000000");
    file.u32(0);
    file.u32(grids.len() as u32);
    let mut offset = 0;
    for grid in grids {
        let Grid { name, kind, topology, leaves, .. } = grid;
        [*name, kind, ""].into_iter().for_each(|text| file.text(text));
        let about = about(grid);
        let start = offset + file.0.len() as u64 + 24;
        let blocks = start + (about.0.len() + topology.len()) as u64;
        let end = blocks + leaves.iter().map(|leaf| leaf.len() as u64).sum::<u64>();
        for offset in [start, blocks, end] {
            file.0.extend(offset.to_le_bytes());
        }
        [&file.0, &about.0, topology].iter().try_for_each(|part| to.write_all(part))?;
        leaves.iter().try_for_each(|leaf| to.write_all(leaf))?;
        (offset, file.0) = (end, Vec::new());
    }
    Ok(())
}

/// Compression, metadata and transform.
fn about(grid: &Grid<'_>) -> Bytes {
    let mut bytes = Bytes::default();
    bytes.u32(ZIP | ACTIVE_ONLY);
    bytes.u32(grid.metadata.len() as u32);
    for (key, kind, value) in &grid.metadata {
        bytes.text(key);
        bytes.text(kind);
        bytes.u32(value.len() as u32);
        bytes.0.extend(value);
    }
    let (origin, steps) = (grid.origin.to_array(), grid.steps);
    let scale = [steps.x_axis.x, steps.y_axis.y, steps.z_axis.z];
    if steps == DMat3::from_diagonal(scale.into()) && scale.iter().all(|scale| *scale > 0.0) {
        let is_uniform = scale == [scale[0]; 3];
        bytes.text(if is_uniform { "UniformScaleTranslateMap" } else { "ScaleTranslateMap" });
        // Stored by OpenVDB for its operators: the inverse, its square, and its half.
        let inverse = scale.map(|scale| 1.0 / scale);
        let (squares, halves) = (inverse.map(|inverse| inverse * inverse), inverse.map(|inverse| 0.5 * inverse));
        bytes.doubles([origin, scale, scale, inverse, squares, halves].as_flattened());
    } else {
        bytes.text("AffineMap");
        for axis in [steps.x_axis, steps.y_axis, steps.z_axis] {
            bytes.doubles(&axis.extend(0.0).to_array());
        }
        bytes.doubles(&[origin[0], origin[1], origin[2], 1.0]);
    }
    bytes
}
