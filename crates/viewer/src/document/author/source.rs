//! The text of the edited module, here or in a watched file, and its check.

use super::files::{is_identifier, read, renamed, stamp};
use super::gate::Gate;
use super::trial;
use crate::background::{Background, silent};
use crate::document::model::Model;
use hypertexture::shader::compile::{CompileError, Fault};
use hypertexture::shader::{self, Library};
use hypertexture_support::write_whole;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::task::Poll;
use std::time::{Duration, Instant, SystemTime};

/// Interval between looks at a watched file. Editors replace files: time and length identify a version better than
/// the inode.
pub const WATCH: Duration = Duration::from_millis(250);
/// Rest of a text before it is compiled. Lower: a process for each letter.
const DEBOUNCE: Duration = Duration::from_millis(120);
/// Interval between polls of a running check.
const POLL: Duration = Duration::from_millis(30);
/// Number of failed looks after which a file is gone; a single one may fall between the two steps of a replacement.
const GONE: u32 = 2;

/// The edited module.
pub struct Author {
    slot: String,
    name: String,
    /// The text in the editor.
    pub text: String,
    /// Unfinished texts of other modules, by path.
    drafts: BTreeMap<String, String>,
    file: Option<Watched>,
    tried: Option<String>,
    changed: Instant,
    state: State,
    /// Whether the module goes into the scene once its text passes.
    is_wanted: bool,
    gate: Arc<Gate>,
    /// The check of the text that was submitted last; dropping it cancels it.
    check: Option<Background<Result<(), CompileError>>>,
}

/// Result of the check of the text.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum State {
    /// The text passed.
    Good,
    /// The text is being checked.
    Compiling,
    /// The text was refused; the picture shows the last good one.
    Bad(Vec<Fault>),
}

/// A file that may be edited by another program.
struct Watched {
    path: PathBuf,
    /// Whether the module is not a variation of a shipped one.
    is_own: bool,
    seen: Option<(SystemTime, u64)>,
    looked: Instant,
    /// Number of consecutive looks without a file.
    missed: u32,
    /// The text of the file when it was last read or written.
    text: String,
    /// Text from another program that conflicts with unsaved changes here.
    other: Option<String>,
}

impl Author {
    /// Edits a module of the library. `program` is the executable that compiles: [`std::env::current_exe`].
    ///
    /// # Errors
    /// The module does not exist.
    pub fn new(program: PathBuf, library: &Library, slot: &str, name: &str) -> Result<Author, shader::LibraryError> {
        let path = library.path(slot, name)?;
        let text = library.source(&path).unwrap_or_default().to_string();
        Ok(Author {
            slot: slot.into(),
            name: name.into(),
            tried: Some(text.clone()),
            text,
            drafts: BTreeMap::new(),
            file: None,
            changed: Instant::now(),
            state: State::Good,
            is_wanted: false,
            gate: Arc::new(Gate::new(program)),
            check: None,
        })
    }

    /// The gate that admits programs.
    pub fn gate(&self) -> &Arc<Gate> {
        &self.gate
    }

    /// Slot and name of the module.
    pub fn module(&self) -> (&str, &str) {
        (&self.slot, &self.name)
    }

    /// Path of the module in the library, `slot/name.glsl`.
    pub fn path(&self) -> String {
        format!("{}/{}.glsl", self.slot, self.name)
    }

    /// The watched file.
    pub fn file(&self) -> Option<&Path> {
        self.file.as_ref().map(|file| file.path.as_path())
    }

    /// Whether the file and the text have both changed, so that one must be chosen.
    pub fn is_contested(&self) -> bool {
        self.file.as_ref().is_some_and(|file| file.other.is_some())
    }

    /// Whether the file was deleted.
    pub fn is_gone(&self) -> bool {
        self.file.as_ref().is_some_and(|file| file.missed >= GONE)
    }

    /// Resolves a conflict: takes the text of the file, or keeps this one, which overwrites the file when it is
    /// saved.
    pub fn settle(&mut self, by_file: bool) {
        let Some(file) = &mut self.file else { return };
        if let Some(other) = file.other.take() {
            if by_file {
                self.text.clone_from(&other);
                self.changed = Instant::now() - DEBOUNCE;
            }
            file.text = other;
        }
    }

