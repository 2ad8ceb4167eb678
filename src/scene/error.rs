//! What can be wrong with a scene.

use support::words::nearest;

/// Why a scene cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
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

/// What TOML's reader says on one line, and the nearest name where one is wrong.
pub(super) fn reason(error: &toml::de::Error) -> String {
    let mut reason = plain(&error.message().replace('\n', " "));
    let mut quoted = error.message().split('`').skip(1).step_by(2);
    if let Some(found) = quoted.next() {
        let known: Vec<&str> = quoted.collect();
        if let Some(near) = nearest(found, &known) {
            reason.push_str(&format!("; did you mean `{near}`?"));
        }
    }
    reason
}

/// What TOML's reader says, without the words of Rust.
fn plain(message: &str) -> String {
    const WORDS: [(&str, &str); 14] = [
        (
            "data did not match any variant of untagged enum ParameterValue",
            "a parameter is a number, or a color such as \"#d9a05f\"",
        ),
        (" as i128", ""),
        ("invalid type: sequence", "a list"),
        ("invalid type: map", "a table"),
        ("a boolean", "true or false"),
        ("invalid type: ", ""),
        ("invalid value: ", ""),
        ("invalid length ", "a list of "),
        ("an array of length", "a list of"),
        ("a sequence", "a list, such as [\"a\", \"b\"]"),
        ("a string", "a text in quotes"),
        ("floating point", "number"),
        ("unknown variant", "unknown value"),
        ("missing field", "there is no"),
    ];
    let mut text = WORDS.iter().fold(message.to_string(), |text, (rust, plain)| text.replace(rust, plain));
    for (rust, plain) in
        [("u32", "a whole number"), ("u64", "a whole number"), ("f32", "a number"), ("f64", "a number")]
    {
        text = text.replace(&format!("expected {rust}"), &format!("expected {plain}"));
    }
    match text.split_once("expected struct ") {
        Some((before, _)) => format!("{before}expected a table"),
        None => text,
    }
}
