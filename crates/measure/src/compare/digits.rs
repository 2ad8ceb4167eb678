//! Numbers as text of a report.

const RAISED: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];

/// A number with so many digits, as a power of ten where it is small or large; `–` where it is NaN.
pub fn digits(value: f64, count: usize) -> String {
    if !value.is_finite() {
        return if value > 0.0 { "∞".into() } else { "–".into() };
    }
    if value == 0.0 {
        return "0".into();
    }
    let rounded = format!("{value:.*e}", count - 1);
    let (mantissa, exponent) = rounded.split_once('e').unwrap_or((&rounded, "0"));
    let power: i32 = exponent.parse().unwrap_or(0);
    if (-4..=4).contains(&power) {
        return format!("{value:.*}", (count as i32 - 1 - power).max(0) as usize);
    }
    let raise = |c: char| c.to_digit(10).map_or('⁻', |digit| RAISED[digit as usize]);
    let raised: String = exponent.chars().map(raise).collect();
    if mantissa == "1" { format!("10{raised}") } else { format!("{mantissa}·10{raised}") }
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
        let labels = [1e-6, 2e-5, 9.7e-6, 0.001, 0.05, 1.0, 20.0, 10000.0, 1e6].map(|value| digits(value, 1));
        assert_eq!(labels, ["10⁻⁶", "2·10⁻⁵", "10⁻⁵", "0.001", "0.05", "1", "20", "10000", "10⁶"]);
    }
}
