//! Cases 20 to 23, 35 and 37: what is stored of a distance, where it has no direction, on grids and at sizes of every kind.

use super::matter::PASSES;
use super::{Lab, Row, StressError};
use crate::verify::{box_subject, face, face_subject, homogeneous, rays};
use glam::{DVec3, Mat3, UVec3, Vec3};
use hypertexture::field::{self, DistanceField, Grid, Request};
use hypertexture::render::{RenderError, Subject, render};
use hypertexture::scene::{FieldEncoding, Filter, Pass, Projection};
use hypertexture::shape::{Content, Shape, Volume};
use std::sync::Arc;

/// Where texels of a field are read from.
const SOURCES: [(FieldEncoding, &str); 4] = [
    (FieldEncoding::Normals8, "normals8"),
    (FieldEncoding::Normals16, "normals16"),
    (FieldEncoding::Distance16, "distance16"),
    (FieldEncoding::Distance32, "distance32"),
];

/// Voxels from where it should that a filter may read: by weights of 8 bits, which GPUs round more than once (an NVIDIA H100
/// is off by 1 / 192), and by floats.
const FILTERED: [f64; 2] = [1.0 / 128.0, 1.0 / 512.0];

/// A field over [-1.25, 1.25]^3.
fn sampled(side: u32, distance: impl Fn(Vec3) -> f32) -> DistanceField {
    let grid = Grid { size: [side; 3], origin: Vec3::splat(-1.25), spacing: Vec3::splat(2.5 / (side - 1) as f32) };
    let places = (0..side).flat_map(|k| (0..side).flat_map(move |j| (0..side).map(move |i| (i, j, k))));
    DistanceField { values: places.map(|(i, j, k)| distance(grid.position(i, j, k))).collect(), grid }
}

fn subject_of(field: DistanceField) -> Subject {
    Subject { radius: 1.0, field: Some(Arc::new(field)), ..box_subject(Vec3::ONE) }
}

/// Case 20: normals of a ball of 64^3 samples, in degrees.
pub(super) fn bits(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let mut rows = Vec::new();
    for (source, name) in SOURCES {
        // Code of a component, by rounding; of a distance, over two voxels.
        let code: f64 = match source {
            FieldEncoding::Normals8 => 1.0 / 255.0,
            FieldEncoding::Normals16 => 1.0 / 65535.0,
            _ => 0.0,
        };
        for band in [0.1f32, 0.8] {
            let mut scene = homogeneous("sphere", 1.0, Projection::Parallel);
            (scene.effect.classify, scene.effect.surface) = ("surface".into(), "normals".into());
            (scene.object.field_encoding, scene.object.inner_iso, scene.object.outer_iso) = (source, 0.0, band);
            (scene.quality.pass, scene.quality.samples) = (Pass::March, 1024);
            let subject = subject_of(sampled(64, |p| p.length() - 1.0));
            let frame = render(lab.bench.gpu, &lab.bench.library, &scene, &subject)?;
            let mut angles = Vec::new();
            for (ray, pixel) in rays(&scene, &subject).into_iter().zip(&frame.pixels) {
                let b = ray.impact();
                if b > 0.7 {
                    continue; // a step along a ray that grazes is a turn of the normal
                }
                let truth = DVec3::new(ray.from.x, ray.from.y, (1.0 - b * b).sqrt());
                let [x, y, z, _] = pixel.map(|value| 2.0 * f64::from(value) - 1.0);
                angles.push(DVec3::new(x, y, z).angle_between(truth).to_degrees());
            }
            let mean = angles.iter().sum::<f64>() / angles.len() as f64;
            // Interpolation over a voxel and a step of the ray turn it by some hundredths of a degree.
            let bound = 0.02 + (1.5 * code).to_degrees();
            let known = [(0.0, mean, bound)];
            rows.push(Row::worst(&format!("normals of a ball, {name}"), format!("band {band}"), known));
        }
    }
    Ok(rows)
}