    /// The problem with the watched file, one line.
    pub fn complaint(&self) -> Option<String> {
        let file = self.file.as_ref()?.path.display();
        match &self.state {
            _ if self.is_gone() => {
                Some(format!("{file} was deleted: the picture keeps its text; `save as` in the editor writes it again"))
            }
            _ if self.is_contested() => {
                Some(format!("{file} was changed by another program and in the editor: open the editor to choose"))
            }
            State::Bad(faults) => faults.first().map(|fault| match &fault.at {
                Some((_, line)) => format!("{file}:{line}: {}", fault.text),
                None => format!("{file}: {}", fault.text),
            }),
            _ => None,
        }
    }

    /// Result of the check of the text.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Unfinished texts of other modules, by path.
    pub fn drafts(&self) -> impl Iterator<Item = (&str, &str)> {
        self.drafts.iter().map(|(path, text)| (path.as_str(), text.as_str()))
    }

    /// Edits another module of the library. An unfinished text becomes a draft.
    pub fn open(&mut self, library: &Library, slot: &str, name: &str) {
        self.leave(library);
        (self.slot, self.name, self.file) = (slot.into(), name.into(), None);
        let path = self.path();
        let good = library.source(&path).map(String::from);
        self.text = self.drafts.remove(&path).or(good.clone()).unwrap_or_default();
        (self.tried, self.state) = (good, State::Good);
        self.check = None;
    }

    /// Stores the text as a draft if the library does not have it.
    fn leave(&mut self, library: &Library) {
        if library.source(&self.path()) != Some(self.text.as_str()) {
            self.drafts.insert(self.path(), self.text.clone());
        }
    }

    /// Creates a module from this text and renames its function.
    ///
    /// # Errors
    /// The name is invalid or in use.
    pub fn fork(&mut self, library: &Library, name: &str) -> Result<(), String> {
        if !is_identifier(name) {
            return Err(format!("invalid module name `{name}`: use a-z, 0-9 and _, starting with a letter"));
        }
        if library.modules(&self.slot).contains(&name) {
            return Err(format!("there is a module {}/{name} already", self.slot));
        }
        let text = renamed(&self.text, &self.name, name);
        self.leave(library);
        self.text = text;
        (self.name, self.file, self.tried, self.is_wanted) = (name.into(), None, None, false);
        self.changed = Instant::now();
        Ok(())
    }

    /// Edits a file and watches it for changes by other programs. The folder names the slot, or the slot is `dmf`;
    /// the file names the module.
    ///
    /// # Errors
    /// The file cannot be read, or its name is not a valid module name.
    pub fn watch(&mut self, library: &Library, path: &Path) -> Result<(), String> {
        let name = path.file_stem().and_then(|stem| stem.to_str()).unwrap_or_default();
        if !is_identifier(name) || path.extension().is_none_or(|end| end != "glsl") {
            return Err(format!(
                "{}: a module file is NAME.glsl, where NAME uses a-z, 0-9 and _, starting with a letter",
                path.display()
            ));
        }
        let folder = path.parent().and_then(Path::file_name).and_then(|folder| folder.to_str()).unwrap_or_default();
        let slot = if library.modules(folder).is_empty() { "dmf" } else { folder };
        self.follow(library, slot, name, path)
    }

