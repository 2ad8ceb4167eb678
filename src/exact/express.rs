//! Lowering of expressions: loads, stores, element access, operators, conversions and lookups.

use super::ExactError;
use super::code::{Lookup, Op, Pair, Reg, Source};
use super::lower::{Class, Frame, Lower};
use super::number::{IntBinary, IntUnary, Unary};
use super::value::{Kind, Place, Thing, Ty, Value};
use naga::{BinaryOperator, Expression, Function, Handle, ImageQuery, Literal, SampleLevel, ScalarKind, UnaryOperator};
use std::rc::Rc;

impl<'m> Lower<'m> {
    /// What an expression stands for; computed when it is first asked for.
    pub(super) fn thing(&mut self, frame: &mut Frame<'m>, handle: Handle<Expression>) -> Result<Thing, ExactError> {
        if let Some(thing) = frame.things.get(&handle) {
            return Ok(thing.clone());
        }
        self.visit(frame.function, handle);
        let thing = self.expression(frame, handle)?;
        frame.things.insert(handle, thing.clone());
        Ok(thing)
    }

    pub(super) fn value(&mut self, frame: &mut Frame<'m>, handle: Handle<Expression>) -> Result<Value, ExactError> {
        match self.thing(frame, handle)? {
            Thing::Value(value) => Ok(value),
            _ => Err(self.refuse("a pointer, image or sampler as a value")),
        }
    }

    pub(super) fn scalar(&mut self, frame: &mut Frame<'m>, handle: Handle<Expression>) -> Result<Reg, ExactError> {
        let value = self.value(frame, handle)?;
        if value.regs.len() == 1 { Ok(value.regs[0]) } else { Err(self.refuse("a vector in place of a scalar")) }
    }

    pub(super) fn place(&mut self, frame: &mut Frame<'m>, handle: Handle<Expression>) -> Result<Place, ExactError> {
        match self.thing(frame, handle)? {
            Thing::Place(place) => Ok(place),
            _ => Err(self.refuse("a pointer that is no variable's")),
        }
    }

    /// The value of a constant expression of the module.
    pub(super) fn constant(&mut self, handle: Handle<Expression>) -> Result<Value, ExactError> {
        match self.module.global_expressions[handle].clone() {
            Expression::Literal(literal) => self.literal(literal),
            Expression::Constant(constant) => self.constant(self.module.constants[constant].init),
            Expression::ZeroValue(ty) => {
                let ty = self.ty(ty)?;
                let regs = self.zero(&ty);
                Ok(Value::new(ty, regs))
            }
            Expression::Compose { ty, components } => {
                let ty = self.ty(ty)?;
                let mut regs = Vec::new();
                for component in components {
                    regs.extend_from_slice(&self.constant(component)?.regs);
                }
                Ok(Value::new(ty, regs))
            }
            Expression::Splat { size, value } => {
                let value = self.constant(value)?;
                Ok(splat(&value, size as usize))
            }
            other => Err(self.refuse(format!("the constant {}", name(&other)))),
        }
    }

    fn literal(&mut self, literal: Literal) -> Result<Value, ExactError> {
        let (kind, reg) = match literal {
            Literal::F32(x) => (Kind::Float, self.float(f64::from(x))),
            Literal::I32(x) => (Kind::Sint, self.int(x as u32, true)),
            Literal::U32(x) => (Kind::Uint, self.int(x, false)),
            Literal::Bool(x) => (Kind::Bool, self.source(super::code::File::Truth, Source::Truth(x))),
            other => return Err(self.refuse(format!("the literal {other:?}"))),
        };
        Ok(Value::new(Ty::Scalar(kind), vec![reg]))
    }

