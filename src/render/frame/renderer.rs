//! The renderer: public functions from a scene to its picture.

use super::background::BackgroundPrepare;
use super::depth::by_rays;
use super::destination::Destination;
use super::filters::note;
use super::pixels::paste_areas;
use super::prepared::{Prelude, Prepared, Reusable};
use super::trial::Ways;
use crate::field::Progress;
use crate::gpu::{Area, Gpu, Image};
use crate::render::camera::FrameContext;
use crate::render::custom_modules::with_module_cause;
use crate::render::error::RenderError;
use crate::render::measurements::Frame;
use crate::render::subject::Subject;
use crate::render::variant::{Checkable, PassImage, Variant};
use crate::scene::Scene;
use crate::shader::{Library, Slots};
use crate::shape::Groom;
use hypertexture_support::watchdog::own_processor_time;
use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;

/// Renders a scene.
///
/// The pixels are premultiplied linear RGBA without the background. A hard surface is located within the step
/// (`measurements.step`); a ray that grazes an edge for less than a step may miss it. The error in soft matter is of
/// the order of the step, and with `quality.integration = "segment"` of its square.
///
/// # Errors
/// The scene has no valid program, or a Vulkan call fails.
pub fn render(gpu: &Gpu, library: &Library, scene: &impl Checkable, subject: &Subject) -> Result<Frame, RenderError> {
    Renderer::new(gpu, library, subject).render(scene)
}

/// Renders scenes of one subject, and reuses programs, images and pipelines between pictures.
pub struct Renderer {
    pub(super) gpu: Gpu,
    pub(super) library: Library,
    pub(super) subject: Subject,
    /// Cached scenes, the latest last.
    pub(super) prepared: Vec<Prepared>,
    pub(super) cache_size: usize,
    whole: Option<[u32; 2]>,
    /// Whether the groom is being painted.
    is_stroke: bool,
    stop: Stop,
    /// Modules and samples of scenes whose two-phase rays the device has cut short.
    pub(super) cut_short: Vec<(Arc<Slots>, u32)>,
    /// Ways to draw that trials have chosen.
    pub(super) ways: Ways,
    /// The latest scene that was checked here.
    pub(super) checked: Option<Arc<Variant>>,
    pub(super) recorded: Option<Recorded>,
    /// Preparation of a host's next scene.
    pub(super) preparing: Option<BackgroundPrepare>,
    /// Time of preparing the next picture, milliseconds.
    prepared_ms: f64,
}

/// The latest recorded scene, and the variant that draws it.
pub(super) struct Recorded {
    pub(super) scene: Scene,
    pub(super) variant: Arc<Variant>,
}

/// Whether a picture ends unfinished; receives the milliseconds on the device.
type Stop = Arc<dyn Fn(f64) -> bool + Send + Sync>;

impl Renderer {
    /// Creates a renderer that shares device, library and subject.
    pub fn new(gpu: &Gpu, library: &Library, subject: &Subject) -> Renderer {
        let (gpu, library, subject) = (gpu.clone(), library.clone(), subject.clone());
        Renderer {
            gpu,
            library,
            subject,
            prepared: Vec::new(),
            cache_size: 1,
            whole: None,
            is_stroke: false,
            stop: Arc::new(|_| false),
            cut_short: Vec::new(),
            ways: Ways::default(),
            checked: None,
            recorded: None,
            preparing: None,
            prepared_ms: 0.0,
        }
    }

    /// Sets the number of cached scenes that differ in more than camera, size and parameters (default 1).
    pub fn set_cache_size(&mut self, scenes: usize) {
        self.cache_size = scenes.max(1);
    }

    /// Ends later pictures with [`RenderError::Stopped`] when `stop` returns true. It is called between submissions,
    /// which take about 25 ms, with the milliseconds of the picture so far.
    pub fn stop_where(&mut self, stop: impl Fn(f64) -> bool + Send + Sync + 'static) {
        self.stop = Arc::new(stop);
    }

    /// Sets the size of the finished picture, by which previews choose empty cells.
    pub fn set_full_size(&mut self, size: [u32; 2]) {
        self.whole = Some(size);
    }

