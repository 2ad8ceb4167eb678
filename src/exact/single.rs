//! What f32 makes of a program: every result is rounded to it, and the first in each lane that is beyond it is noted.
//!
//! Invariant: an operation on numbers that f32 holds is computed in f64 and rounded once, which is how f32 rounds sums,
//! products, quotients and square roots.

use super::code::{At, File, Instr, Op};
use super::lanes::{LANES, Row, each, get, put};
use super::number::{Number, Unary};
use super::run::Machine;
use super::{BoundProgram, ExactError, Lanes, Measured};

/// A result that is beyond f32, of numbers that are not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Overflow {
    /// File and line.
    pub place: String,
    /// The operation, in words: `exp(110)`.
    pub operation: String,
    /// Whether a number was lost by it: such as the quotient of two infinities.
    pub is_lost: bool,
}

/// Notes of what is beyond f32.
#[derive(Clone, Debug)]
pub(super) struct Singles {
    /// The places, of all those of the program, that are watched.
    watched: Vec<bool>,
    found: [Option<Beyond>; LANES],
}

/// The first result of a lane that is beyond f32.
#[derive(Clone, Copy, Debug)]
struct Beyond {
    at: At,
    op: Op,
    operands: [f64; 3],
    is_lost: bool,
}

impl BoundProgram<'_> {
    /// Evaluates a program as f32 does: outputs, the operations that it took, and of each lane the first result in a watched
    /// file and line that is beyond f32. All the loops of a lane together make `most_turns` at most.
    ///
    /// # Errors
    /// As [`BoundProgram::measure_within`].
    pub fn measure_single(
        &self,
        lanes: &Lanes<f64>,
        most_turns: u64,
        is_watched: impl Fn(&str) -> bool,
    ) -> Result<(Measured<f64>, Vec<Option<Overflow>>), ExactError> {
        let watched = self.code.places.iter().map(|place| is_watched(place)).collect();
        let none = Singles { watched, found: [None; LANES] };
        let (uniforms, known) = self.computed_uniforms::<f64>(Some(none));
        // What is the same in all lanes is computed whether a lane takes that way or not.
        let first = known.as_ref().and_then(|known| known.found[0]).map(|first| Beyond { is_lost: false, ..first });
        let start = known.map(|known| Singles { found: [first; LANES], ..known });
        let mut machine = Machine::new(self.code, &self.images, uniforms);
        (machine.most_turns, machine.singles) = (Some(most_turns), start.clone());
        let mut found = Vec::new();
        let measured = self.fill(&mut machine, lanes, &mut [], &mut |machine, here| {
            let singles = std::mem::replace(&mut machine.singles, start.clone());
            let noted = singles.map_or([None; LANES], |singles| singles.found);
            found.extend(noted[..here].iter().map(|beyond| beyond.map(|beyond| self.overflow(&beyond))));
        })?;
        Ok((measured, found))
    }

    fn overflow(&self, beyond: &Beyond) -> Overflow {
        let place = self.code.places[beyond.at.0 as usize].clone();
        Overflow { place, operation: words(beyond.op, beyond.operands), is_lost: beyond.is_lost }
    }
}

impl<N: Number> Machine<'_, N> {
    /// Runs instructions one after the other, each with a result of f32.
    pub(super) fn run_single(&mut self, instrs: (usize, usize), mask: u64) {
        for index in instrs.0..instrs.1 {
            let instr = self.code.instrs[index];
            let has_result = instr.single() && instr.dst.file == File::Float && instr.op != Op::Copy;
            let operands = has_result.then(|| self.operands(&instr));
            self.run_straight(index, index + 1, mask);
            let (Some(operands), Some(singles)) = (operands, &mut self.singles) else { continue };
            let row = self.banks.floats.row(instr.dst);
            each(mask, |lane| {
                let operands = operands.each_ref().map(|row| row.as_ref().map(|row| get::<N>(row, lane).as_f64()));
                let operands = operands.map(|operand| operand.unwrap_or_default());
                let Some(held) = singles.held(&instr, operands, get::<N>(row, lane).as_f64(), lane) else { return };
                put(row, lane, N::new(held));
            });
        }
    }

    /// What the instruction reads of floats.
    fn operands(&self, instr: &Instr) -> [Option<Row<N>>; 3] {
        [0, 1, 2].map(|source| {
            let reg = instr.sources[source];
            let is_read = source < usize::from(instr.count) && reg.file == File::Float;
            is_read.then(|| self.banks.floats.rows.read(reg).row())
        })
    }
}

impl Singles {
    /// The f32 of a result; `None` where it is that already.
    fn held(&mut self, instr: &Instr, operands: [f64; 3], result: f64, lane: usize) -> Option<f64> {
        let single = |x: f64| f64::from(x as f32);
        let [a, b, c] = operands;
        let held = if instr.op == Op::MulAdd { single(single(a * b) + c) } else { single(result) };
        let noted = &mut self.found[lane];
        if held.is_nan() && !operands.iter().any(|operand| operand.is_nan()) {
            noted.iter_mut().for_each(|beyond| beyond.is_lost |= operands.iter().any(|operand| operand.is_infinite()));
        } else if held.is_infinite()
            && noted.is_none()
            && self.watched[instr.at.0 as usize]
            && operands.iter().all(|operand| operand.is_finite())
            && !is_pole(instr.op, operands)
        {
            *noted = Some(Beyond { at: instr.at, op: instr.op, operands, is_lost: false });
        }
        (held != result).then_some(held)
    }
}

/// Whether a result is infinite in any format.
fn is_pole(op: Op, [a, b, _]: [f64; 3]) -> bool {
    match op {
        Op::Div => b == 0.0,
        Op::Pow => a == 0.0,
        Op::Unary(Unary::Log | Unary::Log2 | Unary::InverseSqrt) => a == 0.0,
        Op::Unary(Unary::Atanh) => a.abs() == 1.0,
        _ => false,
    }
}

/// An operation in words.
fn words(op: Op, operands: [f64; 3]) -> String {
    let [a, b, c] = operands.map(|x| match x.abs() {
        size if size == 0.0 || (1e-3..1e7).contains(&size) => format!("{}", x as f32),
        _ => format!("{:e}", x as f32),
    });
    match op {
        Op::Add => format!("{a} + {b}"),
        Op::Sub => format!("{a} - {b}"),
        Op::Mul => format!("{a} * {b}"),
        Op::Div => format!("{a} / {b}"),
        Op::MulAdd => format!("{a} * {b} + {c}"),
        Op::Pow => format!("pow({a}, {b})"),
        Op::Mix => format!("mix({a}, {b}, {c})"),
        Op::Unary(Unary::Square) => format!("{a} * {a}"),
        Op::Unary(function) => format!("{}({a})", format!("{function:?}").to_lowercase()),
        op => format!("{op:?} of {a}"),
    }
}
