//! Cells of space that surely hold no matter: what rays leave out.
//!
//! Role: a scene's own program, evaluated by [`exact`] over boxes with the roundings of a device, coarse to fine. Invariant:
//! a cell is called empty only where that is proven, so that a picture is the same with cells and without; what cannot be
//! decided may hold matter.

use super::cpu_inputs::{texture, wrap};
use super::inputs::Inputs;
use super::shot::Shot;
use super::values::{Values, blocks};
use super::{OCTAVES_ID, RenderError};
use crate::exact::{self, Device, Interval, Outline};
use crate::gpu::{Dimension, Format, Gpu, Image};
use crate::render::variant::Program;
use crate::shader::{Library, Linker};
use crate::support::disk_cache::{self, Kind};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::time::Instant;

/// Samples of a picture for each cell. Fewer: finer cells, which cost more than they save.
const SAMPLES: f64 = 400.0;
/// The same on a device that draws much faster than the processor decides.
const SAMPLES_OF_A_GPU: f64 = 100.0 * SAMPLES;
/// Samples of a picture for each texel that is read back for bounds. Fewer: small pictures of large volumes wait for them.
const SAMPLES_OF_A_TEXEL: f64 = 2.0;
/// Cells along a side, at least and at most.
const SIDES: [u32; 2] = [4, 64];
/// More texels are not read back: each takes 21 bytes.
const MOST_TEXELS: u64 = 1 << 24;
/// How much larger a cell is taken than it is, in parts of its side: places of samples are rounded.
const MARGIN: f64 = 1e-3;
/// Roundings of the place of a sample, in parts of its distance from the eye.
const PLACE: f64 = 1e-6;
/// So many cells along a side are always tried; finer ones if of so many boxes at least one is empty.
const TRIED: u32 = 16;
const LEAST_FOUND: usize = 32;
/// Scalar operations that finer boxes may take: some seconds.
const OPERATIONS: u64 = 4_000_000_000;
/// Boxes that one thread decides at a time.
const BOXES: usize = 512;

/// Proofs that take longer are kept on disk, milliseconds. Less: a value that is pulled fills the disk.
const KEPT_FROM_MS: f64 = 20.0;
/// Some ten thousand proofs.
const KIND: Kind = Kind { ends: &["cells"], limit: 64 << 20 };
/// Counts up where proofs change.
const VERSION: u32 = 1;

/// What was found of the cells of a picture.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Found {
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

/// What cells of a scene are decided by.
pub(super) struct Cells {
    library: Library,
    decider: Decider,
    /// Those of the picture before.
    found: Found,
    /// What they depend on; `None` where there are none.
    key: Option<(Vec<u64>, Boxes)>,
}

/// What decides, made for the first picture that it pays for.
enum Decider {
    /// Not made yet; its images have at least so many texels.
    Unmade(u64),
    Made(Box<Bounded>),
    /// There are no bounds, and why.
    Unbounded(String),
}

/// A program that says where matter is, and what it reads.
struct Bounded {
    program: Program,
    code: exact::Program,
    outline: Outline,
    inputs: exact::Inputs,
    texels: u64,
    /// That of the program, and of its images and how they are filtered.
    hash: blake3::Hash,
}

/// A box in object space and how it is divided.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Boxes {
    low: [f64; 3],
    high: [f64; 3],
    /// Cells along each side, a power of two.
    side: u32,
    /// How much larger than they are cells are taken, object units.
    margin: [f64; 3],
}

impl Cells {
    /// What decides the cells of the pictures of one program.
    pub(super) fn new(library: &Library) -> Cells {
        let (library, decider) = (library.clone(), Decider::Unmade(0));
        Cells { library, decider, found: Found::default(), key: None }
    }

    /// What was found last.
    pub(super) fn found(&self) -> Found {
        self.found.clone()
    }

