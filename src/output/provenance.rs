//! Provenance of a picture, stored in its file so that it can be rendered again and verified.
//!
//! Role: the scene as text, hashes of its inputs, and the device, as TOML in an iTXt chunk of a PNG or a text attribute of
//! an OpenEXR file. Invariant: of the machine it reveals only the device and the paths of inputs as typed.

use crate::render::Measurements;
use crate::scene::{self, Reach, Scene, SceneError, ShaderStage};
use crate::shape::{BUILT_IN, MEMORY};
use hypertexture_support::open;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::{fs, io, iter};

/// Name and version of this program.
pub const PROGRAM: &str = concat!("hypertexture ", env!("CARGO_PKG_VERSION"));

/// Name of the chunk or attribute.
pub(super) const KEY: &str = "hypertexture";
/// Length limit of the text, bytes: more than the largest scene file with every character escaped.
const MAX_BYTES: usize = 8 << 20;

/// Provenance of a picture.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Provenance {
    /// Name and version of the program.
    pub program: String,
    /// Name and driver of the device; for a merged picture those of all shards, in order.
    pub device: String,
    /// Slots and modules of the program.
    pub modules: String,
    /// BLAKE3 hash of `scene`.
    pub scene_hash: String,
    /// The scene, complete with defaults, as a scene file; `quality.stage` is not recorded.
    pub scene: String,
    /// BLAKE3 hashes of the input files by their path in the scene, and of detached data files; for a folder, the hash of its
    /// files.
    #[serde(default)]
    pub inputs: BTreeMap<String, String>,
}

/// Errors of reading provenance and of finding its inputs.
#[allow(missing_docs, reason = "the names of the fields describe them")]
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ProvenanceError {
    /// The file has no provenance.
    #[error("it does not say which scene it shows; pictures that hypertexture has written do, unless a tool drops it")]
    None,
    /// The text is too long.
    #[error("its provenance has {0} bytes, more than the {MAX_BYTES} that any scene needs")]
    Long(usize),
    /// The text is malformed.
    #[error("its provenance cannot be read: {0}")]
    Syntax(String),
    /// The scene was changed after rendering.
    #[error("the scene in it is not the one that was rendered: its hash is {found}, not {said}")]
    Changed { found: String, said: String },
    /// The scene cannot be read.
    #[error(transparent)]
    Scene(#[from] SceneError),
    /// An input was in memory.
    #[error(
        "its object was in the memory of the program that rendered it, with contents of BLAKE3 hash {0}, and cannot be had again"
    )]
    InMemory(String),
    /// An input is out of reach.
    #[error("{0}")]
    Outside(String),
    /// An input is missing.
    #[error("input {input}: {reason}; it was rendered from a file with BLAKE3 hash {said}")]
    Missing { input: String, reason: io::Error, said: String },
    /// An input has another content.
    #[error("input {input}: this is not the file it was rendered from: its BLAKE3 hash is {found}, not {said}")]
    Input { input: String, found: String, said: String },
}

impl Provenance {
    /// The provenance of a picture that this program has rendered.
    ///
    /// # Errors
    /// [`ProvenanceError::Missing`]: an input file has disappeared.
    pub fn of(scene: &Scene, device: &str, measured: &Measurements) -> Result<Provenance, ProvenanceError> {
        let mut inputs = BTreeMap::new();
        let named = scene.files().map(|(_, input)| input.to_string()).filter(|input| !BUILT_IN.contains(&&**input));
        for input in named.chain(measured.others.iter().map(|path| path.display().to_string())) {
            if let Some(hash) = input.strip_prefix(MEMORY) {
                inputs.insert(input.clone(), hash.into());
            } else if !inputs.contains_key(&input) {
                let hash = hash_of(Path::new(&input));
                let missing = |reason| ProvenanceError::Missing { input: input.clone(), reason, said: "?".into() };
                inputs.insert(input.clone(), hash.map_err(missing)?);
            }
        }
        let mut drawn = scene.clone();
        drawn.quality.stage = ShaderStage::default(); // a choice for a machine: all stages draw one picture
        let text = scene::to_text(&drawn);
        let scene_hash = blake3::hash(text.as_bytes()).to_string();
        let (program, device, modules) = (PROGRAM.into(), device.into(), measured.modules.clone());
        Ok(Provenance { program, device, modules, scene_hash, scene: text, inputs })
    }

    /// The text in a file, as TOML.
    pub fn to_text(&self) -> String {
        toml::to_string(self).expect("strings by name are TOML")
    }

