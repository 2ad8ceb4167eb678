//! Motion of a module's noise over time: `// @drift`.
//!
//! ```glsl
//! // @drift rise * 0.45 * flame_scale     a speed parameter, times factors to noise cells per second
//! ```
//! Speed times time grows without bound, and far coordinates lose precision in f32. So the speed is replaced by one that leads
//! to the same place of a lattice that repeats after [`PERIOD`] cells.

/// Period of a drift in cells. Block and table noise repeats within it; other noise jumps to another place of its endless
/// lattice. Higher loses precision in f32; lower jumps sooner.
pub const PERIOD: f64 = 4096.0;

/// Largest relative change of a speed to whole periods. Higher: motion is seen to be slower or faster. Lower: more noise is
/// evaluated twice.
const MOST_CHANGE: f64 = 0.34;

/// A drift declared by a module.
#[derive(Clone, Debug, PartialEq)]
pub struct Drift {
    /// The speed parameter.
    pub speed: String,
    /// Further factors: parameters, and the product of all numbers.
    names: Vec<String>,
    number: f64,
    /// Whether turbulence drifts, or noise.
    pub of_turbulence: bool,
}

impl Drift {
    /// Parses the text after `@drift`.
    pub(super) fn parse(text: &str) -> Option<Drift> {
        let mut factors = text.split('*').map(str::trim);
        let speed = super::names::identifier(factors.next()?)?;
        let mut drift = Drift { speed, names: Vec::new(), number: 1.0, of_turbulence: false };
        for factor in factors {
            match factor.parse::<f64>() {
                Ok(number) if number.is_finite() && number > 0.0 => drift.number *= number,
                Ok(_) => return None,
                Err(_) => drift.names.push(super::names::identifier(factor)?),
            }
        }
        Some(drift)
    }

    /// Names of all parameters.
    pub(super) fn parameters(&mut self) -> impl Iterator<Item = &mut String> {
        std::iter::once(&mut self.speed).chain(&mut self.names)
    }

    /// Cells of noise per second.
    fn rate(&self, value: impl Fn(&str) -> f32) -> f64 {
        f64::from(value(&self.speed))
            * self.names.iter().map(|name| f64::from(value(name))).product::<f64>()
            * self.number
    }

    /// The nearest speed that moves noise by whole periods of `cells` in `seconds`; `None` if it differs too much.
    pub fn whole(&self, seconds: f64, cells: f64, value: impl Fn(&str) -> f32) -> Option<f32> {
        let periods = self.rate(&value) * seconds / cells;
        let change = periods.round() / periods;
        ((change - 1.0).abs() <= MOST_CHANGE).then(|| (f64::from(value(&self.speed)) * change) as f32)
    }

    /// The nearest speed that moves noise in `seconds` to at least a cell beside the places where it repeats after `cells`;
    /// `None` for the own one.
    pub fn apart(&self, seconds: f64, cells: f64, value: impl Fn(&str) -> f32) -> Option<f32> {
        let moved = self.rate(&value) * seconds;
        let whole = (moved / cells).round() * cells;
        let (beside, apart) = ((moved - whole) * moved.signum(), (0.5 * cells).min(1.0));
        let wanted = whole.abs() + if beside > 0.0 { apart } else { -apart };
        let is_near = whole != 0.0 && beside.abs() < apart;
        is_near.then(|| (f64::from(value(&self.speed)) * wanted / moved.abs()) as f32)
    }

    /// The replacement of the speed at a time that the program has in f32; `None` while the original is precise enough.
    pub fn wrapped(&self, time: f64, value: impl Fn(&str) -> f32) -> Option<f32> {
        let speed = f64::from(value(&self.speed));
        let cells = self.rate(&value) * time;
        let is_far = cells.abs() > PERIOD && cells.is_finite();
        is_far.then(|| (speed * ((cells % PERIOD) / cells) * (time / f64::from(time as f32))) as f32)
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
        assert_eq!(drift.wrapped(5000.0, value), None, "4050 cells");
        for time in [6000.0, 1e6 + 0.04, 1e9 + 0.5, -7e7] {
            let wrapped = f64::from(drift.wrapped(time, value).unwrap()) * f64::from(time as f32) * 0.45 * 3.0;
            let exact = (rate * time) % PERIOD;
            assert!((wrapped - exact).abs() < PERIOD * 1.3e-7, "{time}: {wrapped} for {exact}");
        }
        assert_eq!(drift.wrapped(1e300, |_| f32::MAX), None, "no place at all");
    }

    #[test]
    fn a_loop_has_whole_periods_at_nearly_the_same_speed_or_none() {
        let drift = Drift::parse("rise * 0.45 * scale").unwrap();
        let value = |name: &str| if name == "rise" { 0.6 } else { 3.0 };
        let speed = drift.whole(4.0, 4.0, value).unwrap();
        assert!((f64::from(speed) * 0.45 * 3.0 * 4.0 - 4.0).abs() < 1e-6, "3.24 cells become 4");
        assert_eq!(drift.whole(4.0, 16.0, value), None, "3.24 of 16 cells");
        assert_eq!(drift.whole(4.0, 4.0, |_| 0.0), None, "no motion");
        for (seconds, cells) in [(4.0, 3.0), (4.9, 3.0), (5.5, 5.0)] {
            let speed = drift.apart(seconds, 4.0, value).unwrap();
            assert!((f64::from(speed) * 0.45 * 3.0 * seconds - cells).abs() < 1e-6, "{seconds} s");
        }
        assert_eq!([1.0, 7.5].map(|seconds| drift.apart(seconds, 4.0, value)), [None; 2], "0.8 and 6.1 cells");
    }

    #[test]
    fn a_drift_that_cannot_be_read_is_refused() {
        for text in ["", "0.5 * rise", "rise *", "rise * -1", "rise + scale", "Rise"] {
            assert_eq!(Drift::parse(text), None, "{text}");
        }
    }
}
