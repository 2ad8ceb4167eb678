//! Errors of writing and reading pictures.

use super::ProvenanceError;
use std::io;

/// Errors of writing and reading pictures.
#[allow(missing_docs, reason = "the names of the fields describe them")]
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The file name has no known extension.
    #[error("{path}: cannot tell the format from the name; end it in .png or .exr")]
    Format { path: String },
    /// The picture cannot be encoded.
    #[error("{path}: the picture could not be encoded: {reason}")]
    Encode { path: String, reason: String },
    /// The file cannot be written.
    #[error("{path}: {source}; nothing was written")]
    Write { path: String, source: io::Error },
    /// The file is also written for something else, or read.
    #[error("{file}: {what}; give it a name of its own")]
    Taken { file: String, what: String },
    /// The file cannot be read.
    #[error("{path}: {reason}")]
    Read { path: String, reason: String },
    /// The provenance in the file is missing or wrong.
    #[error("{path}: {source}")]
    Provenance { path: String, source: ProvenanceError },
}
