//! The candidates of a scene: settings that have one truth.

use crate::compare::CompareError;
use crate::compare::candidates::{Candidate, Sweep, candidates};
use crate::reference::truth_of;
use hypertexture::scene::{EmptySpace, Filter, Integration, Order, Pass, Scene};
use hypertexture::shader::Library;
use std::collections::BTreeSet;

/// Fewest and most samples of a candidate.
pub(super) const SAMPLES: [u32; 2] = [8, 4096];

/// The candidates of a scene without their samples.
pub(super) struct Families {
    pub(super) kept: Vec<Candidate>,
    /// Those that a bound known beforehand excludes.
    pub(super) left_out: usize,
}

/// Every candidate that has the truth of the scene, with the fewest samples, and that may have an error below `error`;
/// `filters`: by both filters, where that of the device may be off.
pub(super) fn families(scene: &Scene, library: &Library, error: f64, filters: bool) -> Result<Families, CompareError> {
    let truth = truth_of(scene, library)?;
    let sweep = Sweep { samples: Some(vec![SAMPLES[0]]), filters, ..Sweep::default() };
    let mut families = Families { kept: Vec::new(), left_out: 0 };
    let mut known = BTreeSet::new();
    let mut refused = None;
    for base in bases(scene, &truth) {
        let found = match candidates(&base, library, &sweep) {
            Ok(found) => found,
            Err(error) => {
                refused.get_or_insert(error); // such as objects that would have different noises
                continue;
            }
        };
        for mut candidate in found {
            if truth_of(&candidate.scene, library)? != truth || !known.insert(candidate.curve().label()) {
                continue;
            }
            if candidate.blend_bound() > error {
                families.left_out += 1;
                continue;
            }
            if candidate.scene.quality.pass == Pass::March {
                // A ray may end early by a part of the error that it may have.
                candidate.scene.quality.early_termination = (0.25 * error).min(0.1) as f32;
            }
            families.kept.push(candidate);
        }
    }
    if families.kept.is_empty() && families.left_out == 0 {
        Err(refused.unwrap_or(CompareError::Nothing))
    } else {
        Ok(families)
    }
}

/// The scene with its noise and turbulence as they are, and each of them computed where it is looked up: computed
/// noise needs the period of a block in cells, and a block does not. Computed noise comes first: it has no error of its
/// own, so the time of one that fits is soon known, and nothing slower is drawn.
fn bases(scene: &Scene, truth: &Scene) -> Vec<Scene> {
    let mut bases = Vec::new();
    for computed in [[true, true], [false, true], [true, false], [false, false]] {
        let mut base = scene.clone();
        let quality = &mut base.quality;
        (quality.empty_space, quality.order, quality.filter) = (EmptySpace::Skip, Order::FrontToBack, Filter::Device);
        let of_parts = base.parts.iter_mut().map(|(name, part)| (&mut part.effect, &truth.parts[name].effect));
        for (effect, exact) in [(&mut base.effect, &truth.effect)].into_iter().chain(of_parts) {
            if computed[0] {
                effect.noise.clone_from(&exact.noise);
                effect.noise_repeat = exact.noise_repeat;
            }
            if computed[1] {
                effect.turbulence.clone_from(&exact.turbulence);
                effect.turbulence_repeat = exact.turbulence_repeat;
            }
        }
        bases.push(base);
    }
    bases
}

/// A candidate with more samples, or with fewer.
pub(super) fn with_samples(candidate: &Candidate, samples: u32) -> Candidate {
    let mut candidate = candidate.clone();
    candidate.scene.quality.samples = samples;
    candidate
}

/// The scenes that have no error but that of their steps, the best first, by this filter.
pub(super) fn finest(
    scene: &Scene,
    library: &Library,
    samples: u32,
    filter: Filter,
) -> Result<Vec<Scene>, CompareError> {
    let truth = truth_of(scene, library)?;
    let settings = [
        (Pass::March, Integration::Segment),
        (Pass::Slices, Integration::Segment),
        (Pass::March, Integration::Point),
        (Pass::Slices, Integration::Point),
    ];
    let finest = settings.into_iter().map(|(pass, integration)| {
        let mut finest = truth.clone();
        let quality = &mut finest.quality;
        (quality.pass, quality.integration, quality.samples) = (pass, integration, samples);
        quality.filter = filter;
        finest
    });
    Ok(finest.filter(|scene| scene.check(library).is_ok()).collect())
}
