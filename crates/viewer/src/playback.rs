//! Playback of time.

/// Speed, range and repetition of time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Playback {
    /// Seconds of the scene per second.
    pub speed: f64,
    /// Start and end of the timeline, seconds.
    pub range: [f64; 2],
    /// Whether time repeats from the start at the end.
    pub repeats: bool,
}

impl Default for Playback {
    fn default() -> Playback {
        Playback { speed: 1.0, range: [0.0, 10.0], repeats: false }
    }
}

impl Playback {
    /// Extends the end of the timeline by multiples of its length to include a time; a repeated range stays.
    pub fn reach(&mut self, time: f64) {
        let [from, to] = &mut self.range;
        if self.repeats || !time.is_finite() {
            return;
        }
        *from = from.min(time);
        if time > *to {
            let length = (*to - *from).max(1.0);
            *to += length * ((time - *to) / length).ceil();
        }
    }

    /// The time `passed` seconds after `time`.
    pub fn after(&self, time: f64, passed: f64) -> f64 {
        let next = time + self.speed * passed;
        let [from, to] = self.range;
        if self.repeats && from < to { from + (next - from).rem_euclid(to - from) } else { next }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_runs_at_its_speed_and_restarts_only_in_loops() {
        let once = Playback { speed: 2.0, range: [1.0, 3.0], repeats: false };
        assert_eq!(once.after(2.5, 1.0), 4.5);
        let again = Playback { repeats: true, ..once };
        assert_eq!(again.after(2.5, 0.125), 2.75);
        assert_eq!(again.after(2.5, 1.0), 2.5);
        assert_eq!(again.after(0.0, 0.0), 2.0, "a time outside is brought in");
        let mut line = once;
        line.reach(2.5);
        assert_eq!(line, once);
        line.reach(3.5);
        assert_eq!(line.range, [1.0, 5.0]);
        line.reach(-1.0);
        assert_eq!(line.range, [-1.0, 5.0]);
        let mut part = again;
        part.reach(9.0);
        assert_eq!(part, again);
        let empty = Playback { range: [1.0, 1.0], ..again };
        assert_eq!(empty.after(2.0, 1.0), 4.0);
    }
}
