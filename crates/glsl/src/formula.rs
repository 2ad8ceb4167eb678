//! Soft boolean formulas, which combine the objects of a scene.
//!
//! `a | b` union, `a & b` intersection, `a - b` difference, `!a` complement, parentheses. `!` binds closest, then `&`;
//! `|` and `-` are applied from left to right.
//! Source: PH 2.2.

use std::collections::BTreeMap;

/// A soft boolean formula.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Formula {
    /// An object by its name.
    Object(String),
    /// Complement, 1 - a.
    Not(Box<Formula>),
    /// Intersection, a b.
    And(Box<Formula>, Box<Formula>),
    /// Union, a + b - a b.
    Or(Box<Formula>, Box<Formula>),
}

/// A syntax error in a formula.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("`{text}`: {reason} at character {at}; write names with | & - ! and parentheses, such as `(a | b) - c`")]
pub struct FormulaError {
    /// The text.
    pub text: String,
    /// The reason.
    pub reason: String,
    /// Position in characters, from 1.
    pub at: usize,
}

/// Deepest nesting, since the parser and GLSL compilers recurse.
const MAX_DEPTH: usize = 64;
/// Most names, since chains nest too.
const MAX_NAMES: usize = 64;

impl Formula {
    /// Reads a formula.
    ///
    /// # Errors
    /// [`FormulaError`] with its position.
    pub fn parse(text: &str) -> Result<Formula, FormulaError> {
        let mut parser = Parser { text, at: 0, depth: 0, names: 0 };
        let formula = parser.sum()?;
        match parser.peek() {
            None => Ok(formula),
            Some(found) => Err(parser.fail(&format!("`{found}` is not expected"))),
        }
    }

    /// The objects by name, and whether any of their occurrences adds matter. Others only remove matter.
    pub fn objects(&self) -> BTreeMap<&str, bool> {
        let mut found = BTreeMap::new();
        self.visit(true, &mut |name, adds| *found.entry(name).or_insert(false) |= adds);
        found
    }

    fn visit<'a>(&'a self, adds: bool, on: &mut impl FnMut(&'a str, bool)) {
        match self {
            Formula::Object(name) => on(name, adds),
            Formula::Not(a) => a.visit(!adds, on),
            Formula::And(a, b) | Formula::Or(a, b) => {
                a.visit(adds, on);
                b.visit(adds, on);
            }
        }
    }

    /// The formula with the empty object in place of those that are `gone`; `Err` if it is full (`true`) or empty
    /// everywhere.
    ///
    /// # Errors
    /// No object is left; the value says whether there is matter everywhere.
    pub fn without(&self, gone: &impl Fn(&str) -> bool) -> Result<Formula, bool> {
        // A value that decides the operator, else the other operand.
        let both = |a: &Formula, b: &Formula, decides: bool, of: fn(Box<Formula>, Box<Formula>) -> Formula| match (
            a.without(gone),
            b.without(gone),
        ) {
            (Ok(a), Ok(b)) => Ok(of(a.into(), b.into())),
            (Err(full), _) | (_, Err(full)) if full == decides => Err(decides),
            (Err(_), other) | (other, Err(_)) => other,
        };
        match self {
            Formula::Object(name) if gone(name) => Err(false),
            Formula::Object(_) => Ok(self.clone()),
            Formula::Not(a) => a.without(gone).map(|a| Formula::Not(a.into())).map_err(|full| !full),
            Formula::And(a, b) => both(a, b, false, Formula::And),
            Formula::Or(a, b) => both(a, b, true, Formula::Or),
        }
    }

    /// How close its operator binds: 0 for `|` and `-`, 1 for `&`, 2 for `!` and names.
    fn rank(&self) -> u8 {
        match self {
            Formula::Object(_) | Formula::Not(_) => 2,
            Formula::And(_, b) if !matches!(**b, Formula::Not(_)) => 1,
            Formula::And(..) | Formula::Or(..) => 0,
        }
    }

