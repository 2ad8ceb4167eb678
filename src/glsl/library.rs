//! The modules by path, and the declarations in their comments.
//!
//! A module declares its parameters where it uses them:
//! ```glsl
//! // @knob hair_length = 0.16 in [0.005, 0.6]: Length of the hair, object units.
//! // @color tip_color = #d9a05f: Color of the hair at its tip.
//! // @outer hair_length      the soft region ends at this signed distance
//! // @move drip_length       a lookup moves at most so far, and matter grows as far; see `reach`
//! // @grow 0                 matter grows less than that
//! // @bound 1                the largest value of this noise
//! // @needs normal           the module reads the normal of a sample
//! // @exact procedural noise_block   what the module holds samples of: a module of its slot, and the lattice's repetition
//! ```
//! The same lines feed the uniform block, the checks of a scene file and the documentation.

use super::names::{definitions, rename};
use super::reach::Reach;
use std::borrow::Cow;
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};

/// Which modules fill each slot: one name, or for a stack (`warp`, `dmf`) any number in order of application, and for
/// `medium` one for each layer of the DMFs; a DMF may be `module@mask`. The slot of a further object is `object.slot`, and [`COMBINE`] holds the formula of the objects.
pub type Slots = BTreeMap<String, Vec<String>>;

/// GLSL sources by path relative to the `glsl` folder, such as `dmf/fur.glsl`.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Library {
    sources: BTreeMap<String, String>,
}

/// What a module declares.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Declarations {
    /// Parameters, in the order of the file.
    pub knobs: Vec<Knob>,
    /// Knobs that set the outer iso-value of the soft region, one for each layer of it.
    pub outer: Vec<String>,
    /// How far each of the modules moves lookups, and how far matter grows by that.
    pub reach: Vec<Reach>,
    /// The largest value of the noise, where it is not [`super::reach::NOISE_BOUND`].
    pub noise_bound: Option<f32>,
    /// Whether the normal of a sample is read.
    pub needs_normal: bool,
    /// The module of the same slot that computes what this one holds samples of.
    pub exact: Option<Exact>,
}

/// The module that a module approximates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exact {
    /// Its name; it fills the same slot.
    pub module: String,
    /// After how many cells its lattice has to repeat: a value of `effect.turbulence_repeat`; none where it does not
    /// matter.
    pub repeat: Option<String>,
}

/// A parameter of a module.
#[derive(Clone, Debug, PartialEq)]
pub struct Knob {
    /// Name in GLSL, in scene files and on the command line.
    pub name: String,
    /// Value where the scene gives none, with the allowed range of a number.
    pub default: Default,
    /// One sentence with the unit.
    pub doc: String,
}

/// Type, default and range of a [`Knob`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Default {
    /// A finite number and the closed range it must lie in.
    Number(f32, [f32; 2]),
    /// A color: sRGB, 8 bits each.
    Color([u8; 3]),
}

/// Why a library does not give what is asked of it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LibraryError {
    /// There is no such module.
    #[error("no module `{name}` in slot `{slot}`; choose one of: {known}")]
    Unknown {
        /// The slot.
        slot: String,
        /// The name asked for.
        name: String,
        /// What there is.
        known: String,
    },
    /// A declaration cannot be read.
    #[error("{path}:{line}: `{text}` is not a declaration; write `// @knob name = 0.5 in [0, 1]: What it does.`")]
    Declaration {
        /// The module.
        path: String,
        /// Line, from 1.
        line: usize,
        /// The comment.
        text: String,
    },
    /// A DMF reads more or less than its header says.
    #[error("{path} says that it is {claimed}, and reads what makes it {found}")]
    Kind {
        /// The module.
        path: String,
        /// The kind that its header names.
        claimed: String,
        /// The kind that it is.
        found: String,
    },
    /// Two modules of one program declare the same knob differently.
    #[error("knob `{name}` is declared twice with different defaults; rename it in one of the modules")]
    Twice {
        /// The knob.
        name: String,
    },
    /// A `@move` or `@grow` speaks of what is no knob.
    #[error("`{name}` in a `// @move` or `// @grow` is no knob of the program; declare it with `// @knob`")]
    Unmeasured {
        /// The name.
        name: String,
    },
}

impl Library {
    /// A library of (path, text) pairs.
    pub fn new(sources: impl IntoIterator<Item = (String, String)>) -> Library {
        Library { sources: sources.into_iter().collect() }
    }

    /// The same library with one more module, or with that module replaced.
    pub fn with_module(mut self, slot: &str, name: &str, text: &str) -> Library {
        self.sources.insert(format!("{slot}/{name}.glsl"), text.to_string());
        self
    }

    /// Every file: path relative to the `glsl` folder, and text.
    pub fn sources(&self) -> impl Iterator<Item = (&str, &str)> {
        self.sources.iter().map(|(path, text)| (path.as_str(), text.as_str()))
    }

    /// Text of a file, by its path relative to the `glsl` folder.
    pub fn source(&self, path: &str) -> Option<&str> {
        self.sources.get(path).map(String::as_str)
    }

