//! Syntax highlighting of GLSL.

use super::complete::BUILTINS;
use super::field::FONT;
use egui::text::{LayoutJob, TextFormat};
use egui::{Align, Color32};
use hypertexture::shader::declare::declaration;
use hypertexture::shader::{is_reserved, tokens};
use std::ops::Range;

/// Text colors, with a contrast of at least 4.5 to 1 on their backgrounds.
pub(super) struct Colors {
    plain: Color32,
    comment: Color32,
    declaration: Color32,
    directive: Color32,
    number: Color32,
    reserved: Color32,
    function: Color32,
    /// Background of a line with an error.
    wrong_line: Color32,
    /// Text and background of a match.
    found: [Color32; 2],
    /// Text and background of the current match.
    current: [Color32; 2],
}

/// Height of a line with room for its error below, in sizes of the font.
const TALL: f32 = 2.6;

const DARK: Colors = Colors {
    plain: Color32::from_gray(214),
    comment: Color32::from_rgb(138, 160, 138),
    declaration: Color32::from_rgb(226, 178, 96),
    directive: Color32::from_rgb(206, 148, 206),
    number: Color32::from_rgb(180, 210, 150),
    reserved: Color32::from_rgb(120, 178, 238),
    function: Color32::from_rgb(220, 214, 160),
    wrong_line: Color32::from_rgb(72, 24, 28),
    found: [Color32::WHITE, Color32::from_rgb(90, 80, 20)],
    current: [Color32::BLACK, Color32::from_rgb(255, 186, 60)],
};

const LIGHT: Colors = Colors {
    plain: Color32::from_gray(30),
    comment: Color32::from_rgb(64, 98, 64),
    declaration: Color32::from_rgb(126, 70, 0),
    directive: Color32::from_rgb(124, 40, 124),
    number: Color32::from_rgb(50, 94, 16),
    reserved: Color32::from_rgb(0, 74, 156),
    function: Color32::from_rgb(98, 80, 0),
    wrong_line: Color32::from_rgb(255, 224, 222),
    found: [Color32::BLACK, Color32::from_rgb(255, 236, 130)],
    current: [Color32::WHITE, Color32::from_rgb(150, 72, 0)],
};

/// The colors of a theme.
pub(super) fn colors(is_dark: bool) -> &'static Colors {
    if is_dark { &DARK } else { &LIGHT }
}

/// Highlights a text. `parameters` have the color of declarations; lines that are `wrong`, counted from 1, and the byte
/// ranges `found` have backgrounds, and the match `current` has its own. Lines that are `tall` have room for an error below.
pub(super) fn job(
    text: &str,
    colors: &Colors,
    parameters: &[String],
    wrong: &dyn Fn(usize) -> bool,
    tall: &[usize],
    found: &[Range<usize>],
    current: usize,
) -> LayoutJob {
    let mut job = LayoutJob { break_on_newline: true, ..LayoutJob::default() };
    job.wrap.max_width = f32::INFINITY;
    let all: Vec<&str> = tokens(text).collect();
    let mark = |(index, range): (usize, &Range<usize>)| {
        (range.clone(), if index == current { colors.current } else { colors.found })
    };
    let marks: Vec<_> = found.iter().enumerate().map(mark).collect();
    let (mut at, mut line) = (0, 1);
    for (index, token) in all.iter().enumerate() {
        let before = |steps: usize| index.checked_sub(steps).map_or("", |index| all[index]);
        let opens = all[index + 1..].iter().find(|next| !next.trim().is_empty()) == Some(&"(");
        let color = match *token {
            comment if declaration(comment).is_some() => colors.declaration,
            comment if comment.starts_with("//") || comment.starts_with("/*") => colors.comment,
            directive if directive.starts_with('#') || before(1) == "#" => colors.directive,
            number if number.starts_with(|c: char| c.is_ascii_digit()) => colors.number,
            "." if before(1).starts_with(|c: char| c.is_ascii_digit()) => colors.number,
            word if is_reserved(word) => colors.reserved,
            word if parameters.iter().any(|parameter| parameter == word) => colors.declaration,
            word if opens && word.starts_with(|c: char| c.is_ascii_alphabetic()) => colors.function,
            word if BUILTINS.iter().any(|(name, _)| *name == word) => colors.function,
            _ => colors.plain,
        };
        for piece in token.split_inclusive('\n') {
            let behind = if wrong(line) { colors.wrong_line } else { Color32::TRANSPARENT };
            let mut format = TextFormat { background: behind, ..TextFormat::simple(FONT, color) };
            if tall.contains(&line) {
                (format.line_height, format.valign) = (Some(TALL * FONT.size), Align::TOP);
            }
            append(&mut job, piece, at, format, &marks);
            at += piece.len();
            line += usize::from(piece.ends_with('\n'));
        }
    }
    job
}

