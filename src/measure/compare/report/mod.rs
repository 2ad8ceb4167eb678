//! The report of a comparison: CSV, JSON, SVG and one page.
//!
//! Invariant: files are written whole, and no text in them names a folder of this machine.

mod chart;
mod data;
mod environment;
mod html;
mod images;
mod page;
mod paper_html;
pub mod replay;
mod replay_grid;
mod replay_html;

pub use environment::{Environment, load};

use super::candidates::Curve;
use super::paper::{Crop, Table};
use super::{CompareError, Comparison, Failure, Stage};
use crate::output::OutputError;
use crate::render::Frame;
use crate::scene::{Integration, Pass, Scene, to_text};
use crate::support::write_whole;
use chart::{Chart, Line, Marker};
use std::path::{Path, PathBuf};

/// Files of a report.
pub const FILES: [&str; 5] = ["index.html", "candidates.csv", "runs.csv", "report.json", "chart.svg"];
/// Pictures of the front, at most.
const PICTURES: usize = 6;

/// All that a report tells.
#[derive(Clone, Debug)]
pub struct Report {
    /// What was compared: the name of a scene.
    pub title: String,
    /// Hash of the scene as it is written to a file.
    pub hash: String,
    /// Where and when.
    pub environment: Environment,
    /// What was measured.
    pub comparison: Comparison,
    /// Pictures of rows, by their index.
    pub pictures: Vec<(usize, Frame)>,
    /// The paper's Table 3 beside ours.
    pub table: Option<Table>,
    /// The pictures of its Fig. 8.
    pub crops: Vec<Crop>,
}

/// The hash of a scene as it is written to a file, its object without the folder that it lies in.
pub fn hash(scene: &Scene) -> String {
    let mut scene = scene.clone();
    for object in scene.parts.values_mut().map(|part| &mut part.object).chain([&mut scene.object]) {
        object.input = file_name(&object.input);
    }
    blake3::hash(to_text(&scene).as_bytes()).to_hex().to_string()
}

/// The last part of a path, or the name itself.
pub fn file_name(path: &str) -> String {
    Path::new(path).file_name().map_or_else(|| path.into(), |name| name.to_string_lossy().into_owned())
}

/// Renders the pictures of the front once more, those at its ends and some between; what cannot be drawn again is told.
pub fn pictures(stage: Stage<'_>, comparison: &Comparison, failures: &mut Vec<Failure>) -> Vec<(usize, Frame)> {
    let front = comparison.front();
    let count = front.len().min(PICTURES);
    let chosen = (0..count).map(|place| front[place * (front.len() - 1) / (count - 1).max(1)]);
    let mut draw = |index: usize| {
        let candidate = &comparison.rows[index].candidate;
        let fail = |error: crate::render::RenderError| {
            failures.push(Failure { label: candidate.label(), message: error.to_string() });
        };
        stage.painter().render(&candidate.scene).map_err(fail).ok().map(|frame| (index, frame))
    };
    chosen.filter_map(&mut draw).collect()
}

/// Writes the report into a folder, which is made if there is none; gives the path of the page.
///
/// # Errors
/// What the system says; a file is whole or as it was.
pub fn write(report: &Report, folder: &Path) -> Result<PathBuf, CompareError> {
    let io = |path: &Path| {
        let path = path.display().to_string();
        move |source| CompareError::Output(OutputError::Write { path, source })
    };
    std::fs::create_dir_all(folder).map_err(io(folder))?;
    let chart = chart(report);
    let contents = [
        html::page(report, &chart::svg(&chart)),
        data::candidates(report),
        data::runs(report),
        data::summary(report),
        chart::standalone(&chart),
    ];
    let mut files: Vec<_> = FILES.into_iter().zip(contents).collect();
    files.reverse(); // the page appears last: when it is there, all of it is
    for (name, content) in files {
        let path = folder.join(name);
        write_whole(&path, content.as_bytes()).map_err(io(&path))?;
    }
    Ok(folder.join(FILES[0]))
}

/// Error against time, a line for each curve.
fn chart(report: &Report) -> Chart {
    let rows = &report.comparison.rows;
    let mut groups: Vec<String> = Vec::new();
    let mut lines = Vec::new();
    for (Curve { strategy, pass, integration, .. }, indices, _) in data::curves(report) {
        let group = groups.iter().position(|name| *name == strategy).unwrap_or_else(|| {
            groups.push(strategy);
            groups.len() - 1
        });
        let point = |&index: &usize| {
            let (row, (time, error)) = (&rows[index], rows[index].point());
            (time, error, format!("{}: error {error:.2e} in {time:.3} ms", row.candidate.label()))
        };
        lines.push(Line {
            group,
            marker: if pass == Pass::March { Marker::Circle } else { Marker::Square },
            filled: integration == Integration::Segment,
            faint: rows[indices[0]].candidate.aside,
            points: indices.iter().map(point).collect(),
        });
    }
    let points = report.comparison.points();
    let front = report.comparison.front().into_iter().map(|index| points[index]).collect();
    let floor = rows.iter().map(|row| row.reference_error).fold(0.0, f64::max);
    Chart { groups, lines, front, floor: (floor > 0.0).then_some(floor) }
}

#[cfg(test)]
mod examples;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::preset;

    #[test]
    fn the_hash_of_a_scene_does_not_depend_on_where_its_object_lies() {
        let mut here = preset("fire").unwrap();
        here.object.input = "/home/somebody/bunny.obj".into();
        let mut there = here.clone();
        there.object.input = "bunny.obj".into();
        assert_eq!(hash(&here), hash(&there));
        there.quality.samples += 1;
        assert_ne!(hash(&here), hash(&there));
    }

    #[test]
    fn a_report_is_written_whole_and_its_tables_have_a_row_for_each_candidate_and_run() {
        let folder = tempfile::tempdir().unwrap();
        let report = examples::report();
        let page = write(&report, &folder.path().join("new")).unwrap();
        let read = |name: &str| std::fs::read_to_string(page.with_file_name(name)).unwrap();
        let table = read("candidates.csv");
        let columns = table.lines().next().unwrap().split(',').count();
        assert!(table.lines().all(|line| line.split(',').count() == columns), "{table}");
        assert_eq!(table.lines().count(), 1 + report.comparison.rows.len());
        let runs: usize = report.comparison.rows.iter().map(|row| row.runs.len()).sum();
        assert_eq!(read("runs.csv").lines().count(), 1 + runs);
        let json: serde_json::Value = serde_json::from_str(&read("report.json")).unwrap();
        assert_eq!(json["measured"], report.comparison.rows.len());
        assert_eq!(json["orders"][0]["order"]["points"], 3);
        assert!(read("chart.svg").starts_with("<svg"));
        assert!(read("index.html").ends_with("</html>\n"));
    }

    #[test]
    fn a_report_into_a_file_is_refused() {
        let file = tempfile::NamedTempFile::new().unwrap();
        assert!(write(&examples::report(), file.path()).is_err());
    }
}
