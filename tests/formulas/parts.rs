//! Several objects made one, and the gradient of what a DMF has made of them.

use crate::formulas::classify::{covering, line};
use crate::formulas::harness::{At, COLOR, Check};
use glam::{DMat3, DMat4, DVec3};
use hypertexture::shader::Library;

crate::rows! {
    p06_to_p09_soft_booleans_are_products = |l| booleans(l, "algebraic", |a, b| [a * b, a + b - a * b]),
        "boolean/algebraic.glsl": "b.density * a.slope + a.density * b.slope" => "a.density * a.slope + b.density * b.slope",
        "boolean/algebraic.glsl": "b.distance < a.distance" => "b.distance > a.distance",
        "boolean/algebraic.glsl": "1.0 - a.density, -a.slope" => "1.0 - a.density, a.slope";
    p12_fuzzy_booleans_are_extremes = |l| booleans(l, "minmax", |a, b| [a.min(b), a.max(b)]),
        "boolean/minmax.glsl": "b.density < a.density ||" => "b.density > a.density ||",
        "boolean/minmax.glsl": "max(a.distance_bound" => "min(a.distance_bound";
    p05_a_shade_is_of_each_object_by_its_density = objects,
        "classify/objects.glsl": "#include <opacity>" => "#define opacity_rate 1.0\n#include <opacity>",
        "one_of_several.glsl": "modulate(s.density, s)" => "s.density",
        "one_of_several.glsl": "place_scale * (s.distance" => "(s.distance",
        "one_of_several.glsl": "normal / -width" => "normal / width";
    p09_matter_faces_down_its_density = facing,
        "soft.glsl": "-normalize(a.slope)" => "normalize(a.slope)";
    p09_thin_matter_has_the_side_that_a_ray_enters = entry,
        "thin_matter.glsl": "< entry_reach" => "> entry_reach",
        "thin_matter.glsl": "entered_from) < 0.0" => "entered_from) > 0.0";
    m26_the_normal_of_a_sample_is_that_of_its_distance = analytic,
        "gradient/analytic.glsl": "return s.normal" => "return -s.normal";
    p41_central_differences_of_a_line_are_its_slope = |l| ramp(l, "central"),
        "gradient/central.glsl": "ahead - behind" => "behind - ahead",
        "modulated.glsl": "gradient_eye * mat3(object_matrix)" => "mat3(object_matrix) * gradient_eye";
    p41_dense_matter_is_shaded_where_a_ray_enters_it = entered,
        "entered.glsl": "inside = middle" => "outside = middle",
        "entered.glsl": "< 0.5) return" => "< 2.0) return";
    m30_a_surface_is_located_within_the_step = located,
        "located.glsl": "s.x + at *" => "s.x - at *",
        "located.glsl": "(at * path)" => "(-at * path)",
        "step_back.glsl": "s.far.y / min" => "s.near.y / min";
    m30_an_edge_is_found_between_two_samples = edge,
        "step_back.glsl": "gap >= most" => "gap <= most",
        "step_back.glsl": "to_eye() * path" => "to_eye() * -path";
    p41_three_differences_of_a_line_are_its_slope = |l| ramp(l, "three"),
        "gradient/three.glsl": "s.x + offset[1]" => "s.x - offset[1]";
    p41_three_differences_look_back_along_the_ray = three,
        "gradient/three.glsl": "s.x - offset[0]" => "s.x + offset[0]",
        "modulated.glsl": "modulate(s.density, s)" => "s.density";
}

