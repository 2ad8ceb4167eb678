//! The shipped modules, embedded by `build.rs`.

use hypertexture_glsl::Library;
use std::collections::BTreeMap;
use std::sync::LazyLock;

include!(concat!(env!("OUT_DIR"), "/library.rs"));

/// The shipped library.
pub fn shipped() -> Library {
    static SHIPPED: LazyLock<Library> =
        LazyLock::new(|| Library::new(SHIPPED_SOURCES.iter().map(|(path, text)| (path.to_string(), text.to_string()))));
    SHIPPED.clone()
}

/// The shipped library with files replaced or added: path relative to the `glsl` folder, and text.
pub fn shipped_with(changed: BTreeMap<String, String>) -> Library {
    let shipped = SHIPPED_SOURCES.iter().map(|(path, text)| (path.to_string(), text.to_string()));
    Library::new(shipped.chain(changed))
}

/// The files of a library that differ from the shipped ones.
pub fn changed(library: &Library) -> BTreeMap<String, String> {
    let shipped = shipped();
    let changed = library.sources().filter(|(path, text)| shipped.source(path) != Some(text));
    changed.map(|(path, text)| (path.into(), text.into())).collect()
}
