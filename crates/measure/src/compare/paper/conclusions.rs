//! The paper's conclusions (MJ 7) beside the figures that were measured.
//!
//! Invariant: every number is one of the tables; a conclusion whose numbers are missing is left out.

use super::numbers::{BEST_BLOCK, CARDS, EFFECTS, FULL_SCREEN, FX_5900, SOFTWARE_SECONDS};
use super::replay::{BLOCK_SHEET, DISCARD_SHEET, EFFECTS_SHEET, Replay, Row, Sheet, TURBULENCE_SHEET};
use super::{Cell, TABLE_3};
use crate::compare::digits::short;
use crate::compare::timing::Spread;
use serde::Serialize;

/// Frames per second from which on a sequence counts as real time: those of the cinema.
const REAL_TIME: f64 = 24.0;
/// Ratios that count as marginal.
const MARGINAL: [f64; 2] = [0.9, 1.1];
/// Figures that are written out; of more, the least and the largest.
const MAX_FIGURES: usize = 4;

/// A claim of the paper beside the measurement.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Conclusion {
    /// The claim.
    pub claim: String,
    /// The paper's figures.
    pub paper: String,
    /// Ours.
    pub ours: String,
    /// Agreement of both.
    pub verdict: String,
}

/// A block of noise that was tried.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Block {
    /// Texels along a side.
    pub side: u32,
    /// Milliseconds of a picture.
    pub time: Spread,
    /// Its root mean square error.
    pub error: f64,
}

/// The conclusions of a replay of all tables.
pub fn conclusions(replay: &Replay) -> Vec<Conclusion> {
    let [effects, turbulence, discard, blocks] =
        [EFFECTS_SHEET, TURBULENCE_SHEET, DISCARD_SHEET, BLOCK_SHEET].map(|place| &replay.sheets[place]);
    let blocks: Vec<Block> = blocks.rows.iter().filter_map(|row| block(replay, row)).collect();
    let seconds: Figures = rates(replay, effects, 0).into_iter().map(|(name, rate)| (name, 1.0 / rate)).collect();
    let smoothing = |card: usize| EFFECTS.map(|row| row.2[card][0] / row.2[card][1]);
    let (samples, anisotropy) = replay.sampling.of(8);
    let equal = discard.rows.iter().filter(|row| same_picture(replay, row) == Some(true)).count();
    let bumps: Figures = replay.bumps.iter().map(|bump| (format!("k = {}", bump.k), bump.angle)).collect();
    let falls = replay.bumps.is_sorted_by(|a, b| a.k < b.k && a.angle > b.angle);
    let all = [
        reached(replay, "Real time", REAL_TIME, 0),
        reached(replay, "Full screen", FULL_SCREEN, 2),
        conclude(
            &format!("Seconds for a picture at {}, in software in 2002 (Satherley and Jones)", size(replay, 0)),
            format!("{SOFTWARE_SECONDS} s"),
            &seconds,
            |[_, slowest]| format!("{} times as fast", short(SOFTWARE_SECONDS / slowest)),
        ),
        conclude(
            &format!("Smoothing: times as long with 8x ({samples} samples, anisotropy {anisotropy}) as with 0x"),
            cards(|card| text(range(&smoothing(card)))),
            &ratios(replay, effects, [0, 1]),
            |own| beside(own, range([0, 1].map(smoothing).as_flattened())),
        ),
        conclude(
            "Smoothing: times as long with 8x as with 4x",
            "marginal".into(),
            &ratios(replay, turbulence, [1, 2]),
            |own| beside(own, MARGINAL),
        ),
        conclude(
            "Discard: times as long if fragments without matter are blended with alpha 0",
            format!("an FX 5900 that discards takes about {FX_5900} times as long as the 9700 Pro"),
            &ratios(replay, discard, [0, 1]),
            |_| format!("pictures equal bit for bit: {equal} of {}", discard.rows.len()),
        ),
        lookups(replay, turbulence),
        balance(&blocks),
        conclude("Eq. 7: degrees that the bumps turn the normal by", "less as k grows".into(), &bumps, |_| {
            if falls { "always less" } else { "NOT always less" }.into()
        }),
    ];
    all.into_iter().flatten().collect()
}

