//! Writer of sparse fog volumes: several grids of OpenVDB with one tree, given leaf by leaf.

use super::grid::{Grid, write_file};
use super::tree::{LEAF, Place, leaf, order, place_in_leaf, topology};
use crate::write::values::LEVEL;
use flate2::Compress;
use glam::{DMat3, DVec3};
use half::f16;
use std::io::{self, Write};

/// A grid of a [`Fog`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FogGrid {
    /// Name.
    pub name: &'static str,
    /// Values of a voxel: 1, or 3 of a vector.
    pub channels: usize,
}

/// Fog volume of cubic voxels: background 0, active voxels in leaves of 8^3.
#[derive(Clone, Debug, Default)]
pub struct Fog {
    /// World position of voxel (0, 0, 0).
    pub origin: DVec3,
    /// Side of a voxel, world units.
    pub step: f64,
    /// Whether values are stored in 16 bits.
    pub is_half: bool,
    /// Grids in the order of the values of a leaf.
    pub grids: Vec<FogGrid>,
    /// Leaves, in any order.
    pub leaves: Vec<FogLeaf>,
}

/// Compressed leaf of a [`Fog`].
#[derive(Clone, Debug)]
pub struct FogLeaf {
    place: Place,
    /// Bytes for each grid.
    blocks: Vec<Vec<u8>>,
}

impl FogLeaf {
    /// Voxels along a side.
    pub const SIDE: u32 = LEAF;

    /// Number of the voxel at a place in a leaf.
    pub fn index(at: [u32; 3]) -> usize {
        place_in_leaf(at)
    }

    /// Place in a leaf of the voxel of a number.
    pub fn at(index: usize) -> [u32; 3] {
        [6, 3, 0].map(|shift| index as u32 >> shift & 7)
    }

    /// Compresses the leaf whose first voxel is `corner`, a multiple of 8. `active` has 512 voxels in the order of
    /// [`FogLeaf::index`], `values` the values of the active ones for each grid.
    ///
    /// # Errors
    /// Errors of the compression.
    pub fn new(corner: [u32; 3], active: &[bool], values: &[Vec<f32>], is_half: bool) -> io::Result<FogLeaf> {
        let mut mask = [0; 64];
        for (place, _) in active.iter().enumerate().filter(|(_, is_active)| **is_active) {
            mask[place / 8] |= 1 << (place % 8);
        }
        let mut packer = Compress::new(LEVEL, true);
        let mut block = |values: &Vec<f32>| {
            let bytes: Vec<u8> = if is_half {
                values.iter().flat_map(|value| f16::from_f32(*value).to_le_bytes()).collect()
            } else {
                values.iter().flat_map(|value| value.to_le_bytes()).collect()
            };
            leaf(&mask, &bytes, &mut packer)
        };
        Ok(FogLeaf { blocks: values.iter().map(&mut block).collect::<io::Result<_>>()?, place: (corner, mask) })
    }
}

impl Fog {
    /// Writes an OpenVDB file with the grids that `keep` takes.
    ///
    /// # Errors
    /// Errors of `to`.
    pub fn write(&mut self, keep: impl Fn(&FogGrid) -> bool, to: &mut dyn Write) -> io::Result<()> {
        self.leaves.sort_unstable_by_key(|leaf| order(leaf.place.0));
        let places: Vec<Place> = self.leaves.iter().map(|leaf| leaf.place).collect();
        let metadata = self.metadata();
        let grids = self.grids.iter().enumerate().filter(|(_, grid)| keep(grid)).map(|(number, grid)| {
            let FogGrid { name, channels } = *grid;
            let kind = if channels == 1 { "float" } else { "vec3s" };
            let mut metadata = metadata.clone();
            metadata.push(("name", "string", name.into()));
            if channels == 3 {
                let moves = if name == "vel" { "contravariant relative" } else { "invariant" };
                metadata.push(("vector_type", "string", moves.into()));
            }
            Grid {
                name,
                kind: format!("Tree_{kind}_5_4_3{}", if self.is_half { "_HalfFloat" } else { "" }),
                metadata,
                origin: self.origin,
                steps: DMat3::from_diagonal(DVec3::splat(self.step)),
                topology: topology(&vec![0; 4 * channels], &places, self.is_half),
                leaves: self.leaves.iter().map(|leaf| &leaf.blocks[number][..]).collect(),
            }
        });
        write_file(&grids.collect::<Vec<_>>(), to)
    }

    /// Metadata of every grid, as OpenVDB writes it.
    fn metadata(&self) -> Vec<(&'static str, &'static str, Vec<u8>)> {
        let voxels = self.leaves.iter().flat_map(|FogLeaf { place: (corner, mask), .. }| {
            let is_on = |place: &usize| mask[place / 8] & 1 << (place % 8) != 0;
            (0..512).filter(is_on).map(|place| {
                let within = FogLeaf::at(place);
                [0, 1, 2].map(|axis| corner[axis] + within[axis])
            })
        });
        let (mut low, mut high, mut count) = ([u32::MAX; 3], [0; 3], 0_i64);
        for voxel in voxels {
            (low, high) =
                ([0, 1, 2].map(|axis| low[axis].min(voxel[axis])), [0, 1, 2].map(|axis| high[axis].max(voxel[axis])));
            count += 1;
        }
        let corner = |corner: [u32; 3]| corner.map(u32::to_le_bytes).concat();
        vec![
            ("class", "string", "fog volume".into()),
            ("creator", "string", "hypertexture".into()),
            ("file_bbox_min", "vec3i", corner(low)),
            ("file_bbox_max", "vec3i", corner(high)),
            ("file_voxel_count", "int64", count.to_le_bytes().to_vec()),
            ("is_saved_as_half_float", "bool", vec![u8::from(self.is_half)]),
        ]
    }
}
