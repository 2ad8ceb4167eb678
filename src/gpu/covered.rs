//! Fragment programs that do nothing in invocations outside of their triangle.
//!
//! Drivers run pixels in groups, also those of a group that a triangle does not cover. llvmpipe of Mesa 26.1 reads values
//! behind a loop from the first of a group, which has none if it is not covered: see `docs/notes/drivers.md`.

use hypertexture_glsl::spirv::{Decoration, ExecutionModel, HEADER, Op, StorageClass, encode, instructions};

/// Index of the header word that exceeds every id.
const BOUND: usize = 3;
/// The built-in variable that is true outside of the triangle.
const HELPER_INVOCATION: u32 = 23;

/// A fragment program whose entry is called by covered invocations alone. `None` if the program reads other pixels, whose
/// invocations must then run, or has no plain entry.
pub(super) fn covered(module: &[u32]) -> Option<Vec<u32>> {
    const FRAGMENT: u32 = ExecutionModel::Fragment as u32;
    let all = || instructions(module);
    if all().any(|(op, _)| reads_neighbors(op)) {
        return None;
    }
    let entry = all().find_map(|(op, words)| match *words {
        [_, FRAGMENT, entry, ..] if op == Op::EntryPoint => Some(entry),
        _ => None,
    })?;
    let (void, function) = all().find_map(|(op, words)| match *words {
        [_, void, result, _, function] if op == Op::Function && result == entry => Some((void, function)),
        _ => None,
    })?;
    let mut bound = *module.get(BOUND)?;
    let mut id = || {
        bound += 1;
        bound - 1
    };
    let known = all().find_map(|(op, words)| (op == Op::TypeBool).then(|| words[1]));
    let (boolean, pointer, outside, own) = (known.unwrap_or_else(&mut id), id(), id(), id());
    let [start, loaded, body, end, called] = [id(), id(), id(), id(), id()];

    const INPUT: u32 = StorageClass::Input as u32;
    let mut declared = Vec::new();
    if known.is_none() {
        declared.extend(encode(Op::TypeBool, &[boolean]));
    }
    declared.extend(encode(Op::TypePointer, &[pointer, INPUT, boolean]));
    declared.extend(encode(Op::Variable, &[pointer, outside, INPUT]));
    let decorated = encode(Op::Decorate, &[outside, Decoration::BuiltIn as u32, HELPER_INVOCATION]);

    let mut found = module[..HEADER].to_vec();
    found[BOUND] = bound;
    let (mut is_decorated, mut is_declared) = (false, false);
    for (op, words) in all() {
        // Annotations precede types, and types precede functions.
        if !is_decorated && ((Op::TypeVoid as u32..=Op::TypeForwardPointer as u32).contains(&(op as u32))) {
            found.extend(&decorated);
            is_decorated = true;
        }
        if !is_declared && op == Op::Function {
            found.extend(&declared);
            is_declared = true;
        }
        match op {
            Op::EntryPoint if words[2] == entry => {
                let interface = [&words[1..2], &[own], &words[3..], &[outside]].concat();
                found.extend(encode(op, &interface));
            }
            Op::ExecutionMode if words[1] == entry => found.extend(encode(op, &[&[own], &words[2..]].concat())),
            _ => found.extend(words),
        }
    }
    let calls: [(Op, &[u32]); 10] = [
        (Op::Function, &[void, own, 0, function]),
        (Op::Label, &[start]),
        (Op::Load, &[boolean, loaded, outside]),
        (Op::SelectionMerge, &[end, 0]),
        (Op::BranchConditional, &[loaded, end, body]),
        (Op::Label, &[body]),
        (Op::FunctionCall, &[void, called, entry]),
        (Op::Branch, &[end]),
        (Op::Label, &[end]),
        (Op::Return, &[]),
    ];
    calls.iter().for_each(|(op, words)| found.extend(encode(*op, words)));
    found.extend(encode(Op::FunctionEnd, &[]));
    Some(found)
}

/// Whether an instruction reads other invocations of a quad: derivatives, and lookups at levels of their own.
fn reads_neighbors(op: Op) -> bool {
    use Op::*;
    matches!(
        op,
        DPdx | DPdy
            | Fwidth
            | DPdxFine
            | DPdyFine
            | FwidthFine
            | DPdxCoarse
            | DPdyCoarse
            | FwidthCoarse
            | ImageSampleImplicitLod
            | ImageSampleDrefImplicitLod
            | ImageSampleProjImplicitLod
            | ImageQueryLod
    )
}
