//! Layers of the soft region: DMFs that each have a width of their own, and a medium for each.
//!
//! Source: MJ 6: different DMFs through the soft region, possible and not done in the paper.

use super::declare::parse;
use super::error::LibraryError;
use super::library::{Library, MEDIUM, MEDIUM_FUNCTIONS};
use super::names::definitions;
use std::fmt::Write;

impl Library {
    /// The parameter by which a module says how wide its soft region is; of its second copy in a stack, that of the copy.
    ///
    /// # Errors
    /// A declaration that cannot be read.
    pub fn width(&self, path: &str) -> Result<Option<String>, LibraryError> {
        let (file, copy) =
            path.split_once('#').map_or((path, String::new()), |(file, copy)| (file, format!("_{copy}")));
        let parameter = parse(file, self.source(file).unwrap_or_default())?.outer.pop();
        Ok(parameter.map(|parameter| parameter + &copy))
    }

    /// Whether one of these media says how opaque it is.
    pub fn has_extinction(&self, media: &[String]) -> bool {
        let text = |name: &String| self.source(&format!("{MEDIUM}/{name}.glsl")).unwrap_or_default();
        media.iter().any(|name| definitions(text(name)).contains(MEDIUM_FUNCTIONS[1]))
    }

    /// How many DMFs of a stack make layers: those that say how wide their soft region is.
    ///
    /// # Errors
    /// [`LibraryError::Unknown`], or a declaration that cannot be read.
    pub fn layers(&self, dmfs: &[String]) -> Result<usize, LibraryError> {
        let widths: Vec<_> = self.files("dmf", dmfs)?.iter().map(|file| self.width(file)).collect::<Result<_, _>>()?;
        Ok(widths.into_iter().flatten().count())
    }
}

/// DMFs that each say how wide their soft region is: each sees the density of its own, and the matter of all of them is
/// in one another, `a + b - a b` (PH 2.2), so that their optical depths add.
pub(super) fn layered(glue: &mut String, signature: &str, layers: &[(String, String)]) {
    for (index, (width, calls)) in layers.iter().enumerate() {
        write!(
            glue,
            "float layer_{index}(inout Sample s) {{\n    \
             if (s.density < 1.0) s.density = min(soften(s.distance, {width}), BELOW_ONE);\n    \
             float density = s.density;\n    if (density <= 0.0) return 0.0;\n{calls}    \
             return clamp(density, 0.0, 1.0);\n}}\n"
        )
        .expect("writing to a string");
    }
    write!(glue, "{signature} {{\n    Sample own = s, densest;\n").expect("writing to a string");
    glue.push_str("    float part = layer_0(own), most = part;\n    density = part;\n    densest = own;\n");
    for index in 1..layers.len() {
        write!(
            glue,
            "    own = s;\n    part = layer_{index}(own);\n    density += part - density * part;\n    \
             if (part > most) {{ most = part; densest = own; }}\n"
        )
        .expect("writing to a string");
    }
    // What the densest layer left in its sample stays for a medium that serves them all.
    glue.push_str("    densest.density = s.density;\n    s = densest;\n");
    glue.push_str("    return density;\n}\n");
}

/// A medium for each layer: each colors its own in proportion to its optical depth there (PH 3.1).
pub(super) fn media(library: &Library, names: &[String]) -> Result<(String, String), LibraryError> {
    let (mut glue, mut shades, mut rates) = (String::new(), String::new(), String::new());
    for (index, file) in library.files(MEDIUM, names)?.iter().enumerate() {
        let tag = file.split_once('#').map_or("", |(_, tag)| tag);
        let sum = format!(
            "    own = s;\n    part = layer_{index}(own);\n    depth = -log(1.0 - min(part, BELOW_ONE));\n    \
             if (part > 0.0) sum += depth"
        );
        writeln!(glue, "#include \"{file}\"").expect("writing to a string");
        writeln!(shades, "{sum} * extinction_{tag}(own, part) * vec4(medium_{tag}(own, part), 1.0);")
            .expect("writing to a string");
        writeln!(rates, "{sum} * vec2(extinction_{tag}(own, part), 1.0);").expect("writing to a string");
    }
    write!(
        glue,
        "vec3 medium(Sample s, float density) {{\n    Sample own;\n    float part, depth;\n    vec4 sum = vec4(0.0);\n{shades}    \
         return sum.rgb / max(sum.a, 1e-20);\n}}\n\
         float extinction(Sample s, float density) {{\n    Sample own;\n    float part, depth;\n    vec2 sum = vec2(0.0);\n{rates}    \
         return sum.x / max(sum.y, 1e-20);\n}}\n"
    )
    .expect("writing to a string");
    Ok((format!("stack of {MEDIUM}"), glue))
}
