//! Intervals with bounds of the slope: what a program may compute along a parameter, and how fast that changes.
//!
//! Role: a number is a function of one parameter, such as the distance along a ray, on a segment or on all parallel segments
//! through a box. Invariant: as for [`Interval`], which holds its values; its slope holds what any two of them differ by,
//! divided by how far their parameters are apart, in exact arithmetic. Where the function may jump the slope is the whole line.
//! Source: Krawczyk and Neumaier 1985 (slopes); what two values of a smooth function differ by is bounded by its derivative
//! between them.

use super::interval::Interval;
use super::number::{GROUP, Number, Packed, Unary};
use super::range::{Range, Tri};
use super::texture::Image;
use super::{BoundProgram, ExactError, Lanes, Measured};
use noise::Knots;
use std::f64::consts::{LN_2, LOG2_E};

/// A number that changes with a parameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sloped {
    /// Bounds of its values.
    pub all: Interval,
    /// Bounds of what two values differ by, divided by how far their parameters are apart.
    pub slope: Interval,
}

const ZERO: Interval = Interval { lo: 0.0, hi: 0.0 };
const ONE: Interval = Interval { lo: 1.0, hi: 1.0 };

/// A number that is not rounded.
fn point(x: f64) -> Interval {
    Interval { lo: x, hi: x }
}

/// The derivative of a function over an interval; the whole line where it may jump or is not defined.
fn derivative(function: Unary, x: Interval) -> Interval {
    let of = |function| x.unary(function);
    let square = || of(Unary::Square);
    let root = |x: Interval| x.unary(Unary::Sqrt);
    let within = |lo: f64, hi: f64| Interval { lo, hi };
    match function {
        Unary::Negate => ONE.negate(),
        Unary::Abs if x.lo >= 0.0 => ONE,
        Unary::Abs if x.hi <= 0.0 => ONE.negate(),
        Unary::Abs => within(-1.0, 1.0),
        Unary::Fract if x.lo.floor() == x.hi.floor() => ONE,
        // Steps: where none is passed the value is one number.
        Unary::Fract | Unary::Sign | Unary::Floor | Unary::Ceil | Unary::Trunc | Unary::Round => Interval::WHOLE,
        Unary::Saturate if x.lo >= 0.0 && x.hi <= 1.0 => ONE,
        Unary::Saturate if x.hi <= 0.0 || x.lo >= 1.0 => ZERO,
        Unary::Saturate => within(0.0, 1.0),
        Unary::Square => point(2.0).mul(x),
        Unary::Sqrt => point(0.5).div(root(x)),
        Unary::InverseSqrt => point(-0.5).div(x.mul(root(x))),
        Unary::Hermite => {
            let [low, high] = [x.lo, x.hi].map(|t| t.clamp(0.0, 1.0));
            let [from, to] = [low, high].map(|t| 6.0 * t * (1.0 - t));
            let most = if low <= 0.5 && high >= 0.5 { 1.5 } else { from.max(to) };
            within(from.min(to), most).wider()
        }
        Unary::Exp => of(Unary::Exp),
        Unary::Exp2 => of(Unary::Exp2).mul(point(LN_2).wider()),
        Unary::Log => ONE.div(x),
        Unary::Log2 => point(LOG2_E).wider().div(x),
        Unary::Sin => of(Unary::Cos),
        Unary::Cos => of(Unary::Sin).negate(),
        Unary::Tan => ONE.add(of(Unary::Tan).unary(Unary::Square)),
        Unary::Asin => ONE.div(root(ONE.sub(square()))),
        Unary::Acos => ONE.div(root(ONE.sub(square()))).negate(),
        Unary::Atan => ONE.div(ONE.add(square())),
        Unary::Sinh => of(Unary::Cosh),
        Unary::Cosh => of(Unary::Sinh),
        Unary::Tanh => ONE.sub(of(Unary::Tanh).unary(Unary::Square)),
        Unary::Asinh => ONE.div(root(ONE.add(square()))),
        Unary::Acosh => ONE.div(root(square().sub(ONE))),
        Unary::Atanh => ONE.div(ONE.sub(square())),
    }
}

