//! Additional objects of a scene, each with its own effect, and their combination.

use super::fields::schema::{self, ChangeSet, Changes, Filled, Setting};
use super::fields::setting::{Moment, Node, push_name, settings};
use super::{Effect, Integration, Material, Object, ParameterValue, Scene, SceneError, Storage, Transfer};
use crate::shader::slots::{FORMULA, MAIN};
use crate::shader::{Formula, FormulaError, Library, Slots};
use glam::{EulerRot, Mat4, Quat, Vec3};
use std::collections::BTreeMap;
use toml::Value;

/// Most additional objects. Higher: some devices cannot bind enough images.
const MAX_PARTS: usize = 4;

settings! {
    /// An additional object of a scene.
    pub struct Part: PartField = "" {
        /// Preset for effect, parameters, material and transfer map; the fields of the part override it.
        #[serde(skip_serializing_if = "Option::is_none")]
        preset: Option<String> = None;
        /// The object.
        object: Object = Object::default();
        /// The modules of its effect. Noise, turbulence and opacity are those of the scene.
        effect: Effect = Effect::default();
        /// Parameters of those modules, by name.
        parameters: BTreeMap<String, ParameterValue> = BTreeMap::new();
        /// Reflection of its hard surface.
        material: Material = Material::default();
        /// Color and opacity by density.
        transfer: Transfer = Transfer::default();
        /// Its placement.
        transform: Transform = Transform::default();
        /// Whether an additional object is left out of the picture and of its program.
        #[serde(skip_serializing_if = "std::ops::Not::not")]
        hidden: bool = false => Images, Kind::Switch;
    }
}

/// The additional objects, by name.
impl Node for BTreeMap<String, Part> {
    type Id = (String, PartField);

    fn find(name: &str) -> Option<(String, PartField)> {
        let (part, below) = name.split_once('.')?;
        Some((part.into(), Part::find(below)?))
    }

    fn write_name((part, below): &(String, PartField), name: &mut String) {
        push_name(name, part);
        Part::write_name(below, name);
    }

    fn setting((_, below): &(String, PartField)) -> Option<&'static Setting> {
        Part::setting(below)
    }

    fn each(&self, on: &mut dyn FnMut((String, PartField))) {
        for (name, part) in self {
            part.each(&mut |below| {
                // A file says it of hidden objects alone.
                if part.hidden || below != PartField::hidden(()) {
                    on((name.clone(), below));
                }
            });
        }
    }

    fn get(&self, (part, below): &(String, PartField)) -> Option<Value> {
        Node::get(BTreeMap::get(self, part)?, below)
    }

    fn set(
        &mut self,
        (name, below): &(String, PartField),
        value: Option<&Value>,
        _: fn() -> Self,
    ) -> Result<(), toml::de::Error> {
        let mut part = BTreeMap::get(self, name).cloned().unwrap_or_default();
        part.set(below, value, Part::default)?;
        self.insert(name.clone(), part);
        Ok(())
    }

    fn animate(&mut self, (name, below): &(String, PartField), moment: Moment<'_>, _: Option<&Setting>) -> bool {
        self.get_mut(name).is_some_and(|part| part.animate(below, moment, None))
    }

    fn changes(&self, other: &Self, _: Option<&Setting>) -> ChangeSet {
        if !self.keys().eq(other.keys()) {
            return ChangeSet::of(&[Changes::Field, Changes::Images, Changes::Picture]);
        }
        let pairs = self.values().zip(other.values());
        pairs.fold(ChangeSet::default(), |all, (own, other)| all.with(own.changes(other, None)))
    }

    fn is_valid(&self, _: Option<&Setting>) -> bool {
        self.values().all(|part| part.transform.is_valid(None)) // `Scene::check_parts` checks the rest
    }
}

settings! {
    /// Placement of an additional object: scale, then rotations about x, y and z, then translation.
    #[derive(Copy)]
    pub struct Transform: TransformField = "transform." {
        /// Position of the center of an additional object in object space of the scene.
        at: [f32; 3] = [0.0; 3] => Images, numbers(3, -100.0, 100.0), usual(-2.0, 2.0);
        /// Degrees about x, y and z.
        turn: [f32; 3] = [0.0; 3] => Images, numbers(3, -1e6, 1e6), usual(-180.0, 180.0), unit(Unit::Degrees);
        /// Size relative to the object of the scene.
        scale: f32 = 1.0 => Images, number(0.01, 100.0), usual(0.01, 4.0);
        /// Whether it keeps its place relative to the object of the scene in their common file, such as bone in skin, in place of the middle.
        aligned: bool = false => Field, Kind::Switch;
    }
}

