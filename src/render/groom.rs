//! Channels of a groom from expressions in GLSL.

use crate::eval::{ExactError, Inputs, Invocations, Program};
use crate::shader::Slots;
use crate::shader::compile::{CompileError, Fault, Job, Limits, compile};
use crate::shape::Groom;
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::path::Path;

/// Voxels in a batch of a thread.
const BATCH: usize = 4096;
/// Entry file of the channels.
const ENTRY: &str = "groom/entry.glsl";

/// A painted channel.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Channel {
    /// A factor of the length, 0 to 2.
    Length,
    /// A factor of the density, 0 to 2.
    Density,
    /// Red, green and blue, 0 to 2 each.
    Color,
    /// A tangent, -1 to 1 along each axis.
    Direction,
}

impl Channel {
    /// All channels.
    pub const ALL: [Channel; 4] = [Channel::Length, Channel::Density, Channel::Color, Channel::Direction];

    /// Name, as in `// @groom` of a module.
    pub fn name(self) -> &'static str {
        ["length", "density", "color", "direction"][self as usize]
    }

    /// Its first channel in a [`Groom`], and their number.
    pub fn place(self) -> (usize, usize) {
        [(0, 1), (1, 1), (2, 3), (5, 3)][self as usize]
    }
}

/// Why an expression gives no channel.
#[derive(Debug, thiserror::Error)]
pub enum GroomError {
    /// More than an expression.
    #[error("{0} is a statement; write an expression of x, y, z and p, such as \"y > 0.2 ? 0.3 : 1.0\"")]
    Statement(String),
    /// The compiler refuses it.
    #[error("{0}")]
    Compile(#[from] CompileError),
    /// It cannot be evaluated.
    #[error("it cannot be evaluated: {0}")]
    Exact(#[from] ExactError),
    /// Not a number somewhere.
    #[error("{value} at {}, {}, {}; keep it finite", .place[0], .place[1], .place[2])]
    NotFinite {
        /// The value.
        value: f64,
        /// The place, object space.
        place: [f32; 3],
    },
}

/// Fills a channel of a groom with an expression of the place `p`, which is `x`, `y` and `z` of object space.
/// `program` is the executable of hypertexture, which compiles it in a child process.
///
/// Values beyond the limits of the channel are cut to them. Returns the least and the greatest value where skin may be.
///
/// # Errors
/// The expression is not one, or its value is somewhere not finite.
pub fn fill_channel(program: &Path, groom: &mut Groom, channel: Channel, text: &str) -> Result<[f64; 2], GroomError> {
    if text.contains([';', '{', '}', '#']) {
        return Err(GroomError::Statement(text.into()));
    }
    let (first, count) = channel.place();
    let kind = if count == 1 { "float" } else { "vec3" };
    let source = format!(
        "#version 450\nlayout(location = 0) in vec4 place;\nlayout(location = 0) out vec4 value;\n\
         {kind} painted(vec3 p, float x, float y, float z) {{\n    return {kind}(\n{text}\n    );\n}}\n\
         void main() {{ value = vec4(painted(place.xyz, place.x, place.y, place.z){}); }}\n",
        if count == 1 { ", 0.0, 0.0, 0.0" } else { ", 0.0" }
    );
    let changed = BTreeMap::from([(ENTRY.to_string(), source)]);
    let entries = ["march.vert", ENTRY].map(String::from);
    let job = Job { changed, entries, slots: Slots::new(), is_optimized: true };
    let compiled = compile(program, &job, &Limits::default(), &|| false).map_err(|error| match error {
        CompileError::Refused(text) => {
            let first = Fault::all(&text).into_iter().next().map_or(text, |fault| fault.text);
            CompileError::Refused(first.trim_start_matches("error: ").trim_start_matches("'' :").trim().into())
        }
        other => other,
    });
    let [_, code] = compiled?;
    let (code, inputs) = (Program::read(&code, &[])?, Inputs::default());
    let bound = code.bind(&inputs)?;
    let indices: Vec<usize> = (0..groom.voxels()).collect();
    let of_batch = |indices: &[usize]| -> Result<Vec<[f64; 4]>, GroomError> {
        let place = |index: &usize| groom.place(*index).extend(0.0).to_array().map(f64::from);
        let places: Vec<[f64; 4]> = indices.iter().map(place).collect();
        let coordinates = vec![[0.0; 4]; indices.len()];
        let lanes = Invocations { fragment_coordinates: coordinates, varyings: [(0, places)].into() };
        Ok(bound.run::<f64>(&lanes)?.remove(&0).unwrap_or_default())
    };
    let values = indices.par_chunks(BATCH).map(of_batch).collect::<Result<Vec<_>, _>>()?.concat();
    let mut found = [f64::INFINITY, f64::NEG_INFINITY];
    for (index, value) in values.iter().enumerate() {
        if let Some(value) = value.iter().find(|value| !value.is_finite()) {
            return Err(GroomError::NotFinite { value: *value, place: groom.place(index).to_array() });
        }
        let mut voxel = groom.at(index);
        voxel[first..][..count].iter_mut().zip(value).for_each(|(own, value)| *own = *value as f32);
        if groom.may_hold_skin(index) {
            found =
                value[..count].iter().fold(found, |[least, greatest], value| [least.min(*value), greatest.max(*value)]);
        }
        groom.set(index, voxel);
    }
    Ok(found)
}
