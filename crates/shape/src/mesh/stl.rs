//! Stereolithography (STL): triangles, binary or text.
//!
//! Role: triangles as a mesh with welded corners. Invariant: a file whose length fits its triangle count is binary, whatever its
//! header says; other contents are skipped with a note. Source: 3D Systems, "Stereolithography interface specification", 1988.
//! The crate stl_io loses all but the first solid of a text file.

use super::polygon::{self, triangulate};
use crate::error::{Found, Location, ShapeError};
use crate::shape::{MAX_TRIANGLES, Mesh, Shape};
use crate::source::{Source, check_positions, number, tokens};
use glam::{DVec3, Vec3};

/// Header of a binary file: 80 bytes of text and the triangle count.
const HEADER_BYTES: u64 = 84;
/// Bytes of a binary triangle: normal and 3 corners as f32, and 2 attribute bytes.
const TRIANGLE_BYTES: u64 = 50;

/// Whether the length fits a binary file, or the file begins as a text file.
pub(crate) fn recognizes(start: &[u8], len: u64) -> bool {
    let lower = start.to_ascii_lowercase();
    let has = |word: &[u8]| lower.windows(word.len()).any(|window| window == word);
    is_binary(start, len) || is_text(start) && (has(b"facet") || has(b"endsolid"))
}

/// Reads a binary or text file; the winding counts, the normals are ignored.
pub(crate) fn read(source: &mut Source) -> Result<Shape, ShapeError> {
    let len = source.len;
    let start = source.peek()?;
    if !is_binary(start, len) && is_text(start) {
        let corners = text(source)?;
        finish(source, &corners)
    } else {
        let corners = binary(source)?;
        finish(source, &corners)
    }
}

fn finish(source: &Source, corners: &[impl Copy + Into<DVec3>]) -> Result<Shape, ShapeError> {
    check_positions(&source.file, "triangle corners", corners)?;
    source.finish(Mesh::of_corners(corners), "no facet, or a count of 0 in a binary header")
}

/// Triangle count of a binary header, if it is complete.
fn declared(start: &[u8]) -> Option<u64> {
    let count = start.get(80..84)?.first_chunk()?;
    Some(u64::from(u32::from_le_bytes(*count)))
}

fn is_binary(start: &[u8], len: u64) -> bool {
    declared(start).is_some_and(|count| len == HEADER_BYTES + TRIANGLE_BYTES * count)
}

fn is_text(start: &[u8]) -> bool {
    let word = start.trim_ascii_start().get(..5).unwrap_or_default();
    // The triangle count of a binary file below 2^24 triangles has a zero byte.
    word.eq_ignore_ascii_case(b"solid") && !start[..start.len().min(HEADER_BYTES as usize)].contains(&0)
}

fn binary(source: &mut Source) -> Result<Vec<Vec3>, ShapeError> {
    let len = source.len;
    let Some(count) = declared(source.peek()?) else {
        return Err(source.data_size(HEADER_BYTES, "an STL header".into(), Found::Bytes(len)));
    };
    source.fill(&mut [0; HEADER_BYTES as usize])?;
    let (needed, left) = (TRIANGLE_BYTES * count, source.remaining());
    if left < needed {
        let what = format!("{count} triangles of {TRIANGLE_BYTES} bytes");
        return Err(source.data_size(needed, what, Found::Bytes(left)));
    }
    source.check_triangles(count)?;
    // Longest possible data with attributes.
    let most = (needed + u64::from(u16::MAX) * count).min(TRIANGLE_BYTES * MAX_TRIANGLES);
    let bytes = source.block(left.min(most), "triangles")?;
    let more = left - needed;
    // Length of the attributes after a triangle, from its last two bytes; many files store other data there.
    let own = |at: usize| Some(usize::from(u16::from_le_bytes(*bytes.get(at + 48..)?.first_chunk()?)));
    let stride = TRIANGLE_BYTES as usize;
    let end = (0..count).try_fold(0, |at, _| Some(at + stride + own(at)?));
    let is_attributed = more > 0 && end == Some(bytes.len());
    match is_attributed {
        true => source.note(format!("attributes of triangles are left out: {more} bytes")),
        false if more > 0 => source.note(format!("bytes after the last triangle are left out: {more}")),
        false => {}
    }
    let (mut corners, mut at) = (Vec::with_capacity(3 * count as usize), 0);
    for _ in 0..count {
        let (floats, _) = bytes[at + 12..at + 48].as_chunks(); // between the normal and the last two bytes
        corners.extend(floats.as_chunks::<3>().0.iter().map(|xyz| Vec3::from(xyz.map(f32::from_le_bytes))));
        at += stride + own(at).filter(|_| is_attributed).unwrap_or_default();
    }
    Ok(corners)
}

