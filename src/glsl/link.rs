//! Linking: an entry file and the modules chosen for its slots become one SPIR-V module.
//!
//! `#include "file"` takes a file of the library, once; `#include <slot>` takes the modules chosen for that slot and,
//! for a stack, a function that applies them in order; `#include <knobs>` takes the uniform block of every knob that
//! the program declares. Errors name the module and the line, since glslang sees each module under its own name.
//!
//! SPIR-V for Vulkan cannot import functions, so this is what "program objects linked to swap functions" (MJ 3)
//! becomes: the same text, a different file in one slot.

use super::library::{Default, KNOBS, Library, LibraryError, Slots};
use std::cell::RefCell;
use std::collections::BTreeSet;
use std::fmt::Write;

/// Shader stage of an entry file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stage {
    /// Vertex shader.
    Vertex,
    /// Fragment shader.
    Fragment,
}

/// Why a program cannot be linked.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum LinkError {
    /// A module is missing or its declarations are wrong.
    #[error(transparent)]
    Library(#[from] LibraryError),
    /// glslang refuses the text; the message names module and line.
    #[error("{0}")]
    Compile(String),
    /// The GLSL compiler cannot be started.
    #[error("the GLSL compiler (shaderc) could not be initialized: {0}")]
    Compiler(String),
}

/// Slots that hold a stack: the signature of the function that applies it, and how one module is called.
const STACKS: [(&str, &str, &str, &str); 2] = [
    ("warp", "void displace(inout vec3 x, inout mat3 jacobian)", "    MODULE(x, jacobian);\n", ""),
    ("dmf", "float modulate(float density, Sample s)", "    density = MODULE(density, s);\n", "    return density;\n"),
];

/// A GLSL compiler, made once: glslang's start costs far more than a program.
pub struct Linker {
    compiler: shaderc::Compiler,
}

impl Linker {
    /// Starts the compiler.
    ///
    /// # Errors
    /// [`LinkError::Compiler`] when shaderc cannot be initialized.
    pub fn new() -> Result<Linker, LinkError> {
        let compiler = shaderc::Compiler::new().map_err(|error| LinkError::Compiler(error.to_string()))?;
        Ok(Linker { compiler })
    }

    /// Links `entry` (a file of `library`) with the modules in `slots` to SPIR-V 1.3 with names.
    /// `knobs_of` lists every entry of the pipeline, so that all its stages share one knob block.
    ///
    /// # Errors
    /// A missing module, a bad declaration, or what glslang says.
    pub fn link(
        &self,
        library: &Library,
        (entry, stage): (&str, Stage),
        knobs_of: &[&str],
        slots: &Slots,
    ) -> Result<Vec<u32>, LinkError> {
        let text = library.source(entry).ok_or_else(|| LibraryError::Unknown {
            slot: "entry".into(),
            name: entry.into(),
            known: "slice.vert, slice.frag".into(),
        })?;
        let knobs = knob_block(library, knobs_of, slots)?;
        let included = RefCell::new(BTreeSet::new());
        let compiler = |error: shaderc::Error| LinkError::Compiler(error.to_string());
        let mut options = shaderc::CompileOptions::new().map_err(compiler)?;
        options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_1 as u32);
        options.set_optimization_level(shaderc::OptimizationLevel::Performance);
        options.set_generate_debug_info();
        options.set_warnings_as_errors();
        options.set_include_callback(|name, kind, _, _| {
            let (resolved_name, content) = match kind {
                shaderc::IncludeType::Relative => {
                    let content = library.source(name).ok_or_else(|| format!("no file `{name}` in the library"))?;
                    (name.to_string(), content.to_string())
                }
                shaderc::IncludeType::Standard if name == KNOBS => ("knobs".to_string(), knobs.clone()),
                shaderc::IncludeType::Standard => fill(library, name, slots).map_err(|error| error.to_string())?,
            };
            let first = included.borrow_mut().insert(resolved_name.clone());
            Ok(shaderc::ResolvedInclude { resolved_name, content: if first { content } else { String::new() } })
        });
        let kind = match stage {
            Stage::Vertex => shaderc::ShaderKind::Vertex,
            Stage::Fragment => shaderc::ShaderKind::Fragment,
        };
        match self.compiler.compile_into_spirv(text, kind, entry, "main", Some(&options)) {
            Ok(artifact) => Ok(artifact.as_binary().to_vec()),
            Err(shaderc::Error::CompilationError(_, message)) => {
                Err(LinkError::Compile(message.trim_end().to_string()))
            }
            Err(error) => Err(LinkError::Compile(error.to_string())),
        }
    }
}

