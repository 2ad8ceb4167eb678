//! Faults that a watched program notes.

use crate::code::Reg;
use std::collections::HashMap;

/// Location of the output with the first fault of each point; all 0 where there is none. Its components are the number of
/// the file, the [`Fault`], the number of the place, and the index or divisor.
pub const FAULTS: u32 = u32::MAX;

/// Kinds of faults.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// A function gives NaN, in its result or in a parameter that it writes.
    Nan = 1,
    /// A function gives an infinity of f32.
    Infinite = 2,
    /// An index is out of range.
    Index = 3,
    /// An integer is divided by 0.
    Divisor = 4,
}

impl Fault {
    const ALL: [Fault; 4] = [Fault::Nan, Fault::Infinite, Fault::Index, Fault::Divisor];

    /// The fault of a component of [`FAULTS`].
    pub fn of(component: f64) -> Option<Fault> {
        Fault::ALL.into_iter().find(|fault| fault.component() == component)
    }

    /// Its component of [`FAULTS`].
    pub(super) fn component(self) -> f64 {
        f64::from(self as u8)
    }
}

/// Files whose faults are noted.
pub struct Watch<'w> {
    /// Number of a file, from 1; 0 for files that are not watched.
    pub number: &'w dyn Fn(&str) -> u32,
    /// Initial value of variables that the program does not initialize.
    pub fill: f64,
}

/// The state of a [`Watch`] during lowering.
pub(crate) struct Watching<'w> {
    pub watch: &'w Watch<'w>,
    /// Numbers of the watched functions, by name.
    pub functions: HashMap<String, u32>,
    /// Variables of the output.
    pub fault: [Reg; 4],
}
