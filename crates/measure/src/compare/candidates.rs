//! Candidates: the settings of a scene that are compared.
//!
//! Invariant: no two candidates run the same program over the same values. A way that the scene's check refuses is left
//! out, and so is one that differs only in what its program does not read.

use super::CompareError;
use super::strategies::{chosen, strategies};
use hypertexture::render::variant::Variant;
use hypertexture::scene::{Filter, Integration, Pass, Scene, TargetFormat};
use hypertexture::shader::Library;
use serde::Serialize;

/// Choice of candidates.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sweep {
    /// Few candidates; without `samples`, more of them along the front.
    pub quick: bool,
    /// Samples; without them, 16 to 128 or 512.
    pub samples: Option<Vec<u32>>,
    /// Names of strategies, or of their turbulence; without them, all that the library has.
    pub strategies: Option<Vec<String>>,
    /// The other filter too: filters of some devices have weights of few bits, which may change a picture.
    pub filters: bool,
}

/// Samples of a ray without `--sweep`: powers of two, as orders are read off them.
const SAMPLES: [u32; 6] = [16, 32, 64, 128, 256, 512];
/// How many of them a quick sweep begins with.
const QUICK_SAMPLES: usize = 4;
/// Sides of the blocks of noise, texels, beside that of the scene.
const BLOCKS: [u32; 3] = [32, 64, 128];

/// One way to draw the scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Candidate {
    /// Where turbulence and noise come from, such as `encoded` or `octaves+block`.
    pub strategy: String,
    /// Whether its program reads a block of noise.
    pub reads_block: bool,
    /// Whether its program looks up between texels.
    pub reads_filter: bool,
    /// Octaves that its turbulence has.
    pub octaves_held: u32,
    /// Whether it differs from the others of its samples in block or target alone.
    pub aside: bool,
    /// The scene.
    pub scene: Scene,
}

/// Settings shared by the samples of a curve.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct Curve {
    /// Where turbulence and noise come from.
    pub strategy: String,
    /// Slices or rays.
    pub pass: Pass,
    /// Integration rule.
    pub integration: Integration,
    /// Side of the block of noise, texels; `None` where none is read.
    pub block: Option<u32>,
    /// Format that slices are blended in; `None` of rays, which add up in registers.
    pub target: Option<TargetFormat>,
    /// Filter between texels; the default if no texels are read.
    pub filter: Filter,
}

impl Candidate {
    /// The curve that the candidate is a point of.
    pub fn curve(&self) -> Curve {
        let quality = &self.scene.quality;
        Curve {
            strategy: self.strategy.clone(),
            pass: quality.pass,
            integration: quality.integration,
            block: self.reads_block.then_some(quality.block_size),
            target: (quality.pass == Pass::Slices).then_some(quality.target),
            filter: if self.reads_filter { quality.filter } else { Filter::default() },
        }
    }

    /// Samples of a ray, or slices.
    pub fn samples(&self) -> u32 {
        self.scene.quality.samples
    }

    /// Octaves that its turbulence has, and those that were asked for; `None` where it reads none.
    pub fn octaves(&self) -> Option<[u32; 2]> {
        let effect = &self.scene.effect;
        let reads = self.strategy.split('+').next() == Some(effect.turbulence.as_str());
        reads.then_some([self.octaves_held, effect.octaves])
    }

    /// The candidate in words.
    pub fn label(&self) -> String {
        format!("{}, {} samples", self.curve().label(), self.samples())
    }

    /// The most that blending may add to an error, known beforehand: each of N blends rounds the opacity by at most half
    /// a code (8 bits), or cuts off a unit in the last place of a value below 1 (floats, on drivers that truncate).
    /// Matter that is thinner than that is lost altogether, however much there is of it.
    pub(crate) fn blend_bound(&self) -> f64 {
        let unit = match self.curve().target {
            None => return 0.0,
            Some(TargetFormat::Unorm8) => 1.0 / 510.0,
            Some(TargetFormat::Float16) => 2f64.powi(-11),
            Some(TargetFormat::Float32) => 2f64.powi(-24),
        };
        (unit * f64::from(self.samples())).min(1.0)
    }
}

