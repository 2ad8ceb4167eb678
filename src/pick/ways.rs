//! The ways to draw a scene that have one truth.

use crate::compare::CompareError;
use crate::compare::candidates::{Candidate, Sweep, candidates};
use crate::glsl::Library;
use crate::reference::truth_of;
use crate::scene::{Order, Pass, Rule, Scene, Traverse};
use std::collections::BTreeSet;

/// The ways of a scene without their samples.
pub(super) struct Families {
    pub(super) kept: Vec<Candidate>,
    /// Those that a bound known beforehand excludes.
    pub(super) left_out: usize,
}

/// Every way that has the truth of the scene, with the fewest samples, and that may have an error below `error`.
pub(super) fn families(scene: &Scene, library: &Library, error: f64) -> Result<Families, CompareError> {
    let truth = truth_of(scene, library)?;
    let sweep = Sweep { samples: Some(vec![super::SAMPLES[0]]), ..Sweep::default() };
    let mut families = Families { kept: Vec::new(), left_out: 0 };
    let mut known = BTreeSet::new();
    for base in bases(scene, &truth) {
        for mut way in candidates(&base, library, &sweep)? {
            if truth_of(&way.scene, library)? != truth || !known.insert(way.curve().label()) {
                continue;
            }
            if way.blend_bound() > error {
                families.left_out += 1;
                continue;
            }
            if way.scene.quality.pass == Pass::March {
                // A ray may end early by a part of the error that it may have.
                way.scene.quality.stop = (0.25 * error).min(0.1) as f32;
            }
            families.kept.push(way);
        }
    }
    Ok(families)
}

/// The scene with its noise and turbulence as they are, and each of them computed where it is looked up: what computes
/// must be told after how many cells a block repeats, and a block must not. What computes comes first: it has no error of its
/// own, so the time of one that fits is soon known, and nothing slower is drawn.
fn bases(scene: &Scene, truth: &Scene) -> Vec<Scene> {
    let mut bases = Vec::new();
    for computed in [[true, true], [false, true], [true, false], [false, false]] {
        let mut base = scene.clone();
        (base.quality.traverse, base.quality.order) = (Traverse::Leap, Order::FrontToBack);
        let (effect, exact) = (&mut base.effect, &truth.effect);
        if computed[0] {
            effect.noise.clone_from(&exact.noise);
            effect.noise_repeat = exact.noise_repeat;
        }
        if computed[1] {
            effect.turbulence.clone_from(&exact.turbulence);
            effect.turbulence_repeat = exact.turbulence_repeat;
        }
        bases.push(base);
    }
    bases
}

/// A way with more samples, or with fewer.
pub(super) fn with_samples(way: &Candidate, samples: u32) -> Candidate {
    let mut way = way.clone();
    way.scene.quality.samples = samples;
    way
}

/// The ways that have no error but that of their steps, the best first.
pub(super) fn finest(scene: &Scene, library: &Library, samples: u32) -> Result<Vec<Scene>, CompareError> {
    let truth = truth_of(scene, library)?;
    let ways = [
        (Pass::March, Rule::Segment),
        (Pass::Slices, Rule::Segment),
        (Pass::March, Rule::Point),
        (Pass::Slices, Rule::Point),
    ];
    let finest = ways.into_iter().map(|(pass, rule)| {
        let mut finest = truth.clone();
        (finest.quality.pass, finest.quality.rule, finest.quality.samples) = (pass, rule, samples);
        finest
    });
    Ok(finest.filter(|scene| scene.check(library).is_ok()).collect())
}
