//! From a shape to its distance field, step by step.

use super::bvh::Bvh;
use super::distance::Distances;
use super::grid::{Local, check_samples, range};
use super::iso_surface::Scalar;
use super::soup::Soup;
use super::stage::Stage;
use super::winding::Winding;
use super::{ClosestPoints, DistanceField, FieldError, FieldReport, Grid, Progress, Request, overlap, seal, sign};
use glam::Vec3;
use rayon::prelude::*;
use shape::{Content, MAX_COORDINATE, Mesh, Shape, Volume};
use std::cell::Cell;
use std::ops::RangeInclusive;
use std::time::Instant;
use support::memory;

/// Most memory one computation may take. Larger: a laptop starts to swap. Smaller: 512 samples on each side of a cube
/// would be refused.
const MEMORY_LIMIT_BYTES: u64 = 2 << 30;
/// Value, sign, state and the block corners' share of a voxel, with room for the queue that floods signs.
const BYTES_PER_VOXEL: u64 = 10;
/// Three coordinates of the closest point of a voxel.
const BYTES_PER_POINT: u64 = 12;
/// Corners, packet, boxes, moments and edges of a triangle.
const BYTES_PER_TRIANGLE: u64 = 320;

/// Longest sides of shapes that are computed as they are, world units. The squares of lengths far outside of these leave
/// f32: such shapes are computed larger or smaller.
const HANDY: RangeInclusive<f32> = 1e-6..=1e6;

/// Distance field of `shape`: signed, positive outside, world units; x fastest, then y, then z.
///
/// The grid has cubic voxels, see [`Grid::covering`]; a volume of signed distances is taken as it is, on its own grid.
/// Where the magnitude is at most `request.band` it is the distance to the surface to f32 rounding (of positions up to
/// `resolution` voxels from the origin: 1e-4 voxels). Elsewhere it is at most the distance and at least the distance
/// less a quarter of a voxel, with the right sign. The result does not depend on the number of threads.
///
/// - Solid: its formula at every sample.
/// - Mesh: inside is where the surface winds around at least half a turn, either way; triangles that disagree with
///   their neighbors are turned first, surfaces buried where solids overlap are dropped, and holes are closed by the
///   level 1/2 of the winding number, so that the field is that of a closed solid.
/// - Scalar volume: inside is where `value >= request.iso`, linear in tetrahedra between samples; the world beyond the
///   samples is outside.
/// - Level set: the same with inside where `value <= 0`.
///
/// With `request.shell` above 0 inside is what is nearer than half of that to the surface of any of them, closed or not.
///
/// Sources: Barill et al. 2018 (winding number); Doi & Koide 1991 (tetrahedra); the lower bound far from the
/// surface is derived in `distance.rs`.
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

/// [`transform`], and for every sample the closest point of the surface that its distance is measured to.
///
/// The points cost no more searches: where a distance is exact, its search has found the point. Elsewhere the point is
/// one of the surface, farther by at most a quarter of a voxel than the field says. The points of a volume of signed
/// distances, which brings no surface, are those of [`ClosestPoints::of_field`].
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

/// A field, its closest points in world space or none, and what it took.
type Computed = (DistanceField, Vec<Vec3>, FieldReport);

fn compute(shape: &Shape, request: &Request, closest: bool, progress: Progress) -> Result<Computed, FieldError> {
    let bounds = shape.bounds();
    let longest = (bounds.max - bounds.min).max_element();
    if longest > 0.0 && longest < 4.0 * MAX_COORDINATE && !HANDY.contains(&longest) {
        // By a power of two, so that nothing is rounded.
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

/// The field of a surface; of a mesh that becomes a shell without signs.
fn surface(shape: &Shape, request: &Request, closest: bool, progress: Progress) -> Result<Computed, FieldError> {
    Ok(match shape {
        Shape::Volume(volume) if volume.content == Content::SignedDistance => {
            let field = DistanceField::from_volume(volume)?;
            let points = if closest { ClosestPoints::of_field(&field, progress).points } else { Vec::new() };
            (field, points, FieldReport::default())
        }
        Shape::Volume(volume) if volume.content == Content::LevelSet => {
            // Inside is where a scalar is large, and a level set small.
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
        report.exact = distances.exact() as u64;
        let (mut values, points) = distances.into_values();
        values.par_iter_mut().for_each(|value| *value *= grid.spacing.x);
        return Ok((DistanceField { grid, values }, to_world(points, &grid), report));
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
    // Most often a few points show that solids overlap, before anything is measured in vain.
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
    report.exact = distances.exact() as u64;
    let (mut values, points) = distances.into_values();
    values.par_iter_mut().zip(signs.inside).for_each(|(value, inside)| {
        let distance = *value * grid.spacing.x;
        *value = if inside { -distance } else { distance };
    });
    Ok((DistanceField { grid, values }, to_world(points, &grid), report))
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
    // A value at the iso-value is inside: without one below there is no outside among the samples.
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
    let exact = distances.exact() as u64;
    let (mut values, points) = distances.into_values();
    let stage = Stage::new(progress, 0.9, 1.0, size[2]);
    values.par_chunks_mut(size[0] * size[1]).enumerate().for_each(|(z, slice)| {
        for (i, value) in slice.iter_mut().enumerate() {
            let inside = scalar.level(local.world([i % size[0], i / size[0], z])) >= 0.0;
            let distance = *value * grid.spacing.x;
            *value = if inside { -distance } else { distance };
        }
        stage.advance(1);
    });
    let report = FieldReport { triangles: count, exact, ..FieldReport::default() };
    Ok((DistanceField { grid, values }, to_world(points, &grid), report))
}

/// Positions in voxels as positions in the world.
fn to_world(mut points: Vec<Vec3>, grid: &Grid) -> Vec<Vec3> {
    points.par_iter_mut().for_each(|point| *point = grid.origin + *point * grid.spacing);
    points
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
