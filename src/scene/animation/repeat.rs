//! Drift of noise in a loop: by whole periods of the noise where that changes speeds little, else in two phases
//! (`glsl/phases/two.glsl`).

use crate::scene::rules::header::header;
use crate::scene::{ParameterValue, Repeat, Scene, Wrap};
use crate::shader::declare::ParameterKind;
use crate::shader::drift::Drift;
use crate::shader::{Declarations, Library};

/// Drift of noise in a loop.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Looped {
    /// Length of the loop, seconds.
    pub(crate) period: f64,
    /// Cells after which noise and turbulence repeat; `None` if they never do.
    cells: [Option<f64>; 2],
    /// Whether some noise has two phases, and then all.
    pub(crate) two_phases: bool,
}

impl Looped {
    /// The speed of a drift in the loop, if it is another: of whole periods, or so that two phases are not alike.
    pub(crate) fn speed(&self, drift: &Drift, value: impl Fn(&str) -> f32) -> Option<f32> {
        let cells = self.cells[usize::from(drift.of_turbulence)]?;
        if self.two_phases { drift.apart(self.period, cells, value) } else { drift.whole(self.period, cells, value) }
    }
}

impl Scene {
    /// The loop of the scene, if any.
    pub(crate) fn looped(&self, library: &Library) -> Option<Looped> {
        let (effect, period) = (&self.effect, self.animation.period?);
        let cells = [
            self.repeats_after(library, "noise", &effect.noise, effect.noise_repeat),
            self.repeats_after(library, "turbulence", &effect.turbulence, effect.turbulence_repeat),
        ];
        let looped = Looped { period, cells, two_phases: false };
        let mut objects = self.parts.keys().map(|name| self.part_as_scene(name));
        let two_phases = self.drifts_apart(library, &looped) || objects.any(|own| own.drifts_apart(library, &looped));
        Some(Looped { two_phases, ..looped })
    }

    /// Cells after which a source of noise repeats.
    fn repeats_after(&self, library: &Library, slot: &str, module: &str, chosen: Repeat) -> Option<f64> {
        let Declarations { exact, period, .. } = header(library, slot, module);
        let own = exact.map_or(period, |exact| exact.repeat);
        let [noise, turbulence, channels] = self.block_cells();
        let cells = match if chosen == Repeat::Own { Repeat::named(own.as_deref()) } else { chosen } {
            Repeat::Own | Repeat::Never => return None,
            Repeat::NoiseBlock => noise,
            Repeat::TurbulenceBlock => turbulence,
            Repeat::ChannelBlock => channels,
        };
        Some(f64::from(if self.quality.wrap == Wrap::Mirror { 2 * cells } else { cells }))
    }

    /// Whether the noise of a module of the main object drifts by other than whole periods.
    fn drifts_apart(&self, library: &Library, looped: &Looped) -> bool {
        let effect = &self.effect;
        let dmfs = effect.dmf.iter().map(|name| ("dmf", name.split('@').next().unwrap_or_default()));
        let warps = effect.warp.iter().map(|name| ("warp", name.as_str()));
        let media = effect.medium.split('+').map(|name| ("medium", name.trim()));
        dmfs.chain(warps).chain(media).any(|(slot, name)| {
            let Declarations { parameters, drifts, .. } = header(library, slot, name);
            let default = |name: &str| match parameters.iter().find(|own| own.name == name)?.kind {
                ParameterKind::Number(default, _) => Some(default),
                ParameterKind::Color(_) => None,
            };
            let value = |name: &str| match self.parameters.get(name) {
                Some(ParameterValue::Number(number)) => *number,
                _ => default(name).unwrap_or_default(),
            };
            drifts.iter().any(|drift| value(&drift.speed) != 0.0 && looped.speed(drift, value).is_none())
        })
    }
}
