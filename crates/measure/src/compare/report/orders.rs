//! The observed orders of a report, beside theory.

use super::Report;
use super::data::{CurveRows, curves};
use super::page::{escape, short};
use crate::compare::front::Order;
use crate::compare::theory::{Theory, theory};

/// The section of the page.
pub fn orders(report: &Report) -> String {
    let line = |(curve, indices, order): CurveRows| {
        let theory = theory(&report.comparison.rows[indices[0]].candidate.scene);
        let (value, points, floor) = match order {
            None => ("–".into(), "–".into(), "–".into()),
            Some(order) => {
                let doubt =
                    order.plus_minus.map_or("<small>(two points)</small>".into(), |half| format!("± {half:.2}"));
                let floor = order.floor.map_or("none seen".into(), short);
                (format!("{:.2} {doubt}", order.order), order.points.to_string(), floor)
            }
        };
        format!(
            "<tr><td>{}<td class=\"n\">{}<td class=\"n\">{value}<td class=\"n\">{points}<td class=\"n\">{floor}<td>{}",
            escape(&curve.label()),
            indices.len(),
            expected(theory, order)
        )
    };
    let lines: Vec<String> = curves(report).into_iter().map(line).collect();
    format!(
        "<h2>Observed order</h2>\n<p>The error falls like samples<sup>−order</sup>: least squares over the samples above the \
         floor, with the 95 % interval. The floor is where more samples no longer help: what is left is the block of noise, \
         the format or the field. ≠: observation and theory disagree by more than that interval, as few samples may before \
         a step is finer than the matter.</p>\n<details{}><summary>{} curves</summary><div class=\"scroll\"><table><tr><th>curve\
         <th class=\"n\">samples<th class=\"n\">order<th class=\"n\">of points<th class=\"n\">floor, RMSE<th>in theory</tr>\n{}\n</table></div></details>\n",
        if lines.len() <= 16 { " open" } else { "" },
        lines.len(),
        lines.join("\n")
    )
}

/// Theory in words, and whether it disagrees with what is observed.
fn expected(theory: Option<Theory>, observed: Option<Order>) -> String {
    let Some(theory) = theory else { return "not known".into() };
    let mark = match observed {
        Some(seen) if theory.contradicts(seen.order, seen.plus_minus) => "<b>≠</b> ",
        _ => "",
    };
    let [low, high] = theory.order;
    let orders = if low == high { format!("{low}") } else { format!("{low} to {high}") };
    format!("{mark}{orders}: {}", theory.why)
}

#[cfg(test)]
mod tests {
    use super::super::examples;
    use super::*;

    #[test]
    fn theory_stands_beside_observation_and_a_disagreement_is_marked() {
        // Fire has a core; the errors of the example are 1 / samples by points, 1 / samples^2 by segments.
        let mut report = examples::report();
        let text = orders(&report);
        let row = |text: &str, curve: &str| text.lines().find(|line| line.contains(curve)).unwrap().to_string();
        assert!(row(&text, "encoded 64³, march, point").ends_with("<td>1: a step cuts the hard core"), "{text}");
        assert!(row(&text, "encoded 64³, march, segment").ends_with("<td>2: the density is linear within the step"));
        assert_eq!(text.matches("<b>≠</b>").count(), 0);
        for row in &mut report.comparison.rows {
            row.metrics.errors.rmse = f64::from(row.candidate.samples()).powf(-2.0);
        }
        let text = orders(&report);
        assert!(
            row(&text, "encoded 64³, march, point").ends_with("<td><b>≠</b> 1: a step cuts the hard core"),
            "{text}"
        );
        assert!(!row(&text, "encoded 64³, march, segment").contains('≠'));
    }
}
