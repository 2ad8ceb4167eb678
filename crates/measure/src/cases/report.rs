//! The table of a report, and its page with error against stiffness.

use super::lab::{Report, Row};
use crate::compare::report::page::page;
use serde_json::{Value, json};

const HEAD: [&str; 8] = ["case", "what", "setting", "expected", "found", "error", "bound", ""];

fn short(value: f64) -> String {
    if value == 0.0 { "0".into() } else { format!("{value:.1e}") }
}

fn cells(row: &Row) -> [String; 8] {
    let mark = if row.ok { "pass" } else { "FAIL" };
    [
        format!("{} {}", row.case, row.name),
        row.what.clone(),
        row.setting.clone(),
        row.expected.clone(),
        row.found.clone(),
        short(row.error),
        short(row.bound),
        mark.into(),
    ]
}

/// The rows as a table of text, one line for each.
pub fn table(report: &Report) -> String {
    /// Characters of the longest cell.
    const WIDEST: usize = 60;
    let lines = std::iter::once(HEAD.map(String::from)).chain(report.rows.iter().map(cells));
    let lines: Vec<_> = lines.map(|line| line.map(|cell| cell.chars().take(WIDEST).collect::<String>())).collect();
    let width = |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or_default();
    let widths: Vec<usize> = (0..HEAD.len()).map(width).collect();
    let line = |line: &[String; 8]| {
        let padded = line.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}"));
        padded.collect::<Vec<_>>().join("  ").trim_end().to_string() + "\n"
    };
    lines.iter().map(line).collect()
}

/// Rows of one case and quantity that differ in stiffness.
fn curves(report: &Report) -> Vec<Vec<&Row>> {
    let mut curves: Vec<Vec<&Row>> = Vec::new();
    for row in report.rows.iter().filter(|row| row.stiffness.is_some()) {
        match curves.iter_mut().find(|curve| curve[0].case == row.case && curve[0].what == row.what) {
            Some(curve) => curve.push(row),
            None => curves.push(vec![row]),
        }
    }
    curves.retain(|curve| curve.len() > 2);
    curves
}

/// Width and height of a chart, and the margin around its area.
const SIZE: [f64; 2] = [420.0, 220.0];
const MARGIN: [f64; 2] = [56.0, 30.0];
/// Errors below this are drawn at it.
const FLOOR: f64 = 1e-9;

/// Error and bound against stiffness, on logarithmic axes, in pixels.
fn chart(curve: &[&Row]) -> Value {
    let stiffness = |row: &Row| row.stiffness.unwrap_or(1.0).abs().max(1e-300).log10();
    let height_of = |error: f64| error.clamp(FLOOR, 10.0).log10();
    let range = |values: &mut dyn Iterator<Item = f64>| {
        values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
    };
    let [low, high] = range(&mut curve.iter().map(|row| stiffness(row)));
    let high = high.max(low + 1.0);
    let [bottom, top] = range(&mut curve.iter().flat_map(|row| [row.error, row.bound].map(height_of)));
    let (bottom, top) = (bottom.floor(), top.ceil().max(bottom.floor() + 1.0));
    let [width, height] = SIZE;
    let tenths = |pixels: f64| (10.0 * pixels).round() / 10.0;
    let x = |value: f64| tenths(MARGIN[0] + (value - low) / (high - low) * (width - MARGIN[0] - 12.0));
    let y = |value: f64| tenths(height - MARGIN[1] - (value - bottom) / (top - bottom) * (height - MARGIN[1] - 12.0));
    let point = |row: &&Row| {
        let about = format!("{}: error {}, bound {}", row.setting, short(row.error), short(row.bound));
        let [error, bound] = [row.error, row.bound].map(|value| y(height_of(value)));
        json!({ "x": x(stiffness(row)), "y": error, "bound": bound, "ok": row.ok, "about": about })
    };
    let decade = |decade: i32| json!({ "y": y(decade.into()), "label": format!("1e{decade}") });
    let end = |row: &&Row| {
        let at = x(stiffness(row));
        json!({ "x": at, "anchor": if at > 0.5 * width { "end" } else { "start" }, "label": row.setting })
    };
    let ends = [curve.first(), curve.last()].into_iter().flatten();
    json!({
        "title": format!("case {}: {}", curve[0].case, curve[0].what),
        "size": SIZE,
        "left": MARGIN[0],
        "decades": (bottom as i32..=top as i32).map(decade).collect::<Vec<_>>(),
        "ends": ends.map(end).collect::<Vec<_>>(),
        "points": curve.iter().map(point).collect::<Vec<_>>(),
    })
}

/// The page: failures, error against stiffness, and every row.
pub fn chart_page(report: &Report) -> String {
    let failed: Vec<String> = report.failed().map(Row::title).collect();
    let charts: Vec<Value> = curves(report).iter().map(|curve| chart(curve)).collect();
    let rows: Vec<[String; 8]> = report.rows.iter().map(cells).collect();
    let environment = &report.environment;
    page(
        "stress.html",
        &json!({ "failed": failed, "charts": charts, "head": HEAD, "rows": rows, "environment": environment }),
    )
}
