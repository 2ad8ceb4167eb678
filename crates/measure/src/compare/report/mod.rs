//! The report of a comparison: CSV, JSON, SVG and one page.
//!
//! Invariant: files are written whole, and no text in them names a folder of this machine.

mod chart;
mod data;
mod environment;
mod fastest;
mod html;
pub mod images;
mod orders;
pub mod page;
mod paper_html;
pub mod replay;
mod replay_grid;
mod replay_html;

pub use environment::{Environment, load};

use super::candidates::Curve;
use super::paper::{Crop, Table};
use super::{CompareError, Comparison, Failure, Group, Session};
use chart::{Chart, Line, Marker, Point};
use hypertexture::output::OutputError;
use hypertexture::render::Frame;
use hypertexture::scene::{Integration, Pass, Scene, to_text};
use std::path::{Path, PathBuf};
use support::{quoted, write_whole};

/// Files of a report.
pub const FILES: [&str; 5] = ["index.html", "candidates.csv", "runs.csv", "report.json", "chart.svg"];
/// Pictures of the front of the scene's own truth, at most, and of each of the others.
const PICTURES: [usize; 2] = [6, 2];

/// All that a report tells.
#[derive(Clone, Debug)]
pub struct Report {
    /// Name of the scene.
    pub title: String,
    /// Hash of [`scene_text`].
    pub hash: String,
    /// The error that pixels of a reference are allowed.
    pub tolerance: f64,
    /// Where and when.
    pub environment: Environment,
    /// The comparison.
    pub comparison: Comparison,
    /// Pictures of rows, by their index.
    pub pictures: Vec<(usize, Frame)>,
    /// The paper's Table 3 beside ours.
    pub table: Option<Table>,
    /// The pictures of its Fig. 8.
    pub crops: Vec<Crop>,
}

/// The scene as it is written to a file, its files without the folders that they lie in.
pub fn scene_text(scene: &Scene) -> String {
    let mut scene = scene.clone();
    for object in scene.parts.values_mut().map(|part| &mut part.object).chain([&mut scene.object]) {
        object.input = file_name(&object.input);
    }
    scene.modules.values_mut().for_each(|module| *module = file_name(module));
    to_text(&scene)
}

/// The hash of a scene as it is written to a file.
pub fn hash(scene: &Scene) -> String {
    blake3::hash(scene_text(scene).as_bytes()).to_hex().to_string()
}

/// The words behind the name of the program as a command line for `sh`, files without the folders that they lie in.
pub fn command_line(words: impl Iterator<Item = String>) -> String {
    let without_folders = |word: String| match Path::new(&word).exists() {
        true => file_name(&word),
        false => word.split_inclusive(['=', '+', ',']).map(last_part).collect(),
    };
    let words = words.map(|word| quoted(&without_folders(word)));
    ["hypertexture".into()].into_iter().chain(words).collect::<Vec<_>>().join(" ")
}

/// The last part of a path that a sign may end.
fn last_part(word: &str) -> String {
    let path = word.trim_end_matches(['=', '+', ',']);
    if path.contains(std::path::MAIN_SEPARATOR) { file_name(path) + &word[path.len()..] } else { word.into() }
}

/// The last part of a path, or the name itself.
pub fn file_name(path: &str) -> String {
    Path::new(path).file_name().map_or_else(|| path.into(), |name| name.to_string_lossy().into_owned())
}

/// Renders pictures of the fronts once more, those at their ends and some between; what cannot be drawn again is told.
pub fn pictures(session: Session<'_>, comparison: &Comparison, failures: &mut Vec<Failure>) -> Vec<(usize, Frame)> {
    let chosen = comparison.groups().into_iter().flat_map(|Group { truth, front, .. }| {
        let count = front.len().min(PICTURES[usize::from(!truth.is_own)]);
        (0..count).map(move |place| front[place * (front.len() - 1) / (count - 1).max(1)])
    });
    let draw = |index: usize| {
        let candidate = &comparison.rows[index].candidate;
        let fail = |error: hypertexture::render::RenderError| {
            failures.push(Failure { label: candidate.label(), message: error.to_string() });
        };
        session.painter().render(&candidate.scene).map_err(fail).ok().map(|frame| (index, frame))
    };
    chosen.filter_map(draw).collect()
}

/// Writes the report into a folder, which is created if necessary; gives the path of the page.
///
/// # Errors
/// Errors of the file system; a file is whole or unchanged.
pub fn write(report: &Report, folder: &Path) -> Result<PathBuf, CompareError> {
    let io = |path: &Path| {
        let path = path.display().to_string();
        move |source| CompareError::Output(OutputError::Write { path, source })
    };
    std::fs::create_dir_all(folder).map_err(io(folder))?;
    let charts = charts(report);
    let contents = [
        html::page(report, &charts),
        data::candidates(report),
        data::runs(report),
        data::summary(report),
        chart::standalone(&charts),
    ];
    let mut files: Vec<_> = FILES.into_iter().zip(contents).collect();
    files.reverse(); // the page appears last: when it is there, all of it is
    for (name, content) in files {
        let path = folder.join(name);
        write_whole(&path, content.as_bytes()).map_err(io(&path))?;
    }
    Ok(folder.join(FILES[0]))
}

