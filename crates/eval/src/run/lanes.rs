//! Registers for blocks of lanes, and loops over them.

use crate::code::{File, Reg};
use crate::integer_splits::IntegerSplits;
use crate::number::{Bool, Domain, GROUP, Number, Packed};
use std::ops::{Deref, DerefMut};

/// Lanes of a block, one for each bit of a mask. A group is computed whole if one of its lanes is active.
pub(crate) const LANES: usize = 64;

/// One value for each lane.
pub(crate) type Row<T> = [<T as Packed>::Group; LANES / GROUP];

/// A row aligned to cache lines, so that no vector crosses two.
#[derive(Clone, Copy)]
#[repr(align(64))]
pub(crate) struct Aligned<T: Packed>(pub Row<T>);

impl<T: Packed> Deref for Aligned<T> {
    type Target = Row<T>;

    #[inline(always)]
    fn deref(&self) -> &Row<T> {
        &self.0
    }
}

impl<T: Packed> DerefMut for Aligned<T> {
    #[inline(always)]
    fn deref_mut(&mut self) -> &mut Row<T> {
        &mut self.0
    }
}

/// Reads a lane.
#[inline(always)]
pub(crate) fn get<T: Packed>(row: &Row<T>, lane: usize) -> T {
    T::get(&row[lane / GROUP], lane % GROUP)
}

/// Writes a lane.
#[inline(always)]
pub(crate) fn put<T: Packed>(row: &mut Row<T>, lane: usize, value: T) {
    value.put(&mut row[lane / GROUP], lane % GROUP);
}

/// An operand of an instruction.
#[derive(Clone, Copy)]
pub(crate) enum Operand<'a, T: Packed> {
    Lanes(&'a Row<T>),
    Uniform(T),
}

impl<T: Packed> Operand<'_, T> {
    pub(crate) fn at(&self, lane: usize) -> T {
        match self {
            Operand::Lanes(row) => get(row, lane),
            Operand::Uniform(value) => *value,
        }
    }

    #[inline(always)]
    fn group(&self, group: usize) -> T::Group {
        match self {
            Operand::Lanes(row) => row[group],
            Operand::Uniform(value) => value.splat(),
        }
    }

    /// A copy of all lanes.
    pub(crate) fn row(&self) -> Row<T> {
        match self {
            Operand::Lanes(row) => **row,
            Operand::Uniform(value) => [value.splat(); LANES / GROUP],
        }
    }
}

/// Calls `on` with each lane of a mask.
#[inline(always)]
pub(crate) fn each(mut mask: u64, mut on: impl FnMut(usize)) {
    while mask != 0 {
        on(mask.trailing_zeros() as usize);
        mask &= mask - 1;
    }
}

// Groups are copied before they are computed with: memory that may overlap would prevent vectorization.

