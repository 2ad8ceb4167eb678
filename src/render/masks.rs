//! Masks that let all of a DMF through, and need not be asked.
//!
//! Role: a scene -> the same without them. Invariant: its picture is the same bit for bit. A mask is left out only where it is
//! proven to be 1 wherever its DMF is asked, whatever else is known there, with the roundings of a device.

use super::shot::Shot;
use super::variant::{Use, Variant, VariantError};
use super::view::Own;
use super::{RenderError, Subject};
use crate::eval::{self, Domain, F32Interval, Interval, Invocations};
use crate::scene::{Neutral, ParameterValue, Parameters, Scene};
use crate::shader::library::MASK;
use crate::shader::{Library, Linker};
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, PoisonError};

/// What says how much of a DMF a mask lets through. What it may know of a place but for place and density is anything.
const COVER: &str = "#version 450
#include \"interface.glsl\"
#include \"vector.glsl\"
#include \"sample_point.glsl\"
layout(location = 0) in vec4 place;
layout(location = 1) in vec4 other;
layout(location = 0) out vec4 fragment;
#include \"MASK\"
void main() {
    Sample s;
    s.x = place.xyz;
    s.density = place.w;
    s.distance = s.distance_bound = s.coherence = s.hair_length = other.x;
    s.normal = s.shading = s.wide_normal = s.hair_normal = s.hair_tangent = other.xyz;
    fragment = vec4(FUNCTION(s));
}
";
const NAME: &str = "cover";
const ENTRIES: [&str; 2] = ["march.vert", "mask/cover.glsl"];
/// How far from the soft region a sample may look, as segments do: the longest step and more, object units.
const AROUND: f32 = 0.5;
/// Answers that are kept.
const KEPT: usize = 64;

/// What is known of masks.
#[derive(Default)]
pub(super) struct Masks {
    /// Newest last.
    known: Mutex<Vec<(Question, bool)>>,
}

/// A mask, the values of its parameters, and a box in the object's own space.
#[derive(Clone, PartialEq)]
struct Question {
    mask: String,
    values: BTreeMap<String, ParameterValue>,
    places: [[f32; 3]; 2],
}