impl Curve {
    /// The curve in words.
    pub fn label(&self) -> String {
        let block = self.block.map_or(String::new(), |side| format!(" {side}³"));
        let target = self.target.map_or("", |target| match target {
            TargetFormat::Unorm8 => ", 8-bit",
            TargetFormat::Float16 => ", 16-bit float",
            TargetFormat::Float32 => ", 32-bit float",
        });
        let filter = if self.filter == Filter::Exact { ", exact filter" } else { "" };
        let [pass, integration] =
            [format!("{:?}", self.pass), format!("{:?}", self.integration)].map(|name| name.to_lowercase());
        format!("{}{block}, {pass}, {integration}{target}{filter}", self.strategy)
    }
}

/// The candidates for a scene, in the order of their curves.
///
/// # Errors
/// The scene itself is not valid, a strategy is unknown, or nothing is left.
pub fn candidates(scene: &Scene, library: &Library, sweep: &Sweep) -> Result<Vec<Candidate>, CompareError> {
    let least = samples(sweep).iter().copied().min().unwrap_or(1);
    let mut checked = scene.clone();
    checked.quality.samples = least;
    checked.check(library)?;
    let mut found: Vec<(String, Candidate)> = Vec::new();
    let all = strategies(scene, library, sweep.quick && sweep.strategies.is_none());
    for strategy in chosen(all, sweep.strategies.as_deref())? {
        let brief = sweep.quick && !strategy.is_own(scene);
        for Method { pass, integration, target, block_size, filter, aside } in methods(scene, sweep) {
            if brief && !aside && (pass, integration) != (Pass::March, Integration::Point) {
                continue;
            }
            for &samples in samples(sweep) {
                let mut scene = strategy.scene.clone();
                let quality = &mut scene.quality;
                (quality.pass, quality.integration, quality.samples) = (pass, integration, samples);
                (quality.target, quality.block_size, quality.filter) = (target, block_size, filter);
                let Ok(variant) = Variant::of(&scene, library) else { continue };
                let candidate = Candidate {
                    strategy: strategy.name.clone(),
                    reads_block: variant.reads_block(library),
                    reads_filter: variant.reads("filter"),
                    octaves_held: variant.octaves,
                    aside,
                    scene,
                };
                let key = format!("{} {:?} {samples}", variant.key(), candidate.curve());
                if found.iter().all(|(other, _)| *other != key) {
                    found.push((key, candidate));
                }
            }
        }
    }
    if found.is_empty() {
        Err(CompareError::Nothing)
    } else {
        Ok(found.into_iter().map(|(_, candidate)| candidate).collect())
    }
}

/// The samples of the sweep.
fn samples(sweep: &Sweep) -> &[u32] {
    let count = if sweep.quick { QUICK_SAMPLES } else { SAMPLES.len() };
    sweep.samples.as_deref().unwrap_or(&SAMPLES[..count])
}

/// How a candidate is drawn.
#[derive(Clone, Copy)]
struct Method {
    pass: Pass,
    integration: Integration,
    target: TargetFormat,
    block_size: u32,
    filter: Filter,
    /// Whether it differs in target, block or filter alone: these vary one at a time, but passes and integrations are
    /// crossed.
    aside: bool,
}

