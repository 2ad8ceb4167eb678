//! The report of a comparison: CSV, JSON, SVG and one page, by the templates of this folder.
//!
//! Invariant: files are written whole, and no text in them names a folder of this machine.

mod chart;
mod csv;
mod data;
mod environment;
pub mod images;
pub mod page;
pub mod replay;
mod sheet;

pub use environment::{Environment, load};

use super::paper::Crop;
use super::paper::replay::Replay;
use super::{BACKGROUND, CompareError, Comparison, Failure, Group, Session};
use hypertexture::output::OutputError;
use hypertexture::render::Frame;
use hypertexture::scene::{Scene, to_text};
use hypertexture_support::{quoted, write_whole};
use serde_json::{Value, json};
use std::path::{Path, PathBuf};

/// Pictures of the front of the scene's own truth, at most, and of each of the others.
const PICTURES: [usize; 2] = [6, 2];

/// All that a report tells.
#[derive(Clone, Debug)]
pub struct Report {
    /// Name of the scene.
    pub title: String,
    /// Hash of `scene_text`.
    pub hash: String,
    /// The error that pixels of a reference are allowed.
    pub tolerance: f64,
    /// Where and when.
    pub environment: Environment,
    /// The comparison.
    pub comparison: Comparison,
    /// Pictures of rows, by their index.
    pub pictures: Vec<(usize, Frame)>,
    /// Rows with a live page at [`live_page`].
    pub live: Vec<usize>,
    /// The paper's Table 3 beside ours.
    pub table: Option<Replay>,
    /// The pictures of its Fig. 8.
    pub crops: Vec<Crop>,
}

