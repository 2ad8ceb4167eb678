//! The paper's conclusions (MJ 7), drawn anew from what was measured.
//!
//! Invariant: every number in a sentence is one of the tables; a sentence whose numbers are missing is left out.

use super::numbers::{BEST_BLOCK, CARDS, EFFECTS, FULL_SCREEN, FX_5900, SOFTWARE_SECONDS};
use super::replay::{BLOCK_SHEET, DISCARD_SHEET, EFFECTS_SHEET, Replay, Row, Sheet, TURBULENCE_SHEET, WINDOWS, Window};
use super::{Cell, TABLE_3};
use crate::compare::timing::Spread;

/// Frames per second from which on a sequence counts as real time: those of the cinema.
pub const REAL_TIME: f64 = 24.0;

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

/// The conclusions, a sentence or two each.
pub fn conclusions(replay: &Replay) -> Vec<String> {
    let sheet = |place: usize| &replay.sheets[place];
    let blocks: Vec<Block> = sheet(BLOCK_SHEET).rows.iter().filter_map(|row| block(replay, row)).collect();
    [
        real_time(replay, sheet(EFFECTS_SHEET)),
        full_screen(replay, sheet(EFFECTS_SHEET)),
        software(replay, sheet(EFFECTS_SHEET)),
        smoothing(replay),
        discarded(replay, sheet(DISCARD_SHEET)),
        lookups(replay, sheet(TURBULENCE_SHEET)),
        balance(&blocks),
        bumps(replay),
    ]
    .into_iter()
    .flatten()
    .collect()
}

/// Three digits.
pub fn digits(value: f64) -> String {
    let power = if value == 0.0 || !value.is_finite() { 0.0 } else { value.abs().log10().floor() };
    if (-4.0..4.0).contains(&power) {
        format!("{value:.*}", (2.0 - power).max(0.0) as usize)
    } else {
        format!("{value:.2e}")
    }
}

/// Least and largest with their names.
fn ends(rates: &[(String, f64)]) -> Option<[&(String, f64); 2]> {
    let by = |a: &&(String, f64), b: &&(String, f64)| a.1.total_cmp(&b.1);
    Some([rates.iter().min_by(by)?, rates.iter().max_by(by)?])
}

/// Frames per second of a sheet in a window, by row; and whether all of them were drawn, not scaled.
fn rates(replay: &Replay, sheet: &Sheet, window: Window) -> (Vec<(String, f64)>, bool) {
    let Some(column) = sheet.columns.iter().position(|column| column.window == window) else {
        return (Vec::new(), true);
    };
    let cells: Vec<(String, Cell)> =
        sheet.rows.iter().map(|row| (row.name.clone(), replay.cell(row, column))).collect();
    let drawn = !cells.iter().any(|(_, cell)| matches!(cell, Cell::Scaled(_)));
    (cells.into_iter().filter_map(|(name, cell)| Some((name, cell.rate()?))).collect(), drawn)
}

/// Figures of one of the paper's cards in a column of Tables 1 and 2.
fn card(card: usize, column: usize) -> Vec<(String, f64)> {
    EFFECTS.iter().map(|row| (row.1.to_string(), row.2[card][column])).collect()
}

fn reach(rates: &[(String, f64)]) -> Vec<&str> {
    rates.iter().filter(|(_, rate)| *rate >= REAL_TIME).map(|(name, _)| name.as_str()).collect()
}

fn size(replay: &Replay, window: Window) -> String {
    let [width, height] = replay.plan.pixels(window);
    let not = if replay.plan.scale == 1.0 { "" } else { " (not the paper's window)" };
    format!("{width} × {height}{not}")
}

