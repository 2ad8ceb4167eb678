//! Copies of modules, whose names end in a suffix.

use super::error::LibraryError;
use super::library::{Library, is_copy, own_names};
use super::names::{find_word, suffixed};
use std::collections::BTreeMap;

impl Library {
    /// Checks that the names of a second copy of a module, `path#2`, are free.
    ///
    /// # Errors
    /// [`LibraryError::Taken`].
    pub(super) fn check_copy(&self, path: &str) -> Result<(), LibraryError> {
        match path.split_once('#').filter(|(_, copy)| is_copy(copy)) {
            None => Ok(()),
            Some((file, copy)) => self.check_suffix(file, &format!("_{copy}"), "the second use of the module"),
        }
    }

    /// Checks that names of a file with a suffix are free.
    ///
    /// # Errors
    /// [`LibraryError::Taken`].
    pub(super) fn check_suffix(&self, file: &str, suffix: &str, of: &str) -> Result<(), LibraryError> {
        let text = self.source(file).unwrap_or_default();
        let (mut made, mut twice) = (BTreeMap::new(), BTreeMap::new());
        for name in own_names(file, text) {
            if let Some(other) = made.insert(suffixed(&name, suffix), name.clone()) {
                twice.insert(name, other);
            }
        }
        let taken = find_word(text, |word| made.contains_key(word) || twice.contains_key(word));
        match taken {
            None => Ok(()),
            Some((line, word)) => Err(LibraryError::Taken {
                place: format!("{file}:{line}").into(),
                name: word.into(),
                other: made.get(word).or(twice.get(word)).cloned().unwrap_or_default().into(),
                of: of.into(),
            }),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_that_a_copy_gives_to_another_is_refused() {
        let check = |text: &str| {
            let library = Library::new([("dmf/a.glsl".to_string(), text.to_string())]);
            library.check_copy("dmf/a.glsl#2").map_err(|error| error.to_string())
        };
        let taken =
            "dmf/a.glsl:3: `rings_2` is the name of `rings` in the second use of the module; rename one of them";
        let local = "// @param rings = 1 in [0, 2]: Rings.\nfloat a(float d) {\n    float rings_2 = 2.0 * rings;\n    return rings_2;\n}";
        assert_eq!(check(local), Err(taken.into()));
        assert_eq!(check(&local.replace("rings_2", "rings_3")), Ok(()));
        assert!(check("float w_; float w; float a() { return w; }").is_err(), "both are `w_2`");
    }
}
