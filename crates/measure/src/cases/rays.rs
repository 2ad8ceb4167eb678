//! Rays of a picture, computed from the camera of its scene alone.

use glam::DVec3;
use hypertexture::render::Subject;
use hypertexture::scene::{Projection, Scene};

/// Share of the picture's height that the object fills at zoom 1, and the most with its soft region.
const FILL: [f64; 2] = [0.8, 0.97];

/// Ray through the center of a pixel, in object space at azimuth 0 and elevation 0.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// The camera; in parallel projection the intersection with the plane z = 0.
    pub from: DVec3,
    /// Unit vector.
    pub along: DVec3,
}

impl Ray {
    /// Distance from the origin.
    pub fn impact(&self) -> f64 {
        self.from.cross(self.along).length()
    }

    /// Path length over depth.
    pub fn slant(&self) -> f64 {
        -1.0 / self.along.z
    }

    /// Intersection with a plane of constant z.
    pub fn at(&self, z: f64) -> DVec3 {
        self.from + self.along * ((z - self.from.z) / self.along.z)
    }
}

/// Rays of a picture, in the order of its pixels. No module may widen the soft region of the scene.
pub fn rays(scene: &Scene, subject: &Subject) -> Vec<Ray> {
    let camera = &scene.camera;
    let [width, height] = scene.image.size.map(f64::from);
    let (aspect, fit) = (width / height, (width / height).min(1.0));
    let radius = f64::from(subject.radius);
    let outer = if scene.effect.softness == "hard" { scene.object.inner_iso } else { scene.object.outer_iso };
    let soft = f64::from(outer).max(0.0);
    let half_height = (radius / FILL[0]).max((radius + soft) / FILL[1]) / f64::from(camera.zoom) / fit;
    let half_angle = 0.5 * f64::from(camera.field_of_view).to_radians();
    let pixel = |index: u32| {
        let [columns, _] = scene.image.size;
        let x = 2.0 * (f64::from(index % columns) + 0.5) / width - 1.0;
        let y = 1.0 - 2.0 * (f64::from(index / columns) + 0.5) / height;
        match camera.projection {
            Projection::Parallel => {
                Ray { from: DVec3::new(x * aspect * half_height, y * half_height, 0.0), along: DVec3::NEG_Z }
            }
            Projection::Perspective => {
                let along = DVec3::new(x * aspect * half_angle.tan(), y * half_angle.tan(), -1.0).normalize();
                Ray { from: DVec3::new(0.0, 0.0, half_height / half_angle.sin()), along }
            }
        }
    };
    (0..scene.image.size[0] * scene.image.size[1]).map(pixel).collect()
}
