//! What a program reads, made without a device: the values of its blocks, its images encoded, and nothing that it does
//! not read.

use super::noise_blocks::block;
use super::shadow::LightSpace;
use super::sub_frame::SubFrame;
use super::view::{Own, View};
use super::{RenderError, Subject};
use crate::field::Progress;
use crate::gpu::{Address, Dimension, Format};
use crate::pass::Planes;
use crate::scene::{KnobValue, Knobs, Projection, Rule, Scene, Source, Wrap};
use crate::texture::{self, Encoding, Texels};
use crate::variant::{Program, Resource, Use, Variant};
use std::collections::HashMap;

/// An image, encoded.
pub(crate) struct Encoded {
    pub(crate) name: &'static str,
    pub(crate) dimension: Dimension,
    pub(crate) format: Format,
    pub(super) content: Content,
}

/// Texels as they were made, x fastest.
pub(super) enum Content {
    Bytes(Vec<u8>),
    Codes(Vec<u16>),
    Floats(Vec<f32>),
}

impl Encoded {
    /// The texels as the device takes them.
    pub(crate) fn bytes(&self) -> &[u8] {
        match &self.content {
            Content::Bytes(bytes) => bytes,
            Content::Codes(codes) => bytemuck::cast_slice(codes),
            Content::Floats(floats) => bytemuck::cast_slice(floats),
        }
    }
}

/// The inputs of one program, but for the shadow volume, which is rendered.
pub(crate) struct Inputs {
    /// The images by binding.
    pub(crate) images: Vec<(u32, Encoded)>,
    /// The samplers by binding.
    pub(crate) samplers: Vec<(u32, Address)>,
    stored: StoredObjects,
}

/// How the distance of each object is stored, in the order of the view's objects.
#[derive(Clone)]
pub(super) struct StoredObjects(Vec<Stored>);

/// The values of the members of all blocks, by name.
pub(crate) type Values = HashMap<String, Vec<f32>>;

impl Inputs {
    /// Encodes every image that a program reads; `progress` is told of each block of noise.
    pub(crate) fn new(
        scene: &Scene,
        subject: &Subject,
        variant: &Variant,
        program: &Program,
        (view, planes): (&View, &Planes),
        progress: Progress<'_>,
    ) -> Result<Inputs, RenderError> {
        let mut items: Vec<Item<'_>> =
            view.objects.iter().map(|own| Item::of(own, scene, subject, variant, Stored::default())).collect();
        let (mut texels, mut ways) = (Vec::new(), Vec::new());
        for item in &mut items {
            let read = program.reads(&format!("volume_image{}", item.suffix));
            let made = if read { item.volume(variant) } else { None };
            if let Some(texels) = &made {
                item.stored.decode = texels.decode.map(|value| value * item.subject.scale);
                item.stored.quantization = texels.quantization * item.subject.scale;
            }
            texels.push(made);
            let read = program.reads(&format!("closest_image{}", item.suffix));
            let made = if read { Some(item.closest()?) } else { None };
            item.stored.closest_range = made.as_ref().map_or(0.0, |(_, range)| range * item.subject.scale);
            ways.push(made.map(|(ways, _)| ways));
        }
        let (mut images, mut samplers) = (Vec::new(), Vec::new());
        for Resource { name, binding, holds, .. } in &program.resources {
            match holds {
                Use::Image if name == SHADOW => {}
                Use::Image => {
                    let made = match block(scene, name, progress) {
                        Some(block) => block,
                        None => image(scene, &items, (&mut texels, &mut ways), planes, name)?,
                    };
                    images.push((*binding, made));
                }
                Use::Sampler if name == "repeat_sampler" => samplers.push((*binding, Address::Repeat)),
                Use::Sampler if name == "block_sampler" => {
                    let mirrors = scene.quality.wrap == Wrap::Mirror;
                    samplers.push((*binding, if mirrors { Address::Mirror } else { Address::Repeat }));
                }
                Use::Sampler => samplers.push((*binding, Address::Clamp)),
                Use::Block(_) => {}
            }
        }
        let stored = StoredObjects(items.iter().map(|item| item.stored).collect());
        Ok(Inputs { images, samplers, stored })
    }

