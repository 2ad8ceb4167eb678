//! Variants: the program that a scene needs, and nothing else.
//!
//! Role: scene -> chosen modules -> SPIR-V with its live bindings. Invariant: [`Variant::of`] is pure, and what the
//! scene does not reach is neither in the program nor in its layout; [`Program::left_out`] says so.

mod linked;
mod program;
mod reflect;

pub use crate::scene::FORMULAS;
pub(crate) use program::parts;
pub use program::{Program, why_left_out};
pub use reflect::{Block, Member, ReflectError, Resource, Use};

use super::texture;
use crate::noise::Period;
use crate::scene::{
    Color, Integration, Neutral, ParameterValue, Parameters, SHADOW_SAMPLES, Scene, SceneError, Source,
};
use crate::shader::slots::{FOLDED, objects, qualified};
use crate::shader::{Library, LibraryError, LinkError, Linker, Parameter, Slots};
use std::collections::BTreeMap;
use std::iter;

include!(concat!(env!("OUT_DIR"), "/programs.rs"));

/// The entry files of the program that gives the shadow volume.
const SHADOW_ENTRIES: [&str; 2] = ["march.vert", "shadow.frag"];
/// The entry files of the program that hands the light from slice to slice.
const LIGHT_ENTRIES: [&str; 2] = ["light.vert", "light.frag"];
/// The entry files of the program that gives one sample.
const PROBE_ENTRIES: [&str; 2] = ["march.vert", "probe.frag"];
/// The entry files of the program that says where there is matter.
const CELL_ENTRIES: [&str; 2] = ["march.vert", "cell.frag"];
/// The entry files of the program that gives the depth of a picture.
const DEPTH_ENTRIES: [&str; 2] = ["march.vert", "depth.frag"];
/// What programs of shadows and depth have in place of the modules that color and light matter.
const SHADOW_SLOTS: [(&str, &str); 4] =
    [("surface", "unlit"), ("medium", "material"), ("shadow", "none"), ("gradient", "analytic")];

/// The modules of a scene's program.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    /// The files of the library that the program starts from: vertex stage, fragment stage.
    pub entries: [&'static str; 2],
    /// The slots that the program reaches, with the modules that fill them.
    pub slots: Slots,
    /// The parameters that those modules declare, with their values; without those of additional objects.
    pub parameters: Parameters,
    /// The parameters of each additional object, by its name.
    pub parts: BTreeMap<String, Parameters>,
    /// Octaves that its turbulence has.
    pub octaves: u32,
    /// After how many cells its procedural noise repeats, and the octaves of its procedural turbulence.
    pub periods: [Period; 2],
    /// Whether a sample asks for hard matter between it and the one before, a step nearer to the eye.
    pub looks_back: bool,
}

