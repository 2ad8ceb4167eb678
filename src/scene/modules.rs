//! Custom modules: GLSL files besides those that ship.

use super::{Scene, SceneError};
use crate::shader::{self, Library};
use hypertexture_support::open;
use std::path::Path;

/// Size limit of the file of a module, bytes.
const MAX_BYTES: u64 = 1 << 20;

impl Scene {
    /// Adds the module of a file to a slot; returns its name, the stem of the file.
    ///
    /// # Errors
    /// The name is not a GLSL identifier.
    pub fn add_module(&mut self, slot: &str, file: &str) -> Result<String, SceneError> {
        let name = Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let letters = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
        if !name.starts_with(|c: char| c.is_ascii_lowercase()) || !name.chars().all(letters) {
            let limit = "a module is named after its file: a-z, 0-9 and _, a letter first, such as my_fur.glsl";
            return Err(SceneError::value(slot, file, limit));
        }
        self.modules.insert(format!("{slot}/{name}"), file.into());
        Ok(name)
    }

    /// The shipped modules and those of the scene.
    ///
    /// # Errors
    /// A file cannot be read, its slot is unknown, or a shipped module has its name.
    pub fn library(&self) -> Result<Library, SceneError> {
        let mut library = shader::shipped();
        for (module, file) in &self.modules {
            let fail = |reason: String| SceneError::Read { path: file.clone(), reason };
            let (slot, name) = module.split_once('/').unwrap_or((module, ""));
            let shipped = library.modules(slot);
            if shipped.is_empty() {
                let limit = format!("`{slot}` is not a slot; write modules.\"dmf/my_fur\" = \"my_fur.glsl\"");
                return Err(SceneError::value(format!("modules.\"{module}\""), file, limit));
            }
            if shipped.contains(&name) {
                return Err(fail(format!("{slot}/{name} is a module that ships; give the file another name")));
            }
            let text = open::text(Path::new(file), MAX_BYTES).map_err(|error| fail(error.to_string()))?;
            library = library.with_module(slot, name, &text);
        }
        Ok(library)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::variant::Variant;
    use crate::scene::preset;

    const MODULE: &str = "// Half of it.\n// Source: a test.\n// @param part = 0.5 in [0, 1]: How much.\n// Result: density.\n\
                          float half_of(float density, Sample s) { return part * density; }\n";

    #[test]
    fn m52_a_module_of_a_file_is_one_among_the_others() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("half_of.glsl");
        std::fs::write(&file, MODULE).unwrap();
        let mut scene = preset("fire").unwrap();
        let name = scene.add_module("dmf", &file.display().to_string()).unwrap();
        scene.effect.dmf.push(name);
        let library = scene.library().unwrap();
        let variant = Variant::of(&scene, &library).unwrap();
        assert!(variant.all_parameters().any(|(name, ..)| name == "part"));
        assert!(!variant.program(&library, crate::shader::Linker::new).unwrap().shipped);
    }

    #[test]
    fn a_file_that_is_no_module_is_one_clear_line() {
        let refusal = |slot: &str, file: &str| {
            let mut scene = Scene::default();
            scene.add_module(slot, file).and_then(|_| scene.library()).unwrap_err().to_string()
        };
        assert!(refusal("dmf", "My Fur.glsl").starts_with("dmf = My Fur.glsl: a module is named after its file"));
        assert!(refusal("dmf", "no_such.glsl").starts_with("no_such.glsl: there is no such file"));
        assert!(refusal("dfm", "half.glsl").contains("`dfm` is not a slot"));
        assert_eq!(refusal("dmf", "fur.glsl"), "fur.glsl: dmf/fur is a module that ships; give the file another name");
    }
}