    fn expression(&mut self, frame: &mut Frame<'m>, handle: Handle<Expression>) -> Result<Thing, ExactError> {
        let function: &'m Function = frame.function;
        let value = match &function.expressions[handle] {
            Expression::Literal(literal) => self.literal(*literal)?,
            Expression::Constant(constant) => self.constant(self.module.constants[*constant].init)?,
            Expression::ZeroValue(ty) => {
                let ty = self.ty(*ty)?;
                let regs = self.zero(&ty);
                Value::new(ty, regs)
            }
            Expression::Compose { ty, components } => {
                let ty = self.ty(*ty)?;
                let mut regs = Vec::new();
                for component in components {
                    regs.extend_from_slice(&self.value(frame, *component)?.regs);
                }
                Value::new(ty, regs)
            }
            Expression::Access { base, index } => return self.access(frame, *base, *index),
            Expression::AccessIndex { base, index } => {
                let part = match self.thing(frame, *base)? {
                    Thing::Value(value) => value.element(*index as usize).map(Thing::Value),
                    Thing::Place(place) => place.element(*index as usize).map(Thing::Place),
                    _ => None,
                };
                return part.ok_or_else(|| self.refuse("an index out of range"));
            }
            Expression::Splat { size, value } => splat(&self.value(frame, *value)?, *size as usize),
            Expression::Swizzle { size, vector, pattern } => {
                let vector = self.value(frame, *vector)?;
                let regs = pattern[..*size as usize].iter().map(|component| vector.regs[*component as usize]);
                let kind = vector.ty.kind().ok_or_else(|| self.refuse("a swizzle of no vector"))?;
                Value::new(Ty::Vector(kind, *size as usize), regs.collect())
            }
            Expression::FunctionArgument(index) => return Ok(frame.arguments[*index as usize].clone()),
            Expression::GlobalVariable(global) => return self.global(*global),
            Expression::LocalVariable(local) => return Ok(Thing::Place(frame.locals[local].clone())),
            Expression::Load { pointer } => match self.thing(frame, *pointer)? {
                Thing::Place(place) => self.load(&place),
                resource => return Ok(resource),
            },
            Expression::ImageSample {
                image,
                sampler,
                gather: None,
                coordinate,
                array_index: None,
                offset: None,
                level,
                depth_ref: None,
                ..
            } => {
                // There is one level: it answers whatever is asked for.
                if !matches!(level, SampleLevel::Auto | SampleLevel::Zero | SampleLevel::Exact(_)) {
                    return Err(self.refuse("a texture lookup with a bias or gradients"));
                }
                self.lookup(frame, *image, Some(*sampler), *coordinate)?
            }
            Expression::ImageSample { .. } => {
                return Err(self.refuse("a texture lookup with gather, offset, layers or comparison"));
            }
            Expression::ImageLoad { image, coordinate, array_index: None, sample: None, .. } => {
                self.lookup(frame, *image, None, *coordinate)?
            }
            Expression::ImageQuery { image, query: ImageQuery::Size { .. } } => {
                let Thing::Image(binding, axes, _) = self.thing(frame, *image)? else {
                    return Err(self.refuse("the size of no image"));
                };
                let size = |axis| Source::Size { image: binding, axis, signed: false };
                let regs = (0..axes).map(|axis| self.source(super::code::File::Int, size(axis))).collect();
                Value::new(if axes == 1 { Ty::Scalar(Kind::Uint) } else { Ty::Vector(Kind::Uint, axes) }, regs)
            }
            Expression::Unary { op, expr } => {
                let value = self.value(frame, *expr)?;
                self.unary(*op, &value)?
            }
            Expression::Binary { op, left, right } => {
                let (left, right) = (self.value(frame, *left)?, self.value(frame, *right)?);
                self.binary(*op, &left, &right)?
            }
            Expression::Select { condition, accept, reject } => {
                let condition = self.value(frame, *condition)?;
                let (accept, reject) = (self.value(frame, *accept)?, self.value(frame, *reject)?);
                let pairs = accept.regs.iter().zip(reject.regs.iter()).enumerate();
                let regs = pairs.map(|(index, (a, b))| {
                    let condition = condition.regs[if condition.regs.len() == 1 { 0 } else { index }];
                    self.emit(Op::Select, false, &[condition, *a, *b])
                });
                Value::new(accept.ty.clone(), regs.collect())
            }
            Expression::Derivative { axis, expr, .. } => {
                let value = self.value(frame, *expr)?;
                self.code.derivatives = true;
                let regs = value.regs.iter().map(|reg| {
                    let along = |lower: &mut Self, y| lower.emit(Op::Derivative(y), false, &[*reg]);
                    match axis {
                        naga::DerivativeAxis::X => along(self, false),
                        naga::DerivativeAxis::Y => along(self, true),
                        naga::DerivativeAxis::Width => {
                            let both = [along(self, false), along(self, true)];
                            let [x, y] = both.map(|reg| self.emit(Op::Unary(Unary::Abs), false, &[reg]));
                            self.emit(Op::Add, false, &[x, y])
                        }
                    }
                });
                let regs = regs.collect();
                Value::new(value.ty.clone(), regs)
            }
            Expression::Relational { fun, argument } => {
                let value = self.value(frame, *argument)?;
                self.relational(*fun, &value)?
            }
            Expression::Math { fun, arg, arg1, arg2, arg3 } => {
                let mut values = vec![self.value(frame, *arg)?];
                for argument in [arg1, arg2, arg3].into_iter().flatten() {
                    values.push(self.value(frame, *argument)?);
                }
                self.math(*fun, &values)?
            }
            Expression::As { expr, kind, convert } => {
                let value = self.value(frame, *expr)?;
                self.convert(&value, *kind, convert.is_some())?
            }
            other => return Err(self.refuse(format!("the expression {}", name(other)))),
        };
        Ok(Thing::Value(value))
    }