    /// Replaces the groom that is painted on the object. During a `stroke`, pictures are drawn without empty cells,
    /// whose proofs take longer.
    ///
    /// # Errors
    /// Memory of the device is exhausted.
    pub fn paint(&mut self, groom: &Option<Arc<Groom>>, stroke: bool) -> Result<(), RenderError> {
        let is_same = match (&self.subject.groom, groom) {
            (Some(own), Some(other)) => Arc::ptr_eq(own, other),
            (own, other) => own.is_none() && other.is_none(),
        };
        if is_same && (stroke || !self.is_stroke) {
            return Ok(());
        }
        let strength = self.subject.strength();
        (self.subject.groom, self.is_stroke) = (groom.clone(), stroke);
        if self.subject.strength() != strength {
            self.prepared.clear(); // matter reaches as far as it is moved
        }
        self.prepared.iter_mut().for_each(Prepared::forget_recorded);
        let Some(groom) = groom else { return Ok(()) };
        self.prepared.iter_mut().filter(|own| own.variant.scene.groom.is_some()).try_for_each(|own| {
            let has_cells = !stroke && (own.program.reads_image(PassImage::Cells) || own.is_cut());
            own.bound.paint(&self.gpu, &self.library, &own.program, groom, has_cells)
        })
    }

    /// Prepares the next picture of a scene. `progress` receives the finished share of a noise block, from any thread;
    /// the largest take seconds.
    ///
    /// # Errors
    /// As [`render`].
    pub fn prepare(&mut self, scene: &impl Checkable, progress: Progress<'_>) -> Result<(), RenderError> {
        let start = Instant::now();
        let asked = self.check(scene)?;
        let own = self.suited(Cow::Borrowed(&asked));
        self.ways.recall(&self.gpu, &own, &self.library);
        let variant = self.in_way(&own);
        self.prepared(&variant, Destination::Frame, progress)?;
        self.prepared_ms += start.elapsed().as_secs_f64() * 1e3;
        Ok(())
    }

    /// Whether [`Renderer::prepare`] has nothing to do for a scene.
    pub fn is_prepared(&self, scene: &impl Checkable) -> bool {
        self.variant(scene).is_ok_and(|variant| self.serving(&variant).next().is_some())
    }

    /// Whether a picture of a scene can be drawn at once, with its prover of empty cells loaded.
    pub fn is_ready(&self, scene: &impl Checkable) -> bool {
        self.variant(scene).is_ok_and(|variant| {
            let whole = self.whole.unwrap_or(variant.scene.image.size);
            let frame = FrameContext { whole, ..FrameContext::of(variant, &self.subject) };
            self.serving(&frame.variant).any(|own| own.bound.is_ready(&self.gpu, &frame))
        })
    }

    fn serving<'a>(&'a self, variant: &'a Variant) -> impl Iterator<Item = &'a Prepared> {
        self.prepared.iter().filter(move |own| own.fits(variant, Destination::Frame))
    }

    /// Discards cached shadow volumes, so that the next pictures include their time.
    pub fn invalidate_shadows(&mut self) {
        self.prepared.iter_mut().for_each(Prepared::invalidate_shadows);
    }

    /// Renders a scene, with the bits of [`render`].
    ///
    /// # Errors
    /// As [`render`].
    pub fn render(&mut self, scene: &impl Checkable) -> Result<Frame, RenderError> {
        self.render_with(scene, &|_| ())
    }

    /// Renders a scene as [`Renderer::render`]. `progress` receives the finished share between submissions.
    ///
    /// # Errors
    /// As [`render`].
    pub fn render_with(&mut self, scene: &impl Checkable, progress: Progress<'_>) -> Result<Frame, RenderError> {
        let checked = self.check(scene)?;
        let whole = Area::whole(checked.scene.image.size);
        self.areas(&checked, std::slice::from_ref(&whole), None, progress)
    }

    /// Renders bands of a picture: ranges of rows that neither overlap nor touch. Their pixels have the bits of the
    /// whole picture; the others are undefined.
    ///
    /// # Errors
    /// As [`render`].
    pub fn render_bands(&mut self, scene: &impl Checkable, bands: &[Range<u32>]) -> Result<Frame, RenderError> {
        let checked = self.check(scene)?;
        let size @ [width, height] = checked.scene.image.size;
        let areas: Vec<Area> = bands.iter().map(|rows| Area { columns: 0..width, rows: rows.clone() }).collect();
        let mut frame = self.areas(&checked, &areas, None, &|_| ())?;
        if areas != [Area::whole(size)] {
            let mut pixels = vec![[0.0; 4]; width as usize * height as usize];
            paste_areas(&frame.pixels, &areas, width, &mut pixels);
            frame.pixels = pixels;
        }
        Ok(frame)
    }

