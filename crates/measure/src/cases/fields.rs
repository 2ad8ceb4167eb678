//! Precision of stored distances and normals, filters, grids of unusual sizes, and scans of any unit.

use super::lab::{CaseError, Lab, PASSES, Rows};
use super::rays::rays;
use super::scenes::{box_subject, face, face_subject, homogeneous, indices, sampled};
use glam::{DVec3, Mat3, UVec3, Vec3};
use hypertexture::field::{self, Request};
use hypertexture::render::{RenderError, Subject};
use hypertexture::scene::{FieldEncoding, Filter, Pass, Projection};
use hypertexture::shape::{Content, Shape, Volume};
use std::sync::Arc;

/// Encodings of a field.
const SOURCES: [(FieldEncoding, &str); 4] = [
    (FieldEncoding::Normals8, "normals8"),
    (FieldEncoding::Normals16, "normals16"),
    (FieldEncoding::Distance16, "distance16"),
    (FieldEncoding::Distance32, "distance32"),
];

/// Error of the place that a filter reads, in voxels: with weights of 8 bits, which GPUs round more than once (an NVIDIA
/// H100 is off by 1 / 192), and with floats.
const FILTERED: [f64; 2] = [1.0 / 128.0, 1.0 / 512.0];

/// A field over [-1.25, 1.25]^3.
fn subject_of(side: u32, distance: impl Fn(Vec3) -> f32) -> Subject {
    let field = sampled([side; 3], 1.25, |p| distance(p).into());
    Subject { radius: 1.0, field: Some(Arc::new(field)), ..box_subject(Vec3::ONE) }
}

/// Width of a code of a normal's component.
fn code(source: FieldEncoding) -> f64 {
    match source {
        FieldEncoding::Normals8 => 1.0 / 255.0,
        FieldEncoding::Normals16 => 1.0 / 65535.0,
        _ => 0.0,
    }
}

/// Angles between the normals of a ball of 64^3 samples and the true ones, degrees.
pub(super) fn bits(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    for (source, name) in SOURCES {
        for band in [0.1f32, 0.8] {
            let mut scene = homogeneous("sphere", 1.0, Projection::Parallel);
            (scene.effect.classify, scene.effect.surface) = ("surface".into(), "normals".into());
            (scene.object.field_encoding, scene.object.inner_iso, scene.object.outer_iso) = (source, 0.0, band);
            (scene.quality.pass, scene.quality.samples) = (Pass::March, 1024);
            let subject = subject_of(64, |p| p.length() - 1.0);
            let frame = lab.render(&scene, &subject)?;
            let mut angles = Vec::new();
            for (ray, pixel) in rays(&scene, &subject).into_iter().zip(&frame.pixels) {
                let b = ray.impact();
                if b > 0.7 {
                    continue; // along a grazing ray, a step turns the normal
                }
                let truth = DVec3::new(ray.from.x, ray.from.y, (1.0 - b * b).sqrt());
                let [x, y, z, _] = pixel.map(|value| 2.0 * f64::from(value) - 1.0);
                angles.push(DVec3::new(x, y, z).angle_between(truth).to_degrees());
            }
            let mean = angles.iter().sum::<f64>() / angles.len() as f64;
            // Interpolation and the step of the ray turn a normal by some hundredths of a degree.
            let bound = 0.02 + (1.5 * code(source)).to_degrees();
            let known = [(0.0, mean, bound)];
            rows.worst(format!("normals of a ball, {name}"), format!("band {band}"), known);
        }
    }
    Ok(())
}

/// Where a distance has no gradient, normals are unit vectors.
pub(super) fn medial(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
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
                let frame = lab.render(&scene, &subject_of(33, distance))?;
                let known = frame.pixels.iter().flat_map(|pixel| {
                    let alpha = f64::from(pixel[3]);
                    // Components of a unit vector, scaled to [0, 1] and multiplied by alpha.
                    [0, 1, 2].map(|c| (f64::from(pixel[c]).clamp(0.0, alpha), f64::from(pixel[c]), 1e-5))
                });
                rows.worst(name, format!("{stored}, {how}"), known);
            }
        }
    }
    Ok(())
}

/// Expected and found values of a linear field over [-1, 1]^3.
fn of_linear(
    lab: &Lab<'_>,
    source: FieldEncoding,
    size: [u32; 3],
    filter: Filter,
    linear: impl Fn(Vec3) -> f32,
) -> Result<Vec<(f64, f64)>, CaseError> {
    let mut scene = face("field_value", Pass::March);
    (scene.object.field_encoding, scene.quality.filter) = (source, filter);
    (scene.object.inner_iso, scene.object.outer_iso) = (1.0, 1.0);
    let field = sampled(size, 1.0, |p| linear(p).into());
    let subject = Subject { field: Some(Arc::new(field)), ..face_subject() };
    let frame = lab.render(&scene, &subject)?;
    let value = |pixel: &[f32; 4]| (f64::from(pixel[0]) - 0.5) * 4.0; // inverse of `field_value`
    let rays = rays(&scene, &subject).into_iter();
    Ok(rays.zip(&frame.pixels).map(|(ray, pixel)| (f64::from(linear(ray.from.as_vec3())), value(pixel))).collect())
}

/// Error of the place that the filter of the device reads, in voxels.
pub(super) fn filters(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    let bound = FILTERED[usize::from(!lab.gpu.info().filters_by_few_bits())];
    for side in [2, 3, 5, 9, 33] {
        for (source, name) in [(FieldEncoding::Distance32, "distance32"), (FieldEncoding::Distance16, "distance16")] {
            let voxel = 2.0 / f64::from(side - 1);
            let found = of_linear(lab, source, [side; 3], Filter::Device, |p| p.x)?;
            let known = found.into_iter().map(|(expected, found)| (0.0, (found - expected).abs() / voxel, bound));
            rows.worst(format!("filtered place, {name}"), format!("voxel of {voxel}"), known).at(voxel);
        }
    }
    Ok(())
}

