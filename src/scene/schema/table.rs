//! The table of settings, in the order in which the window and the documentation show them.

use super::{Changes, Filled, Flag, Kind, Range, Setting};
use Changes::{Field, Images, Picture, Targets};
use Filled::{ByObject, ByScene};
use Kind::{Choice, Color, Module, Numbers, OneOf, Stack, Stops, Switch, Text, Wholes};

/// Every finite number.
pub(super) const ANY: Range = Range { low: f32::MIN, high: f32::MAX, usual: [0.0, 1.0] };

const fn setting(name: &'static str, kind: Kind, changes: Changes, doc: &'static str) -> Setting {
    Setting { name, doc, kind, optional: None, flag: None, changes }
}

const fn range(low: f32, high: f32) -> Range {
    Range { low, high, usual: [low, high] }
}

const fn number(low: f32, high: f32) -> Kind {
    Kind::Number(range(low, high))
}

const fn whole(low: f32, high: f32) -> Kind {
    Kind::Whole(range(low, high))
}

impl Setting {
    /// With a flag of the command line.
    const fn flag(mut self, name: &'static str) -> Setting {
        self.flag = Some(Flag { name, alone: None });
        self
    }

    /// With a flag that may stand alone.
    const fn flag_alone(mut self, name: &'static str, alone: &'static str) -> Setting {
        self.flag = Some(Flag { name, alone: Some(alone) });
        self
    }

    /// Off at first; the value that it is switched on with.
    const fn optional(mut self, on: &'static str) -> Setting {
        self.optional = Some(on);
        self
    }

    /// With a slider over a part of its range, or a step for it.
    const fn usual(mut self, low: f32, high: f32) -> Setting {
        if let Kind::Number(range) | Kind::Whole(range) | Numbers(_, range) = &mut self.kind {
            range.usual = [low, high];
        }
        self
    }
}

const UP: Kind = Choice(&[
    ("x", "x of the file points up."),
    ("y", "y of the file points up."),
    ("z", "z of the file points up."),
    ("-x", "-x of the file points up."),
    ("-y", "-y of the file points up."),
    ("-z", "-z of the file points up."),
]);
const SOURCE: Kind = Choice(&[
    ("auto", "A formula where the object has one, else a volume with normals if they are read."),
    ("normals16", "A volume: normal and distance, 4 x 16 bits."),
    ("normals8", "A volume: normal and distance, 4 x 8 bits."),
    ("distance16", "A volume: the distance alone, 16 bits."),
    ("distance32", "A volume: the distance alone, 32-bit float."),
]);
const STORAGE: Kind = Choice(&[
    ("dense", "All of the volume."),
    ("sparse", "Bricks that the surface or its soft region touches: less memory, slower lookups."),
]);
const BOOLEAN: Kind = Choice(&[
    ("algebraic", "Products, with fillets as wide as the soft regions."),
    ("minmax", "Minimum and maximum, with creases."),
]);
const REPEAT: Kind = Choice(&[
    ("own", "As the module has it by itself."),
    ("never", "Not at all."),
    ("noise_block", "As a block of noise."),
    ("turbulence_block", "As a block of turbulence."),
    ("channel_block", "As a block whose channels hold four octaves."),
]);
const RAY_PATH: Kind = Choice(&[
    ("straight", "Rays are straight lines."),
    ("refracted", "Rays bend where the index of refraction changes; needs pass march."),
]);
const CURVE: Kind = Choice(&[
    ("steps", "The value of the lower stop."),
    ("linear", "A straight line."),
    ("spline", "A smooth curve that never goes beyond the stops."),
]);
const METHOD: Kind = Choice(&[
    ("volume", "A volume, rendered before the picture: any light, slices and rays."),
    ("half_angle", "Slice by slice with the picture: slices alone; knows translucency."),
]);
const PROJECTION: Kind =
    Choice(&[("perspective", "Rays leave from one point."), ("parallel", "Rays leave side by side.")]);
