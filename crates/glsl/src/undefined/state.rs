//! State of variables at a place of a function: the parts without a value, and scalars.

use super::scalar::Scalar;
use std::collections::BTreeMap;

/// Why a scalar may have no value: [`DEFINED`], [`UNWRITTEN`], or the number of an origin.
pub(super) type Code = u32;
/// It has a value on every path.
pub(super) const DEFINED: Code = 0;
/// Nothing was stored in it on some path.
pub(super) const UNWRITTEN: Code = 1;
/// Number of the first origin.
pub(super) const FIRST_ORIGIN: Code = 2;

/// Codes of the scalars of a value. Empty if all are [`DEFINED`].
pub(super) type Codes = Vec<Code>;

/// The code of a scalar where two paths meet.
pub(super) fn joined(a: Code, b: Code) -> Code {
    match (a, b) {
        (DEFINED, other) | (other, DEFINED) => other,
        (a, b) => a.min(b),
    }
}

/// Joins codes into others; returns whether these changed.
pub(super) fn join(into: &mut Codes, from: &[Code]) -> bool {
    if into.is_empty() && from.iter().any(|code| *code != DEFINED) {
        into.resize(from.len(), DEFINED);
    }
    let mut changed = false;
    for (into, from) in into.iter_mut().zip(from) {
        let code = joined(*into, *from);
        changed |= code != *into;
        *into = code;
    }
    changed
}

/// Codes without a list of [`DEFINED`] alone.
pub(super) fn tidy(codes: Codes) -> Codes {
    if codes.iter().all(|code| *code == DEFINED) { Vec::new() } else { codes }
}

/// Variables, at a place of a function.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct State {
    /// Codes by variable.
    pub(super) variables: BTreeMap<u32, Codes>,
    /// Values of variables of one scalar, where they are known.
    pub(super) scalars: BTreeMap<u32, Scalar>,
}

impl State {
    /// Joins the state of another path; returns whether this one changed.
    pub(super) fn join(&mut self, other: &State) -> bool {
        let mut changed = false;
        for (variable, codes) in &other.variables {
            match self.variables.get_mut(variable) {
                Some(own) => changed |= join(own, codes),
                None => drop(self.variables.insert(*variable, codes.clone())),
            }
        }
        let before = self.scalars.len();
        self.scalars.retain(|variable, value| other.scalars.get(variable) == Some(value));
        changed || self.scalars.len() != before
    }
}

/// A part of a variable.
#[derive(Clone, Debug)]
pub(super) struct Pointer {
    pub(super) variable: u32,
    /// First scalar of the part; several where an index is not known.
    pub(super) starts: Vec<usize>,
    /// The same where only the indices are known that are constants.
    pub(super) stored: Vec<usize>,
    /// Type of the part.
    pub(super) kind: u32,
}
