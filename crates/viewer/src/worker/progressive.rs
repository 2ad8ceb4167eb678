//! Progressive refinement: levels of previews within a time budget, the order of tiles, and sub-frames.

use hypertexture::gpu::Area;
use hypertexture::scene::{Jitter, RayPath, Scene, TargetFormat};

/// Levels of previews, from the best: side of a pixel in quarters of one, and divisor of the samples.
const LEVELS: [[u32; 2]; 20] = [
    [4, 1],
    [4, 2],
    [5, 2],
    [6, 2],
    [8, 2],
    [10, 2],
    [12, 2],
    [16, 2],
    [16, 3],
    [20, 3],
    [20, 4],
    [24, 4],
    [32, 4],
    [40, 4],
    [48, 4],
    [64, 4],
    [80, 5],
    [96, 5],
    [96, 6],
    [96, 8],
];
/// Largest predicted fraction of the budget for a better level. Nearer to 1: noise in the times changes the level.
pub(super) const HEADROOM: f64 = 0.7;
/// Largest fraction of the budget for time outside of the device, which no level can save.
const MAX_OVERHEAD: f64 = 0.3;
/// Multiple of the budget after which a preview is aborted for a coarser one.
pub(crate) const GIVEN_UP_AT: f64 = 2.0;
/// Minimum of samples. Lower: slices become visible.
const MIN_SAMPLES: u32 = 32;
/// Maximum of texels along a side of the noise blocks of previews. Higher: seconds to bake.
pub(crate) const PREVIEW_BLOCK: u32 = 64;
/// Maximum of rays along a side of the shadow volume during a stroke, of which each touch draws it anew.
const STROKE_RAYS: u32 = 16;
/// Minimum of rays along a side of the shadow volume of previews.
const MIN_RAYS: u32 = 8;
/// Number of recent previews, whose median predicts the next one: a single pause of the machine changes no level.
pub(super) const RECENT_PREVIEWS: usize = 3;
/// Pixels along a side of a refinement tile: the tile size of lavapipe's threads.
const TILE: u32 = 64;
/// Maximum of sub-frames in a mean: the limit of `quality.supersampling`.
pub(crate) const MAX_SUB_FRAMES: u32 = 256;
/// Minimum of sub-frames in a mean. Lower: noisier than the scene's own picture.
pub(crate) const MIN_SUB_FRAMES: u32 = 4;

/// Level of a preview.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Level(usize);

impl Level {
    /// The coarsest level.
    pub(super) const COARSEST: Level = Level(LEVELS.len() - 1);
    /// A level for a device that is not known yet.
    pub(super) const MIDDLE: Level = Level(8);

    /// All levels, from the best.
    pub(super) fn all() -> impl Iterator<Item = Level> {
        (0..LEVELS.len()).map(Level)
    }

    /// Whether this is the level of the scene's own pixels and samples.
    pub(super) fn is_finest(self) -> bool {
        self.0 == 0
    }

    /// The scene with fewer pixels and samples, a coarser shadow volume, and smaller noise blocks unless its own are
    /// baked.
    pub(crate) fn scene(self, scene: &Scene, has_blocks: bool) -> Scene {
        let [side, samples] = LEVELS[self.0];
        let mut coarse = scene.clone();
        coarse.image.size = scene.image.size.map(|own| (4 * own).div_ceil(side));
        coarse.light.shadow_resolution = self.rays(scene);
        let quality = &mut coarse.quality;
        quality.samples = (quality.samples / samples).max(MIN_SAMPLES).min(quality.samples);
        (quality.msaa, quality.supersampling, coarse.camera.shutter) = (1, 1, 0.0);
        if !has_blocks && quality.block_size > PREVIEW_BLOCK {
            quality.block_size = PREVIEW_BLOCK;
            quality.turbulence_cells = quality.turbulence_cells.min(PREVIEW_BLOCK / 2);
        }
        coarse
    }

