//! Tasks between pictures.

use super::job::{Event, Task, Variant};
use super::render_thread::RenderThread;
use crate::background::{cancel_if, catch_cancellation};
use hypertexture::output::sequence::{Frames, Sequence, frame_path};
use hypertexture::output::{self, Depth, Provenance};
use hypertexture::render::{Frame, RenderError, Renderer};
use hypertexture::scene::Scene;
use measure::compare::Session;
use measure::pick::{ErrorBound, PickError, pick};
use std::path::Path;
use std::sync::atomic::Ordering;

/// Frames per second of a turntable.
const FPS: f64 = 25.0;

impl RenderThread {
    pub(super) fn work(&self, task: Task) -> Result<(), RenderError> {
        let (Task::Write { variant, .. } | Task::Pick { variant, .. }) = &task;
        if !self.admits(&variant.scene, &variant.library) {
            return Ok(());
        }
        match task {
            Task::Write { variant, path, frames, edited } => {
                let count = frames.unwrap_or(1);
                let frames_of = Frames { first: 0, last: count.max(1) - 1 };
                let sequence = Sequence { frames: frames_of, fps: FPS, turntable: true };
                let mut renderer = Renderer::new(&self.gpu, &variant.library, &variant.subject);
                for frame in 0..count {
                    let (scene, to) = match frames {
                        Some(_) => (sequence.scene(&variant.scene, frame), frame_path(&path, frame)),
                        None => (variant.scene.clone(), path.clone()),
                    };
                    if frames.is_some() {
                        if self.stops() {
                            let reason = format!("the turntable was stopped after {frame} of {count} frames");
                            (self.send)(Event::Stopped(reason));
                            return Ok(());
                        }
                        (self.send)(Event::Recorded(frame, count));
                    }
                    if !self.write(&renderer.render(&scene)?, &scene, &edited, &to) {
                        return Ok(());
                    }
                }
                (self.send)(Event::Wrote(path));
            }
            Task::Pick { variant, bound } => self.pick(&variant, bound)?,
        }
        Ok(())
    }

    fn stops(&self) -> bool {
        self.shared.quits() || self.shared.stop.load(Ordering::Relaxed)
    }

    /// Writes a picture with its metadata; returns whether that succeeded.
    fn write(&self, frame: &Frame, scene: &Scene, edited: &[String], path: &Path) -> bool {
        let mut measured = frame.measurements.clone();
        if !edited.is_empty() {
            measured.modules += &format!("; edited in the window: {}", edited.join(", "));
        }
        let written = Provenance::of(scene, &self.gpu.info().title(), &measured)
            .map_err(|error| error.to_string())
            .and_then(|provenance| {
                let background = scene.image.background;
                output::write(frame, background, Depth::Eight, &provenance, path).map_err(|error| error.to_string())
            });
        written.map_err(|reason| (self.send)(Event::Failed(reason))).is_ok()
    }

    fn pick(&self, variant: &Variant, bound: ErrorBound) -> Result<(), RenderError> {
        let Variant { scene, library, subject } = variant;
        let progress = |done: f32| {
            cancel_if(self.stops());
            (self.send)(Event::Picking(done));
        };
        let session = Session { gpu: &self.gpu, library, subject, worker: None, stop: &|| false };
        let found = match catch_cancellation(|| pick(session, scene, bound, &progress)) {
            Some(Ok(found)) => Event::Picked(Some(Box::new(found))),
            Some(Err(PickError::Render(error))) => return Err(error),
            Some(Err(error)) => Event::Failed(error.to_string()),
            None => Event::Picked(None),
        };
        (self.send)(found);
        Ok(())
    }
}
