//! What a picture is made with, in words.

use super::cells::Found;
use super::variant::{Variant, why_left_out};
use super::{Measurements, RenderError, Subject, doubts};
use crate::scene::Scene;
use crate::shader::Library;
use crate::shader::slots::FOLDED;

/// A line for each thing that a picture is made with or that its scene leaves out, and for each doubt: what it is about, and
/// what there is.
///
/// # Errors
/// The scene has no program.
pub fn made_with(
    m: &Measurements,
    scene: &Scene,
    subject: &Subject,
    library: &Library,
) -> Result<Vec<[String; 2]>, RenderError> {
    let line = |about: &str, what: String| [about.to_string(), what];
    let mib = |bytes: u64| bytes as f64 / f64::from(1 << 20);
    let mut lines = vec![
        line("program", if m.shipped { "ships" } else { "linked for this scene" }.into()),
        line("modules", m.modules.clone()),
    ];
    for image in m.images.iter().filter(|image| image.size != [1; 3]) {
        let axes = image.size.iter().rposition(|side| *side > 1).map_or(1, |last| last + 1);
        let size = image.size[..axes].iter().map(u32::to_string).collect::<Vec<_>>().join(" x ");
        let (name, channels, bits) = (&image.name, image.channels, image.bits);
        lines.push(line("reads", format!("{name}: {size}, {channels} x {bits} bits, {:.2} MiB", mib(image.bytes))));
    }
    lines.extend(m.left_out.iter().map(|part| line("left out", format!("{part}: {}", why_left_out(part)))));
    let variant = Variant::of(scene, library)?;
    let zero = variant.slots.get(FOLDED).map(|names| names.join(", "));
    lines.extend(zero.map(|names| line("left out", format!("what these take away, as they are 0: {names}"))));
    lines.extend(
        masks_left_out(m, scene).map(|name| line("left out", format!("the mask of {name}: it lets all of it through"))),
    );
    lines.extend(octaves_held(m, scene, library).map(|text| line("octaves", text)));
    lines.extend(m.cells.as_ref().map(|cells| line("cells", cells.to_string())));
    lines.extend(doubts(m, scene, subject, library)?.into_iter().map(|text| line("note", text)));
    lines.push(line("memory", format!("{:.1} MiB of images on the device", mib(m.device_bytes))));
    Ok(lines)
}

/// The DMFs that were drawn without their mask.
fn masks_left_out<'a>(m: &'a Measurements, scene: &'a Scene) -> impl Iterator<Item = &'a String> {
    let own = [(String::new(), &scene.effect)].into_iter();
    let effects = own.chain(scene.parts.iter().map(|(name, part)| (format!("{name}."), &part.effect)));
    effects.flat_map(|(object, effect)| {
        let drawn = m.modules.split(' ').find_map(|slot| slot.strip_prefix(&format!("{object}dmf=")));
        let pairs = drawn.into_iter().flat_map(|drawn| effect.dmf.iter().zip(drawn.split('+')));
        pairs.filter(|(asked, drawn)| asked.contains('@') && !drawn.contains('@')).map(|(asked, _)| asked)
    })
}

/// What is said of octaves that a scene asks for in vain.
pub fn octaves_held(m: &Measurements, scene: &Scene, library: &Library) -> Option<String> {
    let [held, asked] = m.octaves.filter(|[held, asked]| held < asked)?;
    Some(format!("{held} of {asked}: {}", scene.octaves_limit(library)))
}

impl std::fmt::Display for Found {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Found { side, empty, ms, kept, why } = self;
        match why {
            Some(why) => write!(f, "none: {why}"),
            None => {
                let share = 100.0 * empty;
                let how = if *kept { "as kept on disk".into() } else { format!("in {ms:.0} ms") };
                write!(f, "{side} x {side} x {side}, {share:.0} % proven to be empty {how}")
            }
        }
    }
}
