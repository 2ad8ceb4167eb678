//! Cost of baking: run with `cargo bench --bench bake`, some seconds.
//!
//! Blocks of eight octaves of turbulence on all cores, and the same sum by well-kept crates of noise on the same cores.
//! Times are milliseconds, median (lowest-highest); a sample is one octave at one texel.
#![expect(clippy::unwrap_used, reason = "a bench stops where something is not as described")]

#[path = "common/mod.rs"]
mod bench;

use bench::Spread;
use fastnoise_lite::{FastNoiseLite, NoiseType};
use hypertexture::noise::{Bake, Weights};
use hypertexture::render::texture::{Depth, block_gradients};
use noise_rs::{NoiseFn, Perlin};
use rayon::prelude::*;
use std::hint::black_box;
use std::time::Instant;

const REPEATS: usize = 5;
/// Lattice cells of the first octave across the block.
const CELLS: u32 = 4;
const OCTAVES: u32 = 8;

/// Milliseconds of repeats, after one that is not counted.
fn time(mut run: impl FnMut()) -> Spread {
    run();
    let one = |_| {
        let start = Instant::now();
        run();
        start.elapsed().as_secs_f64() * 1e3
    };
    Spread::of((0..REPEATS).map(one).collect())
}

/// The sum of all octaves by a noise that gives one value at one place.
fn by_samples(size: u32, octaves: u32, noise: impl Fn([f64; 3]) -> f64 + Sync) -> Vec<f32> {
    let side = size as usize;
    let mut block = vec![0.0; side.pow(3)];
    block.par_chunks_mut(side * side).enumerate().for_each(|(z, plane)| {
        for (index, out) in plane.iter_mut().enumerate() {
            let p = [index % side, index / side, z].map(|i| (i as f64 + 0.5) / f64::from(size) * f64::from(CELLS));
            let octave = |i: u32| noise(p.map(|c| c * f64::from(1u32 << i))).abs() / f64::from(1u32 << i);
            *out = (0..octaves).map(octave).sum::<f64>() as f32;
        }
    });
    block
}

fn main() {
    let threads = rayon::current_num_threads();
    println!(
        "Turbulence, {CELLS} cells of the first octave, {threads} threads; {REPEATS} repeats: median (lowest-highest)"
    );
    println!("{:<52} {:>24} {:>16} {:>18}", "", "ms", "M samples/s", "ns/sample/thread");
    for size in [64u32, 128, 256] {
        let held = Bake::held(size, CELLS, OCTAVES);
        let bake = |octaves| Bake { weights: Weights::Quintic, size, cells: CELLS, octaves, absolute: true };
        let row = |name: &str, octaves: u32, ms: Spread| {
            let samples = f64::from(size).powi(3) * f64::from(octaves);
            let each = ms.median * 1e6 / samples * threads as f64;
            let name = format!("{size}^3, {octaves} octaves, {name}");
            println!("{name:<52} {ms:>24.1} {:>16.0} {each:>18.2}", samples / ms.median / 1e3);
        };
        row("values", held, time(|| drop(black_box(bake(held).values(&|_| ())))));
        row("values and gradients", held, time(|| drop(black_box(bake(held).values_and_gradients(&|_| ())))));
        let stored =
            || drop(black_box(block_gradients(&bake(held).values_and_gradients(&|_| ()), true, Depth::Sixteen)));
        row("the same as texels of 4 x 16 bits", held, time(stored));
        if size > 128 {
            continue; // the others take minutes
        }
        let perlin = Perlin::new(1);
        row("crate noise, Perlin", held, time(|| drop(black_box(by_samples(size, held, |p| perlin.get(p))))));
        let mut lite = FastNoiseLite::with_seed(1);
        lite.set_noise_type(Some(NoiseType::Perlin));
        lite.set_frequency(Some(1.0));
        let lite = |p: [f64; 3]| f64::from(lite.get_noise_3d(p[0] as f32, p[1] as f32, p[2] as f32));
        row("crate fastnoise-lite, Perlin", held, time(|| drop(black_box(by_samples(size, held, lite)))));
    }
    println!("Octaves are those that a block can hold: the same for all.");
}
