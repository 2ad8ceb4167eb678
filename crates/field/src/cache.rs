//! Disk cache of distance fields.
//!
//! Invariant: a file is used only if magic, version, key, sizes and hash match. Any other is recomputed and replaced.

use super::closest::ClosestPoints;
use super::error::FieldError;
use super::grid::{DistanceField, Grid};
use super::request::{FieldReport, Progress, Request};
use super::transform::{transform, transform_with_closest};
use glam::Vec3;
use hypertexture_shape::{Content, Shape, Solid};
use hypertexture_support::disk_cache;
use hypertexture_support::open::OpenError;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// A kind of file: magic, file extension, and decoding of a sample.
struct FileKind<T, const BYTES: usize> {
    magic: &'static [u8; 8],
    extension: &'static str,
    sample: fn([u8; BYTES]) -> T,
}

/// Distances.
const FIELD: FileKind<f32, 4> = FileKind { magic: b"HYPERFLD", extension: "field", sample: f32::from_le_bytes };
/// Closest points.
const CLOSEST: FileKind<Vec3, 12> = FileKind {
    magic: b"HYPERCPT",
    extension: "closest",
    sample: |bytes| Vec3::from_array(bytemuck::cast::<_, [[u8; 4]; 3]>(bytes).map(f32::from_le_bytes)),
};
/// Version of the computation and of the file layout, to be raised when either changes.
const VERSION: u32 = 6;
/// Magic, version, key, size, origin, spacing and five counts, followed by the samples.
const HEADER_BYTES: usize = 8 + 4 + 32 + 12 + 12 + 12 + 5 * 8;
/// Lower evicts scans at a high resolution too early; higher fills disks.
const CACHE: disk_cache::CacheKind =
    disk_cache::CacheKind { ends: &[FIELD.extension, CLOSEST.extension], limit: 2 << 30 };

/// Hash of a field's inputs: geometry and values of the shape, the request, and the version.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Key([u8; 32]);

impl Key {
    /// Key of the field of a shape. Equal content gives equal keys.
    pub fn new(shape: &Shape, request: &Request) -> Key {
        let mut hash = blake3::Hasher::new();
        hash.update(&VERSION.to_le_bytes()).update(&request.resolution.to_le_bytes());
        floats(&mut hash, &[request.margin, request.band, request.shell]);
        match shape {
            Shape::Solid(solid) => {
                let (kind, sizes) = match *solid {
                    Solid::Sphere { radius } => (0u8, [radius, 0.0]),
                    Solid::Cube { half } => (1, [half, 0.0]),
                    Solid::Torus { major, minor } => (2, [major, minor]),
                };
                hash.update(&[0, kind]);
                floats(&mut hash, &sizes);
            }
            Shape::Mesh(mesh) => {
                hash.update(&[1]).update(&(mesh.positions.len() as u64).to_le_bytes());
                hash.update(bytemuck::cast_slice(&mesh.positions)).update(bytemuck::cast_slice(&mesh.triangles));
            }
            Shape::Volume(volume) => {
                hash.update(&[2, volume.content as u8]);
                hash.update(bytemuck::bytes_of(&volume.size));
                floats(&mut hash, &[request.iso]);
                floats(&mut hash, &volume.origin.to_array());
                floats(&mut hash, &volume.steps.to_cols_array());
                hash.update(bytemuck::cast_slice(&volume.values));
            }
        }
        Key(*hash.finalize().as_bytes())
    }

    /// Hash of the contents of a shape alone, as 64 hexadecimal digits.
    pub fn of_contents(shape: &Shape) -> String {
        let none = Request { resolution: 0, margin: 0.0, band: 0.0, iso: 0.0, shell: 0.0 };
        blake3::Hash::from_bytes(Key::new(shape, &none).0).to_hex().to_string()
    }

    fn file(&self, extension: &str, folder: &Path) -> PathBuf {
        folder.join(format!("{}.{extension}", blake3::Hash::from_bytes(self.0).to_hex()))
    }
}

/// A field, its closest points if requested, and statistics.
type Computed = (DistanceField, Option<ClosestPoints>, FieldReport);