/// Components of a normal that are 0, which codes of normals lack: half a code beside it.
pub(super) fn normals(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    // A plate, seen from the front.
    for (along, axis, [azimuth, elevation]) in
        [("x", Vec3::X, [90.0, 0.0]), ("y", Vec3::Y, [0.0, 90.0]), ("z", Vec3::Z, [0.0, 0.0])]
    {
        let subject = subject_of(33, |p| p.dot(axis).abs() - 0.5);
        for (source, name) in SOURCES {
            let mut scene = homogeneous("cube", 1.0, Projection::Parallel);
            (scene.effect.classify, scene.effect.surface) = ("surface".into(), "normals".into());
            (scene.object.field_encoding, scene.object.inner_iso, scene.object.outer_iso) = (source, 0.0, 0.1);
            (scene.quality.pass, scene.image.size) = (Pass::March, [16, 16]);
            (scene.camera.azimuth, scene.camera.elevation, scene.camera.zoom) = (azimuth, elevation, 4.0);
            let frame = lab.render(&scene, &subject)?;
            let known = frame.pixels.iter().flat_map(|pixel| {
                let found = [0, 1, 2].map(|c| (2.0 * f64::from(pixel[c]) - f64::from(pixel[3])).abs());
                let expected = axis.to_array().map(f64::from);
                expected.into_iter().zip(found).map(|(expected, found)| (expected, found, 1e-5 + code(source)))
            });
            rows.worst(format!("normals along an axis, {name}"), along, known);
        }
    }
    Ok(())
}

/// A linear field stays linear on grids of any size, down to two samples.
pub(super) fn thin(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    let filter = Filter::precise(lab.gpu.info().filters_by_few_bits());
    for size in [[2, 2, 2], [3, 5, 7], [2, 17, 33], [63, 64, 65], [2, 2, 200]] {
        for (source, name, bound) in
            [(FieldEncoding::Distance32, "distance32", 4e-6), (FieldEncoding::Normals16, "normals16", 4e-5)]
        {
            let found = of_linear(lab, source, size, filter, |p| 0.6 * p.x - 0.3 * p.y)?;
            let known = found.into_iter().map(|(expected, found)| (expected, found, bound));
            let sides = size.map(|side| side.to_string()).join(" x ");
            rows.worst(format!("linear field, {name}"), sides, known);
        }
    }
    Ok(())
}

/// The unit of a scan does not change the object.
pub(super) fn sizes(_: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    const SIDE: u32 = 33;
    let scan = |unit: f32, stretch: Vec3| {
        let spacing = unit * stretch * (2.5 / (SIDE - 1) as f32);
        let middle = 0.5 * (SIDE - 1) as f32;
        let values = indices([SIDE; 3]).map(|at| {
            let p = (UVec3::from(at).as_vec3() - middle) * (2.5 / (SIDE - 1) as f32) * stretch;
            1.0 - p.length() // positive in a ball of radius 1
        });
        Shape::Volume(Volume {
            size: [SIDE; 3],
            origin: Vec3::ZERO,
            steps: Mat3::from_diagonal(spacing),
            values: values.collect(),
            content: Content::Scalar,
        })
    };
    for exponent in [-36, -30, -20, -10, 0, 10, 20, 30] {
        let unit = 10f32.powi(exponent);
        let request = Request { resolution: 64, margin: 0.1 * unit, band: 0.2 * unit, iso: 0.0, shell: 0.0 };
        let (field, _) = field::transform(&scan(unit, Vec3::ONE), &request, &|_| ()).map_err(RenderError::from)?;
        let inside = field.values.iter().filter(|value| **value < 0.0).count() as f64;
        let cell = (field.grid.spacing.as_dvec3() / f64::from(unit)).element_product();
        let truth = 4.0 / 3.0 * std::f64::consts::PI;
        let known = [(truth, inside * cell, 0.02 * truth)];
        rows.worst("volume of a ball in a scan", format!("unit 1e{exponent}"), known).at(unit);
        let along = field.grid.size.map(|side| side / 2);
        let (row, layer) = (along[1], along[2]);
        let known = (0..field.grid.size[0]).map(|i| {
            let p = field.grid.position(i, row, layer).as_dvec3() / f64::from(unit) - DVec3::splat(1.25);
            let found = f64::from(field.value(i, row, layer)) / f64::from(unit);
            (p.length() - 1.0, found, 0.01)
        });
        let near = known.filter(|(truth, ..)| truth.abs() < 0.19);
        rows.worst("distances within the band", format!("unit 1e{exponent}"), near);
    }
    for ratio in [4.0f32, 1000.0] {
        let stretch = Vec3::new(1.0, 1.0, 1.0 / ratio);
        let request = Request { resolution: 64, margin: 0.0, band: 0.2, iso: 0.0, shell: 0.0 };
        let found = field::transform(&scan(1.0, stretch), &request, &|_| ());
        match found {
            Ok((field, _)) => {
                let finite = field.values.iter().filter(|value| value.is_finite()).count();
                rows.worst("spacing 1 to", format!("{ratio}"), [(field.values.len() as f64, finite as f64, 0.0)]);
            }
            Err(error) => rows.holds("spacing 1 to", format!("{ratio}"), "a field", error.to_string(), false),
        }
    }
    Ok(())
}
