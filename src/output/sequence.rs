//! Sequences: numbered pictures of one scene in motion, and their progress.
//!
//! Role: the scene and the file name of each frame, and the manifest beside the frames, from which a stopped rendering
//! resumes. Invariant: a frame is finished only if its line in the manifest is complete and its file has the hash of the
//! line; the line is written after the file.

use crate::output::shard::Shard;
use crate::scene::{Animation, Scene};
use hypertexture_support::open::{self, OpenError};
use hypertexture_support::{may_fail, write_whole};
use std::collections::BTreeMap;
use std::fs::{File, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::str::FromStr;

/// Highest frame number.
const MAX_FRAME: u32 = 9_999_999;
/// Size limit of a manifest, bytes: 100 for each possible frame.
const MAX_BYTES: u64 = 1 << 30;
/// Digits of a frame number if the name has no `#`.
const DIGITS: usize = 4;
/// Start of a manifest, before the identity of the sequence.
const TITLE: &str = "hypertexture-frames 1 ";

/// Errors of sequences.
#[allow(missing_docs, reason = "the names of the fields describe them")]
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum SequenceError {
    /// Malformed range of frames.
    #[error("write A..B, the numbers of the first and the last frame, from 0 to {MAX_FRAME}, such as 1..100")]
    Range,
    /// Frame rate out of range.
    #[error("--fps {0}: must be from 0.001 to 1000 frames per second")]
    Rate(f64),
    /// A manifest or frame cannot be read or written.
    #[error("{path}: {source}")]
    File { path: String, source: io::Error },
    /// The manifest belongs to something else.
    #[error("{path} {what}; give another --output, or --restart to render every frame again")]
    Foreign { path: String, what: &'static str },
}

/// A range of frame numbers that includes both ends, as in Blender's `-f 1..100`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Frames {
    /// First frame.
    pub first: u32,
    /// Last frame, at least `first`.
    pub last: u32,
}

impl FromStr for Frames {
    type Err = SequenceError;

    /// Reads `A..B`.
    fn from_str(text: &str) -> Result<Frames, SequenceError> {
        let parsed = text.split_once("..").and_then(|(first, last)| Some((first.parse().ok()?, last.parse().ok()?)));
        match parsed {
            Some((first, last)) if first <= last && last <= MAX_FRAME => Ok(Frames { first, last }),
            _ => Err(SequenceError::Range),
        }
    }
}

/// A scene in motion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sequence {
    /// Frames.
    pub frames: Frames,
    /// Frames per second, 0.001 to 1000.
    pub fps: f64,
    /// Whether the camera circles the object once in equal steps, so that the frame after the last would equal the first.
    pub turntable: bool,
}

impl Sequence {
    /// Checks the frame rate.
    ///
    /// # Errors
    /// [`SequenceError::Rate`].
    pub fn check(&self) -> Result<(), SequenceError> {
        if (0.001..=1000.0).contains(&self.fps) { Ok(()) } else { Err(SequenceError::Rate(self.fps)) }
    }

    /// The scene of frame k. Adds k / fps seconds to the time of `scene` and, with a turntable,
    /// 360 (k - first) / (last - first + 1) degrees to its azimuth.
    pub fn scene(&self, scene: &Scene, frame: u32) -> Scene {
        let mut moved = scene.clone();
        moved.camera.time = scene.camera.time + f64::from(frame) / self.fps;
        if self.turntable {
            let Frames { first, last } = self.frames;
            let part = f64::from(frame - first) / f64::from(last - first + 1);
            moved.camera.azimuth = (f64::from(scene.camera.azimuth) + 360.0 * part) as f32;
            if scene.camera.rotation.is_some() {
                let around = glam::Quat::from_rotation_y((-std::f64::consts::TAU * part) as f32);
                moved.camera.rotation = Some((scene.camera.turn() * around).normalize().to_array());
            }
        }
        moved
    }

    /// Hash of everything that determines the pixels of a frame besides its number. `scene` is the identity of the scene at
    /// rest, `depth` the bits of a channel. The range of frames is included only for a turntable, so that other sequences can
    /// be extended.
    pub fn identity(&self, scene: blake3::Hash, animation: &Animation, depth: &str) -> blake3::Hash {
        let range = self.turntable.then_some(self.frames);
        let moves = (!animation.tracks.is_empty()).then(|| toml::to_string(animation));
        blake3::hash(
            format!("{scene} {} {range:?} {depth}{}", self.fps, moves.and_then(Result::ok).unwrap_or_default())
                .as_bytes(),
        )
    }
}

