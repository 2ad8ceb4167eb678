//! Wavefront OBJ: polygons.
//!
//! Role: `v` and `f` statements as a mesh. Invariant: an index is checked against the vertices above its line.
//! Source: Alias|Wavefront, "Object Files (.obj)", Advanced Visualizer manual, appendix B1, 1995. The crate tobj gives no line
//! numbers, splits vertices between objects, refuses comments that are not UTF-8 or follow data, and accepts NaN.

use super::mtl::{Faces, first_word};
use super::polygon::{self, triangulate};
use crate::error::{Location, ShapeError, quoted};
use crate::shape::looks::{full_scale, linear};
use crate::shape::{MAX_TRIANGLES, Mesh, Shape};
use crate::source::{MAX_LINE, Source, check_positions, number, tokens};
use glam::DVec3;

/// Reads positions and faces; polygons are triangulated.
///
/// Colors follow coordinates, as many programs write them. Normals, groups, points, lines and fourth coordinates (weights of
/// control points) are skipped, and texture coordinates and materials unless they are asked for. Curved surfaces are refused.
pub(crate) fn read(source: &mut Source) -> Result<Shape, ShapeError> {
    let mut positions: Vec<DVec3> = Vec::new();
    let mut colors: Vec<[f32; 3]> = Vec::new();
    let mut triangles: Vec<[u32; 3]> = Vec::new();
    let mut polygon: Vec<u32> = Vec::new();
    let mut statement = Vec::new();
    // Four numbers after a position.
    let mut fours: Vec<[f32; 4]> = Vec::new();
    let mut faces = source.is_painted.then(Faces::default);
    // Number of faces with fewer than 3 corners and the line of the first; first unknown statement and its line.
    let (mut short, mut foreign) = ((0, 0), None);
    while let Some(line) = next_statement(source, &mut statement)? {
        let mut words = tokens(&statement);
        match words.next() {
            Some(b"v") => {
                positions.push(position(source, &mut words)?);
                let rest: Vec<f64> = words.filter_map(number).collect();
                match rest[..] {
                    [r, g, b] => colors.push([r, g, b].map(|code| code as f32)),
                    [a, b, c, d] => fours.push([a, b, c, d].map(|code| code as f32)),
                    _ => {}
                }
                // Three vertices for each triangle, and never more than a u32 can count.
                source.check_triangles((positions.len() as u64).div_ceil(3))?;
            }
            // `fo`: a face in files of versions up to 2.11.
            Some(b"f" | b"fo") => {
                polygon.clear();
                for word in words {
                    let corner = index(source, line, word, positions.len())?;
                    polygon.push(match &mut faces {
                        Some(faces) => faces.corner(source, line, word, (corner, positions[corner as usize]))?,
                        None => corner,
                    });
                }
                if polygon.len() < 3 {
                    short = (short.0 + 1, if short.0 == 0 { line } else { short.1 });
                    continue;
                }
                source.check_triangles((triangles.len() + polygon.len() - 2) as u64)?;
                if !triangulate(&polygon, faces.as_ref().map_or(&positions, |faces| &faces.positions), &mut triangles) {
                    return Err(polygon::too_large(source, Location::Line(line), polygon.len()));
                }
            }
            Some(curve @ (b"curv" | b"curv2" | b"surf")) => {
                let remedy = "convert curves and surfaces to polygons first";
                return Err(source.unsupported(Location::Line(line), "the statement", quoted(curve), remedy));
            }
            Some(word @ (b"vt" | b"usemtl" | b"mtllib")) => {
                if let Some(faces) = &mut faces {
                    faces.statement(source, word, first_word(&statement).1)?;
                }
            }
            Some(word) if foreign.is_none() && !PASSED_OVER.contains(&word) => foreign = Some((quoted(word), line)),
            _ => {}
        }
    }
    if short.0 > 0 {
        source.note(format!("faces of fewer than 3 corners are left out: {}, the first in line {}", short.0, short.1));
    }
    check_positions(&source.file, "vertices", &positions)?;
    let unread =
        foreign.map_or(String::new(), |(word, line)| format!("; {word} in line {line} is not an OBJ statement"));
    if !fours.is_empty() && fours.len() == positions.len() {
        colors = colors_of_fours(source, &fours);
    }
    let colors = if colors.len() == positions.len() { decoded(source, colors) } else { Vec::new() };
    let holds = format!("{} vertices and no face{unread}", positions.len());
    let found = match faces {
        Some(faces) => faces.finish(source, &positions, &colors, triangles)?,
        None => Mesh::cleaned_with(&positions, &colors, &[], triangles),
    };
    source.finish(found, holds)
}

/// Codes of colors from four numbers after each position: a weight of 1 and a color, or a color and an opacity. Where both fit, as
/// with `1 0 0 1`, nothing is guessed.
fn colors_of_fours(source: &Source, fours: &[[f32; 4]]) -> Vec<[f32; 3]> {
    let (is_weighted, last) = (fours.iter().all(|[weight, ..]| *weight == 1.0), fours[0][3]);
    if is_weighted && last > 0.0 && fours.iter().all(|four| four[3] == last) {
        source.note(
            "vertices of 7 numbers are a position with a weight and a color, or with a color and an opacity; both fit, so their \
             colors are left out: write 6 numbers"
                .into(),
        );
        return Vec::new();
    }
    let order = if is_weighted { "a weight, then a color" } else { "a color, then an opacity" };
    source.note(format!("vertices of 7 numbers are read as a position, {order}"));
    fours.iter().map(|[a, b, c, d]| if is_weighted { [*b, *c, *d] } else { [*a, *b, *c] }).collect()
}

