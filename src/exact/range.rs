//! Integers and truth values of programs in intervals: what may be.
//!
//! Invariant: integers wrap, so that a range which passes an end of 32 bits is any integer.

use super::number::{IntBinary, IntUnary, Integer, Truth};

/// What may be true, false or either.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tri {
    pub(super) may_hold: bool,
    pub(super) may_fail: bool,
}

super::number::packed_as_they_are!(Tri Range);

impl Truth for Tri {
    #[inline(always)]
    fn new(truth: bool) -> Tri {
        Tri { may_hold: truth, may_fail: !truth }
    }
    fn whole() -> Tri {
        Tri { may_hold: true, may_fail: true }
    }
    #[inline(always)]
    fn join(self, b: Tri) -> Tri {
        Tri { may_hold: self.may_hold || b.may_hold, may_fail: self.may_fail || b.may_fail }
    }
    fn within(self, other: Tri) -> bool {
        self.join(other) == other
    }
    #[inline(always)]
    fn may_hold(self) -> bool {
        self.may_hold
    }
    #[inline(always)]
    fn may_fail(self) -> bool {
        self.may_fail
    }
    #[inline(always)]
    fn and(self, b: Tri) -> Tri {
        Tri { may_hold: self.may_hold & b.may_hold, may_fail: self.may_fail | b.may_fail }
    }
    #[inline(always)]
    fn or(self, b: Tri) -> Tri {
        self.not().and(b.not()).not()
    }
    #[inline(always)]
    fn not(self) -> Tri {
        Tri { may_hold: self.may_fail, may_fail: self.may_hold }
    }
    #[inline(always)]
    fn equal(self, b: Tri) -> Tri {
        self.and(b).or(self.not().and(b.not()))
    }
    fn select(self, a: Tri, b: Tri) -> Tri {
        match (self.may_hold, self.may_fail) {
            (true, false) => a,
            (false, true) => b,
            _ => a.join(b),
        }
    }
}

/// All integers from `lo` to `hi`, as signed or as unsigned ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Range {
    pub(super) lo: i64,
    pub(super) hi: i64,
}

impl Range {
    pub(super) fn full(signed: bool) -> Range {
        if signed {
            Range { lo: i64::from(i32::MIN), hi: i64::from(i32::MAX) }
        } else {
            Range { lo: 0, hi: i64::from(u32::MAX) }
        }
    }

    /// The bits, where there is one value.
    pub(super) fn single(self) -> Option<u32> {
        (self.lo == self.hi).then_some(self.lo as u32)
    }

    /// What an operation that does not wrap gives; wrapping leaves the full range.
    fn held(lo: i64, hi: i64, signed: bool) -> Range {
        let full = Range::full(signed);
        if lo < full.lo || hi > full.hi { full } else { Range { lo, hi } }
    }

    fn corners(self, b: Range, f: impl Fn(i64, i64) -> i64) -> (i64, i64) {
        let values = [f(self.lo, b.lo), f(self.lo, b.hi), f(self.hi, b.lo), f(self.hi, b.hi)];
        values.iter().fold((i64::MAX, i64::MIN), |(lo, hi), value| (lo.min(*value), hi.max(*value)))
    }
}

impl Integer for Range {
    type Truth = Tri;

