//! The report as one page that needs nothing else: no script, no file beside it.

use super::page::{circumstances, escape, short, spread, whole};
use super::paper_html::{blocks, crops, table_3};
use super::{Report, data, images};
use crate::measure::compare::candidates::{Candidate, Curve};
use crate::measure::compare::front::cheapest;
use crate::measure::compare::{BACKGROUND, Row};
use crate::scene::{Integration, Pass};

/// Errors that the cheapest candidate is asked for.
const BOUNDS: [f64; 3] = [1e-1, 1e-2, 1e-3];

/// The page.
pub fn page(report: &Report, chart: &str) -> String {
    let body = [
        head(report),
        answers(report),
        format!("<h2>Error against time</h2>\n{}\n{}\n", chart_note(report), chart),
        front_pictures(report),
        table_3(report),
        blocks(report),
        crops(report),
        orders(report),
        all_candidates(report),
        octaves(report),
        method(report),
    ];
    whole(&format!("{}: error against run time", report.title), &body.concat())
}

fn head(report: &Report) -> String {
    let comparison = &report.comparison;
    let [width, height] = comparison.scene.image.size;
    let e = &report.environment;
    let mut text = format!(
        "<h1>{}: error against run time</h1>\n<p class=\"sub\">{} of {} candidates at {width} × {height} on {}, {}</p>\n",
        escape(&report.title),
        comparison.rows.len(),
        comparison.planned,
        escape(&e.device),
        escape(&e.date),
    );
    if !comparison.failures.is_empty() {
        let lines: Vec<String> = comparison
            .failures
            .iter()
            .map(|failure| format!("<br>{}: {}", escape(&failure.label), escape(&failure.message)))
            .collect();
        let count = comparison.failures.len();
        text += &format!(
            "<div class=\"banner\"><b>FAILED</b>: {count} of the candidates failed.{}</div>\n",
            lines.concat()
        );
    }
    if comparison.partial {
        text += "<div class=\"banner\"><b>Partial</b>: the comparison was interrupted; what was measured until then is shown.</div>\n";
    }
    text
}

/// The cheapest candidate within each bound, in words and as a table. What blending may lose must lie within the bound
/// beforehand: drivers round in their own ways, and a measurement of one of them promises nothing.
fn answers(report: &Report) -> String {
    let rows = &report.comparison.rows;
    let safe = |bound: f64| -> Option<&Row> {
        let points: Vec<(f64, f64)> = rows
            .iter()
            .map(|row| {
                let (time, error) = row.point();
                (time, if row.candidate.blend_bound() <= bound { error } else { f64::INFINITY })
            })
            .collect();
        cheapest(&points, bound).map(|index| &rows[index])
    };
    let picks: Vec<(f64, Option<&Row>)> = BOUNDS.into_iter().map(|bound| (bound, safe(bound))).collect();
    let words = match picks.iter().rev().find_map(|(bound, row)| Some((bound, (*row)?))) {
        None => format!("<p class=\"answer\">No candidate comes within an error of {}.</p>\n", BOUNDS[0]),
        Some((bound, row)) => {
            let slowest =
                rows.iter().filter(|other| other.metrics.errors.rmse <= *bound).map(|other| other.gpu().median);
            let ratio = slowest.fold(0.0, f64::max) / row.gpu().median;
            format!(
                "<p class=\"answer\">The cheapest candidate within an error of {bound} is <b>{}</b>: {} ms, {} times faster than the \
                 slowest that gets there.</p>\n",
                escape(&row.candidate.label()),
                short(row.gpu().median),
                short(ratio)
            )
        }
    };
    let line = |(bound, row): &(f64, Option<&Row>)| match row {
        None => format!("<tr><td class=\"n\">{bound}<td colspan=\"5\">none"),
        Some(row) => format!(
            "<tr><td class=\"n\">{bound}<td>{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}",
            escape(&row.candidate.label()),
            spread(&row.gpu()),
            short(row.metrics.errors.rmse),
            short(row.metrics.flip),
            short(row.metrics.psnr),
        ),
    };
    let lines: Vec<String> = picks.iter().map(line).collect();
    format!(
        "{words}<div class=\"scroll\"><table><tr><th class=\"n\">error at most<th>cheapest candidate<th class=\"n\">ms on the device\
         <th class=\"n\">RMSE<th class=\"n\">FLIP<th class=\"n\">PSNR, dB</tr>\n{}\n</table></div>\n\
         <p class=\"note\">The error is the root mean square error of linear RGB against a reference of the candidate's own scene. \
         Times are medians with their 95 % interval; of fewer than six runs, with all of them. A slice format that could lose more than the bound by its rounding \
         alone is not offered here, whatever was measured.</p>\n",
        lines.join("\n")
    )
}

