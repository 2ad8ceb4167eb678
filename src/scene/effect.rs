//! The modules of an effect.

use super::Repeat;
use super::fields::setting::{choices, settings};

settings! {
    /// The modules of an effect: names of files in the folders of `glsl`.
    pub struct Effect: EffectField = "effect." {
        /// Density modulation functions, applied in this order; a mask limits the place of one.
        dmf: Vec<String> = Vec::new() => Images, Kind::Stack;
        /// Displacements of the sampled position, applied in this order.
        warp: Vec<String> = Vec::new() => Images, Kind::Stack;
        /// Height of the base that the effect leaves as it is, object units: warps and DMFs do nothing on so much of the object's own lowest part, along y, nor below or beside it, and reach their strength over another quarter of that height.
        keep_base: f32 = 0.0 => Images, number(0.0, 2.0), usual(0.0, 0.5), flag("keep-base"), unit(Unit::ObjectUnits);
        /// Conversion of a sample to a color.
        classify: String = "surface".into() => Images, Kind::Module(Filled::ByObject);
        /// Conversion of the distance to a density.
        softness: String = "hard".into() => Images, Kind::Module(Filled::ByObject);
        /// Color of the hard region.
        surface: String = "lit".into() => Images, Kind::Module(Filled::ByObject);
        /// Color of the soft region; if several DMFs have a width of their own, one for each in their order, as hair+flame, or one for all.
        medium: String = "material".into() => Images, Kind::Module(Filled::ByObject);
        /// Projection of a point onto the surface; auto is the formula of an object that has one, else the closest point.
        project: String = "auto".into() => Images, Kind::Module(Filled::ByObject);
        /// Opacity of soft matter per object unit: c of Perlin and Hoffert 3.1.
        opacity_rate: f32 = 40.0 => Images, number(0.0, 1e9), usual(0.1, 1000.0);
        /// Source of noise.
        noise: String = "block".into() => Images, Kind::Module(Filled::ByScene);
        /// Period of the lattice of procedural noise, in cells.
        noise_repeat: Repeat = Repeat::Own => Images, Kind::Choice(Repeat::CHOICES);
        /// Interpolation weights of the noise: cubic (1989) or quintic (2002).
        weights: String = "quintic".into() => Images, Kind::Module(Filled::ByScene);
        /// Source of turbulence: the turbulence strategy.
        turbulence: String = "encoded".into() => Images, Kind::Module(Filled::ByScene);
        /// Period of the lattice of each octave of procedural turbulence, in cells.
        turbulence_repeat: Repeat = Repeat::Own => Images, Kind::Choice(Repeat::CHOICES);
        /// Octaves of turbulence; an encoded block holds as many as it has texels for.
        octaves: u32 = 8 => Images, whole(1.0, 10.0);
        /// Treatment of octaves that are finer than a sample.
        bandlimit: String = "none".into() => Images, Kind::Module(Filled::ByScene);
        /// Normal for the lighting of soft matter: analytic, central or three.
        gradient: String = "analytic".into() => Images, Kind::Module(Filled::ByScene), flag("gradient");
        /// Wind that bends fur: none or breeze.
        wind: String = "none".into() => Images, Kind::Module(Filled::ByScene);
        /// Conversion of density to opacity.
        opacity: String = "perlin".into() => Images, Kind::Module(Filled::ByScene);
        /// The path of a ray through the object.
        ray_path: RayPath = RayPath::Straight => Images, Kind::Choice(RayPath::CHOICES);
        /// Source of the index of refraction.
        index: String = "transfer".into() => Images, Kind::Module(Filled::ByScene);
        /// Absorption along a bent ray.
        absorption: String = "none".into() => Images, Kind::Module(Filled::ByScene);
        /// Environment of bent rays: behind the object and in reflections.
        environment: String = "none".into() => Images, Kind::Module(Filled::ByScene);
    }
}

/// The slots of an effect that take one module, with a reference to each module.
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
            ("wind", $($reference)+ $effect.wind),
            ("opacity", $($reference)+ $effect.opacity),
            ("index", $($reference)+ $effect.index),
            ("absorption", $($reference)+ $effect.absorption),
            ("environment", $($reference)+ $effect.environment),
        ]
    };
}

impl Effect {
    /// The slots that take one module, with the module of each.
    pub fn modules(&self) -> [(&'static str, &String); 15] {
        slots!(self, &)
    }

    /// Those slots with mutable references to their modules.
    pub fn modules_mut(&mut self) -> [(&'static str, &mut String); 15] {
        slots!(self, &mut)
    }

    /// Turns a hard object into a soft one, so that DMFs have a density to modulate.
    pub fn soften(&mut self) {
        for (slot, hard, soft) in [(&mut self.softness, "hard", "linear"), (&mut self.classify, "surface", "soft")] {
            if slot == hard {
                *slot = soft.into();
            }
        }
    }
}

choices! {
    /// The path of a ray through the object.
    #[non_exhaustive]
    pub enum RayPath {
        /// A straight line.
        #[default]
        Straight = "straight",
        /// Bent by Snell's law where the index of refraction changes (PH 2.4); needs pass = march.
        Refracted = "refracted",
    }
}