    /// Rays along a side of the shadow volume, halved repeatedly: lavapipe compiles a program again when the sides of
    /// an image change between powers of two and others.
    fn rays(self, scene: &Scene) -> u32 {
        let (own, side) = (scene.light.shadow_resolution, LEVELS[self.0][0]);
        let halves = (1..).map(|times| own >> times).take_while(|rays| *rays >= MIN_RAYS);
        halves.take_while(|rays| rays * side >= 6 * own).last().unwrap_or(own)
    }

    /// The scene of a picture during a stroke, with few rays of shadows.
    pub(super) fn stroke_scene(self, scene: &Scene, has_blocks: bool) -> Scene {
        let mut coarse = self.scene(scene, has_blocks);
        while coarse.light.shadow_resolution > STROKE_RAYS {
            coarse.light.shadow_resolution /= 2;
        }
        coarse
    }

    /// Number of samples, including those of shadows.
    pub(super) fn work(self, scene: &Scene) -> f64 {
        samples(&self.scene(scene, true), 1.0)
    }

    /// Number of samples during a stroke that changes a `share` of the picture.
    pub(super) fn stroke_work(self, scene: &Scene, share: f64) -> f64 {
        samples(&self.stroke_scene(scene, true), share)
    }
}

/// Number of samples of a share of a picture, including those of its shadows.
fn samples(scene: &Scene, share: f64) -> f64 {
    let [width, height] = scene.image.size.map(f64::from);
    let rays = if scene.light.shadows { f64::from(scene.light.shadow_resolution).powi(2) } else { 0.0 };
    (share * width * height + rays) * f64::from(scene.quality.samples)
}

/// Medians of the costs of a sample and of the other times.
pub(super) fn medians(recent: &[[f64; 2]]) -> [f64; 2] {
    [0, 1].map(|of| {
        let mut sorted: Vec<f64> = recent.iter().map(|own| own[of]).collect();
        sorted.sort_by(f64::total_cmp);
        sorted[sorted.len() / 2]
    })
}

/// Time budget of previews, and their level.
#[derive(Clone, Debug)]
pub(crate) struct Budget {
    level: Level,
    /// The budget, milliseconds.
    ms: f64,
    /// Of the last previews, the newest last: milliseconds per sample on the device, and other milliseconds.
    recent: Vec<[f64; 2]>,
}

impl Budget {
    /// A budget without measurements.
    pub(crate) fn new(ms: f64, cpu: bool) -> Budget {
        Budget { level: Level(if cpu { 8 } else { 4 }), ms, recent: Vec::new() }
    }

    /// Level of the next preview.
    pub(crate) fn level(&self) -> Level {
        self.level
    }

    /// Predicate whether a preview is aborted after some milliseconds on the device. The coarsest level never is.
    pub(crate) fn ends(&self) -> impl Fn(f64) -> bool + Send + Sync + 'static {
        let limit = if self.level.0 + 1 < LEVELS.len() { GIVEN_UP_AT * self.ms } else { f64::INFINITY };
        move |ms| ms > limit
    }

    /// Records the time of a preview on the device and elsewhere, and adapts the level.
    pub(crate) fn took(&mut self, scene: &Scene, device_ms: f64, other_ms: f64) {
        self.recent.push([device_ms / self.level.work(scene), other_ms]);
        if self.recent.len() > RECENT_PREVIEWS {
            self.recent.remove(0);
        }
        let [cost, other] = medians(&self.recent);
        let other = other.clamp(0.0, MAX_OVERHEAD * self.ms);
        let predicted = |level: usize| other + cost * Level(level).work(scene);
        let (now, last) = (self.level.0, LEVELS.len() - 1);
        let fits = |level: &usize| predicted(*level) <= HEADROOM * self.ms;
        // The level stays unless a better one certainly fits.
        let is_kept = predicted(now) <= self.ms;
        let next = if is_kept { (0..now).find(fits) } else { (now..=last).find(fits) };
        self.level = Level(next.unwrap_or(if is_kept { now } else { last }));
    }

    /// Records that a preview was aborted.
    pub(crate) fn gave_up(&mut self, scene: &Scene) {
        let least = 0.3 * self.level.work(scene);
        let fits = |level: &usize| Level(*level).work(scene) <= least;
        self.level = Level((self.level.0..LEVELS.len()).find(fits).unwrap_or(LEVELS.len() - 1));
        self.recent.clear();
    }
}

