//! The modules of an effect.

use super::Repeat;
use serde::{Deserialize, Serialize};

/// The modules of an effect: names of files in the folders of `glsl`.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Effect {
    /// How a sample becomes a color: `surface`, `soft`, `post`, `pre`, `preintegrated`, `clear`.
    pub classify: String,
    /// How the distance becomes a density: `hard`, `linear`, `quadratic`.
    pub softness: String,
    /// Displacements of the position, applied in this order.
    pub warp: Vec<String>,
    /// Density modulation functions, applied in this order.
    pub dmf: Vec<String>,
    /// Color of the hard region.
    pub surface: String,
    /// Color of the soft region; where several DMFs have a width of their own, one for each in their order, as
    /// `hair+flame`, or one for all.
    pub medium: String,
    /// Where noise comes from.
    pub noise: String,
    /// After how many cells the lattice of `noise = "procedural"` repeats.
    pub noise_repeat: Repeat,
    /// Weights of the noise: `cubic` (1989) or `quintic` (2002).
    pub weights: String,
    /// Where turbulence comes from.
    pub turbulence: String,
    /// After how many cells the lattice of each octave of `turbulence = "procedural"` repeats.
    pub turbulence_repeat: Repeat,
    /// Octaves of turbulence, 1 to 10; an encoded block holds as many as it has texels for.
    pub octaves: u32,
    /// What becomes of octaves that are finer than a sample: `none` (nothing) or `clamp` (they fade).
    pub bandlimit: String,
    /// The normal that soft matter is lit by: `analytic`, `central` or `three`.
    pub gradient: String,
    /// Whether rays bend where the index of refraction changes.
    pub ray_path: RayPath,
    /// Where the index of refraction comes from: `transfer`, the index of its stops.
    pub index: String,
    /// What takes light from a ray that bends: `none` or `tinted`.
    pub absorption: String,
    /// What a ray that bends meets behind the object and in its mirror: `none` or `studio`.
    pub environment: String,
    /// How a point finds the surface under it: `gradient`, `closest`, `formula`; `auto` is `formula` for an object that is
    /// one, else `closest`.
    pub project: String,
    /// How density becomes opacity: `perlin` or `beer`.
    pub opacity: String,
    /// c of PH 3.1, per object unit: how fast soft matter becomes opaque.
    pub opacity_rate: f32,
}

/// The slots of an effect that take one module: their names, and references of either kind to their modules.
macro_rules! slots {
    ($effect:ident, $($reference:tt)+) => {
        [
            ("classify", $($reference)+ $effect.classify),
            ("softness", $($reference)+ $effect.softness),
            ("surface", $($reference)+ $effect.surface),
            ("medium", $($reference)+ $effect.medium),
            ("project", $($reference)+ $effect.project),
            ("noise", $($reference)+ $effect.noise),
            ("weights", $($reference)+ $effect.weights),
            ("turbulence", $($reference)+ $effect.turbulence),
            ("bandlimit", $($reference)+ $effect.bandlimit),
            ("gradient", $($reference)+ $effect.gradient),
            ("opacity", $($reference)+ $effect.opacity),
            ("index", $($reference)+ $effect.index),
            ("absorption", $($reference)+ $effect.absorption),
            ("environment", $($reference)+ $effect.environment),
        ]
    };
}

impl Effect {
    /// The modules of the slots that take one, with the names of the slots.
    pub fn modules(&self) -> [(&'static str, &String); 14] {
        slots!(self, &)
    }

    /// The same, to be changed.
    pub fn modules_mut(&mut self) -> [(&'static str, &mut String); 14] {
        slots!(self, &mut)
    }

    /// Makes a hard object soft, for DMFs: it has no density to modulate.
    pub fn soften(&mut self) {
        for (slot, hard, soft) in [(&mut self.softness, "hard", "linear"), (&mut self.classify, "surface", "soft")] {
            if slot == hard {
                *slot = soft.into();
            }
        }
    }
}

impl std::default::Default for Effect {
    fn default() -> Effect {
        Effect {
            classify: "surface".into(),
            softness: "hard".into(),
            warp: Vec::new(),
            dmf: Vec::new(),
            surface: "lit".into(),
            medium: "material".into(),
            noise: "block".into(),
            noise_repeat: Repeat::Own,
            weights: "quintic".into(),
            turbulence: "encoded".into(),
            turbulence_repeat: Repeat::Own,
            octaves: 8,
            bandlimit: "none".into(),
            gradient: "analytic".into(),
            ray_path: RayPath::Straight,
            index: "transfer".into(),
            absorption: "none".into(),
            environment: "none".into(),
            project: "auto".into(),
            opacity: "perlin".into(),
            opacity_rate: 40.0,
        }
    }
}

/// The path of a ray through the object.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum RayPath {
    /// A straight line.
    #[default]
    Straight,
    /// It bends by Snell's law where the index of refraction changes (PH 2.4); slices cannot.
    Refracted,
}
