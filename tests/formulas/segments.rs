//! Samples that stand for a segment of their ray.

use crate::formulas::classify::{classified, covering, line};
use crate::formulas::density::mean_logarithm;
use crate::formulas::harness::{At, COLOR, Check};
use glam::{DMat3, DVec3};
use hypertexture::shader::Library;

crate::rows! {
    m05_the_density_of_a_segment_is_a_line = soft,
        "classify/soft_segment.glsl": "amount * (soft.y - soft.x)" => "amount",
        "classify/soft_segment.glsl": "1.0 - near.a" => "1.0 + near.a";
    m30_a_surface_is_found_within_the_step = surface,
        "classify/surface_segment.glsl": "x + 0.5 *" => "x - 0.5 *",
        "classify/surface_segment.glsl": "gap < 0.0 && at" => "gap > 0.0 && at";
    m05_a_sample_reaches_half_a_path_to_each_side = ends,
        "segment.glsl": "to_eye() * -path" => "to_eye() * path",
        "segment.glsl": "(value - a)" => "(value + a)",
        "segment.glsl": "(t - 0.5) * path" => "t * path";
}

/// The near and the far end of the segment around a point, object space.
fn segment(at: &At<'_>) -> [DVec3; 2] {
    let along = DMat3::from_mat4(at.matrix("texture_matrix")) * at.place(3).normalize() * at.p[0][3];
    [at.place(0) - along / 2.0, at.place(0) + along / 2.0]
}

/// From end to end the density D is a line; where it is 1 the surface hides the rest, in front of it is soft matter.
fn soft(library: &Library) -> f64 {
    let slots = [("classify", "soft_segment"), ("surface", "unlit"), ("medium", "soft_region")];
    classified(library, &slots).worst(|at, found| {
        let [from, to] = segment(at);
        let [mut a, mut b] = [from, to].map(|x| line(at, x));
        let entering = b > a;
        let whole = b - a;
        // Where on the way the line is 0 and 1.
        let [zero, one] = [0.0, 1.0].map(|value| ((value - a) / whole).clamp(0.0, 1.0));
        let (start, end) = if entering { (zero, one) } else { (one, zero) };
        let (near_hard, far_hard) = (a >= 1.0, b >= 1.0);
        (a, b) = (a + start * whole, a + end * whole);
        let path = at.p[0][3] * (end - start);
        let lowest = a.min(b).max(0.0);
        let (mut alpha, mut color) = (0.0, DVec3::ZERO);
        if path > 0.0 {
            // One at the surface itself is as much as anything next to it.
            let held = |d: f64| d.clamp(0.0, 1.0 - 2f64.powi(-24));
            alpha = -(at.number("opacity_rate") * path * mean_logarithm(held(a), held(b))).exp_m1();
            let density = (held(a) + held(b)) / 2.0;
            let [low, high] = [[0.1f32, 0.25, 1.0], [0.2, 1.0, 0.6]].map(|ends| DVec3::from(ends.map(f64::from)));
            color = low.lerp(high, density);
        }
        let skin = COLOR * at.vector("material_color");
        let expected = match (near_hard, far_hard) {
            (true, _) => covering(skin, 1.0),
            (false, true) => (color * alpha + skin * (1.0 - alpha)).extend(1.0).to_array().to_vec(),
            (false, false) => covering(color, alpha),
        };
        assert!(lowest >= 0.0);
        expected.iter().zip(found).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max) / 3e-6
    })
}

/// Behind a flat face the distance is a line, so that the crossing is exact.
fn surface(library: &Library) -> f64 {
    let text = "#include <clip>\n#include <classify>\nvoid check() { out0 = classify(p0.xyz, p0.w); }";
    let slots = [("classify", "surface_segment"), ("softness", "hard"), ("object", "cube"), ("surface", "tex_coord")];
    let check = Check::new(library, &slots, text).with("iso_value", &[0.1]);
    let check = check.with("steepness", &[1.0]).with("sample_reach", &[2.0]).given(|random, _| {
        let face = DVec3::new(random.within(-0.5, 0.5), 1.1 + random.within(-0.1, 0.1), random.within(-0.5, 0.5));
        let path = random.within(0.01, 0.2);
        [face.extend(path).to_array(), [0.0; 4], [0.0; 4], random.eye().extend(0.0).to_array()]
    });
    check.holds(1e-6, |at| {
        let [from, to] = segment(at);
        let face = 1.0 + f64::from(0.1f32);
        let (low, high) = (at.vector("own_min"), at.vector("own_max"));
        let (over_from, over_to) = (from.y - face, to.y - face);
        let seen = match (over_from > 0.0, over_to > 0.0) {
            // Nothing is met, or the segment before has met it.
            (_, true) => return vec![0.0; 4],
            (true, false) => from + (to - from) * over_from / (over_from - over_to),
            (false, false) => from,
        };
        covering((seen - low) / (high - low), 1.0)
    })
}

fn ends(library: &Library) -> f64 {
    let text = "#include \"segment.glsl\"
        void check() {
            out0 = vec4(to_far_end(p0.w), place_of(p0.x, p0.y, p0.z));
            look_from_middle_to(p1.x, p0.w);
            out1.xyz = position_eye;
        }";
    Check::new(library, &[], text).holds(1e-8, |at| {
        let ([value, a, b, path], eye) = (at.p[0], at.place(3));
        let away = eye.normalize() * path;
        let far = DMat3::from_mat4(at.matrix("texture_matrix")) * away;
        let place = ((value - a) / (b - a)).clamp(0.0, 1.0);
        let looked = eye + away * (at.p[1][0] - 0.5);
        [far.to_array().as_slice(), &[place], &looked.to_array()].concat()
    })
}
