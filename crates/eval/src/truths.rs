//! What truth values have to do with each other in straight code.
//!
//! Role: a compiler writes `a || b` as a choice by a between a and b. Where a is not decided, either may be false; but not both
//! where b is true. Invariant: no value changes, in no kind of numbers, but for what is not decided.

use super::code::{Code, File, Instr, Op, Reg};
use super::optimizer::runs;
use std::collections::HashMap;

/// Of which value each register holds the same (true) or the contrary (false).
#[derive(Default)]
struct Truths {
    values: HashMap<Reg, (usize, bool)>,
    count: usize,
}

impl Truths {
    fn add(&mut self, instr: &Instr) {
        if !instr.single() || instr.dst.file != File::Truth {
            return;
        }
        self.count += 1;
        let mut value = (self.count, true);
        if let Op::Copy | Op::Not = instr.op {
            let (of, same) = *self.values.entry(instr.sources[0]).or_insert(value);
            value = (of, same == (instr.op == Op::Copy));
        }
        self.values.insert(instr.dst, value);
    }

    /// Whether a register holds the same as another (true) or its contrary (false), where one of the two is known.
    fn same(&self, a: Reg, b: Reg) -> Option<bool> {
        let ((of, same), (of_other, other)) = (self.values.get(&a)?, self.values.get(&b)?);
        (of == of_other).then_some(same == other)
    }
}

/// Makes an `or` or an `and` of a choice by what is chosen.
pub(super) fn simplify(code: &mut Code) {
    for (start, end) in runs(&code.body) {
        let mut truths = Truths::default();
        for instr in &mut code.instrs[start..end] {
            let [condition, a, b] = instr.sources;
            if instr.op == Op::Select && instr.dst.file == File::Truth {
                let (op, sources, count) = match [a, b].map(|side| truths.same(side, condition)) {
                    [Some(same), _] => (if same { Op::Or } else { Op::And }, [a, b, a], 2),
                    [_, Some(same)] => (if same { Op::And } else { Op::Or }, [b, a, b], 2),
                    _ => (Op::Select, instr.sources, 3),
                };
                (instr.op, instr.sources, instr.count) = (op, sources, count);
            }
            truths.add(instr);
        }
    }
}
