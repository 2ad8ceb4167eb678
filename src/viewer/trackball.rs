//! The virtual trackball: a ball in the middle of the view that the pointer takes hold of.
//!
//! Source: Bell's ball, after Chen, Mountford and Sellen 1988: a sphere, and a hyperbolic sheet around it, so that the
//! motion has no edge. Invariant: the turn is a unit quaternion to the last bits of f64, after any number of drags: it is
//! normalized after each.

use crate::scene::Camera;
use glam::{DQuat, DVec3};

/// A turn from object space to that of the camera.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Trackball {
    turn: DQuat,
}

impl Trackball {
    /// The turn of a camera.
    pub fn of(camera: &Camera) -> Trackball {
        Trackball { turn: camera.turn().as_dquat().normalize() }
    }

    /// Takes the turn of a camera, unless it is this one rounded: then nothing of it is lost.
    pub fn follow(&mut self, camera: &Camera) {
        if camera.rotation != Some(self.rotation()) {
            *self = Trackball::of(camera);
        }
    }

    /// The turn, for [`Camera::rotation`].
    pub fn rotation(&self) -> [f32; 4] {
        self.turn.as_quat().to_array()
    }

    /// The turn.
    pub fn turn(&self) -> DQuat {
        self.turn
    }

    /// Moves the pointer over the ball. Places are right and up from the middle of the view, in units of the radius.
    /// Gives the turn that this was: its axis, and the angle in radians.
    pub fn drag(&mut self, from: [f64; 2], to: [f64; 2]) -> (DVec3, f64) {
        let arc = DQuat::from_rotation_arc(on_ball(from), on_ball(to));
        let (axis, angle) = arc.to_axis_angle();
        self.turn = (arc * self.turn).normalize();
        (axis, angle)
    }

    /// Turns by an angle in radians around an axis of eye space, a unit vector.
    pub fn spin(&mut self, axis: DVec3, angle: f64) {
        self.turn = (DQuat::from_axis_angle(axis, angle) * self.turn).normalize();
    }
}

/// The unit vector to the place on the ball, or on the sheet around it, that is seen at a place of the view.
fn on_ball([x, y]: [f64; 2]) -> DVec3 {
    let square = x * x + y * y;
    let z = if square <= 0.5 { (1.0 - square).sqrt() } else { 0.5 / square.sqrt() };
    DVec3::new(x, y, z).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::support::random::SplitMix;

    #[test]
    fn m26_a_million_drags_leave_a_unit_quaternion() {
        let mut ball = Trackball::of(&Camera::default());
        let mut random = SplitMix(1);
        let mut next = || 4.0 * random.unit() - 2.0;
        let mut worst = 0.0f64;
        for _ in 0..1_000_000 {
            ball.drag([next(), next()], [next(), next()]);
            worst = worst.max((ball.turn().length() - 1.0).abs());
        }
        println!("largest | |q| - 1 | of a million drags: {worst:.1e}");
        assert!(worst < 1e-12, "{worst}");
    }

    #[test]
    fn m26_a_drag_of_no_length_turns_nothing() {
        let mut ball = Trackball::of(&Camera::default());
        let before = ball.turn();
        for place in [[0.0, 0.0], [0.3, -0.2], [5.0, 1.0], [-1e9, 0.0]] {
            let (_, angle) = ball.drag(place, place);
            assert!(angle.abs() < 1e-7, "{angle}");
        }
        assert!(ball.turn().angle_between(before) < 1e-7);
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
            let behind = ball.turn() * DVec3::Z;
            assert!((behind + DVec3::Z).length() < 1e-5, "{behind}");
            assert!((ball.turn().length() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn m26_a_place_on_the_ball_stays_under_the_pointer() {
        let mut ball = Trackball { turn: DQuat::IDENTITY };
        let (from, to) = ([0.2, 0.1], [-0.3, 0.4]);
        ball.drag(from, to);
        assert!((ball.turn() * on_ball(from)).distance(on_ball(to)) < 1e-12);
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
