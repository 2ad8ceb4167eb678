//! Truths 6 and 8: what is read from volumes: distances between voxels, and noise.

use super::analytic::Level;
use super::pictures::{box_subject, homogeneous};
use super::rays::rays;
use super::{Bench, PASSES, Row, name};
use glam::{DVec3, Vec3};
use hypertexture::field::{DistanceField, Grid};
use hypertexture::render::{RenderError, Subject, render};
use hypertexture::scene::{FieldEncoding, Filter, Pass, Projection, Scene};
use std::sync::Arc;

/// A hard face across the picture, colored by a module.
pub fn face(surface: &str, pass: Pass) -> Scene {
    let mut scene = homogeneous("cube", 1.0, Projection::Parallel);
    (scene.effect.classify, scene.effect.surface) = ("surface".into(), surface.into());
    (scene.quality.pass, scene.quality.samples) = (pass, 64);
    scene.camera.zoom = 2.5; // the picture spans [-1/2, 1/2] of a subject of radius 1
    scene
}

/// What that face is of.
pub fn face_subject() -> Subject {
    Subject { radius: 1.0, ..box_subject(Vec3::new(0.6, 0.6, 0.4)) }
}

/// A field that is negative in the whole box, sampled at the corners of so many cells along each side of [-1, 1]^3.
fn sampled(cells: u32, distance: fn(DVec3) -> f64) -> DistanceField {
    let n = cells + 1;
    let grid = Grid { size: [n; 3], origin: Vec3::NEG_ONE, spacing: Vec3::splat(2.0 / cells as f32) };
    let voxel = |index: u32| distance(grid.position(index % n, index / n % n, index / (n * n)).as_dvec3()) as f32;
    DistanceField { values: (0..n * n * n).map(voxel).collect(), grid }
}

/// Linear along each axis: what trilinear interpolation reproduces.
fn trilinear(p: DVec3) -> f64 {
    -0.9 + 0.2 * p.x - 0.15 * p.y + 0.1 * p.z + 0.12 * p.x * p.y - 0.1 * p.y * p.z + 0.08 * p.x * p.y * p.z
}

/// The distance to a sphere around the whole box.
fn from_inside(p: DVec3) -> f64 {
    (p - DVec3::new(0.3, -0.2, -1.6)).length() - 3.6
}

pub(super) fn fields(bench: &Bench<'_>) -> Result<Vec<Row>, RenderError> {
    type Case = (&'static str, fn(DVec3) -> f64, &'static [u32], fn(&Level) -> f64, Option<[f64; 2]>);
    let cases: [Case; 2] = [
        // f32 holds a distance of at most 1.5 to 2^-24, and its place in the volume to about as much.
        ("trilinear field, N cells", trilinear, &[1, 16, 63], |_| 4e-7, None),
        // h^2 / 8 of the curvature along each of two axes, 1 / r with r > 1.2.
        (
            "distance to a sphere, N cells",
            from_inside,
            &[8, 16, 32],
            |level| 0.25 * level.step.powi(2) / 4.8,
            Some([1.9, 2.1]),
        ),
    ];
    let mut rows = Vec::new();
    let filters = [(Filter::Device, ""), (Filter::Exact, ", exact filter")];
    for ((what, distance, cells, bound, order), (filter, named)) in
        cases.into_iter().flat_map(|case| filters.map(|filter| (case, filter)))
    {
        // Weights of 8 bits are off by less than 1 / 128 of a cell along each axis, where distances grow by less than 1.
        let coarse = filter == Filter::Device && bench.gpu.info().filters_by_few_bits();
        let by_weights = |level: &Level| if coarse { 0.25 * level.step * 3f64.sqrt() / 128.0 } else { 0.0 };
        let order = order.filter(|_| !coarse);
        for pass in PASSES {
            let mut scene = face("field_value", pass);
            scene.quality.filter = filter;
            scene.object.field_encoding = FieldEncoding::Distance32;
            (scene.object.inner_iso, scene.object.outer_iso) = (1.0, 1.0); // all of it is inside, and distances are stored in twice that range
            let mut subject = face_subject();
            let mut levels = Vec::new();
            for &cells in cells {
                subject.field = Some(Arc::new(sampled(cells, distance)));
                let frame = render(bench.gpu, &bench.library, &scene, &subject)?;
                let pixels = rays(&scene, &subject).into_iter().zip(&frame.pixels);
                let off = pixels.map(|(ray, pixel)| {
                    let truth = 0.5 + 0.25 * distance(DVec3::new(ray.from.x, ray.from.y, 0.3));
                    (f64::from(pixel[0]) - truth).abs()
                });
                levels.push(Level::of(cells, 2.0 / f64::from(cells), off));
            }
            let bound = |level: &Level| bound(level) + by_weights(level);
            rows.push(Row { what: format!("{what}{named}"), ..Row::of(&levels, bound, order, name(pass)) });
        }
    }
    Ok(rows)
}

pub(super) fn noise(bench: &Bench<'_>) -> Result<Vec<Row>, RenderError> {
    let mut rows = Vec::new();
    for pass in PASSES {
        let mut scene = face("noise_lattice", pass);
        scene.effect.noise = "procedural".into();
        let frame = render(bench.gpu, &bench.library, &scene, &face_subject())?;
        let at_points = Level::of(0, 0.0, frame.pixels.iter().map(|pixel| f64::from(pixel[0])));
        let between = Level::of(0, 0.0, frame.pixels.iter().map(|pixel| f64::from(pixel[1])));
        let mut row = Row::single("0 at lattice points", name(pass), at_points, |_| 0.0);
        // Noise that is 0 everywhere is none; gradients of length 1 cannot give more than sqrt(3) / 2.
        row.ok &= between.mean > 0.05 && between.max <= 0.8661;
        rows.push(row);

        scene.effect = face("noise_period", pass).effect;
        let frame = render(bench.gpu, &bench.library, &scene, &face_subject())?;
        let mean = |channel: usize| {
            frame.pixels.iter().map(|pixel| f64::from(pixel[channel])).sum::<f64>() / frame.pixels.len() as f64
        };
        let (value, square) = (2.0 * mean(0) - 1.0, mean(1));
        let integral = Level::of(64, 0.0, std::iter::once(value.abs()));
        // Zero is no code of 16 bits: half a code of [-1, 1].
        let mut row = Row::single("integral over periods", name(pass), integral, |_| 2e-5);
        row.ok &= square > 0.01;
        rows.push(row);
    }
    Ok(rows)
}