fn real_time(replay: &Replay, sheet: &Sheet) -> Option<String> {
    let (own, _) = rates(replay, sheet, WINDOWS[0]);
    let [slowest, fastest] = ends(&own)?;
    let fast = reach(&own);
    let verdict = match fast.len() {
        0 => "not real time on this device".to_string(),
        all if all == own.len() => "real time on this device".into(),
        _ => format!("real time on this device for {} alone", fast.join(", ")),
    };
    let cards: Vec<String> = (0..CARDS.len())
        .filter_map(|index| {
            let rates = card(index, 0);
            let [low, high] = ends(&rates)?.map(|end| digits(end.1));
            Some(format!("{} {low} to {high}, {} of {}", CARDS[index], reach(&rates).len(), rates.len()))
        })
        .collect();
    Some(format!(
        "Real time: {} frames per second ({}) to {} ({}) at {}, of {REAL_TIME} that the cinema has; {} of {} effects reach \
         them: {verdict}. The paper calls its own real time on all cards ({}).",
        digits(slowest.1),
        slowest.0,
        digits(fastest.1),
        fastest.0,
        size(replay, WINDOWS[0]),
        fast.len(),
        own.len(),
        cards.join("; "),
    ))
}

fn full_screen(replay: &Replay, sheet: &Sheet) -> Option<String> {
    let (own, drawn) = rates(replay, sheet, WINDOWS[3]);
    let [low, high] = ends(&own)?;
    let reach = own.iter().filter(|(_, rate)| *rate >= FULL_SCREEN).count();
    let scaled = if drawn { "" } else { ", some in proportion to smaller windows" };
    Some(format!(
        "Full screen: {} ({}) to {} ({}) frames per second at {}{scaled}; {reach} of {} effects reach the {FULL_SCREEN} of the \
         paper's conclusion.",
        digits(low.1),
        low.0,
        digits(high.1),
        high.0,
        size(replay, WINDOWS[3]),
        own.len(),
    ))
}

fn software(replay: &Replay, sheet: &Sheet) -> Option<String> {
    let (own, _) = rates(replay, sheet, WINDOWS[0]);
    let (name, rate) = ends(&own)?[0];
    let seconds = 1.0 / rate;
    let ratio = SOFTWARE_SECONDS / seconds;
    let (factor, word) = if ratio >= 1.0 { (ratio, "sooner") } else { (1.0 / ratio, "later") };
    Some(format!(
        "Software of 2002 (Satherley and Jones) took {SOFTWARE_SECONDS} s for 300 × 300; the slowest effect, {name}, takes {} s at \
         {}, {} times {word}.",
        digits(seconds),
        size(replay, WINDOWS[0]),
        digits(factor),
    ))
}

/// Least and largest ratio of the rates of two windows over the rows that were drawn in both: of what is in proportion
/// the ratio is known beforehand.
fn slowdown(replay: &Replay, sheet: &Sheet, windows: [Window; 2]) -> Option<[f64; 2]> {
    let place = |window| sheet.columns.iter().position(|column| column.window == window);
    let [before, after] = [place(windows[0])?, place(windows[1])?];
    let ratio = |row: &Row| match [before, after].map(|column| replay.cell(row, column)) {
        [Cell::Measured(before), Cell::Measured(after)] => Some(after.median / before.median),
        _ => None,
    };
    let ratios: Vec<f64> = sheet.rows.iter().filter_map(ratio).collect();
    let least = ratios.iter().copied().reduce(f64::min)?;
    Some([least, ratios.iter().copied().fold(least, f64::max)])
}

fn smoothing(replay: &Replay) -> Option<String> {
    let [low, high] = slowdown(replay, &replay.sheets[EFFECTS_SHEET], [WINDOWS[0], WINDOWS[2]])?.map(digits);
    let cards: Vec<String> = (0..CARDS.len())
        .filter_map(|index| {
            let ratios = EFFECTS.map(|row| (row.1.to_string(), row.2[index][0] / row.2[index][1]));
            let [low, high] = ends(&ratios)?.map(|end| digits(end.1));
            Some(format!("{} {low} to {high}", CARDS[index]))
        })
        .collect();
    let (samples, anisotropy) = replay.sampling.of(8);
    let marginal = slowdown(replay, &replay.sheets[TURBULENCE_SHEET], [WINDOWS[1], WINDOWS[2]]).map(|ends| {
        let [low, high] = ends.map(digits);
        format!(" 8x against 4x: {low} to {high} times (the paper: marginal).")
    });
    Some(format!(
        "Smoothing: 8x (here {samples} samples and anisotropy {anisotropy}) takes {low} to {high} times as long as 0x; {}.{}",
        cards.join(", "),
        marginal.unwrap_or_default()
    ))
}