/// Why there is no program for a scene.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum VariantError {
    /// The scene is not valid.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// A module is missing.
    #[error(transparent)]
    Library(#[from] LibraryError),
    /// The program cannot be linked.
    #[error(transparent)]
    Link(#[from] LinkError),
    /// The linked program cannot be read back.
    #[error(transparent)]
    Reflect(#[from] ReflectError),
}

impl Variant {
    /// The modules that `scene` needs out of `library`.
    ///
    /// # Errors
    /// What [`Scene::check`] finds.
    pub fn of(scene: &Scene, library: &Library) -> Result<Variant, VariantError> {
        let parameters = scene.check(library)?;
        let entries = scene.entries();
        let mut choice = scene.slots(library);
        let parts = scene.check_parts(library)?;
        let slot = |name: &str| if name.is_empty() { "object".to_string() } else { format!("{name}.object") };
        let objects = || [""].into_iter().chain(scene.parts.keys().map(String::as_str));
        choice.extend(objects().map(|name| (slot(name), vec!["normals".into()])));
        for name in objects() {
            let needs_normal = match name {
                "" => library.declarations(&entries, &choice)?.needs_normal,
                _ => library.object_declarations(name, &choice)?.needs_normal,
            };
            let own = if name.is_empty() { scene.clone() } else { scene.alone(name) };
            // A boolean may turn the normal of any of its operands into that of the whole.
            choice.insert(slot(name), vec![object_module(&own, needs_normal || scene.has_several()).into()]);
        }
        if scene.quality.neutral == Neutral::LeaveOut {
            let mut all = zero(scene, "", &parameters);
            all.extend(parts.iter().flat_map(|(name, parameters)| zero(&scene.alone(name), name, parameters)));
            choice.insert(FOLDED.into(), all);
        }
        let (octaves, periods) = (scene.octaves_held(library), scene.periods(library));
        let (slots, looks_back) = (library.needed(&entries, &choice)?, scene.looks_back(library));
        Ok(Variant { entries, slots, parameters, parts, octaves, periods, looks_back })
    }

    /// Whether rays first find their matter, all of them together, and then shade it.
    pub(super) fn uses_two_phase(&self) -> bool {
        self.module("empty_space") == Some("skip")
    }

    /// The faster variant on a device. On GPUs soft matter is shaded directly: finding it first evaluates the density twice,
    /// and GPUs skip branches that no ray takes (H100: fire 3.1 ms instead of 4.4, flow 2.7 instead of 4.7). Hard matter is
    /// shaded once a ray and stays in two phases (lit 0.12 ms instead of 0.2).
    pub fn for_device(self, on_processor: bool) -> Variant {
        if self.is_hard() || on_processor { self } else { self.without_two_phase() }
    }

    /// Whether the matter of every object begins at a surface, at once.
    pub(super) fn is_hard(&self) -> bool {
        self.softness().all(|name| name == "hard")
    }

    /// Whether a warp moves what is looked up of any object.
    pub(super) fn has_warps(&self) -> bool {
        self.slots.iter().any(|(key, names)| slot_of(key) == "warp" && !names.is_empty())
    }

    fn softness(&self) -> impl Iterator<Item = &String> {
        self.slots.iter().filter(|(key, _)| slot_of(key) == "softness").flat_map(|(_, names)| names)
    }

    /// The variant whose rays shade matter as they find it.
    pub(super) fn without_two_phase(&self) -> Variant {
        let mut variant = self.clone();
        if self.uses_two_phase() {
            variant.slots.insert("empty_space".into(), vec!["leap".into()]);
        }
        variant
    }

    /// The modules that give the shadow volume of the same scene: those of its matter, without what colors it. Such a
    /// program reads no image that the picture's does not.
    ///
    /// # Errors
    /// A module is missing, which [`Variant::of`] excludes.
    pub fn shadow(&self, scene: &Scene, library: &Library) -> Result<Variant, VariantError> {
        self.of_light(scene, library, SHADOW_ENTRIES)
    }

    /// The modules that hand the light from slice to slice, where the slices lie half way between eye and light.
    ///
    /// # Errors
    /// As [`Variant::shadow`].
    pub fn light(&self, scene: &Scene, library: &Library) -> Result<Variant, VariantError> {
        self.of_light(scene, library, LIGHT_ENTRIES)
    }

    /// The modules that say whether there is matter at a place: as those of the shadow.
    ///
    /// # Errors
    /// As [`Variant::shadow`].
    pub fn cells(&self, scene: &Scene, library: &Library) -> Result<Variant, VariantError> {
        self.of_light(scene, library, CELL_ENTRIES)
    }

    /// The same with another module in the slot of opacity.
    ///
    /// # Errors
    /// As [`Variant::shadow`].
    pub(super) fn cells_by(&self, opacity: &str, scene: &Scene, library: &Library) -> Result<Variant, VariantError> {
        let mut variant = self.cells(scene, library)?;
        if let Some(names) = variant.slots.get_mut("opacity") {
            *names = vec![opacity.into()];
        }
        Ok(variant)
    }

    fn of_light(&self, scene: &Scene, library: &Library, entries: [&'static str; 2]) -> Result<Variant, VariantError> {
        let mut scene = scene.clone();
        scene.quality.integration = Integration::Point; // a segment of the light holds many samples
        scene.quality.samples = SHADOW_SAMPLES;
        self.of_matter(&scene, library, entries)
    }

    /// The modules that give the depth of a picture of a scene by rays, as those of the shadow: it takes the same samples.
    ///
    /// # Errors
    /// As [`Variant::shadow`].
    pub fn depth(&self, scene: &Scene, library: &Library) -> Result<Variant, VariantError> {
        self.of_matter(scene, library, DEPTH_ENTRIES)
    }

    fn of_matter(&self, scene: &Scene, library: &Library, entries: [&'static str; 2]) -> Result<Variant, VariantError> {
        let is_light = entries != DEPTH_ENTRIES;
        let mut choice = scene.slots(library);
        choice.extend(self.kept());
        let fades = self.slots.iter().any(|(key, names)| is_light && key.ends_with("bandlimit") && names != &["none"]);
        for (key, names) in &mut choice {
            let slot = slot_of(key);
            if slot == "medium" && library.has_extinction(names) {
                continue; // how opaque the matter is
            }
            if let Some((_, module)) = SHADOW_SLOTS.iter().find(|(other, _)| *other == slot) {
                *names = vec![module.to_string()];
            } else if slot == "cells" {
                // A shadow reads no image that the picture does not, and octaves that fade fade there with other steps.
                let own = self.slots.get("cells").filter(|_| !fades);
                *names = own.cloned().unwrap_or_else(|| vec!["none".into()]);
            } else if slot == "empty_space" && names == &["skip"] && !scene.may_find_first(library) {
                *names = vec!["leap".into()];
            } else if slot == "filter" && entries == CELL_ENTRIES {
                *names = vec!["device".into()]; // which is asked for bounds of its texels, not for a sample
            } else if is_light && slot == "storage" && names == &["anisotropic"] {
                *names = vec!["dense".into()]; // a sample of the light is wider than a pixel
            }
        }
        Ok(Variant { entries, slots: library.needed(&entries, &choice)?, ..self.clone() })
    }

    /// The modules that give one sample of a ray of the same scene, anywhere on it: what a picture is the integral of.
    ///
    /// # Errors
    /// A module is missing, which [`Variant::of`] excludes.
    pub fn probe(&self, scene: &Scene, library: &Library) -> Result<Variant, VariantError> {
        let mut choice = scene.slots(library);
        choice.extend(self.kept());
        Ok(Variant { entries: PROBE_ENTRIES, slots: library.needed(&PROBE_ENTRIES, &choice)?, ..self.clone() })
    }

    /// The modules of the same scene that give the entries of a table: `entry` is the fragment stage.
    ///
    /// # Errors
    /// A module is missing, which [`Variant::of`] excludes.
    pub fn table(&self, entry: &'static str, library: &Library) -> Result<Variant, VariantError> {
        let entries = ["march.vert", entry];
        Ok(Variant { entries, slots: library.needed(&entries, &self.slots)?, ..self.clone() })
    }

    /// What other programs of the same scene share: the modules that sample the objects, by slot, and what is 0.
    fn kept(&self) -> impl Iterator<Item = (String, Vec<String>)> {
        let is_kept = |key: &String| key == "object" || key.ends_with(".object") || key == FOLDED;
        let own = self.slots.iter().filter(move |(key, _)| is_kept(key));
        own.map(|(key, names)| (key.clone(), names.clone()))
    }

    /// The module that fills a slot; `None` where the program does not reach it or its stack is empty.
    pub fn module(&self, slot: &str) -> Option<&str> {
        self.slots.get(slot)?.first().map(String::as_str)
    }

    /// Whether the program of any object reaches a slot.
    pub fn reads(&self, slot: &str) -> bool {
        self.slots.keys().any(|key| slot_of(key) == slot)
    }

    /// Whether the file is among those that the program is linked from.
    pub fn reaches(&self, library: &Library, path: &str) -> bool {
        let own = library.files_reached(&self.entries, &self.slots);
        let of_parts = objects(&self.slots).into_iter().map(|object| library.object_files(object, &self.slots));
        iter::once(own).chain(of_parts).flatten().flatten().any(|file| file.split('#').next() == Some(path))
    }

    /// Whether the program reads the closest points of the object.
    pub fn reads_closest(&self) -> bool {
        self.module("project") == Some("closest")
    }

    /// Whether the program reads the closest points of an additional object.
    pub fn part_reads_closest(&self, name: &str) -> bool {
        self.module(&format!("{name}.project")) == Some("closest")
    }

    /// Every parameter of the scene with its value, under the name that `--set` knows it by: that of an additional object is
    /// `parts.OBJECT.PARAMETER`.
    pub fn all_parameters(&self) -> impl Iterator<Item = (String, &Parameter, &ParameterValue)> {
        let further = self.parts.iter().map(|(part, parameters)| (format!("parts.{part}."), parameters));
        let all = [(String::new(), &self.parameters)].into_iter().chain(further);
        all.flat_map(|(prefix, parameters)| {
            parameters.iter().map(move |(parameter, value)| (format!("{prefix}{}", parameter.name), parameter, value))
        })
    }

    /// The name of the program: its slots and modules.
    pub fn key(&self) -> String {
        self.slots.iter().map(|(slot, names)| format!("{slot}={}", names.join("+"))).collect::<Vec<_>>().join(" ")
    }

    /// The linked program: the one that ships, if `library` is the shipped one and has it, else one from the disk, else
    /// linked here. `linker` is called only for that.
    ///
    /// # Errors
    /// What glslang says about a module.
    pub fn program(
        &self,
        library: &Library,
        linker: impl FnOnce() -> Result<Linker, LinkError>,
    ) -> Result<Program, VariantError> {
        let key = self.key();
        let ships = SHIPPED_PROGRAMS.binary_search_by(|program| program.0.cmp(&key)).ok();
        let ships = ships.filter(|_| self.entries != DEPTH_ENTRIES); // a picture has the same modules
        let shipped = ships.filter(|_| *library == crate::shader::shipped()).and_then(|index| {
            let (_, vertex, fragment) = SHIPPED_PROGRAMS[index];
            Some([program::words(vertex).ok()?, program::words(fragment).ok()?])
        });
        let is_shipped = shipped.is_some();
        let [vertex, fragment] = match shipped {
            Some(stages) => stages,
            None => self.linked(library, true, linker)?,
        };
        Program::of(vertex, fragment, is_shipped)
    }

    /// The program with all that its text says, such as loops without an end, which an optimizer may take away.
    ///
    /// # Errors
    /// As [`Variant::program`].
    pub(super) fn unoptimized(&self, library: &Library) -> Result<Program, VariantError> {
        let [vertex, fragment] = self.linked(library, false, || Linker::new().map(Linker::unoptimized))?;
        Program::of(vertex, fragment, false)
    }
}

/// What is 0 of an object of a scene, of which `own` is the scene of that object alone.
fn zero(own: &Scene, object: &str, parameters: &Parameters) -> Vec<String> {
    let is_zero = |value: &ParameterValue| *value == ParameterValue::Number(0.0);
    let parameters = parameters.iter().filter(|(_, value)| is_zero(value)).map(|(own, _)| own.name.as_str());
    let (light, black) = (&own.light, |color: Color| color == Color([0; 3]));
    let members = [
        ("light_color", light.intensity == 0.0 || black(light.color)),
        ("ambient_color", black(light.ambient)),
        ("specular_strength", own.material.specular == 0.0),
        ("material_color", black(own.material.color)),
        ("transfer_color", own.transfer.is_flat() && texture::transfer_texel(&own.transfer) == [0.0; 4]),
    ];
    let members = members.into_iter().filter(|(_, is_zero)| *is_zero).map(|(name, _)| name);
    parameters.chain(members).map(|name| qualified(object, name)).collect()
}

fn object_module(scene: &Scene, needs_normal: bool) -> &str {
    match scene.object.source {
        Source::Normals16 | Source::Normals8 => "normals",
        Source::Distance16 | Source::Distance32 => "distance",
        Source::Auto => scene.object.formula().unwrap_or(if needs_normal { "normals" } else { "distance" }),
    }
}

/// The slot of a key, which an additional object's name may come before.
pub fn slot_of(key: &str) -> &str {
    key.rsplit('.').next().unwrap_or(key)
}

#[cfg(test)]
mod tests;
