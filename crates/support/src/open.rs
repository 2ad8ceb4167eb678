//! Checked opening of user-named files: only plain files up to a length limit are read. A pipe would block and a device never
//! end. [`Home`] confines the paths inside files from others.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// The UTF-8 byte order mark that some programs write before text.
pub const MARK: &[u8] = b"\xef\xbb\xbf";

/// Why a file is not read. Messages follow its name.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// The file does not exist.
    #[error("there is no such file")]
    Missing,
    /// Permission denied.
    #[error("it may not be read: look at its permissions")]
    Denied,
    /// A folder, a device, a pipe or a socket.
    #[error("it is {0}, not a file")]
    NotAFile(&'static str),
    /// The file exceeds the length limit.
    #[error("{bytes} bytes, and at most {most} are read of such a file; is it the right one?")]
    Long {
        /// Length in bytes.
        bytes: u64,
        /// Limit in bytes.
        most: u64,
    },
    /// Invalid UTF-8 in a line, counted from 1.
    #[error("line {0} is not text in UTF-8; save it as UTF-8")]
    NotText(usize),
    /// Any other I/O error.
    #[error("{0}")]
    Other(io::Error),
}

impl From<io::Error> for OpenError {
    fn from(error: io::Error) -> OpenError {
        match error.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => OpenError::Missing,
            io::ErrorKind::PermissionDenied => OpenError::Denied,
            _ => OpenError::Other(error),
        }
    }
}

impl From<OpenError> for io::Error {
    fn from(error: OpenError) -> io::Error {
        match error {
            OpenError::Other(error) => error,
            other => io::Error::other(other.to_string()),
        }
    }
}

/// The folders that a file from an untrusted source may refer to: its own and the current one, with everything below.
#[derive(Debug)]
pub struct Home(Vec<PathBuf>);

impl Home {
    /// The home of files in a folder.
    pub fn of(folder: &Path) -> Home {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        Home([folder, Path::new(".")].into_iter().filter_map(|folder| folder.canonicalize().ok()).collect())
    }

    /// Whether a path is inside once links are followed. Paths to nothing count as inside.
    pub fn holds(&self, path: &Path) -> bool {
        match path.canonicalize() {
            Ok(path) => self.0.iter().any(|folder| path.starts_with(folder)),
            Err(_) => fs::metadata(path).is_err(),
        }
    }
}

/// Opens a plain file of at most `most` bytes. Returns its length too.
pub fn open(path: &Path, most: u64) -> Result<(File, u64), OpenError> {
    // Checked before opening, which would wait for the writer of a pipe.
    let about = fs::metadata(path)?;
    if !about.is_file() {
        return Err(OpenError::NotAFile(if about.is_dir() { "a directory" } else { "a device, pipe or socket" }));
    }
    super::faults::file("open")?;
    let file = File::open(path)?;
    match file.metadata()?.len() {
        bytes if bytes > most => Err(OpenError::Long { bytes, most }),
        bytes => Ok((file, bytes)),
    }
}

/// Reads a plain file of at most `most` bytes.
pub fn bytes(path: &Path, most: u64) -> Result<Vec<u8>, OpenError> {
    let (file, length) = open(path, most)?;
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(length as usize).map_err(|_| io::Error::from(io::ErrorKind::OutOfMemory))?;
    super::faults::file("read")?;
    file.take(most.saturating_add(1)).read_to_end(&mut bytes)?; // the file may grow meanwhile
    match bytes.len() as u64 {
        bytes if bytes > most => Err(OpenError::Long { bytes, most }),
        _ => Ok(bytes),
    }
}

/// Reads the UTF-8 text of a plain file of at most `most` bytes, without its byte order mark.
pub fn text(path: &Path, most: u64) -> Result<String, OpenError> {
    let mut bytes = bytes(path, most)?;
    if bytes.starts_with(MARK) {
        bytes.drain(..MARK.len());
    }
    String::from_utf8(bytes).map_err(|error| {
        let before = &error.as_bytes()[..error.utf8_error().valid_up_to()];
        OpenError::NotText(1 + before.iter().filter(|byte| **byte == b'\n').count())
    })
}

/// Hash of the content of a plain file.
pub fn hash(path: &Path) -> Result<blake3::Hash, OpenError> {
    let mut hash = blake3::Hasher::new();
    hash.update_reader(open(path, u64::MAX)?.0)?;
    Ok(hash.finalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_plain_files_within_the_limit_are_read() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("text"), "one\ntwo").unwrap();
        fs::write(at("binary"), b"one\n\xff").unwrap();
        assert_eq!(text(&at("text"), 7).unwrap(), "one\ntwo");
        fs::write(at("marked"), "\u{feff}one").unwrap();
        assert_eq!(text(&at("marked"), 7).unwrap(), "one");
        for (file, most, found) in [
            ("text", 6, "7 bytes, and at most 6"),
            ("binary", 99, "line 2 is not text"),
            ("none", 99, "there is no such file"),
            ("text/none", 99, "there is no such file"),
            ("", 99, "it is a directory, not a file"),
        ] {
            let error = text(&at(file), most).unwrap_err().to_string();
            assert!(error.starts_with(found), "{file}: {error}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn pipes_and_devices_are_refused_at_once() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        for path in [&*pipe, Path::new("/dev/zero")] {
            assert!(matches!(bytes(path, 99), Err(OpenError::NotAFile("a device, pipe or socket"))));
        }
    }
}
