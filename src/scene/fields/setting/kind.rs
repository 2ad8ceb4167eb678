//! Settings, and the kinds of values that they take.

/// A setting of a scene.
#[derive(Clone, Copy, Debug)]
pub struct Setting {
    /// Name with its table, as in a scene file: `quality.samples`.
    pub name: &'static str,
    /// Description with the unit, one sentence.
    pub doc: &'static str,
    /// Values that it takes.
    pub kind: Kind,
    /// First value of a setting that can be switched off; `None` for one that always has a value.
    pub optional: Option<&'static str>,
    /// Flag of the command line.
    pub flag: Option<Flag>,
    /// Part of the renderer that a change rebuilds.
    pub changes: Changes,
    /// Unit of its numbers.
    pub unit: Option<Unit>,
}

/// Unit of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unit {
    /// Degrees.
    Degrees,
    /// Seconds.
    Seconds,
    /// Pixels.
    Pixels,
    /// Texels.
    Texels,
    /// Object units: the longest side of the object is 2.
    ObjectUnits,
    /// Millimeters.
    Millimeters,
}

impl Unit {
    /// Symbol behind a number, with the space between them.
    pub fn symbol(self) -> &'static str {
        match self {
            Unit::Degrees => "\u{b0}",
            Unit::Seconds => " s",
            Unit::Pixels => " px",
            Unit::Texels => " tx",
            Unit::ObjectUnits => " u",
            Unit::Millimeters => " mm",
        }
    }
}

/// Values that a setting takes.
#[derive(Clone, Copy, Debug)]
pub enum Kind {
    /// A number.
    Number(Range),
    /// A whole number.
    Whole(Range),
    /// One of these numbers.
    OneOf(&'static [u32]),
    /// A list of this many numbers.
    Numbers(usize, Range),
    /// A list of this many whole numbers.
    Wholes(usize, Range),
    /// True or false.
    Switch,
    /// One of these names, each with its description.
    Choice(&'static [(&'static str, &'static str)]),
    /// A color, `#rrggbb` in sRGB.
    Color,
    /// Any text.
    Text,
    /// A module for the slot with the name of the setting.
    Module(Filled),
    /// A stack of modules for that slot, applied in order.
    Stack,
    /// The stops of a transfer map.
    Stops,
}

/// Whether a slot is filled for each object or once for the scene.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filled {
    /// Filled for each object.
    ByObject,
    /// Filled once; all objects share the module.
    ByScene,
}

/// Range of a number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// The smallest.
    pub low: f32,
    /// The largest.
    pub high: f32,
    /// Range of the slider; numbers beyond it can be typed.
    pub usual: [f32; 2],
}

/// A flag of the command line.
#[derive(Clone, Copy, Debug)]
pub struct Flag {
    /// Name, without the dashes.
    pub name: &'static str,
    /// Value of the flag without a value; `None` if it needs one.
    pub alone: Option<&'static str>,
}

/// First stage of the renderer that a change of a setting rebuilds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Changes {
    /// The distance field of the object.
    Field,
    /// The program, or the images that it reads.
    Images,
    /// The render targets and the way of blending.
    Targets,
    /// The picture; also the program, if the setting chooses a module.
    Picture,
    /// The size of the render targets.
    Size,
    /// The picture alone: its program is the same.
    View,
}

/// Stages that the differences of two scenes concern.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct ChangeSet(u8);

impl ChangeSet {
    /// A set of these.
    pub fn of(all: &[Changes]) -> ChangeSet {
        ChangeSet(all.iter().fold(0, |set, one| set | 1 << *one as u8))
    }

    /// With those of another set.
    pub fn with(self, other: ChangeSet) -> ChangeSet {
        ChangeSet(self.0 | other.0)
    }

    /// Whether nothing differs.
    pub fn is_empty(self) -> bool {
        self.0 == 0
    }

    /// Whether one of these is in the set.
    pub fn has_any(self, some: &[Changes]) -> bool {
        self.0 & ChangeSet::of(some).0 != 0
    }

    /// Whether nothing but these is in the set.
    pub fn is_within(self, all: &[Changes]) -> bool {
        self.0 & !ChangeSet::of(all).0 == 0
    }
}

/// A number from `low` to `high`.
pub(crate) const fn number(low: f32, high: f32) -> Kind {
    Kind::Number(Range::new(low, high))
}

/// A whole number from `low` to `high`.
pub(crate) const fn whole(low: f32, high: f32) -> Kind {
    Kind::Whole(Range::new(low, high))
}

/// A list of `count` numbers from `low` to `high`.
pub(crate) const fn numbers(count: usize, low: f32, high: f32) -> Kind {
    Kind::Numbers(count, Range::new(low, high))
}

/// A list of `count` whole numbers from `low` to `high`.
pub(crate) const fn wholes(count: usize, low: f32, high: f32) -> Kind {
    Kind::Wholes(count, Range::new(low, high))
}

impl Setting {
    /// A setting without a flag, which always has a value. The text comes from a doc comment, whose space it begins with.
    pub(crate) const fn new(name: &'static str, doc: &'static str, changes: Changes, kind: Kind) -> Setting {
        Setting { name, doc: doc.trim_ascii(), kind, optional: None, flag: None, changes, unit: None }
    }

    /// With a flag of the command line.
    pub(crate) const fn flag(mut self, name: &'static str) -> Setting {
        self.flag = Some(Flag { name, alone: None });
        self
    }

    /// With a flag that may stand without a value, and then sets this one.
    pub(crate) const fn flag_alone(mut self, name: &'static str, alone: &'static str) -> Setting {
        self.flag = Some(Flag { name, alone: Some(alone) });
        self
    }

    /// Not set by default; the value that it is switched on with.
    pub(crate) const fn optional(mut self, on: &'static str) -> Setting {
        self.optional = Some(on);
        self
    }

    /// With a unit.
    pub(crate) const fn unit(mut self, unit: Unit) -> Setting {
        self.unit = Some(unit);
        self
    }

    /// With a slider over a part of its range.
    pub(crate) const fn usual(mut self, low: f32, high: f32) -> Setting {
        if let Kind::Number(range) | Kind::Whole(range) | Kind::Numbers(_, range) = &mut self.kind {
            range.usual = [low, high];
        }
        self
    }

    /// Table of a scene file that holds the setting; empty at the top level.
    pub fn table(&self) -> &'static str {
        self.name.rsplit_once('.').map_or("", |(table, _)| table)
    }

    /// Name within that table.
    pub fn field(&self) -> &'static str {
        self.name.rsplit('.').next().unwrap_or_default()
    }

    /// Allowed values in words: `8 to 1024`, `steps, linear or spline`.
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
    /// Every finite number.
    pub(crate) const ANY: Range = Range { low: f32::MIN, high: f32::MAX, usual: [0.0, 1.0] };

    const fn new(low: f32, high: f32) -> Range {
        Range { low, high, usual: [low, high] }
    }

    /// Whether the range holds every finite number.
    pub fn is_all(self) -> bool {
        (self.low, self.high) == (f32::MIN, f32::MAX)
    }

    /// The range in words; empty for every number.
    fn limits(self) -> String {
        if self.is_all() { String::new() } else { format!("{} to {}", self.low, self.high) }
    }
}
