//! Blocks of lanes: registers, loops over them, and what is left of lanes that took several ways.

use super::case::Case;
use super::code::{File, Reg};
use super::number::{GROUP, Integer, Number, Packed, Truth};

/// Lanes of a block: one bit each of a mask. Those of a group are computed together as soon as one of them is active.
pub(super) const LANES: usize = 64;

/// One value for each lane.
pub(super) type Row<T> = [<T as Packed>::Group; LANES / GROUP];

/// The value of a lane.
#[inline(always)]
pub(super) fn get<T: Packed>(row: &Row<T>, lane: usize) -> T {
    T::get(&row[lane / GROUP], lane % GROUP)
}

/// Sets the value of a lane.
#[inline(always)]
pub(super) fn put<T: Packed>(row: &mut Row<T>, lane: usize, value: T) {
    value.put(&mut row[lane / GROUP], lane % GROUP);
}

/// What an instruction reads.
#[derive(Clone, Copy)]
pub(super) enum Operand<'a, T: Packed> {
    Lanes(&'a Row<T>),
    One(T),
}

impl<T: Packed> Operand<'_, T> {
    pub(super) fn at(&self, lane: usize) -> T {
        match self {
            Operand::Lanes(row) => get(row, lane),
            Operand::One(value) => *value,
        }
    }

    /// All lanes.
    pub(super) fn row(&self) -> Row<T> {
        match self {
            Operand::Lanes(row) => **row,
            Operand::One(value) => [value.splat(); LANES / GROUP],
        }
    }
}

/// Calls `on` with each lane of a mask.
#[inline(always)]
pub(super) fn each(mut mask: u64, mut on: impl FnMut(usize)) {
    while mask != 0 {
        on(mask.trailing_zeros() as usize);
        mask &= mask - 1;
    }
}

// Groups are copied before they are computed with: what may overlap in memory would be computed lane by lane.

/// Calls `on` with each group of lanes of which one is in the mask, and its number.
#[inline(always)]
fn groups<G>(out: &mut [G; LANES / GROUP], mask: u64, mut on: impl FnMut(usize, &mut G)) {
    if mask == u64::MAX {
        // Most often, and without a jump for each group.
        for (group, out) in out.iter_mut().enumerate() {
            on(group, out);
        }
    } else {
        for (group, out) in out.iter_mut().enumerate() {
            if (mask >> (GROUP * group)) & 0xff != 0 {
                on(group, out);
            }
        }
    }
}

#[inline(always)]
pub(super) fn map1<A: Packed, D: Packed>(out: &mut Row<D>, mask: u64, a: Operand<'_, A>, f: impl Fn(A) -> D) {
    match a {
        Operand::Lanes(a) => groups(
            out,
            mask,
            #[inline(always)]
            |group, out| {
                let (a, mut values) = (a[group], *out);
                for place in 0..GROUP {
                    f(A::get(&a, place)).put(&mut values, place);
                }
                *out = values;
            },
        ),
        Operand::One(a) => out.fill(f(a).splat()),
    }
}

#[inline(always)]
pub(super) fn map2<A: Packed, B: Packed, D: Packed>(
    out: &mut Row<D>,
    mask: u64,
    (a, b): (Operand<'_, A>, Operand<'_, B>),
    f: impl Fn(A, B) -> D,
) {
    match (a, b) {
        (Operand::Lanes(a), Operand::Lanes(b)) => groups(
            out,
            mask,
            #[inline(always)]
            |group, out| {
                let (a, b, mut values) = (a[group], b[group], *out);
                for place in 0..GROUP {
                    f(A::get(&a, place), B::get(&b, place)).put(&mut values, place);
                }
                *out = values;
            },
        ),
        (a, Operand::One(b)) => map1(
            out,
            mask,
            a,
            #[inline(always)]
            |a| f(a, b),
        ),
        (Operand::One(a), b) => map1(
            out,
            mask,
            b,
            #[inline(always)]
            |b| f(a, b),
        ),
    }
}

#[inline(always)]
pub(super) fn map3<A: Packed, B: Packed, C: Packed, D: Packed>(
    out: &mut Row<D>,
    mask: u64,
    (a, b, c): (Operand<'_, A>, Operand<'_, B>, Operand<'_, C>),
    f: impl Fn(A, B, C) -> D,
) {
    match (a, b, c) {
        (Operand::Lanes(a), Operand::Lanes(b), Operand::Lanes(c)) => groups(
            out,
            mask,
            #[inline(always)]
            |group, out| {
                let (a, b, c, mut values) = (a[group], b[group], c[group], *out);
                for place in 0..GROUP {
                    f(A::get(&a, place), B::get(&b, place), C::get(&c, place)).put(&mut values, place);
                }
                *out = values;
            },
        ),
        (a, b, Operand::One(c)) => map2(
            out,
            mask,
            (a, b),
            #[inline(always)]
            |a, b| f(a, b, c),
        ),
        (a, Operand::One(b), c) => map2(
            out,
            mask,
            (a, c),
            #[inline(always)]
            |a, c| f(a, b, c),
        ),
        (Operand::One(a), b, c) => map2(
            out,
            mask,
            (b, c),
            #[inline(always)]
            |b, c| f(a, b, c),
        ),
    }
}

/// The same for what is too long to be worth doing in lanes that are not active.
pub(super) fn slow<A: Copy, D: Packed, O: Lane<A>>(out: &mut Row<D>, mask: u64, a: O, f: impl Fn(A) -> D) {
    each(mask, |lane| put(out, lane, f(a.lane(lane))));
}

/// What has a value for each lane.
pub(super) trait Lane<T> {
    fn lane(&self, lane: usize) -> T;
}

impl<T: Packed> Lane<T> for Operand<'_, T> {
    fn lane(&self, lane: usize) -> T {
        self.at(lane)
    }
}

