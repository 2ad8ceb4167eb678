//! Paint of a mesh: colors and textures of its materials. Readers take it up only where it is asked for.

use super::texture::{Texture, Wrap};
use std::sync::Arc;

/// Materials of a mesh, and the place of each vertex in the texture of its own.
#[derive(Clone, Debug, Default)]
pub struct Paint {
    /// One for each vertex; empty without paint. The vertices of a triangle have the same material.
    pub(crate) spots: Vec<Spot>,
    pub(crate) materials: Vec<Material>,
}

/// Material of a vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Spot {
    pub material: u32,
    /// Texture coordinates; v is 0 in the first row.
    pub uv: [f32; 2],
}

/// Color of a surface.
#[derive(Clone, Debug, Default)]
pub(crate) struct Material {
    /// Linear RGB, a factor of the texture; `None` leaves the surface unpainted.
    pub color: Option<[f32; 3]>,
    pub texture: Option<Arc<Texture>>,
    pub wraps: [Wrap; 2],
}

impl Paint {
    /// Whether a material has a texture.
    pub fn is_textured(&self) -> bool {
        self.materials.iter().any(|material| material.texture.is_some())
    }

    /// Linear RGB of a point between the vertices of a triangle; `None` where it is unpainted.
    pub(crate) fn color(&self, triangle: [u32; 3], mix: impl Fn([f32; 3]) -> f32) -> Option<[f32; 3]> {
        let spots = triangle.map(|corner| self.spots[corner as usize]);
        let material = &self.materials[spots[0].material as usize];
        let factor = material.color?;
        let Some(texture) = &material.texture else { return Some(factor) };
        let color = texture.sample([0, 1].map(|axis| mix(spots.map(|spot| spot.uv[axis]))), material.wraps);
        Some([0, 1, 2].map(|channel| factor[channel] * color[channel]))
    }
}
