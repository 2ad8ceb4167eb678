//! A renderer that compiles programs and bakes images on another thread, where they do not block previews.

use crate::background::{Background, silent};
use hypertexture::render::{RenderError, Renderer};
use hypertexture::scene::Scene;
use hypertexture::shape::Groom;
use std::sync::Arc;
use std::task::Poll;
use std::thread;
use std::time::Duration;

/// Interval at which a wait checks whether its result is stale.
const POLL: Duration = Duration::from_millis(5);

/// A renderer that is either idle or at work on another thread.
pub(super) struct BackgroundRenderer {
    idle: Option<Renderer>,
    busy: Option<Background<(Renderer, Result<f64, RenderError>)>>,
}

impl BackgroundRenderer {
    pub(super) fn new(renderer: Renderer) -> BackgroundRenderer {
        BackgroundRenderer { idle: Some(renderer), busy: None }
    }

    /// Whether the renderer is idle and can render a scene without preparation.
    pub(super) fn is_ready(&self, scene: &Scene) -> bool {
        self.idle.as_ref().is_some_and(|renderer| renderer.is_ready(scene))
    }

    /// The renderer, prepared for a scene with its groom; `None` if it is `stale` before that.
    pub(super) fn prepared(
        &mut self,
        scene: &Scene,
        groom: &Option<Arc<Groom>>,
        stale: &dyn Fn() -> bool,
    ) -> Result<Option<&mut Renderer>, RenderError> {
        self.wait(stale)?;
        self.idle.as_mut().map(|renderer| renderer.paint(groom, false)).transpose()?;
        if self.idle.as_ref().is_some_and(|renderer| !renderer.is_prepared(scene)) {
            let scene = scene.clone();
            self.start(move |renderer| renderer.prepare(&scene, &|_| ()).map(|()| 0.0));
            self.wait(stale)?;
        }
        Ok(self.idle.as_mut())
    }

    /// The result of `work` on the other thread; `None` if it is `stale` before that.
    pub(super) fn run(
        &mut self,
        stale: &dyn Fn() -> bool,
        work: impl FnOnce(&mut Renderer) -> Result<f64, RenderError> + Send + 'static,
    ) -> Result<Option<f64>, RenderError> {
        if self.wait(stale)?.is_none() {
            return Ok(None);
        }
        self.start(work);
        self.wait(stale)
    }

    fn start(&mut self, work: impl FnOnce(&mut Renderer) -> Result<f64, RenderError> + Send + 'static) {
        if let Some(mut renderer) = self.idle.take() {
            self.busy = Some(Background::start(&silent(), move |task| {
                let done = work(&mut renderer);
                task.send((renderer, done));
            }));
        }
    }

    /// Waits until the renderer is idle or the result `stale`; the result of its work.
    fn wait(&mut self, stale: &dyn Fn() -> bool) -> Result<Option<f64>, RenderError> {
        let Some(busy) = &self.busy else { return Ok(self.idle.as_ref().map(|_| 0.0)) };
        let done = loop {
            match busy.poll() {
                Poll::Ready(done) => break done,
                Poll::Pending if stale() => return Ok(None),
                Poll::Pending => thread::sleep(POLL),
            }
        };
        match (done, self.busy.take().map(Background::join)) {
            (Some((renderer, done)), _) => {
                self.idle = Some(renderer);
                done.map(Some)
            }
            (None, Some(Err(reason))) => std::panic::resume_unwind(reason),
            (None, _) => Ok(None),
        }
    }
}

impl Drop for BackgroundRenderer {
    fn drop(&mut self) {
        // The device must outlive the thread.
        if self.busy.take().is_some_and(|busy| busy.join().is_err()) {
            log::error!("a thread that prepares a renderer has panicked");
        }
    }
}
