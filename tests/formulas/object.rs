//! Objects, the way down to their surface, and what is sampled of them.

use crate::formulas::density::smoothstep;
use crate::formulas::dual::{Dual, Place, length, place, scaled, slope, value};
use crate::formulas::harness::Check;
use crate::formulas::knots::noise;
use crate::formulas::values::{Random, SIDE, c, filtered, image};
use glam::DVec3;
use hypertexture::eval::Wrap;
use hypertexture::shader::Library;

crate::rows! {
    m11_a_sphere_is_its_distance_and_slope = |l| formula(l, "sphere", sphere),
        "object/sphere.glsl": "length(x) - 1.0" => "length(x) + 1.0";
    p03_a_cube_is_its_distance_and_slope = |l| formula(l, "cube", cube),
        "object/cube.glsl": "length(outside) + inside" => "length(outside) - inside",
        "object/cube.glsl": "q.y > q.x && q.y >= q.z" => "q.y > q.x && q.y <= q.z";
    p03_a_torus_is_its_distance_and_slope = |l| formula(l, "torus", torus),
        "object/torus.glsl": "vec3(x.x, 0.0, x.z)" => "vec3(x.x, x.y, x.z)";
    m22_a_volume_has_the_normal_in_rgb_and_the_distance_in_a = packed,
        "object/normals.glsl": "2.0 * v.rgb - 1.0" => "v.rgb",
        "object/normals.glsl": "distance_decode.x + " => "distance_decode.x - ";
    m07_a_lean_volume_has_the_slope_of_its_distance = lean,
        "object/distance.glsl": "volume_scale.xyz / (2.0 * volume_texel.xyz)" => "volume_scale.xyz / volume_texel.xyz",
        "object/distance.glsl": "volume_distance(tex_coord - w)" => "volume_distance(tex_coord + w)";
    m47_a_sample_is_displaced_and_softened = sampled,
        "sample.glsl": "transpose(jacobian)" => "(jacobian)",
        "sample.glsl": "object(displaced)" => "object(x)",
        "sample.glsl": "object(shaded)" => "object(x)";
    p32_the_foot_on_a_formula_lies_on_the_inner_surface = |l| feet(l, "formula"),
        "project/formula.glsl": "surface.distance - iso_value" => "surface.distance + iso_value";
    p32_the_foot_along_the_gradient_lies_on_the_inner_surface = |l| feet(l, "gradient"),
        "project/gradient.glsl": "at.distance - iso_value" => "at.distance + iso_value",
        "project/gradient.glsl": "sample_object(x)" => "s";
    p32_a_foot_is_trusted_where_the_gradient_is_whole = trusted,
        "project/gradient.glsl": "smoothstep(0.35, 0.85" => "smoothstep(0.85, 0.35",
        "project/gradient.glsl": "= at.coherence" => "= s.coherence";
    p55_closest_points_of_a_plane_are_its_feet = flat,
        "project/closest.glsl": "far - dot(down" => "far + dot(down",
        "project/closest.glsl": "return x + sum" => "return x - sum";
    p55_between_two_planes_the_nearer_foot_counts = corner,
        "project/closest.glsl": "dot(b, b) < dot(a, a)" => "dot(b, b) > dot(a, a)",
        "project/closest.glsl": "2.5 * voxel" => "25.0 * voxel";
    a_vector_without_a_direction_is_given_one = normalized,
        "vector.glsl": "bvec3(n2 < 1e-12)" => "bvec3(n2 > 1e-12)";
}

pub fn sphere(x: Place) -> Dual {
    length(x) - 1.0
}

/// The distance to [-1, 1]^3.
pub fn cube(x: Place) -> Dual {
    let beyond = x.map(|c| c.abs() - 1.0);
    if beyond.iter().any(|c| c.v > 0.0) {
        length(beyond.map(|c| c.max(0.0)))
    } else {
        beyond[0].max(beyond[1]).max(beyond[2])
    }
}

/// The torus with radii 0.7 and 0.3 around y.
pub fn torus([x, y, z]: Place) -> Dual {
    let from_ring = (x * x + z * z).sqrt() - c(0.7);
    (from_ring * from_ring + y * y).sqrt() - c(0.3)
}

const OBJECT: &str =
    "#include <object>\nvoid check() { Surface found = object(p0.xyz); out0 = vec4(found.normal, found.distance); }";

/// The normal is the derivative of the distance.
fn formula(library: &Library, object: &str, distance: fn(Place) -> Dual) -> f64 {
    Check::new(library, &[("object", object)], OBJECT).holds(1e-9, |at| {
        let distance = distance(place(at.place(0)));
        [distance.d.to_array().as_slice(), &[distance.v]].concat()
    })
}

