//! The report as data: the records of its tables, and all of it as JSON.

use super::csv::Record;
use super::{Report, scene_text, sheet};
use crate::compare::answers::{Answer, answers};
use crate::compare::candidates::Curve;
use crate::compare::front::{Order, order};
use crate::compare::metrics::FLIP;
use crate::compare::paper::conclusions::{Block, balance, lookups};
use crate::compare::theory::theory;
use crate::compare::{Comparison, Row};
use hypertexture::scene::{Integration, Pass};
use serde_json::{Value, json};
use std::collections::BTreeMap;

/// Advice for steady times.
const STEADIER: &str = "repeat on an idle machine, with more runs (--repeat)";

/// Meaning of numbers whose names leave it open.
const UNITS: [(&str, &str); 8] = [
    ("rmse", "root mean square over R, G, B and A of premultiplied linear RGBA; 1 is white, or opaque"),
    ("covered_rmse", "the same over the pixels in which the picture or its truth is not clear"),
    ("rgb_rmse, opacity_rmse", "the same over R, G and B, and over A, of all pixels"),
    ("max_rgba", "largest difference of any of the four channels"),
    ("p999_rgba", "bound of 99.9 % of the pixels in the worst of their four channels"),
    ("relative_mse", "mean of d^2 / (t^2 + 0.01) over premultiplied linear R, G and B"),
    ("time_ms", "of the processor where that is the device, all threads; else on the device"),
    ("efficiency_per_mse_second", "1 / (rmse^2 x seconds of that time)"),
];

/// A record for each candidate.
pub fn candidates(comparison: &Comparison) -> Vec<Record> {
    let groups = comparison.groups();
    let record = |(index, row): (usize, &Row)| {
        let (curve, m, time, wall, first) =
            (row.candidate.curve(), &row.metrics, row.time(), row.wall(), &row.first.measurements);
        let truth = groups.iter().position(|group| group.rows.contains(&index)).unwrap_or_default();
        vec![
            ("candidate", index.into()),
            ("strategy", curve.strategy.into()),
            ("block", curve.block.into()),
            ("pass", json!(curve.pass)),
            ("integration", json!(curve.integration)),
            ("target", json!(curve.target)),
            ("samples", row.candidate.samples().into()),
            ("octaves", row.candidate.octaves().map(|[held, _]| held).into()),
            ("rmse", m.errors.rmse.into()),
            ("covered_rmse", m.errors.covered_rmse.into()),
            ("rgb_rmse", m.errors.rgb_rmse.into()),
            ("opacity_rmse", m.errors.opacity_rmse.into()),
            ("max_rgba", m.errors.max.into()),
            ("p999_rgba", m.errors.p999.into()),
            ("own_rmse", m.own_rmse.into()),
            ("relative_mse", m.relative_mse.into()),
            ("psnr_db", m.psnr.into()),
            ("ssim", m.ssim.into()),
            ("flip", m.flip.into()),
            ("flip_p99", m.flip_p99.into()),
            ("normal_mean_deg", row.normals.map(|angles| angles.mean).into()),
            ("normal_p99_deg", row.normals.map(|angles| angles.p99).into()),
            ("reference_rmse", row.truth.error().into()),
            ("reference_bound", row.truth.bound().into()),
            ("reference_proven", row.truth.proven().into()),
            ("blend_bound", row.candidate.blend_bound().into()),
            ("time_ms", time.median.into()),
            ("time_low_ms", time.interval[0].into()),
            ("time_high_ms", time.interval[1].into()),
            ("time_min_ms", time.min.into()),
            ("time_p95_ms", time.p95.into()),
            ("gpu_ms", row.gpu().median.into()),
            ("wall_ms", wall.median.into()),
            ("wall_low_ms", wall.interval[0].into()),
            ("wall_high_ms", wall.interval[1].into()),
            ("runs", time.runs.into()),
            ("unsteady", time.is_unsteady().into()),
            ("compile_ms", first.compile_ms.into()),
            ("device_bytes", first.device_bytes.into()),
            ("fragments", first.fragments.into()),
            ("efficiency_per_mse_second", row.efficiency().into()),
            ("front", groups[truth].front.contains(&index).into()),
            ("truth", truth.into()),
        ]
    };
    comparison.rows.iter().enumerate().map(record).collect()
}

