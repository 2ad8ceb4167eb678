//! What a program reads, made for it: blocks filled, images encoded and uploaded, and nothing that it does not read.

use super::shadow::LightSpace;
use super::view::View;
use super::{RenderError, Subject};
use crate::gpu::{self, Address, Buffer, BufferUse, Dimension, Format, Gpu, Image, Sampler};
use crate::noise::{Noise, Weights, noise_block, turbulence_block};
use crate::pass::Planes;
use crate::scene::{KnobValue, Scene, Source};
use crate::texture::{self, Encoding, Texels};
use crate::variant::{Block, Program, Resource, Use, Variant};
use std::collections::HashMap;

/// Lattice cells across a block of noise of 64 texels: four texels for each cell. Fewer texels: the trilinear filter
/// shows its facets. More: the noise repeats sooner.
const NOISE_TEXELS_PER_CELL: u32 = 4;
/// Lattice cells of the first octave across a block of turbulence. More: fewer octaves fit. Fewer: it repeats sooner.
const TURBULENCE_CELLS: u32 = 4;
/// Octaves of turbulence (MJ 4.1), where the block can hold them.
const OCTAVES: u32 = 8;
/// Seed of the noise: changing it changes every picture.
const SEED: u64 = 1989;

/// The resources of one program.
pub(super) struct Bound {
    blocks: Vec<(u32, Buffer)>,
    images: Vec<(u32, Image)>,
    samplers: Vec<(u32, Sampler)>,
    values: HashMap<String, Vec<f32>>,
    /// Largest error of a stored distance, object units.
    pub(super) quantization: f32,
}

impl Bound {
    /// Everything that a program reads, but for the shadow volume, which is made with the rest of it: see [`Bound::add`].
    #[expect(clippy::too_many_arguments, reason = "all that a scene is, taken apart")]
    pub(super) fn new(
        gpu: &Gpu,
        scene: &Scene,
        subject: &Subject,
        variant: &Variant,
        program: &Program,
        view: &View,
        planes: &Planes,
        space: &LightSpace,
    ) -> Result<Bound, RenderError> {
        let texels = program.reads("volume_image").then(|| volume(scene, subject, variant, view)).flatten();
        let closest = program.reads("closest_image").then(|| closest(scene, subject)).transpose()?;
        let mut values = values(scene, subject, variant, view, texels.as_ref(), planes);
        let range = closest.as_ref().map_or(0.0, |(_, range)| range * subject.scale);
        values.insert("closest_range".into(), vec![range]);
        values.extend(space.values().map(|(name, floats)| (name.to_string(), floats)));
        let quantization = texels.as_ref().map_or(0.0, |texels| texels.quantization * subject.scale);
        let mut bound = Bound { blocks: Vec::new(), images: Vec::new(), samplers: Vec::new(), values, quantization };
        bound.blocks = bound.blocks_of(gpu, program)?;
        for resource in &program.resources {
            match &resource.holds {
                Use::Block(_) => {}
                Use::Image if resource.name == "shadow_image" => {}
                Use::Sampler => {
                    let address = if resource.name == "repeat_sampler" { Address::Repeat } else { Address::Clamp };
                    let sampler = Sampler::new(gpu, address, scene.quality.anisotropy)?;
                    bound.samplers.push((resource.binding, sampler));
                }
                Use::Image if resource.name == "closest_image" => {
                    let (texels, _) = closest.as_ref().ok_or(RenderError::Missing(CLOSEST))?;
                    let [x, y, z] = subject.field.as_ref().ok_or(RenderError::Missing(CLOSEST))?.grid.size;
                    let (size, format) = (Dimension::Volume(x, y, z), Format::Rgba16Unorm);
                    let image = Image::sampled(gpu, CLOSEST, size, format, bytemuck::cast_slice(texels))?;
                    bound.images.push((resource.binding, image));
                }
                Use::Image => {
                    let image = image(gpu, scene, subject, view, planes, &resource.name, texels.as_ref())?;
                    bound.images.push((resource.binding, image));
                }
            }
        }
        Ok(bound)
    }

