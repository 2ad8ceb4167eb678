//! Execution of scripts.

use super::input_latency::InputLatency;
use super::parse::{ScriptEvent, Step, key, parse};
use super::widgets::{Widget, button, drag, find, request};
use crate::ViewError;
use crate::app::App;
use crate::document::author::State;
use crate::worker::Stage;
use accesskit::{Action, ActionData};
use egui::{Event, Key, Modifiers, MouseWheelUnit, PointerButton, TouchPhase, Vec2, accesskit};
use hypertexture_support::open;
use std::collections::VecDeque;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

/// Size limit of a script, bytes.
const MAX_BYTES: u64 = 1 << 20;
/// Timeout of a step.
const STEP_TIMEOUT: Duration = Duration::from_secs(600);
/// Interval between lines about a wait.
const REPORT_INTERVAL: Duration = Duration::from_secs(10);
/// Timeout for the last picture of an orbit.
const LAST_ANSWER: Duration = Duration::from_secs(20);
/// Interval between frames while a step waits for a picture.
const WAITING: Duration = Duration::from_millis(50);

/// A running script.
pub(crate) struct Script {
    file: String,
    steps: VecDeque<(usize, Step)>,
    /// Remaining events of the last step.
    events: VecDeque<Vec<Event>>,
    began: Instant,
    frames: u32,
    /// Latency of the running orbit, and its number of moves.
    orbit: Option<(InputLatency, u32)>,
    /// Whether long waits are reported on the standard error, and the last time.
    is_told: bool,
    told: Instant,
}

impl Script {
    /// Reads a script.
    pub(crate) fn read(file: &Path) -> Result<Script, ViewError> {
        let name = file.display().to_string();
        let text =
            open::text(file, MAX_BYTES).map_err(|error| ViewError::Failed(format!("{}: {error}", file.display())))?;
        let mut steps = VecDeque::new();
        for (number, line) in (1..).zip(text.lines()) {
            let line = line.split('#').next().unwrap_or_default().trim();
            if !line.is_empty() {
                let fail = |reason| ViewError::Script(name.clone(), number, reason);
                steps.push_back((number, parse(line).map_err(fail)?));
            }
        }
        Ok(Script::new(name, steps))
    }

    /// The script of `--frames` and `--screenshot`.
    pub(crate) fn of_frames(frames: Option<u32>, shot: Option<PathBuf>) -> Script {
        // The frames count from the first picture on; the screenshot is rendered anew.
        let wait = frames.map_or(vec![Step::Converged], |frames| vec![Step::Drawn, Step::Frames(frames)]);
        let shot = shot.map(|path| Step::Do(ScriptEvent::Shot(path)));
        let steps = wait.into_iter().chain(shot).chain([Step::Do(ScriptEvent::Quit)]);
        Script { is_told: true, ..Script::new("--frames".into(), (1..).zip(steps).collect()) }
    }

    fn new(file: String, steps: VecDeque<(usize, Step)>) -> Script {
        let (events, now) = (VecDeque::new(), Instant::now());
        Script { file, steps, events, began: now, frames: 0, orbit: None, is_told: false, told: now }
    }

    /// The input before the next frame.
    pub(crate) fn next(&mut self, app: &mut App, tree: &[Widget]) -> Result<Option<ScriptEvent>, ViewError> {
        if let Some(events) = self.events.pop_front() {
            return Ok(Some(ScriptEvent::Events(events)));
        }
        let Some((line, step)) = self.steps.front().cloned() else { return Ok(None) };
        let fail = |reason: String| ViewError::Script(self.file.clone(), line, reason);
        if let Some(reason) = &app.failure {
            return Err(fail(reason.clone()));
        }
        if let Step::Orbit(moves, seconds) = step {
            return Ok(self.orbit(app, moves, seconds).map(ScriptEvent::Events));
        }
        self.frames += 1;
        let stage = app.figures.stage;
        let steady = app.is_idle();
        let done = match &step {
            Step::Drawn => app.is_current(),
            Step::Picture => app.is_current() && !matches!(stage, Stage::None | Stage::Coarse | Stage::Partial),
            Step::Converged if app.lesson.is_held() => app.is_current() && stage == Stage::Scene,
            Step::Converged => app.is_current() && matches!(stage, Stage::Converged(_)),
            Step::Validity => app.is_current() && stage == Stage::Validity,
            Step::Inspected => app.inspector.is_done(),
            Step::Loading => app.loading().is_some(),
            Step::Frames(count) => self.frames > *count,
            Step::Good => self.frames > 1 && *app.author().state() == State::Good,
            Step::Bad => matches!(app.author().state(), State::Bad(_)),
            // Keys do not wait for tasks.
            Step::Do(ScriptEvent::Events(_)) => true,
            _ => steady,
        };
        if !done {
            if self.is_told && self.told.elapsed() >= REPORT_INTERVAL {
                self.told = Instant::now();
                // The standard error may be closed.
                let _ = writeln!(io::stderr(), "view waits for {}", app.awaited());
            }
            if self.began.elapsed() > STEP_TIMEOUT {
                return Err(fail(format!("{step:?} timed out after {} s", STEP_TIMEOUT.as_secs())));
            }
            return Ok(None);
        }
        let event = match &step {
            Step::Do(event) => Some(event.clone()),
            Step::Drag(places, button, modifiers) => {
                self.events = drag(app.place, *places, *button, *modifiers);
                self.events.pop_front().map(ScriptEvent::Events)
            }
            Step::Scroll(lines) => {
                let unit = MouseWheelUnit::Line;
                let (delta, phase, modifiers) = (Vec2::new(0.0, *lines), TouchPhase::Move, Modifiers::NONE);
                let wheel = Event::MouseWheel { unit, delta, phase, modifiers };
                Some(ScriptEvent::Events(vec![Event::PointerMoved(app.place.center()), wheel]))
            }
            Step::Click(name) => Some(request(find(tree, name, Action::Click).map_err(fail)?, Action::Click, None)),
            Step::Where(name) => {
                let text = |own: &Widget| own.node.label().or(own.node.value()).unwrap_or_default().to_string();
                let is_own = tree.iter().rfind(|own| text(own) == *name);
                let own = is_own.or_else(|| tree.iter().rfind(|own| text(own).starts_with(name)));
                let place = own.and_then(|own| own.node.bounds());
                let place = place.ok_or_else(|| fail(format!("no control begins with `{name}`")))?;
                let _ = writeln!(io::stdout(), "{name}: {} {} {} {}", place.x0, place.y0, place.x1, place.y1);
                None
            }
            Step::Set(name, value) => {
                let (value, widget) = (ActionData::NumericValue(*value), find(tree, name, Action::SetValue));
                Some(request(widget.map_err(fail)?, Action::SetValue, Some(value)))
            }
            Step::Write(name, text) => {
                let focus = request(find(tree, name, Action::Focus).map_err(fail)?, Action::Focus, None);
                let all = Modifiers::COMMAND | Modifiers::CTRL;
                self.events = [key(Key::A, all).into(), vec![Event::Text(text.clone())]].into();
                Some(focus)
            }
            Step::Copy(from, to) => {
                let failed = |error| fail(format!("{} to {}: {error}", from.display(), to.display()));
                std::fs::copy(from, to).map_err(failed)?;
                None
            }
            _ => None,
        };
        self.end_step();
        Ok(event)
    }

