//! Distance transform of a shape.

use super::bvh::Bvh;
use super::closest::ClosestPoints;
use super::distance::Distances;
use super::error::FieldError;
use super::grid::{DistanceField, Grid, Local, check_samples, range};
use super::iso_surface::Scalar;
use super::request::{FieldReport, Progress, Request};
use super::soup::Soup;
use super::stage::Stage;
use super::winding::Winding;
use super::{overlap, seal, sign};
use glam::Vec3;
use hypertexture_shape::{Content, MAX_COORDINATE, Mesh, Shape, Volume};
use hypertexture_support::memory;
use rayon::prelude::*;
use std::cell::Cell;
use std::ops::RangeInclusive;
use std::time::Instant;

/// Memory limit of a computation. Higher makes a laptop swap; lower refuses a cube of 512 samples a side.
const MEMORY_LIMIT_BYTES: u64 = 2 << 30;
/// Memory of a voxel: value, sign, state, its share of the block corners, and of the queue of the flood fill.
const BYTES_PER_VOXEL: u64 = 10;
/// Memory of the closest point of a voxel.
const BYTES_PER_POINT: u64 = 12;
/// Memory of a triangle: corners, packet, boxes, moments and edges.
const BYTES_PER_TRIANGLE: u64 = 320;

/// Longest sides, in world units, of shapes that are not rescaled first. Squares of lengths far outside overflow f32.
const UNSCALED_SIDES: RangeInclusive<f32> = 1e-6..=1e6;

/// Computes the signed distance field of a shape.
///
/// The grid is [`Grid::covering`]; a volume of signed distances keeps its own grid and values. Up to a magnitude of
/// `request.band` the field is exact to f32 rounding (1e-4 voxels). Elsewhere it is short of the distance by at most a quarter
/// of a voxel, with the right sign. The result does not depend on the number of threads.
///
/// - Solid: its formula at every sample.
/// - Mesh: inside is where the winding number is at least 1/2 in magnitude. Triangles that disagree with their neighbors are
///   flipped first, surfaces buried where solids overlap are dropped, and holes are closed by the level 1/2 of the winding
///   number, so that the solid is closed.
/// - Scalar volume: inside is where `value >= request.iso`, linear in tetrahedra between samples; outside beyond them.
/// - Level set: inside is where `value <= 0`.
///
/// With `request.shell` above 0, inside is nearer than half of that to the surface, closed or not.
///
/// Sources: Barill et al. 2018 (winding number); Doi & Koide 1991 (tetrahedra); `distance.rs` derives the lower bound.
///
/// # Errors
/// Every variant of [`FieldError`].
pub fn transform(
    shape: &Shape,
    request: &Request,
    progress: Progress,
) -> Result<(DistanceField, FieldReport), FieldError> {
    let (field, _, report) = compute(shape, request, false, progress)?;
    Ok((field, report))
}

/// Computes the signed distance field of a shape, and the closest surface point of every sample.
///
/// Points come from the searches for exact distances. Elsewhere a point is on the surface, farther than the field says by at
/// most a quarter of a voxel. Those of a volume of signed distances are [`ClosestPoints::of_field`].
///
/// # Errors
/// Every variant of [`FieldError`].
pub fn transform_with_closest(
    shape: &Shape,
    request: &Request,
    progress: Progress,
) -> Result<(DistanceField, ClosestPoints, FieldReport), FieldError> {
    let (field, points, report) = compute(shape, request, true, progress)?;
    let closest = ClosestPoints { grid: field.grid, points };
    Ok((field, closest, report))
}

/// A field, its closest points in world space if requested, and statistics.
type Computed = (DistanceField, Vec<Vec3>, FieldReport);

