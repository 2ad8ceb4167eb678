//! Text in messages: escaping of untrusted text (file names, scene keys, comments, compiler output), spelling suggestions,
//! number formatting and shell quoting.
//!
//! Invariant: escaped text has no effect on a terminal. No escape sequence, direction mark or invisible character is left.

use std::borrow::Cow;

/// Letters per typo that [`nearest`] tolerates, and the shortest prefix that it completes.
const LETTERS: usize = 3;

/// Whether a character may deceive a terminal or a reader: control characters, direction marks, line separators, and
/// invisible characters except joiners.
fn is_hidden(c: char) -> bool {
    let is_format = matches!(c,
        '\u{ad}' | '\u{61c}' | '\u{180e}' | '\u{200b}' | '\u{200e}'..='\u{200f}' | '\u{2028}'..='\u{202e}'
        | '\u{2060}'..='\u{206f}' | '\u{feff}' | '\u{fff9}'..='\u{fffb}' | '\u{e0000}'..='\u{e0fff}');
    c.is_control() || is_format
}

/// Text with its hidden characters escaped, except those in `kept`.
fn escaped<'a>(text: &'a str, kept: &[char], escape: impl Fn(char, &mut String)) -> Cow<'a, str> {
    let is_escaped = |c: char| is_hidden(c) && !kept.contains(&c);
    if !text.contains(is_escaped) {
        return Cow::Borrowed(text);
    }
    let mut shown = String::with_capacity(text.len());
    text.chars().for_each(|c| if is_escaped(c) { escape(c, &mut shown) } else { shown.push(c) });
    Cow::Owned(shown)
}

/// Untrusted text escaped as one line.
pub fn line(text: &str) -> Cow<'_, str> {
    escaped(text, &[], |c, shown| shown.extend(c.escape_default()))
}

/// Untrusted text escaped, with its line breaks and tabs kept.
pub fn lines(text: &str) -> Cow<'_, str> {
    escaped(text, &['\n', '\t'], |c, shown| shown.extend(c.escape_default()))
}

/// Equivalent JSON with hidden characters escaped.
pub fn json(text: &str) -> Cow<'_, str> {
    escaped(text, &['\n', '\t'], |c, shown| {
        shown.extend(c.encode_utf16(&mut [0; 2]).iter().map(|unit| format!("\\u{unit:04x}")));
    })
}

/// The known name closest to a misspelt one by edit distance, or one that it is a prefix of.
pub fn nearest<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    let name: String = name.trim().to_lowercase().chars().take(64).collect();
    let length = name.chars().count();
    let rank = |candidate: &&'a str| {
        let begins = length >= LETTERS && candidate.starts_with(&name);
        let letters = strsim::osa_distance(candidate, &name);
        let is_near = LETTERS * letters <= length.max(candidate.chars().count());
        (begins || is_near).then(|| (!is_near, letters, -strsim::jaro_winkler(candidate, &name), *candidate))
    };
    let least = known.iter().filter_map(rank).min_by(|a, b| a.partial_cmp(b).unwrap_or(std::cmp::Ordering::Equal));
    least.map(|(.., candidate)| candidate)
}

/// A number with `digits` significant digits: 0.0123, or 1.23e-9 far from 1.
pub fn significant(number: f64, digits: usize) -> String {
    let rounded: f64 = format!("{number:.*e}", digits.saturating_sub(1)).parse().unwrap_or(number);
    let is_near = rounded == 0.0 || (1e-4..1e9).contains(&rounded.abs());
    if is_near { rounded.to_string() } else { format!("{rounded:e}") }
}

/// A word quoted for `sh`.
pub fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_ascii_alphanumeric() || "-_./,=+:@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) { word.into() } else { format!("'{}'", word.replace('\'', "'\\''")) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn escaped_text_has_no_effect_on_a_terminal() {
        let hostile = "a\u{1b}[2J\u{9b}31m\r\n\t\u{7}\u{202e}\u{2066}\u{200f}\u{feff}\u{e0041}b é 毛 🔥";
        assert_eq!(
            line(hostile),
            "a\\u{1b}[2J\\u{9b}31m\\r\\n\\t\\u{7}\\u{202e}\\u{2066}\\u{200f}\\u{feff}\\u{e0041}b é 毛 🔥"
        );
        assert_eq!(lines("one\n\ttwo\u{1b}"), "one\n\ttwo\\u{1b}");
        // Joiners of words and of pictures stay.
        assert!(matches!(line("क्\u{200d}ष e\u{301} 👩\u{200d}🔬"), Cow::Borrowed(_)));
        let value = serde_json::json!({ hostile: hostile });
        let text = serde_json::to_string_pretty(&value).unwrap();
        let shown = json(&text);
        assert!(!shown.contains(|c| is_hidden(c) && c != '\n') && shown != text, "{shown}");
        assert_eq!(serde_json::from_str::<serde_json::Value>(&shown).unwrap(), value);
    }

    #[test]
    fn a_name_is_suggested_where_it_is_near_and_nowhere_else() {
        let known = ["gun", "box", "fire", "fur", "furry_donut", "sphere", "samples", "sample_radius", "quality"];
        for (name, near) in [
            ("x", None),
            ("", None),
            ("zz", None),
            ("nothing", None),
            ("fir", Some("fire")),
            ("furr", Some("fur")),
            ("Shpere ", Some("sphere")),
            ("sampels", Some("samples")),
            ("qualities", Some("quality")),
            ("sph", Some("sphere")),
        ] {
            assert_eq!(nearest(name, &known), near, "{name}");
        }
    }
}
