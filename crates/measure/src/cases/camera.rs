//! Wide views, an eye inside the matter, and whole turns of the camera.

use super::closed_forms::slab;
use super::lab::{CaseError, Lab, PASSES, Rows, same};
use super::rays::{Ray, rays};
use super::scenes::{box_subject, homogeneous, sphere};
use glam::{DVec3, Vec3};
use hypertexture::render::Subject;
use hypertexture::scene::{Pass, Projection, preset};

/// A slab across the view has the path length of each ray.
pub(super) fn wide(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    const RATE: f64 = 2.0;
    let subject = box_subject(Vec3::new(1.0, 1.0, 0.5));
    let mut renderer = lab.renderer(&subject);
    for (pass, how) in PASSES {
        for degrees in [10.0f64, 45.0, 90.0, 120.0] {
            let mut scene = homogeneous("cube", RATE as f32, Projection::Perspective);
            scene.effect.dmf = vec!["pane".into()];
            scene.camera.field_of_view = degrees as f32;
            // The pane of half side 1, 0.5 thick, fills the view: closer for wider views.
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
            rows.worst(format!("pane by {how}"), format!("{degrees} degrees"), known).at(degrees);
        }
    }
    Ok(())
}

/// Length of a ray inside a box.
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

/// An eye in front of the matter, on its face, inside it and close to its middle.
pub(super) fn eye(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    const RATE: f64 = 1.0;
    let half = Vec3::new(0.8, 0.6, 0.5);
    let subject = Subject { radius: half.length(), ..box_subject(half) };
    let mut renderer = lab.renderer(&subject);
    for (pass, how) in PASSES {
        let places =
            [(0.51, "in front"), (0.5, "on a face"), (0.49, "just behind"), (0.2, "inside"), (0.06, "near the middle")];
        for (distance, place) in places {
            let mut scene = homogeneous("cube", RATE as f32, Projection::Perspective);
            let angle = 0.5 * f64::from(scene.camera.field_of_view).to_radians();
            scene.camera.zoom = (f64::from(subject.radius) / 0.8 / distance / angle.sin()) as f32;
            (scene.quality.pass, scene.quality.samples, scene.quality.early_termination) = (pass, 512, 0.0);
            let frame = renderer.render(&scene)?;
            let step = f64::from(frame.measurements.step);
            let known = rays(&scene, &subject).into_iter().zip(&frame.pixels).map(|(ray, pixel)| {
                let truth = -(-RATE * path(&ray, half.as_dvec3())).exp_m1();
                (truth, f64::from(pixel[3]), 2.0 * RATE * step * ray.slant() + 1e-5) // a step at each end
            });
            rows.worst(format!("box by {how}"), format!("eye {place}"), known);
        }
    }
    Ok(())
}

/// Whole turns of the camera change nothing.
pub(super) fn turns(lab: &Lab<'_>, rows: &mut Rows) -> Result<(), CaseError> {
    let mut scene = preset("lit")?;
    scene.object.input = "torus".into();
    (scene.image.size, scene.quality.pass) = ([64, 64], Pass::March);
    (scene.camera.azimuth, scene.camera.elevation) = (32.0, 17.0);
    let mut renderer = lab.renderer(&lab.subject(&scene)?);
    let original = renderer.render(&scene)?;
    for count in [1, 16, 1024] {
        scene.camera.azimuth = 32.0 + 360.0 * count as f32;
        let turned = renderer.render(&scene)?;
        let known = same(&original, &turned, 0.0);
        rows.worst("torus", format!("{count} turns"), known).at(count);
    }
    let mut scene = homogeneous("sphere", 3.0, Projection::Perspective);
    let mut renderer = lab.renderer(&sphere());
    let level = renderer.render(&scene)?;
    scene.camera.elevation = 90.0;
    let above = renderer.render(&scene)?;
    rows.worst("ball", "from straight above", same(&level, &above, 1e-5));
    Ok(())
}
