//! A scene for hosts without this library: fragment programs, their inputs, and numbers for a camera.
//!
//! Role: [`Portable::of`] selects the programs whose pictures are those of [`render`](crate::render::render) and that need
//! nothing from the device but a fragment shader. Invariant: rays without proven cells and in one phase; no parameter is
//! folded into the program.

mod unread;

use super::camera::{FrameContext, SubFrame, slant};
use super::error::RenderError;
use super::inputs::Inputs;
use super::subject::{Subject, field_margin};
use super::variant::{ImageInput, PassImage, Program, Purpose, Variant, VariantError};
use crate::field::Progress;
use crate::gpu::{Address, Dimension, Format};
use crate::scene::schema::{Changes, setting};
use crate::scene::{Animation, ParameterValue, Pass, Projection, SHADOW_SAMPLES, Scene, Track};
use crate::shader::{Library, Linker, ParameterKind, suffixed};
use glam::{Mat4, Vec3};
use std::collections::BTreeMap;

/// Moments of a motion: in a second, and at most. Between them, values are interpolated.
const MOMENTS: [f64; 2] = [20.0, 400.0];
/// Seconds of a motion by expressions without a loop.
const ENDLESS_SECONDS: f64 = 60.0;
/// Equal parts of the range of a parameter between which values that follow it are interpolated.
const PARTS: u32 = 8;
/// Values for the host's own camera, which no program reads.
const VIEW: &str = "view_";
/// Values that the host computes from its camera: those of the scene are its first picture.
const OF_CAMERA: [&str; 13] = [
    "projection",
    "object_matrix",
    "texture_matrix",
    "display_matrix",
    "normal_matrix",
    "light_position",
    "picture_scale",
    "ray_scale",
    "step_size",
    "first_depth",
    "slice_count",
    "sample_reach",
    "box_margin",
];

/// A scene for hosts without this library.
pub struct Portable {
    /// The scene as it is carried, checked.
    pub variant: Variant,
    /// Programs: the picture, and the shadow volume if the picture reads one.
    pub programs: Vec<PortableProgram>,
    /// Images that the programs read, except the shadow volume.
    pub images: Vec<PortableImage>,
    /// Samplers.
    pub samplers: Vec<PortableSampler>,
    /// Values of all block members by name, and of the camera's numbers.
    pub values: BTreeMap<String, Vec<f32>>,
    /// Parameters of the scene.
    pub parameters: Vec<PortableParameter>,
    /// Sub-frames whose mean is the picture: offset to the right and down in pixels, seconds after the time of the scene, and
    /// seed of the jitter.
    pub sub_frames: Vec<[f64; 4]>,
    /// Motion by keyframes, expressions or a loop.
    pub motion: Option<PortableMotion>,
}

/// Motion of a scene.
pub struct PortableMotion {
    /// First and last moment, seconds.
    pub seconds: [f64; 2],
    /// Whether it begins anew after the last moment.
    pub repeats: bool,
    /// Values that change, at moments with equal distances.
    pub values: BTreeMap<String, Vec<Vec<f32>>>,
    /// Fields whose motion is left out: they change programs, images or the field of the object.
    pub still: Vec<String>,
}

/// A program with its sources.
pub struct PortableProgram {
    /// `picture` or `shadow`.
    pub name: &'static str,
    /// The linked program.
    pub program: Program,
    /// Its linked GLSL.
    pub glsl: String,
}

/// An image that a program reads.
pub struct PortableImage {
    /// Number of the binding.
    pub binding: u32,
    /// Name of the binding.
    pub name: String,
    /// Content.
    pub input: ImageInput,
    /// Its additional object; empty for an image of the scene or of its main object.
    pub object: String,
    /// Size in texels.
    pub dimension: Dimension,
    /// Texel format.
    pub format: Format,
    /// Mip levels, each with half the side of the one before.
    pub levels: u32,
    /// Texels of all levels, x fastest, then y, then z.
    pub bytes: Vec<u8>,
}

/// A sampler with linear filtering.
pub struct PortableSampler {
    /// Number of the binding.
    pub binding: u32,
    /// Name of the binding.
    pub name: String,
    /// Continuation of the image outside of [0, 1].
    pub address: Address,
    /// Anisotropy, 1 for none.
    pub anisotropy: f32,
}