    /// The cells of a picture as rays read them, unless they are those of the picture before.
    pub(super) fn update(&mut self, gpu: &Gpu, shot: &Shot<'_>, values: &Values) -> Result<Option<Image>, RenderError> {
        let start = Instant::now();
        let side_of = |texels| side(gpu, shot, texels);
        if let Decider::Unmade(texels) = self.decider
            && side_of(texels) > 0
        {
            self.decider = Decider::new(&self.library, shot, |texels| side_of(texels) > 0)?;
        }
        let few = || (None, Err::<(Vec<bool>, bool), String>("so few samples are not worth it".into()));
        let (key, empty) = match &mut self.decider {
            Decider::Unmade(_) => few(),
            Decider::Unbounded(why) => (None, Err(why.clone())),
            Decider::Made(bounded) => match Boxes::of(shot, side_of(bounded.texels)) {
                Boxes { side: 0, .. } => few(),
                boxes => {
                    let read = bounded.fill(values)?;
                    if self.key.as_ref().is_some_and(|(before, of)| *before == read && *of == boxes) {
                        return Ok(None);
                    }
                    let proven = bounded.proven(&boxes, &read).map_err(|error| error.to_string());
                    (Some((read, boxes)), proven)
                }
            },
        };
        let empty = empty.and_then(|(empty, kept)| match empty.contains(&true) {
            true => Ok((empty, kept)),
            false => Err("no bounds prove that there is no matter".to_string()),
        });
        let before = std::mem::replace(&mut self.key, key);
        Ok(match (&self.key, empty) {
            (Some((_, Boxes { side, .. })), Ok((empty, kept))) => {
                let part = empty.iter().filter(|&&empty| empty).count() as f32 / empty.len() as f32;
                let image = image(gpu, *side, &distances(&empty, *side as usize))?;
                let ms = start.elapsed().as_secs_f64() * 1e3;
                self.found = Found { side: *side, empty: part, ms, kept, why: None };
                Some(image)
            }
            (_, why) => {
                self.found = Found { why: why.err(), ..Found::default() };
                before.is_some().then(|| open(gpu)).transpose()?
            }
        })
    }
}

/// One cell, which may hold matter.
pub(super) fn open(gpu: &Gpu) -> Result<Image, RenderError> {
    image(gpu, 1, &[0])
}

fn image(gpu: &Gpu, side: u32, texels: &[u8]) -> Result<Image, RenderError> {
    Ok(Image::sampled(gpu, "cells", Dimension::Volume(side, side, side), Format::R8Unorm, texels)?)
}

/// Cells along a side that pay for a picture; 0 for none.
fn side(gpu: &Gpu, shot: &Shot<'_>, texels: u64) -> u32 {
    let scene = shot.scene;
    let pictures = if scene.camera.shutter == 0.0 { scene.quality.supersampling } else { 1 };
    let [width, height] = shot.whole.map(f64::from);
    let samples = width * height * f64::from(shot.planes.count) * f64::from(pictures) * unskipped(shot);
    let of_a_cell = if gpu.info().cpu { SAMPLES } else { SAMPLES_OF_A_GPU };
    let levels = (samples / of_a_cell).cbrt().log2().floor().clamp(0.0, 8.0);
    let side = 1 << levels as u32;
    let pays = side >= SIDES[0] && samples >= texels as f64 * SAMPLES_OF_A_TEXEL;
    if pays { side.min(SIDES[1]) } else { 0 }
}

/// About which part of a ray's samples the distance to the objects does not show to be empty.
fn unskipped(shot: &Shot<'_>) -> f64 {
    let near = shot.view.objects.iter().map(|own| {
        let inner_iso = match own.name.as_str() {
            "" => shot.scene.object.inner_iso,
            name => shot.scene.parts[name].object.inner_iso,
        };
        own.scale * (own.spread.moves.span() + own.outer_iso - inner_iso)
    });
    f64::from((near.fold(0.0, f32::max) / shot.view.extent.radius).min(1.0))
}

