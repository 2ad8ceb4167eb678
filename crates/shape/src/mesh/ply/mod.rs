//! Polygon File Format (PLY): polygons and strips, as text or binary.
//!
//! Role: the elements `vertex`, `face` and `tristrips` as a mesh; others are skipped. Invariant: no memory is allocated for a
//! declared count. Source: G. Turk, "The PLY polygon file format", Stanford, 1994.

mod colors;
mod header;
mod values;

use super::polygon::{self, triangulate};
use crate::error::{Location, ShapeError};
use crate::shape::{MAX_TRIANGLES, Mesh, Shape};
use crate::source::{Source, check_positions};
use colors::{Channels, colored_by_face};
use glam::DVec3;
use header::{Element, PlyHeader};
use values::Values;

/// Whether the file begins with the line `ply`.
pub(crate) fn recognizes(start: &[u8], _len: u64) -> bool {
    start.starts_with(b"ply") && start.get(3).is_some_and(u8::is_ascii_whitespace)
}

/// Reads positions, faces and strips; properties may have any order and type.
///
/// Normals, texture coordinates and other elements are skipped.
pub(crate) fn read(source: &mut Source) -> Result<Shape, ShapeError> {
    let header = PlyHeader::read(source)?;
    let mut parts = Parts::default();
    let mut values = Values::new(source, &header);
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

/// Contents of the elements read so far.
#[derive(Default)]
struct Parts {
    positions: Vec<DVec3>,
    /// Colors of the vertices, linear RGB; empty without.
    colors: Vec<[f32; 3]>,
    /// Colors of the faces and strips, linear RGB; empty without.
    face_colors: Vec<[f32; 3]>,
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
        let channels = Channels::of(|name| element.scalar(name));
        for _ in 0..element.count {
            let (mut position, mut color) = ([0.0; 3], [0.0; 3]);
            values.element(element, |place, value| {
                channels.take(&mut color, place, value);
                for (axis, own) in properties.iter().enumerate() {
                    if *own == place {
                        position[axis] = value;
                    }
                }
            })?;
            self.positions.push(DVec3::from(position));
            self.colors.extend(channels.are_there().then_some(color));
        }
        channels.decode(values.source, &mut self.colors);
        Ok(())
    }

    fn polygons(&mut self, values: &mut Values<'_, '_>, element: &Element, is_strip: bool) -> Result<(), ShapeError> {
        let Some(own) = element.find(&["vertex_indices", "vertex_index"], true) else {
            let expected = "a list `vertex_indices` of its faces";
            return Err(values.source.malformed_at(Location::Header, expected, format!("none in `{}`", element.name)));
        };
        let channels = Channels::of(|name| element.scalar(name));
        let first = self.face_colors.len();
        for _ in 0..element.count {
            let (before, mut bad, mut color) = (self.corners.len(), None, [0.0; 3]);
            values.element(element, |place, value| {
                channels.take(&mut color, place, value);
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
            self.face_colors.extend(channels.are_there().then_some(color));
        }
        channels.decode(values.source, &mut self.face_colors[first..]);
        Ok(())
    }

    fn check_corners(&self, source: &Source) -> Result<(), ShapeError> {
        let (count, mut corners) = (self.positions.len(), self.corners.as_slice());
        for (face, (own, is_strip)) in self.polygons.iter().enumerate() {
            let polygon;
            (polygon, corners) = corners.split_at(*own as usize);
            let is_missing = |index: &&u32| **index as usize >= count && !(*is_strip && **index == END);
            if let Some(index) = polygon.iter().find(is_missing).filter(|_| *own >= 3) {
                let (place, found) =
                    (Location::Face(face as u64), format!("vertex {index} of {count}, counted from 0"));
                return Err(source.malformed_at(place, "the index of a vertex", found));
            }
        }
        Ok(())
    }

    fn finish(mut self, source: &mut Source) -> Result<Shape, ShapeError> {
        self.check_corners(source)?;
        let faces = std::mem::take(&mut self.face_colors);
        match (faces.is_empty() || faces.len() != self.polygons.len(), self.colors.is_empty()) {
            (true, _) => {}
            (false, false) => source.note("colors of faces are left out, those of vertices are read".into()),
            (false, true) => {
                let polygons = self.polygons.iter().map(|(count, _)| *count).zip(faces);
                (self.positions, self.colors) = colored_by_face(&self.positions, &mut self.corners, polygons);
            }
        }
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
