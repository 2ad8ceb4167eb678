//! What decides which cells hold no matter: a program of the scene, evaluated over boxes.
//!
//! Role: the images and values of a picture -> for each cell whether it is proven to be empty. Invariant: proofs that took
//! long are kept on disk under all that they depend on.

use super::super::cpu_inputs::{texture, wrap};
use super::super::inputs::Inputs;
use super::super::shot::Shot;
use super::super::values::{TIME, Values, blocks};
use super::super::{OCTAVES_ID, Read, RenderError};
use super::ranged;
use crate::eval::{self, F32Interval, Fingerprint, Interval};
use crate::noise::Lattice;
use crate::render::variant::{Program, Resource, Variant, VariantError};
use crate::scene::Scene;
use crate::shader::{Library, Linker};
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};
use support::disk_cache::{self, Kind};

/// Cells along a side, at least and at most.
pub(super) const SIDES: [u32; 2] = [4, 64];
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
/// While images are read, whether to stop is asked this often.
const LOOK: Duration = Duration::from_micros(200);
/// Bytes of the stack of the thread that reads them: programs of tables are walked deeply.
pub(super) const STACK: usize = 16 << 20;

/// Proofs that take longer are kept on disk, milliseconds. Less: a value that is pulled fills the disk.
const KEPT_FROM_MS: f64 = 20.0;
/// Some ten thousand proofs.
const KIND: Kind = Kind { ends: &["cells"], limit: 64 << 20 };
/// Counts up where proofs change.
const VERSION: u32 = 2;

/// What decides, made for the first picture that it pays for.
pub(super) enum Decider {
    /// Not made yet; its images have at least so many texels.
    Unmade(u64),
    /// It reads its images, which have so many texels, on a thread of its own: a part of a second.
    Coming(u64, Option<JoinHandle<Result<Bounded, RenderError>>>),
    Made(Box<Bounded>),
    /// There are no bounds, and why.
    Unbounded(String),
}

/// A program that says where matter is, and what it reads.
pub(super) struct Bounded {
    pub(super) reads: Arc<Reads>,
    pub(super) code: eval::Program,
    fingerprint: Fingerprint,
    pub(super) inputs: eval::Inputs,
    pub(super) texels: u64,
    /// That of the program, and of its images and how they are filtered.
    hash: blake3::Hash,
}

/// What a program reads of the values of a picture.
pub(super) struct Reads {
    program: Program,
    /// The members of blocks that it reads.
    members: BTreeSet<(u32, u32)>,
}

/// A box in object space and how it is divided.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Boxes {
    low: [f64; 3],
    high: [f64; 3],
    /// Cells along each side, a power of two.
    pub(super) side: u32,
    /// How much larger than they are cells are taken, object units.
    margin: [f64; 3],
}

/// The program that says where matter is, and the noise that it looks up.
pub(super) fn deciding(
    variant: &Variant,
    scene: &Scene,
    library: &Library,
) -> Result<(Program, Option<Lattice>), VariantError> {
    let variant = variant.cells(scene, library)?;
    match ranged::bounded(&variant, library) {
        Some((program, noise)) => Ok((program, Some(noise))),
        None => Ok((variant.program(library, Linker::new)?, None)),
    }
}