    /// Adds the image of that name.
    pub(super) fn add(&mut self, program: &Program, name: &str, image: Image) {
        let binding = program.resources.iter().find(|resource| resource.name == name).map(|found| found.binding);
        self.images.extend(binding.map(|binding| (binding, image)));
    }

    /// The blocks of a program that reads no value which this one does not have.
    pub(super) fn blocks_of(&self, gpu: &Gpu, program: &Program) -> Result<Vec<(u32, Buffer)>, RenderError> {
        let mut blocks = Vec::new();
        for resource in &program.resources {
            if let Use::Block(block) = &resource.holds {
                blocks.push((resource.binding, uniform(gpu, resource, block, &self.values)?));
            }
        }
        Ok(blocks)
    }

    /// The resources by binding.
    pub(super) fn resources(&self) -> Vec<(u32, gpu::Resource<'_>)> {
        let blocks = self.blocks.iter().map(|(binding, block)| (*binding, gpu::Resource::Uniform(block)));
        blocks.chain(self.images_and_samplers()).collect()
    }

    /// The images and samplers by binding.
    pub(super) fn images_and_samplers(&self) -> impl Iterator<Item = (u32, gpu::Resource<'_>)> {
        let images = self.images.iter().map(|(binding, image)| (*binding, gpu::Resource::Image(image)));
        images.chain(self.samplers.iter().map(|(binding, sampler)| (*binding, gpu::Resource::Sampler(sampler))))
    }

    /// Bytes of the images on the device.
    pub(super) fn bytes(&self) -> u64 {
        self.images.iter().map(|(_, image)| image.bytes()).sum()
    }
}

/// The layout entry of a resource.
pub(super) fn binding(resource: &Resource) -> gpu::Binding {
    let kind = match resource.holds {
        Use::Block(_) => gpu::BindingKind::Uniform,
        Use::Image => gpu::BindingKind::Image,
        Use::Sampler => gpu::BindingKind::Sampler,
    };
    gpu::Binding { index: resource.binding, kind, vertex: resource.vertex, fragment: resource.fragment }
}

/// The volume of the object; `None` for a formula.
fn volume(scene: &Scene, subject: &Subject, variant: &Variant, view: &View) -> Option<Texels> {
    let field = subject.field.as_ref()?;
    let encoding = match (scene.object.source, variant.module("object")) {
        (Source::Normals8, _) => Encoding::Normals8,
        (Source::Distance32, _) => Encoding::Distance32,
        (_, Some("distance")) => Encoding::Distance16,
        _ => Encoding::Normals16,
    };
    // The soft region and as much again on either side: gradients and filters read beyond it.
    let reach = (view.outer_iso.abs() + scene.object.inner_iso.abs() + 0.25) / subject.scale;
    Some(texture::encode(field, encoding, [-reach, reach]))
}

/// What an error calls the closest points.
const CLOSEST: &str = "closest points";

/// The ways to the closest points of the inner surface, and their range in the units of the field.
fn closest(scene: &Scene, subject: &Subject) -> Result<(Vec<u16>, f32), RenderError> {
    let (field, closest) = subject.field.as_ref().zip(subject.closest.as_ref()).ok_or(RenderError::Missing(CLOSEST))?;
    Ok(texture::encode_closest(closest, field, scene.object.inner_iso / subject.scale))
}

fn uniform(
    gpu: &Gpu,
    resource: &Resource,
    block: &Block,
    values: &HashMap<String, Vec<f32>>,
) -> Result<Buffer, RenderError> {
    let bytes = block.fill(|name| values.get(name).map(Vec::as_slice)).map_err(RenderError::Unfilled)?;
    Ok(Buffer::new(gpu, &resource.name, BufferUse::Uniform, &bytes)?)
}

