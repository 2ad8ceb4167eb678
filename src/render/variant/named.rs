//! Images that the modules of a program name.
//!
//! Role: answers where a program is not linked yet, which takes up to a second. Comments and other names do not count; an
//! image that a module names but never reads does, while [`Program::images`](super::Program::images) leaves it out.

use super::bindings::ImageInput;
use super::scene_variant::Variant;
use crate::shader::slots::{PART, objects, qualified};
use crate::shader::{Library, find_word};

/// File of the resources that a scene has once.
const INTERFACE: &str = "interface.glsl";

impl Variant {
    /// Whether a module of any object looks noise or turbulence up in a block.
    pub fn reads_block(&self, library: &Library) -> bool {
        let is_block = |image| matches!(image, ImageInput::Noise(own) if own.is_block());
        [""].into_iter().chain(objects(&self.slots)).any(|object| self.names(library, object, is_block))
    }

    /// Whether an object takes colors, opacities or indices of refraction from its transfer map; `""` is the main object.
    /// A hidden object has no part in the variant.
    pub fn reads_transfer(&self, library: &Library, object: &str) -> bool {
        let is_made_of_it = |image| matches!(image, ImageInput::Object(own) if own.is_of_transfer());
        // A map of one color is a constant, without an image.
        self.slots.contains_key(&qualified(object, "transfer")) || self.names(library, object, is_made_of_it)
    }

    /// Whether a file that an object reaches names an image that satisfies a condition.
    fn names(&self, library: &Library, object: &str, is: impl Fn(ImageInput) -> bool) -> bool {
        let files = match object {
            "" => library.files_reached(&self.entries, &self.slots),
            object => library.object_files(object, &self.slots),
        };
        let declarations = [INTERFACE, PART].map(|file| library.source(file).unwrap_or_default());
        let accessors: Vec<(&str, ImageInput)> =
            declarations.into_iter().flat_map(str::lines).filter_map(accessor).collect();
        let image = |word: &str| {
            let of_accessor = accessors.iter().find(|(name, _)| *name == word).map(|(_, image)| *image);
            of_accessor.or_else(|| Some(ImageInput::of(word)?.0))
        };
        let files = files.unwrap_or_default();
        let paths = files.iter().map(|file| file.split('#').next().unwrap_or_default());
        let texts = paths.filter(|path| ![INTERFACE, PART].contains(path)).filter_map(|path| library.source(path));
        texts.into_iter().any(|text| find_word(text, |word| image(word).is_some_and(&is)).is_some())
    }
}

/// Name and image of a line `#define NAME sampler3D(IMAGE, SAMPLER)`.
fn accessor(line: &str) -> Option<(&str, ImageInput)> {
    let (name, constructor) = line.strip_prefix("#define ")?.split_once(' ')?;
    let (_, arguments) = constructor.split_once('(')?;
    let (image, _) = ImageInput::of(arguments.split_once(',')?.0)?;
    Some((name, image))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Scene, preset};
    use crate::shader;

    #[test]
    fn blocks_in_comments_are_not_read() {
        let read = |text: &str| {
            let library = shader::shipped().with_module("turbulence", "mine", text);
            let mut scene = preset("fire").unwrap();
            (scene.effect.turbulence, scene.effect.noise) = ("mine".into(), "procedural".into());
            scene.quality.samples = 16;
            Variant::of(&scene, &library).unwrap().reads_block(&library)
        };
        assert!(!read("/* as noise_block */ float my_block(vec3 p) { return 0.5; } // no turbulence_image"));
        assert!(read("float turbulence(vec3 p) { return lookup_block(low_octaves_block, p, 0.0).r; }"));
        assert!(read("#include \"noise_fetch.glsl\"\n"));
    }

    #[test]
    fn transfer_maps_are_read_by_modules_that_include_them() {
        let library = shader::shipped().with_module(
            "medium",
            "mine",
            "// transfer: none\nvec3 medium(Sample s, float d) { return vec3(d); }",
        );
        let read = |effect: &str, change: &dyn Fn(&mut Scene)| {
            let mut scene = preset(effect).unwrap();
            change(&mut scene);
            scene.drop_foreign_parameters(&library).unwrap();
            Variant::of(&scene, &library).unwrap().reads_transfer(&library, "")
        };
        assert!(read("fire", &|_| ()));
        assert!(!read("fire", &|scene| scene.effect.medium = "mine".into()));
        assert!(!read("lit", &|_| ()));
        assert!(read("solid", &|_| ()), "by a file that its surface includes");
        for classify in ["post", "pre", "preintegrated"] {
            assert!(read("fire", &|scene| scene.effect.classify = classify.into()), "{classify}");
        }
    }
}