/// Linear colors by codes of sRGB of an unknown full scale.
fn decoded(source: &Source, mut colors: Vec<[f32; 3]>) -> Vec<[f32; 3]> {
    let (full, note) = full_scale(&colors);
    note.into_iter().for_each(|note| source.note(note));
    colors.as_flattened_mut().iter_mut().for_each(|code| *code = linear(f64::from(*code) / full));
    colors
}

/// Keywords of skipped statements.
const PASSED_OVER: [&[u8]; 7] = [b"vn", b"vp", b"o", b"g", b"s", b"l", b"p"];

/// Replaces `statement` by the next one and returns its line number. A backslash at the end continues a vertex or face on the
/// next line.
fn next_statement(source: &mut Source, statement: &mut Vec<u8>) -> Result<Option<u64>, ShapeError> {
    if !next_part(source, statement)? {
        return Ok(None);
    }
    let first = source.line;
    let mut more = Vec::new();
    while statement.last() == Some(&b'\\') {
        statement.pop();
        // Names of folders may end in a backslash.
        if !matches!(tokens(statement).next(), None | Some(b"v" | b"f" | b"fo")) || !next_part(source, &mut more)? {
            break;
        }
        statement.push(b' ');
        statement.append(&mut more);
        if statement.len() > MAX_LINE {
            return Err(source.malformed("a statement of at most 1 MiB, all of its lines together", statement));
        }
    }
    Ok(Some(first))
}

/// Replaces `part` by the next line without comment and trailing white space; `false` at the end of the file.
fn next_part(source: &mut Source, part: &mut Vec<u8>) -> Result<bool, ShapeError> {
    let is_there = source.next_line(part)?;
    let text = part.split(|byte| *byte == b'#').next().unwrap_or_default();
    part.truncate(text.trim_ascii_end().len());
    Ok(is_there)
}

fn position<'a>(source: &Source, words: &mut impl Iterator<Item = &'a [u8]>) -> Result<DVec3, ShapeError> {
    let mut xyz = [0.0; 3];
    for x in &mut xyz {
        let word = words.next().unwrap_or_default();
        *x = number(word).ok_or_else(|| source.malformed("a coordinate (3 numbers after `v`)", word))?;
    }
    Ok(DVec3::from(xyz))
}

/// Position index of `7`, `7/2`, `7//3` or `7/2/3`, counted from 1, or backwards from -1.
fn index(source: &Source, line: u64, word: &[u8], count: usize) -> Result<u32, ShapeError> {
    let digits = word.split(|&byte| byte == b'/').next().unwrap_or_default();
    let malformed = || source.malformed("a vertex index (as 7, 7/2, 7//3 or 7/2/3)", word);
    let index: i64 = number(digits).ok_or_else(malformed)?;
    let from_zero = if index < 0 { index.checked_add(count as i64) } else { index.checked_sub(1) };
    match from_zero {
        Some(from_zero) if (0..count as i64).contains(&from_zero) => Ok(from_zero as u32),
        _ => Err(ShapeError::IndexOutOfRange { file: source.file.clone(), line, index, count }),
    }
}

// Every index fits a u32.
const _: () = assert!(3 * MAX_TRIANGLES < u32::MAX as u64);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::open::read as read_any;
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
    fn an_index_out_of_range_names_line_and_vertex_count() {
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
        let message = error(format!("f 1 2 3\n{TRIANGLE}").as_bytes()).to_string();
        assert!(message.contains("line 1: vertex index 1 is out of range, no vertices are defined above"), "{message}");
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
    }

    #[test]
    fn a_mesh_without_area_is_refused() {
        for (text, said) in [
            ("v 0 0 0\n", "no triangles (1 vertices and no face)"),
            (
                "v 0 0 0\nl 1 1\nface 1 2 3\nfaces\n",
                "no triangles (1 vertices and no face; `face` in line 3 is not an OBJ statement",
            ),
            ("v 0 0 0\nv 1 1 1\nv 2 2 2\nf 1 2 3\n", "no triangles (1 of zero area were dropped)"),
        ] {
            let line = error(text.as_bytes()).to_string();
            assert!(line.contains(said), "{line}");
        }
    }

    #[test]
    fn curved_surfaces_are_refused_and_not_dropped() {
        assert!(matches!(error(b"v 0 0 0\nsurf 0 1 0 1 1 2 3\n"), ShapeError::Unsupported { .. }));
    }

    #[test]
    fn concave_faces_have_a_corner_limit_and_convex_ones_do_not() {
        let wheel = |n: usize, inner: f64| {
            let corner = |i: usize| {
                let (sin, cos) = (i as f64 * std::f64::consts::TAU / n as f64).sin_cos();
                let radius = if i.is_multiple_of(2) { 1.0 } else { inner };
                format!("v {} {} 0\n", radius * cos, radius * sin)
            };
            let face: Vec<String> = (1..=n).map(|i| i.to_string()).collect();
            (0..n).map(corner).collect::<String>() + "f " + &face.join(" ")
        };
        let star = mesh(&wheel(4000, 0.9));
        let area = |triangle| {
            let [a, b, c] = star.corners(triangle).map(Vec3::as_dvec3);
            0.5 * (b - a).cross(c - a).z
        };
        assert!(star.triangles.len() == 3998 && (0..3998).all(|triangle| area(triangle) > 0.0));
        // 4000 triangles around the center, with sides 1 and 0.9.
        let expected = 2000.0 * 0.9 * (std::f64::consts::TAU / 4000.0).sin();
        assert!(((0..3998).map(area).sum::<f64>() / expected - 1.0).abs() < 1e-5);
        assert_eq!(mesh(&wheel(20_000, 1.0)).triangles.len(), 19_998);
        let line = error(wheel(20_000, 0.9).as_bytes()).to_string();
        assert!(line.contains("line 20001: a concave face with 20000 corners (the limit is 16384)"), "{line}");
    }
}