/// Every member of the blocks of `interface.glsl`, and every knob, by name.
fn values(
    scene: &Scene,
    subject: &Subject,
    variant: &Variant,
    view: &View,
    texels: Option<&Texels>,
    planes: &Planes,
) -> HashMap<String, Vec<f32>> {
    let mut values = HashMap::new();
    let mut set = |name: &str, floats: &[f32]| drop(values.insert(name.to_string(), floats.to_vec()));
    set("projection", &view.projection.to_cols_array());
    set("texture_matrix", &view.texture_matrix.to_cols_array());
    set("object_matrix", &view.object_matrix.to_cols_array());
    set("display_matrix", &view.display_matrix.to_cols_array());
    set("normal_matrix", &view.normal_matrix.to_cols_array());
    set("box_min", &view.box_min.extend(0.0).to_array());
    set("box_max", &view.box_max.extend(0.0).to_array());
    let plane = scene.camera.clip.unwrap_or([0.0, 0.0, 1.0, f32::MAX]);
    let length = glam::Vec3::from_slice(&plane).length();
    set("clip_plane", &plane.map(|value| value / length));

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
    let decode = texels.map_or([0.0; 2], |texels| texels.decode.map(|value| value * subject.scale));
    set("distance_decode", &[decode[0], decode[1], 0.0, 0.0]);
    set("step_size", &[planes.step]);
    set("first_depth", &[planes.first_depth]);
    set("slice_count", &[planes.count as f32]);
    set("leap_slack", &[leap_slack(subject, variant, texels)]);
    set("full_opacity", &[1.0 - scene.quality.stop]);
    let [width, height] = scene.image.size.map(|side| 2.0 / side as f32);
    set("picture_scale", &[width, height, 0.0, 0.0]);
    set("ray_scale", &[view.ray_scale[0], view.ray_scale[1], 0.0, 0.0]);
    set("time", &[scene.camera.time]);
    set("opacity_rate", &[scene.effect.opacity_rate]);
    set("noise_cells", &[noise_cells(scene) as f32]);
    set("turbulence_cells", &[TURBULENCE_CELLS as f32]);

    let color = |rgb: [f32; 3], factor: f32| [rgb[0] * factor, rgb[1] * factor, rgb[2] * factor, 1.0];
    set("material_color", &color(scene.material.color.linear(), 1.0));
    set("ambient_color", &color(scene.light.ambient.linear(), 1.0));
    set("light_color", &color(scene.light.color.linear(), scene.light.intensity));
    set("light_position", &view.light_eye.extend(1.0).to_array());
    set("specular_power", &[scene.material.specular_power]);
    set("specular_strength", &[scene.material.specular]);
    set("iso_value", &[scene.object.inner_iso]);
    set("outer_iso_value", &[view.outer_iso]);
    for (knob, value) in variant.knobs.iter() {
        match value {
            KnobValue::Number(number) => set(&knob.name, &[*number]),
            KnobValue::Color(rgb) => set(&knob.name, &color(rgb.linear(), 1.0)),
        }
    }
    values
}

/// How much nearer the matter may be than a sampled distance says, object units.
///
/// A warp moves the place that is looked up, here and wherever the ray lands, by its reach. The filter mixes the distances
/// of eight samples, whose weighted mean is at most half a voxel's diagonal away (by Jensen's inequality); a stored
/// distance is rounded; and f32 has its own few ulps.
fn leap_slack(subject: &Subject, variant: &Variant, texels: Option<&Texels>) -> f32 {
    let voxel = subject.field.as_ref().map_or(0.0, |field| field.grid.spacing.length() * subject.scale);
    let rounding = texels.map_or(0.0, |texels| texels.quantization * subject.scale);
    2.0 * variant.knobs.reach() + 0.5 * voxel + rounding + 1e-5
}

/// The noise that blocks are made of.
fn noise(scene: &Scene) -> Noise {
    let weights = if scene.effect.weights == "cubic" { Weights::Cubic } else { Weights::Quintic };
    Noise::new(SEED, weights)
}

