//! Lowering of operators and conversions.

use super::function::Lower;
use super::types::{ScalarType, Ty, Value};
use crate::code::{File, Op, Reg};
use crate::error::ExactError;
use crate::number::{Binary, Comparison, IntBinary, IntUnary, Unary};
use naga::{BinaryOperator, ScalarKind, UnaryOperator};

impl Lower<'_> {
    pub(crate) fn unary(&mut self, op: UnaryOperator, value: &Value) -> Result<Value, ExactError> {
        let kind = value.ty.kind().ok_or_else(|| self.uncovered("an operator on an array or structure"))?;
        let op = match (op, kind) {
            (UnaryOperator::Negate, ScalarType::Float) => Op::Unary(Unary::Negate),
            (UnaryOperator::Negate, _) => Op::IntUnary(IntUnary::Negate),
            (UnaryOperator::LogicalNot, _) => Op::Not,
            (UnaryOperator::BitwiseNot, _) => Op::IntUnary(IntUnary::Not),
        };
        let regs = value.regs.iter().map(|reg| self.emit(op, kind.signed(), &[*reg]));
        Ok(Value::new(value.ty.clone(), regs.collect()))
    }

    pub(crate) fn relational(
        &mut self,
        function: naga::RelationalFunction,
        value: &Value,
    ) -> Result<Value, ExactError> {
        let regs = value.regs.clone();
        let fold = |lower: &mut Self, op| {
            let all = regs[1..].iter().fold(regs[0], |all, reg| lower.emit(op, false, &[all, *reg]));
            Value::new(Ty::Scalar(ScalarType::Bool), vec![all])
        };
        let op = match function {
            naga::RelationalFunction::All => return Ok(fold(self, Op::And)),
            naga::RelationalFunction::Any => return Ok(fold(self, Op::Or)),
            naga::RelationalFunction::IsNan => Op::IsNan,
            naga::RelationalFunction::IsInf => Op::IsInfinite,
        };
        let regs = value.regs.iter().map(|reg| self.emit(op, false, &[*reg])).collect();
        Ok(Value::new(value.ty.with(ScalarType::Bool), regs))
    }

    pub(crate) fn convert(&mut self, value: &Value, kind: ScalarKind, convert: bool) -> Result<Value, ExactError> {
        let to = match kind {
            ScalarKind::Float => ScalarType::Float,
            ScalarKind::Sint => ScalarType::Sint,
            ScalarKind::Uint => ScalarType::Uint,
            ScalarKind::Bool => ScalarType::Bool,
            other => return Err(self.uncovered(format!("a conversion to {other:?}"))),
        };
        let from = value.ty.kind().ok_or_else(|| self.uncovered("a conversion of an array or structure"))?;
        if from == to {
            return Ok(value.clone());
        }
        let constant = |lower: &mut Self, number: u32| match to {
            ScalarType::Float => lower.float(f64::from(number)),
            _ => lower.int(number, to.signed()),
        };
        let regs = value.regs.iter().map(|reg| match (from, to) {
            (ScalarType::Float, ScalarType::Sint | ScalarType::Uint) if convert => {
                self.emit(Op::ToInt, to.signed(), &[*reg])
            }
            (ScalarType::Float, ScalarType::Sint | ScalarType::Uint) => self.emit(Op::ToBits, to.signed(), &[*reg]),
            (ScalarType::Sint | ScalarType::Uint, ScalarType::Float) if convert => {
                self.emit(Op::FromInt, from.signed(), &[*reg])
            }
            (ScalarType::Sint | ScalarType::Uint, ScalarType::Float) => self.emit(Op::FromBits, false, &[*reg]),
            (ScalarType::Sint | ScalarType::Uint, ScalarType::Sint | ScalarType::Uint) => {
                self.emit(Op::Bitcast, to.signed(), &[*reg])
            }
            (ScalarType::Bool, _) => {
                let (one, zero) = (constant(self, 1), constant(self, 0));
                self.emit(Op::Select, false, &[*reg, one, zero])
            }
            (ScalarType::Float, _) => {
                let zero = self.float(0.0);
                let same = self.emit(Op::Compare(Comparison::Equal), false, &[*reg, zero]);
                self.emit(Op::Not, false, &[same])
            }
            _ => {
                let zero = self.int(0, false);
                let same = self.emit(Op::IntEqual, false, &[*reg, zero]);
                self.emit(Op::Not, false, &[same])
            }
        });
        Ok(Value::new(value.ty.with(to), regs.collect()))
    }

    pub(crate) fn binary(&mut self, op: BinaryOperator, a: &Value, b: &Value) -> Result<Value, ExactError> {
        let kind = a.ty.kind().ok_or_else(|| self.uncovered("an operator on an array or structure"))?;
        if op == BinaryOperator::Multiply
            && let Some(product) = self.product(a, b)
        {
            return Ok(product);
        }
        let count = a.regs.len().max(b.regs.len());
        let pick = |value: &Value, index: usize| value.regs[if value.regs.len() == 1 { 0 } else { index }];
        let mut regs = Vec::with_capacity(count);
        for index in 0..count {
            regs.push(self.scalar_binary(op, kind, pick(a, index), pick(b, index))?);
        }
        let truth = regs[0].file == File::Bool;
        let shape = if a.regs.len() >= b.regs.len() { &a.ty } else { &b.ty };
        Ok(Value::new(if truth { shape.with(ScalarType::Bool) } else { shape.clone() }, regs))
    }

    fn scalar_binary(&mut self, op: BinaryOperator, kind: ScalarType, a: Reg, b: Reg) -> Result<Reg, ExactError> {
        use BinaryOperator as B;
        let signed = kind.signed();
        let integer = matches!(kind, ScalarType::Sint | ScalarType::Uint);
        if integer && matches!(op, B::Divide | B::Modulo) {
            self.watch_divisor(b);
        }
        let (less, less_equal) = if integer {
            (Op::IntLess, None)
        } else {
            (Op::Compare(Comparison::Less), Some(Op::Compare(Comparison::LessEqual)))
        };
        let not = |lower: &mut Self, op: Op, a: Reg, b: Reg| {
            let reg = lower.emit(op, signed, &[a, b]);
            lower.emit(Op::Not, false, &[reg])
        };
        let equal = match kind {
            ScalarType::Float => Op::Compare(Comparison::Equal),
            ScalarType::Bool => Op::BoolEqual,
            _ => Op::IntEqual,
        };
        let simple = match (op, kind) {
            (B::Add, ScalarType::Float) => Op::Binary(Binary::Add),
            (B::Subtract, ScalarType::Float) => Op::Binary(Binary::Sub),
            (B::Multiply, ScalarType::Float) if a == b => return Ok(self.emit(Op::Unary(Unary::Square), false, &[a])),
            (B::Multiply, ScalarType::Float) => Op::Binary(Binary::Mul),
            (B::Divide, ScalarType::Float) => Op::Binary(Binary::Div),
            (B::Modulo, ScalarType::Float) => Op::Binary(Binary::Rem),
            (B::Add, _) => Op::Int(IntBinary::Add),
            (B::Subtract, _) => Op::Int(IntBinary::Sub),
            (B::Multiply, _) => Op::Int(IntBinary::Mul),
            (B::Divide, _) => Op::Int(IntBinary::Div),
            (B::Modulo, _) => Op::Int(IntBinary::Rem),
            (B::ShiftLeft, _) => Op::Int(IntBinary::ShiftLeft),
            (B::ShiftRight, _) => Op::Int(IntBinary::ShiftRight),
            (B::And | B::LogicalAnd, ScalarType::Bool) => Op::And,
            (B::InclusiveOr | B::LogicalOr, ScalarType::Bool) => Op::Or,
            (B::ExclusiveOr, ScalarType::Bool) => return Ok(not(self, Op::BoolEqual, a, b)),
            (B::And, _) => Op::Int(IntBinary::And),
            (B::InclusiveOr, _) => Op::Int(IntBinary::Or),
            (B::ExclusiveOr, _) => Op::Int(IntBinary::Xor),
            (B::Equal, _) => equal,
            (B::NotEqual, _) => return Ok(not(self, equal, a, b)),
            (B::Less, _) => less,
            (B::Greater, _) => return Ok(self.emit(less, signed, &[b, a])),
            (B::LessEqual, _) => match less_equal {
                Some(op) => op,
                None => return Ok(not(self, less, b, a)),
            },
            (B::GreaterEqual, _) => match less_equal {
                Some(op) => return Ok(self.emit(op, false, &[b, a])),
                None => return Ok(not(self, less, a, b)),
            },
            (other, kind) => return Err(self.uncovered(format!("the operator {other:?} on {kind:?}"))),
        };
        Ok(self.emit(simple, signed, &[a, b]))
    }

    /// A product of matrices and vectors; `None` for products by component.
    fn product(&mut self, a: &Value, b: &Value) -> Option<Value> {
        match (&a.ty, &b.ty) {
            (Ty::Matrix(columns, rows), Ty::Vector(..)) => {
                let regs = (0..*rows).map(|row| {
                    let of_row: Vec<Reg> = (0..*columns).map(|column| a.regs[column * rows + row]).collect();
                    self.dot(&of_row, &b.regs)
                });
                Some(Value::new(Ty::Vector(ScalarType::Float, *rows), regs.collect()))
            }
            (Ty::Vector(..), Ty::Matrix(columns, rows)) => {
                let regs = (0..*columns).map(|column| self.dot(&a.regs, &b.regs[column * rows..(column + 1) * rows]));
                Some(Value::new(Ty::Vector(ScalarType::Float, *columns), regs.collect()))
            }
            (Ty::Matrix(inner, rows), Ty::Matrix(columns, _)) => {
                let mut regs = Vec::new();
                for column in 0..*columns {
                    for row in 0..*rows {
                        let of_row: Vec<Reg> = (0..*inner).map(|k| a.regs[k * rows + row]).collect();
                        regs.push(self.dot(&of_row, &b.regs[column * inner..(column + 1) * inner]));
                    }
                }
                Some(Value::new(Ty::Matrix(*columns, *rows), regs))
            }
            _ => None,
        }
    }

    /// Dot product.
    pub(crate) fn dot(&mut self, a: &[Reg], b: &[Reg]) -> Reg {
        let mut sum = None;
        for (a, b) in a.iter().zip(b) {
            sum = Some(match sum {
                None if a == b => self.emit(Op::Unary(Unary::Square), false, &[*a]),
                None => self.emit(Op::Binary(Binary::Mul), false, &[*a, *b]),
                Some(sum) if a == b => {
                    let square = self.emit(Op::Unary(Unary::Square), false, &[*a]);
                    self.emit(Op::Binary(Binary::Add), false, &[sum, square])
                }
                Some(sum) => self.emit(Op::MulAdd, false, &[*a, *b, sum]),
            });
        }
        sum.unwrap_or_else(|| self.float(0.0))
    }
}