/// Densities a and b, and what becomes of their slopes by the derivative of the formula: of `and` and `or`.
fn booleans(library: &Library, module: &str, formula: fn(f64, f64) -> [f64; 2]) -> f64 {
    let text = "#include <boolean>
        void check() {
            Soft a = Soft(p0.x, p0.yzw, p2.x, normalize(p0.yzw), p2.z);
            Soft b = Soft(p1.x, p1.yzw, p2.y, normalize(p1.yzw), p2.w);
            Soft found = intersect(a, b);
            if (p3.w >= 0.25) found = intersect(a, complement(b));
            if (p3.w >= 0.5) found = complement(intersect(complement(a), complement(b)));
            if (p3.w >= 0.75) found = unite(a, b);
            out0 = vec4(found.slope, found.density);
            out1 = vec4(found.normal, found.distance);
            if (p3.w > 0.9 || p3.w < 0.1) out1.w = found.distance_bound;
        }";
    let check = Check::new(library, &[("boolean", module)], text).given(|random, _| {
        let mut p = random.point();
        (0..2).for_each(|i| p[i] = [random.unit(), random.coordinate(), random.coordinate(), random.coordinate()]);
        p
    });
    check.worst(|at, found| {
        let ([a, b], [slope_a, slope_b]) = ([at.p[0][0], at.p[1][0]], [0, 1].map(|i| DVec3::from_slice(&at.p[i][1..])));
        // A difference is the intersection with what the other one is not.
        let less = if (0.25..0.5).contains(&at.p[3][3]) { -1.0 } else { 1.0 };
        let (b, slope_b, distance_b) = (if less < 0.0 { 1.0 - b } else { b }, less * slope_b, less * at.p[2][1]);
        // De Morgan: not (not a and not b) is a or b.
        let or = usize::from(at.p[3][3] >= 0.5);
        let h = 1e-3;
        let partial = [formula(a + h, b)[or] - formula(a - h, b)[or], formula(a, b + h)[or] - formula(a, b - h)[or]];
        let slope = (slope_a * partial[0] + slope_b * partial[1]) / (2.0 * h);
        // Of two equal materials the sharp operation has the border of one: the nearer of a union, the further of an
        // intersection; for extremes, of the one whose density it is.
        let second = match module {
            "algebraic" => (distance_b < at.p[2][0]) == (or == 1),
            _ => formula(a, b)[or] == b,
        };
        let (normal, distance) = if second { (slope_b, distance_b) } else { (slope_a, at.p[2][0]) };
        let last = match at.p[3][3] {
            w if w < 0.1 => at.p[2][2].max(at.p[2][3]),
            w if w > 0.9 => at.p[2][2].min(at.p[2][3]),
            _ => distance,
        };
        let of = |v: DVec3, w: f64| v.extend(w).to_array();
        let expected = [of(slope, formula(a, b)[or]), of(normal.normalize(), last)].concat();
        let errors = expected.iter().zip(found).map(|(a, b)| (a - b).abs() / (1.0 + a.abs()));
        if module == "minmax" && (a - b).abs() < 2.0 * h { 0.0 } else { errors.fold(0.0, f64::max) / 1e-8 }
    })
}

fn place_of_b(at: &At<'_>) -> DMat4 {
    at.matrix("place_matrix_b")
}

/// A biased sphere, and another one in a place of its own: color and rate are the means by density.
fn objects(library: &Library) -> f64 {
    let text = "#define ONE_SAMPLE\n#include <clip>\n#include <classify>
        void check() {
            out0 = classify(p0.xyz, p0.w);
            Sample b = one_sample_b(p0.xyz);
            float density = one_density_b(b);
            Soft soft = one_soft_b(b, density);
            out1 = vec4(soft.slope, soft.distance);
        }";
    let slots = [
        ("classify", "objects"),
        ("combine", "main | b"),
        ("b.object", "sphere"),
        ("b.dmf", "scaled"),
        ("b.warp", "-"),
        ("b.medium", "material"),
        ("b.surface", "unlit"),
    ];
    let check = Check::new(library, &slots, text)
        .with("place_matrix", &DMat4::IDENTITY.to_cols_array())
        .with("place_scale", &[1.0]);
    let check = [("density_factor_b", 0.75), ("density_offset_b", 0.125), ("place_scale_b", 0.5)]
        .into_iter()
        .fold(check, |check, (name, value)| check.with(name, &[value]))
        .with(
            "place_matrix_b",
            &(DMat4::from_scale(DVec3::splat(2.0)) * DMat4::from_translation(DVec3::new(-0.75, 0.25, 0.0)))
                .to_cols_array(),
        )
        .given(|random, _| {
            let mut p = random.point();
            p[0] = random.in_cube(1.6).extend(random.within(0.0, 0.1)).to_array();
            p
        });
    check.holds(1e-5, |at| {
        let x = at.place(0);
        let own = place_of_b(at).transform_point3(x);
        let (inner, outer) = (at.number("iso_value_b"), at.number("outer_iso_value_b"));
        let bare = ((outer + 1.0 - own.length()) / (outer - inner)).clamp(0.0, 1.0);
        let b = if bare > 0.0 { (0.75 * bare + 0.125).min(1.0) } else { 0.0 };
        let a = line(at, x).clamp(0.0, 1.0);
        let both = 1.0 - (1.0 - a) * (1.0 - b); // no rounding keeps it below 1 where one of them is 1
        // Lengths in the scene are half of those of the object.
        let slope = if bare > 0.0 && bare < 1.0 { -own.normalize() / (0.5 * (outer - inner)) } else { DVec3::ZERO };
        let soft = slope.extend(0.5 * (own.length() - 1.0 - inner)).to_array();
        if both == 0.0 {
            return [[0.0; 4], soft].concat();
        }
        let [mine, other] = ["material_color", "material_color_b"].map(|name| COLOR * at.vector(name));
        let color = (a * mine + b * other) / (a + b);
        let rate = (a * at.number("opacity_rate") + b * at.number("opacity_rate_b")) / (a + b);
        let alpha = if both >= 1.0 { 1.0 } else { 1.0 - (1.0 - both).powf(rate * at.p[0][3]) };
        [covering(color, alpha), soft.to_vec()].concat()
    })
}

