//! Pareto fronts of error and run time, and observed orders of convergence.

use serde::Serialize;

/// Least order between two samples of a curve that falls; below, the curve is at its floor.
const SATURATED: f64 = 0.25;
/// Two-sided 95 % quantiles of Student's t, by degrees of freedom from 1 on.
const STUDENT: [f64; 10] = [12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228];

/// Indices of the points (time, error) on the Pareto front, by rising time.
pub fn front(points: &[(f64, f64)]) -> Vec<usize> {
    let mut order: Vec<usize> = (0..points.len()).collect();
    order.sort_by(|&a, &b| points[a].0.total_cmp(&points[b].0).then(points[a].1.total_cmp(&points[b].1)));
    let mut least = f64::INFINITY;
    order.retain(|&index| {
        let better = points[index].1 < least;
        least = least.min(points[index].1);
        better
    });
    order
}

/// Index of the fastest point (time, error) within an error.
pub(crate) fn cheapest(points: &[(f64, f64)], error: f64) -> Option<usize> {
    let within = (0..points.len()).filter(|&index| points[index].1 <= error);
    within.min_by(|&a, &b| points[a].0.total_cmp(&points[b].0))
}

/// Observed order of convergence of a curve.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Order {
    /// Exponent of samples^-order, by least squares of the logarithms.
    pub order: f64,
    /// Half the width of its 95 % interval; `None` for two points, which leave no residual.
    pub plus_minus: Option<f64>,
    /// Number of fitted points, from the coarsest on.
    pub points: usize,
    /// Least error of the curve, if it is at its floor.
    pub floor: Option<f64>,
}

/// Order between two points (samples, error) of a curve.
fn gain(pair: &[(f64, f64)]) -> f64 {
    (pair[0].1 / pair[1].1).ln() / (pair[1].0 / pair[0].0).ln()
}

/// Whether a curve of (samples, error) still falls at its end.
pub(crate) fn still_falls(curve: &[(f64, f64)]) -> bool {
    curve.windows(2).next_back().is_some_and(|pair| gain(pair) >= SATURATED)
}

/// Order of the part of a curve of (samples, error) above its floor, by rising samples. `None` for fewer than two points.
pub fn order(curve: &[(f64, f64)]) -> Option<Order> {
    let falling = curve.windows(2).take_while(|pair| gain(pair) >= SATURATED).count() + 1;
    let floor = (falling < curve.len()).then(|| curve.iter().map(|point| point.1).fold(f64::INFINITY, f64::min));
    let fitted = &curve[..falling.min(curve.len())];
    if fitted.len() < 2 || fitted.iter().any(|point| point.1 <= 0.0) {
        return None;
    }
    let n = fitted.len() as f64;
    let logs: Vec<(f64, f64)> = fitted.iter().map(|(samples, error)| (samples.ln(), error.ln())).collect();
    let (mx, my) = (logs.iter().map(|p| p.0).sum::<f64>() / n, logs.iter().map(|p| p.1).sum::<f64>() / n);
    let sxx: f64 = logs.iter().map(|p| (p.0 - mx).powi(2)).sum();
    let slope = logs.iter().map(|p| (p.0 - mx) * (p.1 - my)).sum::<f64>() / sxx;
    let residual: f64 = logs.iter().map(|p| (p.1 - my - slope * (p.0 - mx)).powi(2)).sum();
    let plus_minus = (fitted.len() > 2).then(|| {
        let freedom = fitted.len() - 2;
        STUDENT[freedom.min(STUDENT.len()) - 1] * (residual / freedom as f64 / sxx).sqrt()
    });
    Some(Order { order: -slope, plus_minus, points: fitted.len(), floor })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_front_holds_the_points_that_no_other_beats() {
        let points = [(3.0, 0.1), (1.0, 1.0), (2.0, 1.0), (4.0, 0.1), (2.5, 0.2), (5.0, 0.01), (1.0, 2.0)];
        assert_eq!(front(&points), [1, 4, 0, 5]);
        assert_eq!(front(&[]), [0usize; 0]);
    }

    #[test]
    fn the_cheapest_point_is_within_the_error() {
        let points = [(3.0, 0.1), (1.0, 1.0), (5.0, 0.01)];
        assert_eq!(cheapest(&points, 0.1), Some(0));
        assert_eq!(cheapest(&points, 0.05), Some(2));
        assert_eq!(cheapest(&points, 1e-3), None);
    }

    #[test]
    fn a_power_law_has_its_exponent_without_doubt() {
        let curve: Vec<(f64, f64)> = [16.0, 32.0, 64.0, 128.0].map(|n: f64| (n, 3.0 * n.powf(-1.75))).to_vec();
        let found = order(&curve).unwrap();
        assert!((found.order - 1.75).abs() < 1e-12 && found.plus_minus.unwrap() < 1e-9, "{found:?}");
        assert_eq!((found.points, found.floor), (4, None));
    }

    #[test]
    fn scatter_widens_the_interval_as_regression_says() {
        // Residuals of +e, -2e, +e about a line at equal steps h: s^2 = 6 e^2, Sxx = 2 h^2, t(1) = 12.706.
        let (e, h) = (0.01, 2f64.ln());
        let curve: Vec<(f64, f64)> =
            [e, -2.0 * e, e].iter().zip(0..).map(|(d, i)| (2f64.powi(i), (d - f64::from(i) * h).exp())).collect();
        let found = order(&curve).unwrap();
        let expected = 12.706 * (6.0 * e * e / (2.0 * h * h)).sqrt();
        assert!((found.order - 1.0).abs() < 1e-12 && (found.plus_minus.unwrap() - expected).abs() < 1e-9);
    }

    #[test]
    fn a_floor_ends_the_fit_and_is_stated() {
        let curve = [(16.0, 0.08), (32.0, 0.04), (64.0, 0.02), (128.0, 0.0199), (256.0, 0.0198)];
        let found = order(&curve).unwrap();
        assert!((found.order - 1.0).abs() < 1e-12);
        assert_eq!((found.points, found.floor), (3, Some(0.0198)));
        assert_eq!(order(&curve[3..]), None);
        assert_eq!(order(&[]), None);
        assert!(still_falls(&curve[..3]) && !still_falls(&curve) && !still_falls(&curve[..1]));
    }
}