fn compute(shape: &Shape, request: &Request, closest: bool, progress: Progress) -> Result<Computed, FieldError> {
    let bounds = shape.bounds();
    let longest = (bounds.max - bounds.min).max_element();
    if longest > 0.0 && longest < 4.0 * MAX_COORDINATE && !UNSCALED_SIDES.contains(&longest) {
        // A power of two, for no rounding.
        let by = (-longest.log2().floor()).min(120.0).exp2();
        let [margin, band, shell] = [request.margin, request.band, request.shell].map(|length| by * length);
        let request = Request { margin, band, shell, ..*request };
        let (field, mut points, report) = compute(&shape.scaled(by), &request, closest, progress)?;
        points.iter_mut().for_each(|point| *point /= by);
        return Ok((field.scaled(1.0 / by), points, report));
    }
    let start = Instant::now();
    let half = 0.5 * request.shell;
    let wide = Request { margin: request.margin + half, band: request.band + half, ..*request };
    let (mut field, mut points, report) = surface(shape, &wide, closest, progress)?;
    if half > 0.0 {
        let grid = field.grid;
        let [nx, ny, _] = grid.size;
        field.values.par_iter_mut().for_each(|value| *value = value.abs() - half);
        points.par_iter_mut().enumerate().for_each(|(index, point)| {
            let index = index as u32;
            let away = grid.position(index % nx, index / nx % ny, index / (nx * ny)) - *point;
            *point += away.normalize_or_zero() * half;
        });
    }
    progress(1.0);
    Ok((field, points, FieldReport { ms: start.elapsed().as_secs_f64() * 1e3, ..report }))
}

/// The field of a surface, unsigned for a mesh that becomes a shell.
fn surface(shape: &Shape, request: &Request, closest: bool, progress: Progress) -> Result<Computed, FieldError> {
    Ok(match shape {
        Shape::Volume(volume) if volume.content == Content::SignedDistance => {
            let field = DistanceField::from_volume(volume)?;
            let points = if closest { ClosestPoints::of_field(&field, progress).points } else { Vec::new() };
            (field, points, FieldReport::default())
        }
        Shape::Volume(volume) if volume.content == Content::LevelSet => {
            // Scalars are large inside, level sets small.
            let values = volume.values.iter().map(|value| -value).collect();
            let scalar = Volume { values, content: Content::Scalar, ..*volume };
            of_scalar(&scalar, shape, &Request { iso: 0.0, ..*request }, closest, progress)?
        }
        Shape::Volume(volume) => of_scalar(volume, shape, request, closest, progress)?,
        Shape::Mesh(mesh) => of_mesh(mesh, shape, request, closest, progress)?,
        Shape::Solid(solid) => {
            let grid = budgeted(shape, request, 0, closest)?;
            let part = if closest { 0.5 } else { 1.0 };
            let stage = Stage::new(progress, 0.0, part, grid.size()[2]);
            let values = sampled(&grid, &stage, |p| solid.distance(p));
            let stage = Stage::new(progress, part, 1.0, grid.size()[2]);
            let points = if closest { sampled(&grid, &stage, |p| solid.closest(p)) } else { Vec::new() };
            (DistanceField { grid, values }, points, FieldReport { exact: grid.samples(), ..FieldReport::default() })
        }
    })
}

fn of_mesh(
    mesh: &Mesh,
    shape: &Shape,
    request: &Request,
    closest: bool,
    progress: Progress,
) -> Result<Computed, FieldError> {
    if mesh.triangles.is_empty() {
        return Err(FieldError::EmptyMesh);
    }
    let vertices = mesh.positions.len();
    if let Some(&index) = mesh.triangles.iter().flatten().find(|&&i| i as usize >= vertices) {
        return Err(FieldError::Corner { index, vertices });
    }
    let grid = budgeted(shape, request, mesh.triangles.len(), closest)?;
    let (size, band) = (grid.size(), request.band / grid.spacing.x);
    let soup = Soup::new(mesh, &Local::new(&grid));
    let mut report = FieldReport {
        triangles: soup.triangles.len(),
        open_edges: soup.open_edges,
        turned_triangles: soup.turned,
        ..FieldReport::default()
    };

    let whole = Bvh::new(&soup.triangles);
    if request.shell > 0.0 {
        let mut distances = Distances::new(size, closest);
        distances.add(&[&whole], band, &Stage::new(progress, 0.05, 1.0, size[2]));
        return Ok(signed(distances, grid, |_| false, report));
    }
    let winding = Winding::new(&whole);
    progress(0.05);
    let tangled = Cell::new(false);
    let bare = || {
        let (boundary, is_tangled) = overlap::boundary(&soup.triangles, &winding, grid.samples());
        tangled.set(is_tangled);
        Bvh::new(&boundary)
    };
    let measured = |surface: &Bvh, from, to| {
        let mut distances = Distances::new(size, closest);
        distances.add(&[surface], band, &Stage::new(progress, from, to, size[2]));
        distances
    };
    // Most overlaps show at a few points, before distances are measured in vain.
    let mut bared = sign::overlaps(size, &winding).then(bare);
    let mut distances = measured(bared.as_ref().unwrap_or(&whole), 0.05, 0.5);
    let signs = sign::signs(size, &distances, &winding, &soup.rim);
    progress(0.65);
    if signs.overlap && bared.is_none() {
        distances = measured(bared.insert(bare()), 0.65, 0.9);
    }
    (report.buried, report.tangled) = (bared.is_some(), tangled.get());
    let surface = bared.as_ref().unwrap_or(&whole);
    let closing = seal::closing_triangles(size, distances.values(), &signs.inside, &winding);
    report.closing_triangles = closing.len();
    if !closing.is_empty() {
        distances.add(&[surface, &Bvh::new(&closing)], band, &Stage::new(progress, 0.9, 1.0, size[2]));
    }
    Ok(signed(distances, grid, |i| signs.inside[i], report))
}

