//! Tree of an OpenVDB grid: root, nodes of 32^3 and 16^3 children, leaves of 8^3 voxels.
//!
//! Role: reads the topology, then fills a dense box. Invariant: the tree in memory is smaller than 100 times its bytes in the
//! file. Source: K. Museth, "VDB: High-Resolution Sparse Volumes with Dynamic Topology", ACM Trans. Graph. 32(3), 2013, and
//! OpenVDB 10, `tree/RootNode.h`, `InternalNode.h`, `LeafNode.h`.

use super::values::{NODE_MASKS, ValueEncoding, count, is_on};
use crate::error::{Location, ShapeError, quoted};
use crate::source::Source;
use glam::{I64Vec3, IVec3};
use std::collections::HashSet;

/// Side of a child of the root, in voxels.
const ROOT_CHILD: i32 = 4096;
/// Farthest origin of a child of the root. Higher: sums of coordinates overflow 32 bits.
const FARTHEST: i32 = 1 << 30;
/// Voxels of a leaf, and its side.
const LEAF_VOXELS: usize = 512;
const LEAF: i32 = 8;
/// Nouns for messages.
const TREE: &str = "nodes of a tree";
const LEAVES: &str = "a leaf of a tree";

/// A tree without the values of its leaves.
#[derive(Default)]
pub(super) struct Tree {
    /// Origin and active mask of each leaf, in the order of the file.
    leaves: Vec<(IVec3, [u8; LEAF_VOXELS / 8])>,
    /// Constant boxes with another value than the background.
    tiles: Vec<Tile>,
    /// First and last active voxel of the bounding box.
    pub active: Option<[IVec3; 2]>,
}

/// A constant box.
struct Tile {
    min: IVec3,
    max: IVec3,
    value: f32,
}

/// Dense box of the grid, x fastest.
pub(super) struct Dense<'a> {
    pub min: I64Vec3,
    pub size: [u32; 3],
    pub values: &'a mut [f32],
}

impl Tree {
    /// Reads the topology, and the background into `encoding`.
    pub fn read(source: &mut Source, encoding: &mut ValueEncoding) -> Result<Tree, ShapeError> {
        let place = Location::Byte(source.offset);
        let buffers = source.u32(TREE)?;
        if buffers != 1 {
            return Err(source.malformed_at(place, "a tree with 1 buffer", buffers.to_string()));
        }
        encoding.background = encoding.value(source)?;
        let [tiles, children] = [source.u32(TREE)?, source.u32(TREE)?];
        let (mut tree, mut seen) = (Tree::default(), HashSet::new());
        for _ in 0..tiles {
            let min = root_key(source, &mut seen)?;
            let value = encoding.value(source)?;
            let is_active = source.array::<1>(TREE)?[0] != 0;
            tree.add(Tile { min, max: min + (ROOT_CHILD - 1), value }, is_active, encoding);
        }
        for _ in 0..children {
            let min = root_key(source, &mut seen)?;
            tree.node(source, encoding, min, 5)?;
        }
        Ok(tree)
    }

    /// Reads a node of 2^`log` children along each axis and its descendants.
    fn node(&mut self, source: &mut Source, encoding: &ValueEncoding, min: IVec3, log: u32) -> Result<(), ShapeError> {
        let (places, child) = (1 << (3 * log), if log == 5 { ROOT_CHILD >> log } else { LEAF });
        let children = source.block(places as u64 / 8, TREE)?;
        let active = source.block(places as u64 / 8, TREE)?;
        let is_packed = encoding.version < NODE_MASKS; // values of children are left out
        let values = encoding.values(source, &active, if is_packed { places - count(&children) } else { places })?;
        let corner = |place: usize| {
            let part = |shift: u32| (place >> shift & ((1 << log) - 1)) as i32;
            min + child * IVec3::new(part(2 * log), part(log), part(0))
        };
        let mut next = 0;
        let mut run: Option<(Tile, bool)> = None; // adjacent equal tiles along z are merged
        for place in 0..places {
            if is_on(&children, place) {
                continue;
            }
            let value = values[if is_packed { next } else { place }];
            next += 1;
            let (min, is_active) = (corner(place), is_on(&active, place));
            match &mut run {
                Some((tile, was_active))
                    if *was_active == is_active
                        && tile.value.to_bits() == value.to_bits()
                        && min == tile.min.with_z(tile.max.z + 1) =>
                {
                    tile.max.z += child;
                }
                _ => {
                    let ended = run.replace((Tile { min, max: min + (child - 1), value }, is_active));
                    ended.into_iter().for_each(|(tile, was_active)| self.add(tile, was_active, encoding));
                }
            }
        }
        run.into_iter().for_each(|(tile, was_active)| self.add(tile, was_active, encoding));
        for place in (0..places).filter(|place| is_on(&children, *place)) {
            match log {
                5 => self.node(source, encoding, corner(place), 4)?,
                _ => self.leaf(source, corner(place))?,
            }
        }
        Ok(())
    }

