//! Settings of accuracy against time.

use super::fields::setting::{choices, settings};

settings! {
    /// Accuracy against time.
    pub struct Quality: QualityField = "quality." {
        /// Method of sampling: rays or slices.
        pass: Pass = Pass::March => Images, Kind::Choice(Pass::CHOICES), flag("pass");
        /// Slices, or samples of a ray, through the bounding sphere.
        samples: u32 = 256 => Picture, whole(1.0, 100_000.0), usual(1.0, 4096.0), flag("samples");
        /// Integration along a ray.
        integration: Integration = Integration::Point => Images, Kind::Choice(Integration::CHOICES), flag("integration");
        /// Shader stage that traces rays: the same picture.
        stage: ShaderStage = ShaderStage::Auto => Targets, Kind::Choice(ShaderStage::CHOICES), flag("stage");
        /// Treatment of samples in empty space.
        empty_space: EmptySpace = EmptySpace::Skip => Images, Kind::Choice(EmptySpace::CHOICES), flag("empty-space");
        /// Whether terms that a parameter of 0 cancels are compiled out: the same picture but for roundings, sooner.
        fold_zero_terms: bool = true => Images, Kind::Switch;
        /// Transmittance below which a ray ends, and slices from front to back at the end of a batch: the largest error of a pixel.
        early_termination: f32 = 1e-4 => Targets, number(0.0, 0.5);
        /// Format of the render target of slices.
        target: TargetFormat = TargetFormat::Float32 => Targets, Kind::Choice(TargetFormat::CHOICES), flag("target");
        /// Order of the slices.
        order: Order = Order::FrontToBack => Targets, Kind::Choice(Order::CHOICES), flag("order");
        /// Shape of the slices.
        proxy: Proxy = Proxy::Polygons => Targets, Kind::Choice(Proxy::CHOICES), flag("proxy");
        /// Whether fragments of slices without matter are discarded (MJ 3.5). If not, they are blended with alpha 0 (MJ 7): the same picture.
        discard_empty_fragments: bool = true => Images, Kind::Switch;
        /// Samples per pixel, each of them shaded.
        msaa: u32 = 1 => Targets, Kind::OneOf(&[1, 2, 4, 8]), flag("msaa");
        /// Phase of the steps along the ray of each pixel: noise in place of banding.
        jitter: Jitter = Jitter::None => Images, Kind::Choice(Jitter::CHOICES), flag_alone("jitter", "hash");
        /// Seed of the phases.
        seed: u32 = 0 => View, whole(0.0, 16_777_215.0), usual(0.0, 1000.0), flag("seed");
        /// Pictures whose mean is the result; each has its own position in the pixel, phase and time.
        supersampling: u32 = 1 => Picture, whole(1.0, 256.0), flag("supersampling");
        /// Interpolation between the texels of volumes, blocks and tables; anisotropic filters are those of the device.
        filter: Filter = Filter::Device => Images, Kind::Choice(Filter::CHOICES), flag("filter");
        /// Anisotropy of the filter of volumes; 1 is off. Blocks of noise have none.
        anisotropy: f32 = 1.0 => Images, number(1.0, 16.0), flag("anisotropy");
        /// Texels along a side of the blocks of noise and turbulence.
        block_size: u32 = 64 => Images, Kind::OneOf(&[16, 32, 64, 128, 256]), unit(Unit::Texels);
        /// Lattice cells of the first octave across the block of turbulence, at most half of block_size. Half as many: one octave more, and the pattern repeats after half the distance.
        turbulence_cells: u32 = 4 => Images, Kind::OneOf(&[1, 2, 4, 8, 16, 32, 64]);
        /// Continuation of a block beyond its border.
        wrap: Wrap = Wrap::Repeat => Images, Kind::Choice(Wrap::CHOICES);
        /// Format of the texels of a block.
        block_format: BlockFormat = BlockFormat::Auto => Images, Kind::Choice(BlockFormat::CHOICES);
        /// Standard deviation of the blur of noise = random, texels.
        block_blur: f32 = 0.7 => Images, number(0.0, 4.0), unit(Unit::Texels);
    }
}

