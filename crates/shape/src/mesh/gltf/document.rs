//! JSON of a glTF file.
//!
//! Role: the part of the schema that describes surfaces. Invariant: references are not checked here; memory is a small multiple
//! of the text.

use crate::error::{Location, ShapeError, quoted, shown};
use crate::source::Source;
use hypertexture_support::open::MARK;
use serde::Deserialize;
use serde::de::{Deserializer, Error, IgnoredAny, SeqAccess, Visitor};
use serde_json::error::Category;
use std::borrow::Cow;
use std::fmt;
use std::marker::PhantomData;

/// Most entries of a list: an entry in memory is up to 30 times as long as its text.
const MAX_ENTRIES: usize = 1 << 20;
/// Prefix of the error of a longer list.
const TOO_MANY: &str = "too many";
/// Characters shown before an error in the text.
const SHOWN: usize = 32;

/// Root of the file.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Document<'a> {
    pub asset: Asset,
    #[serde(default, deserialize_with = "list")]
    pub extensions_required: Vec<String>,
    #[serde(default)]
    pub animations: Vec<IgnoredAny>,
    pub scene: Option<u32>,
    #[serde(default, deserialize_with = "list")]
    pub scenes: Vec<Scene>,
    #[serde(default, deserialize_with = "list")]
    pub nodes: Vec<Node>,
    #[serde(default, deserialize_with = "list")]
    pub meshes: Vec<Mesh>,
    #[serde(default, deserialize_with = "list")]
    pub materials: Vec<Material>,
    #[serde(default, deserialize_with = "list")]
    pub accessors: Vec<Accessor>,
    #[serde(default, deserialize_with = "list")]
    pub buffer_views: Vec<View>,
    #[serde(borrow, default, deserialize_with = "list")]
    pub buffers: Vec<Buffer<'a>>,
}

impl Document<'_> {
    /// Whether the material of a primitive cuts parts of it away.
    pub(crate) fn is_masked(&self, primitive: &Primitive) -> bool {
        let material = primitive.material.and_then(|index| self.materials.get(index as usize));
        material.is_some_and(|material| material.alpha_mode.as_deref() == Some("MASK"))
    }
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Asset {
    pub version: String,
    pub min_version: Option<String>,
}

#[derive(Deserialize)]
pub struct Scene {
    #[serde(default)]
    pub nodes: Vec<u32>,
}

#[derive(Deserialize)]
pub struct Node {
    #[serde(default)]
    pub children: Vec<u32>,
    pub mesh: Option<u32>,
    pub skin: Option<u32>,
    pub matrix: Option<Box<[f64; 16]>>,
    pub translation: Option<Box<[f64; 3]>>,
    pub rotation: Option<Box<[f64; 4]>>,
    pub scale: Option<Box<[f64; 3]>>,
    #[serde(default)]
    pub extensions: Extensions,
}

#[derive(Deserialize)]
pub struct Mesh {
    /// Empty if the file has none, which counts only for a mesh that is used.
    #[serde(default, deserialize_with = "list")]
    pub primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
pub struct Primitive {
    pub attributes: Attributes,
    pub indices: Option<u32>,
    pub mode: Option<u32>,
    material: Option<u32>,
    pub targets: Option<Vec<IgnoredAny>>,
    #[serde(default)]
    pub extensions: Extensions,
}

/// The part of a material that belongs to the geometry.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Material {
    alpha_mode: Option<String>,
}