    /// Bound of the formula, from bounds of objects (`of`), intersections (`and`) and unions (`or`). `None` is unbounded, as
    /// complements are.
    pub fn bound<T>(&self, of: &impl Fn(&str) -> T, and: &impl Fn(T, T) -> T, or: &impl Fn(T, T) -> T) -> Option<T> {
        match self {
            Formula::Object(name) => Some(of(name)),
            Formula::Not(_) => None,
            Formula::And(a, b) => match (a.bound(of, and, or), b.bound(of, and, or)) {
                (Some(a), Some(b)) => Some(and(a, b)),
                (a, b) => a.or(b),
            },
            Formula::Or(a, b) => Some(or(a.bound(of, and, or)?, b.bound(of, and, or)?)),
        }
    }

    /// The formula as a GLSL expression over variables `soft_NAME` of type `Soft`.
    pub fn glsl(&self) -> String {
        let mut out = String::new();
        self.write(&mut out);
        out
    }

    fn write(&self, out: &mut String) {
        let (name, operands): (&str, &[&Formula]) = match self {
            Formula::Object(name) => {
                *out += &format!("soft_{name}");
                return;
            }
            Formula::Not(a) => ("complement", &[a]),
            Formula::And(a, b) => ("intersect", &[a, b]),
            Formula::Or(a, b) => ("unite", &[a, b]),
        };
        out.push_str(name);
        for (index, operand) in operands.iter().enumerate() {
            out.push_str(if index == 0 { "(" } else { ", " });
            operand.write(out);
        }
        out.push(')');
    }
}

impl std::fmt::Display for Formula {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // Operands of an operator that binds closer than their own are in parentheses.
        let operand = |f: &mut std::fmt::Formatter<'_>, of: &Formula, rank: u8| {
            if of.rank() < rank { write!(f, "({of})") } else { write!(f, "{of}") }
        };
        let (a, sign, b, right) = match self {
            Formula::Object(name) => return f.write_str(name),
            Formula::Not(a) => {
                f.write_str("!")?;
                return operand(f, a, 2);
            }
            Formula::And(a, b) => match &**b {
                Formula::Not(b) => (a, "-", b, 1),
                _ => (a, "&", b, 2),
            },
            Formula::Or(a, b) => (a, "|", b, 1),
        };
        operand(f, a, self.rank())?;
        write!(f, " {sign} ")?;
        operand(f, b, right)
    }
}

struct Parser<'a> {
    text: &'a str,
    at: usize,
    depth: usize,
    names: usize,
}

