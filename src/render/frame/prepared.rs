//! Resources shared by the pictures of a scene, and the frame pipeline.

use super::bind::{BoundInputs, PipelineShape};
use super::depth::{Depth, variant_by_rays};
use super::destination::{Destination, targets};
use super::early_exit::OpaqueMask;
use super::half_angle::{HalfAngle, Slices};
use super::pixels::{Mean, check_finite};
use super::shadow::{ShadowCaster, ShadowVolume};
use super::submission_budget::{SubmissionBudget, SubmissionControl};
use super::{bind, pass};
use crate::field::Progress;
use crate::gpu::{self, Buffer, Gpu};
use crate::render::camera::{FrameContext, SubFrame};
use crate::render::error::RenderError;
use crate::render::inputs::Inputs;
use crate::render::measurements::{Frame, Measurements};
use crate::render::subject::Subject;
use crate::render::variant::{PassImage, Program, Variant};
use crate::scene::{Pass, Scene};
use crate::shader::{Library, Linker, Slots};
use std::sync::Arc;
use std::time::Instant;

/// Alpha below this marks a ray whose loops the device has cut: see `march.frag`.
const CUT_SHORT: f32 = -1000.0;

/// Parts of a prepared scene for reuse.
#[derive(Default)]
pub(crate) struct Reusable {
    /// A program with its slots.
    program: Option<(Program, Arc<Slots>)>,
    bound: Option<BoundInputs>,
    pipelines: Option<Pipelines>,
}

/// Compiled pipelines, with the state of their targets.
#[derive(Clone)]
pub(super) struct Pipelines {
    /// Octaves of the picture's program.
    octaves: u32,
    shape: PipelineShape,
    pub(super) picture: Arc<gpu::Pipeline>,
    /// Shadow casting, with `light.shadows`.
    pub(super) caster: Option<ShadowCaster>,
    /// Light buffers, with half-angle slicing.
    half_angle: Option<HalfAngle>,
    /// Depth, once requested.
    pub(super) depth: Option<Depth>,
    /// Submission budget of the pictures.
    budget: SubmissionBudget,
}

impl Pipelines {
    /// Blending of the picture's fragments.
    pub(super) fn blend(&self) -> gpu::Blend {
        self.shape.blend
    }
}

/// Work before the first rays of a picture, once its blocks are filled.
pub(super) type Prelude<'a> = &'a mut dyn FnMut(&mut Prepared, &FrameContext) -> Result<(), RenderError>;

/// Whether slices are cut into tiles by cells.
fn is_cut(destination: Destination, scene: &Scene) -> bool {
    destination == Destination::Frame && scene.quality.pass == Pass::Slices
}

/// A scene with program, pipelines, images and targets.
pub(crate) struct Prepared {
    pub(super) gpu: Gpu,
    /// The scene with the modules of its program, which may serve others.
    pub(super) variant: Variant,
    pub(super) destination: Destination,
    pub(crate) program: Program,
    pub(crate) bound: BoundInputs,
    pub(super) pipelines: Pipelines,
    /// Render target, and its resolve target with multisampling.
    pub(super) targets: Option<(Arc<gpu::Image>, Option<gpu::Image>)>,
    /// Buffer through which pictures are read.
    download: Option<Buffer>,
    /// Early exit of slices.
    marks: Option<OpaqueMask>,
    compile_ms: f64,
    /// Size of the full picture of which pictures are previews.
    pub(crate) whole: [u32; 2],
    /// The latest recorded picture, whose values the blocks hold, by its variant.
    pub(super) recorded: Option<(Arc<Variant>, FrameContext)>,
}

impl Prepared {
    #[cfg(test)]
    pub(crate) fn budget(&mut self) -> &mut SubmissionBudget {
        &mut self.pipelines.budget
    }

