//! Colors of vertices and faces in PLY.

use crate::sample_type::SampleType;
use crate::shape::looks::{full_scale, linear};
use crate::source::Source;
use foldhash::HashMap;
use glam::DVec3;

/// Properties of an element that are its color.
pub(super) struct Channels {
    places: [Option<usize>; 3],
    /// Whether all are bytes.
    are_bytes: bool,
}

impl Channels {
    /// Names of the channels in the order of preference.
    const NAMES: [[&'static str; 3]; 3] =
        [["red", "green", "blue"], ["diffuse_red", "diffuse_green", "diffuse_blue"], ["r", "g", "b"]];

    /// Channels among the properties, of which `find` gives the index and the type.
    pub fn of(find: impl Fn(&str) -> Option<(usize, SampleType)>) -> Channels {
        let named = Channels::NAMES.map(|names| names.map(&find));
        let found = named.into_iter().find(|channels| channels.iter().all(Option::is_some)).unwrap_or_default();
        let are_bytes = found.iter().flatten().all(|(_, kind)| *kind == SampleType::U8);
        Channels { places: found.map(|channel| channel.map(|(place, _)| place)), are_bytes }
    }

    pub(crate) fn are_there(&self) -> bool {
        self.places[0].is_some()
    }

    /// Takes the value of a property if it is a channel.
    pub fn take(&self, color: &mut [f32; 3], place: usize, value: f64) {
        if let Some(channel) = self.places.iter().position(|own| *own == Some(place)) {
            color[channel] = value as f32;
        }
    }

    /// Turns codes of sRGB into linear light. Bytes end at 255; the other types declare no full scale.
    pub fn decode(&self, source: &Source, colors: &mut [[f32; 3]]) {
        let (full, note) = if self.are_bytes { (255.0, None) } else { full_scale(colors) };
        note.into_iter().for_each(|note| source.note(note));
        colors.as_flattened_mut().iter_mut().for_each(|code| *code = linear(f64::from(*code) / full));
    }
}

/// Vertices and their colors by those of faces, given as a number of corners and a color: a vertex for each color of its faces.
/// Corners beyond the vertices stay.
pub(super) fn colored_by_face(
    positions: &[DVec3],
    corners: &mut [u32],
    faces: impl Iterator<Item = (u32, [f32; 3])>,
) -> (Vec<DVec3>, Vec<[f32; 3]>) {
    let (mut places, mut colors) = (Vec::new(), Vec::new());
    let mut known = HashMap::<(u32, [u32; 3]), u32>::default();
    let mut rest = corners;
    for (count, color) in faces {
        let (own, after) = rest.split_at_mut(count as usize);
        rest = after;
        for corner in own {
            let Some(position) = positions.get(*corner as usize) else { continue };
            let next = places.len() as u32;
            *corner = *known.entry((*corner, color.map(f32::to_bits))).or_insert(next);
            if *corner == next {
                places.push(*position);
                colors.push(color);
            }
        }
    }
    (places, colors)
}
