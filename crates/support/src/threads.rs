//! The threads that computations are divided among.

use rayon::ThreadPoolBuilder;
use std::error::Error;
use std::num::NonZero;
use std::thread::available_parallelism;

/// Starts as many threads as there are processors, or as `RAYON_NUM_THREADS` asks for below that: more help nothing. Where the
/// system gives fewer, those.
///
/// # Errors
/// The system gives none.
pub fn start() -> Result<(), String> {
    let processors = available_parallelism().map_or(1, NonZero::get);
    let asked = std::env::var("RAYON_NUM_THREADS").ok().and_then(|text| text.parse().ok());
    let mut count = held(asked, processors);
    if let Some(asked) = asked.filter(|asked| *asked > processors) {
        log::warn!(
            "RAYON_NUM_THREADS = {asked}: {count} threads are started, one for each processor; more help nothing"
        );
    }
    loop {
        let Err(error) = ThreadPoolBuilder::new().num_threads(count).build_global() else { return Ok(()) };
        let Some(reason) = error.source() else { return Ok(()) }; // they are started
        if count == 1 {
            return Err(format!("no thread can be started: {reason}; look at `ulimit -v` and `ulimit -u`"));
        }
        log::warn!("{count} threads cannot be started ({reason}); half of them are tried");
        count /= 2;
    }
}

/// How many threads are started where so many are asked for.
fn held(asked: Option<usize>, processors: usize) -> usize {
    asked.filter(|asked| *asked > 0).unwrap_or(processors).min(processors)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_more_threads_are_started_than_there_are_processors() {
        let all = [None, Some(0), Some(1), Some(3), Some(100_000)].map(|asked| held(asked, 4));
        assert_eq!(all, [4, 4, 1, 3, 4]);
    }
}
