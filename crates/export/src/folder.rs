//! The files of `hypertexture export`.

use crate::describe::describe;
use crate::wgsl::{constant, wgsl};
use crate::{ExportError, File};
use hypertexture::render::{Portable, PortableImage};

/// GLSL, SPIR-V, WGSL and texels of a scene, and `scene.json`, which describes them.
///
/// # Errors
/// [`ExportError::Wgsl`].
pub fn folder(portable: &Portable, command: &str) -> Result<Vec<File>, ExportError> {
    let bytes = |words: &[u32]| words.iter().flat_map(|word| word.to_le_bytes()).collect::<Vec<u8>>();
    let mut files = vec![("screen.spv".into(), bytes(&portable.programs[0].program.vertex))];
    for own in &portable.programs {
        let spirv = constant(portable, own)?;
        let name = own.name;
        files.push((format!("{name}.frag"), own.glsl.clone().into_bytes()));
        files.push((format!("{name}.wgsl"), wgsl(name, &spirv)?.into_bytes()));
        files.push((format!("{name}.spv"), bytes(&spirv)));
    }
    let file = |image: &PortableImage| format!("{}.bin", image.name);
    files.extend(portable.images.iter().map(|image| (file(image), image.bytes.clone())));
    let text = format!("{:#}\n", describe(portable, command, |image| file(image).into()));
    files.push(("scene.json".into(), text.into_bytes()));
    Ok(files)
}