    /// What a module declares to hold samples of; `None` where it is its own truth.
    ///
    /// # Errors
    /// The module does not exist or has a declaration that cannot be read.
    pub fn exact(&self, slot: &str, name: &str) -> Result<Option<Exact>, LibraryError> {
        let path = self.path(slot, name)?;
        Ok(parse(&path, self.source(&path).unwrap_or_default())?.exact)
    }

    /// Names of the modules of a slot, sorted.
    pub fn modules(&self, slot: &str) -> Vec<&str> {
        let prefix = format!("{slot}/");
        self.sources.keys().filter_map(|path| path.strip_prefix(&prefix)?.strip_suffix(".glsl")).collect()
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
        Ok(needed)
    }

    /// Every file that is reached from `entries`, but for those of further objects.
    ///
    /// # Errors
    /// [`LibraryError::Unknown`].
    pub fn files_reached(&self, entries: &[&str], choice: &Slots) -> Result<Vec<String>, LibraryError> {
        self.files_of("", entries, choice)
    }

    /// Everything that the files reached from `entries` declare; without what further objects declare.
    ///
    /// # Errors
    /// A declaration that cannot be read, two that disagree, or a module that does not exist.
    pub fn declarations(&self, entries: &[&str], choice: &Slots) -> Result<Declarations, LibraryError> {
        self.declared("", entries, choice)
    }

    /// Everything that the modules of a further object declare, under the names that they have in their files.
    ///
    /// # Errors
    /// As [`Library::declarations`].
    pub fn object_declarations(&self, object: &str, choice: &Slots) -> Result<Declarations, LibraryError> {
        self.declared(object, &[OBJECT_ENTRY], choice)
    }

    fn declared(&self, object: &str, entries: &[&str], choice: &Slots) -> Result<Declarations, LibraryError> {
        let mut all = Declarations::default();
        self.visit(object, entries, choice, &mut |path, _| {
            let Some(path) = path else { return Ok(()) };
            let (file, copy) = path.split_once('#').unwrap_or((path, ""));
            let mut one = parse(file, self.source(file).unwrap_or_default())?;
            if is_copy(copy) {
                one.add_suffix(&format!("_{copy}"));
            }
            for knob in one.knobs {
                match all.knobs.iter().find(|known| known.name == knob.name) {
                    None => all.knobs.push(knob),
                    Some(known) if *known == knob => {}
                    Some(_) => return Err(LibraryError::Twice { name: knob.name }),
                }
            }
            all.outer.extend(one.outer);
            all.reach.extend(one.reach);
            all.noise_bound = one.noise_bound.or(all.noise_bound);
            all.needs_normal |= one.needs_normal;
            Ok(())
        })?;
        let names = all.reach.iter_mut().flat_map(Reach::names);
        let unknown = names.map(|name| name.clone()).find(|name| !all.knobs.iter().any(|knob| knob.name == *name));
        unknown.map_or(Ok(all), |name| Err(LibraryError::Unmeasured { name }))
    }