    /// Prepares a scene, with reusable parts.
    pub(crate) fn new(
        gpu: &Gpu,
        library: &Library,
        frame: &FrameContext,
        destination: Destination,
        reusable: Reusable,
        progress: Progress<'_>,
    ) -> Result<Prepared, RenderError> {
        let (start, scene) = (Instant::now(), &frame.variant.scene);
        let (program, slots) = match reusable.program {
            Some(made) => made,
            None => (frame.variant.program(library, Linker::new)?, frame.variant.slots.clone()),
        };
        let variant = Variant { slots, ..Variant::clone(&frame.variant) };
        let mut compile_ms = start.elapsed().as_secs_f64() * 1e3;
        let quality = &scene.quality;
        let bound = reusable.bound.map_or_else(
            || {
                let is_recorded = destination != Destination::Frame;
                // A host's scene is prepared without submissions; and a CPU bakes faster by rows than by texels.
                let on_device = !is_recorded && !gpu.info().cpu && gpu.info().unread.is_empty();
                let inputs = Inputs::without_blocks(library, frame, &program, progress, on_device)?;
                BoundInputs::new(gpu, library, &program, &inputs, is_cut(destination, scene), is_recorded, progress)
            },
            Ok,
        )?;
        let (format, blend) = (destination.format(quality), destination.blend(scene));
        let pipeline_start = Instant::now();
        let attributes = if quality.pass == Pass::Slices { pass::attributes(quality.proxy) } else { &[] };
        let ends_early = destination == Destination::Frame && OpaqueMask::serve(scene);
        let marks = ends_early.then(|| OpaqueMask::new(gpu, library, &variant)).transpose()?;
        let heeds = if marks.is_some() { gpu::Marks::Test } else { gpu::Marks::None };
        let shape = PipelineShape { attributes, format, samples: quality.msaa, blend, marks: heeds };
        let octaves = scene.effect.octaves;
        let (picture, caster, half_angle, mut depth, budget) =
            match reusable.pipelines.filter(|made| (made.octaves, made.shape) == (octaves, shape)) {
                Some(made) => (made.picture, made.caster, made.half_angle, made.depth, made.budget),
                None => {
                    let picture = bind::pipeline(gpu, &program, scene, shape)?;
                    (Arc::new(picture), None, None, None, SubmissionBudget::default())
                }
            };
        let caster = program
            .reads_image(PassImage::Shadow)
            .then(|| ShadowCaster::new(gpu, library, &variant, caster))
            .transpose()?;
        let half_angle = scene.is_half_angle().then(|| HalfAngle::new(gpu, library, &variant, half_angle));
        if let Destination::Host { has_depth: true, .. } = destination {
            depth = Some(Depth::new(gpu, library, &variant_by_rays(&variant, library)?, depth)?);
        }
        let pipelines =
            Pipelines { octaves, shape, picture, caster, half_angle: half_angle.transpose()?, depth, budget };
        compile_ms += pipeline_start.elapsed().as_secs_f64() * 1e3;
        let targets = match destination {
            Destination::Host { .. } => None,
            Destination::Frame => Some(targets(gpu, scene, format)?),
        };
        let (gpu, whole) = (gpu.clone(), frame.whole);
        Ok(Prepared {
            gpu,
            variant,
            destination,
            program,
            bound,
            pipelines,
            targets,
            download: None,
            marks,
            compile_ms,
            whole,
            recorded: None,
        })
    }

    /// Whether its slices are cut into tiles by cells.
    pub(super) fn is_cut(&self) -> bool {
        is_cut(self.destination, &self.variant.scene)
    }

    /// The target, unless it has several samples per pixel.
    pub(crate) fn latest(&self) -> Option<&Arc<gpu::Image>> {
        self.targets.as_ref().filter(|(_, resolved)| resolved.is_none()).map(|(color, _)| color)
    }

    /// Resizes the targets to those of a scene that fits.
    pub(crate) fn resize(&mut self, scene: &Scene) -> Result<(), RenderError> {
        if self.variant.scene.image.size != scene.image.size {
            self.variant.scene.image.size = scene.image.size;
            if let Some((color, _)) = &self.targets {
                self.targets = Some(targets(&self.gpu, scene, color.format())?);
            }
            self.marks.iter_mut().try_for_each(|marks| marks.resize(&self.gpu, scene))?;
        }
        self.pipelines.half_angle.iter_mut().try_for_each(|light| light.resize(&self.gpu, scene))
    }

    /// Parts for another scene that the program serves.
    pub(crate) fn into_reusable(self, variant: &Variant) -> Reusable {
        let has_same_inputs = self.has_same_inputs(variant);
        Reusable {
            program: Some((self.program, self.variant.slots)),
            bound: has_same_inputs.then_some(self.bound),
            pipelines: Some(self.pipelines),
        }
    }

    /// Copies of the compiled parts, for another scene.
    pub(crate) fn share(&self) -> Reusable {
        let program = Some((self.program.clone(), self.variant.slots.clone()));
        Reusable { program, bound: None, pipelines: Some(self.pipelines.clone()) }
    }

    /// Slots of the program. A variant that it serves may fold further terms.
    pub(super) fn slots(&self) -> &Arc<Slots> {
        &self.variant.slots
    }

    /// Context of a picture, with the slots of this program: its cells and tables serve the next picture, in which a zero
    /// may have changed.
    pub(super) fn context(&self, variant: &Variant, subject: &Subject) -> FrameContext {
        let variant = Variant { slots: self.variant.slots.clone(), ..variant.clone() };
        FrameContext { whole: self.whole, ..FrameContext::of(variant, subject) }
    }

