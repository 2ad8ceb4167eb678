//! Computed noise as bounds know it.
//!
//! Role: in a program that is evaluated over boxes, noise that is computed in place, of hashes or of tables, is replaced by one
//! lookup, whose range [`Lattice::range`] knows: bounds of a hash whose cell is not certain are those of all noise. What sums
//! octaves of it stays as it is. Invariant: only of noise whose text is as shipped, since that is what the range is of.

use crate::noise::{Lattice, Weights};
use crate::render::inputs::CELLS;
use crate::render::variant::{Program, Variant, slot_of};
use crate::shader::{self, Library};

/// The image in whose place the noise stands: a program that decides about cells does not read them.
pub const LOOKED_UP: &str = CELLS;
/// What the texts below call it.
const NAME: &str = "cell_grid";
/// The files that are replaced, with what replaces them. The level of a lookup is that of
/// [`Knots::of_level`](crate::noise::Knots::of_level).
const REPLACED: [(&str, &str); 4] = [
    ("lattice_noise.glsl", include_str!("ranged_lattice.glsl")),
    ("array_noise.glsl", "vec4 array_noise(vec3 p) { return textureLod(cell_grid, p, 0.0); }\n"),
    ("table_noise.glsl", "vec4 table_noise(vec3 p) { return textureLod(cell_grid, p, 0.0); }\n"),
    (
        "noise/wavelet.glsl",
        "#define NOISE_MEAN MEAN_OF_VALUES\nvec4 noise_gradient(vec3 p) { return textureLod(cell_grid, p, -1.0); }\n\
         float noise(vec3 p) { return noise_gradient(p).w; }\n",
    ),
];
/// What these include that ranges depend on.
const INCLUDED: [&str; 5] =
    ["corners.glsl", "hash.glsl", "noise_tables.glsl", "weights/cubic.glsl", "weights/quintic.glsl"];

/// The program of these modules that bounds are taken of, and the noise that it looks up; none where that is the program
/// which is drawn.
pub fn bounded(variant: &Variant, library: &Library) -> Option<(Program, Lattice)> {
    let (own, noise) = ranged(variant, library)?;
    // A module of a person may use more of a file than what replaces it has.
    Some((variant.program_of(library, own).ok()?, noise))
}

/// The library that bounds of these modules are taken of, and the noise that it looks up; none where no noise is computed,
/// or it is not known as well.
pub(super) fn ranged(variant: &Variant, library: &Library) -> Option<(Library, Lattice)> {
    let replaced = REPLACED.map(|(path, _)| path);
    if !replaced.iter().any(|path| variant.reaches(library, path)) {
        return None;
    }
    let shipped = shader::shipped();
    let differs = |path: &str| library.source(path) != shipped.source(path);
    if replaced.into_iter().chain(INCLUDED).any(differs) {
        return None;
    }
    // A module of a person may read cells.
    let reads_cells = |text: &str| text.contains(NAME) || text.contains(LOOKED_UP);
    if library.sources().any(|(path, text)| reads_cells(text) && differs(path)) {
        return None;
    }
    // Of all objects.
    let are = |module: &str| {
        let mut of = variant.slots.iter().filter(|(key, _)| slot_of(key) == "weights");
        of.all(|(_, names)| names.as_slice() == [module])
    };
    let weights = [("cubic", Weights::Cubic), ("quintic", Weights::Quintic)];
    let (_, weights) = weights.into_iter().find(|(module, _)| variant.reads("weights") && are(module))?;
    let library = REPLACED.iter().fold(library.clone(), |library, (path, text)| library.with_file(path, text));
    Some((library, Lattice { weights }))
}