    /// Renders areas of a picture, one after the other. Their quads of 2 x 2 pixels must not overlap; with
    /// `quality.msaa`, the areas must not touch either. `number` selects one sub-frame of `quality.supersampling`. The
    /// pixels of the frame are those of the areas in order, each row by row, with the bits of the whole picture.
    ///
    /// # Errors
    /// As [`render`].
    ///
    /// # Panics
    /// If the number is not below `quality.supersampling`, or an area is empty or outside the picture.
    pub fn render_areas(
        &mut self,
        scene: &impl Checkable,
        areas: &[Area],
        number: Option<u32>,
    ) -> Result<Frame, RenderError> {
        let checked = self.check(scene)?;
        self.areas(&checked, areas, number, &|_| ())
    }

    fn areas(
        &mut self,
        asked: &Variant,
        areas: &[Area],
        number: Option<u32>,
        progress: Progress<'_>,
    ) -> Result<Frame, RenderError> {
        let (start, before) = (Instant::now(), own_processor_time());
        let own = self.suited(Cow::Borrowed(asked));
        let mut is_open =
            self.ways.recall(&self.gpu, &own, &self.library) && !self.is_cut(&own) && !self.bends_in_compute(&own);
        let mut variant = self.in_way(&own);
        let count = variant.scene.quality.supersampling;
        assert!(number.is_none_or(|number| number < count), "{number:?} of {count}");
        let (subject, stop) = (self.subject.clone(), self.stop.clone());
        let wanted = |own: u32| number.is_none_or(|number| number == own);
        let (mut found, library) = (None, self.library.clone());
        let mut choose = |prepared: &mut Prepared, frame: &FrameContext| {
            found = Some(prepared.choose_way(&own, &library, frame, &*stop)?);
            Ok(())
        };
        let (slots, mut frame) = loop {
            let prelude: Option<Prelude<'_>> = if is_open { Some(&mut choose) } else { None };
            let prepared = self.prepared(&variant, Destination::Frame, &|_| ())?;
            let slots = prepared.slots().clone();
            let told = |ms: f64, part: f32| {
                progress(part);
                stop(ms)
            };
            let frame = prepared.frame(&variant, &subject, areas, wanted, prelude, &told);
            match frame.map_err(|error| with_module_cause(error, &self.library, &self.plain(&own), &subject))? {
                Some(frame) => break (slots, frame),
                None => {
                    self.cut_short.push((variant.slots.clone(), variant.scene.quality.samples));
                    self.recorded = None; // it may have two phases
                }
            }
            (variant, is_open) = (Cow::Owned(variant.without_two_phase()), false);
        };
        found.into_iter().for_each(|way| self.ways.set(&own, way));
        frame.measurements.total_ms = std::mem::take(&mut self.prepared_ms) + start.elapsed().as_secs_f64() * 1e3;
        let taken = own_processor_time().zip(before).map(|(after, before)| after.saturating_sub(before));
        frame.measurements.processor_ms = taken.map(|taken| taken.as_secs_f64() * 1e3);
        let drawn = Variant { slots, ..variant.into_owned() };
        frame.measurements.replaced = note(self.gpu.info(), &asked.scene, &drawn, &frame.measurements);
        // The record of a picture does not depend on a trial, which depends on time.
        frame.measurements.modules = drawn.with_phases_of(&self.plain(&own)).key();
        frame.measurements.others = subject.all_others().cloned().collect();
        Ok(frame)
    }

    /// The latest sub-frame on the device, which the next one overwrites; `None` with several samples per pixel.
    pub fn latest(&self) -> Option<&Arc<Image>> {
        self.prepared.last().and_then(Prepared::latest)
    }

    /// Renders the depth of a picture: for each pixel, row by row from the top, the distance from the eye along the
    /// axis of view (object units) at which a ray through its center reaches an opacity of 1/2; infinity where it does
    /// not. Hard matter is located within the step, as in [`render`]; in soft matter the error is of the order of the
    /// step. Scenes of slices are drawn by rays through the same samples. `quality.supersampling` and `quality.msaa`
    /// are ignored, since a mean of depths has no meaning.
    ///
    /// # Errors
    /// As [`render`] and [`check_depth`](crate::render::check_depth).
    pub fn render_depth(&mut self, scene: &Scene) -> Result<Vec<f32>, RenderError> {
        let (library, subject, stop) = (self.library.clone(), self.subject.clone(), self.stop.clone());
        let asked = self.check(&by_rays(scene)?)?; // slices may have more samples
        let own = self.suited(Cow::Borrowed(&asked));
        let variant = self.in_way(&own);
        let prepared = self.prepared(&variant, Destination::Frame, &|_| ())?;
        prepared.depth(&library, &variant, &subject, &*stop)
    }

