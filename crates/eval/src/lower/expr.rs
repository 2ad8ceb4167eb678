//! Lowering of expressions: loads, element access, conversions and texture lookups.

use super::function::{CallFrame, Class, Lower};
use super::types::{Lowered, ScalarType, Ty, Value, Variable};
use crate::code::{File, Instr, Lookup, Op, Pair, Reg, Source};
use crate::error::ExactError;
use crate::number::{Binary, IntBinary, Unary};
use naga::{Expression, Function, Handle, ImageQuery, Literal, SampleLevel};
use std::rc::Rc;

impl<'m> Lower<'m> {
    /// Lowers an expression at its first use.
    pub(crate) fn lowered(
        &mut self,
        frame: &mut CallFrame<'m>,
        handle: Handle<Expression>,
    ) -> Result<Lowered, ExactError> {
        if let Some(lowered) = frame.lowered.get(&handle) {
            return Ok(lowered.clone());
        }
        self.visit(frame.function, handle);
        let lowered = self.expression(frame, handle)?;
        frame.lowered.insert(handle, lowered.clone());
        Ok(lowered)
    }

    pub(crate) fn value(&mut self, frame: &mut CallFrame<'m>, handle: Handle<Expression>) -> Result<Value, ExactError> {
        match self.lowered(frame, handle)? {
            Lowered::Value(value) => Ok(value),
            _ => Err(self.uncovered("a pointer, image or sampler as a value")),
        }
    }

    pub(crate) fn scalar(&mut self, frame: &mut CallFrame<'m>, handle: Handle<Expression>) -> Result<Reg, ExactError> {
        let value = self.value(frame, handle)?;
        if value.regs.len() == 1 { Ok(value.regs[0]) } else { Err(self.uncovered("a vector in place of a scalar")) }
    }

    pub(crate) fn variable_of(
        &mut self,
        frame: &mut CallFrame<'m>,
        handle: Handle<Expression>,
    ) -> Result<Variable, ExactError> {
        match self.lowered(frame, handle)? {
            Lowered::Variable(variable) => Ok(variable),
            _ => Err(self.uncovered("a pointer to something other than a variable")),
        }
    }

