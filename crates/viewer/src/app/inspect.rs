//! The inspected pixel.

use super::state::App;
use egui::{Pos2, Ui};

impl App {
    /// Width and height of the picture, pixels.
    fn pixels(&self) -> Option<[u32; 2]> {
        Some(self.jobs.submitted.as_ref()?.variants.first()?.scene.image.size)
    }

    /// The pixel at a position of the window.
    pub(super) fn pixel_at(&self, at: Pos2) -> Option<[u32; 2]> {
        let size = self.pixels()?;
        let part = (at - self.place.min) / self.place.size();
        let index = |axis: usize| ((part[axis].max(0.0) * size[axis] as f32) as u32).min(size[axis] - 1);
        self.place.contains(at).then(|| [index(0), index(1)])
    }

    /// Moves the inspector to the clicked pixel.
    pub(super) fn inspect_clicked(&mut self, at: Option<Pos2>) {
        if let Some(pixel) = at.and_then(|at| self.pixel_at(at)) {
            self.inspector.look_at(Some(pixel));
        }
    }

    /// Inspects the pixel under the pointer, or the central one; closes an open inspector.
    pub(super) fn inspect_under_pointer(&mut self) {
        let pointer = self.navigation.pointer.and_then(|at| self.pixel_at(at));
        let pixel = pointer.or_else(|| self.pixel_at(self.place.center()));
        self.inspector.look_at(pixel.filter(|_| !self.inspector.is_open()));
    }

    /// Inspects the next of the most different pixels.
    pub(super) fn jump_to_worst(&mut self) {
        if !self.inspector.jump() {
            self.note("the most different pixels are known once the picture has been refined");
        }
    }

    /// Shows the lesson, about the ray under the pointer, or else of the inspected or the central pixel.
    pub(super) fn teach(&mut self, ui: &Ui) {
        let pointer = self.navigation.pointer.and_then(|at| self.pixel_at(at));
        let pixel = pointer.or(self.inspector.pixel()).or_else(|| self.pixel_at(self.place.center()));
        let job = self.jobs.submitted.as_ref().and_then(|job| Some((job, pixel?)));
        self.lesson.show(ui, self.place, &mut self.document.model, job, &self.notify);
    }

    /// Shows the inspector.
    pub(super) fn inspect(&mut self, ui: &Ui) {
        let job = self.jobs.submitted.as_ref().filter(|_| self.loader.progress().is_none());
        self.inspector.follow(job, &self.notify);
        if let Some(size) = self.pixels() {
            self.inspector.show(ui, self.place, size);
        }
    }
}
