//! The table of a stress, and its page with error against stiffness.

use super::{Row, Stress};
use crate::compare::report::page::{circumstances, escape, whole};
use std::fmt::Write;

/// A number of a row: as many digits as tell something.
pub(super) fn number(value: f64) -> String {
    match value.abs() {
        0.0 => "0".into(),
        1e-3..1e4 => {
            let text = format!("{value:.6}");
            text.trim_end_matches('0').trim_end_matches('.').to_string()
        }
        _ => format!("{value:.3e}"),
    }
}

fn short(value: f64) -> String {
    if value == 0.0 { "0".into() } else { format!("{value:.1e}") }
}

/// At most so many characters of what a cell says.
fn cut(text: &str, most: usize) -> String {
    match text.chars().count() > most {
        true => text.chars().take(most - 1).chain(['…']).collect(),
        false => text.into(),
    }
}

/// The rows as a table of text, one line for each.
pub fn table(stress: &Stress) -> String {
    let head = ["case", "what", "setting", "expected", "found", "error", "bound", ""].map(String::from);
    let cells = |row: &Row| {
        [
            row.case.to_string(),
            row.what.clone(),
            row.setting.clone(),
            row.expected.clone(),
            cut(&row.found, 60),
            short(row.error),
            short(row.bound),
            if row.ok() { "pass".into() } else { "FAIL".into() },
        ]
    };
    let lines: Vec<[String; 8]> = std::iter::once(head).chain(stress.rows.iter().map(cells)).collect();
    let width = |column: usize| lines.iter().map(|line| line[column].chars().count()).max().unwrap_or_default();
    let widths: Vec<usize> = (0..8).map(width).collect();
    let mut text = String::new();
    for line in &lines {
        let padded = line.iter().zip(&widths).map(|(cell, width)| format!("{cell:<width$}"));
        let _ = writeln!(text, "{}", padded.collect::<Vec<_>>().join("  ").trim_end());
    }
    text
}

/// Rows of one case and kind that make a curve.
struct CurveOf<'a> {
    case: u32,
    what: &'a str,
    rows: Vec<&'a Row>,
}

fn curves(stress: &Stress) -> Vec<CurveOf<'_>> {
    let mut curves: Vec<CurveOf<'_>> = Vec::new();
    for row in stress.rows.iter().filter(|row| row.stiffness.is_some()) {
        match curves.iter_mut().find(|curve| curve.case == row.case && curve.what == row.what) {
            Some(curve) => curve.rows.push(row),
            None => curves.push(CurveOf { case: row.case, what: &row.what, rows: vec![row] }),
        }
    }
    curves.retain(|curve| curve.rows.len() > 2);
    curves
}

/// Width and height of a chart, and of the margin around its area.
const SIZE: [f64; 2] = [420.0, 220.0];
const MARGIN: [f64; 2] = [56.0, 30.0];
/// An error of 0 stands here.
const FLOOR: f64 = 1e-9;

