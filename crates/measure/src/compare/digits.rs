//! Numbers as text of a report.

const RAISED: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];

/// A number with so many digits, as a power of ten where it is small or large; `–` where it is NaN.
pub fn digits(value: f64, count: usize) -> String {
    if !value.is_finite() {
        return if value > 0.0 { "∞".into() } else { "–".into() };
    }
    let power = if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    if (-4..=4).contains(&power) {
        let decimals = (count as i32 - 1 - power).max(0) as usize;
        return if value == 0.0 { "0".into() } else { format!("{value:.decimals$}") };
    }
    let raise = |c: char| c.to_digit(10).map_or('⁻', |digit| RAISED[digit as usize]);
    let raised: String = power.to_string().chars().map(raise).collect();
    match format!("{:.*}", count - 1, value / 10f64.powi(power)).as_str() {
        "1" => format!("10{raised}"),
        mantissa => format!("{mantissa}·10{raised}"),
    }
}

/// A number with three digits.
pub fn short(value: f64) -> String {
    digits(value, 3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_written_out_or_with_a_power_of_ten() {
        let written = [0.0, 0.0123456, 1.0, 23.24, 123.4, 43210.0, 1.23e-5, 2.5e6, f64::INFINITY, f64::NAN].map(short);
        assert_eq!(written, ["0", "0.0123", "1.00", "23.2", "123", "43210", "1.23·10⁻⁵", "2.50·10⁶", "∞", "–"]);
        let labels = [1e-6, 2e-5, 0.001, 0.05, 1.0, 20.0, 10000.0, 1e6].map(|value| digits(value, 1));
        assert_eq!(labels, ["10⁻⁶", "2·10⁻⁵", "0.001", "0.05", "1", "20", "10000", "10⁶"]);
    }
}