const PASS: Kind = Choice(&[
    ("march", "Rays through the pixels, sampled where the slices would be: the same picture, sooner."),
    ("slices", "View-aligned slices, blended: the paper's; half-angle slicing needs them."),
]);
const INTEGRATION: Kind = Choice(&[
    ("point", "A sample stands for itself, hard surfaces are located: first order in soft matter."),
    ("segment", "It stands for half a step to either side: second order at surfaces and in opaque matter."),
]);
const EMPTY_SPACE: Kind = Choice(&[
    (
        "skip",
        "Those that neither bounds nor, to rays, the distance show to be empty: the same picture, sooner; rays that bend may end elsewhere in some pixels.",
    ),
    ("sample", "All of them."),
]);
const NEUTRAL: Kind = Choice(&[
    (
        "leave_out",
        "The program does without them and what they alone read: the same picture but for roundings, sooner.",
    ),
    ("keep", "They are computed and come to nothing."),
]);
const TARGET: Kind = Choice(&[
    ("unorm8", "8 bits: the paper's; loses thin matter."),
    ("float16", "16-bit float."),
    ("float32", "32-bit float."),
]);
const ORDER: Kind = Choice(&[("front_to_back", "Nearest first."), ("back_to_front", "Farthest first.")]);
const PROXY: Kind = Choice(&[
    ("polygons", "Cut to the box around the soft region."),
    ("quads", "Quads that fit every rotation: the paper's."),
]);
const REJECT: Kind =
    Choice(&[("discard", "They end at once."), ("keep", "They are blended with alpha 0: the same picture.")]);
const JITTER: Kind = Choice(&[
    ("none", "All pixels have the same: banding where steps are long."),
    ("hash", "A hash of the pixel: white noise."),
    ("blue", "A tile of blue noise: the same error, fine grain alone."),
]);
const FILTER: Kind = Choice(&[
    ("device", "The device: one lookup, whose weights have 8 bits on most GPUs."),
    ("exact", "The shader: eight lookups, and weights of 32 bits."),
]);
const WRAP: Kind = Choice(&[
    ("repeat", "The block again: it has no seam."),
    ("mirror", "Its mirror image: period twice as long, with creases."),
]);
const BLOCK_FORMAT: Kind = Choice(&[
    ("auto", "32-bit floats where it holds values alone, with gradients 16 bits each."),
    ("unorm8", "8 bits a channel."),
    ("unorm16", "16 bits a channel."),
    ("float32", "32-bit floats."),
]);

