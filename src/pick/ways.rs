//! The ways to draw a scene that have one truth.

use crate::compare::CompareError;
use crate::compare::candidates::{Candidate, Sweep, candidates};
use crate::glsl::Library;
use crate::reference::truth_of;
use crate::scene::{Order, Pass, Rule, Scene, Traverse};

/// The ways of a scene without their samples.
pub(super) struct Families {
    pub(super) kept: Vec<Candidate>,
    /// Those that a bound known beforehand excludes.
    pub(super) left_out: usize,
}

/// Every way that has the truth of the scene, with the fewest samples, and that may have an error below `error`.
pub(super) fn families(scene: &Scene, library: &Library, error: f64) -> Result<Families, CompareError> {
    let truth = truth_of(scene, library)?;
    let mut base = scene.clone();
    // Said, so that another module does not repeat as it would by itself.
    (base.effect.noise_repeat, base.effect.turbulence_repeat) =
        (truth.effect.noise_repeat, truth.effect.turbulence_repeat);
    (base.quality.traverse, base.quality.order) = (Traverse::Leap, Order::FrontToBack);
    let sweep = Sweep { samples: Some(vec![super::SAMPLES[0]]), ..Sweep::default() };
    let mut families = Families { kept: Vec::new(), left_out: 0 };
    for mut way in candidates(&base, library, &sweep)? {
        if truth_of(&way.scene, library)? != truth {
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
    Ok(families)
}

/// A way with more samples, or with fewer.
pub(super) fn with_samples(way: &Candidate, samples: u32) -> Candidate {
    let mut way = way.clone();
    way.scene.quality.samples = samples;
    way
}

/// The way that has no error but that of its steps.
pub(super) fn finest(scene: &Scene, library: &Library, samples: u32) -> Result<Scene, CompareError> {
    let mut finest = truth_of(scene, library)?;
    finest.quality.samples = samples;
    let rules = [(Pass::March, Rule::Segment), (Pass::Slices, Rule::Segment), (Pass::March, Rule::Point)];
    for (pass, rule) in rules {
        (finest.quality.pass, finest.quality.rule) = (pass, rule);
        if finest.check(library).is_ok() {
            return Ok(finest);
        }
    }
    (finest.quality.pass, finest.quality.rule) = (Pass::Slices, Rule::Point);
    Ok(finest)
}
