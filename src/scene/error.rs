//! Errors of scenes.

use hypertexture_support::words::nearest;

/// Errors of scenes and scene files.
#[allow(missing_docs, reason = "the names of the fields describe them")]
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SceneError {
    /// A scene file cannot be read.
    #[error("{path}: {reason}")]
    Read { path: String, reason: String },
    /// A scene file is malformed.
    #[error("{path}:{line}: {reason}")]
    Syntax { path: String, line: usize, reason: String },
    /// A value is not allowed.
    #[error("{field} = {value}: {limit}")]
    Value { field: String, value: String, limit: String },
    /// A name is unknown.
    #[error("no {kind} `{name}`{nearest}{known}")]
    Name { kind: String, name: String, nearest: String, known: String },
    /// The formula of the objects is malformed.
    #[error("combine = {0}")]
    Formula(String),
    /// Error of an additional object.
    #[error("in parts.{0}: {1}")]
    Part(String, Box<SceneError>),
    /// Error of a module or its declarations.
    #[error(transparent)]
    Library(#[from] crate::shader::LibraryError),
}

impl SceneError {
    /// A value of a field that is not allowed.
    pub(super) fn value(field: impl Into<String>, value: impl ToString, limit: impl Into<String>) -> SceneError {
        SceneError::Value { field: field.into(), value: value.to_string(), limit: limit.into() }
    }

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

/// Message of the TOML parser on one line, with the nearest name for a wrong one.
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

/// Message of the TOML parser without terms of Rust.
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
