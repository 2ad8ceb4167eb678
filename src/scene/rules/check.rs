//! Validation of scenes.

use super::header::{declaring, header};
use crate::scene::fields::schema::{Changes, setting};
use crate::scene::fields::setting::Node;
use crate::scene::{Object, Parameters, Pass, Scene, SceneError, Storage};
use crate::shader::declare::Outside;
use crate::shader::library::Library;
use crate::shader::slots::{FORMULA, NONE};
use crate::shader::{Declarations, Slots};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::Arc;

impl Scene {
    /// Checks all values, modules and parameters, and returns the values of the parameters.
    ///
    /// # Errors
    /// The first error, with field, value and allowed values.
    pub fn check(&self, library: &Library) -> Result<Parameters, SceneError> {
        Ok(self.checked_moment(library)?.1)
    }

    /// The scene at its time as by [`Scene::moment`], checked, with the values of its parameters.
    ///
    /// # Errors
    /// Those of [`Scene::check`].
    pub(crate) fn checked_moment(&self, library: &Library) -> Result<(Cow<'_, Scene>, Parameters), SceneError> {
        self.check_names()?;
        let moment = self.moment()?;
        let declared = Arc::new(moment.check_still(library)?);
        self.check_keys_of_parameters(&declared)?;
        let parameters = moment.parameters(&declared)?.in_loop(moment.looped(library));
        Ok((moment, parameters))
    }