    /// The value of a constant expression of the module.
    pub(crate) fn constant(&mut self, handle: Handle<Expression>) -> Result<Value, ExactError> {
        match self.module.global_expressions[handle].clone() {
            Expression::Literal(literal) => self.literal(literal),
            Expression::Constant(constant) => self.constant(self.module.constants[constant].init),
            Expression::ZeroValue(ty) => {
                let ty = self.ty(ty)?;
                Ok(self.zero(ty))
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
            other => Err(self.uncovered(format!("the constant {}", name(&other)))),
        }
    }

    fn literal(&mut self, literal: Literal) -> Result<Value, ExactError> {
        let (kind, reg) = match literal {
            Literal::F32(x) => (ScalarType::Float, self.float(f64::from(x))),
            Literal::I32(x) => (ScalarType::Sint, self.int(x as u32, true)),
            Literal::U32(x) => (ScalarType::Uint, self.int(x, false)),
            Literal::Bool(x) => (ScalarType::Bool, self.source(File::Bool, Source::Bool(x))),
            other => return Err(self.uncovered(format!("the literal {other:?}"))),
        };
        Ok(Value::new(Ty::Scalar(kind), vec![reg]))
    }

    /// Whether an integer is a literal 0.
    fn is_zero(&self, function: &Function, handle: Handle<Expression>) -> bool {
        let is = |expression: &Expression| {
            matches!(expression, Expression::Literal(Literal::I32(0) | Literal::U32(0)) | Expression::ZeroValue(_))
        };
        match &function.expressions[handle] {
            Expression::Constant(constant) => {
                is(&self.module.global_expressions[self.module.constants[*constant].init])
            }
            own => is(own),
        }
    }

    fn expression(&mut self, frame: &mut CallFrame<'m>, handle: Handle<Expression>) -> Result<Lowered, ExactError> {
        let function: &'m Function = frame.function;
        let value = match &function.expressions[handle] {
            Expression::Literal(literal) => self.literal(*literal)?,
            Expression::Constant(constant) => self.constant(self.module.constants[*constant].init)?,
            Expression::ZeroValue(ty) => {
                let ty = self.ty(*ty)?;
                self.zero(ty)
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
                let part = match self.lowered(frame, *base)? {
                    Lowered::Value(value) => value.element(*index as usize).map(Lowered::Value),
                    Lowered::Variable(place) => place.element(*index as usize).map(Lowered::Variable),
                    _ => None,
                };
                return part.ok_or_else(|| self.uncovered("an index out of range"));
            }
            Expression::Splat { size, value } => splat(&self.value(frame, *value)?, *size as usize),
            Expression::Swizzle { size, vector, pattern } => {
                let vector = self.value(frame, *vector)?;
                let regs = pattern[..*size as usize].iter().map(|component| vector.regs[*component as usize]);
                let kind = vector.ty.kind().ok_or_else(|| self.uncovered("a swizzle of an array or structure"))?;
                Value::new(Ty::Vector(kind, *size as usize), regs.collect())
            }
            Expression::FunctionArgument(index) => return Ok(frame.arguments[*index as usize].clone()),
            Expression::GlobalVariable(global) => return self.global(*global),
            Expression::LocalVariable(local) => return Ok(Lowered::Variable(frame.locals[local].clone())),
            Expression::Load { pointer } => match self.lowered(frame, *pointer)? {
                Lowered::Variable(place) => self.load(&place),
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
                // An implicit level is that of a point: the finest one.
                let level = match level {
                    SampleLevel::Auto | SampleLevel::Zero | SampleLevel::Gradient { .. } => None,
                    SampleLevel::Exact(level) => Some(*level),
                    SampleLevel::Bias(_) => return Err(self.uncovered("a texture lookup with a bias")),
                };
                self.lookup(frame, *image, Some((*sampler, level)), *coordinate)?
            }
            Expression::ImageSample { .. } => {
                return Err(self.uncovered("a texture lookup with gather, offset, layers or comparison"));
            }
            Expression::ImageLoad { image, coordinate, array_index: None, sample: None, .. } => {
                self.lookup(frame, *image, None, *coordinate)?
            }
            Expression::ImageQuery { image, query: ImageQuery::Size { level } } => {
                if level.is_some_and(|level| !self.is_zero(frame.function, level)) {
                    return Err(self.uncovered("the size of a coarser level of an image"));
                }
                let Lowered::Image(binding, axes, _) = self.lowered(frame, *image)? else {
                    return Err(self.uncovered("the size of something other than an image"));
                };
                let size = |axis| Source::Size { image: binding, axis, signed: false };
                let regs = (0..axes).map(|axis| self.source(File::Int, size(axis))).collect();
                Value::new(
                    if axes == 1 { Ty::Scalar(ScalarType::Uint) } else { Ty::Vector(ScalarType::Uint, axes) },
                    regs,
                )
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
                            self.emit(Op::Binary(Binary::Add), false, &[x, y])
                        }
                    }
                });
                Value::new(value.ty.clone(), regs.collect())
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
            other => return Err(self.uncovered(format!("the expression {}", name(other)))),
        };
        Ok(Lowered::Value(value))
    }

    fn access(
        &mut self,
        frame: &mut CallFrame<'m>,
        base: Handle<Expression>,
        index: Handle<Expression>,
    ) -> Result<Lowered, ExactError> {
        let index = self.scalar(frame, index)?;
        let base = self.lowered(frame, base)?;
        let (ty, regs, outer) = match &base {
            Lowered::Value(value) => (&value.ty, vec![value.regs.clone()], None),
            Lowered::Variable(place) => (&place.ty, place.choices.clone(), place.index),
            _ => return Err(self.uncovered("an array of images")),
        };
        let count = ty.count();
        self.watch_index(index, count);
        let (element, _) = ty.element(0).ok_or_else(|| self.uncovered("an index into a scalar"))?;
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
        let place = Variable { ty: element, choices, index: Some(index) };
        Ok(match base {
            Lowered::Value(_) => Lowered::Value(self.load(&place)),
            _ => Lowered::Variable(place),
        })
    }

    fn load(&mut self, place: &Variable) -> Value {
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
        Value::new(place.ty.clone(), regs.collect())
    }

    /// Copies the current value of a variable.
    pub(crate) fn copy(&mut self, reg: Reg) -> Reg {
        let dst = self.register(reg.file, Class::Temporary);
        self.push(Instr::new(Op::Copy, dst, &[reg]));
        dst
    }

    pub(crate) fn store(&mut self, place: &Variable, value: &Value) {
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
        frame: &mut CallFrame<'m>,
        image: Handle<Expression>,
        sampler: Option<(Handle<Expression>, Option<Handle<Expression>>)>,
        at: Handle<Expression>,
    ) -> Result<Value, ExactError> {
        let Lowered::Image(image, axes, true) = self.lowered(frame, image)? else {
            return Err(self.uncovered("a lookup in an image of integers"));
        };
        let level = sampler.and_then(|(_, level)| level).map(|level| self.value(frame, level)).transpose()?;
        let sampler = match sampler.map(|(sampler, _)| self.lowered(frame, sampler)).transpose()? {
            None => None,
            Some(Lowered::Sampler(binding)) => Some(binding),
            Some(_) => return Err(self.uncovered("a lookup through something other than a sampler")),
        };
        let at = self.value(frame, at)?;
        if at.regs.len() != axes {
            return Err(self.uncovered("a lookup whose coordinates do not match the axes of the image"));
        }
        let pair = Pair { image, sampler, axes };
        let found = self.code.images.iter().position(|known| *known == pair);
        let image = found.unwrap_or_else(|| {
            self.code.images.push(pair);
            self.code.images.len() - 1
        });
        let channels = [0; 4].map(|_| self.register(File::Float, Class::Temporary));
        let op = if sampler.is_some() { Op::Sample } else { Op::Fetch };
        let table = self.code.lookups.len() as u32;
        let regs = at.regs.iter().chain(level.iter().flat_map(|level| level.regs.iter())).copied().collect();
        self.code.lookups.push(Lookup { image, at: regs, channels: channels.map(Some) });
        self.push(Instr { signed: true, count: 0, table, ..Instr::new(op, channels[0], &[at.regs[0]]) });
        Ok(Value::new(Ty::Vector(ScalarType::Float, 4), channels.to_vec()))
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
