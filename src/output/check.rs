//! Checks of the files that a command is to write.

use super::OutputError;
use super::format::FileFormat;
use hypertexture_support::{destination, probe};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::io;
use std::path::{Path, PathBuf};

/// Checks that a picture can be written to a file, before anything is computed.
///
/// # Errors
/// An unknown format, or a folder that does not exist.
pub fn check(path: &Path) -> Result<(), OutputError> {
    FileFormat::of(path)?;
    check_folder(path)
}

/// Checks that a file can be written, before anything is computed.
///
/// # Errors
/// The folder is missing or read-only, the name is too long, or something other than a file has this name.
pub fn check_folder(path: &Path) -> Result<(), OutputError> {
    check_all([("", path.into())], [])
}

/// Checks that several files can be written, before anything is computed. Each comes with the flag that names it, such as
/// `-o`. No two may be the same file, and none may be among those that are `read`.
///
/// # Errors
/// Those of [`check_folder`], and [`OutputError::Taken`].
pub fn check_all<'a>(
    written: impl IntoIterator<Item = (&'a str, PathBuf)>,
    read: impl IntoIterator<Item = PathBuf>,
) -> Result<(), OutputError> {
    let read =
        read.into_iter().filter_map(|file| Some((file.canonicalize().ok()?, "this command reads that file".into())));
    let mut taken: HashMap<PathBuf, String> = read.collect();
    let mut folders: HashMap<PathBuf, PathBuf> = HashMap::new();
    for (asked_by, path) in written {
        let fail = |source| OutputError::Write { path: path.display().to_string(), source };
        let none =
            |folder: &Path| io::Error::new(io::ErrorKind::NotFound, format!("there is no folder {}", folder.display()));
        let own = folder(&path);
        if !own.is_dir() {
            return Err(fail(none(&own)));
        }
        let (file, _) = destination(&path).map_err(fail)?;
        let folder = match folders.entry(folder(&file)) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(new) => {
                let found = probe(new.key()).and_then(|()| new.key().canonicalize()).map_err(fail)?;
                new.insert(found)
            }
        };
        let place = folder.join(file.file_name().unwrap_or_default());
        if let Some(what) = taken.insert(place, format!("{asked_by} goes there")) {
            return Err(OutputError::Taken { file: format!("{asked_by} {}", path.display()), what });
        }
    }
    Ok(())
}

fn folder(path: &Path) -> PathBuf {
    path.parent().filter(|parent| !parent.as_os_str().is_empty()).unwrap_or(Path::new(".")).into()
}
