//! Integers and truth values of programs in intervals: what may be.
//!
//! Invariant: integers wrap, so that a range which passes an end of 32 bits is any integer.

use super::number::{GROUP, IntBinary, IntUnary, Integer, Packed, Truth};

/// What may be true, false or either.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Tri {
    pub(super) may_hold: bool,
    pub(super) may_fail: bool,
}

/// Values of two parts that lie together.
macro_rules! packed_in_parts {
    ($value:ident { $first:ident, $second:ident: $part:ty }) => {
        impl Packed for $value {
            type Group = [[$part; GROUP]; 2];

            #[inline(always)]
            fn splat(self) -> Self::Group {
                [self.$first, self.$second].map(|part| [part; GROUP])
            }
            #[inline(always)]
            fn get([first, second]: &Self::Group, place: usize) -> Self {
                $value { $first: first[place], $second: second[place] }
            }
            #[inline(always)]
            fn put(self, [first, second]: &mut Self::Group, place: usize) {
                (first[place], second[place]) = (self.$first, self.$second);
            }
        }
    };
}
packed_in_parts!(Tri { may_hold, may_fail: bool });
packed_in_parts!(Range { lo, hi: i64 });

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
        Tri { may_hold: self.may_hold | b.may_hold, may_fail: self.may_fail | b.may_fail }
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
    #[inline(always)]
    fn select(self, a: Tri, b: Tri) -> Tri {
        let either = |a: bool, b: bool| a & self.may_hold | b & self.may_fail;
        Tri { may_hold: either(a.may_hold, b.may_hold), may_fail: either(a.may_fail, b.may_fail) }
    }
}

/// All integers from `lo` to `hi`, as signed or as unsigned ones.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Range {
    pub(super) lo: i64,
    pub(super) hi: i64,
}

/// Products of this size may pass 64 bits.
const HUGE: f64 = (1u64 << 62) as f64;

// What most of a hash is made of has no jumps, so that the lanes of a group are computed together.
impl Range {
    #[inline(always)]
    pub(super) fn full(signed: bool) -> Range {
        if signed {
            Range { lo: i64::from(i32::MIN), hi: i64::from(i32::MAX) }
        } else {
            Range { lo: 0, hi: i64::from(u32::MAX) }
        }
    }

    /// The other one, if that is so.
    #[inline(always)]
    fn unless(self, so: bool, other: Range) -> Range {
        Range { lo: if so { other.lo } else { self.lo }, hi: if so { other.hi } else { self.hi } }
    }

    #[inline(always)]
    fn is_single(self) -> bool {
        self.lo == self.hi
    }

    /// The bits, where there is one value.
    pub(super) fn single(self) -> Option<u32> {
        (self.lo == self.hi).then_some(self.lo as u32)
    }

    /// What an operation that does not wrap gives; wrapping leaves the full range.
    #[inline(always)]
    fn held(lo: i64, hi: i64, signed: bool) -> Range {
        let full = Range::full(signed);
        Range { lo, hi }.unless((lo < full.lo) | (hi > full.hi), full)
    }

    #[inline(always)]
    fn corners(self, b: Range, f: impl Fn(i64, i64) -> i64) -> (i64, i64) {
        let [p, q, r, s] = [f(self.lo, b.lo), f(self.lo, b.hi), f(self.hi, b.lo), f(self.hi, b.hi)];
        (p.min(q).min(r.min(s)), p.max(q).max(r.max(s)))
    }

    /// An operation on integers of which one at least is not known, both read alike.
    #[inline(always)]
    fn wide(self, function: IntBinary, b: Range, signed: bool) -> Range {
        let (a, full) = (self, Range::full(signed));
        let held = |(lo, hi)| Range::held(lo, hi, signed);
        let positive = (a.lo >= 0) & (b.lo >= 0);
        let by = b.lo & 31;
        match function {
            IntBinary::Add => held((a.lo + b.lo, a.hi + b.hi)),
            IntBinary::Sub => held((a.lo - b.hi, a.hi - b.lo)),
            IntBinary::Mul => {
                let largest = |x: Range| x.hi.max(-x.lo) as f64;
                held(a.corners(b, i64::wrapping_mul)).unless(largest(a) * largest(b) > HUGE, full)
            }
            IntBinary::Div if b.lo > 0 => held(a.corners(b, |x, y| x / y)),
            IntBinary::Rem if positive && b.lo > 0 => Range { lo: 0, hi: a.hi.min(b.hi - 1) },
            IntBinary::Min => Range { lo: a.lo.min(b.lo), hi: a.hi.min(b.hi) },
            IntBinary::Max => Range { lo: a.lo.max(b.lo), hi: a.hi.max(b.hi) },
            // The result has no bit that both (one of them) have not.
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
            IntBinary::ShiftLeft => full.unless(b.is_single() & (a.lo >= 0), held((a.lo << by, a.hi << by))),
            IntBinary::Div | IntBinary::Rem => full,
        }
    }
}

impl Integer for Range {
    type Truth = Tri;

    #[inline(always)]
    fn new(bits: u32, signed: bool) -> Range {
        let value = if signed { i64::from(bits as i32) } else { i64::from(bits) };
        Range { lo: value, hi: value }
    }
    fn whole() -> Range {
        Range { lo: i64::from(i32::MIN), hi: i64::from(u32::MAX) }
    }
    #[inline(always)]
    fn join(self, b: Range) -> Range {
        Range { lo: self.lo.min(b.lo), hi: self.hi.max(b.hi) }
    }
    #[inline(always)]
    fn within(self, other: Range) -> bool {
        (other.lo <= self.lo) & (self.hi <= other.hi)
    }
    #[inline(always)]
    fn select(truth: Tri, a: Range, b: Range) -> Range {
        a.join(b).unless(!truth.may_hold, b).unless(!truth.may_fail, a)
    }
    #[inline(always)]
    fn binary(self, function: IntBinary, b: Range, signed: bool) -> Range {
        let known = Range::new((self.lo as u32).binary(function, b.lo as u32, signed), signed);
        let wide = self.reread(signed).wide(function, b.reread(signed), signed);
        wide.unless(self.is_single() & b.is_single(), known)
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
    #[inline(always)]
    fn reread(self, signed: bool) -> Range {
        let full = Range::full(signed);
        let (turn, other) = if signed { (-(1 << 32), self.lo > full.hi) } else { (1 << 32, self.hi < 0) };
        let turned = full.unless(other, Range { lo: self.lo + turn, hi: self.hi + turn });
        turned.unless(self.within(full), self).unless(self.is_single(), Range::new(self.lo as u32, signed))
    }
    #[inline(always)]
    fn less(self, b: Range, signed: bool) -> Tri {
        let (a, b) = (self.reread(signed), b.reread(signed));
        Tri { may_hold: a.lo < b.hi, may_fail: a.hi >= b.lo }
    }
    #[inline(always)]
    fn equal(self, b: Range) -> Tri {
        let (a, b) = (self.reread(true), b.reread(true));
        let same = a.is_single() & b.is_single() & (a.lo == b.lo);
        Tri { may_hold: (a.lo <= b.hi) & (b.lo <= a.hi), may_fail: !same }
    }
    fn index(self, count: usize) -> (usize, usize) {
        let a = self.reread(true);
        let last = count as i64 - 1;
        (a.lo.clamp(0, last) as usize, a.hi.clamp(0, last) as usize)
    }
}