/// A parameter of the scene.
pub struct PortableParameter {
    /// Name for `--set`.
    pub name: String,
    /// The block member that holds it.
    pub member: String,
    /// Its description.
    pub doc: String,
    /// Its kind; a range ends where the carried images end.
    pub kind: ParameterKind,
    /// Its value in the scene.
    pub value: ParameterValue,
    /// Other values that follow a number, at equal distances over its range.
    pub follow: BTreeMap<String, Vec<Vec<f32>>>,
}

/// The scene as it is carried.
fn carried(scene: &Scene) -> Result<Scene, RenderError> {
    let refused = [
        (scene.is_half_angle(), "light.method = \"half_angle\"", "--set light.method=volume --set quality.pass=march"),
        (scene.camera.slice_stack, "camera.slice_stack = true", "--set camera.slice_stack=false"),
        (scene.camera.matrices.is_some(), "camera.matrices", "azimuth, elevation and zoom: --set camera.matrices="),
    ];
    if let Some((_, what, remedy)) = refused.into_iter().find(|(is_refused, ..)| *is_refused) {
        return Err(RenderError::Portable(what, remedy));
    }
    let mut scene = scene.clone();
    let quality = &mut scene.quality;
    quality.supersampling = quality.supersampling.max(quality.msaa);
    (quality.pass, quality.msaa, quality.fold_zero_terms) = (Pass::March, 1, false);
    Ok(scene)
}

impl Portable {
    /// Selects the programs of a scene and encodes their inputs.
    ///
    /// # Errors
    /// [`RenderError::Portable`], and those of a program and its inputs.
    pub fn of(
        library: &Library,
        scene: &Scene,
        subject: &Subject,
        progress: Progress<'_>,
    ) -> Result<Portable, RenderError> {
        let variant_of = |scene: &Scene| -> Result<Variant, RenderError> {
            Ok(Variant::of(scene, library)?.without_two_phase().without_cells())
        };
        let whole = carried(scene)?;
        let variant = variant_of(&whole)?;
        let mut programs = vec![program("picture", &variant, library)?];
        if programs[0].program.reads_image(PassImage::Shadow) {
            let shadow = variant.for_purpose(Purpose::Shadow, library)?.without_two_phase().without_cells();
            programs.push(program("shadow", &shadow, library)?);
        }
        let picture = &programs[0].program;
        let frame = FrameContext::of(variant.clone(), subject);
        let inputs = Inputs::new(library, &frame, picture, progress)?;
        let name =
            |binding: u32| picture.resources.iter().find(|own| own.binding == binding).map(|own| own.name.clone());
        let values = |variant: &Variant| all_values(&FrameContext::of(variant.clone(), subject), &inputs);
        let own = values(&variant);
        let read: Vec<&str> = programs.iter().flat_map(|own| own.program.members()).collect();
        let is_kept = |name: &str| read.contains(&name) || name.starts_with(VIEW) || name.starts_with("place_matrix");
        let is_of_camera = |name: &str| OF_CAMERA.iter().any(|own| name.starts_with(own));
        let mut parameters = Vec::new();
        for (name, parameter, value) in variant.all_parameters().filter(|_| !inputs.holds_parameters) {
            let (part, bare) = name.strip_prefix("parts.").and_then(|rest| rest.split_once('.')).unwrap_or(("", &name));
            let suffix = if part.is_empty() { String::new() } else { format!("_{part}") };
            let (mut kind, mut follow) = (parameter.kind, BTreeMap::<String, Vec<Vec<f32>>>::new());
            let (of_part, field) = match part {
                "" => (&variant.parameters, subject.field.is_some()),
                part => (&variant.parts[part], subject.parts[part].field.is_some()),
            };
            if let (ParameterKind::Number(default, [low, high]), ParameterValue::Number(value)) = (kind, value) {
                let is_outer = field && of_part.outer().iter().any(|outer| outer == bare);
                let high = if is_outer { held_by_field(*value, high) } else { high };
                kind = ParameterKind::Number(default, [low, high]);
                let places = (0..=PARTS).map(|at| low + (high - low) * at as f32 / PARTS as f32);
                let moved = places.map(|place| {
                    let mut moved = variant.scene.clone();
                    let parameters = match part {
                        "" => &mut moved.parameters,
                        part => &mut moved.parts.get_mut(part).expect("a part of the scene").parameters,
                    };
                    parameters.insert(bare.into(), ParameterValue::Number(place));
                    Ok(values(&variant_of(&moved)?))
                });
                let moved = moved.collect::<Result<Vec<_>, RenderError>>()?;
                let member = suffixed(bare, &suffix);
                let names = own.keys().filter(|name| is_kept(name) && **name != member && !is_of_camera(name));
                let follows = |name: &&String| moved.iter().any(|moved| moved[*name] != own[*name]);
                follow = names
                    .filter(follows)
                    .map(|name| (name.clone(), moved.iter().map(|moved| moved[name].clone()).collect()))
                    .collect();
            }
            let (member, doc) = (suffixed(bare, &suffix), parameter.doc.clone());
            if read.contains(&member.as_str()) || !follow.is_empty() {
                parameters.push(PortableParameter { name, member, doc, kind, value: value.clone(), follow });
            }
        }
        let motion = moments(&whole).map(|(seconds, times)| -> Result<PortableMotion, RenderError> {
            let is_still = |field: &&String| match setting(field) {
                Some(setting) => !matches!(setting.changes, Changes::Picture | Changes::View),
                None => inputs.holds_parameters,
            };
            let still: Vec<String> = whole.animation.tracks.keys().filter(is_still).cloned().collect();
            let mut moving = whole.clone();
            moving.animation.tracks.retain(|field, _| !still.contains(field));
            let moved = times.iter().map(|time| {
                moving.camera.time = *time;
                Ok(values(&variant_of(&moving)?))
            });
            let moved: Vec<BTreeMap<String, Vec<f32>>> = moved.collect::<Result<_, RenderError>>()?;
            let changes = |name: &&String| moved.windows(2).any(|pair| pair[0][*name] != pair[1][*name]);
            let names = own.keys().filter(|name| is_kept(name) && *name != "time" && !is_of_camera(name));
            let values = names.filter(changes);
            let values = values.map(|name| (name.clone(), moved.iter().map(|moved| moved[name].clone()).collect()));
            let values = values.collect();
            Ok(PortableMotion { seconds, repeats: whole.animation.period.is_some(), values, still })
        });
        let motion = motion.transpose()?;
        let values = own.into_iter().filter(|(name, _)| is_kept(name)).collect();
        let samplers = inputs.samplers.iter().filter_map(|(binding, filter)| {
            let (address, anisotropy) = (filter.address, filter.anisotropy);
            Some(PortableSampler { binding: *binding, name: name(*binding)?, address, anisotropy })
        });
        let samplers = samplers.collect();
        let images = images(picture, &inputs);
        let time = variant.scene.camera.time;
        let sub_frame =
            |own: SubFrame| [own.offset[0].into(), own.offset[1].into(), own.time - time, own.jitter_seed.into()];
        let sub_frames = SubFrame::all(&variant.scene).map(sub_frame).collect();
        Ok(Portable { variant, programs, images, samplers, values, parameters, sub_frames, motion })
    }
}

