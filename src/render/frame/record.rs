//! Pictures recorded into the commands of a host.

use super::background::BackgroundPrepare;
use super::destination::Destination;
use super::prepared::Prepared;
use super::renderer::{Recorded, Renderer};
use crate::gpu::{Format, HostCommands, Recording};
use crate::render::camera::{FrameContext, SubFrame};
use crate::render::error::RenderError;
use crate::render::subject::Subject;
use crate::render::variant::Variant;
use crate::scene::{Order, Scene};
use std::borrow::Cow;
use std::sync::Arc;

impl Renderer {
    /// Whether [`Renderer::record`] draws a scene at once in a format. Otherwise starts the preparation on a thread
    /// that submits nothing: a host asks before each frame, and draws something else until then. One scene is prepared
    /// at a time. Dropping the renderer waits for the thread.
    ///
    /// # Errors
    /// As [`Renderer::record`].
    pub fn is_recordable(&mut self, scene: &Scene, format: Format) -> Result<bool, RenderError> {
        self.prepare_recording(scene, Destination::Host { format, has_depth: false })
    }

    /// Whether [`Renderer::record`] draws a scene and its depth ([`HostCommands::with_depth`]) at once in a format.
    ///
    /// # Errors
    /// As [`Renderer::record`].
    pub fn is_recordable_with_depth(&mut self, scene: &Scene, format: Format) -> Result<bool, RenderError> {
        self.prepare_recording(scene, Destination::Host { format, has_depth: true })
    }

    /// Whether a scene can be recorded at once; starts the preparation otherwise.
    fn prepare_recording(&mut self, scene: &Scene, destination: Destination) -> Result<bool, RenderError> {
        let variant = self.recorded(scene, None)?;
        let is_finished = self.preparing.as_ref().is_some_and(BackgroundPrepare::is_finished);
        if let Some(preparing) = self.preparing.take_if(|_| is_finished) {
            self.take(preparing, &variant, destination)?;
        }
        if self.prepared.iter().any(|own| own.fits(&variant, destination)) {
            return Ok(true);
        }
        if self.preparing.is_none() {
            let made = self.prepared.iter().rev().find(|own| own.serves(&variant)).map(Prepared::share);
            let frame = FrameContext::of(variant, &self.subject);
            let (gpu, library) = (self.gpu.clone(), self.library.clone());
            self.preparing = Some(BackgroundPrepare::new(gpu, library, frame, destination, made.unwrap_or_default()));
        }
        Ok(false)
    }

    /// Records a picture of a scene over the content of a host's image: slices back to front, or rays. Size and format
    /// of the image replace `image.size` and `quality.target`. Commands [with depth](HostCommands::with_depth) also
    /// draw the depth of [`Renderer::render_depth`].
    ///
    /// The picture is that of [`Renderer::render`]. The call submits nothing and waits for nothing on the device, with one
    /// exception: the shadow volume of a scene with `light.shadows` is cast by submissions that are waited for, when
    /// its time, light or matter has changed. The host's commands copy images. Empty cells are proven on a thread;
    /// until then, pictures are drawn without.
    ///
    /// Scenes that differ only in camera, time, size and parameters share everything. Missing programs, images and
    /// pipelines are prepared by the calling thread: ask [`Renderer::is_recordable`] first.
    ///
    /// # Errors
    /// As [`Renderer::render`]; or the scene has `quality.msaa` or `quality.supersampling` above 1, or half-angle slices; with
    /// depth, as [`Renderer::render_depth`].
    pub fn record(&mut self, commands: &mut HostCommands<'_>, scene: &Scene) -> Result<Recording, RenderError> {
        let destination = Destination::Host { format: commands.format(), has_depth: commands.has_depth() };
        let variant = self.recorded(scene, Some(commands.size()))?;
        if let Some(preparing) = self.preparing.take_if(|preparing| preparing.serves(&variant, destination)) {
            self.take(preparing, &variant, destination)?;
        }
        let subject = self.subject.clone();
        let prepared = self.prepared(&variant, destination, &|_| ())?;
        prepared.record(commands, &variant, &subject)
    }