    /// Parses the text of [`Provenance::to_text`].
    ///
    /// # Errors
    /// The text is malformed, or the scene does not have its hash.
    pub fn from_text(text: &str) -> Result<Provenance, ProvenanceError> {
        if text.len() > MAX_BYTES {
            return Err(ProvenanceError::Long(text.len()));
        }
        let syntax = |error: toml::de::Error| ProvenanceError::Syntax(error.message().replace('\n', " "));
        let read: Provenance = toml::from_str(text).map_err(syntax)?;
        let found = blake3::hash(read.scene.as_bytes()).to_string();
        if found != read.scene_hash {
            let said = read.scene_hash.chars().take(found.len()).collect();
            return Err(ProvenanceError::Changed { found, said });
        }
        Ok(read)
    }

    /// The scene of the picture in the file `picture`. Inputs that are not at their path are looked for beside the picture.
    ///
    /// # Errors
    /// This version cannot read the scene, or it names a file out of reach.
    pub fn scene(&self, picture: &Path, reach: Reach) -> Result<Scene, ProvenanceError> {
        let mut scene = scene::parse(&self.scene, &format!("the scene in {}", picture.display()))?;
        for file in scene.files_mut().filter(|file| self.inputs.contains_key(*file)) {
            *file = self.place(file, picture);
        }
        reach.check(&scene, picture)?;
        Ok(scene)
    }

    /// Checks that the input files are unchanged since rendering. Files out of reach are not read.
    ///
    /// # Errors
    /// A file is out of reach, missing or changed.
    pub fn check_inputs(&self, picture: &Path, reach: Reach) -> Result<(), ProvenanceError> {
        for (input, said) in &self.inputs {
            if input.starts_with(MEMORY) {
                return Err(ProvenanceError::InMemory(said.clone()));
            }
            let (input, said) = (self.place(input, picture), said.clone());
            let below = iter::once_with(|| read_for(Path::new(&input)).unwrap_or_default()).flatten();
            let files = iter::once(PathBuf::from(&input)).chain(below);
            let named = files.map(|file| (format!("input {}", file.display()), file));
            if let Some(reason) = reach.first_out(named, picture) {
                return Err(ProvenanceError::Outside(reason));
            }
            match hash_of(Path::new(&input)) {
                Err(reason) => return Err(ProvenanceError::Missing { input, reason, said }),
                Ok(found) if found != said => return Err(ProvenanceError::Input { input, found, said }),
                Ok(_) => {}
            }
        }
        Ok(())
    }

    /// Present path of an input.
    fn place(&self, input: &str, picture: &Path) -> String {
        let beside = picture.parent().unwrap_or(Path::new("")).join(input);
        if !Path::new(input).exists() && beside.exists() { beside.display().to_string() } else { input.into() }
    }
}

/// Files of an input: itself, or those in a folder by name.
fn read_for(input: &Path) -> io::Result<Vec<PathBuf>> {
    if !input.is_dir() {
        return Ok(vec![input.into()]);
    }
    let paths: Vec<PathBuf> = fs::read_dir(input)?.map(|entry| Ok(entry?.path())).collect::<io::Result<_>>()?;
    let mut files: Vec<PathBuf> = paths.into_iter().filter(|path| path.is_file()).collect();
    files.sort();
    Ok(files)
}

