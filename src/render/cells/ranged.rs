//! Computed noise as bounds know it.
//!
//! Role: in a program that is evaluated over boxes, noise that is computed from hashes is replaced by one lookup, whose range
//! [`Lattice::range`] knows: bounds of a hash whose cell is not certain are those of all noise. Invariant: only of noise whose
//! text is as shipped, since that is what the range is of.

use crate::noise::{Lattice, Weights};
use crate::render::variant::{Variant, slot_of};
use crate::shader::{self, Library};

/// The image in whose place the noise stands, in programs that do not read it.
pub(crate) const LOOKED_UP: &str = "noise_image";
/// The modules that are replaced, by slot, with what replaces them.
const REPLACED: [(&str, &str); 2] =
    [("noise", include_str!("ranged_noise.glsl")), ("turbulence", include_str!("ranged_turbulence.glsl"))];
const COMPUTED: &str = "procedural";
/// What replaces them is called.
const NAME: &str = "ranged";
/// What the noise is made of.
const TEXTS: [&str; 6] = [
    "noise/procedural.glsl",
    "turbulence/procedural.glsl",
    "lattice_noise.glsl",
    "corners.glsl",
    "weights/cubic.glsl",
    "weights/quintic.glsl",
];

/// The modules that bounds are taken of in place of these, in a library that has them, and the noise that they look up; none
/// where no noise is computed, or it is not known as well.
pub(crate) fn ranged(variant: &Variant, library: &Library) -> Option<(Variant, Library, Lattice)> {
    let shipped = shader::shipped();
    if TEXTS.iter().any(|path| library.source(path) != shipped.source(path)) {
        return None;
    }
    // Whoever reads the block itself, as a module of a person may, reads it under this name.
    let reads_block =
        |path: &str, text: &str| path != "interface.glsl" && (text.contains(LOOKED_UP) || text.contains("noise_block"));
    if library.sources().any(|(path, text)| reads_block(path, text) && variant.reaches(library, path)) {
        return None;
    }
    // All modules of a slot, of whichever object.
    let are = |slot: &str, module: &str| {
        let mut of = variant.slots.iter().filter(|(key, _)| slot_of(key) == slot);
        of.all(|(_, names)| names.as_slice() == [module])
    };
    if !REPLACED.iter().all(|(slot, _)| are(slot, COMPUTED)) {
        return None;
    }
    let weights = [("cubic", Weights::Cubic), ("quintic", Weights::Quintic)];
    let (_, weights) = weights.into_iter().find(|(module, _)| variant.reads("weights") && are("weights", module))?;
    let (mut variant, mut library) = (variant.clone(), library.clone());
    for (slot, text) in REPLACED {
        library = library.with_module(slot, NAME, text);
        let own = variant.slots.iter_mut().filter(|(key, _)| slot_of(key) == slot);
        own.for_each(|(_, names)| *names = vec![NAME.into()]);
    }
    Some((variant, library, Lattice { weights }))
}
