//! SPIR-V modules as sequences of instructions, with the names of the specification.

pub use ::spirv::{Capability, Decoration, ExecutionModel, Op, StorageClass};

/// Words before the first instruction.
pub const HEADER: usize = 5;

/// The instructions of a module: opcode and all words, of which the first holds opcode and length. Opcodes that the
/// `spirv` crate does not know are `Op::Nop`; the iterator ends at an instruction that is cut off.
pub fn instructions(module: &[u32]) -> impl Iterator<Item = (Op, &[u32])> {
    let mut rest = module.get(HEADER..).unwrap_or_default();
    std::iter::from_fn(move || {
        let &first = rest.first()?;
        let (words, after) = rest.split_at_checked((first >> 16).max(1) as usize)?;
        rest = after;
        Some((Op::from_u32(first & 0xffff).unwrap_or(Op::Nop), words))
    })
}

/// The words of an instruction.
pub fn encode(op: Op, operands: &[u32]) -> Vec<u32> {
    let first = (operands.len() as u32 + 1) << 16 | op as u32;
    [&[first], operands].concat()
}
