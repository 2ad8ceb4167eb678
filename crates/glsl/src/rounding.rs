//! Arithmetic that a device rounds as it is written.
//!
//! A driver's compiler may fuse, reorder and simplify sums and products, and does so by what stands around them: a term
//! that is left out would change the last digits of those that stay. The decoration `NoContraction` of SPIR-V, which
//! GLSL calls `precise`, forbids that; set here, after glslang's optimizer, which may still leave out what comes to nothing.
//! A dot product is one instruction, whose sum a driver may fuse all the same, as that of an NVIDIA H100 does: it is
//! written as products and sums.

use std::collections::{BTreeMap, BTreeSet};

/// Words before the first instruction.
const HEADER: usize = 5;
const OP_EXT_INST: u32 = 12;
const OP_DECORATE: u32 = 71;
/// `OpDecorate` to `OpGroupMemberDecorate`: the last instructions before the types.
const ANNOTATIONS: std::ops::RangeInclusive<u32> = 71..=75;
const NO_CONTRACTION: u32 = 42;
const OP_TYPE_VECTOR: u32 = 23;
const OP_COMPOSITE_EXTRACT: u32 = 81;
const OP_F_ADD: u32 = 129;
const OP_F_MUL: u32 = 133;
const OP_DOT: u32 = 148;
/// The word of the header that all numbers are below.
const BOUND: usize = 3;

/// Whether an instruction is arithmetic of floats: `OpFNegate` to `OpDot`, without those of integers.
fn is_arithmetic(opcode: u32) -> bool {
    matches!(opcode, OP_EXT_INST | 127 | 129 | 131 | 133 | 136 | 140..=148)
}

/// The instructions of a module, each with its opcode.
fn instructions(words: &[u32]) -> impl Iterator<Item = (u32, &[u32])> {
    let mut left = words.get(HEADER..).unwrap_or_default();
    std::iter::from_fn(move || {
        let first = *left.first()?;
        let (own, rest) = left.split_at_checked(((first >> 16).max(1)) as usize)?;
        left = rest;
        Some((first & 0xffff, own))
    })
}

/// The same module, whose arithmetic is rounded as it is written.
pub(super) fn as_written(words: &[u32]) -> Vec<u32> {
    let words = without_dots(words);
    let (mut at, mut behind, mut added) = (HEADER, None, Vec::new());
    let mut known = BTreeSet::new();
    for (opcode, own) in instructions(&words) {
        at += own.len();
        if ANNOTATIONS.contains(&opcode) {
            behind = Some(at);
        }
        match own[1..] {
            [target, NO_CONTRACTION, ..] if opcode == OP_DECORATE => _ = known.insert(target),
            [_, result, ..] if is_arithmetic(opcode) && !known.contains(&result) => {
                added.extend([3 << 16 | OP_DECORATE, result, NO_CONTRACTION]);
            }
            _ => {}
        }
    }
    // What has no annotation has no interface, and computes nothing.
    match behind.and_then(|behind| words.split_at_checked(behind)) {
        Some((before, after)) => [before, &added, after].concat(),
        None => words,
    }
}

/// The same module with each dot product as the products of its components and their sums, from the first on.
fn without_dots(words: &[u32]) -> Vec<u32> {
    let mut sizes = BTreeMap::new(); // of the vectors of each type
    let mut vectors = BTreeMap::new(); // the type of each vector
    let Some(&bound) = words.get(BOUND) else { return words.to_vec() };
    let (mut next, mut all) = (bound, words[..HEADER.min(words.len())].to_vec());
    for (opcode, own) in instructions(words) {
        match *own {
            [_, result, _, count] if opcode == OP_TYPE_VECTOR => _ = sizes.insert(result, count),
            [_, of, result, a, b] if opcode == OP_DOT => {
                // Words of other instructions look like results as well: what is no vector is never asked for.
                if let Some((&vector, &count)) = vectors.get(&a).and_then(|vector| Some((vector, sizes.get(vector)?))) {
                    let mut one = |length: u32, opcode, of, operands: [u32; 2], result: Option<u32>| {
                        let result = result.unwrap_or_else(|| {
                            next += 1;
                            next - 1
                        });
                        all.extend([length << 16 | opcode, of, result]);
                        all.extend(operands);
                        result
                    };
                    let products = one(5, OP_F_MUL, vector, [a, b], None);
                    let mut sum = one(5, OP_COMPOSITE_EXTRACT, of, [products, 0], None);
                    for index in 1..count {
                        let part = one(5, OP_COMPOSITE_EXTRACT, of, [products, index], None);
                        sum = one(5, OP_F_ADD, of, [sum, part], (index + 1 == count).then_some(result));
                    }
                    continue;
                }
            }
            _ => {}
        }
        if let [_, of, result, ..] = *own
            && sizes.contains_key(&of)
        {
            vectors.insert(result, of);
        }
        all.extend(own);
    }
    all[BOUND] = next;
    all
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

    #[test]
    fn a_dot_product_is_products_and_their_sums() {
        let header = [0x0723_0203, 0x0001_0300, 0, 9, 0];
        let before = [[4 << 16 | OP_TYPE_VECTOR, 2, 1, 3].as_slice(), &[4 << 16 | 61, 2, 7, 4]].concat();
        let dot = [5 << 16 | OP_DOT, 1, 6, 7, 8];
        let one = |opcode, of, result, a, b| [5 << 16 | opcode, of, result, a, b];
        let code = [
            one(OP_F_MUL, 2, 9, 7, 8),
            one(OP_COMPOSITE_EXTRACT, 1, 10, 9, 0),
            one(OP_COMPOSITE_EXTRACT, 1, 11, 9, 1),
            one(OP_F_ADD, 1, 12, 10, 11),
            one(OP_COMPOSITE_EXTRACT, 1, 13, 9, 2),
            one(OP_F_ADD, 1, 6, 12, 13),
        ];
        let longer = [header[0], header[1], 0, 14, 0];
        let given = [header.as_slice(), &before, &dot].concat();
        assert_eq!(as_written(&given), [longer.as_slice(), &before, &code.concat()].concat());
    }
}
