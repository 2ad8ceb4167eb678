//! Grid of cells that are proven to hold no matter.
//!
//! Role: the scene's program is evaluated by [`eval`](crate::eval) over boxes with the roundings of a device, coarse to
//! fine. Invariant: a cell is empty only if proven, so that a picture is equal with cells and without; an undecided
//! cell may hold matter.

use super::prover::{CellGrid, CellProver, SIDES, deciding};
use super::slice_tiles;
use super::tiles::Tiles;
use super::time_span::TimeSpan;
use crate::gpu::{Area, Dimension, Format, Gpu, Image, Uploads};
use crate::render::camera::FrameContext;
use crate::render::error::RenderError;
use crate::render::inputs::{ImageInfo, Values};
use crate::render::variant::{PassImage, Variant, VariantError};
use crate::scene::{Pass, RayPath, Scene};
use crate::shader::Library;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use std::time::Instant;

/// Lowest number of samples for each cell. Lower: finer cells, which cost more than they save.
const SAMPLES: f64 = 400.0;
/// Lowest number of samples for each cell on a GPU, which draws much faster than the CPU proves.
const SAMPLES_OF_A_GPU: f64 = 100.0 * SAMPLES;
/// Largest number of sharing pictures that refines the cells. Higher: playback pauses for proofs.
const MAX_SHARING: u32 = 8;
/// Lowest number of samples for each texel that bounds read. Lower: small pictures of large volumes wait for bounds.
const SAMPLES_OF_A_TEXEL: f64 = 2.0;
/// Lowest number of samples for each texel for the first picture of slices, which gains less than rays and may be the
/// only one.
const SAMPLES_OF_FIRST_SLICES: f64 = 16.0;

/// Statistics of the cells of a picture.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct CellStats {
    /// Cells along each side of the box around the soft region; 0 without cells.
    pub side: u32,
    /// Share of cells that are proven to be empty.
    pub empty: f32,
    /// Time of the proofs, milliseconds.
    pub ms: f64,
    /// Whether the proofs came from the disk cache.
    #[serde(default)]
    pub kept: bool,
    /// Reason for the absence of cells.
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

/// Empty cells of a scene's pictures.
pub(crate) struct EmptyCells {
    library: Library,
    prover: CellProver,
    /// Statistics of the latest cells.
    found: CellStats,
    /// Inputs of the proofs; `None` without cells.
    key: Option<(Vec<u64>, CellGrid)>,
    /// Times at which the proofs hold.
    span: TimeSpan,
    /// Emptiness of each cell, x fastest; without elements if no cell is empty.
    empty: Vec<bool>,
    /// The cells as a distance image, created on demand.
    image: Option<Arc<Image>>,
    /// Whether no picture has been drawn.
    is_first: bool,
    /// Whether the latest picture profits from cells.
    serve: bool,
}

impl EmptyCells {
    pub(crate) fn new(library: &Library) -> EmptyCells {
        let (library, prover) = (library.clone(), CellProver::Idle(0));
        EmptyCells {
            library,
            prover,
            found: CellStats::default(),
            key: None,
            span: TimeSpan::default(),
            empty: Vec::new(),
            image: None,
            is_first: true,
            serve: true,
        }
    }

    /// Statistics of the latest cells; `None` if the picture does not profit from cells.
    pub(crate) fn found(&self) -> Option<CellStats> {
        self.serve.then(|| self.found.clone())
    }

    /// Whether the prover of a picture is ready or does not pay.
    pub(crate) fn are_decided(&self, gpu: &Gpu, frame: &FrameContext) -> bool {
        if !serve(frame, &self.library) {
            return true;
        }
        match self.prover {
            CellProver::Idle(texels) | CellProver::Loading(texels, _) => {
                side(gpu.info().cpu, frame, texels, self.is_first, 1) == 0
            }
            CellProver::Ready(_) | CellProver::Unavailable(_) => true,
        }
    }

