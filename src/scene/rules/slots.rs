//! The program of a scene: its entry files, and the modules of its slots.

use super::header::header;
use crate::scene::{Curve, EmptySpace, Integration, LightMethod, Pass, RayPath, Scene, Storage, TargetFormat};
use crate::shader::file::{Include, include};
use crate::shader::slots::{AMOUNT, GROOM, NONE, WIND};
use crate::shader::{Library, Slots, tokens};
use std::collections::BTreeSet;

/// Whether a medium may read the normal that soft matter is lit by.
fn is_lit(library: &Library, slots: &Slots) -> bool {
    let media = slots.get("medium").map(|names| library.files("medium", names)).transpose();
    let Ok(Some(mut left)) = media else { return true };
    let mut seen = BTreeSet::new();
    while let Some(path) = left.pop() {
        let path = path.split('#').next().unwrap_or_default().to_string();
        if !seen.insert(path.clone()) {
            continue;
        }
        let text = library.text(&path);
        if tokens(&text).any(|word| word == "shading") {
            return true;
        }
        left.extend(text.lines().filter_map(|line| match include(line) {
            Some(Include::File(file)) => Some(file.to_string()),
            _ => None,
        }));
    }
    false
}

impl Scene {
    /// Entry files of the program in the folder `glsl`: vertex stage, fragment stage.
    pub fn entries(&self) -> [&'static str; 2] {
        match (self.quality.pass, self.effect.ray_path) {
            (Pass::Slices, _) => ["slice.vert", "slice.frag"],
            (Pass::March, RayPath::Straight) => ["march.vert", "march.frag"],
            (Pass::March, RayPath::Refracted) => ["march.vert", "refract.frag"],
        }
    }

    /// Modules for all slots but `object`, which depends on the input. Settings with a slot of their name have the names of
    /// its modules as values.
    pub fn slots(&self, library: &Library) -> Slots {
        let Scene { effect, quality, light, camera, .. } = self;
        let half_angle = self.is_half_angle();
        let storage = match self.object.storage {
            Storage::Dense if quality.anisotropy > 1.0 => "anisotropic",
            storage => storage.name(),
        };
        let empty_space = match quality.empty_space {
            EmptySpace::Skip if !self.is_empty_outside(library) || effect.index != "transfer" => "sample",
            // An unorm target cannot report that a device has cut the loops of a ray.
            EmptySpace::Skip if quality.target == TargetFormat::Unorm8 && !self.may_find_first(library) => "leap",
            empty_space => empty_space.name(),
        };
        let has_cells = empty_space != "sample" && self.is_plain() && self.has_cells(library);
        let jumps = effect.index == "transfer" && self.transfer.curve == Curve::Steps;
        let is_flat = quality.fold_zero_terms && self.transfer.is_flat();
        let classify = match quality.integration {
            Integration::Segment => header(library, "classify", &effect.classify).segments,
            Integration::Point => None,
        };
        let chosen = [
            ("projection", self.projection().name()),
            ("proxy", quality.proxy.name()),
            ("reject", if quality.discard_empty_fragments { "discard" } else { "keep" }),
            ("shadow", if light.shadows { light.method.name() } else { "none" }),
            ("planes", if half_angle { LightMethod::HalfAngle.name() } else { "facing" }),
            ("scatter", if light.translucency > 0.0 { "cone" } else { "none" }),
            ("clip", if camera.clip.is_some() { "plane" } else { "none" }),
            ("empty_space", empty_space),
            ("cells", if has_cells { "grid" } else { "none" }),
            ("jitter", quality.jitter.name()),
            ("ray_path", if jumps { "straight" } else { "curved" }),
            ("wrap", quality.wrap.name()),
            ("filter", quality.filter.name()),
            ("storage", storage),
            ("phases", if self.looped(library).is_some_and(|own| own.two_phases) { "two" } else { "one" }),
            ("transfer", if is_flat { "flat" } else { "map" }),
            (
                "sampling",
                if camera.slice_stack {
                    "stack"
                } else if quality.msaa == 1 {
                    "pixel"
                } else {
                    "sample"
                },
            ),
            ("classify", classify.as_ref().unwrap_or(&effect.classify)),
            (
                "project",
                match effect.project.as_str() {
                    "auto" if self.object.is_formula() => "formula",
                    "auto" => "closest",
                    module => module,
                },
            ),
        ];
        let of_effect = effect.modules().into_iter().map(|(slot, module)| (slot, module.as_str()));
        let mut slots: Slots =
            of_effect.chain(chosen).map(|(slot, module)| (slot.to_string(), vec![module.to_string()])).collect();
        slots.insert("medium".into(), effect.medium.split('+').map(|name| name.trim().to_string()).collect());
        slots.insert("warp".into(), effect.warp.clone());
        slots.insert("dmf".into(), effect.dmf.clone());
        if effect.wind == NONE {
            slots.remove(WIND);
        }
        // Both make nothing but that normal; `central` moves samples for its sake.
        if ["central", "three"].contains(&effect.gradient.as_str()) && !is_lit(library, &slots) {
            slots.insert("gradient".into(), vec!["analytic".into()]);
        }
        if self.groom.is_some() {
            slots.insert(GROOM.into(), vec!["volume".into()]);
        }
        let amount = match (self.groom.is_some(), effect.keep_base > 0.0) {
            (true, false) => Some("painted"),
            (false, true) => Some("base"),
            (true, true) => Some("both"),
            (false, false) => None,
        };
        if let Some(module) = amount.filter(|_| !(effect.warp.is_empty() && effect.dmf.is_empty())) {
            slots.insert(AMOUNT.into(), vec![module.into()]);
        }
        if self.has_several() {
            self.fill_parts(library, &mut slots);
        }
        slots
    }
}
