//! Rounding of results to f32, and notes of the first overflow in each lane.
//!
//! Invariant: an operation on numbers of f32 is computed in f64 and rounded once, which equals the rounding of f32 for sums,
//! products, quotients and square roots.

use super::lanes::LANES;
use crate::code::{At, Instr, Op};
use crate::number::{Binary, Unary};

/// A result that overflows f32, of operands that do not.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Overflow {
    /// File and line.
    pub place: String,
    /// The operation, such as `exp(110)`.
    pub operation: String,
    /// Whether it led to NaN, such as the quotient of two infinities.
    pub is_lost: bool,
}

/// Overflows of f32 in a block of lanes.
#[derive(Clone, Debug)]
pub(crate) struct Singles {
    /// Whether each place of the program is watched.
    watched: Vec<bool>,
    found: [Option<Note>; LANES],
}

/// The first overflow of a lane.
#[derive(Clone, Copy, Debug)]
struct Note {
    at: At,
    op: Op,
    operands: [f64; 3],
    is_lost: bool,
}

impl Singles {
    pub(crate) fn new(watched: Vec<bool>) -> Singles {
        Singles { watched, found: [None; LANES] }
    }

    /// The notes that each lane starts with: those of uniform expressions, which are computed on any path.
    pub(crate) fn start(&self) -> Singles {
        let first = self.found[0].map(|first| Note { is_lost: false, ..first });
        Singles { found: [first; LANES], ..self.clone() }
    }

    /// The overflows of the first `lanes` lanes.
    pub(crate) fn overflows(&self, lanes: usize, places: &[String]) -> impl Iterator<Item = Option<Overflow>> {
        let overflow = |note: Note| Overflow {
            place: places[note.at.0 as usize].clone(),
            operation: text(note.op, note.operands),
            is_lost: note.is_lost,
        };
        self.found[..lanes].iter().map(move |note| note.map(overflow))
    }

    /// Rounds a result to f32; `None` if that changes nothing.
    pub(crate) fn rounded(&mut self, instr: &Instr, operands: [f64; 3], result: f64, lane: usize) -> Option<f64> {
        let single = |x: f64| f64::from(x as f32);
        let [a, b, c] = operands;
        let rounded = if instr.op == Op::MulAdd { single(single(a * b) + c) } else { single(result) };
        let noted = &mut self.found[lane];
        if rounded.is_nan() && !operands.iter().any(|operand| operand.is_nan()) {
            noted.iter_mut().for_each(|note| note.is_lost |= operands.iter().any(|operand| operand.is_infinite()));
        } else if rounded.is_infinite()
            && noted.is_none()
            && self.watched[instr.at.0 as usize]
            && operands.iter().all(|operand| operand.is_finite())
            && !is_pole(instr.op, operands)
        {
            *noted = Some(Note { at: instr.at, op: instr.op, operands, is_lost: false });
        }
        (rounded != result).then_some(rounded)
    }
}

/// Whether a function is infinite at its operands in exact arithmetic.
fn is_pole(op: Op, [a, b, _]: [f64; 3]) -> bool {
    match op {
        Op::Binary(Binary::Div) => b == 0.0,
        Op::Binary(Binary::Pow) => a == 0.0,
        Op::Unary(Unary::Log | Unary::Log2 | Unary::InverseSqrt) => a == 0.0,
        Op::Unary(Unary::Atanh) => a.abs() == 1.0,
        _ => false,
    }
}

/// Text of an operation.
fn text(op: Op, operands: [f64; 3]) -> String {
    let [a, b, c] = operands.map(|x| match x.abs() {
        size if size == 0.0 || (1e-3..1e7).contains(&size) => format!("{}", x as f32),
        _ => format!("{:e}", x as f32),
    });
    match op {
        Op::Binary(Binary::Add) => format!("{a} + {b}"),
        Op::Binary(Binary::Sub) => format!("{a} - {b}"),
        Op::Binary(Binary::Mul) => format!("{a} * {b}"),
        Op::Binary(Binary::Div) => format!("{a} / {b}"),
        Op::MulAdd => format!("{a} * {b} + {c}"),
        Op::Binary(Binary::Pow) => format!("pow({a}, {b})"),
        Op::Mix => format!("mix({a}, {b}, {c})"),
        Op::Unary(Unary::Square) => format!("{a} * {a}"),
        Op::Unary(function) => format!("{}({a})", format!("{function:?}").to_lowercase()),
        op => format!("{op:?} of {a}"),
    }
}
