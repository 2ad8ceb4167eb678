//! Scenes with a closed form of every pixel, and the modules that they need.

use super::analytic::{AnalyticCase, Level};
use super::closed_forms::{self as closed, SoftBall};
use super::rays::Ray;
use super::scenes::{SLAB, SLANT, box_subject, homogeneous, sphere};
use glam::Vec3;
use hypertexture::scene::{Integration, Projection, Scene};
use hypertexture::shader;

/// Soft ball with a hard core; its surface is at 1.
pub const TWO_TONE: SoftBall = SoftBall { inner: 0.75, outer: 1.25, rate: 3.0 };
/// Soft ball without a hard core.
const SOFT: SoftBall = SoftBall { inner: 0.5, outer: 1.25, rate: 3.0 };
const BALL_EXTINCTION: f64 = 2.0;
const RAMP_RATE: f64 = 3.0;
const DEPTH_RATE: f64 = 7.5;
const PANE_RATE: f64 = 2.0;

/// Soft ball in the classification of MJ 6.
fn soft_scene(ball: SoftBall) -> Scene {
    let mut scene = homogeneous("sphere", ball.rate as f32, Projection::Parallel);
    scene.effect.softness = "quadratic".into();
    (scene.object.inner_iso, scene.object.outer_iso) = (ball.inner as f32 - 1.0, ball.outer as f32 - 1.0);
    scene.quality.early_termination = 0.0;
    scene
}

/// Soft white around a hard red core, unlit: red is the opacity, green and blue are those of the soft region alone.
pub fn two_tone(integration: Integration) -> Scene {
    let mut scene = soft_scene(TWO_TONE);
    scene.effect.opacity = "perlin".into();
    scene.effect.surface = "core".into();
    scene.quality.integration = integration;
    scene
}

/// Whether a ray passes both faces of the slab away from their edges.
fn through(ray: &Ray) -> bool {
    [-1.0 / 3.0, 1.0 / 3.0].iter().all(|&z| ray.at(z).truncate().abs().max_element() < 0.66)
}

/// Worst-case rounding of that many blends.
fn rounding(level: &Level) -> f64 {
    f64::from(level.samples) * 2f64.powi(-24)
}

const GROWING: &[u32] = &[64, 256, 1024];
const ALIGNED: &[u32] = &[48, 192, 768];

const BALL: AnalyticCase = AnalyticCase {
    variant: "ball",
    projection: Projection::Parallel,
    scene: || (homogeneous("sphere", BALL_EXTINCTION as f32, Projection::Parallel), sphere()),
    samples: GROWING,
    channel: 3,
    truth: |ray| Some(closed::ball(BALL_EXTINCTION, ray.impact())),
    // Equidistant samples measure a chord to within one step.
    bound: |level| BALL_EXTINCTION * level.step * SLANT + 1e-5,
    order: Some([0.9, 1.1]),
};

const RAMP: AnalyticCase = AnalyticCase {
    variant: "linear slab",
    scene: || {
        let mut scene = homogeneous("cube", RAMP_RATE as f32, Projection::Parallel);
        scene.effect.dmf = vec!["ramp".into()];
        (scene, box_subject(SLAB))
    },
    samples: ALIGNED,
    truth: |ray| through(ray).then(|| closed::slab(0.8 * RAMP_RATE, 0.2 * RAMP_RATE, 2.0 / 3.0 * ray.slant())),
    // The middle of a slice has its mean density: no quadrature error, and roundings that cancel out.
    bound: |_| 2e-6,
    order: None,
    ..BALL
};

const DEPTH: AnalyticCase = AnalyticCase {
    variant: "",
    scene: || {
        let mut scene = homogeneous("cube", DEPTH_RATE as f32, Projection::Parallel);
        scene.effect.surface = "depth".into();
        scene.quality.early_termination = 0.0;
        (scene, box_subject(SLAB))
    },
    samples: ALIGNED,
    channel: 0,
    truth: |ray| through(ray).then(|| closed::depth_color(DEPTH_RATE * ray.slant(), 2.0 / 3.0)),
    // A slice has the color of its middle; the visible mean lies k h^2 / 12 in front of it.
    bound: |level| 1.1 * DEPTH_RATE * level.step.powi(2) / 12.0 + rounding(level),
    order: Some([1.9, 2.1]),
    ..BALL
};

const SOFT_BALL: AnalyticCase = AnalyticCase {
    variant: "",
    scene: || (soft_scene(SOFT), sphere()),
    truth: |ray| Some(SOFT.beer(ray.impact())),
    // Kinks of the density with slopes up to 2 r0 / (r0^2 - r1^2): h^2 / 8 of slope each.
    bound: |level| {
        let slope = 2.0 * SOFT.outer / (SOFT.outer.powi(2) - SOFT.inner.powi(2));
        4.0 * SOFT.rate * slope * (1.1 * level.step).powi(2) / 8.0 + rounding(level)
    },
    order: Some([1.9, 2.2]),
    ..BALL
};

