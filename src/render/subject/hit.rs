//! Rays against the surface of an object, on the CPU.

use super::load::Subject;
use crate::shape::{self, Shape};
use glam::Vec3;

/// Share of a distance that a step goes. Higher: a ray steps through thin parts of sampled fields.
const CAUTION: f32 = 0.9;
const STEPS: usize = 512;

impl Subject {
    /// A function of the signed distance to the surface, object space; `None` for a custom formula.
    pub fn distance(&self) -> Option<Box<dyn Fn(Vec3) -> f32 + '_>> {
        if let Some(field) = &self.field {
            return Some(Box::new(|x| field.sample(self.center + x / self.scale) * self.scale));
        }
        match shape::open(&self.input) {
            Ok(Shape::Solid(solid)) => Some(Box::new(move |x| solid.distance(x))),
            _ => None,
        }
    }

    /// A function of the unit normal of the surface nearest to a place, object space, from differences over a voxel to each
    /// side; up where they vanish. `None` for a custom formula.
    pub fn normal(&self) -> Option<impl Fn(Vec3) -> Vec3 + '_> {
        let (distance, voxel) = (self.distance()?, self.voxel());
        Some(move |x| {
            let slope = |axis: Vec3| distance(x + voxel * axis) - distance(x - voxel * axis);
            Vec3::new(slope(Vec3::X), slope(Vec3::Y), slope(Vec3::Z)).normalize_or(Vec3::Y)
        })
    }

    fn voxel(&self) -> f32 {
        self.field.as_ref().map_or(1e-3, |field| field.grid.spacing.max_element() * self.scale)
    }

    /// Place and unit normal of the surface that a ray meets first: from a place in a unit direction of object space.
    pub fn hit(&self, from: Vec3, along: Vec3) -> Option<(Vec3, Vec3)> {
        let (distance, reach) = (self.distance()?, 1.05 * self.radius + 0.01);
        let voxel = self.voxel();
        // The part of the ray within the ball around the object.
        let middle = -from.dot(along);
        let half = reach * reach - (from + middle * along).length_squared();
        if half <= 0.0 {
            return None;
        }
        let (mut at, end) = ((middle - half.sqrt()).max(0.0), middle + half.sqrt());
        for _ in 0..STEPS {
            let place = from + at * along;
            let left = distance(place);
            if left <= 0.1 * voxel {
                let slope = |axis: Vec3| distance(place + voxel * axis) - distance(place - voxel * axis);
                let normal = Vec3::new(slope(Vec3::X), slope(Vec3::Y), slope(Vec3::Z)).normalize_or(-along);
                return Some((place, normal));
            }
            at += CAUTION * left.max(0.1 * voxel);
            if at > end {
                return None;
            }
        }
        None
    }

    /// Whether another subject has the same object, but for its groom.
    pub fn is_same_object(&self, other: &Subject) -> bool {
        let same = match (&self.field, &other.field) {
            (Some(own), Some(field)) => std::sync::Arc::ptr_eq(own, field),
            (own, field) => own.is_none() && field.is_none() && self.input == other.input,
        };
        same && self.closest.is_some() == other.closest.is_some() && self.parts.is_empty() && other.parts.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{scene::preset, shader};

    #[test]
    fn a_ray_hits_the_nearest_surface_of_formula_and_field() {
        for encoding in ["auto", "distance32"] {
            let mut scene = preset("lit").unwrap();
            scene.object.input = "torus".into();
            scene.set_field("object.field_encoding", &format!("{encoding:?}")).unwrap();
            let subject = Subject::load(&scene, &shader::shipped(), &|_| ()).unwrap();
            // Along x through a tube whose radius is 0.3, in a ring of radius 0.7; a hit is a tenth of a voxel above it.
            let (place, normal) = subject.hit(Vec3::new(3.0, 0.0, 0.0), Vec3::NEG_X).unwrap();
            assert!(place.distance(Vec3::X) < 1e-2 && normal.distance(Vec3::X) < 1e-2, "{encoding}: {place} {normal}");
            let inside = subject.hit(Vec3::new(0.0, 3.0, 0.0), Vec3::NEG_Y);
            assert_eq!(inside, None, "{encoding}: through the hole");
        }
    }
}
