//! The two phases of a loop.

use crate::formulas::harness::{At, Check};
use glam::DVec3;
use hypertexture::shader::Library;
use std::f64::consts::FRAC_PI_2;

crate::rows! {
    noise_fades_into_that_of_one_loop_before = phases,
        "phases/two.glsl": "p - loop_seconds * velocity" => "p + loop_seconds * velocity",
        "phases/two.glsl": "range.y + dot(" => "dot(",
        "phases/two.glsl": "2.0 * alike" => "alike",
        "phases/two.glsl": "cos(part), sin(part)" => "sin(part), cos(part)";
}

fn phases(library: &Library) -> f64 {
    let text = "#include <phases>
        void check() {
            vec3 velocity = 0.1 * p1.xyz;
            out0.x = passing(p0.x, p0.y, velocity, SUM_RANGE);
            out0.yzw = passing(p2.xyz, p3.xyz, velocity);
            out1.xyz = earlier(p2.xyz, velocity);
            out1.w = passing(mat3(p2.x), mat3(p3.x), velocity)[1].y;
        }";
    let expected = |at: &At<'_>| {
        let (velocity, seconds) = (0.1 * at.place(1), at.number("loop_seconds"));
        let moved = (seconds * velocity.length()).min(1.0);
        let alike = 1.0 - moved * moved * (3.0 - 2.0 * moved);
        let (b, a) = (FRAC_PI_2 * (at.number("time") / seconds).clamp(0.0, 1.0)).sin_cos();
        // The variance of a now + b then, each of variance 1, is 1.
        let scale = 1.0 / (a * a + b * b + 2.0 * a * b * alike).sqrt();
        let sum = |now: f64, then: f64| scale * (a * now + b * then);
        let [now, then] = [2, 3].map(|input| at.place(input));
        let mean = f64::from(0.3f32);
        let turbulence = (mean + sum(at.p[0][0] - mean, at.p[0][1] - mean)).clamp(0.0, f64::from(1.732_050_8f32));
        let before: DVec3 = now - seconds * velocity;
        vec![
            turbulence,
            sum(now.x, then.x),
            sum(now.y, then.y),
            sum(now.z, then.z),
            before.x,
            before.y,
            before.z,
            sum(now.x, then.x),
        ]
    };
    Check::new(library, &[("phases", "two")], text)
        .with("loop_seconds", &[4.0])
        .with("time", &[1.5])
        .holds(1e-5, expected)
}
