//! Pictures on disk.
//!
//! Role: a [`Frame`] into a PNG (8 or 16 bits, straight alpha, sRGB) or an OpenEXR file (32-bit float, premultiplied
//! linear, as that format has it), with its [`Provenance`]; and both back. Invariant: a file appears whole or not at
//! all: it is written beside its place under a temporary name, synced and renamed.

mod map;
mod provenance;
mod read;
pub mod sequence;
pub mod shard;

pub use map::write_map;
pub use provenance::{Provenance, ProvenanceError};
pub use read::{Encoding, Stored, read, read_provenance, size};

use crate::render::Frame;
use crate::scene::{Color, linear_to_srgb};
use exr::image::write::WritableImage;
use exr::image::{Image, SpecificChannels};
use exr::math::Vec2;
use exr::meta::attribute::{AttributeValue, Text};
use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::io::{self, Cursor};
use std::path::{Path, PathBuf};
use support::{destination, probe, write_whole};

/// Name and version of this program.
pub const PROGRAM: &str = concat!("hypertexture ", env!("CARGO_PKG_VERSION"));

/// Bits of each channel of a PNG.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Depth {
    /// 8 bits.
    #[default]
    Eight,
    /// 16 bits.
    Sixteen,
}

/// Why a picture is not on disk, or cannot be had from there.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum OutputError {
    /// The file name does not say which format to write.
    #[error("{path}: cannot tell the format from the name; end it in .png or .exr")]
    Format {
        /// The file.
        path: String,
    },
    /// The picture cannot be encoded.
    #[error("{path}: the picture could not be encoded: {reason}")]
    Encode {
        /// The file.
        path: String,
        /// Those of the encoder.
        reason: String,
    },
    /// The file cannot be written.
    #[error("{path}: {source}; nothing was written")]
    Write {
        /// The file.
        path: String,
        /// What the system says.
        source: io::Error,
    },
    /// Another file is to be written there, or one is read from there.
    #[error("{file}: {what}; give it a name of its own")]
    Taken {
        /// What asks for the file, and its name.
        file: String,
        /// What else is done with it.
        what: String,
    },
    /// The file cannot be read.
    #[error("{path}: {reason}")]
    Read {
        /// The file.
        path: String,
        /// What the system or the decoder says.
        reason: String,
    },
    /// What the file says of its origin is not there, or not to be believed.
    #[error("{path}: {source}")]
    Provenance {
        /// The file.
        path: String,
        /// What is wrong.
        source: ProvenanceError,
    },
}

/// The formats, by the end of a file name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Kind {
    Png,
    Exr,
}

/// Checks, before any work is done, that a picture can be written under this name.
///
/// # Errors
/// An unknown format, or a folder that does not exist.
pub fn check(path: &Path) -> Result<(), OutputError> {
    kind(path)?;
    check_folder(path)
}

/// Checks, before any work is done, that this file can be written.
///
/// # Errors
/// A folder that does not exist or cannot be written into, a name that is too long, or what no file may replace.
pub fn check_folder(path: &Path) -> Result<(), OutputError> {
    check_all([("", path.into())], [])
}

/// Checks, before any work is done, that all of these files can be written, each named by what asks for it such as `-o`:
/// no two of them are the same file, and none is one that is `read`.
///
/// # Errors
/// Those of [`check_folder`], and a file that is taken.
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

/// Writes a picture over `background`; without one, its alpha is kept. The provenance goes into the file.
///
/// # Errors
/// An unknown format, or what the system says; the file is then not there.
pub fn write(
    frame: &Frame,
    background: Option<Color>,
    depth: Depth,
    provenance: &Provenance,
    path: &Path,
) -> Result<(), OutputError> {
    let encoded = match kind(path)? {
        Kind::Png => png(frame, background, depth, provenance).map_err(|error| error.to_string()),
        Kind::Exr => exr(frame, background, provenance).map_err(|error| error.to_string()),
    };
    let bytes = encoded.map_err(|reason| OutputError::Encode { path: path.display().to_string(), reason })?;
    write_whole(path, &bytes).map_err(|source| OutputError::Write { path: path.display().to_string(), source })
}

/// The bytes of a PNG that [`write()`] would write.
///
/// # Errors
/// Those of the encoder.
pub fn encode_png(
    frame: &Frame,
    background: Option<Color>,
    depth: Depth,
    provenance: &Provenance,
) -> Result<Vec<u8>, OutputError> {
    let fails = |error: png::EncodingError| OutputError::Encode { path: "a PNG".into(), reason: error.to_string() };
    png(frame, background, depth, provenance).map_err(fails)
}

fn kind(path: &Path) -> Result<Kind, OutputError> {
    match path.extension().map(|end| end.to_string_lossy().to_lowercase()).as_deref() {
        Some("png") => Ok(Kind::Png),
        Some("exr") => Ok(Kind::Exr),
        _ => Err(OutputError::Format { path: path.display().to_string() }),
    }
}

fn folder(path: &Path) -> PathBuf {
    match path.parent() {
        Some(parent) if parent.as_os_str().is_empty() => PathBuf::from("."),
        Some(parent) => parent.to_path_buf(),
        None => PathBuf::from("."),
    }
}

/// A premultiplied pixel over an opaque background, if there is one; linear.
fn over(pixel: [f32; 4], background: Option<[f32; 3]>) -> [f32; 4] {
    let Some(behind) = background else { return pixel };
    let through = 1.0 - pixel[3];
    [pixel[0] + behind[0] * through, pixel[1] + behind[1] * through, pixel[2] + behind[2] * through, 1.0]
}

