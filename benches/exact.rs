//! Cost of evaluation in f64: run with `cargo bench --bench exact`, half a minute.
//!
//! Matter at random points around the object, one thread. Operations are scalar ones of the lowered program in active
//! lanes; copies and branches do not count. Median (lowest-highest) of several runs.
#![expect(clippy::unwrap_used, reason = "a bench stops where something is not as described")]

#[path = "common/mod.rs"]
mod bench;
#[path = "../tests/common/probe.rs"]
#[allow(dead_code, reason = "a bench draws nothing")]
mod probe;

use bench::Spread;
use hypertexture::eval::{Affine, BoundProgram, Evaluate, Interval, Invocations};
use hypertexture::render::variant::Variant;
use hypertexture::scene;
use hypertexture::shader::{self, Slots};
use probe::Probe;
use std::collections::BTreeMap;
use std::time::Instant;

const POINTS: u32 = 1 << 14;
const REPEATS: usize = 7;

/// Millions of operations per second, and operations for a point.
fn measure<N: Evaluate>(bound: &BoundProgram<'_>, width: f64, of: impl Fn(f64, f64) -> N) -> (Spread, f64) {
    let root = 1.220_744_084_605_759_5_f64; // of x^4 = x + 1 (Roberts 2018)
    let place = |n: u32| [1, 2, 3, 4].map(|axis| 4.0 * (f64::from(n) * root.powi(-axis)).fract() - 2.0);
    let points = (0..POINTS).map(|n| place(n).map(|low| of(low, low + width))).collect();
    let fragments = vec![[0.5, 0.5, 0.5, 1.0].map(|x| of(x, x)); POINTS as usize];
    let lanes = Invocations { fragment_coordinates: fragments, varyings: BTreeMap::from([(0, points)]) };
    let mut rates = Vec::new();
    let mut operations = 0;
    for _ in 0..REPEATS {
        let start = Instant::now();
        operations = bound.measure(&lanes).unwrap().1;
        rates.push(operations as f64 / start.elapsed().as_secs_f64() / 1e6);
    }
    (Spread::of(rates), operations as f64 / f64::from(POINTS))
}

fn main() {
    let library = shader::shipped();
    let titles = ["f64, M operations / s", "interval 0.01, M / s", "affine 0.01, M / s"];
    println!("{:<14} {:>16} {:>28} {:>28} {:>28}", "", "per point", titles[0], titles[1], titles[2]);
    for name in ["lit", "solid", "fur", "fire", "melting", "noisy_sphere", "smoke", "woven", "ensemble"] {
        let scene = scene::preset(name).unwrap();
        let mut slots = scene.slots(&library);
        slots.extend(Slots::clone(&Variant::of(&scene, &library).unwrap().slots));
        let text = include_str!("../tests/glsl/exact_point.glsl");
        let probe = Probe::new(&library, text, &slots, "classify", true).unwrap();
        let program = probe.program();
        let bound = program.bind(&probe.inputs).unwrap();
        let (f64s, operations) = measure(&bound, 0.0, |low, _| low);
        let (intervals, _) = measure(&bound, 0.01, Interval::of);
        let (forms, _) = measure(&bound, 0.01, Affine::between);
        println!("{name:<14} {operations:>16.0} {f64s:>28} {intervals:>28} {forms:>28}");
    }
}
