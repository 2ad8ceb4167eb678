//! The shader library: modules by path, and the part of it that a program reaches.

use super::declare::{Declarations, parse};
use super::drift::Drift;
use super::error::LibraryError;
use super::file::{File, Include, include};
use super::names::{definitions, members, rename};
use super::reach::Reach;
use super::slots::{
    FOLDED, FORMULA, MASK, MEDIUM, MEDIUM_FUNCTIONS, NONE, OBJECT_ENTRY, OBJECTS, OPTIONAL, PARAMETERS, PART, Slots,
    objects, qualified,
};
use std::borrow::Cow;
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;
use std::{fs, io};

/// GLSL sources by path relative to the `glsl` folder, such as `dmf/fur.glsl`. Clones share the sources.
#[derive(Clone, Debug)]
pub struct Library {
    sources: Arc<BTreeMap<String, File>>,
    compiler: Compiler,
    /// Whether pictures are counts.
    pub(super) counts: bool,
}

/// Where user text is compiled.
#[derive(Clone, Debug, Default)]
pub enum Compiler {
    /// In this process, unrestricted.
    #[default]
    Here,
    /// In this process, which has limits; restrictions on user text apply.
    HereWithLimits,
    /// In a child process with limits, by this hypertexture executable.
    Apart(Arc<Path>),
}

/// Compares sources only.
impl PartialEq for Library {
    fn eq(&self, other: &Library) -> bool {
        self.sources().eq(other.sources())
    }
}

impl Eq for Library {}

impl Library {
    /// Builds a library from (path, text) pairs.
    pub fn new(sources: impl IntoIterator<Item = (String, String)>) -> Library {
        let files = sources.into_iter().map(|(path, text)| (path, File::new(text)));
        Library { sources: Arc::new(files.collect()), compiler: Compiler::Here, counts: false }
    }

    /// Reads every file of a folder that has an extension.
    ///
    /// # Errors
    /// I/O errors, or a file that is not UTF-8.
    pub fn read(folder: &Path) -> io::Result<Library> {
        fn collect(root: &Path, folder: &Path, files: &mut Vec<(String, String)>) -> io::Result<()> {
            for entry in fs::read_dir(folder)? {
                let path = entry?.path();
                if path.is_dir() {
                    collect(root, &path, files)?;
                } else if path.extension().is_some() {
                    let relative = path.strip_prefix(root).unwrap_or(&path).to_string_lossy().replace('\\', "/");
                    files.push((relative, fs::read_to_string(&path)?));
                }
            }
            Ok(())
        }
        let mut files = Vec::new();
        collect(folder, folder, &mut files)?;
        Ok(Library::new(files))
    }

    /// Adds or replaces a module.
    pub fn with_module(self, slot: &str, name: &str, text: &str) -> Library {
        self.with_file(&format!("{slot}/{name}.glsl"), text)
    }

    /// Adds or replaces a file.
    pub fn with_file(mut self, path: &str, text: &str) -> Library {
        Arc::make_mut(&mut self.sources).insert(path.into(), File::new(text.into()));
        self
    }

    /// A library of other sources with the compiler of this one.
    pub(super) fn with_sources(&self, sources: impl IntoIterator<Item = (String, String)>) -> Library {
        Library { compiler: self.compiler.clone(), counts: self.counts, ..Library::new(sources) }
    }

    /// Compiles user text in child processes with limits that run the hypertexture executable `program`. Text can crash a compiler,
    /// or keep it busy until memory ends.
    pub fn compiled_by(self, program: &Path) -> Library {
        Library { compiler: Compiler::Apart(program.into()), ..self }
    }

    /// Compiles user text in this process.
    pub fn compiled_here(self) -> Library {
        Library { compiler: Compiler::Here, ..self }
    }

    /// Compiles user text in this process, which has limits.
    pub fn compiled_with_limits(self) -> Library {
        Library { compiler: Compiler::HereWithLimits, ..self }
    }

    /// Where user text is compiled.
    pub fn compiler(&self) -> &Compiler {
        &self.compiler
    }

    /// Path and text of every file.
    pub fn sources(&self) -> impl Iterator<Item = (&str, &str)> {
        self.sources.iter().map(|(path, file)| (path.as_str(), file.text.as_str()))
    }

