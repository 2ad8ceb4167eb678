//! Typed access to the fields of a scene: tables, maps and values.
//!
//! Role: `settings!` implements [`Node`] for each table, so that fields are found, read, set, compared and checked without
//! text. Only a value by its name is text of a scene file.

use super::kind::{ChangeSet, Changes, Kind, Setting};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::fmt::Debug;
use toml::Value;

/// A table, a map or a value of a scene.
pub trait Node: Sized {
    /// Identity of a field below this node; `()` for a value.
    type Id: Clone + Debug + Ord;

    /// The field with a name relative to this node; a value has an empty one.
    fn find(name: &str) -> Option<Self::Id>;

    /// Appends the name of a field to that of this node.
    fn write_name(id: &Self::Id, name: &mut String);

    /// The setting of a field.
    fn setting(id: &Self::Id) -> Option<&'static Setting>;

    /// Calls `on` with each field that has a value.
    fn each(&self, on: &mut dyn FnMut(Self::Id));

    /// The value of a field.
    fn get(&self, id: &Self::Id) -> Option<Value>;

    /// Sets a field; `None` restores its default or removes it. `default` makes that of a value.
    ///
    /// # Errors
    /// The field does not take the value; it keeps the present one.
    fn set(&mut self, id: &Self::Id, value: Option<&Value>, default: fn() -> Self) -> Result<(), toml::de::Error>;

    /// Sets a field to what a track has at a time; `setting` is that of a value. Returns whether the field takes it.
    fn animate(&mut self, id: &Self::Id, moment: Moment<'_>, setting: Option<&Setting>) -> bool;

    /// Stages of the renderer that the differences from another node concern; `setting` is that of a value.
    fn changes(&self, other: &Self, setting: Option<&Setting>) -> ChangeSet;

    /// Whether all values are allowed by their settings; `setting` is that of a value.
    fn is_valid(&self, setting: Option<&Setting>) -> bool;
}

/// Numbers of a track at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Moment<'a> {
    /// A number.
    Number(f64),
    /// A list of numbers.
    Numbers(&'a [f64]),
    /// A color in linear light.
    Color([f64; 3]),
}

/// The type of a value of a scene.
pub trait Leaf: Clone + Debug + PartialEq + Serialize + DeserializeOwned {
    /// Stage that a change concerns where no setting says it.
    const CHANGES: Changes = Changes::Images;

    /// Whether there is a value.
    fn is_set(&self) -> bool {
        true
    }

    /// Whether a setting of this kind allows the value.
    fn is_allowed(&self, _: &Kind) -> bool {
        true
    }

    /// The value of a track at a time, if the type has such a value.
    fn at(_: Moment<'_>) -> Option<Self> {
        None
    }
}

impl<T: Leaf> Node for T {
    type Id = ();

    fn find(name: &str) -> Option<()> {
        name.is_empty().then_some(())
    }

    fn write_name((): &(), _: &mut String) {}

    fn setting((): &()) -> Option<&'static Setting> {
        None
    }

    fn each(&self, on: &mut dyn FnMut(())) {
        if self.is_set() {
            on(());
        }
    }

    fn get(&self, (): &()) -> Option<Value> {
        Value::try_from(self).ok() // an unset value has none
    }

    fn set(&mut self, (): &(), value: Option<&Value>, default: fn() -> T) -> Result<(), toml::de::Error> {
        *self = value.map_or_else(|| Ok(default()), |value| value.clone().try_into())?;
        Ok(())
    }

    fn animate(&mut self, (): &(), moment: Moment<'_>, setting: Option<&Setting>) -> bool {
        let Some(value) = T::at(moment).filter(|value| value.is_valid(setting)) else { return false };
        *self = value;
        true
    }

    fn changes(&self, other: &T, setting: Option<&Setting>) -> ChangeSet {
        if self == other {
            ChangeSet::default()
        } else {
            ChangeSet::of(&[setting.map_or(T::CHANGES, |setting| setting.changes)])
        }
    }

    fn is_valid(&self, setting: Option<&Setting>) -> bool {
        setting.is_none_or(|setting| self.is_allowed(&setting.kind))
    }
}

/// Values by name, such as parameters.
impl<T: Leaf> Node for BTreeMap<String, T> {
    type Id = String;

    fn find(name: &str) -> Option<String> {
        (!name.is_empty() && !name.contains('.')).then(|| name.into())
    }

