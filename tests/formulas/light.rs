//! Light: the point light, its shadows, and the surroundings.

use crate::formulas::density::smoothstep;
use crate::formulas::harness::{At, Check};
use crate::formulas::values::{c, filtered};
use glam::{DMat3, DVec2, DVec3};
use hypertexture::eval::Wrap;
use hypertexture::shader::Library;

crate::rows! {
    p54_the_shadow_volume_is_asked_off_the_surface = shadowed,
        "shadow/volume.glsl": "position_eye + shadow_bias" => "position_eye - shadow_bias",
        "shadow/volume.glsl": "+ 0.5) / layers" => ") / layers";
    p54_without_shadows_a_guess_stands = unshadowed,
        "shadow/none.glsl": "vec3 normal) {" => "vec3 normal) { guess = 1.0;";
    p54_light_space_is_angle_and_distance = light_space,
        "light_space.glsl": "sqrt(0.5 + 0.5 * cosine)" => "sqrt(0.5 + 0.4 * cosine)",
        "light_space.glsl": "cosine = 0.5 * across" => "cosine = 0.4 * across",
        "light_space.glsl": "max(1.0 - quarter, 0.0)" => "max(1.0 - 0.9 * quarter, 0.0)",
        "light_space.glsl": "2.0 * cosine * cosine - 1.0" => "1.0 - 2.0 * cosine * cosine",
        "light_space.glsl": "p - shadow_matrix[3]" => "p + shadow_matrix[3]";
    p28_without_surroundings_there_is_nothing = |l| environment(l, "none", |_| [0.0; 4]),
        "environment/none.glsl": "vec4(0.0)" => "vec4(1.0)";
    p28_the_surroundings_are_a_studio = |l| environment(l, "studio", studio),
        "environment/studio.glsl": "fract(0.5 * a)" => "fract(0.4 * a)",
        "environment/studio.glsl": "vec3(0.0, -up.z, up.y)" => "vec3(0.0, up.z, up.y)",
        "environment/studio.glsl": "0.6 * part.x" => "0.8 * part.x",
        "environment/studio.glsl": "spread * (1.0 + dot(p, p))" => "spread",
        "environment/studio.glsl": "vec2(0.61, 0.88)" => "vec2(0.61, 0.36)";
}

/// The normal of an object in eye space.
pub fn to_eye_space(at: &At<'_>, normal: DVec3) -> DVec3 {
    (DMat3::from_mat4(at.matrix("normal_matrix")) * normal).normalize()
}

/// Unit directions to the light and to the eye, in perspective.
pub fn directions(at: &At<'_>) -> [DVec3; 2] {
    let eye = at.place(3);
    [(at.vector("light_position") - eye).normalize(), -eye.normalize()]
}

/// MJ 3.2: ambient, diffuse, and a highlight about the half vector; nothing on the far side.
pub fn phong(at: &At<'_>, base: DVec3, normal: DVec3) -> DVec3 {
    lit(at, base, to_eye_space(at, normal))
}

/// The same, of a normal in eye space.
pub fn lit(at: &At<'_>, base: DVec3, n: DVec3) -> DVec3 {
    let [l, v] = directions(at);
    let cosine = n.dot(l);
    let mut light = at.vector("ambient_color") * base;
    if cosine > 0.0 {
        let highlight = n.dot((l + v).normalize()).max(c(1e-6)).powf(at.number("specular_power"));
        light += at.vector("light_color") * (base * cosine + at.number("specular_strength") * highlight);
    }
    light
}

fn unshadowed(library: &Library) -> f64 {
    let text = "#include <shadow>\nvoid check() { out0.xyz = vec3(shadow(p0.x, p0.xyz)); }";
    Check::new(library, &[], text).holds(1e-12, |at| vec![at.p[0][0]; 3])
}

/// Around the light: x and y by the sine of a quarter of the angle from its axis, which `shadow_rim` brings to 1, z by the
/// distance.
pub fn in_light_space(at: &At<'_>, position: DVec3) -> DVec3 {
    let p = at.matrix("shadow_matrix").transform_point3(position);
    let angle = (p.z / p.length()).clamp(-1.0, 1.0).acos();
    let across = p.truncate().normalize_or_zero() * (4.0 * (angle / 4.0).sin()) / at.number("shadow_rim");
    let (near, far) = (at.number("shadow_near"), at.number("shadow_far"));
    ((across + 1.0) / 2.0).extend((p.length() - near) / (far - near))
}

/// There, and back again.
fn light_space(library: &Library) -> f64 {
    let text = "#include \"light_space.glsl\"
        void check() { out0.xyz = to_light_space(p3.xyz); out1.xyz = from_light_space(to_light_space(p3.xyz)); }";
    Check::new(library, &[], text).holds(1e-6, |at| {
        let position = at.place(3);
        [in_light_space(at, position).to_array().as_slice(), &[0.0], &position.to_array()].concat()
    })
}

