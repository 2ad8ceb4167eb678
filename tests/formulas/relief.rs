//! Reliefs: heights over the foot of a place, and the matter below them.

use crate::formulas::density::{mix, smoothstep};
use crate::formulas::dual::place;
use crate::formulas::hairy::{density, distance};
use crate::formulas::harness::{At, Check};
use crate::formulas::knots::{noise, pcg3d};
use crate::formulas::values::c;
use glam::DVec3;
use hypertexture::shader::Library;
use std::f64::consts::TAU;

crate::rows! {
    pyramids_stand_between_two_families_of_grooves = |l| relief(l, "knurled", knurled),
        "dmf/knurled.glsl": "around - across" => "around + across",
        "relief.glsl": "s.x - (s.distance" => "s.x + (s.distance";
    cells_are_pads_or_hollows = |l| relief(l, "pebbled", pebbled),
        "dmf/pebbled.glsl": "near.y - near.x" => "near.y",
        "dmf/pebbled.glsl": "mix(pad, dent" => "mix(dent, pad",
        "relief.glsl": "(1.0 + RELIEF_EDGE)" => "1.0";
    rough_noise_is_drawn_out_and_folded = |l| relief(l, "rugged", rugged),
        "dmf/rugged.glsl": "1.0 / rough_stretch" => "rough_stretch",
        "dmf/rugged.glsl": "weight *= rough_detail" => "weight *= 0.5";
}

/// The height of a relief at a foot on the unit sphere.
fn relief(library: &Library, module: &str, height: fn(&At<'_>, DVec3) -> f64) -> f64 {
    let text = "#include \"sample.glsl\"\n#include <dmf>
        void check() { Sample s = sample_object(p0.xyz); out0.x = modulate(s.density, s); }";
    let check = Check::new(library, &[("dmf", module)], text)
        .given(|random, _| [(random.direction() * random.within(0.9, 1.3)).extend(0.0).to_array(); 4]);
    // Up to 400 grooves, of which a twentieth slopes, enlarge errors of angles.
    check.holds(1e-3, move |at| {
        let foot = at.place(0).normalize() * (1.0 + at.number("iso_value"));
        let (d, edge) = (density(at), c(0.15));
        let filled = (((1.0 + edge) * height(at, foot) - (1.0 - d)) / edge).clamp(0.0, 1.0);
        vec![if distance(at) <= at.number("iso_value") { 1.0 } else { filled }]
    })
}

fn knurled(at: &At<'_>, foot: DVec3) -> f64 {
    let (knurls, normal) = (at.number("knurls"), foot.normalize());
    let groove = |turns: f64| {
        let within = turns - turns.floor();
        ((1.0 - (2.0 * within - 1.0).abs()) / at.number("knurl_sharpness")).min(1.0)
    };
    let around = knurls.floor() * foot.z.atan2(foot.x) / TAU;
    let tilt = normal.y.atan2(normal.x.hypot(normal.z)) / TAU;
    let across = (c(0.3) * knurls).floor() * tilt + c(0.16) * knurls * foot.y;
    groove(around + across).min(groove(around - across))
}

fn pebbled(at: &At<'_>, foot: DVec3) -> f64 {
    let p = foot * at.number("pebbles");
    let mut all = Vec::new();
    for index in 0..27 {
        let cell = p.floor() + DVec3::from([index % 3, index / 3 % 3, index / 9].map(f64::from)) - 1.0;
        let inside = pcg3d(cell.to_array().map(|along| along as i32 as u32)).map(|bits| f64::from(bits >> 8));
        all.push((cell + c(0.15) + c(0.7) * DVec3::from(inside) / 16777216.0).distance(p));
    }
    all.sort_by(f64::total_cmp);
    let groove = (c(1.4) * (all[1] - all[0])).clamp(0.0, 1.0);
    mix(groove * (2.0 - groove), (all[0].powi(2) / c(0.6)).min(1.0), at.number("hollow"))
}

fn rugged(at: &At<'_>, foot: DVec3) -> f64 {
    let stretched = DVec3::new(foot.x, foot.y / at.number("rough_stretch"), foot.z);
    let mut p = stretched * at.number("rough_frequency");
    let (mut sum, mut whole) = (0.0, 0.0);
    for octave in 0..4 {
        let (n, weight) = (noise(place(p)).v, at.number("rough_detail").powi(octave));
        sum += weight * mix(c(1.6) * n, c(3.2) * n.abs() - c(0.7), at.number("ridges"));
        whole += weight;
        p = 2.0 * p + DVec3::new(c(5.2), c(1.3), c(7.7));
    }
    smoothstep(-1.0, 1.0, c(1.3) * sum / whole)
}
