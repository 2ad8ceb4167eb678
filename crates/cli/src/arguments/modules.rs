//! Modules from the command line, and the debug views.

use hypertexture::scene::{Projection, RayPath, Scene, SceneError, schema};

/// Sets the modules of one slot, separated by `+`. A name that ends in `.glsl` is a custom module.
pub(crate) fn module(text: &str, scene: &mut Scene) -> Result<(), SceneError> {
    let limit = "write SLOT=MODULE, such as noise=procedural; a stack is DMF+DMF".to_string();
    let wrong = || SceneError::Value { field: "--module".into(), value: text.into(), limit };
    let (slot, names) = text.split_once('=').ok_or_else(wrong)?;
    let slot = slot.trim();
    let mut modules = Vec::new();
    for name in names.split('+').map(str::trim).filter(|name| !name.is_empty()) {
        let is_file = name.ends_with(".glsl");
        modules.push(if is_file { scene.add_module(slot, name)? } else { name.to_string() });
    }
    match schema::slots().find(|(known, _)| *known == slot) {
        None => Err(SceneError::unknown("slot", slot, &schema::slots().map(|(slot, _)| slot).collect::<Vec<_>>())),
        Some(_) if ["dmf", "warp"].contains(&slot) => {
            let stack = if slot == "warp" { &mut scene.effect.warp } else { &mut scene.effect.dmf };
            *stack = modules;
            Ok(())
        }
        Some(_) => {
            let single = scene.effect.modules_mut().into_iter().find(|(own, _)| *own == slot);
            single.into_iter().for_each(|(_, module)| *module = modules.join("+"));
            Ok(())
        }
    }
}

/// A plain effect without modulation on the scene's object, for debug views.
pub(crate) fn show(scene: &mut Scene, classify: &str, surface: &str) {
    scene.parts.clear();
    scene.combine = None;
    scene.effect.classify = classify.into();
    scene.effect.surface = surface.into();
    scene.effect.ray_path = RayPath::Straight;
    scene.effect.absorption = "none".into();
    scene.effect.environment = "none".into();
    scene.effect.softness = "hard".into();
    scene.effect.dmf.clear();
    scene.effect.warp.clear();
    scene.parameters.clear();
}

/// Zoom for a plane of noise: the face of a cube fills the picture.
const PLANE_ZOOM: f32 = 2.1;

/// A plane of noise, seen from the front.
pub(crate) fn show_plane(scene: &mut Scene, surface: &str) {
    show(scene, "surface", surface);
    let camera = &mut scene.camera;
    camera.projection = Projection::Parallel;
    (camera.azimuth, camera.elevation, camera.rotation) = (0.0, 0.0, None);
    camera.zoom = PLANE_ZOOM;
}
