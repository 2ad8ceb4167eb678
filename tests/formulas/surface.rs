//! Appearance of a hard surface.

use crate::formulas::dual::{Dual, place};
use crate::formulas::harness::{At, COLOR, Check};
use crate::formulas::knots::{noise, turbulence};
use crate::formulas::light::{lit, phong, to_eye_space};
use crate::formulas::values::{c, filtered};
use glam::{DMat3, DVec3};
use hypertexture::eval::Wrap;
use hypertexture::shader::Library;

crate::rows! {
    m25_m28_lit_is_the_material_under_the_light = |l| surface(l, "lit", |at| phong(at, material(at), at.place(1))),
        "surface/lit.glsl": "color.rgb * material_color.rgb" => "material_color.rgb",
        "lighting.glsl": "max(dot(n, l), 0.0)" => "abs(dot(n, l))",
        "lighting.glsl": "safe_normalize(l + to_eye()" => "safe_normalize(l - to_eye()";
    m51_unlit_is_the_material = |l| surface(l, "unlit", material),
        "surface/unlit.glsl": "color.rgb * material_color.rgb" => "material_color.rgb";
    m45_a_solid_texture_is_lit = |l| surface(l, "solid", |at| phong(at, marble(at), at.place(1))),
        "surface/solid.glsl": "s.normal" => "-s.normal",
        "solid_texture.glsl": "distortion * 0.3" => "distortion * 0.4",
        "transfer/map.glsl": "(size - 1.0) + 0.5" => "size + 0.5";
    m45_a_solid_texture_is_unlit = |l| surface(l, "solid_unlit", marble),
        "surface/solid_unlit.glsl": "s.x" => "-s.x";
    m46_a_bump_is_the_normal_of_k_v_plus_b = |l| surface(l, "bump", |at| lit(at, material(at), bump_normal(at))),
        "surface/bump.glsl": "bump_normal(s)" => "s.normal",
        "bump_normal.glsl": "k * v + b" => "k * b + v",
        "bump_normal.glsl": "bump_frequency * s.x" => "s.x",
        "bump_normal.glsl": "eye_normal(b)" => "b",
        "bump_normal.glsl": "eye_normal(s.normal), eye_normal(b), bump_scale" => "s.normal, b, bump_scale",
        "eye_normal.glsl": "mat3(normal_matrix) * normal" => "normal";
    m46_bump_normals_are_colors = |l| surface(l, "bump_normals", |at| {
        let back = DMat3::from_mat4(at.matrix("normal_matrix")).inverse() * bump_normal(at);
        (back.normalize() + 1.0) / 2.0
    }),
        "surface/bump_normals.glsl": "return 0.5 + 0.5" => "return 0.5 - 0.5";
    m41_a_slice_of_noise_is_grey = |l| surface(l, "noise", |at| DVec3::splat(((1.0 + sliced(at).v) / 2.0).powi(2))),
        "surface/noise.glsl": "texel * texel" => "texel",
        "plane_point.glsl": "vec3(s.x.xy, plane_z)" => "s.x";
    m41_m40_the_gradient_of_noise_is_a_color = |l| surface(l, "noise_gradient", |at| {
        let normal = (sliced(at).d.normalize() + 1.0) / 2.0;
        normal * normal
    }),
        "surface/noise_gradient.glsl": "texel * texel" => "texel";
    m23_normals_are_colors = |l| surface(l, "normals", |at| (at.place(1) + 1.0) / 2.0),
        "surface/normals.glsl": "0.5 + 0.5" => "0.5 - 0.5";
    m23_texture_coordinates_are_colors = |l| surface(l, "tex_coord", |at| {
        let (low, high) = (at.vector("own_min"), at.vector("own_max"));
        (at.place(0) - low) / (high - low)
    }),
        "surface/tex_coord.glsl": "s.x - own_min.xyz" => "s.x + own_min.xyz";
    overhangs_and_thin_walls_have_colors = printable,
        "surface/printable.glsl": "-sin(" => "sin(",
        "surface/printable.glsl": "s.x - depth" => "s.x + depth",
        "surface/printable.glsl": "most * float(step)" => "float(step)";
    m46_a_bump_without_a_direction_keeps_the_normal = cancelled,
        "bump_normal.glsl": "safe_normalize(k * v + b, v)" => "normalize(k * v + b)";
}

/// A sample with a place, a unit normal, and a wide one that is shorter.
pub const SAMPLE: &str = "#include \"sample_point.glsl\"\nSample given() {
    Sample s;
    s.x = p0.xyz; s.distance = p0.w; s.normal = p1.xyz; s.shading = p2.xyz; s.coherence = 1.0; s.density = p2.w;
    s.wide_normal = 0.75 * p2.xyz;
    return s;
}\n";

