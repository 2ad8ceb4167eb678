//! Animated pictures and sprite sheets, from the PNG files of a sequence.
//!
//! Role: frames -> WebP (lossless), GIF (256 colors) or APNG, which repeat without end; or one PNG of all frames with a
//! JSON file of their places, in the form of Aseprite and TexturePacker. Colors have 8 bits, as sRGB.

use super::OutputError;
use super::provenance::PROGRAM;
use hypertexture_support::write_whole;
use image::RgbaImage;
use serde_json::json;
use std::path::{Path, PathBuf};

/// Longest side of a sheet, pixels.
const MAX_SIDE: u32 = 16_384;
/// Longest side of a frame of a WebP, pixels.
const MAX_WEBP: u32 = 16_383;
/// Speed of the choice of 256 colors. Higher: visible steps in gradients. Lower: slow.
const GIF_SPEED: i32 = 10;
/// Shortest frame of a GIF, hundredths of a second: browsers show shorter ones for a tenth.
const GIF_SHORTEST: u32 = 2;
/// Most frames a second of WebP and APNG that browsers show at that rate: frames of 10 ms and less take a tenth of a second.
const FASTEST: f64 = 90.0;
/// Most frames a second of a GIF.
const GIF_FPS: f64 = 100.0 / GIF_SHORTEST as f64;
/// Error of a picture without frames.
const EMPTY: &str = "there are no frames";

/// A format of animated pictures.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Animated {
    /// WebP without loss.
    WebP,
    /// GIF: 256 colors for each frame, and pixels are transparent or opaque.
    Gif,
    /// Animated PNG.
    Apng,
}

type Encoded = Result<Vec<u8>, Box<dyn std::error::Error>>;

impl Animated {
    /// The format of a file, by its extension.
    pub fn of(path: &Path) -> Option<Animated> {
        match path.extension()?.to_string_lossy().to_lowercase().as_str() {
            "webp" => Some(Animated::WebP),
            "gif" => Some(Animated::Gif),
            "apng" => Some(Animated::Apng),
            _ => None,
        }
    }

    /// Line about the frames that viewers show in a second, if they are fewer.
    pub fn note(self, fps: f64) -> Option<String> {
        match self {
            Animated::Gif if fps > GIF_FPS => Some(format!(
                "a GIF shows at most {GIF_FPS} frames a second: of {fps}, the nearest to each 20 ms are written"
            )),
            Animated::WebP | Animated::Apng if fps > FASTEST => Some(format!(
                "browsers show frames of 10 ms or less for 100 ms: --fps {fps} plays slower there; {FASTEST} is fine"
            )),
            _ => None,
        }
    }

    /// Writes an animated picture of the frames in PNG files, which repeats without end. A GIF leaves out the frames beyond 50 a
    /// second.
    ///
    /// # Errors
    /// A frame cannot be read, or the file cannot be written.
    pub fn write(self, frames: &[PathBuf], fps: f64, path: &Path) -> Result<(), OutputError> {
        let encoded = match self {
            Animated::WebP => webp(frames, fps),
            Animated::Gif => gif(frames, fps),
            Animated::Apng => apng(frames, fps),
        };
        save(path, encoded)
    }
}

/// A grid of frames in one picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Sheet {
    /// Frames side by side.
    pub columns: u32,
    /// Rows of frames.
    pub rows: u32,
}

impl std::str::FromStr for Sheet {
    type Err = String;

    /// Reads columns x rows.
    fn from_str(text: &str) -> Result<Sheet, String> {
        let sides = text.split_once('x').and_then(|(columns, rows)| Some((columns.parse().ok()?, rows.parse().ok()?)));
        match sides {
            Some((columns @ 1..=1024, rows @ 1..=1024)) => Ok(Sheet { columns, rows }),
            _ => Err("write columns x rows, each from 1 to 1024, such as 8x8".into()),
        }
    }
}

