//! The toolkit of PH 2.3 and 2.4 against its formulas in f64: shaping, DMFs, warps and their jacobians, noises.

use crate::common::{picture, subject, with_gpu};
use crate::lattice::{noise, octaves, wavelet};
use crate::seen::{seen, set, worst};
use glam::DVec3;
use hypertexture::noise::{Lattice, Noise, Weights};
use hypertexture::scene::{Integration, preset};
use hypertexture::shader;

fn bias(b: f64, t: f64) -> f64 {
    t.powf(b.ln() / 0.5f64.ln())
}

fn gain(g: f64, t: f64) -> f64 {
    if t < 0.5 { 0.5 * bias(1.0 - g, 2.0 * t) } else { 1.0 - 0.5 * bias(1.0 - g, 2.0 - 2.0 * t) }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p13_p14_bias_and_gain_keep_their_identities() {
    let identities = [
        ("bias at 0, 1/2 and 1", "abs(bias(v, 0.0)) + abs(bias(v, 0.5) - v) + abs(bias(v, 1.0) - 1.0)"),
        ("bias of 1/2 is the identity", "abs(bias(0.5, t) - t)"),
        ("bias is symmetric", "abs(bias(v, t) - bias(t, v))"),
        (
            "gain at 1/4, 1/2 and 3/4",
            "abs(gain(v, 0.25) - 0.5 * (1.0 - v)) + abs(gain(v, 0.5) - 0.5) + abs(gain(v, 0.75) - 0.5 * (1.0 + v))",
        ),
        ("gain of 1/2 is the identity", "abs(gain(0.5, t) - t)"),
        ("gain is symmetric about 1/2", "abs(gain(v, t) + gain(v, 1.0 - t) - 1.0)"),
        (
            "both hold outside [0, 1]",
            "abs(bias(v, -t)) + abs(bias(v, 1.0 + t) - 1.0) + abs(gain(v, -t)) + abs(gain(v, 1.0 + t) - 1.0)",
        ),
    ];
    with_gpu(|gpu| {
        for (what, error) in identities {
            let text = format!(
                "#include \"shaping.glsl\"\nvec3 surface(Sample s) {{\n\
                 float t = 0.5 + 0.5 * s.x.x, v = 0.5 + 0.5 * s.x.y;\nreturn vec3({error}, t, v);\n}}"
            );
            let seen = seen(gpu, &text, |_| ());
            let off = worst(&seen, |x| DVec3::new(0.0, 0.5 + 0.5 * x.x, 0.5 + 0.5 * x.y));
            assert!(off <= 8e-6, "{what}: {off:e}");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p22_the_dmfs_that_know_the_density_are_their_formulas() {
    with_gpu(|gpu| {
        let text = include_str!("../glsl/dmf_a_probe.glsl");
        let parameters = [("density_bias", 0.3), ("density_gain", 0.9), ("fold", 0.4)];
        let seen_a = seen(gpu, text, |scene| set(scene, &parameters));
        let held = |x: DVec3| (0.5 + x.x).clamp(0.0, 1.0);
        let off =
            worst(&seen_a, |x| 0.5 * DVec3::new(bias(0.3, held(x)), gain(0.9, held(x)), (held(x) - 0.4).abs() / 0.6));
        assert!(off <= 4e-6, "biased, gained, folded: {off:e}");
        let text = include_str!("../glsl/dmf_b_probe.glsl");
        let parameters = [("density_factor", -2.5), ("density_offset", 0.7), ("wave_count", 3.0), ("wave_depth", 0.8)];
        let seen_b = seen(gpu, text, |scene| set(scene, &parameters));
        let off = worst(&seen_b, |x| {
            let (density, soft) = (0.5 + x.x, 0.5 + 0.5 * x.x);
            let waves = density * (1.0 - 0.8 * (0.5 - 0.5 * (std::f64::consts::TAU * 3.0 * density).cos()));
            DVec3::new(0.5 + 0.1 * (0.7 - 2.5 * density), 0.5 + 0.25 * waves, 4.0 * soft * (1.0 - soft))
        });
        assert!(off <= 4e-6, "scaled, waves, the part of the soft region: {off:e}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p22_the_dmfs_that_know_the_place_are_their_formulas() {
    with_gpu(|gpu| {
        let parameters =
            [("noise_frequency", 3.0), ("fractal_scale", 2.0), ("turbulence_scale", 2.0), ("fractal_speed", 0.5)];
        let seen = seen(gpu, include_str!("../glsl/dmf_c_probe.glsl"), |scene| {
            set(scene, &parameters);
            scene.camera.time = 1.5;
        });
        let off = worst(&seen, |x| {
            let noisy = 0.3 + 0.5 * noise(3.0 * x);
            let fractal = 0.3 + 0.8 * octaves(2.0 * (x - DVec3::Y * 0.75), 8, |n| n);
            let turbulent = 0.3 * (1.0 - octaves(2.0 * x, 8, f64::abs)).max(0.0);
            0.5 + 0.25 * DVec3::new(noisy, fractal, turbulent)
        });
        assert!(off <= 2e-5, "noisy, fractal, turbulent: {off:e}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p05_toolkit_stacks_of_any_order_stay_in_range() {
    let dmfs = shader::shipped().modules("dmf").iter().map(|name| name.to_string()).collect::<Vec<_>>();
    let plain =
        |name: &String| !["fur", "tribble", "fire", "woven", "knurled", "pebbled", "rugged"].contains(&name.as_str());
    let dmfs: Vec<String> = dmfs.into_iter().filter(plain).collect();
    assert!(dmfs.len() >= 9, "{dmfs:?}");
    let library = shader::shipped();
    with_gpu(|gpu| {
        for turn in 0..dmfs.len() {
            let mut scene = preset("noisy_sphere").unwrap();
            scene.effect.dmf = dmfs.clone();
            scene.effect.dmf.rotate_left(turn);
            if turn % 2 == 1 {
                scene.effect.dmf.reverse();
                scene.effect.medium = "lit".into();
            }
            set(&mut scene, &[("noise_strength", 4.0), ("density_factor", -10.0), ("density_offset", 5.0)]);
            scene.image.size = [48, 48];
            scene.quality.samples = 64;
            let frame = picture(gpu, &library, &scene, &subject(&scene, &library));
            let whole = frame.pixels.iter().all(|pixel| (0.0..=1.0001).contains(&pixel[3]));
            assert!(whole, "{:?}", scene.effect.dmf);
            assert!(frame.pixels.iter().any(|pixel| pixel[3] > 0.01), "{:?} is empty", scene.effect.dmf);
        }
    });
}

/// The constant of a vector in a GLSL file.
fn vector(file: &str, name: &str) -> DVec3 {
    let library = shader::shipped();
    let text = library.source(file).unwrap();
    let numbers = text.split_once(&format!("{name} = vec3(")).unwrap().1.split_once(')').unwrap().0;
    let parts: Vec<f64> = numbers.split(',').map(|number| number.trim().parse().unwrap()).collect();
    DVec3::from_slice(&parts)
}

fn vector_noise(p: DVec3) -> DVec3 {
    let shift = vector("vector_noise.glsl", "NOISE_SHIFT");
    DVec3::new(noise(p - shift), noise(p), noise(p + shift))
}

/// Derivative of `f` along `v`, from both sides; `None` where it has a crease.
fn derivative(f: impl Fn(DVec3) -> DVec3, p: DVec3, v: DVec3) -> Option<DVec3> {
    let h = 1e-6;
    let (behind, here, ahead) = (f(p - h * v), f(p), f(p + h * v));
    let (left, right) = ((here - behind) / h, (ahead - here) / h);
    ((left - right).abs().max_element() < 0.02).then_some(0.5 * (left + right))
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p35_vector_noise_is_the_scalar_noise_at_three_places() {
    with_gpu(|gpu| {
        let seen = seen(gpu, include_str!("../glsl/vector_probe.glsl"), |_| ());
        let off = worst(&seen, |x| match x.x < 0.0 {
            true => 0.5 + 0.5 * vector_noise(4.0 * x),
            false => 0.5 + 0.1 * derivative(vector_noise, 4.0 * x, DVec3::new(0.6, -0.5, 0.62)).unwrap(),
        });
        assert!(off <= 2e-5, "{off:e}");
    });
}

#[test]
fn p35_the_components_of_vector_noise_are_not_correlated() {
    let shift = vector("vector_noise.glsl", "NOISE_SHIFT");
    let source = Noise::new(1989, Weights::Quintic);
    // The table of PH, and the noise blocks of 64^3 (shipped), 128^3 and 256^3 texels.
    for period in [256, 16, 32, 64] {
        let at = |p: DVec3| match period {
            256 => source.sample(p.to_array(), period).1,
            _ => Lattice::default().sample(p.to_array(), period).1,
        };
        let (mut sums, mut squares) = ([0.0; 3], [0.0; 3]);
        // A lattice of points that no cell repeats: additive recurrence with the plastic number (Roberts 2018).
        for index in 0..400_000 {
            let step = DVec3::new(0.819_172_513_396_164_4, 0.671_043_606_703_789_2, 0.549_700_477_901_970_3);
            let p = (f64::from(index) * step).fract() * f64::from(period);
            let n = [at(p - shift), at(p), at(p + shift)];
            for pair in 0..3 {
                sums[pair] += n[pair] * n[(pair + 1) % 3];
                squares[pair] += n[pair] * n[pair];
            }
        }
        for pair in 0..3 {
            let correlation = sums[pair] / (squares[pair] * squares[(pair + 1) % 3]).sqrt();
            println!("period {period}, components {pair} and {}: {correlation:.4}", (pair + 1) % 3);
            assert!(correlation.abs() < 0.01, "period {period}, pair {pair}: {correlation}");
        }
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p20_wavelet_noise_has_no_gradient_at_its_lattice_points() {
    with_gpu(|gpu| {
        let seen = seen(gpu, include_str!("../glsl/wavelet_probe.glsl"), |scene| scene.effect.noise = "wavelet".into());
        let off = seen.iter().map(|(x, c)| (c.x - 0.5 - 0.5 * wavelet(4.0 * *x)).abs()).fold(0.0, f64::max);
        assert!(off <= 2e-6, "{off:e}");
        assert!(seen.iter().all(|(_, color)| color.y == 0.0), "a gradient at a lattice point");
        assert!(seen.iter().all(|(_, color)| color.z > 0.0), "no gradient in the middle of a cell");
    });
}

/// PH 2.4: the places of these tests are all within the radius beyond which the step is held.
fn scale_radius(x: DVec3, amount: f64) -> DVec3 {
    x * (1.0 + amount)
}

const TIME: f64 = 1.5;

/// Name, parameters, how far it says that a lookup moves, and the formula of a warp.
type Warp = (&'static str, &'static [(&'static str, f32)], &'static str, fn(DVec3) -> DVec3);

const WARPS: [Warp; 6] = [
    ("noisy", &[("amplitude", 0.7), ("frequency", 2.0)], "0.8660254 * amplitude * hold_radius", |x| {
        scale_radius(x, 0.7 * noise(2.0 * x))
    }),
    (
        "fractal",
        &[("fractal_amplitude", 0.5), ("fractal_frequency", 0.5)],
        "2.0 * 0.8660254 * fractal_amplitude * hold_radius",
        |x| scale_radius(x, 0.5 * octaves(0.5 * x, 8, |n| n)),
    ),
    (
        "turbulent",
        &[("turbulence_amplitude", 1.0), ("turbulence_frequency", 0.5), ("turbulence_speed", 0.4)],
        "2.0 * 0.8660254 * turbulence_amplitude * hold_radius",
        |x| scale_radius(x, octaves(0.5 * (x - DVec3::Y * 0.4 * TIME), 8, f64::abs)),
    ),
    ("dripping", &[("drip_amplitude", 0.8), ("drips", 3.0)], "drip_amplitude", |x| {
        let n = noise(3.0 * DVec3::new(1.0, 0.2, 1.0) * x);
        x + DVec3::Y * 0.8 / 0.75f64.sqrt() * if n > 0.0 { n } else { 0.25 * n }
    }),
    (
        "perturbed",
        &[
            ("perturbation", 0.6),
            ("perturbation_frequency", 1.5),
            ("perturbation_roughness", 0.5),
            ("perturbation_speed", 0.3),
        ],
        "perturbation",
        |x| {
            let (mut moved, mut drift) = (x, DVec3::new(0.3125, -1.0, 0.1875) * 0.3 * TIME);
            for octave in 0..3 {
                let (weight, scale) = (0.6 / (1.5 * 1.75) * 0.5f64.powi(octave), 1.5 * 2f64.powi(octave));
                moved += weight * vector_noise(scale * x + drift);
                drift = 1.5 * DVec3::new(drift.z, drift.x, drift.y) + DVec3::new(3.1, 7.7, 1.3);
            }
            moved
        },
    ),
    ("flowing", &[("flow_length", 1.2), ("flow_frequency", 1.5), ("flow_speed", 0.4)], "flow_length", |mut x| {
        for _ in 0..4 {
            let shear = |place: f64, a: f64, b: f64| {
                1.2 / (4.0 * 1.5) * noise(DVec3::new(1.5 * a, place + 0.4 * TIME, 1.5 * b))
            };
            x.x += shear(2.6, x.y, x.z);
            x.y += shear(9.9, x.z, x.x);
            x.z += shear(17.2, x.x, x.y);
        }
        x
    }),
];

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p24_warps_match_formula_derivative_and_reach() {
    let text = include_str!("../glsl/warp_probe.glsl");
    with_gpu(|gpu| {
        for (name, parameters, reach, formula) in WARPS {
            let mode = |mode: &str| {
                let text = text.replace("MODULE", name).replace("MODE", mode).replace("REACH", reach);
                seen(gpu, &text, |scene| {
                    set(scene, parameters);
                    scene.camera.time = TIME;
                    // Otherwise the turbulence ends its sum where the density is 0 anyway.
                    scene.quality.integration = Integration::Segment;
                })
            };
            let off = worst(&mode("0"), |x| 0.5 + 0.1 * formula(x));
            assert!(off <= 3e-6, "{name}: {off:e}");
            let (mut off, mut count) = (0f64, 0);
            let seen = mode("1");
            for (x, color) in &seen {
                let p = *x;
                let Some(slope) = derivative(formula, p, DVec3::new(p.y, 1.0 - p.x, 0.5 + p.x * p.y)) else { continue };
                off = off.max(((*color - 0.5) / 0.02 - slope).abs().max_element());
                count += 1;
            }
            println!("{name}: jacobian off by {off:.1e} on {count} of {} points", seen.len());
            assert!(off <= 2e-2 && 2 * count > seen.len(), "the jacobian of {name}: {off:e} on {count} points");
            let far = mode("2").iter().map(|(_, color)| color.x).fold(0.0, f64::max);
            assert!((0.15..=1.0).contains(&far), "{name} moves a point by {far} reaches");
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn g03_flames_and_relief_rise_at_the_speed_parameter() {
    with_gpu(|gpu| {
        for mode in ["0", "1"] {
            let text = include_str!("../glsl/rising_probe.glsl").replace("MODE", mode);
            let at = |time: f32| {
                seen(gpu, &text, |scene| {
                    set(scene, &[("rise", 0.7), ("relief_rise", 0.7), ("fury", 1.0), ("relief", 1.0), ("glow", 1.0)]);
                    scene.camera.time = f64::from(time);
                })
            };
            let (first, later) = (at(0.0), at(1.5));
            let bright = first.iter().map(|(_, color)| color.x);
            let (low, high) = bright.fold((f64::INFINITY, 0.0f64), |(low, high), x| (low.min(x), high.max(x)));
            // The relief turns around where a noise changes its sign: there a rounding may decide.
            let off = first.iter().zip(&later).filter(|(a, b)| (a.1 - b.1).abs().max_element() > 2e-3).count();
            assert!(high - low > 0.1, "nothing to see in mode {mode}: {low} to {high}");
            assert!(
                50 * off < first.len(),
                "mode {mode}: {off} of {} points after one and a half seconds",
                first.len()
            );
        }
    });
}
