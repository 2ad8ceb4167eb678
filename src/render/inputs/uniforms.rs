//! Values of uniform blocks, by member name.

use super::noise_blocks;
use super::object_inputs::ObjectInputs;
use crate::render::camera::{FrameContext, SubFrame, View, slant};
use crate::render::error::RenderError;
use crate::render::texture::transfer_texel;
use crate::render::variant::{Blocks, Program, Use};
use crate::scene::{Integration, Jitter, ParameterValue};
use crate::shader::suffixed;
use std::collections::HashMap;

/// Values of the members of all blocks.
#[derive(Clone, Default)]
pub(crate) struct Values {
    /// By name, without the time.
    pub(crate) named: HashMap<String, Vec<f32>>,
    pub(crate) time: f32,
}

/// Fills the blocks of a program.
pub(crate) fn blocks(program: &Program, values: &Values) -> Result<Blocks, RenderError> {
    blocks_at(program, values, values.time)
}

/// Fills the blocks of a program for another time.
pub(crate) fn blocks_at(program: &Program, values: &Values, time: f32) -> Result<Blocks, RenderError> {
    let (named, time) = (&values.named, [time]);
    let value = |name: &str| if name == "time" { Some(&time[..]) } else { named.get(name).map(Vec::as_slice) };
    let filled = program.resources.iter().filter_map(|resource| {
        let Use::Block(block) = &resource.holds else { return None };
        Some(block.fill(value).map(|bytes| (resource.binding, bytes)).map_err(RenderError::Unfilled))
    });
    filled.collect()
}

/// Members that differ between sub-frames, except the time.
pub(crate) fn moment(frame: &FrameContext, sub_frame: &SubFrame) -> [(String, Vec<f32>); 3] {
    let (view, size) = (&frame.view, frame.variant.scene.image.size);
    let [width, height] = size.map(|side| 2.0 / side as f32);
    let [x, y] = [sub_frame.offset[0] * width - view.pan[0], sub_frame.offset[1] * height - view.pan[1]];
    // Slices are rasterized at pixel centers, so they move against the offset of the rays.
    let projection = glam::Mat4::from_translation(glam::Vec3::new(-x, -y, 0.0)) * view.projection;
    [
        ("projection".into(), projection.to_cols_array().to_vec()),
        ("picture_scale".into(), vec![width, height, x, y]),
        ("jitter_seed".into(), vec![sub_frame.jitter_seed]),
    ]
}

