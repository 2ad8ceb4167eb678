//! Functions of the density: softness, shaping, DMFs, masks, opacity.

use crate::formulas::dual::{moved, place, scaled};
use crate::formulas::groom::painted;
use crate::formulas::harness::{At, Check, OCTAVES};
use crate::formulas::knots::{noise, octaves, turbulence};
use crate::formulas::values::{Random, Setting, c};
use glam::DVec3;
use hypertexture::shader::Library;
use std::cell::Cell;

crate::rows! {
    p13_p14_bias_and_gain_are_phs = shaping,
        "shaping.glsl": "bias(1.0 - g, t < 0.5" => "bias(g, t < 0.5",
        "shaping.glsl": "log(0.5)" => "log(0.4)";
    p13_biased_density_is_phs_bias = |l| dmf(l, "biased", |at, d| bias(at.number("density_bias"), d)),
        "dmf/biased.glsl": "density_bias, density" => "1.0 - density_bias, density";
    p14_gained_density_is_phs_gain = |l| dmf(l, "gained", |at, d| gain(at.number("density_gain"), d)),
        "dmf/gained.glsl": "density_gain, density" => "1.0 - density_gain, density";
    p22_arithmetic_scales_the_density = |l| dmf(l, "scaled", |at, d| at.number("density_factor") * d + at.number("density_offset")),
        "dmf/scaled.glsl": "+ density_offset" => "- density_offset";
    p22_abs_folds_the_density = |l| dmf(l, "folded", folded),
        "dmf/folded.glsl": "- fold)" => "+ fold)";
    p22_a_sine_makes_shells = |l| dmf(l, "waves", waves),
        "dmf/waves.glsl": "0.5 - 0.5 * cos" => "0.5 + 0.5 * cos";
    p22_noise_is_added_in_the_soft_region = |l| dmf(l, "noisy", noisy),
        "dmf/noisy.glsl": "density + noise_strength" => "density - noise_strength",
        "soft_part.glsl": "1.0 - s.density" => "1.0 + s.density";
    p26_noise_of_many_frequencies_is_added = |l| dmf(l, "fractal", fractal),
        "dmf/fractal.glsl": "fractal_speed * time" => "-fractal_speed * time";
    p21_turbulence_eats_the_density = |l| dmf(l, "turbulent", turbulent),
        "dmf/turbulent.glsl": "1.0 - turbulence_strength" => "1.0 + turbulence_strength";
    p04_matter_settles_where_the_object_faces_up = |l| dmf(l, "settled", settled),
        "dmf/settled.glsl": "s.normal.y" => "s.normal.z";
    p40_more_gain_forces_less_amplitude = |l| dmf(l, "traded", traded),
        "dmf/traded.glsl": "-log2(1.0 - trade_gain)" => "-log2(trade_gain)";
    it_burns_where_it_is_painted = |l| fire(l, &[("dmf", "fire"), ("groom", "volume")]),
        "dmf/fire.glsl": "away / clamp" => "away * clamp",
        "dmf/fire.glsl": "min(groom_density(foot), 1.0)" => "min(groom_density(s.x), 1.0)";
    m49_p30_fire_varies_with_height_and_rises = |l| fire(l, &[("dmf", "fire")]),
        "dmf/fire.glsl": "rise * time" => "-rise * time",
        "dmf/fire.glsl": "mix(0.22, 1.0, up)" => "mix(1.0, 0.22, up)",
        "dmf/fire.glsl": "s.x + reach * C" => "s.x - reach * C",
        "dmf/fire.glsl": "s.wide_normal.y" => "s.normal.y";
    m49_flames_have_no_crease_across_the_medial_axis = creases,
        "dmf/fire.glsl": "s.wide_normal.y" => "s.normal.y";
    m49_a_mask_is_a_ball = |l| mask(l, "ball", |at| {
        let away = at.place(0).distance(DVec3::new(at.number("ball_x"), at.number("ball_y"), at.number("ball_z")));
        1.0 - faded(at.number("ball_radius"), at.number("ball_blend"), away)
    }),
        "mask/ball.glsl": "ball_radius + half_blend" => "ball_radius + ball_blend";
    m50_a_mask_is_a_band_of_the_depth = |l| mask(l, "band", |at| {
        between([at.number("band_from"), at.number("band_to"), at.number("band_blend")], at.p[2][0])
    }),
        "mask/band.glsl": "band_to - half_blend" => "band_to + half_blend";
    m49_a_mask_is_a_range_of_heights = |l| mask(l, "height", |at| {
        between([at.number("height_from"), at.number("height_to"), at.number("height_blend")], at.p[0][1])
    }),
        "mask/height.glsl": "s.x.y" => "s.x.z";
    m47_hard_objects_end_at_their_iso_value = hard,
        "softness/hard.glsl": "distance <= iso_value" => "distance >= iso_value";
    m47_the_soft_region_lies_between_two_iso_values = linear,
        "softness/linear.glsl": "(outer - distance)" => "(outer + distance)";
    m11_p02_soft_spheres_go_by_squared_radii = quadratic,
        "softness/quadratic.glsl": "(r_outer - r) * (r_outer + r) / width" => "(r_outer - r) * (r_outer - r) / width";
    p45_opacity_does_not_depend_on_the_steps = perlin,
        "opacity/perlin.glsl": "e2 * (1.0 / 24.0" => "e2 * (1.0 / 12.0",
        "opacity/perlin.glsl": "amount * log_one_minus(density)" => "amount * -density";
    p45_extinction_goes_by_beers_law = beer,
        "opacity/beer.glsl": "0.5 * (d0 + d1)" => "(d0 + d1)";
    p45_logarithm_and_exponential_keep_their_digits = exponential,
        "exponential.glsl": "1.0 / 5.0 + q2" => "1.0 / 5.0 - q2",
        "exponential.glsl": "t / 4.0" => "t / 3.0";
}