    /// Checks a scene, unless it is the latest one, or the latest one from another view.
    pub(super) fn check(&mut self, scene: &impl Checkable) -> Result<Arc<Variant>, RenderError> {
        let last = self.checked.clone();
        let made = match (scene.checked_after(&self.library, last.as_deref())?, &last) {
            (Cow::Borrowed(own), Some(last)) if std::ptr::eq(own, &**last) => return Ok(last.clone()),
            (Cow::Borrowed(own), _) => return Ok(Arc::new(own.clone())), // checked by the caller
            (Cow::Owned(made), _) => Arc::new(made),
        };
        self.checked = Some(made.clone());
        Ok(made)
    }

    /// Finds or prepares the cache entry of a scene.
    pub(super) fn prepared(
        &mut self,
        variant: &Variant,
        destination: Destination,
        progress: Progress<'_>,
    ) -> Result<&mut Prepared, RenderError> {
        let mut prepared = match self.prepared.iter().rposition(|own| own.fits(variant, destination)) {
            Some(found) => self.prepared.remove(found),
            None => {
                let running = self.prepared.iter().rposition(|own| own.serves(variant));
                // The oldest entry is evicted first, and its reusable parts are kept.
                let oldest = (self.prepared.len() >= self.cache_size).then(|| self.prepared.remove(0));
                let made = match (running, oldest) {
                    (Some(0), Some(oldest)) => oldest.into_reusable(variant),
                    (Some(found), oldest) => self.prepared[found - usize::from(oldest.is_some())].share(),
                    (None, _) => Reusable::default(),
                };
                let frame = FrameContext::of(variant.clone(), &self.subject);
                Prepared::new(&self.gpu, &self.library, &frame, destination, made, progress)?
            }
        };
        prepared.resize(&variant.scene)?;
        prepared.whole = self.whole.unwrap_or(variant.scene.image.size);
        self.prepared.push(prepared);
        let last = self.prepared.len() - 1;
        Ok(&mut self.prepared[last])
    }
}

#[cfg(test)]
mod tests {
    use super::super::submission_budget::SubmissionBudget;
    use super::*;
    use crate::gpu::Options;
    use crate::scene::{Pass, Proxy};
    use crate::shader;
    use hypertexture_support::validation_lock::ValidationLock;

    #[test]
    #[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
    fn where_slices_are_cut_into_submissions_changes_no_bit() {
        let _lock = ValidationLock::acquire();
        let gpu = Gpu::new(&Options { validation: true, ..Options::from_env() }).unwrap();
        let mut scene = Scene::default();
        scene.object.input = "sphere".into();
        (scene.effect.classify, scene.effect.softness) = ("soft".into(), "quadratic".into());
        (scene.effect.opacity, scene.effect.surface) = ("beer".into(), "unlit".into());
        scene.effect.opacity_rate = 3.0; // light passes through all of it
        (scene.object.inner_iso, scene.object.outer_iso) = (-0.5, 0.25);
        (scene.camera.azimuth, scene.camera.elevation) = (0.0, 0.0); // slices are squares
        (scene.quality.pass, scene.quality.samples, scene.quality.early_termination) = (Pass::Slices, 1024, 0.0);
        scene.image.size = [24, 24];
        let subject = Subject::load(&scene, &shader::shipped(), &|_| ()).unwrap();
        let mut renderer = Renderer::new(&gpu, &shader::shipped(), &subject);
        for proxy in [Proxy::Polygons, Proxy::Quads] {
            scene.quality.proxy = proxy;
            let mut cut = |slices: f64| {
                renderer.prepare(&scene, &|_| ()).unwrap();
                *renderer.prepared[0].budget() = SubmissionBudget::fixed(slices * 24.0 * 24.0);
                renderer.render(&scene).unwrap().pixels
            };
            let whole = cut(1024.0);
            for slices in [1.0, 7.0, 256.0, 341.0, 342.0, 512.0, 683.0] {
                assert!(cut(slices) == whole, "{slices} {proxy:?} in a submission");
            }
        }
        assert!(gpu.messages().take().is_empty());
    }
}