/// The inputs of [`SAMPLE`]: a place within 1000 of the origin, two unit vectors, densities.
pub fn sample(random: &mut crate::formulas::values::Random, _: &crate::formulas::values::Setting) -> [[f64; 4]; 4] {
    let density = random.density().clamp(0.0, 1.0);
    [
        random.vector().extend(0.0).to_array(),
        random.direction().extend(random.density().clamp(0.0, 1.0)).to_array(),
        random.direction().extend(density).to_array(),
        random.eye().extend(0.0).to_array(),
    ]
}

fn surface(library: &Library, module: &str, formula: fn(&At<'_>) -> DVec3) -> f64 {
    let text = format!("{SAMPLE}#include <surface>\nvoid check() {{ out0.xyz = surface(given()); }}");
    let check = Check::new(library, &[("surface", module)], &text).given(sample);
    check.holds(2e-8, |at| formula(at).to_array().to_vec())
}

pub fn material(at: &At<'_>) -> DVec3 {
    COLOR * at.vector("material_color")
}

/// The transfer map at a density.
pub fn transfer(at: &At<'_>, density: f64) -> [f64; 4] {
    let texture = at.texture("transfer_image");
    let size = f64::from(texture.size[0]);
    // The ends of the map are at the centers of its first and last texel.
    filtered(texture, &[(0.5 + density * (size - 1.0)) / size], Wrap::Clamp)
}

/// MJ 5.1: marble, whose veins the turbulence bends; without veins the turbulence itself.
pub fn marble(at: &At<'_>) -> DVec3 {
    let x = at.place(0);
    let t = turbulence(place(at.number("grain") * x)).v;
    let along = x.dot(DVec3::new(c(0.8), 0.5, c(0.33)));
    let veins = at.number("veins");
    let wave = (c(std::f64::consts::PI) * veins * (along + at.number("distortion") * c(0.3) * t)).sin();
    let value = if veins > 0.0 { (1.0 + wave) / 2.0 } else { (c(0.6) * t).clamp(0.0, 1.0) };
    DVec3::from_slice(&transfer(at, value))
}

/// MJ 5.2, Eq. 7: both normals are in eye space before they are added.
pub fn bump_normal(at: &At<'_>) -> DVec3 {
    let b = noise(place(at.number("bump_frequency") * at.place(0))).d;
    (at.number("bump_scale") * to_eye_space(at, at.place(1)) + to_eye_space(at, b)).normalize()
}

/// MJ 4.1, Fig. 5: the noise on a plane of z, by the cell.
fn sliced(at: &At<'_>) -> Dual {
    let [x, y, ..] = at.p[0];
    noise(place(at.number("plane_frequency") * DVec3::new(x, y, at.number("plane_z"))))
}

/// Where k V + B is nothing, V stands.
fn cancelled(library: &Library) -> f64 {
    let text =
        format!("{SAMPLE}#include <surface>\nvoid check() {{ out0.xyz = bumpmap(p1.xyz, -p2.x * p1.xyz, p2.x); }}");
    let check = Check::new(library, &[("surface", "bump")], &text).given(sample);
    check.holds(1e-9, |at| at.p[1][..3].to_vec())
}

/// A print of the unit sphere: its undersides, and what has the other side near.
fn printable(library: &Library) -> f64 {
    let text = format!("{SAMPLE}#include <surface>\nvoid check() {{ out0.xyz = surface(given()); }}");
    let check = Check::new(library, &[("surface", "printable")], &text).given(|random, setting| {
        let mut p = sample(random, setting);
        p[0] = (random.direction() * random.within(0.2, 1.0)).extend(0.0).to_array();
        p
    });
    check.holds(2e-8, |at| {
        let (x, normal) = (at.place(0), at.place(1));
        let hangs = normal.y < -at.number("overhang_angle").to_radians().sin();
        let depths = (1..=8).map(|step| at.number("least_wall") * f64::from(step) / 8.0);
        let thin = depths.into_iter().any(|depth| (x - depth * normal).length() - 1.0 > at.number("iso_value"));
        let own = match (hangs, thin) {
            (true, true) => DVec3::new(c(0.4), c(0.07), c(0.4)),
            (true, false) => DVec3::new(c(0.8), c(0.05), c(0.03)),
            (false, true) => DVec3::new(c(0.03), c(0.1), c(0.8)),
            (false, false) => material(at),
        };
        phong(at, own, normal).to_array().to_vec()
    })
}