/// PH 2.3, with b held in [2^-10, 1 - 2^-10]; `ln 1/2` is a constant of f32.
pub fn bias(b: f64, t: f64) -> f64 {
    let edge = 2f64.powi(-10);
    let t = t.clamp(0.0, 1.0);
    if t == 0.0 { 0.0 } else { t.powf(b.clamp(edge, 1.0 - edge).ln() / 0.5f64.ln()) }
}

/// PH 2.3.
pub fn gain(g: f64, t: f64) -> f64 {
    match t < 0.5 {
        true => bias(1.0 - g, 2.0 * t) / 2.0,
        false => 1.0 - bias(1.0 - g, 2.0 - 2.0 * t) / 2.0,
    }
}

/// Hermite's cubic between two places.
pub fn smoothstep(from: f64, to: f64, x: f64) -> f64 {
    let t = ((x - from) / (to - from)).clamp(0.0, 1.0);
    3.0 * t.powi(2) - 2.0 * t.powi(3)
}

pub fn mix(a: f64, b: f64, t: f64) -> f64 {
    (1.0 - t) * a + t * b
}

fn shaping(library: &Library) -> f64 {
    let text = "#include \"shaping.glsl\"\nvoid check() { out0.xy = vec2(bias(p0.x, p0.y), gain(p0.x, p0.y)); }";
    let check = Check::new(library, &[], text).given(|random, _| [[random.density(), random.density(), 0.0, 0.0]; 4]);
    check.holds(1e-8, |at| vec![bias(at.p[0][0], at.p[0][1]), gain(at.p[0][0], at.p[0][1])])
}

/// The place, the normal and the density of a sample that a DMF or a mask is asked at.
const SAMPLE: &str = "#include \"sample_point.glsl\"\nSample given() {
    Sample s;
    s.x = p0.xyz; s.distance = p0.w; s.normal = p1.xyz; s.shading = p1.xyz; s.coherence = p1.w; s.density = p2.x;
    return s;
}\n";

fn sample(random: &mut Random, _: &Setting) -> [[f64; 4]; 4] {
    let mut p = random.point();
    p[1] = random.direction().extend(random.unit()).to_array();
    p[2] = [random.density(), random.density(), 0.0, 0.0];
    p
}

