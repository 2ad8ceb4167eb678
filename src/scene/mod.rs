//! Scenes: everything that decides what a picture shows.
//!
//! Role: a readable description, from a preset, a file and the command line, one over the other. Invariant: after
//! [`Scene::check`] every value is finite and in its range, every module and parameter exists. A scene knows no GPU.

mod axis;
mod check;
mod color;
mod command;
mod effect;
mod error;
mod field;
mod file;
mod header;
mod lens;
mod light;
mod loops;
mod modules;
mod parameters;
mod part;
mod preset_texts;
mod presets;
mod quality;
mod reach;
pub mod schema;
mod strategy;
mod transfer;

pub use axis::Axis;
pub use color::{Color, linear_to_srgb, srgb_to_linear};
pub use effect::{Effect, RayPath};
pub use error::SceneError;
pub use field::parse_value;
#[cfg(feature = "window")]
pub use file::MAX_BYTES;
pub use file::{load, parse, to_text};
pub use light::{Light, LightMethod};
pub(crate) use loops::SHADOW_SAMPLES;
pub use parameters::{Parameters, Spread};
pub use part::{Boolean, Part, Transform};
pub use preset_texts::names;
pub use presets::{EFFECTS, nearest_preset, preset};
pub use quality::{
    BlockFormat, EmptySpace, Filter, Integration, Jitter, Neutral, Order, Pass, Proxy, Quality, Reject, TargetFormat,
    Wrap,
};
pub use reach::Reach;
pub use strategy::Repeat;
pub use transfer::{Curve, Stop, Transfer};

use crate::shader::{Library, Slots};
use header::header;
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
    /// Custom modules: `slot/name` and the file that holds it.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub modules: BTreeMap<String, String>,
    /// Parameters of those modules, by name.
    pub parameters: BTreeMap<String, ParameterValue>,
    /// Reflection of the hard surface.
    pub material: Material,
    /// Color and opacity by density.
    pub transfer: Transfer,
    /// The light.
    pub light: Light,
    /// The camera.
    pub camera: Camera,
    /// The picture.
    pub image: Picture,
    /// Accuracy against time.
    pub quality: Quality,
    /// Further objects, by name.
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub parts: BTreeMap<String, Part>,
    /// The formula by which the objects make one, such as `main - hole`; `main` is the scene's own. Without one, the
    /// union of all.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub combine: Option<String>,
    /// What the signs of that formula mean.
    pub boolean: Boolean,
}

/// The object of a scene.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Object {
    /// A built-in name, or the path of a mesh, a scalar volume or a distance field.
    pub input: String,
    /// The grid of an OpenVDB file that is the object; without one `density`, or the first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub grid: Option<String>,
    /// Voxels along the longest side of the distance field, 8 to 1024.
    pub resolution: u32,
    /// Iso-value of the surface of a scalar volume; without one, the lowest that `info` proposes.
    pub iso: Option<f32>,
    /// Thickness of the shell that the surface is made into, object units; 0: what it encloses is solid.
    pub shell: f32,
    /// The axis of the file that points up: `x`, `y`, `z`, or `-x`, `-y`, `-z`.
    pub up: Axis,
    /// Factors along x, y and z of object space by which the object is stretched before it is drawn, 0.05 to 20.
    pub stretch: [f32; 3],
    /// Whether a volume holds signed distances, positive outside, although its file does not say so.
    pub distance: bool,
    /// Signed distance at which the object starts, object units (the longest side of the object is 2).
    pub inner_iso: f32,
    /// Signed distance at which the soft region starts, object units; the effect's own parameter goes before it.
    pub outer_iso: f32,
    /// Where the distance comes from.
    pub source: Source,
    /// Which part of a volume is on the device.
    pub storage: Storage,
}

impl std::default::Default for Object {
    fn default() -> Object {
        Object {
            input: "teapot".into(),
            grid: None,
            resolution: 192,
            iso: None,
            shell: 0.0,
            up: Axis::Y,
            stretch: [1.0; 3],
            distance: false,
            inner_iso: 0.0,
            outer_iso: 0.15,
            source: Source::Auto,
            storage: Storage::Dense,
        }
    }
}

/// Built-in objects that are a formula in `glsl/object` and need no volume.
pub const FORMULAS: [&str; 3] = ["sphere", "cube", "torus"];

