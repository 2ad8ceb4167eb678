//! Tree of a written OpenVDB grid: leaves of 8^3 voxels in two levels of nodes below the root.
//!
//! Invariant: inactive voxels are background, and no node is empty. Source: OpenVDB 10, `tree/InternalNode.h`,
//! `tree/LeafNode.h`.

use flate2::{Compress, FlushCompress};
use std::io;

/// Voxels along a side of a leaf.
pub(super) const LEAF: u32 = 8;
/// Side of a node below the root, children along a side as a power of two, and side of a child, in voxels.
const LEVELS: [(u32, u32, u32); 2] = [(4096, 5, 128), (128, 4, LEAF)];

/// First voxel of a leaf, and mask of its active voxels.
pub(super) type Place = ([u32; 3], [u8; 64]);

/// Number of a voxel in its leaf: z fastest.
pub(super) fn place_in_leaf([x, y, z]: [u32; 3]) -> usize {
    (x << 6 | y << 3 | z) as usize
}

/// Sorting key of the leaf at `corner`: nodes in the order of their numbers.
pub(super) fn order(corner: [u32; 3]) -> [[u32; 3]; 3] {
    [LEVELS[0].0, LEVELS[1].0, LEAF].map(|side| corner.map(|part| part / side))
}

/// Everything of a tree before the values of its leaves, which are in [`order`]. `background`: bytes of a value.
/// `is_half`: whether values are stored in 16 bits.
pub(super) fn topology(background: &[u8], leaves: &[Place], is_half: bool) -> Vec<u8> {
    let of_node = |level: usize| move |a: &Place, b: &Place| order(a.0)[level] == order(b.0)[level];
    let mut bytes = 1_u32.to_le_bytes().to_vec();
    bytes.extend(background);
    let uppers = leaves.chunk_by(of_node(0));
    bytes.extend([0, uppers.clone().count() as u32].map(u32::to_le_bytes).as_flattened()); // tiles and children
    for upper in uppers {
        let (side, ..) = LEVELS[0];
        bytes.extend(upper[0].0.map(|part| (part / side * side).to_le_bytes()).as_flattened());
        node(upper, 0, is_half, &mut bytes);
        for lower in upper.chunk_by(of_node(1)) {
            node(lower, 1, is_half, &mut bytes);
            lower.iter().for_each(|(_, mask)| bytes.extend(mask));
        }
    }
    bytes
}

/// Appends the masks of the node that holds these leaves. Places without a child are inactive background, whose values are not
/// stored.
fn node(leaves: &[Place], level: usize, is_half: bool, to: &mut Vec<u8>) {
    let (side, log, step) = LEVELS[level];
    let mut mask = vec![0; 1 << (3 * log - 3)];
    for (corner, _) in leaves {
        let [x, y, z] = corner.map(|part| (part % side / step) as usize);
        let place = x << (2 * log) | y << log | z;
        mask[place / 8] |= 1 << (place % 8);
    }
    to.extend(&mask);
    // Active tiles, code and length of values; OpenVDB stores no length of no halves.
    to.resize(to.len() + mask.len() + 1 + if is_half { 0 } else { 8 }, 0);
}

/// Encodes the active values of a leaf after its mask: zip after its length, or plain after its negative length if zip is not
/// shorter.
pub(super) fn leaf(mask: &[u8; 64], values: &[u8], packer: &mut Compress) -> io::Result<Vec<u8>> {
    let start = mask.len() + 1;
    let mut bytes = Vec::with_capacity(start + 8 + values.len() + 64);
    bytes.extend(mask);
    bytes.resize(start + 8, 0); // code: inactive voxels are background
    packer.reset();
    packer.compress_vec(values, &mut bytes, FlushCompress::Finish).map_err(io::Error::from)?;
    let mut length = (bytes.len() - start - 8) as i64;
    if length >= values.len() as i64 {
        bytes.truncate(start + 8);
        bytes.extend(values);
        length = -(values.len() as i64);
    }
    bytes[start..start + 8].copy_from_slice(&length.to_le_bytes());
    Ok(bytes)
}
