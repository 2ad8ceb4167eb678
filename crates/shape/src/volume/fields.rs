//! Named values of a text header, as NRRD and MetaImage have them.

use crate::error::{Location, ShapeError, quoted};
use crate::source::Source;
use std::collections::HashMap;

/// Values by name, each with its line.
pub(super) struct Fields {
    file: String,
    values: HashMap<String, (u64, String)>,
}

impl Fields {
    pub fn new(source: &Source) -> Fields {
        Fields { file: source.file.clone(), values: HashMap::new() }
    }

    /// Adds a value from the current line; `false` if the name is repeated.
    pub fn insert(&mut self, source: &Source, name: String, value: &str) -> bool {
        self.values.insert(name, (source.line, value.trim().to_owned())).is_none()
    }

    pub fn get(&self, name: &str) -> Option<&str> {
        self.values.get(name).map(|(_, value)| value.as_str())
    }

    /// Whitespace-separated words of a value; none where it is missing.
    pub fn words(&self, name: &str) -> Vec<&str> {
        self.get(name).unwrap_or_default().split_whitespace().collect()
    }

    /// Whole numbers of a value.
    pub fn integers(&self, name: &str) -> Option<Vec<u64>> {
        self.words(name).into_iter().map(|word| word.parse().ok()).collect()
    }

    pub fn place(&self, name: &str) -> Location {
        self.values.get(name).map_or(Location::Header, |(line, _)| Location::Line(*line))
    }

    /// Wrong or missing value of `name`.
    pub fn malformed(&self, name: &str, expected: &'static str) -> ShapeError {
        let found = self.get(name).map_or("nothing".into(), |value| quoted(value.as_bytes()));
        ShapeError::Malformed { file: self.file.clone(), place: self.place(name), expected, found }
    }

    /// Unsupported value of `name`.
    pub fn unsupported(&self, name: &'static str, remedy: &'static str) -> ShapeError {
        let found = quoted(self.get(name).unwrap_or_default().as_bytes());
        ShapeError::unsupported(&self.file, self.place(name), name, found, remedy)
    }
}

/// A number that is finite or NaN.
pub(super) fn finite_or_nan(word: &str) -> Option<f64> {
    word.parse().ok().filter(|number: &f64| !number.is_infinite())
}
