//! Completion of identifiers: parameters, functions and words of GLSL.

use super::field::{FONT, field};
use egui::text::{CCursor, CCursorRange};
use egui::{Area, Color32, Frame, Id, Key, Modifiers, Order, Pos2, RichText, TextEdit, Ui};
use hypertexture::shader::declare::declaration;
use hypertexture::shader::{Library, reserved};
use std::collections::BTreeSet;
use std::ops::Range;

/// Number of letters after which the list opens. Lower: it opens at every letter.
const LETTERS: usize = 2;
/// Length of the list.
const MAX_OFFERS: usize = 8;

/// GLSL functions with their arguments.
pub(super) const BUILTINS: [(&str, &str); 44] = [
    ("abs", "(x)"),
    ("acos", "(x)"),
    ("all", "(bvec)"),
    ("any", "(bvec)"),
    ("asin", "(x)"),
    ("atan", "(y, x)"),
    ("ceil", "(x)"),
    ("clamp", "(x, low, high)"),
    ("cos", "(x)"),
    ("cross", "(a, b)"),
    ("degrees", "(radians)"),
    ("distance", "(a, b)"),
    ("dot", "(a, b)"),
    ("equal", "(a, b)"),
    ("exp", "(x)"),
    ("exp2", "(x)"),
    ("floor", "(x)"),
    ("fract", "(x)"),
    ("greaterThan", "(a, b)"),
    ("inversesqrt", "(x)"),
    ("isnan", "(x)"),
    ("length", "(x)"),
    ("lessThan", "(a, b)"),
    ("log", "(x)"),
    ("log2", "(x)"),
    ("max", "(a, b)"),
    ("min", "(a, b)"),
    ("mix", "(a, b, part)"),
    ("mod", "(x, y)"),
    ("normalize", "(x)"),
    ("not", "(bvec)"),
    ("pow", "(x, y)"),
    ("radians", "(degrees)"),
    ("reflect", "(incident, normal)"),
    ("refract", "(incident, normal, eta)"),
    ("round", "(x)"),
    ("sign", "(x)"),
    ("sin", "(x)"),
    ("smoothstep", "(low, high, x)"),
    ("sqrt", "(x)"),
    ("step", "(edge, x)"),
    ("tan", "(x)"),
    ("transpose", "(matrix)"),
    ("trunc", "(x)"),
];

/// An identifier and its description.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Word {
    pub(super) text: String,
    pub(super) about: String,
}

/// The completion list.
#[derive(Default)]
pub(super) struct Completion {
    words: Vec<Word>,
    /// Bytes of the prefix.
    range: Range<usize>,
    /// Index of the selected word.
    at: usize,
    /// Whether the list was opened by its key, and so owns the arrow keys and Enter.
    asked: bool,
}

/// Key of the completion list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum CompletionKey {
    Nothing,
    List,
    Take,
}

impl Completion {
    /// Whether the list is open.
    pub(super) fn is_open(&self) -> bool {
        !self.words.is_empty()
    }

    pub(super) fn close(&mut self) {
        *self = Completion::default();
    }

    /// Handles keys of the list before the text field does.
    pub(super) fn keys(&mut self, ui: &Ui) -> CompletionKey {
        if !ui.memory(|memory| memory.has_focus(field())) {
            self.close();
            return CompletionKey::Nothing;
        }
        let (open, asked, count) = (self.is_open(), self.asked, self.words.len());
        let pressed = |modifiers, key| ui.input_mut(|input| input.consume_key(modifiers, key));
        if pressed(Modifiers::COMMAND, Key::Space) {
            return CompletionKey::List;
        }
        if open && pressed(Modifiers::NONE, Key::Tab) || open && asked && pressed(Modifiers::NONE, Key::Enter) {
            return CompletionKey::Take;
        }
        if open && pressed(Modifiers::NONE, Key::Escape) {
            self.close();
        } else if open && asked && pressed(Modifiers::NONE, Key::ArrowDown) {
            self.at = (self.at + 1) % count;
        } else if open && asked && pressed(Modifiers::NONE, Key::ArrowUp) {
            self.at = (self.at + count - 1) % count;
        }
        CompletionKey::Nothing
    }

    /// Opens the list for the prefix that ends at a byte of the text; `asked` also for one letter.
    pub(super) fn offer(&mut self, text: &str, end: usize, library: &Library, asked: bool) {
        let begins =
            text[..end].rfind(|c| !is_word(c)).map_or(0, |at| at + text[at..].chars().next().map_or(1, char::len_utf8));
        let start = &text[begins..end];
        let line = text[..end].rsplit('\n').next().unwrap_or_default();
        let is_prose = line.contains("//");
        let is_whole = text[end..].starts_with(is_word);
        let least = if asked { 1 } else { LETTERS };
        if start.len() < least || !start.starts_with(|c: char| c.is_ascii_alphabetic()) || is_prose || is_whole {
            return self.close();
        }
        let words = words(text, library);
        let fits = |word: &Word| word.text.starts_with(start) && word.text != start;
        let words = words.into_iter().filter(fits).take(MAX_OFFERS).collect();
        *self = Completion { words, range: begins..end, at: 0, asked };
    }

    /// Replaces the prefix by the selected word, or by the clicked one; returns the byte after it.
    pub(super) fn take(&mut self, text: &mut String, word: Option<usize>) -> Option<usize> {
        let chosen = self.words.get(word.unwrap_or(self.at))?.text.clone();
        let range = self.range.clone();
        self.close();
        text.get(range.clone())?;
        text.replace_range(range.clone(), &chosen);
        Some(range.start + chosen.len())
    }

