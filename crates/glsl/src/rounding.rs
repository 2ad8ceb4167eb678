//! Floating-point arithmetic that every device rounds as written.
//!
//! A driver's compiler may fuse, reorder and simplify sums and products depending on the surrounding code, so leaving out
//! a term would change the last digits of the others. SPIR-V's decoration `NoContraction` (`precise` in GLSL) forbids
//! that. It is set after glslang's optimizer, which may still remove dead code.
//! A dot product is a single instruction whose sum drivers fuse all the same (seen on an NVIDIA H100), so it is expanded
//! into products and sums.

use super::spirv::{Decoration, HEADER, Op, encode, instructions};
use std::collections::{BTreeMap, BTreeSet};

/// Index of the header word that exceeds every id.
const BOUND: usize = 3;

/// Whether an instruction is floating-point arithmetic.
fn is_arithmetic(op: Op) -> bool {
    use Op::*;
    matches!(op, ExtInst | FNegate | FAdd | FSub | FMul | FDiv | FRem | FMod) || (VectorTimesScalar..=Dot).contains(&op) // products of vectors and matrices
}

/// Expands dot products and decorates all arithmetic with `NoContraction`.
pub(super) fn with_exact_rounding(module: &[u32]) -> Vec<u32> {
    const NO_CONTRACTION: u32 = Decoration::NoContraction as u32;
    let module = without_dot_products(module);
    let (mut at, mut annotations_end, mut added) = (HEADER, None, Vec::new());
    let mut decorated = BTreeSet::new();
    for (op, words) in instructions(&module) {
        at += words.len();
        if (Op::Decorate..=Op::GroupMemberDecorate).contains(&op) {
            annotations_end = Some(at);
        }
        match words[1..] {
            [target, NO_CONTRACTION, ..] if op == Op::Decorate => _ = decorated.insert(target),
            [_, result, ..] if is_arithmetic(op) && !decorated.contains(&result) => {
                added.extend(encode(Op::Decorate, &[result, NO_CONTRACTION]));
            }
            _ => {}
        }
    }
    // A module without annotations has no interface and computes nothing.
    match annotations_end.and_then(|end| module.split_at_checked(end)) {
        Some((before, after)) => [before, &added, after].concat(),
        None => module,
    }
}

/// Replaces each dot product by the products of its components and their sum, added from the first component on.
fn without_dot_products(module: &[u32]) -> Vec<u32> {
    let Some(&bound) = module.get(BOUND) else { return module.to_vec() };
    let mut sizes = BTreeMap::new(); // components by vector type
    let mut vector_types = BTreeMap::new(); // type by vector
    let (mut next_id, mut out) = (bound, module[..HEADER.min(module.len())].to_vec());
    for (op, words) in instructions(module) {
        match *words {
            [_, result, _, count] if op == Op::TypeVector => _ = sizes.insert(result, count),
            [_, scalar, result, a, b] if op == Op::Dot => {
                let vector = vector_types.get(&a).copied();
                if let Some((vector, &count)) = vector.and_then(|vector| Some((vector, sizes.get(&vector)?))) {
                    let mut emit = |op, kind, operands: [u32; 2], result: Option<u32>| {
                        let result = result.unwrap_or_else(|| {
                            next_id += 1;
                            next_id - 1
                        });
                        out.extend(encode(op, &[kind, result, operands[0], operands[1]]));
                        result
                    };
                    let products = emit(Op::FMul, vector, [a, b], None);
                    let mut sum = emit(Op::CompositeExtract, scalar, [products, 0], None);
                    for index in 1..count {
                        let part = emit(Op::CompositeExtract, scalar, [products, index], None);
                        sum = emit(Op::FAdd, scalar, [sum, part], (index + 1 == count).then_some(result));
                    }
                    continue;
                }
            }
            _ => {}
        }
        // Instructions without a result type add entries that no dot product looks up.
        if let [_, kind, result, ..] = *words
            && sizes.contains_key(&kind)
        {
            vector_types.insert(result, kind);
        }
        out.extend(words);
    }
    out[BOUND] = next_id;
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEAD: [u32; HEADER] = [0x0723_0203, 0x0001_0300, 0, 9, 0];

    #[test]
    fn each_result_of_arithmetic_is_decorated_once() {
        let decorate = |id| encode(Op::Decorate, &[id, 42]);
        let add = |id| encode(Op::FAdd, &[1, id, 7, 8]);
        let code = [add(5), add(6)].concat();
        let rounded = with_exact_rounding(&[&HEAD[..], &decorate(5), &code].concat());
        assert_eq!(rounded, [&HEAD[..], &decorate(5), &decorate(6), &code].concat());
        assert_eq!(with_exact_rounding(&rounded), rounded);
        assert_eq!(with_exact_rounding(&HEAD), HEAD);
    }

    #[test]
    fn a_dot_product_is_products_and_their_sums() {
        let before = [encode(Op::TypeVector, &[2, 1, 3]), encode(Op::Load, &[2, 7, 4])].concat();
        let code = [
            encode(Op::FMul, &[2, 9, 7, 8]),
            encode(Op::CompositeExtract, &[1, 10, 9, 0]),
            encode(Op::CompositeExtract, &[1, 11, 9, 1]),
            encode(Op::FAdd, &[1, 12, 10, 11]),
            encode(Op::CompositeExtract, &[1, 13, 9, 2]),
            encode(Op::FAdd, &[1, 6, 12, 13]),
        ];
        let longer = [HEAD[0], HEAD[1], 0, 14, 0];
        let given = [&HEAD[..], &before, &encode(Op::Dot, &[1, 6, 7, 8])].concat();
        assert_eq!(with_exact_rounding(&given), [&longer[..], &before, &code.concat()].concat());
    }
}