/// A record for each run.
pub fn runs(comparison: &Comparison) -> Vec<Record> {
    let numbered = comparison.rows.iter().enumerate();
    let all =
        numbered.flat_map(|(index, row)| row.runs.iter().enumerate().map(move |(number, run)| (index, number, run)));
    let record = |(index, number, run): (usize, usize, &crate::compare::timing::Run)| {
        vec![
            ("candidate", index.into()),
            ("run", number.into()),
            ("gpu_ms", run.gpu_ms.into()),
            ("processor_ms", run.processor_ms.into()),
            ("wall_ms", run.wall_ms.into()),
        ]
    };
    all.map(record).collect()
}

/// The report but for its pictures and runs.
pub fn json(report: &Report, candidates: Vec<Record>) -> Value {
    let comparison = &report.comparison;
    let rows = &comparison.rows;
    let groups = comparison.groups();
    let candidates = rows.iter().zip(candidates).map(|(row, mut record)| {
        record.push(("label", row.candidate.label().into()));
        record.into_iter().map(|(name, value)| (name.to_string(), value)).collect::<Value>()
    });
    let candidates: Vec<Value> = candidates.collect();
    let failure = |failure: &crate::compare::Failure| json!({ "candidate": failure.label, "message": failure.message });
    let truths = groups.iter().enumerate().map(|(number, group)| {
        json!({
            "truth": number,
            "pattern": group.truth.pattern,
            "own": group.truth.is_own,
            "candidates": group.rows.len(),
            "reference_rmse": group.truth.error(),
            "reference_bound": group.truth.bound(),
            "reference_proven": group.truth.proven(),
            "answers": answers(rows, &group.rows),
        })
    });
    let table = report.table.as_ref();
    let turbulence = table.and_then(|table| lookups(table, &table.sheets[0]));
    let table = table.map(|table| {
        let (slices, samples) = (table.plan.effects[0].quality.samples, table.sampling.of(8).0);
        json!({ "slices": slices, "samples": samples, "sheet": sheet::json(table, 0) })
    });
    json!({
        "title": report.title,
        "command": report.environment.command,
        "scene": scene_text(&comparison.scene),
        "failed": comparison.failures.len(),
        "partial": comparison.partial,
        "planned": comparison.planned,
        "measured": rows.len(),
        "unsteady": { "candidates": comparison.unsteady(), "of": rows.len(), "advice": STEADIER },
        "environment": report.environment,
        "tolerance": report.tolerance,
        "units": UNITS.into_iter().collect::<BTreeMap<_, _>>(),
        "flip": FLIP,
        "clock": comparison.clock(),
        "scene_blake3": report.hash,
        "size": comparison.scene.image.size,
        "truths": truths.collect::<Vec<_>>(),
        "fastest": groups.first().and_then(|own| fastest(rows, &own.rows)),
        "candidates": candidates,
        "orders": orders(comparison),
        "octaves": octaves(rows),
        "table": table,
        "conclusions": turbulence.into_iter().chain(balance(&blocks(comparison))).collect::<Vec<_>>(),
        "failures": comparison.failures.iter().map(failure).collect::<Vec<_>>(),
    })
}

