//! The paper's tables beside ours, as one page that needs nothing else.

use super::images;
use super::page::{circumstances, escape, whole};
use super::replay_grid::{Replayed, about, grid};
use crate::compare::BACKGROUND;
use crate::compare::paper::conclusions::{conclusions, digits};
use crate::compare::paper::numbers::CARDS;

/// The page.
pub fn page(report: &Replayed) -> String {
    let replay = &report.replay;
    let sheets: Vec<String> = (0..replay.sheets.len()).map(|place| sheet(report, place)).collect();
    let sentences: Vec<String> =
        conclusions(replay).iter().map(|sentence| format!("<li>{}", escape(sentence))).collect();
    let body = format!(
        "{}<h2>Conclusions</h2>\n<ul>\n{}\n</ul>\n{}{}{}",
        head(report),
        sentences.join("\n"),
        sheets.concat(),
        bumps(report),
        method(report)
    );
    whole("The paper's tables beside ours", &body)
}

fn head(report: &Replayed) -> String {
    let failures = report.replay.failures();
    let mut text = format!(
        "<h1>The paper's tables beside ours</h1>\n<p class=\"sub\">{}, {}</p>\n<p>{}</p>\n",
        escape(&report.object),
        escape(&report.environment.date),
        escape(&about(report))
    );
    if !failures.is_empty() {
        let lines: Vec<String> = failures.iter().map(|failure| format!("<br>{}", escape(failure))).collect();
        text +=
            &format!("<div class=\"banner\"><b>FAILED</b>: {} cells failed.{}</div>\n", failures.len(), lines.concat());
    }
    if report.replay.partial {
        text += "<div class=\"banner\"><b>Partial</b>: the replay was interrupted; what was measured until then is shown.</div>\n";
    }
    text
}

fn sheet(report: &Replayed, place: usize) -> String {
    let grid = grid(&report.replay, place, true);
    // Ours stands out from the paper's.
    let is_paper = |column: usize| CARDS.contains(&grid.head[column].as_str());
    let head: Vec<String> =
        grid.head.iter().enumerate().map(|(i, text)| format!("<th{}>{}", class(i), escape(text))).collect();
    let line = |row: &Vec<String>| {
        let cell = |(column, text): (usize, &String)| {
            let text = escape(text);
            let (value, spread) = text.split_once(" [").map_or((text.clone(), String::new()), |(value, spread)| {
                (value.into(), format!(" <small>[{spread}</small>"))
            });
            let value = if column == 0 || is_paper(column) { value } else { format!("<b>{value}</b>") };
            format!("<td{}>{value}{spread}", class(column))
        };
        format!("<tr>{}", row.iter().enumerate().map(cell).collect::<String>())
    };
    let lines: Vec<String> = grid.rows.iter().map(line).collect();
    format!(
        "<h2>{}</h2>\n<p class=\"note\">Frames per second; <b>ours</b> with the 95 % interval of the median. ≈: not drawn, as one \
         picture would take longer than 8 s: in proportion to pixels and samples of a smaller window. –: not measured.</p>\n\
         <div class=\"scroll\"><table><tr>{}</tr>\n{}\n</table></div>\n",
        escape(report.replay.sheets[place].title),
        head.concat(),
        lines.join("\n")
    )
}

fn class(column: usize) -> &'static str {
    if column == 0 { "" } else { " class=\"n\"" }
}

fn bumps(report: &Replayed) -> String {
    if report.replay.bumps.is_empty() {
        return String::new();
    }
    let background = report.replay.plan.effects[0].image.background.unwrap_or(BACKGROUND);
    let figures: Vec<String> = report
        .replay
        .bumps
        .iter()
        .map(|bump| {
            let pixels: Vec<[f64; 4]> = bump.frame.pixels.iter().map(|pixel| pixel.map(f64::from)).collect();
            let picture = images::picture(&pixels, bump.frame.size, background);
            let (k, angle) = (bump.k, digits(bump.angle));
            format!(
                "<figure><img src=\"{picture}\" alt=\"k = {k}\"><figcaption><b>k = {k}</b><br><span>{angle}° in the \
                 mean</span></figcaption></figure>"
            )
        })
        .collect();
    format!(
        "<h2>Eq. 7: k sets the severity</h2>\n<p>normalize(kV + B), V the normal of the volume and B that of the noise: the larger \
         k, the milder the bumps. Below each the mean angle between the normal that is shaded with and V.</p>\n\
         <div class=\"pictures four\">\n{}\n</div>\n",
        figures.join("\n")
    )
}

fn method(report: &Replayed) -> String {
    format!(
        "<h2>Method</h2>\n<p>Times are those of the device's timestamps. Scenes of a window are warmed up, and their runs are mixed \
         in random order, so that a slow moment of the machine slows all alike; no run is dropped. The paper's figures are \
         those that it prints, of a Pentium 4 at 2.8 GHz with the card.</p>\n{}",
        circumstances(&report.environment, &[])
    )
}
