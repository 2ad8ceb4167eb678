//! The paper's tables beside ours: as text, CSV, JSON, Markdown and a page.
//!
//! Invariant: files are written whole, and no text in them names a folder of this machine.

pub use super::replay_grid::Replayed;

use super::replay_grid::{about, grid};
use super::replay_html;
use crate::compare::CompareError;
use crate::compare::paper::Cell;
use crate::compare::paper::conclusions::{conclusions, same_picture};
use crate::compare::paper::numbers::SOFTWARE_SECONDS;
use crate::compare::paper::replay::{Row, Sheet};
use hypertexture::output::OutputError;
use serde_json::{Value, json};
use std::fmt::Write;
use std::path::{Path, PathBuf};
use support::write_whole;

/// Files of the report.
pub const FILES: [&str; 4] = ["paper.html", "paper.md", "paper.csv", "paper.json"];

/// Writes the report into a folder, which is created if necessary; gives the path of the page.
///
/// # Errors
/// Errors of the file system; a file is whole or unchanged.
pub fn write(report: &Replayed, folder: &Path) -> Result<PathBuf, CompareError> {
    let io = |path: &Path| {
        let path = path.display().to_string();
        move |source| CompareError::Output(OutputError::Write { path, source })
    };
    std::fs::create_dir_all(folder).map_err(io(folder))?;
    let contents = [replay_html::page(report), markdown(report), csv(report), json(report)];
    for (name, content) in FILES.into_iter().zip(contents).rev() {
        let path = folder.join(name);
        write_whole(&path, content.as_bytes()).map_err(io(&path))?;
    }
    Ok(folder.join(FILES[0]))
}

/// The tables as lines of a terminal.
pub fn text(report: &Replayed) -> String {
    let mut text = format!("{}\n", about(report));
    for (place, sheet) in report.replay.sheets.iter().enumerate() {
        let grid = grid(&report.replay, place, false);
        let all = || [&grid.head].into_iter().chain(&grid.rows);
        let width = |column: usize| all().map(|row| row[column].chars().count()).max().unwrap_or(0);
        let widths: Vec<usize> = (0..grid.head.len()).map(width).collect();
        write!(text, "\n{}, frames per second\n", sheet.title).expect("writing to a string");
        for row in all() {
            let cells = row[1..].iter().zip(&widths[1..]).map(|(cell, &width)| format!("  {cell:>width$}"));
            let name = format!("{:width$}", row[0], width = widths[0]);
            text += (name + &cells.collect::<String>()).trim_end();
            text += "\n";
        }
    }
    for sentence in conclusions(&report.replay) {
        write!(text, "\n{sentence}\n").expect("writing to a string");
    }
    text + "\n"
}

fn markdown(report: &Replayed) -> String {
    let mut text = format!("# The paper's tables beside ours\n\n{}\n", about(report));
    for (place, sheet) in report.replay.sheets.iter().enumerate() {
        let grid = grid(&report.replay, place, true);
        let rule = format!("|---|{}", "---:|".repeat(grid.head.len() - 1));
        write!(text, "\n## {}\n\nFrames per second.\n\n", sheet.title).expect("writing to a string");
        writeln!(text, "| {} |\n{rule}", grid.head.join(" | ")).expect("writing to a string");
        for row in &grid.rows {
            writeln!(text, "| {} |", row.join(" | ")).expect("writing to a string");
        }
    }
    text += "\n## Conclusions\n\n";
    for sentence in conclusions(&report.replay) {
        writeln!(text, "- {sentence}").expect("writing to a string");
    }
    text
}

/// How a cell came to be.
fn state(cell: Cell) -> &'static str {
    match cell {
        Cell::Measured(_) => "measured",
        Cell::Scaled(_) => "scaled",
        Cell::Failed => "failed",
        Cell::Missing => "missing",
    }
}

/// One row for each cell.
fn csv(report: &Replayed) -> String {
    let mut text = String::from(
        "table,row,width,height,sampling,reject,state,fps,ms,ms_low,ms_high,runs,paper_9700_pro,paper_6800_gt,rmse,flip\n",
    );
    let replay = &report.replay;
    let number = |value: Option<f64>| value.map_or(String::new(), |value| format!("{value}"));
    for (place, sheet) in replay.sheets.iter().enumerate() {
        for (row, (index, column)) in
            sheet.rows.iter().flat_map(|row| sheet.columns.iter().enumerate().map(move |column| (row, column)))
        {
            let cell = replay.cell(row, index);
            let [width, height] = replay.plan.pixels(column.window);
            let spread = if let Cell::Measured(spread) = cell { Some(spread) } else { None };
            let paper = |card: usize| number(row.paper.get(card).and_then(|rates| rates[index]));
            let errors = row.errors.as_ref().and_then(|errors| errors.as_ref().ok());
            let cells = [
                place.to_string(),
                row.name.clone(),
                width.to_string(),
                height.to_string(),
                column.window.sampling.to_string(),
                if !column.discards { "keep" } else { "discard" }.into(),
                state(cell).into(),
                number(cell.rate()),
                number(cell.rate().map(|rate| 1e3 / rate)),
                number(spread.map(|spread| spread.interval[0])),
                number(spread.map(|spread| spread.interval[1])),
                spread.map_or(String::new(), |spread| spread.runs.to_string()),
                paper(0),
                paper(1),
                number(errors.map(|errors| errors.rmse)),
                number(errors.map(|errors| errors.flip)),
            ];
            writeln!(text, "{}", cells.join(",")).expect("writing to a string");
        }
    }
    text
}

