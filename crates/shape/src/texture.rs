//! Textures: pictures in PNG and JPEG, as texels in linear light.

use super::error::{Location, ShapeError, quoted, shown};
use super::looks::linear;
use super::source::Source;
use half::f16;
use jpeg_decoder::PixelFormat;
use png::{ColorType, Transformations};
use std::io::Cursor;

/// Most pixels of a picture.
const MAX_PIXELS: u64 = 1 << 26;
/// Most texels along a side; a voxel of a groom is larger than a texel still. Pixels of larger pictures are averaged.
const MAX_TEXELS: usize = 1024;

/// Texels beyond the edges of a texture.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) enum Wrap {
    #[default]
    Repeat,
    Mirror,
    Clamp,
}

impl Wrap {
    /// The texel for a coordinate, which is below `count`.
    fn texel(self, at: i64, count: usize) -> usize {
        let count = count as i64;
        (match self {
            Wrap::Repeat => at.rem_euclid(count),
            Wrap::Mirror => {
                let both = at.rem_euclid(2 * count);
                both.min(2 * count - 1 - both)
            }
            Wrap::Clamp => at.clamp(0, count - 1),
        }) as usize
    }
}

/// A picture over texture coordinates of 0 to 1, its first row at v = 0.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Texture {
    size: [usize; 2],
    texels: Vec<[f16; 3]>,
}

impl Texture {
    /// Decodes the picture at `place` of a source.
    pub fn decode(source: &Source, place: Location, bytes: &[u8]) -> Result<Texture, ShapeError> {
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

    /// Pixels of one byte in each of their samples, averaged to at most [`MAX_TEXELS`] a side.
    fn reduced([width, height]: [usize; 2], pixels: &[u8], samples: usize, is_gray: bool) -> Texture {
        let light: [f32; 256] = std::array::from_fn(|code| linear(code as f64 / 255.0));
        let size = [width, height].map(|side| side.min(MAX_TEXELS));
        let mut sums = vec![[0.0_f32; 4]; size[0] * size[1]];
        for (y, row) in pixels.chunks_exact(width * samples).take(height).enumerate() {
            let first = y * size[1] / height * size[0];
            for (x, pixel) in row.chunks_exact(samples).enumerate() {
                let rgb = if is_gray { [pixel[0]; 3] } else { [pixel[0], pixel[1], pixel[2]] };
                let [r, g, b] = rgb.map(|code| light[usize::from(code)]);
                sums[first + x * size[0] / width].iter_mut().zip([r, g, b, 1.0]).for_each(|(sum, part)| *sum += part);
            }
        }
        let texels = sums.into_iter().map(|[r, g, b, count]| [r, g, b].map(|sum| f16::from_f32(sum / count)));
        Texture { size, texels: texels.collect() }
    }

    /// Linear RGB at texture coordinates, interpolated between four texels.
    pub fn sample(&self, uv: [f32; 2], wraps: [Wrap; 2]) -> [f32; 3] {
        let axes: [_; 2] = std::array::from_fn(|axis| {
            let at = f64::from(uv[axis]) * self.size[axis] as f64 - 0.5;
            let below = at.floor();
            let texel = |at: i64| wraps[axis].texel(at, self.size[axis]);
            [(texel(below as i64), 1.0 - (at - below)), (texel((below as i64).saturating_add(1)), at - below)]
        });
        let mut rgb = [0.0; 3];
        for (y, own) in axes[1] {
            for (x, part) in axes[0] {
                let texel = self.texels[y * self.size[0] + x].map(f16::to_f32);
                rgb.iter_mut().zip(texel).for_each(|(sum, value)| *sum += (own * part) as f32 * value);
            }
        }
        rgb
    }
}