/// The scene as it is written to a file, its files without the folders that they lie in.
pub(crate) fn scene_text(scene: &Scene) -> String {
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
    let without_folders = |word: String| {
        if Path::new(&word).exists() {
            file_name(&word)
        } else {
            word.split_inclusive(['=', '+', ',']).map(last_part).collect()
        }
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

/// Folder of the live page of a row, in that of the report.
pub fn live_page(index: usize) -> String {
    format!("live/{index}")
}

/// Renders pictures of the fronts once more, those at their ends and some between; one that cannot be drawn again is
/// recorded in `failures`.
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
    let comparison = &report.comparison;
    let candidates = data::candidates(comparison);
    let table = csv::csv(&candidates);
    let json = data::json(report, candidates);
    let charts = chart::charts(comparison, &data::curves(&comparison.rows));
    let files = [
        ("index.html", html(report, &json, &charts)),
        ("candidates.csv", table),
        ("runs.csv", csv::csv(&data::runs(comparison))),
        ("report.json", format!("{json:#}\n")),
        ("chart.svg", page::page("chart.html", &json!({ "titled": true, "charts": charts }))),
    ];
    write_all(&files, folder)
}

/// Writes files into a folder, which is made if it is missing, the page last: if it exists, the report is complete. Gives
/// the path of the page, which is the first.
fn write_all(files: &[(&str, String)], folder: &Path) -> Result<PathBuf, CompareError> {
    let io = |path: &Path| {
        let path = path.display().to_string();
        move |source| CompareError::Output(OutputError::Write { path, source })
    };
    std::fs::create_dir_all(folder).map_err(io(folder))?;
    for (name, content) in files.iter().rev() {
        let path = folder.join(name);
        write_whole(&path, content.as_bytes()).map_err(io(&path))?;
    }
    Ok(folder.join(files[0].0))
}

/// The page, with a chart for each truth.
fn html(report: &Report, json: &Value, charts: &[Value]) -> String {
    let comparison = &report.comparison;
    let background = comparison.scene.image.background.unwrap_or(BACKGROUND);
    let picture = |(index, frame): &(usize, Frame)| {
        let truth = &comparison.rows[*index].truth.reference;
        let images = [
            images::address_of(&truth.pixels, frame.size, background),
            images::picture(frame, background),
            images::heat_map(frame, &truth.pixels),
        ];
        let live = report.live.contains(index).then(|| format!("{}/index.html", live_page(*index)));
        json!({ "candidate": index, "images": images, "live": live })
    };
    let crop = |crop: &Crop| json!({ "caption": crop.caption, "drawn": crop.drawn, "picture": images::picture(&crop.frame, background) });
    let mut context = json.clone();
    context["charts"] = charts.into();
    context["pictures"] = report.pictures.iter().map(picture).collect();
    context["crops"] = report.crops.iter().map(crop).collect();
    (context["heat"], context["scale"]) = (images::HEAT.into_iter().collect(), images::scale().into());
    page::page("compare.html", &context)
}

#[cfg(test)]
pub(super) mod examples;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::paper::replay::{Plan, Sampling};
    use crate::compare::paper::{self, Cell};
    use crate::compare::timing::Spread;
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
    fn report_tables_have_a_row_for_each_candidate_and_run() {
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
        let keys = json["candidates"][0].as_object().unwrap();
        assert!(table.lines().next().unwrap().split(',').all(|column| keys.contains_key(column)), "{keys:?}");
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
        let all = json["candidates"].as_array().unwrap();
        for truth in [0, 1] {
            assert!(all.iter().any(|row| row["truth"] == truth && row["front"] == true));
        }
        let efficiency = all[0]["efficiency_per_mse_second"].as_f64().unwrap();
        assert!((efficiency - rows[0].efficiency()).abs() < 1e-6 * efficiency);
        assert!(read("chart.svg").starts_with("<svg"));
        assert!(read("index.html").ends_with("</html>\n"));
    }

    fn page(report: &Report) -> String {
        let comparison = &report.comparison;
        let charts = chart::charts(comparison, &data::curves(&comparison.rows));
        html(report, &data::json(report, data::candidates(comparison)), &charts)
    }

    #[test]
    fn failures_stand_at_the_top_of_the_page() {
        let mut report = examples::report();
        let good = page(&report);
        assert!(["FAILED", "Partial", "Unsteady"].iter().all(|banner| !good.contains(banner)));
        let (label, message) = ("encoded".to_string(), "a <b> too many".to_string());
        report.comparison.failures.push(Failure { label, message });
        report.comparison.partial = true;
        report.comparison.rows[0].runs[6].gpu_ms *= 2.0;
        let bad = page(&report);
        let place = |part: &str| bad.find(part).unwrap();
        assert!(["FAILED", "Partial", "Unsteady"].iter().all(|banner| place(banner) < place("fastest")));
        let unsteady = format!("of 1 of {} candidates", report.comparison.rows.len());
        let parts = ["a &lt;b&gt; too many", &unsteady, "idle machine, with more runs (--repeat)"];
        assert!(parts.iter().all(|part| bad.contains(part)), "{bad}");
    }

    #[test]
    fn the_page_is_self_contained_and_shows_errors_of_truths() {
        let text = page(&examples::report());
        assert!(["<script", "href=", "src=\"http", "{{", "{%"].iter().all(|part| !text.contains(part)));
        for tag in ["table", "details", "svg"] {
            assert_eq!(text.matches(&format!("<{tag}")).count(), text.matches(&format!("</{tag}>")).count());
        }
        let place = |part: &str| text.find(part).unwrap_or_else(|| panic!("{part}: {text}"));
        assert!(place("Truth 0, the scene's own: own") < place("Truth 1: other"));
        place("<summary>Truth 1: other: ");
        // An estimate of 1e-7 in all pixels, with an opacity of 1e-3 left open.
        place("<td class=\"n\">1.00·10⁻⁷<td class=\"n\">0.00100<td class=\"n\">100.0 %");
        place("<dt>command line<dd>hypertexture compare fire");
        assert!(place("<summary>The scene</summary><pre>") < place("input = &quot;"));
        // Points of the same samples take as long as segments.
        place("<small>not separable from the fastest within 0.1");
    }

    #[test]
    fn m56_table_3_shows_ours_the_paper_and_errors() {
        let mut report = examples::report();
        let way = &crate::compare::paper::TABLE_3[3];
        let plan = Plan {
            effects: vec![report.comparison.scene.clone()],
            scale: 1.0,
            quick: false,
            repeat: 1,
            error_size: [8; 2],
        };
        let sampling = Sampling::new(vec![1, 4], 8.0);
        let mut table = Replay::of_table_3(plan, sampling, [(way, report.comparison.scene.clone())].into_iter());
        table.shots[0].cell = Cell::Measured(Spread::of(&[100.0]));
        table.shots[2].cell = Cell::Scaled(5000.0);
        let label = "encoded 64³, slices, point, 8-bit, 64 samples";
        let index = report.comparison.rows.iter().position(|row| row.candidate.label() == label).unwrap();
        table.sheets[0].rows[0].errors = Some(Ok(paper::errors(&report.comparison.rows, index)));
        report.table = Some(table);
        let text = page(&report);
        let line = text.lines().find(|line| line.starts_with("<tr><td>encoded texture")).unwrap();
        for part in ["<b>10.0</b>", " 23.24<", " 17.00<", "<b>≈0.200</b>", " 4.18<"] {
            assert!(line.contains(part), "{line}");
        }
        // The error of 64 points is 1/64; 16 segments have a smaller one.
        assert!(
            line.contains(">0.0156<td") && line.contains(">0.00781<td") && line.ends_with("<td class=\"n\">3.99"),
            "{line}"
        );
    }

    #[test]
    fn a_report_into_a_file_is_refused() {
        let file = tempfile::NamedTempFile::new().unwrap();
        assert!(write(&examples::report(), file.path()).is_err());
    }
}