/// Straight sRGB codes in [0, 1] of a premultiplied linear pixel. Below an alpha of 2^-16 a color is noise: black.
fn straight(pixel: [f32; 4]) -> [f32; 4] {
    let alpha = pixel[3].clamp(0.0, 1.0);
    let code = |c: f32| if alpha < 1.0 / 65536.0 { 0.0 } else { linear_to_srgb((c / alpha).clamp(0.0, 1.0)) };
    [code(pixel[0]), code(pixel[1]), code(pixel[2]), alpha]
}

fn png(
    frame: &Frame,
    background: Option<Color>,
    depth: Depth,
    provenance: &Provenance,
) -> Result<Vec<u8>, png::EncodingError> {
    let behind = background.map(Color::linear);
    let codes = frame.pixels.iter().flat_map(|&pixel| straight(over(pixel, behind)));
    let data: Vec<u8> = match depth {
        Depth::Eight => codes.map(|code| (code * 255.0).round() as u8).collect(),
        Depth::Sixteen => codes.flat_map(|code| ((code * 65535.0).round() as u16).to_be_bytes()).collect(),
    };
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, frame.size[0], frame.size[1]);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(match depth {
        Depth::Eight => png::BitDepth::Eight,
        Depth::Sixteen => png::BitDepth::Sixteen,
    });
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.add_text_chunk("Software".into(), PROGRAM.into())?;
    encoder.add_itxt_chunk(provenance::KEY.into(), provenance.to_text())?;
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&data)?;
    writer.finish()?;
    Ok(bytes)
}

fn exr(frame: &Frame, background: Option<Color>, provenance: &Provenance) -> exr::error::Result<Vec<u8>> {
    let behind = background.map(Color::linear);
    let [width, height] = frame.size.map(|side| side as usize);
    let channels = SpecificChannels::rgba(|at: Vec2<usize>| {
        let [r, g, b, a] = over(frame.pixels[at.y() * width + at.x()], behind);
        (r, g, b, a)
    });
    let mut image = Image::from_channels((width, height), channels);
    image.layer_data.attributes.software_name = Some(Text::from(PROGRAM));
    // One attribute and not several: the encoder writes those that it does not know in an order that changes.
    let text = Text::from_slice_unchecked(provenance.to_text().as_bytes());
    image.layer_data.attributes.other.insert(Text::from(provenance::KEY), AttributeValue::Text(text));
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes)?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Measurements;
    use crate::scene::{Scene, srgb_to_linear};

    fn frame(pixels: Vec<[f32; 4]>) -> Frame {
        Frame { size: [pixels.len() as u32, 1], pixels, measurements: Default::default() }
    }

    fn read(path: &Path) -> image::DynamicImage {
        image::open(path).unwrap()
    }

    fn provenance() -> Provenance {
        Provenance::of(&Scene::default(), "a device", &Measurements::default()).unwrap()
    }

    #[test]
    fn half_cover_over_white_and_black_is_right_to_a_code() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("half.png");
        let half = frame(vec![[0.5 * 0.2, 0.5 * 0.4, 0.5 * 0.8, 0.5]]);
        for (behind, value) in [([255; 3], 1.0), ([0; 3], 0.0)] {
            write(&half, Some(Color(behind)), Depth::Eight, &provenance(), &path).unwrap();
            let pixel = read(&path).to_rgba8().get_pixel(0, 0).0;
            for (code, linear) in pixel.into_iter().zip([0.2, 0.4, 0.8]) {
                let expected = 0.5 * linear + 0.5 * value;
                assert!((srgb_to_linear(f32::from(code) / 255.0) - expected).abs() < 0.005);
            }
        }
    }

    #[test]
    fn a_transparent_picture_keeps_its_straight_color() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("straight.png");
        write(
            &frame(vec![[0.25 * 0.5, 0.0, 0.0, 0.25], [1e-9, 0.0, 0.0, 1e-9]]),
            None,
            Depth::Sixteen,
            &provenance(),
            &path,
        )
        .unwrap();
        let image = read(&path).to_rgba16();
        let red = srgb_to_linear(f32::from(image.get_pixel(0, 0).0[0]) / 65535.0);
        assert!((red - 0.5).abs() < 1e-4);
        assert!((f32::from(image.get_pixel(0, 0).0[3]) / 65535.0 - 0.25).abs() < 1e-4);
        assert_eq!(image.get_pixel(1, 0).0, [0; 4]);
    }

    #[test]
    fn an_exr_keeps_every_bit() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("exact.exr");
        let pixels = vec![[0.1, 7.5, 1e-7, 0.3], [0.0, 0.0, 0.0, 0.0]];
        write(&frame(pixels.clone()), None, Depth::Eight, &provenance(), &path).unwrap();
        let image = read(&path).to_rgba32f();
        assert_eq!(image.get_pixel(0, 0).0, pixels[0]);
    }

    #[test]
    fn a_failed_write_leaves_nothing_behind() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("taken.png");
        std::fs::create_dir(&path).unwrap();
        assert!(write(&frame(vec![[0.0; 4]]), None, Depth::Eight, &provenance(), &path).is_err());
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        let error = check(&folder.path().join("missing/x.png")).unwrap_err().to_string();
        assert!(error.contains("there is no folder"), "{error}");
        assert!(check(Path::new("x.jpg")).unwrap_err().to_string().contains(".png or .exr"));
    }
}
