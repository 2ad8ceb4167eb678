//! Reprojection of a picture to another camera, until the new picture is rendered.
//!
//! The visible part is approximated by a ball as large as the object; anything beside the ball stands upright in the
//! plane through its middle. Exact at the middle, and nearly so after a small turn.

use super::view::View;
use crate::render::subject::Subject;
use crate::render::variant::Variant;
use crate::scene::Projection;
use glam::{Mat4, Vec2, Vec3};

/// Distance from the middle, in radii of the ball, at which points stop turning with the ball. Between 1 and this the
/// turn fades.
const STANDS_FROM: f32 = 1.3;
/// Depth of the relief relative to a ball; objects are flatter.
const RELIEF: f32 = 0.8;

/// Camera pose of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ViewPose {
    /// From object space to eye space.
    object_matrix: Mat4,
    /// The middle of the scene in eye space.
    center_eye: Vec3,
    /// Depth of the middle of the scene.
    distance: f32,
    /// Radius of the approximating ball.
    radius: f32,
    ray_scale: Vec2,
    pan: Vec2,
    is_parallel: bool,
}

impl ViewPose {
    /// Pose of a scene.
    pub fn of(variant: &Variant, subject: &Subject) -> ViewPose {
        let view = View::of(variant, subject);
        ViewPose {
            object_matrix: view.object_matrix,
            center_eye: view.center_eye,
            distance: view.extent.distance,
            radius: view.shown_radius,
            ray_scale: view.ray_scale.into(),
            pan: view.pan.into(),
            is_parallel: variant.scene.projection() == Projection::Parallel,
        }
    }

    /// Maps a place in this picture to its place in the picture of another pose. Places are in [-1, 1], to the right
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

    /// The ray through a place of the picture, in object space: where it begins, and its unit direction.
    pub fn ray(&self, at: [f32; 2]) -> (Vec3, Vec3) {
        let across = ((Vec2::from(at) - self.pan) * self.ray_scale * Vec2::new(1.0, -1.0)).extend(0.0);
        let [from, to] = if self.is_parallel { [across, across - Vec3::Z] } else { [Vec3::ZERO, across - Vec3::Z] };
        let [from, to] = [from, to].map(|end| self.object_matrix.inverse().transform_point3(end));
        (from, (to - from).normalize())
    }

    /// The place of a point of object space in the picture.
    pub fn place(&self, point: Vec3) -> [f32; 2] {
        self.place_of(self.object_matrix.transform_point3(point))
    }

    /// The place of a point given like the light, from the middle of the scene: right, up, toward the eye. `None` behind the
    /// eye.
    pub fn place_in_view(&self, point: Vec3) -> Option<[f32; 2]> {
        let eye = self.center_eye + point;
        (self.is_parallel || eye.z < 0.0).then(|| self.place_of(eye))
    }

    fn place_of(&self, eye: Vec3) -> [f32; 2] {
        let depth = if self.is_parallel { 1.0 } else { -eye.z };
        (eye.truncate() / (self.ray_scale * depth) * Vec2::new(1.0, -1.0) + self.pan).into()
    }

    /// Scale from places of the picture to lengths, at a distance `toward` the eye from the middle.
    fn depth(&self, toward: f32) -> f32 {
        if self.is_parallel { 1.0 } else { self.distance - toward }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Scene, preset};
    use crate::shader;

    fn sight(change: impl Fn(&mut Scene)) -> (ViewPose, View) {
        let library = shader::shipped();
        let mut scene = preset("lit").unwrap();
        scene.object.input = "sphere".into();
        change(&mut scene);
        let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
        let variant = Variant::of(&scene, &library).unwrap();
        (ViewPose::of(&variant, &subject), View::of(&variant, &subject))
    }

    /// Place of an object-space point in a picture, by the projection of the renderer.
    fn rendered(view: &View, point: Vec3) -> Vec2 {
        let clip = view.projection * view.object_matrix * point.extend(1.0);
        Vec2::new(clip.x, clip.y) / clip.w + Vec2::from(view.pan)
    }

    #[test]
    fn b1_pan_zoom_and_aspect_move_the_middle_plane() {
        for projection in [Projection::Perspective, Projection::Parallel] {
            let still = |scene: &mut Scene| (scene.image.size, scene.camera.projection) = ([400, 300], projection);
            let (from, old) = sight(still);
            let (to, new) = sight(|scene| {
                still(scene);
                (scene.camera.pan, scene.camera.zoom, scene.image.size) = ([0.3, -0.2], 1.7, [300, 350]);
            });
            for place in [Vec3::new(0.9, 0.6, 0.0), Vec3::new(-0.2, 1.4, 0.0), Vec3::new(1.6, -0.1, 0.0)] {
                // Points of the upright plane through the middle, whatever the turn of the object; without relief.
                let [a, b] = [&old, &new].map(|view| {
                    let eye = view.object_matrix.transform_point3(Vec3::ZERO) + place;
                    let clip = view.projection * eye.extend(1.0);
                    Vec2::new(clip.x, clip.y) / clip.w + Vec2::from(view.pan)
                });
                let moved = Vec2::from(from.reproject(&to, a.into()));
                let off = moved.distance(b);
                let inside = place.length() < 1.0; // the relief inside is nearer to the eye
                assert!(off < if inside { 0.2 } else { 1e-3 }, "{projection:?} {place}: {moved} for {b}");
            }
            let there_and_back = to.reproject(&from, from.reproject(&to, [0.1, 0.2]));
            assert!(Vec2::from(there_and_back).distance(Vec2::new(0.1, 0.2)) < 0.02, "{there_and_back:?}");
            assert!(Vec2::from(from.reproject(&from, [0.4, -0.3])).distance(Vec2::new(0.4, -0.3)) < 1e-4);
        }
    }

    #[test]
    fn a_ray_goes_through_the_points_that_are_drawn_at_its_place() {
        for projection in [Projection::Perspective, Projection::Parallel] {
            let (pose, view) = sight(|scene| {
                (scene.image.size, scene.camera.projection) = ([400, 300], projection);
                (scene.camera.pan, scene.camera.azimuth, scene.camera.zoom) = ([0.3, -0.2], 40.0, 1.3);
            });
            for point in [Vec3::new(0.3, 0.5, -0.2), Vec3::new(-0.8, 0.1, 0.6)] {
                let place = pose.place(point);
                assert!(Vec2::from(place).distance(rendered(&view, point)) < 1e-5, "{projection:?} {point}");
                let (from, along) = pose.ray(place);
                assert!((point - from).cross(along).length() < 1e-4, "{projection:?} {point}");
                let seen = view.object_matrix.transform_point3(point) - view.center_eye;
                assert_eq!(pose.place_in_view(seen), Some(place));
            }
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