/// The moment of a scene with the widest soft region: its field serves the others.
///
/// # Errors
/// Those of a variant.
pub fn widest(scene: &Scene, library: &Library) -> Result<Variant, VariantError> {
    let mut widest = Variant::of(scene, library)?;
    let outer = |variant: &Variant| variant.parameters.outer_iso().unwrap_or(variant.scene.object.outer_iso);
    let moves = |field: &String| field.starts_with("parameters.") || field == "object.outer_iso";
    for time in moments(scene).filter(|_| scene.animation.tracks.keys().any(moves)).into_iter().flat_map(|own| own.1) {
        let mut moment = scene.clone();
        moment.camera.time = time;
        let moment = Variant::of(&moment, library)?;
        if outer(&moment) > outer(&widest) {
            widest = moment;
        }
    }
    Ok(widest)
}

fn program(name: &'static str, variant: &Variant, library: &Library) -> Result<PortableProgram, RenderError> {
    let program = variant.program(library, Linker::new)?;
    Ok(PortableProgram { name, program, glsl: variant.text(library)? })
}

/// Images that a program reads.
fn images(program: &Program, inputs: &Inputs) -> Vec<PortableImage> {
    let images = inputs.images.iter().filter_map(|(binding, image)| {
        let resource = program.resources.iter().find(|own| own.binding == *binding)?;
        let (input, object) = resource.image()?;
        let (dimension, format, bytes) = (image.dimension, image.format, image.bytes.clone());
        let levels = levels(dimension, bytes.len() as u64 / format.bytes());
        let (name, object) = (resource.name.clone(), object.to_string());
        Some(PortableImage { binding: *binding, name, input, object, dimension, format, levels, bytes })
    });
    images.collect()
}