/// Facets of a text file.
#[derive(Default)]
struct Text {
    /// Corners of the triangles.
    corners: Vec<DVec3>,
    /// Corners of the open loop.
    polygon: Option<Vec<DVec3>>,
    in_solid: bool,
    solids: u64,
    /// Facets of fewer than 3 corners, and of more; solids without an end; lines between solids.
    short: u64,
    long: u64,
    unended: u64,
    between: u64,
}

fn text(source: &mut Source) -> Result<Vec<DVec3>, ShapeError> {
    let (mut read, mut line) = (Text::default(), Vec::new());
    while source.next_line(&mut line)? {
        let words: Vec<&[u8]> = tokens(&line).collect();
        let mut rest = &words[..];
        while let [_, ..] = rest {
            rest = read.statement(source, &line, rest)?;
        }
    }
    read.finish(source)
}

/// Whether a word is this keyword, in any case.
fn is(word: &[u8], keyword: &str) -> bool {
    word.eq_ignore_ascii_case(keyword.as_bytes())
}

impl Text {
    /// Reads the statement at the start of the words of a line; returns the words after it.
    fn statement<'a>(
        &mut self,
        source: &Source,
        line: &[u8],
        words: &'a [&'a [u8]],
    ) -> Result<&'a [&'a [u8]], ShapeError> {
        let word = words[0].to_ascii_lowercase();
        let next = words.get(1).copied().unwrap_or_default();
        // Some programs write `end loop` and `end facet`.
        let (keyword, after) = match &word[..] {
            b"end" if ["loop", "facet", "solid"].iter().any(|own| is(next, own)) => {
                ([&b"end"[..], &next.to_ascii_lowercase()].concat(), 2)
            }
            _ => (word, 1),
        };
        let after = &words[after..];
        // The rest of a statement, up to the next keyword on the same line.
        let up_to = |keywords: &[&str]| {
            let end = after.iter().position(|word| keywords.iter().any(|own| is(word, own))).unwrap_or(after.len());
            &after[end..]
        };
        match (&keyword[..], &mut self.polygon) {
            (b"solid", None) => {
                self.unended += u64::from(self.in_solid);
                (self.in_solid, self.solids) = (true, self.solids + 1);
                // A name may be any words, and the first facet may follow it.
                let facet = after.windows(2).position(|pair| is(pair[0], "facet") && is(pair[1], "normal"));
                Ok(&after[facet.unwrap_or(after.len())..])
            }
            (b"endsolid", None) if self.in_solid => {
                self.in_solid = false;
                Ok(up_to(&["solid"]))
            }
            (b"facet", None) if self.in_solid => Ok(up_to(&["outer"])),
            (b"endfacet", None) if self.in_solid => Ok(up_to(&["facet", "endsolid", "end"])),
            (b"outer", None) if self.in_solid => {
                self.polygon = Some(Vec::new());
                Ok(up_to(&["vertex", "endloop", "end"]))
            }
            (b"vertex", Some(polygon)) => {
                let [x, y, z] = [0, 1, 2].map(|at| after.get(at).and_then(|word| number(word)));
                let (Some(x), Some(y), Some(z)) = (x, y, z) else {
                    return Err(source.malformed("3 numbers after `vertex`", line));
                };
                polygon.push(DVec3::new(x, y, z));
                source.check_triangles((self.corners.len() + polygon.len()) as u64 / 3)?;
                Ok(up_to(&["vertex", "endloop", "end"]))
            }
            (b"endloop", Some(_)) => {
                self.end_loop(source)?;
                Ok(up_to(&["endfacet", "end", "outer"]))
            }
            (_, Some(polygon)) if polygon.len() >= 3 => Err(source.malformed("`vertex` or `endloop`", line)),
            (_, Some(_)) => Err(source.malformed("`vertex`, 3 of them in a loop", line)),
            (_, None) if self.in_solid => Err(source.malformed("`facet`, `outer loop` or `endsolid`", line)),
            (_, None) if self.solids > 0 => {
                self.between += 1;
                Ok(&[])
            }
            (_, None) => Err(source.malformed("`solid`", line)),
        }
    }

    fn end_loop(&mut self, source: &Source) -> Result<(), ShapeError> {
        let polygon = self.polygon.take().unwrap_or_default();
        match polygon.len() {
            3 => self.corners.extend(polygon),
            0..3 => self.short += 1,
            count => {
                self.long += 1;
                let (all, mut triangles): (Vec<u32>, _) = ((0..count as u32).collect(), Vec::new());
                if !triangulate(&all, &polygon, &mut triangles) {
                    return Err(polygon::too_large(source, Location::Line(source.line), count));
                }
                self.corners.extend(triangles.as_flattened().iter().map(|corner| polygon[*corner as usize]));
            }
        }
        source.check_triangles(self.corners.len() as u64 / 3)
    }

    fn finish(self, source: &Source) -> Result<Vec<DVec3>, ShapeError> {
        if self.polygon.is_some() {
            return Err(source.ended("`endloop`"));
        }
        for (count, text) in [
            (self.short, "facets of fewer than 3 corners are left out"),
            (self.long, "facets of more than 3 corners are cut into triangles"),
            (self.unended + u64::from(self.in_solid), "solids without `endsolid` are read as complete"),
            (self.between, "lines after `endsolid` are left out"),
        ] {
            if count > 0 {
                source.note(format!("{text}: {count}"));
            }
        }
        Ok(self.corners)
    }
}

