//! The virtual trackball.
//!
//! Source: Bell's trackball, after Chen, Mountford and Sellen 1988: a sphere and a hyperbolic sheet around it, so
//! that the motion has no edge. Invariant: the rotation is normalized after each drag, to the last bits of f64.

use glam::{DQuat, DVec3};
use hypertexture::scene::Camera;

/// A rotation from object space to camera space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trackball {
    turn: DQuat,
}

impl Trackball {
    /// The rotation of a camera.
    pub fn of(camera: &Camera) -> Trackball {
        Trackball { turn: camera.turn().as_dquat().normalize() }
    }

    /// Takes the rotation of a camera, unless that is this one rounded to f32.
    pub fn follow(&mut self, camera: &Camera) {
        if camera.rotation != Some(self.rotation()) {
            *self = Trackball::of(camera);
        }
    }

    /// The rotation for [`Camera::rotation`].
    pub fn rotation(&self) -> [f32; 4] {
        self.turn.as_quat().to_array()
    }

    /// Drags the ball between two positions, right and up from the center in units of its radius. Returns axis and
    /// angle of the rotation, radians.
    pub fn drag(&mut self, from: [f64; 2], to: [f64; 2]) -> (DVec3, f64) {
        let arc = DQuat::from_rotation_arc(on_ball(from), on_ball(to));
        let (axis, angle) = arc.to_axis_angle();
        self.turn = (arc * self.turn).normalize();
        (axis, angle)
    }

    /// Rotates by an angle in radians around a unit axis in eye space.
    pub fn spin(&mut self, axis: DVec3, angle: f64) {
        self.turn = (DQuat::from_axis_angle(axis, angle) * self.turn).normalize();
    }
}

/// Azimuth and elevation of a camera with any roll, degrees: -180 to 180 and -90 to 90.
pub(crate) fn level_angles(camera: &Camera) -> [f32; 2] {
    if camera.rotation.is_none() {
        return [camera.azimuth, camera.elevation];
    }
    let from = camera.turn().as_dquat().inverse() * DVec3::Z;
    // The azimuth of a vertical view is arbitrary.
    let azimuth = if from.x.hypot(from.z) < 1e-6 { camera.azimuth } else { from.x.atan2(from.z).to_degrees() as f32 };
    [azimuth, from.y.clamp(-1.0, 1.0).asin().to_degrees() as f32]
}

/// A level orbit by a drag right and down, in fractions of half a turn: the vertical axis stays upright.
pub(crate) fn orbit(camera: &Camera, [right, down]: [f32; 2]) -> Camera {
    let [azimuth, elevation] = level_angles(camera);
    let azimuth = (azimuth - 180.0 * right + 180.0).rem_euclid(360.0) - 180.0;
    let elevation = (elevation + 180.0 * down).clamp(-90.0, 90.0);
    Camera { azimuth, elevation, rotation: None, ..camera.clone() }
}

/// The position of a light after a drag over the ball; right, up and toward the camera.
pub(crate) fn drag_light(position: [f32; 3], from: [f64; 2], to: [f64; 2]) -> [f32; 3] {
    let arc = DQuat::from_rotation_arc(on_ball(from), on_ball(to));
    (arc * DVec3::from(position.map(f64::from))).as_vec3().to_array()
}

/// Zooms by a factor towards a point, which stays in place. `at` is the point right and up from the center, in units
/// of half the height of the picture; `half` is that height in object units.
pub(crate) fn zoom_to(camera: &Camera, factor: f32, at: [f32; 2], half: f32) -> Camera {
    let zoom = (camera.zoom * factor).clamp(0.02, 100.0);
    let moved = half * (camera.zoom / zoom - 1.0);
    let pan = [0, 1].map(|axis| (camera.pan[axis] + at[axis] * moved).clamp(-100.0, 100.0));
    Camera { zoom, pan, ..camera.clone() }
}