/// Measured values with their names.
type Figures = Vec<(String, f64)>;

/// A claim beside our figures; `None` without any. The verdict hears the least and the largest.
fn conclude(claim: &str, paper: String, ours: &Figures, verdict: impl Fn([f64; 2]) -> String) -> Option<Conclusion> {
    let mut sorted: Vec<&(String, f64)> = ours.iter().collect();
    sorted.sort_by(|a, b| a.1.total_cmp(&b.1));
    let (low, high) = (sorted.first()?, sorted.last()?);
    let figure = |(name, value): &(String, f64)| format!("{} ({name})", short(*value));
    let all = if sorted.len() > MAX_FIGURES {
        format!("{} to {}", figure(low), figure(high))
    } else {
        list(ours.iter().map(figure))
    };
    Some(Conclusion { claim: claim.into(), paper, ours: all, verdict: verdict([low.1, high.1]) })
}

fn list(texts: impl Iterator<Item = String>) -> String {
    texts.collect::<Vec<_>>().join(", ")
}

/// Least and largest.
fn range(values: &[f64]) -> [f64; 2] {
    values.iter().fold([f64::INFINITY, 0.0], |[low, high], &value| [value.min(low), value.max(high)])
}

fn text([low, high]: [f64; 2]) -> String {
    format!("{} to {}", short(low), short(high))
}

/// A measured range beside that of the paper.
fn beside(own: [f64; 2], paper: [f64; 2]) -> String {
    let verdict = if own[1] < paper[0] { "less" } else { "as in the paper" };
    if own[0] > paper[1] { "more".into() } else { verdict.into() }
}

/// Frames per second of a column of a sheet.
fn rates(replay: &Replay, sheet: &Sheet, column: usize) -> Figures {
    sheet.rows.iter().filter_map(|row| Some((row.name.clone(), replay.cell(row, column).rate()?))).collect()
}

/// Times of a column, in those of another, of the rows that were drawn in both: of what is in proportion the ratio is known
/// beforehand.
fn ratios(replay: &Replay, sheet: &Sheet, columns: [usize; 2]) -> Figures {
    let ratio = |row: &Row| match columns.map(|column| replay.cell(row, column)) {
        [Cell::Measured(before), Cell::Measured(after)] => Some((row.name.clone(), after.median / before.median)),
        _ => None,
    };
    sheet.rows.iter().filter_map(ratio).collect()
}

/// The window of a column of Tables 1 and 2.
fn size(replay: &Replay, column: usize) -> String {
    let [width, height] = replay.plan.pixels(replay.sheets[EFFECTS_SHEET].columns[column].window);
    let not = if replay.plan.scale == 1.0 { "" } else { " (not the paper's window)" };
    format!("{width} × {height}{not}")
}

/// Something of each of the paper's cards.
fn cards(of: impl Fn(usize) -> String) -> String {
    list(CARDS.iter().enumerate().map(|(card, name)| format!("{name} {}", of(card))))
}

/// How many effects reach a rate in a column of Tables 1 and 2.
fn reached(replay: &Replay, name: &str, limit: f64, column: usize) -> Option<Conclusion> {
    let sheet = &replay.sheets[EFFECTS_SHEET];
    let own = rates(replay, sheet, column);
    let reach = |rates: &[f64]| format!("{} of {}", rates.iter().filter(|rate| **rate >= limit).count(), rates.len());
    let paper = cards(|card| {
        let rates = EFFECTS.map(|row| row.2[card][column]);
        format!("{} ({})", text(range(&rates)), reach(&rates))
    });
    let scaled = sheet.rows.iter().any(|row| matches!(replay.cell(row, column), Cell::Scaled(_)));
    let scaled = if scaled { ", some in proportion to smaller windows" } else { "" };
    let claim = format!("{name}: {limit} frames per second at {}{scaled}", size(replay, column));
    let rates: Vec<f64> = own.iter().map(|(_, rate)| *rate).collect();
    conclude(&claim, paper, &own, |_| format!("{} effects", reach(&rates)))
}

