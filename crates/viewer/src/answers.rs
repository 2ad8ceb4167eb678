//! How fast the window answers the hand: what the step `orbit` of a script measures.

use std::fmt;
use std::time::{Duration, Instant};
use support::watchdog;

/// A person takes what comes within this for the effect of what the hand does.
const PROMPT: Duration = Duration::from_millis(100);

/// What the window does while a hand moves.
pub(super) struct Answers {
    began: Instant,
    processor: Option<Duration>,
    moves: Vec<Move>,
    /// When pictures came, how many pixels and samples they have, and the job of the last.
    pictures: Vec<(Instant, [u32; 2], u32)>,
    on_screen: u64,
}

/// A move of the hand.
struct Move {
    at: Instant,
    /// The first job that shows it.
    job: Option<u64>,
    /// Until the window was drawn with it, and until there was a picture of it.
    drawn: Option<Duration>,
    answered: Option<Duration>,
}

impl Answers {
    /// Begins to measure; the picture of job `on_screen` is seen.
    pub(super) fn new(now: Instant, on_screen: u64) -> Answers {
        let processor = watchdog::own_processor_time();
        Answers { began: now, processor, moves: Vec::new(), pictures: Vec::new(), on_screen }
    }

    /// The hand has moved.
    pub(super) fn moved(&mut self, at: Instant) {
        self.moves.push(Move { at, job: None, drawn: None, answered: None });
    }

    /// Every move so far is in the job of this number, or in one before.
    pub(super) fn posted(&mut self, number: u64) {
        for own in &mut self.moves {
            own.job.get_or_insert(number);
        }
    }

    /// The window was drawn; `on_screen` is the job of the picture, which has this size and samples.
    pub(super) fn drawn(&mut self, now: Instant, on_screen: u64, size: [u32; 2], samples: u32) {
        if on_screen != self.on_screen {
            self.on_screen = on_screen;
            self.pictures.push((now, size, samples));
        }
        for own in self.moves.iter_mut().filter(|own| own.answered.is_none()) {
            own.drawn.get_or_insert(now.saturating_duration_since(own.at));
            let is_seen = own.job.is_some_and(|job| job <= on_screen);
            own.answered = is_seen.then(|| now.saturating_duration_since(own.at));
        }
    }

    /// Whether there is a picture of every move.
    pub(super) fn is_complete(&self) -> bool {
        self.moves.iter().all(|own| own.answered.is_some())
    }

    /// The part of the moves of which there was a picture in time.
    fn prompt(&self) -> f64 {
        let prompt = self.moves.iter().filter(|own| own.answered.is_some_and(|after| after <= PROMPT)).count();
        prompt as f64 / self.moves.len().max(1) as f64
    }
}

impl fmt::Display for Answers {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ms =
            |time: Option<Duration>| time.map_or("none".into(), |time| format!("{:.0} ms", time.as_secs_f64() * 1e3));
        let sorted = |of: fn(&Move) -> Option<Duration>| {
            let mut all: Vec<Duration> = self.moves.iter().map(|own| of(own).unwrap_or(Duration::MAX)).collect();
            all.sort_unstable();
            all
        };
        let (answers, frames) = (sorted(|own| own.answered), sorted(|own| own.drawn));
        let at = |all: &[Duration], part: f64| {
            let place = (part * all.len() as f64) as usize;
            all.get(place.min(all.len().saturating_sub(1))).copied().filter(|time| *time < Duration::MAX)
        };
        let last = self.pictures.last().map_or(self.began, |(when, ..)| *when);
        let seconds = last.duration_since(self.began).as_secs_f64();
        let times = std::iter::once(self.began).chain(self.pictures.iter().map(|(when, ..)| *when));
        let gap = times.clone().zip(times.skip(1)).map(|(a, b)| b - a).max();
        write!(
            f,
            "{} moves: {:.0} % answered within {}; first {}, median {}, 95 % {}, slowest {}; the window follows after {} (95 % {}); ",
            self.moves.len(),
            100.0 * self.prompt(),
            ms(Some(PROMPT)),
            ms(self.moves.first().and_then(|own| own.answered)),
            ms(at(&answers, 0.5)),
            ms(at(&answers, 0.95)),
            ms(answers.last().copied().filter(|time| *time < Duration::MAX)),
            ms(at(&frames, 0.5)),
            ms(at(&frames, 0.95)),
        )?;
        let count = self.pictures.len();
        write!(f, "{:.1} pictures a second, longest gap {}", count as f64 / seconds.max(1e-3), ms(gap))?;
        if let Some(taken) = watchdog::own_processor_time().zip(self.processor).map(|(now, before)| now - before) {
            write!(f, ", processor {:.0} ms each", taken.as_secs_f64() * 1e3 / count.max(1) as f64)?;
        }
        let mut sizes: Vec<_> = self
            .pictures
            .iter()
            .map(|(_, [width, height], samples)| (width * height, width, height, samples))
            .collect();
        sizes.sort_unstable();
        match sizes.get(sizes.len() / 2) {
            Some((_, width, height, samples)) => write!(f, ", {width} x {height} with {samples} samples"),
            None => Ok(()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_move_is_answered_by_the_first_picture_of_it() {
        let start = Instant::now();
        let at = |ms: u64| start + Duration::from_millis(ms);
        let mut answers = Answers::new(start, 4);
        answers.moved(at(0));
        answers.posted(5);
        answers.drawn(at(10), 4, [8, 8], 32); // the job of the move is posted, the picture is the one before
        answers.moved(at(50));
        answers.posted(6);
        answers.drawn(at(60), 5, [8, 8], 32);
        assert!(!answers.is_complete());
        answers.drawn(at(250), 6, [8, 8], 32);
        assert!(answers.is_complete());
        assert_eq!(answers.prompt(), 0.5);
        let line = answers.to_string();
        assert!(line.starts_with("2 moves: 50 % answered within 100 ms; first 60 ms, median 200 ms"), "{line}");
        assert!(
            line.contains("8.0 pictures a second, longest gap 190 ms") && line.ends_with("8 x 8 with 32 samples"),
            "{line}"
        );
    }
}