/// The tiles of a picture in ascending distance from `focus`, which is in fractions of its width and height.
pub(crate) fn tiles([width, height]: [u32; 2], focus: [f32; 2]) -> Vec<Area> {
    let along = |side: u32| (0..side.div_ceil(TILE)).map(move |tile| tile * TILE..((tile + 1) * TILE).min(side));
    let of_row = |rows: std::ops::Range<u32>| along(width).map(move |columns| Area { columns, rows: rows.clone() });
    let mut all: Vec<Area> = along(height).flat_map(of_row).collect();
    let [x, y] = [focus[0] * width as f32, focus[1] * height as f32];
    let away = |area: &Area| {
        let middle = |range: &std::ops::Range<u32>| 0.5 * (range.start + range.end) as f32;
        (middle(&area.columns) - x).hypot(middle(&area.rows) - y)
    };
    all.sort_by(|a, b| away(a).total_cmp(&away(b)));
    all
}

/// The scene of the sub-frames, whose mean converges.
pub(crate) fn reference(scene: &Scene) -> Scene {
    let mut fine = scene.clone();
    let quality = &mut fine.quality;
    (quality.supersampling, quality.msaa, quality.target) = (MAX_SUB_FRAMES, 1, TargetFormat::Float32);
    if quality.jitter == Jitter::None && scene.effect.ray_path == RayPath::Straight {
        quality.jitter = Jitter::Hash; // rays that bend have no phase
    }
    fine
}

