//! Preparation of a host's next scene, while the host draws something else.

use super::destination::Destination;
use super::prepared::{Prepared, Reusable};
use crate::gpu::Gpu;
use crate::render::camera::FrameContext;
use crate::render::error::RenderError;
use crate::render::variant::Variant;
use crate::shader::Library;
use std::thread::{self, JoinHandle};

/// Preparation of a scene for a host's images, on a thread that submits nothing.
pub(crate) struct BackgroundPrepare {
    frame: FrameContext,
    destination: Destination,
    /// Running until taken.
    thread: Option<JoinHandle<Result<Prepared, RenderError>>>,
}

impl BackgroundPrepare {
    /// Starts the preparation, with reusable parts.
    pub(crate) fn new(
        gpu: Gpu,
        library: Library,
        frame: FrameContext,
        destination: Destination,
        reusable: Reusable,
    ) -> BackgroundPrepare {
        let own = frame.clone();
        let make = move || Prepared::new(&gpu, &library, &own, destination, reusable, &|_| ());
        BackgroundPrepare { frame, destination, thread: Some(thread::spawn(make)) }
    }

    /// Whether the preparation is finished, or has failed.
    pub(crate) fn is_finished(&self) -> bool {
        self.thread.as_ref().is_none_or(JoinHandle::is_finished)
    }

    /// Whether the result serves a scene, of any size.
    pub(crate) fn serves(&self, variant: &Variant, destination: Destination) -> bool {
        let (mut alike, own) = (variant.clone(), &self.frame.variant);
        alike.scene.image.size = own.scene.image.size;
        alike.scene.camera = own.scene.camera.clone();
        self.destination.serves(destination) && alike == **own
    }

    /// Waits for the result.
    pub(crate) fn join(mut self) -> Result<Prepared, RenderError> {
        match self.thread.take().map(JoinHandle::join) {
            Some(Ok(made)) => made,
            Some(Err(reason)) => std::panic::resume_unwind(reason),
            None => Err(RenderError::Stopped),
        }
    }
}

impl Drop for BackgroundPrepare {
    /// Waits for the thread, since the prepared objects must be dropped before the host's device.
    fn drop(&mut self) {
        if let Some(thread) = self.thread.take() {
            let _ = thread.join();
        }
    }
}