const PERLIN_BALL: AnalyticCase = AnalyticCase {
    scene: || (two_tone(Integration::Point), sphere()),
    // More than a step beside the core, where the logarithm of the density is infinite.
    truth: |ray| (ray.impact() > 0.85).then(|| 1.0 - TWO_TONE.perlin(ray.impact().min(TWO_TONE.outer))),
    // Euler-Maclaurin: h^2 / 12 of the slope at both ends of the ray, 2 c L0 / (r0^2 - r1^2) each.
    bound: |level| {
        let slope = 2.0 * TWO_TONE.rate * TWO_TONE.outer / (TWO_TONE.outer.powi(2) - TWO_TONE.inner.powi(2));
        2.0 * slope * (SLANT * level.step).powi(2) / 12.0 + rounding(level)
    },
    ..SOFT_BALL
};

/// Point samples miss most of the infinite extinction at the core.
const TWO_TONE_POINTS: AnalyticCase = AnalyticCase {
    variant: "points",
    channel: 1,
    truth: |ray| Some(1.0 - TWO_TONE.perlin(ray.impact().min(TWO_TONE.outer))),
    // As measured: 3.3e-2 with 256 samples of 64 phases in the middle.
    bound: |level| 4.0 * level.step,
    order: Some([0.8, 1.1]),
    ..PERLIN_BALL
};

const TWO_TONE_SEGMENTS: AnalyticCase = AnalyticCase {
    variant: "segments",
    scene: || (two_tone(Integration::Segment), sphere()),
    bound: |level| 5.0 * level.step.powi(2) + rounding(level),
    order: Some([1.8, 2.2]),
    ..TWO_TONE_POINTS
};

const PANE: AnalyticCase = AnalyticCase {
    variant: "view of 90 degrees",
    projection: Projection::Perspective,
    scene: || {
        let mut scene = homogeneous("cube", PANE_RATE as f32, Projection::Perspective);
        scene.effect.dmf = vec!["pane".into()];
        scene.camera.field_of_view = 90.0;
        // The camera is 0.7 from the middle of the pane, and the pane fills 1.5 times the view.
        scene.camera.zoom = (1.0 / 0.8 / 0.7 / 45f64.to_radians().sin()) as f32;
        scene.camera.zoom *= 1.5;
        (scene, box_subject(Vec3::new(1.0, 1.0, 0.5)))
    },
    samples: &[96, 384],
    truth: |ray| Some(closed::slab(PANE_RATE, PANE_RATE, 0.5 * ray.slant())),
    bound: |_| 2e-5,
    order: None,
    ..BALL
};

const fn perspective(known: AnalyticCase) -> AnalyticCase {
    AnalyticCase { projection: Projection::Perspective, ..known }
}

/// Homogeneous balls and slabs.
pub const HOMOGENEOUS: &[AnalyticCase] = &[BALL, perspective(BALL), RAMP, perspective(RAMP)];
/// Slabs colored by depth.
pub const COLOR_BY_DEPTH: &[AnalyticCase] = &[DEPTH, perspective(DEPTH)];
/// Soft balls with Beer-Lambert opacity.
pub const SOFT_BALLS: &[AnalyticCase] = &[SOFT_BALL, perspective(SOFT_BALL)];
/// Soft balls with the opacity of PH 3.1.
pub const PERLIN_BALLS: &[AnalyticCase] = &[PERLIN_BALL, perspective(PERLIN_BALL)];
/// Soft balls with a hard core.
pub const TWO_TONES: &[AnalyticCase] =
    &[TWO_TONE_POINTS, TWO_TONE_SEGMENTS, perspective(TWO_TONE_POINTS), perspective(TWO_TONE_SEGMENTS)];
/// A pane across a wide view.
pub const SLANTED: &[AnalyticCase] = &[PANE];

/// The modules that ship and those of the cases.
pub fn library() -> shader::Library {
    shader::shipped()
        .with_module("dmf", "ramp", include_str!("ramp.glsl"))
        .with_module("dmf", "pane", include_str!("pane.glsl"))
        .with_module("surface", "depth", include_str!("depth.glsl"))
        .with_module("surface", "core", include_str!("core.glsl"))
        .with_module("surface", "field_value", include_str!("field_value.glsl"))
        .with_module("surface", "noise_lattice", include_str!("noise_lattice.glsl"))
        .with_module("surface", "noise_period", include_str!("noise_period.glsl"))
        .with_module("index", "luneburg", include_str!("luneburg.glsl"))
        .with_module("index", "fish_eye", include_str!("fish_eye.glsl"))
        .with_module("environment", "exit_direction", include_str!("exit_direction.glsl"))
        .with_module("environment", "exit_moment", include_str!("exit_moment.glsl"))
}
