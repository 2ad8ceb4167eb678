//! The picture on the screen: encoding and placement.

use super::compare::{CompareMode, Comparison};
use egui::epaint::Vertex;
use egui::{Color32, ColorImage, Mesh, Rect, Shape, TextureHandle, TextureId, TextureOptions, Ui, Vec2, pos2};
use hypertexture::gpu::Image;
use hypertexture::render::ViewPose;
use hypertexture::scene::{Color, linear_to_srgb};
use rayon::prelude::*;
use std::sync::{Arc, LazyLock};

/// Gray levels of the checkerboard behind transparent pictures: dark, so that glow is visible.
const CHECKERBOARD: [u8; 2] = [28, 42];
/// Side of its squares, screen pixels.
const SQUARE: f32 = 12.0;
/// Cells along a side of a reprojected picture. Lower: bent edges.
const GRID: u32 = 32;
/// Entries of the sRGB table, which is indexed by the square root: dark codes are the closest.
const TABLE: usize = 4096;

/// sRGB codes of linear light.
static CODES: LazyLock<Vec<f32>> = LazyLock::new(|| {
    let code = |index: usize| {
        let root = (index as f32 + 0.5) / TABLE as f32;
        linear_to_srgb(root * root) * 255.0
    };
    (0..TABLE).map(code).collect()
});

fn code(linear: f32) -> f32 {
    CODES[((linear.clamp(0.0, 1.0).sqrt() * TABLE as f32) as usize).min(TABLE - 1)]
}

fn rounded(codes: [f32; 3]) -> [u8; 3] {
    codes.map(|code| code.round() as u8) // what is beyond a code is held to it
}

fn image(light: &[[f32; 3]], size: [u32; 2]) -> ColorImage {
    let pixels = light.par_iter().map(|light| {
        let [r, g, b] = rounded(light.map(code));
        Color32::from_rgb(r, g, b)
    });
    ColorImage::new(size.map(|side| side as usize), pixels.collect())
}

/// Encodes a pixel over its background, or with an alpha for the checkerboard. The window blends codes, not light:
/// the alpha reproduces the blend over both gray levels, in the mean of the channels.
fn shown(pixel: &[f32; 4], background: Option<[f32; 3]>) -> Color32 {
    let over = |behind: [f32; 3]| [0, 1, 2].map(|c| code(pixel[c] + (1.0 - pixel[3]) * behind[c]));
    let behind = match background {
        None if pixel[3] < 1.0 => CHECKERBOARD.map(|grey| over(Color([grey; 3]).linear())),
        behind => {
            let [r, g, b] = rounded(over(behind.unwrap_or_default()));
            return Color32::from_rgb(r, g, b);
        }
    };
    let [dark, light] = behind;
    let [low, high] = CHECKERBOARD.map(f32::from);
    let through = (light.iter().sum::<f32>() - dark.iter().sum::<f32>()) / (3.0 * (high - low));
    let own = [0, 1, 2].map(|c| 0.5 * (dark[c] + light[c]) - through * 0.5 * (low + high));
    let [r, g, b] = rounded(own);
    Color32::from_rgba_premultiplied(r, g, b, (255.0 * (1.0 - through)).round() as u8)
}

/// Encoded pictures, one for each variant.
pub(crate) enum Encoded {
    /// On the host.
    Host(Vec<ColorImage>),
    /// On the device, over these backgrounds.
    Device(Vec<Arc<Image>>, Vec<Option<Color>>),
}

impl Default for Encoded {
    fn default() -> Encoded {
        Encoded::Host(Vec::new())
    }
}

impl Encoded {
    /// The images of the device.
    pub(crate) fn of_device(&self) -> &[Arc<Image>] {
        if let Encoded::Device(images, _) = self { images } else { &[] }
    }
}

/// Background that a picture is encoded over, for [`Encoder::encode`](hypertexture::gpu::Encoder::encode).
pub(crate) fn behind(background: Option<Color>) -> [[f32; 4]; 2] {
    let with = |color: Color, code: f32| {
        let [r, g, b] = color.linear();
        [r, g, b, code]
    };
    match background {
        Some(color) => [with(color, 0.0); 2],
        None => CHECKERBOARD.map(|grey| with(Color([grey; 3]), f32::from(grey) / 255.0)),
    }
}

/// Encodes pictures over their backgrounds, or with alpha.
pub(crate) fn encode_srgb(frames: &[&[[f32; 4]]], backgrounds: &[Option<Color>], size: [u32; 2]) -> Vec<ColorImage> {
    let encode = |(frame, background): (&&[[f32; 4]], &Option<Color>)| {
        let behind = background.map(Color::linear);
        let pixels = frame.par_iter().map(|pixel| shown(pixel, behind)).collect();
        ColorImage::new(size.map(|side| side as usize), pixels)
    };
    frames.iter().zip(backgrounds).map(encode).collect()
}

