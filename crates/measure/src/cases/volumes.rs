//! Distances interpolated between voxels, and lattice noise.

use super::analytic::Level;
use super::lab::{CaseError, Lab, PASSES, Row, Rows};
use super::rays::rays;
use super::scenes::{face, face_subject, sampled};
use glam::DVec3;
use hypertexture::render::Frame;
use hypertexture::scene::{FieldEncoding, Filter};
use std::sync::Arc;

/// A field that trilinear interpolation reproduces.
fn trilinear(p: DVec3) -> f64 {
    -0.9 + 0.2 * p.x - 0.15 * p.y + 0.1 * p.z + 0.12 * p.x * p.y - 0.1 * p.y * p.z + 0.08 * p.x * p.y * p.z
}

/// Distance to a sphere around the whole box.
fn from_inside(p: DVec3) -> f64 {
    (p - DVec3::new(0.3, -0.2, -1.6)).length() - 3.6
}

pub(super) fn fields(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    type Field = (&'static str, fn(DVec3) -> f64, &'static [u32], fn(&Level) -> f64, Option<[f64; 2]>);
    let fields: [Field; 2] = [
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
    let filters = [(Filter::Device, ""), (Filter::Exact, ", exact filter")];
    for ((what, distance, cells, bound, order), (filter, named)) in
        fields.into_iter().flat_map(|field| filters.map(|filter| (field, filter)))
    {
        // Weights of 8 bits are off by less than 1 / 128 of a cell along each axis, where distances grow by less than 1.
        let coarse = filter == Filter::Device && lab.gpu.info().filters_by_few_bits();
        let by_weights = |level: &Level| if coarse { 0.25 * level.step * 3f64.sqrt() / 128.0 } else { 0.0 };
        let order = order.filter(|_| !coarse);
        for (pass, how) in PASSES {
            let mut scene = face("field_value", pass);
            (scene.quality.filter, scene.object.field_encoding) = (filter, FieldEncoding::Distance32);
            // The whole box is inside, and distances are stored in twice that range.
            (scene.object.inner_iso, scene.object.outer_iso) = (1.0, 1.0);
            let mut subject = face_subject();
            let mut levels = Vec::new();
            for &cells in cells {
                subject.field = Some(Arc::new(sampled([cells + 1; 3], 1.0, |p| distance(p.as_dvec3()))));
                let frame = lab.render(&scene, &subject)?;
                let off = rays(&scene, &subject).into_iter().zip(&frame.pixels).map(|(ray, pixel)| {
                    let truth = 0.5 + 0.25 * distance(DVec3::new(ray.from.x, ray.from.y, 0.3));
                    (f64::from(pixel[0]) - truth).abs()
                });
                levels.push(Level::of(cells, 2.0 / f64::from(cells), off));
            }
            let bound = |level: &Level| bound(level) + by_weights(level);
            rows.push(Row::converging(format!("{what}{named}, {how}"), &levels, bound, order));
        }
    }
    Ok(())
}

pub(super) fn noise(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    for (pass, how) in PASSES {
        let mut scene = face("noise_lattice", pass);
        scene.effect.noise = "procedural".into();
        let frame = lab.render(&scene, &face_subject())?;
        let channel =
            |frame: &Frame, c: usize| frame.pixels.iter().map(|pixel| f64::from(pixel[c])).collect::<Vec<_>>();
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        let [at_points, between] = [0, 1].map(|c| channel(&frame, c));
        rows.worst(format!("noise, {how}"), "at lattice points", at_points.into_iter().map(|found| (0.0, found, 0.0)));
        // Gradients of length 1 give at most sqrt(3) / 2.
        let (least, most) = (mean(&between), between.iter().fold(0.0f64, |most, value| most.max(*value)));
        let found = format!("mean {least:.3}, largest {most:.3}");
        rows.holds(format!("noise, {how}"), "between them", "in (0, 0.8661]", found, least > 0.05 && most <= 0.8661);

        scene.effect = face("noise_period", pass).effect;
        let frame = lab.render(&scene, &face_subject())?;
        let [value, square] = [0, 1].map(|c| mean(&channel(&frame, c)));
        // 0 has no code of 16 bits: half a code of [-1, 1].
        rows.worst(format!("integral of noise, {how}"), "over periods", [(0.0, 2.0 * value - 1.0, 2e-5)]);
        rows.holds(
            format!("mean square of noise, {how}"),
            "over periods",
            "above 0.01",
            format!("{square:.3}"),
            square > 0.01,
        );
    }
    Ok(())
}
