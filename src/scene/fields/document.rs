//! A scene and its small tables.

use super::setting::{Changes, Leaf, Moment, choices, settings};
use crate::scene::{Animation, Camera, Color, Effect, Light, Object, Part, Quality, Transfer};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

settings! {
    /// Everything that determines a picture.
    pub struct Scene: FieldId = "" {
        /// The preset that the scene starts from; the fields of the file override it.
        #[serde(skip_serializing_if = "Option::is_none")]
        preset: Option<String> = None => Picture, Kind::Text, optional("lit");
        /// A description of the scene, one sentence.
        about: String = String::new() => View, Kind::Text;
        /// The object.
        object: Object = Object::default();
        /// The modules of the effect.
        effect: Effect = Effect::default();
        /// Custom modules: `slot/name` and the file of each.
        #[serde(skip_serializing_if = "BTreeMap::is_empty")]
        modules: BTreeMap<String, String> = BTreeMap::new();
        /// Parameters of the modules, by name.
        parameters: BTreeMap<String, ParameterValue> = BTreeMap::new();
        /// Lengths with a unit, such as `1.2mm`, by field with `/` for `.`, until the size of the object is known.
        #[serde(skip_serializing_if = "BTreeMap::is_empty")]
        lengths: BTreeMap<String, String> = BTreeMap::new();
        /// Reflection of the hard surface.
        material: Material = Material::default();
        /// Color and opacity by density.
        transfer: Transfer = Transfer::default();
        /// The light.
        light: Light = Light::default();
        /// The camera.
        camera: Camera = Camera::default();
        /// The picture.
        image: Picture = Picture::default();
        /// Motion of settings over time.
        #[serde(skip_serializing_if = "Animation::is_empty")]
        animation: Animation = Animation::default();
        /// Accuracy against time.
        quality: Quality = Quality::default();
        /// Additional objects, by name.
        #[serde(skip_serializing_if = "BTreeMap::is_empty")]
        parts: BTreeMap<String, Part> = BTreeMap::new();
        /// The groom of the object: a file by `groom` or the window, with what is painted on it.
        #[serde(skip_serializing_if = "Option::is_none")]
        groom: Option<String> = None => Picture, Kind::Text, optional("groom.nrrd"), flag("groom");
        /// Formula that combines the objects, such as main - hole; main is the object of the scene. By default their union.
        #[serde(skip_serializing_if = "Option::is_none")]
        combine: Option<String> = None => Images, Kind::Text, optional("main");
        /// Meaning of the operators in that formula.
        boolean: Boolean = Boolean::Algebraic => Images, Kind::Choice(Boolean::CHOICES);
    }
}

choices! {
    /// Meaning of the operators in the formula of the objects.
    pub enum Boolean {
        /// Products (PH 2.2), with fillets as wide as the soft regions.
        #[default]
        Algebraic = "algebraic",
        /// Minimum and maximum, with creases.
        Minmax = "minmax",
    }
}

impl Leaf for ParameterValue {
    const CHANGES: Changes = Changes::Picture;

    fn at(moment: Moment<'_>) -> Option<ParameterValue> {
        match moment {
            Moment::Number(number) => Some(ParameterValue::Number(number as f32)),
            Moment::Color(_) => Color::at(moment).map(ParameterValue::Color),
            Moment::Numbers(_) => None,
        }
    }
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

settings! {
    /// Reflection of the hard surface.
    pub struct Material: MaterialField = "material." {
        /// Color of the hard surface.
        color: Color = Color([201, 190, 172]) => Picture, Kind::Color;
        /// Strength of the highlight.
        specular: f32 = 0.25 => Picture, number(0.0, 10.0), usual(0.0, 1.0);
        /// Exponent of the highlight; higher is sharper.
        specular_power: f32 = 40.0 => Picture, number(1.0, 1000.0);
    }
}

settings! {
    /// The picture.
    pub struct Picture: PictureField = "image." {
        /// Width and height in pixels.
        size: [u32; 2] = [512, 512] => Size, wholes(2, 1.0, 16384.0), flag("size"), unit(Unit::Pixels);
        /// Background color; transparent by default.
        background: Option<Color> = None => View, Kind::Color, optional("#20242c"), flag("background");
    }
}
