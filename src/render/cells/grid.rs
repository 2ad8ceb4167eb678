//! Cells of space that surely hold no matter: what rays and slices leave out.
//!
//! Role: a scene's own program, evaluated by [`exact`] over boxes with the roundings of a device, coarse to fine. Invariant:
//! a cell is called empty only where that is proven, so that a picture is the same with cells and without; what cannot be
//! decided may hold matter.

use super::prover::{CellGrid, CellProver, SIDES};
use super::tiles::Tiles;
use super::time_span::TimeSpan;
use super::{prover, slice_tiles};
use crate::gpu::{Area, Dimension, Format, Gpu, Image, Uploads};
use crate::render::camera::FrameContext;
use crate::render::error::RenderError;
use crate::render::inputs::{ImageInfo, TIME, Values};
use crate::render::variant::{Variant, VariantError};
use crate::scene::Pass;
use crate::scene::Scene;
use crate::shader::Library;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Instant;

/// Samples of a picture for each cell. Fewer: finer cells, which cost more than they save.
const SAMPLES: f64 = 400.0;
/// The same on a device that draws much faster than the processor decides.
const SAMPLES_OF_A_GPU: f64 = 100.0 * SAMPLES;
/// For so many pictures at most finer cells are decided that share them. More: a window that plays pauses for them.
const SHARED: u32 = 8;
/// Samples of a picture for each texel that is read back for bounds. Fewer: small pictures of large volumes wait for them.
const SAMPLES_OF_A_TEXEL: f64 = 2.0;
/// The same for the first picture of slices, which gains less than rays, and may be the only one.
const SAMPLES_OF_FIRST_SLICES: f64 = 16.0;

/// What was found of the cells of a picture.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct CellStats {
    /// Cells along each side of the box around the soft region; 0: none.
    pub side: u32,
    /// The part of them that is proven to be empty.
    pub empty: f32,
    /// Milliseconds that the proofs took.
    pub ms: f64,
    /// Whether they were kept on disk.
    #[serde(default)]
    pub kept: bool,
    /// Why there are none.
    pub why: Option<String>,
}

impl std::fmt::Display for CellStats {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let CellStats { side, empty, ms, kept, why } = self;
        match why {
            Some(why) => write!(f, "none: {why}"),
            None => {
                let share = 100.0 * empty;
                let how = if *kept { "as kept on disk".into() } else { format!("in {ms:.0} ms") };
                write!(f, "{side} x {side} x {side}, {share:.0} % proven to be empty {how}")
            }
        }
    }
}

/// What cells of a scene are decided by.
pub(crate) struct EmptyCells {
    library: Library,
    decider: CellProver,
    /// Those of the picture before.
    found: CellStats,
    /// What they depend on; `None` where there are none.
    key: Option<(Vec<u64>, CellGrid)>,
    /// For how long they are.
    span: TimeSpan,
    /// Which of them are empty, x fastest; none where no one is.
    empty: Vec<bool>,
    /// The same as rays read it, once it was asked for.
    image: Option<Arc<Image>>,
    /// Whether no picture was asked for yet.
    is_first: bool,
    /// Whether they serve the last picture at all.
    serve: bool,
}

impl EmptyCells {
    /// What decides the cells of the pictures of one program.
    pub(crate) fn new(library: &Library) -> EmptyCells {
        let (library, decider) = (library.clone(), CellProver::Idle(0));
        EmptyCells {
            library,
            decider,
            found: CellStats::default(),
            key: None,
            span: TimeSpan::default(),
            empty: Vec::new(),
            image: None,
            is_first: true,
            serve: true,
        }
    }

    /// What was found last; nothing where none would be left out.
    pub(crate) fn found(&self) -> Option<CellStats> {
        self.serve.then(|| self.found.clone())
    }

    /// Whether what decides the cells of a picture is made, or none pays for it.
    pub(crate) fn are_decided(&self, gpu: &Gpu, shot: &FrameContext<'_>) -> bool {
        if !serve(shot, &self.library) {
            return true;
        }
        match self.decider {
            CellProver::Idle(texels) | CellProver::Loading(texels, _) => {
                side(gpu.info().cpu, shot, texels, self.is_first, 1) == 0
            }
            CellProver::Ready(_) | CellProver::Unavailable(_) => true,
        }
    }

