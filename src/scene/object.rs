//! The object of a scene, and the storage of its distance field.

use super::Axis;
use super::fields::schema::Changes;
use super::fields::setting::{Node, choices, settings};
use crate::shape;

settings! {
    /// The object of a scene.
    pub struct Object: ObjectField = "object." {
        /// A built-in name (sphere, cube, torus, teapot, knot, ...), or the path of a mesh, a scalar volume or a distance field.
        input: String = "teapot".into() => Field, Kind::Text;
        /// The grid of an OpenVDB file with several. By default density, else the first level set or fog volume.
        #[serde(skip_serializing_if = "Option::is_none")]
        grid: Option<String> = None => Field, Kind::Text, optional("density"), flag("grid");
        /// Voxels along the longest side of the distance field.
        resolution: u32 = 192 => Field, whole(8.0, 1024.0), flag("resolution");
        /// Iso-value of the surface of a scalar volume. By default the lowest that info proposes; --iso 500,1300 also sets those of aligned objects.
        iso: Option<f32> = None => Field, Kind::Number(Range::ANY), optional("0.5"), flag("iso");
        /// Thickness of the shell around the surface, half of it to each side, object units; 0 is solid.
        shell: f32 = 0.0 => Field, number(0.0, 2.0), flag("shell"), unit(Unit::ObjectUnits);
        /// The axis of the file that points up.
        up: Axis = Axis::Y => Field, Kind::Choice(Axis::CHOICES), flag("up");
        /// The unit of the coordinates of the file, for prints; pictures do not depend on it.
        unit: FileUnit = FileUnit::File => View, Kind::Choice(FileUnit::CHOICES), flag("unit");
        /// Longest side of the object when it is printed, millimeters; 0 is that of the file in its unit.
        scale_to: f32 = 0.0 => View, number(0.0, 1e6), usual(0.0, 200.0), flag("scale-to"), unit(Unit::Millimeters);
        /// Stretch factors along x, y and z of object space.
        stretch: [f32; 3] = [1.0; 3] => Images, numbers(3, 0.05, 20.0), usual(0.05, 4.0), flag("stretch");
        /// Whether a volume holds signed distances, positive outside, although its file does not say so.
        distance: bool = false => Field, Kind::Switch, flag_alone("distance", "true");
        /// Signed distance at which the object starts, object units; the longest side of the object is 2.
        inner_iso: f32 = 0.0 => Images, number(-2.0, 2.0), unit(Unit::ObjectUnits);
        /// Signed distance at which the soft region starts, object units; a parameter of the effect takes precedence.
        outer_iso: f32 = 0.15 => Images, number(-2.0, 2.0), unit(Unit::ObjectUnits);
        /// Encoding of the distance field.
        field_encoding: FieldEncoding = FieldEncoding::Auto
            => Field, Kind::Choice(FieldEncoding::CHOICES), flag("field-encoding");
        /// Part of a volume that is in device memory.
        storage: Storage = Storage::Dense => Field, Kind::Choice(Storage::CHOICES);
    }
}

choices! {
    /// The unit of the coordinates of a file.
    pub enum FileUnit {
        /// That of the file; millimeters if it has none.
        #[default]
        File = "file",
        /// Micrometers.
        Micron = "um",
        /// Millimeters.
        Millimeter = "mm",
        /// Centimeters.
        Centimeter = "cm",
        /// Inches.
        Inch = "in",
        /// Feet.
        Foot = "ft",
        /// Meters.
        Meter = "m",
    }
}

impl FileUnit {
    /// The unit; `None` for that of the file.
    pub fn unit(self) -> Option<shape::Unit> {
        shape::Unit::named(self.name())
    }
}

choices! {
    /// Encoding of the distance field of an object (MJ 3.1).
    #[non_exhaustive]
    pub enum FieldEncoding {
        /// The formula of an object that has one; else a volume with normals if the effect reads them, without otherwise.
        #[default]
        Auto = "auto",
        /// A volume of normals and distances, 4 x 16 bits.
        Normals16 = "normals16",
        /// A volume of normals and distances, 4 x 8 bits.
        Normals8 = "normals8",
        /// A volume of distances, 16 bits; normals by central differences.
        Distance16 = "distance16",
        /// A volume of distances, 32-bit floats; normals by central differences.
        Distance32 = "distance32",
    }
}

choices! {
    /// Part of a volume that is in device memory (GG 39.6). Sparse storage supports no anisotropic filter.
    #[non_exhaustive]
    pub enum Storage {
        /// The whole volume.
        #[default]
        Dense = "dense",
        /// Bricks of 8 x 8 x 8 cells that touch the surface or the soft region: the same picture, less memory, slower lookups.
        Sparse = "sparse",
    }
}

/// Built-in objects with a formula in `glsl/object`, which need no volume.
pub const FORMULAS: [&str; 3] = ["sphere", "cube", "torus"];

/// Prefix of an input that names a custom module of slot `object`. Its surface must lie within the cube from -1 to 1.
pub const GLSL: &str = "glsl:";

impl Object {
    /// Whether the object is a formula, without a volume.
    pub fn is_formula(&self) -> bool {
        self.formula().is_some()
    }

    /// Module of slot `object` for the object; `None` for a volume.
    pub fn formula(&self) -> Option<&str> {
        // A grid of a built-in object is refused where the object is opened.
        let is_plain = self.field_encoding == FieldEncoding::Auto && self.shell == 0.0 && self.grid.is_none();
        let shipped = FORMULAS.contains(&self.input.as_str()).then_some(self.input.as_str());
        self.input.strip_prefix(GLSL).or(shipped).filter(|_| is_plain)
    }

    /// The object with the settings that determine its field; the others have their defaults.
    pub fn without_look(&self) -> Object {
        let mut own = self.clone();
        self.each(&mut |id| {
            if Object::setting(&id).is_none_or(|setting| setting.changes != Changes::Field) {
                own.set(&id, None, Object::default).expect("every field of an object has a default");
            }
        });
        own
    }
}
