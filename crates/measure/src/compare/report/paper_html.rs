//! The paper's Table 3 beside ours, and its Fig. 8, as parts of the page.

use super::page::{escape, short};
use super::{Report, images};
use crate::compare::front::cheapest;
use crate::compare::paper::conclusions::{Block, balance};
use crate::compare::paper::{COLUMNS, Cell, TABLE_3, Table};
use crate::compare::{BACKGROUND, Row};
use hypertexture::scene::{Integration, Pass};
use std::collections::BTreeMap;
use std::sync::Arc;

/// The paper's table beside ours, with the errors that it lacks.
pub fn table_3(report: &Report) -> String {
    let Some(table) = &report.table else { return String::new() };
    let columns: Vec<String> = COLUMNS
        .iter()
        .map(|([width, height], smooth)| {
            let sampling = if *smooth { format!("8x <small>(ours {}x)</small>", table.sampling) } else { "0x".into() };
            format!("<th class=\"n\">{width} × {height}<br>{sampling}")
        })
        .collect();
    let lines: Vec<String> = (0..TABLE_3.len()).map(|row| line(report, table, row)).collect();
    format!(
        "<h2>The paper's Table 3</h2>\n<p>Frames per second for ways to get turbulence: the paper's on an ATI Radeon 9700 Pro, and \
         <b>ours</b> on this device, with the error that the paper does not tell. Both draw slices; ours are {} of 8 bits.</p>\n\
         <div class=\"scroll\"><table><tr><th>turbulence<br><small>paper · <b>ours</b></small>{}<th class=\"n\">RMSE<br><small>of its octaves</small><th class=\"n\">FLIP<th class=\"n\">same error,<br>best of this page</tr>\n{}\n</table></div>\n\
         <p>{}</p>\n<p class=\"note\">≈: in proportion to the first column, not drawn, as one picture would take longer than 8 s. –: \
         not measured. 8x of the paper is antialiasing and anisotropic filtering; ours shades every sample. The errors are \
         those of the same candidate at the size of this page; the last column says how many times faster a candidate of the \
         same truth has no larger error.</p>\n",
        table.slices,
        columns.concat(),
        lines.join("\n"),
        ratios(table),
    )
}

fn line(report: &Report, table: &Table, row: usize) -> String {
    let (name, module, paper) = TABLE_3[row];
    let cell = |column: usize| {
        let own = match table.rows[row][column] {
            Cell::Missing => "–".into(),
            cell => {
                let mark = if matches!(cell, Cell::Scaled(_)) { "≈ " } else { "" };
                format!("{mark}<b>{}</b>", cell.rate().map_or("–".into(), short))
            }
        };
        let doubt = match table.rows[row][column] {
            Cell::Measured(time) => {
                format!("<br><small>[{}, {}]</small>", short(1e3 / time.interval[1]), short(1e3 / time.interval[0]))
            }
            _ => String::new(),
        };
        format!("<td class=\"n\">{:.2} · {own}{doubt}", paper[column])
    };
    let cells: String = (0..COLUMNS.len()).map(cell).collect();
    let rows = &report.comparison.rows;
    let errors = match table.errors[row] {
        None => format!("<td class=\"n\" colspan=\"3\"><small>no module <code>{module}</code> was measured</small>"),
        Some(index) => {
            let row = &rows[index];
            let (time, error) = row.point();
            let like = rows.iter().filter(|other| Arc::ptr_eq(&other.truth, &row.truth));
            let points: Vec<(f64, f64)> = like.map(Row::point).collect();
            let best = cheapest(&points, error).map_or(time, |best| points[best].0);
            format!(
                "<td class=\"n\">{}<br><small>{}</small><td class=\"n\">{}<td class=\"n\">{} times faster",
                short(row.metrics.errors.rmse),
                row.metrics.own_rmse.map_or("–".into(), short),
                short(row.metrics.flip),
                short(time / best)
            )
        }
    };
    format!("<tr><td>{}{cells}{errors}", escape(name))
}

/// How much longer than the encoded texture the others took, there and here, at 300 x 300 without smoothing.
fn ratios(table: &Table) -> String {
    let last = TABLE_3.len() - 1;
    let ours = |row: usize| Some(table.rows[last][0].rate()? / table.rows[row][0].rate()?);
    let words: Vec<String> = (0..last)
        .filter_map(|row| {
            let theirs = TABLE_3[last].2[0] / TABLE_3[row].2[0];
            Some(format!("{} {} times as long (paper: {})", TABLE_3[row].0, short(ours(row)?), short(theirs)))
        })
        .collect();
    match words.is_empty() {
        true => String::new(),
        false => format!("Against the encoded texture at 300 × 300, 0x: {}.", words.join("; ")),
    }
}

