//! Texels of a portable scene that no ray reads.

use super::{Portable, PortableImage};
use crate::gpu::Format;
use crate::render::variant::ObjectImage;
use crate::shader::suffixed;

/// Distance inside the hard region to which rays may look, object units.
const INNER_DISTANCE: f32 = 0.1;

impl Portable {
    /// Marks offsets to closest points that no ray reads: deep inside, and beyond the widest soft region. `None` for other
    /// images, and for objects whose stored distances are not of 16 bits beside normals.
    pub fn unread(&self, image: &PortableImage) -> Option<Vec<bool>> {
        if image.input != ObjectImage::Closest.into() {
            return None;
        }
        let is_volume = |own: &&PortableImage| own.input == ObjectImage::Volume.into() && own.object == image.object;
        let volume = self.images.iter().find(is_volume).filter(|own| own.format == Format::Rgba16Unorm)?;
        let suffix = if image.object.is_empty() { String::new() } else { format!("_{}", image.object) };
        let value = |name: &str| self.values.get(&suffixed(name, &suffix));
        let (decode, outer) = (value("distance_decode")?, suffixed("outer_iso_value", &suffix));
        let voxel =
            value("volume_texel")?.iter().zip(value("volume_scale")?).take(3).map(|(texel, scale)| texel / scale);
        let near = 2.0 * voxel.fold(0.0, f32::max);
        let tables = self.parameters.iter().filter_map(|own| own.follow.get(&outer));
        let widest = tables.flatten().chain(self.values.get(&outer)).flatten().copied().fold(0.0, f32::max);
        let read = value("iso_value")?[0] - near - INNER_DISTANCE..=widest + near;
        let code = |texel: &[u8; 8]| f32::from(u16::from_le_bytes([texel[6], texel[7]])) / 65535.0;
        let texels = volume.bytes.as_chunks().0.iter();
        Some(texels.map(|texel| !read.contains(&(decode[0] + decode[1] * code(texel)))).collect())
    }
}

#[cfg(all(test, feature = "glsl"))]
mod tests {
    use super::*;
    use crate::render::Subject;
    use crate::scene::preset;
    use crate::shader;

    #[test]
    fn offsets_near_the_surface_are_read() {
        let (library, mut scene) = (shader::shipped(), preset("fur").unwrap());
        (scene.object.input, scene.object.resolution) = ("dodecahedron".into(), 32);
        let subject = Subject::load(&scene, &library, &|_| ()).unwrap();
        let portable = Portable::of(&library, &scene, &subject, &|_| ()).unwrap();
        let marks = portable.images.iter().filter_map(|image| Some((image, portable.unread(image)?)));
        let marks: Vec<_> = marks.collect();
        let [(image, unread)] = marks.as_slice() else { panic!("{} images", marks.len()) };
        assert_eq!((image.input, image.object.as_str()), (ObjectImage::Closest.into(), ""));
        assert_eq!(unread.len() as u32, image.dimension.size().iter().product::<u32>());
        assert!(unread.contains(&true) && unread.contains(&false));
    }
}