/// The checkerboard, fixed to the screen.
fn checkerboard(place: Rect, pixels_per_point: f32) -> Mesh {
    let side = SQUARE / pixels_per_point;
    let mut mesh = Mesh::default();
    mesh.add_colored_rect(place, Color32::from_gray(CHECKERBOARD[0]));
    let [columns, rows] = [place.width(), place.height()].map(|length| (length / side).ceil() as u32);
    for (row, column) in (0..rows).flat_map(|row| (0..columns).map(move |column| (row, column))) {
        if (row + column) % 2 == 0 {
            let corner = place.min + side * Vec2::new(column as f32, row as f32);
            let square = Rect::from_min_size(corner, Vec2::splat(side)).intersect(place);
            mesh.add_colored_rect(square, Color32::from_gray(CHECKERBOARD[1]));
        }
    }
    mesh
}

/// The amplified difference of two pictures: of each channel, or of the opacity if that is larger.
fn difference(frames: &[Frame], size: [u32; 2], gain: f32) -> Option<ColorImage> {
    let [a, b] = frames else { return None };
    let apart = a.par_iter().zip(b.par_iter()).map(|(a, b)| {
        let opacity = (a[3] - b[3]).abs();
        [0, 1, 2].map(|c| gain * (a[c] - b[c]).abs().max(opacity))
    });
    Some(image(&apart.collect::<Vec<_>>(), size))
}

/// Premultiplied linear RGBA, row by row from the top.
pub(crate) type Frame = Arc<[[f32; 4]]>;

/// Textures of the pictures.
#[derive(Default)]
pub(crate) struct Screen {
    textures: Vec<TextureHandle>,
    /// The encoded pictures; those of the host are kept for the replacement of a lost device.
    pub(crate) images: Encoded,
    fresh: bool,
    /// Whether a pixel is transparent.
    is_clear: bool,
    /// The rendered pictures, one for each variant, and their size.
    pub(crate) frames: Vec<Frame>,
    pub(crate) size: [u32; 2],
    /// View of the picture and current view, if they differ.
    pub(crate) moved: Option<(ViewPose, ViewPose)>,
    /// The texture of the difference, and its gain.
    difference: Option<(TextureHandle, f32)>,
}

impl Screen {
    /// Receives the images of a picture and its linear pixels.
    pub(crate) fn take(&mut self, images: Encoded, frames: Vec<Frame>, size: [u32; 2]) {
        self.is_clear = match &images {
            Encoded::Host(images) => images.iter().any(|own| own.pixels.par_iter().any(|pixel| !pixel.is_opaque())),
            Encoded::Device(_, backgrounds) => {
                let is_clear = |frame: &Frame| frame.par_iter().any(|[.., alpha]| *alpha < 1.0);
                frames.iter().zip(backgrounds).any(|(frame, background)| background.is_none() && is_clear(frame))
            }
        };
        (self.images, self.frames, self.size) = (images, frames, size);
        (self.fresh, self.difference) = (true, None);
    }

    /// Moves pictures of the device to the host.
    pub(crate) fn leave_device(&mut self) {
        if let Encoded::Device(_, backgrounds) = &self.images {
            let frames: Vec<&[[f32; 4]]> = self.frames.iter().map(|frame| &**frame).collect();
            self.images = Encoded::Host(encode_srgb(&frames, backgrounds, self.size));
        }
    }

    /// Drops the textures of a lost device.
    pub(crate) fn forget(&mut self) {
        self.textures.clear();
        (self.fresh, self.difference) = (true, None);
    }

