//! Lowering of the mathematical functions of GLSL.

use super::function::Lower;
use super::types::{ScalarType, Ty, Value};
use crate::code::{Op, Reg};
use crate::error::ExactError;
use crate::number::{Binary, Comparison, IntBinary, IntUnary, Unary};
use naga::{BinaryOperator, MathFunction};

/// The function of one float of the same name, if there is one.
fn unary(function: MathFunction) -> Option<Unary> {
    macro_rules! named {
        ($($name:ident)*) => {
            match function {
                $(MathFunction::$name => Some(Unary::$name),)*
                _ => None,
            }
        };
    }
    named!(Abs Sign Ceil Floor Round Fract Trunc Saturate Sqrt InverseSqrt Exp Exp2 Log Log2 Sin Cos Tan Asin Acos
        Atan Sinh Cosh Tanh Asinh Acosh Atanh)
}

impl Lower<'_> {
    pub(crate) fn math(&mut self, function: MathFunction, values: &[Value]) -> Result<Value, ExactError> {
        use MathFunction as M;
        let a = &values[0];
        let kind = a.ty.kind().ok_or_else(|| self.uncovered("a function of an array or structure"))?;
        let float = kind == ScalarType::Float;
        let (op, count) = match function {
            M::Abs if !float => (Op::IntUnary(IntUnary::Abs), 1),
            M::Sign if !float => (Op::IntUnary(IntUnary::Sign), 1),
            M::CountOneBits => (Op::IntUnary(IntUnary::CountBits), 1),
            M::ReverseBits => (Op::IntUnary(IntUnary::ReverseBits), 1),
            M::FirstTrailingBit => (Op::IntUnary(IntUnary::LowestBit), 1),
            M::FirstLeadingBit => (Op::IntUnary(IntUnary::HighestBit), 1),
            M::Min if float => (Op::Binary(Binary::Min), 2),
            M::Max if float => (Op::Binary(Binary::Max), 2),
            M::Min => (Op::Int(IntBinary::Min), 2),
            M::Max => (Op::Int(IntBinary::Max), 2),
            M::Pow => (Op::Binary(Binary::Pow), 2),
            M::Atan2 => (Op::Binary(Binary::Atan2), 2),
            M::Ldexp => (Op::Ldexp, 2),
            M::Fma => (Op::MulAdd, 3),
            M::Mix => (Op::Mix, 3),
            _ => match unary(function) {
                Some(unary) => (Op::Unary(unary), 1),
                None => return self.composite(function, values),
            },
        };
        let mut found = self.by_component(op, &values[..count]);
        if matches!(function, M::CountOneBits | M::FirstTrailingBit | M::FirstLeadingBit) {
            found.ty = found.ty.with(ScalarType::Sint); // GLSL returns int for any argument
        }
        Ok(found)
    }

    fn by_component(&mut self, op: Op, values: &[Value]) -> Value {
        let signed = values[0].ty.kind().is_some_and(ScalarType::signed);
        let widest = values.iter().max_by_key(|value| value.regs.len()).unwrap_or(&values[0]);
        let (count, ty) = (widest.regs.len(), widest.ty.clone());
        let regs = (0..count).map(|index| {
            let pick = |value: &Value| value.regs[if value.regs.len() == 1 { 0 } else { index }];
            let sources: Vec<Reg> = values.iter().map(pick).collect();
            self.emit(op, signed, &sources)
        });
        Value::new(ty, regs.collect())
    }

    fn scaled(&mut self, value: &Value, by: Reg) -> Value {
        let by = Value::new(Ty::Scalar(ScalarType::Float), vec![by]);
        self.by_component(Op::Binary(Binary::Mul), &[value.clone(), by])
    }

    fn length(&mut self, regs: &[Reg]) -> Reg {
        match regs {
            [reg] => self.emit(Op::Unary(Unary::Abs), false, &[*reg]),
            _ => {
                // Bounds of a sum of squares may extend below 0.
                let (square, zero) = (self.dot(regs, regs), self.float(0.0));
                let square = self.emit(Op::Binary(Binary::Max), false, &[square, zero]);
                self.emit(Op::Unary(Unary::Sqrt), false, &[square])
            }
        }
    }

    /// Functions of several operations.
    fn composite(&mut self, function: MathFunction, values: &[Value]) -> Result<Value, ExactError> {
        use BinaryOperator as B;
        use MathFunction as M;
        let a = &values[0];
        let float = a.ty.kind() == Some(ScalarType::Float);
        let second = || values.get(1).cloned().unwrap_or_else(|| a.clone());
        let third = || values.get(2).cloned().unwrap_or_else(|| a.clone());
        let scalar = |reg: Reg| Value::new(Ty::Scalar(ScalarType::Float), vec![reg]);
        Ok(match function {
            M::Clamp => {
                let (min, max) = if float {
                    (Op::Binary(Binary::Min), Op::Binary(Binary::Max))
                } else {
                    (Op::Int(IntBinary::Min), Op::Int(IntBinary::Max))
                };
                let (zero, one) = (self.float(0.0), self.float(1.0));
                let (low, high) = (second(), third());
                if low.regs.iter().all(|reg| *reg == zero) && high.regs.iter().all(|reg| *reg == one) {
                    return Ok(self.by_component(Op::Unary(Unary::Saturate), std::slice::from_ref(a)));
                }
                let low = self.by_component(max, &[a.clone(), low]);
                self.by_component(min, &[low, high])
            }
            M::Radians | M::Degrees => {
                let degree = std::f64::consts::PI / 180.0;
                let factor = self.float(if function == M::Radians { degree } else { 1.0 / degree });
                self.scaled(a, factor)
            }
            M::Step => {
                let below = self.binary(B::Less, &second(), a)?;
                let (one, zero) = (self.float(1.0), self.float(0.0));
                let regs = below.regs.iter().map(|below| self.emit(Op::Select, false, &[*below, zero, one]));
                Value::new(below.ty.with(ScalarType::Float), regs.collect())
            }
            M::SmoothStep => {
                let (from, to, x) = (a, second(), third());
                let way = self.binary(B::Subtract, &x, from)?;
                let whole = self.binary(B::Subtract, &to, from)?;
                let part = self.binary(B::Divide, &way, &whole)?;
                let part = self.by_component(Op::Unary(Unary::Saturate), &[part]);
                self.by_component(Op::Unary(Unary::Hermite), &[part])
            }
            M::Dot if float => scalar(self.dot(&a.regs, &second().regs)),
            M::Length => scalar(self.length(&a.regs)),
            M::Distance => {
                let way = self.binary(B::Subtract, a, &second())?;
                scalar(self.length(&way.regs))
            }
            M::Normalize => {
                let length = self.length(&a.regs);
                self.by_component(Op::Binary(Binary::Unit), &[a.clone(), scalar(length)])
            }
            M::Cross => {
                let b = second();
                let regs = (0..3).map(|axis| {
                    let (y, z) = ((axis + 1) % 3, (axis + 2) % 3);
                    let right = self.emit(Op::Binary(Binary::Mul), false, &[a.regs[z], b.regs[y]]);
                    let left = self.emit(Op::Binary(Binary::Mul), false, &[a.regs[y], b.regs[z]]);
                    self.emit(Op::Binary(Binary::Sub), false, &[left, right])
                });
                Value::new(a.ty.clone(), regs.collect())
            }
            M::FaceForward => {
                let facing = self.dot(&third().regs, &second().regs);
                let zero = self.float(0.0);
                let facing = self.emit(Op::Compare(Comparison::Less), false, &[facing, zero]);
                let back = self.by_component(Op::Unary(Unary::Negate), std::slice::from_ref(a));
                self.chosen(facing, a, &back)
            }
            M::Reflect => {
                let normal = second();
                let cosine = self.dot(&normal.regs, &a.regs);
                let two = self.float(2.0);
                let twice = self.emit(Op::Binary(Binary::Mul), false, &[two, cosine]);
                let along = self.scaled(&normal, twice);
                self.binary(B::Subtract, a, &along)?
            }
            M::Refract => self.refract(a, &second(), third().regs[0])?,
            M::Outer => {
                let b = second();
                let mut regs = Vec::new();
                for column in b.regs.iter() {
                    regs.extend(a.regs.iter().map(|row| self.emit(Op::Binary(Binary::Mul), false, &[*row, *column])));
                }
                Value::new(Ty::Matrix(b.regs.len(), a.regs.len()), regs)
            }
            M::Transpose => {
                let Ty::Matrix(columns, rows) = a.ty else {
                    return Err(self.uncovered("a transpose of a value other than a matrix"));
                };
                let regs = (0..rows).flat_map(|row| (0..columns).map(move |column| a.regs[column * rows + row]));
                Value::new(Ty::Matrix(rows, columns), regs.collect())
            }
            M::Determinant | M::Inverse => {
                let Ty::Matrix(size, _) = a.ty else {
                    return Err(self.uncovered("a determinant of a value other than a matrix"));
                };
                let all: Vec<usize> = (0..size).collect();
                let determinant = self.minor(&a.regs, size, &all, &all);
                if function == M::Determinant {
                    return Ok(scalar(determinant));
                }
                let mut regs = Vec::new();
                for (column, row) in (0..size).flat_map(|column| (0..size).map(move |row| (column, row))) {
                    // The adjugate: cofactors, transposed.
                    let without = |left_out: usize| (0..size).filter(|at| *at != left_out).collect::<Vec<_>>();
                    let minor = self.minor(&a.regs, size, &without(row), &without(column));
                    let signed = match (row + column) % 2 {
                        0 => minor,
                        _ => self.emit(Op::Unary(Unary::Negate), false, &[minor]),
                    };
                    regs.push(self.emit(Op::Binary(Binary::Div), false, &[signed, determinant]));
                }
                Value::new(a.ty.clone(), regs)
            }
            other => return Err(self.uncovered(format!("the function {other:?}"))),
        })
    }

    /// `a` where the truth holds, else `b`.
    fn chosen(&mut self, truth: Reg, a: &Value, b: &Value) -> Value {
        let pairs = a.regs.iter().zip(b.regs.iter());
        let regs = pairs.map(|(a, b)| self.emit(Op::Select, false, &[truth, *a, *b]));
        Value::new(a.ty.clone(), regs.collect())
    }

    fn refract(&mut self, incident: &Value, normal: &Value, eta: Reg) -> Result<Value, ExactError> {
        let (zero, one) = (self.float(0.0), self.float(1.0));
        let cosine = self.dot(&normal.regs, &incident.regs);
        let square = self.emit(Op::Unary(Unary::Square), false, &[cosine]);
        let sine = self.emit(Op::Binary(Binary::Sub), false, &[one, square]);
        let eta2 = self.emit(Op::Unary(Unary::Square), false, &[eta]);
        let sine = self.emit(Op::Binary(Binary::Mul), false, &[eta2, sine]);
        let k = self.emit(Op::Binary(Binary::Sub), false, &[one, sine]);
        let total = self.emit(Op::Compare(Comparison::Less), false, &[k, zero]);
        let held = self.emit(Op::Binary(Binary::Max), false, &[k, zero]);
        let root = self.emit(Op::Unary(Unary::Sqrt), false, &[held]);
        let along = self.emit(Op::MulAdd, false, &[eta, cosine, root]);
        let bent = self.scaled(incident, eta);
        let normal = self.scaled(normal, along);
        let bent = self.binary(BinaryOperator::Subtract, &bent, &normal)?;
        let nothing = Value::new(bent.ty.clone(), vec![zero; bent.regs.len()]);
        Ok(self.chosen(total, &nothing, &bent))
    }

    /// The determinant of a submatrix.
    fn minor(&mut self, regs: &[Reg], size: usize, columns: &[usize], rows: &[usize]) -> Reg {
        if let ([column], [row]) = (columns, rows) {
            return regs[column * size + row];
        }
        let mut sum = None;
        for (index, row) in rows.iter().enumerate() {
            let others: Vec<usize> = rows.iter().copied().filter(|other| other != row).collect();
            let minor = self.minor(regs, size, &columns[1..], &others);
            let part = self.emit(Op::Binary(Binary::Mul), false, &[regs[columns[0] * size + row], minor]);
            let op = if index % 2 == 0 { Op::Binary(Binary::Add) } else { Op::Binary(Binary::Sub) };
            sum = Some(sum.map_or(part, |sum| self.emit(op, false, &[sum, part])));
        }
        sum.unwrap_or_else(|| self.float(1.0))
    }
}