fn discarded(replay: &Replay, sheet: &Sheet) -> Option<String> {
    let pair = |row: &Row| {
        let [a, b] = [0, 1].map(|column| replay.cell(row, column).rate());
        Some((row.name.clone(), a? / b?))
    };
    let ratios: Vec<(String, f64)> = sheet.rows.iter().filter_map(pair).collect();
    let [low, high] = ends(&ratios)?;
    let equal = sheet.rows.iter().filter(|row| same_picture(replay, row) == Some(true)).count();
    Some(format!(
        "Discard: blending fragments without matter with alpha 0 takes {} ({}) to {} ({}) times as long as discarding them; the \
         pictures are equal bit for bit for {equal} of {} effects. The paper blames the way its FX 5900 discards for taking \
         about {FX_5900} times as long as the 9700 Pro.",
        digits(low.1),
        low.0,
        digits(high.1),
        high.0,
        ratios.len(),
    ))
}

/// Whether the pictures of a row's first two columns are equal bit for bit; `None` where one is missing.
pub fn same_picture(replay: &Replay, row: &Row) -> Option<bool> {
    let picture = |column: usize| replay.shots[row.shots.get(column).copied()??].picture.as_ref();
    Some(picture(0)? == picture(1)?)
}

fn lookups(replay: &Replay, sheet: &Sheet) -> Option<String> {
    let (own, _) = rates(replay, sheet, WINDOWS[0]);
    let last = TABLE_3.len() - 1;
    let rate = |name: &str| own.iter().find(|(other, _)| other == name).map(|(_, rate)| *rate);
    let encoded = rate(TABLE_3[last].0)?;
    let ratios: Vec<String> = TABLE_3[..last]
        .iter()
        .filter_map(|(name, _, paper)| {
            Some(format!("{name} {} (paper: {})", digits(encoded / rate(name)?), digits(TABLE_3[last].2[0] / paper[0])))
        })
        .collect();
    (!ratios.is_empty()).then(|| format!("Turbulence, times as long as one encoded texture: {}.", ratios.join(", ")))
}

fn block(replay: &Replay, row: &Row) -> Option<Block> {
    let Cell::Measured(time) = replay.cell(row, 0) else { return None };
    let side = row.name.trim_end_matches('³').parse().ok()?;
    Some(Block { side, time, error: row.errors.as_ref()?.as_ref().ok()?.rmse })
}

/// Which of some blocks of noise is the best balance: the least square of its error times its time, as is usual for
/// estimators; blocks within the spread of its times are as good. `None` of fewer than two.
pub fn balance(blocks: &[Block]) -> Option<String> {
    let cost = |block: &Block, ms: f64| block.error.powi(2) * ms;
    let median = |block: &Block| cost(block, block.time.median);
    let best = blocks.iter().min_by(|a, b| median(a).total_cmp(&median(b)))?;
    if blocks.len() < 2 {
        return None;
    }
    let rivals: Vec<String> = blocks
        .iter()
        .filter(|other| other.side != best.side)
        .filter(|other| cost(other, other.time.interval[0]) <= cost(best, best.time.interval[1]))
        .map(|other| format!("{}³", other.side))
        .collect();
    let rivals = match rivals.is_empty() {
        true => String::new(),
        false => format!(" ({} as good within the spread of the times)", rivals.join(", ")),
    };
    let paper = match best.side == BEST_BLOCK {
        true => "as in the paper".to_string(),
        false => format!("where the paper has {BEST_BLOCK}³"),
    };
    let tried: Vec<String> = blocks
        .iter()
        .map(|block| format!("{}³: {} in {} ms", block.side, digits(block.error), digits(block.time.median)))
        .collect();
    Some(format!(
        "Blocks of noise: {}³ is the best balance of error and time{rivals}, {paper}. RMSE by side: {}.",
        best.side,
        tried.join(", ")
    ))
}

