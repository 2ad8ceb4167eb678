//! Validation of samples, integration and rays against what the modules take.

use super::check::within;
use super::header::{declaring, header};
use super::loops::{BENDING_LOOPS, BENDING_STEPS, LOOP_BUDGET, SHADOW_SAMPLES};
use crate::scene::{Integration, Jitter, Pass, RayPath, Repeat, Scene, SceneError};
use crate::shader::Declarations;
use crate::shader::library::Library;

impl Scene {
    pub(super) fn check_quality(&self, library: &Library) -> Result<(), SceneError> {
        let (quality, effect) = (&self.quality, &self.effect);
        if quality.pass == Pass::March && effect.ray_path == RayPath::Straight {
            let most = (self.loop_budget(library) / self.sample_loops(library)).floor();
            if quality.samples as f32 > most {
                let limit = format!(
                    "must be from 1 to {most} by rays, whose loops add up; quality.pass = \"slices\" takes more"
                );
                return Err(SceneError::value("quality.samples", quality.samples, limit));
            }
        }
        let shadow_loops = SHADOW_SAMPLES as f32 * self.procedural_loops(library);
        if self.light.shadows && self.has_noise_loops(library) && shadow_loops > LOOP_BUDGET {
            let limit = "needs fewer modules or octaves, or noise = \"block\" and turbulence = \"encoded\": shadow rays \
                         would exceed the loop limit of some drivers";
            return Err(SceneError::value("light.shadows", true, limit));
        }
        let has_segments = |declared: &Declarations| declared.segments.is_some();
        if quality.integration == Integration::Segment && !has_segments(&header(library, "classify", &effect.classify))
        {
            let limit = format!(
                "effect.classify = \"{}\" has points only; use {}, or integration = \"point\"",
                effect.classify,
                declaring(library, "classify", has_segments)
            );
            return Err(SceneError::value("quality.integration", "segment", limit));
        }
        let cells = quality.turbulence_cells;
        if 2 * cells > quality.block_size {
            let limit = format!("at most half of quality.block_size = {}", quality.block_size);
            return Err(SceneError::value("quality.turbulence_cells", cells, limit));
        }
        for (slot, repeat, module) in [
            ("noise", effect.noise_repeat, &effect.noise),
            ("turbulence", effect.turbulence_repeat, &effect.turbulence),
        ] {
            if repeat != Repeat::Own && header(library, slot, module).period.is_some() {
                let limit = format!("must be \"own\" with {module}, which repeats as its memory does; use procedural");
                return Err(SceneError::value(format!("effect.{slot}_repeat"), format!("{repeat:?}"), limit));
            }
        }
        Ok(())
    }

    /// Checks that bent rays have the settings they need, and that settings for them are only used with them.
    pub(super) fn check_ray(&self, library: &Library) -> Result<(), SceneError> {
        let effect = &self.effect;
        let refuse =
            |field: &str, value: &str, limit: &str| Err(SceneError::value(field, format!("\"{value}\""), limit));
        if effect.ray_path == RayPath::Straight {
            let unused = [
                ("effect.environment", &effect.environment, effect.environment != "none"),
                ("effect.absorption", &effect.absorption, effect.absorption != "none"),
                ("effect.classify", &effect.classify, effect.classify == "clear"),
            ];
            return match unused.into_iter().find(|(_, _, set)| *set) {
                None => Ok(()),
                Some((field, value, _)) => refuse(field, value, "needs effect.ray_path = \"refracted\""),
            };
        }
        let refuse_path = |limit| refuse("effect.ray_path", "refracted", limit);
        if self.quality.pass == Pass::Slices {
            return refuse_path("needs quality.pass = \"march\": light does not bend from slice to slice");
        }
        if self.has_noise_loops(library) {
            return refuse_path(
                "needs turbulence = \"encoded\", and a noise whose header has `@loops 1`: a ray that bends reads too much of a sum",
            );
        }
        let straight_only = [
            ("quality.integration", "segment", self.quality.integration == Integration::Segment, "\"point\""),
            ("quality.jitter", "on", self.quality.jitter != Jitter::None, "\"none\""),
            ("effect.gradient", effect.gradient.as_str(), effect.gradient != "analytic", "\"analytic\""),
        ];
        if let Some((field, value, _, other)) = straight_only.into_iter().find(|entry| entry.2) {
            return refuse(field, value, &format!("must be {other} where effect.ray_path = \"refracted\""));
        }
        if self.has_several() {
            return refuse_path("needs a scene of one object");
        }
        let most = ((LOOP_BUDGET / BENDING_LOOPS - BENDING_STEPS[1]) / BENDING_STEPS[0]).floor();
        within("quality.samples", self.quality.samples as f32, 1.0, most)
    }
}
