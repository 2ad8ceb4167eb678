//! Inputs of a program, encoded on the CPU: uniform values and only those images that the program reads.

use super::bricks::Sparse;
use super::encoded::{Encoded, FIELD, Filter};
use super::noise_blocks::NoiseImage;
use super::object_inputs::{CLOSEST, ObjectInputs, StoredDistance};
use super::table::{self, Function};
use super::uniforms::{Values, moment, values};
use crate::field::Progress;
use crate::gpu::{Dimension, Format};
use crate::render::camera::{FrameContext, SlicePlanes, SubFrame, View};
use crate::render::error::RenderError;
use crate::render::texture::{self, Bricks, Encoding, Texels};
use crate::render::variant::{Program, Resource, Use, Variant, bindings};
use crate::shader::{Library, suffixed};
use crate::shape::Groom;
use std::cell::Cell;

/// Encoded volumes of one object, as far as the program reads them.
struct Volumes {
    texels: Option<Texels>,
    /// Offsets to the closest points.
    offsets: Option<Texels>,
    bricks: Option<Bricks>,
}

/// Inputs of one program except the images that are rendered, such as the shadow volume.
pub(crate) struct Inputs {
    /// Images by binding.
    pub(crate) images: Vec<(u32, Encoded)>,
    /// Noise blocks by binding that the device makes.
    pub(crate) blocks: Vec<(u32, NoiseImage)>,
    /// Samplers by binding.
    pub(crate) samplers: Vec<(u32, Filter)>,
    /// Memory saved by bricks.
    pub(crate) sparse: Option<Sparse>,
    /// Whether a table depends on module parameters.
    pub(crate) holds_parameters: bool,
    stored: StoredObjects,
}

/// Storage of the distances of each object, in the order of the view's objects.
#[derive(Clone)]
pub(crate) struct StoredObjects(Vec<StoredDistance>);

impl Inputs {
    /// Encodes every image that a program reads; `progress` reports each noise block.
    pub(crate) fn new(
        library: &Library,
        frame: &FrameContext,
        program: &Program,
        progress: Progress<'_>,
    ) -> Result<Inputs, RenderError> {
        Inputs::without_blocks(library, frame, program, progress, false)
    }

    /// [`Inputs::new`]; leaves blocks of lattice noise to the device if `on_device`.
    pub(crate) fn without_blocks(
        library: &Library,
        frame: &FrameContext,
        program: &Program,
        progress: Progress<'_>,
        on_device: bool,
    ) -> Result<Inputs, RenderError> {
        let FrameContext { variant: variant @ Variant { scene, .. }, planes, .. } = frame;
        let mut items: Vec<ObjectInputs<'_>> =
            frame.view.objects.iter().map(|own| ObjectInputs::of(frame, own, StoredDistance::default())).collect();
        let mut volumes = Vec::new();
        let mut sparse = None;
        for item in &mut items {
            let read = item.is_read(program, bindings::VOLUME);
            let mut texels = if read { item.volume(variant) } else { None };
            if let Some(texels) = &texels {
                item.stored.decode = texels.decode.map(|value| value * item.subject.scale);
                item.stored.quantization = texels.quantization * item.subject.scale;
            }
            let bricks = texels.as_ref().filter(|_| item.is_read(program, bindings::BRICKS));
            let bricks = bricks.and_then(|texels| item.bricks(frame, texels));
            if let (Some(texels), Some(bricks)) = (&mut texels, &bricks) {
                sparse.get_or_insert_with(Sparse::default).add(texels, bricks);
            }
            let read = item.is_read(program, bindings::CLOSEST);
            let made = if read { Some(item.closest()?) } else { None };
            item.stored.closest_range = made.as_ref().map_or(0.0, |(_, range)| range * item.subject.scale);
            let mut offsets = made.map(|(offsets, _)| offsets);
            if let (Some(offsets), Some(bricks), Some(sparse)) = (&mut offsets, &bricks, &mut sparse) {
                sparse.add(offsets, bricks);
            }
            volumes.push(Volumes { texels, offsets, bricks });
        }
        let holds_parameters = Cell::new(false);
        let function = |entry| {
            let values = values(frame, &items, scene.camera.time);
            let function = Function::new(entry, variant, library, &values)?;
            holds_parameters.set(holds_parameters.get() || function.reads_parameters);
            Ok(function)
        };
        let (mut images, mut blocks, mut samplers) = (Vec::new(), Vec::new(), Vec::new());
        for Resource { name, binding, holds, .. } in &program.resources {
            match holds {
                Use::Image if bindings::RENDERED.contains(&name.as_str()) => {}
                Use::Image => {
                    let made = match NoiseImage::of(scene, name) {
                        Some(own) if on_device && own.recipe.bake().is_some() => {
                            blocks.push((*binding, own));
                            continue;
                        }
                        Some(own) => own.encode(progress),
                        None => image(&items, &mut volumes, planes, &function, name)?,
                    };
                    images.push((*binding, made));
                }
                Use::Sampler => samplers.push((*binding, Filter::of(name, &scene.quality))),
                Use::Block(_) => {}
            }
        }
        let stored = StoredObjects(items.iter().map(|item| item.stored).collect());
        Ok(Inputs { images, blocks, samplers, sparse, holds_parameters: holds_parameters.get(), stored })
    }