    /// How the distances of the objects are stored.
    pub(super) fn stored(&self) -> &StoredObjects {
        &self.stored
    }
}

impl StoredObjects {
    /// Largest error of a stored distance, units of its object; 0 for formulas.
    pub(super) fn quantization(&self) -> f32 {
        self.0.iter().map(|stored| stored.quantization).fold(0.0, f32::max)
    }

    /// The values of every member of the blocks for one picture.
    pub(super) fn values(
        &self,
        scene: &Scene,
        subject: &Subject,
        variant: &Variant,
        view: &View,
        (planes, space): (&Planes, &LightSpace),
        sub_frame: &SubFrame,
    ) -> Values {
        let objects = view.objects.iter().zip(&self.0);
        let items: Vec<Item<'_>> =
            objects.map(|(own, stored)| Item::of(own, scene, subject, variant, *stored)).collect();
        let mut values = values(scene, view, &items, planes);
        values.extend(moment(scene, view, sub_frame));
        values.extend(space.values().map(|(name, floats)| (name.to_string(), floats)));
        values
    }
}

/// The blocks of a program, filled.
pub(crate) fn blocks(program: &Program, values: &Values) -> Result<Vec<(Resource, Vec<u8>)>, RenderError> {
    let filled = program.resources.iter().filter_map(|resource| {
        let Use::Block(block) = &resource.holds else { return None };
        let bytes = block.fill(|name| values.get(name).map(Vec::as_slice)).map_err(RenderError::Unfilled);
        Some(bytes.map(|bytes| (resource.clone(), bytes)))
    });
    filled.collect()
}

/// How a distance is stored in a volume, units of its object: `x + y s` for a texel s.
#[derive(Clone, Copy, Default)]
struct Stored {
    decode: [f32; 2],
    quantization: f32,
    /// Range of the ways to the closest points.
    closest_range: f32,
}

/// The shadow volume's name in `interface.glsl`.
pub(super) const SHADOW: &str = "shadow_image";
/// What an error calls the closest points.
const CLOSEST: &str = "closest points";

/// One object of the scene, with what its names in the program end in.
struct Item<'a> {
    suffix: String,
    own: &'a Own,
    /// The scene with this object as its only one.
    scene: Scene,
    subject: &'a Subject,
    knobs: &'a Knobs,
    stored: Stored,
}