fn shadowed(library: &Library) -> f64 {
    let text = "#include <shadow>\nvoid check() { out0.xy = vec2(vec3(shadow(p0.x, p1.xyz)).x, vec3(shadow(p0.x, vec3(0.0))).y); }";
    let check = Check::new(library, &[("shadow", "volume")], text).given(|random, _| {
        [[0.5; 4], random.direction().extend(0.0).to_array(), [0.0; 4], random.eye().extend(0.0).to_array()]
    });
    check.holds(1e-6, |at| {
        let [l, _] = directions(at);
        let off = at.number("shadow_bias") * (at.place(1) + l);
        let asked = [at.place(3) + off, at.place(3)].map(|position| {
            let place = in_light_space(at, position);
            // Layer k of 9 is the light before segment k of 8.
            let side = at.number("shadow_side");
            let layer = (place.z * side + 0.5) / (side + 1.0);
            filtered(at.texture("shadow_image"), &[place.x, place.y, layer], Wrap::Clamp)[0]
        });
        asked.to_vec()
    })
}

fn environment(library: &Library, module: &str, formula: fn(&At<'_>) -> [f64; 4]) -> f64 {
    let text = "#include <environment>\nvoid check() { out0 = environment(p0.xyz, p1.xyz, p0.w); }";
    let check = Check::new(library, &[("environment", module)], text).with("object_matrix", &{
        let turned = glam::DMat4::from_rotation_x(0.4).to_cols_array();
        turned.map(|x| 1.25 * x)
    });
    let check = check.given(|random, _| {
        let from = random.in_cube(0.5).extend(random.unit().powi(4));
        [from.to_array(), random.direction().extend(0.0).to_array(), [0.0; 4], [0.0, 0.0, -1.0, 0.0]]
    });
    check.holds(1e-6, |at| formula(at).to_vec())
}

/// The part of [a, b] that stripes of width 1 with an even number cover, less that of odd ones, over its length.
fn stripes(middle: f64, width: f64) -> f64 {
    let width = width.max(c(1e-4));
    let (a, b) = (middle - width / 2.0, middle + width / 2.0);
    let stripe = |number: i64| {
        let covered = (b.min(number as f64 + 1.0) - a.max(number as f64)).max(0.0);
        if number % 2 == 0 { covered } else { -covered }
    };
    (a.floor() as i64..=b.floor() as i64).map(stripe).sum::<f64>() / width
}

/// A rectangle of light on a plane at distance 1: the part of a square footprint that it covers. The edge is as wide as the
/// narrowest footprint.
fn panel(p: DVec2, centers: &[[f64; 2]], half: [f64; 2], spread: f64) -> f64 {
    let width = c(0.03).max(spread * (1.0 + p.length_squared()));
    let covered = |center: &[f64; 2]| {
        let along = |axis: usize| {
            let side = c(half[axis]);
            let ends = [p[axis] - c(center[axis]) - width / 2.0, p[axis] - c(center[axis]) + width / 2.0];
            let [a, b] = ends.map(|end| end.clamp(-side, side));
            (b - a) / width
        };
        along(0) * along(1)
    };
    centers.iter().map(covered).sum()
}

fn studio(at: &At<'_>) -> [f64; 4] {
    let up = at.matrix("object_matrix").y_axis.truncate();
    let size = up.length();
    let up = up / size;
    let front = DVec3::X.cross(up);
    let level = |v: DVec3| DVec3::new(v.x, v.dot(up), v.dot(front));
    let (d, p) = (level(at.place(1)), level(at.place(0)));
    let mix = |a: DVec3, b: DVec3, t: f64| a + (b - a) * t;
    let mut light = mix(at.vector("horizon_color"), at.vector("backdrop_color"), smoothstep(0.0, c(0.45), d.y));
    if d.y < c(-1e-4) {
        let away = (p.y - at.vector("box_min").y * size) / -d.y;
        let hit = DVec2::new(p.x + away * d.x, p.z + away * d.z);
        let horizon = smoothstep(2.0, 14.0, hit.length());
        if horizon < 1.0 {
            let tile = at.number("tile_size");
            let footprint = away.abs() * at.p[0][3] / tile;
            let checks = stripes(hit.x / tile, footprint) * stripes(hit.y / tile, footprint / c(0.02).max(-d.y));
            let ground = mix(at.vector("tile_color_2"), at.vector("tile_color"), (1.0 + checks) / 2.0);
            light = mix(ground, at.vector("horizon_color"), horizon);
        } else {
            light = at.vector("horizon_color");
        }
    }
    let on = |a: f64, b: f64, depth: f64| DVec2::new(a, b) / depth.max(c(1e-3));
    let (spread, mut shine) = (at.p[0][3], 0.0);
    if d.x < 0.0 {
        // Two by two panes.
        let panes = [[0.09, 0.36], [0.61, 0.36], [0.09, 0.88], [0.61, 0.88]];
        shine += panel(on(d.z, d.y, -d.x), &panes, [0.205; 2], spread);
    } else if d.x > 0.0 {
        shine += c(0.6) * panel(on(d.z, d.y, d.x), &[[-0.3, 0.45]], [0.085, 0.735], spread);
    }
    if d.y > 0.0 {
        shine += c(0.8) * panel(on(d.x, d.z, d.y), &[[0.1, -0.2]], [0.685, 0.205], spread);
    }
    (light + at.number("studio_light") * shine).extend(1.0).to_array()
}
