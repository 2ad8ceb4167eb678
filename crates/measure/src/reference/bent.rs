//! The light of rays that bend.
//!
//! Role: how a ray bends depends on its own steps, and what it meets at last is filtered by its neighbors, so nothing
//! can be sampled along it beforehand: the program of the picture itself runs in f64, four pixels of a quad together,
//! with ever more steps, between which it locates interfaces as exactly as f64 can. Invariant: what two numbers of steps differ by is the error that is stated.

use super::{Reference, ReferenceError, Stop, go_on};
use hypertexture::eval;
use hypertexture::render::variant::{Program, Variant, VariantError};
use hypertexture::render::{CpuInputs, OCTAVES_ID, Subject};
use hypertexture::shader::Library;
use rayon::prelude::*;
use std::collections::BTreeMap;

/// Steps through the scene to begin with: smooth glass is done with them.
pub(super) const FEWEST: u32 = 256;
/// So many times they are doubled, at most; a device may not bear as many loops.
const DOUBLINGS: u32 = 4;
/// Halvings of a step that locate an interface in f64: total reflection multiplies what is left at each.
const HALVINGS: &str = "44";
/// Quads that are evaluated together.
const BATCH: usize = 16;

/// The light of some pixels, and by how much twice the steps changed it.
pub(super) fn reference(
    library: &Library,
    truth: &Variant,
    subject: &Subject,
    pixels: &[[u32; 2]],
    tolerance: f64,
    progress: &(dyn Fn(f32) + Sync),
    stop: Stop<'_>,
) -> Result<Reference, ReferenceError> {
    let glass = Glass::new(library, truth, subject)?;
    let mut found = glass.light(FEWEST, pixels, stop)?;
    let mut estimate = vec![f64::INFINITY; pixels.len()];
    for doubling in 1..=DOUBLINGS {
        progress(doubling as f32 / (DOUBLINGS + 1) as f32);
        let coarse: Vec<usize> = (0..pixels.len()).filter(|&index| estimate[index] > tolerance).collect();
        if coarse.is_empty() {
            break;
        }
        let asked: Vec<[u32; 2]> = coarse.iter().map(|&index| pixels[index]).collect();
        for (&index, finer) in coarse.iter().zip(glass.light(FEWEST << doubling, &asked, stop)?) {
            estimate[index] = (0..4).map(|c| (finer[c] - found[index][c]).abs()).fold(0.0, f64::max);
            found[index] = finer;
        }
    }
    progress(1.0);
    let open = vec![1.0; pixels.len()]; // no bounds follow a ray that bends
    Ok(Reference { size: truth.scene.image.size, pixels: found, estimate, open })
}

/// The program that follows rays through glass.
pub(super) fn linked(variant: &Variant, library: &Library) -> Result<Program, VariantError> {
    variant.program_of(library, library.with_constant("HALVINGS", HALVINGS))
}

/// The program of a picture through glass.
struct Glass<'a> {
    library: &'a Library,
    subject: &'a Subject,
    variant: &'a Variant,
    linked: Program,
    program: eval::Program,
}

impl<'a> Glass<'a> {
    fn new(library: &'a Library, variant: &'a Variant, subject: &'a Subject) -> Result<Glass<'a>, ReferenceError> {
        let linked = linked(variant, library)?;
        let program = eval::Program::read(&linked.fragment, &[(OCTAVES_ID, variant.scene.effect.octaves)])?;
        Ok(Glass { library, subject, variant, linked, program })
    }

    /// The light of some pixels, by so many steps through the scene.
    fn light(&self, steps: u32, pixels: &[[u32; 2]], stop: Stop<'_>) -> Result<Vec<[f64; 4]>, ReferenceError> {
        let Glass { library, subject, variant, linked, program } = self;
        let mut variant = (*variant).clone();
        variant.scene.quality.samples = steps;
        let cpu_inputs = CpuInputs::new(library, &variant, subject, linked)?;
        let moments = cpu_inputs.moments(linked)?;
        let mut inputs = cpu_inputs.exact();
        let mut quads: BTreeMap<[u32; 2], [[f64; 4]; 4]> =
            pixels.iter().map(|p| (p.map(|c| c / 2), [[0.0; 4]; 4])).collect();
        for blocks in &moments {
            inputs.blocks.clone_from(blocks);
            let bound = program.bind(&inputs)?;
            let mut all: Vec<(&[u32; 2], &mut [[f64; 4]; 4])> = quads.iter_mut().collect();
            all.par_chunks_mut(BATCH).try_for_each(|quads| -> Result<(), ReferenceError> {
                go_on(stop)?;
                let place =
                    |quad: [u32; 2], k: u32| [2 * quad[0] + k % 2, 2 * quad[1] + k / 2].map(|c| f64::from(c) + 0.5);
                let at = quads.iter().flat_map(|(quad, _)| [0, 1, 2, 3].map(|k| place(**quad, k)));
                let fragment_coordinates = at.map(|[x, y]| [x, y, 0.5, 1.0]).collect();
                let lanes = eval::Invocations { fragment_coordinates, varyings: BTreeMap::new() };
                let light = bound.run::<f64>(&lanes)?.remove(&0).unwrap_or_default();
                for ((_, sum), light) in quads.iter_mut().zip(light.as_chunks::<4>().0) {
                    for (sum, light) in sum.as_flattened_mut().iter_mut().zip(light.as_flattened()) {
                        *sum += light / moments.len() as f64;
                    }
                }
                Ok(())
            })?;
        }
        Ok(pixels.iter().map(|[x, y]| quads[&[x / 2, y / 2]][(y % 2 * 2 + x % 2) as usize]).collect())
    }
}
