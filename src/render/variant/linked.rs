//! Disk cache of linked programs, which glslang takes up to a second to link.

use super::error::VariantError;
use super::program::{Program, shipped_programs};
use super::scene_variant::Variant;
use crate::shader::compile::{CompileError, Job, Limits, compile, link, names};
use crate::shader::library::Compiler;
use crate::shader::{self, Library, LinkError, Linker, Slots, Stage};
use hypertexture_support::disk_cache::{self, CacheKind};
use std::collections::BTreeMap;

/// SPIR-V of the vertex stage and the fragment stage.
type Stages = [Vec<u32>; 2];

/// A few thousand programs.
const KIND: CacheKind = CacheKind { ends: &["program"], limit: 256 << 20 };

impl Variant {
    /// Links both stages, or loads them from the disk cache.
    pub(super) fn linked(
        &self,
        library: &Library,
        is_optimized: bool,
        linker: impl FnOnce() -> Result<Linker, LinkError>,
    ) -> Result<Stages, VariantError> {
        let entries = self.entries;
        let apart = self.apart(library, is_optimized);
        let key = self::key(library, entries, &self.slots, (is_optimized, apart.is_some()));
        if let Some(stages) = load(key) {
            return Ok(stages);
        }
        let stages = match apart {
            Some(job) => link_under_limits(library.compiler(), &job)?,
            None => {
                let linker = linker()?;
                let link = |entry| linker.link(library, entry, Stage::of(entry), &entries, &self.slots);
                [link(entries[0])?, link(entries[1])?]
            }
        };
        save(key, &stages);
        Ok(stages)
    }

    /// Hash of all that determines the linked program, without linking it.
    pub(crate) fn text_hash(&self, library: &Library) -> blake3::Hash {
        key(library, self.entries, &self.slots, (true, false))
    }

    /// Links the modules with a library of generated texts, see [`Variant::with_own`].
    ///
    /// # Errors
    /// As [`Variant::program`].
    pub fn program_of(&self, library: &Library, own: Library) -> Result<Program, VariantError> {
        self.program(&self.with_own(library, own), Linker::new)
    }

    /// A library with generated texts in place of some of `library`. It is compiled in a separate process only if
    /// `library` asks for that.
    pub fn with_own(&self, library: &Library, own: Library) -> Library {
        if self.apart(library, true).is_some() { own } else { own.compiled_here() }
    }

    /// Request to link both stages under limits, if the library asks for that and a reached text is not as shipped.
    fn apart(&self, library: &Library, is_optimized: bool) -> Option<Job> {
        if matches!(library.compiler(), Compiler::Here) {
            return None;
        }
        let mut changed = shader::changed(library);
        changed.retain(|path, _| self.reaches(library, path));
        (!changed.is_empty()).then(|| self.job(changed, is_optimized))
    }

    /// Request for [`compile`].
    pub fn job(&self, changed: BTreeMap<String, String>, is_optimized: bool) -> Job {
        Job { changed, entries: self.entries.map(String::from), slots: Slots::clone(&self.slots), is_optimized }
    }
}

/// Links a job in a child, or in this process if it has limits.
fn link_under_limits(compiler: &Compiler, job: &Job) -> Result<Stages, LinkError> {
    let Compiler::Apart(program) = compiler else { return link(job) };
    compile(program, job, &Limits::default(), &|| false).map_err(|error| match error {
        // These messages name the text.
        CompileError::Refused(_) | CompileError::Long { .. } => LinkError::Compile(error.to_string()),
        other => LinkError::Compile(format!("{}: {other}", names(&job.changed))),
    })
}

/// Hash of all that determines the words of a program. The largest shipped program identifies the compiler version.
/// `how`: whether the program is optimized, and whether it was linked under limits.
fn key(library: &Library, entries: [&str; 2], slots: &Slots, how: (bool, bool)) -> blake3::Hash {
    let mut hash = blake3::Hasher::new();
    let compiler = shipped_programs().iter().max_by_key(|program| program.2.len());
    for part in compiler.into_iter().flat_map(|(_, vertex, fragment)| [vertex, fragment]) {
        hash.update(part);
    }
    for (path, text) in library.sources() {
        hash.update(format!("{path} {}\n", text.len()).as_bytes()).update(text.as_bytes());
    }
    hash.update(format!("{entries:?} {slots:?} {how:?}").as_bytes());
    hash.finalize()
}

fn load(key: blake3::Hash) -> Option<Stages> {
    let bytes = disk_cache::load(KIND, key)?;
    let (words, rest) = bytes.as_chunks::<4>();
    let words: Vec<u32> = words.iter().map(|word| u32::from_le_bytes(*word)).collect();
    let (&first, stages) = words.split_first()?;
    let (vertex, fragment) = stages.split_at_checked(first as usize)?;
    rest.is_empty().then(|| [vertex.to_vec(), fragment.to_vec()])
}

fn save(key: blake3::Hash, [vertex, fragment]: &Stages) {
    let words = [vertex.len() as u32].into_iter().chain(vertex.iter().chain(fragment).copied());
    disk_cache::save(KIND, key, &words.flat_map(u32::to_le_bytes).collect::<Vec<u8>>());
}

#[cfg(all(test, feature = "glsl"))]
mod tests {
    use super::super::program::words;
    use super::*;
    use crate::shader::compile::refusal;

    #[test]
    fn shipped_texts_are_linked_here_and_custom_ones_by_a_child() {
        let mut scene = crate::scene::preset("noisy_sphere").unwrap();
        let shipped = shader::shipped().compiled_by(std::path::Path::new("no such program"));
        let own = |library: &Library, variant: &Variant| {
            let mut reached = library.sources().filter(|(path, _)| variant.reaches(library, path));
            let (path, text) = reached.next().unwrap();
            library.clone().with_file(path, &format!("{text}// of the program itself\n"))
        };
        let variant = Variant::of(&scene, &shipped).unwrap();
        assert!(variant.program(&own(&shipped, &variant), Linker::new).is_err());
        assert!(variant.program_of(&shipped, own(&shipped, &variant)).is_ok());
        let text = "float modulate(float density, inout Sample s) { return 0.5 * density; }\n";
        let persons = shipped.with_module("dmf", "halved", text);
        scene.effect.dmf = vec!["halved".into()];
        let variant = Variant::of(&scene, &persons).unwrap();
        let refused = variant.program_of(&persons, own(&persons, &variant)).unwrap_err().to_string();
        assert!(refused.contains("dmf/halved.glsl"), "{refused}");
    }

    #[test]
    fn every_program_that_ships_asks_for_no_more_than_a_person_may() {
        for (key, vertex, fragment) in shipped_programs() {
            for stage in [vertex, fragment] {
                assert_eq!(refusal(&words(stage).unwrap(), &BTreeMap::new()), None, "{key}");
            }
        }
    }
}