    /// Text of a file.
    pub fn source(&self, path: &str) -> Option<&str> {
        self.sources.get(path).map(|file| file.text.as_str())
    }

    /// Declarations of a module.
    ///
    /// # Errors
    /// The module does not exist or has a declaration that cannot be read.
    pub fn header(&self, slot: &str, name: &str) -> Result<Declarations, LibraryError> {
        let path = self.path(slot, name)?;
        self.sources.get(&path).map_or_else(|| Ok(Declarations::default()), |file| file.declared(&path))
    }

    /// Names of the modules of a slot, sorted.
    pub fn modules(&self, slot: &str) -> Vec<&str> {
        let prefix = format!("{slot}/");
        let files = self.sources.range(prefix.clone()..).map_while(|(path, _)| path.strip_prefix(&prefix));
        files.filter_map(|file| file.strip_suffix(".glsl")).collect()
    }

    /// Path of a module.
    ///
    /// # Errors
    /// [`LibraryError::Unknown`] lists the modules of the slot.
    pub fn path(&self, slot: &str, name: &str) -> Result<String, LibraryError> {
        let path = format!("{slot}/{name}.glsl");
        if self.sources.contains_key(&path) {
            return Ok(path);
        }
        let known = self.modules(slot).join(", ");
        Err(LibraryError::Unknown { slot: slot.into(), name: name.into(), known })
    }

