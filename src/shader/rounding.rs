//! Arithmetic that a device rounds as it is written.
//!
//! A driver's compiler may fuse, reorder and simplify sums and products, and does so by what stands around them: a term
//! that is left out would change the last digits of those that stay. The decoration `NoContraction` of SPIR-V, which
//! GLSL calls `precise`, forbids that; set here, after glslang's optimizer, which may still leave out what comes to nothing.

use std::collections::BTreeSet;

/// Words before the first instruction.
const HEADER: usize = 5;
const OP_EXT_INST: u32 = 12;
const OP_DECORATE: u32 = 71;
/// `OpDecorate` to `OpGroupMemberDecorate`: the last instructions before the types.
const ANNOTATIONS: std::ops::RangeInclusive<u32> = 71..=75;
const NO_CONTRACTION: u32 = 42;

/// Whether an instruction is arithmetic of floats: `OpFNegate` to `OpDot`, without those of integers.
fn is_arithmetic(opcode: u32) -> bool {
    matches!(opcode, OP_EXT_INST | 127 | 129 | 131 | 133 | 136 | 140..=148)
}

/// The same module, whose arithmetic is rounded as it is written.
pub(super) fn as_written(words: &[u32]) -> Vec<u32> {
    let (mut at, mut behind, mut added) = (HEADER, None, Vec::new());
    let mut known = BTreeSet::new();
    while let Some(&first) = words.get(at) {
        let (length, opcode) = ((first >> 16).max(1) as usize, first & 0xffff);
        if ANNOTATIONS.contains(&opcode) {
            behind = Some(at + length);
        }
        match words[at + 1..] {
            [target, NO_CONTRACTION, ..] if opcode == OP_DECORATE => _ = known.insert(target),
            [_, result, ..] if is_arithmetic(opcode) && !known.contains(&result) => {
                added.extend([3 << 16 | OP_DECORATE, result, NO_CONTRACTION]);
            }
            _ => {}
        }
        at += length;
    }
    // What has no annotation has no interface, and computes nothing.
    match behind.and_then(|behind| words.split_at_checked(behind)) {
        Some((before, after)) => [before, &added, after].concat(),
        None => words.to_vec(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_result_of_arithmetic_is_decorated_once() {
        let decorate = |id| [3 << 16 | OP_DECORATE, id, NO_CONTRACTION];
        let add = |id| [5 << 16 | 129, 1, id, 7, 8];
        let header = [0x0723_0203, 0x0001_0300, 0, 9, 0];
        let own = decorate(5);
        let code = [add(5), add(6)].concat();
        let written = as_written(&[header.as_slice(), &own, &code].concat());
        assert_eq!(written, [header.as_slice(), &own, &decorate(6), &code].concat());
        assert_eq!(as_written(&written), written);
        assert_eq!(as_written(&header), header);
    }
}
