//! The table of a run, and changes since a saved one.

use super::roofline::Peaks;
use super::suite::BETTER_STAGE;
use super::timed::{Bench, Floor, Timed};
use crate::compare::timing::Spread;
use std::fmt::Write as _;

/// Smallest relative change that is reported; the place of a program in memory changes times as much.
const CHANGE: f64 = 0.05;

/// Time of `quality.stage = "auto"` that is allowed, in times of the better stage.
const AUTO: f64 = 1.05;

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
    if let Some(Peaks { operations, fetches }) = bench.peaks {
        let [operations, fetches] = [operations, fetches].map(|each| each * 1e-6);
        let _ = writeln!(
            text,
            "peaks of the device: {operations:.0} G operations (fma counts two) and {fetches:.3} G trilinear fetches a second\n\
             floor: the time of the operations and fetches that a picture executes, each at its peak; the longer of both"
        );
    }
    let mut part = "";
    for row in &bench.rows {
        let (group, name) = row.name.split_once('/').unwrap_or(("", &row.name));
        if group != part {
            part = group;
            let _ = write!(
                text,
                "\n| {group} | device | processor | wall | relative time | GeForce 6800 GT | samples with matter | operations | fetches | x lower bound |\n\
                 |---|---|---|---|---|---|---|---|---|---|\n"
            );
        }
        let against = row.against.as_ref();
        let against = against.map_or(String::new(), |other| format!("{} {}", cell(Some(other.times), 2), other.what));
        let paper = row.paper_ms.map_or(String::new(), |ms| format!("{ms:.1}"));
        let [device, processor, wall] =
            [row.device_ms, row.processor_ms, Some(row.wall_ms)].map(|spread| cell(spread, 1));
        let floor = row.floor.map_or("- | - | - | -".into(), |Floor { counts, times, .. }| {
            let [samples, operations, fetches] = [counts.samples, counts.operations, counts.fetches].map(|n| n * 1e-6);
            format!("{samples:.2} M | {operations:.0} M | {fetches:.1} M | {times:.1}")
        });
        let _ = writeln!(text, "| {name} | {device} | {processor} | {wall} | {against} | {paper} | {floor} |");
    }
    let of_auto = |row: &&Timed| row.against.as_ref().is_some_and(|other| other.what == BETTER_STAGE);
    let times = |row: &Timed| row.against.as_ref().map_or(0.0, |other| other.times.median);
    let autos: Vec<&Timed> = bench.rows.iter().filter(of_auto).collect();
    let slow: Vec<&str> = autos.iter().filter(|row| times(row) > AUTO).map(|row| &*row.name).collect();
    if !autos.is_empty() {
        let all = autos.len();
        let _ = writeln!(
            text,
            "\nauto takes more than {AUTO} times the better stage in {} of {all} rows{}{}",
            slow.len(),
            if slow.is_empty() { "" } else { ": " },
            slow.join("; ")
        );
    }
    for failure in &bench.failures {
        let _ = writeln!(text, "\nnot timed: {failure}");
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bench::roofline::Counts;
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
            floor: None,
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
        let counts = Counts { samples: 1.5e6, operations: 2e9, fetches: 3e6 };
        bench.rows[0].floor = Some(Floor { counts, ms: 5.0, times: 2.2 });
        let read: Bench = serde_json::from_str(&serde_json::to_string(&bench).unwrap()).unwrap();
        assert_eq!(read, bench);
        let text = table(&bench);
        let row = "| lit | 5.0 (5.0 to 5.0) | 11.0 (10.0 to 12.0) | 9.0 (9.0 to 9.0) | 2.00 (2.00 to 2.00) its fetches alone | 13.8 | 1.50 M | 2000 M | 3.0 M | 2.2 |";
        assert!(text.contains(row) && !text.contains("auto"), "{text}");
        for (times, slow) in [(1.05, "in 0 of 1 rows\n"), (1.06, "in 1 of 1 rows: effects/lit\n")] {
            bench.rows[0].against = Some(Against { what: BETTER_STAGE.into(), times: Spread::of(&[times]) });
            let text = table(&bench);
            assert!(text.contains(&format!("auto takes more than 1.05 times the better stage {slow}")), "{text}");
        }
    }
}
