//! From a scene to its picture: what users of the crate call.

use super::coming::Coming;
use super::depth::by_rays;
use super::masks::Masks;
use super::pixels::put;
use super::prepared::{Destination, Made, Prepared};
use super::shot::Shot;
use super::watchdog::explained;
use super::{Frame, RenderError, Subject};
use crate::field::Progress;
use crate::gpu::{Area, Format, Gpu, HostCommands, Recording};
use crate::render::variant::Variant;
use crate::scene::{Order, Scene};
use crate::shader::{Library, Slots};
use std::borrow::Cow;
use std::ops::Range;
use std::sync::Arc;
use std::time::Instant;
use support::watchdog::own_processor_time;

/// Renders a scene.
///
/// The pixels are premultiplied linear RGBA without the background. A hard surface is located within the step
/// (`measurements.step`); a ray that grazes an edge for less than a step may miss it.
/// The error in soft matter is of the order of the step, and with `quality.integration = "segment"` of its square.
///
/// # Errors
/// The scene has no valid program, or the device refuses.
pub fn render(gpu: &Gpu, library: &Library, scene: &Scene, subject: &Subject) -> Result<Frame, RenderError> {
    Renderer::new(gpu, library, subject).render(scene)
}

/// Renders scenes of one subject: what was made for one picture and fits the next is not made again.
pub struct Renderer {
    gpu: Gpu,
    library: Library,
    subject: Subject,
    /// For the last scenes, the last one last.
    prepared: Vec<Prepared>,
    kept: usize,
    whole: Option<[u32; 2]>,
    stop: Stop,
    /// Modules and samples of scenes whose loops the device has cut where rays waited for each other.
    cut: Vec<(Slots, u32)>,
    masks: Masks,
    /// What the next scene of a host needs.
    coming: Option<Coming>,
    /// Milliseconds of making what the next picture needs.
    prepared_ms: f64,
}

/// Whether a picture ends unfinished, after so many milliseconds on the device.
type Stop = Arc<dyn Fn(f64) -> bool + Send + Sync>;

impl Renderer {
    /// A renderer that has made nothing yet. It shares device, library and subject, which are not copied.
    pub fn new(gpu: &Gpu, library: &Library, subject: &Subject) -> Renderer {
        let (gpu, library, subject) = (gpu.clone(), library.clone(), subject.clone());
        Renderer {
            gpu,
            library,
            subject,
            prepared: Vec::new(),
            kept: 1,
            whole: None,
            stop: Arc::new(|_| false),
            cut: Vec::new(),
            masks: Masks::default(),
            coming: None,
            prepared_ms: 0.0,
        }
    }

    /// Keeps what was made for so many scenes that have less in common than camera, size and parameters; without this, for
    /// one.
    pub fn keep(&mut self, scenes: usize) {
        self.kept = scenes.max(1);
    }

    /// Pictures from now on end with [`RenderError::Stopped`] where `stop` says so. It is asked between submissions to the
    /// device, which take some [`SUBMISSION_MS`](super::pace::SUBMISSION_MS), with the milliseconds of the picture so far.
    pub fn stop_where(&mut self, stop: impl Fn(f64) -> bool + Send + Sync + 'static) {
        self.stop = Arc::new(stop);
    }

    /// Pictures from now on are small ones of a picture of this size: they leave out as much of empty space as that does.
    pub fn stand_for(&mut self, size: [u32; 2]) {
        self.whole = Some(size);
    }

    /// Makes what the next picture of a scene needs. Calls `progress` with the part of a block of noise that is done, from
    /// any thread, while one is made: the largest take seconds.
    ///
    /// # Errors
    /// As [`render`].
    pub fn prepare(&mut self, scene: &Scene, progress: Progress<'_>) -> Result<(), RenderError> {
        let start = Instant::now();
        let (scene, variant) = self.chosen(scene)?;
        self.prepared(&scene, &variant, Destination::Frame, progress)?;
        self.prepared_ms += start.elapsed().as_secs_f64() * 1e3;
        Ok(())
    }

    /// Whether program and images of a scene are made: what [`Renderer::prepare`] makes.
    pub fn is_prepared(&self, scene: &Scene) -> bool {
        self.chosen(scene).is_ok_and(|(scene, variant)| self.serving(&scene, &variant).next().is_some())
    }

