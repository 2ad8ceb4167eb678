//! Settings that the picture does not read, computed in the background once the scene rests.

use crate::background::{Background, Notify};
use crate::worker::{Job, LoadedScene};
use hypertexture::render::unused_settings;
use hypertexture::scene::{Effect, Scene};
use hypertexture::shader::shipped;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::task::Poll;
use std::thread;
use std::time::Duration;

/// Number of cached results.
const CACHED: usize = 32;
/// Interval at which the computation checks whether the scene rests.
const POLL: Duration = Duration::from_millis(20);

/// Unused settings by the shape of a scene.
#[derive(Default)]
pub(crate) struct UnusedSettings {
    /// The most recently used last.
    found: Vec<Found>,
    /// The scene that was asked for last.
    asked: Option<Arc<Scene>>,
    running: Option<(String, Effect, Background<Vec<String>>)>,
    /// Whether the scene moves or has no current picture: the processor belongs to previews.
    paused: Arc<AtomicBool>,
}

struct Found {
    shape: String,
    effect: Effect,
    names: Vec<String>,
}

impl UnusedSettings {
    /// Pauses or resumes the computation.
    pub(crate) fn pause(&self, paused: bool) {
        self.paused.store(paused, Ordering::Relaxed);
    }

    /// Starts the computation for a job, unless its result is cached; cancels the one for another job.
    pub(crate) fn request(&mut self, job: &Job, notify: &Notify) {
        let LoadedScene { scene, library, subject } = &job.variants[0];
        if self.asked.as_ref().is_some_and(|asked| Arc::ptr_eq(asked, scene)) {
            return;
        }
        self.asked = Some(scene.clone());
        let shape = scene.shape();
        if let Some(known) = self.found.iter().position(|found| found.shape == shape) {
            let last = self.found.remove(known);
            return self.found.push(last);
        }
        // Compiling a custom module takes a child process, which this is not worth.
        let is_custom = !scene.modules.is_empty() || **library != shipped();
        if is_custom || self.running.as_ref().is_some_and(|(running, ..)| *running == shape) {
            return;
        }
        let (library, effect) = (library.clone(), scene.effect.clone());
        let (scene, subject, paused) = (scene.clone(), subject.clone(), self.paused.clone());
        let background = Background::start(notify, move |task| {
            let is_cancelled = || {
                while paused.load(Ordering::Relaxed) && !task.is_cancelled() {
                    thread::sleep(POLL);
                }
                task.is_cancelled()
            };
            task.send(unused_settings(&library, &subject, &scene, &is_cancelled));
        });
        self.running = Some((shape, effect, background));
    }

    /// The unused settings of a scene. Until they are known, those of the previous scene if it has the same effect, else
    /// none: a setting in use is never listed.
    pub(crate) fn poll(&mut self, scene: &Scene) -> &[String] {
        if let Some((shape, effect, background)) = self.running.take() {
            match background.poll() {
                Poll::Pending => self.running = Some((shape, effect, background)),
                Poll::Ready(Some(names)) => {
                    self.found.push(Found { shape, effect, names });
                    self.asked = None; // the next request looks for its own result
                    let surplus = self.found.len().saturating_sub(CACHED);
                    self.found.drain(..surplus);
                }
                Poll::Ready(None) => {}
            }
        }
        self.found.last().filter(|found| found.effect == scene.effect).map_or(&[], |found| &found.names)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::background::silent;
    use hypertexture::render::Subject;
    use hypertexture::scene::preset;
    use std::time::Instant;

    fn job(name: &str) -> Job {
        let library = Arc::new(shipped());
        let mut scene = preset(name).unwrap();
        scene.object.input = "cube".into();
        let subject = Arc::new(Subject::load(&scene, &library, &|_| ()).unwrap());
        let variants = vec![LoadedScene { scene: Arc::new(scene), library, subject }];
        Job {
            number: 1,
            variants,
            moving: false,
            max_error: 1e-3,
            focus: [0.5; 2],
            held: false,
            validity: false,
            trace: None,
        }
    }

    fn wait(unused: &mut UnusedSettings, job: &Job) -> Vec<String> {
        let start = Instant::now();
        while unused.running.is_some() {
            assert!(start.elapsed() < Duration::from_secs(600)); // a test that fails ends
            thread::sleep(Duration::from_millis(2));
            unused.poll(&job.variants[0].scene);
        }
        unused.poll(&job.variants[0].scene).to_vec()
    }

    #[test]
    fn what_a_lit_cube_does_not_read_is_known_without_a_picture() {
        let mut unused = UnusedSettings::default();
        let [lit, fire] = ["lit", "fire"].map(job);
        unused.request(&lit, &silent());
        let idle = wait(&mut unused, &lit);
        for name in ["effect.turbulence", "effect.project", "effect.index", "effect.absorption"] {
            assert!(idle.contains(&name.to_string()), "{name}: {idle:?}");
        }
        assert!(!idle.contains(&"light.intensity".to_string()), "{idle:?}");
        // Another effect reads turbulence, also before it is known; the first is known when it is back.
        assert!(unused.poll(&fire.variants[0].scene).is_empty());
        unused.request(&fire, &silent());
        assert!(!wait(&mut unused, &fire).contains(&"effect.turbulence".to_string()));
        unused.request(&lit, &silent());
        assert!(unused.running.is_none());
        assert_eq!(unused.poll(&lit.variants[0].scene), idle);
    }
}
