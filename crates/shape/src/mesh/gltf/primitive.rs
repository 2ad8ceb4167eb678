//! Primitives of a glTF mesh.
//!
//! Role: indexed and plain triangles, strips and fans as triangles over the used vertices. Invariant: triangles without area are
//! dropped before they take memory.

use super::accessor::Elements;
use super::buffer::Data;
use super::document::{Primitive, malformed};
use super::material::Materials;
use crate::error::ShapeError;
use crate::sample_type::SampleType::{F32, I8, I16, U8, U16, U32};
use crate::shape::looks::{channel, full_scale};
use crate::shape::paint::Spot;
use crate::source::Source;
use glam::{DAffine3, DVec3};
use std::collections::HashMap;

/// Mesh in its local coordinates.
#[derive(Default)]
pub(crate) struct MeshPart {
    pub positions: Vec<DVec3>,
    /// Linear RGB of each position; white where a primitive has no colors.
    pub colors: Vec<[f32; 3]>,
    /// Spots of the positions; empty unless materials are asked for.
    pub spots: Vec<Spot>,
    /// Whether a primitive has colors.
    pub is_colored: bool,
    pub triangles: Vec<[u32; 3]>,
    /// Dropped triangles.
    pub zero_area: usize,
    /// Number of primitives of points or lines.
    pub points_and_lines: usize,
    /// Number of primitives without positions.
    pub without_positions: usize,
    /// Number of corners after the last whole triangle.
    pub leftover_corners: usize,
    /// Number of primitives without vertices or indices.
    pub empty: usize,
    /// Number of primitives with a material that cuts parts of them away.
    pub masked: usize,
    /// Whether there are morph targets.
    pub morphs: bool,
}

