//! Slots, and the modules chosen for them.

use std::collections::{BTreeMap, BTreeSet};

/// Modules by slot: one name, any number in order of application for a stack (`warp`, `dmf`), one per layer for `medium`. A DMF
/// may be `module@mask`. The slot of an additional object is `object.slot`. [`FORMULA`] holds the formula of the objects,
/// [`FOLDED`] the parameters folded to 0.
pub type Slots = BTreeMap<String, Vec<String>>;

/// Name of the scene's main object in formulas.
pub const MAIN: &str = "main";
/// Slot of the generated uniform block of all parameters.
pub(crate) const PARAMETERS: &str = "parameters";
/// Slot of the generated classification of several objects.
pub(crate) const OBJECTS: &str = "objects";
/// Key in [`Slots`] of the formula that combines the objects.
pub const FORMULA: &str = "combine";
/// Key in [`Slots`] of the names folded to 0: parameters and members of the block in `part.glsl`, as `object.name` for additional
/// objects. They become constants, so that the compiler drops their terms.
pub const FOLDED: &str = "zero";
/// File of the resources that each object has for itself.
pub const PART: &str = "part.glsl";
/// Slot of the masks, which limit where a DMF acts.
pub const MASK: &str = "mask";
/// Slot of the groom.
pub const GROOM: &str = "groom";
/// Slot of the strength of warps and DMFs.
pub const AMOUNT: &str = "amount";
/// Slot of the wind.
pub const WIND: &str = "wind";
/// Slots that a choice may leave out; they then have the module [`NONE`], which adds no line to a program.
pub(crate) const OPTIONAL: [&str; 3] = [GROOM, AMOUNT, WIND];
/// Module of an optional slot without effect.
pub const NONE: &str = "none";
/// Slot that colors soft matter.
pub const MEDIUM: &str = "medium";
/// Functions of a medium: its color, and optionally its extinction relative to the scene's rate.
pub(crate) const MEDIUM_FUNCTIONS: [&str; 2] = [MEDIUM, "extinction"];
/// Entry file of each of several objects.
pub(crate) const OBJECT_ENTRY: &str = "one_of_several.glsl";

/// Names of the additional objects of a scene.
pub fn objects(choice: &Slots) -> BTreeSet<&str> {
    choice.keys().filter_map(|key| key.split_once('.')).map(|(object, _)| object).collect()
}

/// A name in [`FOLDED`].
pub fn qualified(object: &str, name: &str) -> String {
    if object.is_empty() { name.into() } else { format!("{object}.{name}") }
}
