//! The checks that make a scene valid.

use super::header::{declaring, header};
use super::loops::{BENDING_LOOPS, BENDING_STEPS, LOOP_BUDGET, SHADOW_SAMPLES};
use super::schema::setting;
use super::{Integration, Jitter, Parameters, RayPath, Repeat, Scene, SceneError, Storage};
use crate::shader::declare::Outside;
use crate::shader::library::Library;
use crate::shader::slots::FORMULA;
use crate::shader::{Declarations, Slots};
use std::collections::BTreeMap;

impl Scene {
    /// Checks every value, module and parameter, and gives the parameters their values.
    ///
    /// # Errors
    /// The first thing that is wrong: the field, its value, and what is allowed.
    pub fn check(&self, library: &Library) -> Result<Parameters, SceneError> {
        self.check_values()?;
        self.check_object()?;
        self.check_transfer()?;
        self.check_half_angle()?;
        self.check_formula()?;
        let slots = self.slots_with_objects(library);
        self.check_modules(library, &slots)?;
        self.check_look(library)?;
        self.check_quality(library)?;
        self.check_ray(library)?;
        self.check_layers(library)?;
        self.parameters(&library.declarations(&self.entries(), &slots)?)
    }

    /// Checks the additional objects of a scene that is valid but for them, and gives their parameters their values.
    ///
    /// # Errors
    /// As [`Scene::check`], with the object named.
    pub fn check_parts(&self, library: &Library) -> Result<BTreeMap<String, Parameters>, SceneError> {
        let slots = self.slots_with_objects(library);
        let check = |name: &String| {
            let own = self.alone(name);
            own.check_values()?;
            own.check_object()?;
            own.check_look(library)?;
            own.check_transfer()?;
            own.check_layers(library)?;
            own.parameters(&library.object_declarations(name, &slots)?)
        };
        let within = |name: &String, error| SceneError::Part(name.clone(), Box::new(error));
        let checked =
            self.parts.keys().map(|name| Ok((name.clone(), check(name).map_err(|error| within(name, error))?)));
        checked.collect()
    }

    /// The modules of the scene with one for each object: any, since all declare the same.
    fn slots_with_objects(&self, library: &Library) -> Slots {
        let mut slots = self.slots(library);
        let own = self.parts.keys().map(|name| format!("{name}.object"));
        slots.extend(own.chain(["object".into()]).map(|slot| (slot, vec!["normals".into()])));
        slots
    }

    /// Drops the values of parameters that no module of the scene declares: for a scene whose modules were exchanged.
    ///
    /// # Errors
    /// An unknown module.
    pub fn drop_foreign_parameters(&mut self, library: &Library) -> Result<(), SceneError> {
        let slots = self.slots_with_objects(library);
        self.check_modules(library, &slots)?;
        let declared = library.declarations(&self.entries(), &slots)?.parameters;
        self.parameters.retain(|name, _| declared.iter().any(|parameter| parameter.name == *name));
        Ok(())
    }

    /// Every value is in the range of its setting; those of additional objects are checked with them.
    fn check_values(&self) -> Result<(), SceneError> {
        let fields = self.fields();
        let own = fields.iter().filter(|(name, _)| !name.starts_with("parts.") || name.contains(".transform."));
        own.filter_map(|(name, value)| Some((name, value, setting(name)?)))
            .try_for_each(|(name, value, setting)| setting.check(name, value))
    }

    fn check_object(&self) -> Result<(), SceneError> {
        let object = &self.object;
        if object.inner_iso > object.outer_iso {
            return Err(SceneError::Value {
                field: "object.inner_iso".into(),
                value: object.inner_iso.to_string(),
                limit: format!(
                    "at most object.outer_iso = {}; for a hard object use softness = \"hard\"",
                    object.outer_iso
                ),
            });
        }
        Ok(())
    }