/// Error and bound against stiffness, on logarithmic axes.
fn chart(curve: &CurveOf<'_>) -> String {
    let stiffness = |row: &Row| row.stiffness.unwrap_or(1.0).abs().max(1e-300).log10();
    let held = |error: f64| error.clamp(FLOOR, 10.0).log10();
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    let mut deep = [f64::INFINITY, f64::NEG_INFINITY];
    for row in &curve.rows {
        (low, high) = (low.min(stiffness(row)), high.max(stiffness(row)));
        for value in [row.error, row.bound] {
            deep = [deep[0].min(held(value)), deep[1].max(held(value))];
        }
    }
    let (low, high) = (low, high.max(low + 1.0));
    let deep = [deep[0].floor(), deep[1].ceil().max(deep[0].floor() + 1.0)];
    let [width, height] = SIZE;
    let x = |value: f64| MARGIN[0] + (value - low) / (high - low) * (width - MARGIN[0] - 12.0);
    let y = |value: f64| height - MARGIN[1] - (value - deep[0]) / (deep[1] - deep[0]) * (height - MARGIN[1] - 12.0);
    let line = |of: &dyn Fn(&Row) -> f64| {
        let points = curve.rows.iter().map(|row| format!("{:.1},{:.1}", x(stiffness(row)), y(held(of(row)))));
        points.collect::<Vec<_>>().join(" ")
    };
    let mut svg =
        format!("<svg viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" font-size=\"11\">");
    for decade in deep[0] as i32..=deep[1] as i32 {
        let at = y(decade.into());
        let _ = write!(
            svg,
            "<line x1=\"{}\" x2=\"{}\" y1=\"{at:.1}\" y2=\"{at:.1}\" stroke=\"var(--integration)\"/><text x=\"{}\" y=\"{:.1}\" \
             text-anchor=\"end\" fill=\"var(--muted)\">1e{decade}</text>",
            MARGIN[0],
            width - 12.0,
            MARGIN[0] - 6.0,
            at + 4.0
        );
    }
    for row in [curve.rows.first(), curve.rows.last()].into_iter().flatten() {
        let anchor = if x(stiffness(row)) > 0.5 * width { "end" } else { "start" };
        let _ = write!(
            svg,
            "<text x=\"{:.1}\" y=\"{}\" text-anchor=\"{anchor}\" fill=\"var(--muted)\">{}</text>",
            x(stiffness(row)),
            height - 10.0,
            escape(&row.setting)
        );
    }
    let _ = write!(
        svg,
        "<polyline points=\"{}\" fill=\"none\" stroke=\"var(--muted)\" stroke-dasharray=\"4 3\"/><polyline points=\"{}\" \
         fill=\"none\" stroke=\"#4e79a7\" stroke-width=\"2\"/>",
        line(&|row| row.bound),
        line(&|row| row.error)
    );
    for row in &curve.rows {
        let color = if row.ok() { "#4e79a7" } else { "#e15759" };
        let about = format!("{}: error {}, bound {}", row.setting, short(row.error), short(row.bound));
        let _ = write!(
            svg,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3.5\" fill=\"{color}\"><title>{}</title></circle>",
            x(stiffness(row)),
            y(held(row.error)),
            escape(&about)
        );
    }
    format!("<figure><figcaption>case {}: {}</figcaption>{svg}</svg></figure>\n", curve.case, escape(curve.what))
}

/// The page: what failed, error against stiffness, and every row.
pub fn chart_page(stress: &Stress) -> String {
    let failed: Vec<String> = stress.failed().map(|row| format!("<li>{}</li>", escape(&row.title()))).collect();
    let count = stress.rows.len() - failed.len();
    let mut body = format!(
        "<h1>Stress</h1>\n<p>{count} of {} rows hold.</p>\n<ul>{}</ul>\n{}\n<h2>Error against stiffness</h2>\n<p>Solid: the \
         largest error, for what it may be; dashed: what it may be; an error of 0 stands at the bottom. Red: beyond its \
         bound.</p>\n<div style=\"display:flex;flex-wrap:wrap;gap:1em\">\n",
        stress.rows.len(),
        failed.concat(),
        circumstances(&stress.environment, &[])
    );
    body.extend(curves(stress).iter().map(chart));
    body.push_str(
        "</div>\n<h2>Rows</h2>\n<table><thead><tr><th>case</th><th>what</th><th>setting</th><th>expected</th><th>found</th>\
         <th>error</th><th>bound</th><th></th></tr></thead><tbody>\n",
    );
    for row in &stress.rows {
        let cells = [
            row.case.to_string(),
            row.what.clone(),
            row.setting.clone(),
            row.expected.clone(),
            row.found.clone(),
            short(row.error),
            short(row.bound),
            if row.ok() { "pass".into() } else { "<b>FAIL</b>".into() },
        ];
        let last = cells.len() - 1;
        let cells = cells
            .iter()
            .enumerate()
            .map(|(at, cell)| format!("<td>{}</td>", if at == last { cell.clone() } else { escape(cell) }));
        let _ = writeln!(body, "<tr>{}</tr>", cells.collect::<String>());
    }
    body.push_str("</tbody></table>\n");
    whole("Stress", &body)
}
