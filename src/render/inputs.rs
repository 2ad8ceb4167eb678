//! What a program reads, made without a device: the values of its blocks, its images encoded, and nothing that it does
//! not read.

use super::noise_blocks::{block, block_key};
use super::shadow::LightSpace;
use super::sparse::Sparse;
use super::sub_frame::SubFrame;
use super::values::{Values, moment, values};
use super::view::{Own, View};
use super::{RenderError, Subject};
use crate::field::Progress;
use crate::gpu::{Address, Dimension, Format};
use crate::render::pass::Planes;
use crate::render::texture::{self, Bricks, Encoding, Texels};
use crate::render::variant::{Program, Resource, Use, Variant};
use crate::scene::{Parameters, Quality, Scene, Source, Wrap};

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

/// A sampler: what it returns outside [0, 1], and its anisotropy, 1 for none.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Filter {
    pub(crate) address: Address,
    pub(super) anisotropy: f32,
}

impl Filter {
    /// The sampler of a name in `interface.glsl`. Only that of volumes is anisotropic: a driver may end by an anisotropic
    /// sampler of an image of one dimension (lavapipe of Mesa 22.3), a table is never seen at a slant, and blocks are
    /// read at a level of their own.
    pub(super) fn of(name: &str, quality: &Quality) -> Filter {
        let (address, anisotropy) = match name {
            "table_sampler" => (Address::Clamp, 1.0),
            "repeat_sampler" => (Address::Repeat, 1.0),
            "block_sampler" if quality.wrap == Wrap::Mirror => (Address::Mirror, 1.0),
            "block_sampler" => (Address::Repeat, 1.0),
            _ => (Address::Clamp, quality.anisotropy),
        };
        Filter { address, anisotropy }
    }
}

/// The volumes of one object, as far as its program reads them.
struct Volumes {
    texels: Option<Texels>,
    /// The ways to the closest points.
    ways: Option<Texels>,
    bricks: Option<Bricks>,
}

/// The inputs of one program, but for the shadow volume, which is rendered.
pub(crate) struct Inputs {
    /// The images by binding.
    pub(crate) images: Vec<(u32, Encoded)>,
    /// The samplers by binding.
    pub(crate) samplers: Vec<(u32, Filter)>,
    /// What bricks save.
    pub(super) sparse: Option<Sparse>,
    stored: StoredObjects,
}

/// How the distance of each object is stored, in the order of the view's objects.
#[derive(Clone)]
pub(super) struct StoredObjects(Vec<Stored>);

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
        let mut volumes = Vec::new();
        let mut sparse = None;
        for item in &mut items {
            let read = program.reads(&format!("volume_image{}", item.suffix));
            let mut texels = if read { item.volume(variant) } else { None };
            if let Some(texels) = &texels {
                item.stored.decode = texels.decode.map(|value| value * item.subject.scale);
                item.stored.quantization = texels.quantization * item.subject.scale;
            }
            let bricks = texels.as_ref().filter(|_| program.reads(&format!("brick_image{}", item.suffix)));
            let bricks = bricks.and_then(|texels| item.bricks(texels, planes));
            if let (Some(texels), Some(bricks)) = (&mut texels, &bricks) {
                sparse.get_or_insert_with(Sparse::default).add(texels, bricks);
            }
            let read = program.reads(&format!("closest_image{}", item.suffix));
            let made = if read { Some(item.closest()?) } else { None };
            item.stored.closest_range = made.as_ref().map_or(0.0, |(_, range)| range * item.subject.scale);
            let mut ways = made.map(|(ways, _)| ways);
            if let (Some(ways), Some(bricks), Some(sparse)) = (&mut ways, &bricks, &mut sparse) {
                sparse.add(ways, bricks);
            }
            volumes.push(Volumes { texels, ways, bricks });
        }
        let (mut images, mut samplers) = (Vec::new(), Vec::new());
        for Resource { name, binding, holds, .. } in &program.resources {
            match holds {
                Use::Image if [SHADOW, BEFORE, BEHIND].contains(&name.as_str()) => {}
                Use::Image => {
                    let made = match block(scene, name, progress) {
                        Some(block) => block,
                        None => image(scene, &items, &mut volumes, planes, name)?,
                    };
                    images.push((*binding, made));
                }
                Use::Sampler => samplers.push((*binding, Filter::of(name, &scene.quality))),
                Use::Block(_) => {}
            }
        }
        let stored = StoredObjects(items.iter().map(|item| item.stored).collect());
        Ok(Inputs { images, samplers, sparse, stored })
    }

    /// How the distances of the objects are stored.
    pub(super) fn stored(&self) -> &StoredObjects {
        &self.stored
    }
}

