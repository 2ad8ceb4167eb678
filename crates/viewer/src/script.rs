//! Scripts of user input, for tests and screenshots.
//!
//! A script has one step per line; `#` starts a comment. Each step ends before the next one starts:
//! ```text
//! wait picture | converged         until the scene's own picture is shown, or a converged one
//! wait validity                    until the validity of the pixels is shown
//! wait inspected                   until the report on the inspected pixel is complete
//! wait drawn                       until any picture of the current scene is shown
//! wait loading                     until an object is being loaded
//! frames N                         until N frames were drawn
//! size W H                         resizes the window, points
//! minimize, restore                minimizes or restores the window
//! key NAME                         presses a key, named as in the help
//! drag X Y X Y [right | ctrl]      drags over the picture, in fractions from its left and top
//! scroll LINES                     turns the wheel in the center of the picture
//! orbit MOVES SECONDS              drags in circles, and prints the latency of the window
//! wait idle                        until no task is running
//! click NAME                       clicks the last control of that name
//! where NAME                       prints the rectangle of a control whose name starts so: left, top, right, bottom
//! set NAME NUMBER                  sets a slider
//! write NAME TEXT                  replaces the text of a field, `\n` for a new line
//! wait good | bad                  until the text of the editor has passed, or was refused
//! copy FILE FILE                   copies a file, as another program would
//! drop FILE                        drops a file on the window
//! shot FILE                        writes the picture of the scene
//! lose                             simulates a lost device
//! quit                             closes the window
//! ```

use super::ViewError;
use super::app::App;
use super::author::State;
use super::input_latency::InputLatency;
use super::keys;
use super::status::Stage;
use accesskit::{Action, ActionData, ActionRequest, Node, NodeId, TreeId};
use egui::{Event, Key, Modifiers, MouseWheelUnit, PointerButton, Pos2, Rect, TouchPhase, Vec2, accesskit};
use std::collections::VecDeque;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};
use support::open;

/// Size limit of a script, bytes.
const MAX_BYTES: u64 = 1 << 20;
/// Timeout of a step.
const PATIENCE: Duration = Duration::from_secs(600);
/// Timeout for the last picture of an orbit.
const LAST_ANSWER: Duration = Duration::from_secs(20);
/// Interval between frames while a step waits for a picture.
const WAITING: Duration = Duration::from_millis(50);
/// Number of moves of a drag.
const DRAG_STEPS: u32 = 8;

/// An input of the window system.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum ScriptEvent {
    /// Events for the next frame.
    Events(Vec<Event>),
    /// A dropped file.
    Drop(PathBuf),
    /// A size of the window, points.
    Size([u32; 2]),
    /// Minimizes or restores the window.
    Minimize(bool),
    /// Writes a picture.
    Shot(PathBuf),
    /// Simulates a lost device.
    Lose,
    /// Closes the window.
    Quit,
}

#[derive(Clone, Debug, PartialEq)]
enum Step {
    Drawn,
    Idle,
    Picture,
    Converged,
    Validity,
    Inspected,
    Loading,
    Frames(u32),
    Drag([f32; 4], PointerButton, Modifiers),
    Scroll(f32),
    Orbit(u32, f32),
    Good,
    Bad,
    Click(String),
    Where(String),
    Set(String, f64),
    Write(String, String),
    Copy(PathBuf, PathBuf),
    Do(ScriptEvent),
}

/// A running script.
pub(super) struct Script {
    file: String,
    steps: VecDeque<(usize, Step)>,
    /// Remaining events of the last step.
    events: VecDeque<Vec<Event>>,
    began: Instant,
    frames: u32,
    /// Latency of the running orbit, and its number of moves.
    orbit: Option<(InputLatency, u32)>,
}

impl Script {
    /// Reads a script.
    pub(super) fn read(file: &Path) -> Result<Script, ViewError> {
        let name = file.display().to_string();
        let text =
            open::text(file, MAX_BYTES).map_err(|error| ViewError::Failed(format!("{}: {error}", file.display())))?;
        let mut steps = VecDeque::new();
        for (number, line) in (1..).zip(text.lines()) {
            let line = line.split('#').next().unwrap_or_default().trim();
            if !line.is_empty() {
                let fail = |reason| ViewError::Script { file: name.clone(), line: number, reason };
                steps.push_back((number, parse(line).map_err(fail)?));
            }
        }
        Ok(Script::new(name, steps))
    }

    /// The script of `--frames` and `--screenshot`.
    pub(super) fn of_frames(frames: Option<u32>, shot: Option<PathBuf>) -> Script {
        let wait = frames.map_or(vec![Step::Converged], |frames| vec![Step::Picture, Step::Frames(frames)]);
        let shot = shot.map(|path| Step::Do(ScriptEvent::Shot(path)));
        let steps = wait.into_iter().chain(shot).chain([Step::Do(ScriptEvent::Quit)]);
        Script::new("--frames".into(), (1..).zip(steps).collect())
    }