fn facing(library: &Library) -> f64 {
    let text = "#include \"soft.glsl\"
        void check() { out0.xyz = outward(Soft(0.5, p2.w < 0.0 ? vec3(0.0) : p0.xyz, 0.0, p1.xyz, 0.0)); }";
    let check = Check::new(library, &[], text).given(|random, _| {
        let mut p = random.point();
        p[0] = (random.direction() * random.within(0.01, 9.0)).extend(0.0).to_array();
        p
    });
    check.holds(1e-9, |at| if at.p[2][3] < 0.0 { at.place(1) } else { -at.place(0).normalize() }.to_array().to_vec())
}

/// Of two surfaces within reach of each other the one that faces the ray counts.
fn entry(library: &Library) -> f64 {
    let text = "#include \"thin_matter.glsl\"
        void check() {
            entered_from = p0.xyz;
            entry_reach = p0.w;
            Soft other = Soft(1.0, vec3(0.0), p1.w, p1.xyz, 0.0), chosen = Soft(1.0, vec3(0.0), p2.w, p2.xyz, 0.0);
            out0.x = enters_through(other, chosen) ? 1.0 : 0.0;
        }";
    let check = Check::new(library, &[], text);
    check.holds(1e-9, |at| {
        let [from, other, chosen] = [0, 1, 2].map(|index| at.place(index));
        let is_near = (at.p[1][3] - at.p[2][3]).abs() < at.p[0][3];
        vec![f64::from(is_near && other.dot(from) > 0.0 && chosen.dot(from) < 0.0), 0.0, 0.0, 0.0]
    })
}

const GRADIENT: &str =
    "#include <clip>\n#include <opacity>\n#include \"sample.glsl\"\n#include <dmf>\n#include <gradient>
    void check() {
        Sample s = sample_object(p0.xyz);
        out0.xyz = shading_normal(s, modulate(s.density, s), p0.w);
    }";

fn analytic(library: &Library) -> f64 {
    let check = Check::new(library, &[("object", "torus")], GRADIENT);
    check.holds(1e-9, |at| {
        crate::formulas::object::torus(crate::formulas::dual::place(at.place(0))).d.to_array().to_vec()
    })
}

/// Above a flat face the density falls along the normal alone, however the object is turned and stretched.
fn ramp(library: &Library, gradient: &str) -> f64 {
    let check = Check::new(library, &[("object", "cube"), ("gradient", gradient)], GRADIENT);
    let check = check.with("iso_value", &[0.0]).with("outer_iso_value", &[2.0]).given(|random, _| {
        let x = DVec3::new(random.within(-0.5, 0.5), random.within(1.4, 2.6), random.within(-0.5, 0.5));
        [x.extend(random.within(0.01, 0.1)).to_array(), [0.0; 4], [0.0; 4], random.eye().extend(0.0).to_array()]
    });
    check.holds(1e-6, |_| vec![0.0, 1.0, 0.0])
}

/// A point above or in a flat face, whose density falls along y, and a step of a ray towards the eye.
fn on_a_face(check: Check, low: f64, high: f64) -> Check {
    check.with("iso_value", &[0.0]).given(move |random, _| {
        let x = DVec3::new(random.within(-0.4, 0.4), random.within(low, high), random.within(-0.4, 0.4));
        [x.extend(random.within(0.05, 0.4)).to_array(), [0.0; 4], [0.0; 4], random.eye().extend(0.0).to_array()]
    })
}

/// The way back to the sample before, in object space and in eye space.
fn back(at: &At<'_>) -> [DVec3; 2] {
    let to_eye = -at.place(3).normalize() * at.p[0][3];
    [DMat3::from_mat4(at.matrix("texture_matrix")) * to_eye, to_eye]
}

/// Where the face is crossed, a line finds it exactly.
fn located(library: &Library) -> f64 {
    let text = "#include <clip>\n#include \"sample.glsl\"\n#include \"located.glsl\"
        void check() {
            Sample s = sample_object(p0.xyz);
            float at;
            meets(s.x, s.distance - iso_value, iso_value, p0.w, at);
            s = moved_back(s, at, p0.w);
            out0 = vec4(s.x, s.distance);
            out1.xyz = position_eye;
        }";
    on_a_face(Check::new(library, &[("object", "cube")], text), 0.75, 1.0).holds(1e-8, |at| {
        let ([back, back_eye], x) = (back(at), at.place(0));
        // The part of the way at which y is 1.
        let part = (1.0 - x.y) / back.y;
        let part = if (0.0..=1.0).contains(&part) { part } else { 0.0 };
        let found = x + part * back;
        [found.to_array().as_slice(), &[found.y - 1.0], &(at.place(3) + part * back_eye).to_array()].concat()
    })
}

