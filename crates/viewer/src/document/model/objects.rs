//! Additional objects of the edited scene: they come, go and have names.

use super::state::Model;
use hypertexture::scene::{Part, Scene, Transform};
use hypertexture::shader::slots::MAIN;

/// Distance of a copy from its original, in units of the original.
const COPY_OFFSET: f32 = 0.25;

impl Model {
    /// Adds an object and appends it to the formula. Returns its name.
    pub fn add_part(&mut self, input: &str) -> Option<String> {
        let name = (1..).map(|number| format!("object{number}")).find(|name| !self.scene.parts.contains_key(name))?;
        let mut part = Part::default();
        part.object.input = input.into();
        part.transform = Transform { at: [1.0, 0.0, 0.0], scale: 0.5, ..part.transform };
        let good = self.edit(&format!("add {name}"), |scene| {
            scene.parts.insert(name.clone(), part);
            if let Some(formula) = &mut scene.combine {
                formula.push_str(&format!(" | {name}"));
            }
        });
        self.end_undo_group();
        good.then_some(name)
    }

    /// Adds a copy of an object beside it, appended to the formula. Returns the name of the copy.
    pub fn duplicate_part(&mut self, from: Option<&str>) -> Option<String> {
        let name = (1..).map(|number| format!("object{number}")).find(|name| !self.scene.parts.contains_key(name))?;
        let present = self.present();
        let mut part = match from {
            Some(from) => present.parts.get(from)?.clone(),
            None => {
                let Scene { object, effect, parameters, material, transfer, .. } = Scene::clone(&present);
                Part { object, effect, parameters, material, transfer, ..Part::default() }
            }
        };
        let [x, y, z] = part.transform.at;
        part.transform.at = [x + COPY_OFFSET * part.transform.scale, y, z];
        let good = self.edit(&format!("duplicate {}", from.unwrap_or(MAIN)), |scene| {
            scene.parts.insert(name.clone(), part);
            if let Some(formula) = &mut scene.combine {
                formula.push_str(&format!(" | {name}"));
            }
        });
        self.end_undo_group();
        good.then_some(name)
    }

    /// Removes an additional object. A formula that names it is replaced by the union.
    pub fn remove_part(&mut self, name: &str) -> bool {
        let good = self.edit(&format!("remove {name}"), |scene| {
            scene.parts.remove(name);
            let uses = scene.formula().is_ok_and(|formula| formula.objects().contains_key(name));
            if uses || scene.parts.is_empty() {
                scene.combine = None;
            }
        });
        self.end_undo_group();
        good
    }

    /// Renames an additional object, also in the formula and in its tracks.
    pub fn rename_part(&mut self, from: &str, to: &str) -> bool {
        if to == MAIN || self.scene.parts.contains_key(to) {
            self.say(format!("parts.{from}: `{to}` is the name of another object; choose one that no object has"));
            return false;
        }
        let good = self.edit(&format!("rename {from}"), |scene| {
            if let Some(part) = scene.parts.remove(from) {
                scene.parts.insert(to.into(), part);
            }
            scene.combine = scene.combine.as_deref().map(|formula| renamed(formula, from, to));
            let [own, new] = [from, to].map(|name| format!("parts.{name}."));
            let tracks = std::mem::take(&mut scene.animation.tracks).into_iter();
            let tracks = tracks.map(|(field, track)| match field.strip_prefix(&own) {
                Some(rest) => (format!("{new}{rest}"), track),
                None => (field, track),
            });
            scene.animation.tracks = tracks.collect();
        });
        self.end_undo_group();
        good
    }
}

/// A formula with another name for an object.
fn renamed(formula: &str, from: &str, to: &str) -> String {
    let is_name = |c: char| c.is_ascii_alphanumeric() || c == '_';
    let pieces = formula.split_inclusive(|c: char| !is_name(c));
    let piece = |piece: &str| match piece.trim_end_matches(|c: char| !is_name(c)) {
        name if name == from => piece.replacen(from, to, 1),
        _ => piece.into(),
    };
    pieces.map(piece).collect()
}