fn packed(library: &Library) -> f64 {
    Check::new(library, &[("object", "normals")], OBJECT).holds(1e-9, |at| {
        let p = at.vector("volume_scale") * at.place(0) + at.vector("volume_offset");
        let texel = filtered(at.texture("volume_image"), &p.to_array(), Wrap::Clamp);
        let decode = at.vector("distance_decode");
        let normal = [0, 1, 2].map(|axis| (texel[axis] - 0.5) * 2.0);
        [normal.as_slice(), &[decode.x + decode.y * texel[3]]].concat()
    })
}

/// A distance that changes as much from texel to texel everywhere: by 2, 3 and 5 of 64 codes.
const RISE: DVec3 = DVec3::new(2.0, 3.0, 5.0);

fn lean(library: &Library) -> f64 {
    let side = f64::from(SIDE);
    let code = move |p: DVec3| ((p * side - 0.5).dot(RISE) + 1.0) / 64.0;
    Check::new(library, &[("object", "distance")], OBJECT)
        .with_texture("volume_image", image([SIDE; 3], |p| [code(p), 0.0, 0.0, 0.0]))
        .given(|random, setting| {
            // One texel off the border.
            let p = DVec3::splat(0.5) + random.in_cube(0.24);
            let x = (p - setting.vector("volume_offset")) / setting.vector("volume_scale");
            [x.extend(0.0).to_array(); 4]
        })
        .holds(1e-6, |at| {
            let (scale, decode) = (at.vector("volume_scale"), at.vector("distance_decode"));
            let slope = decode.y * RISE * side / 64.0 * scale;
            let distance = decode.x + decode.y * code(scale * at.place(0) + at.vector("volume_offset"));
            [slope.to_array().as_slice(), &[distance]].concat()
        })
}

/// PH 2.4: D(x (1 + a noise(f x))), with the gradient of the distance through the warp.
fn sampled(library: &Library) -> f64 {
    let text = "#include \"sample.glsl\"
        void check() {
            Sample s = sample_object(p0.xyz);
            out0 = vec4(s.normal, s.distance);
            out1 = vec4(s.density, s.x);
        }";
    let slots = [("object", "torus"), ("warp", "noisy"), ("softness", "linear")];
    let check = Check::new(library, &slots, text).given(|random, _| [random.in_cube(0.55).extend(0.0).to_array(); 4]);
    check.holds(1e-8, |at| {
        let x = place(at.place(0));
        let amount = noise(scaled(x, at.number("frequency"))) * at.number("amplitude");
        let distance = torus(scaled(x, amount + 1.0));
        let (inner, outer) = (at.number("iso_value"), at.number("outer_iso_value"));
        let density = ((outer - distance.v) / (outer - inner)).clamp(0.0, 1.0);
        let normal = distance.d.normalize();
        [normal.to_array().as_slice(), &[distance.v, density], &at.p[0][..3]].concat()
    })
}

/// The foot of a point is where the torus with an inner radius of 0.3 + iso is the nearest, wherever the sample is that the
/// point was displaced from.
fn feet(library: &Library, project: &str) -> f64 {
    let text = "#include \"sample.glsl\"\n#include <project>
        void check() {
            Sample s = sample_object(p1.xyz);
            out0.xyz = project(p0.xyz, s);
            out0.w = trust(s);
        }";
    let check = Check::new(library, &[("object", "torus"), ("project", project)], text).given(|random, _| {
        let x = random.in_cube(2.0);
        let from = x + 0.4 * random.direction();
        [x.extend(0.0).to_array(), from.extend(0.0).to_array(), [0.0; 4], [0.0, 0.0, -1.0, 0.0]]
    });
    check.holds(1e-9, move |at| {
        let x = at.place(0);
        let ring = DVec3::new(x.x, 0.0, x.z).normalize() * c(0.7);
        let foot = ring + (x - ring).normalize() * (c(0.3) + at.number("iso_value"));
        [foot.to_array().as_slice(), &[1.0]].concat()
    })
}

/// Between voxels whose normals differ the filtered one is short.
fn trusted(library: &Library) -> f64 {
    let text = "#include \"sample.glsl\"\n#include <project>
        void check() { Sample s = sample_object(p1.xyz); project(p0.xyz, s); out0.x = trust(s); }";
    Check::new(library, &[("object", "normals"), ("project", "gradient")], text).holds(1e-6, |at| {
        let p = at.vector("volume_scale") * at.place(0) + at.vector("volume_offset");
        let texel = filtered(at.texture("volume_image"), &p.to_array(), Wrap::Clamp);
        let normal = DVec3::from_array([0, 1, 2].map(|axis| (texel[axis] - 0.5) * 2.0));
        vec![smoothstep(c(0.35), c(0.85), normal.length())]
    })
}

