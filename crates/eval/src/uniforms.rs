//! Values of uniform registers, computed once for each program and number type.

use crate::bind::{BoundProgram, Constant};
use crate::code::{Code, File, Node, Reg};
use crate::number::{Bool, Integer, Number, Packed};
use crate::run::control_flow::Machine;
use crate::run::lanes::get;
use crate::run::single::Singles;
use std::any::TypeId;
use std::sync::{Arc, PoisonError};

/// Values of the uniform registers by file.
type Uniforms<N> = (Vec<N>, Vec<<N as Number>::Int>, Vec<<N as Number>::Bool>);

impl BoundProgram<'_> {
    /// The cached values of the uniform registers, which would dominate calls with few points.
    pub(crate) fn uniforms<N: Number>(&self) -> Uniforms<N> {
        let mut known = self.uniforms.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = known.entry(TypeId::of::<N>()).or_insert_with(|| Arc::new(self.computed_uniforms::<N>(None).0));
        known.downcast_ref::<Uniforms<N>>().cloned().unwrap_or_else(|| self.computed_uniforms(None).0)
    }

    /// Computes the uniform registers, rounded to f32 if `singles` is given.
    pub(crate) fn computed_uniforms<N: Number>(&self, singles: Option<Singles>) -> (Uniforms<N>, Option<Singles>) {
        let prelude = Code {
            instrs: self.code.prelude.clone(),
            body: vec![Node::Run(0, self.code.prelude.len())],
            tables: self.code.tables.clone(),
            registers: self.code.uniforms,
            ..Code::default()
        };
        let mut machine = Machine::<N>::new(&prelude, &[], (Vec::new(), Vec::new(), Vec::new()));
        machine.singles = singles;
        for ((reg, _), value) in self.code.sources.iter().zip(&self.values) {
            match *value {
                Constant::Float(x) => machine.banks.floats.row(*reg).fill(N::new(x).splat()),
                Constant::Between(a, b) => machine.banks.floats.row(*reg).fill(N::new(a).join(N::new(b)).splat()),
                Constant::Int(bits, signed) => machine.banks.ints.row(*reg).fill(N::Int::new(bits, signed).splat()),
                Constant::Bool(value) => machine.banks.bools.row(*reg).fill(N::Bool::new(value).splat()),
            }
        }
        // A basic block cannot fail.
        drop(machine.run(1));
        let row = |file, index| Reg { file, uniform: true, index };
        let counts = self.code.uniforms;
        let uniforms = (
            (0..counts[0]).map(|index| get(machine.banks.floats.row(row(File::Float, index)), 0)).collect(),
            (0..counts[1]).map(|index| get(machine.banks.ints.row(row(File::Int, index)), 0)).collect(),
            (0..counts[2]).map(|index| get(machine.banks.bools.row(row(File::Bool, index)), 0)).collect(),
        );
        (uniforms, machine.singles)
    }
}