/// Appends a piece of the text that starts at byte `at`, split at the edges of matches.
fn append(job: &mut LayoutJob, piece: &str, at: usize, format: TextFormat, marks: &[(Range<usize>, [Color32; 2])]) {
    let mut start = 0;
    for (range, [color, background]) in
        marks.iter().filter(|(range, _)| range.start < at + piece.len() && range.end > at)
    {
        let [from, to] = [range.start.max(at) - at, (range.end - at).min(piece.len())];
        job.append(&piece[start..from], 0.0, format.clone());
        job.append(&piece[from..to], 0.0, TextFormat { color: *color, background: *background, ..format.clone() });
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
        let job = job(text, &DARK, &["zest".into()], &|line| line == 6, &[], &found, 1);
        assert_eq!(job.text, text);
        let format = |word: &str| {
            let at = text.rfind(word).unwrap();
            let section = job.sections.iter().find(|section| section.byte_range.contains(&at.into())).unwrap();
            section.format.clone()
        };
        let expected = [
            ("A part", DARK.comment),
            ("// @param", DARK.declaration),
            ("#include", DARK.directive),
            ("define", DARK.directive),
            ("return", DARK.reserved),
            ("float", DARK.reserved),
            ("zest", DARK.declaration),
            ("clamp", DARK.function),
            ("_of", DARK.function),
            ("1.5", DARK.number),
            ("a\n b", DARK.comment),
        ];
        for (word, color) in expected {
            assert_eq!(format(word).color, color, "{word}");
        }
        assert_eq!(format("return").background, Color32::TRANSPARENT, "line 7");
        assert_eq!(format("/* a").background, DARK.wrong_line);
        let looks = |word: &str| [format(word).color, format(word).background];
        assert_eq!(found.len(), 3);
        assert_eq!([looks("part.\n"), looks("part(float"), looks("part_of")], [DARK.found, DARK.current, DARK.found]);
        assert_eq!(format("_of").background, Color32::TRANSPARENT);
    }

    #[test]
    fn every_color_stands_out_in_both_themes() {
        use crate::panels::theme::{contrast, dark, light};
        for visuals in [dark(), light()] {
            let own = colors(visuals.dark_mode);
            let Colors { plain, comment, declaration, directive, number, reserved, function, .. } = *own;
            let texts = [plain, comment, declaration, directive, number, reserved, function];
            let grounds = [visuals.text_edit_bg_color(), visuals.extreme_bg_color, own.wrong_line];
            let all = texts.iter().flat_map(|text| grounds.iter().map(move |ground| [*text, *ground]));
            let errors = grounds.iter().map(|ground| [visuals.error_fg_color, *ground]);
            for [text, ground] in all.chain(errors).chain([own.found, own.current]) {
                let found = contrast(text, ground);
                assert!(found >= 4.5, "dark: {}, {text:?} on {ground:?}: {found:.2}", visuals.dark_mode);
            }
            // The current match differs from the others.
            assert!(contrast(own.found[1], own.current[1]) >= 3.0, "dark: {}", visuals.dark_mode);
        }
    }
}
