//! How much of the object has which density, found beside the window.

use super::worker::{Job, Variant};
use hypertexture::render::densities;
use hypertexture::scene::{Camera, Light, Quality, Scene};
use std::sync::{Arc, mpsc};
use std::thread;

/// Points that are looked at. Fewer: bars are noisy. More: they come late.
const POINTS: u32 = 1 << 15;
/// Bars.
const BARS: usize = 64;

/// What was found for the scene that was looked at last.
#[derive(Default)]
pub(super) struct Densities {
    of: Option<Scene>,
    coming: Option<mpsc::Receiver<Option<Vec<u32>>>>,
    found: Option<Arc<[u32]>>,
}

impl Densities {
    /// Begins to look at what a job shows, unless that is known or something is being looked at.
    pub(super) fn want(&mut self, job: &Job, notify: impl Fn() + Send + 'static) {
        let Variant { scene, library, subject } = job.variants[0].clone();
        let content = content(&scene);
        if self.coming.is_some() || self.of.as_ref() == Some(&content) {
            return;
        }
        let (sender, coming) = mpsc::channel();
        (self.of, self.coming) = (Some(content), Some(coming));
        thread::spawn(move || {
            let found = densities(&library, &scene, &subject, POINTS, BARS);
            // Nobody listens any more when the window is closed.
            let _ = sender.send(found.map_err(|error| log::info!("densities: {error}")).ok());
            notify();
        });
    }

    /// What is known by now; what is of the scene before stays until then.
    pub(super) fn poll(&mut self) -> Option<Arc<[u32]>> {
        match self.coming.as_ref().map(mpsc::Receiver::try_recv) {
            None | Some(Err(mpsc::TryRecvError::Empty)) => {}
            Some(Ok(found)) => (self.coming, self.found) = (None, found.map(Arc::from)),
            Some(Err(mpsc::TryRecvError::Disconnected)) => (self.coming, self.found) = (None, None),
        }
        self.found.clone()
    }
}

/// What of a scene decides its densities.
fn content(scene: &Scene) -> Scene {
    let camera = Camera { time: scene.camera.time, ..Camera::default() };
    Scene { camera, light: Light::default(), quality: Quality::default(), ..scene.clone() }
}
