//! What is left of lanes that took several ways: what their registers hold, made one where the ways meet.

use super::code::{File, Reg};
use super::lanes::{Bank, Banks, Row, each, get, put};
use super::number::{GROUP, Integer, Number, Packed, Truth};

/// What registers held in some lanes: of lanes that left a part of the program, or will enter another part of it.
pub(super) struct State<N: Number> {
    pub(super) lanes: u64,
    floats: Vec<Row<N>>,
    ints: Vec<Row<N::Int>>,
    truths: Vec<Row<N::Truth>>,
}

/// How values of all three files are made one, and compared.
struct Joins<T> {
    join: fn(T, T) -> T,
    within: fn(T, T) -> bool,
}

fn of_file(written: &[Reg], file: File) -> impl Iterator<Item = usize> + '_ {
    written.iter().filter(move |reg| reg.file == file).map(|reg| reg.index as usize)
}

/// Puts lanes of one row into another, in which some lanes are `here` already: there it is either.
fn merge<T: Packed>(into: &mut Row<T>, from: &Row<T>, (lanes, here): (u64, u64), joins: &Joins<T>) {
    let new = lanes & !here;
    for (group, (into, from)) in into.iter_mut().zip(from).enumerate() {
        match (new >> (GROUP * group)) & 0xff {
            0xff => *into = *from,
            bits => each(bits, |place| T::get(from, place).put(into, place)),
        }
    }
    each(lanes & here, |lane| put(into, lane, (joins.join)(get(into, lane), get(from, lane))));
}

/// Adds lanes to rows that hold those of `before`.
fn add<T: Packed>(
    rows: &mut Vec<Row<T>>,
    bank: &Bank<T>,
    of: impl Iterator<Item = usize>,
    (before, lanes): (u64, u64),
    joins: &Joins<T>,
) {
    for (slot, index) in of.enumerate() {
        let now = &bank.rows.rows[index];
        if slot == rows.len() {
            rows.push(now.0); // no lane has been before
            continue;
        }
        merge(&mut rows[slot], now, (lanes, before), joins);
    }
}

/// Brings lanes back: those of `here` have come another way as well.
fn take<T: Packed>(
    rows: &[Row<T>],
    bank: &mut Bank<T>,
    of: impl Iterator<Item = usize>,
    (lanes, here): (u64, u64),
    joins: &Joins<T>,
) {
    for (row, index) in rows.iter().zip(of) {
        merge(&mut bank.rows.rows[index], row, (lanes, here), joins);
    }
}

/// The lanes in which nothing is new.
fn old<T: Packed>(
    rows: &[Row<T>],
    bank: &Bank<T>,
    of: impl Iterator<Item = usize>,
    mut lanes: u64,
    joins: &Joins<T>,
) -> u64 {
    for (row, index) in rows.iter().zip(of) {
        let now = &bank.rows.rows[index];
        each(lanes, |lane| lanes &= !(u64::from(!(joins.within)(get(now, lane), get(row, lane))) << lane));
        if lanes == 0 {
            break;
        }
    }
    lanes
}

fn floats<N: Number>() -> Joins<N> {
    Joins { join: N::join, within: N::within }
}

fn ints<N: Number>() -> Joins<N::Int> {
    Joins { join: N::Int::join, within: N::Int::within }
}

fn truths<N: Number>() -> Joins<N::Truth> {
    Joins { join: N::Truth::join, within: N::Truth::within }
}

impl<N: Number> State<N> {
    pub(super) fn new() -> State<N> {
        State { lanes: 0, floats: Vec::new(), ints: Vec::new(), truths: Vec::new() }
    }

    /// Lanes come: where there are some already, either may have been.
    pub(super) fn add(&mut self, banks: &Banks<N>, written: &[Reg], lanes: u64) {
        let which = (self.lanes, lanes);
        add(&mut self.floats, &banks.floats, of_file(written, File::Float), which, &floats::<N>());
        add(&mut self.ints, &banks.ints, of_file(written, File::Int), which, &ints::<N>());
        add(&mut self.truths, &banks.truths, of_file(written, File::Truth), which, &truths::<N>());
        self.lanes |= lanes;
    }

    /// Some of the lanes go back to the registers, in addition to those that are `here` already.
    pub(super) fn take(&self, banks: &mut Banks<N>, written: &[Reg], lanes: u64, here: u64) {
        let which = (self.lanes & lanes, here);
        take(&self.floats, &mut banks.floats, of_file(written, File::Float), which, &floats::<N>());
        take(&self.ints, &mut banks.ints, of_file(written, File::Int), which, &ints::<N>());
        take(&self.truths, &mut banks.truths, of_file(written, File::Truth), which, &truths::<N>());
    }

    /// The lanes in which the registers hold nothing that they did not hold then.
    pub(super) fn covers(&self, banks: &Banks<N>, written: &[Reg], lanes: u64) -> u64 {
        let lanes = old(&self.floats, &banks.floats, of_file(written, File::Float), lanes & self.lanes, &floats::<N>());
        let lanes = old(&self.ints, &banks.ints, of_file(written, File::Int), lanes, &ints::<N>());
        old(&self.truths, &banks.truths, of_file(written, File::Truth), lanes, &truths::<N>())
    }
}