    fn access(
        &mut self,
        frame: &mut Frame<'m>,
        base: Handle<Expression>,
        index: Handle<Expression>,
    ) -> Result<Thing, ExactError> {
        let index = self.scalar(frame, index)?;
        let base = self.thing(frame, base)?;
        let (ty, regs, outer) = match &base {
            Thing::Value(value) => (&value.ty, vec![value.regs.clone()], None),
            Thing::Place(place) => (&place.ty, place.choices.clone(), place.index),
            _ => return Err(self.refuse("an array of images")),
        };
        let count = ty.count();
        let (element, _) = ty.element(0).ok_or_else(|| self.refuse("an index into a scalar"))?;
        let size = element.size();
        let parts = regs.iter().flat_map(|regs| regs.chunks_exact(size).map(Rc::from));
        let choices: Vec<Rc<[Reg]>> = parts.collect();
        let index = match outer {
            None => index,
            Some(outer) => {
                let limits = [0, count as u32 - 1].map(|limit| self.int(limit, true));
                let low = self.emit(Op::Int(IntBinary::Max), true, &[index, limits[0]]);
                let held = self.emit(Op::Int(IntBinary::Min), true, &[low, limits[1]]);
                let count = self.int(count as u32, true);
                let first = self.emit(Op::Int(IntBinary::Mul), true, &[outer, count]);
                self.emit(Op::Int(IntBinary::Add), true, &[first, held])
            }
        };
        let place = Place { ty: element, choices, index: Some(index) };
        Ok(match base {
            Thing::Value(_) => Thing::Value(self.load(&place)),
            _ => Thing::Place(place),
        })
    }

    fn load(&mut self, place: &Place) -> Value {
        let regs = (0..place.ty.size()).map(|scalar| match place.index {
            Some(index) => {
                let table: Vec<Reg> = place.choices.iter().map(|choice| choice[scalar]).collect();
                self.emit_table(Op::Gather, true, &[index], &table)
            }
            None => {
                let reg = place.choices[0][scalar];
                let variable = !reg.uniform && self.classes[reg.file as usize][reg.index as usize] != Class::Temporary;
                if variable { self.copy(reg) } else { reg }
            }
        });
        let regs = regs.collect();
        Value::new(place.ty.clone(), regs)
    }