    /// Slices of a picture; `None` for rays.
    pub(super) fn slices(&self, frame: &FrameContext) -> Result<Option<(Buffer, pass::Stack)>, RenderError> {
        let (quality, view, planes) = (&frame.variant.scene.quality, &frame.view, &frame.planes);
        if quality.pass == Pass::March {
            return Ok(None);
        }
        // Slanted rays may leave the sphere at the nearest plane.
        let radius = view.reaches()[0] + planes.step;
        let stack = pass::stack(planes, radius, quality.proxy, quality.order, view.tint());
        let none = [0; 4]; // a buffer cannot be empty, a stack can
        let bytes = if stack.vertices.is_empty() { &none } else { bytemuck::cast_slice(&stack.vertices) };
        Ok(Some((Buffer::new(&self.gpu, "proxy slices", gpu::BufferUse::Vertices, bytes)?, stack)))
    }

    pub(crate) fn invalidate_shadows(&mut self) {
        self.pipelines.caster.iter_mut().for_each(ShadowCaster::forget);
    }

    /// Casts the shadow volume of a picture and waits for it, unless the latest serves. Returns the milliseconds on the
    /// device now, and those of a reused volume.
    pub(super) fn cast(
        &mut self,
        frame: &FrameContext,
        stop: &dyn Fn(f64) -> bool,
    ) -> Result<Option<[f64; 2]>, RenderError> {
        let Some(caster) = &mut self.pipelines.caster else { return Ok(None) };
        let ShadowVolume { image, gpu_ms, is_kept, .. } = caster.volume(&self.gpu, frame, &self.bound, stop)?;
        self.bound.replace(&self.program, PassImage::Shadow, image);
        Ok(Some(if is_kept { [0.0, gpu_ms] } else { [gpu_ms, 0.0] }))
    }

    /// Depth of a picture of a scene that fits, by rays; `stop` receives the milliseconds on the device.
    pub(crate) fn depth(
        &mut self,
        library: &Library,
        variant: &Variant,
        subject: &Subject,
        stop: &dyn Fn(f64) -> bool,
    ) -> Result<Vec<f32>, RenderError> {
        self.forget_recorded();
        let frame = self.context(variant, subject);
        let depth = Depth::new(&self.gpu, library, &frame.variant, self.pipelines.depth.take())?;
        for sub_frame in SubFrame::all(&variant.scene).take(1) {
            self.bound.fill(&self.gpu, &self.program, &frame, &sub_frame, &|| stop(0.0))?;
        }
        self.pipelines.depth.insert(depth).draw(&self.gpu, &frame, &self.bound, stop)
    }

    /// Pipeline of another program of the scene, for the targets.
    pub(super) fn pipeline_of(&self, program: &Program) -> Result<gpu::Pipeline, gpu::GpuError> {
        bind::pipeline(&self.gpu, program, &self.variant.scene, self.pipelines.shape)
    }

    /// Draws later pictures by another program that reads the same resources.
    pub(super) fn replace_program(&mut self, variant: Variant, program: Program, pipeline: gpu::Pipeline) {
        (self.variant, self.program) = (variant, program);
        (self.pipelines.picture, self.pipelines.budget) = (Arc::new(pipeline), SubmissionBudget::default());
    }

