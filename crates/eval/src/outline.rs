//! What a program computes, apart from where its numbers stand.
//!
//! Invariant: two programs with equal outlines, over blocks that give equal values, are the same function of the same
//! images: what nothing reads, and what a block holds for others, makes no difference.

use super::code::{Node, Op, Reg, Source};
use super::number::Truth;
use super::optimizer::each_condition;
use super::uniforms::Known;
use super::{BoundProgram, ExactError, Inputs, Program, Start, start};
use std::cell::RefCell;
use std::collections::{BTreeMap, HashMap};

/// What a program computes.
#[derive(Clone, Debug)]
pub struct Outline {
    /// Its instructions, in one number.
    pub hash: blake3::Hash,
    /// The images that it reads, each with its sampler: their bindings.
    pub images: Vec<(u32, Option<u32>)>,
    /// The values from outside, in the order in which they are first read.
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
    /// What the program computes.
    pub fn outline(&self) -> Outline {
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
                instr.dst.uniform = false; // it writes the channels
            } else if instr.op == Op::Gather {
                others.clone_from(&code.tables[instr.table as usize]);
                instr.table = 0;
            }
            instr.sources.iter_mut().chain(&mut others).for_each(swap);
            hasher.update(format!("{instr:?} {others:?}").as_bytes());
        }
        let mut body: Vec<Node> = code.body.clone();
        each_condition(&mut body, &swap);
        let mut outputs = code.outputs.clone();
        outputs.iter_mut().flat_map(|(_, regs)| regs).for_each(swap);
        hasher.update(format!("{body:?} {:?} {outputs:?}", code.inputs).as_bytes());
        Outline { hash: hasher.finalize(), images, uniforms: order.into_inner().regs }
    }

    /// The values that come from outside, as the blocks have them, in the order of the outline.
    ///
    /// # Errors
    /// A block is missing or too short.
    pub fn values(&self, outline: &Outline, blocks: &BTreeMap<u32, Vec<u8>>) -> Result<Vec<u64>, ExactError> {
        let inputs = Inputs::default();
        let value = |(reg, source): &(Reg, Source)| match source {
            Source::Size { signed, .. } => Ok(Start::Int(0, *signed)), // that of an image is known with the image
            source => start((&inputs, blocks), reg.file, *source),
        };
        let values = self.code.sources.iter().map(value).collect::<Result<_, _>>()?;
        let (floats, ints, truths) =
            BoundProgram { code: &self.code, images: Vec::new(), values, known: Known::default() }.uniforms::<f64>();
        let read = |reg: &Reg| match reg.file {
            super::code::File::Float => floats[reg.index as usize].to_bits(),
            super::code::File::Int => u64::from(ints[reg.index as usize]),
            super::code::File::Truth => u64::from(truths[reg.index as usize].may_hold()),
        };
        Ok(outline.uniforms.iter().map(read).collect())
    }
}