impl<'a, 'b, A: Packed, B: Packed> Lane<(A, B)> for (Operand<'a, A>, Operand<'b, B>) {
    fn lane(&self, lane: usize) -> (A, B) {
        (self.0.at(lane), self.1.at(lane))
    }
}

/// The registers of one file: with a value for each lane, and with one for all.
pub(super) struct Rows<T: Packed> {
    rows: Vec<Box<Row<T>>>,
    ones: Vec<T>,
}

/// The registers of one file, and where results are computed before they change places with a register.
pub(super) struct Bank<T: Packed> {
    pub(super) rows: Rows<T>,
    pub(super) spare: Box<Row<T>>,
}

impl<T: Packed> Rows<T> {
    #[inline(always)]
    pub(super) fn read(&self, reg: Reg) -> Operand<'_, T> {
        // While uniform registers are computed, they have rows.
        match reg.uniform && !self.ones.is_empty() {
            true => Operand::One(self.ones[reg.index as usize]),
            false => Operand::Lanes(&self.rows[reg.index as usize]),
        }
    }
}

impl<T: Packed> Bank<T> {
    pub(super) fn new(registers: u32, ones: Vec<T>, zero: T) -> Bank<T> {
        let row = || Box::new([zero.splat(); LANES / GROUP]);
        Bank { rows: Rows { rows: (0..registers).map(|_| row()).collect(), ones }, spare: row() }
    }

    pub(super) fn row(&mut self, reg: Reg) -> &mut Row<T> {
        &mut self.rows.rows[reg.index as usize]
    }

    /// Puts the result in its place: for the lanes of a mask, or for all where others do not matter.
    #[inline(always)]
    pub(super) fn settle(&mut self, dst: Reg, mask: u64, all: bool) {
        let row = &mut self.rows.rows[dst.index as usize];
        if all {
            std::mem::swap(row, &mut self.spare);
        } else {
            let from = &self.spare;
            groups(
                row,
                mask,
                #[inline(always)]
                |group, out| match (mask >> (GROUP * group)) & 0xff {
                    0xff => *out = from[group],
                    bits => each(bits, |place| T::get(&from[group], place).put(out, place)),
                },
            );
        }
    }
}

/// What registers held in some lanes: of lanes that left a part of the program, or will enter another part of it.
pub(super) struct State<N: Number> {
    pub(super) lanes: u64,
    floats: Vec<Row<N>>,
    ints: Vec<Row<N::Int>>,
    truths: Vec<Row<N::Truth>>,
}

/// The three files of registers.
pub(super) struct Banks<N: Number> {
    pub(super) floats: Bank<N>,
    pub(super) ints: Bank<N::Int>,
    pub(super) truths: Bank<N::Truth>,
    /// One for each lane, or none where cases are not told apart.
    pub(super) cases: Vec<Case>,
}

/// How values of all three files are made one, and compared.
struct Joins<T> {
    join: fn(T, T) -> T,
    within: fn(T, T) -> bool,
}

fn of_file(written: &[Reg], file: File) -> impl Iterator<Item = usize> + '_ {
    written.iter().filter(move |reg| reg.file == file).map(|reg| reg.index as usize)
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
            rows.push(**now);
        }
        let row = &mut rows[slot];
        each(lanes & before, |lane| put(row, lane, (joins.join)(get(row, lane), get(now, lane))));
        each(lanes & !before, |lane| put(row, lane, get::<T>(now, lane)));
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
        let now = &mut bank.rows.rows[index];
        each(lanes & here, |lane| put(now, lane, (joins.join)(get(now, lane), get(row, lane))));
        each(lanes & !here, |lane| put(now, lane, get::<T>(row, lane)));
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

impl<N: Number> Banks<N> {
    /// Nothing is known about these registers.
    pub(super) fn forget(&mut self, written: &[Reg], lanes: u64) {
        for reg in written {
            each(lanes, |lane| match reg.file {
                File::Float => put(self.floats.row(*reg), lane, N::whole()),
                File::Int => put(self.ints.row(*reg), lane, N::Int::whole()),
                File::Truth => put(self.truths.row(*reg), lane, N::Truth::whole()),
            });
        }
    }
}