choices! {
    /// Method of sampling.
    pub enum Pass {
        /// Rays through the pixels, sampled where the slices would be (PH): the same picture, sooner.
        #[default]
        March = "march",
        /// View-aligned slices, blended (MJ); half-angle slicing needs them.
        Slices = "slices",
    }
}

choices! {
    /// Integration along a ray.
    pub enum Integration {
        /// Density at points; hard surfaces are located. Second order in smooth matter, first order at a hard core.
        #[default]
        Point = "point",
        /// Density linear over half a step to either side. Second order at surfaces and in opaque matter.
        Segment = "segment",
    }
}

choices! {
    /// Shader stage that traces rays.
    pub enum ShaderStage {
        /// The faster one for a program on this device, as timed on a part of its first large picture.
        #[default]
        Auto = "auto",
        /// Fragment shaders.
        Fragment = "fragment",
        /// Compute shaders: rays, one sample per pixel, a target of 32-bit floats; fragment shaders draw the rest.
        Compute = "compute",
    }
}

choices! {
    /// Treatment of samples in empty space.
    #[non_exhaustive]
    pub enum EmptySpace {
        /// Samples that bounds, or for rays the distance, prove empty are skipped: the same picture, sooner; bent rays may end elsewhere in some pixels.
        #[default]
        Skip = "skip",
        /// All samples are taken.
        Sample = "sample",
    }
}

choices! {
    /// Source of the phases of the pixels.
    #[non_exhaustive]
    pub enum Jitter {
        /// The same phase for all pixels: banding where steps are long.
        #[default]
        None = "none",
        /// A hash of the pixel: white noise.
        Hash = "hash",
        /// A tile of blue noise: the same error as fine grain.
        Blue = "blue",
    }
}

choices! {
    /// Format of the render target of slices.
    pub enum TargetFormat {
        /// 8 bits, as in MJ; loses thin matter.
        Unorm8 = "unorm8",
        /// 16-bit floats.
        Float16 = "float16",
        /// 32-bit floats.
        #[default]
        Float32 = "float32",
    }
}

choices! {
    /// Order of the slices.
    pub enum Order {
        /// Nearest first.
        #[default]
        FrontToBack = "front_to_back",
        /// Farthest first.
        BackToFront = "back_to_front",
    }
}

choices! {
    /// Shape of the slices.
    pub enum Proxy {
        /// Polygons, cut to the bounding box of the soft region.
        #[default]
        Polygons = "polygons",
        /// Quads that fit every rotation, as in MJ.
        Quads = "quads",
    }
}

choices! {
    /// Interpolation between the texels of volumes, blocks and tables.
    #[non_exhaustive]
    pub enum Filter {
        /// One lookup by the device, with weights of 8 bits on most GPUs.
        #[default]
        Device = "device",
        /// Up to eight lookups by the shader, with weights of 32 bits.
        Exact = "exact",
    }
}

impl Filter {
    /// The fastest filter with floating-point weights, or with those of the device if they have as many bits.
    pub fn precise(device_has_few_bits: bool) -> Filter {
        if device_has_few_bits { Filter::Exact } else { Filter::Device }
    }
}

choices! {
    /// Continuation of a block beyond its border.
    #[non_exhaustive]
    pub enum Wrap {
        /// The block repeats, without a seam.
        #[default]
        Repeat = "repeat",
        /// Its mirror image, with twice the period and creases (MJ 4.1).
        Mirror = "mirror",
    }
}

choices! {
    /// Format of the texels of a block.
    #[non_exhaustive]
    pub enum BlockFormat {
        /// 32-bit floats for values alone; 16 bits a channel with gradients.
        #[default]
        Auto = "auto",
        /// 8 bits a channel.
        Unorm8 = "unorm8",
        /// 16 bits a channel.
        Unorm16 = "unorm16",
        /// 32-bit floats.
        Float32 = "float32",
    }
}