impl<'a> Item<'a> {
    fn of(own: &'a Own, scene: &Scene, subject: &'a Subject, variant: &'a Variant, stored: Stored) -> Item<'a> {
        match own.name.as_str() {
            "" => Item { suffix: String::new(), own, scene: scene.clone(), subject, knobs: &variant.knobs, stored },
            name => Item {
                suffix: format!("_{name}"),
                own,
                scene: scene.alone(name),
                subject: &subject.parts[name],
                knobs: &variant.parts[name],
                stored,
            },
        }
    }

    /// The volume of the object; `None` for a formula.
    fn volume(&self, variant: &Variant) -> Option<Texels> {
        let field = self.subject.field.as_ref()?;
        let slot = if self.own.name.is_empty() { "object".into() } else { format!("{}.object", self.own.name) };
        let encoding = match (self.scene.object.source, variant.module(&slot)) {
            (Source::Normals8, _) => Encoding::Normals8,
            (Source::Distance32, _) => Encoding::Distance32,
            (_, Some("distance")) => Encoding::Distance16,
            _ => Encoding::Normals16,
        };
        // The soft region and as much again on either side: gradients and filters read beyond it.
        let reach = (self.own.outer_iso.abs() + self.scene.object.inner_iso.abs() + 0.25) / self.subject.scale;
        Some(texture::encode(field, encoding, [-reach, reach]))
    }

    /// The ways to the closest points of the inner surface, and their range in the units of the field.
    fn closest(&self) -> Result<(Vec<u16>, f32), RenderError> {
        let both = self.subject.field.as_ref().zip(self.subject.closest.as_ref());
        let (field, closest) = both.ok_or(RenderError::Missing(CLOSEST))?;
        Ok(texture::encode_closest(closest, field, self.scene.object.inner_iso / self.subject.scale))
    }

    /// How much nearer the matter may be than a sampled distance says, units of the object.
    ///
    /// A warp moves the place that is looked up, here and wherever the ray lands, by its reach. The filter mixes the
    /// distances of eight samples, whose weighted mean is at most half a voxel's diagonal away (by Jensen's
    /// inequality); a stored distance is rounded; and f32 has its own few ulps.
    fn leap_slack(&self) -> f32 {
        let spacing = self.subject.field.as_ref().map_or(0.0, |field| field.grid.spacing.length());
        2.0 * self.knobs.reach() + 0.5 * spacing * self.subject.scale + self.stored.quantization + 1e-5
    }
}

/// Members that differ from sub-frame to sub-frame, by name.
fn moment(scene: &Scene, view: &View, sub_frame: &SubFrame) -> [(String, Vec<f32>); 4] {
    let [width, height] = scene.image.size.map(|side| 2.0 / side as f32);
    let [x, y] = [sub_frame.offset[0] * width - view.pan[0], sub_frame.offset[1] * height - view.pan[1]];
    // The slices move against the rays, which go through a place beside the center of the pixel, or of another one.
    let projection = glam::Mat4::from_translation(glam::Vec3::new(-x, -y, 0.0)) * view.projection;
    [
        ("projection".into(), projection.to_cols_array().to_vec()),
        ("picture_scale".into(), vec![width, height, x, y]),
        ("time".into(), vec![sub_frame.time]),
        ("jitter_seed".into(), vec![sub_frame.jitter_seed]),
    ]
}

/// Every other member of the blocks of `interface.glsl` and `part.glsl`, and every knob, by name.
fn values(scene: &Scene, view: &View, items: &[Item<'_>], planes: &Planes) -> HashMap<String, Vec<f32>> {
    let mut values = HashMap::new();
    let mut set = |name: &str, floats: &[f32]| drop(values.insert(name.to_string(), floats.to_vec()));
    set("texture_matrix", &view.texture_matrix.to_cols_array());
    set("object_matrix", &view.object_matrix.to_cols_array());
    set("display_matrix", &view.display_matrix.to_cols_array());
    set("box_min", &view.box_min.extend(0.0).to_array());
    set("box_max", &view.box_max.extend(0.0).to_array());
    set("soft_radius", &[view.soft_radius]);
    let plane = scene.camera.clip.unwrap_or([0.0, 0.0, 1.0, f32::MAX]);
    let length = glam::Vec3::from_slice(&plane).length();
    set("clip_plane", &plane.map(|value| value / length));
    set("step_size", &[planes.step]);
    set("first_depth", &[planes.first_depth]);
    set("slice_count", &[planes.count as f32]);
    set("full_opacity", &[1.0 - scene.quality.stop]);
    let half_path = half_path(scene, view, planes);
    let reaches =
        [scene.quality.rule == Rule::Segment, scene.quality.jitter].map(|reaches| f32::from(u8::from(reaches)));
    set("segment_reach", &[reaches[0] * half_path]);
    set("box_margin", &[(reaches[0] + reaches[1]) * half_path]);
    set("ray_scale", &[view.ray_scale[0], view.ray_scale[1], 0.0, 0.0]);
    let [noise_cells, turbulence_cells, channel_cells] = scene.block_cells().map(|cells| cells as f32);
    set("noise_cells", &[noise_cells]);
    set("turbulence_cells", &[turbulence_cells]);
    set("channel_cells", &[channel_cells]);
    set("low_octaves", &[scene.block_octaves()[1] as f32]);
    let [noise, turbulence] = scene.periods();
    set("noise_period", &[noise.cells as f32]);
    set("turbulence_period", &[turbulence.cells as f32]);
    set("turbulence_growth", &[f32::from(u8::from(turbulence.growing))]);
    set("turbulence_cycle", &[turbulence.cycle as f32]);
    for item in items {
        set_object(item, view, &mut |name, floats| set(&format!("{name}{}", item.suffix), floats));
    }
    values
}

/// The members of `part.glsl` and the knobs of one object.
fn set_object(item: &Item<'_>, view: &View, set: &mut dyn FnMut(&str, &[f32])) {
    let (scene, subject, own) = (&item.scene, item.subject, item.own);
    set("normal_matrix", &(view.object_matrix * own.place).inverse().transpose().to_cols_array());
    set("place_matrix", &own.place.inverse().to_cols_array());
    set("place_scale", &[own.scale]);
    set("own_radius", &[own.own_radius]);
    set("own_min", &own.own_min.extend(0.0).to_array());
    set("own_max", &own.own_max.extend(0.0).to_array());

    // Texel-center mapping: sample i of n lies at texture coordinate (i + 0.5) / n.
    let (scale, offset, texel) = match &subject.field {
        None => (glam::Vec3::ZERO, glam::Vec3::ZERO, glam::Vec3::ONE),
        Some(field) => {
            let size = glam::UVec3::from(field.grid.size).as_vec3();
            let scale = 1.0 / (subject.scale * field.grid.spacing * size);
            let offset = ((subject.center - field.grid.origin) / field.grid.spacing + 0.5) / size;
            (scale, offset, 1.0 / size)
        }
    };
    set("volume_scale", &scale.extend(0.0).to_array());
    set("volume_offset", &offset.extend(0.0).to_array());
    set("volume_texel", &texel.extend(0.0).to_array());
    set("distance_decode", &[item.stored.decode[0], item.stored.decode[1], 0.0, 0.0]);
    set("leap_slack", &[item.leap_slack()]);
    set("closest_range", &[item.stored.closest_range]);
    set("opacity_rate", &[scene.effect.opacity_rate]);

    let color = |rgb: [f32; 3], factor: f32| [rgb[0] * factor, rgb[1] * factor, rgb[2] * factor, 1.0];
    set("material_color", &color(scene.material.color.linear(), 1.0));
    set("ambient_color", &color(scene.light.ambient.linear(), 1.0));
    set("light_color", &color(scene.light.color.linear(), scene.light.intensity));
    set("light_position", &view.light_eye.extend(1.0).to_array());
    set("specular_power", &[scene.material.specular_power]);
    set("specular_strength", &[scene.material.specular]);
    set("iso_value", &[scene.object.inner_iso]);
    set("outer_iso_value", &[own.outer_iso]);
    for (knob, value) in item.knobs.iter() {
        match value {
            KnobValue::Number(number) => set(&knob.name, &[*number]),
            KnobValue::Color(rgb) => set(&knob.name, &color(rgb.linear(), 1.0)),
        }
    }
}

/// The longest that half a step along a ray can be, object units.
fn half_path(scene: &Scene, view: &View, planes: &Planes) -> f32 {
    let slant = match scene.camera.projection {
        Projection::Parallel => 1.0,
        Projection::Perspective => {
            let farthest = glam::Vec2::from(view.pan).abs() + 1.0;
            (farthest * glam::Vec2::from(view.ray_scale)).extend(1.0).length()
        }
    };
    0.5 * planes.step * slant / glam::Vec3::from(scene.object.stretch).min_element()
}

/// The image of a name in `interface.glsl` or `part.glsl` that is no block; takes what was encoded of the object.
fn image(
    scene: &Scene,
    items: &[Item<'_>],
    (texels, ways): (&mut [Option<Texels>], &mut [Option<Vec<u16>>]),
    planes: &Planes,
    name: &str,
) -> Result<Encoded, RenderError> {
    let base = |item: &Item<'_>| name.strip_suffix(item.suffix.as_str()).filter(|base| base.ends_with("_image"));
    let found = (0..items.len()).rev().find_map(|index| base(&items[index]).map(|base| (index, base)));
    let (index, name) = found.ok_or_else(|| RenderError::Unfilled(name.into()))?;
    let item = &items[index];
    let (scene, subject) = (if item.suffix.is_empty() { scene } else { &item.scene }, item.subject);
    let encoded = |name, dimension, format, content| Encoded { name, dimension, format, content };
    Ok(match name {
        "transfer_image" => {
            let texels = texture::transfer_map(&scene.transfer);
            let size = Dimension::Line(texels.len() as u32 / 4);
            encoded("transfer map", size, Format::Rgba16Unorm, Content::Codes(texels))
        }
        "index_image" => {
            let texels = texture::index_map(&scene.transfer);
            let size = Dimension::Line(texels.len() as u32 / 4);
            encoded("index map", size, Format::Rgba32Float, Content::Floats(texels))
        }
        "closest_image" => {
            let (ways, field) = ways[index].take().zip(subject.field.as_ref()).ok_or(RenderError::Missing(CLOSEST))?;
            let [x, y, z] = field.grid.size;
            let (size, format) = (Dimension::Volume(x, y, z), Format::Rgba16Unorm);
            encoded(CLOSEST, size, format, Content::Codes(ways))
        }
        "segment_image" => {
            let exponent = scene.effect.opacity_rate * planes.step;
            let perlin = scene.effect.opacity == "perlin";
            let opacity = |density: f32, path: f32| match perlin {
                true if density >= 1.0 => 1.0,
                true => -(exponent * path * (-density).ln_1p()).exp_m1(),
                false => -(-exponent * path * density).exp_m1(),
            };
            let texels = texture::segment_table(&scene.transfer, opacity);
            let size = Dimension::Plane(texture::SEGMENT_SIZE as u32, texture::SEGMENT_SIZE as u32);
            encoded("segment table", size, Format::Rgba32Float, Content::Floats(texels))
        }
        "classified_image" => {
            let field = subject.field.as_ref().ok_or(RenderError::Classification(
                scene.effect.classify.clone(),
                "voxels, and this object is a formula (object.source = \"normals16\" makes a volume of it)",
            ))?;
            if scene.effect.softness != "linear" || !scene.effect.dmf.is_empty() || !scene.effect.warp.is_empty() {
                let what = "softness = \"linear\" and no DMF or warp: colors are given to voxels";
                return Err(RenderError::Classification(scene.effect.classify.clone(), what));
            }
            let (inner, outer) = (scene.object.inner_iso, item.own.outer_iso);
            let density = |distance: f32| match outer > inner {
                true => ((outer - distance * subject.scale) / (outer - inner)).clamp(0.0, 1.0),
                false => f32::from(u8::from(distance * subject.scale <= inner)),
            };
            let texels = texture::classify(field, &scene.transfer, density);
            let [x, y, z] = field.grid.size;
            let (size, format) = (Dimension::Volume(x, y, z), Format::Rgba16Unorm);
            encoded("classified volume", size, format, Content::Codes(texels))
        }
        _ => {
            let texels = texels[index].take().ok_or_else(|| RenderError::Unfilled(name.into()))?;
            let [x, y, z] = texels.size;
            let format = match texels.bytes.len() as u64 / (u64::from(x) * u64::from(y) * u64::from(z)) {
                8 => Format::Rgba16Unorm,
                2 => Format::R16Unorm,
                _ if scene.object.source == Source::Normals8 => Format::Rgba8Unorm,
                _ => Format::R32Float,
            };
            encoded("distance field", Dimension::Volume(x, y, z), format, Content::Bytes(texels.bytes))
        }
    })
}