/// The fastest candidate within the smallest error that any has, and how many times faster it is than the slowest.
fn fastest(rows: &[Row], of: &[usize]) -> Option<Value> {
    let is_found = |answer: &Answer| Some((answer.error_at_most, answer.candidate?));
    let (error, best) = answers(rows, of).iter().rev().find_map(is_found)?;
    let within = of.iter().map(|&index| &rows[index]).filter(|row| row.point().1 <= error);
    let slowest = within.map(Row::time).max_by(|a, b| a.median.total_cmp(&b.median))?;
    let time = rows[best].time();
    let times =
        [slowest.median / time.median, slowest.interval[0] / time.interval[1], slowest.interval[1] / time.interval[0]];
    Some(json!({ "error_at_most": error, "candidate": best, "times_faster": times }))
}

/// The observed orders beside theory.
fn orders(comparison: &Comparison) -> Vec<Value> {
    let one = |(curve, indices, order): CurveRows| {
        let theory = theory(&comparison.rows[indices[0]].candidate.scene);
        let contradicts = theory.zip(order).map(|(theory, seen)| theory.contradicts(seen.order, seen.plus_minus));
        json!({
            "curve": curve.label(),
            "name": curve,
            "samples": indices.len(),
            "order": order,
            "theory": theory,
            "contradicts": contradicts,
        })
    };
    curves(&comparison.rows).into_iter().map(one).collect()
}

/// The strategies that have fewer octaves than were asked for.
fn octaves(rows: &[Row]) -> Vec<String> {
    let mut short: Vec<String> = Vec::new();
    for candidate in rows.iter().map(|row| &row.candidate) {
        let Some([held, asked]) = candidate.octaves().filter(|[held, asked]| held < asked) else { continue };
        let block = candidate.curve().block.map_or(String::new(), |side| format!(" {side}³"));
        let line = format!("{}{block} has {held} of {asked}", candidate.strategy);
        if !short.contains(&line) {
            short.push(line);
        }
    }
    short
}

/// The blocks of noise that were tried (MJ 7): by the scene's own strategy, on rays, with the most samples that several
/// have.
fn blocks(comparison: &Comparison) -> Vec<Block> {
    let own = &comparison.scene.effect;
    let mut tried: BTreeMap<(u32, bool), Vec<Block>> = BTreeMap::new();
    for row in &comparison.rows {
        let (curve, other) = (row.candidate.curve(), &row.candidate.scene.effect);
        if curve.pass == Pass::March && (&other.turbulence, &other.noise) == (&own.turbulence, &own.noise) {
            let key = (row.candidate.samples(), curve.integration == Integration::Segment);
            let block = curve.block.map(|side| Block { side, time: row.time(), error: row.metrics.errors.rmse });
            tried.entry(key).or_default().extend(block);
        }
    }
    tried.into_values().rev().find(|blocks| blocks.len() > 1).unwrap_or_default()
}

/// A curve, the indices of its rows by rising samples, and the order of their error.
pub(crate) type CurveRows = (Curve, Vec<usize>, Option<Order>);

