//! What is the same for all lanes: computed once for a program with its inputs, in each kind of numbers.

use super::code::{Code, File, Node, Reg};
use super::number::{Integer, Number, Packed, Truth};
use super::run::Machine;
use super::single::Singles;
use super::{BoundProgram, Start, lanes};
use std::any::{Any, TypeId};
use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError};

/// What uniform registers hold, by the kind of numbers.
#[derive(Debug, Default)]
pub(super) struct Known(Mutex<HashMap<TypeId, Arc<dyn Any + Send + Sync>>>);

/// What uniform registers hold.
type Uniforms<N> = (Vec<N>, Vec<<N as Number>::Int>, Vec<<N as Number>::Truth>);

impl BoundProgram<'_> {
    /// What uniform registers hold: of many calls with a few lanes each, they would be most of the work.
    pub(super) fn uniforms<N: Number>(&self) -> Uniforms<N> {
        let mut known = self.known.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = known.entry(TypeId::of::<N>()).or_insert_with(|| Arc::new(self.computed_uniforms::<N>(None).0));
        known.downcast_ref::<Uniforms<N>>().cloned().unwrap_or_else(|| self.computed_uniforms(None).0)
    }

    /// The same, computed; where results are rounded to f32, with what is beyond it in the first lane.
    pub(super) fn computed_uniforms<N: Number>(&self, singles: Option<Singles>) -> (Uniforms<N>, Option<Singles>) {
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
                Start::Float(x) => machine.banks.floats.row(*reg).fill(N::new(x).splat()),
                Start::Between(a, b) => machine.banks.floats.row(*reg).fill(N::new(a).join(N::new(b)).splat()),
                Start::Int(bits, signed) => machine.banks.ints.row(*reg).fill(N::Int::new(bits, signed).splat()),
                Start::Truth(truth) => machine.banks.truths.row(*reg).fill(N::Truth::new(truth).splat()),
            }
        }
        // Straight code does not fail.
        drop(machine.run(1));
        let row = |file, index| Reg { file, uniform: true, index };
        let counts = self.code.uniforms;
        let uniforms = (
            (0..counts[0]).map(|index| lanes::get(machine.banks.floats.row(row(File::Float, index)), 0)).collect(),
            (0..counts[1]).map(|index| lanes::get(machine.banks.ints.row(row(File::Int, index)), 0)).collect(),
            (0..counts[2]).map(|index| lanes::get(machine.banks.truths.row(row(File::Truth, index)), 0)).collect(),
        );
        (uniforms, machine.singles)
    }
}
