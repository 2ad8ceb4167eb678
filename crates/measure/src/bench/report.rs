//! The table of a run, and changes since a saved one.

use super::timed::{Bench, Timed};
use crate::compare::timing::Spread;
use std::fmt::Write as _;

/// Smallest relative change that is reported; the place of a program in memory changes times as much.
const CHANGE: f64 = 0.05;

/// Runs of different machines, which cannot be compared.
#[derive(Debug, PartialEq, thiserror::Error)]
#[error("it was measured on {saved}; this is {now}")]
pub struct Mismatch {
    saved: String,
    now: String,
}

/// A row whose time changed.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// Name.
    pub name: String,
    /// New time divided by the saved one; above 1 means slower.
    pub times: f64,
}

/// Rows whose times changed by more than the spread of both and by more than 5 %.
///
/// # Errors
/// The device, the driver or the number of threads differ.
pub fn changes(saved: &Bench, now: &Bench) -> Result<Vec<Change>, Mismatch> {
    let machine = |bench: &Bench| {
        let environment = &bench.environment;
        format!("{}, {}, {} threads", environment.device, environment.driver, environment.threads)
    };
    if machine(saved) != machine(now) {
        return Err(Mismatch { saved: machine(saved), now: machine(now) });
    }
    let change = |row: &Timed| {
        let before = saved.rows.iter().find(|other| other.name == row.name)?;
        let [before, after] = [before, row].map(|row| row.steadiest(now.on_processor));
        let times = after.median / before.median;
        let is_change = !before.overlaps(&after) && !(1.0 - CHANGE..=1.0 + CHANGE).contains(&times);
        is_change.then(|| Change { name: row.name.clone(), times })
    };
    Ok(now.rows.iter().filter_map(change).collect())
}

fn cell(spread: Option<Spread>, digits: usize) -> String {
    let text =
        |Spread { median, interval: [low, high], .. }| format!("{median:.digits$} ({low:.digits$} to {high:.digits$})");
    spread.map_or("-".into(), text)
}

/// The times as tables in Markdown, one for each group.
pub fn table(bench: &Bench) -> String {
    let environment = &bench.environment;
    let mut text = format!(
        "{} ({}), {} threads, hypertexture {}, {}\nmilliseconds: median (95 % interval of it, or all runs where they are \
         fewer than 6); processor: user and system of all threads\n",
        environment.device, environment.driver, environment.threads, environment.version, environment.date
    );
    let mut part = "";
    for row in &bench.rows {
        let (group, name) = row.name.split_once('/').unwrap_or(("", &row.name));
        if group != part {
            part = group;
            let _ = write!(
                text,
                "\n| {group} | device | processor | wall | takes so many times as long as | GeForce 6800 GT |\n|---|---|---|---|---|---|\n"
            );
        }
        let against = row.against.as_ref();
        let against = against.map_or(String::new(), |other| format!("{} {}", cell(Some(other.times), 2), other.what));
        let paper = row.paper_ms.map_or(String::new(), |ms| format!("{ms:.1}"));
        let [device, processor, wall] =
            [row.device_ms, row.processor_ms, Some(row.wall_ms)].map(|spread| cell(spread, 1));
        let _ = writeln!(text, "| {name} | {device} | {processor} | {wall} | {against} | {paper} |");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::timed::Against;

    fn bench(name: &str, processor: &[f64], device: &[f64]) -> Bench {
        let (device_ms, processor_ms) = (Some(Spread::of(device)), Some(Spread::of(processor)));
        let row = Timed {
            name: name.into(),
            device_ms,
            processor_ms,
            wall_ms: Spread::of(&[9.0]),
            against: None,
            paper_ms: None,
        };
        Bench { on_processor: true, rows: vec![row], ..Bench::default() }
    }

    #[test]
    fn a_change_exceeds_the_spread_and_5_percent() {
        let saved = bench("effects/lit", &[10.0, 10.1, 10.2], &[5.0]);
        let now = |times: &[f64]| changes(&saved, &bench("effects/lit", times, &[50.0])).unwrap();
        assert_eq!(now(&[10.2, 11.0, 12.0]), [], "the spreads meet");
        assert_eq!(now(&[10.3, 10.4, 10.5]), [], "3 %");
        let slower = now(&[12.0, 12.12, 12.3]);
        assert_eq!((slower.len(), (slower[0].times * 100.0).round()), (1, 120.0));
        assert!(now(&[5.0, 5.05, 5.1])[0].times < 0.51);
        assert_eq!(changes(&saved, &bench("effects/fur", &[99.0], &[9.0])).unwrap(), [], "a row that was not there");
        let mut gpu = [saved.clone(), bench("effects/lit", &[10.0], &[9.0])];
        gpu.iter_mut().for_each(|bench| bench.on_processor = false);
        assert_eq!(changes(&gpu[0], &gpu[1]).unwrap()[0].times, 9.0 / 5.0, "of a graphics card, its own time counts");
    }

    #[test]
    fn another_device_is_not_a_baseline() {
        let now = bench("effects/lit", &[1.0], &[1.0]);
        let mut saved = now.clone();
        saved.environment.device = "another".into();
        assert!(changes(&saved, &now).is_err());
    }

    #[test]
    fn a_bench_survives_json_and_its_table_has_every_row() {
        let mut bench = bench("effects/lit", &[10.0, 12.0], &[5.0]);
        bench.rows[0].against = Some(Against { what: "its fetches alone".into(), times: Spread::of(&[2.0]) });
        bench.rows[0].paper_ms = Some(13.8);
        let read: Bench = serde_json::from_str(&serde_json::to_string(&bench).unwrap()).unwrap();
        assert_eq!(read, bench);
        let text = table(&bench);
        let row = "| lit | 5.0 (5.0 to 5.0) | 11.0 (10.0 to 12.0) | 9.0 (9.0 to 9.0) | 2.00 (2.00 to 2.00) its fetches alone | 13.8 |";
        assert!(text.contains(row), "{text}");
    }
}
