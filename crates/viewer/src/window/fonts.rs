//! Fallback fonts of the system for glyphs that the fonts of egui lack.

use crate::background::{Background, Notify};
use egui::epaint::ClippedShape;
use egui::epaint::text::{FontInsert, FontPriority, FontTweak, InsertFontFamily};
use egui::{Context, FontData, FontFamily, FontId, Shape};
use skrifa::{FontRef, MetadataProvider};
use std::collections::HashSet;
use std::fs;
use std::process::{Command, Stdio};
use std::task::Poll;

/// Limit for searched fonts: each takes a process, and texts in more scripts are rare.
const MAX_SEARCHES: usize = 16;

/// Search for fallback fonts.
pub(crate) struct Fallback {
    notify: Notify,
    /// Characters that were checked.
    known: HashSet<char>,
    asked: usize,
    search: Option<(char, Background<Option<FontData>>)>,
    complained: bool,
}

impl Fallback {
    /// A search that has not started; `notify` requests a frame when a font is found.
    pub(crate) fn new(notify: Notify) -> Fallback {
        Fallback { notify, known: HashSet::new(), asked: 0, search: None, complained: false }
    }

    /// Starts a search for the first character of a frame that has no glyph.
    pub(crate) fn look(&mut self, context: &Context, shapes: &[ClippedShape]) {
        if let Some((letter, search)) = &self.search {
            let Poll::Ready(found) = search.poll() else { return };
            match found.flatten() {
                Some(data) => context.add_font(insert(*letter, data)),
                None if self.complained => {}
                None => {
                    self.complained = true;
                    log::warn!(
                        "no font of this system has `{letter}`, so that such text is boxes; on Debian or Ubuntu, for \
                         Chinese, Japanese and Korean: sudo apt install fonts-noto-cjk"
                    );
                }
            }
            // The glyphs of a new font are available in the next frame.
            self.search = None;
            context.request_repaint();
            return;
        }
        let mut letters = Vec::new();
        shapes.iter().for_each(|clipped| self.unknown(&clipped.shape, &mut letters));
        let has_glyph = |letter: char| context.fonts_mut(|fonts| fonts.has_glyph(&FontId::default(), letter));
        for letter in letters {
            self.known.insert(letter);
            if self.asked < MAX_SEARCHES && !has_glyph(letter) {
                self.asked += 1;
                self.search =
                    Some((letter, Background::start(&self.notify, move |task| task.send(system_font(letter)))));
                return;
            }
        }
    }

    /// Collects characters that were not checked.
    fn unknown(&self, shape: &Shape, letters: &mut Vec<char>) {
        match shape {
            Shape::Vec(shapes) => shapes.iter().for_each(|shape| self.unknown(shape, letters)),
            Shape::Text(text) => {
                let unknown = |c: &char| !c.is_ascii() && c.is_alphanumeric() && !self.known.contains(c);
                letters.extend(text.galley.text().chars().filter(unknown));
            }
            _ => {}
        }
    }
}

/// A font with the lowest priority.
fn insert(letter: char, data: FontData) -> FontInsert {
    let families = [FontFamily::Proportional, FontFamily::Monospace];
    let families = families.map(|family| InsertFontFamily { family, priority: FontPriority::Lowest });
    FontInsert::new(&format!("for {letter}"), data, families.into())
}

/// The font of fontconfig for a character.
fn system_font(letter: char) -> Option<FontData> {
    let pattern = format!("sans:charset={:x}", u32::from(letter));
    let mut command = Command::new("fc-match");
    let output = command.args(["-f", "%{index}\t%{file}", &pattern]).stderr(Stdio::null()).output().ok()?;
    let said = String::from_utf8(output.stdout).ok()?;
    let (index, file) = said.split_once('\t')?;
    // The upper 16 bits are the named instance of a variable font.
    let index = index.parse::<u32>().ok()? & 0xffff;
    let font = fs::read(file).ok()?;
    // fontconfig returns another font if none has the character, and egui panics on invalid font files.
    FontRef::from_index(&font, index).ok()?.charmap().map(letter)?;
    let tweak = FontTweak { hinting: Some(false), ..FontTweak::default() };
    Some(FontData { index, tweak, ..FontData::from_owned(font) })
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::RawInput;
    use std::sync::Arc;
    use std::thread;
    use std::time::{Duration, Instant};

    /// Shows a text until its letter has been looked for; whether it has a glyph.
    fn is_shown(letter: char) -> (bool, Fallback) {
        let (context, mut fallback) = (Context::default(), Fallback::new(Arc::new(|| ())));
        let start = Instant::now();
        loop {
            let output = context.run_ui(RawInput::default(), |ui| drop(ui.label(format!("an {letter}"))));
            fallback.look(&context, &output.shapes);
            if fallback.known.contains(&letter) && fallback.search.is_none() {
                let _ = context.run_ui(RawInput::default(), |_| ());
                return (context.fonts_mut(|fonts| fonts.has_glyph(&FontId::default(), letter)), fallback);
            }
            assert!(start.elapsed().as_secs() < 300); // a test that fails ends
            thread::sleep(Duration::from_millis(5));
        }
    }

    #[test]
    fn a_letter_that_egui_lacks_is_shown_by_a_font_of_the_system() {
        for letter in ['漢', 'あ'] {
            if system_font(letter).is_none() {
                println!("SKIPPED: no font here has {letter}");
                continue;
            }
            let (shown, fallback) = is_shown(letter);
            assert!(shown && !fallback.complained, "{letter}");
        }
    }

    #[test]
    fn missing_letters_are_reported_once() {
        // Linear A: no font that is usual has it.
        let (shown, fallback) = is_shown('\u{10600}');
        assert!(shown != fallback.complained);
        let (shown, fallback) = is_shown('ä');
        assert!(shown && fallback.asked == 0);
    }
}
