//! Wavefront OBJ: positions and faces; everything else is skipped.

use super::error::{Place, quoted};
use super::{Shape, ShapeError, mesh};
use glam::Vec3;

/// Reads a mesh. Faces of more than three corners become fans; indices may count from the end.
pub(super) fn read(file: &str, bytes: Vec<u8>) -> Result<Shape, ShapeError> {
    let mut positions: Vec<Vec3> = Vec::new();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    for (index, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let number = index as u64 + 1;
        let malformed = |expected, found: &[u8]| ShapeError::Malformed {
            file: file.into(),
            place: Place::Line(number),
            expected,
            found: quoted(found),
        };
        let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        match words.next() {
            Some(b"v") => {
                let mut next = || words.next().and_then(number_of).ok_or_else(|| malformed("three numbers", line));
                positions.push(Vec3::new(next()?, next()?, next()?));
            }
            Some(b"f") => {
                let mut corners = Vec::with_capacity(4);
                for word in words {
                    corners.push(corner(word, positions.len()).map_err(|found| match found {
                        Some(index) => {
                            let count = positions.len();
                            ShapeError::IndexOutOfRange { file: file.into(), line: number, index, count }
                        }
                        None => malformed("a vertex index such as 7 or 7/1/3", word),
                    })?);
                }
                if corners.len() < 3 {
                    return Err(malformed("a face of at least 3 vertices", line));
                }
                triangles.extend((2..corners.len()).map(|last| [corners[0], corners[last - 1], corners[last]]));
            }
            _ => {}
        }
    }
    mesh::checked(file, positions, triangles)
}

fn number_of(word: &[u8]) -> Option<f32> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// Index of a corner from 0; the error is an index out of range, or `None` for what is no index.
fn corner(word: &[u8], count: usize) -> Result<u32, Option<i64>> {
    let index = word.split(|&byte| byte == b'/').next().and_then(|text| std::str::from_utf8(text).ok());
    let index: i64 = index.and_then(|text| text.parse().ok()).ok_or(None)?;
    let from_zero = if index > 0 { index - 1 } else { count as i64 + index };
    match index != 0 && (0..count as i64).contains(&from_zero) {
        true => u32::try_from(from_zero).map_err(|_| Some(index)),
        false => Err(Some(index)),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn mesh_of(text: &str) -> Result<Shape, ShapeError> {
        read("a.obj", text.as_bytes().to_vec())
    }

    #[test]
    fn a_polygon_becomes_a_fan_and_indices_count_from_either_end() {
        let square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";
        for face in ["f 1 2 3 4", "f -4 -3 -2 -1", "f 1/9/9 2//3 3/1 4"] {
            let Shape::Mesh(mesh) = mesh_of(&format!("{square}{face}\n")).unwrap() else { panic!("a mesh") };
            assert_eq!((mesh.positions.len(), mesh.triangles.len()), (4, 2));
        }
    }

    #[test]
    fn what_is_wrong_is_named_with_its_line() {
        let cases = [
            ("v 0 0\n", "line 1: expected three numbers"),
            ("v 0 0 0\nf 1 2 3\n", "line 2: vertex index 2 is out of range"),
            ("v 0 0 0\nf 1 x 1\n", "line 2: expected a vertex index"),
            ("v 0 0 0\nv 1 0 0\nf 1 2\n", "line 3: expected a face of at least 3"),
            ("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "1 of 3 vertices are NaN"),
            ("v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "no triangles (1 of zero area"),
            ("# nothing\n", "no triangles"),
        ];
        for (text, expected) in cases {
            let error = mesh_of(text).unwrap_err().to_string();
            assert!(error.contains(expected) && !error.contains('\n'), "{error}");
        }
    }
}