    /// The value that a variable has now.
    fn copy(&mut self, reg: Reg) -> Reg {
        let dst = self.register(reg.file, Class::Temporary);
        self.assign(dst, reg);
        if let Some(instr) = self.code.instrs.last_mut() {
            instr.masked = false;
        }
        dst
    }

    pub(super) fn store(&mut self, place: &Place, value: &Value) {
        for (choice, regs) in place.choices.iter().enumerate() {
            for (dst, value) in regs.iter().zip(value.regs.iter()) {
                match place.index {
                    None => self.assign(*dst, *value),
                    Some(index) => {
                        let number = self.int(choice as u32, true);
                        let here = self.emit(Op::IntEqual, true, &[index, number]);
                        let chosen = self.emit(Op::Select, false, &[here, *value, *dst]);
                        self.assign(*dst, chosen);
                    }
                }
            }
        }
    }

    fn lookup(
        &mut self,
        frame: &mut Frame<'m>,
        image: Handle<Expression>,
        sampler: Option<Handle<Expression>>,
        at: Handle<Expression>,
    ) -> Result<Value, ExactError> {
        let Thing::Image(image, axes, true) = self.thing(frame, image)? else {
            return Err(self.refuse("a lookup in an image of integers"));
        };
        let sampler = match sampler.map(|sampler| self.thing(frame, sampler)).transpose()? {
            None => None,
            Some(Thing::Sampler(binding)) => Some(binding),
            Some(_) => return Err(self.refuse("a lookup through no sampler")),
        };
        let at = self.value(frame, at)?;
        if at.regs.len() != axes {
            return Err(self.refuse("a lookup with as many coordinates as the image has not"));
        }
        let pair = Pair { image, sampler, axes };
        let found = self.code.images.iter().position(|known| *known == pair);
        let image = found.unwrap_or_else(|| {
            self.code.images.push(pair);
            self.code.images.len() - 1
        });
        let channels = [0; 4].map(|_| self.register(super::code::File::Float, Class::Temporary));
        let op = if sampler.is_some() { Op::Sample } else { Op::Fetch };
        let table = self.code.lookups.len() as u32;
        self.code.lookups.push(Lookup { image, at: at.regs.to_vec(), channels: channels.map(Some) });
        let (dst, sources) = (channels[0], [at.regs[0]; 3]);
        let instr = super::code::Instr { op, signed: true, masked: false, dst, sources, count: 0, table };
        self.code.instrs.push(instr);
        Ok(Value::new(Ty::Vector(Kind::Float, 4), channels.to_vec()))
    }

    fn unary(&mut self, op: UnaryOperator, value: &Value) -> Result<Value, ExactError> {
        let kind = value.ty.kind().ok_or_else(|| self.refuse("an operator on an array or structure"))?;
        let op = match (op, kind) {
            (UnaryOperator::Negate, Kind::Float) => Op::Unary(Unary::Negate),
            (UnaryOperator::Negate, _) => Op::IntUnary(IntUnary::Negate),
            (UnaryOperator::LogicalNot, _) => Op::Not,
            (UnaryOperator::BitwiseNot, _) => Op::IntUnary(IntUnary::Not),
        };
        let regs = value.regs.iter().map(|reg| self.emit(op, kind.signed(), &[*reg]));
        let regs = regs.collect();
        Ok(Value::new(value.ty.clone(), regs))
    }

