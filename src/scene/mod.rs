//! Scenes: everything that decides what a picture shows.
//!
//! Role: a readable description, from a preset, a file and the command line, one over the other. Invariant: after
//! [`Scene::check`] every value is finite and in its range, every module and knob exists. A scene knows no GPU.

mod check;
mod file;
mod presets;

pub(crate) use check::ENTRIES;
pub use check::Knobs;
pub use file::{load, parse, to_text};
pub use presets::{EFFECTS, names, preset};

use crate::glsl::Slots;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A picture to be made.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Scene {
    /// The preset that the scene starts from; what the file says goes over it.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub preset: Option<String>,
    /// One sentence about the scene.
    pub about: String,
    /// The object.
    pub object: Object,
    /// The modules that make the effect.
    pub effect: Effect,
    /// Parameters of those modules, by name.
    pub knobs: BTreeMap<String, KnobValue>,
    /// Reflection of the hard surface.
    pub material: Material,
    /// Color and opacity by density.
    pub transfer: Transfer,
    /// The light.
    pub light: Light,
    /// The eye.
    pub camera: Camera,
    /// The picture.
    pub image: Picture,
    /// Accuracy against time.
    pub quality: Quality,
}

/// The object of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Object {
    /// A built-in name, or the path of a mesh, a scalar volume or a distance field.
    pub input: String,
    /// Voxels along the longest side of the distance field, 8 to 1024.
    pub resolution: u32,
    /// Iso-value of the surface of a scalar volume; without one, the middle of its range.
    pub iso: Option<f32>,
    /// The axis of the file that points up: `x`, `y`, `z`, or `-x`, `-y`, `-z`.
    pub up: Axis,
    /// Whether a volume holds signed distances, positive outside, although its file does not say so.
    pub distance: bool,
    /// Signed distance at which the object starts, object units (the longest side of the object is 2).
    pub inner_iso: f32,
    /// Signed distance at which the soft region starts, object units; the effect's own knob goes before it.
    pub outer_iso: f32,
    /// Where the distance comes from.
    pub source: Source,
}

impl std::default::Default for Object {
    fn default() -> Object {
        Object {
            input: "teapot".into(),
            resolution: 192,
            iso: None,
            up: Axis::Y,
            distance: false,
            inner_iso: 0.0,
            outer_iso: 0.15,
            source: Source::Auto,
        }
    }
}

/// A direction along an axis.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Axis {
    /// +x.
    X,
    /// +y.
    #[default]
    Y,
    /// +z.
    Z,
    /// -x.
    #[serde(rename = "-x")]
    MinusX,
    /// -y.
    #[serde(rename = "-y")]
    MinusY,
    /// -z.
    #[serde(rename = "-z")]
    MinusZ,
}

impl Axis {
    /// For each axis of a space whose y axis is this direction: the axis it comes from, and whether it is reversed. The
    /// turn is a rotation, so that nothing is mirrored.
    pub fn turn(self) -> [(usize, bool); 3] {
        match self {
            Axis::Y => [(0, false), (1, false), (2, false)],
            Axis::MinusY => [(0, false), (1, true), (2, true)],
            Axis::Z => [(0, false), (2, false), (1, true)],
            Axis::MinusZ => [(0, false), (2, true), (1, false)],
            Axis::X => [(1, true), (0, false), (2, false)],
            Axis::MinusX => [(1, false), (0, true), (2, false)],
        }
    }
}

/// Where the distance to the object comes from, and how it is stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Source {
    /// A formula where the object has one, else a volume with normals if the effect reads them, else without.
    #[default]
    Auto,
    /// A volume: normal and distance, 4 x 16 bits (MJ 3.1).
    Normals16,
    /// A volume: normal and distance, 4 x 8 bits.
    Normals8,
    /// A volume: the distance alone, 16 bits; normals by central differences.
    Distance16,
    /// A volume: the distance alone, 32-bit float; normals by central differences.
    Distance32,
}

/// The modules of an effect: names of files in the folders of `glsl`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Effect {
    /// How a sample becomes a color: `surface`, `soft`, `post`, `pre`, `preintegrated`.
    pub classify: String,
    /// How the distance becomes a density: `hard`, `linear`, `quadratic`.
    pub softness: String,
    /// Displacements of the position, applied in this order.
    pub warp: Vec<String>,
    /// Density modulation functions, applied in this order.
    pub dmf: Vec<String>,
    /// Color of the hard region.
    pub surface: String,
    /// Color of the soft region.
    pub medium: String,
    /// Where noise comes from.
    pub noise: String,
    /// Where turbulence comes from.
    pub turbulence: String,
    /// How density becomes opacity: `perlin` or `beer`.
    pub opacity: String,
    /// c of PH 3.1, per object unit: how fast soft matter becomes opaque.
    pub opacity_rate: f32,
}

