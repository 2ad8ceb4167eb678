//! What the pictures of a scene share, and the frame pipeline, read top to bottom.

use super::bind::{self, BoundInputs};
use super::depth::Depth;
use super::half_angle::{HalfAngle, Slices, blend as light_blend};
use super::inputs::{Inputs, SHADOW};
use super::marks::Marks;
use super::pace::{Cut, Pace};
use super::pass;
use super::pixels::{Mean, check_finite};
use super::shadow::{Cast, Caster};
use super::shot::Shot;
use super::sub_frame::SubFrame;
use super::variant::{Program, Variant};
use super::{Frame, Measurements, RenderError, Subject};
use crate::field::Progress;
use crate::gpu::{self, Buffer, Gpu, HostCommands, Recording};
use crate::scene::schema::Changes;
use crate::scene::{Order, Pass, Scene, TargetFormat};
use crate::shader::slots::FOLDED;
use crate::shader::{Library, Linker, Slots};
use std::sync::Arc;
use std::time::Instant;

/// Where pictures go.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Destination {
    /// Into a target of their own, from which they are read back.
    Frame,
    /// Into a host's image of this format, and its depth into another where the host wants that.
    Host { format: gpu::Format, has_depth: bool },
}

impl Destination {
    /// Whether a scene prepared for it serves another one as well.
    pub(super) fn serves(self, other: Destination) -> bool {
        match (self, other) {
            (Destination::Host { format, has_depth }, Destination::Host { format: of_other, has_depth: wanted }) => {
                format == of_other && (has_depth || !wanted)
            }
            _ => self == other,
        }
    }
}

/// No opacity is below this but that of a ray whose loops the device has cut: see `march.frag`.
const CUT_SHORT: f32 = -1000.0;

/// What of a scene was made before.
#[derive(Default)]
pub(super) struct Made {
    /// A program, and which it is.
    program: Option<(Program, Slots)>,
    bound: Option<BoundInputs>,
    pipelines: Option<Pipelines>,
}

/// What is compiled of a program, and how it meets its targets.
#[derive(Clone)]
struct Pipelines {
    shape: Shape,
    picture: Arc<gpu::Pipeline>,
    /// What casts the shadows of a scene that has them.
    caster: Option<Caster>,
    /// What hands the light from slice to slice, in a scene that has it do so.
    half_angle: Option<HalfAngle>,
    /// Program and pipeline of the depth, once it was asked for.
    depth: Option<Depth>,
    /// What submissions of its pictures have taken.
    pace: Pace,
}