fn of_scalar(
    volume: &Volume,
    shape: &Shape,
    request: &Request,
    closest: bool,
    progress: Progress,
) -> Result<Computed, FieldError> {
    check_samples(volume)?;
    let iso = request.iso;
    let (min, max) = range(&volume.values);
    // The iso-value itself is inside, so a value below is needed.
    if !(min < iso && iso <= max) {
        return Err(FieldError::NoSurface { iso, min, max });
    }
    let grid = budgeted(shape, request, 0, closest)?;
    let (size, local) = (grid.size(), Local::new(&grid));
    let scalar = Scalar::new(volume, iso, (min, max));
    let triangles = scalar.triangles(&local);
    let count = triangles.len();
    budgeted(shape, request, count, closest)?;
    progress(0.1);
    let surface = Bvh::new(&triangles);
    drop(triangles);
    progress(0.2);
    let mut distances = Distances::new(size, closest);
    distances.add(&[&surface], request.band / grid.spacing.x, &Stage::new(progress, 0.2, 0.9, size[2]));
    let stage = Stage::new(progress, 0.9, 1.0, size[2]);
    let is_inside = |i: usize| {
        let voxel = [i % size[0], i / size[0] % size[1], i / (size[0] * size[1])];
        if voxel[0] == 0 && voxel[1] == 0 {
            stage.advance(1);
        }
        scalar.level(local.world(voxel)) >= 0.0
    };
    Ok(signed(distances, grid, is_inside, FieldReport { triangles: count, ..FieldReport::default() }))
}

/// Gives distances their signs, and converts distances and closest points from voxels to world units.
fn signed(distances: Distances, grid: Grid, is_inside: impl Fn(usize) -> bool + Sync, report: FieldReport) -> Computed {
    let report = FieldReport { exact: distances.exact() as u64, ..report };
    let (mut values, mut points) = distances.into_values();
    values.par_iter_mut().enumerate().for_each(|(i, value)| {
        let distance = *value * grid.spacing.x;
        *value = if is_inside(i) { -distance } else { distance };
    });
    points.par_iter_mut().for_each(|point| *point = grid.origin + *point * grid.spacing);
    (DistanceField { grid, values }, points, report)
}

/// The grid, if the computation fits in memory.
fn budgeted(shape: &Shape, request: &Request, triangles: usize, closest: bool) -> Result<Grid, FieldError> {
    let grid = Grid::covering(&shape.bounds(), request)?;
    let voxel = BYTES_PER_VOXEL + if closest { BYTES_PER_POINT } else { 0 };
    let bytes = grid.samples() * voxel + triangles as u64 * BYTES_PER_TRIANGLE;
    let limit = memory::available().map_or(MEMORY_LIMIT_BYTES, |left| left.min(MEMORY_LIMIT_BYTES));
    if bytes > limit {
        return Err(FieldError::Memory { bytes, limit, size: grid.size });
    }
    Ok(grid)
}

fn sampled<T: Default + Clone + Send>(grid: &Grid, stage: &Stage, value: impl Fn(Vec3) -> T + Sync) -> Vec<T> {
    let [nx, ny, _] = grid.size();
    let mut values = vec![T::default(); grid.samples() as usize];
    values.par_chunks_mut(nx * ny).enumerate().for_each(|(k, slice)| {
        for (i, out) in slice.iter_mut().enumerate() {
            *out = value(grid.position((i % nx) as u32, (i / nx) as u32, k as u32));
        }
        stage.advance(1);
    });
    values
}
