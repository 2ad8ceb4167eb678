//! The colors of GLSL.

use super::FONT;
use super::complete::BUILTINS;
use crate::shader::{is_reserved, tokens};
use egui::Color32;
use egui::text::{LayoutJob, TextFormat};
use std::ops::Range;

const PLAIN: Color32 = Color32::from_gray(214);
const COMMENT: Color32 = Color32::from_rgb(128, 150, 128);
const DECLARATION: Color32 = Color32::from_rgb(226, 178, 96);
const DIRECTIVE: Color32 = Color32::from_rgb(200, 140, 200);
const NUMBER: Color32 = Color32::from_rgb(180, 210, 150);
const RESERVED: Color32 = Color32::from_rgb(110, 170, 235);
const FUNCTION: Color32 = Color32::from_rgb(220, 214, 160);
/// Backgrounds of a line that is wrong, and of what is looked for.
const WRONG_LINE: Color32 = Color32::from_rgb(72, 24, 28);
const FOUND: Color32 = Color32::from_rgb(90, 80, 20);

/// The text in its colors: declared names, given by `parameters`, as their declarations; lines that are `wrong`, counted from
/// 1, and the bytes that are `found` have backgrounds.
pub(super) fn job(
    text: &str,
    parameters: &[String],
    wrong: &dyn Fn(usize) -> bool,
    found: &[Range<usize>],
) -> LayoutJob {
    let mut job = LayoutJob { break_on_newline: true, ..LayoutJob::default() };
    job.wrap.max_width = f32::INFINITY;
    let all: Vec<&str> = tokens(text).collect();
    let (mut at, mut line) = (0, 1);
    for (index, token) in all.iter().enumerate() {
        let before = |steps: usize| index.checked_sub(steps).map_or("", |index| all[index]);
        let opens = all[index + 1..].iter().find(|next| !next.trim().is_empty()) == Some(&"(");
        let color = match *token {
            comment if comment.starts_with("// @") => DECLARATION,
            comment if comment.starts_with("//") || comment.starts_with("/*") => COMMENT,
            directive if directive.starts_with('#') || before(1) == "#" => DIRECTIVE,
            number if number.starts_with(|c: char| c.is_ascii_digit()) => NUMBER,
            "." if before(1).starts_with(|c: char| c.is_ascii_digit()) => NUMBER,
            word if is_reserved(word) => RESERVED,
            word if parameters.iter().any(|parameter| parameter == word) => DECLARATION,
            word if opens && word.starts_with(|c: char| c.is_ascii_alphabetic()) => FUNCTION,
            word if BUILTINS.iter().any(|(name, _)| *name == word) => FUNCTION,
            _ => PLAIN,
        };
        for piece in token.split_inclusive('\n') {
            let behind = if wrong(line) { WRONG_LINE } else { Color32::TRANSPARENT };
            append(&mut job, piece, at, found, TextFormat { background: behind, ..TextFormat::simple(FONT, color) });
            at += piece.len();
            line += usize::from(piece.ends_with('\n'));
        }
    }
    job
}

/// Appends a piece of the text that begins at a byte, in parts where some of it is found.
fn append(job: &mut LayoutJob, piece: &str, at: usize, found: &[Range<usize>], format: TextFormat) {
    let mut start = 0;
    for range in found.iter().filter(|range| range.start < at + piece.len() && range.end > at) {
        let [from, to] = [range.start.max(at) - at, (range.end - at).min(piece.len())];
        job.append(&piece[start..from], 0.0, format.clone());
        job.append(&piece[from..to], 0.0, TextFormat { background: FOUND, ..format.clone() });
        start = to;
    }
    job.append(&piece[start..], 0.0, format);
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_letter_is_kept_and_words_have_their_colors() {
        let text = "// A part.\n// @param zest = 0.5 in [0, 2]: New.\n#include <noise>\n#define TWO 2\nfloat part(float d) {\n    \
                    /* a\n b */ return zest * clamp(d, 0.0, 1.5) + part_of(d);\n}\n";
        let found = super::super::find::matches(text, "part");
        let job = job(text, &["zest".into()], &|line| line == 6, &found);
        assert_eq!(job.text, text);
        let format = |word: &str| {
            let at = text.rfind(word).unwrap();
            let section = job.sections.iter().find(|section| section.byte_range.contains(&at.into())).unwrap();
            section.format.clone()
        };
        let expected = [
            ("A part", COMMENT),
            ("// @param", DECLARATION),
            ("#include", DIRECTIVE),
            ("define", DIRECTIVE),
            ("return", RESERVED),
            ("float", RESERVED),
            ("zest", DECLARATION),
            ("clamp", FUNCTION),
            ("part_of", FUNCTION),
            ("1.5", NUMBER),
            ("a\n b", COMMENT),
        ];
        for (word, color) in expected {
            assert_eq!(format(word).color, color, "{word}");
        }
        assert_eq!(format("return").background, Color32::TRANSPARENT, "line 7");
        assert_eq!(format("/* a").background, WRONG_LINE);
        assert_eq!(format("part_of").background, FOUND);
        assert_eq!(format("_of").background, Color32::TRANSPARENT);
    }
}
