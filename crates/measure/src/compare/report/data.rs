//! Tables for programs: a row for each candidate, every run, and the environment.

use super::{Report, scene_text};
use crate::compare::answers::answers;
use crate::compare::candidates::{Curve, integration_name, pass_name};
use crate::compare::front::{Order, order};
use crate::compare::metrics::FLIP;
use crate::compare::theory::theory;
use crate::compare::{Group, Row};
use hypertexture::scene::TargetFormat;
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::fmt::Write;

/// The columns of [`candidates`].
const COLUMNS: &str = "candidate,strategy,block,pass,integration,target,samples,octaves,rmse,covered_rmse,rgb_rmse,opacity_rmse,max_rgba,p999_rgba,\
    own_rmse,relative_mse,psnr_db,ssim,flip,flip_p99,normal_mean_deg,normal_p99_deg,reference_rmse,reference_bound,\
    reference_proven,blend_bound,\
    time_ms,time_low_ms,time_high_ms,time_min_ms,time_p95_ms,gpu_ms,wall_ms,wall_low_ms,wall_high_ms,runs,unsteady,compile_ms,\
    device_bytes,fragments,efficiency_per_mse_second,front,truth";

/// Advice for steady times.
pub const STEADIER: &str = "repeat on an idle machine, with more runs (--repeat)";

/// Meaning of numbers whose names leave it open.
const UNITS: [(&str, &str); 8] = [
    ("rmse", "root mean square over R, G, B and A of premultiplied linear RGBA; 1 is white, or opaque"),
    ("covered_rmse", "the same over the pixels in which the picture or its truth is not clear"),
    ("rgb_rmse, opacity_rmse", "the same over R, G and B, and over A, of all pixels"),
    ("max", "largest difference of any of the four channels"),
    ("p999", "what 99.9 % of the pixels stay below in the worst of their four channels"),
    ("relative_mse", "mean of d^2 / (t^2 + 0.01) over premultiplied linear R, G and B"),
    ("time", "of the processor where that is the device, all threads; else on the device"),
    ("efficiency_per_mse_second", "1 / (rmse^2 x seconds of that time)"),
];

/// One row for each candidate.
pub fn candidates(report: &Report) -> String {
    let mut text = format!("{COLUMNS}\n");
    let groups = report.comparison.groups();
    for (index, row) in report.comparison.rows.iter().enumerate() {
        let Row { candidate, metrics: m, .. } = row;
        let (curve, time, wall) = (candidate.curve(), row.time(), row.wall());
        let block = curve.block.map_or(String::new(), |side| side.to_string());
        let angle = |value: Option<f64>| value.map_or(String::new(), number);
        let first = &row.first.measurements;
        let truth = groups.iter().position(|group| group.rows.contains(&index)).unwrap_or_default();
        let cells = [
            index.to_string(),
            candidate.strategy.clone(),
            block,
            pass_name(curve.pass).into(),
            integration_name(curve.integration).into(),
            target_name(curve.target).into(),
            candidate.samples().to_string(),
            candidate.octaves().map_or(String::new(), |[held, _]| held.to_string()),
            number(m.errors.rmse),
            number(m.errors.covered_rmse),
            number(m.errors.rgb_rmse),
            number(m.errors.opacity_rmse),
            number(m.errors.max),
            number(m.errors.p999),
            m.own_rmse.map_or(String::new(), number),
            number(m.relative_mse),
            number(m.psnr),
            number(m.ssim),
            number(m.flip),
            number(m.flip_p99),
            angle(row.normals.map(|angles| angles.mean)),
            angle(row.normals.map(|angles| angles.p99)),
            number(row.truth.error()),
            number(row.truth.bound()),
            number(row.truth.proven()),
            number(candidate.blend_bound()),
            number(time.median),
            number(time.interval[0]),
            number(time.interval[1]),
            number(time.min),
            number(time.p95),
            number(row.gpu().median),
            number(wall.median),
            number(wall.interval[0]),
            number(wall.interval[1]),
            time.runs.to_string(),
            time.is_unsteady().to_string(),
            number(first.compile_ms),
            first.device_bytes.to_string(),
            first.fragments.map_or(String::new(), |count| count.to_string()),
            number(row.efficiency()),
            groups[truth].front.contains(&index).to_string(),
            truth.to_string(),
        ];
        writeln!(text, "{}", cells.join(",")).expect("writing to a string");
    }
    text
}