    fn end_step(&mut self) {
        self.steps.pop_front();
        (self.began, self.frames) = (Instant::now(), 0);
    }

    /// The due moves of an orbit; several if the window is slow.
    fn orbit(&mut self, app: &App, moves: u32, seconds: f32) -> Option<Vec<Event>> {
        let (now, place) = (Instant::now(), app.place);
        let at = |step: u32| {
            let (sin, cos) = (std::f32::consts::TAU * step as f32 / 50.0).sin_cos();
            place.center() + 0.2 * place.size().min_elem() * Vec2::new(cos, sin)
        };
        let Some((latency, done)) = &mut self.orbit else {
            self.began = now;
            self.orbit = Some((InputLatency::new(now, app.jobs.on_screen), 0));
            return Some(vec![Event::PointerMoved(at(0)), button(at(0), PointerButton::Primary, true)]);
        };
        let mut events = Vec::new();
        let due = |step: u32| self.began + Duration::from_secs_f32(seconds * step as f32 / moves.max(1) as f32);
        while *done < moves && due(*done) <= now {
            latency.moved(due(*done));
            *done += 1;
            events.push(Event::PointerMoved(at(*done)));
        }
        let late = now.duration_since(due(moves).min(now));
        if *done == moves && events.is_empty() && (latency.is_complete() || late > LAST_ANSWER) {
            // Standard output may be closed.
            let name = app.document.model.preset().unwrap_or("scene");
            let _ = writeln!(io::stdout(), "{name}: {latency}");
            events.push(button(at(moves), PointerButton::Primary, false));
            self.orbit = None;
            self.end_step();
        }
        Some(events)
    }

    /// Time until the next input, if known.
    pub(crate) fn pace(&self) -> Option<Duration> {
        match (&self.steps.front()?.1, &self.orbit) {
            (Step::Orbit(moves, seconds), Some((_, done))) if done < moves => {
                let due = self.began + Duration::from_secs_f32(seconds * *done as f32 / (*moves).max(1) as f32);
                Some(due.saturating_duration_since(Instant::now()))
            }
            // The device is busy with the awaited picture, whose arrival wakes the window.
            (Step::Picture | Step::Converged | Step::Drawn | Step::Validity | Step::Inspected, _) => Some(WAITING),
            _ => None,
        }
    }

    /// Records the end of a frame; `was_drawn` is false if it waits for a preview.
    pub(crate) fn drawn(&mut self, app: &App, was_drawn: bool) {
        if let Some((latency, _)) = &mut self.orbit {
            // Moves before the object is loaded belong to its first job.
            if !app.jobs.lacks_object {
                latency.submitted(app.jobs.number);
            }
            if was_drawn {
                latency.drawn(Instant::now(), app.jobs.on_screen, app.figures.size, app.figures.samples);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_that_is_none_is_refused_with_its_line() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("steps");
        std::fs::write(&file, "wait picture # comment\n\nclick Play\ndrag 0 0 1 1 right\nfrobnicate\n").unwrap();
        let error = Script::read(&file).err().unwrap().to_string();
        assert!(error.ends_with("steps:5: `frobnicate` is not a step"), "{error}");
        for (line, reason) in [("drag 0 0 1", "4 numbers"), ("key nothing", "no key"), ("drop", "needs a file")] {
            assert!(parse(line).unwrap_err().contains(reason), "{line}");
        }
    }
}
