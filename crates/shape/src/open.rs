//! Opening of built-in objects and files.
//!
//! Invariant: only plain files are opened; content decides the format before the extension.

use crate::built_in::{self, BUILT_IN};
use crate::error::{Location, ShapeError, quoted, shown, unreadable};
use crate::from_memory::MEMORY;
use crate::mesh::{gltf, obj, ply, stl, threemf};
use crate::shape::Shape;
use crate::source::Source;
use crate::unit::Unit;
use crate::volume::{dicom, meta, nifti, nrrd, raw, vdb};
use hypertexture_support::open::{self as plain, OpenError};
use hypertexture_support::words::nearest;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};

/// One file format.
struct Format {
    /// Extensions without the dot, lower case.
    extensions: &'static [&'static str],
    /// Whether the first bytes (up to 1024) and the length identify the format.
    recognizes: fn(&[u8], u64) -> bool,
    /// Reads the file from its start.
    read: fn(&mut Source) -> Result<Shape, ShapeError>,
}

/// Formats in the order in which they are tried.
const FORMATS: &[Format] = &[
    Format { extensions: &["nrrd", "nhdr"], recognizes: nrrd::recognizes, read: nrrd::read },
    Format { extensions: &["mhd", "mha"], recognizes: meta::recognizes, read: meta::read },
    Format { extensions: &["gltf", "glb"], recognizes: gltf::recognizes, read: gltf::read },
    Format { extensions: &["dcm"], recognizes: dicom::recognizes, read: dicom::read },
    Format { extensions: &["vdb"], recognizes: vdb::recognizes, read: vdb::read },
    Format { extensions: &["nii", "nii.gz", "hdr", "hdr.gz"], recognizes: nifti::recognizes, read: nifti::read },
    Format { extensions: &["raw"], recognizes: |_, _| false, read: raw::refuse },
    Format { extensions: &["3mf"], recognizes: threemf::recognizes, read: threemf::read },
    Format { extensions: &["ply"], recognizes: ply::recognizes, read: ply::read },
    Format { extensions: &["stl"], recognizes: stl::recognizes, read: stl::read },
    Format { extensions: &["obj"], recognizes: |_, _| false, read: obj::read }, // OBJ has no signature
];

/// Opens a built-in object or a file.
///
/// A name in [`BUILT_IN`] always means the built-in object; write `./sphere` for a file of that name. The content decides the
/// format (NRRD, MetaImage, DICOM, OpenVDB, NIfTI, glTF, 3MF, PLY, STL), else the extension (OBJ). Coordinates stay as they are in
/// the file; those of DICOM and MetaImage are converted to the axes of NIfTI. A folder means the DICOM series in it, and a
/// slice its whole series; other folders, devices and pipes are refused. Each note of [`Opened`] is logged as a warning.
///
/// # Errors
/// Any [`ShapeError`]; its message is one line.
pub fn open(name_or_path: &str) -> Result<Shape, ShapeError> {
    Ok(Opened::of(name_or_path)?.warned(name_or_path))
}

/// Opens as [`open`] does; a mesh of glTF or OBJ has the colors and textures of its materials too.
///
/// # Errors
/// Those of [`open`], and those of textures.
pub fn open_painted(name_or_path: &str) -> Result<Shape, ShapeError> {
    Ok(Opened::with(name_or_path, Wanted { grid: None, is_painted: true })?.warned(name_or_path))
}

/// Optional parts of files.
#[derive(Clone, Copy, Default)]
struct Wanted<'a> {
    /// A grid of an OpenVDB file.
    grid: Option<&'a str>,
    /// Colors and textures of materials.
    is_painted: bool,
}

/// A shape with notes about its file.
#[derive(Clone, Debug)]
pub struct Opened {
    /// The shape itself.
    pub shape: Shape,
    /// Short sentences about assumptions and omissions.
    pub notes: Vec<String>,
    /// Other files of the shape: the data of a header, the slices of a series.
    pub others: Vec<PathBuf>,
    /// Names and types of the grids of an OpenVDB file.
    pub grids: Vec<String>,
    /// Names of the objects of a 3MF file.
    pub names: Vec<String>,
    /// Unit of the coordinates of the file: that of 3MF, NIfTI and NRRD, meters of glTF, millimeters of DICOM and MetaImage.
    pub unit: Option<Unit>,
}

impl From<Shape> for Opened {
    fn from(shape: Shape) -> Opened {
        Opened { shape, notes: Vec::new(), others: Vec::new(), grids: Vec::new(), names: Vec::new(), unit: None }
    }
}

