//! A checked scene with the modules of its program.

use super::error::VariantError;
use super::program::{self, Program, shipped_programs};
use crate::noise::Period;
use crate::render::texture;
use crate::scene::{
    Color, FieldEncoding, Integration, ParameterValue, Parameters, Pass, SHADOW_SAMPLES, Scene, TargetFormat,
};
use crate::shader::slots::{FOLDED, objects, qualified};
use crate::shader::{Library, LinkError, Linker, Parameter, Slots, counting, linked_text};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::iter;
use std::sync::{Arc, Mutex};

/// Entries of rays: fragment shaders, and compute shaders that give the same bits.
const COMPUTE_ENTRIES: [(&str, &str); 4] = [
    ("march.frag", "march.frag#compute"),
    ("refract.frag", "refract.frag#compute"),
    ("depth.frag", "depth.frag#compute"),
    ("shadow.frag", "shadow.frag#compute"),
];
/// Entry files of the pictures whose operations are counted.
const COUNTED_ENTRIES: [&str; 3] = ["march.frag", "march.frag#compute", "slice.frag"];
/// Slot of the search for matter: `skip` finds it in a first phase.
const PHASES: &str = "empty_space";
/// Replacements, in programs of shadows and depth, of modules that color and light matter.
const SHADOW_SLOTS: [(&str, &str); 4] =
    [("surface", "unlit"), ("medium", "material"), ("shadow", "none"), ("gradient", "analytic")];

/// A checked scene with the modules of its program.
#[derive(Clone, Debug, PartialEq)]
pub struct Variant {
    /// The scene of the picture, also in variants for its shadows, light, depth and samples.
    pub scene: Scene,
    /// Entry files in the library: vertex stage, fragment stage.
    pub entries: [&'static str; 2],
    /// The slots that the program reaches, with their modules.
    pub slots: Arc<Slots>,
    /// Parameters of these modules with their values, except those of additional objects.
    pub parameters: Parameters,
    /// Parameters of each additional object, by its name.
    pub parts: BTreeMap<String, Parameters>,
    /// Effective octaves of the turbulence.
    pub octaves: u32,
    /// Period of the procedural noise in cells, and period of the procedural turbulence.
    pub periods: [Period; 2],
    /// Whether a sample searches for hard matter back to the previous sample.
    pub looks_back: bool,
}

/// A program of a scene besides that of its picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Purpose {
    /// The shadow volume: matter without color. It reads no image that the picture does not.
    Shadow,
    /// Half-angle light.
    Light,
    /// The emptiness of cells.
    Cells,
    /// The depth of a picture by rays, with the samples of the picture.
    Depth,
    /// A single sample anywhere on a ray: the integrand of a picture.
    Probe,
    /// Density and color at voxels.
    Voxels,
}

impl Purpose {
    fn entries(self) -> [&'static str; 2] {
        match self {
            Purpose::Shadow => ["march.vert", "shadow.frag"],
            Purpose::Light => ["light.vert", "light.frag"],
            Purpose::Cells => ["march.vert", "cell.frag"],
            Purpose::Depth => ["march.vert", "depth.frag"],
            Purpose::Probe => ["march.vert", "probe.frag"],
            Purpose::Voxels => ["voxels.vert", "voxels.frag"],
        }
    }
}