    /// The scene at its time as by [`Scene::checked_moment`], if it differs in the view alone from a checked moment with these
    /// parameters.
    ///
    /// # Errors
    /// Those of [`Scene::check`].
    pub(crate) fn same_but_view(
        &self,
        checked: &Scene,
        parameters: &Parameters,
    ) -> Result<Option<Cow<'_, Scene>>, SceneError> {
        self.check_names()?;
        let moment = self.moment()?;
        if !moment.changes(checked).is_within(&[Changes::View, Changes::Size]) {
            return Ok(None);
        }
        moment.check_values()?;
        moment.check_camera()?;
        self.check_keys_of_parameters(parameters.declared())?;
        Ok(Some(moment))
    }

    /// Checks a scene without tracks, and returns the declarations of its modules.
    fn check_still(&self, library: &Library) -> Result<Declarations, SceneError> {
        self.check_values()?;
        self.check_object()?;
        self.check_transfer()?;
        self.check_half_angle()?;
        self.check_formula()?;
        self.check_groom()?;
        let slots = self.slots_with_objects(library);
        self.check_modules(library, &slots)?;
        self.check_look(library)?;
        self.check_quality(library)?;
        self.check_ray(library)?;
        self.check_layers(library)?;
        Ok(library.declarations(&self.entries(), &slots)?)
    }

    /// Checks the additional objects of an otherwise valid scene, and returns the values of their parameters.
    ///
    /// # Errors
    /// Those of [`Scene::check`], with the name of the object.
    pub fn check_parts(&self, library: &Library) -> Result<BTreeMap<String, Parameters>, SceneError> {
        let slots = self.slots_with_objects(library);
        let check = |name: &String| {
            let own = self.part_as_scene(name);
            own.check_values()?;
            own.check_object()?;
            own.check_look(library)?;
            own.check_transfer()?;
            own.check_layers(library)?;
            let declared = Arc::new(library.object_declarations(name, &slots)?);
            Ok(own.parameters(&declared)?.in_loop(self.looped(library)))
        };
        let within = |name: &String, error| SceneError::Part(name.clone(), Box::new(error));
        let checked =
            self.parts.keys().map(|name| Ok((name.clone(), check(name).map_err(|error| within(name, error))?)));
        checked.collect()
    }

    /// Modules with one of slot `object` for each object; any will do, as all declare the same.
    fn slots_with_objects(&self, library: &Library) -> Slots {
        let mut slots = self.slots(library);
        let own = self.parts.keys().map(|name| format!("{name}.object"));
        slots.extend(own.chain(["object".into()]).map(|slot| (slot, vec!["normals".into()])));
        slots
    }

    /// Removes the values of parameters that no module declares, after modules were exchanged.
    ///
    /// # Errors
    /// A module is unknown.
    pub fn drop_foreign_parameters(&mut self, library: &Library) -> Result<(), SceneError> {
        let slots = self.slots_with_objects(library);
        self.check_modules(library, &slots)?;
        let declared = library.declarations(&self.entries(), &slots)?.parameters;
        let is_declared = |name: &str| declared.iter().any(|parameter| parameter.name == name);
        self.parameters.retain(|name, _| is_declared(name));
        self.lengths.retain(|field, _| field.strip_prefix("parameters/").is_none_or(is_declared));
        self.animation.tracks.retain(|field, _| field.strip_prefix("parameters.").is_none_or(is_declared));
        Ok(())
    }

    /// Checks all values against their settings, except those of additional objects.
    fn check_values(&self) -> Result<(), SceneError> {
        if self.is_valid(None) {
            return Ok(());
        }
        let fields = self.fields();
        let own = fields.iter().filter(|(name, _)| !name.starts_with("parts.") || name.contains(".transform."));
        own.filter_map(|(name, value)| Some((name, value, setting(name)?)))
            .try_for_each(|(name, value, setting)| setting.check(name, value))
    }

    fn check_object(&self) -> Result<(), SceneError> {
        let Object { inner_iso, outer_iso, .. } = self.object;
        if inner_iso <= outer_iso {
            return Ok(());
        }
        let limit = format!("at most object.outer_iso = {outer_iso}; for a hard object use softness = \"hard\"");
        Err(SceneError::value("object.inner_iso", inner_iso, limit))
    }

    fn check_look(&self, library: &Library) -> Result<(), SceneError> {
        let (project, is_formula) = (self.effect.project.as_str(), self.object.is_formula());
        let volume = "needs a volume; object.field_encoding = \"normals16\" makes one of a formula";
        match (project, is_formula) {
            ("closest", true) => return Err(SceneError::value("effect.project", project, volume)),
            ("formula", false) => {
                let limit = "needs an object that is a formula: sphere, cube or torus, without object.field_encoding";
                return Err(SceneError::value("effect.project", project, limit));
            }
            _ => {}
        }
        if self.object.storage == Storage::Sparse {
            let sparse = |limit: String| Err(SceneError::value("object.storage", "\"sparse\"", limit));
            if is_formula {
                return sparse(volume.into());
            }
            let empty = |declared: &Declarations| declared.outside == Outside::Empty;
            if !empty(&header(library, "classify", &self.effect.classify)) {
                let empty = declaring(library, "classify", empty);
                return sparse(format!("needs effect.classify = {empty}: others color space beyond the soft region"));
            }
        }
        self.check_light()?;
        self.check_camera()
    }

    fn check_camera(&self) -> Result<(), SceneError> {
        let camera = &self.camera;
        if let Some(rotation) = camera.rotation {
            let length = rotation.iter().map(|value| value * value).sum::<f32>().sqrt();
            if !(0.999..=1.001).contains(&length) {
                let limit = "must be a unit quaternion x, y, z, w: its squares sum to 1";
                return Err(SceneError::value("camera.rotation", format!("{rotation:?}"), limit));
            }
        }
        self.lens()?;
        if camera.shutter > 0.0 && self.quality.supersampling < 2 {
            let limit = "needs quality.supersampling of 2 or more: one moment is not blurred";
            return Err(SceneError::value("camera.shutter", camera.shutter, limit));
        }
        if camera.slice_stack && self.quality.pass == Pass::March {
            let limit = "needs quality.pass = \"slices\": rays have no stack to look at";
            return Err(SceneError::value("camera.slice_stack", true, limit));
        }
        if let Some(plane) = camera.clip
            && plane[..3].iter().all(|&value| value.abs() < 1e-6)
        {
            let limit = "the first three numbers are the normal of the plane and must not all be 0";
            return Err(SceneError::value("camera.clip", format!("{plane:?}"), limit));
        }
        Ok(())
    }

    fn check_groom(&self) -> Result<(), SceneError> {
        let parts = self.parts.values().map(|part| part.effect.keep_base);
        let kept = parts.fold(self.effect.keep_base, f32::max);
        match &self.groom {
            Some(file) if self.has_several() => Err(SceneError::value("groom", file, "needs a scene of one object")),
            _ if self.has_several() && kept > 0.0 => {
                Err(SceneError::value("effect.keep_base", kept.to_string(), "needs a scene of one object"))
            }
            _ if self.has_several() && self.effect.wind != NONE => {
                Err(SceneError::value("effect.wind", &self.effect.wind, "needs a scene of one object"))
            }
            _ => Ok(()),
        }
    }

    fn check_transfer(&self) -> Result<(), SceneError> {
        let stops = &self.transfer.stops;
        if stops.is_empty() || stops.len() > 256 {
            return Err(SceneError::value("transfer.stops", format!("{} stops", stops.len()), "1 to 256"));
        }
        for stop in stops {
            within("transfer.stops.at", stop.at, 0.0, 1.0)?;
            within("transfer.stops.density", stop.density, 0.0, 1.0)?;
            within("transfer.stops.index", stop.index, 1.0, 4.0)?;
        }
        match stops.windows(2).find(|pair| pair[0].at > pair[1].at) {
            None => Ok(()),
            Some(pair) => {
                let limit = format!("at least that of the stop before it, {}", pair[0].at);
                Err(SceneError::value("transfer.stops.at", pair[1].at, limit))
            }
        }
    }

    /// Checks the kinds of the DMFs, and that there is one medium or one for each layer.
    fn check_layers(&self, library: &Library) -> Result<(), SceneError> {
        for dmf in &self.effect.dmf {
            library.kind(dmf.split('@').next().unwrap_or_default())?;
        }
        let (media, layers) = (self.effect.medium.split('+').count(), library.layers(&self.effect.dmf)?);
        if media == 1 || media == layers {
            return Ok(());
        }
        let limit =
            format!("one medium, or one for each of the {layers} DMFs in effect.dmf that have a width of their own");
        Err(SceneError::value("effect.medium", &self.effect.medium, limit))
    }

    fn check_modules(&self, library: &Library, slots: &Slots) -> Result<(), SceneError> {
        for (key, names) in slots.iter().filter(|(key, _)| *key != FORMULA) {
            let (object, slot) = key.split_once('.').unwrap_or(("", key));
            let field =
                if object.is_empty() { format!("effect.{slot}") } else { format!("parts.{object}.effect.{slot}") };
            let known = library.modules(slot);
            for name in names {
                let (module, mask) = name.split_once('@').map_or((name.as_str(), None), |(a, b)| (a, Some(b)));
                if !known.contains(&module) && module.ends_with(".glsl") {
                    let stem = module.rsplit('/').next().unwrap_or(module).trim_end_matches(".glsl");
                    let limit = format!(
                        "write the name of a module here, \"{stem}\", and its file under [modules]: \"{slot}/{stem}\" = \"{module}\""
                    );
                    return Err(SceneError::value(field, module, limit));
                }
                if !known.contains(&module) {
                    return Err(SceneError::unknown(&format!("module of {field}"), module, &known));
                }
                let masks = if slot == "dmf" { library.modules("mask") } else { Vec::new() };
                if let Some(mask) = mask.filter(|mask| !masks.contains(mask)) {
                    return Err(SceneError::unknown(&format!("mask in {field}"), mask, &masks));
                }
                library.header(slot, module)?;
            }
        }
        Ok(())
    }
}

