//! Wavefront OBJ: polygons.
//!
//! Role: `v` and `f` statements into a mesh. Invariant: an index is checked against the vertices above its line.
//! Source: Alias|Wavefront, "Object Files (.obj)", Advanced Visualizer manual, appendix B1, 1995. Read here and not by
//! the tobj crate, which gives no line numbers, splits vertices between objects, refuses comments that are not UTF-8 or
//! follow data, and lets NaN pass.

use super::error::{Location, ShapeError, quoted};
use super::polygon::{MAX_CONCAVE_CORNERS, triangulate};
use super::source::{MAX_LINE, Source, number, tokens};
use super::{MAX_TRIANGLES, Mesh, Shape};
use glam::DVec3;

/// Reads positions and faces; polygons become triangles.
///
/// Normals, texture coordinates, colors, materials, groups, points and lines have no part in the surface and are passed
/// over, and so is a fourth coordinate (the weight of a control point). Curved surfaces are refused.
pub(super) fn read(source: &mut Source) -> Result<Shape, ShapeError> {
    let mut positions: Vec<DVec3> = Vec::new();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    let mut polygon: Vec<u32> = Vec::new();
    let mut statement = Vec::new();
    while let Some(line) = next_statement(source, &mut statement)? {
        let mut words = tokens(&statement);
        match words.next() {
            Some(b"v") => {
                positions.push(position(source, words)?);
                // Three vertices for each triangle, and never more than a u32 can count.
                source.check_triangles((positions.len() as u64).div_ceil(3))?;
            }
            Some(b"f") => {
                polygon.clear();
                for word in words {
                    polygon.push(index(source, line, word, positions.len())?);
                }
                if polygon.len() < 3 {
                    return Err(source.malformed("a face with 3 or more corners", &statement));
                }
                source.check_triangles((triangles.len() + polygon.len() - 2) as u64)?;
                if !triangulate(&polygon, &positions, &mut triangles) {
                    let found = format!("with {} corners (the limit is {MAX_CONCAVE_CORNERS})", polygon.len());
                    return Err(unsupported(source, line, "a concave face", found, "triangulate the mesh first"));
                }
            }
            Some(curve @ (b"curv" | b"curv2" | b"surf")) => {
                let remedy = "convert curves and surfaces to polygons first";
                return Err(unsupported(source, line, "the statement", quoted(curve), remedy));
            }
            _ => {}
        }
    }
    source.check_positions("vertices", &positions)?;
    source.finish(Mesh::cleaned(&positions, triangles))
}

/// Replaces `statement` by the next one: without its comment, and with the lines joined that end in a backslash.
/// Returns the number of its first line.
fn next_statement(source: &mut Source, statement: &mut Vec<u8>) -> Result<Option<u64>, ShapeError> {
    if !source.next_line(statement)? {
        return Ok(None);
    }
    let first = source.line;
    let mut more = Vec::new();
    while statement.last() == Some(&b'\\') {
        statement.pop();
        statement.push(b' ');
        if !source.next_line(&mut more)? {
            break;
        }
        statement.append(&mut more);
        if statement.len() > MAX_LINE {
            return Err(source.malformed("a statement of at most 1 MiB, all of its lines together", statement));
        }
    }
    let end = statement.iter().position(|&byte| byte == b'#').unwrap_or(statement.len());
    statement.truncate(end);
    Ok(Some(first))
}

fn position<'a>(source: &Source, mut words: impl Iterator<Item = &'a [u8]>) -> Result<DVec3, ShapeError> {
    let mut xyz = [0.0; 3];
    for x in &mut xyz {
        let word = words.next().unwrap_or_default();
        *x = number(word).ok_or_else(|| source.malformed("a coordinate (3 numbers after `v`)", word))?;
    }
    Ok(DVec3::from(xyz))
}

/// The position index of `7`, `7/2`, `7//3` or `7/2/3`, counted from 1, or backwards from -1.
fn index(source: &Source, line: u64, word: &[u8], count: usize) -> Result<u32, ShapeError> {
    let digits = word.split(|&byte| byte == b'/').next().unwrap_or_default();
    let text = std::str::from_utf8(digits).ok();
    let index: i64 = text
        .and_then(|text| text.parse().ok())
        .ok_or_else(|| source.malformed("a vertex index (as 7, 7/2, 7//3 or 7/2/3)", word))?;
    let from_zero = if index < 0 { index.checked_add(count as i64) } else { index.checked_sub(1) };
    match from_zero {
        Some(from_zero) if (0..count as i64).contains(&from_zero) => Ok(from_zero as u32),
        _ => Err(ShapeError::IndexOutOfRange { file: source.file.clone(), line, index, count }),
    }
}

fn unsupported(source: &Source, line: u64, what: &'static str, found: String, remedy: &'static str) -> ShapeError {
    ShapeError::Unsupported { file: source.file.clone(), place: Location::Line(line), what, found, remedy }
}

// Every index fits: a u32 counts more vertices than three for each triangle.
const _: () = assert!(3 * MAX_TRIANGLES < u32::MAX as u64);

#[cfg(test)]
mod tests {
    use super::super::read as read_any;
    use super::*;
    use glam::Vec3;

