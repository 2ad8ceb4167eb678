//! One frame of the window.

use super::state::App;
use crate::input::Command;
use crate::input::keys;
use crate::worker::Stage;
use egui::{Sense, Ui};
use std::path::PathBuf;
use std::time::{Duration, Instant};

/// Time that the window waits for a preview while the scene moves, before it is drawn with the old picture reprojected: a
/// CPU device draws both, one after the other.
pub(super) const MAX_PREVIEW_WAIT: Duration = Duration::from_millis(45);

impl App {
    /// Remaining time to wait for a preview before the window is drawn; `None` to draw it now.
    pub(crate) fn wait_for_preview(&mut self, now: Instant) -> Option<Duration> {
        let is_coming = self.jobs.on_screen < self.jobs.number && self.figures.stage == Stage::Coarse;
        let soon = self.figures.is_cpu && is_coming && self.jobs.submitted.as_ref().is_some_and(|job| job.moving);
        let left = MAX_PREVIEW_WAIT.saturating_sub(now.duration_since(*self.jobs.waiting_since.get_or_insert(now)));
        if soon && !self.jobs.fresh && !left.is_zero() {
            return Some(left);
        }
        self.jobs.waiting_since = None;
        None
    }

    /// Notes that the window was drawn.
    pub(crate) fn drawn(&mut self) {
        self.jobs.fresh = false;
        if let Some(worker) = &self.worker {
            worker.shown(self.jobs.on_screen);
        }
    }

    /// Lays out one frame: the panels, the picture and its overlays.
    pub(crate) fn ui(&mut self, ui: &mut Ui) {
        let now = Instant::now();
        let passed = now.duration_since(self.time.last_frame).as_secs_f64();
        self.time.last_frame = now;
        let before = self.document.model.shared_scene().clone();
        if !self.panels.is_asking() {
            self.type_number(ui.ctx());
            keys::pressed(ui.ctx()).into_iter().for_each(|command| self.perform(command));
        }
        self.document.model.follow(self.time.clock);
        self.receive_selection();
        let status = self.status();
        let commands = self.panels.show(ui, &mut self.document, &status);
        if let Some(error) = self.document.exports.outcome().filter(|outcome| outcome.is_error) {
            self.failure.get_or_insert_with(|| error.text.clone());
        }
        for command in commands {
            self.perform(command);
        }
        let dropped: Vec<PathBuf> =
            ui.ctx().input(|input| input.raw.dropped_files.iter().map(|file| file.path().to_path_buf()).collect());
        for path in dropped {
            self.perform(Command::Open(path));
        }
        self.place = ui.available_rect_before_wrap();
        let response = ui.allocate_rect(self.place, Sense::click_and_drag());
        self.navigate(ui, &response);
        self.hold_frame(&before);
        self.glide(passed);
        if let Some(clock) = &mut self.time.clock {
            *clock = self.time.playback.after(*clock, passed);
            self.time.playback.reach(*clock);
        }
        self.submit(ui, now);
        self.screen.moved = self.jobs.shown_view.zip(self.jobs.current_view).filter(|(seen, now)| seen != now);
        self.screen.draw(ui, self.place, &self.comparison.view);
        self.show_over(ui);
        self.pick(ui, now);
        keys::note_writing(ui.ctx());
    }
}