    /// Draws the picture or the comparison, reprojected to the current view.
    pub(crate) fn draw(&mut self, ui: &Ui, place: Rect, comparison: &Comparison) {
        if let (Encoded::Host(images), true) = (&self.images, std::mem::take(&mut self.fresh)) {
            for (index, image) in images.iter().enumerate() {
                match self.textures.get_mut(index) {
                    Some(texture) => texture.set(image.clone(), TextureOptions::LINEAR),
                    None => {
                        let name = format!("picture {index}");
                        self.textures.push(ui.ctx().load_texture(name, image.clone(), TextureOptions::LINEAR));
                    }
                }
            }
            self.textures.truncate(images.len());
        }
        let (textures, corner): (Vec<TextureId>, Option<Color32>) = match &self.images {
            Encoded::Host(images) => {
                let corner = images.first().and_then(|image| image.pixels.first());
                (self.textures.iter().map(TextureHandle::id).collect(), corner.copied())
            }
            Encoded::Device(images, backgrounds) => {
                let pixel = self.frames.first().and_then(|frame| frame.first()).zip(backgrounds.first());
                let corner = pixel.map(|(pixel, background)| shown(pixel, background.map(Color::linear)));
                ((0..images.len() as u64).map(TextureId::User).collect(), corner)
            }
        };
        let painter = ui.painter_at(place);
        match corner {
            // A reprojected picture leaves gaps at its sides, which get the color of its corner.
            Some(corner) if !self.is_clear => drop(painter.rect_filled(place, 0.0, corner)),
            _ => drop(painter.add(Shape::mesh(checkerboard(place, ui.ctx().pixels_per_point())))),
        }
        let part = |texture: TextureId, from: f32, to: f32| {
            let within = |part: f32| egui::lerp(place.x_range(), part);
            let rect = Rect::from_x_y_ranges(within(from)..=within(to), place.y_range());
            let uv = Rect::from_min_max(pos2(from, 0.0), pos2(to, 1.0));
            match self.moved {
                None => painter.image(texture, rect, uv, Color32::WHITE),
                Some((seen, now)) => {
                    let mesh = mesh(texture, place, |at| seen.reproject(&now, at));
                    painter.with_clip_rect(rect).add(Shape::mesh(mesh))
                }
            };
        };
        match (textures.as_slice(), comparison.mode) {
            (&[now, kept], CompareMode::Wipe) => {
                part(kept, 0.0, comparison.at);
                part(now, comparison.at, 1.0);
            }
            ([_, _], CompareMode::Difference) => {
                if self.difference.as_ref().is_none_or(|(_, gain)| *gain != comparison.gain)
                    && let Some(image) = difference(&self.frames, self.size, comparison.gain)
                {
                    let texture = ui.ctx().load_texture("difference", image, TextureOptions::LINEAR);
                    self.difference = Some((texture, comparison.gain));
                }
                self.difference.iter().for_each(|(texture, _)| part(texture.id(), 0.0, 1.0));
            }
            (&[_, kept], CompareMode::Kept) => part(kept, 0.0, 1.0),
            (&[now, ..], _) => part(now, 0.0, 1.0),
            ([], _) => {}
        }
    }
}

