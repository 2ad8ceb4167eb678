//! Means, root mean squares and quantiles of errors.

/// Mean; NaN without values.
pub fn mean(values: impl Iterator<Item = f64>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), value| (sum + value, count + 1.0));
    sum / count
}

/// Largest of nonnegative values; 0 without values, NaN if one is NaN.
pub fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    values.into_iter().fold(0.0, |most, value| if value > most || value.is_nan() { value } else { most })
}

/// Positive number rounded up to two digits, so that a printed bound stays valid.
pub fn rounded_up(number: f64) -> f64 {
    let shown = |number: f64| format!("{number:.1e}").parse().unwrap_or(number);
    let near: f64 = shown(number);
    if near < number { shown(near + 10f64.powf(number.log10().floor() - 1.0)) } else { near }
}

/// Root mean square; 0 without values.
pub fn rms(values: impl Iterator<Item = f64>) -> f64 {
    weighted_rms(values.map(|value| (value, 1.0)))
}

/// Weighted root mean square; 0 without values.
pub(crate) fn weighted_rms(values: impl Iterator<Item = (f64, f64)>) -> f64 {
    let (sum, count) = values.fold((0.0, 0.0), |(sum, count), (value, w)| (sum + w * value * value, count + w));
    if count == 0.0 { 0.0 } else { (sum / count).sqrt() }
}

/// Root mean square difference of two pictures of the same size, over all channels.
pub fn rms_difference(a: &[[f32; 4]], b: &[[f32; 4]]) -> f64 {
    rms(a.as_flattened().iter().zip(b.as_flattened()).map(|(a, b)| f64::from(*a) - f64::from(*b)))
}

/// Smallest value that a share of all values does not exceed; 0 without values.
pub fn quantile(mut values: Vec<f64>, share: f64) -> f64 {
    values.sort_by(f64::total_cmp);
    let rank = (share * values.len() as f64).ceil() as usize;
    values.get(rank.saturating_sub(1)).copied().unwrap_or_default()
}

/// Smallest value that at most a share `above` of the weight exceeds; 0 without values.
pub(crate) fn weighted_quantile(mut values: Vec<(f64, f64)>, above: f64) -> f64 {
    values.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut above = above * values.iter().map(|(_, weight)| weight).sum::<f64>();
    let first_below = values.iter().find(|(_, weight)| {
        above -= weight;
        above < 0.0
    });
    first_below.map_or(0.0, |(value, _)| *value)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_rounded_up_has_two_digits_and_is_never_less() {
        let all = [(2.84e-2, 2.9e-2), (2.9e-2, 2.9e-2), (9.91e-5, 1e-4), (0.1, 0.1), (3.0, 3.0), (1.01, 1.1)];
        assert!(all.iter().all(|(number, expected)| rounded_up(*number) == *expected));
        assert!(rounded_up(f64::INFINITY).is_infinite() && rounded_up(0.0) == 0.0);
    }

    #[test]
    fn a_value_that_is_no_number_is_not_passed_over() {
        assert!(largest([1.0, f64::NAN, 2.0]).is_nan() && largest([f64::NAN]).is_nan());
        assert_eq!((largest([1.0, f64::INFINITY]), largest([2.0, 1.0]), largest([])), (f64::INFINITY, 2.0, 0.0));
    }

    #[test]
    fn a_quantile_is_one_of_the_values() {
        let values: Vec<f64> = (1..=1000).rev().map(f64::from).collect();
        assert_eq!(quantile(values.clone(), 0.999), 999.0);
        assert_eq!(weighted_quantile(values.iter().map(|value| (*value, 1.0)).collect(), 1e-3), 999.0);
        assert_eq!(quantile(values, 1.0), 1000.0);
        assert_eq!((quantile(vec![3.0], 0.5), quantile(Vec::new(), 0.5)), (3.0, 0.0));
    }
}
