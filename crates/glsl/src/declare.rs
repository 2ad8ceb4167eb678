//! The declarations in the comments of a module.
//!
//! A module declares its parameters where it uses them:
//! ```glsl
//! // @param hair_length = 0.16 in [0.005, 0.6]: Length of the hair, object units.
//! // @color tip_color = #d9a05f: Color of the hair at its tip.
//! // @outer hair_length      the soft region ends at this signed distance
//! // @move drip_length       a lookup moves at most so far, and matter grows as far; see `reach`
//! // @grow 0                 matter grows less than that
//! // @drift flow_speed      how many cells the noise moves in a second; see `drift`
//! // @bound 1                the largest value of this noise
//! // @needs normal           the module reads the normal of a sample
//! // @exact procedural noise_block   what the module holds samples of: a module of its slot, and the lattice's repetition
//! // @loops 1                loop iterations of one noise, or of one octave of turbulence
//! // @places 6               the density is asked for at so many more places
//! // @octaves 4              turbulence has no more octaves: a number, or what its `turbulence_block` holds
//! // @period memory          the lattice repeats as the module has it, and a scene says `own`
//! // @outside empty          a classification draws nothing beyond the soft region
//! // @segments soft_segment  the classification that integrates segments in place of this one
//! // @looks back             a classification asks for matter between a sample and the one before
//! ```
//! The same lines feed the uniform block, the checks of a scene file and the documentation. What a module leaves out has
//! the value that is safe: most loops, all octaves, matter everywhere.

use super::drift::Drift;
use super::error::LibraryError;
use super::names::identifier;
use super::reach::Reach;

/// What a module declares.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Declarations {
    /// Parameters, in the order of the file.
    pub parameters: Vec<Parameter>,
    /// Parameters that set the outer iso-value of the soft region, one for each layer of it.
    pub outer: Vec<String>,
    /// How far each of the modules moves lookups, and how far matter grows by that.
    pub reach: Vec<Reach>,
    /// How fast the modules move their noise.
    pub drifts: Vec<Drift>,
    /// The largest value of the noise, where it is not [`super::reach::NOISE_BOUND`].
    pub noise_bound: Option<f32>,
    /// Whether the normal of a sample is read.
    pub needs_normal: bool,
    /// The module of the same slot that computes what this one holds samples of; this and what follows are of one module,
    /// not of a program.
    pub exact: Option<Exact>,
    /// Loop iterations of one noise, 1 where it has no loop; or of one octave of turbulence, 0 where no sum is computed.
    pub loops: Option<u32>,
    /// At how many more places the module asks for the density.
    pub places: u32,
    /// The most octaves of turbulence.
    pub octaves: Octaves,
    /// How the lattice repeats where the scene has no say in it: `memory`, or one of the values of
    /// `effect.turbulence_repeat`.
    pub period: Option<String>,
    /// What a classification draws beyond the soft region.
    pub outside: Outside,
    /// The module that classifies segments in place of this one; itself, where it does.
    pub segments: Option<String>,
    /// Whether a classification asks for matter between a sample and the one before, a step nearer to the eye.
    pub looks_back: bool,
}

/// How many octaves a module of turbulence has at most.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Octaves {
    /// As many as are asked for.
    #[default]
    All,
    /// As many as its block holds.
    TurbulenceBlock,
    /// A number of them.
    Most(u32),
}

/// What a classification draws beyond the soft region.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outside {
    /// Anything.
    #[default]
    Matter,
    /// What the transfer map has at the density 0.
    Transfer,
    /// Nothing.
    Empty,
}

/// The module that a module approximates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exact {
    /// Its name; it fills the same slot.
    pub module: String,
    /// After how many cells its lattice has to repeat: a value of `effect.turbulence_repeat`; none where it does not
    /// matter.
    pub repeat: Option<String>,
}

/// A parameter of a module.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name in GLSL, in scene files and on the command line.
    pub name: String,
    /// Value where the scene gives none, with the allowed range of a number.
    pub kind: ParameterKind,
    /// One sentence with the unit.
    pub doc: String,
}

/// Type, default and range of a [`Parameter`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParameterKind {
    /// A finite number and the closed range it must lie in.
    Number(f32, [f32; 2]),
    /// A color: sRGB, 8 bits each.
    Color([u8; 3]),
}

