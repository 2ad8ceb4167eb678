//! Writer of 3MF.
//!
//! Invariant: equal contents give equal bytes. Sources: those of the reader.

use super::checked::{check, places};
use crate::shape::Mesh;
use crate::shape::looks::Looks;
use crate::unit::Unit;
use foldhash::{HashMap, HashMapExt};
use glam::DVec3;
use quick_xml::escape::escape;
use std::fmt::Display;
use std::io::{self, BufWriter, Write};
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, DateTime, ZipWriter};

/// Names of metadata that the specification knows; others get a prefix.
const KNOWN: [&str; 9] = [
    "Title",
    "Designer",
    "Description",
    "Copyright",
    "LicenseTerms",
    "Rating",
    "CreationDate",
    "ModificationDate",
    "Application",
];
const RELATIONSHIPS: &str = "http://schemas.openxmlformats.org/package/2006/relationships";

/// Bodies to be printed together.
#[derive(Clone, Copy, Debug, Default)]
pub struct PrintFile<'a> {
    /// Unit of the coordinates.
    pub unit: Unit,
    /// The bodies, each an item of the build.
    pub bodies: &'a [PrintBody<'a>],
    /// Keys and values, such as `Title`.
    pub metadata: &'a [(String, String)],
    /// A picture as PNG.
    pub thumbnail: Option<&'a [u8]>,
}

/// One body of a [`PrintFile`].
#[derive(Clone, Copy, Debug)]
pub struct PrintBody<'a> {
    /// Name, which slicers show; may be empty.
    pub name: &'a str,
    /// Its mesh.
    pub mesh: &'a Mesh,
    /// Colors of its vertices.
    pub looks: Option<&'a Looks>,
}

impl PrintFile<'_> {
    /// Writes the bodies, each with at least one triangle. [`open`](crate::open) reads coordinates back bit for bit, and colors as
    /// bytes of sRGB; a vertex has one color. Control characters in names become spaces.
    ///
    /// # Errors
    /// Errors of `to`, and `InvalidInput` without a body, or for one that [`MeshFormat`](super::MeshFormat) does not write.
    pub fn write(&self, mut to: impl Write) -> io::Result<()> {
        if self.bodies.is_empty() {
            return Err(io::Error::new(io::ErrorKind::InvalidInput, "a 3MF file needs a body"));
        }
        self.bodies.iter().try_for_each(|body| check(body.mesh, body.looks))?;
        let mut zip = ZipWriter::new(io::Cursor::new(Vec::new()));
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Deflated)
            .last_modified_time(DateTime::default());
        zip.start_file("[Content_Types].xml", options)?;
        write!(
            zip,
            "{HEAD}<Types xmlns=\"http://schemas.openxmlformats.org/package/2006/content-types\">\
             <Default Extension=\"rels\" ContentType=\"application/vnd.openxmlformats-package.relationships+xml\"/>\
             <Default Extension=\"model\" ContentType=\"application/vnd.ms-package.3dmanufacturing-3dmodel+xml\"/>\
             <Default Extension=\"png\" ContentType=\"image/png\"/></Types>"
        )?;
        zip.start_file("_rels/.rels", options)?;
        let picture = format!(
            "<Relationship Target=\"/Metadata/thumbnail.png\" Id=\"picture\" Type=\"{RELATIONSHIPS}/metadata/thumbnail\"/>"
        );
        write!(
            zip,
            "{HEAD}<Relationships xmlns=\"{RELATIONSHIPS}\"><Relationship Target=\"/3D/3dmodel.model\" Id=\"model\" \
             Type=\"http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel\"/>{}</Relationships>",
            if self.thumbnail.is_some() { &picture } else { "" }
        )?;
        zip.start_file("3D/3dmodel.model", options)?;
        let mut model = BufWriter::new(&mut zip);
        self.write_model(&mut model)?;
        model.flush()?;
        drop(model);
        if let Some(png) = self.thumbnail {
            zip.start_file("Metadata/thumbnail.png", options)?;
            zip.write_all(png)?;
        }
        to.write_all(zip.finish()?.get_ref())?;
        to.flush()
    }

    fn write_model(&self, to: &mut impl Write) -> io::Result<()> {
        writeln!(
            to,
            "{HEAD}<model unit=\"{}\" xml:lang=\"en-US\" \
             xmlns=\"http://schemas.microsoft.com/3dmanufacturing/core/2015/02\" \
             xmlns:m=\"http://schemas.microsoft.com/3dmanufacturing/material/2015/02\" \
             xmlns:h=\"https://github.com/hypertexture/hypertexture\">",
            self.unit.name()
        )?;
        for (key, value) in self.metadata {
            let prefix = if KNOWN.contains(&key.as_str()) { "" } else { "h:" };
            writeln!(to, "<metadata name=\"{prefix}{}\">{}</metadata>", plain(key), plain(value))?;
        }
        writeln!(to, "<resources>")?;
        let ids = |index: usize| [2 * index + 1, 2 * index + 2];
        for (index, body) in self.bodies.iter().enumerate() {
            body.write_object(ids(index), to)?;
        }
        writeln!(to, "</resources>\n<build>")?;
        (0..self.bodies.len()).try_for_each(|index| writeln!(to, "<item objectid=\"{}\"/>", ids(index)[1]))?;
        writeln!(to, "</build>\n</model>")
    }
}