fn noise_cells(scene: &Scene) -> u32 {
    (scene.quality.block_size / NOISE_TEXELS_PER_CELL).max(1)
}

fn image(
    gpu: &Gpu,
    scene: &Scene,
    subject: &Subject,
    view: &View,
    planes: &Planes,
    name: &str,
    texels: Option<&Texels>,
) -> Result<Image, RenderError> {
    let side = scene.quality.block_size;
    let block = Dimension::Volume(side, side, side);
    let image = match (name, texels) {
        ("noise_image", _) => {
            let texels = noise_block(&noise(scene), side, noise_cells(scene));
            Image::sampled(gpu, "noise block", block, Format::Rgba16Unorm, bytemuck::cast_slice(&texels))
        }
        ("turbulence_image", _) => {
            let (texels, _) = turbulence_block(&noise(scene), side, TURBULENCE_CELLS, OCTAVES);
            Image::sampled(gpu, "turbulence block", block, Format::Rgba16Unorm, bytemuck::cast_slice(&texels))
        }
        ("transfer_image", _) => {
            let texels = texture::transfer_map(&scene.transfer);
            let size = Dimension::Line(texels.len() as u32 / 4);
            Image::sampled(gpu, "transfer map", size, Format::Rgba16Unorm, bytemuck::cast_slice(&texels))
        }
        ("segment_image", _) => {
            let exponent = scene.effect.opacity_rate * planes.step;
            let perlin = scene.effect.opacity == "perlin";
            let opacity = |density: f32, path: f32| match perlin {
                true if density >= 1.0 => 1.0,
                true => -(exponent * path * (-density).ln_1p()).exp_m1(),
                false => -(-exponent * path * density).exp_m1(),
            };
            let texels = texture::segment_table(&scene.transfer, opacity);
            let size = Dimension::Plane(texture::SEGMENT_SIZE as u32, texture::SEGMENT_SIZE as u32);
            Image::sampled(gpu, "segment table", size, Format::Rgba32Float, bytemuck::cast_slice(&texels))
        }
        ("classified_image", _) => {
            let field = subject.field.as_ref().ok_or(RenderError::Classification(
                scene.effect.classify.clone(),
                "voxels, and this object is a formula (object.source = \"normals16\" makes a volume of it)",
            ))?;
            if scene.effect.softness != "linear" || !scene.effect.dmf.is_empty() || !scene.effect.warp.is_empty() {
                let what = "softness = \"linear\" and no DMF or warp: colors are given to voxels";
                return Err(RenderError::Classification(scene.effect.classify.clone(), what));
            }
            let (inner, outer) = (scene.object.inner_iso, view.outer_iso);
            let density = |distance: f32| match outer > inner {
                true => ((outer - distance * subject.scale) / (outer - inner)).clamp(0.0, 1.0),
                false => f32::from(u8::from(distance * subject.scale <= inner)),
            };
            let texels = texture::classify(field, &scene.transfer, density);
            let [x, y, z] = field.grid.size;
            let (size, format) = (Dimension::Volume(x, y, z), Format::Rgba16Unorm);
            Image::sampled(gpu, "classified volume", size, format, bytemuck::cast_slice(&texels))
        }
        (_, Some(texels)) => {
            let [x, y, z] = texels.size;
            let format = match texels.bytes.len() as u64 / (u64::from(x) * u64::from(y) * u64::from(z)) {
                8 => Format::Rgba16Unorm,
                2 => Format::R16Unorm,
                _ if scene.object.source == Source::Normals8 => Format::Rgba8Unorm,
                _ => Format::R32Float,
            };
            Image::sampled(gpu, "distance field", Dimension::Volume(x, y, z), format, &texels.bytes)
        }
        (name, None) => return Err(RenderError::Unfilled(name.into())),
    };
    Ok(image?)
}
