//! Warps: where a point is looked up, and the derivative of that.

use crate::formulas::dual::{Dual, Place, dual, length, moved, place, scaled, slope, value};
use crate::formulas::harness::{At, Check, OCTAVES};
use crate::formulas::knots::{noise, octaves, turbulence, vector_noise};
use crate::formulas::values::{c, filtered};
use glam::{DMat3, DVec3};
use hypertexture::eval::Wrap;
use hypertexture::shader::Library;

crate::rows! {
    p24_noisy_scales_the_radius_by_noise = |l| warp(l, "noisy", |at, x| {
        stretched(at, x, noise(scaled(x, at.number("frequency"))) * at.number("amplitude"))
    }),
        "warp/noisy.glsl": "frequency * n.xyz" => "n.xyz",
        "scale_radius.glsl": "outerProduct(arm, slope)" => "outerProduct(slope, arm)",
        "scale_radius.glsl": "x += amount" => "x -= amount";
    p26_fractal_scales_the_radius_by_many_frequencies = |l| warp(l, "fractal", |at, x| {
        let sum = octaves(scaled(x, at.number("fractal_frequency")), OCTAVES, |p, _| noise(p));
        stretched(at, x, sum * at.number("fractal_amplitude"))
    }),
        "warp/fractal.glsl": "fractal_frequency * n.xyz" => "n.xyz",
        "fractal_sum.glsl": "n.w / scale" => "n.w",
        "fractal_sum.glsl": "noise(scale * p) / scale" => "noise(scale * p)";
    p30_turbulent_scales_the_radius_by_turbulence = |l| warp(l, "turbulent", |at, x| {
        let risen = moved(x, DVec3::NEG_Y * at.number("turbulence_speed") * at.number("time"));
        let sum = turbulence(scaled(risen, at.number("turbulence_frequency")));
        stretched(at, x, sum * at.number("turbulence_amplitude"))
    }),
        "warp/turbulent.glsl": "turbulence_speed * time" => "-turbulence_speed * time";
    p27_dripping_moves_y_alone = |l| warp(l, "dripping", dripping),
        "warp/dripping.glsl": "1.0 + slope.y" => "1.0 - slope.y",
        "warp/dripping.glsl": "1.0 : 0.25" => "0.25 : 1.0";
    m53_p27_melting_sags_towards_the_ground = |l| warp(l, "melting", melting),
        "warp/melting.glsl": "0.15 - 0.5 * x.y" => "0.15 + 0.5 * x.y",
        "warp/melting.glsl": "12.0 * (1.0 - raised)" => "6.0 * (1.0 - raised)",
        "warp/melting.glsl": "0.5 * slower * drip * m.xz" => "0.5 * drip * m.xz";
    g05_perturbed_moves_by_three_scales_of_vector_noise = |l| warp(l, "perturbed", perturbed),
        "warp/perturbed.glsl": "kept * scale * slope" => "kept * slope",
        "warp/perturbed.glsl": "1.5 * drift.zxy" => "1.5 * drift.yzx";
    p28_swirled_matter_is_moved_by_three_noises = |l| warp(l, "swirl", swirled),
        "warp/swirl.glsl": "each * swirl_frequency" => "each";
    p58_flow_is_followed_back_by_shears = flows,
        "warp/flowing.glsl": "n.x * row_a + n.z * row_b" => "n.z * row_a + n.x * row_b",
        "warp/flowing.glsl": "flow_speed * time" => "-flow_speed * time";
    g01_g05_the_channels_of_a_block_are_a_vector = channels,
        "vector_noise.glsl": "return four_noises(p).rgb" => "return four_noises(p).gba",
        "vector_noise.glsl": "vector_noise(p - h.yyx))" => "vector_noise(p + h.yyx))";
    p34_p35_vector_noise_is_noise_at_three_places = vectors,
        "vector_noise.glsl": "noise(p), noise(p + NOISE_SHIFT)" => "noise(p), noise(p - NOISE_SHIFT)",
        "vector_noise.glsl": "transpose(mat3" => "(mat3";
}