impl Transform {
    /// Matrix from the space of the object to object space of the scene.
    pub fn matrix(&self) -> Mat4 {
        let [x, y, z] = self.turn.map(f32::to_radians);
        let turn = Quat::from_euler(EulerRot::ZYX, z, y, x);
        Mat4::from_scale_rotation_translation(Vec3::splat(self.scale), turn, Vec3::from(self.at))
    }
}

impl Scene {
    /// Replaces the object of the scene and those that are aligned with it in the same file. Iso-values and grids of another
    /// file are dropped.
    pub fn replace_object(&mut self, input: &str) {
        let before = std::mem::replace(&mut self.object.input, input.into());
        let aligned = self.parts.values_mut().filter(|part| part.transform.aligned && part.object.input == before);
        for object in aligned.map(|part| &mut part.object).chain([&mut self.object]) {
            object.input = input.into();
            if before != input {
                (object.iso, object.grid) = (None, None);
            }
        }
    }

    /// Sets the iso-value of the object of the scene and, after commas, those of the aligned ones in the order of their names.
    ///
    /// # Errors
    /// A value is not a number, or there are more values than objects.
    pub fn set_isos(&mut self, values: &str) -> Result<(), SceneError> {
        let aligned = self.parts.iter().filter(|(_, part)| part.transform.aligned);
        let aligned: Vec<String> = aligned.map(|(name, _)| format!("parts.{name}.object.iso")).collect();
        let mut names = std::iter::once("object.iso").chain(aligned.iter().map(String::as_str));
        for value in values.split(',') {
            let limit = || match aligned.len() {
                0 => {
                    "one number; a scene with an object in another, such as --effect anatomy, takes one for each".into()
                }
                more => format!("at most {} numbers, one for each object", more + 1),
            };
            let (field, value) = ("object.iso", value.trim().trim_start_matches("none"));
            self.set_field(names.next().ok_or_else(|| SceneError::value(field, values, limit()))?, value)?;
        }
        Ok(())
    }
}

impl Scene {
    /// Whether the scene has additional objects.
    pub fn has_several(&self) -> bool {
        !self.parts.is_empty()
    }

    /// The scene with an additional object as its only object.
    ///
    /// # Panics
    /// If the object is missing.
    pub fn part_as_scene(&self, name: &str) -> Scene {
        let Part { object, effect, parameters, material, transfer, .. } = self.parts[name].clone();
        let (parts, combine) = (BTreeMap::new(), None);
        Scene { object, effect, parameters, material, transfer, parts, combine, ..self.clone() }
    }

    /// The stacks of DMFs of all objects.
    pub fn dmfs(&self) -> impl Iterator<Item = &Vec<String>> {
        [&self.effect].into_iter().chain(self.parts.values().map(|part| &part.effect)).map(|effect| &effect.dmf)
    }

    /// Text of the formula that combines the objects.
    fn formula_text(&self) -> String {
        let union = || [MAIN].into_iter().chain(self.parts.keys().map(String::as_str)).collect::<Vec<_>>().join(" | ");
        self.combine.clone().unwrap_or_else(union)
    }

    /// The formula that combines the objects.
    ///
    /// # Errors
    /// The formula is malformed, as [`Scene::check`] reports.
    pub fn formula(&self) -> Result<Formula, FormulaError> {
        Formula::parse(&self.formula_text())
    }

    /// The scene without its hidden objects, and without those that change nothing then.
    ///
    /// # Errors
    /// The formula is malformed, or has no object of the scene without the hidden ones.
    pub(super) fn without_hidden(mut self) -> Result<Scene, SceneError> {
        let formula = self.formula().map_err(|error| SceneError::Formula(error.to_string()))?;
        let is_hidden = |name: &str| self.parts.get(name).is_some_and(|part| part.hidden);
        let left = formula.without(&is_hidden).ok().filter(|left| left.objects().contains_key(MAIN));
        let Some(left) = left else {
            let hidden = self.parts.keys().filter(|name| is_hidden(name)).cloned().collect::<Vec<_>>().join(", ");
            let limit = format!("must keep `{MAIN}` without hidden objects; show {hidden}, or change the formula");
            return Err(SceneError::value("combine", self.formula_text(), limit));
        };
        let (before, after) = (formula.objects(), left.objects());
        self.parts.retain(|name, part| {
            !part.hidden && (after.contains_key(name.as_str()) || !before.contains_key(name.as_str()))
        });
        self.combine = self.combine.filter(|_| !self.parts.is_empty()).map(|_| left.to_string());
        Ok(self)
    }

