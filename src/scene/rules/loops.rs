//! Estimates of the loop iterations of a fragment, against the limit of drivers (`docs/notes/drivers.md`).

use super::header::header;
use crate::scene::{Integration, Scene};
use crate::shader::Library;

/// Most loop iterations of a fragment, below the 65 535 after which lavapipe ends it silently.
pub(in crate::scene) const LOOP_BUDGET: f32 = 60_000.0;
/// Rays that lavapipe marches together at most. All of them wait for the one that finds matter.
const LANES: f32 = 8.0;
/// Most samples of a fragment of the shadow volume: four segments of 16.
pub(crate) const SHADOW_SAMPLES: u32 = 4 * 16;
/// Iterations of a segment, which has up to four places.
const SEGMENT_LOOPS: f32 = 4.0;
/// Iterations of each step of a bent ray: the step, and three gradients of three differences each.
pub(in crate::scene) const BENDING_LOOPS: f32 = 1.0 + 3.0 * 3.0;
/// Steps of a bent ray: for each sample, and in all to locate its interfaces (`refract.frag`).
pub(in crate::scene) const BENDING_STEPS: [f32; 2] = [3.0, 24.0 * (14.0 + 1.0)];

/// Most iterations that look for surfaces between samples, besides one for each sample: `MOST_TURNS` of `step_back.glsl` and
/// those of the last step, once for each ray that waits.
const SURFACE_SEARCHES: f32 = LANES * (32.0 + 16.0);

impl Scene {
    /// Iterations of a noise; by default those of a loop over the corners of a cell.
    fn noise_loops(&self, library: &Library) -> f32 {
        header(library, "noise", &self.effect.noise).loops.unwrap_or(9) as f32
    }

    /// Iterations of an octave of turbulence; by default those of a loop over the noise.
    fn octave_loops(&self, library: &Library) -> f32 {
        let own = header(library, "turbulence", &self.effect.turbulence).loops;
        own.map_or_else(|| 1.0 + self.noise_loops(library), |loops| loops as f32)
    }

    /// Whether noise or turbulence has a loop.
    pub(in crate::scene) fn has_noise_loops(&self, library: &Library) -> bool {
        self.noise_loops(library) > 1.0 || self.octave_loops(library) > 0.0
    }

    /// Most iterations of the noise of all objects at a sample.
    pub(in crate::scene) fn procedural_loops(&self, library: &Library) -> f32 {
        self.object_loops(library)
            + self.parts.keys().map(|name| self.part_as_scene(name).object_loops(library)).sum::<f32>()
    }

    /// Whether rays may locate matter before they shade it without exceeding the limit. At worst each of the rays marched
    /// together finds matter while the others wait.
    pub fn may_find_first(&self, library: &Library) -> bool {
        let looks = if self.looks_back(library) { 2.0 } else { 1.0 };
        let each = looks * LANES * self.test_loops(library) + 2.0 + self.procedural_loops(library);
        self.quality.samples as f32 * each <= self.loop_budget(library)
    }

    /// Iterations of a test for matter.
    fn test_loops(&self, library: &Library) -> f32 {
        let octave = self.octave_loops(library).max(self.noise_loops(library));
        1.0 + self.phases(library) * self.effect.warp.len() as f32 * self.effect.octaves as f32 * octave
    }

    /// Iterations of a test between two samples, for all objects.
    fn between_samples_loops(&self, library: &Library) -> f32 {
        let parts = self.parts.keys().map(|name| self.part_as_scene(name).test_loops(library));
        if self.has_noise_loops(library) { self.test_loops(library) + parts.sum::<f32>() } else { 1.0 }
    }

    /// Iterations left for the samples of a ray after the tests between them.
    pub(in crate::scene) fn loop_budget(&self, library: &Library) -> f32 {
        LOOP_BUDGET - SURFACE_SEARCHES * self.between_samples_loops(library)
    }

    /// Most iterations of a sample.
    pub(in crate::scene) fn sample_loops(&self, library: &Library) -> f32 {
        let noise = if self.has_noise_loops(library) { self.procedural_loops(library) } else { 1.0 };
        match self.quality.integration {
            Integration::Point if self.looks_back(library) => noise + self.between_samples_loops(library),
            Integration::Point => noise,
            Integration::Segment => noise + SEGMENT_LOOPS,
        }
    }

    /// Iterations of the noise of one object at a sample: at each place where the density is evaluated, a sum of octaves for
    /// every module that changes the density, one for the color, and three more noises.
    fn object_loops(&self, library: &Library) -> f32 {
        let effect = &self.effect;
        let places = match self.quality.integration {
            Integration::Point => 1.0,
            Integration::Segment => 4.0,
        };
        let media = effect.medium.split('+').map(|medium| ("medium", medium.trim()));
        let more: f32 = media
            .chain([("gradient", effect.gradient.as_str())])
            .map(|(slot, name)| header(library, slot, name).places as f32)
            .sum();
        let layers = if effect.medium.contains('+') { 2.0 } else { 0.0 }; // each medium evaluates its own
        let sums = (2 * effect.warp.len() + effect.dmf.len() + 1).max(2) as f32; // a warp for distance and normal
        let noise = self.noise_loops(library);
        let sum = effect.octaves as f32 * self.octave_loops(library).max(noise);
        self.phases(library) * (places + more + layers) * (sums * sum + 3.0 * noise)
    }

