//! Boolean folding: `select(a, a, b)` becomes `a || b`.
//!
//! Role: compilers write `a || b` as a select. If `a` is undecided, the bounds of the select are either boolean, although
//! the result holds wherever `b` does. Invariant: decided values do not change.

use super::tidy::basic_blocks;
use crate::code::{Code, File, Instr, Op, Reg};
use std::collections::HashMap;

/// The value that each register holds (true) or negates (false).
#[derive(Default)]
struct Bools {
    values: HashMap<Reg, (usize, bool)>,
    count: usize,
}

impl Bools {
    fn add(&mut self, instr: &Instr) {
        if !instr.has_dst() || instr.dst.file != File::Bool {
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

    /// Whether a register equals another (true) or its negation (false), if either is known.
    fn same(&self, a: Reg, b: Reg) -> Option<bool> {
        let ((of, same), (of_other, other)) = (self.values.get(&a)?, self.values.get(&b)?);
        (of == of_other).then_some(same == other)
    }
}

/// Replaces selects of their own condition by `or` and `and`.
pub(crate) fn fold_bools(code: &mut Code) {
    for (start, end) in basic_blocks(&code.body) {
        let mut bools = Bools::default();
        for instr in &mut code.instrs[start..end] {
            let [condition, a, b] = instr.sources;
            if instr.op == Op::Select && instr.dst.file == File::Bool {
                let (op, sources, count) = match [a, b].map(|side| bools.same(side, condition)) {
                    [Some(same), _] => (if same { Op::Or } else { Op::And }, [a, b, a], 2),
                    [_, Some(same)] => (if same { Op::And } else { Op::Or }, [b, a, b], 2),
                    _ => (Op::Select, instr.sources, 3),
                };
                (instr.op, instr.sources, instr.count) = (op, sources, count);
            }
            bools.add(instr);
        }
    }
}
