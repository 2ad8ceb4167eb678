//! Proofs of empty cells, by evaluating a program of the scene over boxes.
//!
//! Invariant: the disk cache keeps slow proofs under a hash of all that they depend on.

use super::bounded_noise;
use crate::eval::{self, F32Interval, Fingerprint, Interval};
use crate::noise::Lattice;
use crate::render::camera::FrameContext;
use crate::render::error::RenderError;
use crate::render::inputs::{ImageInfo, Inputs, Values, apart, blocks_at, texture, wrap};
use crate::render::variant::{ImageInput, OCTAVES_ID, Program, Purpose, Resource, Variant, VariantError};
use crate::shader::{Library, Linker};
use hypertexture_support::disk_cache::{self, CacheKind};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// Lowest and highest number of cells along a side.
pub(super) const SIDES: [u32; 2] = [4, 64];
/// Largest number of texels that bounds read; each takes 21 bytes.
const MOST_TEXELS: u64 = 1 << 24;
/// Growth of a cell for the rounding of sample positions, relative to its side.
const MARGIN: f64 = 1e-3;
/// Rounding error of a sample position, relative to its distance from the eye.
const PLACE: f64 = 1e-6;
/// Always refine to 16^3 cells; refine further only if at least 1 in 32 boxes was empty.
const FREE_SIDE: u32 = 16;
const LEAST_FOUND: usize = 32;
/// Largest number of scalar operations for finer boxes: some seconds.
const OPERATIONS: u64 = 4_000_000_000;
/// Boxes that a thread evaluates at a time.
const BOXES: usize = 512;
/// Polling interval of `stop` during the loading of images.
const POLL: Duration = Duration::from_micros(200);
/// Stack size of the loading thread, bytes: programs of tables recurse deeply.
pub(super) const STACK: usize = 16 << 20;

/// Shortest time of a proof that is kept on disk, milliseconds. Lower: dragging a slider fills the disk.
const KEPT_FROM_MS: f64 = 20.0;
/// Some ten thousand proofs.
const KIND: CacheKind = CacheKind { ends: &["cells"], limit: 64 << 20 };
/// Increment when proofs change.
const VERSION: u32 = 3;

/// Prover of a program's cells, loaded for the first picture that it pays for.
pub(super) enum CellProver {
    /// Not loaded; a lower bound of the texels of its images.
    Idle(u64),
    /// A thread reads its images, with this number of texels; takes a fraction of a second.
    Loading(u64, Option<JoinHandle<Result<BoundedProgram, RenderError>>>),
    Ready(Box<BoundedProgram>),
    /// Bounds do not exist, for this reason.
    Unavailable(String),
}

/// A program that decides where matter is, with its inputs.
pub(super) struct BoundedProgram {
    pub(super) reads: Arc<Reads>,
    pub(super) code: eval::Program,
    fingerprint: Fingerprint,
    pub(super) inputs: eval::Inputs,
    pub(super) texels: u64,
    /// Hash of the program, its images and their filters.
    hash: blake3::Hash,
}

/// Uniforms that a program reads.
pub(super) struct Reads {
    program: Program,
    /// Block members that it reads.
    members: BTreeSet<(u32, u32)>,
}

/// A box in object space, divided into cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct CellGrid {
    low: [f64; 3],
    high: [f64; 3],
    /// Cells along each side, a power of two.
    pub(super) side: u32,
    /// Growth of cells for rounding, object units.
    margin: [f64; 3],
}

/// The program that decides where matter is, and the noise that it looks up.
pub(super) fn deciding(variant: &Variant, library: &Library) -> Result<(Program, Option<Lattice>), VariantError> {
    let variant = variant.for_purpose(Purpose::Cells, library)?;
    match bounded_noise::bounded(&variant, library) {
        Some((program, noise)) => Ok((program, Some(noise))),
        None => Ok((variant.program(library, Linker::new)?, None)),
    }
}

impl CellProver {
    /// Starts the loading of a prover if it `pays` to read its number of texels.
    pub(super) fn new(
        library: &Library,
        frame: &FrameContext,
        image_of: &dyn Fn(&str) -> Option<ImageInfo>,
        pays: impl Fn(u64) -> bool,
    ) -> Result<CellProver, RenderError> {
        let (program, noise) = match deciding(&frame.variant, library) {
            Ok(deciding) => deciding,
            Err(error) => return Ok(CellProver::Unavailable(error.to_string())),
        };
        let octaves = [(OCTAVES_ID, frame.variant.scene.effect.octaves)];
        let code = match eval::Program::read_channel(&program.fragment, &octaves, (0, 3)) {
            Ok(code) => code,
            Err(error) => return Ok(CellProver::Unavailable(error.to_string())),
        };
        let fingerprint = code.fingerprint();
        let is_read = |binding: &u32| fingerprint.images.iter().any(|(image, _)| image == binding);
        let read = program.resources.iter().filter(|resource| is_read(&resource.binding));
        let read = read
            .filter(|resource| noise.is_none() || Some(resource.binding) != program.image(bounded_noise::LOOKED_UP));
        let read: Vec<ImageInfo> = read.filter_map(|resource| image_of(&resource.name)).collect();
        if let Some(image) = read.iter().find(|image| (image.channels, image.bits) == (4, 8)) {
            let why = format!("the {} has 8 bits, and some devices interpolate it with 8 bits", image.name);
            return Ok(CellProver::Unavailable(why));
        }
        let texels = read.iter().map(|image| image.size.map(u64::from).iter().product::<u64>()).sum();
        if texels > MOST_TEXELS {
            let why = format!("its images have {texels} texels, and bounds read at most {MOST_TEXELS}");
            return Ok(CellProver::Unavailable(why));
        }
        if !pays(texels) {
            return Ok(CellProver::Idle(texels));
        }
        let (library, frame) = (library.clone(), frame.clone());
        let read = move || BoundedProgram::new(&library, &frame, (program, code, fingerprint), (texels, noise));
        Ok(match thread::Builder::new().stack_size(STACK).spawn(read) {
            Ok(thread) => CellProver::Loading(texels, Some(thread)),
            Err(error) => CellProver::Unavailable(format!("cannot start a thread: {error}")),
        })
    }

