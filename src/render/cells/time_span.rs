//! For how long proofs of empty cells hold: pictures that differ in their time alone share them.
//!
//! Role: sub-frames of a moving picture, frames of a sequence and a window that plays are pictures at even times. Cells are
//! proven for an interval of time that holds the next of them, as many as it can without finding much less that is empty;
//! after the first of an exposure, for all of it.

/// Pictures of one proof at most that may not come. More: nothing to gain, since proofs are then a small part of the time.
const MOST: u32 = 64;
/// The part of what is empty at one time that must be so over an interval. Less: rays take samples that proofs would save.
/// More: more proofs.
const KEPT: f32 = 0.95;

/// For which pictures proofs hold, and for how many the next ones are made.
#[derive(Debug, Default)]
pub(super) struct TimeSpan {
    /// What the proofs depend on but for the time.
    timeless: Vec<u8>,
    /// From when to when they hold, seconds.
    times: [f32; 2],
    /// The time of the picture before.
    last: f32,
    /// Pictures that the last proofs were made for.
    made_for: u32,
    /// Pictures that the next ones are made for.
    pictures: u32,
    /// The part of the cells that was empty at one time.
    at_once: f32,
}

impl TimeSpan {
    /// Whether the proofs hold for a picture that depends on this and on its time.
    pub(super) fn holds(&mut self, timeless: &[u8], time: f32) -> bool {
        let holds = self.timeless == timeless && self.times[0] <= time && time <= self.times[1];
        if holds {
            self.last = time;
        }
        holds
    }

    /// From when to when proofs are to hold that are made for a picture, whose exposure ends at some time.
    pub(super) fn next(&self, timeless: &[u8], time: f32, end: f32) -> [f32; 2] {
        let step = if self.timeless == timeless { time - self.last } else { 0.0 };
        let ahead = step * (self.pictures as f32 - 0.75); // a little more than to the last: times are rounded
        [time, if step > 0.0 && self.pictures > 1 { end.max(time + ahead) } else { time }]
    }

    /// How many pictures share the proofs that hold.
    pub(super) fn shared(&self) -> u32 {
        self.made_for.max(1)
    }

    /// How many pictures are to share proofs that hold from when to when.
    pub(super) fn to_share(&self, times: [f32; 2]) -> u32 {
        if times[0] < times[1] { self.pictures } else { 1 }
    }

    /// Takes proofs that hold for this and found such a part of the cells empty.
    pub(super) fn take(&mut self, timeless: Vec<u8>, times: [f32; 2], empty: f32) {
        self.made_for = self.to_share(times);
        self.pictures = match times[0] < times[1] {
            true if empty >= KEPT * self.at_once => (2 * self.pictures).min(MOST),
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

    /// How many proofs so many pictures take, of which the part that is empty falls with the length of an interval.
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
