//! Ground truths of candidates, each computed once.
//!
//! Candidates of one noise pattern have one truth. Those of another pattern are of another picture: no front holds both.

use super::ComputeReference;
use crate::reference::{Reference, truth_of};
use hypertexture::noise::Period;
use hypertexture::render::variant::Variant;
use hypertexture::scene::Scene;
use hypertexture::shader::{Library, LibraryError};
use std::sync::Arc;

/// The exact picture that candidates of one noise pattern approximate.
#[derive(Clone, Debug, PartialEq)]
pub struct GroundTruth {
    /// The noise pattern in words.
    pub pattern: String,
    /// Whether it is that of the scene that is compared.
    pub is_own: bool,
    /// The picture.
    pub reference: Arc<Reference>,
}

impl GroundTruth {
    /// Root mean square of its own error, as far as samples say.
    pub fn error(&self) -> f64 {
        self.reference.error()
    }

    /// The same with all the opacity that bounds leave open.
    pub fn bound(&self) -> f64 {
        self.reference.bound()
    }

    /// The part of the pixels that bounds prove to hold nothing else.
    pub fn proven(&self) -> f64 {
        self.reference.proven() as f64 / self.reference.pixels.len().max(1) as f64
    }
}

/// The truths that were asked for so far.
#[derive(Clone, Debug, Default)]
pub(super) struct GroundTruths {
    own: Option<Scene>,
    known: Vec<(Scene, Result<Arc<GroundTruth>, String>)>,
}

impl GroundTruths {
    /// None yet, of a scene and its candidates.
    pub(super) fn new(scene: &Scene, library: &Library) -> Result<GroundTruths, LibraryError> {
        Ok(GroundTruths { own: Some(truth_of(scene, library)?), known: Vec::new() })
    }

    /// Whether a scene has the truth of the scene that is compared.
    pub(super) fn is_own(&self, library: &Library, scene: &Scene) -> bool {
        truth_of(scene, library).ok() == self.own
    }

    /// Number of truths, with those of further scenes.
    pub(super) fn count<'a>(&self, library: &Library, scenes: impl Iterator<Item = &'a Scene>) -> usize {
        let mut all: Vec<Scene> = self.known.iter().map(|(truth, _)| truth.clone()).collect();
        for truth in scenes.filter_map(|scene| truth_of(scene, library).ok()) {
            if !all.contains(&truth) {
                all.push(truth);
            }
        }
        all.len()
    }

    /// The truth of a scene, whatever its quality.
    pub(super) fn of(
        &mut self,
        library: &Library,
        scene: &Scene,
        compute_reference: &mut ComputeReference<'_>,
    ) -> Result<Arc<GroundTruth>, String> {
        let truth = truth_of(scene, library).map_err(|error| error.to_string())?;
        if let Some((_, known)) = self.known.iter().find(|(known, _)| *known == truth) {
            return known.clone();
        }
        let found = compute_reference(&truth).map(|reference| {
            Arc::new(GroundTruth {
                pattern: pattern(&truth, library),
                is_own: self.own.as_ref() == Some(&truth),
                reference,
            })
        });
        self.known.push((truth, found.clone()));
        found
    }
}

/// The noise pattern of a truth in words: what it is made of, and where it repeats.
fn pattern(truth: &Scene, library: &Library) -> String {
    let Ok(variant) = Variant::of(truth, library) else { return "unknown noise".into() };
    let effect = &truth.effect;
    let slots = [("turbulence", &effect.turbulence, variant.periods[1]), ("noise", &effect.noise, variant.periods[0])];
    let read = slots.into_iter().filter(|(slot, ..)| variant.reads(slot));
    let words: Vec<String> = read.map(|(slot, module, period)| format!("{module} {slot}{}", repeats(period))).collect();
    if words.is_empty() { "no noise".into() } else { words.join(", ") }
}

fn repeats(Period { cells, growing, cycle }: Period) -> String {
    let after = match growing {
        _ if cells >= Period::ENDLESS.cells => return String::new(),
        false => "each octave".into(),
        true if cycle < Period::ENDLESS.cycle => format!("the first of every {cycle} octaves"),
        true => "the first octave".to_string(),
    };
    format!(" that repeats after {cells} cells of {after}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture::scene::preset;
    use hypertexture::shader;

    fn blank(scene: &Scene) -> Arc<Reference> {
        let count = (scene.image.size[0] * scene.image.size[1]) as usize;
        let (pixels, estimate, open) = (vec![[0.0; 4]; count], vec![0.0; count], vec![0.0; count]);
        Arc::new(Reference { size: scene.image.size, pixels, estimate, open })
    }

    #[test]
    fn a_truth_is_computed_once_for_all_qualities() {
        let mut asked = 0;
        let mut compute_reference = |scene: &Scene| {
            asked += 1;
            Ok(blank(scene))
        };
        let library = shader::shipped();
        let mut scene = preset("fire").unwrap();
        let mut truths = GroundTruths::new(&scene, &library).unwrap();
        for samples in [8, 16, 32] {
            scene.quality.samples = samples;
            assert!(truths.of(&library, &scene, &mut compute_reference).unwrap().is_own);
        }
        scene.effect.turbulence = "procedural".into();
        assert!(!truths.of(&library, &scene, &mut compute_reference).unwrap().is_own);
        assert_eq!(asked, 2);
        let failed = truths.of(&library, &preset("lit").unwrap(), &mut |_| Err("no such function".into()));
        assert_eq!(failed.unwrap_err(), "no such function");
    }

    #[test]
    fn patterns_are_named_by_their_noise_and_period() {
        let library = shader::shipped();
        let named = |effect: &str, turbulence: &str| {
            let mut scene = preset(effect).unwrap();
            scene.effect.turbulence = turbulence.into();
            pattern(&truth_of(&scene, &library).unwrap(), &library)
        };
        assert_eq!(named("fire", "encoded"), "procedural turbulence that repeats after 4 cells of the first octave");
        assert_eq!(named("fire", "hybrid"), named("fire", "encoded"));
        assert_eq!(named("fire", "lookups8"), "procedural turbulence that repeats after 16 cells of each octave");
        assert_eq!(
            named("fire", "channels"),
            "procedural turbulence that repeats after 4 cells of the first of every 4 octaves"
        );
        assert_eq!(named("fire", "procedural"), "procedural turbulence");
        assert_eq!(
            named("fire", "octaves"),
            "octaves turbulence, procedural noise that repeats after 16 cells of each octave"
        );
        assert_eq!(named("lit", "encoded"), "no noise");
    }

    #[test]
    fn the_bound_of_a_truth_adds_open_error_to_its_estimate() {
        let reference =
            Reference { size: [2, 1], pixels: vec![[0.0; 4]; 2], estimate: vec![0.3, 0.4], open: vec![0.0, 0.9] };
        let truth = GroundTruth { pattern: String::new(), is_own: true, reference: reference.into() };
        assert!((truth.error() - (0.25f64 / 2.0).sqrt()).abs() < 1e-15);
        assert!((truth.bound() - (1.09f64 / 2.0).sqrt()).abs() < 1e-15, "no pixel is off by more than 1");
        assert_eq!(truth.proven(), 0.5);
    }
}
