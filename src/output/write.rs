//! Pictures to disk.

use super::OutputError;
use super::format::FileFormat;
use super::provenance::{KEY, PROGRAM, Provenance};
use crate::render::Frame;
use crate::scene::{Color, linear_to_srgb};
use exr::image::write::WritableImage;
use exr::image::{Image, SpecificChannels};
use exr::math::Vec2;
use exr::meta::attribute::{AttributeValue, Text};
use hypertexture_support::write_whole;
use std::io::Cursor;
use std::path::Path;

/// Bits of each channel of a PNG.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Depth {
    /// 8 bits.
    #[default]
    Eight,
    /// 16 bits.
    Sixteen,
}

/// Writes a picture with its provenance, composited over `background`; without one, with its alpha.
///
/// # Errors
/// An unknown format, or an error of the encoder or the system; the file is then unchanged.
pub fn write(
    frame: &Frame,
    background: Option<Color>,
    depth: Depth,
    provenance: &Provenance,
    path: &Path,
) -> Result<(), OutputError> {
    let encoded = match FileFormat::of(path)? {
        FileFormat::Png => png(frame, background, depth, provenance).map_err(|error| error.to_string()),
        FileFormat::Exr => exr(frame, background, provenance).map_err(|error| error.to_string()),
    };
    let bytes = encoded.map_err(|reason| OutputError::Encode { path: path.display().to_string(), reason })?;
    write_whole(path, &bytes).map_err(|source| OutputError::Write { path: path.display().to_string(), source })
}

/// The bytes of a PNG file as [`write()`] writes it.
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

/// Composites a premultiplied linear pixel over an opaque background, if any.
pub(super) fn over(pixel: [f32; 4], background: Option<[f32; 3]>) -> [f32; 4] {
    let Some(behind) = background else { return pixel };
    let through = 1.0 - pixel[3];
    [pixel[0] + behind[0] * through, pixel[1] + behind[1] * through, pixel[2] + behind[2] * through, 1.0]
}

/// Straight sRGB in [0, 1] of a premultiplied linear pixel. Black where the alpha is below 2^-16, as the color is noise.
pub(super) fn straight(pixel: [f32; 4]) -> [f32; 4] {
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
    encoder.add_itxt_chunk(KEY.into(), provenance.to_text())?;
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
    // One attribute: the encoder writes several custom ones in random order.
    let text = Text::from_slice_unchecked(provenance.to_text().as_bytes());
    image.layer_data.attributes.other.insert(Text::from(KEY), AttributeValue::Text(text));
    let mut bytes = Cursor::new(Vec::new());
    image.write().to_buffered(&mut bytes)?;
    Ok(bytes.into_inner())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::output::check;
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