    /// The frame pipeline: areas of a picture of a scene that fits, averaged over the `wanted` sub-frames. Returns the
    /// pixels of the areas in order, or `None` if the device has cut the loops of two-phase rays. `stop` receives the
    /// milliseconds on the device. `prelude` may replace the program.
    pub(crate) fn frame(
        &mut self,
        variant: &Variant,
        subject: &Subject,
        areas: &[gpu::Area],
        wanted: impl Fn(u32) -> bool,
        mut prelude: Option<Prelude<'_>>,
        stop: &dyn Fn(f64, f32) -> bool,
    ) -> Result<Option<Frame>, RenderError> {
        self.forget_recorded();
        let (frame, scene) = (self.context(variant, subject), &variant.scene);
        let slices = self.slices(&frame)?;
        let mut pictures = Mean::default();
        let mut drawn = pass::PassTiming { fragments: Some(0), ..Default::default() };
        let (mut shadow_ms, mut shadow_before_ms) = (None, 0.0);
        let all = (0..).zip(SubFrame::all(scene)).filter(|(number, _)| wanted(*number)).count() as f32;
        for (_, sub_frame) in (0..).zip(SubFrame::all(scene)).filter(|(number, _)| wanted(*number)) {
            let finished = pictures.count as f32;
            let stop = |ms: f64, part: f32| stop(ms, (finished + part) / all);
            let so_far = drawn.gpu_ms + shadow_ms.unwrap_or(0.0);
            self.bound.fill(&self.gpu, &self.program, &frame, &sub_frame, &|| stop(so_far, 0.0))?;
            if let Some([now, before]) = self.cast(&frame, &|ms| stop(so_far + ms, 0.0))? {
                shadow_ms = Some(shadow_ms.unwrap_or(0.0) + now);
                shadow_before_ms += if pictures.count == 0 { before } else { 0.0 };
            }
            if let Some(prelude) = prelude.take() {
                let start = Instant::now();
                prelude(self, &frame)?;
                self.compile_ms += start.elapsed().as_secs_f64() * 1e3;
            }
            let Some((color, resolved)) = &self.targets else { continue };
            let marks = self.marks.as_ref().map(|marks| &marks.image);
            let target = gpu::Target { color, resolved: resolved.as_ref(), marks };
            let (gpu, pipeline) = (&self.gpu, &*self.pipelines.picture);
            let before = drawn.gpu_ms + shadow_ms.unwrap_or(0.0);
            let stop = |ms: f64, part: f32| stop(before + ms, part);
            let mut control = SubmissionControl { budget: &mut self.pipelines.budget, stop: &stop };
            let tiles = self.bound.tiles(&frame, areas);
            drawn.append(&match (&slices, &self.pipelines.half_angle) {
                (Some((vertices, stack)), Some(light)) => {
                    let slices = Slices { pipeline, program: &self.program, bound: &self.bound, vertices, stack };
                    light.draw(gpu, &frame, &slices, areas, target, &mut control)?
                }
                (Some((vertices, stack)), None) => {
                    let set = pipeline.bind(&self.bound.resources())?;
                    let between = match &self.marks {
                        Some(marks) => marks.between(gpu, &self.bound, color, stack.slices)?,
                        None => pass::BetweenSlices::Nothing,
                    };
                    let places = (areas, &tiles);
                    pass::draw(gpu, pipeline, [&set; 2], vertices, stack, places, target, &between, &mut control)?
                }
                (None, _) => {
                    let set = bind::bind_rays(&self.program, pipeline, self.bound.resources(), Some(color))?;
                    pass::march(gpu, pipeline, &set, (tiles.of_rays(), frame.planes.count), target, &mut control)?
                }
            });
            let texels = resolved.as_ref().unwrap_or(color).read_areas(areas, &mut self.download)?;
            // Only two-phase programs mark cut rays; custom modules may return any alpha.
            let least = |part: &[[f32; 4]]| part.iter().fold(f32::MAX, |least, [.., alpha]| least.min(*alpha));
            if self.variant.uses_two_phase() && texels.chunks(1024).any(|part| least(part) < CUT_SHORT) {
                return Ok(None);
            }
            pictures.add(texels);
        }
        let pixels = pictures.of_all();
        check_finite(&pixels, areas)?;
        let measurements = self.measurements(&frame, &drawn, shadow_ms, shadow_before_ms);
        Ok(Some(Frame { size: scene.image.size, pixels, measurements }))
    }

    /// Measurements of a picture; the renderer adds those of all its work.
    fn measurements(
        &mut self,
        frame: &FrameContext,
        drawn: &pass::PassTiming,
        shadow_ms: Option<f64>,
        shadow_before_ms: f64,
    ) -> Measurements {
        let images = self.targets.iter().flat_map(|(color, resolved)| std::iter::once(&**color).chain(resolved));
        let images = images.chain(self.marks.as_ref().map(|marks| &marks.image));
        let targets: u64 = images.map(gpu::Image::bytes).sum();
        let scene = &frame.variant.scene;
        Measurements {
            modules: frame.variant.key(),
            is_compute: self.program.is_compute,
            is_direct: scene.quality.pass == Pass::March && !self.variant.uses_two_phase(),
            others: Vec::new(),
            shipped: self.program.shipped,
            left_out: self.program.left_out(),
            octaves: frame.variant.reads("turbulence").then_some([frame.variant.octaves, scene.effect.octaves]),
            slices: frame.planes.count,
            step: frame.planes.step,
            fragments: drawn.fragments,
            compile_ms: std::mem::take(&mut self.compile_ms) + drawn.first_use_ms,
            gpu_ms: drawn.gpu_ms,
            shadow_ms,
            shadow_before_ms,
            longest_ms: drawn.longest_ms,
            total_ms: 0.0,
            processor_ms: None,
            replaced: None,
            images: self.bound.images(),
            device_bytes: self.bound.bytes() + targets + self.pipelines.half_angle.as_ref().map_or(0, HalfAngle::bytes),
            sparse: self.bound.sparse(),
            cells: self.bound.cells(),
            quantization: self.bound.quantization(),
            held_beyond: frame
                .view
                .objects
                .iter()
                .filter(|own| own.spread.held)
                .map(|own| own.spread.hold_radius)
                .reduce(f32::min),
        }
    }
}
