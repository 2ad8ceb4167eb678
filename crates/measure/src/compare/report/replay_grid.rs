//! Tables of a replay as text, shared by all files of the report.

use super::Environment;
use crate::compare::paper::Cell;
use crate::compare::paper::conclusions::{digits, same_picture};
use crate::compare::paper::replay::{Column, DISCARD_SHEET, Errors, Replay, Row, Sheet};
use hypertexture::scene::{Proxy, TargetFormat};

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

/// Description of the replay in one sentence.
pub fn about(report: &Replayed) -> String {
    let quality = &report.replay.plan.effects[0].quality;
    let target = match quality.target {
        TargetFormat::Unorm8 => "8 bits",
        TargetFormat::Float16 => "16-bit floats",
        TargetFormat::Float32 => "32-bit floats",
    };
    let proxy = match quality.proxy {
        Proxy::Quads => "quads that fit every rotation",
        Proxy::Polygons => "polygons cut to the box of the object",
    };
    let (samples, anisotropy) = report.replay.sampling.of(8);
    let [width, height] = report.replay.plan.error_size;
    format!(
        "{} slices through {}, {proxy}, blended in {target}, on {}; 8x is {samples} samples a pixel and anisotropy {anisotropy}. The \
         errors are those of the slices without smoothing at {width} x {height}, against the f64 reference. The paper names \
         neither its object nor its slices.",
        quality.samples, report.object, report.environment.device,
    )
}

/// A table of texts, with a heading for each column.
pub struct Grid {
    /// The headings.
    pub head: Vec<String>,
    /// The rows; the first text is the name.
    pub rows: Vec<Vec<String>>,
}

/// A sheet as texts: for each column ours and the paper's, then the errors. With `spread`, the interval of each median.
pub fn grid(replay: &Replay, place: usize, spread: bool) -> Grid {
    let sheet = &replay.sheets[place];
    let mut head = vec![String::new()];
    for (index, column) in sheet.columns.iter().enumerate() {
        head.push(heading(replay, sheet, column));
        head.extend(printed(sheet, index).map(|card| sheet.cards[card].to_string()));
    }
    head.extend(["RMSE", "FLIP"].map(String::from));
    let compared = place == DISCARD_SHEET;
    if compared {
        head.push("pictures".into());
    }
    let line = |row: &Row| {
        let mut line = vec![row.name.clone()];
        for index in 0..sheet.columns.len() {
            line.push(rate(replay.cell(row, index), spread));
            let paper = |card: usize| row.paper[card][index].map_or("–".into(), |rate| format!("{rate:.2}"));
            line.extend(printed(sheet, index).map(paper));
        }
        let error = |of: fn(&Errors) -> f64| match &row.errors {
            Some(Ok(errors)) => digits(of(errors)),
            Some(Err(_)) => "failed".into(),
            None => "–".into(),
        };
        line.extend([error(|errors| errors.rmse), error(|errors| errors.flip)]);
        if compared {
            let same = same_picture(replay, row).map_or("–", |same| if same { "equal" } else { "DIFFERENT" });
            line.push(same.into());
        }
        line
    };
    Grid { head, rows: sheet.rows.iter().map(line).collect() }
}

/// The cards of a sheet that the paper has a figure of in a column.
fn printed(sheet: &Sheet, column: usize) -> impl Iterator<Item = usize> + '_ {
    let has =
        move |card: &usize| sheet.rows.iter().any(|row| row.paper.get(*card).is_some_and(|p| p[column].is_some()));
    (0..sheet.cards.len()).filter(has)
}

fn heading(replay: &Replay, sheet: &Sheet, column: &Column) -> String {
    let [width, height] = replay.plan.pixels(column.window);
    let reject = match (sheet.columns.iter().any(|column| !column.discards), column.discards) {
        (false, _) => "",
        (true, true) => ", discard",
        (true, false) => ", alpha 0",
    };
    format!("{width}×{height} {}x{reject}", column.window.sampling)
}

/// Frames per second; of a picture that was not drawn, in proportion to a smaller one.
fn rate(cell: Cell, spread: bool) -> String {
    match (cell, cell.rate()) {
        (Cell::Failed, _) => "failed".into(),
        (Cell::Measured(time), Some(rate)) if spread => {
            let [low, high] = time.interval.map(|ms| digits(1e3 / ms));
            format!("{} [{high}, {low}]", digits(rate))
        }
        (Cell::Scaled(_), Some(rate)) => format!("≈{}", digits(rate)),
        (_, Some(rate)) => digits(rate),
        (_, None) => "–".into(),
    }
}