/// How each declaration is written.
const FORMS: [(&str, &str); 16] = [
    ("param", "`// @param name = 0.5 in [0, 1]: What it does.`"),
    ("color", "`// @color name = #ff8000: What it is.`"),
    ("outer", "`// @outer parameter`, which the module declares by `// @param`"),
    ("move", "`// @move parameter` or, of one axis, `// @move +y 0.5 * parameter`"),
    ("grow", "`// @grow parameter` or, of one axis, `// @grow +y 0.5 * parameter`"),
    (
        "drift",
        "`// @drift speed` or, in other units than cells of noise per second, `// @drift speed * 0.5 * frequency`",
    ),
    ("bound", "`// @bound 0.87`"),
    ("needs", "`// @needs normal`"),
    ("exact", "`// @exact module`, and never, noise_block, turbulence_block or channel_block behind it"),
    ("loops", "`// @loops` and a whole number, 0 or more"),
    ("places", "`// @places` and a whole number, 0 or more"),
    ("octaves", "`// @octaves` and a whole number, 1 or more, or turbulence_block"),
    ("period", "`// @period` and memory, never, noise_block, turbulence_block or channel_block"),
    ("outside", "`// @outside empty` or `// @outside transfer`"),
    ("segments", "`// @segments module`"),
    ("looks", "`// @looks back`"),
];
/// How a lattice may repeat: values of `effect.turbulence_repeat`.
const PERIODS: [&str; 4] = ["never", "noise_block", "turbulence_block", "channel_block"];

impl Declarations {
    pub(super) fn add_suffix(&mut self, suffix: &str) {
        let parameters = self.parameters.iter_mut().map(|parameter| &mut parameter.name);
        let lengths = self.reach.iter_mut().flat_map(Reach::names);
        let speeds = self.drifts.iter_mut().flat_map(Drift::parameters);
        parameters.chain(&mut self.outer).chain(lengths).chain(speeds).for_each(|name| name.push_str(suffix));
    }
}

/// The kind of the declaration in a line, and what is behind it: `param` of `// @param`, which needs no blanks.
pub fn declaration(line: &str) -> Option<(&str, &str)> {
    let text = line.trim_start().strip_prefix("//")?.trim_start().strip_prefix('@')?;
    Some(text.split_once(char::is_whitespace).unwrap_or((text, "")))
}

pub(super) fn parse(path: &str, text: &str) -> Result<Declarations, LibraryError> {
    let (mut found, mut reach) = (Declarations::default(), Reach::default());
    let mut outer = None;
    for (index, line) in text.lines().enumerate() {
        let Some((kind, rest)) = declaration(line) else { continue };
        let wrong = || {
            let (path, text) = (path.to_string(), line.trim_start().to_string());
            LibraryError::Declaration { path, line: index + 1, text, allowed: allowed(kind) }
        };
        let word = rest.trim();
        let number = || word.parse::<u32>().map_err(|_| wrong());
        let name = || identifier(word).ok_or_else(wrong);
        let period = |name: &str| PERIODS.contains(&name).then(|| name.to_string()).ok_or_else(wrong);
        match kind {
            "param" => found.parameters.push(parameter(rest).ok_or_else(wrong)?),
            "color" => found.parameters.push(color(rest).ok_or_else(wrong)?),
            "outer" => {
                found.outer = vec![name()?];
                outer = Some(wrong());
            }
            "exact" => {
                let (module, repeat) = word.split_once(' ').map_or((word, None), |(a, b)| (a, Some(b.trim())));
                let repeat = repeat.map(period).transpose()?;
                found.exact = Some(Exact { module: identifier(module).ok_or_else(wrong)?, repeat });
            }
            "needs" if word == "normal" => found.needs_normal = true,
            "bound" => found.noise_bound = Some(word.parse().map_err(|_| wrong())?),
            "move" | "grow" => reach.add(kind == "grow", rest).ok_or_else(wrong)?,
            "drift" => found.drifts.push(Drift::parse(rest).ok_or_else(wrong)?),
            "loops" => found.loops = Some(number()?),
            "places" => found.places = number()?,
            "octaves" if word == "turbulence_block" => found.octaves = Octaves::TurbulenceBlock,
            "octaves" if word != "0" => found.octaves = Octaves::Most(number()?),
            "period" if word == "memory" => found.period = Some(word.into()),
            "period" => found.period = Some(period(word)?),
            "outside" if word == "empty" => found.outside = Outside::Empty,
            "outside" if word == "transfer" => found.outside = Outside::Transfer,
            "segments" => found.segments = Some(name()?),
            "looks" if word == "back" => found.looks_back = true,
            _ => return Err(wrong()),
        }
    }
    if let Some(unknown) = outer.filter(|_| !found.parameters.iter().any(|own| found.outer.contains(&own.name))) {
        return Err(unknown);
    }
    found.reach.extend((!reach.is_empty()).then_some(reach));
    Ok(found)
}

/// How a declaration is written, or which there are.
fn allowed(kind: &str) -> String {
    let form = FORMS.iter().find(|(known, _)| *known == kind).map(|(_, form)| form.to_string());
    let known = || FORMS.map(|(known, _)| format!("@{known}")).join(", ");
    form.unwrap_or_else(|| format!("one of: {}", known()))
}

