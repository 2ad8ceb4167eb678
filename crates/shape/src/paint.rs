//! Paint of a mesh: colors and textures of its materials. Readers take it up only where it is asked for.

use super::error::{Location, ShapeError};
use super::source::Source;
use super::texture::{Texture, Wrap};
use std::collections::HashMap;
use std::sync::Arc;

/// Most textures of a mesh.
const MAX_TEXTURES: usize = 256;

/// Materials of a mesh, and the place of each vertex in the texture of its own.
#[derive(Clone, Debug, Default)]
pub struct Paint {
    /// One for each vertex; empty without paint. The vertices of a triangle have the same material.
    pub(super) spots: Vec<Spot>,
    pub(super) materials: Vec<Material>,
}

/// Material of a vertex.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Spot {
    pub material: u32,
    /// Texture coordinates; v is 0 in the first row.
    pub uv: [f32; 2],
}

/// Color of a surface.
#[derive(Clone, Debug, Default)]
pub(super) struct Material {
    /// Linear RGB, a factor of the texture; `None` leaves the surface unpainted.
    pub color: Option<[f32; 3]>,
    pub texture: Option<Arc<Texture>>,
    pub wraps: [Wrap; 2],
}

/// Decoded textures of a file, by their names.
#[derive(Default)]
pub(super) struct Textures(HashMap<String, Arc<Texture>>);

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

impl Paint {
    /// Whether a material has a texture.
    pub fn is_textured(&self) -> bool {
        self.materials.iter().any(|material| material.texture.is_some())
    }

    /// Linear RGB of a point between the vertices of a triangle; `None` where it is unpainted.
    pub(super) fn color(&self, triangle: [u32; 3], mix: impl Fn([f32; 3]) -> f32) -> Option<[f32; 3]> {
        let spots = triangle.map(|corner| self.spots[corner as usize]);
        let material = &self.materials[spots[0].material as usize];
        let factor = material.color?;
        let Some(texture) = &material.texture else { return Some(factor) };
        let color = texture.sample([0, 1].map(|axis| mix(spots.map(|spot| spot.uv[axis]))), material.wraps);
        Some([0, 1, 2].map(|channel| factor[channel] * color[channel]))
    }
}

/// Checks that texture coordinates are finite.
pub(super) fn check_spots(source: &Source, spots: &[Spot]) -> Result<(), ShapeError> {
    let is_wrong = |spot: &Spot| !spot.uv.iter().all(|part| part.is_finite());
    let Some(first) = spots.iter().position(is_wrong) else { return Ok(()) };
    let count = spots.iter().filter(|spot| is_wrong(spot)).count();
    let (file, what, total) = (source.file.clone(), "texture coordinates", spots.len());
    Err(ShapeError::NotFinite { file, what, count, total, first })
}
