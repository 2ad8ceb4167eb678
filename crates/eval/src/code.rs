//! A lowered program: instructions on registers that hold one scalar for each lane, in structured control flow.
//!
//! Invariant: vectors, matrices, structures, arrays, functions and pointers are gone. Instructions are total and have
//! no effect but their results, so that lanes which are not active may compute anything in registers that only their
//! own branch reads; a *masked* result is that of a variable, which keeps its value in other lanes.

use super::number::{IntBinary, IntUnary, Unary};

/// The three files of registers.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum File {
    Float,
    Int,
    Truth,
}

/// A register: one value for each lane, or one for all lanes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct Reg {
    pub(super) file: File,
    pub(super) uniform: bool,
    pub(super) index: u32,
}

/// What an instruction computes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Op {
    /// Nothing: an instruction that was removed.
    Nop,
    Copy,
    Unary(Unary),
    Add,
    Sub,
    Mul,
    Div,
    Min,
    Max,
    Pow,
    Atan2,
    Rem,
    Unit,
    /// `a * b + c`, both rounded.
    MulAdd,
    Mix,
    Less,
    LessEqual,
    Equal,
    IsNan,
    IsInfinite,
    ToInt,
    FromInt,
    ToBits,
    FromBits,
    Ldexp,
    /// The first where the condition holds, else the second; of any file.
    Select,
    Int(IntBinary),
    IntUnary(IntUnary),
    Reread,
    IntLess,
    IntEqual,
    And,
    Or,
    Not,
    Same,
    /// One of a table, by an index.
    Gather,
    /// A filtered lookup; `table` is one of [`Code::lookups`].
    Sample,
    /// A texel.
    Fetch,
    /// The difference across a quad of lanes, along x or along y.
    Derivative(bool),
}

/// An instruction. `sources` are as many as the operation has, further ones repeat the first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Instr {
    pub(super) op: Op,
    pub(super) signed: bool,
    pub(super) masked: bool,
    pub(super) dst: Reg,
    pub(super) sources: [Reg; 3],
    pub(super) count: u8,
    pub(super) table: u32,
    pub(super) at: At,
}

/// Where an instruction stands, a number of [`Code::places`]. Two programs are the same wherever their lines stand, so an
/// outline prints none.
#[derive(Clone, Copy, Default)]
pub(super) struct At(pub(super) u32);

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

/// A lookup in an image.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Lookup {
    /// Index of what is bound: see [`Code::images`].
    pub(super) image: usize,
    /// The coordinates, and behind them the level if the program names one.
    pub(super) at: Vec<Reg>,
    /// The channels; `None` where the program does not use one.
    pub(super) channels: [Option<Reg>; 4],
}

/// An image with the sampler that it is read through; 1, 2 or 3 axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Pair {
    pub(super) image: u32,
    pub(super) sampler: Option<u32>,
    pub(super) axes: usize,
}

/// Where a value that is the same for all lanes comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Source {
    Float(u64),
    Int(u32, bool),
    Truth(bool),
    /// A scalar of a uniform block: binding, offset in bytes; whether it is signed matters to integers.
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

/// Registers that are written in a part of the program, and may be read after it.
pub(super) type Written = Vec<Reg>;

/// Structured control flow over ranges of instructions.
#[derive(Clone, Debug)]
pub(super) enum Node {
    Run(usize, usize),
    If {
        condition: Reg,
        accept: Vec<Node>,
        reject: Vec<Node>,
        written: Written,
        /// What the condition compares, where it is one comparison: it holds only if the first is at most the second, and
        /// fails only if the second is at most the first.
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

/// A loop: the body, what follows it and every `continue`, and whether that was the last turn.
#[derive(Clone, Debug)]
pub(super) struct Loop {
    pub(super) body: Vec<Node>,
    pub(super) continuing: Vec<Node>,
    pub(super) break_if: Option<Reg>,
    pub(super) written: Written,
    pub(super) returns: bool,
    pub(super) kills: bool,
    pub(super) place: Place,
}

/// File and line, for errors. Two programs are the same wherever their lines stand, so an outline prints none.
#[derive(Clone)]
pub(super) struct Place(pub(super) String);

impl std::fmt::Debug for Place {
    fn fmt(&self, _: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        Ok(())
    }
}

/// A case of a switch: it is entered with one of `values`, or with any that no case has if it is the default.
#[derive(Clone, Debug)]
pub(super) struct Case {
    pub(super) values: Vec<u32>,
    pub(super) default: bool,
    pub(super) body: Vec<Node>,
    /// Whether its end leads into the next case.
    pub(super) falls: bool,
}

/// What a lane starts with.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Input {
    Fragment,
    Varying(u32),
}

/// A lowered program.
#[derive(Debug, Default)]
pub(super) struct Code {
    /// Runs once: results are uniform, and so are its operands, under the same indices.
    pub(super) prelude: Vec<Instr>,
    pub(super) instrs: Vec<Instr>,
    pub(super) body: Vec<Node>,
    pub(super) tables: Vec<Vec<Reg>>,
    pub(super) lookups: Vec<Lookup>,
    pub(super) images: Vec<Pair>,
    /// Uniform registers that are known before the prelude.
    pub(super) sources: Vec<(Reg, Source)>,
    /// Number of uniform registers, and of those with a value for each lane, by file.
    pub(super) uniforms: [u32; 3],
    pub(super) registers: [u32; 3],
    pub(super) inputs: Vec<(Input, usize, Reg)>,
    /// By location, the registers that hold the outputs at the end.
    pub(super) outputs: Vec<(u32, Vec<Reg>)>,
    /// Whether it needs lanes in quads.
    pub(super) derivatives: bool,
    /// Files and lines of instructions; the first is that of those without one.
    pub(super) places: Vec<String>,
}

impl Instr {
    /// Whether it has one result, in `dst`.
    pub(super) fn single(&self) -> bool {
        !matches!(self.op, Op::Sample | Op::Fetch | Op::Nop)
    }
}

impl Code {
    /// Every register that an instruction reads.
    pub(super) fn reads(&self, instr: &Instr, mut on: impl FnMut(Reg)) {
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

    /// Every register that an instruction writes.
    pub(super) fn writes(&self, instr: &Instr, mut on: impl FnMut(Reg)) {
        match instr.op {
            Op::Nop => {}
            Op::Sample | Op::Fetch => {
                self.lookups[instr.table as usize].channels.iter().flatten().copied().for_each(on);
            }
            _ => on(instr.dst),
        }
    }
}
