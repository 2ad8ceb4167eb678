//! Results of other threads, and the status for the panels.

use super::jobs::Standing;
use super::state::{App, GOOD};
use crate::panels::Status;
use crate::worker::Event;
use crate::worker::{Figures, Stage};

impl App {
    /// Receives results of other threads.
    pub(crate) fn receive(&mut self) {
        if let Err(reason) = self.loader.poll() {
            self.failure.get_or_insert(reason.clone());
            self.fail(reason);
        }
        let Some(worker) = &self.worker else { return };
        // A thread that has panicked is replaced like a lost device: once.
        self.lost |= worker.has_ended();
        let events: Vec<Event> = worker.events.try_iter().collect();
        for event in events {
            match event {
                Event::Picture(picture) => {
                    self.inspector.take(&picture.frames, picture.size, picture.stage);
                    self.screen.take(picture.images, picture.frames, picture.size);
                    (self.jobs.shown_view, self.jobs.fresh) = (picture.pose, true);
                    let figures = &mut self.figures;
                    (figures.stage, figures.size, figures.samples) = (picture.stage, picture.size, picture.samples);
                    (figures.gpu_ms, figures.difference) = (picture.gpu_ms, picture.difference);
                    figures.done = picture.done;
                    (figures.error, figures.standard_error) = (picture.error, picture.standard_error);
                    (figures.validity, figures.costs) = (picture.validity, picture.costs);
                    if picture.stage == Stage::Coarse {
                        figures.ignored.clear();
                        figures.recent_ms.push(picture.gpu_ms);
                        let surplus = figures.recent_ms.len().saturating_sub(120);
                        figures.recent_ms.drain(..surplus);
                    }
                    self.jobs.on_screen = picture.number;
                    // Errors of an earlier scene no longer apply.
                    self.message.take_if(|said| said.is_error && picture.number > self.message_job);
                }
                Event::Made(lines) => self.figures.made = lines,
                Event::Ignored(ignored) => self.figures.ignored = ignored,
                Event::Picking(done) => self.figures.picking = Some(done),
                Event::Picked(pick) => {
                    self.figures.picking = None;
                    if let Some(pick) = pick {
                        self.take(&pick);
                    }
                }
                Event::Refused(reason) => {
                    self.failure.get_or_insert(reason.clone());
                    self.figures.picking = None;
                    self.fail(reason);
                }
                Event::Failed(reason) => {
                    if self.figures.picking.take().is_some() {
                        self.failure.get_or_insert(reason.clone());
                    }
                    self.fail(reason);
                }
                Event::Lost => self.lost = true,
            }
        }
    }

    /// Contents of the picture while an object of the scene is not loaded, in words.
    fn standing_words(&self) -> String {
        let name = &self.document.model.scene().object.input;
        match (self.jobs.standing, self.loader.progress()) {
            (Standing::Coarser, Some(_)) => "preview: a finer field is being computed".into(),
            (Standing::Before, Some(loading)) => format!("preview of the previous object: {} is loading", loading.name),
            (Standing::Nothing, Some(loading)) => format!("{} is loading", loading.name),
            (Standing::Coarser, None) => "preview: the field of the scene was not computed".into(),
            (Standing::Before, None) => format!("preview of the previous object: {name} is not loaded"),
            (Standing::Nothing, None) => format!("no picture: {name} is not loaded"),
        }
    }

    pub(super) fn status(&mut self) -> Status {
        let Figures { error, standard_error, size, samples, .. } = &self.figures;
        let recording = self.document.exports.frames();
        let recent = &self.figures.recent_ms;
        let mean = recent.iter().sum::<f64>() / recent.len().max(1) as f64;
        let variance = recent.iter().map(|ms| (ms - mean).powi(2)).sum::<f64>() / recent.len().max(1) as f64;
        // Only previews are frequent enough for a standard deviation.
        let spread = if self.figures.stage == Stage::Coarse { variance.sqrt() } else { 0.0 };
        Status {
            frame_ms: (!recent.is_empty() && self.figures.gpu_ms > 0.0).then_some([self.figures.gpu_ms, spread]),
            error: error.map(|error| [error, standard_error.unwrap_or(error)]),
            picture: if self.jobs.lacks_object {
                self.standing_words()
            } else if self.lesson.is_held() && self.figures.stage == Stage::Scene {
                "\u{1f4cc} as drawn".into()
            } else {
                self.figures.words(self.max_error.unwrap_or(GOOD))
            },
            detail: format!("{} x {} pixels, {samples} samples", size[0], size[1]),
            device: self.figures.device.clone(),
            message: self.message.clone(),
            ignored: self.figures.ignored.clone(),
            idle: self.unused_settings.poll(self.document.model.scene()).to_vec(),
            window: self.jobs.submitted.as_ref().map_or([0, 0], |job| job.variants[0].scene.image.size),
            made: self.figures.made.clone(),
            progress: self.figures.picking.or(recording.map(|(done, all)| done as f32 / all.max(1) as f32)),
            recent_ms: recent.clone(),
            budget_ms: self.figures.budget_ms,
            paused: self.time.clock.is_none(),
            recording: recording.is_some(),
            split: self.comparison.pinned.is_some(),
            max_error: self.max_error,
            validity: self.validity,
            densities: self.densities.poll(),
            time: self.time.clock,
            playback: self.time.playback,
            lesson: self.lesson.is_open,
            level: self.navigation.level,
            states: self.states(),
        }
    }
}
