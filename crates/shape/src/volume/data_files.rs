//! Data files of a header, one after another along the slowest axes.
//!
//! Invariant: the files hold equal parts of the samples; numbered names are formatted one at a time.

use crate::error::{Location, ShapeError, quoted};
use crate::source::Source;

const EXPECTED: &str =
    "a file, `LIST` and then a file on each line, or `NAME%03d.raw FIRST LAST STEP`: one for each slice";

/// Data files in NRRD's or MetaImage's notation.
pub(super) enum DataFiles {
    Named(Vec<String>),
    Numbered {
        /// Text before and after the number.
        name: [String; 2],
        /// Minimal number of digits, and the character that pads them.
        digits: (usize, char),
        first: i64,
        step: i64,
        count: u64,
    },
}

impl DataFiles {
    /// Parses `value` at the current line of a header; the names of a `LIST` are on the following lines.
    pub fn read(value: &str, size: [u32; 3], source: &mut Source) -> Result<DataFiles, ShapeError> {
        let (at, words) = (source.line, value.split_whitespace().collect::<Vec<_>>());
        let (files, dimensions) = match words[..] {
            ["LIST", ref rest @ ..] if rest.len() < 2 => (DataFiles::list(source)?, rest.first().copied()),
            _ => match DataFiles::numbered(&words) {
                Some((files, dimensions)) => (files, dimensions),
                None => return Ok(DataFiles::Named(vec![value.to_owned()])),
            },
        };
        let [_, y, z] = size.map(u64::from);
        let fits = match dimensions.map_or("2", |dimensions| dimensions.trim_end_matches('D')) {
            "1" => files.count() == y * z,
            "2" => files.count() == z,
            "3" => files.count() > 0 && z % files.count() == 0,
            _ => false,
        };
        if !fits {
            let found = format!("{} with {} files for {z} slices", quoted(value.as_bytes()), files.count());
            return Err(source.malformed_at(Location::Line(at), EXPECTED, found));
        }
        Ok(files)
    }

    fn list(source: &mut Source) -> Result<DataFiles, ShapeError> {
        let (mut names, mut line) = (Vec::new(), Vec::new());
        while source.next_line(&mut line)? {
            let name = String::from_utf8_lossy(line.trim_ascii());
            if !name.is_empty() {
                names.push(name.into_owned());
            }
        }
        Ok(DataFiles::Named(names))
    }

    /// Parses `NAME%03d.raw FIRST LAST STEP`, optionally followed by the dimensions of a file.
    fn numbered<'a>(words: &[&'a str]) -> Option<(DataFiles, Option<&'a str>)> {
        let number = |word: &&str| word.parse::<i64>().is_ok();
        let numbers = words.iter().rev().take_while(|word| number(word)).count().min(4);
        let (name, numbers) = words.split_at_checked(words.len() - numbers)?;
        let name = name.join(" ");
        let (before, rest) = name.split_once('%')?;
        let (width, behind) = rest.split_once(['d', 'i', 'u'])?;
        let digits = match width {
            "" => 0,
            _ if width.bytes().all(|byte| byte.is_ascii_digit()) => {
                width.parse().ok().filter(|digits| *digits <= 32)?
            }
            _ => return None,
        };
        let &[first, last, step, ref dimensions @ ..] = numbers else { return None };
        let [first, last, step] = [first.parse::<i64>().ok()?, last.parse().ok()?, step.parse().ok()?];
        let steps = (i128::from(last) - i128::from(first)).checked_div(i128::from(step)).filter(|steps| *steps >= 0)?;
        let count = u64::try_from(steps + 1).ok()?;
        let fill = if width.starts_with('0') { '0' } else { ' ' };
        let name = [before.to_owned(), behind.to_owned()];
        Some((DataFiles::Numbered { name, digits: (digits, fill), first, step, count }, dimensions.first().copied()))
    }

    pub fn count(&self) -> u64 {
        match self {
            DataFiles::Named(names) => names.len() as u64,
            DataFiles::Numbered { count, .. } => *count,
        }
    }

    pub fn name(&self, index: u64) -> String {
        match self {
            DataFiles::Named(names) => names[index as usize].clone(),
            DataFiles::Numbered { name: [before, behind], digits: (digits, fill), first, step, .. } => {
                let number = (i128::from(*first) + i128::from(*step) * i128::from(index)).to_string();
                let more = digits.saturating_sub(number.len());
                format!("{before}{}{number}{behind}", fill.to_string().repeat(more))
            }
        }
    }
}