/// A picture with its grid points displaced by `moved`, in coordinates from -1 to 1, right and down.
fn mesh(texture: TextureId, place: Rect, moved: impl Fn([f32; 2]) -> [f32; 2]) -> Mesh {
    let mut mesh = Mesh::with_texture(texture);
    for row in 0..=GRID {
        for column in 0..=GRID {
            let [u, v] = [column, row].map(|line| line as f32 / GRID as f32);
            let [x, y] = moved([2.0 * u - 1.0, 2.0 * v - 1.0]);
            let pos = place.center() + 0.5 * Vec2::new(x * place.width(), y * place.height());
            mesh.vertices.push(Vertex { pos, uv: pos2(u, v), color: Color32::WHITE });
        }
    }
    for (row, column) in (0..GRID).flat_map(|row| (0..GRID).map(move |column| (row, column))) {
        let corner = row * (GRID + 1) + column;
        mesh.add_triangle(corner, corner + 1, corner + GRID + 1);
        mesh.add_triangle(corner + 1, corner + GRID + 2, corner + GRID + 1);
    }
    mesh
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture_support::random::SplitMix;

    #[test]
    fn the_table_of_codes_is_right_to_a_code() {
        for step in 0..=10_000 {
            let linear = step as f32 / 10_000.0;
            let exact = (linear_to_srgb(linear) * 255.0).round();
            assert!((code(linear).round() - exact).abs() <= 1.0, "{linear}");
        }
        assert_eq!([-1.0, 0.0, 1.0, 9.0].map(|linear| code(linear).round()), [0.0, 0.0, 255.0, 255.0]);
    }

    #[test]
    fn two_variants_have_a_difference_with_a_gain_and_one_has_none() {
        let [a, b]: [Frame; 2] = [[[0.5, 0.5, 0.5, 1.0]; 4].into(), [[0.5, 0.5, 0.6, 1.0]; 4].into()];
        assert!(difference(std::slice::from_ref(&a), [2, 2], 8.0).is_none());
        for gain in [1.0, 8.0] {
            let found = difference(&[a.clone(), b.clone()], [2, 2], gain).unwrap();
            assert_eq!(found.pixels, [Color32::from_rgb(0, 0, code(gain * 0.1).round() as u8); 4]);
        }
    }

    #[test]
    fn what_is_transparent_is_mixed_with_both_greys_as_light_is() {
        let mut random = SplitMix(3);
        for _ in 0..10_000 {
            let opacity = random.unit() as f32;
            let light = std::array::from_fn::<f32, 3, _>(|_| random.unit() as f32 * opacity);
            let pixel = [light[0], light[1], light[2], opacity];
            let [r, g, b, a] = shown(&pixel, None).to_array();
            for grey in CHECKERBOARD {
                let [behind, ..] = Color([grey; 3]).linear();
                for (own, light) in [r, g, b].into_iter().zip(light) {
                    let mixed = f32::from(own) + (1.0 - f32::from(a) / 255.0) * f32::from(grey);
                    let exact = 255.0 * linear_to_srgb(light + (1.0 - opacity) * behind);
                    assert!((mixed - exact).abs() < 5.0, "{pixel:?} over {grey}: {mixed} {exact}");
                }
            }
        }
        assert_eq!(shown(&[0.0; 4], None), Color32::TRANSPARENT);
        assert_eq!(shown(&[0.0, 0.0, 0.0, 1.0], None), Color32::BLACK);
        // A background hides the squares.
        let red = Some(Color([200, 0, 0]).linear());
        assert_eq!(shown(&[0.0; 4], red), Color32::from_rgb(200, 0, 0));
    }

    #[test]
    fn transparent_pictures_show_squares_of_whole_dots() {
        let place = Rect::from_min_max(pos2(100.0, 50.0), pos2(148.0, 80.0));
        let squares = |clear: bool, pixels_per_point: f32| {
            let mut screen = Screen::default();
            let pixel = if clear { [0.0; 4] } else { [0.0, 0.0, 0.0, 1.0] };
            let images = Encoded::Host(encode_srgb(&[&[pixel; 2]], &[None], [2, 1]));
            screen.take(images, vec![[pixel; 2].into()], [2, 1]);
            let context = egui::Context::default();
            context.set_pixels_per_point(pixels_per_point);
            let output = context.run_ui(egui::RawInput::default(), |ui| screen.draw(ui, place, &Comparison::default()));
            let meshes = output.shapes.iter().filter_map(|clipped| match &clipped.shape {
                Shape::Mesh(mesh) if mesh.texture_id == TextureId::default() => Some(mesh.vertices.clone()),
                _ => None,
            });
            let light = Color32::from_gray(CHECKERBOARD[1]);
            let corners = meshes.flatten().filter(|vertex| vertex.color == light).map(|vertex| vertex.pos);
            let corners: Vec<_> = corners.collect();
            output.drop_without_applying_deltas();
            corners
        };
        let all = squares(true, 1.0);
        assert_eq!(all.len(), 4 * 6, "4 columns, 3 rows");
        assert!(
            all.contains(&pos2(112.0, 62.0))
                && all.contains(&pos2(136.0, 80.0))
                && all.iter().all(|at| place.contains(*at))
        );
        assert!(squares(true, 2.0).len() > all.len() && squares(false, 1.0).is_empty());
    }

    #[test]
    fn of_two_pictures_each_has_its_side_of_the_line() {
        let frames: Vec<Frame> = vec![[[0.2; 4]; 4].into(), [[0.4; 4]; 4].into()];
        let place = Rect::from_min_max(pos2(100.0, 50.0), pos2(300.0, 150.0));
        let images = vec![ColorImage::filled([2, 2], Color32::RED), ColorImage::filled([2, 2], Color32::BLUE)];
        let mut screen = Screen::default();
        screen.take(Encoded::Host(images), frames, [2, 2]);
        let context = egui::Context::default();
        let mut drawn = |comparison: Comparison| {
            let output = context.run_ui(egui::RawInput::default(), |ui| screen.draw(ui, place, &comparison));
            let meshes = output.shapes.into_iter().filter_map(|clipped| match clipped.shape {
                egui::Shape::Mesh(mesh) => Some((mesh.texture_id, mesh.calc_bounds(), mesh.vertices[0].uv.x)),
                _ => None,
            });
            meshes.collect::<Vec<_>>()
        };
        let wipe = drawn(Comparison { mode: CompareMode::Wipe, at: 0.25, gain: 8.0 });
        let [(kept, left, from), (now, right, at)] = wipe[..] else { panic!("{wipe:?}") };
        assert_eq!((left.left(), left.right(), right.left(), right.right()), (100.0, 150.0, 150.0, 300.0));
        assert_eq!((from, at), (0.0, 0.25), "both are of the same place");
        let mut whole = |mode| match drawn(Comparison { mode, at: 0.25, gain: 8.0 })[..] {
            [(texture, rect, _)] if rect == place => texture,
            _ => panic!("one whole picture"),
        };
        let (only_now, only_kept, difference) =
            (whole(CompareMode::Now), whole(CompareMode::Kept), whole(CompareMode::Difference));
        assert_eq!((only_now, only_kept), (now, kept));
        assert!(difference != now && difference != kept);
    }
}