    fn new(file: String, steps: VecDeque<(usize, Step)>) -> Script {
        Script { file, steps, events: VecDeque::new(), began: Instant::now(), frames: 0, orbit: None }
    }

    /// The input before the next frame.
    pub(super) fn next(&mut self, app: &mut App, tree: &[Widget]) -> Result<Option<ScriptEvent>, ViewError> {
        if let Some(events) = self.events.pop_front() {
            return Ok(Some(ScriptEvent::Events(events)));
        }
        let Some((line, step)) = self.steps.front().cloned() else { return Ok(None) };
        let fail = |reason: String| ViewError::Script { file: self.file.clone(), line, reason };
        if let Some(reason) = &app.failure {
            return Err(fail(reason.clone()));
        }
        if let Step::Orbit(moves, seconds) = step {
            return Ok(self.orbit(app, moves, seconds).map(ScriptEvent::Events));
        }
        self.frames += 1;
        let stage = app.figures.stage;
        let steady = app.tasks.running == 0;
        let done = match &step {
            Step::Drawn => app.is_current(),
            Step::Picture => app.is_current() && !matches!(stage, Stage::None | Stage::Coarse | Stage::Partial),
            Step::Converged => app.is_current() && matches!(stage, Stage::Converged(_)),
            Step::Validity => app.is_current() && stage == Stage::Validity,
            Step::Inspected => app.is_inspected(),
            Step::Loading => app.loading().is_some(),
            Step::Frames(count) => self.frames > *count,
            Step::Good => self.frames > 1 && *app.author().state() == State::Good,
            Step::Bad => matches!(app.author().state(), State::Bad(_)),
            // Keys do not wait for tasks.
            Step::Do(ScriptEvent::Events(_)) => true,
            _ => steady,
        };
        if !done {
            return match self.began.elapsed() > PATIENCE {
                true => Err(fail(format!("{step:?} timed out after {} s", PATIENCE.as_secs()))),
                false => Ok(None),
            };
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
                let begins =
                    |own: &Widget| own.node.label().or(own.node.value()).is_some_and(|own| own.starts_with(name));
                let place = tree.iter().rfind(|own| begins(own)).and_then(|own| own.node.bounds());
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
            let name = app.model.preset().unwrap_or("scene");
            let _ = writeln!(io::stdout(), "{name}: {latency}");
            events.push(button(at(moves), PointerButton::Primary, false));
            self.orbit = None;
            self.end_step();
        }
        Some(events)
    }

