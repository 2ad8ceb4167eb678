//! Prints: solids in millimeters, for slicers.

use hypertexture::scene::{Axis, FileUnit, Object};
use hypertexture::shape::{BUILT_IN, MeshFormat};
use std::path::Path;

/// Default longest side of an object without a unit, millimeters.
const FIRST_SIDE: f32 = 60.0;

/// Accuracy and bodies of a print.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Print {
    /// Largest distance from the surface, millimeters.
    pub(crate) tolerance: f64,
    /// Most triangles, in place of the tolerance.
    pub(crate) triangles: Option<u32>,
    /// Whether each body is an object of its own in the file.
    pub(crate) apart: bool,
}

impl Default for Print {
    fn default() -> Print {
        Print { tolerance: 0.1, triangles: None, apart: false }
    }
}

impl Print {
    /// Options of the command line.
    pub(super) fn words(&self) -> Vec<String> {
        let mut words: Vec<String> = match self.triangles {
            Some(count) => vec!["--triangles".into(), count.to_string()],
            None => vec!["--tolerance".into(), format!("{}mm", self.tolerance)],
        };
        if self.apart {
            words.extend(["--bodies", "apart"].map(String::from));
        }
        words
    }
}

/// Longest side of an object when it is printed, millimeters: that of its scene, else of its file as 0, else a default.
pub(crate) fn longest_side(object: &Object) -> f32 {
    let has_unit = object.unit != FileUnit::File || has_file(object);
    if object.scale_to > 0.0 || has_unit { object.scale_to } else { FIRST_SIDE }
}

/// The axis of a written print that points up: objects without a file stand in 3MF with z up.
pub(crate) fn up_of_print(object: &Object, path: &Path) -> Axis {
    let stands = MeshFormat::from_path(path) == Some(MeshFormat::ThreeMf) && !has_file(object);
    if stands && object.up == Axis::Y { Axis::Z } else { object.up }
}

/// Whether an object is of a file, which has axes of its own.
fn has_file(object: &Object) -> bool {
    !object.is_formula() && !BUILT_IN.contains(&&*object.input)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_print_has_the_size_and_the_axes_of_its_object() {
        let object = |input: &str, scale_to| Object { input: input.into(), scale_to, ..Object::default() };
        let sides = [("teapot", 0.0), ("teapot", 20.0), ("a.stl", 0.0)];
        assert_eq!(sides.map(|(input, scale_to)| longest_side(&object(input, scale_to))), [FIRST_SIDE, 20.0, 0.0]);
        let prints = [("teapot", "b.3mf"), ("teapot", "b.stl"), ("a.stl", "b.3mf")];
        let ups = prints.map(|(input, path)| up_of_print(&object(input, 0.0), Path::new(path)));
        assert_eq!(ups, [Axis::Z, Axis::Y, Axis::Y]);
    }
}