/// Hash of a file; for a folder, the hash of the names and contents of its files.
fn hash_of(path: &Path) -> io::Result<String> {
    if !path.is_dir() {
        return Ok(open::hash(path)?.to_string());
    }
    let mut all = blake3::Hasher::new();
    for file in read_for(path)? {
        let name = file.file_name().unwrap_or_default().as_encoded_bytes();
        all.update(&(name.len() as u64).to_le_bytes()).update(name).update(open::hash(&file)?.as_bytes());
    }
    Ok(all.finalize().to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::Subject;
    use crate::shader::shipped;

    #[test]
    fn any_text_comes_back_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let mut scene =
            Scene { about: "line\nline\r\n\"\"\" ''' \\ \u{0} \u{7f} é 毛 \u{1f525}".into(), ..Scene::default() };
        scene.object.input = folder.path().join("ü '\"\n.obj").display().to_string();
        std::fs::write(&scene.object.input, "v 0 0 0").unwrap();
        let whole = Provenance::of(&scene, "a \"device\"", &Measurements::default()).unwrap();
        let read = Provenance::from_text(&whole.to_text()).unwrap();
        assert_eq!(read, whole);
        assert_eq!(read.scene(Path::new("x.png"), Reach::Anywhere).unwrap(), scene);
        assert_eq!(read.inputs[&scene.object.input], blake3::hash(b"v 0 0 0").to_string());
        scene.quality.stage = ShaderStage::Compute;
        assert_eq!(Provenance::of(&scene, "a \"device\"", &Measurements::default()).unwrap(), whole);
    }

    #[test]
    fn a_folder_of_slices_is_known_by_its_files() {
        let folder = tempfile::tempdir().unwrap();
        let scan = folder.path().join("scan");
        fs::create_dir(&scan).unwrap();
        ["a", "b"].iter().for_each(|name| fs::write(scan.join(name), name).unwrap());
        let mut scene = Scene::default();
        scene.object.input = scan.display().to_string();
        let whole = Provenance::of(&scene, "a device", &Measurements::default()).unwrap();
        let is_same = || whole.check_inputs(&folder.path().join("x.png"), Reach::Beside).is_ok();
        assert!(is_same());
        fs::rename(scan.join("b"), scan.join("c")).unwrap();
        assert!(!is_same());
        fs::rename(scan.join("c"), scan.join("b")).unwrap();
        assert!(is_same());
        fs::write(scan.join("b"), "a").unwrap();
        assert!(!is_same());
    }

    #[test]
    fn the_data_of_a_header_is_known_by_its_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let [header, data] = ["scan.nhdr", "scan.raw"].map(|name| folder.path().join(name));
        fs::write(&header, "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 8 8 8\nencoding: raw\ndata file: scan.raw\n")
            .unwrap();
        let ball = |k: i32| [k % 8, k / 8 % 8, k / 64].map(|at| (2 * at - 7).pow(2)).iter().sum::<i32>() < 40;
        fs::write(&data, (0..512).map(|k| 200 * u8::from(ball(k))).collect::<Vec<_>>()).unwrap();
        let mut scene = Scene::default();
        (scene.object.input, scene.object.iso) = (header.display().to_string(), Some(100.0));
        let subject = Subject::load(&scene, &shipped(), &|_| ()).unwrap();
        let others = subject.all_others().cloned().collect();
        let whole = Provenance::of(&scene, "a device", &Measurements { others, ..Measurements::default() }).unwrap();
        assert_eq!(whole.inputs.len(), 2, "{:?}", whole.inputs);
        let said =
            || whole.check_inputs(&folder.path().join("x.png"), Reach::Beside).map_err(|error| error.to_string());
        assert_eq!(said(), Ok(()));
        fs::write(&data, [100; 512]).unwrap();
        assert!(said().unwrap_err().contains("scan.raw"), "{:?}", said());
    }

    #[cfg(unix)]
    #[test]
    fn a_picture_has_no_file_read_that_a_scene_may_not_name() {
        let root = tempfile::tempdir().unwrap();
        let [home, away] = ["home", "away"].map(|name| root.path().join(name));
        for folder in [&home, &away, &home.join("series"), &away.join("series")] {
            fs::create_dir(folder).unwrap();
            fs::write(folder.join("a.obj"), "v 0 0 0").unwrap();
        }
        let link = |to: &str, from: &str| std::os::unix::fs::symlink(away.join(to), home.join(from)).unwrap();
        link("a.obj", "link.obj");
        link("series", "link");
        link("a.obj", "series/link.obj");
        let picture = home.join("x.png");
        let whole = Provenance::of(&Scene::default(), "a device", &Measurements::default()).unwrap();
        let said = |input: &Path, reach| {
            let inputs = [(input.display().to_string(), "0".repeat(64))].into();
            Provenance { inputs, ..whole.clone() }.check_inputs(&picture, reach).unwrap_err().to_string()
        };
        for (input, is_beside) in [
            (home.join("a.obj"), true),
            (away.join("a.obj"), false),
            (away.join("series"), false),
            (home.join("link.obj"), false),
            (home.join("link"), false),
            (home.join("link/a.obj"), false),
            (home.join("series"), false), // for what is in it
            (home.join("none.obj"), true),
        ] {
            let out = said(&input, Reach::Beside);
            assert_eq!(!out.ends_with("if that is meant: --outside"), is_beside, "{}: {out}", input.display());
            assert!(!said(&input, Reach::Anywhere).contains("--outside"), "{}", input.display());
        }
    }

    #[test]
    fn what_is_no_provenance_or_was_changed_is_refused_in_one_line() {
        let good = Provenance::of(&Scene::default(), "a device", &Measurements::default()).unwrap().to_text();
        let said = |text: &str| Provenance::from_text(text).unwrap_err().to_string();
        for (text, expected) in [
            (String::new(), "cannot be read: missing field `program`"),
            (good.replace("program = ", "program"), "cannot be read"),
            (good.replace("samples = 256", "samples = 255"), "is not the one that was rendered"),
            ("x".repeat(MAX_BYTES + 1), "more than the"),
        ] {
            let said = said(&text);
            assert!(said.contains(expected) && !said.contains('\n'), "{said}");
        }
    }
}
