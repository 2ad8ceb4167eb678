//! Fur, tribble and cloth: what grows on a surface, and how it is lit.

use crate::formulas::density::{bias, gain, mix};
use crate::formulas::dual::{Place, moved, place, scaled, value};
use crate::formulas::groom::{Painted, mixed, narrowed, painted};
use crate::formulas::harness::{At, COLOR, Check};
use crate::formulas::knots::{noise, vector_noise};
use crate::formulas::light::{directions, phong, to_eye_space};
use crate::formulas::values::{Random, Setting, c};
use glam::{DVec2, DVec3};
use hypertexture::shader::Library;

crate::rows! {
    p31_fur_is_gain_of_bias_of_noise_at_the_root = |l| hairs(l, &[("dmf", "fur")], fur),
        "dmf/fur.glsl": "gain(hair_gain, bias(hair_bias" => "gain(hair_bias, bias(hair_gain",
        "dmf/fur.glsl": "s.x + vec3(0.0, droop" => "s.x - vec3(0.0, droop",
        "dmf/fur.glsl": "s.hair_normal - vec3(0.0, 2.0 * droop" => "s.hair_normal + vec3(0.0, 2.0 * droop",
        "dmf/fur.glsl": "= unevenness * clamp" => "= -unevenness * clamp",
        "dmf/fur.glsl": "s.hair_length = hair_length" => "s.hair_length = 0.2";
    fur_is_cut_thinned_and_combed = |l| hairs(l, &[("dmf", "fur"), ("groom", "volume")], fur),
        "dmf/fur.glsl": "groomed(- hair_length" => "groomed(+ hair_length",
        "dmf/fur.glsl": "groomed(+ 2.0 * tip" => "groomed(- 2.0 * tip",
        "dmf/fur.glsl": "groom_length(root) * (1.0 - shorter)" => "groom_length(s.x) * (1.0 - shorter)",
        "dmf/fur.glsl": "groom_density(root) - 1.0" => "1.0 - groom_density(root)",
        "dmf/fur.glsl": "clamp(groom_length(root), 0.1" => "clamp(groom_length(root), 0.9";
    fur_bends_in_the_wind = |l| hairs(l, &[("dmf", "fur"), ("wind", "breeze")], fur),
        "dmf/fur.glsl": "windy(- hair_length" => "windy(+ hair_length",
        "dmf/fur.glsl": "windy(+ 2.0" => "windy(- 2.0",
        "wind/breeze.glsl": "0.0, -sin(radians" => "0.0, sin(radians",
        "wind/breeze.glsl": "- 2.0 * turns" => "- turns";
    tribble_bends_in_the_wind = |l| hairs(l, &[("dmf", "tribble"), ("wind", "breeze")], tribble),
        "dmf/tribble.glsl": "windy(- tribble_length" => "windy(+ tribble_length",
        "dmf/tribble.glsl": "windy(bend -=" => "windy(bend +=";
    without_wind_nothing_is_bent = |l| hairs(l, &[("dmf", "fur")], fur),
        "wind/none.glsl": "windy(code)" => "windy(code) * 2.0";
    tribble_is_cut_thinned_and_combed = |l| hairs(l, &[("dmf", "tribble"), ("groom", "volume")], tribble),
        "dmf/tribble.glsl": "groomed(- tribble_length" => "groomed(+ tribble_length",
        "dmf/tribble.glsl": "bend -= 2.0" => "bend += 2.0",
        "dmf/tribble.glsl": "groom_depth(density, root)" => "density",
        "dmf/tribble.glsl": "groom_density(root) - 1.0" => "1.0 - groom_density(root)";
    p34_tribble_curls_towards_its_tips = |l| hairs(l, &[("dmf", "tribble")], tribble),
        "dmf/tribble.glsl": "s.x + strength * curl" => "s.x - strength * curl",
        "dmf/tribble.glsl": "gain(0.9, bias(0.3" => "gain(0.3, bias(0.9",
        "dmf/tribble.glsl": "s.normal - bend" => "s.normal + bend",
        "dmf/tribble.glsl": "s.hair_length = tribble_length" => "s.hair_length = 0.2";
    hair_is_painted = |l| hair(l, &[("medium", "hair"), ("groom", "volume")]),
        "medium/hair.glsl": "groom_color(base, s.root)" => "groom_color(base, s.x)";
    p56_hair_is_lit_as_a_thin_cylinder = |l| hair(l, &[("medium", "hair")]),
        "medium/hair.glsl": "sin_tl * sin_tv - tl * tv" => "tl * tv + sin_tl * sin_tv",
        "medium/hair.glsl": "lit * sin_tl" => "lit * tl",
        "medium/hair.glsl": "0.2 / max(s.hair_length, 0.005)" => "1.0";
    cloth_is_worn_where_it_is_thin = |l| cloth(l, &GROOMED, false),
        "dmf/woven.glsl": "1.0 - groom_density(s.root)" => "groom_density(s.root)";
    cloth_is_painted = |l| cloth(l, &GROOMED, true),
        "medium/cloth.glsl": "groom_color(base, s.root)" => "groom_color(base, s.x)";
    p58_woven_threads_go_over_and_under = |l| cloth(l, &GROOMED[..2], false),
        "dmf/woven.glsl": "-up * half_wave(part.x)" => "up * half_wave(part.x)",
        "dmf/woven.glsl": "mod(number.x + number.y, 2.0)" => "mod(number.x, 2.0)",
        "dmf/woven.glsl": "floor(0.3 * pairs)" => "floor(0.4 * pairs)";
    angles_and_waves_without_device_functions = turns,
        "turns.glsl": "0.25 - turns" => "0.25 + turns",
        "turns.glsl": "0.5 - turns" => "turns",
        "turns.glsl": "0.000366053864" => "0.000367053864",
        "turns.glsl": "0.0239636544" => "0.0249636544";
    p58_cloth_has_threads_of_two_colors = |l| cloth(l, &GROOMED[..2], true),
        "medium/cloth.glsl": "depth.x > depth.y" => "depth.x < depth.y",
        "medium/cloth.glsl": "1.0, 0.35, buried" => "0.35, 1.0, buried";
}