fn dmf(library: &Library, module: &str, formula: fn(&At<'_>, f64) -> f64) -> f64 {
    let text = format!("{SAMPLE}#include <dmf>\nvoid check() {{ Sample s = given(); out0.x = modulate(p2.y, s); }}");
    let check = Check::new(library, &[("dmf", module)], &text).given(sample);
    check.holds(4e-8, |at| vec![formula(at, at.p[2][1])])
}

fn mask(library: &Library, module: &str, formula: fn(&At<'_>) -> f64) -> f64 {
    let text = format!("{SAMPLE}#include \"mask/{module}.glsl\"\nvoid check() {{ out0.x = {module}(given()); }}");
    Check::new(library, &[], &text).given(sample).holds(1e-9, |at| vec![formula(at)])
}

/// From 0 to 1 around a place, over a length.
fn faded(around: f64, over: f64, x: f64) -> f64 {
    smoothstep(around - over / 2.0, around + over / 2.0, x)
}

fn between([from, to, over]: [f64; 3], x: f64) -> f64 {
    faded(from, over, x) * (1.0 - faded(to, over, x))
}

fn folded(at: &At<'_>, density: f64) -> f64 {
    let fold = at.number("fold");
    (density.clamp(0.0, 1.0) - fold).abs() / (1.0 - fold)
}

fn waves(at: &At<'_>, density: f64) -> f64 {
    let wave = (c(std::f64::consts::TAU) * at.number("wave_count").floor() * density).cos();
    density * (1.0 - at.number("wave_depth") * (1.0 - wave) / 2.0)
}

/// How deep in the soft region the sample lies: a parabola that is 1 in the middle.
fn soft_part(at: &At<'_>) -> f64 {
    1.0 - (2.0 * at.p[2][0] - 1.0).powi(2)
}

fn noisy(at: &At<'_>, density: f64) -> f64 {
    let noise = noise(scaled(place(at.place(0)), at.number("noise_frequency"))).v;
    density + at.number("noise_strength") * soft_part(at) * noise
}

/// The place of a pattern that rises.
fn risen(at: &At<'_>, speed: &str) -> crate::formulas::dual::Place {
    moved(place(at.place(0)), DVec3::NEG_Y * at.number(speed) * at.number("time"))
}

fn fractal(at: &At<'_>, density: f64) -> f64 {
    let sum = octaves(scaled(risen(at, "fractal_speed"), at.number("fractal_scale")), OCTAVES, |p, _| noise(p)).v;
    density + at.number("fractal_strength") * soft_part(at) * sum
}

fn turbulent(at: &At<'_>, density: f64) -> f64 {
    let eaten = turbulence(scaled(risen(at, "turbulence_rise"), at.number("turbulence_scale"))).v;
    let left = (1.0 - at.number("turbulence_strength") * eaten).max(0.0);
    if at.p[2][0] >= 1.0 { density } else { density * left }
}

/// PH 3.1, footnote: with the slope -log2(1 - g) of a gain in its middle the amplitude falls.
fn traded(at: &At<'_>, density: f64) -> f64 {
    let g = at.number("trade_gain");
    let noise = noise(scaled(place(at.place(0)), at.number("trade_frequency"))).v;
    let steepness = (1.0 - g).ln() / 0.5f64.ln();
    density + at.number("trade_strength") / steepness * soft_part(at) * (2.0 * gain(g, (1.0 + noise) / 2.0) - 1.0)
}

fn settled(at: &At<'_>, density: f64) -> f64 {
    let over = 2.0 * at.number("settle_width");
    if at.p[2][0] >= 1.0 { density } else { density * faded(at.number("settle_slope"), over, at.p[1][1]) }
}

/// On a sphere: what is left of a flame, and the direction that it leaves to its medium there.
fn fire(library: &Library, slots: &[(&str, &str)]) -> f64 {
    let text = "#include \"sample.glsl\"\n#include <dmf>
        void check() {
            Sample s = sample_object(p0.xyz);
            out0.x = modulate(p0.w, s);
            out0.yzw = out0.x > 0.0 ? s.wide_normal : vec3(0.0);
        }";
    let check = Check::new(library, slots, text)
        .given(|random, _| [(random.direction() * random.within(0.6, 1.8)).extend(random.density()).to_array(); 4]);
    check.holds(1e-7, |at| {
        let (x, density) = (at.place(0), at.p[0][3]);
        if density >= 1.0 {
            return [1.0].into_iter().chain(x.normalize().to_array()).collect();
        }
        // Differences of the distance over half of it to each side, at the corners of a tetrahedron.
        let reach = ((x.length() - 1.0 - at.number("iso_value")) / 2.0).max(c(1e-3));
        let corners =
            [DVec3::ONE, DVec3::new(1.0, -1.0, -1.0), DVec3::new(-1.0, 1.0, -1.0), DVec3::new(-1.0, -1.0, 1.0)];
        let wide =
            corners.into_iter().map(|corner| corner * (x + reach * corner).length()).sum::<DVec3>() / (4.0 * reach);
        let (low, high) = (at.vector("own_min").y, at.vector("own_max").y);
        // 0 on the object, 1 at the tip of a flame, which is shorter where the object faces down.
        let longest = mix(c(0.22), 1.0, smoothstep(c(-0.8), c(0.9), wide.y));
        let groom = painted(at, x - (x.length() - 1.0 - at.number("iso_value")) * wide);
        let away = ((1.0 - density) / longest).clamp(0.0, 1.0) / groom.length.clamp(c(1e-3), 1.0);
        let away = away.min(1.0);
        let height = ((x.y - low) / (high - low)).clamp(0.0, 1.0);
        let rising = DVec3::new(x.x, c(0.45) * (x.y - at.number("rise") * at.number("time")), x.z);
        let torn = turbulence(place(at.number("flame_scale") * rising)).v;
        let left = 1.0 - away - at.number("fury") * mix(c(0.8), 1.5, height) * (c(0.35) + away) * torn;
        let gas = c(0.85)
            * (c(1.4) * left).clamp(0.0, 1.0)
            * smoothstep(0.0, c(0.15), 1.0 - density)
            * groom.density.min(1.0);
        let wide = if gas > 0.0 { wide } else { DVec3::ZERO };
        [gas].into_iter().chain(wide.to_array()).collect()
    })
}

/// Flames between a floor and a wall: how much more than 1e-3 they differ on both sides of the diagonal, from where both
/// are equally near.
fn creases(library: &Library) -> f64 {
    const CORNER: &str =
        "// A floor and a wall.\n// Source: a test.\n// x: object space.\n#include \"surface_point.glsl\"
        Surface object(vec3 x) {
            return x.x < x.y ? Surface(x.x, vec3(1.0, 0.0, 0.0)) : Surface(x.y, vec3(0.0, 1.0, 0.0));
        }";
    let text = "#include \"sample.glsl\"\n#include <dmf>
        float beside(float way) {
            Sample s = sample_object(p0.xyz + vec3(way, 0.0, 0.0));
            return modulate(s.density, s);
        }
        void check() { out0.xy = vec2(beside(1e-6), beside(-1e-6)); }";
    let library = library.clone().with_module("object", "corner", CORNER);
    let fixed = [("iso_value", 0.0), ("outer_iso_value", 0.5), ("fury", 1.0)];
    let check = Check::new(&library, &[("dmf", "fire"), ("object", "corner")], text);
    let check = fixed.into_iter().fold(check, |check, (name, value)| check.with(name, &[value]));
    let check = check.given(|random, _| {
        let away = random.within(0.05, 0.4);
        [[away, away, random.within(-1.0, 1.0), 0.0]; 4]
    });
    let burning = Cell::new(0);
    let worst = check.worst(|_, found| {
        burning.set(burning.get() + usize::from(found[0].max(found[1]) > 0.05));
        (found[0] - found[1]).abs() / 1e-3
    });
    assert!(worst > 1.0 || burning.get() > 1000, "flames at {} places", burning.get());
    worst
}

const SOFTEN: &str = "#include <softness>\nvoid check() { out0.xy = vec2(soften(p0.x), soften_unclamped(p0.x)); }";

fn hard(library: &Library) -> f64 {
    Check::new(library, &[("softness", "hard")], SOFTEN).holds(1e-9, |at| {
        let depth = at.number("iso_value") - at.p[0][0];
        vec![f64::from(depth >= 0.0), 1.0 + 1e6 * depth]
    })
}

fn linear(library: &Library) -> f64 {
    Check::new(library, &[("softness", "linear")], SOFTEN).holds(1e-9, |at| {
        let (inner, outer) = (at.number("iso_value"), at.number("outer_iso_value"));
        let line = (at.p[0][0] - outer) / (inner - outer);
        vec![line.clamp(0.0, 1.0), line]
    })
}

fn quadratic(library: &Library) -> f64 {
    Check::new(library, &[("softness", "quadratic")], SOFTEN).holds(1e-9, |at| {
        let [r, inner, outer] =
            [at.p[0][0], at.number("iso_value"), at.number("outer_iso_value")].map(|d| (1.0 + d).max(0.0));
        // MJ Eq. 1.
        let line = (outer.powi(2) - r.powi(2)) / (outer.powi(2) - inner.powi(2));
        vec![line.clamp(0.0, 1.0), line]
    })
}

const OPACITY: &str =
    "#include <opacity>\nvoid check() { out0.xy = vec2(opacity(p0.x, p0.z), segment_opacity(p0.x, p0.y, p0.z)); }";

/// Largest relative error of two opacities.
fn opacities(library: &Library, module: &str, formula: fn([f64; 4]) -> [f64; 2]) -> f64 {
    let check = Check::new(library, &[("opacity", module)], OPACITY).given(|random, _| {
        let held = |x: f64| x.clamp(0.0, 1.0);
        let first = held(random.density());
        let second = if random.unit() < 0.3 { held(first + 0.1 * random.unit()) } else { held(random.density()) };
        [[first, second, 10f64.powf(random.within(-4.0, 2.0)), 0.0]; 4]
    });
    check.worst(|at, found| {
        let errors = formula(at.p[0]).into_iter().zip(found);
        errors.map(|(expected, found)| (found - expected).abs() / expected.max(1e-30) / 1e-6).fold(0.0, f64::max)
    })
}

fn beer(library: &Library) -> f64 {
    opacities(library, "beer", |[d0, d1, amount, _]| [d0, (d0 + d1) / 2.0].map(|d| -(-amount * d).exp_m1()))
}

/// PH 3.1: 1 - (1 - D)^(c ds), and its product over a segment on which D is linear: exp of the mean logarithm.
fn perlin(library: &Library) -> f64 {
    opacities(library, "perlin", |[d0, d1, amount, _]| {
        let once = if d0 >= 1.0 { 1.0 } else { -(amount * (-d0).ln_1p()).exp_m1() };
        [once, if d0 + d1 >= 2.0 { 1.0 } else { -(amount * mean_logarithm(d0, d1)).exp_m1() }]
    })
}

/// The mean of ln(1 - d) for d from d0 to d1.
pub fn mean_logarithm(d0: f64, d1: f64) -> f64 {
    let (u0, u1) = (1.0 - d0, 1.0 - d1);
    if (u0 - u1).abs() < 0.5 * u0.min(u1) {
        // Gauss and Legendre, eight nodes: smooth, and the closed form would cancel.
        const NODES: [[f64; 2]; 4] = [
            [0.183_434_642_495_649_8, 0.362_683_783_378_362],
            [0.525_532_409_916_329, 0.313_706_645_877_887_3],
            [0.796_666_477_413_626_7, 0.222_381_034_453_374_5],
            [0.960_289_856_497_536_3, 0.101_228_536_290_376_3],
        ];
        let at = |t: f64| (-(d0 + d1) / 2.0 - t * (d1 - d0) / 2.0).ln_1p();
        return NODES.iter().map(|[node, weight]| weight / 2.0 * (at(*node) + at(-node))).sum();
    }
    let antiderivative = |u: f64| if u > 0.0 { u * u.ln() - u } else { 0.0 };
    (antiderivative(u1) - antiderivative(u0)) / (u1 - u0)
}

fn exponential(library: &Library) -> f64 {
    let text = "#include \"exponential.glsl\"
        void check() { out0.xy = vec2(log_one_minus(p0.x), exp_minus_one(p0.y)); }";
    let check = Check::new(library, &[], text)
        .given(|random, _| [[random.unit().powi(3), -10f64.powf(random.within(-6.0, 1.5)), 0.0, 0.0]; 4]);
    check.worst(|at, found| {
        let expected = [(-at.p[0][0]).ln_1p(), at.p[0][1].exp_m1()];
        (0..2).map(|i| (found[i] / expected[i] - 1.0).abs() / 1e-6).fold(0.0, f64::max)
    })
}
