//! Materials of a glTF file: base colors and their textures.
//!
//! Role: the part of the schema that describes colors, parsed only where it is asked for. Invariant: references are checked
//! where they are used.

use super::accessor::Elements;
use super::buffer::Data;
use super::document::{Text, entry, json_as, list, malformed, unsupported};
use crate::error::{Location, ShapeError};
use crate::mesh::textures::{Textures, check_spots, decode_texture};
use crate::sample_type::SampleType::{F32, I8, I16, U8, U16};
use crate::shape::looks::channel;
use crate::shape::paint::{self, Spot};
use crate::shape::texture::{Texture, Wrap};
use crate::source::Source;
use serde::Deserialize;
use std::collections::BTreeMap;
use std::sync::Arc;

/// Colors in the JSON.
#[derive(Deserialize)]
pub(crate) struct Materials<'a> {
    #[serde(default, deserialize_with = "list")]
    meshes: Vec<Mesh>,
    #[serde(default, deserialize_with = "list")]
    materials: Vec<Material>,
    #[serde(default, deserialize_with = "list")]
    textures: Vec<TextureOf>,
    #[serde(borrow, default, deserialize_with = "list")]
    images: Vec<Image<'a>>,
    #[serde(default, deserialize_with = "list")]
    samplers: Vec<Sampler>,
}

#[derive(Deserialize)]
struct Mesh {
    #[serde(default, deserialize_with = "list")]
    primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
struct Primitive {
    material: Option<u32>,
    attributes: BTreeMap<String, u32>,
}

#[derive(Default, Deserialize)]
struct Material {
    #[serde(default, rename = "pbrMetallicRoughness")]
    base: Base,
    #[serde(default)]
    extensions: Shading,
}

/// Older and other descriptions of a color.
#[derive(Default, Deserialize)]
struct Shading {
    #[serde(rename = "KHR_materials_pbrSpecularGlossiness")]
    diffuse: Option<Diffuse>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Diffuse {
    diffuse_factor: Option<[f64; 4]>,
    diffuse_texture: Option<TextureInfo>,
}

impl Material {
    /// Color and texture, with the place of the latter in a material: those of the core, else the diffuse ones of specular-glossiness.
    fn color(&self) -> (Option<[f64; 4]>, Option<(&TextureInfo, &'static str)>) {
        let core = self.base.base_color_texture.as_ref().map(|info| (info, "pbrMetallicRoughness.baseColorTexture"));
        let diffuse =
            self.extensions.diffuse.as_ref().filter(|_| core.is_none() && self.base.base_color_factor.is_none());
        let Some(diffuse) = diffuse else { return (self.base.base_color_factor, core) };
        let place = "extensions.KHR_materials_pbrSpecularGlossiness.diffuseTexture";
        // Without a factor it is white.
        let factor = diffuse.diffuse_factor.or(Some([1.0; 4]));
        (factor, diffuse.diffuse_texture.as_ref().map(|info| (info, place)))
    }
}

#[derive(Default, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Base {
    base_color_factor: Option<[f64; 4]>,
    base_color_texture: Option<TextureInfo>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct TextureInfo {
    index: u32,
    #[serde(default)]
    tex_coord: u32,
    #[serde(default)]
    extensions: Moves,
}

#[derive(Default, Deserialize)]
struct Moves {
    #[serde(rename = "KHR_texture_transform")]
    transform: Option<Transform>,
}

/// Scale, rotation and offset of texture coordinates.
#[derive(Clone, Deserialize)]
#[serde(rename_all = "camelCase", default)]
struct Transform {
    offset: [f64; 2],
    rotation: f64,
    scale: [f64; 2],
    tex_coord: Option<u32>,
}

impl Default for Transform {
    fn default() -> Transform {
        Transform { offset: [0.0; 2], rotation: 0.0, scale: [1.0; 2], tex_coord: None }
    }
}

#[derive(Deserialize)]
struct TextureOf {
    sampler: Option<u32>,
    source: Option<u32>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Image<'a> {
    #[serde(borrow)]
    uri: Option<Text<'a>>,
    buffer_view: Option<u32>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
struct Sampler {
    wrap_s: Option<u32>,
    wrap_t: Option<u32>,
}

/// Spots of the vertices of a primitive.
pub(crate) struct Spots<'a> {
    material: u32,
    coordinates: Option<(Elements<'a, 2>, Transform)>,
}

impl Spots<'_> {
    pub fn at(&self, corner: u64) -> Spot {
        let uv = self.coordinates.as_ref().map_or([0.0; 2], |(elements, transform)| {
            let [u, v] = elements.get(corner);
            let ([u, v], (sin, cos)) = ([u * transform.scale[0], v * transform.scale[1]], transform.rotation.sin_cos());
            // Counterclockwise where v runs down, as in the examples of the extension.
            [cos * u + sin * v + transform.offset[0], cos * v - sin * u + transform.offset[1]]
        });
        Spot { material: self.material, uv: uv.map(|part| part as f32) }
    }
}

impl<'a> Materials<'a> {
    pub fn parse(source: &Source, json: &'a [u8]) -> Result<Materials<'a>, ShapeError> {
        json_as(source, json)
    }

    /// Spots of a primitive of a mesh with `count` vertices. A primitive without a material gets the one after the last.
    pub fn spots<'d>(&self, data: &'d Data, [mesh, index]: [u32; 2], count: u64) -> Result<Spots<'d>, ShapeError> {
        let primitive = &self.meshes[mesh as usize].primitives[index as usize];
        let Some(material) = primitive.material else {
            return Ok(Spots { material: self.materials.len() as u32, coordinates: None });
        };
        let at = |field: &str| format!("meshes[{mesh}].primitives[{index}]{field}");
        let own = entry(data.source, &self.materials, material, || at(".material"))?;
        let Some((texture, _)) = own.color().1 else { return Ok(Spots { material, coordinates: None }) };
        let transform = texture.extensions.transform.clone().unwrap_or_default();
        let name = format!("TEXCOORD_{}", transform.tex_coord.unwrap_or(texture.tex_coord));
        let Some(accessor) = primitive.attributes.get(&name) else {
            let expected = "the texture coordinates that its material names";
            return Err(malformed(data.source, at(".attributes"), expected, format!("no {name}")));
        };
        let place = || at(&format!(".attributes.{name}"));
        let elements = Elements::read(data, *accessor, &[F32, I8, U8, I16, U16], place)?;
        if elements.count < count {
            let found = format!("{} for {count} vertices", elements.count);
            return Err(malformed(data.source, place(), "texture coordinates of every vertex", found));
        }
        Ok(Spots { material, coordinates: Some((elements, transform)) })
    }

