//! What f32 makes of a program: every result is rounded to it, and the first in each lane that is beyond it is noted.
//!
//! Invariant: an operation on numbers that f32 holds is computed in f64 and rounded once, which is how f32 rounds sums,
//! products, quotients and square roots.

use super::code::{At, Instr, Op};
use super::lanes::LANES;
use super::number::Unary;

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

impl Singles {
    /// Nothing yet, of a program that is watched in these places.
    pub(super) fn new(watched: Vec<bool>) -> Singles {
        Singles { watched, found: [None; LANES] }
    }

    /// Where all lanes begin with the first note of this block, of what is the same in all of them and computed whether a lane
    /// takes that way or not.
    pub(super) fn start(&self) -> Singles {
        let first = self.found[0].map(|first| Beyond { is_lost: false, ..first });
        Singles { found: [first; LANES], ..self.clone() }
    }

    /// The notes of so many lanes; `places` are those of the program.
    pub(super) fn overflows(&self, lanes: usize, places: &[String]) -> impl Iterator<Item = Option<Overflow>> {
        let overflow = |beyond: Beyond| Overflow {
            place: places[beyond.at.0 as usize].clone(),
            operation: words(beyond.op, beyond.operands),
            is_lost: beyond.is_lost,
        };
        self.found[..lanes].iter().map(move |beyond| beyond.map(overflow))
    }

    /// The f32 of a result; `None` where it is that already.
    pub(super) fn held(&mut self, instr: &Instr, operands: [f64; 3], result: f64, lane: usize) -> Option<f64> {
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