/// Whether the pictures of a row's first two columns are equal bit for bit; `None` where one is missing.
pub fn same_picture(replay: &Replay, row: &Row) -> Option<bool> {
    let picture = |column: usize| replay.shots[row.shots.get(column).copied()??].picture.as_ref();
    Some(picture(0)? == picture(1)?)
}

/// How much longer than the encoded texture the other ways to get turbulence take, at 300 x 300 without smoothing.
pub fn lookups(replay: &Replay, sheet: &Sheet) -> Option<Conclusion> {
    let (encoded, others) = TABLE_3.split_last()?;
    let own = rates(replay, sheet, 0);
    let rate = |name: &str| own.iter().find(|(other, _)| other == name).map(|(_, rate)| *rate);
    let best = rate(encoded.0)?;
    let ours: Figures = others.iter().filter_map(|way| Some((way.0.into(), best / rate(way.0)?))).collect();
    let paper = list(others.iter().map(|way| format!("{} ({})", short(encoded.2[0] / way.2[0]), way.0)));
    conclude("Turbulence: times as long as one encoded texture", paper, &ours, |[least, _]| {
        if least >= 1.0 { "encoded is the fastest" } else { "encoded is NOT the fastest" }.into()
    })
}

fn block(replay: &Replay, row: &Row) -> Option<Block> {
    let Cell::Measured(time) = replay.cell(row, 0) else { return None };
    let side = row.name.trim_end_matches('³').parse().ok()?;
    Some(Block { side, time, error: row.errors.as_ref()?.as_ref().ok()?.rmse })
}