    /// Storage of the objects' distances.
    pub(crate) fn stored(&self) -> &StoredObjects {
        &self.stored
    }
}

impl StoredObjects {
    /// Storage of formulas, for uses that need no volume.
    pub(crate) fn none(view: &View) -> StoredObjects {
        StoredObjects(vec![StoredDistance::default(); view.objects.len()])
    }

    /// Largest error of a stored distance, units of its object; 0 for formulas.
    pub(crate) fn quantization(&self) -> f32 {
        self.0.iter().map(|stored| stored.quantization).fold(0.0, f32::max)
    }

    /// Values of all block members for one sub-frame.
    pub(crate) fn values(&self, frame: &FrameContext, sub_frame: &SubFrame) -> Values {
        let objects = frame.view.objects.iter().zip(&self.0);
        let items: Vec<ObjectInputs<'_>> = objects.map(|(own, stored)| ObjectInputs::of(frame, own, *stored)).collect();
        let mut values = values(frame, &items, sub_frame.time);
        values.named.extend(moment(frame, sub_frame));
        for item in &items {
            let speeds = item.parameters.held_speeds(sub_frame.time);
            values.named.extend(speeds.map(|(name, speed)| (suffixed(name, &item.suffix), vec![speed])));
        }
        values.named.extend(frame.space.values().map(|(name, floats)| (name.to_string(), floats)));
        values
    }
}

/// Text of all that an image depends on, for loaded objects.
pub(crate) fn image_key(frame: &FrameContext, name: &str) -> String {
    let FrameContext { variant: variant @ Variant { scene, .. }, view, planes, .. } = frame;
    if let Some(own) = NoiseImage::of(scene, name) {
        return format!("{own:?}");
    }
    let items: Vec<_> =
        view.objects.iter().map(|own| ObjectInputs::of(frame, own, StoredDistance::default())).collect();
    let Some((index, base)) = object_image(&items, name) else { return name.into() };
    let item = &items[index];
    let (object, effect, transfer) = (&item.scene.object, &item.scene.effect, &item.scene.transfer);
    let densities = (object.inner_iso, item.own.outer_iso);
    match base {
        bindings::TRANSFER => format!("{:?}", texture::transfer_map(transfer)),
        bindings::INDEX => format!("{:?}", texture::index_map(transfer)),
        bindings::SEGMENT => {
            format!("{transfer:?} {} {} {:?}", effect.opacity_rate * planes.step, effect.opacity, item.parameters)
        }
        bindings::CLASSIFIED => {
            format!(
                "{transfer:?} {} {densities:?} {:?}{:?} {:?}",
                effect.softness, effect.dmf, effect.warp, item.parameters
            )
        }
        bindings::CLOSEST => format!("{}", object.inner_iso),
        bindings::GROOM_SHAPE | bindings::GROOM_LOOK => format!("{:?}", scene.groom),
        bindings::BRICKS => format!("{densities:?} {:?} {}", scene.quality.integration, planes.step),
        _ => format!("{:?}", item.encoding(variant)),
    }
}

