//! Errors of modules, declarations and programs.

use super::formula::FormulaError;

/// Errors of a library.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LibraryError {
    /// The module does not exist.
    #[error("no module `{name}` in slot `{slot}`; choose one of: {known}")]
    Unknown {
        /// The slot.
        slot: String,
        /// The name asked for.
        name: String,
        /// The existing modules.
        known: String,
    },
    /// A declaration cannot be read.
    #[error("{path}:{line}: `{text}` is not a declaration; write {allowed}")]
    Declaration {
        /// The module.
        path: String,
        /// Line, from 1.
        line: usize,
        /// The comment.
        text: String,
        /// The expected form.
        allowed: String,
    },
    /// A parameter has a wrong name, default or range.
    #[error("{path}:{line}: the parameter `{name}`: {reason}")]
    Parameter {
        /// The module.
        path: String,
        /// Line, from 1.
        line: usize,
        /// The name in the declaration.
        name: String,
        /// The fault and its remedy.
        reason: String,
    },
    /// The kind of a DMF contradicts its header.
    #[error("{path} claims to be {claimed}, but reads fields that make it {found}")]
    Kind {
        /// The module.
        path: String,
        /// The kind that its header names.
        claimed: String,
        /// The actual kind.
        found: String,
    },
    /// Two modules of one program declare the same parameter differently.
    #[error("parameter `{name}` is declared twice with different defaults; rename it in one of the modules")]
    Twice {
        /// The parameter.
        name: String,
    },
    /// A name of a module is the one that its copy gives to another name.
    #[error("{place}: `{name}` is the name of `{other}` in {of}; rename one of them")]
    Taken {
        /// File and line.
        place: Box<str>,
        /// The name.
        name: Box<str>,
        /// The name that becomes it.
        other: Box<str>,
        /// The copy.
        of: Box<str>,
    },
    /// The slot does not exist.
    #[error("{path}: #include <{slot}>: unknown slot; docs/modules.md lists them")]
    Slot {
        /// The module.
        path: String,
        /// The name.
        slot: String,
    },
    /// An include that is neither a slot nor a shipped file. The compiler appends its name.
    #[error(
        "a module can include slots, such as <noise>, and files that ship; put functions of your own into the module: there is \
         nothing"
    )]
    Include,
    /// A `@move`, `@grow` or `@drift` names something that is not a parameter.
    #[error(
        "{path}: `{name}` in a `// @move`, `// @grow` or `// @drift` is not a parameter of the program; declare it with `// @param`"
    )]
    Unmeasured {
        /// The module.
        path: String,
        /// The name.
        name: String,
    },
}

/// Why a program cannot be linked.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum LinkError {
    /// A module is missing or its declarations are wrong.
    #[error(transparent)]
    Library(#[from] LibraryError),
    /// A syntax error in the formula of the objects.
    #[error(transparent)]
    Formula(#[from] FormulaError),
    /// An error of glslang, with module and line.
    #[error("{0}")]
    Compile(String),
    /// glslang ran out of memory.
    #[error("the GLSL compiler ran out of memory on this text; look at `ulimit -v`")]
    Memory,
    /// The GLSL compiler cannot be initialized.
    #[error("the GLSL compiler (shaderc) could not be initialized: {0}")]
    Compiler(String),
    /// Built without a GLSL compiler.
    #[error(
        "no shipped program fits this scene, and this build has no GLSL compiler; build hypertexture with its feature `glsl`"
    )]
    NoCompiler,
}