    /// Every file that a further object reaches.
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
            for line in self.text(&path).lines() {
                match include(line) {
                    Some(Include::File(file)) => queue.push(file.to_string()),
                    Some(Include::Slot(KNOBS)) | None => {}
                    Some(Include::Slot(OBJECTS)) => {
                        on(None, Some(OBJECTS))?;
                        queue.push(OBJECT_ENTRY.into());
                    }
                    Some(Include::Slot(slot)) => {
                        let own = choice.get(&format!("{object}.{slot}"));
                        let Some(names) = own.or(choice.get(slot)) else {
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

/// The further objects of a scene, by name.
pub fn objects(choice: &Slots) -> BTreeSet<&str> {
    choice.keys().filter_map(|key| key.split_once('.')).map(|(object, _)| object).collect()
}

/// What a file defines and declares.
pub fn own_names(path: &str, text: &str) -> BTreeSet<String> {
    let declared = parse(path, text).unwrap_or_default().knobs.into_iter().map(|knob| knob.name);
    definitions(text).into_iter().chain(declared).collect()
}

impl Declarations {
    fn add_suffix(&mut self, suffix: &str) {
        let knobs = self.knobs.iter_mut().map(|knob| &mut knob.name);
        let lengths = self.reach.iter_mut().flat_map(Reach::names);
        knobs.chain(&mut self.outer).chain(lengths).for_each(|name| name.push_str(suffix));
    }
}

/// Whether what follows the `#` of a path is the number of a copy.
fn is_copy(tag: &str) -> bool {
    tag.starts_with(|c: char| c.is_ascii_digit())
}

/// Called with the path of a file or with the name of a slot.
type Visitor<'a> = dyn FnMut(Option<&str>, Option<&str>) -> Result<(), LibraryError> + 'a;

/// The slot that the linker fills with the uniform block of all knobs.
pub const KNOBS: &str = "knobs";
/// The slot that the linker fills with all objects of a scene and the classification of what they make together.
pub const OBJECTS: &str = "objects";
/// The key in [`Slots`] of the formula by which the objects make one.
pub const COMBINE: &str = "combine";
/// The slot of the masks: where a DMF acts.
const MASK: &str = "mask";
/// The slot that colors soft matter.
pub const MEDIUM: &str = "medium";
/// What a module of that slot defines: its color and, where it is not 1, how opaque it is against the scene's rate.
pub const MEDIUM_FUNCTIONS: [&str; 2] = [MEDIUM, "extinction"];
/// The file that each object of several is entered by.
pub const OBJECT_ENTRY: &str = "one_of_several.glsl";

/// What an `#include` asks for.
pub enum Include<'a> {
    /// A file of the library.
    File(&'a str),
    /// What fills a slot.
    Slot(&'a str),
}

/// The `#include` of a line.
pub fn include(line: &str) -> Option<Include<'_>> {
    let what = line.trim_start().strip_prefix("#include")?.trim();
    if let Some(file) = what.strip_prefix('"') {
        return file.split_once('"').map(|(file, _)| Include::File(file));
    }
    what.strip_prefix('<')?.split_once('>').map(|(slot, _)| Include::Slot(slot))
}

pub(super) fn parse(path: &str, text: &str) -> Result<Declarations, LibraryError> {
    let (mut found, mut reach) = (Declarations::default(), Reach::default());
    for (index, line) in text.lines().enumerate() {
        let Some(declaration) = line.trim_start().strip_prefix("// @") else { continue };
        let wrong =
            || LibraryError::Declaration { path: path.into(), line: index + 1, text: line.trim_start().to_string() };
        let (kind, rest) = declaration.split_once(' ').ok_or_else(wrong)?;
        match kind {
            "knob" => found.knobs.push(number(rest).ok_or_else(wrong)?),
            "color" => found.knobs.push(color(rest).ok_or_else(wrong)?),
            "outer" => found.outer = vec![identifier(rest).ok_or_else(wrong)?],
            "exact" => {
                let (module, repeat) = rest.trim().split_once(' ').map_or((rest, None), |(a, b)| (a, Some(b)));
                let repeat = repeat.map(|name| identifier(name).ok_or_else(wrong)).transpose()?;
                found.exact = Some(Exact { module: identifier(module).ok_or_else(wrong)?, repeat });
            }
            "needs" if rest.trim() == "normal" => found.needs_normal = true,
            "bound" => found.noise_bound = Some(rest.trim().parse().map_err(|_| wrong())?),
            "move" | "reach" | "grow" => reach.add(kind == "grow", rest).ok_or_else(wrong)?,
            _ => return Err(wrong()),
        }
    }
    found.reach.extend((!reach.is_empty()).then_some(reach));
    Ok(found)
}

fn number(text: &str) -> Option<Knob> {
    let (name, rest) = text.split_once('=')?;
    let (value, rest) = rest.split_once(" in [")?;
    let (range, doc) = rest.split_once("]:")?;
    let (low, high) = range.split_once(',')?;
    let finite = |text: &str| text.trim().parse::<f32>().ok().filter(|value| value.is_finite());
    let (value, low, high) = (finite(value)?, finite(low)?, finite(high)?);
    let valid = low < high && (low..=high).contains(&value);
    valid.then_some(Knob {
        name: identifier(name)?,
        default: Default::Number(value, [low, high]),
        doc: doc.trim().into(),
    })
}

fn color(text: &str) -> Option<Knob> {
    let (name, rest) = text.split_once('=')?;
    let (value, doc) = rest.split_once(": ")?;
    Some(Knob { name: identifier(name)?, default: Default::Color(hex_color(value.trim())?), doc: doc.trim().into() })
}

/// Reads `#rrggbb`.
pub fn hex_color(text: &str) -> Option<[u8; 3]> {
    let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6 && digits.is_ascii())?;
    let channel = |from: usize| u8::from_str_radix(&digits[from..from + 2], 16).ok();
    Some([channel(0)?, channel(2)?, channel(4)?])
}

pub(super) fn identifier(text: &str) -> Option<String> {
    let name = text.trim();
    let valid = name.starts_with(|c: char| c.is_ascii_lowercase())
        && name.chars().all(|c| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_');
    valid.then(|| name.to_string())
}

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
    fn knobs_are_read_with_default_range_and_sentence() {
        let library =
            library(&[("a.frag", "// @knob size = 0.5 in [0, 2]: Size, in cells.\n// @color tint = #ff8000: Tint.")]);
        let found = library.declarations(&["a.frag"], &Slots::new()).unwrap();
        assert_eq!(found.knobs[0].default, Default::Number(0.5, [0.0, 2.0]));
        assert_eq!(found.knobs[0].doc, "Size, in cells.");
        assert_eq!(found.knobs[1].default, Default::Color([255, 128, 0]));
    }

    #[test]
    fn a_bad_declaration_names_file_and_line() {
        for text in ["// @knob x = 3 in [0, 2]: Out of range.", "// @knob Big = 1 in [0, 2]: Upper case.", "// @what x"]
        {
            let library = library(&[("a.frag", &format!("\n{text}"))]);
            let error = library.declarations(&["a.frag"], &Slots::new()).unwrap_err().to_string();
            assert!(error.starts_with("a.frag:2:"), "{error}");
        }
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