    /// Checks the names of the additional objects.
    pub(super) fn check_names(&self) -> Result<(), SceneError> {
        let letters = |name: &str| name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit());
        let good = |name: &str| {
            letters(name) && name.starts_with(|c: char| c.is_ascii_lowercase()) && name != MAIN && name.len() <= 32
        };
        match self.parts.keys().find(|name| !good(name)) {
            None => Ok(()),
            Some(name) => {
                let limit = format!("must be lower-case letters and digits, at most 32, and not `{MAIN}`");
                Err(SceneError::value("name in parts", name, limit))
            }
        }
    }

    /// Adds the modules of the additional objects and of the formula.
    pub(super) fn fill_parts(&self, library: &Library, slots: &mut Slots) {
        slots.insert("classify".into(), vec!["objects".into()]);
        slots.insert("boolean".into(), vec![self.boolean.name().into()]);
        slots.insert(FORMULA.into(), vec![self.formula_text()]);
        for name in self.parts.keys() {
            let own = self.part_as_scene(name).slots(library);
            let own = own.into_iter().filter(|(slot, _)| {
                slot != "classify" && (slot == "transfer" || schema::slots().any(|own| own == (slot, Filled::ByObject)))
            });
            slots.extend(own.map(|(slot, modules)| (format!("{name}.{slot}"), modules)));
        }
    }

    /// Checks the objects together; [`Scene::check_parts`] checks each of them.
    pub(super) fn check_formula(&self) -> Result<(), SceneError> {
        let wrong = |field: String, value: &str, limit: String| Err(SceneError::value(field, value, limit));
        if !self.has_several() {
            return match &self.combine {
                Some(text) if text.trim() != MAIN => {
                    wrong("combine".into(), text, "the scene has no [parts.NAME] to combine".into())
                }
                _ => Ok(()),
            };
        }
        if self.quality.integration != Integration::Point {
            return wrong("quality.integration".into(), "segment", "point, in a scene of several objects".into());
        }
        let objects = self.parts.values().map(|part| &part.object).chain([&self.object]);
        if objects.into_iter().any(|object| object.storage == Storage::Sparse) {
            return wrong("object.storage".into(), "\"sparse\"", "dense, in a scene of several objects".into());
        }
        if self.parts.len() > MAX_PARTS {
            return wrong(
                "parts".into(),
                &self.parts.len().to_string(),
                format!("at most {MAX_PARTS} additional objects"),
            );
        }
        for (name, part) in &self.parts {
            if part.object.stretch != [1.0; 3] {
                let value = format!("{:?}", part.object.stretch);
                return wrong(
                    format!("parts.{name}.object.stretch"),
                    &value,
                    "1, 1, 1: only the scene is stretched".into(),
                );
            }
        }
        for (name, effect) in
            self.parts.iter().map(|(name, part)| (name.as_str(), &part.effect)).chain([(MAIN, &self.effect)])
        {
            if !["surface", "soft"].contains(&effect.classify.as_str()) {
                let limit = "surface or soft, in a scene of several objects".to_string();
                return wrong(format!("effect.classify of {name}"), &effect.classify, limit);
            }
            if effect.gradient != "analytic" {
                let limit = "analytic: the normal of several objects is that of their formula".to_string();
                return wrong(format!("effect.gradient of {name}"), &effect.gradient, limit);
            }
            let shared = effect.modules().into_iter().zip(self.effect.modules());
            let shared = shared.filter(|((slot, _), _)| schema::is_shared(slot));
            if let Some(((slot, own), (_, scene))) = shared.into_iter().find(|((_, own), (_, scene))| own != scene) {
                let limit = format!(
                    "{scene}, as effect.{slot} of the scene: all objects share it; set each, as by --set effect.{slot}={scene} --set \
                     parts.{name}.effect.{slot}={scene}"
                );
                return wrong(format!("parts.{name}.effect.{slot}"), own, limit);
            }
        }
        let text = self.formula_text();
        let formula = self.formula().map_err(|error| SceneError::Formula(error.to_string()))?;
        let used = formula.objects();
        let known: Vec<&str> = [MAIN].into_iter().chain(self.parts.keys().map(String::as_str)).collect();
        if let Some(name) = used.keys().find(|name| !known.contains(name)) {
            return Err(SceneError::unknown("object in combine", name, &known));
        }
        if let Some(name) = known.iter().find(|name| !used.contains_key(*name)) {
            return wrong("combine".into(), &text, format!("must use every object, and `{name}` is missing"));
        }
        if used.values().all(|adds| !adds) {
            return wrong("combine".into(), &text, "must have an object that is not only taken away".into());
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::parse;
    use crate::shader;

    fn refusal(text: &str) -> String {
        let scene = parse(text, "x").unwrap();
        let library = shader::shipped();
        let checked = scene.check(&library).and_then(|_| scene.check_parts(&library));
        checked.unwrap_err().to_string()
    }

    #[test]
    fn errors_of_further_objects_name_field_and_limit() {
        for (text, expected) in [
            ("combine = 'main | b'", "combine = main | b: the scene has no [parts.NAME]"),
            ("combine = 'main'\n[parts.b]", "must use every object, and `b` is missing"),
            ("combine = 'main | c'\n[parts.b]", "no object in combine `c`"),
            ("combine = '!main - b'\n[parts.b]", "not only taken away"),
            ("combine = 'main |'\n[parts.b]", "combine = `main |`: a name is missing at character 7"),
            ("[parts.B]", "name in parts = B: must be lower-case"),
            ("[parts.main]", "and not `main`"),
            ("[parts.B]\nhidden = true", "name in parts = B: must be lower-case"),
            (
                "combine = 'main & b'\n[parts.b]\nhidden = true",
                "combine = main & b: must keep `main` without hidden objects; show b, or change the formula",
            ),
            ("combine = 'main & b | c'\n[parts.b]\nhidden = true\n[parts.c]", "show b, or change"),
            ("combine = 'main | b'\n[parts.b]\nhidden = true\n[parts.c]", "must use every object, and `c` is missing"),
            ("[parts.b.transform]\nscale = 0", "parts.b.transform.scale = 0: must be from 0.01 to 100"),
            ("[parts.b.object]\nstretch = [1, 2, 1]", "parts.b.object.stretch"),
            ("[parts.b.effect]\nclassify = 'post'", "effect.classify of b = post: surface or soft"),
            (
                "[parts.b.effect]\nnoise = 'procedural'",
                "parts.b.effect.noise = procedural: block, as effect.noise of the scene",
            ),
            ("[parts.b.effect]\ndmf = ['furr']", "no module of parts.b.effect.dmf `furr` (did you mean `fur`?)"),
            ("[parts.b.effect]\ndmf = ['fur@bend']", "no mask in parts.b.effect.dmf `bend` (did you mean `band`?)"),
            (
                "[parts.b]\npreset = 'fur'\nparameters = { finenes = 3 }",
                "in parts.b: no parameter `finenes` (did you mean `fineness`?)",
            ),
            (
                "[parts.b]\npreset = 'fur'\nparameters = { fineness = 3e9 }",
                "in parts.b: parameters.fineness = 3000000000: must be from",
            ),
            ("[parts.a]\n[parts.b]\n[parts.c]\n[parts.d]\n[parts.e]", "parts = 5: at most 4"),
        ] {
            let error = refusal(text);
            assert!(error.contains(expected), "{text}: {error}");
        }
    }

    #[test]
    fn a_scene_with_hidden_objects_is_the_scene_without_them() {
        for (combine, hidden, expected) in [
            ("main - b | c", "b", "combine = 'main | c'\n[parts.c]"),
            ("main & !(b | c)", "c", "combine = 'main - b'\n[parts.b]"),
            ("main | b & c", "b", ""),
            ("main | b", "b", ""),
        ] {
            let parts = |name: &str| {
                if combine.contains(name) {
                    format!("[parts.{name}]\nhidden = {}\n", name == hidden)
                } else {
                    String::new()
                }
            };
            let scene = parse(&format!("combine = '{combine}'\n{}{}", parts("b"), parts("c")), "x").unwrap();
            assert_eq!(*scene.moment().unwrap(), parse(expected, "x").unwrap(), "{combine} without {hidden}");
            assert_eq!(parse(&crate::scene::to_text(&scene), "y").unwrap(), scene);
        }
        let shown = parse("[parts.b]\nhidden = false", "x").unwrap();
        assert!(
            !crate::scene::to_text(&shown).contains("hidden"),
            "a scene without hidden objects has the text of before"
        );
    }

    #[test]
    fn a_scene_of_several_objects_reads_back_as_itself() {
        let text = "preset = 'fur'\ncombine = 'main - hole'\nboolean = 'minmax'\n[parts.hole]\npreset = 'fire'\ntransform = { at = [1, 0, 0.5] }";
        let scene = parse(text, "x").unwrap();
        assert_eq!(scene.parts["hole"].effect.medium, "flame");
        assert_eq!(parse(&crate::scene::to_text(&scene), "y").unwrap(), scene);
    }
}
