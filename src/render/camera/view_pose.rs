//! Where a picture is looked at from, so that what is seen can be moved before there is a new picture.
//!
//! Role: two cameras -> where in the picture of one is what the other shows. What is seen is taken for a ball as large as the
//! object, and what is beside it stands upright in the plane through its middle: right at its middle, and nearly so as long
//! as little has turned.

use super::view::View;
use crate::render::subject::Subject;
use crate::render::variant::Variant;
use crate::scene::{Projection, Scene};
use glam::{Mat4, Vec2, Vec3};

/// From here on, in radii of the ball, what is seen does not turn with it; up to the ball it turns less and less.
const STANDS_FROM: f32 = 1.3;
/// How far the ball stands out, in parts of a ball's: objects are thinner than that.
const RELIEF: f32 = 0.8;

/// Where a picture of a scene is looked at from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewPose {
    /// From object space to that of the eye.
    object_matrix: Mat4,
    /// Depth of its middle.
    distance: f32,
    /// Radius of the ball that it is taken for.
    radius: f32,
    ray_scale: Vec2,
    pan: Vec2,
    is_parallel: bool,
}

impl ViewPose {
    /// That of a scene; `variant` is its program.
    pub fn of(scene: &Scene, subject: &Subject, variant: &Variant) -> ViewPose {
        let view = View::of(scene, subject, variant);
        ViewPose {
            object_matrix: view.object_matrix,
            distance: view.extent.distance,
            radius: view.shown_radius,
            ray_scale: view.ray_scale.into(),
            pan: view.pan.into(),
            is_parallel: scene.camera.projection == Projection::Parallel,
        }
    }

    /// Where what is at a place of this picture is in the picture of another sight. Places are from -1 to 1, to the right
    /// and down.
    pub fn reproject(&self, to: &ViewPose, at: [f32; 2]) -> [f32; 2] {
        let flat = (Vec2::from(at) - self.pan) * self.ray_scale * self.depth(0.0) * Vec2::new(1.0, -1.0);
        let from_middle = flat.length() / self.radius;
        let turns = ((STANDS_FROM - from_middle) / (STANDS_FROM - 1.0)).clamp(0.0, 1.0);
        let relief = RELIEF * self.radius * (1.0 - from_middle * from_middle).max(0.0).sqrt();
        let near = (flat * self.depth(relief) / self.depth(0.0)).extend(relief - self.distance);
        let turned = to.object_matrix.transform_point3(self.object_matrix.inverse().transform_point3(near));
        let [stands, turned] = [near + Vec3::Z * self.distance, turned + Vec3::Z * to.distance];
        let seen = stands.lerp(turned, turns);
        let scale = to.ray_scale * to.depth(seen.z.min(0.9 * to.distance)) * Vec2::new(1.0, -1.0);
        (seen.truncate() / scale + to.pan).into()
    }

    /// By how much a place of the picture goes into the width at this depth, from the middle toward the eye.
    fn depth(&self, toward: f32) -> f32 {
        if self.is_parallel { 1.0 } else { self.distance - toward }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::preset;
    use crate::shader;

    fn sight(change: impl Fn(&mut Scene)) -> (ViewPose, View) {
        let library = shader::shipped();
        let mut scene = preset("lit").unwrap();
        scene.object.input = "sphere".into();
        change(&mut scene);
        let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
        let variant = Variant::of(&scene, &library).unwrap();
        (ViewPose::of(&scene, &subject, &variant), View::of(&scene, &subject, &variant))
    }

    /// Where a point of object space is in a picture, by the projection that it is rendered with.
    fn rendered(view: &View, point: Vec3) -> Vec2 {
        let clip = view.projection * view.object_matrix * point.extend(1.0);
        Vec2::new(clip.x, clip.y) / clip.w + Vec2::from(view.pan)
    }

    #[test]
    fn b1_pan_zoom_and_the_shape_of_the_window_move_the_middle_plane_as_the_camera_does() {
        for projection in [Projection::Perspective, Projection::Parallel] {
            let still = |scene: &mut Scene| (scene.image.size, scene.camera.projection) = ([400, 300], projection);
            let (from, old) = sight(still);
            let (to, new) = sight(|scene| {
                still(scene);
                (scene.camera.pan, scene.camera.zoom, scene.image.size) = ([0.3, -0.2], 1.7, [300, 350]);
            });
            for place in [Vec3::new(0.9, 0.6, 0.0), Vec3::new(-0.2, 1.4, 0.0), Vec3::new(1.6, -0.1, 0.0)] {
                // Points that stand in the plane through the middle, whichever way the object is turned, and no relief.
                let [a, b] = [&old, &new].map(|view| {
                    let eye = view.object_matrix.transform_point3(Vec3::ZERO) + place;
                    let clip = view.projection * eye.extend(1.0);
                    Vec2::new(clip.x, clip.y) / clip.w + Vec2::from(view.pan)
                });
                let moved = Vec2::from(from.reproject(&to, a.into()));
                let off = moved.distance(b);
                let inside = place.length() < 1.0; // the relief there is nearer to the eye
                assert!(off < if inside { 0.2 } else { 1e-3 }, "{projection:?} {place}: {moved} for {b}");
            }
            let there_and_back = to.reproject(&from, from.reproject(&to, [0.1, 0.2]));
            assert!(Vec2::from(there_and_back).distance(Vec2::new(0.1, 0.2)) < 0.02, "{there_and_back:?}");
            assert!(Vec2::from(from.reproject(&from, [0.4, -0.3])).distance(Vec2::new(0.4, -0.3)) < 1e-4);
        }
    }

    #[test]
    fn b1_what_is_seen_of_a_ball_turns_with_it() {
        let turn = |azimuth: f32| {
            sight(move |scene| {
                (scene.image.size, scene.camera.azimuth, scene.camera.elevation) = ([300; 2], azimuth, 0.0)
            })
        };
        let ((from, old), (to, new)) = (turn(0.0), turn(8.0));
        for point in [Vec3::Z, Vec3::new(0.5, 0.3, 0.8), Vec3::new(-0.4, -0.6, 0.68)] {
            let (a, b) = (rendered(&old, point), rendered(&new, point));
            let moved = Vec2::from(from.reproject(&to, a.into()));
            assert!(moved.distance(b) < 0.5 * a.distance(b), "{point}: {a} is at {b}, not {moved}");
        }
    }
}