/// PH 2.4: x (1 + amount), with a step that grows no more beyond a radius.
fn stretched(at: &At<'_>, x: Place, amount: Dual) -> Place {
    let held = (dual(at.number("hold_radius")) / length(x)).min(1.0);
    let step = amount * held;
    x.map(|along| along + along * step)
}

/// To divide by a constant is to multiply by its inverse in f32.
fn warp(library: &Library, module: &str, formula: fn(&At<'_>, Place) -> Place) -> f64 {
    displaces(warped(library, &[("warp", module)]), 1e-7, formula)
}

/// A warp after another one, whose derivative is given.
pub fn warped(library: &Library, slots: &[(&str, &str)]) -> Check {
    let text = "#include \"scale_radius.glsl\"
        #include <amount>
        #include <warp>
        void check() {
            vec3 x = p0.xyz;
            mat3 jacobian = mat3(p1.xyz, p2.xyz, vec3(p1.w, p2.w, p3.w)), unset = jacobian;
            displace(x, jacobian);
            out0.xyz = x;
            out1.xyz = jacobian * vec3(0.25, -0.75, 0.5);
            takes_slope = false;
            x = p0.xyz;
            displace(x, unset);
            out0.w = distance(out0.xyz, x); // with slopes and without them, points move alike
        }";
    Check::new(library, slots, text).given(|random, _| {
        let mut p = random.point();
        p[1..].iter_mut().for_each(|input| *input = random.in_cube(1.0).extend(random.within(-1.0, 1.0)).to_array());
        p
    })
}

pub fn displaces(check: Check, tolerance: f64, formula: impl Fn(&At<'_>, Place) -> Place) -> f64 {
    check.holds(tolerance, |at| {
        let before = DMat3::from_cols(at.place(1), at.place(2), DVec3::new(at.p[1][3], at.p[2][3], at.p[3][3]));
        let moved = formula(at, place(at.place(0)));
        let slope = slope(moved, before * DVec3::new(0.25, -0.75, 0.5));
        [value(moved).to_array().as_slice(), &[0.0], &slope.to_array()].concat()
    })
}

pub fn dripping(at: &At<'_>, [x, y, z]: Place) -> Place {
    let drips = at.number("drips");
    let n = noise([x * drips, y * (drips * c(0.2)), z * drips]);
    let longest = at.number("drip_amplitude") / c(0.75f64.sqrt());
    [x, y + n * if n.v > 0.0 { longest } else { longest / 4.0 }, z]
}

pub fn melting(at: &At<'_>, [x, y, z]: Place) -> Place {
    let columns = |frequency: f64, plane: f64| noise([x * frequency, dual(plane), z * frequency]);
    let frequency = at.number("drip_frequency");
    let part = (columns(frequency, 5.5) / dual(0.5)).clamp(0.0, 1.0);
    let raised = part * part * (dual(3.0) - part * 2.0);
    // Flat where a drip has its length.
    let drip = dual(1.0) - (dual(1.0) - raised) * (dual(1.0) - raised);
    let longest =
        (columns(c(0.7) * frequency, 15.5) * 0.5 + c(0.55)) * at.number("drip_length") * at.number("melt_time");
    let low = (dual(c(0.15)) - y * 0.5).clamp(0.0, 1.0);
    [x, y + low * drip * longest, z]
}

fn perturbed(at: &At<'_>, x: Place) -> Place {
    let (rough, frequency) = (at.number("perturbation_roughness"), at.number("perturbation_frequency"));
    let first = at.number("perturbation") / (1.5 * (1.0 + rough + rough.powi(2)));
    let mut drift = DVec3::new(0.3125, -1.0, 0.1875) * at.number("perturbation_speed") * at.number("time");
    let mut moved_to = x;
    for scale in 0..3 {
        let (weight, finer) = (first * rough.powi(scale), frequency * 2f64.powi(scale));
        let by = vector_noise(moved(scaled(x, finer), drift));
        (0..3).for_each(|axis| moved_to[axis] = moved_to[axis] + by[axis] * weight);
        drift = 1.5 * DVec3::new(drift.z, drift.x, drift.y) + DVec3::new(c(3.1), c(7.7), c(1.3));
    }
    moved_to
}

/// Vector noise is 1.5 long at most.
fn swirled(at: &At<'_>, x: Place) -> Place {
    let by = vector_noise(scaled(x, at.number("swirl_frequency")));
    std::array::from_fn(|axis| x[axis] + by[axis] * (at.number("swirl_depth") / 1.5))
}

/// A current of medium strength: a stronger one is chaotic, and enlarges what f32 has rounded.
fn flows(library: &Library) -> f64 {
    let check = warped(library, &[("warp", "flowing")]).with("flow_length", &[1.0]).with("flow_frequency", &[1.5]);
    displaces(check, 1e-5, flowing)
}

/// The number of a constant of a module.
fn constant(name: &str) -> f64 {
    let library = crate::formulas::harness::shipped();
    let text = library.source("warp/flowing.glsl").unwrap();
    text.split_once(&format!("{name} = ")).unwrap().1.split_once(';').unwrap().0.parse().unwrap()
}

/// Each coordinate in turn is moved by a noise of the other two, all of them some times.
fn flowing(at: &At<'_>, mut x: Place) -> Place {
    let (steps, frequency) = (constant("FLOW_STEPS"), at.number("flow_frequency"));
    let far = at.number("flow_length") / (1.5 * steps);
    for step in 0..3 * steps as usize {
        let axis = step % 3;
        let place = c([2.6, 9.9, 17.2][axis]) + at.number("flow_speed") * at.number("time");
        let [across, other] = [x[(axis + 1) % 3], x[(axis + 2) % 3]].map(|c| c * frequency);
        x[axis] = x[axis] + noise([across, dual(place), other]) * far;
    }
    x
}

/// Of a block with four channels the vector is RGB, its slope that of differences over a texel.
fn channels(library: &Library) -> f64 {
    let text = "#include \"vector_noise.glsl\"
        void check() {
            mat3 slope;
            out0.xyz = vector_noise_slope(p0.xyz, slope);
            out1.xyz = slope * p1.xyz;
        }";
    Check::new(library, &[("noise", "random")], text).holds(1e-9, |at| {
        let texture = at.texture("random_image");
        let value = |p: DVec3| {
            let texel = filtered(texture, &(p / f64::from(texture.size[0])).to_array(), Wrap::Repeat);
            2.0 * DVec3::from_slice(&texel) - 1.0
        };
        let (p, along) = (at.place(0), at.place(1));
        let slope = |axis: usize| value(p + DVec3::AXES[axis] / 2.0) - value(p - DVec3::AXES[axis] / 2.0);
        let sum: DVec3 = (0..3).map(|axis| along[axis] * slope(axis)).sum();
        [value(p).to_array().as_slice(), &[0.0], &sum.to_array()].concat()
    })
}

fn vectors(library: &Library) -> f64 {
    let text = "#include \"vector_noise.glsl\"
        void check() {
            mat3 slope;
            out0.xyz = vector_noise(p0.xyz) + 0.5 * vector_noise_slope(p1.xyz, slope);
            out1.xyz = slope * p2.xyz;
        }";
    Check::new(library, &[], text).holds(1e-9, |at| {
        let [here, there] = [0, 1].map(|input| vector_noise(place(at.place(input))));
        let sum = value(here) + 0.5 * value(there);
        [sum.to_array().as_slice(), &[0.0], &slope(there, at.place(2)).to_array()].concat()
    })
}