impl Sheet {
    /// Checks that `count` frames of a size fit.
    ///
    /// # Errors
    /// The reason, in words.
    pub fn check(self, count: u32, [width, height]: [u32; 2]) -> Result<(), String> {
        let Sheet { columns, rows } = self;
        let named = format!("--sprite-sheet {columns}x{rows}");
        if count > columns * rows {
            return Err(format!("{named}: holds {} frames, and --frames has {count}", columns * rows));
        }
        match [columns.saturating_mul(width), rows.saturating_mul(height)] {
            [width, height] if width.max(height) > MAX_SIDE => Err(format!(
                "{named}: has {width} x {height} pixels; {MAX_SIDE} along a side are the most: lower --size"
            )),
            _ => Ok(()),
        }
    }

    /// Writes the frames in PNG files as one PNG, and their places beside it as JSON; `period` is the loop of the scene.
    ///
    /// # Errors
    /// A frame cannot be read, or a file cannot be written.
    pub fn write(self, frames: &[PathBuf], fps: f64, period: Option<f64>, path: &Path) -> Result<(), OutputError> {
        let Sheet { columns, rows } = self;
        let mut whole = None;
        let mut list = Vec::new();
        for (index, (file, ms)) in frames.iter().zip(durations(fps)).enumerate() {
            let frame = read(file).map_err(|error| encoding(path, &*error))?;
            let (width, height) = frame.dimensions();
            let index = index as u32;
            let (x, y) = (index % columns * width, index / columns * height);
            let sheet = whole.get_or_insert_with(|| RgbaImage::new(columns * width, rows * height));
            image::imageops::replace(sheet, &frame, i64::from(x), i64::from(y));
            list.push(json!({
                "filename": file.file_name().unwrap_or_default().to_string_lossy(),
                "frame": { "x": x, "y": y, "w": width, "h": height },
                "rotated": false, "trimmed": false,
                "spriteSourceSize": { "x": 0, "y": 0, "w": width, "h": height },
                "sourceSize": { "w": width, "h": height },
                "duration": ms,
            }));
        }
        let Some(whole) = whole else { return Ok(()) };
        let mut png = std::io::Cursor::new(Vec::new());
        let encoded = whole.write_to(&mut png, image::ImageFormat::Png);
        save(path, encoded.map(|()| png.into_inner()).map_err(Into::into))?;
        let places = json!({
            "frames": list,
            "meta": {
                "app": PROGRAM, "image": path.file_name().unwrap_or_default().to_string_lossy(), "format": "RGBA8888",
                "size": { "w": whole.width(), "h": whole.height() }, "scale": "1",
                "columns": columns, "rows": rows, "fps": fps, "loop": period,
            },
        });
        save(&Sheet::places(path), serde_json::to_vec_pretty(&places).map_err(Into::into))
    }

    /// File of the places of the frames of a sheet.
    pub fn places(path: &Path) -> PathBuf {
        path.with_extension("json")
    }
}

fn encoding(path: &Path, error: &dyn std::error::Error) -> OutputError {
    OutputError::Encode { path: path.display().to_string(), reason: error.to_string() }
}

fn save(path: &Path, encoded: Encoded) -> Result<(), OutputError> {
    let bytes = encoded.map_err(|error| encoding(path, &*error))?;
    write_whole(path, &bytes).map_err(|source| OutputError::Write { path: path.display().to_string(), source })
}

fn read(file: &Path) -> Result<RgbaImage, Box<dyn std::error::Error>> {
    let named = |error: image::ImageError| format!("{}: {error}", file.display());
    Ok(image::open(file).map_err(named)?.to_rgba8())
}

/// Milliseconds of each frame, whose sums are the times of the frames, rounded.
fn durations(fps: f64) -> impl Iterator<Item = u32> {
    let start = move |frame: u32| (f64::from(frame) * 1000.0 / fps).round();
    (0..).map(move |frame| (start(frame + 1) - start(frame)).max(1.0) as u32)
}