/// How the input of an object begins that is a module of slot `object` of one's own; the name of the module follows. The
/// surface that it gives must be within the cube from -1 to 1 on each axis.
pub const GLSL: &str = "glsl:";

impl Object {
    /// Whether the object is a formula, so that there is no volume of it.
    pub fn is_formula(&self) -> bool {
        self.formula().is_some()
    }

    /// The module of slot `object` that the object is; `None` where it needs a volume.
    pub fn formula(&self) -> Option<&str> {
        // A grid of what is no file is refused where it is opened.
        let is_plain = self.source == Source::Auto && self.shell == 0.0 && self.grid.is_none();
        let shipped = FORMULAS.contains(&self.input.as_str()).then_some(self.input.as_str());
        self.input.strip_prefix(GLSL).or(shipped).filter(|_| is_plain)
    }

    /// The object without what a picture does with its field: where two are equal then, they have one field.
    pub fn without_look(&self) -> Object {
        let mut fields = toml::Table::try_from(self).expect("an object holds nothing that TOML cannot hold");
        fields.retain(|field, _| {
            schema::setting(&format!("object.{field}")).is_some_and(|setting| setting.changes == schema::Changes::Field)
        });
        fields.try_into().expect("every field of an object has a default")
    }
}

/// Where the distance to the object comes from, and how it is stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
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

/// Which part of a volume is on the device.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Storage {
    /// All of it.
    #[default]
    Dense,
    /// Bricks of 8 x 8 x 8 cells that the surface or its soft region touches, and a bound of the distance for the others
    /// (GG 39.6): the same picture, with less memory and slower lookups, which no anisotropic filter reaches.
    Sparse,
}

/// The value of a parameter in a scene file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum ParameterValue {
    /// A number.
    Number(f32),
    /// A color, `#rrggbb` in sRGB.
    Color(Color),
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

/// The camera.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Camera {
    /// Parallel or perspective.
    pub projection: Projection,
    /// Degrees around the vertical axis of the object: 0 looks at its +z side, 90 at its +x side.
    pub azimuth: f32,
    /// Degrees above the horizon, -90 to 90.
    pub elevation: f32,
    /// The turn from object space to that of the camera, a unit quaternion x, y, z, w, in place of azimuth and elevation:
    /// what a free trackball leaves behind.
    pub rotation: Option<[f32; 4]>,
    /// How far the picture is moved to the right and up, object units at the middle of the scene: a shift of the lens.
    pub pan: [f32; 2],
    /// 1 fits the object into the picture; 2 is twice as close.
    pub zoom: f32,
    /// Vertical angle of view in degrees, perspective only.
    pub field_of_view: f32,
    /// Time in seconds, for effects that move.
    pub time: f64,
    /// Seconds that the shutter stays open from `time` on; needs several samples of the time: `quality.supersampling`.
    pub shutter: f32,
    /// Keeps the points x, y, z (object space) with `a x + b y + c z <= d`.
    pub clip: Option<[f32; 4]>,
    /// Shows the stack of slices from the side (MJ Fig. 1).
    pub slice_stack: bool,
    /// A view and a projection matrix, column by column: see [`Camera::look_through`].
    pub matrices: Option<[f32; 32]>,
}

impl std::default::Default for Camera {
    fn default() -> Camera {
        Camera {
            projection: Projection::Perspective,
            azimuth: 30.0,
            elevation: 25.0,
            rotation: None,
            pan: [0.0; 2],
            zoom: 1.0,
            field_of_view: 30.0,
            time: 0.0,
            shutter: 0.0,
            clip: None,
            slice_stack: false,
            matrices: None,
        }
    }
}

impl Camera {
    /// The turn from object space to that of the camera: the rotation, or azimuth around the object's vertical axis and then
    /// elevation.
    pub fn turn(&self) -> glam::Quat {
        match self.rotation {
            Some(rotation) => glam::Quat::from_array(rotation).normalize(),
            None => {
                let elevation = glam::Quat::from_rotation_x(self.elevation.to_radians());
                elevation * glam::Quat::from_rotation_y(-(self.azimuth % 360.0).to_radians())
            }
        }
    }
}

/// How rays leave the camera.
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