    /// Time until the next input, if known.
    pub(super) fn pace(&self) -> Option<Duration> {
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
    pub(super) fn drawn(&mut self, app: &App, was_drawn: bool) {
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

/// A node of the accessibility tree.
#[derive(Clone, Debug)]
pub(super) struct Widget {
    id: NodeId,
    node: Node,
}

/// The nodes of the accessibility tree.
pub(super) fn widgets(update: &accesskit::TreeUpdate) -> Vec<Widget> {
    update.nodes.iter().map(|(id, node)| Widget { id: *id, node: node.clone() }).collect()
}

/// The last node of a name that supports an action: overlays come last.
fn find<'a>(tree: &'a [Widget], name: &str, action: Action) -> Result<&'a Widget, String> {
    let named = |widget: &&Widget| widget.node.label().or(widget.node.value()) == Some(name);
    tree.iter().rfind(|widget| widget.node.supports_action(action) && named(widget)).ok_or_else(|| {
        let usable = tree.iter().filter(|widget| widget.node.supports_action(action));
        let known: Vec<&str> = usable.filter_map(|widget| widget.node.label().or(widget.node.value())).collect();
        format!("no control is called `{name}`; known: {}", known.join(", "))
    })
}

/// An accessibility action on a control.
fn request(widget: &Widget, action: Action, data: Option<ActionData>) -> ScriptEvent {
    let request = ActionRequest { action, target_node: widget.id, target_tree: TreeId::ROOT, data };
    ScriptEvent::Events(vec![Event::AccessKitActionRequest(request)])
}

fn key(key: Key, modifiers: Modifiers) -> [Event; 2] {
    [true, false].map(|pressed| Event::Key { key, physical_key: None, pressed, repeat: false, modifiers })
}

fn button(pos: Pos2, button: PointerButton, pressed: bool) -> Event {
    Event::PointerButton { pos, button, pressed, modifiers: Modifiers::NONE }
}

fn drag(place: Rect, [x0, y0, x1, y1]: [f32; 4], with: PointerButton, held: Modifiers) -> VecDeque<Vec<Event>> {
    let at = |part: f32| {
        let (x, y) = (x0 + (x1 - x0) * part, y0 + (y1 - y0) * part);
        place.min + Vec2::new(x * place.width(), y * place.height())
    };
    let moves = (1..=DRAG_STEPS).map(|step| vec![Event::PointerMoved(at(step as f32 / DRAG_STEPS as f32))]);
    let start = [vec![Event::PointerMoved(at(0.0))], vec![Event::ModifiersChanged(held), button(at(0.0), with, true)]];
    start
        .into_iter()
        .chain(moves)
        .chain([vec![button(at(1.0), with, false), Event::ModifiersChanged(Modifiers::NONE)]])
        .collect()
}

fn parse(line: &str) -> Result<Step, String> {
    let (word, rest) = line.split_once(char::is_whitespace).map_or((line, ""), |(word, rest)| (word, rest.trim()));
    let numbers = |count: usize| -> Result<Vec<f32>, String> {
        let parsed: Vec<f32> = rest.split_whitespace().map_while(|number| number.parse().ok()).collect();
        if parsed.len() == count { Ok(parsed) } else { Err(format!("`{word}` needs {count} numbers")) }
    };
    let path = || if rest.is_empty() { Err(format!("`{word}` needs a file")) } else { Ok(PathBuf::from(rest)) };
    Ok(match (word, rest) {
        ("wait", "drawn") => Step::Drawn,
        ("wait", "idle") => Step::Idle,
        ("wait", "picture") => Step::Picture,
        ("wait", "converged") => Step::Converged,
        ("wait", "validity") => Step::Validity,
        ("wait", "inspected") => Step::Inspected,
        ("wait", "loading") => Step::Loading,
        ("wait", "good") => Step::Good,
        ("wait", "bad") => Step::Bad,
        ("set" | "write" | "copy", _) => {
            let (name, value) = rest.split_once(' ').ok_or_else(|| format!("`{word}` needs two words"))?;
            match word {
                "set" => Step::Set(name.into(), value.parse().map_err(|_| format!("`{value}` is not a number"))?),
                "write" => Step::Write(name.into(), value.replace("\\n", "\n")),
                _ => Step::Copy(name.into(), value.into()),
            }
        }
        ("frames", _) => Step::Frames(numbers(1)?[0] as u32),
        ("size", _) => {
            let sides = numbers(2)?;
            Step::Do(ScriptEvent::Size([sides[0] as u32, sides[1] as u32]))
        }
        ("minimize", "") => Step::Do(ScriptEvent::Minimize(true)),
        ("restore", "") => Step::Do(ScriptEvent::Minimize(false)),
        ("key", name) => {
            let named = keys::named(name).ok_or_else(|| format!("no key `{name}`"))?;
            Step::Do(ScriptEvent::Events(key(named.0, named.1).into()))
        }
        ("drag", _) => {
            let places = numbers(4)?;
            let with = if rest.ends_with("right") { PointerButton::Secondary } else { PointerButton::Primary };
            let modifiers = if rest.ends_with("ctrl") { Modifiers::COMMAND } else { Modifiers::NONE };
            Step::Drag([places[0], places[1], places[2], places[3]], with, modifiers)
        }
        ("orbit", _) => {
            let values = numbers(2)?;
            Step::Orbit(values[0] as u32, values[1])
        }
        ("scroll", _) => Step::Scroll(numbers(1)?[0]),
        ("click", name) if !name.is_empty() => Step::Click(name.into()),
        ("where", name) if !name.is_empty() => Step::Where(name.into()),
        ("drop", _) => Step::Do(ScriptEvent::Drop(path()?)),
        ("shot", _) => Step::Do(ScriptEvent::Shot(path()?)),
        ("lose", "") => Step::Do(ScriptEvent::Lose),
        ("quit", "") => Step::Do(ScriptEvent::Quit),
        _ => return Err(format!("`{line}` is not a step")),
    })
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

    #[test]
    fn a_drag_presses_where_it_begins_and_lets_go_where_it_ends() {
        let place = Rect::from_min_size(Pos2::new(10.0, 20.0), Vec2::new(100.0, 200.0));
        let events: Vec<Event> =
            drag(place, [0.0, 0.5, 1.0, 0.5], PointerButton::Primary, Modifiers::CTRL).into_iter().flatten().collect();
        let (from, to) = (Pos2::new(10.0, 120.0), Pos2::new(110.0, 120.0));
        let (press, release) = (button(from, PointerButton::Primary, true), button(to, PointerButton::Primary, false));
        assert_eq!(events[1..3], [Event::ModifiersChanged(Modifiers::CTRL), press]);
        let end = [Event::PointerMoved(to), release, Event::ModifiersChanged(Modifiers::NONE)];
        assert_eq!(events[events.len() - 3..], end);
    }
}