    fn relational(&mut self, function: naga::RelationalFunction, value: &Value) -> Result<Value, ExactError> {
        let regs = value.regs.clone();
        let fold = |lower: &mut Self, op| {
            let all = regs[1..].iter().fold(regs[0], |all, reg| lower.emit(op, false, &[all, *reg]));
            Value::new(Ty::Scalar(Kind::Bool), vec![all])
        };
        let op = match function {
            naga::RelationalFunction::All => return Ok(fold(self, Op::And)),
            naga::RelationalFunction::Any => return Ok(fold(self, Op::Or)),
            naga::RelationalFunction::IsNan => Op::IsNan,
            naga::RelationalFunction::IsInf => Op::IsInfinite,
        };
        let regs = value.regs.iter().map(|reg| self.emit(op, false, &[*reg])).collect();
        Ok(Value::new(value.ty.with(Kind::Bool), regs))
    }

    fn convert(&mut self, value: &Value, kind: ScalarKind, convert: bool) -> Result<Value, ExactError> {
        let to = match kind {
            ScalarKind::Float => Kind::Float,
            ScalarKind::Sint => Kind::Sint,
            ScalarKind::Uint => Kind::Uint,
            ScalarKind::Bool => Kind::Bool,
            other => return Err(self.refuse(format!("a conversion to {other:?}"))),
        };
        let from = value.ty.kind().ok_or_else(|| self.refuse("a conversion of an array or structure"))?;
        if from == to {
            return Ok(value.clone());
        }
        let constant = |lower: &mut Self, number: u32| match to {
            Kind::Float => lower.float(f64::from(number)),
            _ => lower.int(number, to.signed()),
        };
        let regs = value.regs.iter().map(|reg| match (from, to) {
            (Kind::Float, Kind::Sint | Kind::Uint) if convert => self.emit(Op::ToInt, to.signed(), &[*reg]),
            (Kind::Float, Kind::Sint | Kind::Uint) => self.emit(Op::ToBits, to.signed(), &[*reg]),
            (Kind::Sint | Kind::Uint, Kind::Float) if convert => self.emit(Op::FromInt, from.signed(), &[*reg]),
            (Kind::Sint | Kind::Uint, Kind::Float) => self.emit(Op::FromBits, false, &[*reg]),
            (Kind::Sint | Kind::Uint, Kind::Sint | Kind::Uint) => self.emit(Op::Reread, to.signed(), &[*reg]),
            (Kind::Bool, _) => {
                let (one, zero) = (constant(self, 1), constant(self, 0));
                self.emit(Op::Select, false, &[*reg, one, zero])
            }
            (Kind::Float, _) => {
                let zero = self.float(0.0);
                let same = self.emit(Op::Equal, false, &[*reg, zero]);
                self.emit(Op::Not, false, &[same])
            }
            _ => {
                let zero = self.int(0, false);
                let same = self.emit(Op::IntEqual, false, &[*reg, zero]);
                self.emit(Op::Not, false, &[same])
            }
        });
        let regs = regs.collect();
        Ok(Value::new(value.ty.with(to), regs))
    }

    pub(super) fn binary(&mut self, op: BinaryOperator, a: &Value, b: &Value) -> Result<Value, ExactError> {
        let kind = a.ty.kind().ok_or_else(|| self.refuse("an operator on an array or structure"))?;
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
        let truth = regs[0].file == super::code::File::Truth;
        let shape = if a.regs.len() >= b.regs.len() { &a.ty } else { &b.ty };
        Ok(Value::new(if truth { shape.with(Kind::Bool) } else { shape.clone() }, regs))
    }