/// The curves of some rows, with the indices of their rows by rising samples, and the order of their error.
pub fn curves(rows: &[Row]) -> Vec<CurveRows> {
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
        let point = |&index: &usize| (f64::from(rows[index].candidate.samples()), rows[index].metrics.errors.rmse);
        let points: Vec<(f64, f64)> = indices.iter().map(point).collect();
        (curve, indices, order(&points))
    };
    found.into_iter().map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::super::examples;
    use super::*;

    fn told(report: &Report) -> Value {
        json(report, candidates(&report.comparison))
    }

    /// The label of the fastest candidate of the scene's own truth within an error, and of those not separable from it.
    fn within(report: &Report, error: f64) -> (Option<String>, Vec<String>) {
        let json = told(report);
        let label = |index: &Value| json["candidates"][index.as_u64()? as usize]["label"].as_str().map(String::from);
        let answers = json["truths"][0]["answers"].as_array().unwrap();
        let answer = answers.iter().find(|answer| answer["error_at_most"] == error).unwrap();
        let like = answer["not_separable"].as_array().unwrap();
        (label(&answer["candidate"]), like.iter().filter_map(label).collect())
    }

    #[test]
    fn the_answer_is_the_fastest_candidate_within_the_bound() {
        // Segments of 16 samples have an error of 1/256, points of 16 one of 1/16, at the same time.
        let mut report = examples::report();
        assert_eq!(within(&report, 0.01).0.unwrap(), "encoded 64³, march, segment, 16 samples");
        let json = told(&report);
        assert_eq!(json["fastest"]["error_at_most"], 0.001);
        let best = &json["candidates"][json["fastest"]["candidate"].as_u64().unwrap() as usize];
        assert_eq!(best["label"], "encoded 64³, march, segment, 32 samples");
        report.comparison.rows.retain(|row| {
            let label = row.candidate.label();
            label.starts_with("encoded") && label.contains("8-bit")
        });
        assert_eq!(within(&report, 0.1).0.unwrap(), "encoded 64³, slices, point, 8-bit, 16 samples", "16/510");
        assert_eq!(within(&report, 0.01).0, None, "no 8 bits can promise it");
    }

    #[test]
    fn what_the_times_do_not_tell_apart_stands_beside_the_fastest() {
        let mut report = examples::report();
        let [points, segments] = ["point", "segment"].map(|rule| format!("encoded 64³, march, {rule}, 32 samples"));
        for row in report.comparison.rows.iter_mut().filter(|row| row.truth.is_own) {
            // One other takes as long as the fastest, and all others longer.
            let like = [&points, &segments].contains(&&row.candidate.label());
            row.runs.iter_mut().enumerate().for_each(|(run, time)| {
                time.gpu_ms = if like { 30.0 + run as f64 } else { time.gpu_ms + 90.0 };
            });
        }
        assert_eq!(within(&report, 0.1), (Some(points), vec![segments.clone()]));
        assert_eq!(within(&report, 0.001), (Some(segments), Vec::new()), "points of 32 samples are not within 0.001");
    }

    #[test]
    fn theory_beside_observation_marks_disagreement() {
        // Fire has a core; the errors of the example are 1 / samples by points, 1 / samples^2 by segments.
        let mut report = examples::report();
        let contradicts = |report: &Report, rule: &str| {
            let orders = orders(&report.comparison);
            let one = orders.iter().find(|one| one["curve"] == format!("encoded 64³, march, {rule}")).unwrap();
            (one["theory"]["order"][0].as_f64().unwrap(), one["contradicts"] == true)
        };
        assert_eq!(["point", "segment"].map(|rule| contradicts(&report, rule)), [(1.0, false), (2.0, false)]);
        for row in &mut report.comparison.rows {
            row.metrics.errors.rmse = f64::from(row.candidate.samples()).powf(-2.0);
        }
        assert_eq!(["point", "segment"].map(|rule| contradicts(&report, rule)), [(1.0, true), (2.0, false)]);
    }

    #[test]
    fn m60_the_best_block_is_concluded_from_the_rows() {
        let mut report = examples::report();
        assert_eq!(balance(&blocks(&report.comparison)), None, "one block alone is no choice");
        // Rays of segments with 64 samples: the same time, so that the smallest error decides.
        let has = |row: &&Row| row.candidate.label() == "encoded 64³, march, segment, 64 samples";
        let known = report.comparison.rows.iter().find(has).unwrap().clone();
        for (side, factor) in [(32, 3.0), (128, 0.5)] {
            let mut row = known.clone();
            row.candidate.scene.quality.block_size = side;
            row.metrics.errors.rmse *= factor;
            report.comparison.rows.push(row);
        }
        assert_eq!(balance(&blocks(&report.comparison)).unwrap().verdict, "128³");
        report.comparison.rows.last_mut().unwrap().runs.iter_mut().for_each(|run| run.gpu_ms *= 9.0);
        assert_eq!(told(&report)["conclusions"][0]["verdict"], "64³");
    }
}
