//! Declarations in the comments of a module.
//!
//! A module declares its parameters where it uses them:
//! ```glsl
//! // @param hair_length = 0.16 in [0.005, 0.6]: Length of the hair, object units.
//! //                        `, object units`: it is a length, which may be given in millimeters
//! // @color tip_color = #d9a05f: Color of the hair at its tip.
//! // @outer hair_length      signed distance at which the soft region ends
//! // @move drip_length       bound of the motion of lookups, and of the growth of matter; see `reach`
//! // @grow 0                 bound of the growth of matter, if it is less
//! // @drift flow_speed      noise cells per second; see `drift`
//! // @bound 1                the largest value of this noise
//! // @needs normal           the module reads the normal of a sample
//! // @groom length color      channels of the groom that the module reads: length, density, color, direction
//! // @exact procedural noise_block   the module of the slot that this one samples, and the repetition of its lattice
//! // @loops 1                loop iterations of one noise, or of one octave of turbulence
//! // @places 6               additional evaluations of the density
//! // @octaves 4              most octaves of turbulence: a number, or those of `turbulence_block`
//! // @period memory          repetition of the lattice, where the scene does not choose it
//! // @outside empty          content drawn beyond the soft region by a classification
//! // @segments soft_segment  the variant of this classification that integrates segments
//! // @looks back             the classification looks for matter between consecutive samples
//! ```
//! They feed the uniform block, the checks of scene files and the documentation. Defaults are conservative: most loops, all
//! octaves, matter everywhere.

use super::drift::Drift;
use super::error::LibraryError;
use super::names::{identifier, is_reserved, suffixed};
use super::reach::Reach;
use hypertexture_support::words::nearest;
use std::collections::BTreeSet;

/// Declarations of a module or of a program.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Declarations {
    /// Parameters, in the order of the file.
    pub parameters: Vec<Parameter>,
    /// Parameters for the outer iso-value of the soft region, one for each layer.
    pub outer: Vec<String>,
    /// Reach of each module.
    pub reach: Vec<Reach>,
    /// Drifts of the noise.
    pub drifts: Vec<Drift>,
    /// Bound of the noise, if not [`super::reach::NOISE_BOUND`].
    pub noise_bound: Option<f32>,
    /// Whether the normal of a sample is read.
    pub needs_normal: bool,
    /// Channels of the groom that are read.
    pub groom: BTreeSet<String>,
    /// The module of the same slot that this one samples. This and the following fields are for single modules only.
    pub exact: Option<Exact>,
    /// Loop iterations of one noise (1 without a loop) or of one octave of turbulence (0 without a sum).
    pub loops: Option<u32>,
    /// Additional evaluations of the density.
    pub places: u32,
    /// The most octaves of turbulence.
    pub octaves: Octaves,
    /// Repetition of the lattice, if not chosen by the scene: `memory`, or a value of `effect.turbulence_repeat`.
    pub period: Option<String>,
    /// Content drawn beyond the soft region by a classification.
    pub outside: Outside,
    /// The variant of a classification that integrates segments; the module itself if it does.
    pub segments: Option<String>,
    /// Whether a classification looks for matter between a sample and the previous one, a step nearer to the eye.
    pub looks_back: bool,
}

/// Limit of the octaves of a turbulence module.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Octaves {
    /// No limit.
    #[default]
    All,
    /// The octaves of its block.
    TurbulenceBlock,
    /// A number.
    Most(u32),
}

/// Content that a classification draws beyond the soft region.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Outside {
    /// Anything.
    #[default]
    Matter,
    /// The transfer map at density 0.
    Transfer,
    /// Nothing.
    Empty,
}

/// The module that a module approximates.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Exact {
    /// Name of the module, in the same slot.
    pub module: String,
    /// Required repetition of its lattice: a value of `effect.turbulence_repeat`; `None` if it does not matter.
    pub repeat: Option<String>,
}

/// A parameter of a module.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// Name in GLSL, in scene files and on the command line.
    pub name: String,
    /// Type, default and range.
    pub kind: ParameterKind,
    /// One sentence with the unit; see [`Parameter::is_length`].
    pub doc: String,
}

impl Parameter {
    /// Whether it is a length in object space: `object units` follow a comma or begin a clause of its description.
    pub fn is_length(&self) -> bool {
        let after =
            [", ", "; ", "in "].iter().filter_map(|before| self.doc.split_once(&format!("{before}object units")));
        matches!(self.kind, ParameterKind::Number(..)) && after.into_iter().any(|(_, rest)| !rest.starts_with(" per "))
    }
}

