//! Bounds of computed noise.
//!
//! Role: in a program that is evaluated over boxes, noise computed from hashes or tables is replaced by one lookup,
//! whose range [`Lattice::range`] gives: over a box of several lattice cells, bounds of a hash are those of all noise.
//! Sums of octaves stay. Invariant: only shipped noise is replaced, since the range belongs to its text.

use crate::noise::{Lattice, Weights};
use crate::render::variant::{PassImage, Program, Variant, slot_of};
use crate::shader::{self, Library, find_word};

/// Image of the replaced noise. Programs that decide about cells do not read the cell grid.
pub const LOOKED_UP: PassImage = PassImage::Cells;
/// Name of the image's accessor in GLSL.
const NAME: &str = "cell_grid";
/// Replaced files and their replacements. The level of a lookup is that of
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
/// Included files that the ranges depend on.
const INCLUDED: [&str; 5] =
    ["corners.glsl", "hash.glsl", "noise_tables.glsl", "weights/cubic.glsl", "weights/quintic.glsl"];

/// The program for bounds and the noise that it looks up; `None` if the drawn program serves.
pub fn bounded(variant: &Variant, library: &Library) -> Option<(Program, Lattice)> {
    let (own, noise) = ranged(variant, library)?;
    // A custom module may use parts of a file that the replacement lacks.
    Some((variant.program_of(library, own).ok()?, noise))
}

/// The library for bounds and the noise that it looks up; `None` if no noise is computed, or if its range is unknown.
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
    // A custom module may read cells.
    let names_cells = |text: &str| find_word(text, |word| word == NAME || word == LOOKED_UP.binding()).is_some();
    if library.sources().any(|(path, text)| differs(path) && names_cells(text)) {
        return None;
    }
    let are = |module: &str| {
        let mut of = variant.slots.iter().filter(|(key, _)| slot_of(key) == "weights");
        of.all(|(_, names)| names.as_slice() == [module])
    };
    let weights = [("cubic", Weights::Cubic), ("quintic", Weights::Quintic)];
    let (_, weights) = weights.into_iter().find(|(module, _)| variant.reads("weights") && are(module))?;
    let library = REPLACED.iter().fold(library.clone(), |library, (path, text)| library.with_file(path, text));
    Some((library, Lattice { weights }))
}
