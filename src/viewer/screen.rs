//! How a picture gets on the screen: its colors and its place.

use super::compare::{Comparison, Half};
use crate::render::Sight;
use crate::scene::{Color, linear_to_srgb};
use egui::epaint::Vertex;
use egui::{Color32, ColorImage, Mesh, Rect, Shape, TextureHandle, TextureId, TextureOptions, Ui, Vec2, pos2};
use rayon::prelude::*;
use std::sync::{Arc, LazyLock};

/// The greys of the checkerboard behind a picture without a background: dark, so that what glows is seen.
const BEHIND: [u8; 2] = [28, 42];
/// Side of its squares, in pixels of the whole picture.
const SQUARE: u32 = 12;
/// Cells along a side of a picture that is moved. Fewer: edges bend where the cells meet.
const GRID: u32 = 32;
/// Entries of the table of codes, by the square root of the light: the darkest codes are the closest.
const TABLE: usize = 4096;

/// Codes of linear light, by its square root.
static CODES: LazyLock<Vec<u8>> = LazyLock::new(|| {
    let code = |index: usize| {
        let root = (index as f32 + 0.5) / TABLE as f32;
        (linear_to_srgb(root * root) * 255.0).round() as u8
    };
    (0..TABLE).map(code).collect()
});

fn code(linear: f32) -> u8 {
    CODES[((linear.clamp(0.0, 1.0).sqrt() * TABLE as f32) as usize).min(TABLE - 1)]
}

/// A picture over its background, or over a checkerboard. `whole` is the size that it stands for, which may be larger.
fn opaque(frame: &[[f32; 4]], background: Option<Color>, size: [u32; 2], whole: [u32; 2]) -> Vec<[f32; 3]> {
    let [dark, light] = BEHIND.map(|grey| Color([grey; 3]).linear());
    let square = |index: u32, axis: usize| {
        let at = (u64::from(2 * index + 1) * u64::from(whole[axis])) / (2 * u64::from(size[axis].max(1)));
        at / u64::from(SQUARE) % 2
    };
    let columns: Vec<u64> = (0..size[0]).map(|column| square(column, 0)).collect();
    let over = |pixel: &[f32; 4], behind: [f32; 3]| [0, 1, 2].map(|c| pixel[c] + (1.0 - pixel[3]) * behind[c]);
    let rows = frame.par_chunks(size[0].max(1) as usize).enumerate();
    let row = |(row, pixels): (usize, &[[f32; 4]])| -> Vec<[f32; 3]> {
        let odd = square(row as u32, 1);
        let behind = |column: &u64| background.map_or(if *column == odd { dark } else { light }, Color::linear);
        pixels.iter().zip(&columns).map(|(pixel, column)| over(pixel, behind(column))).collect()
    };
    rows.map(row).flatten_iter().collect()
}

fn image(light: &[[f32; 3]], size: [u32; 2]) -> ColorImage {
    let pixels = light.par_iter().map(|&[r, g, b]| Color32::from_rgb(code(r), code(g), code(b)));
    ColorImage::new(size.map(|side| side as usize), pixels.collect())
}

/// Pictures over their backgrounds as codes; `whole` is the size that they stand for.
pub(super) fn encode_srgb(
    frames: &[&[[f32; 4]]],
    backgrounds: &[Option<Color>],
    size: [u32; 2],
    whole: [u32; 2],
) -> Vec<ColorImage> {
    let pairs = frames.iter().zip(backgrounds);
    pairs.map(|(frame, background)| image(&opaque(frame, *background, size, whole), size)).collect()
}

/// What lies between two pictures, enlarged: of each channel, or of opacity where that is more.
fn difference(frames: &[Frame], size: [u32; 2], gain: f32) -> Option<ColorImage> {
    let [a, b] = frames else { return None };
    let apart = a.par_iter().zip(b.par_iter()).map(|(a, b)| {
        let opacity = (a[3] - b[3]).abs();
        [0, 1, 2].map(|c| gain * (a[c] - b[c]).abs().max(opacity))
    });
    Some(image(&apart.collect::<Vec<_>>(), size))
}

/// Premultiplied linear RGBA, row by row from the top.
pub(super) type Frame = Arc<[[f32; 4]]>;

