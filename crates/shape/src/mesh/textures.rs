//! Textures of a file: pictures in PNG and JPEG, each decoded once.

use crate::error::{Location, ShapeError, quoted, shown};
use crate::shape::paint::Spot;
use crate::shape::texture::Texture;
use crate::source::Source;
use jpeg_decoder::PixelFormat;
use png::{ColorType, Transformations};
use std::collections::HashMap;
use std::io::Cursor;
use std::sync::Arc;

/// Most textures of a mesh.
const MAX_TEXTURES: usize = 256;
/// Most pixels of a picture.
const MAX_PIXELS: u64 = 1 << 26;

/// Decoded textures of a file, by their names.
#[derive(Default)]
pub(crate) struct Textures(HashMap<String, Arc<Texture>>);

impl Textures {
    /// The texture of this name, which `decode` gives the first time.
    pub fn named(
        &mut self,
        source: &Source,
        name: String,
        decode: impl FnOnce() -> Result<Texture, ShapeError>,
    ) -> Result<Arc<Texture>, ShapeError> {
        if let Some(known) = self.0.get(&name) {
            return Ok(known.clone());
        }
        if self.0.len() == MAX_TEXTURES {
            let (found, remedy) = (format!("beyond {MAX_TEXTURES}"), "bake them into fewer textures");
            return Err(source.unsupported(Location::Header, "the number of textures", found, remedy));
        }
        Ok(self.0.entry(name).or_insert(Arc::new(decode()?)).clone())
    }
}

/// Decodes the picture at `place` of a source.
pub(super) fn decode_texture(source: &Source, place: Location, bytes: &[u8]) -> Result<Texture, ShapeError> {
    let damaged = |reason: String| source.malformed_at(place.clone(), "a whole picture in PNG or JPEG", reason);
    let check = |width: u32, height: u32| match u64::from(width) * u64::from(height) {
        0 => Err(damaged("one without pixels".into())),
        1..=MAX_PIXELS => Ok([width, height].map(|side| side as usize)),
        _ => {
            let (found, remedy) = (format!("of {width} x {height} pixels"), "scale it to at most 8192 x 8192");
            Err(source.unsupported(place.clone(), "a picture", found, remedy))
        }
    };
    if bytes.starts_with(b"\x89PNG") {
        let limits = png::Limits { bytes: 8 * MAX_PIXELS as usize };
        let mut decoder = png::Decoder::new_with_limits(Cursor::new(bytes), limits);
        decoder.set_transformations(Transformations::normalize_to_color8());
        let mut reader = decoder.read_info().map_err(|error| damaged(shown(&error.to_string())))?;
        let size = check(reader.info().width, reader.info().height)?;
        let mut pixels = vec![0; reader.output_buffer_size().unwrap_or_default()];
        let frame = reader.next_frame(&mut pixels).map_err(|error| damaged(shown(&error.to_string())))?;
        let samples = frame.color_type.samples();
        let is_gray = matches!(frame.color_type, ColorType::Grayscale | ColorType::GrayscaleAlpha);
        return Ok(Texture::reduced(size, &pixels, samples, is_gray));
    }
    if bytes.starts_with(b"\xff\xd8\xff") {
        let fault = |error: jpeg_decoder::Error| match error {
            jpeg_decoder::Error::Unsupported(feature) => {
                let remedy = "save it as PNG";
                source.unsupported(place.clone(), "JPEG with", format!("{feature:?}"), remedy)
            }
            error => damaged(shown(&error.to_string())),
        };
        let mut decoder = jpeg_decoder::Decoder::new(bytes);
        decoder.set_max_decoding_buffer_size(4 * MAX_PIXELS as usize);
        decoder.read_info().map_err(fault)?;
        let info = decoder.info().ok_or_else(|| damaged("one without a frame".into()))?;
        let size = check(info.width.into(), info.height.into())?;
        let samples = match info.pixel_format {
            PixelFormat::L8 => 1,
            PixelFormat::RGB24 => 3,
            format => {
                let remedy = "save it as PNG";
                return Err(source.unsupported(place, "JPEG of", format!("{format:?}"), remedy));
            }
        };
        return Ok(Texture::reduced(size, &decoder.decode().map_err(fault)?, samples, samples == 1));
    }
    let (found, remedy) = (quoted(&bytes[..bytes.len().min(12)]), "save it as PNG or JPEG");
    Err(source.unsupported(place, "the format of a picture that begins with", found, remedy))
}

/// Checks that texture coordinates are finite.
pub(super) fn check_spots(source: &Source, spots: &[Spot]) -> Result<(), ShapeError> {
    let is_wrong = |spot: &Spot| !spot.uv.iter().all(|part| part.is_finite());
    let Some(first) = spots.iter().position(is_wrong) else { return Ok(()) };
    let count = spots.iter().filter(|spot| is_wrong(spot)).count();
    let (file, what, total) = (source.file.clone(), "texture coordinates", spots.len());
    Err(ShapeError::NotFinite { file, what, count, total, first })
}