/// Colors of vertices, with opacity or without.
enum Colors<'a> {
    Rgb(Elements<'a, 3>),
    Rgba(Elements<'a, 4>),
}

impl<'a> Colors<'a> {
    fn read(data: &'a Data, index: u32, place: impl Fn() -> String) -> Result<Colors<'a>, ShapeError> {
        let kind = data.document.accessors.get(index as usize).map(|accessor| accessor.kind.as_str());
        Ok(match kind {
            Some("VEC4") => Colors::Rgba(Elements::read(data, index, &[F32, U8, U16], place)?),
            _ => Colors::Rgb(Elements::read(data, index, &[F32, U8, U16], place)?),
        })
    }

    fn count(&self) -> u64 {
        match self {
            Colors::Rgb(elements) => elements.count,
            Colors::Rgba(elements) => elements.count,
        }
    }

    /// Scales colors that are not in \[0, 1\]: whole numbers that are not declared as normalized, and floats of 0 to 255.
    fn scaled(mut self, source: &Source) -> Colors<'a> {
        let (count, full) = (
            self.count(),
            match &mut self {
                Colors::Rgb(elements) => elements.normalize(),
                Colors::Rgba(elements) => elements.normalize(),
            },
        );
        if let Some(full) = full {
            source.note(format!("COLOR_0 of whole numbers without `normalized` is read as 0 to {full}"));
            return self;
        }
        let all: Vec<[f32; 3]> = (0..count).map(|index| self.raw(index).map(|value| value as f32)).collect();
        let (full, note) = full_scale(&all);
        note.into_iter().for_each(|note| source.note(note));
        match &mut self {
            Colors::Rgb(elements) => elements.full = full,
            Colors::Rgba(elements) => elements.full = full,
        }
        self
    }

    /// Linear RGB.
    fn get(&self, index: u64) -> [f32; 3] {
        self.raw(index).map(channel)
    }

    fn raw(&self, index: u64) -> [f64; 3] {
        match self {
            Colors::Rgb(elements) => elements.get(index),
            Colors::Rgba(elements) => elements.get(index).first_chunk().copied().unwrap_or_default(),
        }
    }
}

impl MeshPart {
    /// Reads a mesh, with materials if they are asked for; `declared` sums the triangles of all meshes.
    pub fn read(
        (data, materials): (&Data, Option<&Materials>),
        mesh: u32,
        declared: &mut u64,
    ) -> Result<MeshPart, ShapeError> {
        let mut part = MeshPart::default();
        if data.document.meshes[mesh as usize].primitives.is_empty() {
            let found = "no `primitives`, or an empty list";
            return Err(malformed(data.source, format!("meshes[{mesh}]"), "1 primitive or more", found));
        }
        for (index, primitive) in data.document.meshes[mesh as usize].primitives.iter().enumerate() {
            let at = |field: &str| format!("meshes[{mesh}].primitives[{index}]{field}");
            let accessors = &data.document.accessors;
            let is_empty = |index: Option<u32>| {
                index.and_then(|index| accessors.get(index as usize)).is_some_and(|accessor| accessor.count == 0)
            };
            if is_empty(primitive.attributes.position) || is_empty(primitive.indices) {
                part.empty += 1;
                continue;
            }
            let is_plain = |index: u32| {
                accessors.get(index as usize).is_some_and(|own| own.buffer_view.is_some() || own.sparse.is_some())
            };
            let has_plain =
                primitive.attributes.position.is_some_and(is_plain) && primitive.indices.is_none_or(is_plain);
            primitive.extensions.check((data.source, data.document), has_plain, || at(""))?;
            part.morphs |= primitive.targets.as_ref().is_some_and(|targets| !targets.is_empty());
            match primitive.mode.unwrap_or(4) {
                0..=3 => part.points_and_lines += 1,
                mode @ 4..=6 => {
                    part.masked += usize::from(data.document.is_masked(primitive));
                    part.add((data, materials), primitive, [mesh, index as u32, mode], declared, at)?;
                }
                mode => return Err(malformed(data.source, at(".mode"), "0 to 6", mode)),
            }
        }
        Ok(part)
    }

    /// Positions in the world of a node.
    pub fn at(&self, world: DAffine3) -> impl Iterator<Item = DVec3> {
        self.positions.iter().map(move |position| world.transform_point3(*position))
    }

    fn add(
        &mut self,
        (data, materials): (&Data, Option<&Materials>),
        primitive: &Primitive,
        [mesh, index, mode]: [u32; 3],
        declared: &mut u64,
        at: impl Fn(&str) -> String,
    ) -> Result<(), ShapeError> {
        let Some(position) = primitive.attributes.position else {
            self.without_positions += 1; // ignored, as the specification requires
            return Ok(());
        };
        let place = || at(".attributes.POSITION");
        let positions = Elements::<3>::read(data, position, &[F32, I8, U8, I16, U16], place)?;
        let colors = primitive.attributes.color.map(|index| Colors::read(data, index, || at(".attributes.COLOR_0")));
        let colors = colors.transpose()?.filter(|colors| colors.count() >= positions.count);
        let colors = colors.map(|colors| colors.scaled(data.source));
        self.is_colored |= colors.is_some();
        let spots = materials.map(|all| all.spots(data, [mesh, index], positions.count)).transpose()?;
        let indices =
            primitive.indices.map(|index| Elements::<1>::read(data, index, &[U8, U16, U32], || at(".indices")));
        let indices = indices.transpose()?;
        let corners = indices.as_ref().map_or(positions.count, |indices| indices.count);
        let count = if mode == 4 { corners / 3 } else { corners.saturating_sub(2) };
        self.leftover_corners += match mode {
            4 => corners % 3,
            _ => corners.min(2) * u64::from(count == 0),
        } as usize;
        *declared = declared.saturating_add(count);
        data.source.check_triangles(*declared)?;

        let corner = |corner: u64| {
            let Some(indices) = &indices else { return Ok(corner) };
            let [index] = indices.get(corner);
            if index < positions.count as f64 && index != indices.largest_index() {
                return Ok(index as u64);
            }
            let place = format!("accessors[{}]", primitive.indices.unwrap_or_default());
            let found = format!("{index} as number {corner} (from 0), of {} vertices", positions.count);
            Err(malformed(data.source, place, "indices of vertices, and none that restarts a strip", found))
        };
        let mut renumbered = HashMap::new();
        for at in 0..count {
            let triangle = match mode {
                4 => [3 * at, 3 * at + 1, 3 * at + 2],
                5 => [at, at + 1 + at % 2, at + 2 - at % 2],
                _ => [at + 1, at + 2, 0],
            };
            let triangle = [corner(triangle[0])?, corner(triangle[1])?, corner(triangle[2])?];
            let [a, b, c] = triangle.map(|corner| DVec3::from(positions.get(corner)));
            if (b - a).cross(c - a) == DVec3::ZERO {
                self.zero_area += 1;
                continue;
            }
            let mut kept = |corner: u64, position: DVec3| {
                *renumbered.entry(corner).or_insert_with(|| {
                    self.positions.push(position);
                    self.colors.push(colors.as_ref().map_or([1.0; 3], |colors| colors.get(corner)));
                    self.spots.extend(spots.as_ref().map(|spots| spots.at(corner)));
                    self.positions.len() as u32 - 1
                })
            };
            let triangle = [kept(triangle[0], a), kept(triangle[1], b), kept(triangle[2], c)];
            self.triangles.push(triangle);
        }
        Ok(())
    }
}