/// The chunks of a WebP container: https://developers.google.com/speed/webp/docs/riff_container.
fn webp(frames: &[PathBuf], fps: f64) -> Encoded {
    let three = |number: u32| number.to_le_bytes().into_iter().take(3);
    let chunk = |name: &[u8; 4], body: &[u8]| {
        let padding = if body.len() % 2 == 1 { &[0][..] } else { &[] };
        [name, &(body.len() as u32).to_le_bytes()[..], body, padding].concat()
    };
    let (mut all, mut size) = (Vec::new(), (1, 1));
    for (file, ms) in frames.iter().zip(durations(fps)) {
        let frame = read(file)?;
        size = frame.dimensions();
        if size.0.max(size.1) > MAX_WEBP {
            return Err(format!("a side has at most {MAX_WEBP} pixels").into());
        }
        let mut single = Vec::new();
        let encoder = image_webp::WebPEncoder::new(&mut single);
        encoder.encode(&frame, size.0, size.1, image_webp::ColorType::Rgba8)?;
        // Place, size and duration; the frame replaces the one before it. After the head of its file, the pixels follow.
        let head = [0, 0].into_iter().chain([size.0 - 1, size.1 - 1]).chain([ms.min((1 << 24) - 1)]).flat_map(three);
        let body: Vec<u8> = head.chain([2]).chain(single.into_iter().skip(12)).collect();
        all.extend(chunk(b"ANMF", &body));
    }
    let extended: Vec<u8> =
        [0x12, 0, 0, 0].into_iter().chain([size.0 - 1, size.1 - 1].into_iter().flat_map(three)).collect();
    let body = [b"WEBP", &chunk(b"VP8X", &extended)[..], &chunk(b"ANIM", &[0; 6]), &all].concat();
    Ok(chunk(b"RIFF", &body))
}

/// Frames of a GIF and their durations in hundredths of a second: the nearest frame to each tick where there are more frames.
fn gif_frames(count: usize, fps: f64) -> Vec<(usize, u32)> {
    if fps <= GIF_FPS {
        return (0..count).zip(durations(10.0 * fps)).collect();
    }
    let ticks = (count as f64 * GIF_FPS / fps).round().max(1.0) as usize;
    let nearest = |tick: usize| (tick as f64 * fps / GIF_FPS).round() as usize;
    (0..ticks).map(|tick| (nearest(tick).min(count.saturating_sub(1)), GIF_SHORTEST)).collect()
}

fn gif(frames: &[PathBuf], fps: f64) -> Encoded {
    let side = |side: u32| u16::try_from(side).unwrap_or(u16::MAX);
    let (width, height) = image::image_dimensions(frames.first().ok_or(EMPTY)?)?;
    let mut bytes = Vec::new();
    let mut encoder = gif::Encoder::new(&mut bytes, side(width), side(height), &[])?;
    encoder.set_repeat(gif::Repeat::Infinite)?;
    for (index, hundredths) in gif_frames(frames.len(), fps) {
        let mut frame = read(&frames[index])?;
        let (width, height) = frame.dimensions();
        let mut picture = gif::Frame::from_rgba_speed(side(width), side(height), &mut frame, GIF_SPEED);
        picture.delay = u16::try_from(hundredths).unwrap_or(u16::MAX);
        picture.dispose = gif::DisposalMethod::Background;
        encoder.write_frame(&picture)?;
    }
    drop(encoder);
    Ok(bytes)
}

fn apng(frames: &[PathBuf], fps: f64) -> Encoded {
    // The rate as a fraction of numbers of 16 bits.
    let parts = [1000_u16, 100, 10, 1].into_iter().find(|parts| fps * f64::from(*parts) <= f64::from(u16::MAX));
    let parts = parts.unwrap_or(1);
    let (width, height) = image::image_dimensions(frames.first().ok_or(EMPTY)?)?;
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, width, height);
    encoder.set_color(png::ColorType::Rgba);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::Perceptual);
    encoder.set_animated(frames.len() as u32, 0)?;
    encoder.set_frame_delay(parts, (fps * f64::from(parts)).round().max(1.0) as u16)?;
    encoder.add_text_chunk("Software".into(), PROGRAM.into())?;
    let mut writer = encoder.write_header()?;
    frames.iter().try_for_each(|file| -> Result<(), Box<dyn std::error::Error>> {
        Ok(writer.write_image_data(&read(file)?)?)
    })?;
    writer.finish()?;
    Ok(bytes)
}

#[cfg(test)]
mod tests;
