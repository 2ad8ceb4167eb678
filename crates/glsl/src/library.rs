//! The modules by path.

use super::declare::{Declarations, parse};
use super::drift::Drift;
use super::error::LibraryError;
use super::file::{File, Include, include};
use super::names::{definitions, members, rename};
use super::reach::Reach;
use std::borrow::Cow;
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::sync::Arc;
use std::{fs, io};

/// Which modules fill each slot: one name, or for a stack (`warp`, `dmf`) any number in order of application, and for
/// `medium` one for each layer of the DMFs; a DMF may be `module@mask`. The slot of an additional object is `object.slot`,
/// [`COMBINE`] holds the formula of the objects, and [`ZERO`] the parameters that are 0.
pub type Slots = BTreeMap<String, Vec<String>>;

/// GLSL sources by path relative to the `glsl` folder, such as `dmf/fur.glsl`. Clones share them.
#[derive(Clone, Debug)]
pub struct Library {
    sources: Arc<BTreeMap<String, File>>,
    compiler: Compiler,
}

/// What compiles texts that do not ship.
#[derive(Clone, Debug, Default)]
pub enum Compiler {
    /// This process, without limits.
    #[default]
    Here,
    /// This process, which has limits; what a person's program may not hold is refused.
    HereWithLimits,
    /// This executable of hypertexture, in a process of its own with limits.
    Apart(Arc<Path>),
}

/// By their texts.
impl PartialEq for Library {
    fn eq(&self, other: &Library) -> bool {
        self.sources().eq(other.sources())
    }
}

impl Eq for Library {}

impl Library {
    /// A library of (path, text) pairs.
    pub fn new(sources: impl IntoIterator<Item = (String, String)>) -> Library {
        let files = sources.into_iter().map(|(path, text)| (path, File::new(text)));
        Library { sources: Arc::new(files.collect()), compiler: Compiler::Here }
    }

    /// The library of a folder: every file that has an extension, by its path from there.
    ///
    /// # Errors
    /// A file or a folder cannot be read, or is not text.
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

    /// The same library with one more module, or with that module replaced.
    pub fn with_module(self, slot: &str, name: &str, text: &str) -> Library {
        self.with_file(&format!("{slot}/{name}.glsl"), text)
    }

    /// The same library with one more file, or with that file replaced.
    pub fn with_file(mut self, path: &str, text: &str) -> Library {
        Arc::make_mut(&mut self.sources).insert(path.into(), File::new(text.into()));
        self
    }

    /// A library of other (path, text) pairs, compiled as this one is.
    pub(super) fn with_sources(&self, sources: impl IntoIterator<Item = (String, String)>) -> Library {
        Library { compiler: self.compiler.clone(), ..Library::new(sources) }
    }

    /// The same library, whose texts that do not ship are compiled in a process of their own, with limits: that executable of
    /// hypertexture. A text can crash a compiler, or keep it busy until memory ends.
    pub fn compiled_by(self, program: &Path) -> Library {
        Library { compiler: Compiler::Apart(program.into()), ..self }
    }

    /// The same library, whose texts are compiled in this process.
    pub fn compiled_here(self) -> Library {
        Library { compiler: Compiler::Here, ..self }
    }

    /// The same library in a process that has limits.
    pub fn compiled_with_limits(self) -> Library {
        Library { compiler: Compiler::HereWithLimits, ..self }
    }

    /// What compiles its texts that do not ship.
    pub fn compiler(&self) -> &Compiler {
        &self.compiler
    }

    /// Every file: path relative to the `glsl` folder, and text.
    pub fn sources(&self) -> impl Iterator<Item = (&str, &str)> {
        self.sources.iter().map(|(path, file)| (path.as_str(), file.text.as_str()))
    }

    /// Text of a file, by its path relative to the `glsl` folder.
    pub fn source(&self, path: &str) -> Option<&str> {
        self.sources.get(path).map(|file| file.text.as_str())
    }

    /// What the header of one module declares.
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

    /// The text of a file. `path#2` is the second copy of a module: all that it defines and declares ends in `_2`.
    /// `path#name` is a medium of several: the functions of its slot end in its name. A medium that does not say how
    /// opaque it is has an extinction of 1.
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

