//! Lowered programs: instructions over registers with one scalar for each lane, in structured control flow.
//!
//! Invariant: vectors, matrices, structures, arrays, functions and pointers are lowered to scalars. Instructions are total and have no
//! side effects, so inactive lanes may compute anything in registers that only their own branch reads. A *masked* result
//! is that of a variable, which keeps its value in inactive lanes.

use crate::number::{Binary, Comparison, IntBinary, IntUnary, Unary};

/// The register files.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) enum File {
    Float,
    Int,
    Bool,
}

/// A register, with a value for each lane or a uniform one.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(crate) struct Reg {
    pub file: File,
    pub uniform: bool,
    pub index: u32,
}

/// An operation.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Op {
    /// No operation: a removed instruction.
    Nop,
    Copy,
    Unary(Unary),
    Binary(Binary),
    /// `a * b + c`, both rounded.
    MulAdd,
    Mix,
    Compare(Comparison),
    IsNan,
    IsInfinite,
    ToInt,
    FromInt,
    ToBits,
    FromBits,
    Ldexp,
    /// The second source where the first holds, else the third; for any file.
    Select,
    Int(IntBinary),
    IntUnary(IntUnary),
    Bitcast,
    IntLess,
    IntEqual,
    And,
    Or,
    Not,
    BoolEqual,
    /// An element of a table, by index.
    Gather,
    /// A filtered texture lookup; `table` is an index of [`Code::lookups`].
    Sample,
    /// A texel lookup; `table` is an index of [`Code::lookups`].
    Fetch,
    /// The difference across a quad of lanes, along x or along y.
    Derivative(bool),
}

/// An instruction. The first `count` of `sources` are its operands; the others repeat the first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Instr {
    pub op: Op,
    pub signed: bool,
    pub masked: bool,
    pub dst: Reg,
    pub sources: [Reg; 3],
    pub count: u8,
    pub table: u32,
    pub at: At,
}

/// The place of an instruction, an index of [`Code::places`]. Not part of a fingerprint: all places are equal and print
/// nothing.
#[derive(Clone, Copy, Default)]
pub(crate) struct At(pub u32);

impl std::fmt::Debug for At {
    fn fmt(&self, _: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        Ok(())
    }
}

impl PartialEq for At {
    fn eq(&self, _: &At) -> bool {
        true
    }
}

/// A texture lookup.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Lookup {
    /// Index of [`Code::images`].
    pub image: usize,
    /// Coordinates, then the level if there is one.
    pub at: Vec<Reg>,
    /// Destinations of the channels; `None` for unused ones.
    pub channels: [Option<Reg>; 4],
}

/// An image of 1, 2 or 3 axes, with its sampler.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Pair {
    pub image: u32,
    pub sampler: Option<u32>,
    pub axes: usize,
}

/// Source of a uniform register.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) enum Source {
    Float(u64),
    Int(u32, bool),
    Bool(bool),
    /// A scalar of a uniform block; `signed` matters for integers.
    Block {
        binding: u32,
        offset: u32,
        signed: bool,
    },
    /// The number of texels along an axis.
    Size {
        image: u32,
        axis: usize,
        signed: bool,
    },
}

/// Registers that a part of the program writes and later parts may read.
pub(crate) type Written = Vec<Reg>;

/// Structured control flow over ranges of instructions.
#[derive(Clone, Debug)]
pub(crate) enum Node {
    Run(usize, usize),
    If {
        condition: Reg,
        accept: Vec<Node>,
        reject: Vec<Node>,
        written: Written,
        /// Operands of a condition that is one comparison: it implies that the first is at most the second, and its
        /// negation that the second is at most the first.
        compared: Option<[Reg; 2]>,
    },
    Loop(Box<Loop>),
    Switch {
        selector: Reg,
        cases: Vec<Case>,
        written: Written,
    },
    /// A function: `Return` ends it.
    Scope {
        body: Vec<Node>,
        written: Written,
    },
    Break,
    Continue,
    Return,
    Kill,
}

/// A loop: its body, the block after it and after every `continue`, and the exit condition.
#[derive(Clone, Debug)]
pub(crate) struct Loop {
    pub body: Vec<Node>,
    pub continuing: Vec<Node>,
    pub break_if: Option<Reg>,
    pub written: Written,
    pub returns: bool,
    pub kills: bool,
    pub place: Place,
}

/// File and line, for errors. Not part of a fingerprint: prints nothing.
#[derive(Clone)]
pub(crate) struct Place(pub String);

impl std::fmt::Debug for Place {
    fn fmt(&self, _: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        Ok(())
    }
}

/// A case of a switch, entered for one of `values`, or for all other values if it is the default.
#[derive(Clone, Debug)]
pub(crate) struct Case {
    pub values: Vec<u32>,
    pub default: bool,
    pub body: Vec<Node>,
    /// Whether it falls through to the next case.
    pub falls: bool,
}

