//! Time budget of pictures during a stroke of the brush.

use super::progressive::{GIVEN_UP_AT, HEADROOM, Level, RECENT_PREVIEWS, medians};
use hypertexture::scene::Scene;

/// Multiple of the budget of previews: a brush may follow the pointer later than the view does.
const STROKE_FACTOR: f64 = 3.0;

/// Time budget of pictures of which only a part is drawn, the one that a stroke changes.
#[derive(Clone, Debug)]
pub(super) struct StrokeBudget {
    /// The budget, milliseconds.
    ms: f64,
    /// Of the last pictures, the newest last: milliseconds per sample on the device, and other milliseconds.
    recent: Vec<[f64; 2]>,
}

impl StrokeBudget {
    /// A budget without measurements, from that of previews.
    pub(super) fn new(preview_ms: f64) -> StrokeBudget {
        StrokeBudget { ms: STROKE_FACTOR * preview_ms, recent: Vec::new() }
    }

    /// The best level that fits for a `share` of the picture; the coarsest if none does.
    pub(super) fn level(&self, scene: &Scene, share: f64) -> Level {
        if self.recent.is_empty() {
            return Level::MIDDLE;
        }
        let [cost, other] = medians(&self.recent);
        let other = other.min(0.5 * HEADROOM * self.ms); // which no level saves
        let fits = |level: &Level| other + cost * level.stroke_work(scene, share) <= HEADROOM * self.ms;
        Level::all().find(fits).unwrap_or(Level::COARSEST)
    }

    /// Predicate whether a picture is aborted after some milliseconds on the device. The coarsest level never is.
    pub(super) fn ends(&self, level: Level) -> impl Fn(f64) -> bool + Send + Sync + 'static {
        let limit = if level == Level::COARSEST { f64::INFINITY } else { GIVEN_UP_AT * self.ms };
        move |ms| ms > limit
    }

    /// Records the time of a picture on the device and elsewhere.
    pub(super) fn took(&mut self, work: f64, device_ms: f64, other_ms: f64) {
        self.recent.push([device_ms / work.max(1.0), other_ms]);
        if self.recent.len() > RECENT_PREVIEWS {
            self.recent.remove(0);
        }
    }

    /// Records that a picture was aborted: a sample takes at least the time until then.
    pub(super) fn gave_up(&mut self, work: f64) {
        self.recent = vec![[GIVEN_UP_AT * self.ms / work.max(1.0), 0.0]];
    }
}

#[cfg(test)]
mod tests {
    use super::super::progressive::Budget;
    use super::*;

    const MS: f64 = 30.0;

    fn scene() -> Scene {
        let mut scene = Scene::default();
        (scene.image.size, scene.light.shadows) = ([900, 720], true);
        (scene.quality.samples, scene.light.shadow_resolution) = (208, 64);
        scene
    }

    /// The level of a stroke on a device on which a sample costs so many milliseconds, after some pictures.
    fn settled(scene: &Scene, cost: f64, share: f64) -> (Level, f64) {
        let mut budget = StrokeBudget::new(MS);
        for _ in 0..12 {
            let level = budget.level(scene, share);
            let work = level.stroke_work(scene, share);
            if budget.ends(level)(cost * work) {
                budget.gave_up(work);
            } else {
                budget.took(work, cost * work, 2.0);
            }
        }
        let level = budget.level(scene, share);
        (level, cost * level.stroke_work(scene, share))
    }

    #[test]
    fn a_small_part_is_drawn_finer_than_a_preview() {
        let scene = scene();
        for cost in [1e-5, 1e-4, 2e-4] {
            let mut previews = Budget::new(MS, true);
            for _ in 0..12 {
                let ms = cost * previews.level().work(&scene);
                if previews.ends()(ms) { previews.gave_up(&scene) } else { previews.took(&scene, ms, 2.0) }
            }
            let width = |level: Level| level.scene(&scene, true).image.size[0];
            let (level, ms) = settled(&scene, cost, 0.04);
            assert!(width(level) >= 3 * width(previews.level()), "{cost}: {level:?} {:?}", previews.level());
            assert!(ms <= STROKE_FACTOR * MS, "{cost}: {ms}");
        }
    }

    #[test]
    fn a_larger_part_is_never_drawn_finer() {
        let scene = scene();
        for cost in [1e-7, 1e-5, 1e-4, 1e-3] {
            let widths = [0.01, 0.1, 1.0].map(|share| settled(&scene, cost, share).0.scene(&scene, true).image.size[0]);
            assert!(widths[0] >= widths[1] && widths[1] >= widths[2], "{cost}: {widths:?}");
        }
    }
}
