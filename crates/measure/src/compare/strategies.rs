//! Strategies: the modules that turbulence and noise of a scene may come from.

use hypertexture::render::variant::Variant;
use hypertexture::scene::{Integration, Scene, SceneError};
use hypertexture::shader::Library;

/// Strategies that a quick sweep leaves out, unless the scene has them: they compute what others compute sooner.
const FULL_ONLY: [&str; 3] = ["arrays", "octaves", "tables"];

/// A choice of modules for turbulence and noise.
pub(super) struct Strategy {
    pub(super) name: String,
    turbulence: Option<String>,
    pub(super) scene: Scene,
}

impl Strategy {
    /// Whether it is the scene's own. Of others, a quick sweep has rays of points and slices of 8 bits alone.
    pub(super) fn is_own(&self, scene: &Scene) -> bool {
        let (own, other) = (&scene.effect, &self.scene.effect);
        (&own.turbulence, &own.noise) == (&other.turbulence, &other.noise)
    }
}

/// All strategies that a scene may have: each module of turbulence if it reads any, with each module of noise if it reads
/// that. A quick sweep takes the scene's own noise and the computed one.
pub(super) fn strategies(scene: &Scene, library: &Library, quick: bool) -> Vec<Strategy> {
    let reads = |scene: &Scene, slot: &str| {
        let variant = Variant::of(scene, library).ok();
        variant.is_some_and(|variant| variant.reads(slot))
    };
    // The scene's own first: of two that differ only in modules that are not read, the first is kept.
    let modules = |slot: &str, own: &str| {
        let mut modules: Vec<String> = library.modules(slot).into_iter().map(String::from).collect();
        modules.sort_by_key(|module| module != own);
        modules
    };
    let mut found: Vec<Strategy> = Vec::new();
    for turbulence in modules("turbulence", &scene.effect.turbulence) {
        if quick && turbulence != scene.effect.turbulence && FULL_ONLY.contains(&turbulence.as_str()) {
            continue;
        }
        for noise in modules("noise", &scene.effect.noise) {
            if quick && noise != scene.effect.noise && noise != "procedural" {
                continue;
            }
            let mut scene = scene.clone();
            (scene.effect.turbulence, scene.effect.noise) = (turbulence.clone(), noise.clone());
            // Few samples: a sum of octaves may not take many, and that must not decide about the strategy.
            (scene.quality.integration, scene.quality.samples) = (Integration::Point, 1);
            if scene.check(library).is_err() {
                continue;
            }
            let turbulence = reads(&scene, "turbulence").then(|| turbulence.clone());
            let noise = reads(&scene, "noise").then_some(noise);
            let name = match (&turbulence, noise) {
                (Some(turbulence), Some(noise)) => format!("{turbulence}+{noise}"),
                (Some(turbulence), None) => turbulence.clone(),
                (None, Some(noise)) => noise,
                (None, None) => "plain".into(),
            };
            if found.iter().all(|other| other.name != name) {
                found.push(Strategy { name, turbulence, scene });
            }
        }
    }
    found
}

/// The strategies with these names, or of turbulence with these names; all without names.
pub(super) fn chosen(all: Vec<Strategy>, names: Option<&[String]>) -> Result<Vec<Strategy>, SceneError> {
    let Some(names) = names else { return Ok(all) };
    let is = |strategy: &Strategy, name: &String| strategy.name == *name || strategy.turbulence.as_ref() == Some(name);
    if let Some(unknown) = names.iter().find(|name| !all.iter().any(|strategy| is(strategy, name))) {
        let known: Vec<&str> = all.iter().map(|strategy| strategy.name.as_str()).collect();
        return Err(SceneError::unknown("strategy", unknown, &known));
    }
    Ok(all.into_iter().filter(|strategy| names.iter().any(|name| is(strategy, name))).collect())
}