/// The pictures on the screen.
#[derive(Default)]
pub(super) struct Screen {
    textures: Vec<TextureHandle>,
    /// What came and is not a texture yet, or was one of a device that is gone.
    images: Vec<ColorImage>,
    fresh: bool,
    /// The pictures as they were rendered, one for each variant, and their size.
    pub(super) frames: Vec<Frame>,
    pub(super) size: [u32; 2],
    /// Where they are looked at from, and where they would be now, where that is another place.
    pub(super) moved: Option<(Sight, Sight)>,
    /// The texture of their difference, and its gain.
    difference: Option<(TextureHandle, f32)>,
}

impl Screen {
    /// Takes the images of a picture, and what they are of.
    pub(super) fn take(&mut self, images: Vec<ColorImage>, frames: Vec<Frame>, size: [u32; 2]) {
        (self.images, self.frames, self.size) = (images, frames, size);
        (self.fresh, self.difference) = (true, None);
    }

    /// Forgets the textures: their device is gone.
    pub(super) fn forget(&mut self) {
        self.textures.clear();
        (self.fresh, self.difference) = (true, None);
    }

    /// Draws the picture, or two as `comparison` says; as it would be seen now, about, where it was moved since.
    pub(super) fn draw(&mut self, ui: &Ui, place: Rect, comparison: &Comparison) {
        if std::mem::take(&mut self.fresh) {
            for (index, image) in self.images.iter().enumerate() {
                match self.textures.get_mut(index) {
                    Some(texture) => texture.set(image.clone(), TextureOptions::LINEAR),
                    None => {
                        let name = format!("picture {index}");
                        self.textures.push(ui.ctx().load_texture(name, image.clone(), TextureOptions::LINEAR));
                    }
                }
            }
            self.textures.truncate(self.images.len());
        }
        let painter = ui.painter_at(place);
        // A picture that was moved leaves gaps at its sides, where its corner is.
        let corner = self.images.first().and_then(|image| image.pixels.first());
        painter.rect_filled(place, 0.0, corner.copied().unwrap_or(Color32::from_gray(BEHIND[0])));
        let part = |texture: &TextureHandle, from: f32, to: f32| {
            let within = |part: f32| egui::lerp(place.x_range(), part);
            let rect = Rect::from_x_y_ranges(within(from)..=within(to), place.y_range());
            let uv = Rect::from_min_max(pos2(from, 0.0), pos2(to, 1.0));
            match self.moved {
                None => painter.image(texture.id(), rect, uv, Color32::WHITE),
                Some((seen, now)) => {
                    let mesh = mesh(texture.id(), place, |at| seen.moved(&now, at));
                    painter.with_clip_rect(rect).add(Shape::mesh(mesh))
                }
            };
        };
        match (self.textures.as_slice(), comparison.half) {
            ([now, kept], Half::Wipe) => {
                part(kept, 0.0, comparison.at);
                part(now, comparison.at, 1.0);
            }
            ([_, _], Half::Difference) => {
                if self.difference.as_ref().is_none_or(|(_, gain)| *gain != comparison.gain)
                    && let Some(image) = difference(&self.frames, self.size, comparison.gain)
                {
                    let texture = ui.ctx().load_texture("difference", image, TextureOptions::LINEAR);
                    self.difference = Some((texture, comparison.gain));
                }
                self.difference.iter().for_each(|(texture, _)| part(texture, 0.0, 1.0));
            }
            ([_, kept], Half::Kept) => part(kept, 0.0, 1.0),
            ([now, ..], _) => part(now, 0.0, 1.0),
            ([], _) => {}
        }
    }
}

