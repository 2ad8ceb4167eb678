//! Pictures from disk: as stored, and where they come from.

use super::provenance::{KEY, Provenance, ProvenanceError};
use super::{Kind, OutputError, kind, over, straight};
use crate::scene::{Color, srgb_to_linear};
use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, Text};
use image::{DynamicImage, ImageFormat, ImageReader, Limits};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;
use support::open;

/// The longest side of a picture that is read, pixels, and what its decoder may allocate, bytes: as much as the largest
/// that is rendered.
const LONGEST: u32 = 16_384;
const MAX_BYTES: u64 = LONGEST as u64 * LONGEST as u64 * 16;

/// What the numbers of a stored picture mean.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// Straight sRGB and alpha in codes from 0 to this many: 255 or 65535, for a PNG.
    Codes(u16),
    /// Premultiplied linear floats, for OpenEXR.
    Linear,
}

/// A picture as it is stored.
#[derive(Clone, Debug, PartialEq)]
pub struct Stored {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Row by row from the top; codes as parts of the largest, so from 0 to 1.
    pub pixels: Vec<[f32; 4]>,
    /// What the numbers mean.
    pub encoding: Encoding,
}

impl Encoding {
    /// A premultiplied linear pixel over a background, if there is one, in this encoding but not rounded to its codes.
    pub fn of(self, pixel: [f32; 4], background: Option<Color>) -> [f32; 4] {
        let whole = over(pixel, background.map(Color::linear));
        match self {
            Encoding::Codes(_) => straight(whole),
            Encoding::Linear => whole,
        }
    }

    /// A pixel in this encoding as it is stored: rounded to codes.
    pub fn rounded(self, pixel: [f32; 4]) -> [f32; 4] {
        match self {
            Encoding::Codes(most) => pixel.map(|part| (part * f32::from(most)).round() / f32::from(most)),
            Encoding::Linear => pixel,
        }
    }

    /// The premultiplied linear pixel that a stored one shows.
    pub fn linear(self, [r, g, b, alpha]: [f32; 4]) -> [f32; 4] {
        match self {
            Encoding::Codes(_) => {
                let [r, g, b] = [r, g, b].map(|part| alpha * srgb_to_linear(part));
                [r, g, b, alpha]
            }
            Encoding::Linear => [r, g, b, alpha],
        }
    }

    /// The distance between two codes; 0 for floats.
    pub fn quantum(self) -> f64 {
        match self {
            Encoding::Codes(most) => 1.0 / f64::from(most),
            Encoding::Linear => 0.0,
        }
    }
}

/// Width and height of the picture in a PNG or OpenEXR file, pixels; it is not decoded.
///
/// # Errors
/// As [`read`].
pub fn size(path: &Path) -> Result<[u32; 2], OutputError> {
    reader(path)?.into_dimensions().map(<[u32; 2]>::from).map_err(|error| fail(path, &error.to_string()))
}

fn reader(path: &Path) -> Result<ImageReader<BufReader<File>>, OutputError> {
    let format = match kind(path)? {
        Kind::Png => ImageFormat::Png,
        Kind::Exr => ImageFormat::OpenExr,
    };
    let mut reader = ImageReader::with_format(opened(path).map_err(|reason| fail(path, &reason))?, format);
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(LONGEST), Some(LONGEST));
    limits.max_alloc = Some(MAX_BYTES);
    reader.limits(limits);
    Ok(reader)
}

/// Reads a PNG or OpenEXR file.
///
/// # Errors
/// An unknown format, or what the system or the decoder says.
pub fn read(path: &Path) -> Result<Stored, OutputError> {
    let image = reader(path)?.decode().map_err(|error| fail(path, &error.to_string()))?;
    let size = [image.width(), image.height()];
    let texels = |most: u16, codes: Vec<f32>| {
        let pixels = codes.as_chunks::<4>().0.iter().map(|texel| texel.map(|code| code / f32::from(most)));
        Stored { size, pixels: pixels.collect(), encoding: Encoding::Codes(most) }
    };
    Ok(match &image {
        DynamicImage::ImageRgb32F(_) | DynamicImage::ImageRgba32F(_) => {
            let pixels = image.to_rgba32f().into_raw().as_chunks::<4>().0.to_vec();
            Stored { size, pixels, encoding: Encoding::Linear }
        }
        DynamicImage::ImageLuma16(_)
        | DynamicImage::ImageLumaA16(_)
        | DynamicImage::ImageRgb16(_)
        | DynamicImage::ImageRgba16(_) => {
            texels(u16::MAX, image.to_rgba16().into_raw().into_iter().map(f32::from).collect())
        }
        _ => texels(u16::from(u8::MAX), image.to_rgba8().into_raw().into_iter().map(f32::from).collect()),
    })
}

/// Reads where the picture in a PNG or OpenEXR file comes from.
///
/// # Errors
/// A file that cannot be read, or that does not say; its scene is only read by [`Provenance::scene`].
pub fn read_provenance(path: &Path) -> Result<Provenance, OutputError> {
    let text = match kind(path)? {
        Kind::Png => png_text(path),
        Kind::Exr => exr_text(path),
    };
    let of = |source| OutputError::Provenance { path: path.display().to_string(), source };
    let text = text.map_err(|reason| fail(path, &reason))?.ok_or_else(|| of(ProvenanceError::None))?;
    Provenance::from_text(&text).map_err(of)
}

fn fail(path: &Path, reason: &str) -> OutputError {
    OutputError::Read { path: path.display().to_string(), reason: reason.replace('\n', " ") }
}

fn opened(path: &Path) -> Result<BufReader<File>, String> {
    open::open(path, u64::MAX).map(|(file, _)| BufReader::new(file)).map_err(|error| error.to_string())
}

fn png_text(path: &Path) -> Result<Option<String>, String> {
    let reader = png::Decoder::new(opened(path)?).read_info().map_err(|error| error.to_string())?;
    let chunk = reader.info().utf8_text.iter().find(|chunk| chunk.keyword == KEY);
    chunk.map(|chunk| chunk.get_text().map_err(|error| error.to_string())).transpose()
}

fn exr_text(path: &Path) -> Result<Option<String>, String> {
    let data = MetaData::read_from_buffered(opened(path)?, false).map_err(|error| error.to_string())?;
    let attribute = data.headers.first().and_then(|header| header.own_attributes.other.get(&Text::from(KEY)));
    Ok(match attribute {
        Some(AttributeValue::Text(text)) => Some(String::from_utf8_lossy(text.as_slice()).into_owned()),
        _ => None,
    })
}