    fn new(bits: u32, signed: bool) -> Range {
        let value = if signed { i64::from(bits as i32) } else { i64::from(bits) };
        Range { lo: value, hi: value }
    }
    fn whole() -> Range {
        Range { lo: i64::from(i32::MIN), hi: i64::from(u32::MAX) }
    }
    fn join(self, b: Range) -> Range {
        Range { lo: self.lo.min(b.lo), hi: self.hi.max(b.hi) }
    }
    fn within(self, other: Range) -> bool {
        other.lo <= self.lo && self.hi <= other.hi
    }
    fn select(truth: Tri, a: Range, b: Range) -> Range {
        match (truth.may_hold, truth.may_fail) {
            (true, false) => a,
            (false, true) => b,
            _ => a.join(b),
        }
    }
    #[inline(never)]
    fn binary(self, function: IntBinary, b: Range, signed: bool) -> Range {
        if let (Some(x), Some(y)) = (self.single(), b.single()) {
            return Range::new(x.binary(function, y, signed), signed);
        }
        let (a, b) = (self.reread(signed), b.reread(signed));
        let held = |(lo, hi)| Range::held(lo, hi, signed);
        let positive = a.lo >= 0 && b.lo >= 0;
        match function {
            IntBinary::Add => held((a.lo + b.lo, a.hi + b.hi)),
            IntBinary::Sub => held((a.lo - b.hi, a.hi - b.lo)),
            IntBinary::Mul => held(a.corners(b, i64::saturating_mul)), // two unsigned factors may pass i64
            IntBinary::Div if b.lo > 0 => held(a.corners(b, |x, y| x / y)),
            IntBinary::Rem if positive && b.lo > 0 => Range { lo: 0, hi: a.hi.min(b.hi - 1) },
            IntBinary::Min => Range { lo: a.lo.min(b.lo), hi: a.hi.min(b.hi) },
            IntBinary::Max => Range { lo: a.lo.max(b.lo), hi: a.hi.max(b.hi) },
            // The result has no bit that both (one of them) have not.
            IntBinary::And if positive => Range { lo: 0, hi: a.hi.min(b.hi) },
            IntBinary::And if b.lo >= 0 => Range { lo: 0, hi: b.hi },
            IntBinary::And if a.lo >= 0 => Range { lo: 0, hi: a.hi },
            IntBinary::Or | IntBinary::Xor if positive => {
                let bits = 64 - (a.hi | b.hi).leading_zeros();
                Range { lo: 0, hi: (1i64 << bits) - 1 }
            }
            IntBinary::ShiftRight if a.lo >= 0 => match b.single() {
                Some(by) => Range { lo: a.lo >> (by & 31), hi: a.hi >> (by & 31) },
                None => Range { lo: 0, hi: a.hi },
            },
            IntBinary::ShiftRight if signed => match b.single() {
                Some(by) => Range { lo: a.lo >> (by & 31), hi: a.hi >> (by & 31) },
                None => Range { lo: a.lo.min(0), hi: a.hi.max(-1) },
            },
            IntBinary::ShiftLeft if b.single().is_some() && a.lo >= 0 => {
                let by = b.lo & 31;
                held((a.lo << by, a.hi << by))
            }
            _ => Range::full(signed),
        }
    }
    #[inline(never)]
    fn unary(self, function: IntUnary, signed: bool) -> Range {
        let bits = matches!(function, IntUnary::CountBits | IntUnary::LowestBit | IntUnary::HighestBit);
        if let Some(value) = self.single() {
            return Range::new(function.of(value, signed), signed || bits);
        }
        let a = self.reread(signed);
        match function {
            IntUnary::Negate if signed => Range::held(-a.hi, -a.lo, signed),
            IntUnary::Abs if a.lo >= 0 => a,
            IntUnary::Abs if a.hi <= 0 => Range::held(-a.hi, -a.lo, signed),
            IntUnary::Abs => Range::held(0, a.hi.max(-a.lo), signed),
            IntUnary::Sign => Range { lo: a.lo.signum(), hi: a.hi.signum() },
            IntUnary::Not if signed => Range { lo: -1 - a.hi, hi: -1 - a.lo },
            _ if bits => Range { lo: -1, hi: 32 },
            _ => Range::full(signed),
        }
    }
    #[inline(never)]
    fn reread(self, signed: bool) -> Range {
        let full = Range::full(signed);
        match self.single() {
            Some(bits) => Range::new(bits, signed),
            None if self.within(full) => self,
            None if signed && self.lo > full.hi => Range { lo: self.lo - (1 << 32), hi: self.hi - (1 << 32) },
            None if !signed && self.hi < 0 => Range { lo: self.lo + (1 << 32), hi: self.hi + (1 << 32) },
            None => full,
        }
    }
    fn less(self, b: Range, signed: bool) -> Tri {
        let (a, b) = (self.reread(signed), b.reread(signed));
        Tri { may_hold: a.lo < b.hi, may_fail: a.hi >= b.lo }
    }
    fn equal(self, b: Range) -> Tri {
        if let (Some(x), Some(y)) = (self.single(), b.single()) {
            return Tri::new(x == y);
        }
        let (a, b) = (self.reread(true), b.reread(true));
        Tri { may_hold: a.lo <= b.hi && b.lo <= a.hi, may_fail: true }
    }
    fn index(self, count: usize) -> (usize, usize) {
        let a = self.reread(true);
        let last = count as i64 - 1;
        (a.lo.clamp(0, last) as usize, a.hi.clamp(0, last) as usize)
    }
}
