//! What can be wrong with a scene.

use crate::support::words::nearest;

/// Why a scene cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SceneError {
    /// A scene file cannot be read.
    #[error("{path}: {reason}")]
    Read {
        /// The file.
        path: String,
        /// What the system says.
        reason: String,
    },
    /// A scene file is not what a scene file must be.
    #[error("{path}:{line}: {reason}")]
    Syntax {
        /// The file.
        path: String,
        /// Line, from 1.
        line: usize,
        /// What is wrong, on one line.
        reason: String,
    },
    /// A value is out of its range.
    #[error("{field} = {value}: {limit}")]
    Value {
        /// The field, as in a scene file.
        field: String,
        /// The value found.
        value: String,
        /// What is allowed.
        limit: String,
    },
    /// A name is not known.
    #[error("no {kind} `{name}`{nearest}{known}")]
    Name {
        /// What was to be named.
        kind: String,
        /// The name found.
        name: String,
        /// The nearest known name, as a question.
        nearest: String,
        /// The known names, or that there are none.
        known: String,
    },
    /// The formula of the objects cannot be read.
    #[error("combine = {0}")]
    Formula(String),
    /// Something is wrong with an additional object.
    #[error("in parts.{0}: {1}")]
    Part(String, Box<SceneError>),
    /// A module is missing or its declarations are wrong.
    #[error(transparent)]
    Library(#[from] crate::shader::LibraryError),
}

impl SceneError {
    /// A name that is not among `known`.
    pub fn unknown(kind: &str, name: &str, known: &[&str]) -> SceneError {
        let nearest = nearest(name, known).map(|near| format!(" (did you mean `{near}`?)")).unwrap_or_default();
        let known = match known {
            [] => format!(": this {} has none", if kind == "parameter" { "effect" } else { "scene" }),
            known => format!("; choose one of: {}", known.join(", ")),
        };
        SceneError::Name { kind: kind.into(), name: name.into(), nearest, known }
    }
}
