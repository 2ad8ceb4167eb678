//! Tables for programs: a row for each candidate, every run, and the environment.

use super::Report;
use crate::measure::compare::Row;
use crate::measure::compare::candidates::{Curve, pass_name, rule_name};
use crate::measure::compare::front::{Order, order};
use crate::measure::compare::metrics::FLIP;
use crate::scene::TargetFormat;
use serde_json::{Value, json};
use std::fmt::Write;

/// The columns of [`candidates`].
const COLUMNS: &str = "candidate,strategy,block,pass,integration,target,samples,octaves,rmse,covered_rmse,rgb_rmse,opacity_rmse,max,p999,\
    own_rmse,relative_mse,psnr_db,ssim,flip,flip_p99,normal_mean_deg,normal_p99_deg,reference_rmse,reference_proven,blend_bound,\
    gpu_ms,gpu_low_ms,gpu_high_ms,gpu_min_ms,gpu_p95_ms,wall_ms,wall_low_ms,wall_high_ms,runs,unsteady,compile_ms,\
    device_bytes,fragments,efficiency,front";

/// One row for each candidate.
pub fn candidates(report: &Report) -> String {
    let mut text = format!("{COLUMNS}\n");
    let front = report.comparison.front();
    for (index, row) in report.comparison.rows.iter().enumerate() {
        let Row { candidate, metrics: m, .. } = row;
        let (curve, gpu, wall) = (candidate.curve(), row.gpu(), row.wall());
        let block = curve.block.map_or(String::new(), |side| side.to_string());
        let angle = |value: Option<f64>| value.map_or(String::new(), number);
        let first = &row.first.measurements;
        let cells = [
            index.to_string(),
            candidate.strategy.clone(),
            block,
            pass_name(curve.pass).into(),
            rule_name(curve.integration).into(),
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
            number(row.reference_error),
            number(row.truth.proven() as f64 / row.truth.pixels.len().max(1) as f64),
            number(candidate.blend_bound()),
            number(gpu.median),
            number(gpu.interval[0]),
            number(gpu.interval[1]),
            number(gpu.min),
            number(gpu.p95),
            number(wall.median),
            number(wall.interval[0]),
            number(wall.interval[1]),
            gpu.runs.to_string(),
            gpu.is_unsteady().to_string(),
            number(first.compile_ms),
            first.device_bytes.to_string(),
            first.fragments.map_or(String::new(), |count| count.to_string()),
            number(row.efficiency()),
            front.contains(&index).to_string(),
        ];
        writeln!(text, "{}", cells.join(",")).expect("writing to a string");
    }
    text
}

/// One row for each run.
pub fn runs(report: &Report) -> String {
    let mut text = String::from("candidate,run,gpu_ms,wall_ms\n");
    for (index, row) in report.comparison.rows.iter().enumerate() {
        for (number, run) in row.runs.iter().enumerate() {
            writeln!(text, "{index},{number},{},{}", run.gpu_ms, run.wall_ms).expect("writing to a string");
        }
    }
    text
}

/// Where, when and with what it was measured, and what follows from it.
pub fn summary(report: &Report) -> String {
    let comparison = &report.comparison;
    let orders: Vec<Value> = curves(report)
        .into_iter()
        .map(|(curve, _, order)| json!({ "curve": curve.label(), "name": curve, "order": order }))
        .collect();
    let failures: Vec<Value> = comparison
        .failures
        .iter()
        .map(|failure| json!({ "candidate": failure.label, "message": failure.message }))
        .collect();
    let front: Vec<Value> = comparison
        .front()
        .into_iter()
        .map(|index| {
            let row = &comparison.rows[index];
            let (gpu, label) = (row.gpu(), row.candidate.label());
            json!({ "candidate": index, "label": label, "metrics": row.metrics, "gpu_ms": gpu })
        })
        .collect();
    let value = json!({
        "title": report.title,
        "failed": comparison.failures.len(),
        "partial": comparison.partial,
        "planned": comparison.planned,
        "measured": comparison.rows.len(),
        "environment": report.environment,
        "flip": FLIP,
        "scene_blake3": report.hash,
        "size": comparison.scene.image.size,
        "front": front,
        "orders": orders,
        "failures": failures,
    });
    format!("{value:#}\n")
}

/// The curves of a report, with the indices of their rows by rising samples, and the order of their error.
pub fn curves(report: &Report) -> Vec<(Curve, Vec<usize>, Option<Order>)> {
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
