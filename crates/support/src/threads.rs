//! The global thread pool.

use rayon::ThreadPoolBuilder;
use std::error::Error;
use std::num::NonZero;
use std::thread::available_parallelism;

/// Starts the thread pool: one thread per processor, or `RAYON_NUM_THREADS` if that is fewer. Halves the number as long as the
/// system refuses.
///
/// # Errors
/// Not even one thread can be started.
pub fn start() -> Result<(), String> {
    let processors = available_parallelism().map_or(1, NonZero::get);
    let asked = std::env::var("RAYON_NUM_THREADS").ok().and_then(|text| text.parse().ok());
    let mut count = clamped(asked, processors);
    if let Some(asked) = asked.filter(|asked| *asked > processors) {
        log::warn!("RAYON_NUM_THREADS = {asked}: more than there are processors; starting {count} threads");
    }
    loop {
        let Err(error) = ThreadPoolBuilder::new().num_threads(count).build_global() else { return Ok(()) };
        let Some(reason) = error.source() else { return Ok(()) }; // already started
        if count == 1 {
            return Err(format!("cannot start a thread: {reason}; look at `ulimit -v` and `ulimit -u`"));
        }
        log::warn!("cannot start {count} threads ({reason}); trying half as many");
        count /= 2;
    }
}

/// The number of threads for the requested number.
fn clamped(asked: Option<usize>, processors: usize) -> usize {
    asked.filter(|asked| *asked > 0).unwrap_or(processors).min(processors)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_more_threads_are_started_than_there_are_processors() {
        let all = [None, Some(0), Some(1), Some(3), Some(100_000)].map(|asked| clamped(asked, 4));
        assert_eq!(all, [4, 4, 1, 3, 4]);
    }
}
