//! Sources of noise and turbulence: layout of blocks, periods of lattices, and the scene without discretized noise.

use super::header::header;
use crate::noise::{Bake, Period};
use crate::scene::Scene;
use crate::scene::fields::setting::choices;
use crate::shader::declare::Octaves;
use crate::shader::{Library, LibraryError};

/// Texels per lattice cell of a block of noise. Lower: facets of the trilinear filter show. Higher: the noise repeats sooner.
const NOISE_TEXELS_PER_CELL: u32 = 4;
/// Octaves in the four channels of one fetch; the finest has two texels per cell.
const CHANNELS: u32 = 4;
/// Texels per cell below which the hybrid computes an octave. Lower: the filter visibly blurs the octaves of the block.
/// Higher: more octaves are computed.
const HYBRID_TEXELS_PER_CELL: u32 = 4;

choices! {
    /// Period of the lattice of an octave, in cells.
    pub enum Repeat {
        /// That of the module: of its block if it reads one, else none.
        #[default]
        Own = "own",
        /// None: the pattern repeats after 2^20 cells.
        Never = "never",
        /// That of a block of noise.
        NoiseBlock = "noise_block",
        /// That of a block of turbulence.
        TurbulenceBlock = "turbulence_block",
        /// That of a block with four octaves in its channels.
        ChannelBlock = "channel_block",
    }
}

impl Repeat {
    /// The value with this name in the header of a module; `Own` for any other name.
    pub(in crate::scene) fn named(name: Option<&str>) -> Repeat {
        name.and_then(|name| toml::Value::from(name).try_into().ok()).unwrap_or_default()
    }
}

impl Scene {
    /// Lattice cells across the block of noise, the block of turbulence (first octave), and the block of four octaves.
    pub fn block_cells(&self) -> [u32; 3] {
        let size = self.quality.block_size;
        let cells = size / NOISE_TEXELS_PER_CELL;
        [cells.max(1), self.quality.turbulence_cells, (size >> CHANNELS).max(1)]
    }

    /// Octaves in the block of turbulence, and in the block of the hybrid: the wanted ones, as far as they fit.
    pub fn block_octaves(&self) -> [u32; 2] {
        let (size, cells) = (self.quality.block_size, self.quality.turbulence_cells);
        [size, 2 * size / HYBRID_TEXELS_PER_CELL].map(|size| Bake::held(size, cells, self.effect.octaves))
    }

    /// Octaves that the turbulence has: a block holds only some, and four lookups are four.
    pub fn octaves_held(&self, library: &Library) -> u32 {
        match header(library, "turbulence", &self.effect.turbulence).octaves {
            Octaves::All => self.effect.octaves,
            Octaves::TurbulenceBlock => self.block_octaves()[0],
            Octaves::Most(most) => self.effect.octaves.min(most),
        }
    }

    /// Reason for the limit by [`Scene::octaves_held`], in words.
    pub fn octaves_limit(&self, library: &Library) -> String {
        let (size, cells) = (self.quality.block_size, self.quality.turbulence_cells);
        let module = &self.effect.turbulence;
        match header(library, "turbulence", module).octaves {
            Octaves::TurbulenceBlock => format!(
                "a block of {size} texels and {cells} cells along a side holds no more; see quality.block_size and \
                 quality.turbulence_cells"
            ),
            _ => format!("turbulence = \"{module}\" has no more"),
        }
    }

    /// Periods of procedural noise, and of the octaves of procedural turbulence.
    pub fn periods(&self, library: &Library) -> [Period; 2] {
        let [noise, turbulence, channels] = self.block_cells();
        let period = |repeat: Repeat, slot, module| {
            let own = || Repeat::named(header(library, slot, module).period.as_deref());
            match if repeat == Repeat::Own { own() } else { repeat } {
                Repeat::Own | Repeat::Never => Period::ENDLESS,
                Repeat::NoiseBlock => Period::same(noise),
                Repeat::TurbulenceBlock => Period::growing(turbulence),
                Repeat::ChannelBlock => Period { cycle: CHANNELS, ..Period::growing(channels) },
            }
        };
        let effect = &self.effect;
        [
            period(effect.noise_repeat, "noise", &effect.noise),
            period(effect.turbulence_repeat, "turbulence", &effect.turbulence),
        ]
    }

