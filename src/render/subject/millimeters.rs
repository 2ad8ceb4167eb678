//! Size of a printed object, and the lengths of a scene in its units.

use super::Subject;
use crate::render::error::RenderError;
use crate::render::variant::VariantError;
use crate::scene::{FileUnit, Object, Scene};
use crate::shape::{BUILT_IN, MEMORY, Unit};
use glam::Vec3;

/// Size of the units of an object when it is printed; pictures do not depend on it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Millimeters {
    /// Millimeters in one object unit.
    pub per_object_unit: f64,
    /// Millimeters in one world unit.
    pub per_world_unit: f64,
    /// Where they come from.
    pub from: UnitOrigin,
}

/// Where the size of a printed object comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnitOrigin {
    /// `object.scale_to`.
    ScaleTo,
    /// `object.unit`.
    Setting(Unit),
    /// The file.
    File(Unit),
    /// The file has no unit; millimeters, as slicers take it.
    Assumed,
}

impl UnitOrigin {
    /// The unit of world coordinates and its origin, in words.
    pub fn words(self) -> String {
        match self {
            UnitOrigin::ScaleTo => "by --scale-to".into(),
            UnitOrigin::Setting(unit) => format!("units are {} by --unit", unit.symbol()),
            UnitOrigin::File(unit) => format!("the unit of the file is {}", unit.symbol()),
            UnitOrigin::Assumed => "the file has no unit: taken as mm; --unit or --scale-to changes it".into(),
        }
    }
}

/// Unit of the coordinates of an object by its setting, its file, or by default; `None` for a built-in one.
fn unit(object: &Object, of_file: Option<Unit>) -> Option<UnitOrigin> {
    let is_file = !object.is_formula() && !BUILT_IN.contains(&&*object.input) && !object.input.starts_with(MEMORY);
    let own = match object.unit {
        FileUnit::File => of_file.map(UnitOrigin::File),
        set => set.unit().map(UnitOrigin::Setting),
    };
    own.or(is_file.then_some(UnitOrigin::Assumed))
}

impl Subject {
    /// Size of the units of the object when it is printed; `None` for an object without a unit or `object.scale_to`.
    pub fn millimeters(&self, object: &Object) -> Option<Millimeters> {
        let scale = f64::from(self.scale);
        if object.scale_to > 0.0 {
            let longest = 2.0 * (self.half_size * Vec3::from(object.stretch)).max_element();
            let per_object_unit = f64::from(object.scale_to) / f64::from(longest);
            return Some(Millimeters {
                per_object_unit,
                per_world_unit: per_object_unit * scale,
                from: UnitOrigin::ScaleTo,
            });
        }
        let from = unit(object, self.unit)?;
        let per_world_unit = match from {
            UnitOrigin::Setting(unit) | UnitOrigin::File(unit) => unit.millimeters(),
            _ => 1.0,
        };
        Some(Millimeters { per_object_unit: per_world_unit / scale, per_world_unit, from })
    }
}

/// Sets the fields of a scene whose values are lengths with a unit, such as `1.2mm`, in the units of its object, which is loaded
/// for it.
///
/// # Errors
/// Those of [`Subject::load`] and [`Scene::set_lengths`], and an object without a unit.
pub fn settle_lengths(scene: &mut Scene) -> Result<(), RenderError> {
    let Some((name, text)) = scene.lengths.first_key_value() else { return Ok(()) };
    let (name, text) = (name.replace('/', "."), text.clone());
    let object = &scene.object;
    let subject = Subject::load_with_margin(object, object.outer_iso, false, &|_| ())?;
    let Some(size) = subject.millimeters(object) else {
        return Err(RenderError::NoUnit { name, text, object: object.input.clone() });
    };
    let settled = scene.library().and_then(|library| scene.set_lengths(&library, size.per_object_unit));
    Ok(settled.map_err(VariantError::from)?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::preset;

    fn settled(fields: &[(&str, &str)]) -> Result<Scene, String> {
        let mut scene = preset("noisy_sphere").map_err(|error| error.to_string())?;
        fields.iter().try_for_each(|(name, value)| scene.set_field(name, value)).map_err(|error| error.to_string())?;
        settle_lengths(&mut scene).map_err(|error| error.to_string())?;
        Ok(scene)
    }

    #[test]
    fn a_length_is_measured_by_the_longest_side() {
        let amplitude = |stretch: &str| {
            let fields = [("object.scale_to", "60mm"), ("object.stretch", stretch), ("parameters.amplitude", "1.2mm")];
            settled(&fields).unwrap().value_named("parameters.amplitude").unwrap().as_float().unwrap() as f32
        };
        assert_eq!((amplitude("[1, 1, 1]"), amplitude("[1, 2, 1]")), (0.04, 0.08));
        let error = settled(&[("parameters.amplitude", "1.2mm")]).unwrap_err();
        assert_eq!(
            error,
            "parameters.amplitude = 1.2mm: sphere has no unit; give its longest side, such as --scale-to 60mm"
        );
    }

    #[test]
    fn the_unit_is_that_of_the_setting_before_the_file() {
        let subject =
            Subject { scale: 0.5, half_size: Vec3::new(1.0, 0.5, 0.25), unit: Some(Unit::Inch), ..Subject::default() };
        let size = |unit, scale_to| {
            let object = Object { input: "a.3mf".into(), unit, scale_to, ..Object::default() };
            let found = subject.millimeters(&object).unwrap();
            (found.per_world_unit, found.per_object_unit, found.from)
        };
        assert_eq!(size(FileUnit::File, 0.0), (25.4, 50.8, UnitOrigin::File(Unit::Inch)));
        assert_eq!(size(FileUnit::Centimeter, 0.0), (10.0, 20.0, UnitOrigin::Setting(Unit::Centimeter)));
        assert_eq!(size(FileUnit::Centimeter, 60.0), (15.0, 30.0, UnitOrigin::ScaleTo));
        let object = Object { input: "a.stl".into(), ..Object::default() };
        assert_eq!(
            Subject { scale: 1.0, ..Subject::default() }.millimeters(&object).unwrap().from,
            UnitOrigin::Assumed
        );
    }
}
