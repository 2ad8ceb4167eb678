//! Inputs of one object of a scene: its volume and the storage of its distances.

use crate::render::camera::{FrameContext, ObjectView};
use crate::render::error::RenderError;
use crate::render::subject::Subject;
use crate::render::texture::{self, Encoding, Texels};
use crate::render::variant::{ObjectImage, Program, Variant};
use crate::scene::{FieldEncoding, Parameters, Scene};
use std::borrow::Cow;

/// Decoding of a distance stored in a volume, units of its object: `x + y s` for a texel s.
#[derive(Clone, Copy, Default)]
pub(crate) struct StoredDistance {
    pub(crate) decode: [f32; 2],
    pub(crate) quantization: f32,
    /// Range of the offsets to the closest points.
    pub(crate) closest_range: f32,
}

/// One object of the scene, with the suffix of its names in the program.
pub(crate) struct ObjectInputs<'a> {
    pub(crate) suffix: String,
    pub(crate) own: &'a ObjectView,
    /// The scene reduced to this object.
    pub(crate) scene: Cow<'a, Scene>,
    pub(crate) subject: &'a Subject,
    pub(crate) parameters: &'a Parameters,
    pub(crate) stored: StoredDistance,
}

impl<'a> ObjectInputs<'a> {
    pub(crate) fn of(frame: &'a FrameContext, view: &'a ObjectView, stored: StoredDistance) -> ObjectInputs<'a> {
        let FrameContext { subject, variant, .. } = frame;
        let (suffix, scene, subject, parameters) = match view.name.as_str() {
            "" => (String::new(), Cow::Borrowed(&variant.scene), subject, &variant.parameters),
            name => {
                let scene = Cow::Owned(variant.scene.part_as_scene(name));
                (format!("_{name}"), scene, &subject.parts[name], &variant.parts[name])
            }
        };
        ObjectInputs { suffix, own: view, scene, subject, parameters, stored }
    }

    /// Whether a program reads an image of this object.
    pub(crate) fn is_read(&self, program: &Program, image: ObjectImage) -> bool {
        program.image_of(&self.own.name, image).is_some()
    }

    /// Volume of the object; `None` for a formula.
    pub(crate) fn volume(&self, variant: &Variant) -> Option<Texels> {
        let field = self.subject.field.as_ref()?;
        let (encoding, range) = self.encoding(variant);
        Some(texture::encode(field, encoding, range))
    }

    /// Encoding of the volume, and the stored range of distances, units of the field.
    pub(crate) fn encoding(&self, variant: &Variant) -> (Encoding, [f32; 2]) {
        let slot = if self.own.name.is_empty() { "object".into() } else { format!("{}.object", self.own.name) };
        let encoding = match (self.scene.object.field_encoding, variant.module(&slot)) {
            (FieldEncoding::Normals8, _) => Encoding::Normals8,
            (FieldEncoding::Distance32, _) => Encoding::Distance32,
            (_, Some("distance")) => Encoding::Distance16,
            _ => Encoding::Normals16,
        };
        let reach = self.reach() / self.subject.scale;
        (encoding, [-reach, reach])
    }

    /// Largest stored distance, units of the object: twice the soft region on either side, since gradients and filters
    /// read beyond it.
    pub(crate) fn reach(&self) -> f32 {
        self.own.outer_iso.abs() + self.scene.object.inner_iso.abs() + 0.25
    }

    /// Offsets to the closest points of the inner surface, and their range in units of the field.
    pub(crate) fn closest(&self) -> Result<(Texels, f32), RenderError> {
        let both = self.subject.field.as_ref().zip(self.subject.closest.as_ref());
        let (field, closest) = both.ok_or(RenderError::Missing(ObjectImage::Closest.label()))?;
        let (bytes, range) = texture::encode_closest(closest, field, self.scene.object.inner_iso / self.subject.scale);
        Ok((
            Texels { size: field.grid.size, encoding: Encoding::Normals16, bytes, decode: [0.0; 2], quantization: 0.0 },
            range,
        ))
    }

    /// Upper bound of a sampled distance minus the true one, units of the object.
    ///
    /// Warps move the lookup, at the sample and at the end of a skip by different amounts. The trilinear filter mixes
    /// eight samples whose weighted mean is at most half a voxel diagonal away (Jensen's inequality). A stored distance
    /// is rounded, and f32 adds a few ulps.
    pub(crate) fn skip_slack(&self) -> f32 {
        let spacing = self.subject.field.as_ref().map_or(0.0, |field| field.grid.spacing.length());
        self.own.spread.moves.span() + 0.5 * spacing * self.subject.scale + self.stored.quantization + 1e-5
    }
}
