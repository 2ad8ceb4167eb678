//! Validity of the pixels on the screen.

use super::job::{Event, Job, LoadedScene, Picture};
use super::render_thread::RenderThread;
use super::status::Stage;
use crate::background::{cancel_if, catch_cancellation};
use crate::screen::Encoded;
use egui::ColorImage;
use hypertexture::render::{RenderError, Renderer, Subject};
use hypertexture::scene::Scene;
use hypertexture::shader::Library;
use hypertexture_measure::validity::{Found, TRUSTED, Validity, examine};

/// Legend color of valid pixels.
const GREY: [u8; 3] = [128; 3];

impl RenderThread {
    /// Computes the validity of the scene's own pixels; `None` if the job is stale.
    pub(super) fn examine(&self, job: &Job, own: &[[f32; 4]]) -> Result<Option<Validity>, RenderError> {
        let LoadedScene { scene, library, subject } = &job.variants[0];
        let mut renderer = Renderer::new(&self.gpu, library, subject);
        let mut lost = None;
        let mut draw = |better: &Scene, modules: &Library| {
            let drawn = if better.object != scene.object {
                self.of_another_object(job, better)
            } else if *modules != **library {
                self.pixels(job, better, &mut Renderer::new(&self.gpu, modules, subject))
            } else {
                self.pixels(job, better, &mut renderer)
            };
            match drawn {
                Err(error) if matches!(&error, RenderError::Gpu(error) if error.is_lost()) => {
                    lost = Some(error);
                    None
                }
                drawn => drawn.map_err(|error| error.to_string()).transpose(),
            }
        };
        let validity = examine(scene, library, own, subject.field.is_some(), &mut draw);
        lost.map_or(Ok(validity), Err)
    }

    /// Sends the picture with its validity colors and their legend.
    pub(super) fn send_validity(&self, job: &Job, validity: &Validity, own: &[[f32; 4]], gpu_ms: f64) {
        let picture = Picture::of(job, Stage::Validity, gpu_ms);
        let colors = ColorImage::from_rgb(picture.size.map(|side| side as usize), &validity.colors(own));
        let images = Encoded::Host(vec![colors]);
        let trusted = format!(
            "{:.1} % change by less than {TRUSTED:.1e} with any better setting; render --validity also shows unresolved bounds",
            validity.trusted()
        );
        let line = |Found { cause, pixels, .. }: &Found| {
            (cause.color, format!("{} {:.1} %: {}", cause.name, validity.percent(*pixels), cause.why))
        };
        let lines = validity.found.iter().filter(|found| found.pixels > 0).map(line);
        let validity = std::iter::once((GREY, trusted)).chain(lines).collect();
        (self.send)(Event::Picture(Box::new(Picture { images, validity, ..picture })));
    }

    /// The picture of a scene with the object of the job; `None` if the job is stale.
    fn pixels(&self, job: &Job, scene: &Scene, renderer: &mut Renderer) -> Result<Option<Vec<[f32; 4]>>, RenderError> {
        let mut pixels = Vec::new();
        Ok(self.in_tiles(job, scene, renderer, &mut pixels, |_, _| ())?.map(|_| pixels))
    }

    /// The picture of a scene with another object, which is loaded first.
    fn of_another_object(&self, job: &Job, scene: &Scene) -> Result<Option<Vec<[f32; 4]>>, RenderError> {
        let library = &job.variants[0].library;
        let progress = |_| cancel_if(self.shared.is_stale(job.number));
        let Some(subject) = catch_cancellation(|| Subject::load(scene, library, &progress)) else { return Ok(None) };
        self.pixels(job, scene, &mut Renderer::new(&self.gpu, library, &subject?))
    }
}