    /// Proves the cells of a picture; `image_of` describes its images by name. Returns [`RenderError::Stopped`] when
    /// told to `stop`.
    pub(crate) fn update(
        &mut self,
        gpu: &Gpu,
        frame: &FrameContext,
        values: &Values,
        image_of: &dyn Fn(&str) -> Option<ImageInfo>,
        stop: &dyn Fn() -> bool,
    ) -> Result<(), RenderError> {
        let start = Instant::now();
        self.serve = serve(frame, &self.library);
        if !self.serve {
            return Ok(());
        }
        let is_first = std::mem::replace(&mut self.is_first, false);
        let side_of = |texels, pictures| side(gpu.info().cpu, frame, texels, is_first, pictures);
        if let CellProver::Idle(texels) = self.prover
            && side_of(texels, 1) > 0
        {
            self.prover = CellProver::new(&self.library, frame, image_of, |texels| side_of(texels, 1) > 0)?;
        }
        if let CellProver::Loading(texels, _) = self.prover
            && side_of(texels, 1) > 0
        {
            self.prover.wait(stop)?;
        }
        let few = || (None, Err::<(Vec<bool>, bool), String>("too few samples to pay for it".into()));
        let (key, empty) = match &mut self.prover {
            CellProver::Idle(_) | CellProver::Loading(..) => few(),
            CellProver::Unavailable(why) => (None, Err(why.clone())),
            CellProver::Ready(bounded) => match CellGrid::of(frame, side_of(bounded.texels, self.span.shared())) {
                CellGrid { side: 0, .. } => few(),
                last => {
                    let is_of = |boxes: &CellGrid| self.key.as_ref().is_some_and(|(_, of)| of == boxes);
                    let (time, camera) = (values.time, &frame.variant.scene.camera);
                    let timeless = bounded.reads.timeless(values)?;
                    if is_of(&last) && self.span.holds(&timeless, time) {
                        return Ok(());
                    }
                    let read = bounded.fill(values, [time; 2])?;
                    let end = (camera.time + f64::from(camera.shutter)) as f32;
                    let times = self.span.next(&timeless, time, end);
                    let boxes = CellGrid::of(frame, side_of(bounded.texels, self.span.to_share(times)));
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
        let empty = empty.and_then(|(empty, kept)| {
            if empty.contains(&true) { Ok((empty, kept)) } else { Err("bounds prove no cell empty".to_string()) }
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

    /// The distance image of the cells; `None` if no cell is known to be empty.
    pub(crate) fn image(&mut self, gpu: &Gpu, uploads: &Uploads) -> Result<Option<Arc<Image>>, RenderError> {
        if let (None, Some((_, CellGrid { side, .. })), false) = (&self.image, &self.key, self.empty.is_empty()) {
            self.image = Some(image(gpu, uploads, *side, &distances(&self.empty, *side as usize))?);
        }
        Ok(self.image.clone())
    }

    /// The cells, if some are known to be empty.
    fn known(&self) -> Option<(&CellGrid, &[bool])> {
        let (_, boxes) = self.key.as_ref().filter(|_| self.serve && !self.empty.is_empty())?;
        Some((boxes, &self.empty))
    }
}

/// Tiles of a picture, within some areas: where its slices, or straight rays, meet cells that may hold matter. The box around
/// the soft region is one cell for rays without cells; bent rays meet matter beside their pixels.
pub(crate) fn tiles(cells: Option<&EmptyCells>, frame: &FrameContext, within: &[Area]) -> Tiles {
    let Scene { effect, quality, .. } = &frame.variant.scene;
    match cells.and_then(EmptyCells::known) {
        Some((boxes, empty)) if quality.msaa == 1 => slice_tiles::tiles(frame, boxes, empty, within),
        None if quality.msaa == 1 && quality.pass == Pass::March && effect.ray_path == RayPath::Straight => {
            slice_tiles::tiles(frame, &CellGrid::of(frame, 1), &[false], within)
        }
        _ => Tiles::everywhere(within),
    }
}

/// Share of empty cells.
fn part(empty: &[bool]) -> f32 {
    empty.iter().filter(|&&empty| empty).count() as f32 / empty.len() as f32
}

/// Links the program that decides the cells of a scene, into the disk cache.
///
/// # Errors
/// As [`Variant::program`].
pub fn link(variant: &Variant, library: &Library) -> Result<(), VariantError> {
    deciding(variant, library).map(drop)
}

/// Whether a picture is drawn faster with known empty cells: by all rays whose program asks for them.
fn serve(frame: &FrameContext, library: &Library) -> bool {
    let scene = &frame.variant.scene;
    scene.quality.pass == Pass::March || scene.has_tiles(library)
}

/// Uploads a cube of cells, each with its distance to one that may hold matter.
pub(crate) fn image(gpu: &Gpu, uploads: &Uploads, side: u32, texels: &[u8]) -> Result<Arc<Image>, RenderError> {
    Ok(uploads.image(gpu, PassImage::Cells.label(), Dimension::Volume(side, side, side), Format::R8Unorm, texels)?)
}

/// Cells along a side that pay for a picture, given the texels that bounds read and the number of `pictures` that share
/// the proofs; 0 if none pay.
pub(super) fn side(is_cpu: bool, frame: &FrameContext, texels: u64, is_first: bool, pictures: u32) -> u32 {
    let scene = &frame.variant.scene;
    let [width, height] = frame.whole.map(f64::from);
    let samples =
        width * height * f64::from(frame.planes.count) * f64::from(scene.quality.supersampling) * unskipped(frame);
    let of_a_cell = if is_cpu { SAMPLES } else { SAMPLES_OF_A_GPU };
    // Sub-frames of an exposure count as samples.
    let shared = if scene.camera.shutter > 0.0 { 1 } else { pictures.min(MAX_SHARING) };
    let levels = (samples * f64::from(shared) / of_a_cell).cbrt().log2().floor().clamp(0.0, 8.0);
    let side = 1 << levels as u32;
    let of_a_texel =
        if is_first && scene.quality.pass == Pass::Slices { SAMPLES_OF_FIRST_SLICES } else { SAMPLES_OF_A_TEXEL };
    let pays = side >= SIDES[0] && samples >= texels as f64 * of_a_texel;
    if pays { side.min(SIDES[1]) } else { 0 }
}

/// Estimated share of samples that the distance field does not skip; slices skip none by it.
fn unskipped(frame: &FrameContext) -> f64 {
    let scene = &frame.variant.scene;
    if scene.quality.pass == Pass::Slices {
        return 1.0;
    }
    let near = frame.view.objects.iter().map(|own| {
        let inner_iso = match own.name.as_str() {
            "" => scene.object.inner_iso,
            name => scene.parts[name].object.inner_iso,
        };
        own.scale * (own.spread.moves.span() + own.outer_iso - inner_iso)
    });
    f64::from((near.fold(0.0, f32::max) / frame.view.extent.radius).min(1.0))
}

/// Chebyshev distance of each cell to the nearest one that may hold matter.
pub(super) fn distances(empty: &[bool], side: usize) -> Vec<u8> {
    let mut all: Vec<u8> = empty.iter().map(|&empty| if empty { u8::MAX } else { 0 }).collect();
    for stride in [1, side, side * side] {
        let before = all.clone();
        for (index, value) in all.iter_mut().enumerate() {
            let at = index / stride % side;
            let mut away = 1;
            // A nearer cell is needed to lower a known distance.
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
