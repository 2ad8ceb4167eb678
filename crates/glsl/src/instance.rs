//! Instances of modules for the additional objects of a scene.
//!
//! Objects may fill a slot with different modules, or with different parameters. So all code that depends on the object is
//! compiled once per object, with names that end in the object's; the rest is shared.

use super::declare::declaration;
use super::error::LibraryError;
use super::file::{Include, include};
use super::library::{Library, own_names};
use super::names::{has_state, rename, uses};
use super::slots::{PART, Slots, objects};
use std::collections::{BTreeMap, BTreeSet};

/// Functions generated for stacks.
const STACK_FUNCTIONS: [&str; 5] = ["displace", "modulate", "layer", "medium", "extinction"];
/// Bindings per object.
const BINDINGS: u32 = 8;

/// The code compiled for one object.
pub(super) struct Instance {
    name: String,
    /// Number of the object, from 1.
    index: u32,
    files: BTreeSet<String>,
    names: BTreeSet<String>,
    slots: BTreeSet<String>,
}

/// The instances of all additional objects, by name.
pub(super) fn instances(library: &Library, slots: &Slots) -> Result<BTreeMap<String, Instance>, LibraryError> {
    let all = objects(slots).into_iter().zip(1..);
    all.map(|(name, index)| Ok((name.to_string(), Instance::new(library, slots, name, index)?))).collect()
}

impl Instance {
    fn new(library: &Library, slots: &Slots, name: &str, index: u32) -> Result<Instance, LibraryError> {
        let prefix = format!("{name}.");
        let mut own = Instance {
            name: name.into(),
            index,
            files: BTreeSet::new(),
            names: STACK_FUNCTIONS.map(String::from).into(),
            slots: slots.keys().filter_map(|key| key.strip_prefix(&prefix)).map(String::from).collect(),
        };
        own.take(library, PART);
        for (key, modules) in slots.iter().filter(|(key, _)| key.starts_with(&prefix)) {
            library.files(&key[prefix.len()..], modules)?.iter().for_each(|file| own.take(library, file));
        }
        let owner = format!("the object `{name}`");
        let reached = library.object_files(name, slots)?;
        loop {
            let before = own.files.len();
            for file in &reached {
                let text = library.text(file);
                let depends = text.lines().filter_map(include).any(|include| match include {
                    Include::File(file) => own.files.contains(file),
                    Include::Slot(slot) => own.slots.contains(slot),
                });
                let declares = text.lines().filter_map(declaration).any(|(kind, _)| ["param", "color"].contains(&kind));
                if !own.files.contains(file) && (depends || declares || has_state(&text) || uses(&text, &own.names)) {
                    own.take(library, file);
                }
            }
            // Slots of the scene whose modules depend on the object become the object's.
            for (slot, modules) in slots.iter().filter(|(slot, _)| !slot.contains('.')) {
                let files = library.files(slot, modules).unwrap_or_default();
                if files.iter().any(|file| own.files.contains(file) && reached.contains(file)) {
                    own.slots.insert(slot.clone());
                }
            }
            if own.files.len() == before {
                let suffix = own.suffix();
                let files = own.files.iter().filter(|file| !file.contains('#') && library.source(file).is_some());
                files.map(|file| library.check_suffix(file, &suffix, &owner)).collect::<Result<Vec<_>, _>>()?;
                return Ok(own);
            }
        }
    }

    fn take(&mut self, library: &Library, file: &str) {
        self.names.extend(own_names(file, &library.text(file)));
        self.files.insert(file.to_string());
    }

    /// Suffix of the object's names.
    pub(super) fn suffix(&self) -> String {
        format!("_{}", self.name)
    }

    /// Text of a file or generated stack for this object.
    pub(super) fn text(&self, path: &str, text: &str) -> String {
        let renamed = rename(text, &self.names, &self.suffix());
        let mut inside_block = false;
        let lines = renamed.lines().map(|line| match include(line) {
            Some(Include::File(file)) if self.files.contains(file) => format!("#include \"{}:{file}\"", self.name),
            Some(Include::Slot(slot)) if self.slots.contains(slot) => format!("#include <{}:{slot}>", self.name),
            _ if path == PART => {
                inside_block |= line.contains(" uniform Constants");
                let kept = if inside_block { String::new() } else { self.shifted(line) };
                inside_block &= !line.starts_with('}');
                kept
            }
            _ => line.to_string(),
        });
        lines.map(|line| line + "\n").collect()
    }

    /// A line of `part.glsl` with this object's binding.
    fn shifted(&self, line: &str) -> String {
        const BEFORE: &str = "binding = ";
        let Some(at) = line.find(BEFORE).map(|at| at + BEFORE.len()) else { return line.into() };
        let end = line[at..].find(|c: char| !c.is_ascii_digit()).map_or(line.len(), |length| at + length);
        let binding: u32 = line[at..end].parse().unwrap_or_default();
        format!("{}{}{}", &line[..at], binding + BINDINGS * self.index, &line[end..])
    }
}