/// One row for each run.
pub fn runs(report: &Report) -> String {
    let mut text = String::from("candidate,run,gpu_ms,processor_ms,wall_ms\n");
    for (index, row) in report.comparison.rows.iter().enumerate() {
        for (number, run) in row.runs.iter().enumerate() {
            let processor = run.processor_ms.map_or(String::new(), |ms| ms.to_string());
            writeln!(text, "{index},{number},{},{processor},{}", run.gpu_ms, run.wall_ms).expect("writing to a string");
        }
    }
    text
}

/// Where, when and with what it was measured, and what follows from it.
pub fn summary(report: &Report) -> String {
    let comparison = &report.comparison;
    let orders: Vec<Value> = curves(report)
        .into_iter()
        .map(|(curve, indices, order)| {
            let theory = theory(&comparison.rows[indices[0]].candidate.scene);
            json!({ "curve": curve.label(), "name": curve, "order": order, "theory": theory })
        })
        .collect();
    let failures: Vec<Value> = comparison
        .failures
        .iter()
        .map(|failure| json!({ "candidate": failure.label, "message": failure.message }))
        .collect();
    let groups = comparison.groups();
    let row = |truth: usize, index: usize| {
        let row = &comparison.rows[index];
        let (time, label, efficiency) = (row.time(), row.candidate.label(), row.efficiency());
        json!({
            "truth": truth,
            "candidate": index,
            "label": label,
            "metrics": row.metrics,
            "time_ms": time,
            "efficiency_per_mse_second": efficiency,
        })
    };
    let numbered = || groups.iter().enumerate();
    let front: Vec<Value> =
        numbered().flat_map(|(truth, group)| group.front.iter().map(move |&index| row(truth, index))).collect();
    let truths: Vec<Value> = numbered()
        .map(|(number, Group { truth, rows, .. })| {
            json!({
                "truth": number,
                "pattern": truth.pattern,
                "own": truth.is_own,
                "candidates": rows.len(),
                "reference_rmse": truth.error(),
                "reference_bound": truth.bound(),
                "reference_proven": truth.proven(),
                "answers": answers(&comparison.rows, rows),
            })
        })
        .collect();
    let value = json!({
        "title": report.title,
        "command": report.environment.command,
        "scene": scene_text(&comparison.scene),
        "failed": comparison.failures.len(),
        "partial": comparison.partial,
        "planned": comparison.planned,
        "measured": comparison.rows.len(),
        "unsteady": { "candidates": comparison.unsteady(), "of": comparison.rows.len(), "advice": STEADIER },
        "environment": report.environment,
        "tolerance": report.tolerance,
        "units": UNITS.into_iter().collect::<BTreeMap<_, _>>(),
        "flip": FLIP,
        "scene_blake3": report.hash,
        "size": comparison.scene.image.size,
        "truths": truths,
        "front": front,
        "orders": orders,
        "failures": failures,
    });
    format!("{value:#}\n")
}

/// A curve, the indices of its rows by rising samples, and the order of their error.
pub type CurveRows = (Curve, Vec<usize>, Option<Order>);

/// The curves of a report, with the indices of their rows by rising samples, and the order of their error.
pub fn curves(report: &Report) -> Vec<CurveRows> {
    let rows = &report.comparison.rows;
    let mut found: Vec<(Curve, Vec<usize>)> = Vec::new();
    for (index, row) in rows.iter().enumerate() {
        let curve = row.candidate.curve();
        match found.iter_mut().find(|(other, _)| *other == curve) {
            Some((_, indices)) => indices.push(index),
            None => found.push((curve, vec![index])),
        }
    }
    let of = |(curve, mut indices): (Curve, Vec<usize>)| {
        indices.sort_by_key(|&index| rows[index].candidate.samples());
        let points: Vec<(f64, f64)> = indices
            .iter()
            .map(|&index| (f64::from(rows[index].candidate.samples()), rows[index].metrics.errors.rmse))
            .collect();
        (curve, indices, order(&points))
    };
    found.into_iter().map(of).collect()
}

/// A target as scene files spell it; none of rays.
fn target_name(target: Option<TargetFormat>) -> &'static str {
    match target {
        None => "",
        Some(TargetFormat::Unorm8) => "unorm8",
        Some(TargetFormat::Float16) => "float16",
        Some(TargetFormat::Float32) => "float32",
    }
}

/// A number with all the digits that it takes to read it back.
fn number(value: f64) -> String {
    format!("{value:e}")
}
