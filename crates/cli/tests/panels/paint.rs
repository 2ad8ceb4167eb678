//! A software painter for egui, for screenshots without a window or a device.

use egui::epaint::{ImageData, Primitive, Vertex};
use egui::{Color32, Context, FullOutput, TextureId, TexturesDelta};
use std::cell::RefCell;
use std::collections::HashMap;
use std::path::Path;
use std::rc::Rc;

type Texture = (usize, Vec<Color32>);

/// The textures of a context, shared with the harness.
#[derive(Clone, Default)]
pub struct Painter(Rc<RefCell<HashMap<TextureId, Texture>>>);

impl egui_kittest::TestRenderer for Painter {
    fn handle_delta(&mut self, delta: &mut TexturesDelta) {
        let mut textures = self.0.borrow_mut();
        for (id, deltas) in delta.set.drain() {
            for delta in deltas {
                let ImageData::Color(image) = &delta.image;
                let [width, height] = image.size;
                let [left, top] = delta.pos.unwrap_or([0, 0]);
                let texture = textures.entry(id).or_default();
                if delta.pos.is_none() {
                    *texture = (width, vec![Color32::TRANSPARENT; width * height]);
                }
                for (row, pixels) in image.pixels.chunks_exact(width).enumerate() {
                    let start = (top + row) * texture.0 + left;
                    texture.1[start..start + width].copy_from_slice(pixels);
                }
            }
        }
        delta.clear();
    }
}

impl Painter {
    /// Writes a picture as PNG.
    pub fn write(&self, context: &Context, output: &FullOutput, [width, height]: [usize; 2], path: &Path) {
        let mut pixels = vec![Color32::from_gray(18); width * height];
        let textures = self.0.borrow();
        for piece in context.tessellate(output.shapes.clone(), 1.0) {
            let Primitive::Mesh(mesh) = &piece.primitive else { continue };
            let clip = piece.clip_rect;
            let [left, top] = [clip.left(), clip.top()].map(|side| side.round().max(0.0) as usize);
            let right = (clip.right().round().max(0.0) as usize).min(width);
            let bottom = (clip.bottom().round().max(0.0) as usize).min(height);
            for triangle in mesh.indices.chunks_exact(3) {
                let corners = [0, 1, 2].map(|corner| mesh.vertices[triangle[corner] as usize]);
                let texture = &textures[&mesh.texture_id];
                fill(&mut pixels, width, [left, top, right, bottom], corners, texture);
            }
        }
        let bytes: Vec<u8> = pixels.iter().flat_map(|color| [color.r(), color.g(), color.b()]).collect();
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        image::save_buffer(path, &bytes, width as u32, height as u32, image::ColorType::Rgb8).unwrap();
    }
}

fn fill(pixels: &mut [Color32], width: usize, clip: [usize; 4], corners: [Vertex; 3], texture: &Texture) {
    let [a, b, c] = corners.map(|corner| corner.pos);
    let area = |p: egui::Pos2, q: egui::Pos2, r: egui::Pos2| (q.x - p.x) * (r.y - p.y) - (q.y - p.y) * (r.x - p.x);
    let whole = area(a, b, c);
    if whole == 0.0 {
        return;
    }
    let [low, high] = [f32::min, f32::max].map(|pick| [pick(pick(a.x, b.x), c.x), pick(pick(a.y, b.y), c.y)]);
    let (height, at) = (texture.1.len() / texture.0, |value: f32| value.floor().max(0.0) as usize);
    for y in at(low[1]).max(clip[1])..(at(high[1]) + 1).min(clip[3]) {
        for x in at(low[0]).max(clip[0])..(at(high[0]) + 1).min(clip[2]) {
            let p = egui::pos2(x as f32 + 0.5, y as f32 + 0.5);
            let weights = [area(p, b, c) / whole, area(a, p, c) / whole, area(a, b, p) / whole];
            if weights.iter().any(|weight| *weight < 0.0) {
                continue;
            }
            let mean = |of: &dyn Fn(&Vertex) -> f32| {
                corners.iter().zip(weights).map(|(v, weight)| of(v) * weight).sum::<f32>()
            };
            let texel = |value: f32, side: usize| ((value * side as f32) as usize).min(side - 1);
            let (u, v) = (texel(mean(&|v| v.uv.x), texture.0), texel(mean(&|v| v.uv.y), height));
            let sample = texture.1[v * texture.0 + u].to_array();
            let below = &mut pixels[y * width + x];
            let mut mixed = [0; 4];
            let alpha = mean(&|v| f32::from(v.color.a())) / 255.0 * f32::from(sample[3]) / 255.0;
            for (channel, mixed) in mixed.iter_mut().enumerate() {
                let above = mean(&|v| f32::from(v.color.to_array()[channel])) * f32::from(sample[channel]) / 255.0;
                *mixed = (above + f32::from(below.to_array()[channel]) * (1.0 - alpha)).round().min(255.0) as u8;
            }
            *below = Color32::from_rgba_premultiplied(mixed[0], mixed[1], mixed[2], mixed[3]);
        }
    }
}
