//! A linked program, and the parts that it leaves out.

use super::bindings::{ImageInput, NoiseImage, ObjectImage, PassImage};
use super::error::VariantError;
use super::reflect::{self, Resource, Use};
use flate2::read::DeflateDecoder;
use std::collections::{BTreeMap, BTreeSet};
use std::io::{self, Read};

include!(concat!(env!("OUT_DIR"), "/programs.rs"));

/// The shipped programs in the order of their keys: key, compressed vertex stage and fragment stage.
pub(super) fn shipped_programs() -> &'static [(&'static str, &'static [u8], &'static [u8])] {
    SHIPPED_PROGRAMS
}

/// `constant_id` of the octaves in `glsl/octave_constants.glsl`.
pub const OCTAVES_ID: u32 = 0;

/// Filled uniform blocks of a program, by binding.
pub type Blocks = BTreeMap<u32, Vec<u8>>;

/// A linked program with its bindings.
#[derive(Clone, Debug, PartialEq)]
pub struct Program {
    /// SPIR-V of the vertex stage.
    pub vertex: Vec<u32>,
    /// SPIR-V of the fragment stage, or of the compute stage.
    pub fragment: Vec<u32>,
    /// Whether it is a compute shader.
    pub is_compute: bool,
    /// Bindings that either stage reads.
    pub resources: Vec<Resource>,
    /// Whether it was linked at build time.
    pub shipped: bool,
}

impl Program {
    pub(super) fn of(vertex: Vec<u32>, fragment: Vec<u32>, shipped: bool) -> Result<Program, VariantError> {
        let resources = reflect::resources(&vertex, &fragment)?;
        let is_compute = reflect::is_compute(&fragment);
        Ok(Program { vertex, fragment, is_compute, resources, shipped })
    }

    /// Whether the program reads a binding.
    pub fn reads(&self, name: &str) -> bool {
        self.binding(name).is_some()
    }

    /// Number of a binding, if the program reads it.
    pub fn binding(&self, name: &str) -> Option<u32> {
        self.resources.iter().find(|resource| resource.name == name).map(|resource| resource.binding)
    }

    /// Whether the program reads an image of the scene or of its main object.
    pub fn reads_image(&self, image: impl Into<ImageInput>) -> bool {
        self.image(image).is_some()
    }

    /// Binding of an image of the scene or of its main object, if the program reads it.
    pub fn image(&self, image: impl Into<ImageInput>) -> Option<u32> {
        self.image_of("", image)
    }

    /// Binding of an image of an object, if the program reads it.
    pub fn image_of(&self, object: &str, image: impl Into<ImageInput>) -> Option<u32> {
        let image = image.into();
        let is_read = |resource: &&Resource| resource.image() == Some((image, object));
        self.resources.iter().find(is_read).map(|resource| resource.binding)
    }

    /// The images that the program reads, of any object.
    pub fn images(&self) -> impl Iterator<Item = ImageInput> {
        self.resources.iter().filter_map(|resource| resource.image()).map(|(image, _)| image)
    }

    /// Names of the members of all blocks.
    pub fn members(&self) -> impl Iterator<Item = &str> {
        let blocks = self.resources.iter().filter_map(|own| match &own.holds {
            Use::Block(block) => Some(block),
            _ => None,
        });
        blocks.flat_map(|block| block.members.iter().map(|member| member.name.as_str()))
    }

    /// Block members that the fragment stage reads in any function: pairs of a binding and a member index.
    pub fn members_read(&self) -> BTreeSet<(u32, u32)> {
        reflect::members_read(&self.fragment)
    }

    /// Bytes of those members in filled blocks.
    pub fn parts_read(&self, read: &BTreeSet<(u32, u32)>, blocks: &Blocks) -> Vec<u8> {
        let mut found = Vec::new();
        for (binding, bytes) in blocks {
            let holds = self.resources.iter().find(|own| own.binding == *binding).map(|own| &own.holds);
            let Some(Use::Block(block)) = holds else { continue };
            for (number, member) in (0..).zip(&block.members) {
                if read.contains(&(*binding, number)) {
                    found.extend_from_slice(&bytes[member.offset..][..4 * member.floats]);
                }
            }
        }
        found
    }

    /// Parts that the scene did not need: not in the program, not allocated, not uploaded, not bound.
    pub fn left_out(&self) -> Vec<&'static str> {
        let is_read = |images: &[ImageInput]| self.images().any(|image| images.contains(&image));
        PARTS.iter().filter(|(images, ..)| !is_read(images)).map(|(_, part, _)| *part).collect()
    }
}

/// Optional parts of a program: their images, name, and reason for the absence.
const PARTS: [(&[ImageInput], &str, &str); 9] = {
    use ImageInput::{Noise, Object, Pass};
    [
        (&[Object(ObjectImage::Volume)], "volume", "the object is a formula"),
        (
            &[Noise(NoiseImage::Noise), Noise(NoiseImage::NoiseValues)],
            "noise block",
            "no module looks noise up in a block",
        ),
        (
            &[Noise(NoiseImage::Turbulence), Noise(NoiseImage::TurbulenceValues)],
            "turbulence block",
            "no module looks turbulence up in a block",
        ),
        (
            &[Object(ObjectImage::Transfer)],
            "transfer map",
            "no module asks for a color by density, or it has one color",
        ),
        (&[Object(ObjectImage::Segment)], "segment table", "no segment is classified by the densities at its ends"),
        (&[Object(ObjectImage::Classified)], "classified volume", "colors are not given to voxels"),
        (&[Object(ObjectImage::Index)], "index map", "no ray bends"),
        (&[Object(ObjectImage::Closest)], "closest points", "no module asks for the root of a hair"),
        (&[Pass(PassImage::Shadow)], "shadow volume", "light.shadows is off, or the light goes from slice to slice"),
    ]
};

/// Reason for the absence of a part of [`Program::left_out`]; empty for other names.
pub(crate) fn why_left_out(name: &str) -> &'static str {
    PARTS.iter().find(|(_, part, _)| *part == name).map_or("", |(_, _, why)| why)
}

/// Deserializes names of [`Program::left_out`].
pub(crate) fn parts<'de, D: serde::Deserializer<'de>>(from: D) -> Result<Vec<&'static str>, D::Error> {
    let names: Vec<String> = serde::Deserialize::deserialize(from)?;
    Ok(PARTS.iter().map(|(_, part, _)| *part).filter(|part| names.iter().any(|name| name == part)).collect())
}

/// Decompresses SPIR-V from `build.rs`.
pub(super) fn words(compressed: &[u8]) -> io::Result<Vec<u32>> {
    let mut bytes = Vec::new();
    DeflateDecoder::new(compressed).read_to_end(&mut bytes)?;
    Ok(bytes.as_chunks().0.iter().map(|word| u32::from_le_bytes(*word)).collect())
}