/// Checks that a value is in a range; NaN never is.
pub(in crate::scene) fn within(field: &str, value: f32, low: f32, high: f32) -> Result<(), SceneError> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    Err(SceneError::value(field, value, format!("must be from {low} to {high}")))
}

#[cfg(test)]
pub(in crate::scene) mod tests {
    use super::*;
    use crate::scene::{Color, ParameterValue, Repeat, preset};
    use crate::shader;

    /// Error of the preset fur after a change.
    pub(in crate::scene) fn refusal(change: impl FnOnce(&mut Scene)) -> String {
        let mut scene = preset("fur").unwrap();
        change(&mut scene);
        scene.check(&shader::shipped()).unwrap_err().to_string()
    }

    #[test]
    fn values_out_of_range_are_refused_with_field_value_and_limit() {
        assert_eq!(refusal(|s| s.quality.samples = 0), "quality.samples = 0: must be from 1 to 100000");
        assert_eq!(refusal(|s| s.camera.zoom = f32::NAN), "camera.zoom = NaN: must be from 0.01 to 100");
        assert!(refusal(|s| s.object.inner_iso = 1.0).starts_with("object.inner_iso = 1: at most object.outer_iso"));
        assert!(refusal(|s| s.camera.rotation = Some([0.0, 0.0, 0.0, 1.1])).ends_with("its squares sum to 1"));
        assert!(refusal(|s| s.camera.rotation = Some([f32::NAN; 4])).starts_with("camera.rotation = NaN"));
        assert_eq!(refusal(|s| s.camera.pan[1] = 101.0), "camera.pan = 101: must be from -100 to 100");
        assert!(refusal(|s| s.camera.clip = Some([0.0, 0.0, 0.0, 1.0])).contains("normal of the plane"));
        assert!(refusal(|s| s.transfer.stops.clear()).starts_with("transfer.stops = 0 stops"));
        assert!(refusal(|s| s.quality.msaa = 3).ends_with("1, 2, 4 or 8"));
        let look = |s: &mut Scene| (s.camera.slice_stack, s.quality.pass) = (true, Pass::March);
        assert!(refusal(look).starts_with("camera.slice_stack = true: needs quality.pass"));
        assert_eq!(refusal(|s| s.effect.octaves = 11), "effect.octaves = 11: must be from 1 to 10");
        assert!(refusal(|s| s.quality.supersampling = 257).ends_with("must be from 1 to 256"));
        assert_eq!(refusal(|s| s.quality.block_size = 48), "quality.block_size = 48: must be 16, 32, 64, 128 or 256");
        let cells = |size, cells| refusal(move |s| (s.quality.block_size, s.quality.turbulence_cells) = (size, cells));
        let limit = |size: u32| format!("at most half of quality.block_size = {size}");
        assert_eq!(cells(64, 3), "quality.turbulence_cells = 3: must be 1, 2, 4, 8, 16, 32 or 64");
        assert_eq!(cells(16, 16), format!("quality.turbulence_cells = 16: {}", limit(16)));
        assert_eq!(cells(64, 64), format!("quality.turbulence_cells = 64: {}", limit(64)));
        let repeats = refusal(|s| s.effect.noise_repeat = Repeat::Never);
        assert!(repeats.starts_with("effect.noise_repeat = Never: must be \"own\" with block"), "{repeats}");
        let fine = |s: &mut Scene| s.light.shadow_resolution = 512;
        assert_eq!(refusal(fine), "light.shadow_resolution = 512: must be from 8 to 256");
        assert!(refusal(|s| s.image.size = [0, 5]).starts_with("image.size = 0"));
    }

