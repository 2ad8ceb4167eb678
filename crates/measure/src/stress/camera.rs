//! Cases 16, 18 and 39: views as wide as they may be, an eye that is in the matter, and a camera that was turned often.

use super::matter::{PASSES, same, sphere};
use super::{Lab, Row, StressError, with};
use crate::verify::{Ray, box_subject, homogeneous, rays, slab};
use glam::{DVec3, Vec3};
use hypertexture::render::{Renderer, Subject};
use hypertexture::scene::{Pass, Projection, preset};

/// Case 16: a slab that fills the view has the path of each ray, not that of the middle one.
pub(super) fn wide(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    const RATE: f64 = 2.0;
    let subject = box_subject(Vec3::new(1.0, 1.0, 0.5));
    let mut renderer = Renderer::new(lab.bench.gpu, &lab.bench.library, &subject);
    let mut rows = Vec::new();
    for (pass, how) in PASSES {
        for degrees in [10.0f64, 45.0, 90.0, 120.0] {
            let mut scene = homogeneous("cube", RATE as f32, Projection::Perspective);
            scene.effect.dmf = vec!["pane".into()];
            scene.camera.field_of_view = degrees as f32;
            // The whole view ends on the pane of half side 1 that is 0.5 thick: nearer for wider ones.
            let half = (0.5 * degrees).to_radians();
            let distance = 0.25 + 0.3 / half.tan().max(0.3);
            scene.camera.zoom = (1.5 / 0.8 / distance / half.sin()) as f32;
            (scene.quality.pass, scene.quality.samples) = (pass, 384);
            let frame = renderer.render(&scene)?;
            let known = rays(&scene, &subject).into_iter().zip(&frame.pixels).filter_map(|(ray, pixel)| {
                let hits = [-0.25, 0.25].iter().all(|z| ray.at(*z).truncate().abs().max_element() < 0.99);
                let outside = ray.from.z > 0.26;
                (hits && outside).then(|| (slab(RATE, RATE, 0.5 * ray.slant()), f64::from(pixel[3]), 4e-5))
            });
            let known: Vec<_> = known.collect();
            rows.push(Row::worst(&format!("pane by {how}"), format!("{degrees} degrees"), known).at(degrees));
        }
    }
    Ok(rows)
}

/// How long a ray is in a box, from its own beginning on.
fn path(ray: &Ray, half: DVec3) -> f64 {
    let (mut enter, mut leave) = (0.0f64, f64::INFINITY);
    for axis in 0..3 {
        let (from, along) = (ray.from[axis], ray.along[axis]);
        if along == 0.0 {
            leave = if from.abs() > half[axis] { f64::NEG_INFINITY } else { leave };
            continue;
        }
        let ends = [(-half[axis] - from) / along, (half[axis] - from) / along];
        enter = enter.max(ends[0].min(ends[1]));
        leave = leave.min(ends[0].max(ends[1]));
    }
    (leave - enter).max(0.0)
}

/// Case 18: an eye before the matter, on its face, in it, and all but in its middle.
pub(super) fn eye(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    const RATE: f64 = 1.0;
    let half = Vec3::new(0.8, 0.6, 0.5);
    let subject = Subject { radius: half.length(), ..box_subject(half) };
    let mut renderer = Renderer::new(lab.bench.gpu, &lab.bench.library, &subject);
    let mut rows = Vec::new();
    for (pass, how) in PASSES {
        for (distance, told) in [
            (0.51, "just before"),
            (0.5, "on a face"),
            (0.49, "just behind"),
            (0.2, "within"),
            (0.06, "near the middle"),
        ] {
            let mut scene = homogeneous("cube", RATE as f32, Projection::Perspective);
            let angle = 0.5 * f64::from(scene.camera.field_of_view).to_radians();
            scene.camera.zoom = (f64::from(subject.radius) / 0.8 / distance / angle.sin()) as f32;
            (scene.quality.pass, scene.quality.samples, scene.quality.early_termination) = (pass, 512, 0.0);
            let frame = renderer.render(&scene)?;
            let step = f64::from(frame.measurements.step);
            let known = rays(&scene, &subject).into_iter().zip(&frame.pixels).map(|(ray, pixel)| {
                let truth = -(-RATE * path(&ray, half.as_dvec3())).exp_m1();
                // A step at each end.
                (truth, f64::from(pixel[3]), 2.0 * RATE * step * ray.slant() + 1e-5)
            });
            rows.push(Row::worst(&format!("box by {how}"), format!("eye {told}"), known.collect::<Vec<_>>()));
        }
    }
    Ok(rows)
}

/// Case 39: whole turns of the camera change nothing.
pub(super) fn turns(lab: &Lab<'_>) -> Result<Vec<Row>, StressError> {
    let scene = with(
        preset("lit")
            .map_err(hypertexture::render::variant::VariantError::from)
            .map_err(hypertexture::render::RenderError::from)?,
        |scene| {
            scene.object.input = "torus".into();
            (scene.image.size, scene.quality.pass) = ([64, 64], Pass::March);
            (scene.camera.azimuth, scene.camera.elevation) = (32.0, 17.0);
        },
    );
    let subject = Subject { input: "torus".into(), ..Subject::load(&scene, &lab.bench.library, &|_| ())? };
    let mut renderer = Renderer::new(lab.bench.gpu, &lab.bench.library, &subject);
    let own = renderer.render(&scene)?;
    let mut rows = Vec::new();
    for count in [1, 16, 1024] {
        let turned = with(scene.clone(), |scene| scene.camera.azimuth += 360.0 * count as f32);
        let known = same(&own, &renderer.render(&turned)?, 0.0);
        rows.push(Row::worst("torus", format!("{count} turns"), known).at(count.into()));
    }
    let ball = sphere();
    let above = with(homogeneous("sphere", 3.0, Projection::Perspective), |scene| scene.camera.elevation = 90.0);
    let level = homogeneous("sphere", 3.0, Projection::Perspective);
    let mut renderer = Renderer::new(lab.bench.gpu, &lab.bench.library, &ball);
    let (above, level) = (renderer.render(&above)?, renderer.render(&level)?);
    rows.push(Row::worst("ball", "from straight above", same(&level, &above, 1e-5)));
    Ok(rows)
}
