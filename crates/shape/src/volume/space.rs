//! Orientation of the axes of a file in the world.
//!
//! Invariant: the world is RAS, as in NIfTI: x to the right of the patient, y to the front, z up. Sources: "nifti1.h",
//! nifti.nimh.nih.gov; NEMA PS3.3, C.7.6.2.1.1; G. Kindlmann, "Definition of NRRD file format"; ITK, `itkMetaImageIO.cxx`.

use crate::source::Source;
use glam::{DMat3, DVec3};

/// World directions of the axes of a file, one column each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Space(DMat3);

impl Space {
    /// Right, anterior, superior: NIfTI, and files without a declared space.
    pub const RAS: Space = Space(DMat3::IDENTITY);
    /// Left, posterior, superior: DICOM and MetaImage.
    pub const LPS: Space = Space(DMat3::from_diagonal(DVec3::new(-1.0, -1.0, 1.0)));
    /// An unspecific left-handed space: z is reversed.
    pub(crate) const LEFT_HANDED: Space = Space(DMat3::from_diagonal(DVec3::new(1.0, 1.0, -1.0)));

    /// Space from one letter per axis: the side that the axis points to.
    pub fn of(letters: &str) -> Option<Space> {
        let column = |letter: char| {
            "RLAPSI".find(letter.to_ascii_uppercase()).map(|at| {
                let sign = if at % 2 == 0 { 1.0 } else { -1.0 };
                DVec3::AXES[at / 2] * sign
            })
        };
        let columns: Vec<DVec3> = letters.chars().map(column).collect::<Option<_>>()?;
        let [x, y, z] = columns.try_into().ok()?;
        let axes = DMat3::from_cols(x, y, z);
        (axes.determinant() != 0.0).then_some(Space(axes))
    }

    /// Letters of the sides that steps in this space point to, by their largest components.
    pub fn letters(self, steps: &DMat3) -> String {
        let world = self.steps(steps);
        let letter = |axis: usize| {
            let step = world.col(axis);
            let row = step.abs().max_position();
            ["RL", "AP", "SI"][row].as_bytes()[usize::from(step[row] < 0.0)] as char
        };
        (0..3).map(letter).collect()
    }

    /// World coordinates of a position.
    pub fn position(self, position: DVec3) -> DVec3 {
        self.0 * position
    }

    /// World coordinates of steps.
    pub fn steps(self, steps: &DMat3) -> DMat3 {
        self.0 * *steps
    }
}

/// The three axes of an image whose other dimensions have one sample. Surplus axes of one sample are dropped with a note:
/// those with `last` first, then from the highest on.
pub(super) fn three_axes(source: &Source, sizes: &[u64], last: impl Fn(usize) -> bool) -> Option<[usize; 3]> {
    let mut single: Vec<usize> = (0..sizes.len()).rev().filter(|&axis| sizes[axis] == 1).collect();
    single.sort_by_key(|&axis| !last(axis));
    single.truncate(sizes.len().checked_sub(3)?);
    let axes: Vec<usize> = (0..sizes.len()).filter(|axis| !single.contains(axis)).collect();
    let axes = axes.try_into().ok()?;
    if !single.is_empty() {
        single.sort_unstable();
        let named = single.iter().map(|axis| (axis + 1).to_string()).collect::<Vec<_>>().join(", ");
        source.note(format!("of its {} dimensions, number {named} has one sample and is left out", sizes.len()));
    }
    Some(axes)
}

/// Numbers per axis; NaN or `unknown` is replaced by `usual`, with a note.
pub(super) fn or_usual(source: &Source, name: &str, numbers: [f64; 3], unknown: f64, usual: f64) -> DVec3 {
    let is_unknown = |number: f64| number.is_nan() || number == unknown;
    if numbers.into_iter().any(is_unknown) {
        source.note(format!("{name} is {}: {usual} is used where it is unknown", listed(&numbers)));
    }
    DVec3::from(numbers.map(|number| if is_unknown(number) { usual } else { number }))
}

/// Numbers separated by spaces.
pub(crate) fn listed(numbers: &[f64]) -> String {
    numbers.iter().map(|number| number.to_string()).collect::<Vec<_>>().join(" ")
}
