//! Blocks of lanes: registers, and loops over them.

use super::case::Case;
use super::code::{File, Reg};
use super::number::{GROUP, Integer, Number, Packed, Truth};
use std::ops::{Deref, DerefMut};

/// Lanes of a block: one bit each of a mask. Those of a group are computed together as soon as one of them is active.
pub(super) const LANES: usize = 64;

/// One value for each lane.
pub(super) type Row<T> = [<T as Packed>::Group; LANES / GROUP];

/// A row that begins where a line of the cache does: its vectors are in one line each.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(super) struct Placed<T: Packed>(pub(super) Row<T>);

impl<T: Packed> Deref for Placed<T> {
    type Target = Row<T>;

    #[inline(always)]
    fn deref(&self) -> &Row<T> {
        &self.0
    }
}

impl<T: Packed> DerefMut for Placed<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut Row<T> {
        &mut self.0
    }
}

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

    #[inline(always)]
    fn group(&self, group: usize) -> T::Group {
        match self {
            Operand::Lanes(row) => row[group],
            Operand::One(value) => value.splat(),
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

/// One of two by a truth that is known in most lanes: where it is in all of a group, nothing has to be joined.
#[inline(always)]
pub(super) fn choose<N: Number>(
    out: &mut Row<N>,
    mask: u64,
    truth: Operand<'_, N::Truth>,
    (a, b): (Operand<'_, N>, Operand<'_, N>),
) {
    groups(
        out,
        mask,
        #[inline(always)]
        |group, out| {
            let (truth, a, b, mut values) = (truth.group(group), a.group(group), b.group(group), *out);
            let known = |place| {
                let truth = <N::Truth as Packed>::get(&truth, place);
                !(truth.may_hold() & truth.may_fail())
            };
            if (0..GROUP).fold(true, |all, place| all & known(place)) {
                for place in 0..GROUP {
                    let truth = <N::Truth as Packed>::get(&truth, place);
                    N::one_of(truth, N::get(&a, place), N::get(&b, place)).put(&mut values, place);
                }
            } else {
                for place in 0..GROUP {
                    let truth = <N::Truth as Packed>::get(&truth, place);
                    N::select(truth, N::get(&a, place), N::get(&b, place)).put(&mut values, place);
                }
            }
            *out = values;
        },
    );
}

/// A loop over lanes for what is too long to be worth doing in lanes that are not active.
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
    pub(super) rows: Vec<Box<Placed<T>>>,
    ones: Vec<T>,
}

/// The registers of one file, and where results are computed before they change places with a register.
pub(super) struct Bank<T: Packed> {
    pub(super) rows: Rows<T>,
    pub(super) spare: Box<Placed<T>>,
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
        let row = || Box::new(Placed([zero.splat(); LANES / GROUP]));
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

/// The three files of registers.
pub(super) struct Banks<N: Number> {
    pub(super) floats: Bank<N>,
    pub(super) ints: Bank<N::Int>,
    pub(super) truths: Bank<N::Truth>,
    /// One for each lane, or none where cases are not told apart.
    pub(super) cases: Vec<Case>,
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