impl PrintBody<'_> {
    /// Writes the colors and the object, with an identity for each.
    fn write_object(&self, [group, own]: [usize; 2], to: &mut impl Write) -> io::Result<()> {
        let PrintBody { name, mesh, looks } = *self;
        let mut colors = Vec::new();
        if let Some(looks) = looks {
            let mut known = HashMap::new();
            writeln!(to, "<m:colorgroup id=\"{group}\">")?;
            for vertex in 0..looks.colors.len() {
                let color @ [red, green, blue] = looks.srgb(vertex).map(|channel| (255.0 * channel).round() as u8);
                let next = known.len();
                let index = *known.entry(color).or_insert(next);
                if index == next {
                    writeln!(to, "<m:color color=\"#{red:02X}{green:02X}{blue:02X}\"/>")?;
                }
                colors.push(index);
            }
            writeln!(to, "</m:colorgroup>")?;
        }
        write!(to, "<object id=\"{own}\" type=\"model\"")?;
        if !name.is_empty() {
            write!(to, " name=\"{}\"", plain(name))?;
        }
        if looks.is_some() {
            write!(to, " pid=\"{group}\" pindex=\"0\"")?;
        }
        writeln!(to, "><mesh>\n<vertices>")?;
        let mut vertex = |[x, y, z]: [&dyn Display; 3]| writeln!(to, "<vertex x=\"{x}\" y=\"{y}\" z=\"{z}\"/>");
        if mesh.offset == DVec3::ZERO {
            mesh.positions.iter().try_for_each(|place| vertex([&place.x, &place.y, &place.z]))?;
        } else {
            places(mesh).try_for_each(|place| vertex([&place.x, &place.y, &place.z]))?;
        }
        writeln!(to, "</vertices>\n<triangles>")?;
        for corners @ [a, b, c] in &mesh.triangles {
            write!(to, "<triangle v1=\"{a}\" v2=\"{b}\" v3=\"{c}\"")?;
            if !colors.is_empty() {
                let [a, b, c] = corners.map(|corner| colors[corner as usize]);
                write!(to, " pid=\"{group}\" p1=\"{a}\"")?;
                if (a, a) != (b, c) {
                    write!(to, " p2=\"{b}\" p3=\"{c}\"")?;
                }
            }
            writeln!(to, "/>")?;
        }
        writeln!(to, "</triangles>\n</mesh></object>")
    }
}

/// The first line of each part.
const HEAD: &str = "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n";

/// A text in XML.
fn plain(text: &str) -> String {
    let text = text.replace(|letter: char| letter.is_control() || matches!(letter, '\u{fffe}' | '\u{ffff}'), " ");
    escape(text).into_owned()
}
