//! Log messages on standard error: warnings and errors, more with `HYPERTEXTURE_LOG=info` or `debug`.

use log::{LevelFilter, Log, Metadata, Record};

struct Stderr;

impl Log for Stderr {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        // What a library warns of is nothing that a person can act upon.
        let ours = metadata.target().starts_with("hypertexture");
        metadata.level() <= if ours { log::max_level() } else { LevelFilter::Error }
    }

    fn log(&self, record: &Record<'_>) {
        if self.enabled(record.metadata()) {
            super::complain(&format!("{}: {}", record.level().as_str().to_lowercase(), record.args()));
        }
    }

    fn flush(&self) {}
}

/// Starts logging.
pub fn start(quiet: bool) {
    let asked = std::env::var("HYPERTEXTURE_LOG").ok().and_then(|level| level.parse().ok());
    let level = asked.unwrap_or(if quiet { LevelFilter::Error } else { LevelFilter::Warn });
    if log::set_logger(&Stderr).is_ok() {
        log::set_max_level(level);
    }
}