#[derive(Deserialize)]
pub(crate) struct Attributes {
    #[serde(rename = "POSITION")]
    pub position: Option<u32>,
    #[serde(rename = "COLOR_0")]
    pub color: Option<u32>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct Accessor {
    pub buffer_view: Option<u32>,
    #[serde(default)]
    pub byte_offset: u64,
    pub component_type: u32,
    #[serde(default)]
    pub normalized: bool,
    pub count: u64,
    #[serde(rename = "type")]
    pub kind: String,
    pub sparse: Option<Box<Sparse>>,
}

#[derive(Deserialize)]
pub struct Sparse {
    pub count: u64,
    pub indices: SparsePart,
    pub values: SparsePart,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub(crate) struct SparsePart {
    pub buffer_view: u32,
    #[serde(default)]
    pub byte_offset: u64,
    /// Of indices only.
    pub component_type: Option<u32>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct View {
    pub buffer: u32,
    #[serde(default)]
    pub byte_offset: u64,
    pub byte_length: u64,
    pub byte_stride: Option<u64>,
    #[serde(default)]
    pub extensions: Extensions,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Buffer<'a> {
    #[serde(borrow)]
    pub uri: Option<Text<'a>>,
    pub byte_length: u64,
}

/// Text borrowed from the file, unless it has escapes.
#[derive(Deserialize)]
pub struct Text<'a>(#[serde(borrow)] pub Cow<'a, str>);

/// Extensions with geometry.
#[derive(Default, Deserialize)]
pub struct Extensions {
    #[serde(rename = "KHR_draco_mesh_compression")]
    draco: Option<IgnoredAny>,
    #[serde(rename = "KHR_meshopt_compression")]
    meshopt: Option<IgnoredAny>,
    #[serde(rename = "EXT_meshopt_compression")]
    older_meshopt: Option<IgnoredAny>,
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    instancing: Option<IgnoredAny>,
    #[serde(rename = "KHR_node_visibility")]
    visibility: Option<Visibility>,
}

#[derive(Deserialize)]
struct Visibility {
    visible: Option<bool>,
}

impl Extensions {
    /// Known extensions with geometry that are not supported.
    const GEOMETRY: [&str; 4] =
        ["KHR_draco_mesh_compression", "KHR_meshopt_compression", "EXT_meshopt_compression", "EXT_mesh_gpu_instancing"];
    /// Prefixes of harmless required extensions: supported ones, and those that change only the appearance or describe things.
    const HARMLESS: [&str; 19] = [
        "KHR_mesh_quantization",
        "KHR_node_visibility",
        "KHR_materials_",
        "KHR_texture_",
        "KHR_lights_",
        "EXT_texture_",
        "MSFT_texture_",
        "EXT_lights_",
        "EXT_mesh_features",
        "EXT_instance_features",
        "EXT_structural_metadata",
        "EXT_mesh_primitive_edge_visibility",
        "CESIUM_primitive_outline",
        "KHR_xmp",
        "KHR_animation_pointer",
        "KHR_audio",
        "KHR_interactivity",
        "KHR_physics_",
        "KHR_node_selectability",
    ];

    /// Whether the node and its descendants are hidden.
    pub fn hides(&self) -> bool {
        self.visibility.as_ref().is_some_and(|visibility| visibility.visible == Some(false))
    }

    /// Checks that no unsupported extension defines the geometry at `place`. One that is not required is passed over where the file
    /// `has_plain` data too.
    pub fn check(
        &self,
        (source, document): (&Source, &Document),
        has_plain: bool,
        place: impl FnOnce() -> String,
    ) -> Result<(), ShapeError> {
        let names = [
            (self.draco, "KHR_draco_mesh_compression"),
            (self.meshopt, "KHR_meshopt_compression"),
            (self.older_meshopt, "EXT_meshopt_compression"),
            (self.instancing, "EXT_mesh_gpu_instancing"),
        ];
        match names.into_iter().find(|(used, _)| used.is_some()) {
            Some((_, name)) if has_plain && !document.extensions_required.iter().any(|own| own == name) => {
                source.note(format!("{} is optional: the plain data beside it is read", quoted(name.as_bytes())));
                Ok(())
            }
            Some((_, name)) => Err(unread(source, place() + ".extensions", name)),
            None => Ok(()),
        }
    }

    /// Checks that no required extension may change the geometry: an unknown one may not occur in the file beyond its list.
    pub(crate) fn check_required(source: &Source, json: &[u8], required: &[String]) -> Result<(), ShapeError> {
        let is_harmless = |name: &str| Extensions::HARMLESS.iter().any(|start| name.starts_with(start));
        for (index, name) in required.iter().enumerate().filter(|(_, name)| !is_harmless(name)) {
            if Extensions::GEOMETRY.contains(&name.as_str()) || is_key(json, name) {
                return Err(unread(source, format!("extensionsRequired[{index}]"), name));
            }
            source.note(format!(
                "the required extension {} is unknown, and nothing in the file uses it",
                quoted(name.as_bytes())
            ));
        }
        Ok(())
    }
}

/// Whether a text is a key of an object in JSON, or may be one: with escapes it is not looked for.
fn is_key(json: &[u8], name: &str) -> bool {
    let quoted = format!("\"{name}\"");
    let is_followed = |at: usize| json[at + quoted.len()..].trim_ascii_start().starts_with(b":");
    let mut places = json.windows(quoted.len()).enumerate().filter(|(_, window)| *window == quoted.as_bytes());
    json.contains(&b'\\') || places.any(|(at, _)| is_followed(at))
}

fn unread(source: &Source, place: String, name: &str) -> ShapeError {
    let remedy = if name.ends_with("_compression") {
        "export it without compression, or unpack it first (`gltf-transform copy in.glb out.glb`)"
    } else {
        "export it without this extension"
    };
    unsupported(source, place, "the extension", quoted(name.as_bytes()), remedy)
}

/// Unsupported value at a place in the JSON.
pub fn unsupported(
    source: &Source,
    place: String,
    what: &'static str,
    found: String,
    remedy: &'static str,
) -> ShapeError {
    source.unsupported(Location::Json(place), what, found, remedy)
}

/// Invalid value at a place in the JSON.
pub fn malformed(source: &Source, place: String, expected: &'static str, found: impl fmt::Display) -> ShapeError {
    source.malformed_at(Location::Json(place), expected, found.to_string())
}

/// Entry `index` of a list; `place` names the reference to it.
pub fn entry<'b, T>(
    source: &Source,
    list: &'b [T],
    index: u32,
    place: impl FnOnce() -> String,
) -> Result<&'b T, ShapeError> {
    let missing = || {
        let found = format!("{index} of {}, counted from 0", list.len());
        malformed(source, place(), "the index of an existing entry", found)
    };
    list.get(index as usize).ok_or_else(missing)
}