    /// The scene with noise and turbulence computed at every point in place of blocks: in f64, the ground truth of this scene.
    /// The header of a module names the exact module (`// @exact`); a module without it is exact.
    ///
    /// The result has all wanted octaves. Set `effect.octaves` to [`Scene::octaves_held`] for the ground truth of those that
    /// this scene has.
    ///
    /// # Errors
    /// A module does not exist, or its header is malformed.
    pub fn unbaked(&self, library: &Library) -> Result<Scene, LibraryError> {
        let mut twin = self.clone();
        let effect = &mut twin.effect;
        let slots = [
            ("noise", &mut effect.noise, &mut effect.noise_repeat),
            ("turbulence", &mut effect.turbulence, &mut effect.turbulence_repeat),
        ];
        for (slot, module, repeat) in slots {
            if let Some(exact) = library.header(slot, module)?.exact {
                library.path(slot, &exact.module)?;
                *module = exact.module;
                if *repeat == Repeat::Own {
                    *repeat = Repeat::named(exact.repeat.as_deref());
                }
            }
        }
        for part in twin.parts.values_mut() {
            part.effect.noise.clone_from(&twin.effect.noise);
            part.effect.turbulence.clone_from(&twin.effect.turbulence);
        }
        Ok(twin)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader;

    fn twin(noise: &str, turbulence: &str) -> Scene {
        let mut scene = Scene::default();
        (scene.effect.noise, scene.effect.turbulence) = (noise.into(), turbulence.into());
        scene.unbaked(&shader::shipped()).unwrap()
    }

    #[test]
    fn every_strategy_has_a_twin_that_nothing_discretizes() {
        let library = shader::shipped();
        for turbulence in library.modules("turbulence") {
            for noise in library.modules("noise") {
                let twin = twin(noise, turbulence);
                for (slot, module) in [("noise", &twin.effect.noise), ("turbulence", &twin.effect.turbulence)] {
                    assert_eq!(library.header(slot, module).unwrap().exact, None, "{slot}: {module}");
                    assert!(["procedural", "arrays", "wavelet", "random", "octaves"].contains(&module.as_str()));
                }
                assert_eq!(twin.unbaked(&library).unwrap(), twin);
                assert!(twin.check(&library).is_ok());
            }
        }
    }

    #[test]
    fn a_twin_repeats_as_the_block_does() {
        let periods = |noise, turbulence| twin(noise, turbulence).periods(&shader::shipped());
        assert_eq!(periods("block", "encoded"), [Period::same(16), Period::growing(4)]);
        assert_eq!(periods("tables", "channels"), [Period::ENDLESS, Period { cycle: 4, ..Period::growing(4) }]);
        assert_eq!(periods("procedural", "hybrid"), [Period::ENDLESS, Period::growing(4)]);
        assert_eq!(periods("block", "lookups8"), [Period::same(16); 2]);
        assert_eq!(twin("tables", "tables").effect.turbulence, "arrays");
    }

    #[test]
    fn a_module_of_ones_own_says_its_truth_in_its_header() {
        let text = "// @exact procedural turbulence_block\n";
        let mut scene = Scene::default();
        scene.effect.turbulence = "mine".into();
        let twin = scene.unbaked(&shader::shipped().with_module("turbulence", "mine", text)).unwrap();
        assert_eq!(
            (twin.effect.turbulence.as_str(), twin.effect.turbulence_repeat),
            ("procedural", Repeat::TurbulenceBlock)
        );
        let unknown = shader::shipped().with_module("turbulence", "mine", "// @exact nothing\n");
        assert!(scene.unbaked(&unknown).unwrap_err().to_string().starts_with("no module `nothing`"));
    }

    #[test]
    fn the_octaves_that_a_strategy_has() {
        let library = shader::shipped();
        let held = |turbulence: &str, size: u32| {
            let mut scene = Scene::default();
            (scene.effect.turbulence, scene.quality.block_size) = (turbulence.into(), size);
            scene.octaves_held(&library)
        };
        assert_eq!([16, 64, 256].map(|size| held("encoded", size)), [2, 4, 6]);
        let mut scene = Scene::default();
        let cells = [1, 2, 8, 32].map(|cells| {
            scene.quality.turbulence_cells = cells;
            (scene.octaves_held(&library), scene.block_cells()[1], scene.periods(&library)[1])
        });
        assert_eq!(cells.map(|(held, ..)| held), [6, 5, 3, 1]);
        assert!(cells.iter().all(|(_, cells, _)| [1, 2, 8, 32].contains(cells)));
        scene.effect.turbulence = "hybrid".into();
        assert_eq!((scene.periods(&library)[1], scene.octaves_held(&library)), (Period::growing(32), 8));
        assert_eq!([held("lookups4", 64), held("lookups8", 64), held("hybrid", 64)], [4, 8, 8]);
        for module in library.modules("turbulence") {
            let (mut expected, mut limit) = (8, "has no more");
            if let "encoded" | "lookups4" = module {
                expected = 4;
            }
            if module == "encoded" {
                limit = "a block of 64 texels and 4 cells along a side holds no more";
            }
            assert_eq!(held(module, 64), expected, "{module}");
            let mut scene = Scene::default();
            scene.effect.turbulence = module.into();
            assert!(scene.octaves_limit(&library).contains(limit), "{module}");
        }
    }

    #[test]
    fn the_lattice_of_what_is_in_memory_repeats_as_that_does() {
        let library = shader::shipped();
        for slot in ["noise", "turbulence"] {
            for module in library.modules(slot) {
                let mut scene = Scene::default();
                let (effect, other) = (&mut scene.effect, Repeat::ChannelBlock);
                match slot {
                    "noise" => (effect.noise, effect.noise_repeat) = (module.into(), other),
                    _ => (effect.turbulence, effect.turbulence_repeat) = (module.into(), other),
                }
                let free = ["procedural", "wavelet", "octaves"].contains(&module);
                assert_eq!(scene.check(&library).is_ok(), free, "{slot}: {module}");
                (scene.effect.noise_repeat, scene.effect.turbulence_repeat) = (Repeat::Own, Repeat::Own);
                let own = if module == "hybrid" { Period::growing(4) } else { Period::ENDLESS };
                assert_eq!(scene.periods(&library), [Period::ENDLESS, own], "{slot}: {module}");
            }
        }
    }
}