impl std::default::Default for Effect {
    fn default() -> Effect {
        Effect {
            classify: "surface".into(),
            softness: "hard".into(),
            warp: Vec::new(),
            dmf: Vec::new(),
            surface: "lit".into(),
            medium: "material".into(),
            noise: "block".into(),
            turbulence: "encoded".into(),
            opacity: "perlin".into(),
            opacity_rate: 40.0,
        }
    }
}

/// The value of a knob in a scene file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum KnobValue {
    /// A number.
    Number(f32),
    /// A color, `#rrggbb` in sRGB.
    Color(Color),
}

/// A color, written `#rrggbb` in sRGB.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Color(pub [u8; 3]);

impl Color {
    /// Linear RGB, each in [0, 1].
    pub fn linear(self) -> [f32; 3] {
        self.0.map(|code| srgb_to_linear(f32::from(code) / 255.0))
    }
}

impl TryFrom<String> for Color {
    type Error = String;
    fn try_from(text: String) -> Result<Color, String> {
        crate::glsl::library::hex_color(&text)
            .map(Color)
            .ok_or_else(|| format!("`{text}` is not a color; write #rrggbb, such as #d9a05f"))
    }
}

impl From<Color> for String {
    fn from(Color([r, g, b]): Color) -> String {
        format!("#{r:02x}{g:02x}{b:02x}")
    }
}

/// Decodes the sRGB curve (IEC 61966-2-1); both in [0, 1].
pub fn srgb_to_linear(code: f32) -> f32 {
    if code <= 0.04045 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

/// Encodes the sRGB curve (IEC 61966-2-1); both in [0, 1].
pub fn linear_to_srgb(linear: f32) -> f32 {
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Reflection of the hard surface.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Material {
    /// Color.
    pub color: Color,
    /// Strength of the highlight, 0 to 1.
    pub specular: f32,
    /// Sharpness of the highlight, 1 to 1000.
    pub specular_power: f32,
}

impl std::default::Default for Material {
    fn default() -> Material {
        Material { color: Color([201, 190, 172]), specular: 0.25, specular_power: 40.0 }
    }
}

/// The transfer map: color and opacity by density.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Transfer {
    /// What lies between two stops.
    pub curve: Curve,
    /// At least one stop, by rising density.
    pub stops: Vec<Stop>,
}

impl std::default::Default for Transfer {
    fn default() -> Transfer {
        let stop = |at, color| Stop { at, color: Color(color), density: at };
        Transfer { curve: Curve::Linear, stops: vec![stop(0.0, [0, 0, 0]), stop(1.0, [255, 255, 255])] }
    }
}

/// What lies between two stops of a transfer map.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Curve {
    /// The value of the lower stop.
    Steps,
    /// A straight line.
    #[default]
    Linear,
    /// A monotone cubic (Fritsch and Carlson 1980): smooth, and never beyond the stops.
    Spline,
}

/// One stop of a transfer map.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Stop {
    /// Density, 0 to 1.
    pub at: f32,
    /// Color there.
    pub color: Color,
    /// Density that the opacity is made of, 0 to 1; 1 is opaque.
    #[serde(default = "one")]
    pub density: f32,
}

fn one() -> f32 {
    1.0
}

/// A point light that moves with the eye (MJ 3.2).
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Light {
    /// Position from the center of the object: right, up, toward the eye; object units.
    pub position: [f32; 3],
    /// Color.
    pub color: Color,
    /// Brightness of the color.
    pub intensity: f32,
    /// Color of what comes from all sides.
    pub ambient: Color,
}

impl std::default::Default for Light {
    fn default() -> Light {
        Light { position: [-3.0, 4.0, 5.0], color: Color([255; 3]), intensity: 1.0, ambient: Color([76, 80, 90]) }
    }
}

/// The eye.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Camera {
    /// Parallel or perspective.
    pub projection: Projection,
    /// Degrees around the vertical axis of the object: 0 looks at its +z side, 90 at its +x side.
    pub azimuth: f32,
    /// Degrees above the horizon, -90 to 90.
    pub elevation: f32,
    /// 1 fits the object into the picture; 2 is twice as close.
    pub zoom: f32,
    /// Vertical angle of view in degrees, perspective only.
    pub field_of_view: f32,
    /// Time in seconds, for effects that move.
    pub time: f32,
    /// Keeps the points x, y, z (object space) with `a x + b y + c z <= d`.
    pub clip: Option<[f32; 4]>,
    /// Shows the stack of slices from the side (MJ Fig. 1).
    pub slice_stack: bool,
}

impl std::default::Default for Camera {
    fn default() -> Camera {
        Camera {
            projection: Projection::Perspective,
            azimuth: 30.0,
            elevation: 25.0,
            zoom: 1.0,
            field_of_view: 30.0,
            time: 0.0,
            clip: None,
            slice_stack: false,
        }
    }
}

/// How rays leave the eye.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Projection {
    /// Side by side.
    Parallel,
    /// From one point.
    #[default]
    Perspective,
}

