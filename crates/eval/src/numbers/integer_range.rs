//! Integers and booleans for interval types: ranges and three-valued logic.
//!
//! Invariant: integers wrap, so a range that overflows 32 bits becomes the full range.

use crate::number::{Bool, Domain, IntBinary, IntUnary, Integer, packed};

/// A boolean that may be true, false or either.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tri {
    pub(crate) may_hold: bool,
    pub(crate) may_fail: bool,
}

packed!(Tri as x: 2 bool { may_hold: x.may_hold, may_fail: x.may_fail } => Tri { may_hold, may_fail });
packed!(Range as x: 2 i64 { lo: x.lo, hi: x.hi } => Range { lo, hi });

impl Domain for Tri {
    fn any() -> Tri {
        Tri { may_hold: true, may_fail: true }
    }
    #[inline(always)]
    fn join(self, b: Tri) -> Tri {
        Tri { may_hold: self.may_hold | b.may_hold, may_fail: self.may_fail | b.may_fail }
    }
    fn is_within(self, other: Tri) -> bool {
        self.join(other) == other
    }
}

impl Bool for Tri {
    #[inline(always)]
    fn new(value: bool) -> Tri {
        Tri { may_hold: value, may_fail: !value }
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
    #[inline(always)]
    fn select(self, a: Tri, b: Tri) -> Tri {
        let either = |a: bool, b: bool| a & self.may_hold | b & self.may_fail;
        Tri { may_hold: either(a.may_hold, b.may_hold), may_fail: either(a.may_fail, b.may_fail) }
    }
}

/// All integers from `lo` to `hi`, signed or unsigned.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Range {
    pub(crate) lo: i64,
    pub(crate) hi: i64,
}

/// Larger products may overflow i64.
const HUGE: f64 = (1u64 << 62) as f64;

// The operations of hashes are without branches, so that groups of lanes vectorize.
impl Range {
    #[inline(always)]
    pub(crate) fn full(signed: bool) -> Range {
        if signed {
            Range { lo: i64::from(i32::MIN), hi: i64::from(i32::MAX) }
        } else {
            Range { lo: 0, hi: i64::from(u32::MAX) }
        }
    }

    /// `other` if `condition`, else `self`, without a branch.
    #[inline(always)]
    fn unless(self, condition: bool, other: Range) -> Range {
        Range { lo: if condition { other.lo } else { self.lo }, hi: if condition { other.hi } else { self.hi } }
    }

    #[inline(always)]
    fn is_single(self) -> bool {
        self.lo == self.hi
    }

    /// The bits of a single value.
    pub(crate) fn single(self) -> Option<u32> {
        (self.lo == self.hi).then_some(self.lo as u32)
    }

    /// A result, or the full range if it overflows.
    #[inline(always)]
    fn wrapping(lo: i64, hi: i64, signed: bool) -> Range {
        let full = Range::full(signed);
        Range { lo, hi }.unless((lo < full.lo) | (hi > full.hi), full)
    }

    #[inline(always)]
    fn corners(self, b: Range, f: impl Fn(i64, i64) -> i64) -> (i64, i64) {
        let [p, q, r, s] = [f(self.lo, b.lo), f(self.lo, b.hi), f(self.hi, b.lo), f(self.hi, b.hi)];
        (p.min(q).min(r.min(s)), p.max(q).max(r.max(s)))
    }

    /// An operation on ranges of the same signedness, at least one with several values.
    #[inline(always)]
    fn wide(self, function: IntBinary, b: Range, signed: bool) -> Range {
        let (a, full) = (self, Range::full(signed));
        let wrapping = |(lo, hi)| Range::wrapping(lo, hi, signed);
        let positive = (a.lo >= 0) & (b.lo >= 0);
        let by = b.lo & 31;
        match function {
            IntBinary::Add => wrapping((a.lo + b.lo, a.hi + b.hi)),
            IntBinary::Sub => wrapping((a.lo - b.hi, a.hi - b.lo)),
            IntBinary::Mul => {
                let largest = |x: Range| x.hi.max(-x.lo) as f64;
                wrapping(a.corners(b, i64::wrapping_mul)).unless(largest(a) * largest(b) > HUGE, full)
            }
            IntBinary::Div if b.lo > 0 => wrapping(a.corners(b, |x, y| x / y)),
            IntBinary::Rem if positive && b.lo > 0 => Range { lo: 0, hi: a.hi.min(b.hi - 1) },
            IntBinary::Min => Range { lo: a.lo.min(b.lo), hi: a.hi.min(b.hi) },
            IntBinary::Max => Range { lo: a.lo.max(b.lo), hi: a.hi.max(b.hi) },
            // The bits are a subset of those of one operand if only one is known to be positive, else of both.
            IntBinary::And => {
                let one =
                    full.unless(a.lo >= 0, Range { lo: 0, hi: a.hi }).unless(b.lo >= 0, Range { lo: 0, hi: b.hi });
                one.unless(positive, Range { lo: 0, hi: a.hi.min(b.hi) })
            }
            IntBinary::Or | IntBinary::Xor => {
                let bits = [1, 2, 4, 8, 16].into_iter().fold(a.hi | b.hi, |bits, by| bits | bits >> by);
                full.unless(positive, Range { lo: 0, hi: bits })
            }
            IntBinary::ShiftRight => {
                let any = Range { lo: a.lo.min(0), hi: a.hi.max(if signed { -1 } else { 0 }) };
                any.unless(b.is_single(), Range { lo: a.lo >> by, hi: a.hi >> by })
            }
            IntBinary::ShiftLeft => full.unless(b.is_single() & (a.lo >= 0), wrapping((a.lo << by, a.hi << by))),
            IntBinary::Div | IntBinary::Rem => full,
        }
    }
}

