//! Lowering of expressions: loads, stores, element access, operators, conversions and lookups.

use super::ExactError;
use super::code::{At, Lookup, Op, Pair, Reg, Source};
use super::lower::{CallFrame, Class, Lower};
use super::number::{IntBinary, Unary};
use super::value::{Kind, Lowered, Ty, Value, Variable};
use naga::{Expression, Function, Handle, ImageQuery, Literal, SampleLevel};
use std::rc::Rc;

impl<'m> Lower<'m> {
    /// What an expression stands for; computed when it is first asked for.
    pub(super) fn thing(
        &mut self,
        frame: &mut CallFrame<'m>,
        handle: Handle<Expression>,
    ) -> Result<Lowered, ExactError> {
        if let Some(thing) = frame.things.get(&handle) {
            return Ok(thing.clone());
        }
        self.visit(frame.function, handle);
        let thing = self.expression(frame, handle)?;
        frame.things.insert(handle, thing.clone());
        Ok(thing)
    }

    pub(super) fn value(&mut self, frame: &mut CallFrame<'m>, handle: Handle<Expression>) -> Result<Value, ExactError> {
        match self.thing(frame, handle)? {
            Lowered::Value(value) => Ok(value),
            _ => Err(self.refuse("a pointer, image or sampler as a value")),
        }
    }

    pub(super) fn scalar(&mut self, frame: &mut CallFrame<'m>, handle: Handle<Expression>) -> Result<Reg, ExactError> {
        let value = self.value(frame, handle)?;
        if value.regs.len() == 1 { Ok(value.regs[0]) } else { Err(self.refuse("a vector in place of a scalar")) }
    }

    pub(super) fn place(
        &mut self,
        frame: &mut CallFrame<'m>,
        handle: Handle<Expression>,
    ) -> Result<Variable, ExactError> {
        match self.thing(frame, handle)? {
            Lowered::Variable(place) => Ok(place),
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

    /// Whether an integer is written as 0.
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
                    Lowered::Value(value) => value.element(*index as usize).map(Lowered::Value),
                    Lowered::Variable(place) => place.element(*index as usize).map(Lowered::Variable),
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
            Expression::LocalVariable(local) => return Ok(Lowered::Variable(frame.locals[local].clone())),
            Expression::Load { pointer } => match self.thing(frame, *pointer)? {
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
                // Where no level is named, there is one; a footprint is that of a point, as without anisotropy.
                let level = match level {
                    SampleLevel::Auto | SampleLevel::Zero | SampleLevel::Gradient { .. } => None,
                    SampleLevel::Exact(level) => Some(*level),
                    SampleLevel::Bias(_) => return Err(self.refuse("a texture lookup with a bias")),
                };
                self.lookup(frame, *image, Some((*sampler, level)), *coordinate)?
            }
            Expression::ImageSample { .. } => {
                return Err(self.refuse("a texture lookup with gather, offset, layers or comparison"));
            }
            Expression::ImageLoad { image, coordinate, array_index: None, sample: None, .. } => {
                self.lookup(frame, *image, None, *coordinate)?
            }
            Expression::ImageQuery { image, query: ImageQuery::Size { level } } => {
                if level.is_some_and(|level| !self.is_zero(frame.function, level)) {
                    return Err(self.refuse("the size of a coarser level of an image"));
                }
                let Lowered::Image(binding, axes, _) = self.thing(frame, *image)? else {
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
        Ok(Lowered::Value(value))
    }

    fn access(
        &mut self,
        frame: &mut CallFrame<'m>,
        base: Handle<Expression>,
        index: Handle<Expression>,
    ) -> Result<Lowered, ExactError> {
        let index = self.scalar(frame, index)?;
        let base = self.thing(frame, base)?;
        let (ty, regs, outer) = match &base {
            Lowered::Value(value) => (&value.ty, vec![value.regs.clone()], None),
            Lowered::Variable(place) => (&place.ty, place.choices.clone(), place.index),
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

    pub(super) fn store(&mut self, place: &Variable, value: &Value) {
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
        let Lowered::Image(image, axes, true) = self.thing(frame, image)? else {
            return Err(self.refuse("a lookup in an image of integers"));
        };
        let level = sampler.and_then(|(_, level)| level).map(|level| self.value(frame, level)).transpose()?;
        let sampler = match sampler.map(|(sampler, _)| self.thing(frame, sampler)).transpose()? {
            None => None,
            Some(Lowered::Sampler(binding)) => Some(binding),
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
        let regs = at.regs.iter().chain(level.iter().flat_map(|level| level.regs.iter())).copied().collect();
        self.code.lookups.push(Lookup { image, at: regs, channels: channels.map(Some) });
        let (dst, sources) = (channels[0], [at.regs[0]; 3]);
        let instr =
            super::code::Instr { op, signed: true, masked: false, dst, sources, count: 0, table, at: At::default() };
        self.code.instrs.push(instr);
        Ok(Value::new(Ty::Vector(Kind::Float, 4), channels.to_vec()))
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
