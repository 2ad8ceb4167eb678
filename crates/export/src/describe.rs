//! The description of a scene for its host, as JSON.

use crate::ExportError;
use hypertexture::gpu::{Address, Dimension, Format};
use hypertexture::render::variant::Use;
use hypertexture::render::{
    Portable, PortableImage, PortableMotion, PortableParameter, PortableProgram, PortableSampler,
};
use hypertexture::scene::ParameterValue;
use hypertexture::shader::ParameterKind;
use serde_json::{Map, Value, json};

/// Longest side of a volume and of another image, and most bytes of all images, in browsers.
const SIDES: [u32; 2] = [2048, 8192];
const BYTES: usize = 1 << 30;

/// The description of a scene; `file` describes the file of an image.
pub(crate) fn describe(portable: &Portable, command: &str, file: impl Fn(&PortableImage) -> Value) -> Value {
    let scene = &portable.variant.scene;
    let image = |own: &PortableImage| {
        json!({
            "binding": own.binding, "name": own.name, "axes": axes(own.dimension), "size": own.dimension.size(),
            "format": format_name(own.format), "levels": own.levels, "bytes": own.bytes.len(), "file": file(own),
        })
    };
    let sampler = |own: &PortableSampler| {
        let address = match own.address {
            Address::Clamp => "clamp-to-edge",
            Address::Repeat => "repeat",
            Address::Mirror => "mirror-repeat",
        };
        json!({ "binding": own.binding, "name": own.name, "address": address, "anisotropy": own.anisotropy })
    };
    let values: Map<String, Value> =
        portable.values.iter().map(|(name, floats)| (name.clone(), numbers(floats))).collect();
    json!({
        "about": scene.about, "object": scene.object.input, "command": command, "size": scene.image.size,
        "background": scene.image.background.map(|color| color.linear()), "time": scene.camera.time,
        "moves": portable.motion.is_some() || portable.programs.iter().any(reads_time),
        "programs": portable.programs.iter().map(program).collect::<Value>(),
        "images": portable.images.iter().map(image).collect::<Value>(),
        "samplers": portable.samplers.iter().map(sampler).collect::<Value>(),
        "values": values,
        "parameters": portable.parameters.iter().map(parameter).collect::<Value>(),
        "sub_frames": portable.sub_frames,
        "motion": portable.motion.as_ref().map(motion),
    })
}

/// Checks the images against the limits of browsers.
pub(crate) fn check(portable: &Portable) -> Result<(), ExportError> {
    let all: usize = portable.images.iter().map(|image| image.bytes.len()).sum();
    for image in &portable.images {
        let size = image.dimension.size();
        let longest = size.iter().copied().max().unwrap_or_default();
        let is_volume = matches!(image.dimension, Dimension::Volume(..));
        if all > BYTES || longest > SIDES[usize::from(!is_volume)] {
            let limit = "1 GiB, volumes of 2048 texels a side and other images of 8192";
            return Err(ExportError::Large { name: image.name.clone(), size, bytes: all, limit });
        }
    }
    Ok(())
}

/// Whether a program depends on the time.
fn reads_time(own: &PortableProgram) -> bool {
    let read = own.program.members_read();
    own.program.resources.iter().any(|resource| match &resource.holds {
        Use::Block(block) => (0..)
            .zip(&block.members)
            .any(|(at, member)| member.name == "time" && read.contains(&(resource.binding, at))),
        _ => false,
    })
}

fn program(own: &PortableProgram) -> Value {
    let blocks = own.program.resources.iter().filter_map(|resource| {
        let Use::Block(block) = &resource.holds else { return None };
        let members = block.members.iter();
        let members = members.map(|own| json!({ "name": own.name, "offset": own.offset, "floats": own.floats }));
        let members: Value = members.collect();
        Some(json!({ "binding": resource.binding, "name": resource.name, "bytes": block.bytes, "members": members }))
    });
    let bindings = |kind: Use| -> Value {
        let own = own.program.resources.iter().filter(|own| own.holds == kind);
        own.map(|own| json!({ "binding": own.binding, "name": own.name })).collect()
    };
    let name = own.name;
    json!({
        "name": name, "entry": "main", "glsl": format!("{name}.frag"), "spirv": format!("{name}.spv"),
        "wgsl": format!("{name}.wgsl"), "blocks": blocks.collect::<Value>(), "images": bindings(Use::Image),
        "samplers": bindings(Use::Sampler),
    })
}

fn parameter(own: &PortableParameter) -> Value {
    let mut value = json!({ "name": own.name, "member": own.member, "doc": own.doc });
    match (own.kind, &own.value) {
        (ParameterKind::Number(_, range), ParameterValue::Number(number)) => {
            (value["value"], value["range"]) = (json!(number), json!(range));
        }
        (_, ParameterValue::Color(color)) => value["color"] = json!(String::from(*color)),
        _ => {}
    }
    let follow =
        own.follow.iter().map(|(name, all)| (name.clone(), all.iter().map(|floats| numbers(floats)).collect()));
    value["follow"] = Value::Object(follow.collect());
    value
}

fn motion(own: &PortableMotion) -> Value {
    let values = own.values.iter().map(|(name, all)| (name.clone(), all.iter().map(|all| numbers(all)).collect()));
    json!({ "seconds": own.seconds, "repeats": own.repeats, "values": values.collect::<Map<_, Value>>() })
}

/// Numbers, with the largest in place of infinities, which JSON lacks.
fn numbers(floats: &[f32]) -> Value {
    floats.iter().map(|float| json!(float.clamp(f32::MIN, f32::MAX))).collect()
}

fn axes(dimension: Dimension) -> u32 {
    match dimension {
        Dimension::Line(_) => 1,
        Dimension::Plane(..) => 2,
        Dimension::Volume(..) => 3,
    }
}

/// Name of a format in WebGPU.
fn format_name(format: Format) -> &'static str {
    match format {
        Format::R8Unorm => "r8unorm",
        Format::R16Unorm => "r16unorm",
        Format::R32Float => "r32float",
        Format::Rgba8Unorm => "rgba8unorm",
        Format::Rgba16Unorm => "rgba16unorm",
        Format::Rgba16Float => "rgba16float",
        Format::Rgba32Float => "rgba32float",
        _ => "none",
    }
}
