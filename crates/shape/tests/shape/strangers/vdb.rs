//! OpenVDB.

use super::noted_volume;
use glam::Vec3;
use half::f16;
use hypertexture_shape::{Opened, ShapeError, Volume, read_noted};
use std::fs;

/// A grid of a file.
#[derive(Clone, Copy)]
struct Grid {
    name: &'static str,
    kind: &'static str,
    /// Name of the grid whose tree it shares.
    parent: &'static str,
    /// Side of a voxel, and whether the two voxels at (0, 0, 0) and (0, 0, 1) are active.
    voxel: f64,
    is_full: bool,
    /// Bytes of a value of the root.
    single: usize,
}

const FULL: Grid = Grid { name: "heat", kind: "Tree_float_5_4_3", parent: "", voxel: 0.5, is_full: true, single: 4 };

fn text(text: &str) -> Vec<u8> {
    [&(text.len() as u32).to_le_bytes()[..], text.as_bytes()].concat()
}

/// Values of two voxels in one leaf.
const VALUES: [f32; 2] = [0.75, 0.5];

impl Grid {
    fn is_half(self) -> bool {
        self.kind.contains("half")
    }

    /// Topology and leaves of a tree, in masked values without compression.
    fn tree(self) -> [Vec<u8>; 2] {
        let number = |number: u32| number.to_le_bytes().to_vec();
        let root = [number(1), vec![0; self.single], number(0), number(u32::from(self.is_full))].concat();
        if !self.is_full {
            return [root, Vec::new()];
        }
        let first = |bytes: usize| (0..bytes).map(|at| u8::from(at == 0)).collect::<Vec<u8>>();
        // Child and value masks of 32^3 and 16^3 places, a code of no stored values; the mask of the leaf has two voxels.
        let node = |places: usize| [first(places / 8), vec![0; places / 8], vec![0]].concat();
        let mask = [vec![3], vec![0; 63]].concat();
        // A real tree of halfs writes no length for no values either way: without compression there is none.
        let topology = [root, vec![0; 12], node(1 << 15), node(1 << 12), mask.clone()].concat();
        let values: Vec<u8> = match self.is_half() {
            true => VALUES.iter().flat_map(|value| f16::from_f32(*value).to_le_bytes()).collect(),
            false => VALUES.iter().flat_map(|value| value.to_le_bytes()).collect(),
        };
        [topology, [mask, vec![0], values].concat()]
    }

    fn bytes(self, at: usize) -> Vec<u8> {
        let entry = |key: &str, kind: &str, value: &[u8]| {
            [text(key), text(kind), (value.len() as u32).to_le_bytes().to_vec(), value.to_vec()].concat()
        };
        let head = [text(self.name), text(self.kind), text(self.parent)].concat();
        let metadata = [
            2_u32.to_le_bytes().to_vec(), // only active values
            2_u32.to_le_bytes().to_vec(),
            entry("class", "string", b"fog volume"),
            entry("is_saved_as_half_float", "bool", &[u8::from(self.is_half() && self.single == 4)]),
        ]
        .concat();
        let scale = [self.voxel; 3].iter().flat_map(|part| part.to_le_bytes()).collect::<Vec<u8>>();
        let transform = [text("UniformScaleMap"), scale, vec![0; 4 * 24]].concat();
        let [topology, leaves] = if self.parent.is_empty() { self.tree() } else { [Vec::new(), Vec::new()] };
        let start = at + head.len() + 24;
        let blocks = start + metadata.len() + transform.len() + topology.len();
        let offsets = [start, blocks, blocks + leaves.len()].map(|offset| (offset as u64).to_le_bytes());
        [head, offsets.concat(), metadata, transform, topology, leaves].concat()
    }
}

fn file(version: u32, grids: &[Grid]) -> Vec<u8> {
    let mut bytes = [&b" BDV\0\0\0\0"[..], &version.to_le_bytes(), &[0; 8], &[1], &[b'x'; 36], &[0; 4]].concat();
    bytes.extend((grids.len() as u32).to_le_bytes());
    for grid in grids {
        let own = grid.bytes(bytes.len());
        bytes.extend(own);
    }
    bytes
}

fn read(grids: &[Grid]) -> Result<(Volume, String), ShapeError> {
    read_noted("a.vdb", &file(224, grids)).map(noted_volume)
}

/// Checks the two values, and the side of a voxel.
fn assert_values(volume: &Volume, voxel: f64) {
    let mut values: Vec<f32> = volume.values.iter().copied().filter(|value| *value != 0.0).collect();
    values.sort_by(|a, b| b.total_cmp(a));
    assert_eq!((values.as_slice(), volume.spacing()), (&VALUES[..], Vec3::splat(voxel as f32)));
}

#[test]
fn an_instance_has_the_tree_of_another_grid_and_its_own_place() {
    let density = Grid { name: "density", parent: "heat", voxel: 2.0, ..FULL };
    for grids in [[FULL, density], [density, FULL]] {
        let (found, notes) = read(&grids).unwrap();
        assert_values(&found, 2.0);
        assert!(notes.starts_with("its grid `density` is read, left out: `heat`"), "{notes}");
        let desk = super::folder(&[("a.vdb", &file(224, &grids))]);
        let path = desk.path().join("a.vdb");
        let path = path.to_str().unwrap();
        assert_values(&noted_volume(Opened::with_grid(path, Some("heat")).unwrap()).0, 0.5);
        assert_values(&noted_volume(Opened::with_grid(path, Some("density")).unwrap()).0, 2.0);
        fs::remove_file(path).unwrap();
    }
    let lost = Grid { parent: "smoke", ..density };
    let error = read(&[FULL, lost]).unwrap_err().to_string();
    assert!(error.contains("expected a grid whose tree another one shares, found `smoke`"), "{error}");
}

#[test]
fn trees_of_halfs_are_read_with_values_of_two_and_of_four_bytes() {
    for single in [2, 4] {
        let own = Grid { kind: "Tree_half_5_4_3", single, ..FULL };
        for (version, grids) in [(225, &[own][..]), (225, &[own, Grid { name: "b", ..own }]), (224, &[own])] {
            let (found, _) =
                noted_volume(read_noted("a.vdb", &file(version, grids)).unwrap_or_else(|error| panic!("{error}")));
            assert_values(&found, 0.5);
        }
    }
}

#[test]
fn an_empty_grid_gives_way_to_a_full_one() {
    let empty = Grid { name: "density", is_full: false, ..FULL };
    for grids in [[empty, FULL], [FULL, empty]] {
        let (found, notes) = read(&grids).unwrap();
        assert_values(&found, 0.5);
        assert!(notes.starts_with("empty, without active voxels: `density`; its grid `heat` is read"), "{notes}");
        let desk = super::folder(&[("a.vdb", &file(224, &grids))]);
        let path = desk.path().join("a.vdb");
        let error = Opened::with_grid(path.to_str().unwrap(), Some("density")).unwrap_err().to_string();
        assert!(
            error.contains("the grid `density` without active voxels (others: `heat`") && error.contains("--grid NAME"),
            "{error}"
        );
    }
    for grids in [&[empty][..], &[empty, Grid { name: "b", ..empty }]] {
        let error = read(grids).unwrap_err().to_string();
        assert!(
            error.contains("the grid `density`") && error.contains("without active voxels is not supported; export it"),
            "{error}"
        );
    }
}