    /// Finds the cells of a picture, whose images are given by name. Ends where it is to `stop`.
    pub(crate) fn update(
        &mut self,
        gpu: &Gpu,
        shot: &FrameContext<'_>,
        values: &Values,
        image_of: &dyn Fn(&str) -> Option<ImageInfo>,
        stop: &dyn Fn() -> bool,
    ) -> Result<(), RenderError> {
        let start = Instant::now();
        self.serve = serve(shot, &self.library);
        if !self.serve {
            return Ok(());
        }
        let is_first = std::mem::replace(&mut self.is_first, false);
        let side_of = |texels, pictures| side(gpu.info().cpu, shot, texels, is_first, pictures);
        if let CellProver::Idle(texels) = self.decider
            && side_of(texels, 1) > 0
        {
            self.decider = CellProver::new(&self.library, shot, image_of, |texels| side_of(texels, 1) > 0)?;
        }
        if let CellProver::Loading(texels, _) = self.decider
            && side_of(texels, 1) > 0
        {
            self.decider.wait(stop)?;
        }
        let few = || (None, Err::<(Vec<bool>, bool), String>("so few samples are not worth it".into()));
        let (key, empty) = match &mut self.decider {
            CellProver::Idle(_) | CellProver::Loading(..) => few(),
            CellProver::Unavailable(why) => (None, Err(why.clone())),
            CellProver::Ready(bounded) => match CellGrid::of(shot, side_of(bounded.texels, self.span.shared())) {
                CellGrid { side: 0, .. } => few(),
                last => {
                    let is_of = |boxes: &CellGrid| self.key.as_ref().is_some_and(|(_, of)| of == boxes);
                    let time = values.get(TIME).and_then(|time| time.first()).copied().unwrap_or_default();
                    let timeless = bounded.reads.timeless(values)?;
                    if is_of(&last) && self.span.holds(&timeless, time) {
                        return Ok(());
                    }
                    let read = bounded.fill(values, [time; 2])?;
                    let camera = &shot.scene.camera;
                    let end = (camera.time + f64::from(camera.shutter)) as f32;
                    let times = self.span.next(&timeless, time, end);
                    let boxes = CellGrid::of(shot, side_of(bounded.texels, self.span.to_share(times)));
                    if is_of(&boxes) && self.key.as_ref().is_some_and(|(before, _)| *before == read) {
                        return Ok(());
                    }
                    if times[0] < times[1] {
                        bounded.fill(values, times)?;
                    }
                    let proven = bounded.proven(&boxes, &read, stop).map_err(|error| error.to_string());
                    let proven = proven.transpose().ok_or(RenderError::Stopped)?;
                    self.span.take(timeless, times, proven.as_ref().map_or(0.0, |(empty, _)| part(empty)));
                    (Some((read, boxes)), proven)
                }
            },
        };
        let empty = empty.and_then(|(empty, kept)| match empty.contains(&true) {
            true => Ok((empty, kept)),
            false => Err("no bounds prove that there is no matter".to_string()),
        });
        (self.key, self.image) = (key, None);
        (self.found, self.empty) = match (&self.key, empty) {
            (Some((_, CellGrid { side, .. })), Ok((empty, kept))) => {
                let ms = start.elapsed().as_secs_f64() * 1e3;
                (CellStats { side: *side, empty: part(&empty), ms, kept, why: None }, empty)
            }
            (_, why) => (CellStats { why: why.err(), ..CellStats::default() }, Vec::new()),
        };
        Ok(())
    }

    /// The cells as rays read them; `None` where none is known to be empty.
    pub(crate) fn image(&mut self, gpu: &Gpu, uploads: &Uploads) -> Result<Option<Arc<Image>>, RenderError> {
        if let (None, Some((_, CellGrid { side, .. })), false) = (&self.image, &self.key, self.empty.is_empty()) {
            self.image = Some(image(gpu, uploads, *side, &distances(&self.empty, *side as usize))?);
        }
        Ok(self.image.clone())
    }