const VOXELS: u32 = 16;
/// A volume of closest points from -2 to 2.
const PLACE: [(&str, [f64; 3]); 3] =
    [("volume_scale", [0.25; 3]), ("volume_offset", [0.5; 3]), ("volume_texel", [1.0 / VOXELS as f64; 3])];
const RANGE: f64 = 4.0;

/// The feet that a volume of ways gives.
fn closest(library: &Library, normal: DVec3, way: impl Fn(DVec3) -> DVec3) -> Check {
    let text = "#include \"sample.glsl\"\n#include <project>
        void check() { Sample s; s.normal = p1.xyz; out0.xyz = project(p0.xyz, s); out0.w = trust(s); }";
    let texel = |p: DVec3| (0.5 + way(4.0 * p - 2.0) / (2.0 * RANGE)).extend(1.0).to_array();
    let check = Check::new(library, &[("object", "sphere"), ("project", "closest")], text);
    let check = PLACE.iter().fold(check, |check, (name, value)| check.with(name, value));
    check.with("closest_range", &[RANGE]).with_texture("closest_image", image([VOXELS; 3], texel)).given(
        move |random, _| {
            let [x, normal] = [random.in_cube(1.8), normal].map(|v| v.extend(0.0).to_array());
            [x, normal, normal, [0.0, 0.0, -1.0, 0.0]]
        },
    )
}

/// Where the surface is flat, each voxel knows the foot of every point: ways are rounded to f32 alone. A voxel that is
/// nearer to the plane than 1/1024 of the range knows no side of it, and points beside it are left out.
fn flat(library: &Library) -> f64 {
    let mut random = Random::new(0, "planes");
    let worst = (0..4).map(|_| {
        let (normal, offset) = (random.direction(), random.within(-0.5, 0.5));
        let height = move |x: DVec3| x.dot(normal) - offset;
        let check = closest(library, normal, move |x| -height(x) * normal);
        let voxels = f64::from(VOXELS) / 4.0;
        check.worst(move |at, found| {
            let x = at.place(0);
            let low = ((x + 2.0) * voxels - 0.5).floor();
            let corners = (0..8).map(|i| low + DVec3::from_array([0, 1, 2].map(|axis| f64::from(i >> axis & 1u8))));
            let nearest =
                corners.map(|corner| height((corner + 0.5) / voxels - 2.0).abs()).fold(f64::INFINITY, f64::min);
            let off = (DVec3::from_slice(&found) - (x - height(x) * normal)).length();
            if nearest < 1.01 * RANGE / 1024.0 { 0.0 } else { off.max((found[3] - 1.0).abs()) / 4e-6 }
        })
    });
    worst.fold(0.0, f64::max)
}

/// Between two planes that face each other a foot is on one or the other, on the nearer one: nothing is mixed.
fn corner(library: &Library) -> f64 {
    let foot = |x: DVec3| DVec3::new(x.x, 1.5f64.copysign(x.y), x.z);
    closest(library, DVec3::Y, |x| foot(x) - x).holds(4e-6, |at| foot(at.place(0)).extend(1.0).to_array().to_vec())
}

fn normalized(library: &Library) -> f64 {
    let text = "void check() { out0.xyz = safe_normalize(p0.xyz, p1.xyz); }";
    let check = Check::new(library, &[], text).given(|random, _| {
        let length = if random.unit() < 0.3 { 0.99e-6 } else { 10f64.powf(random.within(-5.9, 6.0)) };
        let [v, otherwise] = [random.direction() * length, random.vector()];
        [v.extend(0.0).to_array(), otherwise.extend(0.0).to_array(), [0.0; 4], [0.0, 0.0, -1.0, 0.0]]
    });
    check.holds(1e-9, |at| {
        let v = at.place(0);
        let expected = if v.length() < 1e-6 { at.place(1) } else { v / v.length() };
        expected.to_array().to_vec()
    })
}

/// Basis of all slopes in this file.
#[test]
fn dual_numbers_differentiate() {
    let x = DVec3::new(0.3, -0.8, 1.7);
    let f = |x: Place| [torus(x), cube(x), sphere(x) / (length(x) + 0.5)];
    let (h, along) = (1e-6, DVec3::new(0.6, -0.5, 0.62));
    let numeric = (value(f(place(x + h * along))) - value(f(place(x - h * along)))) / (2.0 * h);
    assert!((numeric - slope(f(place(x)), along)).length() < 1e-8);
}