/// Every setting of a scene.
#[rustfmt::skip] // a line each
pub const SETTINGS: &[Setting] = &[
    setting("about", Text, Picture, "One sentence about the scene."),
    setting("preset", Text, Picture, "The preset that the scene starts from; what the file says goes over it.").optional("lit"),
    setting("combine", Text, Images, "The formula by which the objects make one, such as main - hole; nothing is the union of all.").optional("main"),
    setting("boolean", BOOLEAN, Images, "What the signs of that formula mean."),

    setting("object.input", Text, Field, "A built-in name (sphere, cube, torus, teapot, knot, ...), or the path of a mesh, a scalar volume or a distance field."),
    setting("object.grid", Text, Field, "The grid of an OpenVDB file with several; without one the grid density, else the first level set or fog volume.").optional("density").flag("grid"),
    setting("object.resolution", whole(8.0, 1024.0), Field, "Voxels along the longest side of the distance field.").flag("resolution"),
    setting("object.iso", Kind::Number(ANY), Field, "Iso-value of the surface of a scalar volume; without one, the lowest that info proposes; --iso 500,1300 sets those of aligned objects too.").optional("0.5").flag("iso"),
    setting("object.shell", number(0.0, 2.0), Field, "Thickness of the shell that the surface is made into, half of it to each side, object units; 0 makes what it encloses solid.").flag("shell"),
    setting("object.up", UP, Field, "The axis of the file that points up.").flag("up"),
    setting("object.stretch", Numbers(3, range(0.05, 20.0)), Images, "Factors along x, y and z by which the object is stretched before it is drawn.").usual(0.05, 4.0).flag("stretch"),
    setting("object.distance", Switch, Field, "Whether a volume holds signed distances, positive outside, although its file does not say so.").flag_alone("distance", "true"),
    setting("object.inner_iso", number(-2.0, 2.0), Images, "Signed distance at which the object starts, object units: its longest side is 2."),
    setting("object.outer_iso", number(-2.0, 2.0), Images, "Signed distance at which the soft region starts; the effect's own parameter goes before it."),
    setting("object.source", SOURCE, Field, "Where the distance comes from, and how it is stored.").flag("source"),
    setting("object.storage", STORAGE, Field, "Which part of a volume is on the device."),

    setting("transform.at", Numbers(3, range(-100.0, 100.0)), Images, "Position of the center of an additional object in object space of the scene.").usual(-2.0, 2.0),
    setting("transform.turn", Numbers(3, range(-1e6, 1e6)), Images, "Degrees about x, y and z.").usual(-180.0, 180.0),
    setting("transform.scale", number(0.01, 100.0), Images, "Its size against that of the scene's own object.").usual(0.01, 4.0),
    setting("transform.aligned", Switch, Field, "Whether it starts from where its file has it beside that of the scene's own object, such as bone in skin, and not from the middle."),

    setting("effect.dmf", Stack, Images, "Density modulation functions, applied from first to last; a mask says where one acts."),
    setting("effect.warp", Stack, Images, "Displacements of the position that is looked up, applied from first to last."),
    setting("effect.classify", Module(ByObject), Images, "How a sample becomes a color."),
    setting("effect.softness", Module(ByObject), Images, "How the distance becomes a density."),
    setting("effect.surface", Module(ByObject), Images, "Color of the hard region."),
    setting("effect.medium", Module(ByObject), Images, "Color of the soft region; where several DMFs have a width of their own, one for each in their order, as hair+flame, or one for all."),
    setting("effect.project", Module(ByObject), Images, "How a point finds the surface under it; auto is the formula of an object that is one, else its closest points."),
    setting("effect.opacity_rate", number(0.0, 1e9), Images, "How fast soft matter becomes opaque, per object unit: c of Perlin and Hoffert 3.1.").usual(0.1, 1000.0),
    setting("effect.noise", Module(ByScene), Images, "Where noise comes from."),
    setting("effect.noise_repeat", REPEAT, Images, "After how many cells the lattice of procedural noise repeats."),
    setting("effect.weights", Module(ByScene), Images, "Weights of the noise: cubic is of 1989, quintic of 2002."),
    setting("effect.turbulence", Module(ByScene), Images, "Where turbulence comes from: the turbulence strategy."),
    setting("effect.turbulence_repeat", REPEAT, Images, "After how many cells the lattice of each octave of procedural turbulence repeats."),
    setting("effect.octaves", whole(1.0, 10.0), Images, "Octaves of turbulence; an encoded block holds as many as it has texels for."),
    setting("effect.bandlimit", Module(ByScene), Images, "What becomes of octaves that are finer than a sample."),
    setting("effect.gradient", Module(ByScene), Images, "The normal that soft matter is lit by: analytic, central or three.").flag("gradient"),
    setting("effect.opacity", Module(ByScene), Images, "How density becomes opacity."),
    setting("effect.ray_path", RAY_PATH, Images, "The path of a ray through the object."),
    setting("effect.index", Module(ByScene), Images, "Where the index of refraction comes from."),
    setting("effect.absorption", Module(ByScene), Images, "What takes light from a ray that bends."),
    setting("effect.environment", Module(ByScene), Images, "What a ray that bends meets behind the object."),

    setting("transfer.curve", CURVE, Images, "What lies between two stops of the transfer map."),
    setting("transfer.stops", Stops, Images, "The transfer map: color, density and index of refraction by density; 1 to 256 stops."),

    setting("material.color", Color, Picture, "Color of the hard surface."),
    setting("material.specular", number(0.0, 10.0), Picture, "Strength of its highlight.").usual(0.0, 1.0),
    setting("material.specular_power", number(1.0, 1000.0), Picture, "Sharpness of its highlight."),

    setting("light.position", Numbers(3, range(-1e6, 1e6)), Picture, "Position from the center of the object: right, up, toward the camera; object units.").usual(-10.0, 10.0).flag("light"),
    setting("light.color", Color, Picture, "Color of the light."),
    setting("light.intensity", number(0.0, 1000.0), Picture, "Brightness of the light.").usual(0.0, 5.0),
    setting("light.ambient", Color, Picture, "Color of what comes from all sides."),
    setting("light.shadows", Switch, Images, "Whether matter casts shadows.").flag_alone("shadows", "true"),
    setting("light.shadow_resolution", whole(8.0, 2048.0), Picture, "Texels along a side of the volume of shadows, at most 256, or of the buffer of half_angle.").usual(16.0, 256.0),
    setting("light.method", METHOD, Images, "How the light that reaches a place is found."),
    setting("light.translucency", number(0.0, 1.0), Images, "Part of the light that soft matter scatters forward; needs half_angle."),
    setting("light.transport", Color, Images, "Part of the optical depth that scattered light is spared, by channel."),
    setting("light.scatter", number(0.0, 2.0), Images, "Standard deviation of the blur of scattered light after one object unit, object units."),

    setting("camera.projection", PROJECTION, Picture, "How rays leave the camera.").flag("projection"),
    setting("camera.azimuth", number(-1e6, 1e6), Picture, "Degrees around the vertical axis: 0 looks at the +z side, 90 at the +x side.").usual(-180.0, 180.0),
    setting("camera.elevation", number(-90.0, 90.0), Picture, "Degrees above the horizon."),
    setting("camera.rotation", Numbers(4, range(-10.0, 10.0)), Picture, "The turn from object space to that of the camera, a unit quaternion x, y, z, w, in place of azimuth and elevation.").optional("[0, 0, 0, 1]"),
    setting("camera.pan", Numbers(2, range(-100.0, 100.0)), Picture, "How far the picture is moved to the right and up, object units at the middle of the scene.").usual(-2.0, 2.0),
    setting("camera.zoom", number(0.01, 100.0), Picture, "1 fits the object into the picture; 2 is twice as close.").usual(0.1, 30.0),
    setting("camera.field_of_view", number(1.0, 120.0), Picture, "Vertical angle of view in degrees, perspective only."),
    setting("camera.time", number(-1e9, 1e9), Picture, "Time in seconds.").usual(0.0, 60.0).flag("time"),
    setting("camera.shutter", number(0.0, 1e6), Picture, "Seconds that the shutter stays open; needs several pictures: quality.supersampling.").usual(0.0, 1.0).flag("shutter"),
    setting("camera.clip", Numbers(4, range(-1e6, 1e6)), Picture, "a, b, c, d: keeps the points x, y, z of object space with a x + b y + c z <= d; the object spans -1 to 1.").usual(-2.0, 2.0).optional("[0, 0, 1, 0]").flag("clip"),
    setting("camera.matrices", Numbers(32, ANY), Picture, "A view matrix from object space to that of the camera and a projection matrix, column by column, in place of rotation, pan, zoom and angle of view.").optional("[1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, -5, 1, 3, 0, 0, 0, 0, 3, 0, 0, 0, 0, 0, -1, 0, 0, 0.1, 0]"),
    setting("camera.slice_stack", Switch, Targets, "Shows the stack of slices from the side; classify stack draws it."),

    setting("image.size", Wholes(2, range(1.0, 16384.0)), Targets, "Width and height in pixels.").flag("size"),
    setting("image.background", Color, Picture, "Color behind the object; without one it is transparent.").optional("#20242c").flag("background"),

    setting("quality.pass", PASS, Images, "How the samples are taken.").flag("pass"),
    setting("quality.samples", whole(1.0, 100_000.0), Picture, "Slices, or samples of a ray, through the sphere around the object.").usual(1.0, 4096.0).flag("samples"),
    setting("quality.integration", INTEGRATION, Images, "What a sample stands for.").flag("integration"),
    setting("quality.empty_space", EMPTY_SPACE, Images, "Which samples of rays and slices are taken.").flag("empty-space"),
    setting("quality.neutral", NEUTRAL, Images, "What becomes of the terms of modules that a parameter of 0 takes away."),
    setting("quality.early_termination", number(0.0, 0.5), Targets, "A ray ends where less light than this would still come through, slices from front to back at the end of a batch: the largest error of a pixel."),
    setting("quality.target", TARGET, Targets, "Format that the slices are blended in.").flag("target"),
    setting("quality.order", ORDER, Targets, "Order of the slices.").flag("order"),
    setting("quality.proxy", PROXY, Targets, "Shape of the slices.").flag("proxy"),
    setting("quality.reject", REJECT, Images, "What becomes of fragments of slices that hold no matter."),
    setting("quality.msaa", OneOf(&[1, 2, 4, 8]), Targets, "Samples per pixel, each shaded.").flag("msaa"),
    setting("quality.jitter", JITTER, Images, "Whether each pixel has its own phase of the steps along its ray: noise in place of banding.").flag_alone("jitter", "hash"),
    setting("quality.seed", whole(0.0, 16_777_215.0), Picture, "Which phases the pixels have.").usual(0.0, 1000.0).flag("seed"),
    setting("quality.supersampling", whole(1.0, 256.0), Picture, "Pictures of which the mean is taken: each with its own place in the pixel, phase and time.").flag("supersampling"),
    setting("quality.filter", FILTER, Images, "Who interpolates between the texels of volumes and blocks; an anisotropic filter is the device's.").flag("filter"),
    setting("quality.anisotropy", number(1.0, 16.0), Images, "Anisotropy of the filter of volumes; 1 is off.").flag("anisotropy"),
    setting("quality.block_size", OneOf(&[16, 32, 64, 128, 256]), Images, "Texels along a side of the blocks of noise and turbulence."),
    setting("quality.turbulence_cells", OneOf(&[1, 2, 4, 8, 16, 32, 64]), Images, "Cells of the first octave across the block of turbulence: with half as many it holds one octave more, and repeats after half the distance; at most half of block_size."),
    setting("quality.wrap", WRAP, Images, "What is beyond the border of a block."),
    setting("quality.block_format", BLOCK_FORMAT, Images, "How the texels of a block are stored."),
    setting("quality.block_blur", number(0.0, 4.0), Images, "Standard deviation of the blur of noise = random, texels."),
];
