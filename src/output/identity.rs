//! Hashes that identify the pixels of a scene.

use crate::render::variant::Checkable;
use crate::render::{RenderError, Subject};
use crate::scene::{self, Scene};
use crate::shader::{Library, Linker};
use blake3::Hash;

/// Hash of everything but the device that determines the pixels of a scene: the scene, its program, the content of the
/// object (not its path), and the version of this crate.
///
/// # Errors
/// The scene has no valid program.
pub fn identity(scene: &impl Checkable, library: &Library, subject: &Subject) -> Result<Hash, RenderError> {
    let variant = scene.checked(library)?;
    let program = variant.program(library, Linker::new)?;
    Ok(identity_by(
        &variant.scene,
        subject,
        &[&program.vertex, &program.fragment].map(|words| bytemuck::cast_slice(words)),
    ))
}

/// A cheaper identity, by the texts of the library in place of the linked program, which saves up to a second. It also changes
/// with texts that the program does not use.
///
/// # Errors
/// The scene is not valid.
pub fn identity_of_texts(scene: &impl Checkable, library: &Library, subject: &Subject) -> Result<Hash, RenderError> {
    let variant = scene.checked(library)?;
    Ok(identity_by(&variant.scene, subject, &[variant.text_hash(library).as_bytes()]))
}

fn identity_by(scene: &Scene, subject: &Subject, program: &[&[u8]]) -> Hash {
    let mut named = scene.clone();
    named.modules.clear(); // the program contains them
    let mut hash = blake3::Hasher::new();
    hash.update(concat!("hypertexture ", env!("CARGO_PKG_VERSION"), "\n").as_bytes());
    let further = named.parts.iter_mut().map(|(name, part)| (&mut part.object, &subject.parts[name]));
    for (object, subject) in [(&mut named.object, subject)].into_iter().chain(further) {
        let Some(field) = &subject.field else { continue };
        object.input.clear();
        hash.update(bytemuck::cast_slice(&field.grid.size));
        hash.update(bytemuck::cast_slice(&[field.grid.origin.to_array(), field.grid.spacing.to_array()]));
        hash.update(bytemuck::cast_slice(&field.values));
    }
    hash.update(scene::to_text(&named).as_bytes());
    for part in program {
        hash.update(part);
    }
    hash.finalize()
}
