//! The state of the pixel inspector.

use super::search::{PixelReport, Search};
use super::worst::worst;
use crate::background::Notify;
use crate::screen::Frame;
use crate::worker::Stage;
use crate::worker::{Job, LoadedScene};

/// Number of most different pixels, and their minimal distance in pixels.
const WORST: usize = 8;
const APART: u32 = 12;

/// Pictures of a resting scene.
#[derive(Default)]
pub(super) struct Pictures {
    pub(super) size: [u32; 2],
    /// The picture of `render`.
    pub(super) own: Option<Frame>,
    /// The mean, and its number of pictures.
    pub(super) mean: Option<(Frame, u32)>,
    /// The equally sampled picture of the compared variant.
    pub(super) other: Option<Frame>,
}

/// The pixel inspector.
#[derive(Default)]
pub struct Inspector {
    /// The pixel, from the left and the top.
    pub(super) pixel: Option<[u32; 2]>,
    pub(super) pictures: Pictures,
    pub(super) search: Option<Search>,
    pub(super) report: PixelReport,
    /// The most different pixels with their differences, and the index of the current one.
    pub(super) worst: Vec<([u32; 2], f64)>,
    pub(super) at: usize,
}

impl Inspector {
    /// Whether a pixel is selected.
    pub(crate) fn is_open(&self) -> bool {
        self.pixel.is_some()
    }

    /// The selected pixel.
    pub(crate) fn pixel(&self) -> Option<[u32; 2]> {
        self.pixel
    }

    /// Whether the report is complete.
    pub(crate) fn is_done(&self) -> bool {
        self.report.done
    }

    /// Selects a pixel, or none.
    pub(crate) fn look_at(&mut self, pixel: Option<[u32; 2]>) {
        if self.pixel != pixel {
            self.pixel = pixel;
            self.forget();
        }
    }

    /// Cancels the search and clears the report.
    fn forget(&mut self) {
        (self.search, self.report) = (None, PixelReport::default());
    }

    /// Receives the pictures of a stage.
    pub(crate) fn take(&mut self, frames: &[Frame], size: [u32; 2], stage: Stage) {
        let first = frames.first().cloned();
        match stage {
            Stage::Coarse => (self.pictures, self.worst) = (Pictures::default(), Vec::new()),
            Stage::Scene => self.pictures = Pictures { size, own: first, mean: None, other: frames.get(1).cloned() },
            Stage::Refined(count) | Stage::Converged(count) => {
                self.pictures.size = size;
                self.pictures.mean = first.map(|frame| (frame, count));
                self.pictures.other = frames.get(1).cloned();
                self.worst.clear();
            }
            _ => {}
        }
    }

    /// Starts the search once the scene rests, and receives its results.
    pub(crate) fn follow(&mut self, job: Option<&Job>, notify: &Notify) {
        if let Some(search) = &mut self.search {
            search.poll(&mut self.report);
        }
        let (Some(pixel), Some(job)) = (self.pixel, job) else { return };
        let LoadedScene { scene, library, subject } = &job.variants[0];
        let [width, height] = scene.image.size;
        // A smaller window has fewer pixels.
        let within = [pixel[0].min(width - 1), pixel[1].min(height - 1)];
        let is_same = |search: &Search| search.is_of(pixel, scene, library);
        if within != pixel || self.search.as_ref().is_some_and(|search| !is_same(search)) {
            self.pixel = Some(within);
            self.forget();
        }
        if self.search.is_none() && !job.moving {
            let (library, subject) = (library.clone(), subject.clone());
            self.search = Some(Search::start(within, scene.clone(), library, subject, notify));
        }
    }

    /// Selects the next of the most different pixels: between two compared variants, else between the picture and the
    /// mean. Returns whether there are any.
    pub(crate) fn jump(&mut self) -> bool {
        if self.worst.is_empty() {
            let Pictures { size, own, mean, other } = &self.pictures;
            let first = mean.as_ref().map(|(frame, _)| frame).or(own.as_ref());
            let pair = match (first, other, own, mean) {
                (Some(now), Some(other), ..) => Some((now, other)),
                (_, None, Some(own), Some((mean, _))) => Some((own, mean)),
                _ => None,
            };
            self.worst = pair.map(|(a, b)| worst(a, b, *size, WORST, APART)).unwrap_or_default();
            self.at = 0;
        } else {
            self.at = (self.at + 1) % self.worst.len();
        }
        let next = self.worst.get(self.at).map(|(pixel, _)| *pixel);
        if next.is_some() {
            self.look_at(next);
        }
        next.is_some()
    }
}
