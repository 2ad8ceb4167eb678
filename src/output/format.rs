//! File formats of pictures.

use super::OutputError;
use std::path::Path;

/// A file format.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum FileFormat {
    Png,
    Exr,
}

impl FileFormat {
    /// The format of a file, by its extension.
    pub(super) fn of(path: &Path) -> Result<FileFormat, OutputError> {
        match path.extension().map(|end| end.to_string_lossy().to_lowercase()).as_deref() {
            Some("png") => Ok(FileFormat::Png),
            Some("exr") => Ok(FileFormat::Exr),
            _ => Err(OutputError::Format { path: path.display().to_string() }),
        }
    }
}