    /// Shows the list below a position; returns the index of a clicked word.
    pub(super) fn show(&self, ui: &Ui, below: Pos2) -> Option<usize> {
        if !self.is_open() {
            return None;
        }
        let mut clicked = None;
        let area = Area::new(Id::new("author.completion")).order(Order::Foreground).fixed_pos(below);
        area.show(ui.ctx(), |ui| {
            Frame::popup(ui.style()).show(ui, |ui| {
                for (index, Word { text, about }) in self.words.iter().enumerate() {
                    ui.horizontal(|ui| {
                        let name = RichText::new(text).font(FONT);
                        if ui.selectable_label(index == self.at, name).clicked() {
                            clicked = Some(index);
                        }
                        ui.label(RichText::new(about).font(FONT).color(Color32::from_gray(150)));
                    });
                }
                let keys = if self.asked { "Enter or Tab" } else { "Tab" };
                ui.label(RichText::new(format!("{keys} takes it")).small().weak());
            });
        });
        clicked
    }
}

/// Moves the cursor of the text field, or selects characters.
pub(super) fn select(ui: &Ui, range: Range<usize>) {
    let mut state = TextEdit::load_state(ui.ctx(), field()).unwrap_or_default();
    state.cursor.set_char_range(Some(CCursorRange::two(CCursor::new(range.start), CCursor::new(range.end))));
    TextEdit::store_state(ui.ctx(), field(), state);
}

fn is_word(c: char) -> bool {
    c.is_ascii_alphanumeric() || c == '_'
}

/// Declared parameters with their descriptions.
pub(super) fn parameters(text: &str) -> Vec<Word> {
    let declared = |line: &str| {
        let (_, rest) = declaration(line).filter(|(kind, _)| ["param", "color"].contains(kind))?;
        let (name, about) = rest.split_once('=')?;
        Some(Word { text: name.trim().into(), about: format!("= {}", about.trim()) })
    };
    text.lines().filter_map(declared).collect()
}

/// Defined functions with their arguments.
fn functions(text: &str) -> Vec<Word> {
    let defined = |line: &str| {
        let (start, arguments) = line.split_once('(')?;
        let (kind, name) = start.split_once(' ')?;
        let is_name = |name: &str| !name.is_empty() && name.chars().all(is_word);
        let whole = arguments.split_once(')').map_or(arguments, |(arguments, _)| arguments);
        (is_name(kind) && is_name(name)).then(|| Word { text: name.into(), about: format!("({whole})") })
    };
    text.lines().filter_map(defined).collect()
}

/// Functions of included files, recursively. All modules of a slot have the same functions.
fn included(text: &str, library: &Library, seen: &mut BTreeSet<String>) -> Vec<Word> {
    let mut found = functions(text);
    for name in text.lines().filter_map(|line| line.trim().strip_prefix("#include ")) {
        let path = match name.trim().strip_prefix('<').and_then(|name| name.strip_suffix('>')) {
            Some(slot) => library.modules(slot).first().map(|module| format!("{slot}/{module}.glsl")),
            None => Some(name.trim_matches('"').to_string()),
        };
        if let Some(path) = path.filter(|path| seen.insert(path.clone()))
            && let Some(text) = library.source(&path)
        {
            found.extend(included(text, library, seen));
        }
    }
    found
}

/// All words for a text: its parameters, the functions that it reaches, built-in functions and reserved words.
fn words(text: &str, library: &Library) -> Vec<Word> {
    let mut words = parameters(text);
    words.extend(included(text, library, &mut BTreeSet::new()));
    let builtin = BUILTINS.iter().map(|(name, about)| Word { text: name.to_string(), about: about.to_string() });
    words.extend(builtin);
    words.extend(reserved().map(|word| Word { text: word.into(), about: String::new() }));
    let mut seen = BTreeSet::new();
    words.retain(|word| seen.insert(word.text.clone()));
    words
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture::shader;

    fn offered(text: &str, asked: bool) -> Vec<String> {
        let end = text.find('|').unwrap();
        let mut completion = Completion::default();
        completion.offer(&text.replace('|', ""), end, &shader::shipped(), asked);
        completion.words.iter().map(|word| word.text.clone()).collect()
    }

    #[test]
    fn completion_offers_parameters_included_and_glsl_functions() {
        let fur = shader::shipped().source("dmf/fur.glsl").unwrap().to_string();
        assert_eq!(offered(&format!("{fur}float x = finen|"), false), ["fineness"]);
        assert_eq!(offered(&format!("{fur}float x = noise_gr|"), false), ["noise_gradient"]);
        assert_eq!(offered(&format!("{fur}float x = unbe|"), false), ["unbent"]);
        assert_eq!(offered("float x = smooths|", false), ["smoothstep"]);
        assert!(offered("float x = s|", false).is_empty(), "one letter asks for nothing");
        assert!(offered("float x = s|", true).contains(&"sin".to_string()));
        for none in ["// the smooths|", "float x = 1.0smooths|", "smooths|tep", "|", "é|"] {
            assert!(offered(none, true).is_empty(), "{none}");
        }
    }

    #[test]
    fn a_word_takes_the_place_of_its_beginning_and_of_nothing_else() {
        let mut text = "é = smooths + 1;".to_string();
        let mut completion = Completion::default();
        completion.offer(&text, text.find(" +").unwrap(), &shader::shipped(), false);
        let end = completion.take(&mut text, None).unwrap();
        assert_eq!((text.as_str(), &text[end..]), ("é = smoothstep + 1;", " + 1;"));
        assert!(!completion.is_open() && completion.take(&mut text, None).is_none());
    }
}