/// [`transform`] or, with `closest`, [`transform_with_closest`], through the disk cache. Formulas and volumes of signed distances
/// are not cached, being as fast to compute.
///
/// # Errors
/// Those of [`transform`]. A cache that cannot be read or written is logged as a warning.
pub fn load_or_compute(
    shape: &Shape,
    request: &Request,
    closest: bool,
    progress: Progress,
) -> Result<Computed, FieldError> {
    let compute = || computed(shape, request, closest, progress);
    let result = match cache_folder(shape) {
        Some(folder) => cached(&Key::new(shape, request), &folder, closest, compute)?,
        None => compute()?,
    };
    if result.2.tangled {
        log::warn!(
            "its solids overlap in too many places to find all surfaces inside of others: distances inside are too short \
             there; make one solid of them first, or raise the resolution"
        );
    }
    progress(1.0);
    Ok(result)
}

fn computed(shape: &Shape, request: &Request, closest: bool, progress: Progress) -> Result<Computed, FieldError> {
    if closest {
        return transform_with_closest(shape, request, progress)
            .map(|(field, points, report)| (field, Some(points), report));
    }
    transform(shape, request, progress).map(|(field, report)| (field, None, report))
}

/// The cache folder for a shape; `None` if computing its field is as fast as reading it.
fn cache_folder(shape: &Shape) -> Option<PathBuf> {
    match shape {
        Shape::Solid(_) => None,
        Shape::Volume(volume) if volume.content == Content::SignedDistance => None,
        _ => disk_cache::default_folder(),
    }
}

/// The results stored under `key` in `folder`, else those of `compute`, which are then stored.
fn cached(
    key: &Key,
    folder: &Path,
    closest: bool,
    compute: impl FnOnce() -> Result<Computed, FieldError>,
) -> Result<Computed, FieldError> {
    let start = Instant::now();
    let stored = || {
        let points = if closest { Some(read(&CLOSEST, key, folder)?) } else { None };
        let (grid, values, report) = read(&FIELD, key, folder)?;
        let points = points.map(|(grid, points, _)| ClosestPoints { grid, points });
        let report = FieldReport { ms: start.elapsed().as_secs_f64() * 1e3, ..report };
        Some((DistanceField { grid, values }, points, report))
    };
    if let Some(stored) = stored() {
        return Ok(stored);
    }
    let (field, closest, report) = compute()?;
    store(&FIELD, key, folder, (&field.grid, &field.values, &report));
    if let Some(closest) = &closest {
        store(&CLOSEST, key, folder, (&closest.grid, bytemuck::cast_slice(&closest.points), &report));
    }
    Ok((field, closest, report))
}

/// The samples stored under `key`. Logs a warning if a file is damaged or cannot be read.
fn read<T, const BYTES: usize>(kind: &FileKind<T, BYTES>, key: &Key, folder: &Path) -> Option<Stored<T>> {
    let path = key.file(kind.extension, folder);
    match disk_cache::read(&path, CACHE) {
        Ok(bytes) => {
            let stored = bytes.and_then(|bytes| decode(kind, &bytes, key));
            if stored.is_none() {
                log::warn!("{}: damaged or foreign field file; computing the field again", path.display());
            }
            return stored;
        }
        Err(OpenError::Missing) => {}
        Err(error) => log::warn!("{}: cannot read the cached field: {error}", path.display()),
    }
    None
}

/// Stores samples under `key`, or logs a warning.
fn store<T, const BYTES: usize>(kind: &FileKind<T, BYTES>, key: &Key, folder: &Path, input: Unstored<'_>) {
    let path = key.file(kind.extension, folder);
    if let Err(error) = disk_cache::write(&path, encode(kind, key, input), CACHE) {
        disk_cache::warn(folder, &error);
    }
}

fn floats(hash: &mut blake3::Hasher, values: &[f32]) {
    hash.update(bytemuck::cast_slice(values));
}

/// Grid, samples and statistics.
type Stored<T> = (Grid, Vec<T>, FieldReport);
/// Grid, samples as floats and statistics, to be stored.
type Unstored<'a> = (&'a Grid, &'a [f32], &'a FieldReport);