    /// Text of a file or copy. In `path#2`, the second copy of a module, all definitions and declarations end in `_2`. In
    /// `path#name`, a medium of several, the functions of the slot end in its name. A medium without extinction gets 1.
    pub fn text(&self, path: &str) -> Cow<'_, str> {
        let (file, tag) = path.split_once('#').unwrap_or((path, ""));
        let mut text = Cow::from(self.source(file).unwrap_or_default());
        let [_, extinction] = MEDIUM_FUNCTIONS;
        if file.starts_with("medium/") && !definitions(&text).contains(extinction) {
            text.to_mut().push_str("\nfloat extinction(Sample s, float density) { return 1.0; }\n");
        }
        let names = match tag {
            "" => return text,
            copy if is_copy(copy) => own_names(file, &text),
            _ => MEDIUM_FUNCTIONS.map(String::from).into(),
        };
        rename(&text, &names, &format!("_{tag}")).into()
    }

    /// The files that fill a slot, in order. A mask precedes its DMF; the second use of a module in a stack is `path#2`.
    ///
    /// # Errors
    /// [`LibraryError::Unknown`].
    pub fn files(&self, slot: &str, names: &[String]) -> Result<Vec<String>, LibraryError> {
        let mut files: Vec<String> = Vec::new();
        for name in names {
            let (module, mask) = name.split_once('@').map_or((name.as_str(), None), |(name, mask)| (name, Some(mask)));
            let mask = mask.map(|mask| self.path(MASK, mask)).transpose()?;
            for path in mask.into_iter().chain([self.path(slot, module)?]) {
                let same = |file: &&String| file.split('#').next() == Some(path.as_str());
                let copies = files.iter().filter(same).count();
                files.push(match copies {
                    0 if slot == MEDIUM && names.len() > 1 => format!("{path}#{module}"),
                    0 => path,
                    _ => format!("{path}#{}", copies + 1),
                });
            }
        }
        Ok(files)
    }

    /// The part of `choice` that `entries` reach, directly or through the chosen modules.
    ///
    /// # Errors
    /// [`LibraryError::Unknown`] if a reached slot has no choice or the module does not exist.
    pub fn needed(&self, entries: &[&str], choice: &Slots) -> Result<Slots, LibraryError> {
        let mut needed = Slots::new();
        let several = Cell::new(false);
        let mut take = |object: &str, entries: &[&str]| {
            self.visit(object, entries, choice, &mut |reached| {
                let Include::Slot(slot) = reached else { return Ok(()) };
                several.set(several.get() || slot == OBJECTS);
                let own = choice.get_key_value(&format!("{object}.{slot}")).or(choice.get_key_value(slot));
                needed.extend(own.map(|(key, names)| (key.clone(), names.clone())));
                Ok(())
            })
        };
        take("", entries)?;
        if several.get() {
            objects(choice).into_iter().try_for_each(|object| take(object, &[OBJECT_ENTRY]))?;
            needed.extend(choice.get_key_value(FORMULA).map(|(key, formula)| (key.clone(), formula.clone())));
        }
        if let Some(names) = choice.get(FOLDED).filter(|names| !names.is_empty()) {
            let known = self.constants(entries, &needed)?;
            let names: Vec<String> = names.iter().filter(|name| known.contains(*name)).cloned().collect();
            needed.extend((!names.is_empty()).then(|| (FOLDED.into(), names)));
        }
        Ok(needed)
    }

    /// All names of a program that [`FOLDED`] may contain.
    fn constants(&self, entries: &[&str], slots: &Slots) -> Result<BTreeSet<String>, LibraryError> {
        let part = self.text(PART);
        let mut names = BTreeSet::new();
        let parts = objects(slots).into_iter().map(|object| (object, self.object_declarations(object, slots)));
        for (object, declared) in [("", self.declarations(entries, slots))].into_iter().chain(parts) {
            let parameters = declared?.parameters;
            let own =
                parameters.iter().map(|own| own.name.as_str()).chain(members(&part).into_iter().map(|(_, name)| name));
            names.extend(own.map(|name| qualified(object, name)));
        }
        Ok(names)
    }

    /// All files reached from `entries`, without those of additional objects.
    ///
    /// # Errors
    /// [`LibraryError::Unknown`].
    pub fn files_reached(&self, entries: &[&str], choice: &Slots) -> Result<Vec<String>, LibraryError> {
        self.files_of("", entries, choice)
    }

    /// All declarations of the files reached from `entries`, without those of additional objects.
    ///
    /// # Errors
    /// A declaration that cannot be read, two that disagree, or a module that does not exist.
    pub fn declarations(&self, entries: &[&str], choice: &Slots) -> Result<Declarations, LibraryError> {
        self.declared("", entries, choice)
    }

    /// All declarations of an additional object's modules, under their names in the files.
    ///
    /// # Errors
    /// See [`Library::declarations`].
    pub fn object_declarations(&self, object: &str, choice: &Slots) -> Result<Declarations, LibraryError> {
        self.declared(object, &[OBJECT_ENTRY], choice)
    }

    fn declared(&self, object: &str, entries: &[&str], choice: &Slots) -> Result<Declarations, LibraryError> {
        let (mut all, mut measured) = (Declarations::default(), Vec::new());
        self.visit(object, entries, choice, &mut |reached| {
            let Include::File(path) = reached else { return Ok(()) };
            let (file, copy) = path.split_once('#').unwrap_or((path, ""));
            let Some(found) = self.sources.get(file) else { return Ok(()) };
            let mut one = found.declared(file)?;
            if is_copy(copy) {
                one.add_suffix(&format!("_{copy}"));
            }
            let names = one.reach.iter_mut().flat_map(Reach::names);
            let names = names.chain(one.drifts.iter_mut().flat_map(Drift::parameters));
            measured.extend(names.map(|name| (file.to_string(), name.clone())));
            for parameter in one.parameters {
                match all.parameters.iter().find(|known| known.name == parameter.name) {
                    None => all.parameters.push(parameter),
                    Some(known) if *known == parameter => {}
                    Some(_) => return Err(LibraryError::Twice { name: parameter.name }),
                }
            }
            all.outer.extend(one.outer);
            all.reach.extend(one.reach);
            all.drifts.extend(one.drifts);
            all.noise_bound = one.noise_bound.or(all.noise_bound);
            all.needs_normal |= one.needs_normal;
            all.groom.extend(one.groom);
            Ok(())
        })?;
        let is_known = |name: &String| all.parameters.iter().any(|parameter| parameter.name == *name);
        match measured.into_iter().find(|(_, name)| !is_known(name)) {
            None => Ok(all),
            Some((path, name)) => Err(LibraryError::Unmeasured { path, name }),
        }
    }

    /// All files that an additional object reaches.
    ///
    /// # Errors
    /// [`LibraryError::Unknown`].
    pub fn object_files(&self, object: &str, choice: &Slots) -> Result<Vec<String>, LibraryError> {
        self.files_of(object, &[OBJECT_ENTRY], choice)
    }

    fn files_of(&self, object: &str, entries: &[&str], choice: &Slots) -> Result<Vec<String>, LibraryError> {
        let mut files = Vec::new();
        self.visit(object, entries, choice, &mut |reached| {
            if let Include::File(path) = reached {
                files.push(path.into());
            }
            Ok(())
        })?;
        Ok(files)
    }

    /// Calls `on` once for each file and each slot reached from `entries`. Slots of `object` take precedence over the scene's.
    fn visit(&self, object: &str, entries: &[&str], choice: &Slots, on: &mut Visitor<'_>) -> Result<(), LibraryError> {
        let mut queue: Vec<String> = entries.iter().rev().map(|entry| entry.to_string()).collect();
        let mut seen = BTreeSet::new();
        while let Some(path) = queue.pop() {
            if !seen.insert(path.clone()) {
                continue;
            }
            on(Include::File(&path))?;
            let file = self.sources.get(path.split('#').next().unwrap_or_default());
            for line in file.map_or(&[][..], File::includes) {
                match include(line) {
                    Some(Include::File(file)) => queue.push(file.to_string()),
                    Some(Include::Slot(PARAMETERS)) | None => {}
                    Some(Include::Slot(OBJECTS)) => {
                        on(Include::Slot(OBJECTS))?;
                        queue.push(OBJECT_ENTRY.into());
                    }
                    Some(Include::Slot(slot)) => {
                        let own = choice.get(&format!("{object}.{slot}"));
                        let Some(names) = own.or(choice.get(slot)) else {
                            if OPTIONAL.contains(&slot) {
                                queue.push(format!("{slot}/{NONE}.glsl"));
                                continue;
                            }
                            if self.modules(slot).is_empty() {
                                return Err(LibraryError::Slot { path, slot: slot.into() });
                            }
                            self.path(slot, "")?; // no module has an empty name, so this error lists the modules
                            continue;
                        };
                        if seen.insert(format!("<{slot}>")) {
                            on(Include::Slot(slot))?;
                        }
                        queue.extend(self.files(slot, names)?);
                    }
                }
            }
        }
        Ok(())
    }
}

