//! Closed forms of opacity, light and refraction, in f64.
//!
//! Lengths in object units; `b` is the distance of a ray from the center of a ball.

use glam::DVec3;

/// Opacity of a homogeneous ball of radius 1.
pub fn ball(extinction: f64, b: f64) -> f64 {
    1.0 - (-2.0 * extinction * (1.0 - b * b).max(0.0).sqrt()).exp()
}

/// Opacity of a path along which the extinction is linear.
pub fn slab(near: f64, far: f64, path: f64) -> f64 {
    1.0 - (-0.5 * path * (near + far)).exp()
}

/// Light of a slab whose color is the depth in it, for an extinction per unit of depth.
pub(crate) fn depth_color(extinction: f64, depth: f64) -> f64 {
    let (k, d) = (extinction, depth);
    (1.0 - (-k * d).exp() * (1.0 + k * d)) / k
}

/// Soft ball of MJ 6: density 1 below the radius `inner`, 0 above `outer`, and linear in the squared radius between them.
#[derive(Clone, Copy, Debug)]
pub struct SoftBall {
    /// Radius of the core.
    pub inner: f64,
    /// Radius of the soft region.
    pub outer: f64,
    /// c of PH 3.1.
    pub rate: f64,
}

impl SoftBall {
    fn width(&self) -> f64 {
        self.outer.powi(2) - self.inner.powi(2)
    }

    /// Half chords of a ray in the whole ball and in the core.
    fn half_chords(&self, b: f64) -> [f64; 2] {
        [self.outer, self.inner].map(|radius| (radius * radius - b * b).max(0.0).sqrt())
    }

    /// Opacity where the extinction is `rate` times the density.
    pub fn beer(&self, b: f64) -> f64 {
        let [l0, l1] = self.half_chords(b);
        let soft = (self.outer.powi(2) - b * b) * (l0 - l1) - (l0.powi(3) - l1.powi(3)) / 3.0;
        1.0 - (-2.0 * self.rate * (soft / self.width() + l1)).exp()
    }

    /// Transmittance of the soft region, in front of the core or beside it, with the opacity of PH 3.1.
    pub fn perlin(&self, b: f64) -> f64 {
        let [l0, l1] = self.half_chords(b);
        if b < self.inner {
            let xlnx = |x: f64| if x > 0.0 { x * x.ln() } else { 0.0 };
            let f = |x: f64| xlnx(x + l1) + xlnx(x - l1) - 2.0 * x;
            (self.rate * (f(l0) - f(l1) - (l0 - l1) * self.width().ln())).exp()
        } else {
            let a = (b * b - self.inner * self.inner).sqrt();
            let depth = if a > 0.0 { l0 - a * (l0 / a).atan() } else { l0 };
            (-4.0 * self.rate * depth).exp()
        }
    }
}

/// Distance of a line, given by a unit vector and its moment about the center, from the focus of rays along `along` behind
/// a Luneburg lens of radius 1.
pub fn luneburg_miss(along: DVec3, [direction, moment]: [DVec3; 2]) -> f64 {
    (along.cross(direction) - moment).length()
}

/// Ray that leaves Maxwell's fish-eye of radius 1 after entering at `at`: a unit vector, and its moment about the center.
/// It leaves at `-at`: circles through a point of the rim go through the opposite one.
pub(crate) fn fish_eye(at: DVec3, along: DVec3) -> [DVec3; 2] {
    [2.0 * along.dot(at) * at - along, at.cross(along)]
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Simpson's rule.
    fn integral(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
        let n = 20_000;
        let h = (to - from) / f64::from(n);
        let weight = |i: i32| if i == 0 || i == n { 1.0 } else { f64::from(2 + 2 * (i % 2)) };
        (0..=n).map(|i| weight(i) * f(from + f64::from(i) * h)).sum::<f64>() * h / 3.0
    }

    #[test]
    fn closed_forms_have_their_published_values() {
        assert!((depth_color(5.0, 1.0) - 0.191_914_46).abs() < 1e-8);
        let ball = SoftBall { inner: 0.75, outer: 1.25, rate: 3.0 };
        assert!((-ball.perlin(1.0).ln() - 2.268_715_928_011_75).abs() < 1e-13);
        assert!((super::ball(0.7, 0.6) - (1.0 - (-1.12f64).exp())).abs() < 1e-15);
        assert!((slab(2.4, 0.6, 2.0 / 3.0) - (1.0 - (-1f64).exp())).abs() < 1e-15);
    }

    #[test]
    fn closed_forms_are_the_integrals() {
        let ball = SoftBall { inner: 0.75, outer: 1.25, rate: 3.0 };
        let density = |r2: f64| ((ball.outer.powi(2) - r2) / ball.width()).clamp(0.0, 1.0);
        for b in [0.1, 0.5, 0.7, 0.8, 1.1] {
            let [l0, l1] = ball.half_chords(b);
            let depth = 2.0 * ball.rate * (integral(l1, l0, |l| density(b * b + l * l)) + l1);
            assert!((ball.beer(b) - (1.0 - (-depth).exp())).abs() < 1e-9, "{b}");
            // The logarithm is infinite at the core.
            if b > ball.inner {
                let depth = -2.0 * ball.rate * integral(0.0, l0, |l| (1.0 - density(b * b + l * l)).ln());
                assert!((ball.perlin(b) - (-depth).exp()).abs() < 1e-9, "{b}");
            }
        }
    }

    #[test]
    fn a_ray_of_the_fish_eye_runs_in_a_circle_to_the_opposite_point() {
        // Runge-Kutta for r'' = grad(n^2 / 2).
        let (at, along) = (DVec3::new(0.6, 0.0, 0.8), DVec3::NEG_Z);
        let pull = |x: DVec3| -8.0 * x / (1.0 + x.length_squared()).powi(3);
        let (mut x, mut v, h) = (at, along, 1e-4);
        while x.length_squared() <= 1.0 || v.dot(x) < 0.0 {
            let (k1, l1) = (v, pull(x));
            let (k2, l2) = (v + 0.5 * h * l1, pull(x + 0.5 * h * k1));
            let (k3, l3) = (v + 0.5 * h * l2, pull(x + 0.5 * h * k2));
            let (k4, l4) = (v + h * l3, pull(x + h * k3));
            x += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
            v += h / 6.0 * (l1 + 2.0 * l2 + 2.0 * l3 + l4);
        }
        let [direction, moment] = fish_eye(at, along);
        assert!((x + at).length() < 2e-4 && (v.normalize() - direction).length() < 2e-4, "{x} {v}");
        assert!((x.cross(v) - moment).length() < 1e-9);
    }
}
