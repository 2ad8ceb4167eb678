//! Scenes: everything that determines a picture.
//!
//! Role: a readable description, merged from a preset, a file and the command line. Invariant: after [`Scene::check`] every
//! value is finite and in its range, and every module and parameter exists. A scene knows no GPU.

mod animation;
mod axis;
mod camera;
mod color;
mod effect;
mod error;
mod fields;
mod lens;
mod light;
mod modules;
mod object;
mod parameters;
mod part;
mod preset_texts;
mod presets;
mod quality;
mod rules;
mod transfer;

pub(crate) use animation::Looped;
pub use animation::{Animation, AnimationField, Ease, Key, Track, is_movable};
pub use axis::Axis;
pub use camera::{Camera, CameraField, Projection};
pub use color::{Color, linear_to_srgb, srgb_to_linear};
pub use effect::{Effect, EffectField, RayPath};
pub use error::SceneError;
pub use fields::Length;
#[cfg(feature = "window")]
pub use fields::MAX_BYTES;
pub use fields::{
    Boolean, FieldId, Material, MaterialField, ParameterValue, Picture, PictureField, Scene, load, load_given,
    option_text, parse, parse_value, schema, to_text, value_text,
};
pub use light::{Light, LightField, LightMethod};
pub use object::{FORMULAS, FieldEncoding, FileUnit, GLSL, Object, ObjectField, Storage};
pub use parameters::{LOOP_SECONDS, Parameters, Spread};
pub use part::{Part, PartField, Transform, TransformField};
pub use preset_texts::names;
pub use presets::{EFFECTS, nearest_preset, preset};
pub use quality::{
    BlockFormat, EmptySpace, Filter, Integration, Jitter, Order, Pass, Proxy, Quality, QualityField, ShaderStage,
    TargetFormat, Wrap,
};
pub(crate) use rules::SHADOW_SAMPLES;
pub use rules::{Reach, Repeat};
pub use transfer::{Curve, Stop, Transfer, TransferField};
