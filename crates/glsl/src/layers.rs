//! Layers of the soft region: DMFs with widths of their own, and a medium for each.
//!
//! Source: MJ 6, which mentions different DMFs through the soft region as possible.

use super::declare::parse;
use super::error::LibraryError;
use super::library::Library;
use super::names::{definitions, suffixed};
use super::slots::{MEDIUM, MEDIUM_FUNCTIONS};

impl Library {
    /// The parameter for the width of a module's soft region; with a suffix for copies in a stack.
    ///
    /// # Errors
    /// An invalid declaration.
    pub fn width(&self, path: &str) -> Result<Option<String>, LibraryError> {
        let (file, copy) =
            path.split_once('#').map_or((path, String::new()), |(file, copy)| (file, format!("_{copy}")));
        let parameter = parse(file, self.source(file).unwrap_or_default())?.outer.pop();
        Ok(parameter.map(|parameter| suffixed(&parameter, &copy)))
    }

    /// Whether a medium defines its extinction.
    pub fn has_extinction(&self, media: &[String]) -> bool {
        let text = |name: &String| self.source(&format!("{MEDIUM}/{name}.glsl")).unwrap_or_default();
        media.iter().any(|name| definitions(text(name)).contains(MEDIUM_FUNCTIONS[1]))
    }

    /// Number of layers in a stack of DMFs: those with a width.
    ///
    /// # Errors
    /// [`LibraryError::Unknown`], or an invalid declaration.
    pub fn layers(&self, dmfs: &[String]) -> Result<usize, LibraryError> {
        let widths: Vec<_> = self.files("dmf", dmfs)?.iter().map(|file| self.width(file)).collect::<Result<_, _>>()?;
        Ok(widths.into_iter().flatten().count())
    }
}

/// Combines DMFs with widths of their own: each sees the density of its soft region, and their matter is united as `a + b - a b`
/// (PH 2.2), so that optical depths add.
pub(super) fn layered(glue: &mut String, signature: &str, layers: &[(String, String)]) {
    for (index, (width, calls)) in layers.iter().enumerate() {
        *glue += &format!(
            "float layer_{index}(inout Sample s) {{\n    \
             if (s.density < 1.0) s.density = min(soften(s.distance, {width}), BELOW_ONE);\n    \
             float density = s.density;\n    if (density <= 0.0) return 0.0;\n{calls}    \
             return clamp(density, 0.0, 1.0);\n}}\n"
        );
    }
    *glue += &format!("{signature} {{\n    Sample own = s, densest;\n");
    glue.push_str("    float part = layer_0(own), most = part;\n    density = part;\n    densest = own;\n");
    for index in 1..layers.len() {
        *glue += &format!(
            "    own = s;\n    part = layer_{index}(own);\n    density += part - density * part;\n    \
             if (part > most) {{ most = part; densest = own; }}\n"
        );
    }
    // A medium shared by all layers sees the sample of the densest.
    glue.push_str("    densest.density = s.density;\n    s = densest;\n");
    glue.push_str("    return density;\n}\n");
}

/// Combines a medium per layer, weighted by optical depth (PH 3.1).
pub(super) fn media(library: &Library, names: &[String]) -> Result<(String, String), LibraryError> {
    let (mut glue, mut shades, mut rates) = (String::new(), String::new(), String::new());
    for (index, file) in library.files(MEDIUM, names)?.iter().enumerate() {
        let tag = file.split_once('#').map_or("", |(_, tag)| tag);
        let sum = format!(
            "    own = s;\n    part = layer_{index}(own);\n    depth = -log(1.0 - min(part, BELOW_ONE));\n    \
             if (part > 0.0) sum += depth"
        );
        glue += &format!("#include \"{file}\"\n");
        shades += &format!("{sum} * extinction_{tag}(own, part) * vec4(medium_{tag}(own, part), 1.0);\n");
        rates += &format!("{sum} * vec2(extinction_{tag}(own, part), 1.0);\n");
    }
    glue += &format!(
        "vec3 medium(Sample s, float density) {{\n    Sample own;\n    float part, depth;\n    vec4 sum = vec4(0.0);\n{shades}    \
         return sum.rgb / max(sum.a, 1e-20);\n}}\n\
         float extinction(Sample s, float density) {{\n    Sample own;\n    float part, depth;\n    vec2 sum = vec2(0.0);\n{rates}    \
         return sum.x / max(sum.y, 1e-20);\n}}\n"
    );
    Ok((format!("stack of {MEDIUM}"), glue))
}
