//! Modules that bend and tint light.

use crate::formulas::harness::{At, Check};
use crate::formulas::values::{Random, Setting};
use glam::DVec3;
use hypertexture::shader::Library;

crate::rows! {
    p28_nothing_is_absorbed = |l| absorption(l, "none", |_| DVec3::ONE),
        "absorption/none.glsl": "vec3(1.0)" => "vec3(0.5)";
    p28_glass_tints_by_beers_law = |l| absorption(l, "tinted", |at| {
        at.vector("glass_color").max(DVec3::splat(1e-4)).powf(at.p[0][0] / at.number("tint_depth"))
    }),
        "absorption/tinted.glsl": "amount / tint_depth" => "amount * tint_depth";
    p28_light_goes_straight_between_interfaces = |l| ray_path(l, "straight", |_, x, along, path| (x + path * along, along)),
        "ray_path/straight.glsl": "path * ray.along" => "-path * ray.along";
    p28_light_oscillates_in_a_graded_fibre = |l| ray_path(l, "curved", fibre),
        "ray_path/curved.glsl": "a + 2.0 * b" => "a - 2.0 * b",
        "ray_path/curved.glsl": "a + 4.0 * b + c" => "a + 3.0 * b + c";
    p28_the_index_is_a_channel_of_the_color_table = index,
        "index/transfer.glsl": "t * (b.xy - a.xy)" => "t * (a.xy - b.xy)",
        "index/transfer.glsl": "density <= 0.0 ? -0.5 : 0.5" => "density <= 0.0 ? 0.5 : -0.5";
    p28_light_is_pulled_up_the_index = pull,
        "index/transfer.glsl": "at.value * at.slope" => "at.slope",
        "index/transfer.glsl": "return gradient / (2.0 * h)" => "return gradient / h";
}