    /// The files that fill a slot, in order: a mask comes before the DMF that it belongs to, and the second use of a
    /// module in a stack is `path#2`.
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

    /// The slots that `entries` really reach when filled from `choice`, directly or through the modules chosen:
    /// the rest of `choice` is left out.
    ///
    /// # Errors
    /// [`LibraryError::Unknown`] when a reached slot has no choice or the module does not exist.
    pub fn needed(&self, entries: &[&str], choice: &Slots) -> Result<Slots, LibraryError> {
        let mut needed = Slots::new();
        let several = Cell::new(false);
        let mut take = |object: &str, slot: &str| {
            several.set(several.get() || slot == OBJECTS);
            let own = choice.get_key_value(&format!("{object}.{slot}"));
            needed.extend(own.or(choice.get_key_value(slot)).map(|(key, names)| (key.clone(), names.clone())));
        };
        self.visit("", entries, choice, &mut |_, slot| {
            slot.into_iter().for_each(|slot| take("", slot));
            Ok(())
        })?;
        if several.get() {
            for object in objects(choice) {
                self.visit(object, &[OBJECT_ENTRY], choice, &mut |_, slot| {
                    slot.into_iter().for_each(|slot| take(object, slot));
                    Ok(())
                })?;
            }
            needed.extend(choice.get_key_value(COMBINE).map(|(key, formula)| (key.clone(), formula.clone())));
        }
        let mut zero = choice.get(ZERO).cloned().unwrap_or_default();
        if !zero.is_empty() {
            let known = self.constants(entries, &needed)?;
            zero.retain(|name| known.contains(name));
        }
        if !zero.is_empty() {
            needed.insert(ZERO.into(), zero);
        }
        Ok(needed)
    }

    /// Everything of a program that [`ZERO`] may name.
    fn constants(&self, entries: &[&str], slots: &Slots) -> Result<BTreeSet<String>, LibraryError> {
        let part = self.text(PART);
        let mut names = BTreeSet::new();
        let parts = objects(slots).into_iter().map(|object| (object, self.object_declarations(object, slots)));
        for (object, declared) in [("", self.declarations(entries, slots))].into_iter().chain(parts) {
            let parameters = declared?.parameters;
            let own =
                parameters.iter().map(|own| own.name.as_str()).chain(members(&part).into_iter().map(|(_, name)| name));
            names.extend(own.map(|name| prefixed(object, name)));
        }
        Ok(names)
    }

    /// Every file that is reached from `entries`, but for those of additional objects.
    ///
    /// # Errors
    /// [`LibraryError::Unknown`].
    pub fn files_reached(&self, entries: &[&str], choice: &Slots) -> Result<Vec<String>, LibraryError> {
        self.files_of("", entries, choice)
    }

    /// Everything that the files reached from `entries` declare; without what additional objects declare.
    ///
    /// # Errors
    /// A declaration that cannot be read, two that disagree, or a module that does not exist.
    pub fn declarations(&self, entries: &[&str], choice: &Slots) -> Result<Declarations, LibraryError> {
        self.declared("", entries, choice)
    }

    /// Everything that the modules of an additional object declare, under the names that they have in their files.
    ///
    /// # Errors
    /// As [`Library::declarations`].
    pub fn object_declarations(&self, object: &str, choice: &Slots) -> Result<Declarations, LibraryError> {
        self.declared(object, &[OBJECT_ENTRY], choice)
    }

    fn declared(&self, object: &str, entries: &[&str], choice: &Slots) -> Result<Declarations, LibraryError> {
        let (mut all, mut measured) = (Declarations::default(), Vec::new());
        self.visit(object, entries, choice, &mut |path, _| {
            let Some(path) = path else { return Ok(()) };
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
            Ok(())
        })?;
        let is_known = |name: &String| all.parameters.iter().any(|parameter| parameter.name == *name);
        match measured.into_iter().find(|(_, name)| !is_known(name)) {
            None => Ok(all),
            Some((path, name)) => Err(LibraryError::Unmeasured { path, name }),
        }
    }

    /// Every file that an additional object reaches.
    ///
    /// # Errors
    /// [`LibraryError::Unknown`].
    pub fn object_files(&self, object: &str, choice: &Slots) -> Result<Vec<String>, LibraryError> {
        self.files_of(object, &[OBJECT_ENTRY], choice)
    }

