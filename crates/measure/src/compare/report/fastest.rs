//! The fastest candidates within some errors, and what cannot be told from them.

use super::Report;
use super::page::{escape, short, spread};
use crate::compare::answers::{Answer, answers};
use crate::compare::{Group, Row};

/// Labels of candidates that are written out in one cell, at most.
const LABELS: usize = 2;

/// The fastest candidate within each error: in words of the scene's own truth, and as a table of all.
pub fn fastest(report: &Report, groups: &[Group]) -> String {
    let (rows, clock) = (&report.comparison.rows, report.comparison.clock());
    let all: Vec<Vec<Answer>> = groups.iter().map(|group| answers(rows, &group.rows)).collect();
    let best = all.first().and_then(|own| own.iter().rev().find_map(|answer| Some((answer, answer.candidate?))));
    let words = match best {
        None => "<p class=\"answer\">No candidate is accurate enough to be named.</p>\n".into(),
        Some((answer, best)) => {
            let within = groups[0].rows.iter().map(|&index| &rows[index]);
            let within = within.filter(|row| row.point().1 <= answer.error_at_most);
            let slowest = within.map(Row::time).max_by(|a, b| a.median.total_cmp(&b.median));
            let time = rows[best].time();
            let slowest = slowest.unwrap_or(time);
            let [low, high] = [slowest.interval[0] / time.interval[1], slowest.interval[1] / time.interval[0]];
            format!(
                "<p class=\"answer\">The fastest candidate within an error of {} is <b>{}</b>: {} ms {clock}, {} <small>[{}, {}]</small> \
                 times faster than the slowest that gets there.</p>\n",
                answer.error_at_most,
                escape(&rows[best].candidate.label()),
                spread(&time),
                short(slowest.median / time.median),
                short(low),
                short(high)
            )
        }
    };
    let line = |answer: &Answer| match answer.candidate.map(|index| &rows[index]) {
        None => format!("<tr><td class=\"n\">{}<td colspan=\"6\">none", answer.error_at_most),
        Some(row) => format!(
            "<tr><td class=\"n\">{}<td>{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"wrap\">{}",
            answer.error_at_most,
            escape(&row.candidate.label()),
            spread(&row.time()),
            short(row.metrics.errors.rmse),
            short(row.metrics.flip),
            short(row.metrics.psnr),
            labels(rows, &answer.not_separable),
        ),
    };
    let lines: Vec<String> = groups
        .iter()
        .zip(&all)
        .enumerate()
        .map(|(number, (group, answers))| {
            format!("{}{}", heading(number, group, 7), answers.iter().map(line).collect::<Vec<_>>().join("\n"))
        })
        .collect();
    format!(
        "{words}<div class=\"scroll\"><table><tr><th class=\"n\">error at most<th>fastest candidate<th class=\"n\">ms {clock}\
         <th class=\"n\">RMSE<th class=\"n\">FLIP<th class=\"n\">PSNR, dB<th>not separable</tr>\n{}\n</table></div>\n\
         <p class=\"note\">The error is the root mean square over R, G, B and A of premultiplied linear RGBA, against the reference of \
         the candidate's own scene. Times are medians with their 95 % interval; of fewer than six runs, with all of them. <i>Not \
         separable</i>: candidates within the same error whose interval overlaps, so that these runs do not tell which is faster. \
         A slice format that could lose more than the error by its rounding alone is not offered here, whatever was measured.</p>\n",
        lines.join("\n")
    )
}

/// The line of a table above the rows of a truth.
pub fn heading(number: usize, group: &Group, columns: usize) -> String {
    let own = if group.truth.is_own { ", the scene's own" } else { "" };
    format!("<tr><th colspan=\"{columns}\">Truth {number}{own}: {}</tr>\n", escape(&group.truth.pattern))
}

/// The labels of some rows, of many the first.
fn labels(rows: &[Row], indices: &[usize]) -> String {
    let named: Vec<String> = indices.iter().take(LABELS).map(|&index| escape(&rows[index].candidate.label())).collect();
    match indices.len() {
        0 => "–".into(),
        count if count > LABELS => format!("{}; and {} more", named.join("; "), count - LABELS),
        _ => named.join("; "),
    }
}

#[cfg(test)]
mod tests {
    use super::super::examples;
    use super::*;

    fn told(report: &Report) -> String {
        fastest(report, &report.comparison.groups())
    }

    #[test]
    fn the_answer_is_the_fastest_within_the_bound_and_excludes_what_may_lose_more() {
        let text = told(&examples::report());
        // Segments of 16 samples have an error of 1/256, points of 16 one of 1/16, at the same time.
        assert!(
            text.contains("fastest candidate within an error of 0.001 is <b>encoded 64³, march, segment, 32 samples"),
            "{text}"
        );
        assert!(text.contains("<td class=\"n\">0.01<td>encoded 64³, march, segment, 16 samples"), "{text}");
        let mut slices = examples::report();
        slices.comparison.rows.retain(|row| {
            let label = row.candidate.label();
            label.starts_with("encoded") && label.contains("8-bit")
        });
        let text = told(&slices);
        assert!(text.contains("0.1<td>encoded 64³, slices, point, 8-bit, 16 samples"), "16/510 is within 0.1: {text}");
        assert!(text.contains("0.01<td colspan"), "no 8 bits can promise it: {text}");
    }

    #[test]
    fn what_the_times_do_not_tell_apart_stands_beside_the_fastest() {
        let mut report = examples::report();
        let label = "encoded 64³, march, point, 32 samples";
        for row in report.comparison.rows.iter_mut().filter(|row| row.truth.is_own) {
            // One other takes as long as the fastest, and all others longer.
            let like = row.candidate.label() == label || row.candidate.label().contains("march, segment, 32");
            row.runs.iter_mut().enumerate().for_each(|(run, time)| {
                time.gpu_ms = if like { 30.0 + run as f64 } else { time.gpu_ms + 90.0 };
            });
        }
        let text = told(&report);
        let of =
            |bound: &str| text.lines().find(|line| line.contains(&format!("<td class=\"n\">{bound}<td>"))).unwrap();
        assert!(of("0.1").ends_with("<td class=\"wrap\">encoded 64³, march, segment, 32 samples"), "{text}");
        assert!(of("0.001").ends_with("<td class=\"wrap\">–"), "points of 32 samples are not within 0.001: {text}");
    }
}