/// Encodes the image of a binding in `interface.glsl` or `part.glsl`, other than noise; takes the encoded volumes of
/// its object.
fn image(
    items: &[ObjectInputs<'_>],
    volumes: &mut [Volumes],
    planes: &SlicePlanes,
    function: &dyn Fn(&'static str) -> Result<Function, RenderError>,
    name: &str,
) -> Result<Encoded, RenderError> {
    let (index, name) = object_image(items, name).ok_or_else(|| RenderError::Unfilled(name.into()))?;
    let item = &items[index];
    let (scene, subject) = (&item.scene, item.subject);
    let volume = |[x, y, z]: [u32; 3]| Dimension::Volume(x, y, z);
    Ok(match name {
        bindings::TRANSFER => {
            let texels = texture::transfer_map(&scene.transfer);
            Encoded::new("transfer map", Dimension::Line(texels.len() as u32 / 4), Format::Rgba16Unorm, &texels)
        }
        bindings::INDEX => {
            let texels = texture::index_map(&scene.transfer);
            Encoded::new("index map", Dimension::Line(texels.len() as u32 / 4), Format::Rgba32Float, &texels)
        }
        bindings::CLOSEST => {
            let Texels { size, bytes, .. } = volumes[index].offsets.take().ok_or(RenderError::Missing(CLOSEST))?;
            Encoded { name: CLOSEST, dimension: volume(size), format: Format::Rgba16Unorm, bytes }
        }
        bindings::GROOM_SHAPE | bindings::GROOM_LOOK => {
            groom_image(subject.groom.as_ref().ok_or(RenderError::Missing("groom"))?, name)
        }
        bindings::BRICKS => {
            let bricks = volumes[index].bricks.as_ref().ok_or_else(|| RenderError::Unfilled(name.into()))?;
            Encoded::new("index of bricks", volume(bricks.size), Format::Rgba32Float, &bricks.index)
        }
        bindings::SEGMENT => {
            let exponent = scene.effect.opacity_rate * planes.step;
            let opacity = function(table::OPACITY)?;
            let opacities =
                |paths: &[[f32; 2]]| opacity.at(paths.iter().map(|[density, path]| [*density, exponent * path]));
            let texels = texture::segment_table(&scene.transfer, opacities)?;
            let side = texture::SEGMENT_SIZE as u32;
            Encoded::new("segment table", Dimension::Plane(side, side), Format::Rgba32Float, &texels)
        }
        bindings::CLASSIFIED => {
            let field = subject.field.as_ref().ok_or(RenderError::Classification(
                scene.effect.classify.clone(),
                "voxels, and this object is a formula (object.field_encoding = \"normals16\" makes a volume of it)",
            ))?;
            if !scene.effect.dmf.is_empty() || !scene.effect.warp.is_empty() {
                let what = "no DMF or warp: colors are given to voxels";
                return Err(RenderError::Classification(scene.effect.classify.clone(), what));
            }
            let density = function(table::DENSITY)?;
            let densities = |distances: &[f32]| density.at(distances.iter().map(|d| [d * subject.scale, 0.0]));
            let texels = texture::classify(field, &scene.transfer, densities)?;
            Encoded::new("classified volume", volume(field.grid.size), Format::Rgba16Unorm, &texels)
        }
        _ => {
            let texels = volumes[index].texels.take().ok_or_else(|| RenderError::Unfilled(name.into()))?;
            let format = match texels.encoding {
                Encoding::Normals16 => Format::Rgba16Unorm,
                Encoding::Normals8 => Format::Rgba8Unorm,
                Encoding::Distance16 => Format::R16Unorm,
                Encoding::Distance32 => Format::R32Float,
            };
            Encoded { name: FIELD, dimension: volume(texels.size), format, bytes: texels.bytes }
        }
    })
}

/// Encodes the image of a groom: direction and length, or color and density.
pub(crate) fn groom_image(groom: &Groom, name: &str) -> Encoded {
    let (side, channels) = (groom.side(), if name == bindings::GROOM_SHAPE { [5, 6, 7, 0] } else { [2, 3, 4, 1] });
    let (dimension, bytes) = (Dimension::Volume(side, side, side), groom.texels(channels));
    Encoded { name: "groom", dimension, format: Format::Rgba16Float, bytes }
}

/// Resolves a binding to the index of its object, and to its name without the object's suffix.
fn object_image<'a>(items: &[ObjectInputs<'_>], name: &'a str) -> Option<(usize, &'a str)> {
    let base =
        |item: &ObjectInputs<'_>| name.strip_suffix(item.suffix.as_str()).filter(|base| base.ends_with("_image"));
    (0..items.len()).rev().find_map(|index| Some((index, base(&items[index])?)))
}
