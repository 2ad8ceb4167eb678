//! What can be wrong with modules, their declarations and the programs of them.

use super::combine::FormulaError;

/// Why a library does not give what is asked of it.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
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
    #[error("{path}:{line}: `{text}` is not a declaration; write {allowed}")]
    Declaration {
        /// The module.
        path: String,
        /// Line, from 1.
        line: usize,
        /// The comment.
        text: String,
        /// How it is written.
        allowed: String,
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
    /// Two modules of one program declare the same parameter differently.
    #[error("parameter `{name}` is declared twice with different defaults; rename it in one of the modules")]
    Twice {
        /// The parameter.
        name: String,
    },
    /// There is no such slot.
    #[error("{path}: #include <{slot}>: there is no such slot; docs/modules.md lists them")]
    Slot {
        /// The module.
        path: String,
        /// The name.
        slot: String,
    },
    /// A module includes what does not ship; the compiler says its name behind this.
    #[error(
        "a module can include slots, such as <noise>, and files that ship; put functions of your own into the module: there is \
         nothing"
    )]
    Include,
    /// A `@move`, `@grow` or `@drift` speaks of what is no parameter.
    #[error(
        "{path}: `{name}` in a `// @move`, `// @grow` or `// @drift` is no parameter of the program; declare it with `// @param`"
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
    /// The formula of the objects cannot be read.
    #[error(transparent)]
    Formula(#[from] FormulaError),
    /// glslang refuses the text; the message names module and line.
    #[error("{0}")]
    Compile(String),
    /// glslang ran out of memory.
    #[error("the GLSL compiler has not the memory that this text takes; look at `ulimit -v`")]
    Memory,
    /// The GLSL compiler cannot be started.
    #[error("the GLSL compiler (shaderc) could not be initialized: {0}")]
    Compiler(String),
    /// There is none.
    #[error(
        "no program that ships serves this scene, and there is no GLSL compiler here; build hypertexture with its feature `glsl`"
    )]
    NoCompiler,
}
