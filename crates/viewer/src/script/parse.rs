//! Parser of scripts.

use crate::input::keys;
use egui::{Event, Key, Modifiers, PointerButton};
use std::path::PathBuf;

/// An input of the window system.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum ScriptEvent {
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
    /// Simulates a fault of the program.
    Panic,
    /// Closes the window.
    Quit,
}

#[derive(Clone, Debug, PartialEq)]
pub(super) enum Step {
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

pub(super) fn key(key: Key, modifiers: Modifiers) -> [Event; 2] {
    [true, false].map(|pressed| Event::Key { key, physical_key: None, pressed, repeat: false, modifiers })
}

/// Parses one line.
pub(super) fn parse(line: &str) -> Result<Step, String> {
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
        ("type", text) if !text.is_empty() => {
            Step::Do(ScriptEvent::Events(text.chars().map(|letter| Event::Text(letter.into())).collect()))
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
        ("panic", "") => Step::Do(ScriptEvent::Panic),
        ("quit", "") => Step::Do(ScriptEvent::Quit),
        _ => return Err(format!("`{line}` is not a step")),
    })
}