/// A ray that goes through an edge of a cube between two samples enters where it says, and one that misses it enters nowhere.
fn edge(library: &Library) -> f64 {
    let text = "#include <clip>\n#include \"sample.glsl\"\n#include \"located.glsl\"
        void check() {
            float at;
            bool met = meets(p0.xyz, sample_object(p0.xyz).distance - iso_value, iso_value, p0.w, at);
            out0 = vec4(at, met, steepness, sample_reach);
        }";
    let check = Check::new(library, &[("object", "cube")], text).with("iso_value", &[0.0]).with("steepness", &[1.0]);
    let check = check.given(|random, _| {
        let x = DVec3::new(random.within(-0.4, 0.4), random.within(0.9, 1.1), random.within(0.9, 1.1));
        [x.extend(random.within(0.05, 0.4)).to_array(), [0.0; 4], [0.0; 4], random.eye().extend(0.0).to_array()]
    });
    check.worst(|at, found| {
        let ([back, _], x) = (back(at), at.place(0));
        let (a, b) = ((DVec3::splat(-1.0) - x) / back, (DVec3::ONE - x) / back);
        let [leaves, enters] = [a.min(b).max_element(), a.max(b).min_element()];
        let length = enters - leaves;
        let is_outside = leaves > 0.0 && enters < 1.0 || length < 0.0;
        match is_outside {
            true if length > 0.05 => (found[0] - enters).abs().max(1.0 - found[1]) / 0.1,
            true if length < -0.05 => found[1],
            _ => 0.0,
        }
    })
}

/// Four halvings find the place of half the density to a sixteenth of the way back.
fn entered(library: &Library) -> f64 {
    let text = "#include <clip>\n#include \"sample.glsl\"\n#include <dmf>\n#include <opacity>\n#include <gradient>
        void check() {
            Sample s = sample_object(p0.xyz);
            float density = s.density;
            enter(s, density, p0.w);
            out0 = vec4(s.x, density);
            out1.x = opacity(sample_object(p0.xyz).density, opacity_rate * p0.w);
        }";
    let check =
        Check::new(library, &[("object", "cube"), ("gradient", "central")], text).with("outer_iso_value", &[0.5]);
    on_a_face(check, 1.02, 1.4).worst(|at, found| {
        let ([back, _], x) = (back(at), at.place(0));
        let density = |x: DVec3| ((1.5 - x.y) / 0.5).clamp(0.0, 1.0);
        let (here, before) = (density(x), density(x + back));
        let to = DVec3::from_slice(&found);
        let part = (to - x).dot(back) / back.length_squared();
        let crossing = ((1.5 - 0.25 * here) - x.y) / back.y;
        let right = if found[4] < 0.5 || before >= 0.5 * here {
            part.abs() < 1e-9
        } else {
            part <= crossing + 1e-9 && crossing - part <= 1.0 / 16.0 + 1e-9
        };
        let off = (to - (x + part * back)).length().max((found[3] - density(to)).abs());
        if right { off / 1e-8 } else { f64::INFINITY }
    })
}

/// PH 3.1: f(x) - f(x - dx_mu), f(x + dx_nu) - f(x), f(x + dx_omega) - f(x), times the rows of the three steps.
fn three(library: &Library) -> f64 {
    let check = Check::new(library, &[("gradient", "three"), ("dmf", "gained")], GRADIENT);
    let check = check.with("density_gain", &[0.75]).with("iso_value", &[-0.5]).with("outer_iso_value", &[1.0]);
    let check = check
        .with("object_matrix", &DMat4::IDENTITY.to_cols_array())
        .with("texture_matrix", &DMat4::IDENTITY.to_cols_array());
    let check = check.given(|random, _| {
        let x = random.direction() * random.within(0.8, 1.6);
        [x.extend(random.within(0.01, 0.2)).to_array(), [0.0; 4], [0.0; 4], random.eye().extend(0.0).to_array()]
    });
    check.holds(1e-6, |at| {
        let (x, path) = (at.place(0), at.p[0][3]);
        let f = |x: DVec3| crate::formulas::density::gain(0.75, ((2.0 - x.length()) / 1.5).clamp(0.0, 1.0));
        let mu = at.place(3).normalize();
        let nu = DVec3::new(-mu.z, 0.0, mu.x).normalize();
        let basis = DMat3::from_cols(mu, nu, nu.cross(mu));
        let differences =
            DVec3::new(f(x) - f(x - path * mu), f(x + path * nu) - f(x), f(x + path * basis.z_axis) - f(x));
        (-(basis * differences)).normalize().to_array().to_vec()
    })
}