impl Domain for Range {
    fn any() -> Range {
        Range { lo: i64::from(i32::MIN), hi: i64::from(u32::MAX) }
    }
    #[inline(always)]
    fn join(self, b: Range) -> Range {
        Range { lo: self.lo.min(b.lo), hi: self.hi.max(b.hi) }
    }
    #[inline(always)]
    fn is_within(self, other: Range) -> bool {
        (other.lo <= self.lo) & (self.hi <= other.hi)
    }
}

impl Integer for Range {
    type Bool = Tri;

    #[inline(always)]
    fn new(bits: u32, signed: bool) -> Range {
        let value = if signed { i64::from(bits as i32) } else { i64::from(bits) };
        Range { lo: value, hi: value }
    }
    #[inline(always)]
    fn select(condition: Tri, a: Range, b: Range) -> Range {
        a.join(b).unless(!condition.may_hold, b).unless(!condition.may_fail, a)
    }
    #[inline(always)]
    fn binary(self, function: IntBinary, b: Range, signed: bool) -> Range {
        let known = Range::new((self.lo as u32).binary(function, b.lo as u32, signed), signed);
        let wide = self.bitcast(signed).wide(function, b.bitcast(signed), signed);
        wide.unless(self.is_single() & b.is_single(), known)
    }
    #[inline(never)]
    fn unary(self, function: IntUnary, signed: bool) -> Range {
        let bits = matches!(function, IntUnary::CountBits | IntUnary::LowestBit | IntUnary::HighestBit);
        if let Some(value) = self.single() {
            return Range::new(value.unary(function, signed), signed || bits);
        }
        let a = self.bitcast(signed);
        match function {
            IntUnary::Negate if signed => Range::wrapping(-a.hi, -a.lo, signed),
            IntUnary::Abs if a.lo >= 0 => a,
            IntUnary::Abs if a.hi <= 0 => Range::wrapping(-a.hi, -a.lo, signed),
            IntUnary::Abs => Range::wrapping(0, a.hi.max(-a.lo), signed),
            IntUnary::Sign => Range { lo: a.lo.signum(), hi: a.hi.signum() },
            IntUnary::Not if signed => Range { lo: -1 - a.hi, hi: -1 - a.lo },
            _ if bits => Range { lo: -1, hi: 32 },
            _ => Range::full(signed),
        }
    }
    #[inline(always)]
    fn bitcast(self, signed: bool) -> Range {
        let full = Range::full(signed);
        let (turn, other) = if signed { (-(1 << 32), self.lo > full.hi) } else { (1 << 32, self.hi < 0) };
        let turned = full.unless(other, Range { lo: self.lo + turn, hi: self.hi + turn });
        turned.unless(self.is_within(full), self).unless(self.is_single(), Range::new(self.lo as u32, signed))
    }
    #[inline(always)]
    fn less(self, b: Range, signed: bool) -> Tri {
        let (a, b) = (self.bitcast(signed), b.bitcast(signed));
        Tri { may_hold: a.lo < b.hi, may_fail: a.hi >= b.lo }
    }
    #[inline(always)]
    fn equal(self, b: Range) -> Tri {
        let (a, b) = (self.bitcast(true), b.bitcast(true));
        let same = a.is_single() & b.is_single() & (a.lo == b.lo);
        Tri { may_hold: (a.lo <= b.hi) & (b.lo <= a.hi), may_fail: !same }
    }
    fn index(self, count: usize) -> (usize, usize) {
        let a = self.bitcast(true);
        let last = count as i64 - 1;
        (a.lo.clamp(0, last) as usize, a.hi.clamp(0, last) as usize)
    }
}