/// Index of sub-frame `count`: reversed bits, so that every power of two covers the pixel and the shutter evenly.
pub(crate) fn number(count: u32) -> u32 {
    count.reverse_bits() >> (u32::BITS - MAX_SUB_FRAMES.ilog2())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    #[test]
    fn every_sub_frame_has_its_turn_and_powers_of_two_are_even() {
        let all: BTreeSet<u32> = (0..MAX_SUB_FRAMES).map(number).collect();
        assert_eq!(all.len(), MAX_SUB_FRAMES as usize);
        for count in [2, 8, 64] {
            let mut first: Vec<u32> = (0..count).map(number).collect();
            first.sort_unstable();
            assert!(first.windows(2).all(|pair| pair[1] - pair[0] == MAX_SUB_FRAMES / count), "{first:?}");
        }
    }

    const MS: f64 = 50.0;

    /// A device on which a sample of a scene costs so many milliseconds, and a preview two more.
    fn drawn(budget: &mut Budget, scene: &Scene, cost: f64) -> f64 {
        let work = budget.level().work(scene);
        let ms = 2.0 + cost * work;
        if budget.ends()(cost * work) {
            budget.gave_up(scene);
            return GIVEN_UP_AT * MS; // and some part of a submission
        }
        budget.took(scene, cost * work, 2.0);
        ms
    }

    fn scene() -> Scene {
        let mut scene = Scene::default();
        (scene.image.size, scene.light.shadows) = ([900, 720], true);
        scene
    }

    #[test]
    fn b1_previews_reach_their_budget_within_three_and_keep_it() {
        let scene = scene();
        for cost in [1e-9, 1e-7, 2e-7, 1e-6, 3e-6, 1e-5, 3e-5] {
            let mut budget = Budget::new(MS, true);
            let first: f64 = (0..3).map(|_| drawn(&mut budget, &scene, cost)).sum();
            assert!(first <= (2.0 * GIVEN_UP_AT + 1.0) * MS, "{cost}: {first}");
            let level = budget.level();
            for _ in 0..20 {
                let ms = drawn(&mut budget, &scene, cost);
                assert!(ms <= MS, "{cost}: {ms}");
            }
            assert!(budget.level().0 <= level.0, "{cost}: what is too coarse gets better");
            // Time that is left would not do for a level that is twice as dear.
            let dearer = budget.level().0.checked_sub(3).map(|level| cost * Level(level).work(&scene));
            assert!(dearer.is_none_or(|ms| ms > HEADROOM * MS * 0.9), "{cost}: {dearer:?}");
        }
    }

    #[test]
    fn b1_one_slow_preview_changes_no_level_and_two_do() {
        let scene = scene();
        let mut budget = Budget::new(MS, true);
        for _ in 0..9 {
            drawn(&mut budget, &scene, 1e-6);
        }
        let level = budget.level();
        drawn(&mut budget, &scene, 2.5e-6);
        assert_eq!(budget.level(), level);
        drawn(&mut budget, &scene, 2.5e-6);
        assert_ne!(budget.level(), level);
    }

    #[test]
    fn b1_fixed_costs_do_not_coarsen_previews() {
        let scene = scene();
        let mut budget = Budget::new(MS, true);
        // A machine that is busy: each preview waits for a second, whatever is drawn.
        for _ in 0..9 {
            let work = budget.level().work(&scene);
            budget.took(&scene, 1e-6 * work, 1000.0);
        }
        let (busy, mut idle) = (budget.level(), Budget::new(MS, true));
        for _ in 0..9 {
            drawn(&mut idle, &scene, 1e-6);
        }
        assert!(busy.work(&scene) > 0.4 * idle.level().work(&scene), "{busy:?} {:?}", idle.level());
    }

    #[test]
    fn b1_shadows_and_noise_blocks_have_own_preview_levels() {
        let mut scene = scene();
        (scene.quality.block_size, scene.light.shadow_resolution) = (256, 128);
        let shadows = |level: usize| Level(level).scene(&scene, true).light.shadow_resolution;
        assert_eq!([shadows(0), shadows(4), shadows(7), shadows(14)], [128, 128, 64, 16]);
        // A program that lavapipe has compiled for sides that are powers of two, or for others, serves all levels.
        let rays = |own: u32, level: usize| {
            let mut other = scene.clone();
            other.light.shadow_resolution = own;
            Level(level).scene(&other, true).light.shadow_resolution
        };
        assert!((0..LEVELS.len()).all(|level| rays(128, level).is_power_of_two()));
        assert!((0..LEVELS.len()).all(|level| !rays(200, level).is_power_of_two()));
        // They are never more than a part of the work.
        for level in 0..LEVELS.len() {
            let [width, height] = Level(level).scene(&scene, true).image.size;
            assert!(shadows(level).pow(2) < width * height / 4 || level > 12, "{level}");
        }
        let block = |has_blocks| Level(4).scene(&scene, has_blocks).quality.block_size;
        assert_eq!([block(false), block(true)], [PREVIEW_BLOCK, 256]);
        for level in 0..LEVELS.len() {
            assert!(Level(level).scene(&scene, false).check(&hypertexture::shader::shipped()).is_ok(), "{level}");
        }
    }

    #[test]
    fn b3_tiles_cover_the_picture_once_and_begin_where_one_looks() {
        let size = [500, 300];
        let all = tiles(size, [0.9, 0.1]);
        let mut covered = vec![0; 500 * 300];
        for Area { columns, rows } in &all {
            rows.clone().for_each(|y| columns.clone().for_each(|x| covered[(y * 500 + x) as usize] += 1));
        }
        assert!(covered.iter().all(|times| *times == 1));
        assert!(all[0].columns.contains(&450) && all[0].rows.contains(&30), "{:?}", all[0]);
        assert!(all[all.len() - 1].columns.start == 0);
    }
}
