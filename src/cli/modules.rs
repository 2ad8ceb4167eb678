//! Modules from the command line, and the looks that show how a picture is made.

use hypertexture::scene::{Ray, Scene, SceneError};

/// Puts the modules of one slot, separated by `+`, into the scene.
pub(super) fn module(text: &str, scene: &mut Scene) -> Result<(), SceneError> {
    let limit = "write SLOT=MODULE, such as noise=procedural; a stack is DMF+DMF".to_string();
    let wrong = || SceneError::Value { field: "--module".into(), value: text.into(), limit };
    let (slot, names) = text.split_once('=').ok_or_else(wrong)?;
    let effect = &mut scene.effect;
    let single = match slot.trim() {
        "classify" => &mut effect.classify,
        "softness" => &mut effect.softness,
        "surface" => &mut effect.surface,
        "medium" => &mut effect.medium,
        "noise" => &mut effect.noise,
        "weights" => &mut effect.weights,
        "turbulence" => &mut effect.turbulence,
        "bandlimit" => &mut effect.bandlimit,
        "gradient" => &mut effect.gradient,
        "opacity" => &mut effect.opacity,
        "index" => &mut effect.index,
        "absorption" => &mut effect.absorption,
        "environment" => &mut effect.environment,
        "project" => &mut effect.project,
        stack @ ("warp" | "dmf") => {
            let modules =
                names.split('+').map(|name| name.trim().to_string()).filter(|name| !name.is_empty()).collect();
            *if stack == "warp" { &mut effect.warp } else { &mut effect.dmf } = modules;
            return Ok(());
        }
        other => {
            let known = [
                "classify",
                "softness",
                "warp",
                "dmf",
                "surface",
                "medium",
                "noise",
                "weights",
                "turbulence",
                "bandlimit",
                "gradient",
                "opacity",
                "index",
                "absorption",
                "environment",
                "project",
            ];
            return Err(SceneError::unknown("slot", other, &known));
        }
    };
    *single = names.trim().into();
    Ok(())
}

/// A plain effect without modulation on the scene's own object, to look at one thing.
pub(super) fn show(scene: &mut Scene, classify: &str, surface: &str) {
    scene.parts.clear();
    scene.combine = None;
    scene.effect.classify = classify.into();
    scene.effect.surface = surface.into();
    scene.effect.ray = Ray::Straight;
    scene.effect.absorption = "none".into();
    scene.effect.environment = "none".into();
    scene.effect.softness = "hard".into();
    scene.effect.dmf.clear();
    scene.effect.warp.clear();
    scene.knobs.clear();
}
