//! The declarations in the comments of a module.
//!
//! A module declares its parameters where it uses them:
//! ```glsl
//! // @param hair_length = 0.16 in [0.005, 0.6]: Length of the hair, object units.
//! // @color tip_color = #d9a05f: Color of the hair at its tip.
//! // @outer hair_length      the soft region ends at this signed distance
//! // @move drip_length       a lookup moves at most so far, and matter grows as far; see `reach`
//! // @grow 0                 matter grows less than that
//! // @bound 1                the largest value of this noise
//! // @needs normal           the module reads the normal of a sample
//! // @exact procedural noise_block   what the module holds samples of: a module of its slot, and the lattice's repetition
//! ```
//! The same lines feed the uniform block, the checks of a scene file and the documentation.

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
    /// The largest value of the noise, where it is not [`super::reach::NOISE_BOUND`].
    pub noise_bound: Option<f32>,
    /// Whether the normal of a sample is read.
    pub needs_normal: bool,
    /// The module of the same slot that computes what this one holds samples of.
    pub exact: Option<Exact>,
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

impl Declarations {
    pub(super) fn add_suffix(&mut self, suffix: &str) {
        let parameters = self.parameters.iter_mut().map(|parameter| &mut parameter.name);
        let lengths = self.reach.iter_mut().flat_map(Reach::names);
        parameters.chain(&mut self.outer).chain(lengths).for_each(|name| name.push_str(suffix));
    }
}

pub(super) fn parse(path: &str, text: &str) -> Result<Declarations, LibraryError> {
    let (mut found, mut reach) = (Declarations::default(), Reach::default());
    for (index, line) in text.lines().enumerate() {
        let Some(declaration) = line.trim_start().strip_prefix("// @") else { continue };
        let wrong =
            || LibraryError::Declaration { path: path.into(), line: index + 1, text: line.trim_start().to_string() };
        let (kind, rest) = declaration.split_once(' ').ok_or_else(wrong)?;
        match kind {
            "param" => found.parameters.push(number(rest).ok_or_else(wrong)?),
            "color" => found.parameters.push(color(rest).ok_or_else(wrong)?),
            "outer" => found.outer = vec![identifier(rest).ok_or_else(wrong)?],
            "exact" => {
                let (module, repeat) = rest.trim().split_once(' ').map_or((rest, None), |(a, b)| (a, Some(b)));
                let repeat = repeat.map(|name| identifier(name).ok_or_else(wrong)).transpose()?;
                found.exact = Some(Exact { module: identifier(module).ok_or_else(wrong)?, repeat });
            }
            "needs" if rest.trim() == "normal" => found.needs_normal = true,
            "bound" => found.noise_bound = Some(rest.trim().parse().map_err(|_| wrong())?),
            "move" | "grow" => reach.add(kind == "grow", rest).ok_or_else(wrong)?,
            _ => return Err(wrong()),
        }
    }
    found.reach.extend((!reach.is_empty()).then_some(reach));
    Ok(found)
}

fn number(text: &str) -> Option<Parameter> {
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
    use crate::shader::{Library, Slots};

    fn declarations(text: &str) -> Result<Declarations, LibraryError> {
        Library::new([("a.frag".to_string(), text.to_string())]).declarations(&["a.frag"], &Slots::new())
    }

    #[test]
    fn parameters_are_read_with_default_range_and_sentence() {
        let text = "// @param size = 0.5 in [0, 2]: Size, in cells.\n// @color tint = #ff8000: Tint.";
        let found = declarations(text).unwrap();
        assert_eq!(found.parameters[0].kind, ParameterKind::Number(0.5, [0.0, 2.0]));
        assert_eq!(found.parameters[0].doc, "Size, in cells.");
        assert_eq!(found.parameters[1].kind, ParameterKind::Color([255, 128, 0]));
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
}