/// A picture in a place, whose points are `moved`; from -1 to 1, to the right and down.
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

    #[test]
    fn the_table_of_codes_is_right_to_a_code() {
        for step in 0..=10_000 {
            let linear = step as f32 / 10_000.0;
            let exact = (linear_to_srgb(linear) * 255.0).round();
            assert!((f32::from(code(linear)) - exact).abs() <= 1.0, "{linear}");
        }
        assert_eq!([code(-1.0), code(0.0), code(1.0), code(9.0)], [0, 0, 255, 255]);
    }

    #[test]
    fn two_variants_have_a_difference_with_a_gain_and_one_has_none() {
        let [a, b]: [Frame; 2] = [[[0.5, 0.5, 0.5, 1.0]; 4].into(), [[0.5, 0.5, 0.6, 1.0]; 4].into()];
        assert!(difference(std::slice::from_ref(&a), [2, 2], 8.0).is_none());
        for gain in [1.0, 8.0] {
            let found = difference(&[a.clone(), b.clone()], [2, 2], gain).unwrap();
            assert_eq!(found.pixels, [Color32::from_rgb(0, 0, code(gain * 0.1)); 4]);
        }
    }

    #[test]
    fn behind_what_is_transparent_are_squares_that_stay_where_they_are_in_a_coarse_picture() {
        let clear = |size: [u32; 2]| vec![[0.0; 4]; (size[0] * size[1]) as usize];
        let of = |size| encode_srgb(&[&clear(size)], &[None], size, [96, 48]).remove(0);
        let (whole, coarse) = (of([96, 48]), of([16, 8]));
        let [dark, light] = BEHIND.map(Color32::from_gray);
        let grey = |x: u32, y: u32| if (x / SQUARE + y / SQUARE).is_multiple_of(2) { dark } else { light };
        let near = |a: Color32, b: Color32| a.r().abs_diff(b.r()) <= 1;
        for (x, y) in [(0, 0), (11, 0), (12, 0), (12, 12), (95, 47), (30, 20)] {
            assert!(near(whole[(x as usize, y as usize)], grey(x, y)), "{x} {y}");
            let [cx, cy] = [x / 6, y / 6];
            assert!(near(coarse[(cx as usize, cy as usize)], grey(6 * cx + 3, 6 * cy + 3)), "{x} {y}");
        }
        // A background hides them, and so does what is opaque.
        let red = Some(Color([200, 0, 0]));
        let over = encode_srgb(&[&clear([4, 4])], &[red], [4, 4], [96, 48]).remove(0);
        assert!(over.pixels.iter().all(|pixel| *pixel == over.pixels[0]));
        let full = encode_srgb(&[&[[0.0, 0.0, 0.0, 1.0]; 16]], &[None], [4, 4], [96, 48]).remove(0);
        assert!(full.pixels.iter().all(|pixel| *pixel == Color32::BLACK));
    }

    #[test]
    fn of_two_pictures_each_has_its_side_of_the_line() {
        let frames: Vec<Frame> = vec![[[0.2; 4]; 4].into(), [[0.4; 4]; 4].into()];
        let place = Rect::from_min_max(pos2(100.0, 50.0), pos2(300.0, 150.0));
        let images = vec![ColorImage::filled([2, 2], Color32::RED), ColorImage::filled([2, 2], Color32::BLUE)];
        let mut screen = Screen::default();
        screen.take(images, frames, [2, 2]);
        let context = egui::Context::default();
        let mut drawn = |comparison: Comparison| {
            let output = context.run_ui(egui::RawInput::default(), |ui| screen.draw(ui, place, &comparison));
            let meshes = output.shapes.into_iter().filter_map(|clipped| match clipped.shape {
                egui::Shape::Mesh(mesh) => Some((mesh.texture_id, mesh.calc_bounds(), mesh.vertices[0].uv.x)),
                _ => None,
            });
            meshes.collect::<Vec<_>>()
        };
        let wipe = drawn(Comparison { half: Half::Wipe, at: 0.25, gain: 8.0 });
        let [(kept, left, from), (now, right, at)] = wipe[..] else { panic!("{wipe:?}") };
        assert_eq!((left.left(), left.right(), right.left(), right.right()), (100.0, 150.0, 150.0, 300.0));
        assert_eq!((from, at), (0.0, 0.25), "both are of the same place");
        let mut whole = |half| match drawn(Comparison { half, at: 0.25, gain: 8.0 })[..] {
            [(texture, rect, _)] if rect == place => texture,
            _ => panic!("one whole picture"),
        };
        let (only_now, only_kept, difference) = (whole(Half::Now), whole(Half::Kept), whole(Half::Difference));
        assert_eq!((only_now, only_kept), (now, kept));
        assert!(difference != now && difference != kept);
    }
}