    /// Whether the next recorded picture has cells, and the empty share of the latest.
    #[cfg(test)]
    pub(crate) fn recorded_cells(&self) -> (bool, f32) {
        self.prepared.last().map_or((false, 0.0), |own| own.bound.recorded_cells())
    }

    /// The scene for a recorded image of a size, by default of that of the scene. An unchanged scene is not checked again.
    fn recorded(&mut self, scene: &Scene, size: Option<[u32; 2]>) -> Result<Arc<Variant>, RenderError> {
        let serves =
            |own: &&Recorded| own.scene == *scene && size.is_none_or(|size| size == own.variant.scene.image.size);
        if let Some(own) = self.recorded.as_ref().filter(serves) {
            return Ok(own.variant.clone());
        }
        if scene.quality.msaa > 1 {
            return Err(RenderError::Recorded("quality.msaa = 1"));
        }
        if scene.is_half_angle() {
            return Err(RenderError::Recorded("light.method = \"volume\""));
        }
        let mut own = scene.clone();
        (own.image.size, own.quality.order) = (size.unwrap_or(scene.image.size), Order::BackToFront);
        let checked = self.check(&own)?;
        let suited = self.suited(Cow::Borrowed(&checked));
        let mut variant = self.plain(&suited);
        if !own.may_find_first(&self.library) {
            variant = Cow::Owned(variant.without_two_phase()); // two-phase artifacts would not be noticed here
        }
        let variant = Arc::new(variant.into_owned());
        self.recorded = Some(Recorded { scene: scene.clone(), variant: variant.clone() });
        Ok(variant)
    }

    /// Caches the result of a preparation, waiting for it. An error matters only for the `wanted` scene.
    fn take(
        &mut self,
        preparing: BackgroundPrepare,
        wanted: &Variant,
        destination: Destination,
    ) -> Result<(), RenderError> {
        let serves = preparing.serves(wanted, destination);
        match preparing.join() {
            Ok(made) => {
                self.prepared.push(made);
                let more = self.prepared.len().saturating_sub(self.cache_size);
                self.prepared.drain(..more);
            }
            Err(error) if serves => return Err(error),
            Err(_) => {}
        }
        Ok(())
    }
}

impl Prepared {
    /// Records a picture of a scene that fits.
    pub(crate) fn record(
        &mut self,
        commands: &mut HostCommands<'_>,
        variant: &Arc<Variant>,
        subject: &Subject,
    ) -> Result<Recording, RenderError> {
        let kept = self.recorded.take();
        let kept = kept.filter(|(own, frame)| Arc::ptr_eq(own, variant) && frame.whole == self.whole);
        let is_kept = kept.is_some();
        let frame = kept.map_or_else(|| self.context(variant, subject), |(_, frame)| frame);
        let mut all = SubFrame::all(&variant.scene);
        let (Some(sub_frame), None) = (all.next(), all.next()) else {
            return Err(RenderError::Recorded("quality.supersampling = 1"));
        };
        if !is_kept {
            self.bound.set_blocks(&self.gpu, &self.program, &frame, &sub_frame)?;
        }
        self.bound.update_recorded_cells(&self.gpu, &self.program, &frame)?;
        if self.pipelines.caster.is_some() {
            self.bound.uploads.submit(&self.gpu)?; // the shadow pass is submitted, and reads them
        }
        self.cast(&frame, &|_| false)?;
        let (vertices, count) = match self.slices(&frame)? {
            Some((vertices, stack)) => (Some(vertices), stack.slices * stack.per_slice),
            None => (None, 3),
        };
        let pipeline = &self.pipelines.picture;
        let set = pipeline.bind(&self.bound.resources())?;
        let depth = self.pipelines.depth.as_ref().filter(|_| commands.has_depth());
        let depth =
            depth.map(|own| Ok::<_, RenderError>((own.pipeline.clone(), own.bind(&self.gpu, &self.bound, None)?)));
        let recording = commands.draw(&self.bound.uploads, pipeline, set, vertices, 0..count, depth.transpose()?);
        self.recorded = Some((variant.clone(), frame));
        Ok(recording)
    }

    /// Discards the values of the latest recorded picture, which the next one makes anew.
    pub(crate) fn forget_recorded(&mut self) {
        self.recorded = None;
    }
}