/// Octaves, attributes of a vertex, format and samples of the target, and how fragments meet it.
type Shape = (u32, &'static [u32], gpu::Format, u32, gpu::Blend, gpu::Marks);

/// A scene with all that its pictures share, made once: program, pipeline, images and targets.
pub(super) struct Prepared {
    gpu: Gpu,
    scene: Scene,
    /// That of its program, which may serve others.
    variant: Variant,
    destination: Destination,
    pub(super) program: Program,
    pub(super) bound: BoundInputs,
    pipelines: Pipelines,
    /// The images of a picture that is read back: that which is blended into, and where its samples are averaged to.
    targets: Option<(Arc<gpu::Image>, Option<gpu::Image>)>,
    /// What ends slices early, where they may.
    marks: Option<Marks>,
    compile_ms: f64,
    /// The size of the picture that pictures stand for.
    pub(super) whole: [u32; 2],
}

impl Prepared {
    /// How its pictures are cut into submissions.
    #[cfg(test)]
    pub(super) fn pace(&mut self) -> &mut Pace {
        &mut self.pipelines.pace
    }

    /// Makes what the pictures of a scene share; its program, and what that reads, may be `made` already.
    pub(super) fn new(
        gpu: &Gpu,
        library: &Library,
        shot: &Shot<'_>,
        destination: Destination,
        made: Made,
        progress: Progress<'_>,
    ) -> Result<Prepared, RenderError> {
        let (start, scene) = (Instant::now(), shot.scene);
        let (program, slots) = match made.program {
            Some(made) => made,
            None => (shot.variant.program(library, Linker::new)?, shot.variant.slots.clone()),
        };
        let variant = Variant { slots, ..shot.variant.clone() };
        let mut compile_ms = start.elapsed().as_secs_f64() * 1e3;
        let quality = &scene.quality;
        let bound = made.bound.map_or_else(
            || {
                let inputs = Inputs::new(library, shot, &program, progress)?;
                let is_recorded = destination != Destination::Frame;
                let is_cut = !is_recorded && quality.pass == Pass::Slices;
                BoundInputs::new(gpu, library, &program, &inputs, is_cut, is_recorded)
            },
            Ok,
        )?;
        let format = match (destination, quality.target) {
            (Destination::Host { format, .. }, _) => format,
            (_, TargetFormat::Unorm8) => gpu::Format::Rgba8Unorm,
            (_, TargetFormat::Float16) => gpu::Format::Rgba16Float,
            (_, TargetFormat::Float32) => gpu::Format::Rgba32Float,
        };
        let blend = match (quality.pass, quality.order) {
            _ if destination != Destination::Frame => gpu::Blend::Over,
            (Pass::March, _) => gpu::Blend::Replace,
            _ if scene.is_half_angle() => light_blend(scene),
            (Pass::Slices, Order::FrontToBack) => gpu::Blend::Under,
            (Pass::Slices, Order::BackToFront) => gpu::Blend::Over,
        };
        let pipeline_start = Instant::now();
        let attributes = if quality.pass == Pass::Slices { pass::attributes(quality.proxy) } else { &[] };
        let ends_early = destination == Destination::Frame && Marks::serve(scene);
        let marks = ends_early.then(|| Marks::new(gpu, library, scene, &variant)).transpose()?;
        let heeds = if marks.is_some() { gpu::Marks::Heed } else { gpu::Marks::None };
        let shape = (scene.effect.octaves, attributes, format, quality.msaa, blend, heeds);
        let (picture, caster, half_angle, mut depth, pace) = match made.pipelines.filter(|made| made.shape == shape) {
            Some(made) => (made.picture, made.caster, made.half_angle, made.depth, made.pace),
            None => {
                let picture = bind::pipeline(gpu, &program, scene, attributes, format, quality.msaa, (blend, heeds))?;
                (Arc::new(picture), None, None, None, Pace::default())
            }
        };
        let casts = program.reads(SHADOW);
        let caster = casts.then(|| Caster::new(gpu, library, scene, &variant, caster)).transpose()?;
        let half_angle = scene.is_half_angle().then(|| HalfAngle::new(gpu, library, scene, &variant, half_angle));
        if let Destination::Host { has_depth: true, .. } = destination {
            depth = Some(Depth::new(gpu, library, scene, &variant, depth)?);
        }
        let pipelines = Pipelines { shape, picture, caster, half_angle: half_angle.transpose()?, depth, pace };
        compile_ms += pipeline_start.elapsed().as_secs_f64() * 1e3;
        let targets = match destination {
            Destination::Host { .. } => None,
            Destination::Frame => Some(targets(gpu, scene, format)?),
        };
        let (gpu, scene) = (gpu.clone(), scene.clone());
        Ok(Prepared {
            gpu,
            scene,
            variant,
            destination,
            program,
            bound,
            pipelines,
            targets,
            marks,
            compile_ms,
            whole: shot.whole,
        })
    }

    /// Whether all of this serves another scene as well: it differs in what a picture is drawn with alone, or in its size.
    pub(super) fn fits(&self, scene: &Scene, variant: &Variant, destination: Destination) -> bool {
        let mut alike = scene.clone();
        alike.image.size = self.scene.image.size;
        self.destination.serves(destination)
            && !alike.changes(&self.scene).contains(&Changes::Targets)
            && self.reads_the_same(scene, variant)
    }

    /// Makes its pictures and their light as large as those of a scene that fits.
    pub(super) fn resize(&mut self, scene: &Scene) -> Result<(), RenderError> {
        if self.scene.image.size != scene.image.size {
            self.scene.image.size = scene.image.size;
            if let Some((color, _)) = &self.targets {
                self.targets = Some(targets(&self.gpu, scene, color.format())?);
            }
            self.marks.iter_mut().try_for_each(|marks| marks.resize(&self.gpu, scene))?;
        }
        self.pipelines.half_angle.iter_mut().try_for_each(|light| light.resize(&self.gpu, scene))
    }

    /// What serves another scene that its program serves.
    pub(super) fn made(self, scene: &Scene, variant: &Variant) -> Made {
        let reads_the_same = self.reads_the_same(scene, variant);
        Made {
            program: Some((self.program, self.variant.slots)),
            bound: reads_the_same.then_some(self.bound),
            pipelines: Some(self.pipelines),
        }
    }

    /// What serves it while this goes on to serve its own: its program, compiled.
    pub(super) fn shared(&self) -> Made {
        let program = Some((self.program.clone(), self.variant.slots.clone()));
        Made { program, bound: None, pipelines: Some(self.pipelines.clone()) }
    }

    /// Whether another scene has the same program and images: it differs in camera, time, parameters, samples and targets
    /// alone, and its matter reaches as far.
    pub(super) fn reads_the_same(&self, scene: &Scene, variant: &Variant) -> bool {
        // Some images depend on the length of a step.
        let by_step = ["segment_image", "brick_image"].iter().any(|name| self.program.reads(name));
        let samples = [scene, &self.scene].map(|scene| scene.quality.samples);
        let reach = |variant: &Variant| {
            let all = [&variant.parameters].into_iter().chain(variant.parts.values());
            all.map(|parameters| (parameters.outer_iso(), parameters.spread(1.0))).collect::<Vec<_>>()
        };
        let anew = [Changes::Field, Changes::Images];
        let same_settings = scene.changes(&self.scene).iter().all(|change| !anew.contains(change));
        let same_step = !by_step || samples[0] == samples[1];
        let same_tables = !self.bound.holds_parameters || scene.parameters == self.scene.parameters;
        same_settings && same_step && same_tables && self.runs(variant) && reach(variant) == reach(&self.variant)
    }

    /// Whether its program serves a variant: what is 0 in it is 0 there. Where more is, the picture is the same without it,
    /// and to link anew would take longer: a value that is pulled to 0 stands still.
    pub(super) fn runs(&self, variant: &Variant) -> bool {
        let [own, wanted] = [&self.variant, variant].map(|variant| {
            let modules = variant.slots.iter().filter(|(slot, _)| *slot != FOLDED);
            (variant.entries, modules.collect::<Vec<_>>(), variant.slots.get(FOLDED).map_or(&[][..], Vec::as_slice))
        });
        own.0 == wanted.0 && own.1 == wanted.1 && own.2.iter().all(|zero| wanted.2.contains(zero))
    }

    /// A variant that the program serves, as the program has it: what is made for one picture serves the next, where what
    /// is 0 now may be something else.
    fn served(&self, variant: &Variant) -> Variant {
        Variant { slots: self.variant.slots.clone(), ..variant.clone() }
    }

    /// The slices of a picture, or none for rays.
    fn slices(&self, shot: &Shot<'_>) -> Result<Option<(Buffer, pass::Stack)>, RenderError> {
        let (quality, view, planes) = (&shot.scene.quality, &shot.view, &shot.planes);
        if quality.pass == Pass::March {
            return Ok(None);
        }
        // Rays to the rim of the sphere are slanted: at the nearest plane they may be a little beyond it.
        let radius = view.reaches()[0] + planes.step;
        let stack = pass::stack(planes, radius, quality.proxy, quality.order, view.tint());
        let none = [0; 4]; // a buffer cannot be empty, a stack can
        let bytes = if stack.vertices.is_empty() { &none } else { bytemuck::cast_slice(&stack.vertices) };
        Ok(Some((Buffer::new(&self.gpu, "proxy slices", gpu::BufferUse::Vertices, bytes)?, stack)))
    }

    /// Has the shadow volume of the next picture cast anew.
    pub(super) fn forget_shadows(&mut self) {
        self.pipelines.caster.iter_mut().for_each(Caster::forget);
    }

    /// Makes the shadow volume of a picture, and waits for it, unless the last one serves; milliseconds on the device now, and
    /// before.
    fn cast(&mut self, shot: &Shot<'_>, stop: &dyn Fn(f64) -> bool) -> Result<Option<[f64; 2]>, RenderError> {
        let Some(caster) = &mut self.pipelines.caster else { return Ok(None) };
        let Cast { image, gpu_ms, is_kept, .. } = caster.volume(&self.gpu, shot, &self.bound, stop)?;
        self.bound.replace(&self.program, SHADOW, image);
        Ok(Some(if is_kept { [0.0, gpu_ms] } else { [gpu_ms, 0.0] }))
    }

    /// Records a picture of a scene that fits.
    pub(super) fn record(
        &mut self,
        commands: &mut HostCommands<'_>,
        scene: &Scene,
        subject: &Subject,
        variant: &Variant,
    ) -> Result<Recording, RenderError> {
        let variant = &self.served(variant);
        let shot = Shot { whole: self.whole, ..Shot::of(scene, subject, variant) };
        let mut all = SubFrame::all(scene);
        let (Some(sub_frame), None) = (all.next(), all.next()) else {
            return Err(RenderError::Recorded("quality.supersampling = 1"));
        };
        self.bound.fill_recorded(&self.gpu, &self.program, &shot, &sub_frame)?;
        if self.pipelines.caster.is_some() {
            self.bound.uploads.submit(&self.gpu)?; // what casts the shadows is submitted, and reads them
        }
        self.cast(&shot, &|_| false)?;
        let (vertices, count) = match self.slices(&shot)? {
            Some((vertices, stack)) => (Some(vertices), stack.slices * stack.per_slice),
            None => (None, 3),
        };
        let pipeline = &self.pipelines.picture;
        let set = pipeline.bind(&self.bound.resources())?;
        let depth = self.pipelines.depth.as_ref().filter(|_| commands.has_depth());
        let depth = depth.map(|own| Ok::<_, RenderError>((own.pipeline.clone(), own.bind(&self.gpu, &self.bound)?)));
        Ok(commands.draw(&self.bound.uploads, pipeline, set, vertices, 0..count, depth.transpose()?))
    }

    /// The depth of a picture of a scene that fits, by rays; it ends where it is to `stop`, after so many milliseconds.
    pub(super) fn depth(
        &mut self,
        library: &Library,
        scene: &Scene,
        subject: &Subject,
        variant: &Variant,
        stop: &dyn Fn(f64) -> bool,
    ) -> Result<Vec<f32>, RenderError> {
        let variant = &self.served(variant);
        let shot = Shot { whole: self.whole, ..Shot::of(scene, subject, variant) };
        let depth = Depth::new(&self.gpu, library, scene, variant, self.pipelines.depth.take())?;
        for sub_frame in SubFrame::all(scene).take(1) {
            self.bound.fill(&self.gpu, &self.program, &shot, &sub_frame, &|| stop(0.0))?;
        }
        self.pipelines.depth.insert(depth).draw(&self.gpu, &shot, &self.bound, stop)
    }

    /// Areas of a picture of a scene that fits, the mean of the sub-frames that are wanted: the frame pipeline. The pixels
    /// are those of the areas, one behind the other; it ends where it is to `stop`, after so many milliseconds. `None` where
    /// the device has cut the loops of its rays.
    pub(super) fn frame(
        &mut self,
        scene: &Scene,
        subject: &Subject,
        variant: &Variant,
        areas: &[gpu::Area],
        wanted: impl Fn(u32) -> bool,
        stop: &dyn Fn(f64) -> bool,
    ) -> Result<Option<Frame>, RenderError> {
        let variant = &self.served(variant);
        let shot = Shot { whole: self.whole, ..Shot::of(scene, subject, variant) };
        let slices = self.slices(&shot)?;
        let mut pictures = Mean::default();
        let mut drawn = pass::Drawn { fragments: Some(0), ..Default::default() };
        let (mut shadow_ms, mut shadow_before_ms) = (None, 0.0);
        for (_, sub_frame) in (0..).zip(SubFrame::all(scene)).filter(|(number, _)| wanted(*number)) {
            let so_far = drawn.gpu_ms + shadow_ms.unwrap_or(0.0);
            self.bound.fill(&self.gpu, &self.program, &shot, &sub_frame, &|| stop(so_far))?;
            if let Some([now, before]) = self.cast(&shot, &|ms| stop(so_far + ms))? {
                shadow_ms = Some(shadow_ms.unwrap_or(0.0) + now);
                shadow_before_ms += if pictures.count == 0 { before } else { 0.0 };
            }
            let Some((color, resolved)) = &self.targets else { continue };
            let marks = self.marks.as_ref().map(|marks| &marks.image);
            let target = gpu::Target { color, resolved: resolved.as_ref(), marks };
            let (gpu, pipeline) = (&self.gpu, &*self.pipelines.picture);
            let before = drawn.gpu_ms + shadow_ms.unwrap_or(0.0);
            let stop = |ms: f64| stop(before + ms);
            let mut cut = Cut { pace: &mut self.pipelines.pace, stop: &stop };
            drawn.append(&match (&slices, &self.pipelines.half_angle) {
                (Some((vertices, stack)), Some(light)) => {
                    let slices = Slices { pipeline, program: &self.program, bound: &self.bound, vertices, stack };
                    light.draw(gpu, &shot, &slices, areas, target, &mut cut)?
                }
                (Some((vertices, stack)), None) => {
                    let set = pipeline.bind(&self.bound.resources())?;
                    let between = match &self.marks {
                        Some(marks) => marks.between(gpu, &self.bound, color, stack.slices)?,
                        None => pass::Between::Nothing,
                    };
                    let tiles = self.bound.tiles(&shot, areas);
                    let places = (areas, &tiles);
                    pass::draw(gpu, pipeline, [&set; 2], vertices, stack, places, target, &between, &mut cut)?
                }
                (None, _) => {
                    let set = pipeline.bind(&self.bound.resources())?;
                    pass::march(gpu, pipeline, &set, (areas, shot.planes.count), target, &mut cut)?
                }
            });
            let texels = resolved.as_ref().unwrap_or(color).read_areas(areas)?;
            // Rays of other programs do not say so: what a module of a user gives may be below it.
            if self.variant.uses_two_phase() && texels.iter().any(|[.., alpha]| *alpha < CUT_SHORT) {
                return Ok(None);
            }
            pictures.add(texels);
        }
        let pixels = pictures.of_all();
        check_finite(&pixels, areas)?;
        let images = self.targets.iter().flat_map(|(color, resolved)| std::iter::once(&**color).chain(resolved));
        let images = images.chain(self.marks.as_ref().map(|marks| &marks.image));
        let targets: u64 = images.map(gpu::Image::bytes).sum();
        let measurements = Measurements {
            modules: variant.key(),
            others: Vec::new(),
            shipped: self.program.shipped,
            left_out: self.program.left_out(),
            octaves: variant.reads("turbulence").then_some([variant.octaves, scene.effect.octaves]),
            slices: shot.planes.count,
            step: shot.planes.step,
            fragments: drawn.fragments,
            compile_ms: std::mem::take(&mut self.compile_ms) + drawn.first_use_ms,
            gpu_ms: drawn.gpu_ms,
            shadow_ms,
            shadow_before_ms,
            longest_ms: drawn.longest_ms,
            total_ms: 0.0,
            processor_ms: None,
            images: self.bound.images(),
            device_bytes: self.bound.bytes() + targets + self.pipelines.half_angle.as_ref().map_or(0, HalfAngle::bytes),
            sparse: self.bound.sparse(),
            cells: self.bound.cells(),
            quantization: self.bound.quantization(),
            held_beyond: shot
                .view
                .objects
                .iter()
                .filter(|own| own.spread.held)
                .map(|own| own.spread.hold_radius)
                .reduce(f32::min),
        };
        Ok(Some(Frame { size: scene.image.size, pixels, measurements }))
    }
}

/// What the pictures of a scene are drawn into, and where their samples are averaged to.
fn targets(
    gpu: &Gpu,
    scene: &Scene,
    format: gpu::Format,
) -> Result<(Arc<gpu::Image>, Option<gpu::Image>), gpu::GpuError> {
    let ([width, height], msaa) = (scene.image.size, scene.quality.msaa);
    let target = |name, samples| {
        gpu::Image::new(gpu, name, gpu::Dimension::Plane(width, height), format, gpu::ImageUse::Target(samples))
    };
    let resolved = (msaa > 1).then(|| target("resolved target", 1)).transpose()?;
    Ok((Arc::new(target("target", msaa)?), resolved))
}
