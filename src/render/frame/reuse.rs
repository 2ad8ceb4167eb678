//! Comparison of a prepared scene with another one that it may serve.

use super::destination::Destination;
use super::prepared::Prepared;
use crate::render::variant::{ImageInput, Variant};
use crate::scene::schema::Changes;
use crate::shader::slots::FOLDED;

impl Prepared {
    /// Whether this serves another scene: one that differs only in per-picture values or in size.
    pub(crate) fn fits(&self, variant: &Variant, destination: Destination) -> bool {
        let changes = variant.scene.changes(&self.variant.scene);
        // Half-angle slices blend by the side of the light.
        let has_same_blend = destination.blend(&variant.scene) == self.pipelines.blend();
        let is_served = self.destination.serves(destination) && has_same_blend;
        is_served && !changes.has_any(&[Changes::Targets]) && self.has_same_inputs(variant)
    }

    /// Whether another scene has the same program and images: one that differs only in camera, time, parameters,
    /// samples and targets, with matter of equal reach.
    pub(crate) fn has_same_inputs(&self, variant: &Variant) -> bool {
        let (scene, own) = (&variant.scene, &self.variant.scene);
        // Some images depend on the step.
        let depends_on_step = |image| matches!(image, ImageInput::Object(own) if own.depends_on_step());
        let by_step = self.program.images().any(depends_on_step);
        let same_reach = || {
            let [wanted, own] = [variant, &self.variant].map(|variant| {
                let all = [&variant.parameters].into_iter().chain(variant.parts.values());
                all.map(|parameters| (parameters.outer_iso(), parameters.spread(1.0, 1.0)))
            });
            wanted.eq(own)
        };
        let same_settings = !scene.changes(own).has_any(&[Changes::Field, Changes::Images]);
        let same_step = !by_step || scene.quality.samples == own.quality.samples;
        let same_tables = !self.bound.holds_parameters || scene.parameters == own.parameters;
        same_settings && same_step && same_tables && self.serves(variant) && same_reach()
    }

    /// Whether the program serves a variant. Every parameter folded to 0 here must be 0 there. More zeros are fine:
    /// relinking would stall a slider.
    pub(crate) fn serves(&self, variant: &Variant) -> bool {
        let [own, wanted] = [&self.variant, variant];
        own.entries == wanted.entries
            && modules(own).eq(modules(wanted))
            && zeros(own).iter().all(|zero| zeros(wanted).contains(zero))
    }
}

/// Slots of a variant with their modules.
fn modules(variant: &Variant) -> impl Iterator<Item = (&String, &Vec<String>)> {
    variant.slots.iter().filter(|(slot, _)| *slot != FOLDED)
}

/// Parameters of a variant that are folded to 0.
fn zeros(variant: &Variant) -> &[String] {
    variant.slots.get(FOLDED).map_or(&[], Vec::as_slice)
}