    /// Edits and watches the file of a module in a given slot.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn follow(&mut self, library: &Library, slot: &str, name: &str, path: &Path) -> Result<(), String> {
        let text = read(path).map_err(|error| format!("{}: {error}", path.display()))?;
        self.leave(library);
        (self.slot, self.name, self.text, self.tried) = (slot.into(), name.into(), text, None);
        self.drafts.remove(&self.path());
        (self.changed, self.is_wanted) = (Instant::now() - DEBOUNCE, false);
        self.file = Some(self.watched(path));
        Ok(())
    }

    fn watched(&self, path: &Path) -> Watched {
        let is_own = shader::shipped().source(&self.path()).is_none();
        let (seen, text) = (stamp(path), self.text.clone());
        Watched { path: path.into(), is_own, seen, looked: Instant::now(), missed: 0, text, other: None }
    }

    /// Writes the text to a file, and watches the file.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn save(&mut self, path: &Path) -> Result<(), String> {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty());
        folder
            .map_or(Ok(()), std::fs::create_dir_all)
            .and_then(|()| write_whole(path, self.text.as_bytes()))
            .map_err(|error| format!("{}: {error}; nothing was written", path.display()))?;
        self.file = Some(self.watched(path));
        Ok(())
    }

    /// Restores the shipped text, if there is one.
    pub fn reset(&mut self) {
        if let Some(text) = shader::shipped().source(&self.path()) {
            self.text = text.into();
        }
    }

    /// Puts the module into the scene; if its check is running, once it has passed.
    pub fn use_in(&mut self, model: &mut Model) -> bool {
        self.is_wanted = self.state == State::Compiling;
        if self.is_wanted {
            return true;
        }
        let (slot, name) = (self.slot.clone(), self.name.clone());
        let library = model.library().clone();
        let what = format!("use {slot}/{name}");
        let good = model.edit(&what, |scene| trial::use_module(scene, &library, &slot, &name));
        model.end_undo_group();
        good
    }

    /// Looks at the file, submits a new text and receives the result: a text that passes becomes part of the model's
    /// library. Called once per frame, and again after [`Author::wakes`]. Returns whether the model has changed.
    pub fn poll(&mut self, model: &mut Model) -> bool {
        self.look();
        self.is_wanted &= self.state == State::Compiling;
        if self.is_untried() {
            self.state = State::Compiling; // what was said is of another text
            if self.changed.elapsed() >= DEBOUNCE {
                self.submit(model);
            }
        }
        if let Some(file) = self.file.as_ref().filter(|file| file.is_own && self.state == State::Good)
            && model.library().source(&self.path()).is_some()
        {
            model.file_module(&format!("{}/{}", self.slot, self.name), &file.path.to_string_lossy());
        }
        let Some(Poll::Ready(answer)) = self.check.as_ref().map(Background::poll) else { return false };
        self.check = None;
        match answer {
            None => false,
            Some(_) if self.is_untried() => false,
            Some(Err(error)) => {
                self.state = State::Bad(Fault::all(&error.to_string()));
                false
            }
            Some(Ok(())) => {
                let path = self.path();
                let text = self.tried.as_deref().unwrap_or_default();
                let library = model.library().clone().with_module(&self.slot, &self.name, text);
                match model.set_library(library) {
                    Ok(()) => self.state = State::Good,
                    Err(error) => self.state = State::Bad(Fault::all(&format!("{path}: {error}"))),
                }
                let is_good = self.state == State::Good;
                if std::mem::take(&mut self.is_wanted) && is_good {
                    self.use_in(model);
                }
                is_good
            }
        }
    }

    /// Whether the text was not submitted.
    fn is_untried(&self) -> bool {
        self.tried.as_deref() != Some(self.text.as_str())
    }

    /// Time until the next poll that is needed without user input.
    pub fn wakes(&self) -> Option<Duration> {
        match self.state {
            State::Compiling => Some(POLL),
            _ => self.file.as_ref().map(|_| WATCH),
        }
    }

    /// Notes that the text was edited.
    pub fn touch(&mut self) {
        self.changed = Instant::now();
    }

    fn look(&mut self) {
        let Some(file) = self.file.as_mut().filter(|file| file.looked.elapsed() >= WATCH) else { return };
        file.looked = Instant::now();
        let now = stamp(&file.path);
        file.missed = if now.is_some() { 0 } else { file.missed.saturating_add(1) };
        if now.is_some() && now != file.seen {
            match read(&file.path) {
                Ok(text) => {
                    file.seen = now;
                    if self.text == file.text || self.text == text {
                        (self.text, file.other) = (text.clone(), None);
                        self.changed = Instant::now() - DEBOUNCE;
                        file.text = text;
                    } else {
                        file.other = Some(text);
                    }
                }
                Err(error) => {
                    let text = format!("{}: {error}", file.path.display());
                    self.state = State::Bad(vec![Fault { at: None, text }]);
                }
            }
        }
    }

    fn submit(&mut self, model: &Model) {
        self.tried = Some(self.text.clone());
        let library = model.library().clone().with_module(&self.slot, &self.name, &self.text);
        match trial::scene_with(model.scene(), &library, &self.slot, &self.name) {
            Ok(Some(scene)) => {
                self.state = State::Compiling;
                let gate = self.gate.clone();
                self.check = Some(Background::start(&silent(), move |task| {
                    task.send(gate.validate(&scene, &library, &|| task.is_cancelled()));
                }));
            }
            Ok(None) => {
                self.check = None;
                let text = format!("no program of this scene includes {}; choose a scene that does", self.path());
                self.state = State::Bad(vec![Fault { at: None, text }]);
            }
            Err(error) => {
                self.check = None;
                self.state = State::Bad(Fault::all(&error.to_string()));
            }
        }
    }
}
