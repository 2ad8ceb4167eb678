//! Writer of OpenVDB: a dense volume as one grid of floats of version 224, in zip.
//!
//! Invariant: voxels that differ from the background are active, and the box of the volume is in the metadata, so that the
//! volume is read back bit for bit. Source: OpenVDB 10, `io/Archive.cc`, `tree/InternalNode.h` and `tree/LeafNode.h`.

use super::header::{MAGIC, WRITTEN};
use super::metadata::{CONTENT, CORNERS, SIGNED_DISTANCE};
use super::values::{ACTIVE_ONLY, ZIP};
use crate::write_values::LEVEL;
use crate::{Content, Volume};
use flate2::{Compress, FlushCompress};
use rayon::prelude::*;
use std::io::{self, Write};

/// Children along a side as a power of two, and side of a child in voxels: children of the root, nodes below them, leaves.
const LEVELS: [(u32, u32); 3] = [(5, 128), (4, 8), (3, 1)];
/// Side of a child of the root, in voxels.
const ROOT_CHILD: u32 = 4096;

/// Buffer of a part of a file.
#[derive(Default)]
struct Bytes(Vec<u8>);

impl Bytes {
    fn u32(&mut self, number: u32) {
        self.0.extend(number.to_le_bytes());
    }

    fn text(&mut self, text: &str) {
        self.u32(text.len() as u32);
        self.0.extend(text.as_bytes());
    }

    fn entry(&mut self, key: &str, kind: &str, value: &[u8]) {
        self.text(key);
        self.text(kind);
        self.u32(value.len() as u32);
        self.0.extend(value);
    }

    fn doubles(&mut self, numbers: &[f64]) {
        self.0.extend(numbers.iter().flat_map(|number| number.to_le_bytes()));
    }
}

/// Writes a volume whose number of values has been checked. Takes memory for twice the compressed values.
pub(crate) fn write(volume: &Volume, to: &mut dyn Write) -> io::Result<()> {
    let tree = Tree { volume, background: background(volume) }.root()?;
    let mut file = Bytes(MAGIC.to_vec());
    [WRITTEN, 10, 0].into_iter().for_each(|number| file.u32(number)); // with the version of the library
    file.0.push(1); // with offsets
    file.0.extend(b"00000000-0000-0000-0000-000000000000");
    file.u32(0);
    file.u32(1);
    let is_scalar = volume.content == Content::Scalar;
    let name = if is_scalar { "density" } else { "surface" };
    [name, "Tree_float_5_4_3", ""].into_iter().for_each(|text| file.text(text));
    let grid = about(volume, name);
    let start = (file.0.len() + 24) as u64;
    let blocks = start + (grid.0.len() + tree.topology.len()) as u64;
    for offset in [start, blocks, blocks + tree.leaves.len() as u64] {
        file.0.extend(offset.to_le_bytes());
    }
    [&file.0, &grid.0, &tree.topology, &tree.leaves].iter().try_for_each(|part| to.write_all(part))
}

/// Background: the largest distance, at least a voxel; for scalars the first value.
fn background(volume: &Volume) -> f32 {
    match volume.content {
        Content::Scalar => volume.values.first().copied().unwrap_or_default(),
        _ => volume.values.iter().copied().fold(volume.spacing().max_element(), f32::max),
    }
}

/// Compression, metadata and transform.
fn about(volume: &Volume, name: &str) -> Bytes {
    let mut grid = Bytes::default();
    grid.u32(ZIP | ACTIVE_ONLY);
    let is_distance = volume.content == Content::SignedDistance;
    grid.u32(5 + u32::from(is_distance));
    let class = if volume.content == Content::Scalar { "fog volume" } else { "level set" };
    grid.entry("class", "string", class.as_bytes());
    if is_distance {
        grid.entry(CONTENT, "string", SIGNED_DISTANCE.as_bytes());
    }
    let corners = [[0; 3], volume.size.map(|n| n.saturating_sub(1))];
    for (key, corner) in CORNERS.iter().zip(corners) {
        grid.entry(key, "vec3i", &corner.map(u32::to_le_bytes).concat());
    }
    grid.entry("is_saved_as_half_float", "bool", &[0]);
    grid.entry("name", "string", name.as_bytes());
    let (origin, steps) = (volume.origin.as_dvec3().to_array(), volume.steps.as_dmat3());
    if volume.is_aligned() {
        let scale = [steps.x_axis.x, steps.y_axis.y, steps.z_axis.z];
        let is_uniform = scale == [scale[0]; 3];
        grid.text(if is_uniform { "UniformScaleTranslateMap" } else { "ScaleTranslateMap" });
        // Stored by OpenVDB for its operators: the inverse, its square, and its half.
        let inverse = scale.map(|scale| 1.0 / scale);
        let (squares, halves) = (inverse.map(|inverse| inverse * inverse), inverse.map(|inverse| 0.5 * inverse));
        grid.doubles([origin, scale, scale, inverse, squares, halves].as_flattened());
    } else {
        grid.text("AffineMap");
        for axis in [steps.x_axis, steps.y_axis, steps.z_axis] {
            grid.doubles(&axis.extend(0.0).to_array());
        }
        grid.doubles(&[origin[0], origin[1], origin[2], 1.0]);
    }
    grid
}

/// Tree of a volume whose first voxel is the origin.
struct Tree<'a> {
    volume: &'a Volume,
    background: f32,
}