/// The picture.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Picture {
    /// Width and height in pixels.
    pub size: [u32; 2],
    /// Color behind the object; none leaves it transparent.
    pub background: Option<Color>,
}

impl std::default::Default for Picture {
    fn default() -> Picture {
        Picture { size: [512, 512], background: None }
    }
}

/// Accuracy against time.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Quality {
    /// Slices through the sphere around the object.
    pub samples: u32,
    /// Format that the slices are blended in.
    pub target: TargetFormat,
    /// Order of the slices.
    pub order: Order,
    /// Shape of the slices.
    pub proxy: Proxy,
    /// Samples per pixel, each shaded: 1, 2, 4, 8.
    pub msaa: u32,
    /// Anisotropy of the texture filter, 1 (off) to 16.
    pub anisotropy: f32,
    /// Texels along a side of the noise and turbulence blocks.
    pub block_size: u32,
}

impl std::default::Default for Quality {
    fn default() -> Quality {
        Quality {
            samples: 256,
            target: TargetFormat::Float32,
            order: Order::FrontToBack,
            proxy: Proxy::Polygons,
            msaa: 1,
            anisotropy: 1.0,
            block_size: 64,
        }
    }
}

/// Format that the slices are blended in.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum TargetFormat {
    /// 8 bits: the paper's; loses thin matter.
    Unorm8,
    /// 16-bit float.
    Float16,
    /// 32-bit float.
    #[default]
    Float32,
}

/// Order of the slices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Order {
    /// Nearest first.
    #[default]
    FrontToBack,
    /// Farthest first.
    BackToFront,
}

/// Shape of the slices.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Proxy {
    /// Cut to the box around the soft region.
    #[default]
    Polygons,
    /// Quads that fit every rotation: the paper's.
    Quads,
}

impl Scene {
    /// The module that the scene chooses for each slot but `object`, which depends on what the input is.
    pub fn slots(&self) -> Slots {
        let effect = &self.effect;
        let mut slots = Slots::new();
        let mut fill = |slot: &str, modules: Vec<String>| {
            slots.insert(slot.to_string(), modules);
        };
        for (slot, module) in [
            ("classify", &effect.classify),
            ("softness", &effect.softness),
            ("surface", &effect.surface),
            ("medium", &effect.medium),
            ("noise", &effect.noise),
            ("turbulence", &effect.turbulence),
            ("opacity", &effect.opacity),
        ] {
            fill(slot, vec![module.clone()]);
        }
        fill("warp", effect.warp.clone());
        fill("dmf", effect.dmf.clone());
        let projection = match self.camera.projection {
            Projection::Parallel => "parallel",
            Projection::Perspective => "perspective",
        };
        let proxy = match self.quality.proxy {
            Proxy::Polygons => "polygons",
            Proxy::Quads => "quads",
        };
        fill("projection", vec![projection.into()]);
        fill("proxy", vec![proxy.into()]);
        fill("clip", vec![if self.camera.clip.is_some() { "plane" } else { "none" }.into()]);
        fill("sampling", vec![if self.quality.msaa > 1 { "sample" } else { "pixel" }.into()]);
        slots
    }
}

/// Why a scene cannot be made.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SceneError {
    /// A scene file cannot be read.
    #[error("{path}: {reason}")]
    Read {
        /// The file.
        path: String,
        /// What the system says.
        reason: String,
    },
    /// A scene file is not what a scene file must be.
    #[error("{path}:{line}: {reason}")]
    Syntax {
        /// The file.
        path: String,
        /// Line, from 1.
        line: usize,
        /// What is wrong, on one line.
        reason: String,
    },
    /// A value is out of its range.
    #[error("{field} = {value}: {limit}")]
    Value {
        /// The field, as in a scene file.
        field: String,
        /// The value found.
        value: String,
        /// What is allowed.
        limit: String,
    },
    /// A name is not known.
    #[error("no {kind} `{name}`{nearest}; choose one of: {known}")]
    Name {
        /// What was to be named.
        kind: String,
        /// The name found.
        name: String,
        /// The nearest known name, as a question.
        nearest: String,
        /// The known names.
        known: String,
    },
    /// A module is missing or its declarations are wrong.
    #[error(transparent)]
    Library(#[from] crate::glsl::LibraryError),
}

impl SceneError {
    /// A name that is not among `known`.
    pub fn unknown(kind: &str, name: &str, known: &[&str]) -> SceneError {
        let nearest = nearest(name, known).map(|near| format!(" (did you mean `{near}`?)")).unwrap_or_default();
        let known = if known.is_empty() { "nothing: this effect has none".into() } else { known.join(", ") };
        SceneError::Name { kind: kind.into(), name: name.into(), nearest, known }
    }
}

/// The most similar of `known`, if one is similar at all.
pub fn nearest<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    let scored = known.iter().map(|candidate| (strsim::jaro_winkler(name, candidate), *candidate));
    scored.filter(|(score, _)| *score > 0.7).max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, candidate)| candidate)
}
