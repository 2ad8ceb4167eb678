//! Channels of a groom from expressions in GLSL.

use super::subject::Subject;
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
    /// A factor of the effect of warps and DMFs, 0 to 2.
    Amount,
}

impl Channel {
    /// All channels.
    pub const ALL: [Channel; 5] =
        [Channel::Length, Channel::Density, Channel::Color, Channel::Direction, Channel::Amount];

    /// Name, as in `// @groom` of a module; all warps and DMFs read the amount.
    pub fn name(self) -> &'static str {
        ["length", "density", "color", "direction", "amount"][self as usize]
    }

    /// Its first channel in a [`Groom`], and their number.
    pub fn place(self) -> (usize, usize) {
        [(0, 1), (1, 1), (2, 3), (5, 3), (8, 1)][self as usize]
    }
}

/// Degrees over which the amount rises from 0 to 1 beside what lies flat.
const ANGLE_FADE: f32 = 15.0;

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

/// Multiplies the amount by 0 where the normal of the nearest surface is within `degrees` of up or down, the y axis, and by a
/// factor that rises evenly to 1 over another 15 degrees elsewhere.
///
/// Returns whether the object has normals, which a custom formula has not.
pub fn fade_flat(groom: &mut Groom, subject: &Subject, degrees: f32) -> bool {
    let Some(normal) = subject.normal() else { return false };
    for index in 0..groom.voxels() {
        let steep = normal(groom.place(index)).y.abs().min(1.0).acos().to_degrees();
        let part = ((steep - degrees) / ANGLE_FADE).clamp(0.0, 1.0);
        let (mut voxel, (first, _)) = (groom.at(index), Channel::Amount.place());
        voxel[first] *= part * part * (3.0 - 2.0 * part);
        groom.set(index, voxel);
    }
    true
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::camera::View;
    use crate::render::density::DensityProgram;
    use crate::render::variant::Variant;
    use crate::scene::{ParameterValue, Scene, preset};
    use crate::shader;
    use glam::{DVec3, Vec3};
    use hypertexture_support::random::SplitMix;
    use std::sync::Arc;

    /// Densities of a scene, with an even amount in its groom.
    fn densities(scene: &Scene, amount: Option<f32>, places: &[DVec3]) -> (Vec<f64>, Vec3) {
        let library = shader::shipped();
        let mut subject = Subject::load(scene, &library, &|_| ()).unwrap();
        let mut scene = scene.clone();
        if let Some(amount) = amount {
            let mut groom = Groom::unpainted(&scene.object.input, 32);
            let mut voxel = Groom::NEUTRAL;
            voxel[8] = amount;
            (0..groom.voxels()).for_each(|index| groom.set(index, voxel));
            (subject.groom, scene.groom) = (Some(Arc::new(groom)), Some("a.nrrd".into()));
        }
        let variant = Variant::of(&scene, &library).unwrap();
        let program = DensityProgram::of(&library, &variant, &subject).unwrap();
        let found = program.bound(0.0).unwrap().at(places).unwrap();
        (found, View::of(&variant, &subject).box_max)
    }

    fn places(count: usize, low: DVec3, high: DVec3) -> Vec<DVec3> {
        let mut random = SplitMix(7);
        (0..count).map(|_| low + (high - low) * DVec3::from_array(std::array::from_fn(|_| random.unit()))).collect()
    }

    /// The object without its effect; that of a DMF with a width of its own is its hard region.
    fn plain(scene: &Scene, places: &[DVec3]) -> Vec<f64> {
        let mut bare = scene.clone();
        (bare.effect.dmf, bare.effect.warp) = (Vec::new(), Vec::new());
        bare.effect.medium = "material".into();
        bare.parameters.clear();
        let found = densities(&bare, None, places).0;
        let has_width = scene.effect.dmf.iter().any(|dmf| ["fur", "fire"].contains(&dmf.as_str()));
        found.into_iter().map(|d| if has_width && d < 1.0 { 0.0 } else { d }).collect()
    }

    #[test]
    fn a_kept_base_is_the_plain_object_and_all_above_it_is_not_changed() {
        for effect in ["noisy_sphere", "dripping_sphere", "fur", "fire", "fire_ball"] {
            let mut scene = preset(effect).unwrap();
            (scene.object.input, scene.light.shadows) = ("sphere".into(), false);
            let mut kept = scene.clone();
            kept.effect.keep_base = 0.4;
            let below = places(10_000, DVec3::new(-1.4, -1.6, -1.4), DVec3::new(1.4, -0.6, 1.4));
            let (found, whole) = (densities(&kept, None, &below).0, plain(&scene, &below));
            assert!(found == whole && whole.iter().any(|d| *d > 0.0), "{effect}");
            assert!(densities(&scene, None, &below).0 != whole, "{effect}");
            let above = places(2_000, DVec3::new(-1.4, -0.4999, -1.4), DVec3::new(1.4, 1.6, 1.4));
            assert!(densities(&kept, None, &above).0 == densities(&scene, None, &above).0, "{effect}");
        }
    }

    #[test]
    fn an_amount_multiplies_the_effect_and_its_reach() {
        let scene = preset("noisy_sphere").unwrap();
        let within = places(4_000, DVec3::splat(-0.9), DVec3::splat(0.9));
        assert!(densities(&scene, Some(0.0), &within).0 == plain(&scene, &within));
        for amount in [0.5, 1.0, 2.0] {
            let mut other = scene.clone();
            other.parameters.insert("amplitude".into(), ParameterValue::Number(0.25 * amount));
            let [(found, end), (expected, wanted)] =
                [densities(&scene, Some(amount), &within), densities(&other, None, &within)];
            let worst = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(worst < 1e-9, "{amount}: {worst}");
            assert!(amount < 1.0 || end.abs_diff_eq(wanted, 1e-5), "{end}, not {wanted}");
        }
    }

    #[test]
    fn what_lies_flat_has_no_amount_and_what_is_steep_all() {
        let subject = Subject::load(&preset("noisy_sphere").unwrap(), &shader::shipped(), &|_| ()).unwrap();
        let mut groom = Groom::unpainted("sphere", 32);
        assert!(fade_flat(&mut groom, &subject, 40.0));
        for index in 0..groom.voxels() {
            let [x, y, z] = groom.place(index).to_array().map(f64::from);
            let angle = x.hypot(z).atan2(y.abs()).to_degrees();
            let part = ((angle - 40.0) / 15.0).clamp(0.0, 1.0);
            let (expected, found) = (part * part * (3.0 - 2.0 * part), f64::from(groom.at(index)[8]));
            assert!((found - expected).abs() < 2e-3, "{angle}: {found}, not {expected}");
        }
    }
}