    fn leaf(&mut self, source: &mut Source, min: IVec3) -> Result<(), ShapeError> {
        let mask: [u8; LEAF_VOXELS / 8] = source.array(LEAVES)?;
        for (row, bits) in mask.iter().enumerate().filter(|(_, bits)| **bits != 0) {
            let at = |z: u32| min + IVec3::new(row as i32 / 8, row as i32 % 8, z as i32);
            self.include(at(bits.trailing_zeros()), at(7 - bits.leading_zeros()));
        }
        self.leaves.push((min, mask));
        Ok(())
    }

    fn add(&mut self, tile: Tile, is_active: bool, encoding: &ValueEncoding) {
        if is_active {
            self.include(tile.min, tile.max);
        }
        if tile.value != encoding.background {
            self.tiles.push(tile);
        }
    }

    /// Extends the active box.
    fn include(&mut self, min: IVec3, max: IVec3) {
        let [low, high] = self.active.unwrap_or([min, max]);
        self.active = Some([low.min(min), high.max(max)]);
    }

    /// Reads the values of the leaves and writes them and the tiles into `dense`, which is filled with the background.
    pub fn fill(&self, source: &mut Source, encoding: &ValueEncoding, mut dense: Dense) -> Result<(), ShapeError> {
        for tile in &self.tiles {
            dense.rows(tile.min, tile.max, |row, _| row.fill(tile.value));
        }
        for (min, mask) in &self.leaves {
            let place = Location::Byte(source.offset);
            if source.array(LEAVES)? != *mask {
                let found = "another one".into();
                return Err(source.malformed_at(place, "the same mask of a leaf as in the tree", found));
            }
            let buffers = if encoding.version < NODE_MASKS { source.array::<13>(LEAVES)?[12] } else { 1 };
            let values = encoding.values(source, mask, LEAF_VOXELS)?;
            for _ in 1..buffers {
                encoding.skip(source, LEAF_VOXELS)?;
            }
            dense.rows(*min, min + (LEAF - 1), |row, first| {
                // In a leaf x is the slowest axis.
                let [x, y, z] = (first - min.as_i64vec3()).to_array().map(|part| part as usize);
                let of_row = values[64 * x + 8 * y + z..].iter().step_by(64);
                row.iter_mut().zip(of_row).for_each(|(voxel, value)| *voxel = *value);
            });
        }
        Ok(())
    }
}

/// Origin of a child or tile of the root; each may occur once.
fn root_key(source: &mut Source, seen: &mut HashSet<IVec3>) -> Result<IVec3, ShapeError> {
    let place = Location::Byte(source.offset);
    let mut part = || source.array(TREE).map(i32::from_le_bytes);
    let key = IVec3::new(part()?, part()?, part()?);
    let is_near = (key.cmpge(IVec3::splat(-FARTHEST)) & key.cmple(IVec3::splat(FARTHEST))).all();
    if is_near && key % ROOT_CHILD == IVec3::ZERO && seen.insert(key) {
        return Ok(key);
    }
    let found = quoted(key.to_string().as_bytes());
    Err(source.malformed_at(place, "multiples of 4096 up to 2^30, each once, as origins of the root's children", found))
}

impl Dense<'_> {
    /// Calls `with` for each row of voxels in the box from `min` to `max`, with the first voxel of the row.
    fn rows(&mut self, min: IVec3, max: IVec3, mut with: impl FnMut(&mut [f32], I64Vec3)) {
        let size = I64Vec3::from(self.size.map(i64::from));
        let from = (min.as_i64vec3() - self.min).max(I64Vec3::ZERO);
        let to = (max.as_i64vec3() - self.min).min(size - 1);
        if from.x > to.x {
            return;
        }
        for z in from.z..=to.z {
            for y in from.y..=to.y {
                let start = ((z * size.y + y) * size.x + from.x) as usize;
                let row = &mut self.values[start..=start + (to.x - from.x) as usize];
                with(row, self.min + I64Vec3::new(from.x, y, z));
            }
        }
    }
}
