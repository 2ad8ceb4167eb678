//! Polygon File Format (PLY): polygons and strips, as text or binary.
//!
//! Role: the elements `vertex`, `face` and `tristrips` as a mesh; others are skipped. Invariant: no memory is allocated for a
//! declared count. Source: G. Turk, "The PLY polygon file format", Stanford, 1994.

use super::error::{Found, Location, ShapeError, quoted};
use super::looks::linear;
use super::polygon::{self, triangulate};
use super::source::{Source, check_positions, number, tokens};
use super::{MAX_TRIANGLES, Mesh, SampleType, Shape};
use glam::DVec3;
use std::io::Read;

/// Whether the file begins with the line `ply`.
pub(super) fn recognizes(start: &[u8], _len: u64) -> bool {
    start.starts_with(b"ply\n") || start.starts_with(b"ply\r")
}

/// Reads positions, faces and strips; properties may have any order and type.
///
/// Normals, texture coordinates and other elements are skipped.
pub(super) fn read(source: &mut Source) -> Result<Shape, ShapeError> {
    let header = Header::read(source)?;
    let mut parts = Parts::default();
    let mut values = Values { source, encoding: header.encoding, line: Vec::new(), at: 0 };
    for element in &header.elements {
        values.check(element)?;
        match element.name.as_str() {
            "vertex" => parts.vertices(&mut values, element)?,
            "face" => parts.polygons(&mut values, element, false)?,
            "tristrips" => parts.polygons(&mut values, element, true)?,
            _ if element.properties.is_empty() => {} // takes no bytes, whatever the count
            _ => (0..element.count).try_for_each(|_| values.element(element, |_, _| ()))?,
        }
    }
    values.note_rest();
    parts.finish(source)
}