    #[test]
    fn the_way_to_the_surface_must_suit_the_object() {
        let project = |input: &str, module: &str| {
            let (input, module) = (input.to_string(), module.to_string());
            move |s: &mut Scene| (s.object.input, s.effect.project) = (input, module)
        };
        assert!(refusal(project("torus", "closest")).starts_with("effect.project = closest: needs a volume"));
        assert!(refusal(project("teapot", "formula")).starts_with("effect.project = formula: needs an object"));
        assert!(refusal(project("teapot", "nearest")).contains("closest, formula, gradient"));
    }

    #[test]
    fn unknown_modules_and_parameters_suggest_the_nearest_name() {
        assert!(refusal(|s| s.effect.medium = "hairs".into()).contains("did you mean `hair`?"));
        let error = refusal(|s| {
            s.parameters.insert("finenes".into(), ParameterValue::Number(1.0));
        });
        assert!(error.starts_with("no parameter `finenes` (did you mean `fineness`?)"), "{error}");
    }

    #[test]
    fn a_parameter_has_the_type_and_range_that_its_module_declares() {
        let set = |value| {
            move |s: &mut Scene| {
                s.parameters.insert("fineness".into(), value);
            }
        };
        assert_eq!(
            refusal(set(ParameterValue::Number(1e9))),
            "parameters.fineness = 1000000000: must be from 2 to 200"
        );
        assert!(refusal(set(ParameterValue::Color(Color([1, 2, 3])))).contains("must be a number from 2 to 200"));
    }

    #[test]
    fn m47_the_length_of_the_hair_is_the_outer_iso_value() {
        let mut scene = preset("fur").unwrap();
        scene.parameters.insert("hair_length".into(), ParameterValue::Number(0.3));
        assert_eq!(scene.check(&shader::shipped()).unwrap().outer_iso(), Some(0.3));
    }
}
