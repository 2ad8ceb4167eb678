//! A chart of error against run time on logarithmic axes as positions in pixels, which `chart.html` draws: the curves, the
//! front and the error of the reference.

use super::data::CurveRows;
use crate::compare::digits::digits;
use crate::compare::{Comparison, Group, Row};
use hypertexture::scene::{Integration, Pass};
use serde_json::{Value, json};

/// Orders whose slopes are drawn: the time of a curve grows like its samples.
const SLOPES: [i32; 2] = [1, 2];
/// Left, top, right, bottom of the area of the points.
const AREA: [f64; 4] = [78.0, 20.0, 700.0, 500.0];
/// Half the size of a mark, which hides bars that are shorter.
const MARK: f64 = 4.0;

/// Colors of the strategies, legible on white and on black (after Tableau 10).
const COLORS: [&str; 10] =
    ["#4e79a7", "#f28e2b", "#59a14f", "#e15759", "#b07aa1", "#2fa8a0", "#c9a227", "#9c755f", "#e377a2", "#7f8790"];

/// A logarithmic axis.
struct Axis {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Axis {
    /// An axis that holds the values with a margin, from one pixel to another.
    fn over(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Axis {
        let positive = values.filter(|value| *value > 0.0 && value.is_finite());
        let (low, high) = positive.fold((f64::INFINITY, 0.0f64), |(low, high), v| (low.min(v), high.max(v)));
        let (low, high) = if low <= high { (low, high) } else { (0.1, 10.0) };
        let room = (high / low).powf(0.06).max(1.3);
        Axis { low: low / room, high: high * room, from, to }
    }

    /// The place of a value, tenths of a pixel.
    fn place(&self, value: f64) -> f64 {
        let share = (value.max(self.low) / self.low).ln() / (self.high / self.low).ln();
        (10.0 * (self.from + share.min(1.0) * (self.to - self.from))).round() / 10.0
    }

    /// Ticks, and the labels of powers of ten, and of 2 and 5 of them where there are few.
    fn ticks(&self) -> Vec<(f64, Option<String>)> {
        let decades = self.low.log10().floor() as i32..=self.high.log10().ceil() as i32;
        let few = (self.high / self.low).log10() < 3.0;
        let all = decades.flat_map(|decade| (1..10).map(move |digit| (digit, f64::from(digit) * 10f64.powi(decade))));
        let inside = all.filter(|(_, value)| (self.low..=self.high).contains(value));
        let labeled = |digit| digit == 1 || few && (digit == 2 || digit == 5);
        inside.map(|(digit, value)| (self.place(value), labeled(digit).then(|| digits(value, 1)))).collect()
    }
}

/// A chart for each truth, with a line for each curve.
pub(crate) fn charts(comparison: &Comparison, curves: &[CurveRows]) -> Vec<Value> {
    let groups = comparison.groups();
    groups.iter().enumerate().map(|(number, group)| chart(comparison, number, group, curves)).collect()
}

fn chart(comparison: &Comparison, number: usize, group: &Group, curves: &[CurveRows]) -> Value {
    let [left, top, right, bottom] = AREA;
    let rows = || group.rows.iter().map(|&index| &comparison.rows[index]);
    let errors = || rows().map(|row| row.point().1);
    let x = Axis::over(
        rows().map(Row::time).flat_map(|time| [time.interval[0], time.median, time.interval[1]]),
        left,
        right,
    );
    // A floor far below would leave the points no room: it is then named at the lower edge.
    let floor = group.truth.error();
    let near = 30.0 * floor >= errors().fold(f64::INFINITY, f64::min);
    let y = Axis::over(errors().chain(near.then_some(floor)), bottom, top);
    let mut strategies: Vec<&str> = Vec::new();
    let mut lines = Vec::new();
    for (curve, indices, _) in curves.iter().filter(|(_, indices, _)| group.rows.contains(&indices[0])) {
        if !strategies.contains(&curve.strategy.as_str()) {
            strategies.push(&curve.strategy);
        }
        let color = strategies.iter().position(|name| *name == curve.strategy).unwrap_or_default();
        lines.push(json!({
            "color": COLORS[color % COLORS.len()],
            "round": curve.pass == Pass::March,
            "filled": curve.integration == Integration::Segment,
            "faint": comparison.rows[indices[0]].candidate.aside,
            "points": indices.iter().map(|&index| point(&comparison.rows[index], &x, &y)).collect::<Vec<_>>(),
        }));
    }
    let tick = |(at, label): (f64, Option<String>)| json!({ "at": at, "label": label });
    let ticks = |axis: &Axis| axis.ticks().into_iter().map(tick).collect::<Vec<_>>();
    let place = |&index: &usize| {
        let (time, error) = comparison.rows[index].point();
        [x.place(time), y.place(error)]
    };
    let below = if near { "" } else { ", below" };
    let floor = (floor > 0.0).then(|| json!({ "at": y.place(floor), "label": digits(floor, 1) + below }));
    json!({
        "title": format!("Truth {number}: {}", group.truth.pattern),
        "clock": comparison.clock(),
        "area": AREA,
        "x": ticks(&x),
        "y": ticks(&y),
        "floor": floor,
        "slopes": SLOPES.map(|order| slope(order, &x, &y)),
        "legend": legend(&strategies, &lines, group),
        "front": group.front.iter().map(place).collect::<Vec<_>>(),
        "lines": lines,
    })
}

/// A point, with the interval of its time and the doubt about its error where they reach beyond the mark.
fn point(row: &Row, x: &Axis, y: &Axis) -> Value {
    let ((time, error), doubt) = (row.point(), row.truth.error());
    let (px, py) = (x.place(time), y.place(error));
    let beyond = |ends: [f64; 2], at: f64| ends.iter().any(|end| (end - at).abs() > MARK).then_some(ends);
    json!({
        "x": px,
        "y": py,
        "times": beyond(row.time().interval.map(|time| x.place(time)), px),
        "errors": beyond([error - doubt, error + doubt].map(|error| y.place(error)), py),
        "about": format!("{}: error {error:.2e} in {time:.3} ms", row.candidate.label()),
    })
}

/// A line along which the error falls like time^-`order`, from the upper left of the area to its edge.
fn slope(order: i32, x: &Axis, y: &Axis) -> Value {
    let time = (x.low * (y.high / y.low).powf(1.0 / f64::from(order))).min(x.high);
    let from = [x.place(x.low), y.place(y.high)];
    let to = [x.place(time), y.place(y.high * (time / x.low).powi(-order))];
    // Above the foot of the area, where the error of the reference is named.
    let label = [0, 1].map(|axis| from[axis] + 0.85 * (to[axis] - from[axis]));
    json!({ "order": order, "from": from, "to": to, "label": label })
}

/// The names of the strategies with their colors, and the meaning of the marks.
fn legend(strategies: &[&str], lines: &[Value], group: &Group) -> Vec<Value> {
    let named =
        strategies.iter().zip(COLORS.iter().cycle()).map(|(text, color)| json!({ "text": text, "color": color }));
    let mark = |text: &str, round: bool, filled: bool, faint: bool| json!({ "text": text, "color": "var(--muted)", "round": round, "filled": filled, "faint": faint });
    let marks = [
        ("rays, segments", true, true),
        ("rays, points", true, false),
        ("slices, segments", false, true),
        ("slices, points", false, false),
    ];
    let has = |(_, round, filled): &(&str, bool, bool)| {
        lines.iter().any(|line| line["round"] == *round && line["filled"] == *filled)
    };
    let marks = marks.into_iter().filter(has).map(|(text, round, filled)| mark(text, round, filled, false));
    let faint = lines.iter().any(|line| line["faint"] == true);
    let faint = faint.then(|| mark("other targets and blocks", false, false, true));
    let front = (!group.front.is_empty()).then(|| json!({ "text": "Pareto front", "front": true }));
    named.chain(marks).chain(faint).chain(front).collect()
}

#[cfg(test)]
mod tests {
    use super::super::{data::curves, examples, page::page};
    use super::*;