/// File of a frame. Its number replaces the last run of `#` in the name, with at least as many digits; without a `#` it
/// precedes the extension with at least 4 digits.
pub fn frame_path(output: &Path, frame: u32) -> PathBuf {
    let (before, digits, after) = parts(output);
    output.with_file_name(format!("{before}{frame:0digits$}{after}"))
}

/// A line about files of frames whose names do not sort by their number, if there are any.
pub fn unsorted(output: &Path, Frames { first, last }: Frames) -> Option<String> {
    let (before, digits, after) = parts(output);
    let [shortest, longest] = [first, last].map(|frame| frame.to_string().len().max(digits));
    (shortest < longest).then(|| {
        let hashes = "#".repeat(longest);
        format!(
            "{before}{first:0digits$}{after} to {before}{last:0digits$}{after} do not sort by their number; {before}{hashes}{after} does"
        )
    })
}

/// The name of a file of a frame: the part before its number, the fewest digits of that, and the part after it.
fn parts(output: &Path) -> (String, usize, String) {
    let name = output.file_name().unwrap_or_default().to_string_lossy();
    match name.rfind('#') {
        Some(end) => {
            let before = name[..=end].trim_end_matches('#');
            (before.to_string(), end + 1 - before.len(), name[end + 1..].to_string())
        }
        None => {
            let stem = output.file_stem().unwrap_or_default().to_string_lossy();
            (format!("{stem}_"), DIGITS, name[stem.len()..].to_string())
        }
    }
}

/// File of the manifest of the frames `output`, or of one shard of them: beside the frames and named after them.
pub fn manifest_path(output: &Path, shard: Option<Shard>) -> PathBuf {
    let name = output.file_name().unwrap_or_default().to_string_lossy().replace('#', "");
    let shard = shard.map_or(String::new(), |shard| format!(".{}", shard.suffix()));
    output.with_file_name(format!("{name}{shard}.frames"))
}

/// List of the finished frames: a text file with the identity of the sequence in the first line, and a line for each frame
/// with its number, the BLAKE3 hash of its file, and the name of the file.
#[derive(Debug)]
pub struct Manifest {
    path: PathBuf,
    file: File,
    done: BTreeMap<u32, (blake3::Hash, String)>,
}

impl Manifest {
    /// Opens or creates the manifest of a sequence; `restart` empties it. Incomplete lines, as after a crash, are dropped.
    ///
    /// # Errors
    /// [`SequenceError::Foreign`] for the manifest of another sequence or another kind of file, or an error of the system.
    pub fn open(path: &Path, identity: blake3::Hash, restart: bool) -> Result<Manifest, SequenceError> {
        let name = path.display().to_string();
        let failed = |source| SequenceError::File { path: name.clone(), source };
        let title = format!("{TITLE}{identity}\n");
        let text = match open::bytes(path, MAX_BYTES) {
            _ if restart => title.clone(),
            Err(OpenError::Missing) => title.clone(),
            read => String::from_utf8_lossy(&read.map_err(|error| failed(error.into()))?).into_owned(),
        };
        let foreign = |what| SequenceError::Foreign { path: name.clone(), what };
        if !text.starts_with(TITLE) {
            return Err(foreign("is not a manifest of frames"));
        }
        let lines = text.strip_prefix(&title).ok_or_else(|| {
            foreign("is of another scene, object, rate, depth or version: its frames do not go with these")
        })?;
        let done: BTreeMap<_, _> = lines.split_inclusive('\n').filter_map(finished).collect();
        let lines = done.iter().map(|(frame, (hash, name))| line(*frame, hash, name));
        let clean = std::iter::once(title.clone()).chain(lines).collect::<String>();
        write_whole(path, clean.as_bytes()).map_err(failed)?;
        may_fail("append").map_err(failed)?;
        let file = OpenOptions::new().append(true).open(path).map_err(failed)?;
        Ok(Manifest { path: path.into(), file, done })
    }

    /// Whether the file of a frame exists unchanged.
    pub fn has(&self, frame: u32, path: &Path) -> bool {
        let own = |name: &str| path.file_name().is_some_and(|file| file == name);
        match self.done.get(&frame) {
            Some((hash, name)) if own(name) => open::hash(path).is_ok_and(|found| found == *hash),
            _ => false,
        }
    }

    /// Records a finished frame. The line is on disk when this returns.
    ///
    /// # Errors
    /// An error of the system.
    pub fn add(&mut self, frame: u32, path: &Path) -> Result<(), SequenceError> {
        let failed = |path: &Path| {
            let path = path.display().to_string();
            move |source| SequenceError::File { path, source }
        };
        let hash = open::hash(path).map_err(|error| failed(path)(error.into()))?;
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let written = may_fail("write")
            .and_then(|()| self.file.write_all(line(frame, &hash, &name).as_bytes()))
            .and_then(|()| self.file.sync_data());
        written.map_err(failed(&self.path))?;
        self.done.insert(frame, (hash, name));
        Ok(())
    }
}

