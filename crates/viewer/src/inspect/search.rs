//! What is found of a pixel, on a thread of its own.

use crate::background::{Background, Notify};
use hypertexture::render::variant::Variant as Program;
use hypertexture::render::{Along, Subject, density_along};
use hypertexture::scene::Scene;
use hypertexture::shader::Library;
use measure::reference::{TOLERANCE, reference_pixels, truth_of};
use std::sync::Arc;
use std::task::Poll;

/// Places along the ray. Fewer: bounds between them say less. More: the plot comes later.
const PLACES: usize = 512;

/// The error that the share of a module may have. Smaller: it comes later, and two digits are shown.
const SHARE: f64 = 1e-3;

/// The value of a pixel in f64.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exact {
    /// Premultiplied linear RGBA.
    pub value: [f64; 4],
    /// How far off its worst channel may be, as far as samples say.
    pub error: f64,
    /// The most opacity that samples may have overlooked.
    pub open: f64,
}

/// What is known of a pixel.
#[derive(Clone, Debug, Default)]
pub struct PixelReport {
    /// The density along its ray.
    pub ray: Option<Result<Vec<Along>, String>>,
    /// Its reference.
    pub exact: Option<Result<Exact, String>>,
    /// The modules of its program by slot, those of further objects behind the name of the object.
    pub modules: Vec<[String; 2]>,
    /// What of the scene was left out, and how far the pixel of what is left is from it: the largest difference of a
    /// channel.
    pub shares: Vec<(String, f64)>,
    /// Whether nothing more comes.
    pub done: bool,
}

/// One answer.
enum Answer {
    Modules(Vec<[String; 2]>),
    Ray(Result<Vec<Along>, String>),
    Exact(Result<Exact, String>),
    Share(String, f64),
}

/// What is being looked for; it is given up with this.
pub(super) struct Search {
    pixel: [u32; 2],
    scene: Scene,
    library: Arc<Library>,
    answers: Background<Answer>,
}

impl Search {
    /// Begins. `notify` is called from the other thread for each answer.
    pub(super) fn start(
        pixel: [u32; 2],
        scene: Scene,
        library: Arc<Library>,
        subject: Arc<Subject>,
        notify: &Notify,
    ) -> Search {
        let (own, modules) = (scene.clone(), library.clone());
        let answers = Background::start(notify, move |task| {
            let (tell, stops) = (|answer| task.send(answer), || task.is_cancelled());
            tell(Answer::Modules(modules_of(&own, &modules)));
            if !stops() {
                let ray = density_along(&modules, &own, &subject, pixel, PLACES);
                tell(Answer::Ray(ray.map_err(|error| error.to_string())));
            }
            if !stops() {
                let found = exact(&modules, &own, &subject, pixel, TOLERANCE, &stops);
                let whole = found.as_ref().ok().map(|exact| exact.value);
                tell(Answer::Exact(found));
                for (name, without) in whole.iter().flat_map(|_| parts(&own, &modules)) {
                    // What needs another field, or more than its time, has no share.
                    let found = exact(&modules, &without, &subject, pixel, SHARE, &stops);
                    if let (Some(whole), Ok(Exact { value, .. })) = (whole, found) {
                        let apart = [0, 1, 2, 3].map(|channel| (whole[channel] - value[channel]).abs());
                        tell(Answer::Share(name, apart.into_iter().fold(0.0, f64::max)));
                    }
                }
            }
        });
        Search { pixel, scene, library, answers }
    }

    /// A search that ends only by cancellation, and its cancel flag.
    #[cfg(test)]
    pub(super) fn endless(
        pixel: [u32; 2],
        scene: Scene,
        library: Arc<Library>,
    ) -> (Search, Arc<std::sync::atomic::AtomicBool>) {
        let (answers, cancelled) = Background::endless();
        (Search { pixel, scene, library, answers }, cancelled)
    }

    /// Whether this is what is found of the pixel of a scene.
    pub(super) fn is_of(&self, pixel: [u32; 2], scene: &Scene, library: &Arc<Library>) -> bool {
        self.pixel == pixel && Arc::ptr_eq(&self.library, library) && self.scene == *scene
    }

    /// Gives up; what was found stays.
    pub(super) fn cancel(&self) {
        self.answers.cancel();
    }

    /// Takes what was found.
    pub(super) fn poll(&mut self, report: &mut PixelReport) {
        loop {
            match self.answers.poll() {
                Poll::Ready(Some(Answer::Modules(modules))) => report.modules = modules,
                Poll::Ready(Some(Answer::Ray(ray))) => report.ray = Some(ray),
                Poll::Ready(Some(Answer::Exact(exact))) => report.exact = Some(exact),
                Poll::Ready(Some(Answer::Share(name, by))) => report.shares.push((name, by)),
                Poll::Pending => return,
                Poll::Ready(None) => {
                    report.done = true;
                    return;
                }
            }
        }
    }
}

/// The reference of one pixel.
fn exact(
    library: &Library,
    scene: &Scene,
    subject: &Subject,
    pixel: [u32; 2],
    tolerance: f64,
    stop: &(dyn Fn() -> bool + Sync),
) -> Result<Exact, String> {
    let truth = truth_of(scene, library).map_err(|error| error.to_string())?;
    let found = reference_pixels(library, &truth, subject, &[pixel], tolerance, &|_| (), stop);
    let found = found.map_err(|error| error.to_string())?;
    Ok(Exact { value: found.pixels[0], error: found.estimate[0], open: found.open[0] })
}

/// The scene without each module that its matter has one after another, and without its shadows.
fn parts(scene: &Scene, library: &Library) -> Vec<(String, Scene)> {
    let without = |name: &str, change: &dyn Fn(&mut Scene)| {
        let mut less = scene.clone();
        change(&mut less);
        less.check(library).ok().map(|_| (name.to_string(), less))
    };
    let dmf = scene.effect.dmf.iter().enumerate();
    let warp = scene.effect.warp.iter().enumerate();
    let dmf = dmf.map(|(index, name)| without(name, &|less| drop(less.effect.dmf.remove(index))));
    let warp = warp.map(|(index, name)| without(name, &|less| drop(less.effect.warp.remove(index))));
    let shadows = scene.light.shadows.then(|| without("shadows", &|less| less.light.shadows = false));
    dmf.chain(warp).chain(shadows).flatten().collect()
}

/// The modules that the program of a scene reads for its matter, by slot.
fn modules_of(scene: &Scene, library: &Library) -> Vec<[String; 2]> {
    let Ok(program) = Program::of(scene, library) else { return Vec::new() };
    let slots: Vec<&str> =
        scene.effect.modules().iter().map(|(slot, _)| *slot).chain(["object", "dmf", "warp"]).collect();
    let is_matter = |key: &str| slots.contains(&key.rsplit('.').next().unwrap_or_default());
    let key = program.key();
    let filled = key.split(' ').filter_map(|filled| filled.split_once('='));
    let filled = filled.filter(|(slot, names)| is_matter(slot) && !names.is_empty());
    filled.map(|(slot, names)| [slot.to_string(), names.replace('+', " + ")]).collect()
}
