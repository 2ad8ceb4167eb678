//! Pictures from disk, and their provenance.

use super::OutputError;
use super::format::FileFormat;
use super::provenance::{KEY, Provenance, ProvenanceError};
use super::write::{over, straight};
use crate::scene::{Color, srgb_to_linear};
use exr::meta::MetaData;
use exr::meta::attribute::{AttributeValue, Text};
use hypertexture_support::open;
use image::{DynamicImage, ImageFormat, ImageReader, Limits};
use std::fs::File;
use std::io::BufReader;
use std::path::Path;

/// Longest side of a picture, pixels, as for rendering; and the memory limit of the decoder, bytes.
const MAX_SIDE: u32 = 16_384;
const MAX_BYTES: u64 = MAX_SIDE as u64 * MAX_SIDE as u64 * 16;

/// Encoding of the pixels of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Encoding {
    /// PNG: straight sRGB and alpha in codes from 0 to 255 or 65535.
    Codes(u16),
    /// OpenEXR: premultiplied linear floats.
    Linear,
}

/// A picture with the values of its file.
#[derive(Clone, Debug, PartialEq)]
pub struct Stored {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Pixels row by row from the top; codes are scaled to [0, 1].
    pub pixels: Vec<[f32; 4]>,
    /// Their encoding.
    pub encoding: Encoding,
}

impl Encoding {
    /// Encodes a premultiplied linear pixel over a background, if any, without rounding to codes.
    pub fn of(self, pixel: [f32; 4], background: Option<Color>) -> [f32; 4] {
        let whole = over(pixel, background.map(Color::linear));
        match self {
            Encoding::Codes(_) => straight(whole),
            Encoding::Linear => whole,
        }
    }

    /// Rounds an encoded pixel to codes.
    pub fn rounded(self, pixel: [f32; 4]) -> [f32; 4] {
        match self {
            Encoding::Codes(most) => pixel.map(|part| (part * f32::from(most)).round() / f32::from(most)),
            Encoding::Linear => pixel,
        }
    }

    /// Decodes a pixel to premultiplied linear color.
    pub fn linear(self, [r, g, b, alpha]: [f32; 4]) -> [f32; 4] {
        match self {
            Encoding::Codes(_) => {
                let [r, g, b] = [r, g, b].map(|part| alpha * srgb_to_linear(part));
                [r, g, b, alpha]
            }
            Encoding::Linear => [r, g, b, alpha],
        }
    }

    /// Distance between two codes; 0 for floats.
    pub fn quantum(self) -> f64 {
        match self {
            Encoding::Codes(most) => 1.0 / f64::from(most),
            Encoding::Linear => 0.0,
        }
    }
}

/// Width and height of the picture in a PNG or OpenEXR file, in pixels, without decoding it.
///
/// # Errors
/// Those of [`read`].
pub fn size(path: &Path) -> Result<[u32; 2], OutputError> {
    reader(path)?.into_dimensions().map(<[u32; 2]>::from).map_err(|error| fail(path, &error.to_string()))
}

fn reader(path: &Path) -> Result<ImageReader<BufReader<File>>, OutputError> {
    let format = match FileFormat::of(path)? {
        FileFormat::Png => ImageFormat::Png,
        FileFormat::Exr => ImageFormat::OpenExr,
    };
    let mut reader = ImageReader::with_format(opened(path).map_err(|reason| fail(path, &reason))?, format);
    let mut limits = Limits::default();
    (limits.max_image_width, limits.max_image_height) = (Some(MAX_SIDE), Some(MAX_SIDE));
    limits.max_alloc = Some(MAX_BYTES);
    reader.limits(limits);
    Ok(reader)
}

/// Reads a PNG or OpenEXR file.
///
/// # Errors
/// An unknown format, or an error of the system or the decoder.
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

/// Reads the provenance in a PNG or OpenEXR file. [`Provenance::scene`] parses its scene.
///
/// # Errors
/// The file cannot be read, or has no provenance.
pub fn read_provenance(path: &Path) -> Result<Provenance, OutputError> {
    let text = match FileFormat::of(path)? {
        FileFormat::Png => png_text(path),
        FileFormat::Exr => exr_text(path),
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