/// Name and text of what fills a slot.
fn fill(library: &Library, slot: &str, slots: &Slots) -> Result<(String, String), LibraryError> {
    let names = slots.get(slot).map(Vec::as_slice).unwrap_or_default();
    if let Some((_, signature, call, end)) = STACKS.iter().find(|stack| stack.0 == slot) {
        let mut glue = String::new();
        let mut calls = String::new();
        for name in names {
            let path = library.path(slot, name)?;
            writeln!(glue, "#include \"{path}\"").expect("writing to a string");
            calls.push_str(&call.replace("MODULE", name));
        }
        writeln!(glue, "{signature} {{\n{calls}{end}}}").expect("writing to a string");
        return Ok((format!("stack of {slot}"), glue));
    }
    let path = library.path(slot, names.first().map(String::as_str).unwrap_or_default())?;
    let content = library.source(&path).unwrap_or_default().to_string();
    Ok((path, content))
}

/// The uniform block of every knob of a program; empty where it has none.
fn knob_block(library: &Library, entries: &[&str], slots: &Slots) -> Result<String, LibraryError> {
    let knobs = library.declarations(entries, slots)?.knobs;
    if knobs.is_empty() {
        return Ok(String::new());
    }
    let mut block = String::from("layout(set = 0, binding = 2) uniform Knobs {\n");
    for knob in &knobs {
        let kind = match knob.default {
            Default::Number(..) => "float",
            Default::Color(_) => "vec4",
        };
        writeln!(block, "    {kind} {};", knob.name).expect("writing to a string");
    }
    block.push_str("};\n");
    Ok(block)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn slots(pairs: &[(&str, &[&str])]) -> Slots {
        pairs.iter().map(|(slot, names)| (slot.to_string(), names.iter().map(|n| n.to_string()).collect())).collect()
    }

    fn library(dmf: &str) -> Library {
        let entry = "#version 450\n#include <knobs>\nstruct Sample { vec3 x; };\n#include <dmf>\n\
                     layout(location = 0) out vec4 color;\nvoid main() { color = vec4(modulate(1.0, Sample(vec3(0.0)))); }";
        Library::new([("a.frag".to_string(), entry.to_string()), ("dmf/one.glsl".to_string(), dmf.to_string())])
    }

    fn link(library: &Library, names: &[&str]) -> Result<Vec<u32>, LinkError> {
        let entry = ("a.frag", Stage::Fragment);
        Linker::new().unwrap().link(library, entry, &["a.frag"], &slots(&[("dmf", names)]))
    }

    #[test]
    fn a_stack_calls_its_modules_in_order() {
        let (name, glue) =
            fill(&library("").with_module("dmf", "two", ""), "dmf", &slots(&[("dmf", &["one", "two"])])).unwrap();
        assert_eq!(name, "stack of dmf");
        let one = glue.find("density = one(density, s)").unwrap();
        assert!(one < glue.find("density = two(density, s)").unwrap());
    }

    #[test]
    fn an_empty_stack_is_the_identity() {
        assert!(link(&library(""), &[]).is_ok());
    }

    #[test]
    fn an_error_names_the_module_and_its_line() {
        let error = link(&library("float one(float density, Sample s) {\n    return qq;\n}"), &["one"]).unwrap_err();
        assert!(error.to_string().contains("dmf/one.glsl:2: error: 'qq'"), "{error}");
    }

    #[test]
    fn a_knob_is_a_member_of_the_block_under_its_bare_name() {
        let module =
            "// @knob size = 1 in [0, 2]: Size.\nfloat one(float density, Sample s) { return size * density; }";
        assert!(link(&library(module), &["one"]).is_ok());
    }
}