    #[test]
    fn an_axis_is_logarithmic_and_its_ends_have_room() {
        let axis = Axis::over([1.0, 100.0, 0.0, f64::INFINITY].into_iter(), 0.0, 100.0);
        assert!((axis.place(10.0) - 50.0).abs() < 1e-9);
        assert!(axis.place(1.0) > 0.0 && axis.place(100.0) < 100.0);
        assert_eq!(axis.place(1e-9), 0.0, "what lies below the axis is drawn on it");
        let labels: Vec<String> = axis.ticks().into_iter().filter_map(|tick| tick.1).collect();
        assert_eq!(labels, ["1", "2", "5", "10", "20", "50", "100"]);
    }

    #[test]
    fn slopes_fall_as_their_order_says_and_stay_in_the_area() {
        // Two decades of time over 200 pixels, four of error over 400: order 2 ends in the corner, order 1 half way down.
        let x = Axis { low: 1.0, high: 100.0, from: 0.0, to: 200.0 };
        let y = Axis { low: 1e-4, high: 1.0, from: 400.0, to: 0.0 };
        for (order, end) in [(1, [200.0, 200.0]), (2, [200.0, 400.0]), (4, [100.0, 400.0])] {
            assert_eq!((&slope(order, &x, &y)["from"], &slope(order, &x, &y)["to"]), (&json!([0.0, 0.0]), &json!(end)));
        }
    }