/// First and last second of the motion of a scene, and its moments at equal distances; `None` if nothing moves.
fn moments(scene: &Scene) -> Option<([f64; 2], Vec<f64>)> {
    let Animation { period, tracks } = &scene.animation;
    let seconds = match period {
        Some(period) => [0.0, *period],
        None => {
            let ends = tracks.values().flat_map(|track| match track {
                Track::Keys(keys) => keys.iter().map(|key| key.time).collect(),
                Track::Expressions(_) => vec![scene.camera.time.min(0.0), scene.camera.time + ENDLESS_SECONDS],
            });
            ends.fold(None, |range: Option<[f64; 2]>, time| match range {
                Some([low, high]) => Some([time.min(low), time.max(high)]),
                None => Some([time; 2]),
            })?
        }
    };
    let parts = (MOMENTS[0] * (seconds[1] - seconds[0])).ceil().clamp(1.0, MOMENTS[1]);
    let at = |part: u32| seconds[0] + (seconds[1] - seconds[0]) * f64::from(part) / parts;
    Some((seconds, (0..=parts as u32).map(at).collect()))
}

/// The largest outer iso-value up to `high` for which the field of `value` reaches far enough.
fn held_by_field(value: f32, high: f32) -> f32 {
    let is_held = |outer: f32| field_margin(outer) <= field_margin(value);
    let (mut held, mut beyond) = (value, high);
    if is_held(high) {
        return high;
    }
    for _ in 0..16 {
        let middle = 0.5 * (held + beyond);
        *(if is_held(middle) { &mut held } else { &mut beyond }) = middle;
    }
    held
}

/// Mip levels that fill as many texels.
fn levels(dimension: Dimension, texels: u64) -> u32 {
    let count = |level: u32| dimension.size().map(|side| u64::from((side >> level).max(1))).iter().product::<u64>();
    let (mut levels, mut left) = (0, texels);
    while left > 0 {
        left = left.saturating_sub(count(levels));
        levels += 1;
    }
    levels
}

/// Values of the first picture, with the numbers of its camera.
fn all_values(frame: &FrameContext, inputs: &Inputs) -> BTreeMap<String, Vec<f32>> {
    let scene = &frame.variant.scene;
    let first = SubFrame { offset: [0.0; 2], time: scene.camera.time, jitter_seed: 0.0 };
    let values = inputs.stored().values(frame, &first);
    let mut all: BTreeMap<String, Vec<f32>> = values.named.into_iter().collect();
    let (camera, view) = (&scene.camera, &frame.view);
    let stretch = Vec3::from(scene.object.stretch);
    let longest = frame.planes.step * slant(scene, view) / stretch.min_element();
    let steps = |name: &str| all[name][0] / longest;
    let (reach_steps, margin_steps) = (steps("sample_reach"), steps("box_margin"));
    let [width, height] = scene.image.size.map(|side| side as f32);
    let fit = (width / height).min(1.0);
    let is_parallel = scene.projection() == Projection::Parallel;
    let half_height = if is_parallel {
        view.ray_scale[1] * fit
    } else {
        view.extent.distance * fit * (0.5 * camera.field_of_view.to_radians()).sin()
    };
    let turn = camera.rotation.map_or(Mat4::IDENTITY, |_| Mat4::from_quat(camera.turn()));
    let center = view.texture_matrix.transform_point3(view.center_eye);
    let angles = if camera.rotation.is_some() { [0.0; 2] } else { [camera.azimuth, camera.elevation] };
    let shadow_steps = (SHADOW_SAMPLES / 4) as f32;
    let numbers: [(&str, Vec<f32>); 16] = [
        ("center", center.to_array().into()),
        ("half_height", vec![half_height * camera.zoom]),
        ("radius", vec![view.extent.radius]),
        ("near", vec![view.extent.near]),
        ("parallel", vec![f32::from(u8::from(is_parallel))]),
        ("field_of_view", vec![camera.field_of_view]),
        ("turn", turn.to_cols_array().into()),
        ("angles", angles.into()),
        ("zoom", vec![camera.zoom]),
        ("pan", camera.pan.into()),
        ("stretch", scene.object.stretch.into()),
        ("light", scene.light.position.into()),
        ("samples", vec![scene.quality.samples as f32]),
        ("reach_steps", vec![reach_steps]),
        ("margin_steps", vec![margin_steps]),
        ("shadow_most_steps", vec![shadow_steps]),
    ];
    all.extend(numbers.into_iter().map(|(name, floats)| (format!("{VIEW}{name}"), floats)));
    all.insert("time".into(), vec![values.time]);
    all
}
