//! Which settings a picture does not read, found beside the window as soon as a scene stands still.

use super::worker::{Job, Variant};
use hypertexture::render::unused_settings;
use hypertexture::scene::{Effect, Scene};
use hypertexture::shader::shipped;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use std::thread;
use std::time::Duration;

/// Shapes of scenes that are remembered.
const KEPT: usize = 32;
/// Bytes of the stack of the thread that looks: programs are walked deeply.
const STACK: usize = 16 << 20;

/// While the scene moves, whether it rests is asked this often.
const LOOK: Duration = Duration::from_millis(20);

/// What was found, by the shape of the scene, the last one last.
#[derive(Default)]
pub(super) struct Unread {
    found: Vec<Found>,
    coming: Option<Coming>,
    /// Whether the scene moves or is to be seen yet: previews have the processor for themselves.
    moves: Arc<AtomicBool>,
}

struct Found {
    shape: String,
    effect: Effect,
    idle: Vec<String>,
}

struct Coming {
    shape: String,
    effect: Effect,
    is_over: Arc<AtomicBool>,
    idle: mpsc::Receiver<Vec<String>>,
}

impl Drop for Coming {
    fn drop(&mut self) {
        self.is_over.store(true, Ordering::Relaxed);
    }
}

impl Unread {
    /// Whether the scene moves by now, or is to be seen yet.
    pub(super) fn moves(&self, moves: bool) {
        self.moves.store(moves, Ordering::Relaxed);
    }

    /// Begins to look at what a job shows, unless that is known, in place of what was looked at.
    pub(super) fn want(&mut self, job: &Job, notify: impl Fn() + Send + 'static) {
        let Variant { scene, library, subject } = &job.variants[0];
        let shape = scene.shape();
        if let Some(known) = self.found.iter().position(|found| found.shape == shape) {
            let last = self.found.remove(known);
            return self.found.push(last);
        }
        // A custom module is compiled in a process of its own, and never for this.
        let is_own = !scene.modules.is_empty() || **library != shipped();
        if is_own || self.coming.as_ref().is_some_and(|coming| coming.shape == shape) {
            return;
        }
        let (sender, idle_of) = mpsc::channel();
        let is_over = Arc::new(AtomicBool::new(false));
        self.coming = Some(Coming { shape, effect: scene.effect.clone(), is_over: is_over.clone(), idle: idle_of });
        let (library, scene, subject) = (library.clone(), scene.clone(), subject.clone());
        let moves = self.moves.clone();
        let is_over = move || {
            while moves.load(Ordering::Relaxed) && !is_over.load(Ordering::Relaxed) {
                thread::sleep(LOOK);
            }
            is_over.load(Ordering::Relaxed)
        };
        let look = move || {
            // Nobody listens where another scene is looked at by now.
            let _ = sender.send(unused_settings(&library, &subject, &scene, &is_over));
            notify();
        };
        if let Err(error) = thread::Builder::new().stack_size(STACK).spawn(look) {
            log::info!("what the picture does not read is not looked for: {error}");
        }
    }

    /// What is known by now of a scene, or until then of the one before it, where that has the same effect. Nothing is known
    /// of another effect: what it reads is never missing.
    pub(super) fn poll(&mut self, scene: &Scene) -> &[String] {
        match self.coming.as_ref().map(|coming| coming.idle.try_recv()) {
            None | Some(Err(mpsc::TryRecvError::Empty)) => {}
            Some(found) => {
                if let (Some(coming), Ok(idle)) = (self.coming.take(), found) {
                    self.found.push(Found { shape: coming.shape.clone(), effect: coming.effect.clone(), idle });
                    let surplus = self.found.len().saturating_sub(KEPT);
                    self.found.drain(..surplus);
                }
            }
        }
        self.found.last().filter(|found| found.effect == scene.effect).map_or(&[], |found| &found.idle)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture::render::Subject;
    use hypertexture::scene::preset;
    use std::time::Instant;

    fn job(name: &str) -> Job {
        let library = Arc::new(shipped());
        let mut scene = preset(name).unwrap();
        scene.object.input = "cube".into();
        let subject = Arc::new(Subject::load(&scene, &library, &|_| ()).unwrap());
        let variants = vec![Variant { scene, library, subject }];
        Job { number: 1, variants, moving: false, max_error: 1e-3, focus: [0.5; 2], validity: false }
    }

    fn wait(unread: &mut Unread, job: &Job) -> Vec<String> {
        let start = Instant::now();
        while unread.coming.is_some() {
            assert!(start.elapsed() < Duration::from_secs(600)); // a test that fails ends
            thread::sleep(Duration::from_millis(2));
            unread.poll(&job.variants[0].scene);
        }
        unread.poll(&job.variants[0].scene).to_vec()
    }

    #[test]
    fn what_a_lit_cube_does_not_read_is_known_without_a_picture() {
        let mut unread = Unread::default();
        let [lit, fire] = ["lit", "fire"].map(job);
        unread.want(&lit, || ());
        let idle = wait(&mut unread, &lit);
        for name in ["effect.turbulence", "effect.project", "effect.index", "effect.absorption"] {
            assert!(idle.contains(&name.to_string()), "{name}: {idle:?}");
        }
        assert!(!idle.contains(&"light.intensity".to_string()), "{idle:?}");
        // Another effect reads turbulence, also before it is known; the first is known when it is back.
        assert!(unread.poll(&fire.variants[0].scene).is_empty());
        unread.want(&fire, || ());
        assert!(!wait(&mut unread, &fire).contains(&"effect.turbulence".to_string()));
        unread.want(&lit, || ());
        assert!(unread.coming.is_none());
        assert_eq!(unread.poll(&lit.variants[0].scene), idle);
    }
}
