//! Choice between the ways to draw the rays of a program, by time.
//!
//! Role: draws a part of the first large picture of a program in each [`Way`] that the device may prefer, and remembers
//! the fastest, also on disk. Invariant: every way gives the same bits.

use super::bind::bind_rays;
use super::pass::{self, PassTiming};
use super::prepared::Prepared;
use super::submission_budget::{SubmissionBudget, SubmissionControl};
use crate::gpu::{Area, Gpu, Pipeline, Target};
use crate::render::camera::FrameContext;
use crate::render::error::RenderError;
use crate::render::variant::{Program, Variant};
use crate::scene::{Pass, ShaderStage};
use crate::shader::slots::FOLDED;
use crate::shader::{Library, Linker, Slots};
use hypertexture_support::disk_cache::{self, CacheKind};
use std::sync::Arc;

/// Samples of a picture from which on a trial pays. Higher: pictures of 300 x 300 are never tried. Lower: compiling the
/// other programs takes longer than they save.
const LARGE: u64 = 20_000_000;
/// A trial draws one row of groups out of this many.
const PART: u32 = 8;
/// Runs of each way, after one that is not timed.
const RUNS: usize = 3;
/// Share of the time of the present way that another must stay below.
const BETTER_SHARE: f64 = 0.95;
/// Files of choices, one byte each.
const KIND: CacheKind = CacheKind { ends: &["way"], limit: 1 << 20 };

/// A way to draw rays.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Way {
    /// By compute shaders in place of fragment shaders.
    is_compute: bool,
    /// In one phase in place of two.
    is_direct: bool,
}

impl Way {
    /// All ways.
    const ALL: [Way; 4] = [
        Way { is_compute: false, is_direct: false },
        Way { is_compute: false, is_direct: true },
        Way { is_compute: true, is_direct: false },
        Way { is_compute: true, is_direct: true },
    ];

    /// The way of a variant.
    fn of(variant: &Variant) -> Way {
        Way { is_compute: variant.is_compute(), is_direct: !variant.uses_two_phase() }
    }

    /// The variant of a scene that draws in this way, if it can.
    fn applied(self, scene: &Variant, library: &Library) -> Option<Variant> {
        let direct = if self.is_direct { scene.without_two_phase() } else { scene.clone() };
        let own = if self.is_compute { direct.in_compute(library).ok()? } else { direct };
        (Way::of(&own) == self).then_some(own)
    }

    /// The way that an earlier trial chose for a program on this device.
    fn remembered(gpu: &Gpu, scene: &Variant, library: &Library) -> Option<Way> {
        let code = disk_cache::load(KIND, key(gpu, scene, library))?;
        Way::ALL.get(usize::from(*code.first()?)).copied()
    }

    fn remember(self, gpu: &Gpu, scene: &Variant, library: &Library) {
        let code = Way::ALL.iter().position(|way| *way == self).unwrap_or_default();
        disk_cache::save(KIND, key(gpu, scene, library), &[code as u8]);
    }
}

fn key(gpu: &Gpu, scene: &Variant, library: &Library) -> blake3::Hash {
    // Terms that are folded do not count: a slider that is pulled to 0 keeps the way, and so the program.
    let mut unfolded = scene.clone();
    Arc::make_mut(&mut unfolded.slots).remove(FOLDED);
    let text = unfolded.text_hash(library);
    blake3::Hasher::new().update(text.as_bytes()).update(gpu.info().title().as_bytes()).finalize()
}

/// Slots of a variant without terms that are folded.
fn unfolded(scene: &Variant) -> impl Iterator<Item = (&String, &Vec<String>)> {
    scene.slots.iter().filter(|(slot, _)| *slot != FOLDED)
}

/// Ways that trials have chosen, by the modules of a scene.
#[derive(Default)]
pub(crate) struct Ways(Vec<(Slots, Way)>);

impl Ways {
    /// Looks the way to draw a scene up on disk. Returns whether a trial is to choose it and pays.
    pub(crate) fn recall(&mut self, gpu: &Gpu, scene: &Variant, library: &Library) -> bool {
        let ([width, height], quality) = (scene.scene.image.size, &scene.scene.quality);
        let work: u64 = [width, height, quality.samples, quality.supersampling].map(u64::from).iter().product();
        let is_open = quality.stage == ShaderStage::Auto && quality.pass == Pass::March && work >= LARGE;
        if !is_open || self.get(scene).is_some() {
            return false;
        }
        let way = Way::remembered(gpu, scene, library);
        way.into_iter().for_each(|way| self.set(scene, way));
        way.is_none()
    }

