//! Units of length.

/// Unit of the coordinates of a file.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Unit {
    /// 0.001 mm.
    Micron,
    /// 1 mm.
    #[default]
    Millimeter,
    /// 10 mm.
    Centimeter,
    /// 25.4 mm.
    Inch,
    /// 304.8 mm.
    Foot,
    /// 1000 mm.
    Meter,
}

impl Unit {
    /// All, with their names in files and their symbols, smallest first.
    pub const ALL: [(Unit, &str, &str); 6] = [
        (Unit::Micron, "micron", "um"),
        (Unit::Millimeter, "millimeter", "mm"),
        (Unit::Centimeter, "centimeter", "cm"),
        (Unit::Inch, "inch", "in"),
        (Unit::Foot, "foot", "ft"),
        (Unit::Meter, "meter", "m"),
    ];

    /// Millimeters in one.
    pub fn millimeters(self) -> f64 {
        match self {
            Unit::Micron => 1e-3,
            Unit::Millimeter => 1.0,
            Unit::Centimeter => 10.0,
            Unit::Inch => 25.4,
            Unit::Foot => 304.8,
            Unit::Meter => 1e3,
        }
    }

    /// The unit with a name or a symbol; the micron is `µm` or `μm` too.
    pub fn named(text: &str) -> Option<Unit> {
        let text = if matches!(text, "\u{b5}m" | "\u{3bc}m") { "um" } else { text };
        Unit::ALL.iter().find(|(_, name, symbol)| [name, symbol].contains(&&text)).map(|(unit, ..)| *unit)
    }

    /// Name in files.
    pub fn name(self) -> &'static str {
        Unit::ALL[self as usize].1
    }

    /// Symbol behind a number.
    pub fn symbol(self) -> &'static str {
        Unit::ALL[self as usize].2
    }
}
