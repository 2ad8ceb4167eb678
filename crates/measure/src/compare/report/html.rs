//! The report as one page that needs nothing else: no script, no file beside it.

use super::chart::{Chart, svg};
use super::data::STEADIER;
use super::fastest::{fastest, heading};
use super::orders::orders;
use super::page::{circumstances, escape, short, spread, whole};
use super::paper_html::{blocks, crops, table_3};
use super::{Report, images, scene_text};
use crate::compare::answers::{Answer, answers};
use crate::compare::candidates::Candidate;
use crate::compare::{BACKGROUND, Group, Row};

/// The page, with a chart for each truth.
pub fn page(report: &Report, charts: &[Chart]) -> String {
    let groups = report.comparison.groups();
    let body = [
        head(report),
        fastest(report, &groups),
        truths(report, &groups),
        charted(charts, &groups),
        front_pictures(report, &groups),
        table_3(report),
        blocks(report),
        crops(report),
        orders(report),
        all_candidates(report, &groups),
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
    let (unsteady, measured) = (comparison.unsteady(), comparison.rows.len());
    if unsteady > 0 {
        text += &format!(
            "<div class=\"banner\"><b>Unsteady times</b>: of {unsteady} of {measured} candidates the 95th percentile exceeds the median \
             by more than a quarter (≋): {STEADIER}.</div>\n"
        );
    }
    text
}

/// Reference of the candidates, and its own error.
fn truths(report: &Report, groups: &[Group]) -> String {
    let line = |(number, group): (usize, &Group)| {
        let truth = &group.truth;
        format!(
            "<tr><td class=\"n\">{number}<td class=\"wrap\">{}{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{}<td class=\"n\">{:.1} %",
            escape(&truth.pattern),
            if truth.is_own { " <small>(the scene's own)</small>" } else { "" },
            group.rows.len(),
            short(truth.error()),
            short(truth.bound()),
            100.0 * truth.proven(),
        )
    };
    let lines: Vec<String> = groups.iter().enumerate().map(line).collect();
    format!(
        "<h2>Truths</h2>\n<p>Another noise pattern is another picture. So each has a reference of its own, in f64 with a tolerance \
         of {} a pixel, and its own front. What the reference itself is wrong by is told as a root mean square: as samples \
         estimate it, and with all the opacity that bounds leave open.</p>\n\
         <div class=\"scroll\"><table><tr><th class=\"n\">truth<th>noise pattern<th class=\"n\">candidates<th class=\"n\">estimated error\
         <th class=\"n\">with what is open<th class=\"n\">proven pixels</tr>\n{}\n</table></div>\n",
        short(report.tolerance),
        lines.join("\n")
    )
}

/// The charts: that of the scene's own truth, and the others to be opened.
fn charted(charts: &[Chart], groups: &[Group]) -> String {
    let one = |(number, (chart, group)): (usize, (&Chart, &Group))| {
        let open = if number == 0 { " open" } else { "" };
        let (title, count) = (escape(&chart.title), group.front.len());
        format!("<details{open}><summary>{title}: {count} on the front</summary>\n{}\n</details>\n", svg(chart))
    };
    let all: String = charts.iter().zip(groups).enumerate().map(one).collect();
    format!(
        "<h2>Error against time</h2>\n<p>Each line is one way to draw the scene with more and more samples; lower left is better. \
         Rings and steps mark the candidates that no other of the same truth beats in both error and time. Bars are the 95 % interval \
         of the median time, and what the error of the reference may change in the error; where there is none, the mark hides it.</p>\n{all}"
    )
}

/// The pictures of the front beside what is wrong with them.
fn front_pictures(report: &Report, groups: &[Group]) -> String {
    let comparison = &report.comparison;
    let background = comparison.scene.image.background.unwrap_or(BACKGROUND);
    let mut figures = Vec::new();
    for (index, frame) in &report.pictures {
        let row = &comparison.rows[*index];
        let truth = &row.truth.reference;
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
            "<figure><div>{}</div><figcaption><b>{label}</b><br><span>truth {}; {} ms, RMSE {}, FLIP {}</span></figcaption></figure>",
            images.concat(),
            groups.iter().position(|group| group.rows.contains(index)).unwrap_or_default(),
            short(row.time().median),
            short(row.metrics.errors.rmse),
            short(row.metrics.flip),
        ));
    }
    if figures.is_empty() {
        return String::new();
    }
    let [low, high] = images::HEAT;
    format!(
        "<h2>Along the front</h2>\n<p>Reference, candidate, and the largest difference of any channel of linear RGBA: {} \
         <img class=\"scale\" src=\"{}\" alt=\"scale of the differences\"> {}</p>\n<div class=\"pictures\">\n{}\n</div>\n",
        short(low),
        images::scale(),
        short(high),
        figures.join("\n")
    )
}