fn chart_note(report: &Report) -> String {
    let count = report.comparison.front().len();
    format!(
        "<p>Each line is one way to draw the scene with more and more samples; lower left is better. Rings and steps mark the \
         {count} candidates that no other beats in both error and time.</p>"
    )
}

/// The pictures of the front beside what is wrong with them.
fn front_pictures(report: &Report) -> String {
    let comparison = &report.comparison;
    let background = comparison.scene.image.background.unwrap_or(BACKGROUND);
    let mut figures = Vec::new();
    for (index, frame) in &report.pictures {
        let row = &comparison.rows[*index];
        let truth = &row.truth;
        let pixels: Vec<[f64; 4]> = frame.pixels.iter().map(|pixel| pixel.map(f64::from)).collect();
        let address = [
            images::picture(&truth.pixels, frame.size, background),
            images::picture(&pixels, frame.size, background),
            images::heat_map(&pixels, &truth.pixels, frame.size),
        ];
        let label = escape(&row.candidate.label());
        let names = ["reference", "candidate", "difference"].into_iter().zip(&address);
        let images: Vec<String> = names
            .map(|(name, address)| format!("<img src=\"{address}\" alt=\"{name} of {label}\" title=\"{name}\">"))
            .collect();
        figures.push(format!(
            "<figure><div>{}</div><figcaption><b>{label}</b><br><span>{} ms, RMSE {}, FLIP {}</span></figcaption></figure>",
            images.concat(),
            short(row.gpu().median),
            short(row.metrics.errors.rmse),
            short(row.metrics.flip),
        ));
    }
    if figures.is_empty() {
        return String::new();
    }
    let [low, high] = images::HEAT;
    format!(
        "<h2>Along the front</h2>\n<p>Reference, candidate, and the largest difference of each pixel's linear color: {} \
         <img class=\"scale\" src=\"{}\" alt=\"scale of the differences\"> {}</p>\n<div class=\"pictures\">\n{}\n</div>\n",
        short(low),
        images::scale(),
        short(high),
        figures.join("\n")
    )
}

fn orders(report: &Report) -> String {
    let line = |(curve, indices, order): (Curve, Vec<usize>, Option<_>)| {
        let order: Option<crate::measure::compare::front::Order> = order;
        let (value, points, floor) = match order {
            None => ("–".into(), "–".into(), "–".into()),
            Some(order) => {
                let doubt =
                    order.plus_minus.map_or("<small>(two points)</small>".into(), |half| format!("± {half:.2}"));
                let floor = order.floor.map_or("none seen".into(), short);
                (format!("{:.2} {doubt}", order.order), order.points.to_string(), floor)
            }
        };
        let expected = match (curve.integration, curve.pass) {
            (Integration::Segment, _) => "2 where the density is smooth",
            (Integration::Point, Pass::March | Pass::Slices) => "1",
        };
        format!(
            "<tr><td>{}<td class=\"n\">{}<td class=\"n\">{value}<td class=\"n\">{points}<td class=\"n\">{floor}<td>{expected}",
            escape(&curve.label()),
            indices.len()
        )
    };
    let lines: Vec<String> = data::curves(report).into_iter().map(line).collect();
    format!(
        "<h2>Observed order</h2>\n<p>The error falls like samples<sup>−order</sup>: least squares over the samples above the \
         floor, with the 95 % interval. The floor is where more samples no longer help: what is left is the block of noise, \
         the format or the field.</p>\n<details{}><summary>{} curves</summary><div class=\"scroll\"><table><tr><th>curve\
         <th class=\"n\">samples<th class=\"n\">order<th class=\"n\">of points<th class=\"n\">floor, RMSE<th>in theory</tr>\n{}\n</table></div></details>\n",
        if lines.len() <= 16 { " open" } else { "" },
        lines.len(),
        lines.join("\n")
    )
}

fn all_candidates(report: &Report) -> String {
    let front = report.comparison.front();
    let line = |(index, row): (usize, &Row)| {
        let m = &row.metrics;
        let class = if front.contains(&index) { " class=\"front\"" } else { "" };
        let cell = |text: String| format!("<td class=\"n\">{text}");
        let angle = row.normals.map_or("–".into(), |angles| short(angles.mean));
        let cells = [
            spread(&row.gpu()),
            spread(&row.wall()),
            short(m.errors.rmse),
            m.own_rmse.map_or("–".into(), short),
            short(m.errors.max),
            short(m.errors.p999),
            short(m.errors.opacity_rmse),
            short(m.psnr),
            format!("{:.5}", m.ssim),
            short(m.flip),
            angle,
            blend(&row.candidate),
            row.gpu().runs.to_string(),
        ];
        format!("<tr{class}><td>{}{}", escape(&row.candidate.label()), cells.map(cell).concat())
    };
    let lines: Vec<String> = report.comparison.rows.iter().enumerate().map(line).collect();
    format!(
        "<h2>Every candidate</h2>\n<p class=\"note\">Bold: on the front. ≋: the 95th percentile of the times exceeds the median by more \
         than a quarter, so the machine was disturbed. <i>Blending</i> is what rounding between slices may add to the error, \
         known beforehand. Every run is in <code>runs.csv</code>, every digit in <code>candidates.csv</code>.</p>\n\
         <details><summary>{} rows</summary><div class=\"scroll\"><table><tr><th>candidate<th class=\"n\">ms on the device\
         <th class=\"n\">ms in all<th class=\"n\">RMSE<th class=\"n\">of its octaves<th class=\"n\">max<th class=\"n\">p99.9<th class=\"n\">opacity RMSE\
         <th class=\"n\">PSNR, dB<th class=\"n\">SSIM<th class=\"n\">FLIP<th class=\"n\">normals, °<th class=\"n\">blending\
         <th class=\"n\">runs</tr>\n{}\n</table></div></details>\n",
        lines.len(),
        lines.join("\n")
    )
}