/// The block of noise with the best balance: the least square of its error times its time, as is usual for estimators;
/// blocks within the spread of its times are as good. `None` of fewer than two.
pub fn balance(blocks: &[Block]) -> Option<Conclusion> {
    let cost = |block: &Block, ms: f64| block.error.powi(2) * ms;
    let median = |block: &Block| cost(block, block.time.median);
    let best = blocks.iter().min_by(|a, b| median(a).total_cmp(&median(b))).filter(|_| blocks.len() > 1)?;
    let is_rival = |other: &&Block| {
        other.side != best.side && cost(other, other.time.interval[0]) <= cost(best, best.time.interval[1])
    };
    let rivals = list(blocks.iter().filter(is_rival).map(|other| format!("{}³", other.side)));
    let rivals = if rivals.is_empty() { rivals } else { format!("; as good within the spread of the times: {rivals}") };
    let tried = |block: &Block| format!("{} in {} ms ({}³)", short(block.error), short(block.time.median), block.side);
    Some(Conclusion {
        claim: "Blocks of noise: the best balance of error and time".into(),
        paper: format!("{BEST_BLOCK}³"),
        ours: list(blocks.iter().map(tried)),
        verdict: format!("{}³{rivals}", best.side),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::compare::paper::example::{example, rate};

    fn block(side: u32, times: &[f64], error: f64) -> Block {
        Block { side, time: Spread::of(times), error }
    }

    #[test]
    fn m60_the_best_block_has_the_least_squared_error_times_time() {
        // 0.02^2 x 90, 0.01^2 x 100, 0.0095^2 x 140: 0.036, 0.01, 0.0126.
        let blocks = [block(32, &[90.0; 7], 0.02), block(64, &[100.0; 7], 0.01), block(128, &[140.0; 7], 0.0095)];
        let found = balance(&blocks).unwrap();
        assert_eq!(found.ours, "0.0200 in 90.0 ms (32³), 0.0100 in 100 ms (64³), 0.00950 in 140 ms (128³)");
        assert_eq!((found.paper.as_str(), found.verdict.as_str()), ("64³", "64³"));
        // The larger block costs no time here: the paper is not confirmed, and the spread decides about rivals.
        let wide = [90.0, 95.0, 100.0, 100.0, 100.0, 130.0, 160.0];
        let found = balance(&[block(64, &wide, 0.01), block(128, &[100.0; 7], 0.0095), block(16, &[99.0; 7], 0.1)]);
        assert_eq!(found.unwrap().verdict, "128³; as good within the spread of the times: 64³");
        assert_eq!(balance(&[block(64, &[1.0], 0.1)]).or(balance(&[])), None);
    }

    /// Ours and the verdict of the claim with these words, of a replay in which ours is a tenth of the 9700 Pro, after a
    /// change.
    fn found(words: &str, change: impl FnOnce(&mut Replay)) -> Option<(String, String)> {
        let mut replay = example();
        change(&mut replay);
        let found = conclusions(&replay).into_iter().find(|found| found.claim.contains(words))?;
        Some((found.ours, found.verdict))
    }

    fn told(ours: &str, verdict: &str) -> Option<(String, String)> {
        Some((ours.into(), verdict.into()))
    }

    fn set(replay: &mut Replay, (sheet, row, column): (usize, usize, usize), cell: Cell) {
        let shot = replay.sheets[sheet].rows[row].shots[column].unwrap();
        replay.shots[shot].cell = cell;
    }

    #[test]
    fn m62_rates_are_held_against_real_time_and_full_screen() {
        // The paper's own: of the 9700 Pro two reach 24, Lit and Bump mapping.
        let paper = "9700 Pro 15.8 to 29.8 (2 of 6), 6800 GT 39.5 to 72.5 (6 of 6)";
        assert_eq!(conclusions(&example())[0].paper, paper);
        let slow = told("1.58 (Melting) to 2.98 (Lit rendering)", "0 of 6 effects");
        assert_eq!(found("Real time: 24 frames per second at 300 × 300", |_| ()), slow);
        let one = found("at 30 × 30 (not the paper's window)", |replay| {
            set(replay, (EFFECTS_SHEET, 3, 0), rate(30.0));
            replay.plan.scale = 0.1;
        });
        assert_eq!(one, told("1.58 (Melting) to 30.0 (Fur)", "1 of 6 effects"));
        let scaled = found("Full screen: 10 frames per second at 1024 × 768, some in proportion", |replay| {
            set(replay, (EFFECTS_SHEET, 1, 2), Cell::Scaled(90.0));
        });
        assert_eq!(scaled, told("0.343 (Fur) to 11.1 (Solid texturing)", "1 of 6 effects"));
    }

    #[test]
    fn m18_m56_m57_m58_the_other_conclusions_are_made_of_the_tables() {
        // 1 / 1.578 s against 50 s.
        assert_eq!(found("software", |_| ()), told("0.335 (Lit rendering) to 0.634 (Melting)", "78.9 times as fast"));
        // A tenth of the card has its ratios: 25.26 / 21.25 to 15.78 / 10.63.
        let smooth = told("1.19 (Bump mapping) to 1.48 (Melting)", "as in the paper");
        assert_eq!(found("8x (4 samples, anisotropy 8)", |_| ()), smooth);
        // The example's own 4x are in proportion, and say nothing.
        assert_eq!(found("as with 4x", |_| ()), None);
        let against = found("as with 4x", |replay| set(replay, (TURBULENCE_SHEET, 0, 1), rate(1.0)));
        assert_eq!(against, told("5.29 (8 noise lookups)", "more"), "1 against 0.189 frames per second");
        let lookups =
            told("9.49 (8 noise lookups), 3.25 (4 noise lookups), 1.01 (4 channel)", "encoded is the fastest");
        assert_eq!(found("Turbulence", |_| ()), lookups);
        let (ours, verdict) = found("Discard", |replay| {
            set(replay, (DISCARD_SHEET, 3, 1), rate(0.855));
            let kept = replay.sheets[DISCARD_SHEET].rows[3].shots[1].unwrap();
            replay.shots[kept].picture = Some("other".into());
        })
        .unwrap();
        assert!(ours.contains("2.00 (Fur)") && verdict.ends_with("5 of 6"), "{ours}: {verdict}");
        let bumps = told("80.0 (k = 0), 30.0 (k = 1.6), 2.50 (k = 20)", "always less");
        assert_eq!(found("Eq. 7", |_| ()), bumps);
        assert_eq!(found("Eq. 7", |replay| replay.bumps[1].angle = 1.0).unwrap().1, "NOT always less");
    }

    #[test]
    fn what_was_not_measured_is_not_concluded() {
        let mut replay = example();
        replay.shots.iter_mut().for_each(|shot| (shot.cell, shot.picture) = (Cell::Missing, None));
        replay.bumps.clear();
        assert_eq!(conclusions(&replay), []);
    }
}
