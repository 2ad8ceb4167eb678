//! Histogram of the densities of an object, computed in the background.

use crate::background::{Background, Notify};
use crate::worker::{Job, LoadedScene};
use hypertexture::render::densities;
use hypertexture::scene::{Camera, Light, Quality, Scene};
use std::sync::Arc;
use std::task::Poll;

/// Sampled points. Lower: noisy bars. Higher: a slow histogram.
const POINTS: u32 = 1 << 15;
/// Number of bars.
const BARS: usize = 64;

/// The histogram of the last scene that was asked for.
#[derive(Default)]
pub(crate) struct Densities {
    /// The scene that was asked for last, and its content.
    asked: Option<Arc<Scene>>,
    content: Option<Scene>,
    running: Option<Background<Option<Vec<u32>>>>,
    histogram: Option<Arc<[u32]>>,
}

impl Densities {
    /// Starts the histogram of a job, unless it is known or another one is being computed.
    pub(crate) fn request(&mut self, job: &Job, notify: &Notify) {
        let LoadedScene { scene, library, subject } = &job.variants[0];
        if self.running.is_some() || self.asked.as_ref().is_some_and(|asked| Arc::ptr_eq(asked, scene)) {
            return;
        }
        self.asked = Some(scene.clone());
        let content = content(scene);
        if self.content.as_ref() == Some(&content) {
            return;
        }
        self.content = Some(content);
        let (scene, library, subject) = (scene.clone(), library.clone(), subject.clone());
        self.running = Some(Background::start(notify, move |task| {
            let found = densities(&library, &*scene, &subject, POINTS, BARS);
            task.send(found.map_err(|error| log::info!("densities: {error}")).ok());
        }));
    }

    /// The newest histogram.
    pub(crate) fn poll(&mut self) -> Option<Arc<[u32]>> {
        if let Some(Poll::Ready(found)) = self.running.as_ref().map(Background::poll) {
            (self.running, self.histogram) = (None, found.flatten().map(Arc::from));
        }
        self.histogram.clone()
    }
}

/// The scene with defaults for everything that does not affect densities.
fn content(scene: &Scene) -> Scene {
    let camera = Camera { time: scene.camera.time, ..Camera::default() };
    Scene { camera, light: Light::default(), quality: Quality::default(), ..scene.clone() }
}