impl Decider {
    /// For the program of a shot, if it `pays` to read so many texels.
    fn new(library: &Library, shot: &Shot<'_>, pays: impl Fn(u64) -> bool) -> Result<Decider, RenderError> {
        let program = shot.variant.cells(shot.scene, library)?.program(library, Linker::new)?;
        let octaves = [(OCTAVES_ID, shot.scene.effect.octaves)];
        let code = match exact::Program::read_channel(&program.fragment, &octaves, (0, 3)) {
            Ok(code) => code,
            Err(error) => return Ok(Decider::Unbounded(error.to_string())),
        };
        let outline = code.outline();
        let Inputs { mut images, samplers, .. } = Inputs::new(library, shot, &program, &|_| ())?;
        images.retain(|(binding, _)| outline.images.iter().any(|(image, _)| image == binding));
        if let Some((_, image)) = images.iter().find(|(_, image)| image.format == Format::Rgba8Unorm) {
            let why = format!("the {} has 8 bits, and so have its interpolated values on some devices", image.name);
            return Ok(Decider::Unbounded(why));
        }
        let texels = images.iter().map(|(_, image)| image.bytes().len() as u64 / image.format.bytes()).sum();
        if texels > MOST_TEXELS {
            let why = format!("its images have {texels} texels, and bounds read at most {MOST_TEXELS}");
            return Ok(Decider::Unbounded(why));
        }
        if !pays(texels) {
            return Ok(Decider::Unmade(texels));
        }
        let mut hash = blake3::Hasher::new();
        hash.update(outline.hash.as_bytes());
        for (binding, image) in &images {
            hash.update(format!("{binding} {:?} {:?}", image.dimension, image.format).as_bytes());
            hash.update(blake3::hash(image.bytes()).as_bytes());
        }
        samplers.iter().for_each(|(binding, filter)| {
            hash.update(format!("{binding} {:?}", filter.address).as_bytes());
        });
        let hash = hash.finalize();
        let images = images.iter().map(|(binding, image)| (*binding, texture(image))).collect();
        let samplers = samplers.iter().map(|(binding, filter)| (*binding, wrap(filter.address))).collect();
        let inputs = exact::Inputs { blocks: BTreeMap::new(), images, samplers };
        Ok(Decider::Made(Box::new(Bounded { program, code, outline, inputs, texels, hash })))
    }
}

impl Bounded {
    /// Sets what the program reads beside images; what depends on it, in bits.
    fn fill(&mut self, values: &Values) -> Result<Vec<u64>, RenderError> {
        let filled = blocks(&self.program, values)?.into_iter();
        self.inputs.blocks = filled.map(|(resource, bytes)| (resource.binding, bytes)).collect();
        Ok(self.code.values(&self.outline, &self.inputs.blocks)?)
    }

    /// Which cells are proven to be empty by what [`Bounded::fill`] gave, and whether that was kept on disk.
    fn proven(&self, boxes: &Boxes, read: &[u64]) -> Result<(Vec<bool>, bool), exact::ExactError> {
        let key = self.key(boxes, read);
        let count = (boxes.side as usize).pow(3);
        if let Some(empty) = disk_cache::load(KIND, key).and_then(|bytes| unpacked(&bytes, count)) {
            return Ok((empty, true));
        }
        let start = Instant::now();
        let empty = self.empty(boxes)?;
        if start.elapsed().as_secs_f64() * 1e3 > KEPT_FROM_MS {
            disk_cache::save(KIND, key, &packed(&empty));
        }
        Ok((empty, false))
    }

    /// The hash of all that the proofs depend on.
    fn key(&self, boxes: &Boxes, read: &[u64]) -> blake3::Hash {
        blake3::hash(format!("{VERSION} {:?} {boxes:?} {read:?}", self.hash).as_bytes())
    }

