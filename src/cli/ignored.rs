//! What was asked for and changes nothing, in one line.

use super::args::Render;
use crate::render::{Subject, ignored};
use crate::scene::Scene;
use crate::shader::Library;
use std::path::Path;

impl Render {
    /// What changes nothing, with commas between; `None` if all that was asked for does something. `base` is what was there
    /// before, `asked` the scene as the file and the arguments have it, `drawn` that which `--max-error` may have changed.
    pub fn ignored(&self, library: &Library, subject: &Subject, [base, asked, drawn]: [&Scene; 3]) -> Option<String> {
        let (before, after) = (base.fields(), drawn.fields());
        let set: Vec<_> = asked.fields().into_iter().filter(|field| !before.contains(field)).collect();
        let said = |(name, value): &(String, toml::Value)| format!("{name} = {value}");
        let replaced = set.iter().filter(|field| !after.contains(field));
        let mut all: Vec<String> = replaced.map(|field| format!("{} (--max-error chooses)", said(field))).collect();
        let own: Vec<String> = set.iter().map(said).collect();
        all.extend(ignored(library, subject, base, drawn).into_iter().filter(|field| own.contains(field)));
        let ends = |path: &Path, end: &str| path.extension().is_some_and(|own| own.eq_ignore_ascii_case(end));
        if self.depth != "8" && (ends(&self.output, "exr") || self.predict) {
            all.push(format!("--depth {}", self.depth));
        }
        if self.predict && self.output != Path::new("out.png") {
            all.push(format!("--output {}", self.output.display()));
        }
        (!all.is_empty()).then(|| all.join(", "))
    }
}