impl Sloped {
    /// From one number to another, evenly as the parameter goes on by a length above 0.
    pub fn between(from: f64, to: f64, length: f64) -> Sloped {
        Sloped::of(Interval::of(from, to), point(to).sub(point(from)).div(point(length)))
    }

    /// Values and their slope: what is one number does not change, and of what may be NaN nothing is known.
    fn of(all: Interval, slope: Interval) -> Sloped {
        let known = ZERO.unless(all.lo < all.hi, slope);
        Sloped { all, slope: known.unless(all == Interval::WHOLE, all) }
    }

    /// Values that may jump.
    fn jumping(all: Interval) -> Sloped {
        Sloped::of(all, Interval::WHOLE)
    }

    /// What is sampled of a noise or an image, by its slopes along the axes of the coordinates.
    fn sampled(all: Interval, slopes: [Interval; 3], at: [Sloped; 3]) -> Sloped {
        let slope = slopes.into_iter().zip(at).map(|(slope, at)| slope.mul(at.slope));
        Sloped::of(all, slope.fold(ZERO, Interval::add))
    }
}

impl Packed for Sloped {
    type Group = [[f64; GROUP]; 4];

    #[inline(always)]
    fn splat(self) -> Self::Group {
        [self.all.lo, self.all.hi, self.slope.lo, self.slope.hi].map(|part| [part; GROUP])
    }
    #[inline(always)]
    fn get([lo, hi, low, high]: &Self::Group, place: usize) -> Sloped {
        let slope = Interval { lo: low[place], hi: high[place] };
        Sloped { all: Interval { lo: lo[place], hi: hi[place] }, slope }
    }
    #[inline(always)]
    fn put(self, [lo, hi, low, high]: &mut Self::Group, place: usize) {
        (lo[place], hi[place]) = (self.all.lo, self.all.hi);
        (low[place], high[place]) = (self.slope.lo, self.slope.hi);
    }
}

impl Number for Sloped {
    type Int = Range;
    type Truth = Tri;
    const DECIDED: bool = false;

    fn measure(program: &BoundProgram<'_>, lanes: &Lanes<Self>) -> Result<Measured<Self>, ExactError> {
        program.evaluate(lanes, &mut [], None)
    }

