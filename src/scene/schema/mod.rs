//! What a scene can be told: every setting once, in a table.
//!
//! Role: [`SETTINGS`] -> the ranges that a scene is checked by, the flags of the command line and their help, the controls
//! of the window, the command line that it copies, what is made anew for the next picture, and `docs/settings.md`.
//! Invariant: the table and the fields of a scene are the same, which a test holds.

mod table;
#[cfg(test)]
mod tests;
mod value;

pub use table::SETTINGS;
pub use value::number;

/// A setting of a scene.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// Its name with its table, as in a scene file: `quality.samples`.
    pub name: &'static str,
    /// What it does, with its unit: one sentence.
    pub doc: &'static str,
    /// What it may be.
    pub kind: Kind,
    /// The value that it begins with once it is switched on; `None` where it always has one.
    pub optional: Option<&'static str>,
    /// Its flag on the command line.
    pub flag: Option<Flag>,
    /// What is made anew where it changes.
    pub changes: Changes,
}

/// What a setting may be.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// A number.
    Number(Range),
    /// A number without a fraction.
    Whole(Range),
    /// One of these numbers.
    OneOf(&'static [u32]),
    /// As many numbers, in a list.
    Numbers(usize, Range),
    /// As many numbers without a fraction, in a list.
    Wholes(usize, Range),
    /// On or off.
    Switch,
    /// One of these names, each with a sentence about it.
    Choice(&'static [(&'static str, &'static str)]),
    /// A color, `#rrggbb` in sRGB.
    Color,
    /// Any text.
    Text,
    /// The module of a slot that has the name of the setting.
    Module(Filled),
    /// Modules of such a slot, applied in their order.
    Stack,
    /// The stops of a transfer map.
    Stops,
}

/// Who fills a slot.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filled {
    /// Each object for itself.
    ByObject,
    /// The scene, for all objects.
    ByScene,
}

/// From where to where a number goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The smallest.
    pub low: f32,
    /// The largest.
    pub high: f32,
    /// What a slider shows; a number beyond it can be typed.
    pub usual: [f32; 2],
}

/// A flag of the command line.
#[derive(Clone, Copy, Debug)]
pub struct Flag {
    /// Its name, without the dashes.
    pub name: &'static str,
    /// What is set where the flag has no value; `None` where it needs one.
    pub alone: Option<&'static str>,
}

/// What is made anew where a setting changes, and all that follows from it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Changes {
    /// The distance field of the object.
    Field,
    /// The program, or the images that it reads.
    Images,
    /// What the picture is drawn into, and how it is blended there.
    Targets,
    /// The picture; and its program, where it chooses a module of that.
    Picture,
}

/// The setting of this name; those of an additional object are those of the scene's own.
pub fn setting(name: &str) -> Option<&'static Setting> {
    let own = name.strip_prefix("parts.").and_then(|rest| Some(rest.split_once('.')?.1)).unwrap_or(name);
    SETTINGS.iter().find(|setting| setting.name == own)
}

/// Slots that modules are chosen for by name, and who fills them.
pub fn slots() -> impl Iterator<Item = (&'static str, Filled)> {
    SETTINGS.iter().filter_map(|setting| match setting.kind {
        Kind::Module(filled) => Some((setting.field(), filled)),
        Kind::Stack => Some((setting.field(), Filled::ByObject)),
        _ => None,
    })
}

/// Whether all objects of a scene share what fills a slot.
pub fn is_shared(slot: &str) -> bool {
    slots().any(|shared| shared == (slot, Filled::ByScene))
}

impl Setting {
    /// The table of a scene file that it is in; empty for those above all tables.
    pub fn table(&self) -> &'static str {
        self.name.rsplit_once('.').map_or("", |(table, _)| table)
    }

    /// Its name within that table.
    pub fn field(&self) -> &'static str {
        self.name.rsplit('.').next().unwrap_or_default()
    }

    /// What it may be, in words: `8 to 1024`, `steps, linear or spline`.
    pub fn limits(&self) -> String {
        let or = |names: Vec<String>| match names.split_last() {
            Some((last, others)) if !others.is_empty() => format!("{} or {last}", others.join(", ")),
            _ => names.concat(),
        };
        match self.kind {
            Kind::Number(range) | Kind::Whole(range) => range.limits(),
            Kind::Numbers(count, range) | Kind::Wholes(count, range) => match range.limits() {
                limits if limits.is_empty() => format!("{count} numbers"),
                limits => format!("{count} numbers, each {limits}"),
            },
            Kind::OneOf(numbers) => or(numbers.iter().map(u32::to_string).collect()),
            Kind::Choice(choices) => or(choices.iter().map(|(name, _)| name.to_string()).collect()),
            Kind::Switch => "true or false".into(),
            Kind::Color => "#rrggbb".into(),
            Kind::Module(_) => "a module".into(),
            Kind::Stack => "modules".into(),
            Kind::Text | Kind::Stops => String::new(),
        }
    }
}

impl Range {
    /// Whether every finite number is in it.
    pub fn is_all(self) -> bool {
        (self.low, self.high) == (f32::MIN, f32::MAX)
    }

    /// In words; nothing where it has every number.
    fn limits(self) -> String {
        if self.is_all() { String::new() } else { format!("{} to {}", self.low, self.high) }
    }
}
