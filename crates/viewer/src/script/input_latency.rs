//! Input latency of the window, measured by the script step `orbit`.

use hypertexture_support::watchdog;
use std::fmt;
use std::time::{Duration, Instant};

/// Latency that feels immediate.
const PROMPT: Duration = Duration::from_millis(100);

/// Latency of a series of mouse moves.
pub(crate) struct InputLatency {
    began: Instant,
    processor: Option<Duration>,
    moves: Vec<Move>,
    /// Time, size and samples of each picture.
    pictures: Vec<(Instant, [u32; 2], u32)>,
    on_screen: u64,
}

/// A mouse move.
struct Move {
    at: Instant,
    /// The first job that includes the move.
    job: Option<u64>,
    /// Latency of the first drawn frame, and of the first picture with the move.
    drawn: Option<Duration>,
    answered: Option<Duration>,
}

impl InputLatency {
    /// Starts the measurement; `on_screen` is the job of the current picture.
    pub(crate) fn new(now: Instant, on_screen: u64) -> InputLatency {
        let processor = watchdog::own_processor_time();
        InputLatency { began: now, processor, moves: Vec::new(), pictures: Vec::new(), on_screen }
    }

    /// Records a mouse move.
    pub(crate) fn moved(&mut self, at: Instant) {
        self.moves.push(Move { at, job: None, drawn: None, answered: None });
    }

    /// Records that job `number` includes all moves so far.
    pub(crate) fn submitted(&mut self, number: u64) {
        for own in &mut self.moves {
            own.job.get_or_insert(number);
        }
    }

    /// Records that the window was drawn with the picture of job `on_screen`.
    pub(crate) fn drawn(&mut self, now: Instant, on_screen: u64, size: [u32; 2], samples: u32) {
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

    /// Whether every move has a picture.
    pub(crate) fn is_complete(&self) -> bool {
        self.moves.iter().all(|own| own.answered.is_some())
    }

    /// Fraction of the moves with an immediate picture.
    fn prompt(&self) -> f64 {
        let prompt = self.moves.iter().filter(|own| own.answered.is_some_and(|after| after <= PROMPT)).count();
        prompt as f64 / self.moves.len().max(1) as f64
    }
}

impl fmt::Display for InputLatency {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ms =
            |time: Option<Duration>| time.map_or("none".into(), |time| format!("{:.0} ms", time.as_secs_f64() * 1e3));
        let sorted = |of: fn(&Move) -> Option<Duration>| {
            let mut all: Vec<Duration> = self.moves.iter().map(|own| of(own).unwrap_or(Duration::MAX)).collect();
            all.sort_unstable();
            all
        };
        let (latency, frames) = (sorted(|own| own.answered), sorted(|own| own.drawn));
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
            ms(at(&latency, 0.5)),
            ms(at(&latency, 0.95)),
            ms(latency.last().copied().filter(|time| *time < Duration::MAX)),
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
        let mut latency = InputLatency::new(start, 4);
        latency.moved(at(0));
        latency.submitted(5);
        latency.drawn(at(10), 4, [8, 8], 32); // the job of the move is posted, the picture is the one before
        latency.moved(at(50));
        latency.submitted(6);
        latency.drawn(at(60), 5, [8, 8], 32);
        assert!(!latency.is_complete());
        latency.drawn(at(250), 6, [8, 8], 32);
        assert!(latency.is_complete());
        assert_eq!(latency.prompt(), 0.5);
        let line = latency.to_string();
        assert!(line.starts_with("2 moves: 50 % answered within 100 ms; first 60 ms, median 200 ms"), "{line}");
        assert!(
            line.contains("8.0 pictures a second, longest gap 190 ms") && line.ends_with("8 x 8 with 32 samples"),
            "{line}"
        );
    }
}
