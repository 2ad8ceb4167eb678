//! The two-tone soft sphere, of which the picture is known in closed form: truths 4 and 5.

use super::homogeneous;
use hypertexture::glsl::{self, Library};
use hypertexture::scene::{Pass, Projection, Rule, Scene};

/// Where the soft region begins; the surface is at 1.
pub const OUTER: f64 = 1.25;
/// Where the core begins.
pub const INNER: f64 = 0.75;
/// c of PH 3.1.
pub const RATE: f64 = 3.0;

/// Soft white around a hard red core, unlit: red is the opacity, green and blue that of the soft region alone.
pub fn scene(rule: Rule, pass: Pass, projection: Projection) -> Scene {
    let mut scene = homogeneous("sphere", RATE as f32, projection);
    scene.effect.softness = "quadratic".into();
    scene.effect.opacity = "perlin".into();
    scene.effect.surface = "core".into();
    (scene.object.inner_iso, scene.object.outer_iso) = (INNER as f32 - 1.0, OUTER as f32 - 1.0);
    (scene.quality.rule, scene.quality.pass, scene.quality.stop) = (rule, pass, 0.0);
    scene
}

/// Transmittance of the soft region in front of what lies at impact parameter `b`: truths 4 and 5.
pub fn transmittance(b: f64) -> f64 {
    let l0 = (OUTER * OUTER - b * b).max(0.0).sqrt();
    if b < INNER {
        let l1 = (INNER * INNER - b * b).sqrt();
        let xlnx = |x: f64| if x > 0.0 { x * x.ln() } else { 0.0 };
        let f = |x: f64| xlnx(x + l1) + xlnx(x - l1) - 2.0 * x;
        let width: f64 = OUTER * OUTER - INNER * INNER;
        (RATE * (f(l0) - f(l1) - (l0 - l1) * width.ln())).exp()
    } else {
        let a = (b * b - INNER * INNER).sqrt();
        let depth = if a > 0.0 { l0 - a * (l0 / a).atan() } else { l0 };
        (-4.0 * RATE * depth).exp()
    }
}

/// The shipped modules and the red core.
pub fn library() -> Library {
    let core = "// Red.\n// Source: truth 5.\n// Result: linear RGB.\nvec3 surface(Sample s) { return vec3(1.0, 0.0, 0.0); }\n";
    glsl::shipped().with_module("surface", "core", core)
}