fn json(report: &Replayed) -> String {
    let replay = &report.replay;
    let cell = |cell: Cell| match cell {
        Cell::Measured(ms) => json!({ "state": state(cell), "fps": cell.rate(), "ms": ms }),
        _ => json!({ "state": state(cell), "fps": cell.rate() }),
    };
    let row = |sheet: &Sheet, row: &Row| {
        let cells: Vec<Value> = (0..sheet.columns.len()).map(|column| cell(replay.cell(row, column))).collect();
        let errors = row.errors.as_ref().and_then(|errors| errors.as_ref().ok());
        json!({ "name": row.name, "cells": cells, "paper": row.paper, "errors": errors, "equal": same_picture(replay, row) })
    };
    let sheets: Vec<Value> = replay
        .sheets
        .iter()
        .map(|sheet| {
            let rows: Vec<Value> = sheet.rows.iter().map(|one| row(sheet, one)).collect();
            json!({ "title": sheet.title, "cards": sheet.cards, "columns": sheet.columns, "rows": rows })
        })
        .collect();
    let bumps: Vec<Value> =
        replay.bumps.iter().map(|bump| json!({ "k": bump.k, "mean_angle_deg": bump.angle })).collect();
    let quality = &replay.plan.effects[0].quality;
    let value = json!({
        "object": report.object,
        "about": about(report),
        "slices": quality.samples,
        "scale": replay.plan.scale,
        "error_size": replay.plan.error_size,
        "sampling": replay.sampling,
        "software_seconds": SOFTWARE_SECONDS,
        "sheets": sheets,
        "bump_scale": bumps,
        "conclusions": conclusions(replay),
        "failures": replay.failures(),
        "partial": replay.partial,
        "environment": report.environment,
    });
    format!("{value:#}\n")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::paper::example::example;
    use crate::compare::paper::replay::{EFFECTS_SHEET, TURBULENCE_SHEET};
    use crate::compare::report::Environment;

    fn report() -> Replayed {
        let environment = Environment { device: "a <device>".into(), ..Environment::default() };
        Replayed { object: "teapot".into(), environment, replay: example() }
    }

    #[test]
    fn m54_m55_each_window_has_ours_and_both_cards_and_each_row_its_error() {
        let grid = grid(&report().replay, EFFECTS_SHEET, false);
        let heads =
            ["300×300 0x", "300×300 8x", "1024×768 0x", "1024×768 8x"].map(|ours| [ours, "9700 Pro", "6800 GT"]);
        let expected = [&[""][..], heads.as_flattened(), &["RMSE", "FLIP"]].concat();
        assert_eq!(grid.head, expected);
        let fur = "Fur|1.71|17.10|39.52|1.42|14.17|24.32|0.343|3.43|9.88|0.327|3.27|5.43|0.0100|0.0200";
        assert_eq!(grid.rows[3].join("|"), fur);
    }

    #[test]
    fn m56_m57_the_windows_of_4x_have_no_figure_of_the_paper() {
        let grid = grid(&report().replay, TURBULENCE_SHEET, false);
        assert_eq!(grid.head[3..6], ["300×300 4x", "300×300 8x", "9700 Pro"]);
        assert_eq!(grid.rows[0][..6], ["8 noise lookups", "0.245", "2.45", "≈0.100", "0.189", "1.89"]);
    }

    #[test]
    fn a_failure_and_an_interruption_stand_at_the_top_of_the_page() {
        let good = replay_html::page(&report());
        assert!(!good.contains("FAILED") && !good.contains("Partial") && good.contains("a &lt;device&gt;"));
        assert_eq!(good.matches("<table").count(), 4);
        for part in ["<script", "href=", "src=\"http", "{title}", "{body}"] {
            assert!(!good.contains(part), "{part}");
        }
        let mut report = report();
        (report.replay.shots[0].cell, report.replay.shots[0].message) =
            (Cell::Failed, Some("Lit: a <b> too many".into()));
        report.replay.partial = true;
        let bad = replay_html::page(&report);
        let place = |what: &str| bad.find(what).unwrap();
        assert!(place("FAILED") < place("Conclusions") && place("Partial") < place("Conclusions"));
        assert!(bad.contains("a &lt;b&gt; too many") && text(&report).contains("failed"));
    }
}