impl Parser<'_> {
    fn fail(&self, reason: &str) -> FormulaError {
        FormulaError { text: self.text.into(), reason: reason.into(), at: self.text[..self.at].chars().count() + 1 }
    }

    /// The next character after white space.
    fn peek(&mut self) -> Option<char> {
        let rest = &self.text[self.at..];
        self.at += rest.len() - rest.trim_start().len();
        self.text[self.at..].chars().next()
    }

    fn take(&mut self, expected: char) -> bool {
        let found = self.peek() == Some(expected);
        self.at += if found { expected.len_utf8() } else { 0 };
        found
    }

    fn sum(&mut self) -> Result<Formula, FormulaError> {
        let mut left = self.product()?;
        loop {
            if self.take('|') {
                left = Formula::Or(left.into(), self.product()?.into());
            } else if self.take('-') {
                left = Formula::And(left.into(), Formula::Not(self.product()?.into()).into());
            } else {
                return Ok(left);
            }
        }
    }

    fn product(&mut self) -> Result<Formula, FormulaError> {
        let mut left = self.operand()?;
        while self.take('&') {
            left = Formula::And(left.into(), self.operand()?.into());
        }
        Ok(left)
    }

    fn operand(&mut self) -> Result<Formula, FormulaError> {
        self.depth += 1;
        if self.depth > MAX_DEPTH {
            return Err(self.fail(&format!("more than {MAX_DEPTH} levels")));
        }
        let operand = if self.take('!') {
            Formula::Not(self.operand()?.into())
        } else if self.take('(') {
            let inner = self.sum()?;
            if !self.take(')') {
                return Err(self.fail("`)` is missing"));
            }
            inner
        } else {
            self.peek();
            let rest = &self.text[self.at..];
            let length = rest.find(|c: char| !c.is_ascii_alphanumeric() && c != '_').unwrap_or(rest.len());
            if length == 0 {
                return Err(self.fail("a name is missing"));
            }
            self.names += 1;
            if self.names > MAX_NAMES {
                return Err(self.fail(&format!("more than {MAX_NAMES} names")));
            }
            self.at += length;
            Formula::Object(rest[..length].to_string())
        };
        self.depth -= 1;
        Ok(operand)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn glsl(text: &str) -> String {
        Formula::parse(text).unwrap().glsl()
    }

    #[test]
    fn p06_a_formula_of_any_depth_becomes_calls() {
        assert_eq!(glsl("main"), "soft_main");
        assert_eq!(glsl("a | b & !c"), "unite(soft_a, intersect(soft_b, complement(soft_c)))");
        assert_eq!(glsl("a-b-c"), "intersect(intersect(soft_a, complement(soft_b)), complement(soft_c))");
        assert_eq!(glsl(" ( a | b ) - c "), "intersect(unite(soft_a, soft_b), complement(soft_c))");
        assert!(Formula::parse(&format!("{}a{}", "(".repeat(63), ")".repeat(63))).is_ok());
    }

    #[test]
    fn errors_have_a_position() {
        for (text, expected) in [
            ("", "`` : a name is missing at character 1"),
            ("a |", "a name is missing at character 4"),
            ("(a | b", "`)` is missing at character 7"),
            ("a b", "`b` is not expected at character 3"),
            ("a + b", "`+` is not expected at character 3"),
            (&"!".repeat(100), "more than 64 levels at character 65"),
            (&["a"; 100].join("|"), "more than 64 names at character 129"),
        ] {
            let error = Formula::parse(text).unwrap_err().to_string();
            assert!(error.contains(expected.trim_start_matches("`` : ")), "{error}");
        }
    }

    #[test]
    fn an_object_that_is_gone_is_empty_and_a_text_reads_back() {
        fn holds(formula: &Formula, of: &dyn Fn(&str) -> bool) -> bool {
            match formula {
                Formula::Object(name) => of(name),
                Formula::Not(a) => !holds(a, of),
                Formula::And(a, b) => holds(a, of) && holds(b, of),
                Formula::Or(a, b) => holds(a, of) || holds(b, of),
            }
        }
        for text in
            ["a", "!a", "a|b|c", "a|(b|c)", "a-b-c", "a-(b-c)", "!(a&b)|c", "a&(b&c)", "(a|!b)&(c-a)", "!!(a|b)"]
        {
            let formula = Formula::parse(text).unwrap();
            assert_eq!(Formula::parse(&formula.to_string()).unwrap(), formula, "{text}: {formula}");
            for gone in 0..8 {
                let has = |set: u32, name: &str| set >> (name.as_bytes()[0] - b'a') & 1 == 1;
                let left = formula.without(&|name| has(gone, name));
                for full in 0..8 {
                    let own = left.as_ref().map_or_else(|full| *full, |left| holds(left, &|name| has(full, name)));
                    assert_eq!(
                        own,
                        holds(&formula, &|name| has(full & !gone, name)),
                        "{text} without {gone:b}: {left:?}"
                    );
                }
                assert!(left.is_err() || left.unwrap().objects().keys().all(|name| !has(gone, name)));
            }
        }
    }

    #[test]
    fn bounds_combine() {
        let bound = |text: &str| {
            let of = |name: &str| if name == "a" { 1 } else { 2 };
            Formula::parse(text).unwrap().bound(&of, &i32::min, &i32::max)
        };
        let cases = [("a & b", Some(1)), ("a | b", Some(2)), ("b - a", Some(2)), ("!a & !b", None), ("a | !b", None)];
        assert!(cases.into_iter().all(|(text, expected)| bound(text) == expected));
    }

    #[test]
    fn an_object_under_an_even_number_of_complements_adds_matter() {
        let formula = Formula::parse("a - (b - !c) | !d & !!e").unwrap();
        let adds: Vec<_> = formula.objects().into_iter().collect();
        assert_eq!(adds, [("a", true), ("b", false), ("c", false), ("d", false), ("e", true)]);
    }
}