/// Type by its PLY name; those of 64 bits are a common extension.
fn number_type(name: &[u8]) -> Option<SampleType> {
    Some(match name {
        b"char" => SampleType::I8,
        b"uchar" => SampleType::U8,
        b"short" => SampleType::I16,
        b"ushort" => SampleType::U16,
        b"int" => SampleType::I32,
        b"uint" => SampleType::U32,
        b"long" => SampleType::I64,
        b"ulong" => SampleType::U64,
        b"float" => SampleType::F32,
        b"double" => SampleType::F64,
        name => return number(name), // `int8` to `float64`
    })
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Encoding {
    Text,
    Little,
    Big,
}

/// A number or a list of numbers in each element of a kind.
struct Property {
    name: String,
    /// Type of the length of a list.
    list: Option<SampleType>,
    kind: SampleType,
}

/// Kind of elements.
struct Element {
    name: String,
    count: u64,
    properties: Vec<Property>,
}

impl Element {
    /// Index of a property.
    fn find(&self, names: &[&str], is_list: bool) -> Option<usize> {
        self.properties.iter().position(|p| names.contains(&p.name.as_str()) && p.list.is_some() == is_list)
    }
}

struct Header {
    encoding: Encoding,
    elements: Vec<Element>,
}

impl Header {
    /// Reads up to `end_header`.
    fn read(source: &mut Source) -> Result<Header, ShapeError> {
        let (mut line, mut encoding, mut elements) = (Vec::new(), None, Vec::<Element>::new());
        source.next_line(&mut line)?;
        if line != b"ply" {
            return Err(source.malformed("`ply`", &line));
        }
        loop {
            if !source.next_line(&mut line)? {
                return Err(source.ended("`end_header`"));
            }
            let words: Vec<&[u8]> = tokens(&line).collect();
            match words[..] {
                [] | [b"comment" | b"obj_info", ..] => {}
                [b"end_header"] => break,
                [b"format", name, b"1.0"] if encoding.is_none() => {
                    encoding = match name {
                        b"ascii" => Some(Encoding::Text),
                        b"binary_little_endian" => Some(Encoding::Little),
                        b"binary_big_endian" => Some(Encoding::Big),
                        _ => {
                            let expected = "`ascii`, `binary_little_endian` or `binary_big_endian`";
                            return Err(source.malformed(expected, name));
                        }
                    };
                }
                [b"element", name, count] => {
                    let count = number(count).ok_or_else(|| source.malformed("`element NAME COUNT`", &line))?;
                    let name = String::from_utf8_lossy(name).into_owned();
                    elements.push(Element { name, count, properties: Vec::new() });
                }
                [b"property", .., name] => {
                    let types = words[1..words.len() - 1].iter().filter(|word| **word != b"list");
                    let types: Option<Vec<SampleType>> = types.map(|word| number_type(word)).collect();
                    let (list, kind) = match (words[1] == b"list", types.as_deref()) {
                        (false, Some([kind])) => (None, *kind),
                        (true, Some([length, kind])) => (Some(*length), *kind),
                        _ => {
                            return Err(
                                source.malformed("`property TYPE NAME` or `property list TYPE TYPE NAME`", &line)
                            );
                        }
                    };
                    let Some(element) = elements.last_mut() else {
                        return Err(source.malformed("an `element` before its properties", &line));
                    };
                    element.properties.push(Property { name: String::from_utf8_lossy(name).into_owned(), list, kind });
                }
                _ => return Err(source.malformed("a line of a PLY header", &line)),
            }
        }
        let encoding = encoding
            .ok_or_else(|| source.malformed_at(Location::Header, "`format ascii 1.0` or another", "nothing".into()))?;
        Ok(Header { encoding, elements })
    }
}

/// Reader of the numbers after the header.
struct Values<'a, 'b> {
    source: &'a mut Source<'b>,
    encoding: Encoding,
    /// Current line of a text file, and the number of bytes consumed of it.
    line: Vec<u8>,
    at: usize,
}

impl Values<'_, '_> {
    /// Checks that the file is long enough for the declared count.
    fn check(&self, element: &Element) -> Result<(), ShapeError> {
        let least = |property: &Property| match (self.encoding, property.list) {
            (Encoding::Text, _) => 2, // a digit and a separator
            (_, Some(length)) => length.bytes(),
            (_, None) => property.kind.bytes(),
        };
        let bytes = element.properties.iter().map(least).sum::<u64>();
        let (declared, left) = (element.count.saturating_mul(bytes), self.left());
        // The last line of a text file may lack its line end.
        if declared > left + u64::from(self.encoding == Encoding::Text) {
            let what = format!("{} of {}, at least {bytes} bytes each", element.count, element.name);
            return Err(self.source.data_size(declared, what, Found::Bytes(left)));
        }
        Ok(())
    }

    /// Reads an element: calls `take` with each number and the index of its property.
    fn element(&mut self, element: &Element, mut take: impl FnMut(usize, f64)) -> Result<(), ShapeError> {
        for (place, property) in element.properties.iter().enumerate() {
            let count = match property.list {
                None => 1,
                Some(length) => {
                    let count = self.number(length)?;
                    let bytes = if self.encoding == Encoding::Text { 1 } else { property.kind.bytes() };
                    if count < 0.0 || count.fract() != 0.0 || count * bytes as f64 > self.left() as f64 + 1.0 {
                        let found = format!("{count} numbers of `{}`", property.name);
                        return Err(self.malformed("a list that is in the file", found));
                    }
                    count as u64
                }
            };
            for _ in 0..count {
                take(place, self.number(property.kind)?);
            }
        }
        Ok(())
    }

    /// Notes bytes after the last element.
    fn note_rest(&mut self) {
        let bytes = self.left();
        let is_blank = |byte: &u8| byte.is_ascii_whitespace();
        if self.encoding == Encoding::Text && self.line[self.at..].iter().all(is_blank) {
            let mut rest = (&mut *self.source.reader).bytes().map_while(Result::ok);
            if rest.all(|byte| is_blank(&byte)) {
                return;
            }
        }
        if bytes > 0 {
            self.source.note(format!("bytes after the last element are left out: {bytes}"));
        }
    }

    /// Bytes not read yet.
    fn left(&self) -> u64 {
        self.source.remaining() + (self.line.len() - self.at) as u64
    }

    /// Error at the current position.
    fn malformed(&self, expected: &'static str, found: String) -> ShapeError {
        let place = match self.encoding {
            Encoding::Text => Location::Line(self.source.line),
            _ => Location::Byte(self.source.offset),
        };
        self.source.malformed_at(place, expected, found)
    }

    fn number(&mut self, kind: SampleType) -> Result<f64, ShapeError> {
        if self.encoding == Encoding::Text {
            return self.word();
        }
        let mut bytes = [0; 8];
        let bytes = &mut bytes[..kind.bytes() as usize];
        if self.source.remaining() < kind.bytes() {
            return Err(self.malformed("more numbers", "the end of the file".into()));
        }
        self.source.fill(bytes)?;
        Ok(kind.value(bytes, self.encoding == Encoding::Big))
    }

    /// Next number of a text file.
    fn word(&mut self) -> Result<f64, ShapeError> {
        loop {
            let rest = &self.line[self.at..];
            let start = rest.iter().position(|byte| !byte.is_ascii_whitespace());
            if let Some(start) = start {
                let word = &rest[start..];
                let word = &word[..word.iter().position(u8::is_ascii_whitespace).unwrap_or(word.len())];
                let value = number(word).ok_or_else(|| self.malformed("a number", quoted(word)))?;
                self.at += start + word.len();
                return Ok(value);
            }
            self.at = 0;
            if !self.source.next_line(&mut self.line)? {
                return Err(self.malformed("more numbers", "the end of the file".into()));
            }
        }
    }
}

/// Contents of the elements read so far.
#[derive(Default)]
struct Parts {
    positions: Vec<DVec3>,
    /// Colors of the vertices, linear RGB; empty without.
    colors: Vec<[f32; 3]>,
    /// Corners of all faces and strips.
    corners: Vec<u32>,
    /// Number of corners, and whether it is a strip.
    polygons: Vec<(u32, bool)>,
    /// Upper bound of the number of triangles.
    declared: u64,
}

impl Parts {
    fn vertices(&mut self, values: &mut Values<'_, '_>, element: &Element) -> Result<(), ShapeError> {
        let property = |name: &str| {
            let expected = "numbers x, y and z of `element vertex`";
            let missing = || values.source.malformed_at(Location::Header, expected, format!("no `{name}`"));
            element.find(&[name], false).ok_or_else(missing)
        };
        let properties = [property("x")?, property("y")?, property("z")?];
        values.source.check_triangles(element.count.div_ceil(3))?;
        let colors = ["red", "green", "blue"].map(|name| element.find(&[name], false));
        // Whole numbers are codes of sRGB up to the largest of their type.
        let full = |place: usize| match element.properties[place].kind {
            SampleType::U8 => 255.0,
            SampleType::U16 => 65535.0,
            _ => 1.0,
        };
        for _ in 0..element.count {
            let (mut position, mut color) = ([0.0; 3], [0.0; 3]);
            values.element(element, |place, value| {
                for (channel, own) in colors.iter().enumerate() {
                    if *own == Some(place) {
                        color[channel] = linear(value / full(place));
                    }
                }
                for (axis, own) in properties.iter().enumerate() {
                    if *own == place {
                        position[axis] = value;
                    }
                }
            })?;
            self.positions.push(DVec3::from(position));
            self.colors.extend(colors.iter().all(Option::is_some).then_some(color));
        }
        Ok(())
    }

    fn polygons(&mut self, values: &mut Values<'_, '_>, element: &Element, is_strip: bool) -> Result<(), ShapeError> {
        let Some(own) = element.find(&["vertex_indices", "vertex_index"], true) else {
            let expected = "a list `vertex_indices` of its faces";
            return Err(values.source.malformed_at(Location::Header, expected, format!("none in `{}`", element.name)));
        };
        for _ in 0..element.count {
            let (before, mut bad) = (self.corners.len(), None);
            values.element(element, |place, value| {
                if place == own {
                    let is_index = value.fract() == 0.0 && (0.0..f64::from(END)).contains(&value);
                    match is_strip && value == -1.0 {
                        true => self.corners.push(END),
                        false if is_index => self.corners.push(value as u32),
                        false => bad = Some(value),
                    }
                }
            })?;
            if let Some(value) = bad {
                return Err(values.malformed("the index of a vertex", format!("{value}")));
            }
            let count = self.corners.len() - before;
            self.declared += count.saturating_sub(2) as u64;
            values.source.check_triangles(self.declared)?;
            self.polygons.push((count as u32, is_strip));
        }
        Ok(())
    }

    fn finish(self, source: &mut Source) -> Result<Shape, ShapeError> {
        let (mut triangles, mut corners, mut short) = (Vec::new(), self.corners.as_slice(), 0);
        let count = self.positions.len();
        for (face, (own, is_strip)) in self.polygons.into_iter().enumerate() {
            let polygon;
            (polygon, corners) = corners.split_at(own as usize);
            if own < 3 {
                short += 1;
                continue;
            }
            let place = Location::Face(face as u64);
            if let Some(index) = polygon.iter().find(|index| **index as usize >= count && !(is_strip && **index == END))
            {
                let found = format!("vertex {index} of {count}, counted from 0");
                return Err(source.malformed_at(place, "the index of a vertex", found));
            }
            if is_strip {
                for strip in polygon.split(|index| *index == END) {
                    let turned = |(at, corners): (usize, &[u32])| match at % 2 {
                        0 => [corners[0], corners[1], corners[2]],
                        _ => [corners[1], corners[0], corners[2]],
                    };
                    triangles.extend(strip.windows(3).enumerate().map(turned));
                }
            } else if !triangulate(polygon, &self.positions, &mut triangles) {
                return Err(polygon::too_large(source, place, own as usize));
            }
        }
        check_positions(&source.file, "vertices", &self.positions)?;
        if short > 0 {
            source.note(format!("faces and strips of fewer than 3 corners are left out: {short}"));
        }
        source.finish(
            Mesh::cleaned_with(&self.positions, &self.colors, &[], triangles),
            format!("{count} vertices and no face"),
        )
    }
}

/// Marks the end of a triangle strip.
const END: u32 = u32::MAX;

// No vertex has this index.
const _: () = assert!(3 * MAX_TRIANGLES < END as u64);
