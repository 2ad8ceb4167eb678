//! Basic blocks and conditions, compiled for the vectors of this processor.

use super::control_flow::Machine;
use super::lanes::{Banks, Operand, Row, each, get, put};
use crate::code::{Code, File, Instr, Op, Reg};
use crate::number::{Bool, GROUP, Number, Packed};
use crate::texture::Image;

/// A basic block, for the lanes of a mask.
struct BasicBlock<'a, 'b, N: Number> {
    banks: &'b mut Banks<N>,
    instrs: &'a [Instr],
    code: &'a Code,
    images: &'a [Image<'a>],
    mask: u64,
    block: u64,
}

impl<N: Number> pulp::NullaryFnOnce for BasicBlock<'_, '_, N> {
    type Output = ();

    #[inline(always)] // compiled for the vectors of this processor
    fn call(self) {
        for instr in self.instrs {
            self.banks.run(instr, self.code, self.images, self.mask, self.block);
        }
    }
}

/// The lanes in which a condition may hold, and those in which it may fail.
struct Outcomes<'a, T: Packed>(&'a Row<T>);

impl<T: Bool> pulp::NullaryFnOnce for Outcomes<'_, T> {
    type Output = (u64, u64);

    #[inline(always)] // compiled for the vectors of this processor
    fn call(self) -> (u64, u64) {
        let (mut holds, mut fails) = (0, 0);
        for group in self.0.iter().rev() {
            let (mut hold, mut fail) = (0, 0);
            for place in 0..GROUP {
                let condition = T::get(group, place);
                hold |= u64::from(condition.may_hold()) << place;
                fail |= u64::from(condition.may_fail()) << place;
            }
            (holds, fails) = (holds << GROUP | hold, fails << GROUP | fail);
        }
        (holds, fails)
    }
}

impl<N: Number> Machine<'_, N> {
    /// Runs a basic block.
    pub(crate) fn basic_block(&mut self, start: usize, end: usize, mask: u64) {
        let (banks, code, images) = (&mut self.banks, self.code, self.images);
        let instrs = &code.instrs[start..end];
        self.arch.dispatch(BasicBlock { banks, instrs, code, images, mask, block: self.block });
    }

    /// Runs a basic block with results rounded to f32.
    pub(crate) fn basic_block_single(&mut self, instrs: (usize, usize), mask: u64) {
        for index in instrs.0..instrs.1 {
            let instr = self.code.instrs[index];
            let has_result = instr.has_dst() && instr.dst.file == File::Float && instr.op != Op::Copy;
            let operands = has_result.then(|| self.operands(&instr));
            self.basic_block(index, index + 1, mask);
            let (Some(operands), Some(singles)) = (operands, &mut self.singles) else { continue };
            let row = self.banks.floats.row(instr.dst);
            each(mask, |lane| {
                let operands = operands.each_ref().map(|row| row.as_ref().map(|row| get::<N>(row, lane).as_f64()));
                let operands = operands.map(|operand| operand.unwrap_or_default());
                let Some(rounded) = singles.rounded(&instr, operands, get::<N>(row, lane).as_f64(), lane) else {
                    return;
                };
                put(row, lane, N::new(rounded));
            });
        }
    }

    /// Copies of the float operands of an instruction.
    fn operands(&self, instr: &Instr) -> [Option<Row<N>>; 3] {
        [0, 1, 2].map(|source| {
            let reg = instr.sources[source];
            let is_read = source < usize::from(instr.count) && reg.file == File::Float;
            is_read.then(|| self.banks.floats.rows.read(reg).row())
        })
    }

    /// The lanes in which a condition may hold, and those in which it may fail.
    pub(crate) fn split(&self, condition: Reg, mask: u64) -> (u64, u64) {
        match self.banks.bools.rows.read(condition) {
            Operand::Uniform(value) => {
                (if value.may_hold() { mask } else { 0 }, if value.may_fail() { mask } else { 0 })
            }
            Operand::Lanes(row) => {
                let (holds, fails) = self.arch.dispatch(Outcomes::<N::Bool>(row));
                (holds & mask, fails & mask)
            }
        }
    }
}