fn methods(scene: &Scene, sweep: &Sweep) -> Vec<Method> {
    let quick = sweep.quick;
    let (target, block_size, filter) = (TargetFormat::Float32, scene.quality.block_size, scene.quality.filter);
    let of = |pass, integration| Method { pass, integration, target, block_size, filter, aside: false };
    let mut methods = vec![
        of(Pass::March, Integration::Point),
        of(Pass::March, Integration::Segment),
        of(Pass::Slices, Integration::Point),
    ];
    if !quick {
        methods.push(of(Pass::Slices, Integration::Segment));
    }
    if sweep.filters {
        let filter = if filter == Filter::Exact { Filter::Device } else { Filter::Exact };
        let others: Vec<Method> = methods.iter().map(|method| Method { filter, aside: true, ..*method }).collect();
        methods.extend(others);
    }
    let slices = Method { aside: true, ..of(Pass::Slices, Integration::Point) };
    methods.push(Method { target: TargetFormat::Unorm8, ..slices }); // the paper's
    if !quick {
        methods.push(Method { target: TargetFormat::Float16, ..slices });
        let blocks = BLOCKS.into_iter().filter(|&block| block != block_size);
        for integration in [Integration::Segment, Integration::Point] {
            let of = |block_size| Method { block_size, aside: true, ..of(Pass::March, integration) };
            methods.extend(blocks.clone().map(of));
        }
    }
    methods
}

#[cfg(test)]
mod tests {
    use super::*;
    use hypertexture::scene::preset;
    use hypertexture::shader;
    use std::collections::BTreeSet;

    fn all(effect: &str, sweep: &Sweep) -> Vec<Candidate> {
        candidates(&preset(effect).unwrap(), &shader::shipped(), sweep).unwrap()
    }

    fn has(candidates: &[Candidate], label: &str) -> bool {
        candidates.iter().any(|candidate| candidate.label() == label)
    }

    #[test]
    fn both_filters_are_candidates_of_interpolating_programs() {
        let sweep = Sweep { samples: Some(vec![16]), filters: true, ..Sweep::default() };
        let exact = |candidates: &[Candidate]| {
            let exact = candidates.iter().filter(|candidate| candidate.curve().filter == Filter::Exact);
            exact.map(|candidate| candidate.strategy.clone()).collect::<BTreeSet<_>>()
        };
        let fire = all("fire_ball", &sweep);
        assert!(has(&fire, "encoded 64³, march, point, exact filter, 16 samples"));
        assert!(exact(&fire).contains("procedural"), "a map of colors");
        let noisy = exact(&all("noisy_sphere", &sweep));
        assert!(noisy.contains("block") && !noisy.contains("procedural"), "a formula and computed noise: {noisy:?}");
        assert!(exact(&all("fire_ball", &Sweep { filters: false, ..sweep.clone() })).is_empty());
        let mut own = preset("fire").unwrap();
        own.quality.filter = Filter::Exact;
        let own = candidates(&own, &shader::shipped(), &sweep).unwrap();
        assert!(has(&own, "encoded 64³, march, point, 16 samples") && exact(&own).contains("encoded"));
    }

    #[test]
    fn a_sweep_varies_what_the_program_reads_and_nothing_else() {
        let fire = all("fire", &Sweep::default());
        assert!(has(&fire, "encoded 32³, march, segment, 64 samples"));
        assert!(has(&fire, "encoded 64³, slices, point, 8-bit, 256 samples"));
        assert!(has(&fire, "octaves+procedural, march, point, 128 samples"));
        assert!(has(&fire, "octaves+block 64³, slices, segment, 32-bit float, 512 samples"));
        assert!(!fire.iter().any(|c| c.curve().block.is_some() && c.strategy.ends_with("+procedural")));
        let mut labels: Vec<String> = fire.iter().map(Candidate::label).collect();
        labels.sort();
        labels.dedup();
        assert_eq!(labels.len(), fire.len(), "a candidate appears twice");
        for candidate in &fire {
            candidate.scene.check(&shader::shipped()).unwrap();
        }
    }

    #[test]
    fn an_effect_without_turbulence_varies_its_noise_or_nothing() {
        let strategies = |effect| -> BTreeSet<String> {
            all(effect, &Sweep::default()).into_iter().map(|candidate| candidate.strategy).collect()
        };
        assert!(strategies("fur").contains("block") && strategies("fur").contains("procedural"));
        assert_eq!(strategies("lit").into_iter().collect::<Vec<_>>(), ["plain"]);
    }