impl Decider {
    /// For the program of a shot, if it `pays` to read so many texels of images.
    pub(super) fn new(
        library: &Library,
        shot: &Shot<'_>,
        image_of: &dyn Fn(&str) -> Option<Read>,
        pays: impl Fn(u64) -> bool,
    ) -> Result<Decider, RenderError> {
        let (program, noise) = match deciding(shot.variant, shot.scene, library) {
            Ok(deciding) => deciding,
            Err(error) => return Ok(Decider::Unbounded(error.to_string())),
        };
        let octaves = [(OCTAVES_ID, shot.scene.effect.octaves)];
        let code = match eval::Program::read_channel(&program.fragment, &octaves, (0, 3)) {
            Ok(code) => code,
            Err(error) => return Ok(Decider::Unbounded(error.to_string())),
        };
        let fingerprint = code.fingerprint();
        let is_read = |binding: &u32| fingerprint.images.iter().any(|(image, _)| image == binding);
        let read = program.resources.iter().filter(|resource| is_read(&resource.binding));
        let read = read.filter(|resource| noise.is_none() || resource.name != ranged::LOOKED_UP);
        let read: Vec<Read> = read.filter_map(|resource| image_of(&resource.name)).collect();
        if let Some(image) = read.iter().find(|image| (image.channels, image.bits) == (4, 8)) {
            let why = format!("the {} has 8 bits, and so have its interpolated values on some devices", image.name);
            return Ok(Decider::Unbounded(why));
        }
        let texels = read.iter().map(|image| image.size.map(u64::from).iter().product::<u64>()).sum();
        if texels > MOST_TEXELS {
            let why = format!("its images have {texels} texels, and bounds read at most {MOST_TEXELS}");
            return Ok(Decider::Unbounded(why));
        }
        if !pays(texels) {
            return Ok(Decider::Unmade(texels));
        }
        let (library, subject, variant) = (library.clone(), shot.subject.clone(), shot.variant.clone());
        let (scene, whole) = (shot.scene.clone(), shot.whole);
        let read = move || {
            let shot = Shot { whole, ..Shot::of(&scene, &subject, &variant) };
            Bounded::new(&library, &shot, (program, code, fingerprint), (texels, noise))
        };
        Ok(match thread::Builder::new().stack_size(STACK).spawn(read) {
            Ok(thread) => Decider::Coming(texels, Some(thread)),
            Err(error) => Decider::Unbounded(format!("no thread reads its images: {error}")),
        })
    }

    /// Waits until it has read its images; ends where it is to `stop`.
    pub(super) fn wait(&mut self, stop: &dyn Fn() -> bool) -> Result<(), RenderError> {
        let Decider::Coming(_, thread) = self else { return Ok(()) };
        while thread.as_ref().is_some_and(|thread| !thread.is_finished()) {
            if stop() {
                return Err(RenderError::Stopped);
            }
            thread::sleep(LOOK);
        }
        match thread.take().map(JoinHandle::join) {
            Some(Ok(bounded)) => *self = Decider::Made(Box::new(bounded?)),
            Some(Err(reason)) => std::panic::resume_unwind(reason),
            None => *self = Decider::Unmade(0),
        }
        Ok(())
    }
}

impl Bounded {
    /// Reads the images of a program, which have so many texels, beside the noise that it looks up.
    fn new(
        library: &Library,
        shot: &Shot<'_>,
        (mut program, code, fingerprint): (Program, eval::Program, Fingerprint),
        (texels, noise): (u64, Option<Lattice>),
    ) -> Result<Bounded, RenderError> {
        let is_noise = |resource: &&mut Resource| noise.is_some() && resource.name == ranged::LOOKED_UP;
        let place = program.resources.iter_mut().find(is_noise).map(|resource| resource.binding);
        program.resources.retain(|resource| Some(resource.binding) != place);
        let Inputs { mut images, samplers, .. } = Inputs::new(library, shot, &program, &|_| ())?;
        images.retain(|(binding, _)| fingerprint.images.iter().any(|(image, _)| image == binding));
        let mut hash = blake3::Hasher::new();
        hash.update(fingerprint.hash.as_bytes());
        for (binding, image) in &images {
            hash.update(format!("{binding} {:?} {:?}", image.dimension, image.format).as_bytes());
            hash.update(blake3::hash(image.bytes()).as_bytes());
        }
        samplers.iter().for_each(|(binding, filter)| {
            hash.update(format!("{binding} {:?}", filter.address).as_bytes());
        });
        hash.update(format!("{noise:?}").as_bytes());
        let hash = hash.finalize();
        let images = images.iter().map(|(binding, image)| (*binding, texture(image))).collect();
        let samplers = samplers.iter().map(|(binding, filter)| (*binding, wrap(filter.address))).collect();
        let noises = place.zip(noise).into_iter().collect();
        let inputs = eval::Inputs { images, samplers, noises, ..eval::Inputs::default() };
        let reads = Arc::new(Reads { members: program.members_read(), program });
        Ok(Bounded { reads, code, fingerprint, inputs, texels, hash })
    }

