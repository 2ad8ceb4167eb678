//! How a module moves its noise as time passes: `// @drift`.
//!
//! ```glsl
//! // @drift rise * 0.45 * flame_scale     the parameter that is a speed, times what makes it cells of noise per second
//! ```
//! The product of speed and time grows without end, and f32 tells places apart the worse the farther away they are. So a
//! speed is given another value, which leads to the same place of a lattice that repeats after [`WHOLE`] cells.

/// Cells after which a drift begins anew: noise of blocks and tables repeats by then, and other noise is at another place of
/// its endless lattice. More: f32 tells places apart less well. Less: that happens sooner.
pub const WHOLE: f64 = 4096.0;

/// A speed of a module.
#[derive(Clone, Debug, PartialEq)]
pub struct Drift {
    /// The parameter.
    pub speed: String,
    /// The other factors: parameters by their names, and the product of all numbers.
    names: Vec<String>,
    number: f64,
}

impl Drift {
    /// Reads what follows `@drift`; `None` where that cannot be read.
    pub(super) fn parse(text: &str) -> Option<Drift> {
        let mut factors = text.split('*').map(str::trim);
        let speed = super::names::identifier(factors.next()?)?;
        let mut drift = Drift { speed, names: Vec::new(), number: 1.0 };
        for factor in factors {
            match factor.parse::<f64>() {
                Ok(number) if number.is_finite() && number > 0.0 => drift.number *= number,
                Ok(_) => return None,
                Err(_) => drift.names.push(super::names::identifier(factor)?),
            }
        }
        Some(drift)
    }

    /// The names of its parameters.
    pub(super) fn parameters(&mut self) -> impl Iterator<Item = &mut String> {
        std::iter::once(&mut self.speed).chain(&mut self.names)
    }

    /// The speed that leads to the same place of the lattice at a time, which the program has in f32; `None` where the own
    /// one does so well enough.
    pub fn held(&self, time: f64, value: impl Fn(&str) -> f32) -> Option<f32> {
        let factors = self.names.iter().map(|name| f64::from(value(name))).product::<f64>();
        let speed = f64::from(value(&self.speed));
        let cells = speed * factors * self.number * time;
        let is_far = cells.abs() > WHOLE && cells.is_finite();
        is_far.then(|| (speed * ((cells % WHOLE) / cells) * (time / f64::from(time as f32))) as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn c46_a_far_drift_is_at_the_place_of_a_near_one() {
        let drift = Drift::parse("rise * 0.45 * scale").unwrap();
        let value = |name: &str| if name == "rise" { 0.6 } else { 3.0 };
        let rate = f64::from(0.6f32) * 0.45 * 3.0;
        assert_eq!(drift.held(5000.0, value), None, "4050 cells");
        for time in [6000.0, 1e6 + 0.04, 1e9 + 0.5, -7e7] {
            let held = f64::from(drift.held(time, value).unwrap()) * f64::from(time as f32) * 0.45 * 3.0;
            let exact = (rate * time) % WHOLE;
            assert!((held - exact).abs() < WHOLE * 1.3e-7, "{time}: {held} for {exact}");
        }
        assert_eq!(drift.held(1e300, |_| f32::MAX), None, "no place at all");
    }

    #[test]
    fn a_drift_that_cannot_be_read_is_refused() {
        for text in ["", "0.5 * rise", "rise *", "rise * -1", "rise + scale", "Rise"] {
            assert_eq!(Drift::parse(text), None, "{text}");
        }
    }
}
