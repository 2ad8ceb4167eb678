//! The queue of final pictures.

use super::order::{ExportOrder, Rendering};
use crate::document::author::Gate;
use crate::message::Message;
use std::collections::{BTreeSet, VecDeque};
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// An order that has ended, with facts about its file.
pub(crate) struct Written {
    pub(crate) order: ExportOrder,
    /// Subjects and words.
    pub(crate) facts: Vec<[String; 2]>,
}

/// The orders, of which one is running.
pub(crate) struct Exports {
    gate: Arc<Gate>,
    running: Option<Rendering>,
    waiting: VecDeque<ExportOrder>,
    outcome: Option<Message>,
    written: Option<Written>,
    /// First files of all orders.
    own: BTreeSet<PathBuf>,
}

impl Exports {
    pub(crate) fn new(gate: Arc<Gate>) -> Exports {
        Exports { gate, running: None, waiting: VecDeque::new(), outcome: None, written: None, own: BTreeSet::new() }
    }

    /// Renders an order after the earlier ones.
    pub(crate) fn add(&mut self, order: ExportOrder) {
        self.own.insert(order.first());
        self.waiting.push_back(order);
        (self.outcome, self.written) = (None, None);
        self.start_next();
    }

    fn start_next(&mut self) {
        if self.running.is_none() {
            self.running = self.waiting.pop_front().map(|order| Rendering::start(&self.gate, order));
        }
    }

    /// Stops all orders.
    pub(crate) fn stop(&mut self) {
        self.waiting.clear();
        let frames = self.running.take().and_then(|running| running.frames());
        let progress = frames.map_or(String::new(), |(done, all)| format!(" after {done} of {all} frames"));
        self.outcome = Some(Message::note(format!("the final picture was stopped{progress}")));
    }

    /// Receives the result of the running order, and starts the next one.
    pub(crate) fn poll(&mut self) {
        if let Some(done) = self.running.as_mut().and_then(Rendering::poll) {
            let told = self.running.take().filter(|running| done.is_ok() && !running.lines.is_empty());
            self.written = told.map(|Rendering { order, lines, .. }| Written { order, facts: facts(&lines) });
            let failed = |reason: String| Message::error(format!("final picture: {}", of_window(&reason)));
            self.outcome = Some(done.map_or_else(failed, Message::note));
            self.start_next();
        }
    }

    /// Whether an order is running.
    pub(crate) fn is_running(&self) -> bool {
        self.running.is_some()
    }

    /// Marks a file as one of this window.
    pub(crate) fn note_own(&mut self, path: PathBuf) {
        self.own.insert(path);
    }

    /// Whether a file is the first one of an order.
    pub(crate) fn is_own(&self, path: &Path) -> bool {
        self.own.contains(path)
    }

    /// Whether a picture replaces a file that this window did not write.
    pub(crate) fn replaces(&self, path: &Path) -> bool {
        path.exists() && !self.is_own(path)
    }

    /// Finished frames and all frames of the running order, if that is a sequence.
    pub(crate) fn frames(&self) -> Option<(u32, u32)> {
        self.running.as_ref()?.frames()
    }

    /// Finished part of the stage of the running order.
    pub(crate) fn part(&self) -> Option<f32> {
        self.running.as_ref()?.at.as_ref().map(|(_, part)| *part)
    }

    /// Result of the last order.
    pub(crate) fn outcome(&self) -> Option<&Message> {
        self.outcome.as_ref()
    }

    /// Files of the last order, if there are facts about them.
    pub(crate) fn written(&self) -> Option<&Written> {
        self.written.as_ref()
    }

    /// Forgets the facts about what was written.
    pub(crate) fn forget_written(&mut self) {
        self.written = None;
    }

    /// Progress of the running order, in words.
    pub(crate) fn progress(&self) -> Option<String> {
        let running = self.running.as_ref()?;
        let (kind, seconds) = (running.order.kind.name(), running.seconds());
        let stage = running.at.as_ref().filter(|(_, part)| *part < 1.0);
        let stage = stage.map_or(String::new(), |(what, part)| {
            let what = if *what == kind { String::new() } else { format!("{what} ") };
            format!("{what}{:.0} %, ", (100.0 * part).floor())
        });
        Some(match running.frames() {
            Some((done, all)) if done < all => format!("{kind}: {done} of {all} frames, {stage}{seconds} s"),
            Some(_) => format!("{kind}: encoding, {seconds} s"),
            _ => format!("{kind}: {stage}{seconds} s"),
        })
    }
}

/// The facts of lines, each with its subject in front.
fn facts(lines: &str) -> Vec<[String; 2]> {
    let fact = |line: &str| line.split_once(' ').map(|(about, what)| [about.into(), of_window(what.trim_start())]);
    lines.lines().filter_map(fact).collect()
}

/// A reason with the controls of the window in place of the options of the command line.
fn of_window(reason: &str) -> String {
    const NAMES: [(&str, &str); 10] = [
        ("--restart", "tick `restart`"),
        ("give another --output", "give another file name"),
        ("--output", "the file name"),
        ("--grid", "`grid`"),
        ("--tolerance", "`tolerance`"),
        ("--triangles", "`triangles`"),
        ("--bodies apart", "`bodies apart`"),
        ("--scale-to", "`scale to`"),
        ("--unit", "`unit`"),
        ("--smallest", "`mesh --smallest`"),
    ];
    NAMES.iter().fold(reason.to_string(), |text, (option, name)| text.replace(option, name))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn errors_name_controls_of_the_dialog() {
        let said = "a.frames shows another scene; give another --output, or --restart to render every frame again";
        let told =
            "a.frames shows another scene; give another file name, or tick `restart` to render every frame again";
        assert_eq!(of_window(said), told);
        let lines = "mesh       8 vertices\nprint      60 x 40 x 20 mm, by --scale-to\n";
        assert_eq!(facts(lines), [["mesh", "8 vertices"], ["print", "60 x 40 x 20 mm, by `scale to`"]]);
    }
}
