//! A renderer that makes programs and images on a thread of its own, where they would keep the hand waiting.

use hypertexture::render::{RenderError, Renderer};
use hypertexture::scene::Scene;
use std::thread::{self, JoinHandle};
use std::time::Duration;

/// While something is made, whether it is still wanted is asked this often.
const LOOK: Duration = Duration::from_millis(5);

/// A renderer that is here, or away on a thread where it makes something.
pub(super) struct Aside {
    here: Option<Renderer>,
    away: Option<JoinHandle<(Renderer, Result<f64, RenderError>)>>,
}

impl Aside {
    pub(super) fn new(renderer: Renderer) -> Aside {
        Aside { here: Some(renderer), away: None }
    }

    /// Whether the renderer is here, and has all that pictures of a scene need.
    pub(super) fn is_ready(&self, scene: &Scene) -> bool {
        self.here.as_ref().is_some_and(|own| own.is_ready(scene))
    }

    /// The renderer, with all that pictures of a scene need; none while that is being made and is `stale` already.
    pub(super) fn ready(
        &mut self,
        scene: &Scene,
        stale: &dyn Fn() -> bool,
    ) -> Result<Option<&mut Renderer>, RenderError> {
        if self.back(stale)?.is_some() && self.here.as_ref().is_some_and(|own| !own.is_prepared(scene)) {
            let scene = scene.clone();
            self.leave(move |renderer| renderer.prepare(&scene, &|_| ()).map(|()| 0.0));
            self.back(stale)?;
        }
        Ok(self.here.as_mut())
    }

    /// What `work` gives with the renderer; none where it goes on and is `stale` already.
    pub(super) fn away(
        &mut self,
        stale: &dyn Fn() -> bool,
        work: impl FnOnce(&mut Renderer) -> Result<f64, RenderError> + Send + 'static,
    ) -> Result<Option<f64>, RenderError> {
        if self.back(stale)?.is_none() {
            return Ok(None);
        }
        self.leave(work);
        self.back(stale)
    }

    fn leave(&mut self, work: impl FnOnce(&mut Renderer) -> Result<f64, RenderError> + Send + 'static) {
        if let Some(mut renderer) = self.here.take() {
            self.away = Some(thread::spawn(move || {
                let done = work(&mut renderer);
                (renderer, done)
            }));
        }
    }

    /// Waits for the renderer, unless that is stale; what it has come back with.
    fn back(&mut self, stale: &dyn Fn() -> bool) -> Result<Option<f64>, RenderError> {
        while self.away.as_ref().is_some_and(|away| !away.is_finished()) {
            if stale() {
                return Ok(None);
            }
            thread::sleep(LOOK);
        }
        match self.away.take().map(JoinHandle::join) {
            None => Ok(self.here.as_ref().map(|_| 0.0)),
            Some(Ok((renderer, done))) => {
                self.here = Some(renderer);
                done.map(Some)
            }
            Some(Err(reason)) => std::panic::resume_unwind(reason),
        }
    }
}

impl Drop for Aside {
    fn drop(&mut self) {
        // What it holds is of a device that goes when this is gone.
        if self.away.take().is_some_and(|away| away.join().is_err()) {
            log::error!("a thread that makes programs has failed");
        }
    }
}
