//! Inputs of a program, encoded on the CPU: uniform values and only those images that the program reads.

use super::bricks::Sparse;
use super::encoded::{Encoded, Filter};
use super::noise_blocks::NoiseTexels;
use super::object_inputs::{ObjectInputs, StoredDistance};
use super::table::{self, Function};
use super::uniforms::{Values, moment, values};
use crate::field::Progress;
use crate::gpu::{Dimension, Format};
use crate::render::camera::{FrameContext, SlicePlanes, SubFrame, View};
use crate::render::error::RenderError;
use crate::render::texture::{self, Bricks, Encoding, Texels};
use crate::render::variant::{GroomImage, ImageInput, ObjectImage, Program, Resource, Use};
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
    pub(crate) blocks: Vec<(u32, NoiseTexels)>,
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
        let FrameContext { variant, planes, .. } = frame;
        let scene = &variant.scene;
        let mut items: Vec<ObjectInputs<'_>> =
            frame.view.objects.iter().map(|own| ObjectInputs::of(frame, own, StoredDistance::default())).collect();
        let mut volumes = Vec::new();
        let mut sparse = None;
        for item in &mut items {
            let read = item.is_read(program, ObjectImage::Volume);
            let mut texels = if read { item.volume(variant) } else { None };
            if let Some(texels) = &texels {
                item.stored.decode = texels.decode.map(|value| value * item.subject.scale);
                item.stored.quantization = texels.quantization * item.subject.scale;
            }
            let bricks = texels.as_ref().filter(|_| item.is_read(program, ObjectImage::Bricks));
            let bricks = bricks.and_then(|texels| item.bricks(frame, texels));
            if let (Some(texels), Some(bricks)) = (&mut texels, &bricks) {
                sparse.get_or_insert_with(Sparse::default).add(texels, bricks);
            }
            let read = item.is_read(program, ObjectImage::Closest);
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
        for resource @ Resource { name, binding, holds, .. } in &program.resources {
            match holds {
                Use::Image => {
                    let unfilled = || RenderError::Unfilled(name.clone());
                    let (own, object) = resource.image().ok_or_else(unfilled)?;
                    let made = match own {
                        ImageInput::Pass(_) => continue,
                        ImageInput::Noise(own) => {
                            let own = NoiseTexels::of(scene, own);
                            if on_device && own.recipe.bake().is_some() {
                                blocks.push((*binding, own));
                                continue;
                            }
                            own.encode(progress)
                        }
                        ImageInput::Groom(own) => {
                            groom_image(frame.subject.groom.as_ref().ok_or(RenderError::Missing(own.label()))?, own)
                        }
                        ImageInput::Object(own) => {
                            let index = index_of(&items, object).ok_or_else(unfilled)?;
                            object_image(&items[index], &mut volumes[index], planes, &function, own)?
                                .ok_or_else(unfilled)?
                        }
                    };
                    images.push((*binding, made));
                }
                Use::Sampler => {
                    let sampler = resource.sampler().unwrap_or_default();
                    samplers.push((*binding, Filter::of(sampler, &scene.quality)));
                }
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
pub(crate) fn image_key(frame: &FrameContext, object: &str, image: ImageInput) -> String {
    let scene = &frame.variant.scene;
    match image {
        ImageInput::Noise(own) => format!("{:?}", NoiseTexels::of(scene, own)),
        ImageInput::Groom(_) => format!("{:?}", scene.groom),
        ImageInput::Object(own) => object_key(frame, object, own),
        ImageInput::Pass(own) => own.binding().into(),
    }
}

/// Text of all that an image of an object depends on.
fn object_key(frame: &FrameContext, object: &str, image: ObjectImage) -> String {
    let FrameContext { variant, view, planes, .. } = frame;
    let Some(own) = view.objects.iter().find(|own| own.name == object) else { return image.binding().into() };
    let item = ObjectInputs::of(frame, own, StoredDistance::default());
    let (object, effect, transfer) = (&item.scene.object, &item.scene.effect, &item.scene.transfer);
    let densities = (object.inner_iso, item.own.outer_iso);
    match image {
        ObjectImage::Volume => format!("{:?}", item.encoding(variant)),
        ObjectImage::Transfer => format!("{:?}", texture::transfer_map(transfer)),
        ObjectImage::Index => format!("{:?}", texture::index_map(transfer)),
        ObjectImage::Segment => {
            format!("{transfer:?} {} {} {:?}", effect.opacity_rate * planes.step, effect.opacity, item.parameters)
        }
        ObjectImage::Classified => {
            format!(
                "{transfer:?} {} {densities:?} {:?}{:?} {:?}",
                effect.softness, effect.dmf, effect.warp, item.parameters
            )
        }
        ObjectImage::Closest => format!("{}", object.inner_iso),
        ObjectImage::Bricks => format!("{densities:?} {:?} {}", variant.scene.quality.integration, planes.step),
    }
}

/// Encodes an image of an object; takes the encoded volumes. `None` if the object has no such volume.
fn object_image(
    item: &ObjectInputs<'_>,
    volumes: &mut Volumes,
    planes: &SlicePlanes,
    function: &dyn Fn(&'static str) -> Result<Function, RenderError>,
    image: ObjectImage,
) -> Result<Option<Encoded>, RenderError> {
    let (scene, subject) = (&item.scene, item.subject);
    let volume = |[x, y, z]: [u32; 3]| Dimension::Volume(x, y, z);
    Ok(Some(match image {
        ObjectImage::Transfer => {
            let texels = texture::transfer_map(&scene.transfer);
            Encoded::new(image, Dimension::Line(texels.len() as u32 / 4), Format::Rgba16Unorm, &texels)
        }
        ObjectImage::Index => {
            let texels = texture::index_map(&scene.transfer);
            Encoded::new(image, Dimension::Line(texels.len() as u32 / 4), Format::Rgba32Float, &texels)
        }
        ObjectImage::Closest => {
            let Texels { size, bytes, .. } = volumes.offsets.take().ok_or(RenderError::Missing(image.label()))?;
            Encoded { image: image.into(), dimension: volume(size), format: Format::Rgba16Unorm, bytes }
        }
        ObjectImage::Bricks => {
            let Some(bricks) = &volumes.bricks else { return Ok(None) };
            Encoded::new(image, volume(bricks.size), Format::Rgba32Float, &bricks.index)
        }
        ObjectImage::Segment => {
            let exponent = scene.effect.opacity_rate * planes.step;
            let opacity = function(table::OPACITY)?;
            let opacities =
                |paths: &[[f32; 2]]| opacity.at(paths.iter().map(|[density, path]| [*density, exponent * path]));
            let texels = texture::segment_table(&scene.transfer, opacities)?;
            let side = texture::SEGMENT_SIZE as u32;
            Encoded::new(image, Dimension::Plane(side, side), Format::Rgba32Float, &texels)
        }
        ObjectImage::Classified => {
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
            Encoded::new(image, volume(field.grid.size), Format::Rgba16Unorm, &texels)
        }
        ObjectImage::Volume => {
            let Some(texels) = volumes.texels.take() else { return Ok(None) };
            let format = match texels.encoding {
                Encoding::Normals16 => Format::Rgba16Unorm,
                Encoding::Normals8 => Format::Rgba8Unorm,
                Encoding::Distance16 => Format::R16Unorm,
                Encoding::Distance32 => Format::R32Float,
            };
            Encoded { image: image.into(), dimension: volume(texels.size), format, bytes: texels.bytes }
        }
    }))
}

/// Encodes an image of a groom.
pub(crate) fn groom_image(groom: &Groom, image: GroomImage) -> Encoded {
    let (format, bytes) = match image {
        GroomImage::Shape => (Format::Rgba16Float, groom.texels([5, 6, 7, 0])),
        GroomImage::Look => (Format::Rgba16Float, groom.texels([2, 3, 4, 1])),
        GroomImage::Amount => (Format::R32Float, groom.amounts()),
    };
    let side = groom.side();
    Encoded { image: image.into(), dimension: Dimension::Volume(side, side, side), format, bytes }
}

/// Index of an object.
fn index_of(items: &[ObjectInputs<'_>], object: &str) -> Option<usize> {
    items.iter().position(|item| item.own.name == object)
}