    fn new(x: f64) -> Sloped {
        Sloped::of(Interval::new(x), ZERO)
    }
    fn whole() -> Sloped {
        Sloped::jumping(Interval::WHOLE)
    }
    fn join(self, other: Sloped) -> Sloped {
        // The one here, the other there.
        Sloped::jumping(self.all.join(other.all))
    }
    fn within(self, other: Sloped) -> bool {
        self.all.within(other.all) && self.slope.within(other.slope)
    }
    fn select(truth: Tri, a: Sloped, b: Sloped) -> Sloped {
        match (truth.may_hold, truth.may_fail) {
            (true, true) => a.join(b),
            (true, false) => a,
            (false, _) => b,
        }
    }
    fn one_of(truth: Tri, a: Sloped, b: Sloped) -> Sloped {
        Sloped::select(truth, a, b)
    }
    fn unary(self, function: Unary) -> Sloped {
        Sloped::of(self.all.unary(function), derivative(function, self.all).mul(self.slope))
    }
    fn add(self, b: Sloped) -> Sloped {
        Sloped::of(self.all.add(b.all), self.slope.add(b.slope))
    }
    fn sub(self, b: Sloped) -> Sloped {
        Sloped::of(self.all.sub(b.all), self.slope.sub(b.slope))
    }
    fn mul(self, b: Sloped) -> Sloped {
        Sloped::of(self.all.mul(b.all), self.all.mul(b.slope).add(b.all.mul(self.slope)))
    }
    fn div(self, b: Sloped) -> Sloped {
        let all = self.all.div(b.all);
        Sloped::of(all, self.slope.sub(all.mul(b.slope)).div(b.all))
    }
    fn min(self, b: Sloped) -> Sloped {
        let all = self.all.min(b.all);
        if self.all == Interval::WHOLE || b.all == Interval::WHOLE {
            return Sloped::jumping(all); // of NaN and a number the number
        }
        let either = self.slope.join(b.slope);
        Sloped::of(all, either.unless(self.all.hi <= b.all.lo, self.slope).unless(b.all.hi <= self.all.lo, b.slope))
    }
    fn max(self, b: Sloped) -> Sloped {
        let negate = |x: Sloped| x.unary(Unary::Negate);
        negate(negate(self).min(negate(b)))
    }
    fn pow(self, b: Sloped) -> Sloped {
        let all = self.all.pow(b.all);
        let base = b.all.mul(self.all.pow(b.all.sub(ONE))).mul(self.slope);
        let exponent = || all.mul(self.all.unary(Unary::Log)).mul(b.slope);
        Sloped::of(all, if b.slope == ZERO { base } else { base.add(exponent()) })
    }
    fn atan2(self, x: Sloped) -> Sloped {
        let all = self.all.atan2(x.all);
        if self.all.contains(0.0) && x.all.lo <= 0.0 {
            return Sloped::jumping(all); // from pi to -pi
        }
        let square = self.all.unary(Unary::Square).add(x.all.unary(Unary::Square));
        Sloped::of(all, x.all.mul(self.slope).sub(self.all.mul(x.slope)).div(square))
    }
    fn rem(self, b: Sloped) -> Sloped {
        let times = self.all.div(b.all).unary(Unary::Trunc);
        let slope = self.slope.sub(times.mul(b.slope));
        Sloped::of(self.all.rem(b.all), Interval::WHOLE.unless(times.lo == times.hi, slope))
    }
    fn unit(self, length: Sloped) -> Sloped {
        Sloped::of(self.all.unit(length.all), self.div(length).slope)
    }
    fn mix(self, b: Sloped, t: Sloped) -> Sloped {
        let moved = b.all.sub(self.all).mul(t.slope);
        Sloped::of(self.all.mix(b.all, t.all), self.slope.mix(b.slope, t.all).add(moved))
    }
    fn less(self, b: Sloped) -> Tri {
        self.all.less(b.all)
    }
    fn less_equal(self, b: Sloped) -> Tri {
        self.all.less_equal(b.all)
    }
    fn equal(self, b: Sloped) -> Tri {
        self.all.equal(b.all)
    }
    fn is_nan(self) -> Tri {
        self.all.is_nan()
    }
    fn is_infinite(self) -> Tri {
        self.all.is_infinite()
    }
    fn to_int(self, signed: bool) -> Range {
        self.all.to_int(signed)
    }
    fn from_int(int: Range, signed: bool) -> Sloped {
        Sloped::jumping(Interval::from_int(int, signed))
    }
    fn to_bits(self, signed: bool) -> Range {
        self.all.to_bits(signed)
    }
    fn from_bits(int: Range) -> Sloped {
        Sloped::jumping(Interval::from_bits(int))
    }
    fn ldexp(self, exponent: Range) -> Sloped {
        let factor = Interval::WHOLE.unless(exponent.lo == exponent.hi, ONE.ldexp(exponent));
        Sloped::of(self.all.ldexp(exponent), factor.mul(self.slope))
    }
    fn sample(image: &Image<'_>, at: [Sloped; 3], level: Sloped, wanted: [bool; 4]) -> [Sloped; 4] {
        let places = at.map(|at| at.all);
        let all = Interval::sample(image, places, level.all, wanted);
        let mut found = all.map(Sloped::jumping);
        let [low, high] = [places.map(|at| at.lo), places.map(|at| at.hi)];
        if let Some(noise) = image.noise {
            if level.all.lo == level.all.hi {
                let slopes = noise.gradient_range(Knots::of_level(level.all.lo), low, high);
                found[3] = Sloped::sampled(all[3], slopes.map(|[lo, hi]| Interval { lo, hi }), at);
            }
        } else if level.all.hi <= 0.0
            && let Some(slopes) = image.slopes(places.map(|at| [at.lo, at.hi]))
        {
            let slopes = slopes.map(|of| of.map(|[lo, hi]| Interval { lo, hi }.wider()));
            found = std::array::from_fn(|channel| Sloped::sampled(all[channel], slopes[channel], at));
        }
        found
    }
    fn fetch(image: &Image<'_>, at: [Range; 3]) -> [Sloped; 4] {
        Interval::fetch(image, at).map(Sloped::jumping)
    }
}