/// Which block of noise is the best balance (MJ 7), where several were tried: by the scene's own strategy, on rays, with the
/// most samples that several have.
pub fn blocks(report: &Report) -> String {
    let comparison = &report.comparison;
    let own = &comparison.scene.effect;
    let rows = comparison.rows.iter().filter(|row| {
        let (curve, other) = (row.candidate.curve(), &row.candidate.scene.effect);
        curve.pass == Pass::March && (&other.turbulence, &other.noise) == (&own.turbulence, &own.noise)
    });
    let mut tried: BTreeMap<(u32, bool), Vec<Block>> = BTreeMap::new();
    for row in rows {
        let (curve, error) = (row.candidate.curve(), row.metrics.errors.rmse);
        let key = (row.candidate.samples(), curve.integration == Integration::Segment);
        tried.entry(key).or_default().extend(curve.block.map(|side| Block { side, time: row.time(), error }));
    }
    let most = tried.values().rev().find(|blocks| blocks.len() > 1);
    let said = most.and_then(|blocks| balance(blocks));
    said.map_or(String::new(), |said| format!("<h2>The paper's block of noise</h2>\n<p>{}</p>\n", escape(&said)))
}

/// The pictures of Fig. 8 that there are modules for.
pub fn crops(report: &Report) -> String {
    if report.crops.is_empty() {
        return String::new();
    }
    let background = report.comparison.scene.image.background.unwrap_or(BACKGROUND);
    let figures: Vec<String> = report
        .crops
        .iter()
        .map(|crop| {
            let pixels: Vec<[f64; 4]> = crop.frame.pixels.iter().map(|pixel| pixel.map(f64::from)).collect();
            format!(
                "<figure><img src=\"{}\" alt=\"{}\"><figcaption><b>{}</b><br><span>{}</span></figcaption></figure>",
                images::picture(&pixels, crop.frame.size, background),
                crop.caption,
                crop.caption,
                crop.drawn
            )
        })
        .collect();
    format!(
        "<h2>The paper's Fig. 8</h2>\n<p>The same part of the picture, close, by strategy and octaves.</p>\n\
         <div class=\"pictures four\">\n{}\n</div>\n",
        figures.join("\n")
    )
}

#[cfg(test)]
mod tests {
    use super::super::examples;
    use super::*;
    use crate::compare::timing::Spread;

    #[test]
    fn m56_the_paper_s_numbers_stand_beside_ours_with_their_error() {
        let mut report = examples::report();
        let mut rows = [[Cell::Missing; 4]; 4];
        rows[0][0] = Cell::Measured(Spread::of(&[500.0]));
        rows[0][2] = Cell::Scaled(5000.0);
        rows[3][0] = Cell::Measured(Spread::of(&[100.0]));
        let paper = |label: &str| report.comparison.rows.iter().position(|row| row.candidate.label() == label);
        let errors = [None, None, None, paper("encoded 64³, slices, point, 8-bit, 64 samples")];
        assert!(errors[3].is_some());
        report.table = Some(Table { slices: 64, sampling: 4, rows, errors });
        let text = table_3(&report);
        assert!(text.contains("2.45 · <b>2.00</b>") && text.contains("0.49 · ≈ <b>0.200</b>"), "{text}");
        assert!(text.contains("23.24 · <b>10.0</b>") && text.contains("5.26 · –"));
        assert!(text.contains("8 noise lookups 5.00 times as long (paper: 9.49)"), "{text}");
        assert!(
            text.contains("<td class=\"n\">0.0156<br><small>0.00781</small><td"),
            "the error of 64 points is 1/64: {text}"
        );
        assert!(text.contains("3.99 times faster"), "16 segments have a smaller error: {text}");
        assert!(text.contains("no module <code>lookups8</code>"));
    }

    #[test]
    fn m60_the_best_block_is_concluded_from_the_rows() {
        let mut report = examples::report();
        assert_eq!(blocks(&report), "", "one block alone is no choice");
        // Rays of segments with 64 samples: the same time, so that the smallest error decides.
        let has = |row: &&Row| row.candidate.label() == "encoded 64³, march, segment, 64 samples";
        let known = report.comparison.rows.iter().find(has).unwrap().clone();
        for (side, factor) in [(32, 3.0), (128, 0.5)] {
            let mut row = known.clone();
            row.candidate.scene.quality.block_size = side;
            row.metrics.errors.rmse *= factor;
            report.comparison.rows.push(row);
        }
        let text = blocks(&report);
        assert!(text.contains("128³ is the best balance of error and time, where the paper has 64³"), "{text}");
        report.comparison.rows.last_mut().unwrap().runs.iter_mut().for_each(|run| run.gpu_ms *= 9.0);
        let text = blocks(&report);
        assert!(text.contains("64³ is the best balance of error and time, as in the paper"), "{text}");
    }

    #[test]
    fn without_turbulence_there_is_no_table() {
        assert_eq!(table_3(&examples::report()) + &crops(&examples::report()), "");
    }
}