    #[test]
    fn error_bars_span_their_interval_and_hide_behind_marks() {
        let mut row = examples::report().comparison.rows[0].clone();
        let ((time, error), doubt) = (row.point(), row.truth.error());
        let [x, y] = [(time, 1.0 + 1e-3), (error, 1.0 + 1e-9)].map(|(value, factor)| Axis {
            low: value / 4.0,
            high: value * 4.0,
            from: 0.0,
            to: 100.0 * factor,
        });
        assert!(doubt < 1e-3 * error);
        assert!(["times", "errors"].iter().all(|bar| point(&row, &x, &y)[bar].is_null()));
        row.runs[0].gpu_ms *= 0.5;
        row.runs.truncate(2);
        assert!(point(&row, &x, &y)["times"][0].as_f64() < point(&row, &x, &y)["x"].as_f64());
    }

    #[test]
    fn charts_hold_every_point_with_its_words_and_close_every_tag() {
        let comparison = examples::report().comparison;
        let file =
            page("chart.html", &json!({ "titled": true, "charts": charts(&comparison, &curves(&comparison.rows)) }));
        for row in &comparison.rows {
            assert!(file.contains(&format!("<title>{}: error", row.candidate.label())), "{file}");
        }
        let parts = [
            "time on the device, ms",
            ">order 1<",
            ">order 2<",
            "encoded",
            "slices, points",
            ": 10⁻⁷, below",
            "Pareto front",
        ];
        assert!(parts.iter().all(|part| file.contains(part)), "{file}");
        assert!(
            file.starts_with("<svg") && file.contains("--paper:#fff") && file.contains("viewBox=\"0 0 960 1192\""),
            "{file}"
        );
        for tag in ["svg", "g", "circle", "rect", "text", "title"] {
            let starts = file.matches(&format!("<{tag} ")).count() + file.matches(&format!("<{tag}>")).count();
            let closed = file.matches(&format!("</{tag}>")).count();
            assert!(
                starts >= closed && closed > 0 && (starts == closed || tag == "circle"),
                "{tag}: {starts} {closed}"
            );
        }
    }
}