fn absorption(library: &Library, module: &str, formula: fn(&At<'_>) -> DVec3) -> f64 {
    let text = "#include <absorption>\nvoid check() { out0.xyz = transmitted(p0.x); }";
    let check =
        Check::new(library, &[("absorption", module)], text).given(|random, _| [[random.within(0.0, 5.0); 4]; 4]);
    check.holds(1e-6, |at| formula(at).to_array().to_vec())
}

/// A step of a ray in a medium whose index n falls with the distance from the axis: n^2 = 4 - |x|^2, in eye space.
fn ray_path(library: &Library, module: &str, formula: fn(f64, DVec3, DVec3, f64) -> (DVec3, DVec3)) -> f64 {
    let text = "#include \"index_point.glsl\"
        struct Ray { vec3 at; vec3 along; vec3 bent; Index medium; };
        vec3 object_space(vec3 at) { return mat3(texture_matrix) * at; }
        // n grad n of the index by the place in object space, of which the normal matrix makes that in eye space.
        vec3 pull(vec3 x, Index medium) { return transpose(mat3(object_matrix)) * (mat3(object_matrix) * -x); }
        #include <ray_path>
        void check() {
            Ray ray = Ray(p0.xyz, p1.xyz, p0.xyz, Index(sqrt(4.0 - dot(p0.xyz, p0.xyz)), 1.0, 0.0, 0.5));
            ray = moved(ray, p2.x);
            out0.xyz = ray.at;
            out1.xyz = ray.along;
        }";
    let check = Check::new(library, &[("ray_path", module)], text).given(|random, _| {
        let path = if random.unit() < 0.5 { 0.02 * random.unit() } else { 0.02 };
        [
            random.in_cube(1.0).extend(0.0).to_array(),
            random.direction().extend(0.0).to_array(),
            [path; 4],
            [0.0, 0.0, -1.0, 0.0],
        ]
    });
    // A step of order 4 is off by about path^5 / 120; a path of 0.02 by 1e-10, and matrices are rounded to f32.
    check.holds(2e-9, |at| {
        let x = at.place(0);
        let (to, along) = formula((4.0 - x.length_squared()).sqrt(), x, at.place(1), at.p[2][0]);
        [to.to_array().as_slice(), &[0.0], &along.to_array()].concat()
    })
}

/// With dt = ds / n the ray obeys x'' = n grad n = -x: an oscillation. GLSL takes a step of path / n.
fn fibre(index: f64, x: DVec3, along: DVec3, path: f64) -> (DVec3, DVec3) {
    let (sine, cosine) = (path / index).sin_cos();
    (cosine * x + sine * index * along, (index * along * cosine - sine * x).normalize())
}

/// Entries of the index map with layers of four.
fn layered(random: &mut Random) -> hypertexture::eval::Texture {
    let entry = |i: u32, random: &mut Random| {
        [
            1.0 + random.unit() as f32,
            if (i / 4).is_multiple_of(2) { random.within(0.5, 2.0) as f32 } else { 0.0 },
            (i / 4) as f32,
            0.0,
        ]
    };
    hypertexture::eval::Texture { size: [16, 1, 1], texels: (0..16).map(|i| entry(i, random)).collect() }
}

/// A point in or around the soft region of the unit sphere.
fn around(random: &mut Random, _: &Setting) -> [[f64; 4]; 4] {
    [(random.direction() * random.within(0.5, 1.8)).extend(0.0).to_array(); 4]
}

fn density(at: &At<'_>, x: DVec3) -> f64 {
    let (inner, outer) = (at.number("iso_value"), at.number("outer_iso_value"));
    ((outer + 1.0 - x.length()) / (outer - inner)).clamp(0.0, 1.0)
}

/// Index, slope and layer at a density: linear within a layer, the nearer entry between two.
fn entry(at: &At<'_>, density: f64) -> [f64; 3] {
    let texels = &at.texture("index_image").texels;
    let place = density * 15.0;
    let low = (place.floor() as usize).min(14);
    let (t, [a, b]) = (place - low as f64, [low, low + 1].map(|i| texels[i].map(f64::from)));
    let nearer = if t < 0.5 { a } else { b };
    let [mut index, mut slope, mut layer] = [nearer[0], nearer[1], nearer[2]];
    if a[2] == b[2] {
        (index, slope) = ((1.0 - t) * a[0] + t * b[0], (1.0 - t) * a[1] + t * b[1]);
    }
    if slope != 0.0 && (density == 0.0 || density == 1.0) {
        layer += density - 0.5; // the density has an end, and so has what follows it
        slope = 0.0;
    }
    index = index.max(1.0);
    [index, slope, layer]
}

fn index(library: &Library) -> f64 {
    let text = "#include <clip>\n#include <index>
        void check() { Index i = index_at(p0.xyz); out0 = vec4(i.value, i.slope, i.layer, i.density); }";
    let check = Check::new(library, &[], text).with_texture("index_image", layered(&mut Random::new(1, "index")));
    check.given(around).holds(1e-9, |at| {
        let density = density(at, at.place(0));
        [entry(at, density).as_slice(), &[density]].concat()
    })
}

/// n grad n within the soft region, where the slope of the density is -1 / width along the normal, and the normals of an
/// interface there.
fn pull(library: &Library) -> f64 {
    let text = "#include <clip>\n#include <index>
        void check() {
            vec3 face;
            out0.xyz = pull(p0.xyz, index_at(p0.xyz));
            out1.xyz = interface_normal(p0.xyz, p0.xyz, face);
            out1.w = length(cross(normalize(face), out1.xyz));
        }";
    let check = Check::new(library, &[], text).with_texture("index_image", layered(&mut Random::new(1, "index")));
    check.given(around).worst(|at, found| {
        let x = at.place(0);
        let width = at.number("outer_iso_value") - at.number("iso_value");
        let from_end = (x.length() - 1.0 - at.number("iso_value"))
            .abs()
            .min((x.length() - 1.0 - at.number("outer_iso_value")).abs());
        let [index, slope, _] = entry(at, density(at, x));
        let expected = -index * slope / width * x.normalize();
        let off = (DVec3::from_slice(&found) - expected).length() / (1.0 + expected.length());
        let normal = (DVec3::from_slice(&found[4..]) - x.normalize()).length();
        let face = found[7]; // a difference is off by its square, 1e-6
        // A difference that reaches beyond an end of the soft region is of both sides.
        (if from_end > 0.03 { off } else { 0.0 }).max(normal).max(0.01 * face) / 1e-8
    })
}