impl Masks {
    /// A scene without the masks that it does not need, and its modules.
    pub(super) fn without_idle<'a>(
        &self,
        library: &Library,
        scene: &'a Scene,
        subject: &Subject,
    ) -> Result<(Cow<'a, Scene>, Variant), RenderError> {
        let variant = Variant::of(scene, library)?;
        let has_masks = scene.dmfs().flatten().any(|name| name.contains('@'));
        if scene.quality.neutral == Neutral::Keep || !has_masks {
            return Ok((Cow::Borrowed(scene), variant));
        }
        let mut less = scene.clone();
        for own in &Shot::of(scene, subject, &variant).view.objects {
            let (alone, parameters) = match own.name.as_str() {
                "" => (Scene { parts: BTreeMap::new(), combine: None, ..scene.clone() }, &variant.parameters),
                name => (scene.alone(name), &variant.parts[name]),
            };
            let Some(alone) = self.stripped(library, alone, (&variant, parameters), own)? else { continue };
            let (effect, values) = match less.parts.get_mut(&own.name) {
                Some(part) => (&mut part.effect, &mut part.parameters),
                None => (&mut less.effect, &mut less.parameters),
            };
            (*effect, *values) = (alone.effect, alone.parameters);
        }
        if less == *scene {
            return Ok((Cow::Borrowed(scene), variant));
        }
        let variant = Variant::of(&less, library)?;
        Ok((Cow::Owned(less), variant))
    }

    /// The scene of an object alone without the masks that it does not need; `None` where it needs all.
    fn stripped(
        &self,
        library: &Library,
        mut alone: Scene,
        (variant, parameters): (&Variant, &Parameters),
        own: &Own,
    ) -> Result<Option<Scene>, RenderError> {
        let masks: Vec<&str> = alone.effect.dmf.iter().filter_map(|name| Some(name.split_once('@')?.1)).collect();
        let mut idle = BTreeSet::new();
        for mask in masks.iter().copied().collect::<BTreeSet<&str>>() {
            // A second use has parameters of its own, under names that change if the first goes alone.
            let uses = masks.iter().filter(|other| **other == mask).count();
            let mut covers = true;
            for number in 1..=uses {
                let copy = if number == 1 { String::new() } else { number.to_string() };
                covers = covers && self.covers(library, variant, parameters, (mask, &copy), own)?;
            }
            if covers {
                idle.insert(format!("@{mask}"));
            }
        }
        if idle.is_empty() {
            return Ok(None);
        }
        for name in &mut alone.effect.dmf {
            let at = name.find('@').filter(|at| idle.contains(&name[*at..]));
            name.truncate(at.unwrap_or(name.len()));
        }
        alone.drop_foreign_parameters(library).map_err(VariantError::from)?;
        Ok(Some(alone))
    }

    /// Whether a mask is 1 all around the soft region of an object.
    fn covers(
        &self,
        library: &Library,
        variant: &Variant,
        parameters: &Parameters,
        (mask, copy): (&str, &str),
        own: &Own,
    ) -> Result<bool, RenderError> {
        let end = |glue: &str| if copy.is_empty() { String::new() } else { format!("{glue}{copy}") };
        let declared = library.header(MASK, mask).map_err(VariantError::from)?.parameters;
        let names: BTreeSet<String> = declared.iter().map(|parameter| parameter.name.clone() + &end("_")).collect();
        let values = parameters.iter().filter(|(parameter, _)| names.contains(&parameter.name));
        let question = Question {
            mask: format!("{MASK}/{mask}.glsl{}", end("#")),
            values: values.map(|(parameter, value)| (parameter.name.clone(), value.clone())).collect(),
            places: [own.own_min - AROUND, own.own_max + AROUND].map(|corner| corner.to_array()),
        };
        let mut known = self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some((_, covers)) = known.iter().find(|(other, _)| *other == question) {
            return Ok(*covers);
        }
        let covers = question.answer(library, variant, &(mask.to_string() + &end("_")))?;
        if known.len() == KEPT {
            known.remove(0);
        }
        known.push((question, covers));
        Ok(covers)
    }
}