/// Encoded node with its descendants.
struct Node {
    /// Everything but the values of leaves.
    topology: Vec<u8>,
    /// Masks and values of leaves.
    leaves: Vec<u8>,
}

impl Tree<'_> {
    fn root(&self) -> io::Result<Node> {
        let (mut children, mut below, mut leaves) = (0, Vec::new(), Vec::new());
        for min in self.corners([0; 3], u32::MAX, ROOT_CHILD) {
            if let Some(node) = self.upper(min)? {
                children += 1;
                below.extend(min.iter().flat_map(|part| part.to_le_bytes()));
                below.extend(node.topology);
                leaves.extend(node.leaves);
            }
        }
        let mut root = Bytes::default();
        root.u32(1);
        root.0.extend(self.background.to_le_bytes());
        root.u32(0);
        root.u32(children);
        root.0.extend(below);
        Ok(Node { topology: root.0, leaves })
    }

    /// Origins of the boxes of side `step` that overlap the volume and the box of side `side` at `min`; x is the slowest axis.
    fn corners(&self, min: [u32; 3], side: u32, step: u32) -> impl Iterator<Item = [u32; 3]> + use<> {
        let along = |axis: usize| {
            (min[axis]..self.volume.size[axis].min(min[axis].saturating_add(side))).step_by(step as usize)
        };
        let [x, y, z] = [along(0), along(1), along(2)];
        x.flat_map(move |x| {
            let z = z.clone();
            y.clone().flat_map(move |y| z.clone().map(move |z| [x, y, z]))
        })
    }

    /// A child of the root; its children are encoded in parallel.
    fn upper(&self, min: [u32; 3]) -> io::Result<Option<Node>> {
        let corners: Vec<_> = self.children(min, 0).collect();
        let nodes: Vec<_> = corners
            .into_par_iter()
            .map_init(|| Compress::new(LEVEL, true), |packer, corner| Ok((corner, self.lower(corner, packer)?)))
            .collect::<io::Result<_>>()?;
        Ok(joined(min, 0, nodes))
    }

    fn lower(&self, min: [u32; 3], packer: &mut Compress) -> io::Result<Option<Node>> {
        let leaves = self.children(min, 1).map(|corner| Ok((corner, self.leaf(corner, packer)?)));
        Ok(joined(min, 1, leaves.collect::<io::Result<_>>()?))
    }

    /// Origins of the children of a node.
    fn children(&self, min: [u32; 3], level: usize) -> impl Iterator<Item = [u32; 3]> + use<> {
        let (log, step) = LEVELS[level];
        self.corners(min, step << log, step)
    }

    /// A leaf; `None` if all voxels are background.
    fn leaf(&self, min: [u32; 3], packer: &mut Compress) -> io::Result<Option<Node>> {
        let [nx, ny, _] = self.volume.size.map(|n| n as usize);
        let (mut mask, mut values) = (vec![0; 64], Vec::with_capacity(2048));
        for corner in self.children(min, 2) {
            let [x, y, z] = corner.map(|part| part as usize);
            let value = self.volume.values[(z * ny + y) * nx + x];
            if value.to_bits() != self.background.to_bits() {
                let place = place(min, corner, LEVELS[2]);
                mask[place / 8] |= 1 << (place % 8);
                values.extend(value.to_le_bytes());
            }
        }
        if values.is_empty() {
            return Ok(None);
        }
        let mut leaves = mask.clone();
        leaves.push(0); // inactive voxels are background
        pack(&values, packer, &mut leaves)?;
        Ok(Some(Node { topology: mask, leaves }))
    }
}

/// The node of a level at `min` with these children; `None` if all are background.
fn joined(min: [u32; 3], level: usize, children: Vec<([u32; 3], Option<Node>)>) -> Option<Node> {
    let mut mask = vec![0; 1 << (3 * LEVELS[level].0 - 3)];
    let (mut below, mut leaves) = (Vec::new(), Vec::new());
    for (corner, child) in children.into_iter().filter_map(|(corner, child)| Some((corner, child?))) {
        let place = place(min, corner, LEVELS[level]);
        mask[place / 8] |= 1 << (place % 8);
        below.extend(child.topology);
        leaves.extend(child.leaves);
    }
    // Places without a child are inactive background, whose values are not stored.
    let active = vec![0; mask.len()];
    (!below.is_empty()).then(|| Node { topology: [&mask, &active, &[0; 1 + 8][..], &below].concat(), leaves })
}

/// Appends zip after its length, or plain values after their negative length if zip is not shorter.
fn pack(values: &[u8], packer: &mut Compress, to: &mut Vec<u8>) -> io::Result<()> {
    let start = to.len();
    to.extend([0; 8]);
    to.reserve(2 * values.len() + 64);
    packer.reset();
    packer.compress_vec(values, to, FlushCompress::Finish).map_err(io::Error::from)?;
    let mut length = (to.len() - start - 8) as i64;
    if length >= values.len() as i64 {
        to.truncate(start + 8);
        to.extend(values);
        length = -(values.len() as i64);
    }
    to[start..start + 8].copy_from_slice(&length.to_le_bytes());
    Ok(())
}

/// Index of a corner in the node at `min`.
fn place(min: [u32; 3], corner: [u32; 3], (log, step): (u32, u32)) -> usize {
    let [x, y, z] = std::array::from_fn(|axis| ((corner[axis] - min[axis]) / step) as usize);
    x << (2 * log) | y << log | z
}