fn all_candidates(report: &Report, groups: &[Group]) -> String {
    let (rows, clock) = (&report.comparison.rows, report.comparison.clock());
    let answers: Vec<Answer> = groups.iter().flat_map(|group| answers(rows, &group.rows)).collect();
    let line = |(index, row): (usize, &Row)| {
        let m = &row.metrics;
        let class = if groups.iter().any(|group| group.front.contains(&index)) { " class=\"front\"" } else { "" };
        let like = answers.iter().filter(|answer| answer.not_separable.contains(&index));
        let like: Vec<String> = like.map(|answer| answer.error_at_most.to_string()).collect();
        let like = match like.is_empty() {
            true => String::new(),
            false => format!(" <small>not separable from the fastest within {}</small>", like.join(", ")),
        };
        let cell = |text: String| format!("<td class=\"n\">{text}");
        let angle = row.normals.map_or("–".into(), |angles| short(angles.mean));
        let cells = [
            spread(&row.time()),
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
            short(row.efficiency()),
            row.time().runs.to_string(),
        ];
        format!("<tr{class}><td>{}{like}{}", escape(&row.candidate.label()), cells.map(cell).concat())
    };
    let lines: Vec<String> = groups
        .iter()
        .enumerate()
        .flat_map(|(number, group)| {
            let of = group.rows.iter().map(|&index| line((index, &rows[index])));
            std::iter::once(heading(number, group, 15)).chain(of)
        })
        .collect();
    format!(
        "<h2>Every candidate</h2>\n<p class=\"note\">Bold: on the front of its truth. ≋: the 95th percentile of the times exceeds the median by more \
         than a quarter, so the machine was disturbed. <i>Blending</i> is what rounding between slices may add to the error, \
         known beforehand. RMSE, max and p99.9 are of all four channels of premultiplied linear RGBA; max and p99.9 of the worst \
         channel of a pixel. Efficiency is 1 / (RMSE² × seconds {clock}). Every run is in <code>runs.csv</code>, every digit in <code>candidates.csv</code>.</p>\n\
         <details><summary>{} rows</summary><div class=\"scroll\"><table><tr><th>candidate<th class=\"n\">ms {clock}\
         <th class=\"n\">ms in all<th class=\"n\">RMSE<th class=\"n\">of its octaves<th class=\"n\">max<th class=\"n\">p99.9<th class=\"n\">opacity RMSE\
         <th class=\"n\">PSNR, dB<th class=\"n\">SSIM<th class=\"n\">FLIP<th class=\"n\">normals, °<th class=\"n\">blending\
         <th class=\"n\">efficiency, 1/(MSE s)<th class=\"n\">runs</tr>\n{}\n</table></div></details>\n",
        rows.len(),
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
         say, <i>of the processor</i>, where the processor draws, what all its threads took, which other programs hardly change, <i>in all</i> is wall clock from the scene to pixels in memory, without compiling. A strategy that reads a block \
         is held against the noise that the block was made of, and a computed one against its own noise: they are different \
         noises, and each error is that of the candidate's own picture.</p>\n{}<details><summary>The scene</summary><pre>{}</pre></details>\n",
        circumstances(&report.environment, &[("scene, BLAKE3", report.hash.clone())]),
        escape(&scene_text(&report.comparison.scene))
    )
}

#[cfg(test)]
mod tests {
    use super::super::{charts, examples};
    use super::*;
    use crate::compare::Failure;

    fn whole_page(report: &Report) -> String {
        page(report, &charts(report))
    }

    #[test]
    fn what_failed_stands_at_the_top() {
        let mut report = examples::report();
        let good = whole_page(&report);
        assert!(!good.contains("FAILED") && !good.contains("Partial") && !good.contains("Unsteady"));
        let (label, message) = ("encoded".to_string(), "a <b> too many".to_string());
        report.comparison.failures.push(Failure { label, message });
        report.comparison.partial = true;
        report.comparison.rows[0].runs[6].gpu_ms *= 2.0;
        let bad = whole_page(&report);
        let place = |what: &str| bad.find(what).unwrap();
        assert!(["FAILED", "Partial", "Unsteady"].iter().all(|banner| place(banner) < place("fastest")));
        assert!(bad.contains("a &lt;b&gt; too many"));
        let count = report.comparison.rows.len();
        assert!(
            bad.contains(&format!("of 1 of {count} candidates"))
                && bad.contains("idle machine, with more runs (--repeat)")
        );
    }

    #[test]
    fn each_truth_has_its_own_front_and_what_it_is_wrong_by_itself() {
        let report = examples::report();
        let page = whole_page(&report);
        let place = |what: &str| page.find(what).unwrap_or_else(|| panic!("{what}: {page}"));
        assert!(place("Truth 0, the scene's own: own") < place("Truth 1: other"));
        assert!(page.contains("<summary>Truth 1: other: "), "a chart of its own");
        // An estimate of 1e-7 in all pixels, with an opacity of 1e-3 left open.
        assert!(
            page.contains("<td class=\"n\">1.00·10<sup>-7</sup><td class=\"n\">0.00100<td class=\"n\">100.0 %"),
            "{page}"
        );
        assert!(page.contains("<dt>command line<dd>hypertexture compare fire"));
        assert!(page.contains("<summary>The scene</summary><pre>") && page.contains("input = &quot;"));
        assert_eq!(page.matches("<details").count(), page.matches("</details>").count());
        // Points of the same samples take as long as segments.
        assert!(page.contains("<small>not separable from the fastest within 0.1"), "{page}");
        for group in report.comparison.groups() {
            let own = |&index: &usize| report.comparison.rows[index].truth.is_own == group.truth.is_own;
            assert!(!group.front.is_empty() && group.front.iter().chain(&group.rows).all(own));
        }
    }

    #[test]
    fn a_page_needs_no_script_and_nothing_beside_it() {
        let text = whole_page(&examples::report());
        for part in ["<script", "href=", "src=\"http", "{title}", "{body}"] {
            assert!(!text.contains(part), "{part}");
        }
        assert_eq!(text.matches("<table").count(), text.matches("</table>").count());
    }
}