/// Slots of cloth, and of a groom.
const GROOMED: [(&str, &str); 3] = [("dmf", "woven"), ("medium", "cloth"), ("groom", "volume")];

/// A sphere with hair: the density, and normal and tangent of the hair that it leaves.
/// Bias and gain of constants are rounded to f32, and up to 200 hairs a unit enlarge that.
fn hairs(library: &Library, slots: &[(&str, &str)], formula: fn(&At<'_>) -> (f64, DVec3, DVec3, f64)) -> f64 {
    let text = "#include \"sample.glsl\"\n#include <dmf>
        void check() {
            Sample s = sample_object(p0.xyz);
            out0.x = HAIR(s.density, s);
            if (s.density < 1.0) { out0.yzw = s.hair_normal; out1 = vec4(s.hair_tangent, s.hair_length); }
        }";
    let check = Check::new(library, slots, &text.replace("HAIR", slots[0].1))
        .given(|random, _| [(random.direction() * random.within(0.6, 1.8)).extend(0.0).to_array(); 4]);
    check.holds(1e-5, move |at| {
        if distance(at) <= at.number("iso_value") {
            return vec![1.0];
        }
        let (density, normal, tangent, length) = formula(at);
        [&[density], normal.to_array().as_slice(), &tangent.to_array(), &[length]].concat()
    })
}

pub fn distance(at: &At<'_>) -> f64 {
    at.place(0).length() - 1.0
}

/// D, outside of the core.
pub fn density(at: &At<'_>) -> f64 {
    let (inner, outer) = (at.number("iso_value"), at.number("outer_iso_value"));
    ((outer - distance(at)) / (outer - inner)).clamp(0.0, 1.0)
}

/// PH 2.4: perpendicularly down to the inner surface, a sphere.
fn project(at: &At<'_>, x: DVec3) -> DVec3 {
    x.normalize() * (1.0 + at.number("iso_value"))
}

/// The noise of PH is signed, its bias and gain want [0, 1]: 0.5 + 0.5 noise, of which a contrast makes more, and a groom more
/// or less.
fn strand(of: DVec3, frequency: f64, contrast: f64, [b, g]: [f64; 2], groom: &Painted) -> f64 {
    gain(g, bias(b, (contrast * noise(place(frequency * of)).v + groom.density) / 2.0))
}

/// Three waves of gusts, which pass once, twice and three times in a period; 0 in programs without wind.
fn wind(at: &At<'_>, x: DVec3) -> DVec3 {
    if !at.declares("wind_strength") {
        return DVec3::ZERO;
    }
    let heading = at.number("wind_heading").to_radians();
    let ahead = DVec3::new(heading.cos(), 0.0, -heading.sin());
    let aside = DVec3::new(heading.sin(), 0.0, heading.cos());
    let (size, turns) = (at.number("gust_size"), (at.number("time") / at.number("wind_period")).rem_euclid(1.0));
    let (along, across) = (x.dot(ahead) / size, (x.dot(aside) + c(0.4) * x.y) / size);
    let wave = |phase: f64| (c(std::f64::consts::TAU) * phase).sin();
    let once = wave(along - turns);
    let twice = wave(c(1.7) * along + c(0.9) * across - 2.0 * turns + c(0.16));
    let thrice = wave(c(2.9) * along - c(1.3) * across - 3.0 * turns + c(0.32));
    let gust = c(0.6) + c(0.2) * once + c(0.12) * twice + c(0.08) * thrice;
    let sway = c(0.2) * twice + c(0.12) * thrice + c(0.08) * once;
    at.number("wind_strength") * (gust * ahead + sway * aside)
}

/// PH 2.4: f = gain.9(bias.3(noise(freq project(x)))) D(x), of a hair that has been bent by gravity and curled, that is
/// known by its middle, and that is shorter than others by a noise of its own.
fn fur(at: &At<'_>) -> (f64, DVec3, DVec3, f64) {
    let (x, d, length) = (at.place(0), density(at), at.number("hair_length"));
    let tip = 1.0 - d;
    let curl = noise(moved(scaled(place(x), 3.0), DVec3::splat(17.0))).d / 3.0;
    let curled = at.number("curliness") / 2.0 * gain(c(0.8), tip) * curl;
    let comb = painted(at, project(at, x)).direction + wind(at, x);
    let straight = x + curled + (DVec3::Y * at.number("droop") - comb) * length * tip.powi(2);
    let root = project(at, straight);
    let normal = (straight - root).normalize();
    let tangent = (normal - 2.0 * tip * (DVec3::Y * at.number("droop") - comb)).normalize();
    let groom = painted(at, root);
    let middle = root + normal * length * at.number("hair_middle");
    let fineness = at.number("fineness");
    let shorter = (0.5 + noise(place(c(0.23) * fineness * middle)).v).clamp(0.0, 1.0);
    let own = ((1.0 - at.number("unevenness") * shorter) * groom.length).clamp(1.0 - c(0.999), 1.0);
    let grown = ((own - tip) / own).max(0.0);
    let shape = [at.number("hair_bias"), at.number("hair_gain")];
    let strand = strand(middle, fineness, at.number("hair_contrast"), shape, &groom);
    (strand * grown, normal, tangent, length * groom.length.clamp(c(0.1), 1.0))
}

/// PH 2.4: x' = x + gain.8(1 - d) curliness vnoise(x), so that a hair is straight at its root.
fn tribble(at: &At<'_>) -> (f64, DVec3, DVec3, f64) {
    let (x, d) = (at.place(0), density(at));
    let (tip, frequency, curliness) = (1.0 - d, at.number("curl_frequency"), at.number("tribble_curliness"));
    let curl: Place = vector_noise(scaled(place(x), frequency));
    let curled = |strength: f64| curliness * strength * value(curl);
    let (comb, length) = (painted(at, project(at, x)).direction + wind(at, x), at.number("tribble_length"));
    let there = x + curled(gain(c(0.8), tip)) - comb * length * tip.powi(2);
    // Along its normal a hair has moved by the derivative of x' - x: of its strength, over a tenth of its length, and of
    // the noise.
    let step = c(0.05);
    let normal = x.normalize();
    let growth = (curled(gain(c(0.8), tip + step)) - curled(gain(c(0.8), tip - step))) / (c(0.1) * length);
    let bend = growth + curliness * gain(c(0.8), tip) * crate::formulas::dual::slope(curl, normal) - 2.0 * tip * comb;
    let (root, shape) = (project(at, there), [c(0.3), c(0.9)]);
    let groom = painted(at, root);
    let hair = strand(root, at.number("tribble_fineness"), at.number("tribble_contrast"), shape, &groom);
    let length = length * groom.length.clamp(c(0.1), 1.0);
    (hair * narrowed(d, groom.length), normal, (normal - bend).normalize(), length)
}

/// Kajiya and Kay 1989: a cylinder along t mirrors the light into the cone around t whose angle to t is that of the
/// light to -t. The highlight is the cosine between the eye and the nearest direction of that cone.
fn hair(library: &Library, slots: &[(&str, &str)]) -> f64 {
    let text = "#include \"sample_point.glsl\"\n#include <medium>
        void check() {
            Sample s;
            s.x = p0.xyz; s.density = p0.w;
            s.hair_normal = p1.xyz; s.hair_tangent = p2.xyz;
            s.hair_length = 0.1 + p0.w * p0.w;
            groomed(s.root = p1.xyz;)
            out0 = vec4(medium(s, 0.5), extinction(s, 0.5));
        }";
    let check = Check::new(library, slots, text).given(|random, _| {
        let [normal, tangent] = [random.direction(), random.direction()].map(|v| v.extend(0.0).to_array());
        [random.vector().extend(random.density()).to_array(), normal, tangent, random.eye().extend(0.0).to_array()]
    });
    check.holds(2e-7, |at| {
        let tip = (1.0 - at.p[0][3]).clamp(0.0, 1.0);
        let [n, t] = [1, 2].map(|input| to_eye_space(at, at.place(input)));
        let [l, v] = directions(at);
        let along = t.dot(l);
        let across = (1.0 - along.powi(2)).sqrt();
        let mirrored = -along * t + across * (v - v.dot(t) * t).normalize();
        let highlight = mirrored.dot(v).max(c(1e-4)).powf(at.number("specular_power"));
        let lit = mix(0.25, 1.0, tip) * (1.0 + n.dot(l)) / 2.0;
        let base = COLOR * at.vector("root_color").lerp(at.vector("tip_color"), tip);
        let base = mixed(base, painted(at, at.place(1)).color);
        let light = at.vector("light_color");
        let ambient = at.vector("ambient_color") * mix(c(0.4), 1.0, tip);
        let color = base * (ambient + light * lit * across) + light * at.number("sheen") * lit * highlight;
        // As opaque as at a length of 0.2, whatever the length.
        color.extend(c(0.2) / (c(0.1) + at.p[0][3].powi(2))).to_array().to_vec()
    })
}

/// A sample of a body whose surface and normal are anywhere.
fn body(random: &mut Random, _: &Setting) -> [[f64; 4]; 4] {
    [
        random.in_cube(1.5).extend(random.within(-0.3, 0.3)).to_array(),
        random.direction().extend(random.density().clamp(0.0, 1.0)).to_array(),
        random.direction().extend(random.density().clamp(0.0, 1.0)).to_array(),
        random.eye().extend(0.0).to_array(),
    ]
}

/// How deep a point lies in the threads that run up and down, and in those that run around: each an ellipse.
fn threads(at: &At<'_>) -> DVec2 {
    let (normal, count) = (at.place(1), at.number("threads"));
    let root = at.place(0) + (at.number("iso_value") - at.p[0][3]) * normal;
    let out = DVec2::new(root.x, root.z).normalize();
    let turn = c(std::f64::consts::TAU);
    let pairs = (count / 2.0).floor();
    let u = 2.0 * pairs * (0.5 + root.z.atan2(root.x) / turn);
    let tilt = normal.y.atan2(normal.x * out.x + normal.z * out.y) / turn;
    let v = 2.0 * (c(0.3) * pairs).floor() * tilt + c(0.2) * pairs * root.y;
    let height = 1.0 - at.p[1][3];
    let side = |number: f64| if number.rem_euclid(2.0) < 1.0 { 1.0 } else { -1.0 };
    // Half a wave of each thread for each thread that it crosses, up where the other is down.
    let over = DVec2::new(0.5 + side(u) / 4.0 * (turn / 2.0 * v).sin(), 0.5 - side(v) / 4.0 * (turn / 2.0 * u).sin());
    let aside = (DVec2::new(u - u.floor(), v - v.floor()) - 0.5) * 2.0 / at.number("thread_width");
    let above = (height - over) * 4.0;
    (1.0 - aside * aside - above * above).max(DVec2::ZERO)
}

/// Angles of directions, also along the axes, and half waves.
fn turns(library: &Library) -> f64 {
    let text = "#include \"turns.glsl\"\nvoid check() { out0.xy = vec2(turns_of(p0.xy), half_wave(p0.z)); }";
    let check = Check::new(library, &[], text).given(|random, _| {
        let [x, y, _] = random.direction().to_array();
        let [x, y] =
            if random.unit() < 0.1 && x.abs().max(y.abs()) > 0.5 { [x.round() + 0.0, y.round() + 0.0] } else { [x, y] };
        [[x, y, random.unit(), 0.0]; 4]
    });
    check.holds(1e-8, |at| {
        let [x, y, part, _] = at.p[0];
        vec![y.atan2(x) / std::f64::consts::TAU, (std::f64::consts::PI * part).sin()]
    })
}

fn cloth(library: &Library, slots: &[(&str, &str)], colored: bool) -> f64 {
    let text = format!(
        "#include \"sample_point.glsl\"\n#include <dmf>\n{}
        void check() {{
            Sample s;
            s.x = p0.xyz; s.distance = p0.w; s.normal = p1.xyz; s.density = p1.w; s.shading = p2.xyz; s.coherence = 1.0;
            groomed(s.root = p1.xyz;)
            {}
        }}",
        if colored { "#include <medium>" } else { "" },
        if colored { "out0.xyz = medium(s, 0.5);" } else { "out0.x = modulate(p2.w, s);" }
    );
    let check = Check::new(library, slots, &text).given(body);
    // Angles are within 1e-8 turns, with up to 400 threads in one, and a border rises by up to 60 per thread.
    check.holds(2.4e-4, move |at| {
        let (depth, d, groom) = (threads(at), at.p[1][3], painted(at, at.place(1)));
        if colored {
            let base = mixed(at.vector(if depth.x > depth.y { "warp_color" } else { "weft_color" }), groom.color);
            let buried = mix(1.0, c(0.35), d.powi(2));
            return (buried * phong(at, COLOR * base, at.place(2))).to_array().to_vec();
        }
        let thread = depth.max_element() - (1.0 - groom.density).max(0.0);
        vec![if d >= 1.0 { at.p[2][3] } else { (3.0 * thread).clamp(0.0, 1.0) }]
    })
}
