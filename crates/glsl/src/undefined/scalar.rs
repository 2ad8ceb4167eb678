//! Scalars that are known when a module is read.

use crate::spirv::Op;

/// A number or a truth.
#[derive(Clone, Copy, Debug)]
pub(super) enum Scalar {
    Int(u32),
    Float(f32),
    Bool(bool),
}

impl PartialEq for Scalar {
    /// NaN equals itself.
    fn eq(&self, other: &Scalar) -> bool {
        match (self, other) {
            (Scalar::Int(a), Scalar::Int(b)) => a == b,
            (Scalar::Float(a), Scalar::Float(b)) => a.to_bits() == b.to_bits(),
            (Scalar::Bool(a), Scalar::Bool(b)) => a == b,
            _ => false,
        }
    }
}

impl Scalar {
    /// A signed integer.
    pub(super) fn integer(self) -> Option<i32> {
        if let Scalar::Int(bits) = self { Some(bits as i32) } else { None }
    }

    /// A truth.
    pub(super) fn truth(self) -> Option<bool> {
        if let Scalar::Bool(truth) = self { Some(truth) } else { None }
    }
}

/// The result of an operation on known operands, if it is a common one.
pub(super) fn computed(op: Op, operands: &[Scalar]) -> Option<Scalar> {
    use Scalar::{Bool, Float, Int};
    let signed = |bits: u32| bits as i32;
    Some(match *operands {
        [Int(a)] => match op {
            Op::SNegate => Int(a.wrapping_neg()),
            Op::Not => Int(!a),
            Op::ConvertSToF => Float(signed(a) as f32),
            Op::ConvertUToF => Float(a as f32),
            Op::Bitcast | Op::CopyObject => Int(a),
            _ => return None,
        },
        [Float(a)] => match op {
            Op::FNegate => Float(-a),
            Op::ConvertFToS => Int(a as i32 as u32),
            Op::ConvertFToU => Int(a as u32),
            Op::CopyObject => Float(a),
            _ => return None,
        },
        [Bool(a)] => match op {
            Op::LogicalNot => Bool(!a),
            Op::CopyObject => Bool(a),
            _ => return None,
        },
        [Int(a), Int(b)] => match op {
            Op::IAdd => Int(a.wrapping_add(b)),
            Op::ISub => Int(a.wrapping_sub(b)),
            Op::IMul => Int(a.wrapping_mul(b)),
            Op::SDiv => Int(signed(a).checked_div(signed(b))? as u32),
            Op::UDiv => Int(a.checked_div(b)?),
            Op::SMod => Int(signed(a).checked_rem_euclid(signed(b))? as u32),
            Op::UMod => Int(a.checked_rem(b)?),
            Op::IEqual => Bool(a == b),
            Op::INotEqual => Bool(a != b),
            Op::SLessThan => Bool(signed(a) < signed(b)),
            Op::SLessThanEqual => Bool(signed(a) <= signed(b)),
            Op::SGreaterThan => Bool(signed(a) > signed(b)),
            Op::SGreaterThanEqual => Bool(signed(a) >= signed(b)),
            Op::ULessThan => Bool(a < b),
            Op::ULessThanEqual => Bool(a <= b),
            Op::UGreaterThan => Bool(a > b),
            Op::UGreaterThanEqual => Bool(a >= b),
            Op::BitwiseAnd => Int(a & b),
            Op::BitwiseOr => Int(a | b),
            Op::BitwiseXor => Int(a ^ b),
            Op::ShiftLeftLogical => Int(a.checked_shl(b)?),
            Op::ShiftRightLogical => Int(a.checked_shr(b)?),
            _ => return None,
        },
        [Float(a), Float(b)] => match op {
            Op::FAdd => Float(a + b),
            Op::FSub => Float(a - b),
            Op::FMul => Float(a * b),
            Op::FDiv => Float(a / b),
            Op::FOrdEqual => Bool(a == b),
            Op::FUnordNotEqual | Op::FOrdNotEqual => Bool(a != b),
            Op::FOrdLessThan => Bool(a < b),
            Op::FOrdLessThanEqual => Bool(a <= b),
            Op::FOrdGreaterThan => Bool(a > b),
            Op::FOrdGreaterThanEqual => Bool(a >= b),
            _ => return None,
        },
        [Bool(a), Bool(b)] => match op {
            Op::LogicalAnd => Bool(a && b),
            Op::LogicalOr => Bool(a || b),
            Op::LogicalEqual => Bool(a == b),
            Op::LogicalNotEqual => Bool(a != b),
            _ => return None,
        },
        [Bool(truth), a, b] if op == Op::Select => {
            if truth {
                a
            } else {
                b
            }
        }
        _ => return None,
    })
}