// Every welded index fits a u32.
const _: () = assert!(3 * MAX_TRIANGLES < u32::MAX as u64);

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Location;
    use crate::open::{read as read_any, read_noted};

    const CORNERS: [[f32; 3]; 6] =
        [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

    /// A square of two triangles.
    fn binary_square(header: &[u8]) -> Vec<u8> {
        let mut bytes = header.to_vec();
        bytes.resize(80, b' ');
        bytes.extend_from_slice(&2_u32.to_le_bytes());
        for triangle in CORNERS.chunks(3) {
            bytes.extend_from_slice(&[0; 12]);
            bytes.extend(triangle.iter().flatten().flat_map(|x| x.to_le_bytes()));
            bytes.extend_from_slice(&[0; 2]);
        }
        bytes
    }

    fn text_square() -> String {
        let mut text = String::from("  SOLID a name with words\r\n");
        for triangle in CORNERS.chunks(3) {
            text += " facet normal 0 0 1\n  outer loop\n";
            for [x, y, z] in triangle {
                text += &format!("   vertex {x:e} {y} {z}\n");
            }
            text += "  endloop\n endfacet\n\n";
        }
        text + "endsolid a name\n"
    }

    fn assert_square(bytes: &[u8]) {
        match read_any("test.stl", bytes) {
            Ok(Shape::Mesh(mesh)) => {
                assert_eq!(mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
                assert_eq!(mesh.positions, [Vec3::ZERO, Vec3::X, Vec3::X + Vec3::Y, Vec3::Y]);
            }
            other => panic!("{other:?}"),
        }
    }

    fn error(bytes: &[u8]) -> ShapeError {
        read_any("test.stl", bytes).unwrap_err()
    }

    #[test]
    fn binary_and_text_give_the_same_welded_mesh() {
        assert_square(&binary_square(b"made by hand"));
        assert_square(text_square().as_bytes());
    }

    #[test]
    fn binary_stl_whose_header_says_solid_is_read_as_binary() {
        assert_square(&binary_square(b"solid looks like text\nfacet normal"));
        assert_square(&binary_square(b"solid\0"));
    }

    #[test]
    fn a_truncated_binary_file_shows_declared_and_present_bytes() {
        let bytes = binary_square(b"x");
        for len in [84, 100, 183] {
            let error = error(&bytes[..len]);
            let found = Found::Bytes(len as u64 - 84);
            let expected =
                matches!(&error, ShapeError::DataSize { offset: 84, declared: 100, found: f, .. } if *f == found);
            assert!(expected, "{error}");
        }
        assert!(matches!(error(&bytes[..50]), ShapeError::DataSize { offset: 0, declared: 84, .. }));
    }

    #[test]
    fn excess_declared_triangles_are_refused_before_allocation() {
        let mut bytes = binary_square(b"solid \0");
        bytes[80..84].copy_from_slice(&u32::MAX.to_le_bytes());
        assert!(matches!(error(&bytes), ShapeError::DataSize { declared: 214_748_364_750, .. }));
    }

    #[test]
    fn text_errors_name_the_line() {
        let good = text_square();
        for (from, to, line) in
            [("vertex 1e0 0 0", "vertex 1e0 zero 0", 5), ("endloop", "vertex 0 0 0", 8), ("outer", "inner", 3)]
        {
            let error = error(good.replacen(from, to, 1).as_bytes());
            assert!(matches!(error, ShapeError::Malformed { place: Location::Line(l), .. } if l == line), "{error}");
        }
        let cut = &good[..good.rfind("endloop").unwrap()];
        assert!(error(cut.as_bytes()).to_string().contains("expected `endloop`, found the end of the file"));
    }

    /// Notes of the reader about a square.
    fn square_noted(bytes: &[u8]) -> Vec<String> {
        assert_square(bytes);
        read_noted("test.stl", bytes).unwrap().notes
    }

    #[test]
    fn what_is_beside_the_triangles_is_left_out_with_a_line() {
        let good = binary_square(b"made by hand");
        let tailed = [&good[..], &[7; 92]].concat();
        assert_eq!(square_noted(&tailed), ["bytes after the last triangle are left out: 92"]);
        // A color in the last two bytes must not pass for the length of attributes.
        let mut colored = tailed.clone();
        colored[84 + 48..84 + 50].copy_from_slice(&0x7fff_u16.to_le_bytes());
        assert_eq!(square_noted(&colored), ["bytes after the last triangle are left out: 92"]);
        let mut attributed = good[..84].to_vec();
        for (triangle, bytes) in good[84..].chunks(50).zip([3_u16, 300]) {
            attributed.extend_from_slice(&triangle[..48]);
            attributed.extend_from_slice(&bytes.to_le_bytes());
            attributed.resize(attributed.len() + usize::from(bytes), 0xab);
        }
        assert_eq!(square_noted(&attributed), ["attributes of triangles are left out: 303 bytes"]);

        let text = text_square();
        let unended = &text[..text.find("endsolid").unwrap()];
        assert_eq!(square_noted(unended.as_bytes()), ["solids without `endsolid` are read as complete: 1"]);
        let two = text.replacen(" endfacet\n\n", " endfacet\nsolid b\n", 1);
        assert_eq!(square_noted(two.as_bytes()), ["solids without `endsolid` are read as complete: 1"]);
        assert_eq!(square_noted((text.clone() + "bye\n\0\n").as_bytes()), ["lines after `endsolid` are left out: 2"]);
        let short = text.replace("endsolid a", "facet\nouter loop\nvertex 9 9 9\nendloop\nendfacet\nendsolid a");
        assert_eq!(square_noted(short.as_bytes()), ["facets of fewer than 3 corners are left out: 1"]);
    }

    #[test]
    fn nan_corners_are_counted() {
        let error = error(text_square().replacen("vertex 1e0", "vertex nan", 1).as_bytes());
        assert!(matches!(error, ShapeError::NotFinite { count: 1, total: 6, first: 1, .. }), "{error}");
    }

    #[test]
    fn an_stl_file_without_triangles_is_refused() {
        assert!(matches!(error(b"solid nothing\nendsolid nothing\n"), ShapeError::NoTriangles { .. }));
        let mut bytes = vec![0; 84];
        bytes[0] = b'x';
        assert!(matches!(error(&bytes), ShapeError::NoTriangles { .. }));
    }
}