impl Scene {
    /// The entry files of the scene's program in the folder `glsl`: vertex stage, fragment stage.
    pub fn entries(&self) -> [&'static str; 2] {
        match (self.quality.pass, self.effect.ray_path) {
            (Pass::Slices, _) => ["slice.vert", "slice.frag"],
            (Pass::March, RayPath::Straight) => ["march.vert", "march.frag"],
            (Pass::March, RayPath::Refracted) => ["march.vert", "refract.frag"],
        }
    }

    /// The module of slot `project`.
    fn project(&self) -> &str {
        match self.effect.project.as_str() {
            "auto" if self.object.is_formula() => "formula",
            "auto" => "closest",
            module => module,
        }
    }

    /// The module of `library` that the scene chooses for each slot but `object`, which depends on what the input is.
    pub fn slots(&self, library: &Library) -> Slots {
        let effect = &self.effect;
        let mut slots = Slots::new();
        let mut fill = |slot: &str, modules: Vec<String>| {
            slots.insert(slot.to_string(), modules);
        };
        for (slot, module) in effect.modules() {
            fill(slot, vec![module.clone()]);
        }
        let segments = match self.quality.integration {
            Integration::Segment => header(library, "classify", &effect.classify).segments,
            Integration::Point => None,
        };
        fill("classify", vec![segments.unwrap_or_else(|| effect.classify.clone())]);
        fill("project", vec![self.project().into()]);
        fill("medium", effect.medium.split('+').map(|name| name.trim().to_string()).collect());
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
        let reject = match self.quality.reject {
            Reject::Discard => "discard",
            Reject::Keep => "keep",
        };
        fill("projection", vec![projection.into()]);
        fill("proxy", vec![proxy.into()]);
        fill("reject", vec![reject.into()]);
        let half_angle = self.is_half_angle();
        let shadow = match self.light.shadows {
            true if half_angle => "half_angle",
            true => "volume",
            false => "none",
        };
        fill("shadow", vec![shadow.into()]);
        fill("planes", vec![if half_angle { "half_angle" } else { "facing" }.into()]);
        fill("scatter", vec![if self.light.translucency > 0.0 { "cone" } else { "none" }.into()]);
        fill("clip", vec![if self.camera.clip.is_some() { "plane" } else { "none" }.into()]);
        let storage = match self.object.storage {
            Storage::Sparse => "sparse",
            Storage::Dense if self.quality.anisotropy > 1.0 => "anisotropic",
            Storage::Dense => "dense",
        };
        let empty_space = match self.quality.empty_space {
            EmptySpace::Skip if !self.is_empty_outside(library) || effect.index != "transfer" => "sample",
            // A target of unorm cannot say that a device has cut the loops of a ray.
            EmptySpace::Skip if self.quality.target == TargetFormat::Unorm8 && !self.may_find_first(library) => "leap",
            EmptySpace::Skip => "skip",
            EmptySpace::Sample => "sample",
        };
        fill("empty_space", vec![empty_space.into()]);
        let has_cells = empty_space != "sample" && self.is_plain() && self.has_cells(library);
        fill("cells", vec![if has_cells { "grid" } else { "none" }.into()]);
        let jitter = match self.quality.jitter {
            Jitter::None => "none",
            Jitter::Hash => "hash",
            Jitter::Blue => "blue",
        };
        fill("jitter", vec![jitter.into()]);
        let jumps = effect.index == "transfer" && self.transfer.curve == Curve::Steps;
        fill("ray_path", vec![if jumps { "straight" } else { "curved" }.into()]);
        let wrap = match self.quality.wrap {
            Wrap::Repeat => "repeat",
            Wrap::Mirror => "mirror",
        };
        fill("wrap", vec![wrap.into()]);
        let filter = match self.quality.filter {
            Filter::Device => "device",
            Filter::Exact => "exact",
        };
        fill("filter", vec![filter.into()]);
        fill("storage", vec![storage.into()]);
        let is_flat = self.quality.neutral == Neutral::LeaveOut && self.transfer.is_flat();
        fill("transfer", vec![if is_flat { "flat" } else { "map" }.into()]);
        let sampling = match self.quality.msaa {
            _ if self.camera.slice_stack => "stack",
            1 => "pixel",
            _ => "sample",
        };
        fill("sampling", vec![sampling.into()]);
        if self.has_several() {
            self.fill_parts(library, &mut slots);
        }
        slots
    }
}