impl StoredObjects {
    /// Of objects that are not stored: what depends on it has the values of formulas.
    pub(super) fn none(view: &View) -> StoredObjects {
        StoredObjects(vec![Stored::default(); view.objects.len()])
    }

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

/// How a distance is stored in a volume, units of its object: `x + y s` for a texel s.
#[derive(Clone, Copy, Default)]
pub(super) struct Stored {
    pub(super) decode: [f32; 2],
    quantization: f32,
    /// Range of the ways to the closest points.
    pub(super) closest_range: f32,
}

/// The shadow volume's name in `interface.glsl`.
pub(super) const SHADOW: &str = "shadow_image";
/// The names of the light's buffers there.
pub(super) const BEFORE: &str = "light_before_image";
pub(super) const BEHIND: &str = "light_behind_image";
/// What an error calls the closest points.
const CLOSEST: &str = "closest points";

/// One object of the scene, with what its names in the program end in.
pub(super) struct Item<'a> {
    pub(super) suffix: String,
    pub(super) own: &'a Own,
    /// The scene with this object as its only one.
    pub(super) scene: Scene,
    pub(super) subject: &'a Subject,
    pub(super) parameters: &'a Parameters,
    pub(super) stored: Stored,
}

impl<'a> Item<'a> {
    fn of(own: &'a Own, scene: &Scene, subject: &'a Subject, variant: &'a Variant, stored: Stored) -> Item<'a> {
        match own.name.as_str() {
            "" => Item {
                suffix: String::new(),
                own,
                scene: scene.clone(),
                subject,
                parameters: &variant.parameters,
                stored,
            },
            name => Item {
                suffix: format!("_{name}"),
                own,
                scene: scene.alone(name),
                subject: &subject.parts[name],
                parameters: &variant.parts[name],
                stored,
            },
        }
    }

    /// The volume of the object; `None` for a formula.
    fn volume(&self, variant: &Variant) -> Option<Texels> {
        let field = self.subject.field.as_ref()?;
        let (encoding, range) = self.encoding(variant);
        Some(texture::encode(field, encoding, range))
    }

    /// How the volume is stored, and the distances that it tells apart, units of the field.
    fn encoding(&self, variant: &Variant) -> (Encoding, [f32; 2]) {
        let slot = if self.own.name.is_empty() { "object".into() } else { format!("{}.object", self.own.name) };
        let encoding = match (self.scene.object.source, variant.module(&slot)) {
            (Source::Normals8, _) => Encoding::Normals8,
            (Source::Distance32, _) => Encoding::Distance32,
            (_, Some("distance")) => Encoding::Distance16,
            _ => Encoding::Normals16,
        };
        let reach = self.reach() / self.subject.scale;
        (encoding, [-reach, reach])
    }

    /// Distances beyond this are all alike, units of the object: the soft region and as much again on either side, since
    /// gradients and filters read beyond it.
    pub(super) fn reach(&self) -> f32 {
        self.own.outer_iso.abs() + self.scene.object.inner_iso.abs() + 0.25
    }

    /// The ways to the closest points of the inner surface, and their range in the units of the field.
    fn closest(&self) -> Result<(Texels, f32), RenderError> {
        let both = self.subject.field.as_ref().zip(self.subject.closest.as_ref());
        let (field, closest) = both.ok_or(RenderError::Missing(CLOSEST))?;
        let (ways, range) = texture::encode_closest(closest, field, self.scene.object.inner_iso / self.subject.scale);
        let bytes = bytemuck::cast_slice(&ways).to_vec();
        Ok((
            Texels { size: field.grid.size, encoding: Encoding::Normals16, bytes, decode: [0.0; 2], quantization: 0.0 },
            range,
        ))
    }

    /// How much nearer the matter may be than a sampled distance says, units of the object.
    ///
    /// A warp moves the place that is looked up, here and wherever the ray lands, not alike. The filter mixes the
    /// distances of eight samples, whose weighted mean is at most half a voxel's diagonal away (by Jensen's
    /// inequality); a stored distance is rounded; and f32 has its own few ulps.
    pub(super) fn skip_slack(&self) -> f32 {
        let spacing = self.subject.field.as_ref().map_or(0.0, |field| field.grid.spacing.length());
        self.own.spread.moves.span() + 0.5 * spacing * self.subject.scale + self.stored.quantization + 1e-5
    }
}

/// What an image depends on, in words, for objects that are loaded.
pub(super) fn image_key(
    scene: &Scene,
    subject: &Subject,
    variant: &Variant,
    (view, planes): (&View, &Planes),
    name: &str,
) -> String {
    if let Some(key) = block_key(scene, name) {
        return key;
    }
    let items = view.objects.iter().map(|own| Item::of(own, scene, subject, variant, Stored::default()));
    let named =
        |item: &Item<'_>| name.strip_suffix(item.suffix.as_str()).filter(|base| base.ends_with("_image")).is_some();
    let Some(item) = items.rev().find(named) else { return name.into() };
    let (object, effect, transfer) = (&item.scene.object, &item.scene.effect, &item.scene.transfer);
    let densities = (object.inner_iso, item.own.outer_iso);
    match name.strip_suffix(item.suffix.as_str()).unwrap_or(name) {
        "transfer_image" => format!("{:?}", texture::transfer_map(transfer)),
        "index_image" => format!("{:?}", texture::index_map(transfer)),
        "segment_image" => format!("{transfer:?} {} {}", effect.opacity_rate * planes.step, effect.opacity),
        "classified_image" => {
            format!("{transfer:?} {} {densities:?} {:?}{:?}", effect.softness, effect.dmf, effect.warp)
        }
        "closest_image" => format!("{}", object.inner_iso),
        "brick_image" => format!("{densities:?} {:?} {}", scene.quality.integration, planes.step),
        _ => format!("{:?}", item.encoding(variant)),
    }
}

/// The image of a name in `interface.glsl` or `part.glsl` that is no block; takes what was encoded of the object.
fn image(
    scene: &Scene,
    items: &[Item<'_>],
    volumes: &mut [Volumes],
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
            let ways = volumes[index].ways.take().ok_or(RenderError::Missing(CLOSEST))?;
            let [x, y, z] = ways.size;
            let (size, format) = (Dimension::Volume(x, y, z), Format::Rgba16Unorm);
            encoded(CLOSEST, size, format, Content::Bytes(ways.bytes))
        }
        "brick_image" => {
            let bricks = volumes[index].bricks.as_ref().ok_or_else(|| RenderError::Unfilled(name.into()))?;
            let ([x, y, z], format) = (bricks.size, Format::Rgba32Float);
            encoded("index of bricks", Dimension::Volume(x, y, z), format, Content::Floats(bricks.index.concat()))
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
            let texels = volumes[index].texels.take().ok_or_else(|| RenderError::Unfilled(name.into()))?;
            let [x, y, z] = texels.size;
            let format = match texels.encoding {
                Encoding::Normals16 => Format::Rgba16Unorm,
                Encoding::Normals8 => Format::Rgba8Unorm,
                Encoding::Distance16 => Format::R16Unorm,
                Encoding::Distance32 => Format::R32Float,
            };
            encoded("distance field", Dimension::Volume(x, y, z), format, Content::Bytes(texels.bytes))
        }
    })
}