    /// Materials with the textures of those in `spots`, which are cleared if they give no color.
    pub fn used(&self, data: &Data, spots: &mut Vec<Spot>) -> Result<Vec<paint::Material>, ShapeError> {
        check_spots(data.source, spots)?;
        let mut is_used = vec![false; self.materials.len() + 1];
        spots.iter().for_each(|spot| is_used[spot.material as usize] = true);
        let mut textures = Textures::default();
        let default = Material::default();
        let each = self.materials.iter().chain([&default]).zip(&is_used).enumerate();
        let all = each.map(|(index, (material, is_used))| {
            let (factor, own_texture) = material.color();
            let color = factor.map_or([1.0; 3], |[r, g, b, _]| [r, g, b].map(channel));
            let (mut texture, mut wraps) = (None, [Wrap::Repeat; 2]);
            if let Some((info, at)) = own_texture.filter(|_| *is_used) {
                let place = format!("materials[{index}].{at}.index");
                let (decoded, own) = self.texture(data, info.index, &place, &mut textures)?;
                (texture, wraps) = (Some(decoded), own);
            }
            Ok(paint::Material { color: Some(color), texture, wraps })
        });
        let all = all.collect::<Result<Vec<_>, ShapeError>>()?;
        let has_color = |material: &Material| {
            let (factor, texture) = material.color();
            factor.is_some() || texture.is_some()
        };
        if !self.materials.iter().zip(&is_used).any(|(material, is_used)| *is_used && has_color(material)) {
            spots.clear();
        }
        Ok(all)
    }

    /// Decoded texture `index`, and its wrapping.
    fn texture(
        &self,
        data: &Data,
        index: u32,
        place: &str,
        textures: &mut Textures,
    ) -> Result<(Arc<Texture>, [Wrap; 2]), ShapeError> {
        let source = data.source;
        let texture = entry(source, &self.textures, index, || place.into())?;
        let sampler =
            texture.sampler.map(|own| entry(source, &self.samplers, own, || format!("textures[{index}].sampler")));
        let codes = sampler.transpose()?.map_or([None; 2], |sampler| [sampler.wrap_s, sampler.wrap_t]);
        let [s, t] = codes.map(|code| match code {
            None | Some(10497) => Ok(Wrap::Repeat),
            Some(33648) => Ok(Wrap::Mirror),
            Some(33071) => Ok(Wrap::Clamp),
            Some(code) => {
                let place = format!("samplers[{}]", texture.sampler.unwrap_or_default());
                Err(malformed(source, place, "10497, 33648 or 33071 as its wrapping", code))
            }
        });
        let Some(image) = texture.source else {
            let remedy = "export its textures as PNG or JPEG (`gltf-transform png in.glb out.glb`)";
            return Err(unsupported(
                source,
                format!("textures[{index}]"),
                "a picture",
                "of an extension only".into(),
                remedy,
            ));
        };
        let own = entry(source, &self.images, image, || format!("textures[{index}].source"))?;
        let at = |field: &str| format!("images[{image}]{field}");
        let decoded = textures.named(source, image.to_string(), || match (&own.uri, own.buffer_view) {
            (_, Some(view)) => {
                let (_, bytes) = data.view(view, || at(".bufferView"))?;
                decode_texture(source, Location::Json(at("")), bytes)
            }
            (Some(uri), None) => {
                let bytes = data.load(&uri.0, None, || at(".uri"))?;
                decode_texture(source, Location::Json(at(".uri")), &bytes)
            }
            (None, None) => Err(malformed(source, at(""), "a picture in a file or a view", "none")),
        })?;
        Ok((decoded, [s?, t?]))
    }
}