/// Error against time, a chart for each truth and a line for each curve.
fn charts(report: &Report) -> Vec<Chart> {
    let curves = data::curves(report);
    let groups = report.comparison.groups();
    groups.iter().enumerate().map(|(number, group)| chart(report, number, group, &curves)).collect()
}

fn chart(report: &Report, number: usize, group: &Group, curves: &[data::CurveRows]) -> Chart {
    let rows = &report.comparison.rows;
    let mut groups: Vec<String> = Vec::new();
    let mut lines = Vec::new();
    for (Curve { strategy, pass, integration, .. }, indices, _) in
        curves.iter().filter(|(_, indices, _)| group.rows.contains(&indices[0]))
    {
        let color = groups.iter().position(|name| name == strategy).unwrap_or_else(|| {
            groups.push(strategy.clone());
            groups.len() - 1
        });
        let point = |&index: &usize| {
            let (row, (time, error)) = (&rows[index], rows[index].point());
            let about = format!("{}: error {error:.2e} in {time:.3} ms", row.candidate.label());
            Point { time, error, interval: row.time().interval, reference: group.truth.error(), about }
        };
        lines.push(Line {
            group: color,
            marker: if *pass == Pass::March { Marker::Circle } else { Marker::Square },
            filled: *integration == Integration::Segment,
            faint: rows[indices[0]].candidate.aside,
            points: indices.iter().map(point).collect(),
        });
    }
    let front = group.front.iter().map(|&index| rows[index].point()).collect();
    let floor = Some(group.truth.error()).filter(|floor| *floor > 0.0);
    let (title, clock) = (format!("Truth {number}: {}", group.truth.pattern), report.comparison.clock());
    Chart { title, groups, lines, front, floor, clock }
}

#[cfg(test)]
pub(super) mod examples;

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture::scene::preset;

    #[test]
    fn the_hash_of_a_scene_does_not_depend_on_where_its_object_lies() {
        let mut here = preset("fire").unwrap();
        here.object.input = "/somewhere/bunny.obj".into();
        let mut there = here.clone();
        there.object.input = "bunny.obj".into();
        assert_eq!(hash(&here), hash(&there));
        there.quality.samples += 1;
        assert_ne!(hash(&here), hash(&there));
        here.modules.insert("dmf/own".into(), "/somewhere/own.glsl".into());
        let text = scene_text(&here);
        assert!(text.contains("own.glsl") && !text.contains("/home"), "{text}");
    }

    #[test]
    fn a_command_line_can_be_run_again_and_names_no_folder() {
        let folder = tempfile::tempdir().unwrap();
        let odd = folder.path().join("a+b, c.obj");
        std::fs::write(&odd, "").unwrap();
        let words = [
            "compare",
            &odd.to_string_lossy(),
            "--module=dmf=fur+/somewhere/own.glsl",
            "--set",
            "light.color=#ffe0c0",
            "--sweep",
            "8,16",
            "-o",
            "out/report/",
        ];
        assert_eq!(
            command_line(words.into_iter().map(String::from)),
            "hypertexture compare 'a+b, c.obj' --module=dmf=fur+own.glsl --set 'light.color=#ffe0c0' --sweep 8,16 -o report"
        );
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
        assert_eq!((&json["command"], &json["tolerance"]), (&"hypertexture compare fire".into(), &1e-4.into()));
        let scene: toml::Table = json["scene"].as_str().unwrap().parse().unwrap();
        assert_eq!(scene["image"]["size"].as_array().unwrap().len(), 2);
        assert_eq!(json["unsteady"]["candidates"], 0);
        // The scene's own truth first; each front has the rows of its own.
        let rows = &report.comparison.rows;
        assert!(json["truths"][0]["own"] == true && json["truths"][1]["own"] == false);
        let number = |index: usize| usize::from(!rows[index].truth.is_own);
        for (index, line) in table.lines().skip(1).enumerate() {
            assert!(line.ends_with(&format!(",{}", number(index))), "{line}");
        }
        let front = json["front"].as_array().unwrap();
        for truth in [0, 1] {
            let of: Vec<&serde_json::Value> = front.iter().filter(|row| row["truth"] == truth).collect();
            assert!(
                !of.is_empty() && of.iter().all(|row| number(row["candidate"].as_u64().unwrap() as usize) == truth)
            );
        }
        let efficiency = front[0]["efficiency_per_mse_second"].as_f64().unwrap();
        assert!(
            (efficiency - rows[front[0]["candidate"].as_u64().unwrap() as usize].efficiency()).abs()
                < 1e-6 * efficiency
        );
        assert!(read("chart.svg").starts_with("<svg"));
        assert!(read("index.html").ends_with("</html>\n"));
    }

    #[test]
    fn a_report_into_a_file_is_refused() {
        let file = tempfile::NamedTempFile::new().unwrap();
        assert!(write(&examples::report(), file.path()).is_err());
    }
}
