//! Scenes: everything that determines a picture.
//!
//! Role: a readable description, merged from a preset, a file and the command line. Invariant: after [`Scene::check`] every
//! value is finite and in its range, and every module and parameter exists. A scene knows no GPU.

mod animation;
mod axis;
mod camera;
mod check;
mod color;
mod command;
mod document;
mod effect;
mod error;
mod field;
mod file;
mod header;
mod lens;
mod light;
mod loops;
mod modules;
mod object;
mod parameters;
mod part;
mod preset_texts;
mod presets;
mod quality;
mod reach;
pub mod schema;
mod setting;
mod slots;
mod strategy;
mod transfer;

pub(crate) use animation::Looped;
pub use animation::{Animation, AnimationField, Ease, Key, Track, is_movable};
pub use axis::Axis;
pub use camera::{Camera, CameraField, Projection};
pub use color::{Color, linear_to_srgb, srgb_to_linear};
pub use command::{option_text, value_text};
pub use document::{Boolean, FieldId, Material, MaterialField, ParameterValue, Picture, PictureField, Scene};
pub use effect::{Effect, EffectField, RayPath};
pub use error::SceneError;
pub use field::parse_value;
#[cfg(feature = "window")]
pub use file::MAX_BYTES;
pub use file::{load, load_given, parse, to_text};
pub use light::{Light, LightField, LightMethod};
pub(crate) use loops::SHADOW_SAMPLES;
pub use object::{FORMULAS, FieldEncoding, GLSL, Object, ObjectField, Storage};
pub use parameters::{LOOP_SECONDS, Parameters, Spread};
pub use part::{Part, PartField, Transform, TransformField};
pub use preset_texts::names;
pub use presets::{EFFECTS, nearest_preset, preset};
pub use quality::{
    BlockFormat, EmptySpace, Filter, Integration, Jitter, Order, Pass, Proxy, Quality, QualityField, ShaderStage,
    TargetFormat, Wrap,
};
pub use reach::Reach;
pub use strategy::Repeat;
pub use transfer::{Curve, Stop, Transfer, TransferField};