/// All definitions and declarations of a file.
pub fn own_names(path: &str, text: &str) -> BTreeSet<String> {
    let declared = parse(path, text).unwrap_or_default().parameters.into_iter().map(|parameter| parameter.name);
    definitions(text).into_iter().chain(declared).collect()
}

/// Whether the tag of a path is the number of a copy.
pub(super) fn is_copy(tag: &str) -> bool {
    tag.starts_with(|c: char| c.is_ascii_digit())
}

/// Callback for reached files and slots.
type Visitor<'a> = dyn FnMut(Include<'_>) -> Result<(), LibraryError> + 'a;

#[cfg(test)]
mod tests {
    use super::*;

    fn library(files: &[(&str, &str)]) -> Library {
        Library::new(files.iter().map(|(path, text)| (path.to_string(), text.to_string())))
    }

    fn slots(pairs: &[(&str, &[&str])]) -> Slots {
        pairs.iter().map(|(slot, names)| (slot.to_string(), names.iter().map(|n| n.to_string()).collect())).collect()
    }

    #[test]
    fn unreached_slots_are_left_out() {
        let library = library(&[
            ("a.frag", "#include <dmf>"),
            ("dmf/fur.glsl", "#include <noise>"),
            ("dmf/plain.glsl", ""),
            ("noise/block.glsl", ""),
        ]);
        let noise: (&str, &[&str]) = ("noise", &["block"]);
        let fur = library.needed(&["a.frag"], &slots(&[("dmf", &["fur"]), noise])).unwrap();
        assert!(fur.contains_key("noise"));
        let plain = library.needed(&["a.frag"], &slots(&[("dmf", &["plain"]), noise])).unwrap();
        assert!(!plain.contains_key("noise"));
    }

    #[test]
    fn an_unknown_module_is_refused_with_the_known_ones() {
        let library = library(&[("a.frag", "#include <dmf>"), ("dmf/fur.glsl", "")]);
        let error = library.needed(&["a.frag"], &slots(&[("dmf", &["furr"])])).unwrap_err().to_string();
        assert_eq!(error, "no module `furr` in slot `dmf`; choose one of: fur");
    }
}