impl Opened {
    /// Opens a built-in object or a file, as [`open`] does.
    ///
    /// # Errors
    /// Those of [`open`].
    pub fn of(name_or_path: &str) -> Result<Opened, ShapeError> {
        Opened::with_grid(name_or_path, None)
    }

    /// Opens a built-in object or a file, with a grid of an OpenVDB file by name; `None` is the default grid.
    ///
    /// # Errors
    /// Those of [`open`], and [`ShapeError::NoGrid`].
    pub fn with_grid(name_or_path: &str, grid: Option<&str>) -> Result<Opened, ShapeError> {
        Opened::with(name_or_path, Wanted { grid, is_painted: false })
    }

    /// Opens as [`Opened::with_grid`] does, with the colors and textures of materials.
    ///
    /// # Errors
    /// Those of [`Opened::with_grid`], and those of materials and textures.
    pub fn with_paint(name_or_path: &str, grid: Option<&str>) -> Result<Opened, ShapeError> {
        Opened::with(name_or_path, Wanted { grid, is_painted: true })
    }

    fn with(name_or_path: &str, wanted: Wanted) -> Result<Opened, ShapeError> {
        let alone = |opened| match wanted.grid {
            Some(grid) => Err(no_grids(shown(name_or_path), grid)),
            None => Ok(opened),
        };
        if name_or_path.starts_with(MEMORY) {
            return Err(ShapeError::InMemory { name: shown(name_or_path) });
        }
        if let Some(shape) = built_in::by_name(name_or_path) {
            return alone(shape.into());
        }
        let path = Path::new(name_or_path);
        if path.is_dir() {
            let (shape, notes) = dicom::read_folder(&shown(name_or_path), path)?;
            return alone(Opened { notes, unit: Some(Unit::Millimeter), ..shape.into() });
        }
        let (opened, len) = plain::open(path, u64::MAX).map_err(|error| unopened(name_or_path, error))?;
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        parse(name_or_path, len, (Some(folder), wanted), &mut BufReader::new(opened))
    }

    /// Logs the notes and returns the shape.
    pub fn warned(self, name: &str) -> Shape {
        self.notes.iter().for_each(|note| log::warn!("{}: {note}", shown(name)));
        self.shape
    }
}
/// Reads a file that is already in memory; `name` gives the extension and the name for messages. Notes are logged as warnings.
///
/// # Errors
/// Any [`ShapeError`] that the content can cause.
pub fn read(name: &str, bytes: &[u8]) -> Result<Shape, ShapeError> {
    Ok(read_noted(name, bytes)?.warned(name))
}

/// Like [`read`], but returns the notes.
///
/// # Errors
/// Those of [`read`].
pub fn read_noted(name: &str, mut bytes: &[u8]) -> Result<Opened, ShapeError> {
    parse(name, bytes.len() as u64, (None, Wanted::default()), &mut bytes)
}

/// Like [`read`], with the colors and textures of materials.
///
/// # Errors
/// Those of [`read`], and those of textures.
pub fn read_painted(name: &str, mut bytes: &[u8]) -> Result<Shape, ShapeError> {
    let wanted = Wanted { grid: None, is_painted: true };
    Ok(parse(name, bytes.len() as u64, (None, wanted), &mut bytes)?.warned(name))
}

fn known_extensions() -> String {
    let all = FORMATS.iter().flat_map(|format| format.extensions);
    all.map(|extension| format!(".{extension}")).collect::<Vec<_>>().join(", ")
}

fn parse(
    name: &str,
    len: u64,
    (folder, wanted): (Option<PathBuf>, Wanted),
    reader: &mut dyn BufRead,
) -> Result<Opened, ShapeError> {
    let mut source = Source::new(shown(name), len, folder, reader);
    source.grid = wanted.grid.map(str::to_owned);
    source.is_painted = wanted.is_painted;
    if source.peek()?.is_empty() {
        return Err(ShapeError::Empty { file: source.file });
    }
    let mut format = by_content(source.peek()?, len);
    if format.is_none() && source.skip_mark()? {
        format = by_content(source.peek()?, len);
    }
    if format.is_none() && is_utf_16(source.peek()?) {
        return Err(source.malformed_at(Location::Byte(0), "text in UTF-8", "text in UTF-16".into()));
    }
    let start = source.peek()?;
    match format.or_else(|| by_extension(name)) {
        Some(format) => {
            let shape = (format.read)(&mut source)?;
            if let Some(grid) = wanted.grid.filter(|_| source.grids.is_empty()) {
                return Err(no_grids(source.file, grid));
            }
            let (notes, others) = (source.notes.into_inner(), source.others.into_inner());
            Ok(Opened { shape, notes, others, grids: source.grids, names: source.names, unit: source.unit.get() })
        }
        None => {
            let start = quoted(&start[..start.len().min(16)]);
            Err(ShapeError::UnknownFormat { file: source.file, start, known: known_extensions() })
        }
    }
}