/// Type, default and range of a [`Parameter`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ParameterKind {
    /// A finite default and the closed range of values.
    Number(f32, [f32; 2]),
    /// A color: sRGB, 8 bits each.
    Color([u8; 3]),
}

/// Syntax of each declaration, for errors.
const FORMS: [(&str, &str); 17] = [
    ("param", "`// @param name = 0.5 in [0, 1]: Its effect.`"),
    ("color", "`// @color name = #ff8000: Its meaning.`"),
    ("outer", "`// @outer parameter`, which the module declares by `// @param`"),
    ("move", "`// @move parameter` or, of one axis, `// @move +y 0.5 * parameter`"),
    ("grow", "`// @grow parameter` or, of one axis, `// @grow +y 0.5 * parameter`"),
    (
        "drift",
        "`// @drift speed` or, in other units than cells of noise per second, `// @drift speed * 0.5 * frequency`",
    ),
    ("bound", "`// @bound 0.87`"),
    ("needs", "`// @needs normal`"),
    ("groom", "`// @groom` and channels out of length, density, color and direction"),
    ("exact", "`// @exact module`, and never, noise_block, turbulence_block or channel_block behind it"),
    ("loops", "`// @loops` and a whole number, 0 or more"),
    ("places", "`// @places` and a whole number, 0 or more"),
    ("octaves", "`// @octaves` and a whole number, 1 or more, or turbulence_block"),
    ("period", "`// @period` and memory, never, noise_block, turbulence_block or channel_block"),
    ("outside", "`// @outside empty` or `// @outside transfer`"),
    ("segments", "`// @segments module`"),
    ("looks", "`// @looks back`"),
];
/// Values of `effect.turbulence_repeat`.
const PERIODS: [&str; 4] = ["never", "noise_block", "turbulence_block", "channel_block"];

/// Channels of a groom.
const PAINTED: [&str; 4] = ["length", "density", "color", "direction"];

impl Declarations {
    pub(super) fn add_suffix(&mut self, suffix: &str) {
        let parameters = self.parameters.iter_mut().map(|parameter| &mut parameter.name);
        let lengths = self.reach.iter_mut().flat_map(Reach::names);
        let speeds = self.drifts.iter_mut().flat_map(Drift::parameters);
        parameters.chain(&mut self.outer).chain(lengths).chain(speeds).for_each(|name| *name = suffixed(name, suffix));
    }
}

/// The kind of a line's declaration, such as `param` of `// @param`, and the text after it. Blanks are optional.
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
        if !is_meant(kind) {
            continue;
        }
        let word = rest.trim();
        let named = |(name, reason)| LibraryError::Parameter { path: path.into(), line: index + 1, name, reason };
        let number = || word.parse::<u32>().map_err(|_| wrong());
        let name = || identifier(word).ok_or_else(wrong);
        let period = |name: &str| PERIODS.contains(&name).then(|| name.to_string()).ok_or_else(wrong);
        match kind {
            "param" => found.parameters.push(parameter(rest).ok_or_else(wrong)?.map_err(named)?),
            "color" => found.parameters.push(color(rest).ok_or_else(wrong)?.map_err(named)?),
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
            "groom" if !word.is_empty() && word.split_whitespace().all(|channel| PAINTED.contains(&channel)) => {
                found.groom.extend(word.split_whitespace().map(String::from));
            }
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
    let of_turbulence = text.lines().any(|line| line.trim() == "#include <turbulence>");
    found.drifts.iter_mut().for_each(|drift| drift.of_turbulence = of_turbulence);
    Ok(found)
}

/// Syntax of a kind of declaration, or the list of kinds.
fn allowed(kind: &str) -> String {
    let form = FORMS.iter().find(|(known, _)| *known == kind).map(|(_, form)| form.to_string());
    let known = || FORMS.map(|(known, _)| format!("@{known}")).join(", ");
    form.unwrap_or_else(|| format!("one of: {}", known()))
}

/// Whether a tag is a declaration, or a misspelt one. Others, such as `@author`, belong to the comment.
fn is_meant(kind: &str) -> bool {
    let known = FORMS.map(|(known, _)| known);
    known.iter().any(|known| kind.starts_with(known)) || nearest(kind, &known).is_some()
}

/// A parameter, or its name and what is wrong with it. `None` if the text has another form.
type Read = Option<Result<Parameter, (String, String)>>;