/// The part of the JSON that `T` describes.
pub(crate) fn json_as<'a, T: Deserialize<'a>>(source: &Source, json: &'a [u8]) -> Result<T, ShapeError> {
    let json = json.strip_prefix(MARK).unwrap_or(json); // some GLB files have a mark
    let end = json.iter().rposition(|byte| *byte != 0).map_or(0, |last| last + 1);
    let json = &json[..end]; // and some are padded with zeros
    serde_json::from_slice(json).map_err(|error| refusal::<T>(source, json, &error))
}

/// Parses and checks the JSON.
pub fn parse<'a>(source: &Source, json: &'a [u8]) -> Result<Document<'a>, ShapeError> {
    let document: Document = json_as(source, json)?;
    for (version, name) in
        [(Some(&document.asset.version), "version"), (document.asset.min_version.as_ref(), "minVersion")]
    {
        let Some(version) = version else { continue };
        // Minor versions only add optional parts, unless `minVersion` names one.
        if !version.starts_with("2.") || name == "minVersion" && version != "2.0" {
            let (found, remedy) = (quoted(version.as_bytes()), "export it as glTF 2.0");
            return Err(unsupported(source, format!("asset.{name}"), "version", found, remedy));
        }
    }
    Extensions::check_required(source, json, &document.extensions_required)?;
    Ok(document)
}

/// Error of the JSON parser in terms of glTF.
fn refusal<'a, T: Deserialize<'a>>(source: &Source, json: &'a [u8], error: &serde_json::Error) -> ShapeError {
    let message = error.to_string();
    let line = json.split(|byte| *byte == b'\n').nth(error.line().saturating_sub(1)).unwrap_or_default();
    let read = &line[..error.column().min(line.len())];
    let read = quoted(&read[read.len().saturating_sub(SHOWN)..]).replace("\\\"", "\""); // JSON has many quotes
    let found = format!("{read} up to line {}, column {}", error.line(), error.column());
    match error.classify() {
        Category::Data if message.starts_with(TOO_MANY) => {
            let found = format!("more than {MAX_ENTRIES}");
            source.too_large("entries in a list of the JSON", found, MAX_ENTRIES as u64)
        }
        Category::Data => {
            let path = serde_path_to_error::deserialize::<_, T>(&mut serde_json::Deserializer::from_slice(json));
            let path = path.err().map(|error| shown(&error.path().to_string())).filter(|path| path != ".");
            let place = path.map_or(Location::Header, Location::Json);
            let missing = message.strip_prefix("missing field ").and_then(|rest| rest.split_whitespace().next());
            let found = missing.map_or(found, |name| format!("no {name}"));
            source.malformed_at(place, "a value of the glTF 2.0 schema", found)
        }
        Category::Eof => source.malformed_at(Location::Line(error.line() as u64), "more JSON", "its end".into()),
        _ => source.malformed_at(Location::Line(error.line() as u64), "JSON", found),
    }
}

/// Deserializes a list of at most [`MAX_ENTRIES`].
pub fn list<'de, D: Deserializer<'de>, T: Deserialize<'de>>(from: D) -> Result<Vec<T>, D::Error> {
    struct Entries<T>(PhantomData<T>);
    impl<'de, T: Deserialize<'de>> Visitor<'de> for Entries<T> {
        type Value = Vec<T>;

        fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
            f.write_str("a list")
        }

        fn visit_seq<A: SeqAccess<'de>>(self, mut from: A) -> Result<Vec<T>, A::Error> {
            let mut entries = Vec::new();
            while let Some(entry) = from.next_element()? {
                if entries.len() == MAX_ENTRIES {
                    return Err(A::Error::custom(TOO_MANY));
                }
                entries.push(entry);
            }
            Ok(entries)
        }
    }
    from.deserialize_seq(Entries(PhantomData))
}