    /// Which cells are proven to be empty, x fastest.
    fn empty(&self, boxes: &Boxes) -> Result<Vec<bool>, exact::ExactError> {
        let bound = self.code.bind(&self.inputs)?;
        let mut empty = vec![false; (boxes.side as usize).pow(3)];
        let mut side = SIDES[0].min(boxes.side);
        let mut open: Vec<[u32; 3]> = children([0; 3], side).collect();
        loop {
            let is_empty = |cells: &[[u32; 3]]| {
                let places = cells.iter().map(|cell| boxes.cell(*cell, side).map(Device)).collect();
                let lanes = exact::Lanes { fragment_coordinates: Vec::new(), varyings: [(0, places)].into() };
                let (outputs, operations) = bound.measure::<Device>(&lanes)?;
                Ok((outputs[&0].iter().map(|[alpha, ..]| alpha.0.hi <= 0.0).collect(), operations))
            };
            let decided: Vec<(Vec<bool>, u64)> =
                open.par_chunks(BOXES).map(is_empty).collect::<Result<_, exact::ExactError>>()?;
            let of_a_box = decided.iter().map(|(_, operations)| operations).sum::<u64>() / open.len() as u64;
            let scale = boxes.side / side;
            let (mut next, mut found) = (Vec::new(), 0);
            for (cell, is_empty) in open.iter().zip(decided.into_iter().flat_map(|(empty, _)| empty)) {
                if is_empty {
                    found += 1;
                    for [x, y, z] in children(*cell, scale) {
                        empty[((z * boxes.side + y) * boxes.side + x) as usize] = true;
                    }
                } else if scale > 1 {
                    next.extend(children(*cell, 2));
                }
            }
            let vain = side >= TRIED && found * LEAST_FOUND < open.len();
            if next.is_empty() || vain || of_a_box * next.len() as u64 > OPERATIONS {
                return Ok(empty);
            }
            (open, side) = (next, 2 * side);
        }
    }
}

/// Eight truths in a byte.
fn packed(truths: &[bool]) -> Vec<u8> {
    let byte = |eight: &[bool]| eight.iter().rev().fold(0, |byte, &truth| byte << 1 | u8::from(truth));
    truths.chunks(8).map(byte).collect()
}

/// So many truths, where the bytes hold as many.
fn unpacked(bytes: &[u8], count: usize) -> Option<Vec<bool>> {
    let truth = |index: usize| bytes[index / 8] >> (index % 8) & 1 == 1;
    (bytes.len() == count.div_ceil(8)).then(|| (0..count).map(truth).collect())
}

/// The cells that a cell is divided into, so many along each side.
fn children(cell: [u32; 3], count: u32) -> impl Iterator<Item = [u32; 3]> {
    let first = cell.map(|at| at * count);
    (0..count.pow(3)).map(move |k| [first[0] + k % count, first[1] + k / count % count, first[2] + k / count.pow(2)])
}

impl Boxes {
    fn of(shot: &Shot<'_>, side: u32) -> Boxes {
        let [low, high] = [shot.view.box_min, shot.view.box_max].map(|end| end.to_array().map(f64::from));
        let far = f64::from(shot.view.extent.distance + shot.view.extent.radius);
        let margin = [0, 1, 2].map(|axis| MARGIN * (high[axis] - low[axis]) / f64::from(side.max(1)) + PLACE * far);
        Boxes { low, high, side, margin }
    }

    /// The box of one of so many cells along a side, a little larger than it is.
    fn cell(&self, cell: [u32; 3], side: u32) -> [Interval; 4] {
        let of = |axis: usize, at: u32| {
            self.low[axis] + (self.high[axis] - self.low[axis]) * f64::from(at) / f64::from(side)
        };
        let [x, y, z] = [0, 1, 2].map(|axis| Interval {
            lo: of(axis, cell[axis]) - self.margin[axis],
            hi: of(axis, cell[axis] + 1) + self.margin[axis],
        });
        [x, y, z, Interval { lo: 0.0, hi: 0.0 }]
    }
}

/// How many cells it is from each to one that may hold matter, along the axis where that is farthest; 0 for such a one.
fn distances(empty: &[bool], side: usize) -> Vec<u8> {
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

#[cfg(test)]
mod tests;