    /// Waits for the loading thread, unless told to `stop`.
    pub(super) fn wait(&mut self, stop: &dyn Fn() -> bool) -> Result<(), RenderError> {
        let CellProver::Loading(_, thread) = self else { return Ok(()) };
        while thread.as_ref().is_some_and(|thread| !thread.is_finished()) {
            if stop() {
                return Err(RenderError::Stopped);
            }
            thread::sleep(POLL);
        }
        match thread.take().map(JoinHandle::join) {
            Some(Ok(bounded)) => *self = CellProver::Ready(Box::new(bounded?)),
            Some(Err(reason)) => std::panic::resume_unwind(reason),
            None => *self = CellProver::Idle(0),
        }
        Ok(())
    }
}

impl BoundedProgram {
    /// Encodes the images of a program, without the noise that it looks up.
    fn new(
        library: &Library,
        frame: &FrameContext,
        (mut program, code, fingerprint): (Program, eval::Program, Fingerprint),
        (texels, noise): (u64, Option<Lattice>),
    ) -> Result<BoundedProgram, RenderError> {
        let place = program.image(bounded_noise::LOOKED_UP).filter(|_| noise.is_some());
        program.resources.retain(|resource| Some(resource.binding) != place);
        let Inputs { mut images, samplers, .. } = Inputs::new(library, frame, &program, &|_| ())?;
        images.retain(|(binding, _)| fingerprint.images.iter().any(|(image, _)| image == binding));
        let mut hash = blake3::Hasher::new();
        hash.update(fingerprint.hash.as_bytes());
        for (binding, image) in &images {
            hash.update(format!("{binding} {:?} {:?}", image.dimension, image.format).as_bytes());
            hash.update(blake3::hash(&image.bytes).as_bytes());
        }
        samplers.iter().for_each(|(binding, filter)| {
            hash.update(format!("{binding} {:?}", filter.address).as_bytes());
        });
        hash.update(format!("{noise:?}").as_bytes());
        let hash = hash.finalize();
        let images = images.iter().map(|(binding, image)| (*binding, texture(image))).collect();
        let of_device = |own: &Resource| match own.image()? {
            (ImageInput::Noise(image), _) => Some((own.binding, apart(&frame.variant.scene, image)?)),
            _ => None,
        };
        let inexact = program.resources.iter().filter_map(of_device).collect();
        let samplers = samplers.iter().map(|(binding, filter)| (*binding, wrap(filter.address))).collect();
        let noises = place.zip(noise).into_iter().collect();
        let inputs = eval::Inputs { images, samplers, noises, inexact, ..eval::Inputs::default() };
        let reads = Arc::new(Reads { members: program.members_read(), program });
        Ok(BoundedProgram { reads, code, fingerprint, inputs, texels, hash })
    }

    /// Sets the uniforms for the time span from `time` to `until`. Returns the bits of all values that depend on them
    /// at `time`.
    pub(super) fn fill(&mut self, values: &Values, [time, until]: [f32; 2]) -> Result<Vec<u64>, RenderError> {
        self.inputs.blocks = blocks_at(&self.reads.program, values, time)?;
        self.inputs.until = if until > time { blocks_at(&self.reads.program, values, until)? } else { BTreeMap::new() };
        if self.inputs.until == self.inputs.blocks {
            self.inputs.until.clear(); // independent of time
        }
        Ok(self.code.values(&self.fingerprint, &self.inputs.blocks)?)
    }