fn by_content(start: &[u8], len: u64) -> Option<&'static Format> {
    FORMATS.iter().find(|format| (format.recognizes)(start, len))
}

/// Whether the file begins as Latin text in UTF-16, with a byte order mark.
fn is_utf_16(start: &[u8]) -> bool {
    let low = match start {
        [0xff, 0xfe, ..] => 0,
        [0xfe, 0xff, ..] => 1,
        _ => return false,
    };
    start[2..].chunks_exact(2).take(8).all(|pair| pair[low].is_ascii() && pair[1 - low] == 0)
}

/// A grid is requested from a file of another format than OpenVDB.
fn no_grids(file: String, grid: &str) -> ShapeError {
    ShapeError::NoGrid { file, name: quoted(grid.as_bytes()), known: "none: files of OpenVDB have grids".into() }
}

fn by_extension(name: &str) -> Option<&'static Format> {
    let name = name.to_ascii_lowercase();
    let ends = |extension: &&str| name.strip_suffix(*extension).is_some_and(|stem| stem.ends_with('.'));
    FORMATS.iter().find(|format| format.extensions.iter().any(ends))
}

/// Error of a path that cannot be opened: an unknown name if it does not look like a path.
fn unopened(name: &str, error: OpenError) -> ShapeError {
    let file = shown(name);
    match error {
        OpenError::Missing if Path::new(name).extension().is_none() && !name.contains(['/', '\\']) => {
            ShapeError::UnknownName { nearest: nearest(name, BUILT_IN), name: file, known: known_extensions() }
        }
        error => unreadable(file, error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_misspelt_name_gets_the_nearest_built_in_one() {
        for (wrong, right) in [
            ("shpere", "sphere"),
            ("Teapot ", "teapot"),
            ("dodeca", "dodecahedron"),
            ("tea", "teapot"),
            ("qube", "cube"),
        ] {
            let error = open(wrong).unwrap_err();
            assert!(
                matches!(error, ShapeError::UnknownName { nearest: Some(near), .. } if near == right),
                "{wrong}: {error}"
            );
        }
        let far = open("x").unwrap_err().to_string();
        assert!(far.starts_with("no built-in object and no file is called `x`; built in: sphere"), "{far}");
        let message = open("shpere").unwrap_err().to_string();
        assert!(
            message.contains("sphere, cube, torus")
                && message.contains(
                    ".nrrd, .nhdr, .mhd, .mha, .gltf, .glb, .dcm, .vdb, .nii, .nii.gz, .hdr, .hdr.gz, .raw, .3mf, .ply, .stl, .obj"
                ),
            "{message}"
        );
    }

    #[test]
    fn missing_files_directories_and_empty_files_are_told_apart() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name).to_str().unwrap().to_owned();
        std::fs::write(path("empty.obj"), b"").unwrap();
        assert!(matches!(open(&path("none.obj")), Err(ShapeError::Missing { .. })));
        assert!(matches!(open("none.stl"), Err(ShapeError::Missing { .. })));
        assert!(matches!(open(&path("empty.obj")), Err(ShapeError::Empty { .. })));
        assert!(matches!(open(&path("")), Err(ShapeError::NotAFile { kind: "a directory", .. })));
    }

    #[cfg(target_os = "linux")]
    #[test]
    fn a_device_is_refused_before_it_is_opened() {
        assert!(matches!(open("/dev/zero"), Err(ShapeError::NotAFile { .. })));
    }

    #[test]
    fn content_decides_before_the_extension() {
        let stl =
            b"solid s\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n\
            endsolid s\n";
        assert!(matches!(read("wrong.obj", stl), Ok(Shape::Mesh(_))));
        assert!(matches!(read("no_extension", stl), Ok(Shape::Mesh(_))));
    }

    #[test]
    fn an_unknown_format_shows_the_first_bytes_and_known_formats() {
        let message = read("duck.blend", b"BLENDER-v300rest").unwrap_err().to_string();
        assert!(message.contains("BLENDER") && message.contains(".obj"), "{message}");
        assert_eq!(message.lines().count(), 1);
    }

    #[test]
    fn a_name_with_line_breaks_gives_a_message_of_one_line() {
        assert_eq!(open("a\nb").unwrap_err().to_string().lines().count(), 1);
        assert_eq!(open("a\u{85}b\n.obj").unwrap_err().to_string().lines().count(), 1);
    }
}
