//! A table of the paper beside ours, as data.

use super::csv::Record;
use crate::compare::paper::Cell;
use crate::compare::paper::conclusions::same_picture;
use crate::compare::paper::replay::{Column, Errors, Replay, Row, Sheet};
use crate::compare::timing::Spread;
use serde_json::{Value, json};

/// State, milliseconds and frames per second of a cell.
fn parts(cell: Cell) -> (&'static str, Option<Spread>, Option<f64>) {
    match cell {
        Cell::Measured(spread) => ("measured", Some(spread), cell.rate()),
        Cell::Scaled(_) => ("scaled", None, cell.rate()),
        Cell::Failed => ("failed", None, None),
        Cell::Missing => ("missing", None, None),
    }
}

/// The errors of a row, unless they failed.
fn errors(row: &Row) -> Option<&Errors> {
    row.errors.as_ref()?.as_ref().ok()
}

/// A sheet: for each column ours and the cards that the paper has figures of, then the errors.
pub fn json(replay: &Replay, place: usize) -> Value {
    let sheet = &replay.sheets[place];
    let compared = sheet.columns.iter().any(|column| !column.discards);
    let column = |(index, column): (usize, &Column)| {
        let has = |card: &usize| sheet.rows.iter().any(|row| row.paper.get(*card).is_some_and(|p| p[index].is_some()));
        json!({
            "window": column.window,
            "pixels": replay.plan.pixels(column.window),
            "discards": column.discards,
            "cards": (0..sheet.cards.len()).filter(has).collect::<Vec<_>>(),
        })
    };
    let cell = |cell: Cell| {
        let (state, ms, fps) = parts(cell);
        json!({ "state": state, "ms": ms, "fps": fps })
    };
    let row = |row: &Row| {
        json!({
            "name": row.name,
            "cells": (0..sheet.columns.len()).map(|column| cell(replay.cell(row, column))).collect::<Vec<_>>(),
            "paper": row.paper,
            "errors": errors(row),
            "failed": matches!(row.errors, Some(Err(_))),
            "equal": same_picture(replay, row).filter(|_| compared),
        })
    };
    json!({
        "title": sheet.title,
        "cards": sheet.cards,
        "columns": sheet.columns.iter().enumerate().map(column).collect::<Vec<_>>(),
        "compared": compared,
        "rows": sheet.rows.iter().map(row).collect::<Vec<_>>(),
    })
}

/// A record for each cell of a replay.
pub fn records(replay: &Replay) -> Vec<Record> {
    let record = |place: usize, sheet: &Sheet, row: &Row, index: usize| {
        let column = sheet.columns[index];
        let ([width, height], (state, spread, fps)) =
            (replay.plan.pixels(column.window), parts(replay.cell(row, index)));
        let paper = |card: usize| row.paper.get(card).and_then(|rates| rates[index]);
        vec![
            ("table", place.into()),
            ("row", row.name.clone().into()),
            ("width", width.into()),
            ("height", height.into()),
            ("sampling", column.window.sampling.into()),
            ("reject", if column.discards { "discard" } else { "keep" }.into()),
            ("state", state.into()),
            ("fps", fps.into()),
            ("ms", fps.map(|rate| 1e3 / rate).into()),
            ("ms_low", spread.map(|spread| spread.interval[0]).into()),
            ("ms_high", spread.map(|spread| spread.interval[1]).into()),
            ("runs", spread.map(|spread| spread.runs).into()),
            ("paper_9700_pro", paper(0).into()),
            ("paper_6800_gt", paper(1).into()),
            ("rmse", errors(row).map(|errors| errors.rmse).into()),
            ("flip", errors(row).map(|errors| errors.flip).into()),
        ]
    };
    let sheets = replay.sheets.iter().enumerate();
    let rows = sheets.flat_map(|(place, sheet)| sheet.rows.iter().map(move |row| (place, sheet, row)));
    rows.flat_map(|(place, sheet, row)| (0..sheet.columns.len()).map(move |index| record(place, sheet, row, index)))
        .collect()
}