impl Question {
    fn answer(&self, library: &Library, variant: &Variant, function: &str) -> Result<bool, RenderError> {
        let library = library.clone().with_module(
            MASK,
            NAME,
            &COVER.replace("\"MASK\"", &format!("\"{}\"", self.mask)).replace("FUNCTION", function),
        );
        // One that asks for more than a sample has no program here, and is one that cannot be bounded.
        let Ok(slots) = library.needed(&ENTRIES, &variant.slots) else { return Ok(false) };
        let of_mask = Variant { entries: ENTRIES, slots, ..variant.clone() };
        let Ok(program) = of_mask.program(&library, Linker::new) else { return Ok(false) };
        let read = program.members_read();
        let mut inputs = eval::Inputs::default();
        for resource in &program.resources {
            let Use::Block(block) = &resource.holds else { return Ok(false) };
            let is_known = |(number, name): (u32, &String)| {
                self.values.contains_key(name) || !read.contains(&(resource.binding, number))
            };
            if !(0..).zip(block.members.iter().map(|member| &member.name)).all(is_known) {
                return Ok(false); // it moves, or depends on what is no parameter
            }
            let floats = |name: &str, count: usize| match self.values.get(name) {
                Some(ParameterValue::Number(number)) => vec![*number],
                Some(ParameterValue::Color(color)) => [&color.linear()[..], &[1.0]].concat(),
                None => vec![0.0; count],
            };
            let members: BTreeMap<&str, Vec<f32>> = block
                .members
                .iter()
                .map(|member| (member.name.as_str(), floats(&member.name, member.floats)))
                .collect();
            let bytes = block.fill(|name| members.get(name).map(Vec::as_slice)).map_err(RenderError::Unfilled)?;
            inputs.blocks.insert(resource.binding, bytes);
        }
        let [low, high] = self.places.map(|corner| corner.map(f64::from));
        let [x, y, z] = [0, 1, 2].map(|axis| F32Interval(Interval { lo: low[axis], hi: high[axis] }));
        let place = [x, y, z, F32Interval(Interval { lo: 0.0, hi: 1.0 })];
        let varyings = [(0, vec![place]), (1, vec![[F32Interval::any(); 4]])].into();
        let lanes = Invocations { fragment_coordinates: vec![[F32Interval::any(); 4]], varyings };
        // What cannot be bounded may be anything.
        let bounds = eval::Program::read_channel(&program.fragment, &[], (0, 0))
            .and_then(|code| code.bind(&inputs)?.run::<F32Interval>(&lanes));
        Ok(bounds.is_ok_and(|outputs| outputs[&0].first().is_some_and(|[cover, ..]| cover.0.lo >= 1.0)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::preset;
    use crate::shader;

    /// The DMFs that are left of a furry sphere, and its parameters.
    fn left(dmf: &[&str], parameters: &[(&str, f32)], own: &str) -> (Vec<String>, Vec<String>) {
        let library = shader::shipped().with_module(MASK, "own", &format!("float own(Sample s) {{ return {own}; }}"));
        let mut scene = preset("fur").unwrap();
        scene.object.input = "sphere".into();
        scene.effect.dmf = dmf.iter().map(|name| name.to_string()).collect();
        let values = parameters.iter().map(|(name, value)| (name.to_string(), ParameterValue::Number(*value)));
        scene.parameters.extend(values);
        let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
        let masks = Masks::default();
        let (less, variant) = masks.without_idle(&library, &scene, &subject).unwrap();
        assert_eq!(variant, Variant::of(&less, &library).unwrap());
        let again = masks.without_idle(&library, &scene, &subject).unwrap();
        assert!((&less, &variant) == (&again.0, &again.1), "what is known answers as what is proven");
        let is_of_mask = |name: &&String| name.starts_with("ball") || name.starts_with("height");
        (less.effect.dmf.clone(), less.parameters.keys().filter(is_of_mask).cloned().collect())
    }

    #[test]
    fn a_mask_that_lets_all_through_is_left_out_with_its_parameters_and_no_other() {
        let kept =
            |dmf: &[&str], parameters: &[(&str, f32)], own: &str| left(dmf, parameters, own).0.concat().contains('@');
        let around = [("ball_x", 0.1), ("ball_y", 0.0), ("ball_radius", 3.5)];
        assert_eq!(left(&["fur@ball"], &around, "1.0"), (vec!["fur".to_string()], Vec::new()));
        assert!(kept(&["fur@ball"], &[("ball_radius", 1.2)], "1.0"));
        assert!(!kept(&["fur@height"], &[("height_from", -4.0)], "1.0"));
        assert!(kept(&["fur@height"], &[("height_from", -1.2)], "1.0"));
        assert!(kept(&["fur@band"], &[("band_from", 0.0), ("band_to", 1.0)], "1.0"), "half of it at a density of 0");
        for (own, is_kept) in [
            ("1.0", false),
            ("max(1.0, s.density)", false),
            ("length(s.x) < 9.0 ? 1.0 : 0.0", false),
            ("0.9999999", true),
            ("s.distance > -9.0 ? 1.0 : 0.0", true),
            ("time > -9.0 ? 1.0 : 0.0", true),
            ("position_eye.x > -9.0 ? 1.0 : 1.0", true), // of the picture's program, not of a sample
        ] {
            assert_eq!(kept(&["fur@own"], &[], own), is_kept, "{own}");
        }
    }

    #[test]
    fn masks_of_one_module_are_left_out_together_as_their_parameters_have_its_name() {
        let both = ["fur@ball", "noisy@ball"];
        let values = [("ball_radius", 5.0), ("ball_radius_2", 4.0)];
        assert_eq!(left(&both, &values, "1.0"), (vec!["fur".to_string(), "noisy".to_string()], Vec::new()));
        let values = [("ball_radius", 5.0), ("ball_radius_2", 0.5)];
        let names = values.map(|(name, _)| name.to_string()).to_vec();
        assert_eq!(left(&both, &values, "1.0"), (both.map(String::from).to_vec(), names));
        let third = ["fur@ball", "noisy@height"];
        let (dmf, _) = left(&third, &values[..1], "1.0");
        assert_eq!(dmf, ["fur", "noisy@height"]);
    }
}