    fn scalar_binary(&mut self, op: BinaryOperator, kind: Kind, a: Reg, b: Reg) -> Result<Reg, ExactError> {
        use BinaryOperator as B;
        let signed = kind.signed();
        let integer = matches!(kind, Kind::Sint | Kind::Uint);
        let int = |function| Op::Int(function);
        let (less, less_equal) = if integer { (Op::IntLess, None) } else { (Op::Less, Some(Op::LessEqual)) };
        let not = |lower: &mut Self, op: Op, a: Reg, b: Reg| {
            let reg = lower.emit(op, signed, &[a, b]);
            lower.emit(Op::Not, false, &[reg])
        };
        let equal = match kind {
            Kind::Float => Op::Equal,
            Kind::Bool => Op::Same,
            _ => Op::IntEqual,
        };
        let simple = match (op, kind) {
            (B::Add, Kind::Float) => Op::Add,
            (B::Subtract, Kind::Float) => Op::Sub,
            (B::Multiply, Kind::Float) if a == b => return Ok(self.emit(Op::Unary(Unary::Square), false, &[a])),
            (B::Multiply, Kind::Float) => Op::Mul,
            (B::Divide, Kind::Float) => Op::Div,
            (B::Modulo, Kind::Float) => Op::Rem,
            (B::Add, _) => int(IntBinary::Add),
            (B::Subtract, _) => int(IntBinary::Sub),
            (B::Multiply, _) => int(IntBinary::Mul),
            (B::Divide, _) => int(IntBinary::Div),
            (B::Modulo, _) => int(IntBinary::Rem),
            (B::ShiftLeft, _) => int(IntBinary::ShiftLeft),
            (B::ShiftRight, _) => int(IntBinary::ShiftRight),
            (B::And | B::LogicalAnd, Kind::Bool) => Op::And,
            (B::InclusiveOr | B::LogicalOr, Kind::Bool) => Op::Or,
            (B::ExclusiveOr, Kind::Bool) => return Ok(not(self, Op::Same, a, b)),
            (B::And, _) => int(IntBinary::And),
            (B::InclusiveOr, _) => int(IntBinary::Or),
            (B::ExclusiveOr, _) => int(IntBinary::Xor),
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
            (other, kind) => return Err(self.refuse(format!("the operator {other:?} on {kind:?}"))),
        };
        Ok(self.emit(simple, signed, &[a, b]))
    }

    /// A product in the sense of linear algebra; `None` where it is by component.
    fn product(&mut self, a: &Value, b: &Value) -> Option<Value> {
        match (&a.ty, &b.ty) {
            (Ty::Matrix(columns, rows), Ty::Vector(..)) => {
                let regs = (0..*rows).map(|row| {
                    let of_row: Vec<Reg> = (0..*columns).map(|column| a.regs[column * rows + row]).collect();
                    self.dot(&of_row, &b.regs)
                });
                let regs = regs.collect();
                Some(Value::new(Ty::Vector(Kind::Float, *rows), regs))
            }
            (Ty::Vector(..), Ty::Matrix(columns, rows)) => {
                let regs = (0..*columns).map(|column| self.dot(&a.regs, &b.regs[column * rows..(column + 1) * rows]));
                let regs = regs.collect();
                Some(Value::new(Ty::Vector(Kind::Float, *columns), regs))
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

    /// The sum of products.
    pub(super) fn dot(&mut self, a: &[Reg], b: &[Reg]) -> Reg {
        let mut sum = None;
        for (a, b) in a.iter().zip(b) {
            sum = Some(match sum {
                None if a == b => self.emit(Op::Unary(Unary::Square), false, &[*a]),
                None => self.emit(Op::Mul, false, &[*a, *b]),
                Some(sum) if a == b => {
                    let square = self.emit(Op::Unary(Unary::Square), false, &[*a]);
                    self.emit(Op::Add, false, &[sum, square])
                }
                Some(sum) => self.emit(Op::MulAdd, false, &[*a, *b, sum]),
            });
        }
        sum.unwrap_or_else(|| self.float(0.0))
    }
}

fn splat(value: &Value, size: usize) -> Value {
    match &value.ty {
        Ty::Scalar(kind) => Value::new(Ty::Vector(*kind, size), vec![value.regs[0]; size]),
        _ => value.clone(),
    }
}

/// The name of an expression.
fn name(expression: &Expression) -> String {
    let text = format!("{expression:?}");
    text.split([' ', '(', '{']).next().unwrap_or_default().to_string()
}