fn encode<T, const BYTES: usize>(
    kind: &FileKind<T, BYTES>,
    key: &Key,
    (grid, values, report): Unstored<'_>,
) -> Vec<u8> {
    let mut bytes = Vec::with_capacity(HEADER_BYTES + 4 * values.len());
    bytes.extend_from_slice(kind.magic);
    bytes.extend_from_slice(&VERSION.to_le_bytes());
    bytes.extend_from_slice(&key.0);
    bytes.extend(grid.size.iter().flat_map(|n| n.to_le_bytes()));
    bytes.extend([grid.origin, grid.spacing].iter().flat_map(|v| v.to_array()).flat_map(f32::to_le_bytes));
    let marks = u64::from(report.tangled) << 1 | u64::from(report.buried);
    let turned = (report.turned_triangles as u64) << 2 | marks;
    let counts =
        [report.triangles as u64, report.open_edges as u64, turned, report.closing_triangles as u64, report.exact];
    bytes.extend(counts.iter().flat_map(|n| n.to_le_bytes()));
    bytes.extend(values.iter().flat_map(|v| v.to_le_bytes()));
    bytes
}

fn decode<T, const BYTES: usize>(kind: &FileKind<T, BYTES>, bytes: &[u8], key: &Key) -> Option<Stored<T>> {
    let (header, payload) = bytes.split_at_checked(HEADER_BYTES)?;
    let head = header.strip_prefix(kind.magic)?.strip_prefix(&VERSION.to_le_bytes())?.strip_prefix(&key.0)?;
    let (geometry, counts) = head.split_at_checked(36)?;
    let mut words = geometry.as_chunks::<4>().0.iter();
    let mut word = || words.next().copied();
    let size = [word()?, word()?, word()?].map(u32::from_le_bytes);
    let mut vector = || Some(Vec3::from_array([word()?, word()?, word()?].map(f32::from_le_bytes)));
    let grid = Grid { size, origin: vector()?, spacing: vector()? };
    let expected = size.iter().try_fold(BYTES as u64, |a, &n| a.checked_mul(u64::from(n)))?;
    if payload.len() as u64 != expected {
        return None;
    }
    let counts: Vec<u64> = counts.as_chunks::<8>().0.iter().map(|&b| u64::from_le_bytes(b)).collect();
    let report = FieldReport {
        triangles: counts[0] as usize,
        open_edges: counts[1] as usize,
        turned_triangles: (counts[2] >> 2) as usize,
        buried: counts[2] & 1 == 1,
        tangled: counts[2] & 2 == 2,
        closing_triangles: counts[3] as usize,
        exact: counts[4],
        from_cache: true,
        ms: 0.0,
    };
    let values = payload.as_chunks::<BYTES>().0.iter().map(|&bytes| (kind.sample)(bytes)).collect();
    Some((grid, values, report))
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Mat3;
    use hypertexture_shape::{Mesh, Volume};
    use std::cell::Cell;
    use std::collections::HashSet;
    use std::fs;

    const REQUEST: Request = Request { resolution: 8, margin: 0.1, band: 0.1, iso: 0.0, shell: 0.0 };

    fn shape() -> Shape {
        let positions = vec![Vec3::ZERO, Vec3::X, Vec3::Y, Vec3::Z];
        Shape::Mesh(Mesh { positions, triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], ..Mesh::default() })
    }

    /// The cached field, and whether it was computed.
    fn get(folder: &Path) -> (DistanceField, FieldReport, bool) {
        let computed = Cell::new(false);
        let (field, _, report) = cached(&Key::new(&shape(), &REQUEST), folder, false, || {
            computed.set(true);
            super::computed(&shape(), &REQUEST, false, &|_| {})
        })
        .unwrap();
        assert_eq!(report.from_cache, !computed.get());
        (field, report, computed.get())
    }

    #[test]
    fn a_field_is_computed_once() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path().join("new/folder");
        let (first, report, computed) = get(&folder);
        assert!(computed);
        let (second, again, computed) = get(&folder);
        assert!(!computed && first == second);
        assert_eq!(FieldReport { ms: 0.0, from_cache: false, ..again }, FieldReport { ms: 0.0, ..report });
        assert_eq!(fs::read_dir(folder).unwrap().count(), 1, "no temporary file is left");
    }

    #[test]
    fn p55_closest_points_are_cached_beside_their_field() {
        let folder = tempfile::tempdir().unwrap();
        let key = Key::new(&shape(), &REQUEST);
        let computed = Cell::new(0);
        let get = || {
            cached(&key, folder.path(), true, || {
                computed.set(computed.get() + 1);
                super::computed(&shape(), &REQUEST, true, &|_| {})
            })
            .unwrap()
        };
        let (field, closest, _) = get();
        let (again, closest_again, report) = get();
        assert_eq!(computed.get(), 1);
        assert!(report.from_cache && field == again && closest == closest_again);
        assert_eq!(field, cached(&key, folder.path(), false, || unreachable!("it is stored")).unwrap().0);
        let path = key.file(CLOSEST.extension, folder.path());
        let mut bytes = fs::read(&path).unwrap();
        bytes[200] ^= 1;
        fs::write(&path, bytes).unwrap();
        assert!(get().1 == closest && computed.get() == 2, "a damaged file is computed again");
    }

    #[test]
    fn a_damaged_file_is_ignored_and_replaced() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let key = Key::new(&shape(), &REQUEST);
        let (truth, ..) = get(folder);
        let path = key.file(FIELD.extension, folder);
        let good = fs::read(&path).unwrap();
        for at in 0..good.len() {
            let mut bad = good.clone();
            bad[at] ^= 1 << (at % 8);
            for (damaged, how) in [(&bad[..], "byte flipped"), (&good[..at], "cut")] {
                fs::write(&path, damaged).unwrap();
                assert!(read(&FIELD, &key, folder).is_none(), "{how} at {at}");
            }
        }
        let long = [good.as_slice(), &[0]].concat();
        for damaged in [&good[..good.len() / 2], &[], &long, b"something else"] {
            fs::write(&path, damaged).unwrap();
            let (field, _, computed) = get(folder);
            assert!(computed && field == truth);
            assert!(!get(folder).2, "it was replaced");
        }
    }

    #[test]
    fn the_key_depends_on_geometry_and_request() {
        let key = Key::new(&shape(), &REQUEST);
        assert_eq!(key, Key::new(&shape(), &Request { iso: 3.0, ..REQUEST }), "a mesh has no iso-value");
        let Shape::Mesh(mut mesh) = shape() else { panic!("the shape is a mesh") };
        mesh.positions[3].z = 1.0 + f32::EPSILON;
        let others = [
            Key::new(&Shape::Mesh(mesh), &REQUEST),
            Key::new(&shape(), &Request { resolution: 9, ..REQUEST }),
            Key::new(&shape(), &Request { margin: 0.2, ..REQUEST }),
            Key::new(&shape(), &Request { band: 0.2, ..REQUEST }),
            Key::new(&Shape::Solid(Solid::Sphere { radius: 1.0 }), &REQUEST),
            Key::new(&Shape::Solid(Solid::Cube { half: 1.0 }), &REQUEST),
        ];
        assert!(others.iter().all(|other| *other != key));
        assert_ne!(others[4], others[5]);
        let field = transform(&shape(), &REQUEST, &|_| {}).unwrap().0;
        let foreign = encode(&FIELD, &others[0], (&field.grid, &field.values, &FieldReport::default()));
        assert!(decode(&FIELD, &foreign, &key).is_none());
        let of_another_kind = encode(&FIELD, &key, (&field.grid, &field.values, &FieldReport::default()));
        assert!(decode(&FIELD, &of_another_kind, &key).is_some() && decode(&CLOSEST, &of_another_kind, &key).is_none());
    }

    #[test]
    fn the_key_of_a_scan_depends_on_how_its_grid_stands() {
        let key = |steps: [f32; 9]| {
            let (steps, content) = (Mat3::from_cols_array(&steps), Content::Scalar);
            let volume = Volume { size: [1; 3], origin: Vec3::ZERO, steps, values: vec![1.0], content };
            Key::new(&Shape::Volume(volume), &REQUEST).0
        };
        let steps = [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0];
        let changed = |at: usize| {
            let mut steps = steps;
            steps[at] += 0.25;
            key(steps)
        };
        let keys: HashSet<[u8; 32]> = (0..9).map(changed).chain([key(steps)]).collect();
        assert_eq!(keys.len(), 10);
    }

    #[test]
    fn a_folder_that_cannot_be_written_is_no_error() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("file");
        fs::write(&file, b"in the way").unwrap();
        assert!(get(&file.join("below")).2 && get(&file).2);
    }
}
