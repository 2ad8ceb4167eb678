//! Reach of a module: how far it moves lookups (`// @move`), and how far matter grows (`// @grow`).
//!
//! ```glsl
//! // @move perturbation                       a lookup moves at most this far, in any direction
//! // @move +y 0.5 * drip_length               ... along +y; `-y` along -y, `y` along both
//! // @grow 0                                  matter does not grow
//! ```
//! Lines of one kind add up, as do modules of a stack. Without `@grow`, matter grows as far as lookups move, in the opposite
//! direction. Two names in a length are not parameters: `hold_radius`, beyond which steps along the radius keep their length
//! (`scale_radius.glsl`), and `noise_bound`, the bound of the noise. A module of slot `noise` declares the latter by
//! `// @bound 1` if it is not [`NOISE_BOUND`].

use std::array::from_fn;

/// Names in a length that are not parameters.
pub const GIVEN: [&str; 2] = ["hold_radius", "noise_bound"];
/// Bound of gradient noise: eight unit gradients that point to the middle of a cell.
pub const NOISE_BOUND: f32 = 0.866_025_4;

/// Declared lengths of a module.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reach {
    moves: Vec<Length>,
    grows: Vec<Length>,
}

/// Distances in all directions, object units.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sides {
    /// In any direction.
    pub round: f32,
    /// Additionally along -x, -y and -z.
    pub low: [f32; 3],
    /// Additionally along +x, +y and +z.
    pub high: [f32; 3],
}

/// A length: a sum of products.
#[derive(Clone, Debug, PartialEq)]
struct Length {
    /// Axis, and whether its lower and upper side count; `None` for any direction.
    axis: Option<(usize, [bool; 2])>,
    terms: Vec<Vec<Factor>>,
}

#[derive(Clone, Debug, PartialEq)]
enum Factor {
    Number(f32),
    Name(String),
}

impl Reach {
    /// Parses the text after `@move` or `@grow`.
    pub(super) fn add(&mut self, grows: bool, text: &str) -> Option<()> {
        let length = Length::parse(text)?;
        if grows { &mut self.grows } else { &mut self.moves }.push(length);
        Some(())
    }

    /// Whether no length is declared.
    pub(super) fn is_empty(&self) -> bool {
        self.moves.is_empty() && self.grows.is_empty()
    }

    /// Names of the parameters in all lengths.
    pub(super) fn names(&mut self) -> impl Iterator<Item = &mut String> {
        let factors = self.moves.iter_mut().chain(&mut self.grows).flat_map(|length| length.terms.iter_mut().flatten());
        factors.filter_map(|factor| match factor {
            Factor::Name(name) if !GIVEN.contains(&name.as_str()) => Some(name),
            _ => None,
        })
    }

    /// Bound of the motion of lookups.
    pub fn moves(&self, value: &dyn Fn(&str) -> f32) -> Sides {
        sum(&self.moves, value)
    }

    /// Bound of the growth of matter.
    pub fn grows(&self, value: &dyn Fn(&str) -> f32) -> Sides {
        if self.grows.is_empty() { self.moves(value).mirrored() } else { sum(&self.grows, value) }
    }
}

impl Sides {
    /// The sum of two reaches.
    #[must_use]
    pub fn plus(self, other: Sides) -> Sides {
        let add = |a: [f32; 3], b: [f32; 3]| from_fn(|axis| a[axis] + b[axis]);
        Sides { round: self.round + other.round, low: add(self.low, other.low), high: add(self.high, other.high) }
    }

    /// The reach of as many times the effect.
    #[must_use]
    pub fn times(self, strength: f32) -> Sides {
        let all = |sides: [f32; 3]| sides.map(|side| strength * side);
        Sides { round: strength * self.round, low: all(self.low), high: all(self.high) }
    }

    /// The reach in opposite directions.
    #[must_use]
    pub fn mirrored(self) -> Sides {
        Sides { low: self.high, high: self.low, ..self }
    }

    /// Largest distance in any direction.
    pub fn farthest(&self) -> f32 {
        self.round + norm(from_fn(|axis| self.low[axis].max(self.high[axis])))
    }

    /// Largest difference of two steps within this reach.
    pub fn span(&self) -> f32 {
        2.0 * self.round + norm(from_fn(|axis| self.low[axis] + self.high[axis]))
    }
}

fn norm(v: [f32; 3]) -> f32 {
    v.iter().map(|value| value * value).sum::<f32>().sqrt()
}

fn sum(lengths: &[Length], value: &dyn Fn(&str) -> f32) -> Sides {
    lengths.iter().map(|length| length.sides(value)).fold(Sides::default(), Sides::plus)
}

impl Length {
    fn parse(text: &str) -> Option<Length> {
        let (axis, sum) = match text.trim().split_once(' ') {
            Some((first, rest)) if !rest.trim_start().starts_with(['+', '*']) => (Some(axis(first)?), rest),
            _ => (None, text),
        };
        let factor = |text: &str| match text.trim().parse::<f32>() {
            Ok(number) => (number.is_finite() && number >= 0.0).then_some(Factor::Number(number)),
            Err(_) => super::names::identifier(text).map(Factor::Name),
        };
        let product = |text: &str| text.split('*').map(factor).collect::<Option<Vec<_>>>();
        Some(Length { axis, terms: sum.split('+').map(product).collect::<Option<_>>()? })
    }

    fn sides(&self, value: &dyn Fn(&str) -> f32) -> Sides {
        let factor = |factor: &Factor| match factor {
            Factor::Number(number) => *number,
            Factor::Name(name) => value(name),
        };
        let length = self.terms.iter().map(|product| product.iter().map(factor).product::<f32>()).sum::<f32>().max(0.0);
        let Some((axis, sides)) = self.axis else { return Sides { round: length, ..Sides::default() } };
        let along = |side: bool| from_fn(|other| if side && other == axis { length } else { 0.0 });
        Sides { round: 0.0, low: along(sides[0]), high: along(sides[1]) }
    }
}

/// `x`, `-x` or `+x`, and so on.
fn axis(text: &str) -> Option<(usize, [bool; 2])> {
    let (sides, name) = match text.strip_prefix(['+', '-']) {
        Some(name) => ([text.starts_with('-'), text.starts_with('+')], name),
        None => ([true; 2], text),
    };
    Some((["x", "y", "z"].iter().position(|axis| *axis == name)?, sides))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn reach(lines: &[(bool, &str)]) -> Reach {
        let mut reach = Reach::default();
        lines.iter().for_each(|(grows, text)| reach.add(*grows, text).unwrap());
        reach
    }

    #[test]
    fn what_moves_up_grows_down() {
        let value = |name: &str| if name == "size" { 2.0 } else { 5.0 };
        let both = reach(&[(false, "+y 0.5 * size"), (false, "-y other"), (false, "size * other + 1")]);
        let moves = Sides { round: 11.0, low: [0.0, 5.0, 0.0], high: [0.0, 1.0, 0.0] };
        assert_eq!(both.moves(&value), moves);
        assert_eq!(both.grows(&value), Sides { low: moves.high, high: moves.low, ..moves });
        assert_eq!((moves.farthest(), moves.span()), (16.0, 28.0));
        assert_eq!(reach(&[(false, "size"), (true, "0")]).grows(&value), Sides::default());
    }

    #[test]
    fn a_length_that_cannot_be_read_is_refused() {
        for text in ["", "size *", "w size", "Size", "size - 1", "-1 * size", "+y"] {
            assert_eq!(Reach::default().add(false, text), None, "{text}");
        }
    }
}
