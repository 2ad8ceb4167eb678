//! From a scene to its picture: what users of the crate call.

use super::prepared::{Destination, Made, Prepared};
use super::shot::Shot;
use super::watch::explained;
use super::{Frame, RenderError, Subject};
use crate::field::Progress;
use crate::gpu::{Gpu, HostCommands, Recording};
use crate::render::variant::Variant;
use crate::scene::{Order, Scene};
use crate::shader::Library;
use std::ops::Range;
use std::time::Instant;

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
    prepared: Option<Prepared>,
    whole: Option<[u32; 2]>,
}

impl Renderer {
    /// A renderer that has made nothing yet. It shares device, library and subject, which are not copied.
    pub fn new(gpu: &Gpu, library: &Library, subject: &Subject) -> Renderer {
        Renderer { gpu: gpu.clone(), library: library.clone(), subject: subject.clone(), prepared: None, whole: None }
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
        let variant = Variant::of(scene, &self.library)?;
        self.prepared(scene, &variant, Destination::Frame, progress).map(drop)
    }

    /// Renders a scene, as [`render`] does, bit for bit.
    ///
    /// # Errors
    /// As [`render`].
    pub fn render(&mut self, scene: &Scene) -> Result<Frame, RenderError> {
        let all = 0..scene.image.size[1];
        self.render_bands(scene, std::slice::from_ref(&all))
    }

    /// Renders some of the pictures of which a picture with `quality.supersampling` is the mean, by their numbers from 0
    /// on: their mean, in bands as [`Renderer::render_bands`] has them. The mean over all numbers is the whole picture.
    ///
    /// # Errors
    /// As [`render`].
    ///
    /// # Panics
    /// Without a number, or with one that is not below `quality.supersampling`.
    pub fn render_part(&mut self, scene: &Scene, bands: &[Range<u32>], numbers: &[u32]) -> Result<Frame, RenderError> {
        let count = scene.quality.supersampling;
        assert!(!numbers.is_empty() && numbers.iter().all(|&number| number < count), "{numbers:?} of {count}");
        self.render_sub_frames(scene, bands, |number| numbers.contains(&number))
    }

    /// Renders some bands of a picture, ranges of rows in it that neither overlap nor touch. Their pixels are those of
    /// the whole picture, bit for bit; the others are undefined.
    ///
    /// # Errors
    /// As [`render`].
    pub fn render_bands(&mut self, scene: &Scene, bands: &[Range<u32>]) -> Result<Frame, RenderError> {
        self.render_sub_frames(scene, bands, |_| true)
    }

    fn render_sub_frames(
        &mut self,
        scene: &Scene,
        bands: &[Range<u32>],
        wanted: impl Fn(u32) -> bool,
    ) -> Result<Frame, RenderError> {
        let start = Instant::now();
        let variant = Variant::of(scene, &self.library)?;
        let subject = self.subject.clone();
        let prepared = self.prepared(scene, &variant, Destination::Frame, &|_| ())?;
        let frame = prepared.frame(scene, &subject, &variant, bands, wanted);
        let mut frame = frame.map_err(|error| explained(error, &self.library, scene, &subject))?;
        frame.measurements.total_ms = start.elapsed().as_secs_f64() * 1e3;
        frame.measurements.others = subject.all_others().cloned().collect();
        Ok(frame)
    }

    /// Records a picture of a scene over what is in a host's image, without waiting for it: slices back to front, or rays.
    /// The size of the image stands for `image.size`, and its format for `quality.target`.
    ///
    /// What a scene shares with the one before is not made again. What is new is made first, and waited for: programs,
    /// images, and the shadow volume of each picture of a scene with `light.shadows`.
    ///
    /// # Errors
    /// As [`render`]; or the scene has `quality.msaa` or `quality.supersampling` above 1, or half-angle slices.
    pub fn record(&mut self, commands: &mut HostCommands<'_>, scene: &Scene) -> Result<Recording, RenderError> {
        let mut scene = scene.clone();
        scene.image.size = commands.size();
        scene.quality.order = Order::BackToFront;
        if scene.quality.msaa > 1 {
            return Err(RenderError::Recorded("quality.msaa = 1"));
        }
        if scene.is_half_angle() {
            return Err(RenderError::Recorded("light.method = \"volume\""));
        }
        let variant = Variant::of(&scene, &self.library)?;
        let subject = self.subject.clone();
        let prepared = self.prepared(&scene, &variant, Destination::Host(commands.format()), &|_| ())?;
        prepared.record(commands, &scene, &subject, &variant)
    }

    /// What serves a scene, from what there is.
    fn prepared(
        &mut self,
        scene: &Scene,
        variant: &Variant,
        destination: Destination,
        progress: Progress<'_>,
    ) -> Result<&mut Prepared, RenderError> {
        let whole = self.whole;
        let mut prepared = match self.prepared.take() {
            Some(prepared) if prepared.fits(scene, variant, destination) => prepared,
            other => {
                let made = match other {
                    Some(other) if other.runs(variant) => other.made(scene, variant),
                    _ => Made::default(),
                };
                let shot = Shot::of(scene, &self.subject, variant);
                Prepared::new(&self.gpu, &self.library, &shot, destination, made, progress)?
            }
        };
        prepared.whole = whole.unwrap_or(scene.image.size);
        Ok(self.prepared.insert(prepared))
    }
}
