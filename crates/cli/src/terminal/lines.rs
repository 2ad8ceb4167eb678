//! Lines to standard output and standard error, as a terminal may see them.

use hypertexture_support::words;
use serde::Serialize;
use std::io::Write;
use std::path::Path;
use std::sync::OnceLock;

/// Most characters of an error line; characters kept at both ends of a longer line, and of a long word in it.
const LONGEST_LINE: usize = 599;
const KEPT_OF_LINE: [usize; 2] = [400, 195];
const KEPT_OF_WORD: [usize; 2] = [50, 30];
/// Prefix of an error number of the operating system.
const NUMBER_OF_ERROR: &str = " (os error ";
/// First error of standard output.
pub(crate) static UNSAID: OnceLock<std::io::Error> = OnceLock::new();

/// Writes lines to standard output without control characters. A closed pipe is ignored; other errors are reported at the end of
/// the program.
pub fn say(text: &str) {
    let mut out = std::io::stdout().lock();
    if let Err(error) = out.write_all(words::lines(text).as_bytes()).and_then(|()| out.flush())
        && error.kind() != std::io::ErrorKind::BrokenPipe
    {
        let _ = UNSAID.set(error); // the first one tells the cause
    }
}

/// Writes an object as JSON to standard output.
pub(crate) fn say_json(value: &impl Serialize) -> Result<(), serde_json::Error> {
    say(&words::json(&format!("{}\n", serde_json::to_string_pretty(value)?)));
    Ok(())
}

/// Absolute path, printable on one line.
pub(crate) fn absolute(path: &Path) -> String {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    words::line(&path.to_string_lossy()).into_owned()
}

/// Discards lines, in place of [`say`].
pub(crate) fn silent(_: &str) {}

/// Writes lines to standard error, in place of [`say`] where standard output carries a file.
pub(crate) fn aside(text: &str) {
    let _ = write!(std::io::stderr().lock(), "{}", words::lines(text));
}

/// Writes one line to standard error, shortened, without control characters and error numbers of the operating system.
pub(crate) fn complain(line: &str) {
    let mut line = line.replace('\n', " ");
    while let Some(start) = line.find(NUMBER_OF_ERROR)
        && let Some(length) = line[start..].find(')')
    {
        line.replace_range(start..=start + length, "");
    }
    let _ = writeln!(std::io::stderr().lock(), "{}", fitted(&words::line(&line)));
}

/// Shortens a line: first the middle of long words, then its own. The start names the fault, the end the reason.
fn fitted(line: &str) -> String {
    let length = |text: &str| text.chars().count();
    let without_middle = |text: &str, [first, last]: [usize; 2]| -> String {
        let all = length(text);
        if all > first + last {
            text.chars().take(first).chain("...".chars()).chain(text.chars().skip(all - last)).collect()
        } else {
            text.into()
        }
    };
    if length(line) <= LONGEST_LINE {
        return line.into();
    }
    let words: Vec<String> = line.split(' ').map(|word| without_middle(word, KEPT_OF_WORD)).collect();
    let line = words.join(" ");
    if length(&line) <= LONGEST_LINE { line } else { without_middle(&line, KEPT_OF_LINE) }
}