fn bumps(replay: &Replay) -> Option<String> {
    let [first, .., last] = replay.bumps.as_slice() else { return None };
    let falls = replay.bumps.is_sorted_by(|a, b| a.k < b.k && a.angle > b.angle);
    Some(format!(
        "Eq. 7: from k = {} to {} the bumps turn the normal by {}° to {}° in the mean, {} as k grows.",
        first.k,
        last.k,
        digits(first.angle),
        digits(last.angle),
        if falls { "always less" } else { "but NOT always less" }
    ))
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
        let said =
            balance(&[block(32, &[90.0; 7], 0.02), block(64, &[100.0; 7], 0.01), block(128, &[140.0; 7], 0.0095)])
                .unwrap();
        assert!(
            said.starts_with("Blocks of noise: 64³ is the best balance of error and time, as in the paper."),
            "{said}"
        );
        assert!(said.contains("32³: 0.0200 in 90.0 ms") && said.contains("128³: 0.00950 in 140 ms"), "{said}");
        // The larger block costs no time here: the paper is not confirmed, and the spread decides about rivals.
        let wide = [90.0, 95.0, 100.0, 100.0, 100.0, 130.0, 160.0];
        let said = balance(&[block(64, &wide, 0.01), block(128, &[100.0; 7], 0.0095), block(16, &[99.0; 7], 0.1)]);
        let said = said.unwrap();
        assert!(said.contains("128³ is the best") && said.contains("(64³ as good within the spread"), "{said}");
        assert!(said.contains("where the paper has 64³") && !said.contains("16³ as good"), "{said}");
        assert_eq!(balance(&[block(64, &[1.0], 0.1)]), None);
        assert_eq!(balance(&[]), None);
    }

    /// The conclusion that starts with this word, of a replay in which ours is a tenth of the 9700 Pro, after a change.
    fn said(word: &str, change: impl FnOnce(&mut Replay)) -> String {
        let mut replay = example();
        change(&mut replay);
        conclusions(&replay).into_iter().find(|sentence| sentence.starts_with(word)).unwrap_or_default()
    }

    fn set(replay: &mut Replay, (sheet, row, column): (usize, usize, usize), cell: Cell) {
        let shot = replay.sheets[sheet].rows[row].shots[column].unwrap();
        replay.shots[shot].cell = cell;
    }

    #[test]
    fn m62_real_time_is_concluded_from_the_rates() {
        let slow = said("Real time", |_| ());
        let parts =
            ["1.58 frames per second (Melting) to 2.98 (Lit rendering) at 300 × 300", "0 of 6", "not real time"];
        assert!(parts.iter().all(|part| slow.contains(part)), "{slow}");
        // The paper's own: of the 9700 Pro two reach 24, Lit and Bump mapping.
        assert!(slow.contains("9700 Pro 15.8 to 29.8, 2 of 6; 6800 GT 39.5 to 72.5, 6 of 6"), "{slow}");
        let fast = said("Real time", |replay| (0..6).for_each(|row| set(replay, (EFFECTS_SHEET, row, 0), rate(25.0))));
        assert!(fast.contains("6 of 6 effects reach them: real time on this device"), "{fast}");
        let some = said("Real time", |replay| set(replay, (EFFECTS_SHEET, 3, 0), rate(30.0)));
        assert!(some.contains("1 of 6") && some.contains("for Fur alone"), "{some}");
        let other = said("Real time", |replay| replay.plan.scale = 0.1);
        assert!(other.contains("at 30 × 30 (not the paper's window)"), "{other}");
    }

    #[test]
    fn m62_the_full_screen_is_concluded_from_the_rates() {
        let own = said("Full screen", |_| ());
        assert!(
            own.contains("0.343 (Fur) to 0.564 (Lit rendering)") && own.contains("0 of 6 effects reach the 10"),
            "{own}"
        );
        let fast = said("Full screen", |replay| set(replay, (EFFECTS_SHEET, 1, 2), rate(11.0)));
        assert!(fast.contains("11.0 (Solid texturing)") && fast.contains("1 of 6"), "{fast}");
        let scaled = said("Full screen", |replay| set(replay, (EFFECTS_SHEET, 1, 2), Cell::Scaled(1e4)));
        assert!(scaled.contains("0.100 (Solid texturing)") && scaled.contains("in proportion"), "{scaled}");
    }

    #[test]
    fn m18_m56_m57_m58_the_other_conclusions_are_made_of_the_tables() {
        // 1 / 1.578 s against 50 s.
        assert!(said("Software", |_| ()).contains("Melting, takes 0.634 s at 300 × 300, 78.9 times sooner"));
        let smooth = said("Smoothing", |_| ());
        // A tenth of the card has its ratios: 25.26 / 21.25 to 15.78 / 10.63.
        assert!(smooth.contains("4 samples and anisotropy 8) takes 1.19 to 1.48 times"), "{smooth}");
        assert!(smooth.contains("9700 Pro 1.19 to 1.48, 6800 GT 1.50 to 1.71"), "{smooth}");
        // The example's 4x are in proportion, and say nothing.
        assert!(!smooth.contains("8x against 4x"), "{smooth}");
        let against =
            said("Smoothing", |replay| (0..4).for_each(|row| set(replay, (TURBULENCE_SHEET, row, 1), rate(1.0))));
        // 1 against 0.189 and 1.702 frames per second.
        assert!(against.contains("8x against 4x: 0.588 to 5.29 times (the paper: marginal)"), "{against}");
        let drawn =
            said("Smoothing", |replay| (1..6).for_each(|row| set(replay, (EFFECTS_SHEET, row, 1), Cell::Scaled(1e4))));
        assert!(drawn.contains("takes 1.40 to 1.40 times"), "Lit alone was drawn: {drawn}");
        let lookups = said("Turbulence", |_| ());
        assert!(
            lookups.contains("8 noise lookups 9.49 (paper: 9.49), 4 noise lookups 3.25 (paper: 3.25)"),
            "{lookups}"
        );
        let discard = said("Discard", |replay| {
            set(replay, (DISCARD_SHEET, 3, 1), rate(0.855));
            let kept = replay.sheets[DISCARD_SHEET].rows[3].shots[1].unwrap();
            replay.shots[kept].picture = Some("other".into());
        });
        assert!(discard.contains("2.00 (Fur)") && discard.contains("for 5 of 6 effects"), "{discard}");
        let bumps = said("Eq. 7", |_| ());
        assert!(bumps.contains("80.0° to 2.50° in the mean, always less"), "{bumps}");
        assert!(said("Eq. 7", |replay| replay.bumps[1].angle = 1.0).contains("NOT always less"));
    }

    #[test]
    fn what_was_not_measured_is_not_concluded() {
        let mut replay = example();
        for shot in &mut replay.shots {
            (shot.cell, shot.picture) = (Cell::Missing, None);
        }
        replay.bumps.clear();
        assert_eq!(conclusions(&replay), [""; 0]);
    }

    #[test]
    fn numbers_have_three_digits() {
        let written = [0.0, 0.0123456, 1.0, 23.24, 123.4, 4321.0, 1.23e-5, 2.5e6].map(digits);
        assert_eq!(written, ["0.00", "0.0123", "1.00", "23.2", "123", "4321", "1.23e-5", "2.50e6"]);
    }
}