fn line(frame: u32, hash: &blake3::Hash, name: &str) -> String {
    format!("{frame} {hash} {name}\n")
}

/// Parses a complete line.
fn finished(line: &str) -> Option<(u32, (blake3::Hash, String))> {
    let mut parts = line.strip_suffix('\n')?.splitn(3, ' ');
    let frame = parts.next()?.parse().ok()?;
    let hash = blake3::Hash::from_hex(parts.next()?).ok()?;
    Some((frame, (hash, parts.next()?.to_string())))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;

    #[test]
    fn numbers_replace_the_last_hashes_or_precede_the_extension() {
        let name = |pattern: &str, frame| frame_path(Path::new(pattern), frame).display().to_string();
        assert_eq!(name("frames/fire_####.png", 7), "frames/fire_0007.png");
        assert_eq!(name("a#b_##.exr", 123), "a#b_123.exr");
        assert_eq!(name("d#/fire.png", 12345), "d#/fire_12345.png");
        assert_eq!(name("fire.png", 0), "fire_0000.png");
        assert_eq!(manifest_path(Path::new("f/a_##.png"), Shard::new(1, 3)), Path::new("f/a_.png.shard-1-of-3.frames"));
    }

    #[test]
    fn names_with_numbers_of_different_lengths_are_told() {
        let told = |pattern: &str, first, last| unsorted(Path::new(pattern), Frames { first, last });
        let line = "over_8.png to over_11.png do not sort by their number; over_##.png does";
        assert_eq!(told("f/over_#.png", 8, 11).as_deref(), Some(line));
        let line = "a_9999.png to a_10000.png do not sort by their number; a_#####.png does";
        assert_eq!(told("a.png", 9999, 10000).as_deref(), Some(line));
        for (pattern, first, last) in [("a_#.png", 0, 9), ("a_#.png", 10, 99), ("a_##.png", 0, 99), ("a.png", 0, 9999)]
        {
            assert_eq!(told(pattern, first, last), None, "{pattern}");
        }
    }

    #[test]
    fn a_range_holds_its_first_and_its_last_frame() {
        assert_eq!("3..3".parse::<Frames>().unwrap(), Frames { first: 3, last: 3 });
        for wrong in ["3", "4..3", "0..10000000", "a..b", "-1..2", "1...2", "1..=2", ""] {
            assert!(wrong.parse::<Frames>().is_err(), "{wrong}");
        }
    }

    #[test]
    fn a_turntable_comes_around_without_showing_a_view_twice() {
        let mut scene = Scene::default();
        (scene.camera.azimuth, scene.camera.time) = (10.0, 2.0);
        let sequence = Sequence { frames: Frames { first: 5, last: 8 }, fps: 10.0, turntable: true };
        let cameras = [5, 6, 8].map(|frame| sequence.scene(&scene, frame).camera);
        assert_eq!(cameras.clone().map(|camera| camera.azimuth), [10.0, 100.0, 280.0]);
        assert_eq!(cameras.map(|camera| camera.time), [2.5, 2.6, 2.8]);
    }

    #[test]
    fn half_a_line_is_not_believed_and_another_sequence_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let [path, frame] = ["out.png.frames", "out_0001.png"].map(|name| folder.path().join(name));
        let own = blake3::hash(b"own");
        fs::write(&frame, "pixels").unwrap();
        let mut manifest = Manifest::open(&path, own, false).unwrap();
        assert!(!manifest.has(1, &frame));
        manifest.add(1, &frame).unwrap();
        let whole = fs::read(&path).unwrap();
        for cut in TITLE.len() + 65..whole.len() {
            fs::write(&path, &whole[..cut]).unwrap();
            let mut again = Manifest::open(&path, own, false).unwrap();
            assert!(!again.has(1, &frame), "cut at {cut}");
            again.add(1, &frame).unwrap();
            assert_eq!(fs::read(&path).unwrap(), whole);
        }
        assert!(Manifest::open(&path, own, false).unwrap().has(1, &frame));
        fs::write(&frame, "pixel").unwrap();
        assert!(!Manifest::open(&path, own, false).unwrap().has(1, &frame));
        let error = Manifest::open(&path, blake3::hash(b"other"), false).unwrap_err().to_string();
        assert!(error.contains("another scene") && error.contains("--restart"), "{error}");
        assert!(Manifest::open(&frame, own, false).unwrap_err().to_string().contains("not a manifest"));
        assert!(!Manifest::open(&path, blake3::hash(b"other"), true).unwrap().has(1, &frame));
    }
}
