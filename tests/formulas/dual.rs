//! Numbers with their derivative by the place: formulas written once give values and slopes.

use glam::DVec3;
use std::ops::{Add, Div, Mul, Neg, Sub};

/// A value and its gradient.
#[derive(Clone, Copy, Debug)]
pub struct Dual {
    pub v: f64,
    pub d: DVec3,
}

/// A place with the derivatives of its coordinates.
pub type Place = [Dual; 3];

/// A number that does not depend on the place.
pub fn dual(v: f64) -> Dual {
    Dual { v, d: DVec3::ZERO }
}

/// The place itself.
pub fn place(x: DVec3) -> Place {
    [0, 1, 2].map(|axis| Dual { v: x[axis], d: DVec3::AXES[axis] })
}

pub fn value(p: Place) -> DVec3 {
    DVec3::from(p.map(|c| c.v))
}

/// The derivative of a place along a direction.
pub fn slope(p: Place, along: DVec3) -> DVec3 {
    DVec3::from(p.map(|c| c.d.dot(along)))
}

pub fn scaled(p: Place, by: impl Into<Dual>) -> Place {
    let by = by.into();
    p.map(|c| c * by)
}

pub fn moved(p: Place, by: DVec3) -> Place {
    [p[0] + by.x, p[1] + by.y, p[2] + by.z]
}

pub fn length(p: Place) -> Dual {
    (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt()
}

impl Dual {
    fn chain(self, v: f64, slope: f64) -> Dual {
        Dual { v, d: slope * self.d }
    }

    pub fn sqrt(self) -> Dual {
        self.chain(self.v.sqrt(), 0.5 / self.v.sqrt())
    }

    pub fn abs(self) -> Dual {
        if self.v < 0.0 { -self } else { self }
    }

    pub fn max(self, other: impl Into<Dual>) -> Dual {
        let other = other.into();
        if other.v > self.v { other } else { self }
    }

    pub fn min(self, other: impl Into<Dual>) -> Dual {
        -(-self).max(-other.into())
    }

    pub fn clamp(self, low: f64, high: f64) -> Dual {
        self.max(low).min(high)
    }
}

impl From<f64> for Dual {
    fn from(v: f64) -> Dual {
        dual(v)
    }
}

impl Neg for Dual {
    type Output = Dual;
    fn neg(self) -> Dual {
        Dual { v: -self.v, d: -self.d }
    }
}

impl<T: Into<Dual>> Add<T> for Dual {
    type Output = Dual;
    fn add(self, other: T) -> Dual {
        let other = other.into();
        Dual { v: self.v + other.v, d: self.d + other.d }
    }
}

impl<T: Into<Dual>> Sub<T> for Dual {
    type Output = Dual;
    fn sub(self, other: T) -> Dual {
        self + -other.into()
    }
}

impl<T: Into<Dual>> Mul<T> for Dual {
    type Output = Dual;
    fn mul(self, other: T) -> Dual {
        let other = other.into();
        Dual { v: self.v * other.v, d: self.d * other.v + other.d * self.v }
    }
}

impl<T: Into<Dual>> Div<T> for Dual {
    type Output = Dual;
    fn div(self, other: T) -> Dual {
        let other = other.into();
        Dual { v: self.v / other.v, d: (self.d - other.d * (self.v / other.v)) / other.v }
    }
}
