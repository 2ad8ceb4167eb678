//! Fingerprints: what a program computes, apart from the layout of its uniforms.
//!
//! Invariant: two programs with equal fingerprints and equal uniform values are the same function of the same images.
//! Unread code and unread parts of uniform blocks make no difference.

use crate::bind::{BoundProgram, Constant, UniformCache, constant};
use crate::code::{File, Node, Op, Reg, Source};
use crate::error::ExactError;
use crate::number::Bool;
use crate::program::{Inputs, Program};
use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap};

/// Identity of what a program computes.
#[derive(Clone, Debug)]
pub struct Fingerprint {
    /// Hash of the instructions.
    pub hash: blake3::Hash,
    /// Bindings of the images, each with its sampler.
    pub images: Vec<(u32, Option<u32>)>,
    /// The uniform registers, in the order of their first reads.
    uniforms: Vec<Reg>,
}

/// Numbers uniform registers by their first use.
#[derive(Default)]
struct Order {
    places: HashMap<Reg, u32>,
    regs: Vec<Reg>,
}

impl Order {
    fn place(&mut self, reg: &mut Reg) {
        if reg.uniform {
            let next = self.regs.len() as u32;
            let place = *self.places.entry(*reg).or_insert(next);
            if place == next {
                self.regs.push(*reg);
            }
            reg.index = place;
        }
    }
}

impl Program {
    /// The fingerprint of the program.
    pub fn fingerprint(&self) -> Fingerprint {
        let code = &self.code;
        let order = RefCell::new(Order::default());
        let swap = |reg: &mut Reg| order.borrow_mut().place(reg);
        let mut hasher = blake3::Hasher::new();
        let mut images = Vec::new();
        for instr in &code.instrs {
            let mut instr = *instr;
            let mut others: Vec<Reg> = Vec::new();
            if matches!(instr.op, Op::Sample | Op::Fetch) {
                let lookup = &code.lookups[instr.table as usize];
                let pair = code.images[lookup.image];
                if !images.contains(&(pair.image, pair.sampler)) {
                    images.push((pair.image, pair.sampler));
                }
                hasher.update(format!("{pair:?} {:?}", lookup.channels).as_bytes());
                others.clone_from(&lookup.at);
                (instr.dst, instr.sources, instr.table) = (others[0], [others[0]; 3], 0);
                instr.dst.uniform = false; // the channels are written instead
            } else if instr.op == Op::Gather {
                others.clone_from(&code.tables[instr.table as usize]);
                instr.table = 0;
            }
            instr.sources.iter_mut().chain(&mut others).for_each(swap);
            hasher.update(format!("{instr:?} {others:?}").as_bytes());
        }
        let mut body: Vec<Node> = code.body.clone();
        body.iter_mut().for_each(|node| node.each_condition(&swap));
        let mut outputs = code.outputs.clone();
        outputs.iter_mut().flat_map(|(_, regs)| regs).for_each(swap);
        hasher.update(format!("{body:?} {:?} {outputs:?}", code.inputs).as_bytes());
        Fingerprint { hash: hasher.finalize(), images, uniforms: order.into_inner().regs }
    }

    /// Values of the uniforms, in the order of the fingerprint.
    ///
    /// # Errors
    /// [`ExactError::Missing`] and [`ExactError::Unfit`].
    pub fn values(&self, fingerprint: &Fingerprint, blocks: &BTreeMap<u32, Vec<u8>>) -> Result<Vec<u64>, ExactError> {
        let inputs = Inputs::default();
        let value = |(reg, source): &(Reg, Source)| match source {
            Source::Size { signed, .. } => Ok(Constant::Int(0, *signed)), // fixed by the image
            source => constant(&inputs, blocks, reg.file, *source),
        };
        let values = self.code.sources.iter().map(value).collect::<Result<_, _>>()?;
        let (floats, ints, bools) =
            BoundProgram { code: &self.code, images: Vec::new(), values, uniforms: UniformCache::default() }
                .uniforms::<f64>();
        let read = |reg: &Reg| match reg.file {
            File::Float => floats[reg.index as usize].to_bits(),
            File::Int => u64::from(ints[reg.index as usize]),
            File::Bool => u64::from(bools[reg.index as usize].may_hold()),
        };
        Ok(fingerprint.uniforms.iter().map(read).collect())
    }
}