    /// The tiles that slices of a picture are drawn in, within areas of it.
    pub(crate) fn tiles(&self, shot: &FrameContext<'_>, within: &[Area]) -> Tiles {
        match &self.key {
            Some((_, boxes)) if self.serve && !self.empty.is_empty() => {
                slice_tiles::tiles(shot, boxes, &self.empty, within)
            }
            _ => Tiles::everywhere(within),
        }
    }
}

/// The part of them that is empty.
fn part(empty: &[bool]) -> f32 {
    empty.iter().filter(|&&empty| empty).count() as f32 / empty.len() as f32
}

/// Links the program that decides the cells of a scene: it is on the disk where it is asked for.
///
/// # Errors
/// As [`Variant::program`].
pub fn link(variant: &Variant, scene: &Scene, library: &Library) -> Result<(), VariantError> {
    prover::deciding(variant, scene, library).map(drop)
}

/// Whether a picture is drawn sooner where cells are known to be empty: by all rays whose program asks for them.
fn serve(shot: &FrameContext<'_>, library: &Library) -> bool {
    shot.scene.quality.pass == Pass::March || shot.scene.has_tiles(library)
}

/// So many cells along a side, each with its distance to one that may hold matter.
pub(crate) fn image(gpu: &Gpu, uploads: &Uploads, side: u32, texels: &[u8]) -> Result<Arc<Image>, RenderError> {
    Ok(uploads.image(gpu, "cells", Dimension::Volume(side, side, side), Format::R8Unorm, texels)?)
}

/// Cells along a side that pay for a picture on a device, which may be the processor; it may be the first of a program, and
/// so many share them. 0 for none.
pub(super) fn side(is_cpu: bool, shot: &FrameContext<'_>, texels: u64, is_first: bool, pictures: u32) -> u32 {
    let scene = shot.scene;
    let [width, height] = shot.whole.map(f64::from);
    let samples =
        width * height * f64::from(shot.planes.count) * f64::from(scene.quality.supersampling) * unskipped(shot);
    let of_a_cell = if is_cpu { SAMPLES } else { SAMPLES_OF_A_GPU };
    // Sub-frames of an exposure are counted already.
    let shared = if scene.camera.shutter > 0.0 { 1 } else { pictures.min(SHARED) };
    let levels = (samples * f64::from(shared) / of_a_cell).cbrt().log2().floor().clamp(0.0, 8.0);
    let side = 1 << levels as u32;
    let of_a_texel = match is_first && scene.quality.pass == Pass::Slices {
        true => SAMPLES_OF_FIRST_SLICES,
        false => SAMPLES_OF_A_TEXEL,
    };
    let pays = side >= SIDES[0] && samples >= texels as f64 * of_a_texel;
    if pays { side.min(SIDES[1]) } else { 0 }
}

/// About which part of the samples is not shown to be empty by the distance to the objects, which rays alone ask for.
fn unskipped(shot: &FrameContext<'_>) -> f64 {
    if shot.scene.quality.pass == Pass::Slices {
        return 1.0;
    }
    let near = shot.view.objects.iter().map(|own| {
        let inner_iso = match own.name.as_str() {
            "" => shot.scene.object.inner_iso,
            name => shot.scene.parts[name].object.inner_iso,
        };
        own.scale * (own.spread.moves.span() + own.outer_iso - inner_iso)
    });
    f64::from((near.fold(0.0, f32::max) / shot.view.extent.radius).min(1.0))
}

/// How many cells it is from each to one that may hold matter, along the axis where that is farthest; 0 for such a one.
pub(super) fn distances(empty: &[bool], side: usize) -> Vec<u8> {
    let mut all: Vec<u8> = empty.iter().map(|&empty| if empty { u8::MAX } else { 0 }).collect();
    for stride in [1, side, side * side] {
        let before = all.clone();
        for (index, value) in all.iter_mut().enumerate() {
            let at = index / stride % side;
            let mut away = 1;
            // Only what is nearer than what is known can be less.
            while away < *value as usize && (at >= away || at + away < side) {
                let near = if at >= away { before[index - away * stride] } else { u8::MAX };
                let far = if at + away < side { before[index + away * stride] } else { u8::MAX };
                *value = (*value).min(near.min(far).max(away as u8));
                away += 1;
            }
        }
    }
    all
}
