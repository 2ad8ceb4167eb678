//! Files of a scene, and which of them it may name.

use crate::scene::{GLSL, Scene, SceneError};
use hypertexture_support::open::Home;
use std::path::{Path, PathBuf};

impl Scene {
    /// Possible files with their fields: inputs of the objects, the groom, and custom modules.
    pub fn files(&self) -> impl Iterator<Item = (String, &str)> {
        let parts = self.parts.iter().map(|(name, part)| (format!("parts.{name}.object.input"), &part.object));
        let objects = [("object.input".into(), &self.object)].into_iter().chain(parts);
        let modules = self.modules.iter().map(|(module, file)| (format!("modules.\"{module}\""), file.as_str()));
        let groom = self.groom.iter().map(|file| ("groom".into(), file.as_str()));
        let inputs = objects.map(|(field, object)| (field, object.input.as_str()));
        inputs.filter(|(_, input)| !input.starts_with(GLSL)).chain(modules).chain(groom)
    }

    /// Mutable paths of those files.
    pub(crate) fn files_mut(&mut self) -> impl Iterator<Item = &mut String> {
        let objects = [&mut self.object].into_iter().chain(self.parts.values_mut().map(|part| &mut part.object));
        objects.map(|object| &mut object.input).chain(self.modules.values_mut()).chain(&mut self.groom)
    }
}

/// Files that an untrusted scene may name.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Reach {
    /// Files below the folder of the scene or the current folder.
    Beside,
    /// All files.
    Anywhere,
}

impl Reach {
    /// Checks the files of a scene in the file `of`.
    ///
    /// # Errors
    /// A file exists and is out of reach.
    pub fn check(self, scene: &Scene, of: &Path) -> Result<(), SceneError> {
        let files = scene.files().map(|(field, file)| (format!("{field} = {file}"), file.into()));
        match self.first_out(files, of) {
            None => Ok(()),
            Some(reason) => Err(SceneError::Read { path: of.display().to_string(), reason }),
        }
    }

    /// Message about the first of these files, each with its name for messages, that is out of reach of the file `of`.
    pub(crate) fn first_out(self, files: impl Iterator<Item = (String, PathBuf)>, of: &Path) -> Option<String> {
        let home = Home::of(of.parent().unwrap_or(Path::new("")));
        let mut out = files.filter(|(_, file)| self == Reach::Beside && !home.holds(file));
        out.next().map(|(named, _)| {
            format!(
                "{named}: it is not below the folder of this file, nor below the current one; if that is meant: --outside"
            )
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::load;

    #[test]
    fn a_scene_reaches_files_beside_it_and_no_others() {
        let root = tempfile::tempdir().unwrap();
        let [home, away] = ["home", "away"].map(|name| root.path().join(name));
        std::fs::create_dir_all(home.join("deep")).unwrap();
        std::fs::create_dir(&away).unwrap();
        for folder in [&home, &home.join("deep"), &away] {
            std::fs::write(folder.join("a.obj"), "v 0 0 0").unwrap();
        }
        let scene = home.join("x.toml");
        let away = away.join("a.obj").display().to_string();
        for (input, is_beside) in [
            ("a.obj", true),
            ("deep/a.obj", true),
            ("deep/../a.obj", true),
            ("../other/a.obj", true),
            ("../away/a.obj", false),
            (&away, false),
            ("/etc/passwd", false),
            ("/no/such/file", true), // whatever it is, nobody reads it
        ] {
            std::fs::write(&scene, format!("[object]\ninput = {input:?}\n")).unwrap();
            let found = load(&scene, Reach::Beside).map_err(|error| error.to_string());
            assert_eq!(found.is_ok(), is_beside, "{input}: {found:?}");
            let said = found.err().unwrap_or_default();
            assert!(is_beside || said.contains("x.toml: object.input = ") && said.ends_with("--outside"), "{said}");
            load(&scene, Reach::Anywhere).unwrap();
        }
        std::fs::write(&scene, format!("[modules]\n\"dmf/own\" = {away:?}\n")).unwrap();
        let said = load(&scene, Reach::Beside).unwrap_err().to_string();
        assert!(said.contains("modules.\"dmf/own\" = ") && said.ends_with("--outside"), "{said}");
    }
}