/// Calls `on` with the index of each group that has a lane in the mask.
#[inline(always)]
fn groups<G>(out: &mut [G; LANES / GROUP], mask: u64, mut on: impl FnMut(usize, &mut G)) {
    if mask == u64::MAX {
        // The common case, without a branch for each group.
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

/// Loop over lanes with its function inlined, so that it is compiled for the vectors of this processor.
macro_rules! inlined {
    ($map:ident($($argument:expr),*), $function:expr) => {
        $map(
            $($argument,)*
            #[inline(always)]
            $function,
        )
    };
}
pub(crate) use inlined;

// One loop for all operands: a loop for each combination of rows and uniforms is no faster, and takes minutes to compile.

#[inline(always)]
pub(crate) fn map1<A: Packed, D: Packed>(out: &mut Row<D>, mask: u64, a: Operand<'_, A>, f: impl Fn(A) -> D) {
    inlined!(groups(out, mask), |group, out| {
        let (a, mut values) = (a.group(group), *out);
        for place in 0..GROUP {
            f(A::get(&a, place)).put(&mut values, place);
        }
        *out = values;
    });
}

#[inline(always)]
pub(crate) fn map2<A: Packed, B: Packed, D: Packed>(
    out: &mut Row<D>,
    mask: u64,
    (a, b): (Operand<'_, A>, Operand<'_, B>),
    f: impl Fn(A, B) -> D,
) {
    inlined!(groups(out, mask), |group, out| {
        let (a, b, mut values) = (a.group(group), b.group(group), *out);
        for place in 0..GROUP {
            f(A::get(&a, place), B::get(&b, place)).put(&mut values, place);
        }
        *out = values;
    });
}

#[inline(always)]
pub(crate) fn map3<A: Packed, B: Packed, C: Packed, D: Packed>(
    out: &mut Row<D>,
    mask: u64,
    (a, b, c): (Operand<'_, A>, Operand<'_, B>, Operand<'_, C>),
    f: impl Fn(A, B, C) -> D,
) {
    inlined!(groups(out, mask), |group, out| {
        let (a, b, c, mut values) = (a.group(group), b.group(group), c.group(group), *out);
        for place in 0..GROUP {
            f(A::get(&a, place), B::get(&b, place), C::get(&c, place)).put(&mut values, place);
        }
        *out = values;
    });
}

/// Selects by a condition that is decided in most lanes, without joins in groups where all lanes are.
#[inline(always)]
pub(crate) fn select_rows<N: Number>(
    out: &mut Row<N>,
    mask: u64,
    condition: Operand<'_, N::Bool>,
    (a, b): (Operand<'_, N>, Operand<'_, N>),
) {
    inlined!(groups(out, mask), |group, out| {
        let (condition, a, b, mut values) = (condition.group(group), a.group(group), b.group(group), *out);
        let decided = |place| {
            let condition = <N::Bool as Packed>::get(&condition, place);
            !(condition.may_hold() & condition.may_fail())
        };
        if (0..GROUP).fold(true, |all, place| all & decided(place)) {
            for place in 0..GROUP {
                let condition = <N::Bool as Packed>::get(&condition, place);
                N::select_decided(condition, N::get(&a, place), N::get(&b, place)).put(&mut values, place);
            }
        } else {
            for place in 0..GROUP {
                let condition = <N::Bool as Packed>::get(&condition, place);
                N::select(condition, N::get(&a, place), N::get(&b, place)).put(&mut values, place);
            }
        }
        *out = values;
    });
}

/// Loop over the active lanes, for functions too slow to run in others.
pub(crate) fn slow<A: Copy, D: Packed, O: Lane<A>>(out: &mut Row<D>, mask: u64, a: O, f: impl Fn(A) -> D) {
    each(mask, |lane| put(out, lane, f(a.lane(lane))));
}

/// A source of a value for each lane.
pub(crate) trait Lane<T> {
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

/// The registers of one file: those with a value for each lane, and uniform ones.
pub(crate) struct Rows<T: Packed> {
    pub rows: Vec<Box<Aligned<T>>>,
    uniforms: Vec<T>,
}

/// The registers of one file, and a spare row in which results are computed.
pub(crate) struct Bank<T: Packed> {
    pub rows: Rows<T>,
    pub spare: Box<Aligned<T>>,
}

impl<T: Packed> Rows<T> {
    #[inline(always)]
    pub(crate) fn read(&self, reg: Reg) -> Operand<'_, T> {
        // The prelude computes uniform registers in rows.
        if reg.uniform && !self.uniforms.is_empty() {
            Operand::Uniform(self.uniforms[reg.index as usize])
        } else {
            Operand::Lanes(&self.rows[reg.index as usize])
        }
    }
}

impl<T: Packed> Bank<T> {
    pub(crate) fn new(registers: u32, uniforms: Vec<T>, zero: T) -> Bank<T> {
        let row = || Box::new(Aligned([zero.splat(); LANES / GROUP]));
        Bank { rows: Rows { rows: (0..registers).map(|_| row()).collect(), uniforms }, spare: row() }
    }

    pub(crate) fn row(&mut self, reg: Reg) -> &mut Row<T> {
        &mut self.rows.rows[reg.index as usize]
    }

    /// Moves the result to its register, for the lanes of a mask or for all.
    #[inline(always)]
    pub(crate) fn store_result(&mut self, dst: Reg, mask: u64, all: bool) {
        let row = &mut self.rows.rows[dst.index as usize];
        if all {
            std::mem::swap(row, &mut self.spare);
        } else {
            let from = &self.spare;
            inlined!(groups(row, mask), |group, out| match (mask >> (GROUP * group)) & 0xff {
                0xff => *out = from[group],
                bits => each(bits, |place| T::get(&from[group], place).put(out, place)),
            });
        }
    }
}

/// The register files.
pub(crate) struct Banks<N: Number> {
    pub floats: Bank<N>,
    pub ints: Bank<N::Int>,
    pub bools: Bank<N::Bool>,
    /// One for each lane, or empty if segments are not split.
    pub splits: Vec<IntegerSplits>,
}

impl<N: Number> Banks<N> {
    /// Sets registers to any value.
    pub(crate) fn forget(&mut self, written: &[Reg], lanes: u64) {
        for reg in written {
            each(lanes, |lane| match reg.file {
                File::Float => put(self.floats.row(*reg), lane, N::any()),
                File::Int => put(self.ints.row(*reg), lane, N::Int::any()),
                File::Bool => put(self.bools.row(*reg), lane, N::Bool::any()),
            });
        }
    }
}