    /// Keeps the way of a scene.
    pub fn set(&mut self, scene: &Variant, way: Way) {
        self.0.retain(|(slots, _)| !slots.iter().eq(unfolded(scene)));
        self.0.push((unfolded(scene).map(|(slot, names)| (slot.clone(), names.clone())).collect(), way));
    }

    /// The variant that draws a scene in its way, if that is chosen.
    pub fn applied(&self, scene: &Variant, library: &Library) -> Option<Variant> {
        self.get(scene)?.applied(scene, library)
    }

    fn get(&self, scene: &Variant) -> Option<Way> {
        self.0.iter().find(|(slots, _)| slots.iter().eq(unfolded(scene))).map(|(_, way)| *way)
    }
}

impl Prepared {
    /// Draws a part of a picture in each way, once its blocks are filled, and keeps the program of the fastest. `scene`
    /// is the variant of the scene itself. Drivers on a processor run both stages alike, and try fragment shaders only.
    ///
    /// # Errors
    /// Those of a submission; [`RenderError::Stopped`].
    pub(crate) fn choose_way(
        &mut self,
        scene: &Variant,
        library: &Library,
        frame: &FrameContext,
        stop: &dyn Fn(f64) -> bool,
    ) -> Result<Way, RenderError> {
        let present = Way::of(&self.variant);
        let ways = Way::ALL
            .into_iter()
            .filter(|way| *way != present && !(way.is_compute && (self.gpu.info().cpu || !self.gpu.info().computes)));
        let others = ways.filter_map(|way| way.applied(scene, library));
        let (mut fastest, mut limit) = (None, f64::INFINITY);
        for other in others {
            // A program that reads other resources has other images.
            let Ok(program) = other.program(library, Linker::new) else { continue };
            if program.resources != self.program.resources {
                continue;
            }
            if limit.is_infinite() {
                limit = BETTER_SHARE * self.time_part(&self.program, &self.pipelines.picture, frame, stop)?;
            }
            let pipeline = self.pipeline_of(&program)?;
            let ms = self.time_part(&program, &pipeline, frame, stop)?;
            if ms < limit {
                (fastest, limit) = (Some((other, program, pipeline)), ms);
            }
        }
        if let Some((variant, program, pipeline)) = fastest {
            self.replace_program(variant, program, pipeline);
        }
        let way = Way::of(&self.variant);
        way.remember(&self.gpu, scene, library);
        Ok(way)
    }

    /// Least time of a part of a picture, milliseconds on the device.
    fn time_part(
        &self,
        program: &Program,
        pipeline: &Pipeline,
        frame: &FrameContext,
        stop: &dyn Fn(f64) -> bool,
    ) -> Result<f64, RenderError> {
        let Some((color, _)) = &self.targets else { return Ok(f64::INFINITY) };
        let set = bind_rays(program, pipeline, self.bound.resources(), Some(color))?;
        let [width, height, _] = color.size();
        let rows = (0..height.div_ceil(8)).step_by(PART as usize).map(|row| 8 * row..(8 * row + 8).min(height));
        let areas: Vec<Area> = rows.map(|rows| Area { columns: 0..width, rows }).collect();
        let mut budget = SubmissionBudget::default();
        let mut run = |_| {
            let mut control = SubmissionControl { budget: &mut budget, stop: &|ms, _| stop(ms) };
            let places = (areas.as_slice(), frame.planes.count);
            pass::march(&self.gpu, pipeline, &set, places, Target::of(color), &mut control)
        };
        run(0)?;
        let runs: Vec<PassTiming> = (0..RUNS).map(run).collect::<Result<_, _>>()?;
        Ok(runs.iter().map(|run| run.gpu_ms).fold(f64::INFINITY, f64::min))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{ParameterValue, preset};
    use crate::shader;

    #[test]
    fn a_value_that_is_pulled_to_zero_keeps_the_way() {
        let library = shader::shipped();
        let variant = |melt_time| {
            let mut scene = preset("melting").unwrap();
            scene.parameters.insert("melt_time".into(), ParameterValue::Number(melt_time));
            Variant::of(&scene, &library).unwrap()
        };
        let (own, zero) = (variant(1.0), variant(0.0));
        assert_ne!(own.slots, zero.slots, "a term is folded");
        let (mut ways, way) = (Ways::default(), Way { is_compute: false, is_direct: true });
        ways.set(&own, way);
        assert_eq!(Way::of(&ways.applied(&zero, &library).unwrap()), way);
        assert!(ways.applied(&variant(0.5), &library).is_some());
    }
}
