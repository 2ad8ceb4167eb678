//! The table of a report, and its page with error against stiffness.

use super::lab::{Report, Row};
use crate::compare::report::page::{circumstances, escape, whole};
use std::fmt::Write;

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

/// Error and bound against stiffness, on logarithmic axes.
fn chart(curve: &[&Row]) -> String {
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
    let x = |value: f64| MARGIN[0] + (value - low) / (high - low) * (width - MARGIN[0] - 12.0);
    let y = |value: f64| height - MARGIN[1] - (value - bottom) / (top - bottom) * (height - MARGIN[1] - 12.0);
    let line = |of: &dyn Fn(&Row) -> f64| {
        let points = curve.iter().map(|row| format!("{:.1},{:.1}", x(stiffness(row)), y(height_of(of(row)))));
        points.collect::<Vec<_>>().join(" ")
    };
    let mut svg =
        format!("<svg viewBox=\"0 0 {width} {height}\" width=\"{width}\" height=\"{height}\" font-size=\"11\">");
    for decade in bottom as i32..=top as i32 {
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
    for row in [curve.first(), curve.last()].into_iter().flatten() {
        let at = x(stiffness(row));
        let anchor = if at > 0.5 * width { "end" } else { "start" };
        let _ = write!(
            svg,
            "<text x=\"{at:.1}\" y=\"{}\" text-anchor=\"{anchor}\" fill=\"var(--muted)\">{}</text>",
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
    for row in curve {
        let color = if row.ok { "#4e79a7" } else { "#e15759" };
        let about = format!("{}: error {}, bound {}", row.setting, short(row.error), short(row.bound));
        let _ = write!(
            svg,
            "<circle cx=\"{:.1}\" cy=\"{:.1}\" r=\"3.5\" fill=\"{color}\"><title>{}</title></circle>",
            x(stiffness(row)),
            y(height_of(row.error)),
            escape(&about)
        );
    }
    let Row { case, what, .. } = curve[0];
    format!("<figure><figcaption>case {case}: {}</figcaption>{svg}</svg></figure>\n", escape(what))
}

/// The page: failures, error against stiffness, and every row.
pub fn chart_page(report: &Report) -> String {
    let failed: Vec<String> = report.failed().map(|row| format!("<li>{}</li>", escape(&row.title()))).collect();
    let all = report.rows.len();
    let row = |row: &Row| {
        let cells = cells(row).map(|cell| format!("<td>{}</td>", escape(&cell)));
        format!("<tr>{}</tr>\n", cells.concat().replace("<td>FAIL</td>", "<td><b>FAIL</b></td>"))
    };
    let body = format!(
        "<h1>Stress</h1>\n<p>{} of {all} rows hold.</p>\n<ul>{}</ul>\n{}\n<h2>Error against stiffness</h2>\n<p>Solid: the \
         error that is largest relative to its bound; dashed: the bound; errors of 0 are drawn at the bottom. Red: beyond \
         the bound.</p>\n<div style=\"display:flex;flex-wrap:wrap;gap:1em\">\n{}</div>\n<h2>Rows</h2>\n<table><thead>\
         <tr>{}</tr></thead><tbody>\n{}</tbody></table>\n",
        all - failed.len(),
        failed.concat(),
        circumstances(&report.environment, &[]),
        curves(report).iter().map(|curve| chart(curve)).collect::<String>(),
        HEAD.map(|head| format!("<th>{head}</th>")).concat(),
        report.rows.iter().map(row).collect::<String>(),
    );
    whole("Stress", &body)
}
