//! Log messages on standard error: warnings and errors, more with `HYPERTEXTURE_LOG=info` or `debug`.

use log::{Level, LevelFilter, Log, Metadata, Record};

struct Stderr {
    /// Whether messages of libraries pass, down to level info. Users cannot act upon them, and one library traces every
    /// instruction of a program.
    libraries: bool,
}

impl Log for Stderr {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        let heard =
            metadata.target().starts_with("hypertexture") || (self.libraries && metadata.level() <= Level::Info);
        heard && metadata.level() <= log::max_level()
    }

    fn log(&self, record: &Record<'_>) {
        if self.enabled(record.metadata()) {
            super::lines::complain(&format!("{}: {}", record.level().as_str().to_lowercase(), record.args()));
        }
    }

    fn flush(&self) {}
}

/// Starts logging.
pub fn start(quiet: bool) {
    let asked: Option<LevelFilter> = std::env::var("HYPERTEXTURE_LOG").ok().and_then(|level| level.parse().ok());
    let level = asked.unwrap_or(if quiet { LevelFilter::Error } else { LevelFilter::Warn });
    if log::set_boxed_logger(Box::new(Stderr { libraries: asked.is_some() })).is_ok() {
        log::set_max_level(level);
    }
}
