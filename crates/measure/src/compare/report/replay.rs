//! The paper's tables beside ours: a page, Markdown, CSV and JSON.
//!
//! Invariant: files are written whole, and no text in them names a folder of this machine.

use super::page::page;
use super::{Environment, csv, images, sheet, write_all};
use crate::compare::paper::conclusions::conclusions;
use crate::compare::paper::numbers::SOFTWARE_SECONDS;
use crate::compare::paper::replay::{Bump, Replay};
use crate::compare::{BACKGROUND, CompareError};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// All that the report tells.
#[derive(Clone, Debug)]
pub struct Replayed {
    /// The object.
    pub object: String,
    /// Where and when.
    pub environment: Environment,
    /// The replay.
    pub replay: Replay,
}

/// Writes the report into a folder, which is created if necessary; gives the path of the page.
///
/// # Errors
/// Errors of the file system; a file is whole or unchanged.
pub fn write(report: &Replayed, folder: &Path) -> Result<PathBuf, CompareError> {
    let json = json(report);
    let files = [
        ("paper.html", html(report, &json)),
        ("paper.md", markdown(&json)),
        ("paper.csv", csv::csv(&sheet::records(&report.replay))),
        ("paper.json", format!("{json:#}\n")),
    ];
    write_all(&files, folder)
}

/// The tables as lines of a terminal.
pub fn text(report: &Replayed) -> String {
    markdown(&json(report))
}

/// The tables as Markdown, their columns aligned.
fn markdown(json: &Value) -> String {
    let text = page("paper.md", json);
    let lines: Vec<&str> = text.lines().collect();
    let parts = lines.chunk_by(|a, b| a.starts_with('|') == b.starts_with('|'));
    parts.map(|part| if part[0].starts_with('|') { aligned(part) } else { part.join("\n") + "\n" }).collect()
}

/// The lines of a table, its columns aligned, with a rule below the first.
fn aligned(table: &[&str]) -> String {
    let cells = |line: &&str| line.split('|').skip(1).map(|cell| cell.trim().to_string()).collect();
    let rows: Vec<Vec<String>> = table.iter().map(cells).collect();
    let width = |column: usize| rows.iter().map(|row| row[column].chars().count()).max().unwrap_or(0);
    let cell = |(column, cell): (usize, &String)| match (column, width(column)) {
        (0, width) => format!("| {cell:width$} "),
        (_, width) => format!("| {cell:>width$} "),
    };
    let mut lines: Vec<String> = rows.iter().map(|row| row.iter().enumerate().map(cell).collect()).collect();
    let rule = |column: usize| format!("|{:->1$}", if column == 0 { "-" } else { ":" }, width(column) + 2);
    lines.insert(1, (0..rows[0].len()).map(rule).collect());
    lines.join("|\n") + "|\n"
}

fn html(report: &Replayed, json: &Value) -> String {
    let replay = &report.replay;
    let background = replay.plan.effects[0].image.background.unwrap_or(BACKGROUND);
    let bump = |bump: &Bump| json!({ "k": bump.k.to_string(), "angle": bump.angle, "picture": images::picture(&bump.frame, background) });
    let mut context = json.clone();
    context["bumps"] = replay.bumps.iter().map(bump).collect();
    page("paper.html", &context)
}

/// The report but for its pictures.
fn json(report: &Replayed) -> Value {
    let replay = &report.replay;
    let quality = &replay.plan.effects[0].quality;
    let bump = |bump: &Bump| json!({ "k": bump.k, "mean_angle_deg": bump.angle });
    json!({
        "object": report.object,
        "slices": quality.samples,
        "target": quality.target,
        "proxy": quality.proxy,
        "scale": replay.plan.scale,
        "error_size": replay.plan.error_size,
        "sampling": replay.sampling,
        "smoothest": replay.sampling.of(8),
        "software_seconds": SOFTWARE_SECONDS,
        "sheets": (0..replay.sheets.len()).map(|place| sheet::json(replay, place)).collect::<Vec<_>>(),
        "bump_scale": replay.bumps.iter().map(bump).collect::<Vec<_>>(),
        "conclusions": conclusions(replay),
        "failures": replay.failures(),
        "partial": replay.partial,
        "environment": report.environment,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::paper::Cell;
    use crate::compare::paper::example::example;

    fn report() -> Replayed {
        let environment = Environment { device: "a <device>".into(), ..Environment::default() };
        Replayed { object: "teapot".into(), environment, replay: example() }
    }

    /// The cells of the first line of the Markdown that starts with a name, behind a heading.
    fn cells(text: &str, heading: &str, name: &str) -> String {
        let mut lines = text.lines().skip_while(|line| !line.contains(heading));
        let line = lines.find(|line| line.starts_with(&format!("| {name}"))).unwrap();
        line.split('|').map(str::trim).collect::<Vec<_>>().join("|")
    }

    #[test]
    fn m54_m55_m56_m57_windows_show_ours_and_the_cards() {
        let text = text(&report());
        let heads = "|300×300 0x|9700 Pro|6800 GT|300×300 8x|9700 Pro|6800 GT|1024×768 0x|9700 Pro|6800 GT|1024×768 8x|9700 Pro|6800 GT|RMSE|FLIP|";
        assert_eq!(cells(&text, "Tables 1 and 2", " "), format!("|{heads}"));
        let fur = "|Fur|1.71 [1.71, 1.71]|17.10|39.52|1.42 [1.42, 1.42]|14.17|24.32|0.343 [0.343, 0.343]|3.43|9.88|0.327 [0.327, 0.327]|3.27|5.43|0.0100|0.0200|";
        assert_eq!(cells(&text, "Tables 1 and 2", "Fur"), fur);
        // The windows of 4x have no figure of the paper.
        let lookups = "|8 noise lookups|0.245 [0.245, 0.245]|2.45|≈0.100|0.189 [0.189, 0.189]|1.89|";
        assert!(cells(&text, "Table 3", "8 noise").starts_with(lookups), "{text}");
        let table: Vec<&str> = text.lines().filter(|line| line.starts_with('|')).take(8).collect();
        assert!(table.iter().all(|line| line.chars().count() == table[0].chars().count()), "{text}");
    }

    #[test]
    fn a_failure_and_an_interruption_stand_at_the_top_of_the_page() {
        let page = |report: &Replayed| html(report, &json(report));
        let good = page(&report());
        assert!(!good.contains("FAILED") && !good.contains("Partial") && good.contains("a &lt;device&gt;"));
        assert_eq!(good.matches("<table").count(), 5);
        assert!(["<script", "href=", "src=\"http", "{{", "{%"].iter().all(|part| !good.contains(part)));
        let mut report = report();
        (report.replay.shots[0].cell, report.replay.shots[0].message) =
            (Cell::Failed, Some("Lit: a <b> too many".into()));
        report.replay.partial = true;
        let bad = page(&report);
        let place = |what: &str| bad.find(what).unwrap();
        assert!(place("FAILED") < place("Conclusions") && place("Partial") < place("Conclusions"));
        assert!(bad.contains("a &lt;b&gt; too many") && text(&report).contains("failed"));
    }
}
