//! Progress: a bar on a terminal, lines on standard error elsewhere.

use super::lines::complain;
use hypertexture::field::Progress;
use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::sync::{Once, OnceLock};
use std::thread;
use std::time::{Duration, Instant};

/// Time after which a bar appears.
const BAR_DELAY: Duration = Duration::from_secs(1);
/// Time between two lines.
const PERIOD: Duration = Duration::from_secs(60);

/// Where the progress of a job goes: its stage, and the part of it that is done.
type Listener = Box<dyn Fn(&'static str, f32) + Send + Sync>;
static LISTENER: OnceLock<Listener> = OnceLock::new();

/// Sends the progress of this process, which is a job, to `listener`.
#[cfg(feature = "viewer")]
pub(crate) fn listen(listener: Listener) {
    let _ = LISTENER.set(listener); // a process is one job
}

/// Runs a computation; a bar appears on a terminal when it takes longer than a second, a line each minute elsewhere.
pub(crate) fn with_progress<T>(quiet: bool, what: &'static str, run: impl FnOnce(Progress<'_>) -> T) -> T {
    follow(quiet, what, false, run)
}

/// Runs a computation that may take minutes, as [`with_progress`] does; without a terminal its first report is a line too.
pub(crate) fn announced<T>(quiet: bool, what: &'static str, run: impl FnOnce(Progress<'_>) -> T) -> T {
    follow(quiet, what, true, run)
}

fn follow<T>(quiet: bool, what: &'static str, announce: bool, run: impl FnOnce(Progress<'_>) -> T) -> T {
    if let Some(listener) = LISTENER.get() {
        return run(&|part| listener(what, part));
    }
    if quiet {
        return run(&|_| ());
    }
    if std::io::stderr().is_terminal() {
        with_bar(what, run)
    } else {
        with_lines(what, PERIOD, announce, &|line| complain(&line), run)
    }
}

fn with_bar<T>(what: &str, run: impl FnOnce(Progress<'_>) -> T) -> T {
    const STEPS: u64 = 1000;
    let style = ProgressStyle::with_template("{msg} [{bar:40}] {percent} % {eta} left");
    let bar = ProgressBar::new(STEPS).with_message(what.to_string()).with_style(style.expect("the template is valid"));
    let start = Instant::now();
    let result = run(&|fraction| {
        if fraction >= 1.0 {
            bar.finish_and_clear(); // what follows is something else
        } else if start.elapsed() > BAR_DELAY {
            bar.set_position((f64::from(fraction) * STEPS as f64) as u64);
        }
    });
    bar.finish_and_clear();
    result
}

fn with_lines<T>(
    what: &str,
    period: Duration,
    announce: bool,
    say: &(dyn Fn(String) + Sync),
    run: impl FnOnce(Progress<'_>) -> T,
) -> T {
    let (done, first) = (AtomicU32::new(0), Once::new());
    let each_period = |ended: Receiver<()>| {
        let mut periods = 0;
        while ended.recv_timeout(period) == Err(RecvTimeoutError::Timeout) {
            periods += 1;
            let part = f32::from_bits(done.load(Ordering::Relaxed));
            let part = if part < 1.0 { format!(", {:.0} % done", 100.0 * part) } else { String::new() };
            say(format!("progress   {what}: at work for {periods} min{part}"));
        }
    };
    thread::scope(|scope| {
        let (running, ended) = channel();
        scope.spawn(|| each_period(ended));
        let result = run(&|fraction| {
            done.store(fraction.to_bits(), Ordering::Relaxed);
            if announce {
                first.call_once(|| say(format!("progress   {what}: begun; a line follows each minute")));
            }
        });
        drop(running);
        result
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::Mutex;

    #[test]
    fn progress_without_a_terminal_is_a_line_per_period() {
        for announce in [true, false] {
            let lines = Mutex::new(Vec::new());
            let say = |line: String| lines.lock().unwrap().push(line);
            let result = with_lines("work", Duration::from_millis(1), announce, &say, |progress| {
                progress(0.25);
                progress(0.5);
                while lines.lock().unwrap().len() < 3 {
                    thread::yield_now();
                }
                7
            });
            let lines = lines.into_inner().unwrap();
            let begun =
                lines.iter().filter(|line| *line == "progress   work: begun; a line follows each minute").count();
            let is_later =
                |line: &&String| line.starts_with("progress   work: at work for ") && line.ends_with(" % done");
            let later = lines.iter().filter(is_later).count();
            assert_eq!((result, begun, begun + later), (7, usize::from(announce), lines.len()));
        }
    }

    #[test]
    fn what_ends_at_once_says_no_more_than_that_it_began() {
        let lines = Mutex::new(Vec::new());
        let say = |line: String| lines.lock().unwrap().push(line);
        with_lines("work", PERIOD, true, &say, |progress| progress(0.0));
        with_lines("work", PERIOD, true, &say, |_| ()); // refused before it began
        assert_eq!(lines.lock().unwrap().len(), 1);
    }
}