    /// Whether a picture of a scene can be drawn at once: it is prepared, and what decides where its space is empty is made.
    pub fn is_ready(&self, scene: &Scene) -> bool {
        let whole = self.whole.unwrap_or(scene.image.size);
        self.chosen(scene).is_ok_and(|(scene, variant)| {
            let shot = Shot { whole, ..Shot::of(&scene, &self.subject, &variant) };
            self.serving(&scene, &variant).any(|own| own.bound.is_ready(&self.gpu, &shot))
        })
    }

    fn serving<'a>(&'a self, scene: &'a Scene, variant: &'a Variant) -> impl Iterator<Item = &'a Prepared> {
        self.prepared.iter().filter(move |own| own.fits(scene, variant, Destination::Frame))
    }

    /// Pictures from now on have their shadow volumes cast anew: for their time.
    pub fn forget_shadows(&mut self) {
        self.prepared.iter_mut().for_each(Prepared::forget_shadows);
    }

    /// Renders a scene, as [`render`] does, bit for bit.
    ///
    /// # Errors
    /// As [`render`].
    pub fn render(&mut self, scene: &Scene) -> Result<Frame, RenderError> {
        let all = 0..scene.image.size[1];
        self.render_bands(scene, std::slice::from_ref(&all))
    }

    /// Renders some bands of a picture, ranges of rows in it that neither overlap nor touch. Their pixels are those of
    /// the whole picture, bit for bit; the others are undefined.
    ///
    /// # Errors
    /// As [`render`].
    pub fn render_bands(&mut self, scene: &Scene, bands: &[Range<u32>]) -> Result<Frame, RenderError> {
        let [width, height] = scene.image.size;
        let areas: Vec<Area> = bands.iter().map(|rows| Area { columns: 0..width, rows: rows.clone() }).collect();
        let mut frame = self.render_areas(scene, &areas, None)?;
        if areas != [Area::whole(scene.image.size)] {
            let mut pixels = vec![[0.0; 4]; width as usize * height as usize];
            put(&frame.pixels, &areas, width, &mut pixels);
            frame.pixels = pixels;
        }
        Ok(frame)
    }

    /// Renders areas of a picture, one after the other, whose quads of 2 x 2 pixels do not overlap; with `quality.msaa`, they
    /// do not touch either.
    /// Of a picture with `quality.supersampling` it may be the one with this number of those that it is the mean of. The
    /// pixels of the frame are those of the areas, one behind the other, each row by row: those of the whole picture, bit
    /// for bit.
    ///
    /// # Errors
    /// As [`render`].
    ///
    /// # Panics
    /// With a number that is not below `quality.supersampling`, or an area that is empty or not in the picture.
    pub fn render_areas(&mut self, scene: &Scene, areas: &[Area], number: Option<u32>) -> Result<Frame, RenderError> {
        let (start, before) = (Instant::now(), own_processor_time());
        let count = scene.quality.supersampling;
        assert!(number.is_none_or(|number| number < count), "{number:?} of {count}");
        let (scene, mut variant) = self.chosen(scene)?;
        let (subject, stop) = (self.subject.clone(), self.stop.clone());
        let wanted = |own: u32| number.is_none_or(|number| number == own);
        let mut frame = loop {
            let prepared = self.prepared(&scene, &variant, Destination::Frame, &|_| ())?;
            let frame = prepared.frame(&scene, &subject, &variant, areas, wanted, &*stop);
            match frame.map_err(|error| explained(error, &self.library, &scene, &subject))? {
                Some(frame) => break frame,
                None => self.cut.push((variant.slots.clone(), scene.quality.samples)),
            }
            variant = variant.without_two_phase();
        };
        frame.measurements.total_ms = std::mem::take(&mut self.prepared_ms) + start.elapsed().as_secs_f64() * 1e3;
        let taken = own_processor_time().zip(before).map(|(after, before)| after.saturating_sub(before));
        frame.measurements.processor_ms = taken.map(|taken| taken.as_secs_f64() * 1e3);
        frame.measurements.others = subject.all_others().cloned().collect();
        Ok(frame)
    }

    /// Renders the depth of a picture: of each pixel, row by row from the top, how far from the eye along the axis of view
    /// (object units) a ray through its middle meets an opacity of 1/2, all matter in front together; infinite where it meets
    /// less. Hard matter is located within the step, as in [`render`]; in soft matter the error is of the order of the step.
    /// Slices are taken for rays, whose samples are the same; of `quality.supersampling` and `quality.msaa` nothing is left,
    /// since a mean of depths is the depth of nothing.
    ///
    /// # Errors
    /// As [`render`] and [`check_depth`](super::check_depth).
    pub fn render_depth(&mut self, scene: &Scene) -> Result<Vec<f32>, RenderError> {
        let (library, subject, stop) = (self.library.clone(), self.subject.clone(), self.stop.clone());
        let by_rays = by_rays(scene, &library)?;
        let (scene, variant) = self.chosen(&by_rays)?;
        let prepared = self.prepared(&scene, &variant, Destination::Frame, &|_| ())?;
        prepared.depth(&library, &scene, &subject, &variant, &*stop)
    }

    /// Whether [`Renderer::record`] draws a scene at once in a format. What is missing is made on a thread of its own, which
    /// submits nothing: a host asks before each frame, and draws something else until it is there. A second scene is begun
    /// when the first is made. Dropping the renderer waits for the thread.
    ///
    /// # Errors
    /// As [`Renderer::record`].
    pub fn is_recordable(&mut self, scene: &Scene, format: Format) -> Result<bool, RenderError> {
        self.is_made(scene, Destination::Host { format, has_depth: false })
    }

    /// The same with the depth of the picture: of [`HostCommands::with_depth`].
    ///
    /// # Errors
    /// As [`Renderer::record`].
    pub fn is_recordable_with_depth(&mut self, scene: &Scene, format: Format) -> Result<bool, RenderError> {
        self.is_made(scene, Destination::Host { format, has_depth: true })
    }

    /// Whether a scene can be recorded at once; begins the missing parts.
    fn is_made(&mut self, scene: &Scene, destination: Destination) -> Result<bool, RenderError> {
        let (scene, variant) = self.recorded(scene, scene.image.size)?;
        let is_made = self.coming.as_ref().is_some_and(Coming::is_made);
        if let Some(coming) = self.coming.take_if(|_| is_made) {
            self.take(coming, (&scene, &variant, destination))?;
        }
        if self.prepared.iter().any(|own| own.fits(&scene, &variant, destination)) {
            return Ok(true);
        }
        if self.coming.is_none() {
            let made = self.prepared.iter().rev().find(|own| own.runs(&variant)).map(Prepared::shared);
            let all = (self.gpu.clone(), self.library.clone(), self.subject.clone());
            self.coming = Some(Coming::new(all, (scene, variant, destination), made.unwrap_or_default()));
        }
        Ok(false)
    }

    /// Records a picture of a scene over what is in a host's image: slices back to front, or rays. The size of the image
    /// stands for `image.size`, and its format for `quality.target`. Commands [with depth](HostCommands::with_depth) draw what
    /// [`Renderer::render_depth`] gives as well.
    ///
    /// The picture is that of [`render`]. Nothing is submitted, and nothing on the device is waited for, with one exception:
    /// the shadow volume of a scene with `light.shadows` is cast anew, by submissions that are waited for, wherever its time,
    /// light or matter has changed. Images are copied by the host's commands, and the cells of empty space are found on a
    /// thread of their own: until they are, a picture is drawn without them.
    ///
    /// What a scene shares with the one before, all but camera, time, size and parameters, is not made again. Programs, images
    /// and pipelines that are missing are made here, by the calling thread: ask [`Renderer::is_recordable`] first.
    ///
    /// # Errors
    /// As [`render`]; or the scene has `quality.msaa` or `quality.supersampling` above 1, or half-angle slices; with depth, as
    /// [`Renderer::render_depth`].
    pub fn record(&mut self, commands: &mut HostCommands<'_>, scene: &Scene) -> Result<Recording, RenderError> {
        let destination = Destination::Host { format: commands.format(), has_depth: commands.has_depth() };
        let (scene, variant) = self.recorded(scene, commands.size())?;
        if let Some(coming) = self.coming.take_if(|coming| coming.serves(&scene, &variant, destination)) {
            self.take(coming, (&scene, &variant, destination))?;
        }
        let subject = self.subject.clone();
        let prepared = self.prepared(&scene, &variant, destination, &|_| ())?;
        prepared.record(commands, &scene, &subject, &variant)
    }

    /// Whether cells are there for the next picture that is recorded, and the part of the last ones that is empty.
    #[cfg(test)]
    pub(crate) fn recorded_cells(&self) -> (bool, f32) {
        self.prepared.last().map_or((false, 0.0), |own| own.bound.recorded_cells())
    }

    /// A scene as it is recorded for an image of a size, and its modules.
    fn recorded(&self, scene: &Scene, size: [u32; 2]) -> Result<(Scene, Variant), RenderError> {
        let mut scene = scene.clone();
        scene.image.size = size;
        scene.quality.order = Order::BackToFront;
        if scene.quality.msaa > 1 {
            return Err(RenderError::Recorded("quality.msaa = 1"));
        }
        if scene.is_half_angle() {
            return Err(RenderError::Recorded("light.method = \"volume\""));
        }
        let (scene, mut variant) = self.chosen(&scene)?;
        if !scene.may_find_first(&self.library) {
            variant = variant.without_two_phase(); // what comes of it is not seen here
        }
        Ok((scene.into_owned(), variant))
    }

    /// Keeps what was made beside, waiting for it. What failed matters to the scene that is `wanted` alone.
    fn take(&mut self, coming: Coming, wanted: (&Scene, &Variant, Destination)) -> Result<(), RenderError> {
        let serves = coming.serves(wanted.0, wanted.1, wanted.2);
        match coming.made() {
            Ok(made) => {
                self.prepared.push(made);
                let more = self.prepared.len().saturating_sub(self.kept);
                self.prepared.drain(..more);
            }
            Err(error) if serves => return Err(error),
            Err(_) => {}
        }
        Ok(())
    }

    /// A scene as it is drawn, and its modules: without masks that it does not need, and with rays that do not wait for each
    /// other where the device has cut the loops of such rays.
    fn chosen<'a>(&self, scene: &'a Scene) -> Result<(Cow<'a, Scene>, Variant), RenderError> {
        let (scene, variant) = self.masks.without_idle(&self.library, scene, &self.subject)?;
        let is_cut =
            self.cut.iter().any(|(slots, samples)| *slots == variant.slots && *samples <= scene.quality.samples);
        Ok((scene, if is_cut { variant.without_two_phase() } else { variant.for_device(self.gpu.info().cpu) }))
    }

    /// What serves a scene, from what there is.
    fn prepared(
        &mut self,
        scene: &Scene,
        variant: &Variant,
        destination: Destination,
        progress: Progress<'_>,
    ) -> Result<&mut Prepared, RenderError> {
        let mut prepared = match self.prepared.iter().rposition(|own| own.fits(scene, variant, destination)) {
            Some(found) => self.prepared.remove(found),
            None => {
                let running = self.prepared.iter().rposition(|own| own.runs(variant));
                // What goes first makes room for what comes, and what of it serves is kept.
                let oldest = (self.prepared.len() >= self.kept).then(|| self.prepared.remove(0));
                let made = match (running, oldest) {
                    (Some(0), Some(oldest)) => oldest.made(scene, variant),
                    (Some(found), oldest) => self.prepared[found - usize::from(oldest.is_some())].shared(),
                    (None, _) => Made::default(),
                };
                let shot = Shot::of(scene, &self.subject, variant);
                Prepared::new(&self.gpu, &self.library, &shot, destination, made, progress)?
            }
        };
        prepared.resize(scene)?;
        prepared.whole = self.whole.unwrap_or(scene.image.size);
        self.prepared.push(prepared);
        let last = self.prepared.len() - 1;
        Ok(&mut self.prepared[last])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::Options;
    use crate::render::pace::Pace;
    use crate::scene::{Pass, Proxy};
    use crate::shader;
    use support::validation_lock::ValidationLock;

    #[test]
    #[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
    fn where_slices_are_cut_into_submissions_changes_no_bit() {
        let _lock = ValidationLock::acquire();
        let gpu = Gpu::new(&Options { validation: true, ..Options::from_env() }).unwrap();
        let mut scene = Scene::default();
        scene.object.input = "sphere".into();
        (scene.effect.classify, scene.effect.softness) = ("soft".into(), "quadratic".into());
        (scene.effect.opacity, scene.effect.surface) = ("beer".into(), "unlit".into());
        scene.effect.opacity_rate = 3.0; // light comes through all of it
        (scene.object.inner_iso, scene.object.outer_iso) = (-0.5, 0.25);
        (scene.camera.azimuth, scene.camera.elevation) = (0.0, 0.0); // a slice is a square
        (scene.quality.pass, scene.quality.samples, scene.quality.early_termination) = (Pass::Slices, 1024, 0.0);
        scene.image.size = [24, 24];
        let subject = Subject::load(&scene, &shader::shipped(), &|_| ()).unwrap();
        let mut renderer = Renderer::new(&gpu, &shader::shipped(), &subject);
        for proxy in [Proxy::Polygons, Proxy::Quads] {
            scene.quality.proxy = proxy;
            let mut cut = |slices: f64| {
                renderer.prepare(&scene, &|_| ()).unwrap();
                *renderer.prepared[0].pace() = Pace::fixed(slices * 24.0 * 24.0);
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