/// The name of a parameter, or what is wrong with it.
fn parameter_name(text: &str) -> Result<String, (String, String)> {
    let name = text.trim();
    identifier(name).ok_or_else(|| {
        let reason = if is_reserved(name) {
            "GLSL reserves this name; choose another"
        } else {
            "a name has a-z, 0-9 and _, a letter first"
        };
        (name.into(), reason.into())
    })
}

fn parameter(text: &str) -> Read {
    let (name, rest) = text.split_once('=')?;
    let (value, rest) = rest.split_once(" in [")?;
    let (range, doc) = rest.split_once("]:")?;
    let (low, high) = range.split_once(',')?;
    let number = |text: &str| text.trim().parse::<f32>().ok();
    let (value, low, high) = (number(value)?, number(low)?, number(high)?);
    let reason = match [value, low, high].iter().find(|number| !number.is_finite()) {
        Some(number) => format!("{number} is not a finite number of f32, whose largest is 3.4e38"),
        None if low > high => format!("the range [{low}, {high}] begins with its larger end; write [{high}, {low}]"),
        None if low == high => format!("the range [{low}, {high}] has one value; write a constant"),
        None if !(low..=high).contains(&value) => format!("the default {value} is outside of [{low}, {high}]"),
        None => String::new(),
    };
    let valid = |name: String| {
        if reason.is_empty() {
            Ok(Parameter { name, kind: ParameterKind::Number(value, [low, high]), doc: doc.trim().into() })
        } else {
            Err((name, reason))
        }
    };
    Some(parameter_name(name).and_then(valid))
}

fn color(text: &str) -> Read {
    let (name, rest) = text.split_once('=')?;
    let (value, doc) = rest.split_once(": ")?;
    let kind = ParameterKind::Color(hex_color(value.trim())?);
    Some(parameter_name(name).map(|name| Parameter { name, kind, doc: doc.trim().into() }))
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
            ["// @param x = 3 in [0, 2]: Out of range.", "// @param Big = 1 in [0, 2]: Upper case.", "// @parm x"]
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
            ("@groom width", "`// @groom` and channels out of length, density, color and direction"),
        ] {
            let expected = format!("a.frag:1: `// {text}` is not a declaration; write {allowed}");
            assert_eq!(declarations(&format!("// {text}")).unwrap_err().to_string(), expected);
        }
        assert!(declarations("// @parm x").unwrap_err().to_string().ends_with("@segments, @looks"));
    }

    #[test]
    fn a_wrong_parameter_is_answered_with_what_is_wrong() {
        for (text, expected) in [
            ("@param x = 5 in [0, 1]: X.", "the parameter `x`: the default 5 is outside of [0, 1]"),
            (
                "@param x = 0.5 in [1, 0]: X.",
                "the parameter `x`: the range [1, 0] begins with its larger end; write [0, 1]",
            ),
            ("@param x = 1 in [1, 1]: X.", "the parameter `x`: the range [1, 1] has one value; write a constant"),
            (
                "@param x = 1e39 in [0, 1]: X.",
                "the parameter `x`: inf is not a finite number of f32, whose largest is 3.4e38",
            ),
            (
                "@param x = nan in [0, 1]: X.",
                "the parameter `x`: NaN is not a finite number of f32, whose largest is 3.4e38",
            ),
            ("@param float = 1 in [0, 1]: X.", "the parameter `float`: GLSL reserves this name; choose another"),
            ("@param größe = 1 in [0, 1]: X.", "the parameter `größe`: a name has a-z, 0-9 and _, a letter first"),
            ("@color 2nd = #ffffff: X.", "the parameter `2nd`: a name has a-z, 0-9 and _, a letter first"),
        ] {
            assert_eq!(declarations(&format!("\n// {text}")).unwrap_err().to_string(), format!("a.frag:2: {expected}"));
        }
    }

    #[test]
    fn other_tags_belong_to_the_comment_and_misspelt_ones_do_not() {
        for tag in [
            "author nobody",
            "license MIT",
            "see https://a.b",
            "version 2",
            "brief Rings.",
            "note x",
            "return density",
            "todo",
            "",
        ] {
            assert_eq!(declarations(&format!("// @{tag}")), Ok(Declarations::default()), "{tag}");
        }
        for tag in ["parm", "params", "Param", "colour", "octave", "loop", "outter", "mvoe", "parameter", "segmnets"] {
            let error = declarations(&format!("// @{tag} x")).unwrap_err().to_string();
            assert!(error.contains("is not a declaration; write one of: @param"), "{tag}: {error}");
        }
    }

    #[test]
    fn costs_and_limits_are_parsed() {
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
