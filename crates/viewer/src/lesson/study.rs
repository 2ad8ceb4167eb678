//! The ray of a pixel: its samples, and the density along it.

use crate::background::{Background, Notify};
use crate::worker::{LoadedScene, is_same_scene};
use hypertexture::render::{Along, density_along, samples_along};
use hypertexture::scene::Scene;
use std::sync::Arc;
use std::task::Poll;

/// Points on the ray. Lower: corners show in the curves. Higher: the curves follow the pointer later.
const PLACES: usize = 256;

/// The ray of a pixel.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Ray {
    /// Density after all modules; empty where the ray misses the box around the soft region.
    pub(super) density: Vec<Along>,
    /// Density of the soft region alone, at points of its own box; empty for a scene that is invalid without its modules.
    pub(super) soft: Vec<Along>,
    /// Distances of the samples from the origin of the ray, object units.
    pub(super) samples: Vec<f64>,
}

impl Ray {
    /// The density at a distance, linear between two points.
    pub(super) fn at(&self, distance: f64) -> f64 {
        let next = self.density.partition_point(|point| point.depth < distance);
        let (Some(a), Some(b)) = (self.density.get(next.saturating_sub(1)), self.density.get(next)) else { return 0.0 };
        let part = (distance - a.depth) / (b.depth - a.depth).max(1e-12);
        a.density + (b.density - a.density) * part.clamp(0.0, 1.0)
    }

    /// The integral of the density over the ray: by its samples, each of which stands for a step, and by the trapezoids
    /// between all points.
    pub(super) fn integrals(&self) -> [f64; 2] {
        let step = self.samples.windows(2).next().map_or(0.0, |pair| pair[1] - pair[0]);
        let sampled = self.samples.iter().map(|distance| step * self.at(*distance)).sum();
        let trapezoid = |pair: &[Along]| 0.5 * (pair[0].density + pair[1].density) * (pair[1].depth - pair[0].depth);
        [sampled, self.density.windows(2).map(trapezoid).sum()]
    }
}

/// The ray that was found last, and the search for the next one.
#[derive(Default)]
pub(super) struct Study {
    asked: Option<([u32; 2], Arc<Scene>)>,
    running: Option<Background<Result<Ray, String>>>,
    pub(super) found: Option<Result<Ray, String>>,
}

impl Study {
    /// Receives a ray, and starts the search for that of another pixel or scene.
    pub(super) fn follow(&mut self, pixel: [u32; 2], variant: &LoadedScene, notify: &Notify) {
        match self.running.as_ref().map(Background::poll) {
            Some(Poll::Pending) => return,
            Some(Poll::Ready(found)) => (self.running, self.found) = (None, found),
            None => {}
        }
        if self.asked.as_ref().is_some_and(|(of, scene)| *of == pixel && is_same_scene(scene, &variant.scene)) {
            return;
        }
        self.asked = Some((pixel, variant.scene.clone()));
        let variant = variant.clone();
        self.running = Some(Background::start(notify, move |task| task.send(ray(pixel, &variant))));
    }
}

fn ray(pixel: [u32; 2], variant: &LoadedScene) -> Result<Ray, String> {
    let LoadedScene { scene, library, subject } = variant;
    let along = |scene: &Scene| density_along(library, scene, subject, pixel, PLACES);
    let mut plain = Scene::clone(scene);
    // Its soft region is as wide as the modules make it.
    let outer = scene.check(library).ok().and_then(|parameters| parameters.outer_iso());
    plain.object.outer_iso = outer.unwrap_or(plain.object.outer_iso);
    (plain.effect.dmf, plain.effect.warp, plain.parameters) = Default::default();
    let density = along(scene).map_err(|error| error.to_string())?;
    let samples = samples_along(library, &**scene, subject, pixel).map_err(|error| error.to_string())?;
    Ok(Ray { density, soft: along(&plain).unwrap_or_default(), samples })
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture::render::Subject;
    use hypertexture::scene::preset;
    use hypertexture::shader::shipped;

    /// Without its modules, the density along the central ray of a ball is that of its soft region, which falls to 0 outside.
    #[test]
    fn samples_are_equidistant_and_sum_to_the_integral() {
        let mut scene = preset("noisy_sphere").unwrap();
        (scene.quality.samples, scene.image.size) = (512, [101, 101]);
        (scene.effect.dmf, scene.effect.warp, scene.parameters) = Default::default();
        let subject = Arc::new(Subject::load(&scene, &shipped(), &|_| ()).unwrap());
        let found =
            ray([50, 50], &LoadedScene { scene: Arc::new(scene), library: Arc::new(shipped()), subject }).unwrap();
        let steps: Vec<f64> = found.samples.windows(2).map(|pair| pair[1] - pair[0]).collect();
        assert!(steps.len() > 100 && steps.iter().all(|step| (step / steps[0] - 1.0).abs() < 1e-3), "{steps:?}");
        assert_eq!(found.density, found.soft, "nothing modulates it");
        let [sampled, whole] = found.integrals();
        assert!(whole > 0.1 && (sampled / whole - 1.0).abs() < 0.01, "{sampled} {whole}");
        let middle = 0.5 * (found.density[0].depth + found.density[PLACES - 1].depth);
        assert!((found.at(middle) - 1.0).abs() < 1e-6, "the center is opaque");
    }
}
