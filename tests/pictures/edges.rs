//! Outlines of hard matter against closed forms: a ray that cuts off less of an edge than a step meets it all the same.

use crate::common::{homogeneous, picture, rays, subject, with_gpu};
use glam::{DMat3, DVec3};
use hypertexture::render::Subject;
use hypertexture::scene::{Integration, Part, Pass, Projection, Scene};
use hypertexture::shader;
use hypertexture_measure::cases::Ray;

/// Few samples of a picture in which no edge is parallel to an axis of it.
fn coarse(object: &str, projection: Projection, samples: u32) -> Scene {
    let mut scene = homogeneous(object, 1.0, projection);
    let effect = &mut scene.effect;
    (effect.classify, effect.softness, effect.opacity) = ("surface".into(), "hard".into(), "perlin".into());
    (scene.camera.azimuth, scene.camera.elevation) = (33.0, 21.0);
    (scene.image.size, scene.quality.samples) = ([96, 96], samples);
    scene
}

/// The same as one of two objects, of which the other is hidden in it.
fn with_a_kernel(scene: &Scene) -> Scene {
    let mut two = scene.clone();
    let mut kernel = Part { object: scene.object.clone(), effect: scene.effect.clone(), ..Part::default() };
    kernel.transform.scale = 0.2;
    two.parts.insert("kernel".into(), kernel);
    two.combine = Some("main | kernel".into());
    two
}

/// How much of a ray is in the object, and whether it passes by at a distance.
fn crossing(object: &str, ray: &Ray) -> (f64, bool) {
    if object == "sphere" {
        let b = ray.impact();
        return (2.0 * (1.0 - b * b).max(0.0).sqrt(), b > 1.0001);
    }
    let chord = |half: f64| {
        let (a, c) = ((DVec3::splat(-half) - ray.from) / ray.along, (DVec3::splat(half) - ray.from) / ray.along);
        a.max(c).min_element() - a.min(c).max_element()
    };
    (chord(1.0).max(0.0), chord(1.0001) < 0.0)
}

/// The rays of a picture, in object space.
fn object_rays(scene: &Scene, subject: &Subject) -> impl Iterator<Item = Ray> {
    let [azimuth, elevation] =
        [scene.camera.azimuth, scene.camera.elevation].map(|angle| f64::from(angle).to_radians());
    let object = (DMat3::from_rotation_x(elevation) * DMat3::from_rotation_y(-azimuth)).transpose();
    rays(scene, subject).into_iter().map(move |ray| Ray { from: object * ray.from, along: object * ray.along })
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn m30_no_edge_is_cut_off_between_two_samples() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        for (object, samples) in [("sphere", 12), ("cube", 12), ("cube", 31), ("sphere", 20)] {
            for (projection, pass) in [(Projection::Parallel, Pass::March), (Projection::Perspective, Pass::Slices)] {
                let mut points = coarse(object, projection, samples);
                points.quality.pass = pass;
                let mut segments = points.clone();
                segments.quality.integration = Integration::Segment;
                for scene in [&points, &segments, &with_a_kernel(&points)] {
                    let subject = subject(scene, &library);
                    let frame = picture(gpu, &library, scene, &subject);
                    let step = 2.0 * 3.0_f64.sqrt() / f64::from(samples);
                    let (mut short, mut wrong) = (0, Vec::new());
                    for (ray, pixel) in object_rays(scene, &subject).zip(&frame.pixels) {
                        let (chord, is_apart) = crossing(object, &ray);
                        short += u32::from(chord > 0.0 && chord < step);
                        let expected = if chord > 0.01 * step { 1.0 } else { 0.0 };
                        if (expected == 1.0 || is_apart) && pixel[3] != expected {
                            wrong.push((chord / step, pixel[3]));
                        }
                    }
                    let name = (scene.quality.integration, scene.parts.len());
                    println!("{object} {samples} {pass:?} {name:?}: {short} shorter than a step, wrong {wrong:?}");
                    assert!(short > 20 && wrong.is_empty());
                }
            }
        }
    });
}
