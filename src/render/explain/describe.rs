//! Description of a picture's inputs in words.

use super::warnings::warnings;
use crate::render::measurements::Measurements;
use crate::render::subject::Subject;
use crate::render::variant::{Variant, why_left_out};
use crate::scene::Pass;
use crate::shader::Library;
use crate::shader::slots::FOLDED;

/// Lines on the inputs of a picture, on omitted parts and on warnings: pairs of a topic and a text.
pub fn describe_frame(m: &Measurements, variant: &Variant, subject: &Subject, library: &Library) -> Vec<[String; 2]> {
    let line = |about: &str, what: String| [about.to_string(), what];
    let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    let mut lines = vec![
        line("program", if m.shipped { "ships" } else { "linked for this scene" }.into()),
        line("modules", m.modules.clone()),
    ];
    if variant.scene.quality.pass == Pass::March {
        let stage = if m.is_compute { "compute" } else { "fragment" };
        let phases = if m.is_direct { "one phase" } else { "two phases, finding and shading" };
        lines.push(line("rays", format!("{stage} shader, in {phases}")));
    }
    for image in m.images.iter().filter(|image| image.size != [1; 3]) {
        let axes = image.size.iter().rposition(|side| *side > 1).map_or(1, |last| last + 1);
        let size = image.size[..axes].iter().map(u32::to_string).collect::<Vec<_>>().join(" x ");
        let (name, channels, bits) = (&image.name, image.channels, image.bits);
        lines.push(line("reads", format!("{name}: {size}, {channels} x {bits} bits, {:.2} MiB", mib(image.bytes))));
    }
    lines.extend(m.left_out.iter().map(|part| line("left out", format!("{part}: {}", why_left_out(part)))));
    let zero = variant.slots.get(FOLDED).map(|names| names.join(", "));
    lines.extend(zero.map(|names| line("left out", format!("terms of parameters that are 0: {names}"))));
    lines.extend(octaves_held(m, variant, library).map(|text| line("octaves", text)));
    lines.extend(m.cells.as_ref().map(|cells| line("cells", cells.to_string())));
    lines.extend(warnings(m, variant, subject, library).into_iter().map(|text| line("note", text)));
    lines.push(line("memory", format!("{:.1} MiB of images on the device", mib(m.device_bytes))));
    lines
}

/// Notes the octaves that a scene requests beyond their limit.
pub fn octaves_held(m: &Measurements, variant: &Variant, library: &Library) -> Option<String> {
    let [held, asked] = m.octaves.filter(|[held, asked]| held < asked)?;
    Some(format!("{held} of {asked}: {}", variant.scene.octaves_limit(library)))
}
