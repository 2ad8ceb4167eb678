//! STL, binary and ASCII. A binary file may begin with the word "solid", so its length decides.

use super::error::{Found, Place, quoted};
use super::{Shape, ShapeError, mesh};
use glam::Vec3;

/// Bytes before the first triangle: 80 of anything, and the number of triangles.
const HEADER: u64 = 84;
/// Bytes of a triangle: normal, three corners, two bytes of attributes.
const TRIANGLE: u64 = 50;

/// Reads a mesh; corners at equal positions become one vertex.
pub(super) fn read(file: &str, bytes: Vec<u8>) -> Result<Shape, ShapeError> {
    let triangles = bytes.get(80..84).map(|n| u32::from_le_bytes([n[0], n[1], n[2], n[3]]));
    let length = triangles.map(|triangles| HEADER + TRIANGLE * u64::from(triangles));
    if length == Some(bytes.len() as u64) {
        return mesh::checked_corners(file, binary(&bytes));
    }
    let text = bytes.trim_ascii_start().starts_with(b"solid") && !bytes.contains(&0);
    match (text, triangles) {
        (true, _) => mesh::checked_corners(file, ascii(file, &bytes)?),
        (false, Some(triangles)) => Err(ShapeError::DataSize {
            file: file.into(),
            offset: HEADER,
            declared: TRIANGLE * u64::from(triangles),
            what: format!("{triangles} triangles of {TRIANGLE} bytes"),
            found: Found::Bytes(bytes.len() as u64 - HEADER),
        }),
        (false, None) => Err(ShapeError::Malformed {
            file: file.into(),
            place: Place::Header,
            expected: "the word `solid` or a binary header of 84 bytes",
            found: quoted(&bytes),
        }),
    }
}

fn binary(bytes: &[u8]) -> Vec<Vec3> {
    let float = |b: &[u8]| f32::from_le_bytes([b[0], b[1], b[2], b[3]]);
    let corner = |b: &[u8]| Vec3::new(float(b), float(&b[4..]), float(&b[8..]));
    let triangles = bytes[HEADER as usize..].chunks_exact(TRIANGLE as usize);
    triangles.flat_map(|triangle| [corner(&triangle[12..]), corner(&triangle[24..]), corner(&triangle[36..])]).collect()
}

/// The corners of an ASCII file: the three numbers after each word `vertex`.
fn ascii(file: &str, bytes: &[u8]) -> Result<Vec<Vec3>, ShapeError> {
    let mut corners = Vec::new();
    for (index, line) in bytes.split(|&byte| byte == b'\n').enumerate() {
        let place = Place::Line(index as u64 + 1);
        let malformed = |expected| ShapeError::Malformed { file: file.into(), place, expected, found: quoted(line) };
        let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        match words.next() {
            Some(b"vertex") => {
                let number = |word: &[u8]| std::str::from_utf8(word).ok()?.parse().ok();
                let mut next = || words.next().and_then(number).ok_or_else(|| malformed("three numbers"));
                corners.push(Vec3::new(next()?, next()?, next()?));
            }
            Some(b"endloop") if corners.len() % 3 != 0 => return Err(malformed("three vertices in a loop")),
            _ => {}
        }
    }
    match corners.len() % 3 {
        0 => Ok(corners),
        _ => Err(ShapeError::Malformed {
            file: file.into(),
            place: Place::Header,
            expected: "three vertices for each facet",
            found: format!("{} vertices: the file is cut off", corners.len()),
        }),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CORNERS: [[f32; 3]; 3] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];

    fn binary_file(header: &[u8]) -> Vec<u8> {
        let mut bytes = header.to_vec();
        bytes.resize(80, b' ');
        bytes.extend(1u32.to_le_bytes());
        bytes.extend([0; 12]);
        bytes.extend(CORNERS.iter().flatten().flat_map(|c| c.to_le_bytes()));
        bytes.extend([0; 2]);
        bytes
    }

    const ASCII: &str = "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\nendsolid a\n";

    #[test]
    fn a_binary_stl_whose_header_says_solid_is_read_as_binary() {
        for bytes in [binary_file(b"solid model"), binary_file(b""), ASCII.as_bytes().to_vec()] {
            let Shape::Mesh(mesh) = read("a.stl", bytes).unwrap() else { panic!("a mesh") };
            assert_eq!((mesh.positions.len(), mesh.triangles.len()), (3, 1));
        }
    }

    #[test]
    fn a_truncated_stl_is_refused() {
        let whole = binary_file(b"x");
        let error = read("a.stl", whole[..whole.len() - 1].to_vec()).unwrap_err().to_string();
        assert!(error.contains("declares 50 bytes of data (1 triangles of 50 bytes), the file holds 49"), "{error}");
        let cut = &ASCII[..ASCII.find("vertex 0 1").unwrap()];
        assert!(read("a.stl", cut.as_bytes().to_vec()).unwrap_err().to_string().contains("cut off"));
        assert!(read("a.stl", b"short".to_vec()).is_err());
    }
}
