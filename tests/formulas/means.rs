//! Limit of an octave finer than a sample: the mean of its noise (PH 3.1), so that clamping keeps the
//! brightness. The means are measured here, of the noises in f64.

use crate::formulas::dual::place;
use crate::formulas::harness::{Check, OCTAVES};
use crate::formulas::knots::{Weight, cubic, lattice, perlin, quintic, wavelet};
use crate::formulas::values::Random;
use glam::DVec3;
use hypertexture::shader::Library;
use std::sync::LazyLock;

crate::rows! {
    p39_an_octave_that_fades_leaves_the_mean_of_its_noise = means,
        "weights/quintic.glsl": "MEAN_OF_GRADIENTS = 0.156" => "MEAN_OF_GRADIENTS = 0.165",
        "weights/cubic.glsl": "MEAN_OF_VALUES = 0.261" => "MEAN_OF_VALUES = 0.156",
        "octave_gradient.glsl": "OCTAVE_MEAN MEAN_OF_GRADIENTS" => "OCTAVE_MEAN MEAN_OF_VALUES",
        "noise/arrays.glsl": "NOISE_MEAN MEAN_OF_GRADIENTS" => "NOISE_MEAN MEAN_OF_VALUES",
        "noise/tables.glsl": "NOISE_MEAN MEAN_OF_GRADIENTS" => "NOISE_MEAN MEAN_OF_VALUES",
        "noise/procedural.glsl": "NOISE_MEAN MEAN_OF_GRADIENTS" => "NOISE_MEAN MEAN_OF_VALUES",
        "noise/block.glsl": "MEANS_IN_BLOCKS.z" => "MEANS_IN_BLOCKS.x",
        "noise/random.glsl": "NOISE_MEAN random_mean" => "NOISE_MEAN MEAN_OF_GRADIENTS",
        "noise/wavelet.glsl": "NOISE_MEAN MEAN_OF_VALUES" => "NOISE_MEAN MEAN_OF_GRADIENTS",
        "turbulence/octaves.glsl": "OCTAVE_MEAN NOISE_MEAN" => "OCTAVE_MEAN MEAN_OF_GRADIENTS",
        "turbulence/lookups4.glsl": "MEANS_IN_BLOCKS.z" => "MEANS_IN_BLOCKS.y",
        "turbulence/lookups8.glsl": "MEANS_IN_BLOCKS.z" => "MEANS_IN_BLOCKS.y",
        "turbulence/channels.glsl": "mix(MEANS_IN_BLOCKS" => "mix(MEANS_IN_BLOCKS.zyxw";
}

/// Relative: of three digits, and of means over so many places.
const TOLERANCE: f64 = 0.02;
const PLACES: usize = 40_000;

fn mean(noise: impl Fn(DVec3) -> f64) -> f64 {
    let mut random = Random::new(0, "means");
    (0..PLACES).map(|_| noise(random.in_cube(100.0)).abs()).sum::<f64>() / PLACES as f64
}

/// The noise as a linear filter reads it from a block with so many texels for each cell.
fn filtered(p: DVec3, texels: f64, weight: Weight) -> f64 {
    let at = p * texels - 0.5;
    let corners = (0..8).map(|corner| {
        let texel = at.floor() + DVec3::from_array([0, 1, 2].map(|axis| f64::from(corner >> axis & 1u8)));
        let part = 1.0 - (at - texel).abs();
        part.element_product() * lattice(place((texel + 0.5) / texels), weight, 1 << 20).v
    });
    corners.sum()
}

/// The means by weights: of gradients from a hash and from tables, of values, of blocks with 16, 8, 4 and 2 texels a cell.
static MEANS: LazyLock<[[f64; 7]; 2]> = LazyLock::new(|| {
    [quintic as Weight, cubic].map(|weight| {
        let [a, b, c, d] = [16.0, 8.0, 4.0, 2.0].map(|texels| mean(|p| filtered(p, texels, weight)));
        let hashed = mean(|p| lattice(place(p), weight, 1 << 20).v);
        [hashed, mean(|p| perlin(place(p), weight, |g| g).v), mean(|p| wavelet(place(p), weight).v), a, b, c, d]
    })
});

/// Of every strategy that sums octaves, and of every noise that one of them takes, samples as wide as eight cells.
fn means(library: &Library) -> f64 {
    let strategies =
        library.modules("turbulence").into_iter().filter(|module| !["encoded", "octaves"].contains(module));
    let of_strategies = strategies.map(|module| (module, "procedural"));
    let of_noises = library.modules("noise").into_iter().map(|module| ("octaves", module));
    let mut worst = 0.0f64;
    for (turbulence, noise) in of_strategies.chain(of_noises) {
        for (weights, [hashed, tables, values, blocks @ ..]) in [("quintic", MEANS[0]), ("cubic", MEANS[1])] {
            let text = "#include <turbulence>\nvoid check() { out0.x = turbulence_gradient(p0.xyz, 8.0).w; }";
            let slots = [("turbulence", turbulence), ("noise", noise), ("weights", weights), ("bandlimit", "clamp")];
            let octaves = if turbulence == "lookups4" { 4 } else { OCTAVES };
            let own = if turbulence == "octaves" { noise } else { turbulence };
            worst = Check::new(library, &slots, text)
                .worst(|at, found| {
                    let octave = |index: u32| match own {
                        "procedural" | "hybrid" => hashed,
                        "arrays" | "tables" => tables,
                        "wavelet" => values,
                        "block" | "lookups4" | "lookups8" => blocks[2],
                        "channels" => blocks[index as usize % 4],
                        "random" => at.number("random_mean"),
                        _ => panic!("{own}: what is the mean of its noise?"),
                    };
                    let all: f64 = (0..octaves).map(|index| octave(index) / f64::from(1u32 << index)).sum();
                    (found[0] / all - 1.0).abs() / TOLERANCE
                })
                .max(worst);
            if worst > 1.0 {
                return worst; // it fails whatever follows
            }
        }
    }
    worst
}

/// Means of the octaves in blocks of turbulence.
#[test]
fn the_means_of_blocks_are_those_of_the_shader() {
    use hypertexture::noise::Weights;
    for (weights, [hashed, .., a, b, c, d]) in [(Weights::Quintic, MEANS[0]), (Weights::Cubic, MEANS[1])] {
        for (texels, mean) in [(64, hashed), (16, a), (8, b), (4, c), (2, d)] {
            let stated = f64::from(weights.mean_of_block(texels));
            assert!((stated / mean - 1.0).abs() < TOLERANCE, "{weights:?}, {texels}: {stated} for {mean}");
        }
    }
}
