//! Search for the facts about a pixel.

use crate::background::{Background, Notify};
use crate::worker::is_same_scene;
use hypertexture::render::variant::{Variant, slot_of};
use hypertexture::render::{Along, Subject, density_along};
use hypertexture::scene::Scene;
use hypertexture::shader::Library;
use hypertexture_measure::reference::{TOLERANCE, reference_pixels, truth_of};
use std::sync::Arc;
use std::task::Poll;

/// Number of points on the ray. Lower: looser bounds between them. Higher: a slower plot.
const PLACES: usize = 512;

/// Tolerance of the contribution of a module, of which two digits are shown. Lower: slower.
const SHARE: f64 = 1e-3;

/// The f64 reference of a pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exact {
    /// Premultiplied linear RGBA.
    pub value: [f64; 4],
    /// Estimated error of the worst channel.
    pub error: f64,
    /// Opacity that the samples may have missed.
    pub open: f64,
}

/// Report on a pixel.
#[derive(Clone, Debug, Default)]
pub struct PixelReport {
    /// Matter along the ray of the pixel, in f32 as on the device.
    pub ray: Option<Result<Vec<Along>, String>>,
    /// Color of the pixel in f64, and its error.
    pub exact: Option<Result<Exact, String>>,
    /// Modules of its program by slot; those of additional objects have the object's name as prefix.
    pub modules: Vec<[String; 2]>,
    /// Largest change of a channel without each part of the scene.
    pub shares: Vec<(String, f64)>,
    /// Whether the search has ended.
    pub done: bool,
}

/// A result of the search.
enum Answer {
    Modules(Vec<[String; 2]>),
    Ray(Result<Vec<Along>, String>),
    Exact(Result<Exact, String>),
    Share(String, f64),
}

/// A running search, which is cancelled on drop.
pub(super) struct Search {
    pixel: [u32; 2],
    scene: Arc<Scene>,
    library: Arc<Library>,
    answers: Background<Answer>,
}

impl Search {
    /// Starts a search.
    pub(super) fn start(
        pixel: [u32; 2],
        scene: Arc<Scene>,
        library: Arc<Library>,
        subject: Arc<Subject>,
        notify: &Notify,
    ) -> Search {
        let (own, modules) = (scene.clone(), library.clone());
        let answers = Background::start(notify, move |task| {
            let (tell, stops) = (|answer| task.send(answer), || task.is_cancelled());
            tell(Answer::Modules(modules_of(&own, &modules)));
            if !stops() {
                let ray = density_along(&modules, &*own, &subject, pixel, PLACES);
                tell(Answer::Ray(ray.map_err(|error| error.to_string())));
            }
            if !stops() {
                let found = exact(&modules, &own, &subject, pixel, TOLERANCE, &stops);
                let whole = found.as_ref().ok().map(|exact| exact.value);
                tell(Answer::Exact(found));
                for (name, without) in whole.iter().flat_map(|_| parts(&own, &modules)) {
                    // Parts that need another field, or time out, have no contribution.
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
        scene: Arc<Scene>,
        library: Arc<Library>,
    ) -> (Search, Arc<std::sync::atomic::AtomicBool>) {
        let (answers, cancelled) = Background::endless();
        (Search { pixel, scene, library, answers }, cancelled)
    }

    /// Whether this is the search for a pixel of a scene.
    pub(super) fn is_of(&self, pixel: [u32; 2], scene: &Arc<Scene>, library: &Arc<Library>) -> bool {
        self.pixel == pixel && Arc::ptr_eq(&self.library, library) && is_same_scene(&self.scene, scene)
    }

    /// Cancels the search; its results remain.
    pub(super) fn cancel(&self) {
        self.answers.cancel();
    }

    /// Receives results.
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

/// Copies of the scene, each without one module of its density, or without shadows.
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

/// The modules that affect the density in the program of a scene, by slot.
fn modules_of(scene: &Scene, library: &Library) -> Vec<[String; 2]> {
    let Ok(program) = Variant::of(scene, library) else { return Vec::new() };
    let slots: Vec<&str> =
        scene.effect.modules().iter().map(|(slot, _)| *slot).chain(["object", "dmf", "warp"]).collect();
    let filled = program.slots.iter().filter(|(key, names)| slots.contains(&slot_of(key)) && !names.is_empty());
    filled.map(|(key, names)| [key.clone(), names.join(" + ")]).collect()
}