    fn write_name(id: &String, name: &mut String) {
        push_name(name, id);
    }

    fn setting(_: &String) -> Option<&'static Setting> {
        None
    }

    fn each(&self, on: &mut dyn FnMut(String)) {
        self.keys().cloned().for_each(on);
    }

    fn get(&self, id: &String) -> Option<Value> {
        Node::get(BTreeMap::get(self, id)?, &())
    }

    fn set(&mut self, id: &String, value: Option<&Value>, _: fn() -> Self) -> Result<(), toml::de::Error> {
        match value {
            Some(value) => drop(self.insert(id.clone(), value.clone().try_into()?)),
            None => drop(self.remove(id)),
        }
        Ok(())
    }

    fn animate(&mut self, id: &String, moment: Moment<'_>, _: Option<&Setting>) -> bool {
        T::at(moment).map(|value| self.insert(id.clone(), value)).is_some()
    }

    fn changes(&self, other: &Self, _: Option<&Setting>) -> ChangeSet {
        if self == other { ChangeSet::default() } else { ChangeSet::of(&[T::CHANGES]) }
    }

    fn is_valid(&self, _: Option<&Setting>) -> bool {
        true // their modules declare what they take
    }
}

/// Appends a name to that of its table.
pub(crate) fn push_name(name: &mut String, below: &str) {
    if !name.is_empty() {
        name.push('.');
    }
    name.push_str(below);
}

/// The only element, if there is one.
pub(crate) const fn only(settings: &[Setting]) -> Option<Setting> {
    match settings {
        [setting] => Some(*setting),
        _ => None,
    }
}

/// The setting of a field whose changes are declared.
pub(crate) const fn of(setting: Option<Setting>, _: Changes) -> Setting {
    setting.expect("a field with changes is a setting")
}

/// Whether a number is in the range of a setting; NaN never is.
fn is_in_range(kind: &Kind, number: f32) -> bool {
    match kind {
        Kind::Number(range) | Kind::Whole(range) | Kind::Numbers(_, range) | Kind::Wholes(_, range) => {
            (range.low..=range.high).contains(&number)
        }
        Kind::OneOf(numbers) => numbers.iter().any(|&own| own as f32 == number),
        _ => true,
    }
}

impl Leaf for bool {}
impl Leaf for String {}
impl Leaf for Vec<String> {}

impl Leaf for f32 {
    fn is_allowed(&self, kind: &Kind) -> bool {
        is_in_range(kind, *self)
    }

    fn at(moment: Moment<'_>) -> Option<f32> {
        if let Moment::Number(number) = moment { Some(number as f32) } else { None }
    }
}

impl Leaf for f64 {
    fn is_allowed(&self, kind: &Kind) -> bool {
        is_in_range(kind, *self as f32)
    }

    fn at(moment: Moment<'_>) -> Option<f64> {
        if let Moment::Number(number) = moment { Some(number) } else { None }
    }
}

impl Leaf for u32 {
    fn is_allowed(&self, kind: &Kind) -> bool {
        is_in_range(kind, *self as f32)
    }

    fn at(moment: Moment<'_>) -> Option<u32> {
        let Moment::Number(number) = moment else { return None };
        let whole = number.round();
        (0.0..=f64::from(u32::MAX)).contains(&whole).then_some(whole as u32)
    }
}

impl<T: Leaf + Copy + Default, const COUNT: usize> Leaf for [T; COUNT]
where
    [T; COUNT]: Serialize + DeserializeOwned,
{
    fn is_allowed(&self, kind: &Kind) -> bool {
        self.iter().all(|number| number.is_allowed(kind))
    }

    fn at(moment: Moment<'_>) -> Option<[T; COUNT]> {
        let Moment::Numbers(numbers) = moment else { return None };
        let numbers = <[f64; COUNT]>::try_from(numbers).ok()?;
        let mut values = [T::default(); COUNT];
        for (value, number) in values.iter_mut().zip(numbers) {
            *value = T::at(Moment::Number(number))?;
        }
        Some(values)
    }
}

impl<T: Leaf> Leaf for Option<T> {
    fn is_set(&self) -> bool {
        self.is_some()
    }

    fn is_allowed(&self, kind: &Kind) -> bool {
        self.as_ref().is_none_or(|value| value.is_allowed(kind))
    }

    fn at(moment: Moment<'_>) -> Option<Option<T>> {
        T::at(moment).map(Some)
    }
}