    #[test]
    fn what_the_check_refuses_is_left_out() {
        let fire = all("fire", &Sweep::default());
        assert!(has(&fire, "octaves+procedural, slices, segment, 32-bit float, 512 samples"));
        let ball = all("fire_ball", &Sweep::default());
        assert!(
            ball.iter().all(|c| c.curve().integration == Integration::Point),
            "post-classification knows points alone"
        );
    }

    #[test]
    fn a_name_like_that_of_a_block_varies_no_block() {
        let sweep = Sweep { samples: Some(vec![16]), ..Sweep::default() };
        let blocks = |text: &str| {
            let library = shader::shipped().with_module("turbulence", "mine", text);
            let mut scene = preset("fire").unwrap();
            (scene.effect.turbulence, scene.effect.noise) = ("mine".into(), "procedural".into());
            let all = candidates(&scene, &library, &sweep).unwrap();
            let own = all.iter().filter(|own| own.strategy == "mine");
            own.map(|own| own.curve().block).collect::<BTreeSet<_>>()
        };
        assert_eq!(blocks("float my_block(vec3 p) { return p.x; } /* no noise_block */"), [None].into());
        assert!(blocks("float mine(vec3 p) { return lookup_block(noise_value_block, p, 0.0).r; }").len() > 1);
    }

    #[test]
    fn a_sweep_may_be_narrowed() {
        let names = |names: &[&str]| Some(names.iter().map(|name| name.to_string()).collect());
        let sweep = Sweep { samples: Some(vec![24]), strategies: names(&["encoded"]), quick: true, filters: false };
        let few = all("fire", &sweep);
        assert_eq!(few.len(), 4, "rays of points and of segments, slices of two targets");
        assert!(few.iter().all(|c| c.samples() == 24 && c.strategy == "encoded"));
        let both = all("fire", &Sweep { strategies: names(&["octaves"]), ..sweep.clone() });
        assert_eq!(both.iter().filter(|c| c.strategy == "octaves+block").count(), 2, "it is not the scene's own");
        let sweep = Sweep { strategies: names(&["encodd"]), ..sweep };
        let error = candidates(&preset("fire").unwrap(), &shader::shipped(), &sweep).unwrap_err().to_string();
        assert!(error.starts_with("no strategy `encodd` (did you mean `encoded`?)"), "{error}");
        let sweep = Sweep { samples: Some(vec![0]), ..Sweep::default() };
        let error = candidates(&preset("fire").unwrap(), &shader::shipped(), &sweep).unwrap_err().to_string();
        assert!(error.contains("quality.samples = 0"), "{error}");
    }

    #[test]
    fn what_blending_loses_is_bounded_beforehand() {
        // Opacity of an optical depth of 2, which is 0.8647, as measured on lavapipe by format and layers.
        let measured = [
            (TargetFormat::Unorm8, 256, 0.7529),
            (TargetFormat::Unorm8, 1024, 0.0),
            (TargetFormat::Float16, 64, 0.8584),
            (TargetFormat::Float16, 1024, 0.75),
            (TargetFormat::Float16, 10_000, 0.25),
            (TargetFormat::Float32, 100_000, 0.864_665),
        ];
        let mut candidate = all("lit", &Sweep::default()).remove(0);
        for (target, layers, opacity) in measured {
            let quality = &mut candidate.scene.quality;
            (quality.pass, quality.target, quality.samples) = (Pass::Slices, target, layers);
            let error: f64 = 0.864_664_7 - opacity;
            assert!(candidate.blend_bound() >= error.abs(), "{target:?} {layers}");
        }
        candidate.scene.quality.pass = Pass::March;
        assert_eq!(candidate.blend_bound(), 0.0);
    }
}
