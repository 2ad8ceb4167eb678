//! Images and samplers of `interface.glsl` and `part.glsl`, by meaning.
//!
//! Invariant: names of bindings stand here alone. An additional object `NAME` has images of its own, whose names end in
//! `_NAME`.

/// Declares images: each with the name of its binding and its name in words.
macro_rules! images {
    ($(#[$doc:meta])* $name:ident in $group:ident { $($(#[$of:meta])* $image:ident = $binding:literal, $label:literal;)* }) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, PartialEq, Eq)]
        pub enum $name {
            $($(#[$of])* $image,)*
        }

        impl $name {
            /// All of them.
            const ALL: &[$name] = &[$($name::$image),*];

            /// Name of the binding of the scene, or of its main object.
            pub const fn binding(self) -> &'static str {
                match self {
                    $($name::$image => $binding,)*
                }
            }

            /// Name in words.
            pub const fn label(self) -> &'static str {
                match self {
                    $($name::$image => $label,)*
                }
            }
        }

        impl From<$name> for ImageInput {
            fn from(image: $name) -> ImageInput {
                ImageInput::$group(image)
            }
        }
    };
}

/// An image that a program may read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageInput {
    /// Noise, which belongs to no object.
    Noise(NoiseImage),
    /// Data of an object.
    Object(ObjectImage),
    /// The groom of the scene.
    Groom(GroomImage),
    /// The result of a pass that is drawn with the picture.
    Pass(PassImage),
}

images! {
    /// Noise and turbulence in blocks, tables of noise, and jitter.
    NoiseImage in Noise {
        /// Block of noise and its gradient.
        Noise = "noise_image", "noise block";
        /// Block of noise.
        NoiseValues = "noise_value_image", "noise values";
        /// Block of turbulence and its gradient.
        Turbulence = "turbulence_image", "turbulence block";
        /// Block of turbulence.
        TurbulenceValues = "turbulence_value_image", "turbulence values";
        /// Block of the first octaves of turbulence.
        LowOctaves = "low_octaves_image", "low octaves";
        /// Block of four octaves of noise, one in each channel.
        Channels = "channel_image", "four octaves";
        /// Block of random texels.
        Random = "random_image", "random texels";
        /// Permutation of the table of noise.
        Permutation = "permutation_image", "permutation";
        /// Gradients of the table of noise.
        Gradients = "gradient_image", "table of gradients";
        /// Jitter phases of a tile of pixels.
        Phases = "phase_image", "phases of the pixels";
    }
}

images! {
    /// The field of an object, and tables and volumes of its colors.
    ObjectImage in Object {
        /// Distances, and normals in some encodings.
        Volume = "volume_image", "distance field";
        /// Index of the stored bricks of a volume.
        Bricks = "brick_image", "index of bricks";
        /// Offsets to the closest points of the surface.
        Closest = "closest_image", "closest points";
        /// Colors of voxels.
        Classified = "classified_image", "classified volume";
        /// Color and opacity by density.
        Transfer = "transfer_image", "transfer map";
        /// Index of refraction by density.
        Index = "index_image", "index map";
        /// Color and opacity of a segment by the densities at its ends.
        Segment = "segment_image", "segment table";
    }
}

images! {
    /// Painted channels.
    GroomImage in Groom {
        /// Direction and length.
        Shape = "groom_shape_image", "groom";
        /// Color and density.
        Look = "groom_look_image", "groom";
        /// Strength of warps and DMFs.
        Amount = "groom_amount_image", "groom";
    }
}

images! {
    /// Results of passes.
    PassImage in Pass {
        /// Light left before each segment of the light's rays.
        Shadow = "shadow_image", "shadow volume";
        /// Light left before a slice.
        LightBefore = "light_before_image", "light";
        /// Light left behind a slice.
        LightBehind = "light_behind_image", "light";
        /// Cells proven to be empty.
        Cells = "cell_image", "cells";
        /// The picture so far, in the program of the opaque mask.
        Target = "target_image", "picture";
    }
}

impl ImageInput {
    /// The image of a binding, and its object: `""` for an image of the scene or of its main object.
    pub fn of(binding: &str) -> Option<(ImageInput, &str)> {
        ImageInput::all().find_map(|image| match (binding.strip_prefix(image.binding())?, image) {
            ("", _) => Some((image, "")),
            (suffix, ImageInput::Object(_)) => Some((image, suffix.strip_prefix('_')?)),
            _ => None,
        })
    }