/// The unit vector of a position on the sphere or the sheet.
fn on_ball([x, y]: [f64; 2]) -> DVec3 {
    let square = x * x + y * y;
    let z = if square <= 0.5 { (1.0 - square).sqrt() } else { 0.5 / square.sqrt() };
    DVec3::new(x, y, z).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture_support::random::SplitMix;

    #[test]
    fn m26_a_million_drags_leave_a_unit_quaternion() {
        let mut ball = Trackball::of(&Camera::default());
        let mut random = SplitMix(1);
        let mut next = || 4.0 * random.unit() - 2.0;
        let mut worst = 0.0f64;
        for _ in 0..1_000_000 {
            ball.drag([next(), next()], [next(), next()]);
            worst = worst.max((ball.turn.length() - 1.0).abs());
        }
        println!("largest | |q| - 1 | of a million drags: {worst:.1e}");
        assert!(worst < 1e-12, "{worst}");
    }

    #[test]
    fn m26_a_drag_of_no_length_turns_nothing() {
        let mut ball = Trackball::of(&Camera::default());
        let before = ball.turn;
        for place in [[0.0, 0.0], [0.3, -0.2], [5.0, 1.0], [-1e9, 0.0]] {
            let (_, angle) = ball.drag(place, place);
            assert!(angle.abs() < 1e-7, "{angle}");
        }
        assert!(ball.turn.angle_between(before) < 1e-7);
    }

    #[test]
    fn m26_from_rim_to_rim_it_turns_half_around() {
        // Through the middle, in steps; and in one, where both ends are almost opposite.
        let far = 1e6;
        for places in [vec![-far, -0.5, 0.0, 0.5, far], vec![-far, far]] {
            let mut ball = Trackball { turn: DQuat::IDENTITY };
            for pair in places.windows(2) {
                ball.drag([pair[0], 0.0], [pair[1], 0.0]);
            }
            let behind = ball.turn * DVec3::Z;
            assert!((behind + DVec3::Z).length() < 1e-5, "{behind}");
            assert!((ball.turn.length() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn m26_a_place_on_the_ball_stays_under_the_pointer() {
        let mut ball = Trackball { turn: DQuat::IDENTITY };
        let (from, to) = ([0.2, 0.1], [-0.3, 0.4]);
        ball.drag(from, to);
        assert!((ball.turn * on_ball(from)).distance(on_ball(to)) < 1e-12);
    }

    #[test]
    fn a_level_orbit_stays_upright_and_follows_the_trackball() {
        let mut random = SplitMix(5);
        let mut next = || 2.0 * random.unit() - 1.0;
        for _ in 0..200 {
            let mut ball = Trackball::of(&Camera::default());
            ball.drag([next(), next()], [next(), next()]);
            let free = Camera { rotation: Some(ball.rotation()), ..Camera::default() };
            let level = orbit(&free, [0.0; 2]);
            // From the same side, without the roll.
            let toward = |camera: &Camera| camera.turn().inverse() * glam::Vec3::Z;
            assert!(toward(&free).distance(toward(&level)) < 1e-3, "{free:?} {level:?}");
            let moved = orbit(&level, [next() as f32, next() as f32]);
            let up = moved.turn() * glam::Vec3::Y;
            assert!(up.x.abs() < 1e-5 && up.y > -1e-5, "{up}");
            assert!((-180.0..=180.0).contains(&moved.azimuth) && (-90.0..=90.0).contains(&moved.elevation));
        }
        let front = Camera { azimuth: 0.0, elevation: 0.0, ..Camera::default() };
        // The front follows the pointer to the right, which shows the left side of the object.
        assert_eq!(orbit(&front, [0.25, 0.0]).azimuth, -45.0);
        assert_eq!(orbit(&front, [0.0, 0.25]).elevation, 45.0);
    }

    #[test]
    fn the_light_goes_with_the_pointer_and_stays_as_far_away() {
        let moved = drag_light([0.0, 0.0, 5.0], [0.0, 0.0], [0.6, 0.0]);
        assert!((moved[0] - 3.0).abs() < 1e-5 && moved[1].abs() < 1e-6 && (moved[2] - 4.0).abs() < 1e-5, "{moved:?}");
        let moved = drag_light([3.0, -4.0, 12.0], [0.1, 0.2], [-0.7, 0.4]);
        assert!((glam::Vec3::from(moved).length() - 13.0).abs() < 1e-4);
    }

    #[test]
    fn zooming_keeps_the_point_under_the_pointer() {
        let camera = Camera { zoom: 1.5, pan: [0.2, -0.3], ..Camera::default() };
        let (half, at) = (1.8, [0.4, 0.7]);
        for factor in [0.5, 1.3, 4.0] {
            let closer = zoom_to(&camera, factor, at, half);
            // A place q of the middle plane is seen at (q + pan) / half, and half falls as zoom grows.
            let place = [0, 1].map(|axis| at[axis] * half - camera.pan[axis]);
            for axis in 0..2 {
                let seen = (place[axis] + closer.pan[axis]) / (half * camera.zoom / closer.zoom);
                assert!((seen - at[axis]).abs() < 1e-5, "{seen}");
            }
        }
        assert_eq!(zoom_to(&camera, 2.0, [0.0; 2], half).pan, camera.pan);
    }

    #[test]
    fn a_ball_that_follows_its_own_camera_loses_nothing() {
        let mut camera = Camera::default();
        let mut ball = Trackball::of(&camera);
        ball.drag([0.0, 0.0], [0.31, 0.17]);
        camera.rotation = Some(ball.rotation());
        let before = ball;
        ball.follow(&camera);
        assert_eq!(ball, before);
        camera.rotation = None;
        ball.follow(&camera);
        assert_eq!(ball, Trackball::of(&camera));
    }
}