    /// Proves cells for the uniforms of [`BoundedProgram::fill`]: emptiness, and whether the proof came from the disk
    /// cache, which holds proofs of single moments. `None` when told to `stop`.
    pub(super) fn proven(
        &self,
        boxes: &CellGrid,
        read: &[u64],
        stop: &dyn Fn() -> bool,
    ) -> Result<Option<(Vec<bool>, bool)>, eval::ExactError> {
        let key = self.key(boxes, read);
        let count = (boxes.side as usize).pow(3);
        if !self.inputs.until.is_empty() {
            return Ok(self.empty(boxes, stop)?.map(|empty| (empty, false)));
        }
        if let Some(empty) = disk_cache::load(KIND, key).and_then(|bytes| unpacked(&bytes, count)) {
            return Ok(Some((empty, true)));
        }
        let start = Instant::now();
        let Some(empty) = self.empty(boxes, stop)? else { return Ok(None) };
        if start.elapsed().as_secs_f64() * 1e3 > KEPT_FROM_MS {
            disk_cache::save(KIND, key, &packed(&empty));
        }
        Ok(Some((empty, false)))
    }

    /// Hash of all that the proofs depend on.
    pub(super) fn key(&self, boxes: &CellGrid, read: &[u64]) -> blake3::Hash {
        blake3::hash(format!("{VERSION} {:?} {boxes:?} {read:?}", self.hash).as_bytes())
    }

    /// Emptiness of each cell, x fastest; `None` when told to `stop`.
    pub(super) fn empty(
        &self,
        boxes: &CellGrid,
        stop: &dyn Fn() -> bool,
    ) -> Result<Option<Vec<bool>>, eval::ExactError> {
        let bound = self.code.bind(&self.inputs)?;
        let mut empty = vec![false; (boxes.side as usize).pow(3)];
        let mut side = SIDES[0].min(boxes.side);
        let mut open: Vec<[u32; 3]> = children([0; 3], side).collect();
        loop {
            let is_empty = |cells: &[[u32; 3]]| {
                let places = cells.iter().map(|cell| boxes.cell(*cell, side).map(F32Interval)).collect();
                let lanes = eval::Invocations { fragment_coordinates: Vec::new(), varyings: [(0, places)].into() };
                let (outputs, operations) = bound.measure::<F32Interval>(&lanes)?;
                Ok((outputs[&0].iter().map(|[alpha, ..]| alpha.0.hi <= 0.0).collect(), operations))
            };
            let mut decided: Vec<(Vec<bool>, u64)> = Vec::new();
            for boxes in open.chunks(BOXES * rayon::current_num_threads()) {
                if stop() {
                    return Ok(None);
                }
                decided.extend(boxes.par_chunks(BOXES).map(is_empty).collect::<Result<Vec<_>, eval::ExactError>>()?);
            }
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
            let vain = side >= FREE_SIDE && found * LEAST_FOUND < open.len();
            if next.is_empty() || vain || of_a_box * next.len() as u64 > OPERATIONS {
                return Ok(Some(empty));
            }
            (open, side) = (next, 2 * side);
        }
    }
}

impl Reads {
    /// Bytes of the uniforms that the program reads, except the time.
    pub(super) fn timeless(&self, values: &Values) -> Result<Vec<u8>, RenderError> {
        Ok(self.program.parts_read(&self.members, &blocks_at(&self.program, values, 0.0)?))
    }
}

/// Packs eight booleans into a byte.
pub(super) fn packed(truths: &[bool]) -> Vec<u8> {
    let byte = |eight: &[bool]| eight.iter().rev().fold(0, |byte, &truth| byte << 1 | u8::from(truth));
    truths.chunks(8).map(byte).collect()
}

/// Unpacks `count` booleans; `None` for another number of bytes.
pub(super) fn unpacked(bytes: &[u8], count: usize) -> Option<Vec<bool>> {
    let truth = |index: usize| bytes[index / 8] >> (index % 8) & 1 == 1;
    (bytes.len() == count.div_ceil(8)).then(|| (0..count).map(truth).collect())
}

/// Children of a cell that is divided into `count` parts along each side.
fn children(cell: [u32; 3], count: u32) -> impl Iterator<Item = [u32; 3]> {
    let first = cell.map(|at| at * count);
    (0..count.pow(3)).map(move |k| [first[0] + k % count, first[1] + k / count % count, first[2] + k / count.pow(2)])
}

impl CellGrid {
    pub(super) fn of(frame: &FrameContext, side: u32) -> CellGrid {
        let [low, high] = [frame.view.box_min, frame.view.box_max].map(|end| end.to_array().map(f64::from));
        let far = f64::from(frame.view.reaches()[1]);
        let margin = [0, 1, 2].map(|axis| MARGIN * (high[axis] - low[axis]) / f64::from(side.max(1)) + PLACE * far);
        CellGrid { low, high, side, margin }
    }

    /// Grows the margin of cells, for cameras that are farther away by this factor.
    pub(super) fn wider(self, times: f64) -> CellGrid {
        CellGrid { margin: self.margin.map(|margin| times * margin), ..self }
    }

    /// Whether proofs for these cells hold for others.
    pub(super) fn hold_for(&self, other: &CellGrid) -> bool {
        let wide = self.margin.iter().zip(&other.margin).all(|(own, other)| own >= other);
        wide && (self.low, self.high, self.side) == (other.low, other.high, other.side)
    }

    /// Box of a cell in a grid of `side` cells, grown by the margin.
    pub(super) fn cell(&self, cell: [u32; 3], side: u32) -> [Interval; 4] {
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
