//! Material, light, background and the eye.

use super::widgets::{button, choice, color, field, number, numbers, switch};
use super::{Pass, Request, own, prefix};
use crate::scene::{Color, LightMethod, Projection};
use egui::Ui;

/// Color behind the object where one is switched on.
const BACKGROUND: Color = Color([32, 36, 44]);
/// The plane where one is switched on: the half nearer to +z goes.
const CLIP: [f32; 4] = [0.0, 0.0, 1.0, 0.0];

/// Reflection of the hard surface.
pub(super) fn material(ui: &mut Ui, pass: &mut Pass<'_>, part: Option<&str>) {
    let at = |name: &str| format!("{}material.{name}", prefix(part));
    let touch = &mut pass.touch;
    let material = own(&mut pass.draft, part).material;
    color(ui, touch, &field(at("color"), "Color of the surface."), &mut material.color);
    number(ui, touch, &field(at("specular"), "Strength of the highlight."), &mut material.specular, 0.0..=1.0);
    let doc = "Sharpness of the highlight.";
    number(ui, touch, &field(at("specular_power"), doc), &mut material.specular_power, 1.0..=1000.0);
}

/// The light, its shadows, and what is behind.
pub(super) fn light(ui: &mut Ui, pass: &mut Pass<'_>) {
    let touch = &mut pass.touch;
    let light = &mut pass.draft.light;
    let doc = "Position from the center of the object: right, up, toward the eye; object units.";
    numbers(ui, touch, &field("light.position", doc), &mut light.position, 0.05);
    color(ui, touch, &field("light.color", "Color of the light."), &mut light.color);
    number(ui, touch, &field("light.intensity", "Brightness of the light."), &mut light.intensity, 0.0..=5.0);
    color(ui, touch, &field("light.ambient", "Color of what comes from all sides."), &mut light.ambient);
    let doc = "Whether matter keeps the light from what is behind it.";
    switch(ui, touch, &field("light.shadows", doc), &mut light.shadows);
    let doc = "Texels along a side of the volume of shadows.";
    number(ui, touch, &field("light.shadow_resolution", doc), &mut light.shadow_resolution, 16..=256);
    let methods = [
        (LightMethod::Volume, "volume", "A volume, rendered before the picture: any light, slices and rays.".into()),
        (
            LightMethod::HalfAngle,
            "half_angle",
            "Slice by slice with the picture: slices alone; knows translucency.".into(),
        ),
    ];
    let doc = "How the light that reaches a place is found.";
    choice(ui, touch, &field("light.method", doc), &mut light.method, &methods);
    let doc = "Part of the light that soft matter scatters forward; needs half_angle.";
    number(ui, touch, &field("light.translucency", doc), &mut light.translucency, 0.0..=1.0);
    let doc = "Part of the optical depth that scattered light is spared.";
    color(ui, touch, &field("light.transport", doc), &mut light.transport);
    let doc = "Blur of scattered light after one object unit, object units.";
    number(ui, touch, &field("light.scatter", doc), &mut light.scatter, 0.0..=2.0);
    let background = &mut pass.draft.image.background;
    let mut has = background.is_some();
    let doc = "Whether there is a color behind the object; without one it is transparent.";
    switch(ui, touch, &field("image.has_background", doc), &mut has);
    *background = has.then(|| background.unwrap_or(BACKGROUND));
    if let Some(background) = background {
        color(ui, touch, &field("image.background", "Color behind the object."), background);
    }
}

/// The eye, and the moment.
pub(super) fn camera(ui: &mut Ui, pass: &mut Pass<'_>) {
    if button(ui, "reset view", "camera.reset", "Look at the object as its preset does.").clicked() {
        pass.requests.push(Request::ResetCamera);
    }
    let touch = &mut pass.touch;
    let camera = &mut pass.draft.camera;
    let projections = [
        (Projection::Perspective, "perspective", "Rays leave from one point.".into()),
        (Projection::Parallel, "parallel", "Rays leave side by side.".into()),
    ];
    let doc = "How rays leave the eye.";
    choice(ui, touch, &field("camera.projection", doc), &mut camera.projection, &projections);
    let doc = "Degrees around the vertical axis: 0 looks at the +z side, 90 at the +x side.";
    number(ui, touch, &field("camera.azimuth", doc), &mut camera.azimuth, -180.0..=180.0);
    number(ui, touch, &field("camera.elevation", "Degrees above the horizon."), &mut camera.elevation, -90.0..=90.0);
    let doc = "1 fits the object into the picture; 2 is twice as close.";
    number(ui, touch, &field("camera.zoom", doc), &mut camera.zoom, 0.1..=30.0);
    let doc = "Vertical angle of view in degrees, perspective only.";
    number(ui, touch, &field("camera.field_of_view", doc), &mut camera.field_of_view, 1.0..=120.0);
    number(ui, touch, &field("camera.time", "Time in seconds."), &mut camera.time, 0.0..=60.0);
    let doc = "Seconds that the shutter stays open; needs quality.supersampling.";
    number(ui, touch, &field("camera.shutter", doc), &mut camera.shutter, 0.0..=1.0);
    let mut has = camera.clip.is_some();
    switch(ui, touch, &field("camera.has_clip", "Whether a plane cuts the object open."), &mut has);
    camera.clip = has.then(|| camera.clip.unwrap_or(CLIP));
    if let Some(plane) = &mut camera.clip {
        let doc = "a, b, c, d: keeps the points x, y, z of object space with a x + b y + c z <= d.";
        numbers(ui, touch, &field("camera.clip", doc), plane, 0.01);
    }
    let doc = "Shows the stack of slices from the side; classify stack draws it.";
    switch(ui, touch, &field("camera.slice_stack", doc), &mut camera.slice_stack);
}
