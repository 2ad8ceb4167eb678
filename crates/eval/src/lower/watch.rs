//! Notes of faults in watched functions: NaN and infinite results, indices out of range, and integer divisions by 0.

use super::faults::{FAULTS, Fault, Watch, Watching};
use super::function::{CallFrame, Class, Lower};
use super::types::{Lowered, Value};
use super::words::Words;
use crate::code::{File, Op, Reg};
use crate::number::{Comparison, Unary};
use naga::{Expression, Function, Handle, LocalVariable};

/// Largest finite f32.
const LARGEST: f64 = f32::MAX as f64;

impl<'m> Lower<'m> {
    /// Starts to note faults.
    pub(crate) fn begin(&mut self, watch: &'m Watch<'m>, words: &Words) {
        let named =
            |(name, file): (&String, &String)| Some((name.clone(), (watch.number)(file))).filter(|(_, n)| *n > 0);
        let functions = words.functions().filter_map(named).collect();
        let fault = [0; 4].map(|_| self.register(File::Float, Class::Variable));
        let zero = self.float(0.0);
        fault.iter().for_each(|reg| self.assign(*reg, zero));
        self.code.outputs.push((FAULTS, fault.to_vec()));
        self.watching = Some(Watching { watch, functions, fault });
    }

    /// The initial value of variables without one.
    pub(crate) fn fill(&self) -> f64 {
        self.watching.as_ref().map_or(0.0, |watching| watching.watch.fill)
    }

    /// Notes the values that a function gives.
    pub(crate) fn watch_call(
        &mut self,
        frame: &mut CallFrame<'m>,
        (function, arguments): (&Function, &[Handle<Expression>]),
        result: Option<&Value>,
    ) {
        let number = |watching: &Watching<'_>| watching.functions.get(function.name.as_ref()?).copied();
        let Some(number) = self.watching.as_ref().and_then(number) else { return };
        let mut given: Vec<Reg> = result.map(|value| value.regs.to_vec()).unwrap_or_default();
        // A copy of an argument that the caller reads again was passed to be written.
        for argument in arguments {
            let Expression::LocalVariable(local) = frame.function.expressions[*argument] else { continue };
            if let Some(Lowered::Variable(place)) =
                frame.lowered.get(argument).filter(|_| is_read(frame.function, local))
            {
                given.extend(place.choices[0].clone().iter().map(|reg| self.copy(*reg)));
            }
        }
        let (nan, infinite) = (self.float(Fault::Nan.component()), self.float(Fault::Infinite.component()));
        let largest = self.float(LARGEST);
        for reg in given.into_iter().filter(|reg| reg.file == File::Float) {
            let is_nan = self.emit(Op::IsNan, false, &[reg]);
            let size = self.emit(Op::Unary(Unary::Abs), false, &[reg]);
            let is_huge = self.emit(Op::Compare(Comparison::Less), false, &[largest, size]);
            let is_fault = self.emit(Op::Or, false, &[is_nan, is_huge]);
            let kind = self.emit(Op::Select, false, &[is_huge, infinite, nan]);
            self.note(is_fault, (number, kind, reg), false);
        }
    }

    /// Notes an index out of `0..count`.
    pub(crate) fn watch_index(&mut self, index: Reg, count: usize) {
        let Some(number) = self.number_here() else { return };
        let (zero, count) = (self.int(0, true), self.int(count as u32, true));
        let is_below = self.emit(Op::IntLess, true, &[index, zero]);
        let is_within = self.emit(Op::IntLess, true, &[index, count]);
        let is_above = self.emit(Op::Not, false, &[is_within]);
        let is_fault = self.emit(Op::Or, false, &[is_below, is_above]);
        let (kind, value) = (self.float(Fault::Index.component()), self.emit(Op::FromInt, true, &[index]));
        self.note(is_fault, (number, kind, value), true);
    }

    /// Notes a divisor of 0.
    pub(crate) fn watch_divisor(&mut self, divisor: Reg) {
        let Some(number) = self.number_here() else { return };
        let zero = self.int(0, true);
        let is_fault = self.emit(Op::IntEqual, true, &[divisor, zero]);
        let (kind, value) = (self.float(Fault::Divisor.component()), self.float(0.0));
        self.note(is_fault, (number, kind, value), true);
    }

    /// Number of the file of the current expression, if it is watched.
    fn number_here(&self) -> Option<u32> {
        let (file, _) = self.code.places[self.at.0 as usize].rsplit_once(':')?;
        Some((self.watching.as_ref()?.watch.number)(file)).filter(|number| *number > 0)
    }

    /// Notes a fault in the active lanes where a condition holds and none was noted before; one of undefined values also where
    /// a result was noted.
    fn note(&mut self, condition: Reg, (number, kind, value): (u32, Reg, Reg), is_undefined: bool) {
        let Some(fault) = self.watching.as_ref().map(|watching| watching.fault) else { return };
        let before = self.copy(fault[1]);
        let most = self.float(if is_undefined { Fault::Infinite.component() } else { 0.0 });
        let is_clear = self.emit(Op::Compare(Comparison::LessEqual), false, &[before, most]);
        let now = self.emit(Op::And, false, &[condition, is_clear]);
        let noted = [self.float(f64::from(number)), kind, self.float(f64::from(self.at.0)), value];
        for (reg, noted) in fault.into_iter().zip(noted) {
            let before = self.copy(reg);
            let chosen = self.emit(Op::Select, false, &[now, noted, before]);
            self.assign(reg, chosen);
        }
    }
}

/// Whether a function reads a variable.
fn is_read(function: &Function, local: Handle<LocalVariable>) -> bool {
    function.expressions.iter().any(|(_, expression)| match expression {
        Expression::Load { pointer } => function.expressions[*pointer] == Expression::LocalVariable(local),
        _ => false,
    })
}