impl Variant {
    /// Checks a scene and selects the modules that it needs out of `library`.
    ///
    /// # Errors
    /// Those of [`Scene::check`].
    pub fn of(scene: &Scene, library: &Library) -> Result<Variant, VariantError> {
        if let Some((name, text)) = scene.lengths.first_key_value() {
            return Err(VariantError::Length(name.replace('/', "."), text.clone()));
        }
        let (scene, parameters) = scene.checked_moment(library)?;
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
            let own = if name.is_empty() { Cow::Borrowed(&*scene) } else { Cow::Owned(scene.part_as_scene(name)) };
            // A boolean may pass the normal of any operand on.
            choice.insert(slot(name), vec![object_module(&own, needs_normal || scene.has_several()).into()]);
        }
        if scene.quality.fold_zero_terms {
            let mut all = zero(&scene, "", &parameters);
            all.extend(parts.iter().flat_map(|(name, parameters)| zero(&scene.part_as_scene(name), name, parameters)));
            choice.insert(FOLDED.into(), all);
        }
        let (octaves, periods) = (scene.octaves_held(library), scene.periods(library));
        let (slots, looks_back) = (library.needed(&entries, &choice)?.into(), scene.looks_back(library));
        Ok(Variant { scene: scene.into_owned(), entries, slots, parameters, parts, octaves, periods, looks_back })
    }

    /// [`Variant::of`] another scene of the same library. One that differs from this in its view alone shares the modules and parameters; one
    /// without a difference is this.
    ///
    /// # Errors
    /// Those of [`Scene::check`].
    pub fn after(&self, scene: &Scene, library: &Library) -> Result<Cow<'_, Variant>, VariantError> {
        match scene.same_but_view(&self.scene, &self.parameters)? {
            None => Variant::of(scene, library).map(Cow::Owned),
            Some(moment) if moment.changes(&self.scene).is_empty() => Ok(Cow::Borrowed(self)),
            Some(moment) => {
                let Variant { entries, octaves, periods, looks_back, .. } = *self;
                let (slots, parameters, parts) = (self.slots.clone(), self.parameters.clone(), self.parts.clone());
                let scene = moment.into_owned();
                Ok(Cow::Owned(Variant { scene, entries, slots, parameters, parts, octaves, periods, looks_back }))
            }
        }
    }

    /// Whether rays find matter in a first phase and shade it in a second, which waits for the other rays of a group.
    pub(crate) fn uses_two_phase(&self) -> bool {
        self.module(PHASES) == Some("skip")
    }

    /// The fastest variant for a device. GPUs skip branches that no ray of a group takes, and shade soft matter
    /// directly: finding it first evaluates the density twice (H100: fire 3.1 ms instead of 4.4, flow 2.7 instead of
    /// 4.7). Hard matter is shaded once a ray and stays in two phases (lit 0.12 ms instead of 0.2).
    pub(crate) fn for_device(&self, on_processor: bool) -> Cow<'_, Variant> {
        let is_direct = self.uses_two_phase() && !on_processor && !self.is_hard();
        if is_direct { Cow::Owned(self.without_two_phase()) } else { Cow::Borrowed(self) }
    }

    /// Whether all objects have hard surfaces.
    pub(crate) fn is_hard(&self) -> bool {
        let mut softness = self.slots.iter().filter(|(key, _)| slot_of(key) == "softness");
        softness.all(|(_, names)| names.iter().all(|name| name == "hard"))
    }

    /// Whether a warp of any object moves lookups.
    pub(crate) fn has_warps(&self) -> bool {
        self.slots.iter().any(|(key, names)| slot_of(key) == "warp" && !names.is_empty())
    }

    /// The variant whose rays, of the eye or of the light, are traced by a compute shader.
    ///
    /// # Errors
    /// The reason why only a fragment shader traces them.
    pub(crate) fn in_compute(&self, library: &Library) -> Result<Variant, String> {
        let ([vertex, entry], quality) = (self.entries, &self.scene.quality);
        // Compute shaders are linked where they are used.
        let has_compiler = cfg!(feature = "glsl");
        let compute = COMPUTE_ENTRIES.iter().find(|(fragment, _)| *fragment == entry);
        let why = match compute {
            _ if !has_compiler => "this build links no programs (feature `glsl`)".into(),
            None => "slices are blended".into(),
            _ if quality.msaa > 1 => "quality.msaa shades samples of a pixel".into(),
            _ if quality.target != TargetFormat::Float32 => "it stores quality.target = float32".into(),
            Some((_, compute)) => {
                let own = Variant { entries: [vertex, compute], ..self.clone() };
                match own.refused(library) {
                    None => return Ok(own),
                    Some(why) => format!("it cannot be a compute shader: {why}"),
                }
            }
        };
        Err(why)
    }

    /// Why the program cannot be linked; shipped modules can. Asked once for each program.
    fn refused(&self, library: &Library) -> Option<String> {
        static KNOWN: Mutex<BTreeMap<[u8; 32], Option<String>>> = Mutex::new(BTreeMap::new());
        let is_own = crate::shader::changed(library).into_keys().any(|path| self.reaches(library, &path));
        let key = is_own.then(|| *self.text_hash(library).as_bytes())?;
        let known = || KNOWN.lock().unwrap_or_else(|poisoned| poisoned.into_inner());
        if let Some(known) = known().get(&key) {
            return known.clone();
        }
        let error = self.program(library, Linker::new).err().map(|error| error.to_string());
        let why = error.map(|text| text.lines().next().unwrap_or_default().to_string());
        known().insert(key, why.clone());
        why
    }

    /// Whether its rays are traced by a compute shader.
    pub(crate) fn is_compute(&self) -> bool {
        COMPUTE_ENTRIES.iter().any(|(_, compute)| self.entries[1] == *compute)
    }

    /// The variant that finds and shades matter in one phase.
    pub(crate) fn without_two_phase(&self) -> Variant {
        let mut variant = self.clone();
        if self.uses_two_phase() {
            Arc::make_mut(&mut variant.slots).insert(PHASES.into(), vec!["leap".into()]);
        }
        variant
    }

    /// The variant in as many phases as another variant of its scene.
    pub(crate) fn with_phases_of(mut self, other: &Variant) -> Variant {
        if let (Some(own), Some(module)) = (Arc::make_mut(&mut self.slots).get_mut(PHASES), other.slots.get(PHASES)) {
            own.clone_from(module);
        }
        self
    }

    /// Modules of another program of the scene.
    ///
    /// # Errors
    /// A module is missing, which [`Variant::of`] excludes.
    pub fn for_purpose(&self, purpose: Purpose, library: &Library) -> Result<Variant, VariantError> {
        let is_light = !matches!(purpose, Purpose::Depth | Purpose::Probe);
        let (mut scene, entries) = (self.scene.clone(), purpose.entries());
        if is_light {
            scene.quality.integration = Integration::Point; // a segment of the light holds many samples
            scene.quality.samples = SHADOW_SAMPLES;
        }
        let mut choice = scene.slots(library);
        // All programs of a scene share the modules that sample the objects, and the parameters of 0.
        let is_kept = |key: &str| slot_of(key) == "object" || key == FOLDED;
        choice.extend(self.slots.iter().filter(|(key, _)| is_kept(key)).map(|(key, own)| (key.clone(), own.clone())));
        let fades = self.slots.iter().any(|(key, names)| is_light && key.ends_with("bandlimit") && names != &["none"]);
        for (key, names) in choice.iter_mut().filter(|_| purpose != Purpose::Probe) {
            let slot = slot_of(key);
            if slot == "medium" && library.has_extinction(names) {
                continue; // it sets the opacity of matter
            }
            let has_color = purpose == Purpose::Voxels && slot != "shadow";
            if let Some((_, module)) = SHADOW_SLOTS.iter().find(|(other, _)| *other == slot && !has_color) {
                *names = vec![module.to_string()];
            } else if slot == "cells" {
                // A shadow reads no image that the picture does not, and its steps fade octaves differently.
                let own = self.slots.get("cells").filter(|_| !fades);
                *names = own.cloned().unwrap_or_else(|| vec!["none".into()]);
            } else if slot == PHASES && names == &["skip"] && !scene.may_find_first(library) {
                *names = vec!["leap".into()];
            } else if slot == "filter" && purpose == Purpose::Cells {
                *names = vec!["device".into()]; // bounds of texels, not samples
            } else if is_light && slot == "storage" && names == &["anisotropic"] {
                *names = vec!["dense".into()]; // a sample of the light is wider than a pixel
            }
        }
        let own = Variant { entries, slots: library.needed(&entries, &choice)?.into(), ..self.clone() };
        let compute = if self.is_compute() { own.in_compute(library).ok() } else { None };
        Ok(compute.unwrap_or(own))
    }

    /// Modules of a table; `entry` is the fragment stage.
    ///
    /// # Errors
    /// A module is missing, which [`Variant::of`] excludes.
    pub fn table(&self, entry: &'static str, library: &Library) -> Result<Variant, VariantError> {
        let entries = ["march.vert", entry];
        Ok(Variant { entries, slots: library.needed(&entries, &self.slots)?.into(), ..self.clone() })
    }

    /// The module in a slot; `None` if the program does not reach the slot or its stack is empty.
    pub fn module(&self, slot: &str) -> Option<&str> {
        self.slots.get(slot)?.first().map(String::as_str)
    }

    /// Whether the program of any object reaches a slot.
    pub fn reads(&self, slot: &str) -> bool {
        self.slots.keys().any(|key| slot_of(key) == slot)
    }

    /// Whether the program is linked from a file.
    pub fn reaches(&self, library: &Library, path: &str) -> bool {
        let own = library.files_reached(&self.entries, &self.slots);
        let of_parts = objects(&self.slots).into_iter().map(|object| library.object_files(object, &self.slots));
        iter::once(own).chain(of_parts).flatten().flatten().any(|file| file.split('#').next() == Some(path))
    }

    /// Whether the program reads the closest points of the main object.
    pub fn reads_closest(&self) -> bool {
        self.module("project") == Some("closest")
    }

    /// All parameters of the scene with their values, named as for `--set`: those of an additional object are
    /// `parts.OBJECT.PARAMETER`.
    pub fn all_parameters(&self) -> impl Iterator<Item = (String, &Parameter, &ParameterValue)> {
        let further = self.parts.iter().map(|(part, parameters)| (format!("parts.{part}."), parameters));
        let all = [(String::new(), &self.parameters)].into_iter().chain(further);
        all.flat_map(|(prefix, parameters)| {
            parameters.iter().map(move |(parameter, value)| (format!("{prefix}{}", parameter.name), parameter, value))
        })
    }

    /// Name of the program: its slots and modules.
    pub fn key(&self) -> String {
        self.slots.iter().map(|(slot, names)| format!("{slot}={}", names.join("+"))).collect::<Vec<_>>().join(" ")
    }

    /// The linked program: the shipped one if `library` is as shipped and has it, else from the disk cache, else linked
    /// here. `linker` is called only to link.
    ///
    /// # Errors
    /// The messages of glslang on a module.
    pub fn program(
        &self,
        library: &Library,
        linker: impl FnOnce() -> Result<Linker, LinkError>,
    ) -> Result<Program, VariantError> {
        if library.is_of_counts() && COUNTED_ENTRIES.contains(&self.entries[1]) {
            let [vertex, own] = self.linked(&library.noting_matter(), true, linker)?;
            return Program::of(vertex, counting(&own, self.scene.quality.pass == Pass::Slices), false);
        }
        let key = self.key();
        let ships = shipped_programs().binary_search_by(|program| program.0.cmp(&key)).ok();
        // These share their modules with a picture.
        let ships = ships.filter(|_| self.entries != Purpose::Depth.entries() && !self.is_compute());
        let shipped = ships.filter(|_| *library == crate::shader::shipped()).and_then(|index| {
            let (_, vertex, fragment) = shipped_programs()[index];
            Some([program::words(vertex).ok()?, program::words(fragment).ok()?])
        });
        let is_shipped = shipped.is_some();
        let [vertex, fragment] = match shipped {
            Some(stages) => stages,
            None => self.linked(library, true, linker)?,
        };
        Program::of(vertex, fragment, is_shipped)
    }

    /// The variant whose rays know no empty cells.
    pub(crate) fn without_cells(mut self) -> Variant {
        if let Some(names) = Arc::make_mut(&mut self.slots).get_mut("cells") {
            *names = vec!["none".into()];
        }
        self
    }

    /// The linked GLSL of the fragment stage.
    ///
    /// # Errors
    /// A module is missing, which [`Variant::of`] excludes.
    pub fn text(&self, library: &Library) -> Result<String, VariantError> {
        Ok(linked_text(library, self.entries[1], &self.entries, &self.slots)?)
    }

    /// The unoptimized program, in which endless loops remain.
    ///
    /// # Errors
    /// As [`Variant::program`].
    pub(crate) fn unoptimized(&self, library: &Library) -> Result<Program, VariantError> {
        let [vertex, fragment] = self.linked(library, false, || Linker::new().map(Linker::unoptimized))?;
        Program::of(vertex, fragment, false)
    }
}

/// Names of zero parameters and members of an object; `own` is the scene reduced to this object.
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
    match scene.object.field_encoding {
        FieldEncoding::Normals16 | FieldEncoding::Normals8 => "normals",
        FieldEncoding::Distance16 | FieldEncoding::Distance32 => "distance",
        FieldEncoding::Auto => scene.object.formula().unwrap_or(if needs_normal { "normals" } else { "distance" }),
    }
}

/// Slot of a key, without the prefix of an additional object.
pub fn slot_of(key: &str) -> &str {
    key.rsplit('.').next().unwrap_or(key)
}