/// Case 22: where a distance has no gradient, a normal is still one.
pub(super) fn medial(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let mut rows = Vec::new();
    type Distance = (&'static str, fn(Vec3) -> f32, f32);
    let fields: [Distance; 3] = [
        ("middle of a ball", |p| p.length() - 1.0, -0.97),
        ("ridges of a cube", |p| p.abs().max_element() - 1.0, -0.95),
        ("between two plates", |p| (p.y.abs() - 0.5).abs() - 0.5, -0.45),
    ];
    for (name, distance, iso) in fields {
        for (source, stored) in SOURCES {
            for (pass, how) in PASSES {
                let mut scene = homogeneous("cube", 50.0, Projection::Perspective);
                scene.effect.surface = "normals".into();
                (scene.object.field_encoding, scene.object.inner_iso, scene.object.outer_iso) =
                    (source, iso, iso + 0.02);
                (scene.quality.pass, scene.image.size, scene.camera.zoom) = (pass, [32, 32], 4.0);
                // A picture that is not finite is an error of the renderer.
                let frame = render(lab.bench.gpu, &lab.bench.library, &scene, &subject_of(sampled(33, distance)))?;
                let known = frame.pixels.iter().flat_map(|pixel| {
                    let alpha = f64::from(pixel[3]);
                    // Components of a unit vector, of as much matter as there is.
                    [0, 1, 2].map(|c| (f64::from(pixel[c]).clamp(0.0, alpha), f64::from(pixel[c]), 1e-5))
                });
                rows.push(Row::worst(name, format!("{stored}, {how}"), known.collect::<Vec<_>>()));
            }
        }
    }
    Ok(rows)
}

/// What is linear over [-1, 1]^3, sampled on a grid and drawn: what a pixel must be, and what it is.
fn of_linear(
    lab: &Lab<'_>,
    source: FieldEncoding,
    size: [u32; 3],
    filter: Filter,
    linear: impl Fn(Vec3) -> f32,
) -> Result<Vec<(f64, f64)>, StressError> {
    let mut scene = face("field_value", Pass::March);
    (scene.object.field_encoding, scene.quality.filter) = (source, filter);
    (scene.object.inner_iso, scene.object.outer_iso) = (1.0, 1.0);
    let spacing = 2.0 / (UVec3::from(size).as_vec3() - 1.0);
    let grid = Grid { size, origin: Vec3::NEG_ONE, spacing };
    let [x, y, z] = size;
    let places = (0..z).flat_map(|k| (0..y).flat_map(move |j| (0..x).map(move |i| (i, j, k))));
    let values = places.map(|(i, j, k)| linear(grid.position(i, j, k))).collect();
    let mut subject = face_subject();
    subject.field = Some(Arc::new(DistanceField { grid, values }));
    let frame = render(lab.bench.gpu, &lab.bench.library, &scene, &subject)?;
    let value = |pixel: &[f32; 4]| (f64::from(pixel[0]) - 0.5) * 4.0; // as `field_value` shows it
    let rays = rays(&scene, &subject).into_iter();
    Ok(rays.zip(&frame.pixels).map(|(ray, pixel)| (f64::from(linear(ray.from.as_vec3())), value(pixel))).collect())
}

/// Case 21: how far from its place a device reads, in voxels: its filter has so many bits.
pub(super) fn filters(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let mut rows = Vec::new();
    let bound = FILTERED[usize::from(!lab.bench.gpu.info().filters_by_few_bits())];
    for side in [2, 3, 5, 9, 33] {
        for (source, name) in [(FieldEncoding::Distance32, "distance32"), (FieldEncoding::Distance16, "distance16")] {
            let voxel = 2.0 / f64::from(side - 1);
            let found = of_linear(lab, source, [side; 3], Filter::Device, |p| p.x)?;
            let known = found.into_iter().map(|(expected, found)| (0.0, (found - expected).abs() / voxel, bound));
            let row = Row::worst(&format!("place that is read, {name}"), format!("voxel of {voxel}"), known);
            rows.push(row.at(voxel));
        }
    }
    Ok(rows)
}

/// Case 23: components of a normal that are 0, where codes of normals have none: half a code beside it.
pub(super) fn normals(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let mut rows = Vec::new();
    let code = |source| match source {
        FieldEncoding::Normals8 => 1.0 / 255.0,
        FieldEncoding::Normals16 => 1.0 / 65535.0,
        _ => 0.0,
    };
    // A plate, seen from straight ahead.
    for (along, axis, [azimuth, elevation]) in
        [("x", Vec3::X, [90.0, 0.0]), ("y", Vec3::Y, [0.0, 90.0]), ("z", Vec3::Z, [0.0, 0.0])]
    {
        let subject = subject_of(sampled(33, |p| p.dot(axis).abs() - 0.5));
        for (source, name) in SOURCES {
            let mut scene = homogeneous("cube", 1.0, Projection::Parallel);
            (scene.effect.classify, scene.effect.surface) = ("surface".into(), "normals".into());
            (scene.object.field_encoding, scene.object.inner_iso, scene.object.outer_iso) = (source, 0.0, 0.1);
            (scene.quality.pass, scene.image.size) = (Pass::March, [16, 16]);
            (scene.camera.azimuth, scene.camera.elevation, scene.camera.zoom) = (azimuth, elevation, 4.0);
            let frame = render(lab.bench.gpu, &lab.bench.library, &scene, &subject)?;
            let known = frame.pixels.iter().flat_map(|pixel| {
                let found = [0, 1, 2].map(|c| (2.0 * f64::from(pixel[c]) - f64::from(pixel[3])).abs());
                let expected = axis.to_array().map(f64::from);
                expected.into_iter().zip(found).map(|(expected, found)| (expected, found, 1e-5 + code(source)))
            });
            rows.push(Row::worst(&format!("normals along an axis, {name}"), along, known.collect::<Vec<_>>()));
        }
    }
    Ok(rows)
}

/// Case 35: what is linear stays that on grids of every side, down to two samples.
pub(super) fn thin(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let mut rows = Vec::new();
    let filter = Filter::precise(lab.bench.gpu.info().filters_by_few_bits());
    for size in [[2, 2, 2], [3, 5, 7], [2, 17, 33], [63, 64, 65], [2, 2, 200]] {
        for (source, name, bound) in
            [(FieldEncoding::Distance32, "distance32", 4e-6), (FieldEncoding::Normals16, "normals16", 4e-5)]
        {
            let found = of_linear(lab, source, size, filter, |p| 0.6 * p.x - 0.3 * p.y)?;
            let known = found.into_iter().map(|(expected, found)| (expected, found, bound));
            let sides = size.map(|side| side.to_string()).join(" x ");
            rows.push(Row::worst(&format!("linear field, {name}"), sides, known));
        }
    }
    Ok(rows)
}

/// Case 37: a scan is the same object in ångström and in light years.
pub(super) fn sizes(_: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    const SIDE: u32 = 33;
    let scan = |unit: f32, stretch: Vec3| {
        let spacing = unit * stretch * (2.5 / (SIDE - 1) as f32);
        let middle = 0.5 * (SIDE - 1) as f32;
        let places = (0..SIDE).flat_map(|k| (0..SIDE).flat_map(move |j| (0..SIDE).map(move |i| [i, j, k])));
        let values = places.map(|at| {
            let p = (UVec3::from(at).as_vec3() - middle) * (2.5 / (SIDE - 1) as f32) * stretch;
            1.0 - p.length() // at least 0 in a ball of radius 1
        });
        Shape::Volume(Volume {
            size: [SIDE; 3],
            origin: Vec3::ZERO,
            steps: Mat3::from_diagonal(spacing),
            values: values.collect(),
            content: Content::Scalar,
        })
    };
    let mut rows = Vec::new();
    for exponent in [-36, -30, -20, -10, 0, 10, 20, 30] {
        let unit = 10f32.powi(exponent);
        let request = Request { resolution: 64, margin: 0.1 * unit, band: 0.2 * unit, iso: 0.0, shell: 0.0 };
        let (field, _) = field::transform(&scan(unit, Vec3::ONE), &request, &|_| ()).map_err(RenderError::from)?;
        let inside = field.values.iter().filter(|value| **value < 0.0).count() as f64;
        let cell = (field.grid.spacing.as_dvec3() / f64::from(unit)).element_product();
        let truth = 4.0 / 3.0 * std::f64::consts::PI;
        let known = [(truth, inside * cell, 0.02 * truth)];
        rows.push(Row::worst("volume of a ball in a scan", format!("unit 1e{exponent}"), known).at(unit.into()));
        let along = field.grid.size.map(|side| side / 2);
        let (row, layer) = (along[1], along[2]);
        let known = (0..field.grid.size[0]).map(|i| {
            let p = field.grid.position(i, row, layer).as_dvec3() / f64::from(unit) - DVec3::splat(1.25);
            let found = f64::from(field.value(i, row, layer)) / f64::from(unit);
            (p.length() - 1.0, found, 0.01)
        });
        let near = known.filter(|(truth, ..)| truth.abs() < 0.19);
        rows.push(Row::worst("distances in its band", format!("unit 1e{exponent}"), near.collect::<Vec<_>>()));
    }
    for ratio in [4.0f32, 1000.0] {
        let stretch = Vec3::new(1.0, 1.0, 1.0 / ratio);
        let request = Request { resolution: 64, margin: 0.0, band: 0.2, iso: 0.0, shell: 0.0 };
        let found = field::transform(&scan(1.0, stretch), &request, &|_| ());
        // The ball goes through both ends of so short an axis: all that is near to the axis is inside.
        let row = match found {
            Ok((field, _)) => {
                let all = field.values.iter().filter(|value| value.is_finite()).count();
                Row::worst("spacing 1 to", format!("{ratio}"), [(field.values.len() as f64, all as f64, 0.0)])
            }
            Err(error) => Row::said("spacing 1 to", format!("{ratio}"), "a field", error.to_string(), false),
        };
        rows.push(row);
    }
    Ok(rows)
}