    fn check_look(&self, library: &Library) -> Result<(), SceneError> {
        let limit = match (self.effect.project.as_str(), self.object.is_formula()) {
            ("closest", true) => "needs a volume; object.source = \"normals16\" makes one of a formula",
            ("formula", false) => "needs an object that is a formula: sphere, cube or torus, without object.source",
            _ => "",
        };
        if !limit.is_empty() {
            let (field, value) = ("effect.project".into(), self.effect.project.clone());
            return Err(SceneError::Value { field, value, limit: limit.into() });
        }
        let sparse = |limit: &str| {
            let (field, value) = ("object.storage".into(), "\"sparse\"".into());
            Err(SceneError::Value { field, value, limit: limit.into() })
        };
        if self.object.storage == Storage::Sparse {
            if self.object.is_formula() {
                return sparse("needs a volume; object.source = \"normals16\" makes one of a formula");
            }
            let empty = |declared: &Declarations| declared.outside == Outside::Empty;
            if !empty(&header(library, "classify", &self.effect.classify)) {
                let empty = declaring(library, "classify", empty);
                return sparse(&format!(
                    "needs effect.classify = {empty}: others color what is beyond the soft region"
                ));
            }
        }
        self.check_light()?;
        let camera = &self.camera;
        if let Some(rotation) = camera.rotation {
            let length = rotation.iter().map(|value| value * value).sum::<f32>().sqrt();
            if !(0.999..=1.001).contains(&length) {
                return Err(SceneError::Value {
                    field: "camera.rotation".into(),
                    value: format!("{rotation:?}"),
                    limit: "must be a unit quaternion x, y, z, w: its squares sum to 1".into(),
                });
            }
        }
        camera.lens()?;
        if camera.shutter > 0.0 && self.quality.supersampling < 2 {
            return Err(SceneError::Value {
                field: "camera.shutter".into(),
                value: camera.shutter.to_string(),
                limit: "needs quality.supersampling of 2 or more: one moment is not blurred".into(),
            });
        }
        if camera.slice_stack && self.quality.pass == super::Pass::March {
            return Err(SceneError::Value {
                field: "camera.slice_stack".into(),
                value: "true".into(),
                limit: "needs quality.pass = \"slices\": rays have no stack to look at".into(),
            });
        }
        if let Some(plane) = camera.clip
            && plane[..3].iter().all(|&value| value.abs() < 1e-6)
        {
            return Err(SceneError::Value {
                field: "camera.clip".into(),
                value: format!("{plane:?}"),
                limit: "the first three numbers are the normal of the plane and must not all be 0".into(),
            });
        }
        Ok(())
    }

    fn check_transfer(&self) -> Result<(), SceneError> {
        let stops = &self.transfer.stops;
        if stops.is_empty() || stops.len() > 256 {
            return Err(SceneError::Value {
                field: "transfer.stops".into(),
                value: format!("{} stops", stops.len()),
                limit: "1 to 256".into(),
            });
        }
        for stop in stops {
            within("transfer.stops.at", stop.at, 0.0, 1.0)?;
            within("transfer.stops.density", stop.density, 0.0, 1.0)?;
            within("transfer.stops.index", stop.index, 1.0, 4.0)?;
        }
        match stops.windows(2).find(|pair| pair[0].at > pair[1].at) {
            None => Ok(()),
            Some(pair) => Err(SceneError::Value {
                field: "transfer.stops.at".into(),
                value: pair[1].at.to_string(),
                limit: format!("at least that of the stop before it, {}", pair[0].at),
            }),
        }
    }

    fn check_quality(&self, library: &Library) -> Result<(), SceneError> {
        let quality = &self.quality;
        let effect = &self.effect;
        let procedural = self.has_noise_loops(library);
        if quality.pass == super::Pass::March && effect.ray_path == RayPath::Straight {
            let most = (self.loop_budget(library) / self.sample_loops(library)).floor();
            if quality.samples as f32 > most {
                return Err(SceneError::Value {
                    field: "quality.samples".into(),
                    value: quality.samples.to_string(),
                    limit: format!(
                        "must be from 1 to {most} by rays, whose loops add up; quality.pass = \"slices\" takes more"
                    ),
                });
            }
        }
        if self.light.shadows && procedural && SHADOW_SAMPLES as f32 * self.procedural_loops(library) > LOOP_BUDGET {
            return Err(SceneError::Value {
                field: "light.shadows".into(),
                value: "true".into(),
                limit:
                    "needs fewer modules or octaves, or noise = \"block\" and turbulence = \"encoded\": a ray of the \
                        light would loop longer than every device bears"
                        .into(),
            });
        }
        let has_segments = |declared: &Declarations| declared.segments.is_some();
        if quality.integration == Integration::Segment && !has_segments(&header(library, "classify", &effect.classify))
        {
            return Err(SceneError::Value {
                field: "quality.integration".into(),
                value: "segment".into(),
                limit: format!(
                    "effect.classify = \"{}\" has points only; use {}, or integration = \"point\"",
                    effect.classify,
                    declaring(library, "classify", has_segments)
                ),
            });
        }
        let cells = quality.turbulence_cells;
        if 2 * cells > quality.block_size {
            let limit = format!("at most half of quality.block_size = {}", quality.block_size);
            let (field, value) = ("quality.turbulence_cells".into(), cells.to_string());
            return Err(SceneError::Value { field, value, limit });
        }
        for (slot, repeat, module) in [
            ("noise", effect.noise_repeat, &effect.noise),
            ("turbulence", effect.turbulence_repeat, &effect.turbulence),
        ] {
            if repeat != Repeat::Own && header(library, slot, module).period.is_some() {
                let limit = format!("must be \"own\" with {module}, which repeats as its memory does; use procedural");
                let field = format!("effect.{slot}_repeat");
                return Err(SceneError::Value { field, value: format!("{repeat:?}"), limit });
            }
        }
        Ok(())
    }