    fn files_of(&self, object: &str, entries: &[&str], choice: &Slots) -> Result<Vec<String>, LibraryError> {
        let mut files = Vec::new();
        self.visit(object, entries, choice, &mut |path, _| {
            files.extend(path.map(String::from));
            Ok(())
        })?;
        Ok(files)
    }

    /// Calls `on` once for each file and for each slot reached from `entries`; the slots of `object` go before those of
    /// the scene.
    fn visit(&self, object: &str, entries: &[&str], choice: &Slots, on: &mut Visitor<'_>) -> Result<(), LibraryError> {
        let mut queue: Vec<String> = entries.iter().rev().map(|entry| entry.to_string()).collect();
        let mut seen = BTreeSet::new();
        while let Some(path) = queue.pop() {
            if !seen.insert(path.clone()) {
                continue;
            }
            on(Some(&path), None)?;
            let file = self.sources.get(path.split('#').next().unwrap_or_default());
            for line in file.map_or(&[][..], File::includes) {
                match include(line) {
                    Some(Include::File(file)) => queue.push(file.to_string()),
                    Some(Include::Slot(PARAMETERS)) | None => {}
                    Some(Include::Slot(OBJECTS)) => {
                        on(None, Some(OBJECTS))?;
                        queue.push(OBJECT_ENTRY.into());
                    }
                    Some(Include::Slot(slot)) => {
                        let own = choice.get(&format!("{object}.{slot}"));
                        let Some(names) = own.or(choice.get(slot)) else {
                            if self.modules(slot).is_empty() {
                                return Err(LibraryError::Slot { path, slot: slot.into() });
                            }
                            self.path(slot, "")?; // no module has an empty name: this lists what there is
                            continue;
                        };
                        if seen.insert(format!("<{slot}>")) {
                            on(None, Some(slot))?;
                        }
                        queue.extend(self.files(slot, names)?);
                    }
                }
            }
        }
        Ok(())
    }
}

/// The additional objects of a scene, by name.
pub fn objects(choice: &Slots) -> BTreeSet<&str> {
    choice.keys().filter_map(|key| key.split_once('.')).map(|(object, _)| object).collect()
}

/// A name in [`ZERO`].
pub fn prefixed(object: &str, name: &str) -> String {
    if object.is_empty() { name.into() } else { format!("{object}.{name}") }
}

/// What a file defines and declares.
pub fn own_names(path: &str, text: &str) -> BTreeSet<String> {
    let declared = parse(path, text).unwrap_or_default().parameters.into_iter().map(|parameter| parameter.name);
    definitions(text).into_iter().chain(declared).collect()
}

/// Whether what follows the `#` of a path is the number of a copy.
fn is_copy(tag: &str) -> bool {
    tag.starts_with(|c: char| c.is_ascii_digit())
}

/// Called with the path of a file or with the name of a slot.
type Visitor<'a> = dyn FnMut(Option<&str>, Option<&str>) -> Result<(), LibraryError> + 'a;

/// The slot that the linker fills with the uniform block of all parameters.
pub const PARAMETERS: &str = "parameters";
/// The slot that the linker fills with all objects of a scene and the classification of what they make together.
pub const OBJECTS: &str = "objects";
/// The key in [`Slots`] of the formula by which the objects make one.
pub const COMBINE: &str = "combine";
/// The key in [`Slots`] of what is 0: parameters and members of `part.glsl`'s block, those of an additional object as
/// `object.name`. They are constants of the program, which does without the terms that they take away.
pub const ZERO: &str = "zero";
/// The file of what each object has for itself.
pub const PART: &str = "part.glsl";
/// The slot of the masks: where a DMF acts.
pub const MASK: &str = "mask";
/// The slot that colors soft matter.
pub const MEDIUM: &str = "medium";
/// What a module of that slot defines: its color and, where it is not 1, how opaque it is against the scene's rate.
pub const MEDIUM_FUNCTIONS: [&str; 2] = [MEDIUM, "extinction"];
/// The file that each object of several is entered by.
pub const OBJECT_ENTRY: &str = "one_of_several.glsl";

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
    fn slots_that_nothing_reaches_are_left_out() {
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