    /// Name of the binding of the scene, or of its main object.
    pub const fn binding(self) -> &'static str {
        match self {
            ImageInput::Noise(own) => own.binding(),
            ImageInput::Object(own) => own.binding(),
            ImageInput::Groom(own) => own.binding(),
            ImageInput::Pass(own) => own.binding(),
        }
    }

    /// Name in words.
    pub const fn label(self) -> &'static str {
        match self {
            ImageInput::Noise(own) => own.label(),
            ImageInput::Object(own) => own.label(),
            ImageInput::Groom(own) => own.label(),
            ImageInput::Pass(own) => own.label(),
        }
    }

    /// All images.
    fn all() -> impl Iterator<Item = ImageInput> {
        fn each<T: Copy + Into<ImageInput>>(all: &'static [T]) -> impl Iterator<Item = ImageInput> {
            all.iter().map(|own| (*own).into())
        }
        each(NoiseImage::ALL).chain(each(ObjectImage::ALL)).chain(each(GroomImage::ALL)).chain(each(PassImage::ALL))
    }
}

impl NoiseImage {
    /// Whether it is a block, with the side `quality.block_size`.
    pub const fn is_block(self) -> bool {
        !matches!(self, NoiseImage::Permutation | NoiseImage::Gradients | NoiseImage::Phases)
    }
}

/// A sampler that a program may use.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum SamplerInput {
    /// That of tables of one and two dimensions, which clamps.
    Table,
    /// That of volumes, which clamps.
    #[default]
    Clamp,
    /// That of tables of noise, which repeats.
    Repeat,
    /// That of blocks.
    Block,
}

impl SamplerInput {
    /// Name of the binding.
    pub const fn binding(self) -> &'static str {
        match self {
            SamplerInput::Table => "table_sampler",
            SamplerInput::Clamp => "clamp_sampler",
            SamplerInput::Repeat => "repeat_sampler",
            SamplerInput::Block => "block_sampler",
        }
    }

    /// The sampler of a binding.
    pub fn of(binding: &str) -> Option<SamplerInput> {
        let all = [SamplerInput::Table, SamplerInput::Clamp, SamplerInput::Repeat, SamplerInput::Block];
        all.into_iter().find(|sampler| sampler.binding() == binding)
    }
}

impl ObjectImage {
    /// Whether it is made of the transfer map.
    pub const fn is_of_transfer(self) -> bool {
        match self {
            ObjectImage::Transfer | ObjectImage::Index | ObjectImage::Segment | ObjectImage::Classified => true,
            ObjectImage::Volume | ObjectImage::Bricks | ObjectImage::Closest => false,
        }
    }

    /// Whether the texels depend on the distance between samples.
    pub const fn depends_on_step(self) -> bool {
        match self {
            ObjectImage::Segment | ObjectImage::Bricks => true,
            ObjectImage::Volume
            | ObjectImage::Transfer
            | ObjectImage::Index
            | ObjectImage::Classified
            | ObjectImage::Closest => false,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader;

    #[test]
    fn images_are_those_of_the_interface() {
        let library = shader::shipped();
        let text = ["interface.glsl", "part.glsl"].map(|file| library.source(file).unwrap()).concat();
        let declared = text.lines().filter_map(|line| line.split_once(" uniform texture")?.1.split([' ', ';']).nth(1));
        let mut declared: Vec<&str> = declared.collect();
        let mut known: Vec<&str> = ImageInput::all().map(ImageInput::binding).collect();
        declared.sort_unstable();
        known.sort_unstable();
        assert_eq!(known, declared);
    }

    #[test]
    fn samplers_are_those_of_the_interface() {
        let library = shader::shipped();
        let text = library.source("interface.glsl").unwrap();
        let declared = text.lines().filter_map(|line| line.split_once(" uniform sampler ")?.1.split(';').next());
        let declared: Vec<&str> = declared.collect();
        assert!(declared.len() == 4 && declared.iter().all(|name| SamplerInput::of(name).is_some()), "{declared:?}");
    }

    #[test]
    fn objects_have_images_of_their_own() {
        let volume = ObjectImage::Volume.into();
        assert_eq!(ImageInput::of("noise_value_image"), Some((NoiseImage::NoiseValues.into(), "")));
        assert_eq!(ImageInput::of("volume_image"), Some((volume, "")));
        assert_eq!(ImageInput::of("volume_image_left_wing"), Some((volume, "left_wing")));
        assert_eq!(["volume_images", "shadow_image_b", "View"].map(ImageInput::of), [None; 3]);
    }
}
