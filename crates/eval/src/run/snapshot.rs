//! Register snapshots of diverged lanes, joined where control flow meets.

use super::lanes::{Bank, Banks, Row, each, get, put};
use crate::code::{File, Reg};
use crate::number::{Domain, GROUP, Number};

/// Registers of some lanes, taken where they left a part of the program or before they enter another one.
pub(crate) struct Snapshot<N: Number> {
    lanes: u64,
    floats: Vec<Row<N>>,
    ints: Vec<Row<N::Int>>,
    bools: Vec<Row<N::Bool>>,
}

fn of_file(written: &[Reg], file: File) -> impl Iterator<Item = usize> + '_ {
    written.iter().filter(move |reg| reg.file == file).map(|reg| reg.index as usize)
}

/// Copies lanes of a row into another; those of `present` are joined.
fn merge<T: Domain>(into: &mut Row<T>, from: &Row<T>, (lanes, present): (u64, u64)) {
    let new = lanes & !present;
    for (group, (into, from)) in into.iter_mut().zip(from).enumerate() {
        match (new >> (GROUP * group)) & 0xff {
            0xff => *into = *from,
            bits => each(bits, |place| T::get(from, place).put(into, place)),
        }
    }
    each(lanes & present, |lane| put(into, lane, get::<T>(into, lane).join(get(from, lane))));
}

/// Merges lanes of a bank into rows that have those of `present`.
fn add<T: Domain>(
    rows: &mut Vec<Row<T>>,
    bank: &Bank<T>,
    registers: impl Iterator<Item = usize>,
    (lanes, present): (u64, u64),
) {
    for (slot, index) in registers.enumerate() {
        let now = &bank.rows.rows[index];
        match rows.get_mut(slot) {
            Some(row) => merge::<T>(row, now, (lanes, present)),
            None => rows.push(now.0),
        }
    }
}

/// Merges lanes of rows into a bank that has those of `present`.
fn restore<T: Domain>(
    rows: &[Row<T>],
    bank: &mut Bank<T>,
    registers: impl Iterator<Item = usize>,
    (lanes, present): (u64, u64),
) {
    for (row, index) in rows.iter().zip(registers) {
        merge::<T>(&mut bank.rows.rows[index], row, (lanes, present));
    }
}

/// The lanes whose values are all within those of the rows.
fn covered<T: Domain>(rows: &[Row<T>], bank: &Bank<T>, registers: impl Iterator<Item = usize>, mut lanes: u64) -> u64 {
    for (row, index) in rows.iter().zip(registers) {
        let now = &bank.rows.rows[index];
        each(lanes, |lane| lanes &= !(u64::from(!get::<T>(now, lane).is_within(get(row, lane))) << lane));
        if lanes == 0 {
            break;
        }
    }
    lanes
}

impl<N: Number> Snapshot<N> {
    pub(crate) fn new() -> Snapshot<N> {
        Snapshot { lanes: 0, floats: Vec::new(), ints: Vec::new(), bools: Vec::new() }
    }

    /// Adds lanes, joining those that are there already.
    pub(crate) fn add(&mut self, banks: &Banks<N>, written: &[Reg], lanes: u64) {
        let which = (lanes, self.lanes);
        add(&mut self.floats, &banks.floats, of_file(written, File::Float), which);
        add(&mut self.ints, &banks.ints, of_file(written, File::Int), which);
        add(&mut self.bools, &banks.bools, of_file(written, File::Bool), which);
        self.lanes |= lanes;
    }

    /// Restores lanes of the registers, joining those of `present`.
    pub(crate) fn restore(&self, banks: &mut Banks<N>, written: &[Reg], lanes: u64, present: u64) {
        let which = (self.lanes & lanes, present);
        restore(&self.floats, &mut banks.floats, of_file(written, File::Float), which);
        restore(&self.ints, &mut banks.ints, of_file(written, File::Int), which);
        restore(&self.bools, &mut banks.bools, of_file(written, File::Bool), which);
    }

    /// The lanes whose registers are all within the snapshot.
    pub(crate) fn covers(&self, banks: &Banks<N>, written: &[Reg], lanes: u64) -> u64 {
        let lanes = covered(&self.floats, &banks.floats, of_file(written, File::Float), lanes & self.lanes);
        let lanes = covered(&self.ints, &banks.ints, of_file(written, File::Int), lanes);
        covered(&self.bools, &banks.bools, of_file(written, File::Bool), lanes)
    }
}
