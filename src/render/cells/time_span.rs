//! Time spans of proofs, which pictures that differ in time alone share.
//!
//! Sub-frames of an exposure, frames of a sequence and playback are pictures at regular times. A proof covers the next
//! pictures, as many as possible without losing many empty cells; the second proof of an exposure covers all of it.

/// Largest number of future pictures in a proof. Higher: no gain, since proofs take a small share of the time.
const MAX_PICTURES: u32 = 64;
/// Lowest share of the cells empty at one moment that must be empty over a span. Lower: rays take samples that shorter
/// spans would save. Higher: more proofs.
const MIN_KEPT_SHARE: f32 = 0.95;

/// Validity of the current proof, and the length of the next.
#[derive(Debug, Default)]
pub(super) struct TimeSpan {
    /// Inputs of the proof except the time.
    timeless: Vec<u8>,
    /// First and last time of validity, seconds.
    times: [f32; 2],
    /// Time of the previous picture.
    last: f32,
    /// Number of pictures in the current proof.
    made_for: u32,
    /// Number of pictures in the next proof.
    pictures: u32,
    /// Share of cells empty at a single moment.
    at_once: f32,
}

impl TimeSpan {
    /// Whether the proof holds for a picture with these inputs at a time.
    pub(super) fn holds(&mut self, timeless: &[u8], time: f32) -> bool {
        let holds = self.timeless == timeless && self.times[0] <= time && time <= self.times[1];
        if holds {
            self.last = time;
        }
        holds
    }

    /// Time span of the next proof, for a picture whose exposure ends at `end`.
    pub(super) fn next(&self, timeless: &[u8], time: f32, end: f32) -> [f32; 2] {
        let step = if self.timeless == timeless { time - self.last } else { 0.0 };
        let ahead = step * (self.pictures as f32 - 0.75); // a little beyond the last: times are rounded
        [time, if step > 0.0 && self.pictures > 1 { end.max(time + ahead) } else { time }]
    }

    /// Number of pictures that share the current proof.
    pub(super) fn shared(&self) -> u32 {
        self.made_for.max(1)
    }

    /// Number of pictures that share a proof over `times`.
    pub(super) fn to_share(&self, times: [f32; 2]) -> u32 {
        if times[0] < times[1] { self.pictures } else { 1 }
    }

    /// Stores a new proof and the share of empty cells that it found.
    pub(super) fn take(&mut self, timeless: Vec<u8>, times: [f32; 2], empty: f32) {
        self.made_for = self.to_share(times);
        self.pictures = match times[0] < times[1] {
            true if empty >= MIN_KEPT_SHARE * self.at_once => (2 * self.pictures).min(MAX_PICTURES),
            true => self.pictures / 2,
            false => 2,
        };
        if times[0] == times[1] {
            self.at_once = empty;
        }
        (self.timeless, self.times, self.last) = (timeless, times, times[0]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Number of proofs that a sequence of pictures takes; `empty` maps the length of a span to the share of empty
    /// cells.
    fn proofs(pictures: usize, step: f32, end: f32, empty: impl Fn(f32) -> f32) -> usize {
        let mut span = TimeSpan::default();
        let times = (0..pictures).map(|index| 0.3 + step * index as f32);
        times
            .filter(|&time| {
                let is_made = !span.holds(b"scene", time);
                if is_made {
                    let times = span.next(b"scene", time, end);
                    span.take(b"scene".to_vec(), times, empty(times[1] - times[0]));
                }
                is_made
            })
            .count()
    }

    #[test]
    fn proofs_hold_for_more_pictures_while_as_much_is_empty() {
        assert_eq!(proofs(64, 0.04, 0.0, |_| 0.5), 7, "1, 2, 4, 8, 16 and 32 pictures, and one more");
        assert_eq!(proofs(64, -0.04, 0.0, |_| 0.5), 64, "time goes back");
        assert_eq!(proofs(64, 0.04, 3.0, |_| 0.5), 2, "all of an exposure");
        assert_eq!(proofs(1, 0.0, 0.0, |_| 0.5), 1);
        let fast = proofs(60, 0.04, 0.0, |length| 0.5 - 5.0 * length);
        assert!((30..=45).contains(&fast), "one and two pictures in turn: {fast}");
    }

    #[test]
    fn proofs_hold_for_nothing_but_their_own_picture_at_other_times() {
        let mut span = TimeSpan::default();
        let times = span.next(b"a", 1.0, 2.0);
        assert_eq!(times, [1.0; 2], "no picture came before");
        span.take(b"a".to_vec(), times, 0.5);
        assert!(span.holds(b"a", 1.0) && !span.holds(b"b", 1.0) && !span.holds(b"a", 1.1));
        let times = span.next(b"a", 1.1, 0.0);
        assert!(times[0] == 1.1 && times[1] > 1.2 && times[1] < 1.25, "two pictures: {times:?}");
        assert!(!span.holds(b"a", 1.1), "nothing is proven yet");
        span.take(b"a".to_vec(), times, 0.5);
        assert!(span.holds(b"a", 1.2) && !span.holds(b"a", 1.3) && !span.holds(b"a", 1.0));
        assert_eq!(span.next(b"b", 1.3, 2.0), [1.3; 2], "another scene");
    }
}