    /// Evaluations of each noise: two in a loop of two phases.
    fn phases(&self, library: &Library) -> f32 {
        if self.looped(library).is_some_and(|looped| looped.two_phases) { 2.0 } else { 1.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::rules::check::tests::refusal;
    use crate::scene::{Part, Pass, TargetFormat};
    use crate::shader;

    #[test]
    fn what_a_module_costs_stands_in_its_header() {
        let shipped = shader::shipped();
        let loops = |change: &dyn Fn(&mut Scene)| {
            let mut scene = Scene::default();
            (scene.effect.octaves, scene.effect.turbulence) = (1, "encoded".into());
            change(&mut scene);
            scene.object_loops(&shipped)
        };
        // One octave of two sums, and three noises more.
        let noises =
            [("arrays", 5.0), ("block", 5.0), ("procedural", 5.0), ("random", 5.0), ("tables", 5.0), ("wavelet", 45.0)];
        assert_eq!(shipped.modules("noise"), noises.map(|(name, _)| name));
        for (name, expected) in noises {
            assert_eq!(loops(&|s| s.effect.noise = name.into()), expected, "{name}");
        }
        let turbulences = [
            ("arrays", 5.0),
            ("channels", 13.0),
            ("encoded", 5.0),
            ("hybrid", 5.0),
            ("lookups4", 5.0),
            ("lookups8", 5.0),
            ("octaves", 7.0),
            ("procedural", 5.0),
            ("tables", 5.0),
        ];
        assert_eq!(shipped.modules("turbulence"), turbulences.map(|(name, _)| name));
        for (name, expected) in turbulences {
            assert_eq!(loops(&|s| s.effect.turbulence = name.into()), expected, "{name}");
            let mut scene = Scene::default();
            scene.effect.turbulence = name.into();
            assert_eq!(scene.has_noise_loops(&shipped), name != "encoded", "{name}");
        }
        for name in shipped.modules("gradient") {
            let places = match name {
                "central" => 7.0,
                "three" => 4.0,
                _ => 1.0,
            };
            assert_eq!(loops(&|s| s.effect.gradient = name.into()), 5.0 * places, "{name}");
        }
        for name in shipped.modules("medium") {
            let places = if name == "vapor" { 2.0 } else { 1.0 };
            assert_eq!(loops(&|s| s.effect.medium = name.into()), 5.0 * places, "{name}");
        }
        assert_eq!(loops(&|s| s.effect.medium = "hair + vapor".into()), 5.0 * 4.0);
    }

    #[test]
    fn a_module_that_does_not_say_what_it_costs_costs_the_most() {
        let library = shader::shipped().with_module("noise", "mine", "").with_module("turbulence", "mine", "");
        let mut scene = Scene::default();
        (scene.effect.octaves, scene.effect.noise) = (1, "mine".into());
        assert_eq!(scene.object_loops(&library), 2.0 * 9.0 + 3.0 * 9.0);
        scene.effect.turbulence = "mine".into();
        assert_eq!(scene.object_loops(&library), 2.0 * 10.0 + 3.0 * 9.0);
        scene.effect.noise = "block".into();
        assert_eq!(scene.object_loops(&library), 2.0 * 2.0 + 3.0);
        assert_eq!(scene.object_loops(&library.with_module("turbulence", "mine", "// @loops 4\n")), 2.0 * 4.0 + 3.0);
    }

    #[test]
    fn a_ray_may_not_loop_longer_than_every_device_bears() {
        let march = |samples, noise: &str| {
            let noise = noise.to_string();
            move |s: &mut Scene| (s.quality.pass, s.quality.samples, s.effect.noise) = (Pass::March, samples, noise)
        };
        assert!(
            refusal(march(60_001, "block")).starts_with("quality.samples = 60001: must be from 1 to 59616 by rays")
        );
        assert!(refusal(march(500, "wavelet")).starts_with("quality.samples = 500: must be from 1 to 348 by rays"));
        let segments = |s: &mut Scene| {
            march(149, "wavelet")(s);
            s.quality.integration = Integration::Segment;
        };
        assert!(refusal(segments).starts_with("quality.samples = 149: must be from 1 to 86 by rays"));
    }

    #[test]
    fn long_loops_use_two_phases_in_targets_that_mark_cut_rays() {
        let library = shader::shipped();
        let empty_space = |samples, warp: &[&str], target| {
            let mut scene = crate::scene::preset("lit").unwrap();
            (scene.quality.pass, scene.quality.samples, scene.effect.noise) = (Pass::March, samples, "wavelet".into());
            scene.effect.warp = warp.iter().map(|name| name.to_string()).collect();
            scene.quality.target = target;
            scene.slots(&library)["empty_space"][0].clone()
        };
        let bits = TargetFormat::Unorm8;
        assert_eq!(empty_space(256, &[], bits), "skip");
        assert_eq!(empty_space(349, &[], bits), "leap");
        assert_eq!(empty_space(256, &["melting"], bits), "leap");
        for floats in [TargetFormat::Float16, TargetFormat::Float32] {
            assert_eq!(empty_space(349, &["melting"], floats), "skip");
        }
    }

    #[test]
    fn every_object_and_the_light_count_in_what_a_fragment_may_loop() {
        let several = |s: &mut Scene| {
            (s.quality.pass, s.quality.samples, s.effect.noise) = (Pass::March, 300, "wavelet".into());
            s.light.shadows = false;
            s.parts.insert(
                "b".into(),
                Part { effect: s.effect.clone(), parameters: s.parameters.clone(), ..Part::default() },
            );
        };
        assert!(refusal(several).starts_with("quality.samples = 300: must be from 1 to 172 by rays"));
        let shaded = |s: &mut Scene| {
            (s.effect.noise, s.effect.octaves, s.light.shadows) = ("wavelet".into(), 10, true);
            (s.quality.pass, s.effect.turbulence) = (Pass::Slices, "octaves".into());
            s.effect.gradient = "central".into();
            s.effect.dmf.push("fire".into());
        };
        assert!(refusal(shaded).starts_with("light.shadows = true: needs fewer modules or octaves"));
    }
}
