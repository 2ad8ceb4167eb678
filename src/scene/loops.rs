//! How long a fragment may loop, and how long a scene makes it.

use super::{Integration, Scene};

/// Loop iterations of one fragment that every device bears: lavapipe ends a fragment in silence after 65 535.
pub(super) const LOOP_BUDGET: f32 = 60_000.0;
/// Samples of one fragment of the shadow volume, at most: four segments of 64.
pub(super) const SHADOW_SAMPLES: f32 = 4.0 * 64.0;
/// Iterations of a ray that bends, for each step of it: the step, and three gradients of three differences each.
pub(super) const BENDING_LOOPS: f32 = 1.0 + 3.0 * 3.0;
/// Steps of a ray that bends, for each sample of the scene, and in all to locate its interfaces: see `refract.frag`.
pub(super) const BENDING_STEPS: [f32; 2] = [3.0, 24.0 * (14.0 + 1.0)];

impl Scene {
    /// Iterations of one noise: of those that ship, the wavelets alone loop, over the corners of a cell.
    pub(super) fn noise_loops(&self) -> f32 {
        match self.effect.noise.as_str() {
            "block" | "procedural" | "tables" | "arrays" | "random" => 1.0,
            _ => 9.0,
        }
    }

    /// Iterations of the noise at one sample of a ray, at most, for all objects.
    pub(super) fn procedural_loops(&self) -> f32 {
        self.own_loops() + self.parts.keys().map(|name| self.alone(name).own_loops()).sum::<f32>()
    }

    /// Those of one object: a sum of octaves for every module that changes the density, one for the color and three more
    /// noises, at each place where the density is asked for.
    fn own_loops(&self) -> f32 {
        let places = match self.quality.integration {
            Integration::Point => 1.0,
            Integration::Segment => 3.0,
        };
        let more = match self.effect.gradient.as_str() {
            "central" => 6.0,
            "three" => 3.0,
            _ => 0.0,
        };
        let vapor = f32::from(u8::from(self.effect.medium == "vapor")); // it asks once more, towards the light
        let layers = if self.effect.medium.contains('+') { 2.0 } else { 0.0 }; // each medium asks again for its own
        let sums = (self.effect.warp.len() + self.effect.dmf.len() + 1).max(2) as f32;
        let octave = match self.effect.turbulence.as_str() {
            "channels" => 5.0, // and the six differences of its gradient
            "lookups8" | "lookups4" | "encoded" | "tables" | "arrays" | "procedural" | "hybrid" => 1.0,
            _ => 1.0 + self.noise_loops(),
        };
        let sum = self.effect.octaves as f32 * octave.max(self.noise_loops());
        (places + more + vapor + layers) * (sums * sum + 3.0 * self.noise_loops())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::check::tests::refusal;
    use crate::scene::{Part, Pass};

    #[test]
    fn a_ray_may_not_loop_longer_than_every_device_bears() {
        let march = |samples, noise: &str| {
            let noise = noise.to_string();
            move |s: &mut Scene| (s.quality.pass, s.quality.samples, s.effect.noise) = (Pass::March, samples, noise)
        };
        assert_eq!(refusal(march(60_001, "block")), "quality.samples = 60001: must be from 1 to 60000");
        assert_eq!(refusal(march(500, "wavelet")), "quality.samples = 500: must be from 1 to 350");
        let segments = |s: &mut Scene| {
            march(149, "wavelet")(s);
            s.quality.integration = Integration::Segment;
        };
        assert_eq!(refusal(segments), "quality.samples = 149: must be from 1 to 116");
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
        assert_eq!(refusal(several), "quality.samples = 300: must be from 1 to 175");
        let shaded = |s: &mut Scene| {
            (s.effect.noise, s.effect.octaves, s.light.shadows) = ("wavelet".into(), 10, true);
            s.effect.turbulence = "octaves".into();
            s.effect.dmf.push("fire".into());
        };
        assert!(refusal(shaded).starts_with("light.shadows = true: needs fewer modules or octaves"));
    }
}