/// All other members of the blocks of `interface.glsl` and `part.glsl`, and all parameters.
pub(crate) fn values(frame: &FrameContext, items: &[ObjectInputs<'_>], time: f64) -> Values {
    let FrameContext { variant, view, planes, .. } = frame;
    let scene = &variant.scene;
    let mut named = HashMap::new();
    let mut set = |name: &str, floats: &[f32]| drop(named.insert(name.to_string(), floats.to_vec()));
    set("texture_matrix", &view.texture_matrix.to_cols_array());
    set("object_matrix", &view.object_matrix.to_cols_array());
    set("display_matrix", &view.display_matrix.to_cols_array());
    set("box_min", &view.box_min.extend(0.0).to_array());
    set("box_max", &view.box_max.extend(0.0).to_array());
    set("soft_radius", &[view.soft_radius]);
    let plane = scene.camera.clip.unwrap_or([0.0, 0.0, 1.0, f32::MAX]);
    let length = glam::Vec3::from_slice(&plane).length();
    set("clip_plane", &plane.map(|value| value / length));
    set("step_size", &[planes.step]);
    set("first_depth", &[planes.first_depth]);
    set("slice_count", &[planes.count as f32]);
    set("full_opacity", &[1.0 - scene.quality.early_termination]);
    let reach = sample_reach(frame);
    let shift = if scene.quality.jitter == Jitter::None { 0.0 } else { 0.5 * longest_step(frame) };
    set("slice_axis", &view.axis.extend(0.0).to_array());
    let transport = scene.light.transport.linear();
    set("transport_color", &[transport[0], transport[1], transport[2], 1.0]);
    set("translucency", &[scene.light.translucency]);
    set("scatter", &[scene.light.scatter]);
    set("sample_reach", &[reach]);
    set("steepness", &[steepness(frame)]);
    set("box_margin", &[reach + shift]);
    set("ray_scale", &[view.ray_scale[0], view.ray_scale[1], 0.0, 0.0]);
    let [noise_cells, turbulence_cells, channel_cells] = scene.block_cells().map(|cells| cells as f32);
    set("noise_cells", &[noise_cells]);
    set("turbulence_cells", &[turbulence_cells]);
    set("channel_cells", &[channel_cells]);
    let [turbulence_octaves, low_octaves] = scene.block_octaves().map(|octaves| octaves as f32);
    set("turbulence_octaves", &[turbulence_octaves]);
    set("low_octaves", &[low_octaves]);
    let [noise, turbulence] = variant.periods;
    set("noise_period", &[noise.cells as f32]);
    set("turbulence_period", &[turbulence.cells as f32]);
    set("turbulence_growth", &[f32::from(u8::from(turbulence.growing))]);
    set("turbulence_cycle", &[turbulence.cycle as f32]);
    set("random_mean", &[noise_blocks::random_mean(scene)]);
    for item in items {
        set_object(item, view, &mut |name, floats| set(&suffixed(name, &item.suffix), floats));
    }
    Values { named, time: time as f32 }
}

/// Sets the members of `part.glsl` and the parameters of one object.
fn set_object(item: &ObjectInputs<'_>, view: &View, set: &mut dyn FnMut(&str, &[f32])) {
    let (scene, subject, own) = (&item.scene, item.subject, item.own);
    set("normal_matrix", &(view.object_matrix * own.place).inverse().transpose().to_cols_array());
    set("place_matrix", &own.place.inverse().to_cols_array());
    set("place_scale", &[own.scale]);
    set("own_radius", &[own.own_radius]);
    set("own_min", &own.own_min.extend(own.base[0]).to_array());
    set("own_max", &own.own_max.extend(own.base[1]).to_array());

    // Texel-center mapping: sample i of n lies at texture coordinate (i + 0.5) / n.
    let (scale, offset, texel) = match &subject.field {
        None => (glam::Vec3::ZERO, glam::Vec3::ZERO, glam::Vec3::ONE),
        Some(field) => {
            let size = glam::UVec3::from(field.grid.size).as_vec3();
            let scale = 1.0 / (subject.scale * field.grid.spacing * size);
            let offset = ((subject.center - field.grid.origin) / field.grid.spacing + 0.5) / size;
            (scale, offset, 1.0 / size)
        }
    };
    set("volume_scale", &scale.extend(0.0).to_array());
    set("volume_offset", &offset.extend(0.0).to_array());
    set("volume_texel", &texel.extend(0.0).to_array());
    set("distance_decode", &[item.stored.decode[0], item.stored.decode[1], 0.0, 0.0]);
    set("skip_slack", &[item.skip_slack()]);
    set("hold_radius", &[own.spread.hold_radius]);
    set("closest_range", &[item.stored.closest_range]);
    set("opacity_rate", &[scene.effect.opacity_rate]);

    let color = |rgb: [f32; 3], factor: f32| [rgb[0] * factor, rgb[1] * factor, rgb[2] * factor, 1.0];
    set("material_color", &color(scene.material.color.linear(), 1.0));
    set("ambient_color", &color(scene.light.ambient.linear(), 1.0));
    set("light_color", &color(scene.light.color.linear(), scene.light.intensity));
    set("light_position", &view.light_eye.extend(1.0).to_array());
    set("transfer_color", &transfer_texel(&scene.transfer));
    set("specular_power", &[scene.material.specular_power]);
    set("specular_strength", &[scene.material.specular]);
    set("iso_value", &[scene.object.inner_iso]);
    set("outer_iso_value", &[own.outer_iso]);
    for (parameter, value) in item.parameters.iter() {
        match value {
            ParameterValue::Number(number) => set(&parameter.name, &[*number]),
            ParameterValue::Color(rgb) => set(&parameter.name, &color(rgb.linear(), 1.0)),
        }
    }
}

/// Lipschitz bound assumed for warped distances. Higher: needless edge searches. Lower: the thinnest drips of `melting`
/// are clipped.
const WARPED_LIPSCHITZ: f32 = 2.0;

/// Distance along the ray within which a sample looks for matter, object units; 0 if it stands for its point alone.
fn sample_reach(frame: &FrameContext) -> f32 {
    let steps = match frame.variant.scene.quality.integration {
        Integration::Segment => 0.5,
        Integration::Point => f32::from(u8::from(frame.variant.looks_back)),
    };
    steps * longest_step(frame)
}

/// Distance to the matter within which a point sample searches along its ray, object units.
pub(crate) fn search_distance(frame: &FrameContext) -> f32 {
    steepness(frame) * sample_reach(frame)
}

fn steepness(frame: &FrameContext) -> f32 {
    if frame.variant.has_warps() { WARPED_LIPSCHITZ * frame.subject.strength() } else { 1.0 }
}

/// Longest step along a ray, object units.
fn longest_step(frame: &FrameContext) -> f32 {
    let scene = &frame.variant.scene;
    frame.planes.step * slant(scene, &frame.view) / glam::Vec3::from(scene.object.stretch).min_element()
}