/// An input of a lane.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Input {
    Fragment,
    Varying(u32),
}

/// A lowered program.
#[derive(Debug, Default)]
pub(crate) struct Code {
    /// Instructions over uniform registers, run once.
    pub prelude: Vec<Instr>,
    pub instrs: Vec<Instr>,
    pub body: Vec<Node>,
    pub tables: Vec<Vec<Reg>>,
    pub lookups: Vec<Lookup>,
    pub images: Vec<Pair>,
    /// Uniform registers with values from outside or constants.
    pub sources: Vec<(Reg, Source)>,
    /// Number of uniform registers by file.
    pub uniforms: [u32; 3],
    /// Number of other registers by file.
    pub registers: [u32; 3],
    pub inputs: Vec<(Input, usize, Reg)>,
    /// Locations and registers of the outputs.
    pub outputs: Vec<(u32, Vec<Reg>)>,
    /// Whether the program needs quads of lanes.
    pub derivatives: bool,
    /// Files and lines of instructions; the first is for those without one.
    pub places: Vec<String>,
}

impl Instr {
    /// An instruction with some operands, unmasked and of unknown place.
    pub(crate) fn new(op: Op, dst: Reg, operands: &[Reg]) -> Instr {
        let mut sources = [operands[0]; 3];
        sources[..operands.len()].copy_from_slice(operands);
        Instr { op, signed: false, masked: false, dst, sources, count: operands.len() as u8, table: 0, at: At(0) }
    }

    /// Whether the result is in `dst`.
    pub(crate) fn has_dst(&self) -> bool {
        !matches!(self.op, Op::Sample | Op::Fetch | Op::Nop)
    }
}

impl Code {
    /// Calls `on` with every register that an instruction reads.
    pub(crate) fn reads(&self, instr: &Instr, mut on: impl FnMut(Reg)) {
        match instr.op {
            Op::Nop => {}
            Op::Sample | Op::Fetch => self.lookups[instr.table as usize].at.iter().copied().for_each(on),
            _ => {
                instr.sources[..usize::from(instr.count)].iter().copied().for_each(&mut on);
                if instr.op == Op::Gather {
                    self.tables[instr.table as usize].iter().copied().for_each(on);
                }
            }
        }
    }

    /// Calls `on` with every register that an instruction writes.
    pub(crate) fn writes(&self, instr: &Instr, mut on: impl FnMut(Reg)) {
        match instr.op {
            Op::Nop => {}
            Op::Sample | Op::Fetch => {
                self.lookups[instr.table as usize].channels.iter().flatten().copied().for_each(on);
            }
            _ => on(instr.dst),
        }
    }

    /// Calls `on` with every register that is read, to rename it.
    pub(crate) fn each_read(&mut self, on: &dyn Fn(&mut Reg)) {
        self.instrs.iter_mut().flat_map(|instr| &mut instr.sources).for_each(on);
        self.tables.iter_mut().flatten().for_each(on);
        self.lookups.iter_mut().flat_map(|lookup| &mut lookup.at).for_each(on);
        self.outputs.iter_mut().flat_map(|(_, regs)| regs).for_each(on);
        self.body.iter_mut().for_each(|node| node.each_condition(on));
    }
}

impl Node {
    /// The child blocks.
    pub(crate) fn children(&mut self) -> Vec<&mut Vec<Node>> {
        match self {
            Node::If { accept, reject, .. } => vec![accept, reject],
            Node::Loop(node) => vec![&mut node.body, &mut node.continuing],
            Node::Switch { cases, .. } => cases.iter_mut().map(|case| &mut case.body).collect(),
            Node::Scope { body, .. } => vec![body],
            Node::Run(..) | Node::Break | Node::Continue | Node::Return | Node::Kill => Vec::new(),
        }
    }

    /// Calls `on` with every condition and selector, in order.
    pub(crate) fn each_condition(&mut self, on: &dyn Fn(&mut Reg)) {
        match self {
            Node::If { condition, .. } => on(condition),
            Node::Loop(node) => node.break_if.iter_mut().for_each(on),
            Node::Switch { selector, .. } => on(selector),
            Node::Scope { .. } | Node::Run(..) | Node::Break | Node::Continue | Node::Return | Node::Kill => {}
        }
        self.children().into_iter().flatten().for_each(|node| node.each_condition(on));
    }

    /// The list of registers that the node writes.
    pub(crate) fn written(&mut self) -> Option<&mut Written> {
        match self {
            Node::If { written, .. } | Node::Switch { written, .. } | Node::Scope { written, .. } => Some(written),
            Node::Loop(node) => Some(&mut node.written),
            Node::Run(..) | Node::Break | Node::Continue | Node::Return | Node::Kill => None,
        }
    }
}