fn parameter(text: &str) -> Option<Parameter> {
    let (name, rest) = text.split_once('=')?;
    let (value, rest) = rest.split_once(" in [")?;
    let (range, doc) = rest.split_once("]:")?;
    let (low, high) = range.split_once(',')?;
    let finite = |text: &str| text.trim().parse::<f32>().ok().filter(|value| value.is_finite());
    let (value, low, high) = (finite(value)?, finite(low)?, finite(high)?);
    let valid = low < high && (low..=high).contains(&value);
    valid.then_some(Parameter {
        name: identifier(name)?,
        kind: ParameterKind::Number(value, [low, high]),
        doc: doc.trim().into(),
    })
}

fn color(text: &str) -> Option<Parameter> {
    let (name, rest) = text.split_once('=')?;
    let (value, doc) = rest.split_once(": ")?;
    Some(Parameter {
        name: identifier(name)?,
        kind: ParameterKind::Color(hex_color(value.trim())?),
        doc: doc.trim().into(),
    })
}

/// Reads `#rrggbb`.
pub fn hex_color(text: &str) -> Option<[u8; 3]> {
    let digits = text.strip_prefix('#').filter(|digits| digits.len() == 6 && digits.is_ascii())?;
    let channel = |from: usize| u8::from_str_radix(&digits[from..from + 2], 16).ok();
    Some([channel(0)?, channel(2)?, channel(4)?])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Library, Slots};

    fn declarations(text: &str) -> Result<Declarations, LibraryError> {
        Library::new([("a.frag".to_string(), text.to_string())]).declarations(&["a.frag"], &Slots::new())
    }

    #[test]
    fn parameters_are_read_with_default_range_and_sentence() {
        let text = "// @param size = 0.5 in [0, 2]: Size, in cells.\n// @color tint = #ff8000: Tint.";
        for text in [text.to_string(), text.replace("// ", "//"), text.replace("// @", "\t//   @")] {
            let found = declarations(&text).unwrap();
            assert_eq!(found.parameters[0].kind, ParameterKind::Number(0.5, [0.0, 2.0]), "{text}");
            assert_eq!(found.parameters[0].doc, "Size, in cells.");
            assert_eq!(found.parameters[1].kind, ParameterKind::Color([255, 128, 0]));
        }
    }

    #[test]
    fn a_bad_declaration_names_file_and_line() {
        for text in
            ["// @param x = 3 in [0, 2]: Out of range.", "// @param Big = 1 in [0, 2]: Upper case.", "// @what x"]
        {
            let error = declarations(&format!("\n{text}")).unwrap_err().to_string();
            assert!(error.starts_with("a.frag:2:"), "{error}");
        }
    }

    #[test]
    fn a_bad_declaration_is_answered_with_what_is_allowed() {
        for (text, allowed) in [
            ("@loops many", "`// @loops` and a whole number, 0 or more"),
            ("@places -1", "`// @places` and a whole number, 0 or more"),
            ("@octaves 0", "`// @octaves` and a whole number, 1 or more, or turbulence_block"),
            ("@period", "`// @period` and memory, never, noise_block, turbulence_block or channel_block"),
            (
                "@exact procedural ever",
                "`// @exact module`, and never, noise_block, turbulence_block or channel_block behind it",
            ),
            ("@outside air", "`// @outside empty` or `// @outside transfer`"),
            ("@segments A", "`// @segments module`"),
            ("@looks ahead", "`// @looks back`"),
            ("@needs time", "`// @needs normal`"),
        ] {
            let expected = format!("a.frag:1: `// {text}` is not a declaration; write {allowed}");
            assert_eq!(declarations(&format!("// {text}")).unwrap_err().to_string(), expected);
        }
        assert!(declarations("// @what x").unwrap_err().to_string().ends_with("@segments, @looks"));
    }

    #[test]
    fn what_a_module_costs_and_allows_is_read_from_its_header() {
        let text = "// @loops 5\n// @places 6\n// @octaves 4\n// @period noise_block\n// @outside empty\n// @segments fine\n\
             // @looks back";
        let header = |text: &str| Library::new([("a/b.glsl".to_string(), text.to_string())]).header("a", "b").unwrap();
        let found = header(text);
        assert_eq!((found.loops, found.places, found.octaves), (Some(5), 6, Octaves::Most(4)));
        assert_eq!((found.period.as_deref(), found.segments.as_deref()), (Some("noise_block"), Some("fine")));
        assert_eq!((found.outside, found.looks_back), (Outside::Empty, true));
        assert_eq!(header("// Nothing."), Declarations::default());
    }
}
