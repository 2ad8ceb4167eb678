//! The meshes of egui, drawn as triangles of a [`gpu::Canvas`].

use egui::epaint::{ImageData, ImageDelta, Primitive};
use egui::{ClippedPrimitive, Color32, ColorImage, TextureId, TexturesDelta};
use hypertexture::gpu::{self, Area, Batch, CanvasTexture, Gpu, GpuError, Image};
use hypertexture::gpu::{Options, Presented, Vertex, WindowHandle};
use std::sync::Arc;

/// A device that draws egui into a window.
pub struct Canvas {
    canvas: gpu::Canvas,
    /// The font texture, of which egui sends parts.
    glyphs: Option<ColorImage>,
}

impl Canvas {
    /// Opens the best device that can draw into a window.
    ///
    /// # Errors
    /// Those of [`gpu::Canvas::open`].
    pub fn open(options: &Options, window: Arc<dyn WindowHandle>) -> Result<Canvas, GpuError> {
        Ok(Canvas { canvas: gpu::Canvas::open(options, window)?, glyphs: None })
    }

    /// The device.
    pub fn gpu(&self) -> &Gpu {
        self.canvas.gpu()
    }

    /// Draws a frame of egui into a window of `size` pixels. Textures are updated in any case, as egui sends a change once.
    /// `pictures` are the user's textures of egui.
    ///
    /// # Errors
    /// Those of [`gpu::Canvas::draw`].
    pub fn draw(
        &mut self,
        size: [u32; 2],
        mut changes: TexturesDelta,
        primitives: &[ClippedPrimitive],
        pixels_per_point: f32,
        pictures: &[Arc<Image>],
    ) -> Result<Presented, GpuError> {
        let mut textures = Vec::new();
        for (id, deltas) in changes.set.drain() {
            for delta in deltas {
                let delta = self.whole(id, delta);
                let ImageData::Color(image) = &delta.image;
                let size = image.size.map(|side| side as u32);
                let texels = image.pixels.iter().flat_map(Color32::to_array).collect();
                textures.push(CanvasTexture { id: number(id), size, texels });
            }
        }
        let freed: Vec<u64> = changes.free.drain().map(number).collect();
        let pictures = (0..).zip(pictures).map(|(index, image)| (number(TextureId::User(index)), image.clone()));
        self.canvas.draw(size, &textures, freed, pictures, |size| triangles(primitives, size, pixels_per_point))
    }

    /// Completes a partial update of the font texture.
    fn whole(&mut self, id: TextureId, delta: ImageDelta) -> ImageDelta {
        if id != TextureId::default() {
            return delta;
        }
        let ImageData::Color(part) = &delta.image;
        match (delta.pos, &mut self.glyphs) {
            (Some([left, top]), Some(glyphs)) => {
                let [width, height] = part.size;
                for row in 0..height {
                    let to = (top + row) * glyphs.size[0] + left;
                    glyphs.pixels[to..to + width].copy_from_slice(&part.pixels[row * width..(row + 1) * width]);
                }
                ImageDelta::full(glyphs.clone(), delta.options)
            }
            _ => {
                self.glyphs = Some((**part).clone());
                delta
            }
        }
    }
}

fn number(id: TextureId) -> u64 {
    match id {
        TextureId::Managed(number) => 2 * number,
        TextureId::User(number) => 2 * number + 1,
    }
}

/// The triangles of egui in an image of this size, and their batches.
fn triangles(primitives: &[ClippedPrimitive], size: [u32; 2], pixels_per_point: f32) -> (Vec<Vertex>, Vec<Batch>) {
    let (mut vertices, mut batches) = (Vec::new(), Vec::new());
    let [x, y] = size.map(|side| 2.0 * pixels_per_point / side as f32);
    for ClippedPrimitive { clip_rect, primitive } in primitives {
        let Primitive::Mesh(mesh) = primitive else { continue };
        let range = |from: f32, to: f32, side: u32| {
            let [from, to] = [from, to].map(|edge| (edge * pixels_per_point).round().clamp(0.0, side as f32) as u32);
            from..to.max(from)
        };
        let columns = range(clip_rect.min.x, clip_rect.max.x, size[0]);
        let rows = range(clip_rect.min.y, clip_rect.max.y, size[1]);
        let area = Area { columns, rows };
        if area.pixels() == 0 {
            continue;
        }
        let first = vertices.len() as u32;
        vertices.extend(mesh.indices.iter().filter_map(|index| mesh.vertices.get(*index as usize)).map(|vertex| {
            let [r, g, b, a] = vertex.color.to_array().map(|code| f32::from(code) / 255.0);
            [x * vertex.pos.x - 1.0, y * vertex.pos.y - 1.0, vertex.uv.x, vertex.uv.y, r, g, b, a]
        }));
        batches.push(Batch { texture: number(mesh.texture_id), area, vertices: first..vertices.len() as u32 });
    }
    (vertices, batches)
}