    /// Sets what the program reads beside images, from a time on until another; what depends on it at the first, in bits.
    pub(super) fn fill(&mut self, values: &Values, [time, until]: [f32; 2]) -> Result<Vec<u64>, RenderError> {
        self.inputs.blocks = filled(&self.reads.program, values, time)?;
        self.inputs.until = if until > time { filled(&self.reads.program, values, until)? } else { BTreeMap::new() };
        if self.inputs.until == self.inputs.blocks {
            self.inputs.until.clear(); // nothing depends on the time
        }
        Ok(self.code.values(&self.fingerprint, &self.inputs.blocks)?)
    }

    /// Which cells are proven to be empty by what [`Bounded::fill`] gave, and whether that was kept on disk, where proofs of
    /// one time are; none where it was to `stop`.
    pub(super) fn proven(
        &self,
        boxes: &Boxes,
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

    /// The hash of all that the proofs depend on.
    pub(super) fn key(&self, boxes: &Boxes, read: &[u64]) -> blake3::Hash {
        blake3::hash(format!("{VERSION} {:?} {boxes:?} {read:?}", self.hash).as_bytes())
    }

    /// Which cells are proven to be empty, x fastest; none where it was to `stop`.
    pub(super) fn empty(&self, boxes: &Boxes, stop: &dyn Fn() -> bool) -> Result<Option<Vec<bool>>, eval::ExactError> {
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
            let vain = side >= TRIED && found * LEAST_FOUND < open.len();
            if next.is_empty() || vain || of_a_box * next.len() as u64 > OPERATIONS {
                return Ok(Some(empty));
            }
            (open, side) = (next, 2 * side);
        }
    }
}

impl Reads {
    /// What the program reads beside images and the time, in bytes.
    pub(super) fn timeless(&self, values: &Values) -> Result<Vec<u8>, RenderError> {
        let filled = filled(&self.program, values, 0.0)?;
        let blocks = filled.iter().map(|(binding, bytes)| (*binding, bytes.as_slice()));
        Ok(self.program.parts_read(&self.members, blocks))
    }
}

/// The blocks of a program at a time, by binding.
fn filled(program: &Program, values: &Values, time: f32) -> Result<BTreeMap<u32, Vec<u8>>, RenderError> {
    let mut values = values.clone();
    values.insert(TIME.into(), vec![time]);
    let filled = blocks(program, &values)?.into_iter();
    Ok(filled.map(|(resource, bytes)| (resource.binding, bytes)).collect())
}

/// Eight truths in a byte.
pub(super) fn packed(truths: &[bool]) -> Vec<u8> {
    let byte = |eight: &[bool]| eight.iter().rev().fold(0, |byte, &truth| byte << 1 | u8::from(truth));
    truths.chunks(8).map(byte).collect()
}

/// So many truths, where the bytes hold as many.
pub(super) fn unpacked(bytes: &[u8], count: usize) -> Option<Vec<bool>> {
    let truth = |index: usize| bytes[index / 8] >> (index % 8) & 1 == 1;
    (bytes.len() == count.div_ceil(8)).then(|| (0..count).map(truth).collect())
}

/// The cells that a cell is divided into, so many along each side.
fn children(cell: [u32; 3], count: u32) -> impl Iterator<Item = [u32; 3]> {
    let first = cell.map(|at| at * count);
    (0..count.pow(3)).map(move |k| [first[0] + k % count, first[1] + k / count % count, first[2] + k / count.pow(2)])
}

impl Boxes {
    pub(super) fn of(shot: &Shot<'_>, side: u32) -> Boxes {
        let [low, high] = [shot.view.box_min, shot.view.box_max].map(|end| end.to_array().map(f64::from));
        let far = f64::from(shot.view.reaches()[1]);
        let margin = [0, 1, 2].map(|axis| MARGIN * (high[axis] - low[axis]) / f64::from(side.max(1)) + PLACE * far);
        Boxes { low, high, side, margin }
    }

    /// The same with cells that are taken larger: for cameras that are up to so many times as far, and more.
    pub(super) fn wider(self, times: f64) -> Boxes {
        Boxes { margin: self.margin.map(|margin| times * margin), ..self }
    }

    /// Whether what is proven for these holds for others.
    pub(super) fn hold_for(&self, other: &Boxes) -> bool {
        let wide = self.margin.iter().zip(&other.margin).all(|(own, other)| own >= other);
        wide && (self.low, self.high, self.side) == (other.low, other.high, other.side)
    }

    /// The box of one of so many cells along a side, a little larger than it is.
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