    /// What bends needs rays, and what only bent rays read needs rays that bend.
    fn check_ray(&self, library: &Library) -> Result<(), SceneError> {
        let effect = &self.effect;
        let refuse = |field: &str, value: &str, limit: String| {
            Err(SceneError::Value { field: field.into(), value: format!("\"{value}\""), limit })
        };
        if effect.ray_path == RayPath::Straight {
            let idle = [
                ("effect.environment", &effect.environment, effect.environment != "none"),
                ("effect.absorption", &effect.absorption, effect.absorption != "none"),
                ("effect.classify", &effect.classify, effect.classify == "clear"),
            ];
            return match idle.into_iter().find(|(_, _, set)| *set) {
                None => Ok(()),
                Some((field, value, _)) => refuse(field, value, "needs effect.ray_path = \"refracted\"".into()),
            };
        }
        if self.quality.pass == super::Pass::Slices {
            let limit = "needs quality.pass = \"march\": light does not bend from slice to slice".into();
            return refuse("effect.ray_path", "refracted", limit);
        }
        if self.has_noise_loops(library) {
            let limit = "needs turbulence = \"encoded\", and a noise whose header has `@loops 1`: a ray that bends reads too much of a sum";
            return refuse("effect.ray_path", "refracted", limit.into());
        }
        let straight_only = [
            ("quality.integration", "segment", self.quality.integration == Integration::Segment, "\"point\""),
            ("quality.jitter", "on", self.quality.jitter != Jitter::None, "\"none\""),
            ("effect.gradient", effect.gradient.as_str(), effect.gradient != "analytic", "\"analytic\""),
        ];
        if let Some((field, value, _, other)) = straight_only.into_iter().find(|entry| entry.2) {
            return refuse(field, value, format!("must be {other} where effect.ray_path = \"refracted\""));
        }
        if self.has_several() {
            return refuse("effect.ray_path", "refracted", "needs a scene of one object".into());
        }
        let most = ((LOOP_BUDGET / BENDING_LOOPS - BENDING_STEPS[1]) / BENDING_STEPS[0]).floor();
        within("quality.samples", self.quality.samples as f32, 1.0, most)
    }

    /// DMFs are of the kinds that they say, and several media need as many layers.
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
        Err(SceneError::Value { field: "effect.medium".into(), value: self.effect.medium.clone(), limit })
    }

    fn check_modules(&self, library: &Library, slots: &Slots) -> Result<(), SceneError> {
        for (key, names) in slots.iter().filter(|(key, _)| *key != FORMULA) {
            let (object, slot) = key.split_once('.').unwrap_or(("", key));
            let field =
                if object.is_empty() { format!("effect.{slot}") } else { format!("parts.{object}.effect.{slot}") };
            let known = library.modules(slot);
            for name in names {
                let (module, mask) = name.split_once('@').map_or((name.as_str(), None), |(a, b)| (a, Some(b)));
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

/// NaN lies in no range.
pub(super) fn within(field: &str, value: f32, low: f32, high: f32) -> Result<(), SceneError> {
    if (low..=high).contains(&value) {
        return Ok(());
    }
    let limit = format!("must be from {low} to {high}");
    Err(SceneError::Value { field: field.into(), value: value.to_string(), limit })
}

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::scene::{Color, ParameterValue, Pass, preset};
    use crate::shader;

    /// What is said of the preset of fur, changed.
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
    fn unknown_modules_and_parameters_are_refused_with_the_nearest_name() {
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
