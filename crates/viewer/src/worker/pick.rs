//! The search for the fastest settings.

use super::job::{Event, LoadedScene};
use super::render_thread::RenderThread;
use crate::background::{cancel_if, catch_cancellation};
use hypertexture::render::RenderError;
use hypertexture_measure::compare::Session;
use hypertexture_measure::pick::{ErrorBound, PickError, pick};
use std::sync::atomic::Ordering;

impl RenderThread {
    pub(super) fn pick(&self, variant: &LoadedScene, bound: ErrorBound) -> Result<(), RenderError> {
        let LoadedScene { scene, library, subject } = variant;
        if !self.admits(scene, library) {
            return Ok(());
        }
        let progress = |done: f32| {
            cancel_if(self.shared.quits() || self.shared.stop.load(Ordering::Relaxed));
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
