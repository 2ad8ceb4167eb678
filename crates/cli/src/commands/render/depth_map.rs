//! `render --depth-map`: the depth of each pixel in an EXR file for compositors.

use super::picture::Picture;
use crate::session::Prepared;
use crate::terminal::absolute;
use hypertexture::output::write_map;
use hypertexture::render::Renderer;
use hypertexture::render::variant::Variant;
use serde_json::{Value, json};
use std::error::Error;
use std::path::Path;

/// Writes the depth of a picture as channel `Z` of an EXR: see [`Renderer::render_depth`].
pub(crate) fn write_depth_map(picture: &Picture<'_>, path: &Path) -> Result<Value, Box<dyn Error>> {
    let Picture { gpu, prepared: Prepared { library, subject, .. }, variant: Variant { scene, .. }, tell, .. } =
        *picture;
    let depth = Renderer::new(gpu, library, subject).render_depth(scene)?;
    let seen = || depth.iter().copied().filter(|depth| depth.is_finite());
    let (pixels, ends) = (seen().count(), seen().reduce(f32::min).zip(seen().reduce(f32::max)));
    let range = ends.map_or(String::new(), |(near, far)| format!(" is {near:.4} to {far:.4} object units"));
    write_map(path, scene.image.size, &[("Z", depth)])?;
    tell(&format!("depth      of {pixels} pixels{range}; infinite elsewhere\nwrote {}\n", absolute(path)));
    Ok(json!({ "pixels": pixels, "nearest": ends.map(|(near, _)| near), "farthest": ends.map(|(_, far)| far) }))
}