/// Which strategies have fewer octaves than were asked for.
fn octaves(report: &Report) -> String {
    let mut short: Vec<String> = Vec::new();
    for candidate in report.comparison.rows.iter().map(|row| &row.candidate) {
        let Some([held, asked]) = candidate.octaves().filter(|[held, asked]| held < asked) else { continue };
        let block = candidate.curve().block.map_or(String::new(), |side| format!(" {side}³"));
        let line = format!("{}{block} has {held} of {asked}", escape(&candidate.strategy));
        if !short.contains(&line) {
            short.push(line);
        }
    }
    if short.is_empty() {
        return String::new();
    }
    format!(
        "<p><b>Octaves:</b> {}. RMSE counts what is missing; <i>of its octaves</i> is the same error against a reference \
         that has only those of the strategy. With fewer <code>quality.turbulence_cells</code> a block holds more octaves \
         and repeats sooner.</p>\n",
        short.join(", ")
    )
}

fn blend(candidate: &Candidate) -> String {
    match candidate.blend_bound() {
        0.0 => "–".into(),
        bound => format!("≤ {}", short(bound)),
    }
}

fn method(report: &Report) -> String {
    format!(
        "<h2>Method</h2>\n<p>Every candidate is warmed up, and its runs are mixed with those of others in random order, so that \
         a slow moment of the machine slows all alike; no run is dropped. <i>On the device</i> is what timestamps of the device \
         say, <i>in all</i> is wall clock from the scene to pixels in memory, without compiling. A strategy that reads a block \
         is held against the noise that the block was made of, and a computed one against its own noise: they are different \
         noises, and each error is that of the candidate's own picture.</p>\n{}",
        circumstances(&report.environment, &[("scene, BLAKE3", report.hash.clone())])
    )
}

#[cfg(test)]
mod tests {
    use super::super::examples;
    use super::*;
    use crate::measure::compare::Failure;

    #[test]
    fn the_answer_is_the_cheapest_within_the_bound_and_excludes_what_may_lose_more() {
        let text = answers(&examples::report());
        // Segments of 16 samples have an error of 1/256, points of 16 one of 1/16, at the same time.
        assert!(
            text.contains("cheapest candidate within an error of 0.001 is <b>encoded 64³, march, segment, 32 samples"),
            "{text}"
        );
        assert!(text.contains("<td class=\"n\">0.01<td>encoded 64³, march, segment, 16 samples"), "{text}");
        let mut slices = examples::report();
        slices.comparison.rows.retain(|row| {
            let label = row.candidate.label();
            label.starts_with("encoded") && label.contains("8-bit")
        });
        let text = answers(&slices);
        assert!(text.contains("0.1<td>encoded 64³, slices, point, 8-bit, 16 samples"), "16/510 is within 0.1: {text}");
        assert!(text.contains("0.01<td colspan"), "no 8 bits can promise it: {text}");
    }

    #[test]
    fn what_failed_stands_at_the_top() {
        let mut report = examples::report();
        let good = page(&report, "");
        assert!(!good.contains("FAILED") && !good.contains("Partial"));
        let (label, message) = ("encoded".to_string(), "a <b> too many".to_string());
        report.comparison.failures.push(Failure { label, message });
        report.comparison.partial = true;
        let bad = page(&report, "");
        let place = |what: &str| bad.find(what).unwrap();
        assert!(place("FAILED") < place("cheapest") && place("Partial") < place("cheapest"));
        assert!(bad.contains("a &lt;b&gt; too many"));
    }

    #[test]
    fn a_page_needs_no_script_and_nothing_beside_it() {
        let text = page(&examples::report(), "<svg></svg>");
        for part in ["<script", "href=", "src=\"http", "{title}", "{body}"] {
            assert!(!text.contains(part), "{part}");
        }
        assert_eq!(text.matches("<table").count(), text.matches("</table>").count());
    }
}