    const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";

    fn mesh(text: &str) -> Mesh {
        match read_any("test.obj", text.as_bytes()) {
            Ok(Shape::Mesh(mesh)) => mesh,
            other => panic!("{other:?}"),
        }
    }

    fn error(text: &[u8]) -> ShapeError {
        read_any("test.obj", text).unwrap_err()
    }

    #[test]
    fn all_four_ways_to_write_a_corner_give_the_same_triangle() {
        for face in
            ["f 1 2 3", "f 1/1 2/2 3/3", "f 1//1 2//2 3//3", "f 1/9/9 2/9/9 3/9/9", "f -3 -2 -1", "f 1 \\\r\n2 3 # x"]
        {
            let mesh = mesh(&format!("{TRIANGLE}{face}"));
            assert_eq!(mesh.triangles, [[0, 1, 2]], "{face}");
            assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::Y], "{face}");
        }
    }

    #[test]
    fn a_polygon_of_n_corners_becomes_n_minus_2_triangles() {
        let pentagon = "v 0 0 0\nv 2 0 0\nv 2 2 0\nv 1 .5 0\nv 0 2 0\nf 1 2 3 4 5";
        assert_eq!(mesh(pentagon).triangles.len(), 3);
    }

    #[test]
    fn comments_need_not_be_utf_8() {
        let mut bytes = b"# caf\xe9\n".to_vec();
        bytes.extend_from_slice(TRIANGLE.as_bytes());
        bytes.extend_from_slice(b"o na\xefve\nf 1 2 3\n");
        assert!(matches!(read_any("test.obj", &bytes), Ok(Shape::Mesh(_))));
    }

    #[test]
    fn an_index_out_of_range_names_its_line_and_the_number_of_vertices() {
        for (face, wrong) in [("f 1 2 4", 4), ("f 0 1 2", 0), ("f -4 1 2", -4), ("f 1 2 9223372036854775807", i64::MAX)]
        {
            let error = error(format!("{TRIANGLE}{face}").as_bytes());
            let expected =
                matches!(error, ShapeError::IndexOutOfRange { line: 4, index, count: 3, .. } if index == wrong);
            assert!(expected, "{error}");
        }
        let message = error(format!("{TRIANGLE}f 1 2 -9223372036854775808").as_bytes()).to_string();
        assert!(
            message.starts_with("test.obj: line 4: vertex index -9223372036854775808 is out of range"),
            "{message}"
        );
    }

    #[test]
    fn nan_and_infinite_coordinates_are_counted() {
        let error = error(b"v 0 0 0\nv nan inf 1e39\nv 1 0 0\nv 0 1 -inf\nf 1 2 3\n");
        assert!(matches!(error, ShapeError::NotFinite { count: 2, total: 4, first: 1, .. }), "{error}");
    }

    #[test]
    fn coordinates_that_overflow_when_squared_are_refused() {
        let error = error(b"v 0 0 0\nv 1e19 0 0\nv 0 1 0\nf 1 2 3\n");
        assert!(matches!(error, ShapeError::CoordinateRange { index: 1, .. }), "{error}");
        assert!(error.to_string().contains("1e19, the limit is 1e18"), "{error}");
    }

    #[test]
    fn text_where_a_number_should_be_is_shown_with_its_line() {
        let message = error(b"v 0 0 0\nv 1,5 0 0\n").to_string();
        assert!(
            message.starts_with("test.obj: line 2: expected a coordinate") && message.contains("`1,5`"),
            "{message}"
        );
        assert!(error(b"v 0 0").to_string().contains("line 1"));
        assert!(error(format!("{TRIANGLE}f 1 x 3").as_bytes()).to_string().contains("line 4"));
        assert!(error(format!("{TRIANGLE}f 1 2").as_bytes()).to_string().contains("3 or more corners"));
    }

    #[test]
    fn a_mesh_without_area_is_refused() {
        assert!(matches!(error(b"v 0 0 0\n"), ShapeError::NoTriangles { zero_area: 0, .. }));
        assert!(matches!(error(b"v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n"), ShapeError::NoTriangles { zero_area: 1, .. }));
    }

    #[test]
    fn curved_surfaces_are_refused_and_not_dropped() {
        assert!(matches!(error(b"v 0 0 0\nsurf 0 1 0 1 1 2 3\n"), ShapeError::Unsupported { .. }));
    }

    #[test]
    fn a_large_concave_face_is_refused_and_a_large_convex_one_is_not() {
        let wheel = |inner: f64| {
            let n = 1000;
            let corner = |i: usize| {
                let (sin, cos) = (i as f64 * std::f64::consts::TAU / n as f64).sin_cos();
                let radius = if i.is_multiple_of(2) { 1.0 } else { inner };
                format!("v {} {} 0\n", radius * cos, radius * sin)
            };
            let face: Vec<String> = (1..=n).map(|i| i.to_string()).collect();
            (0..n).map(corner).collect::<String>() + "f " + &face.join(" ")
        };
        assert_eq!(mesh(&wheel(1.0)).triangles.len(), 998);
        assert!(matches!(error(wheel(0.9).as_bytes()), ShapeError::Unsupported { .. }));
    }
}
