//! Cases 32 and 33: rays that bend by little, and not at all.

use super::{Known, Lab, Row, StressError, with};
use crate::verify::{clear, fish_eye, luneburg_miss, probed, rays};
use glam::DVec3;
use hypertexture::render::variant::VariantError;
use hypertexture::render::{RenderError, Subject, render};
use hypertexture::scene::{Curve, ParameterValue, Scene, preset};

/// Case 32: lenses of known paths, by ever more steps.
pub(super) fn order(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let library = &lab.bench.library;
    let mut rows = Vec::new();
    for index in ["luneburg", "fish_eye"] {
        let mut scene = clear("sphere", &[(0.0, 1.0)], Curve::Steps);
        scene.effect.index = index.into();
        let subject = Subject::load(&scene, library, &|_| ())?;
        for samples in [3, 12, 48, 192, 768] {
            scene.quality.samples = samples;
            let found = probed(lab.bench.gpu, library, &scene, &subject)?;
            let step = 2.0 / f64::from(samples);
            let known = rays(&scene, &subject).into_iter().zip(found).filter(|(ray, _)| ray.impact() < 0.95);
            let known = known.map(|(ray, line)| {
                let miss = match index {
                    "luneburg" => luneburg_miss(ray.along, line),
                    _ => {
                        let height = (1.0 - ray.impact().powi(2)).sqrt();
                        let [along, turn] = fish_eye(DVec3::new(ray.from.x, ray.from.y, height), ray.along);
                        (along - line[0]).length().max((turn - line[1]).length())
                    }
                };
                // Of fourth order, down to rounding.
                (0.0, miss, 30.0 * step.powi(4) + 4e-6 + 2e-8 * f64::from(samples))
            });
            rows.push(Row::worst(index, format!("{samples} steps"), known.collect::<Vec<_>>()).at(samples.into()));
        }
    }
    Ok(rows)
}

/// Case 33: what bends light less and less is seen less and less; what does not bend it is not seen. The surroundings have
/// no edges, so that a turn of the light is a change of its color.
pub(super) fn to_none(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let library = lab.bench.library.clone().with_module("environment", "direction", include_str!("direction.glsl"));
    let library = &library;
    let glass = |jump: f32| -> Result<Scene, StressError> {
        let scene = preset("blue_glass").map_err(VariantError::from).map_err(RenderError::from)?;
        Ok(with(scene, |scene| {
            (scene.object.input, scene.effect.environment) = ("sphere".into(), "direction".into());
            scene.parameters.insert("tint_depth".into(), ParameterValue::Number(100.0));
            (scene.image.size, scene.quality.samples) = ([64, 64], 128);
            scene
                .transfer
                .stops
                .iter_mut()
                .for_each(|stop| stop.index = if stop.index == 1.0 { 1.0 } else { 1.0 + jump });
        }))
    };
    let none = glass(0.0)?;
    let subject = Subject::load(&none, library, &|_| ())?;
    let none = render(lab.bench.gpu, library, &none, &subject)?;
    let mut rows = Vec::new();
    for exponent in [2, 3, 4, 5, 6] {
        let jump = 10f32.powi(-exponent);
        let frame = render(lab.bench.gpu, library, &glass(jump)?, &subject)?;
        let apart = frame.pixels.as_flattened().iter().zip(none.pixels.as_flattened());
        let mean = apart.map(|(a, b)| f64::from((a - b).abs())).sum::<f64>() / none.pixels.as_flattened().len() as f64;
        // Light turns by about the jump, twice; places along a ray begin anew where it turns, and absorb a little more or less.
        let known: [Known; 1] = [(0.0, mean, 4.0 * f64::from(jump) + 5e-5)];
        rows.push(
            Row::worst("glass that all but is not there", format!("index 1 + 1e-{exponent}"), known).at(jump.into()),
        );
    }
    // Sums of directions over the shares of the light are no longer than one, total reflection or not.
    for index in [1.000_001f32, 1.3, 2.4, 4.0] {
        let mut scene = clear("cube", &[(0.0, 1.0), (0.5, index)], Curve::Steps);
        (scene.camera.azimuth, scene.camera.elevation, scene.quality.samples) = (30.0, 20.0, 64);
        let subject = Subject::load(&scene, library, &|_| ())?;
        let known = probed(lab.bench.gpu, library, &scene, &subject)?;
        let known = known.into_iter().map(|[direction, _]| (direction.length().min(1.0), direction.length(), 1e-5));
        rows.push(Row::worst("light that leaves a cube", format!("index {index}"), known.collect::<Vec<_>>()));
    }
    Ok(rows)
}
