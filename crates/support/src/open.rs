//! Files that people name, opened in one place: what is no plain file, or longer than anything that is looked for there, is
//! refused before it is read. A pipe would wait for its writer, and a device never ends. [`Home`] says which files others may
//! name.

use std::fs::{self, File};
use std::io::{self, Read};
use std::path::{Path, PathBuf};

/// The byte order mark that some programs write before text in UTF-8; no part of the text.
pub const MARK: &[u8] = b"\xef\xbb\xbf";

/// Why a file is not read; the words that come behind its name.
#[derive(Debug, thiserror::Error)]
pub enum OpenError {
    /// Nothing has this name.
    #[error("there is no such file")]
    Missing,
    /// Its permissions, or those of a folder above it, forbid it.
    #[error("it may not be read: look at its permissions")]
    Denied,
    /// A folder, a device, a pipe or a socket.
    #[error("it is {0}, not a file")]
    NotAFile(&'static str),
    /// It is longer than any such file.
    #[error("{bytes} bytes, and at most {most} are read of such a file; is it the right one?")]
    Long {
        /// Its length.
        bytes: u64,
        /// The longest that is read.
        most: u64,
    },
    /// A line, from 1, that is not UTF-8.
    #[error("line {0} is not text in UTF-8; save it as UTF-8")]
    NotText(usize),
    /// Any other error of the system.
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

/// Where the files are that a file may name which somebody else may have written: below its folder, and below the current one.
#[derive(Debug)]
pub struct Home(Vec<PathBuf>);

impl Home {
    /// Of the files in a folder.
    pub fn of(folder: &Path) -> Home {
        let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
        Home([folder, Path::new(".")].into_iter().filter_map(|folder| folder.canonicalize().ok()).collect())
    }

    /// Whether a path stays there once all links are followed; one that leads to nothing does.
    pub fn holds(&self, path: &Path) -> bool {
        match path.canonicalize() {
            Ok(path) => self.0.iter().any(|folder| path.starts_with(folder)),
            Err(_) => fs::metadata(path).is_err(),
        }
    }
}

/// A plain file of at most `most` bytes, and its length.
pub fn open(path: &Path, most: u64) -> Result<(File, u64), OpenError> {
    // Before it is opened: that would wait for the writer of a pipe.
    let about = fs::metadata(path)?;
    if !about.is_file() {
        return Err(OpenError::NotAFile(if about.is_dir() { "a directory" } else { "a device, pipe or socket" }));
    }
    super::may_fail("open")?;
    let file = File::open(path)?;
    match file.metadata()?.len() {
        bytes if bytes > most => Err(OpenError::Long { bytes, most }),
        bytes => Ok((file, bytes)),
    }
}

/// All of a plain file of at most `most` bytes.
pub fn bytes(path: &Path, most: u64) -> Result<Vec<u8>, OpenError> {
    let (file, length) = open(path, most)?;
    let mut bytes = Vec::new();
    bytes.try_reserve_exact(length as usize).map_err(|_| io::Error::from(io::ErrorKind::OutOfMemory))?;
    super::may_fail("read")?;
    file.take(most.saturating_add(1)).read_to_end(&mut bytes)?; // it may grow meanwhile
    match bytes.len() as u64 {
        bytes if bytes > most => Err(OpenError::Long { bytes, most }),
        _ => Ok(bytes),
    }
}

/// The text of a plain file of at most `most` bytes, without its byte order mark.
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

/// The hash of what is in a plain file.
pub fn hash(path: &Path) -> Result<blake3::Hash, OpenError> {
    let mut hash = blake3::Hasher::new();
    hash.update_reader(open(path, u64::MAX)?.0)?;
    Ok(hash.finalize())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_no_plain_file_of_the_right_kind_is_refused_before_it_is_read() {
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
    fn a_pipe_and_a_device_do_not_keep_anybody_waiting() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        for path in [&*pipe, Path::new("/dev/zero")] {
            assert!(matches!(bytes(path, 99), Err(OpenError::NotAFile("a device, pipe or socket"))));
        }
    }
}
