//! A module under test: the program that shows it at points, linked for the device and for the exact evaluator, with
//! the same blocks and texels for both.

use hypertexture::eval::{Inputs, Program, Texture, Wrap};
use hypertexture::gpu::{
    Address, Binding, BindingKind, Blend, Buffer, BufferUse, Dimension, Format, Gpu, Image, ImageUse, Load, Marks,
    Pipeline, PipelineDescription, Resource, Sampler, Target,
};
use hypertexture::noise::{Bake, Noise, Weights, random_block};
use hypertexture::render::texture::{Depth, block_channels, block_gradients, block_values, table_rows};
use hypertexture::render::variant::{self, Use, Variant};
use hypertexture::scene;
use hypertexture::shader::{Library, Linker, Parameter, ParameterKind, Slots};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Points of the device, from the coordinates of a fragment: exact in f32 too.
const HASHED: &str = "vec4 point() {\n    uvec3 a = hash(uvec3(uvec2(gl_FragCoord.xy), 7u)) >> 14u;\n    \
                      return vec4(a, 0.0) / 65536.0 - 2.0;\n}";
/// Points of the evaluator alone: as they are given.
const GIVEN: &str = "layout(location = 0) in vec4 given;\nvec4 point() { return given; }";

/// A program with its inputs.
pub struct Probe {
    pub linked: variant::Program,
    pub inputs: Inputs,
}

impl Probe {
    /// The program of a file of `tests/glsl` with modules in its slots; `None` where it does not reach `slot`.
    pub fn new(library: &Library, text: &str, choice: &Slots, slot: &str, given: bool) -> Option<Probe> {
        let library =
            library.clone().with_module("probe", "exact", &text.replace("POINT", if given { GIVEN } else { HASHED }));
        let entries = ["march.vert", "probe/exact.glsl"];
        let slots = library.needed(&entries, choice).unwrap();
        if !slots.contains_key(slot) {
            return None;
        }
        let mut parameters: Vec<(String, Parameter)> = Vec::new();
        let own = library.declarations(&entries, &slots).unwrap().parameters;
        parameters.extend(own.into_iter().map(|parameter| (parameter.name.clone(), parameter)));
        let parts: Vec<&str> = choice.keys().filter_map(|key| key.split_once('.')).map(|(part, _)| part).collect();
        for part in &parts {
            let own = library.object_declarations(part, &slots).unwrap().parameters;
            parameters.extend(own.into_iter().map(|parameter| (format!("{}_{part}", parameter.name), parameter)));
        }
        let parameters =
            parameters.into_iter().map(|(name, parameter)| (name, parameter.kind)).collect::<BTreeMap<_, _>>();
        let any = Variant::of(&scene::preset("lit").unwrap(), &library).unwrap();
        let variant = Variant { entries, slots: slots.into(), ..any };
        let linked = variant.program(&library, Linker::new).unwrap_or_else(|error| panic!("{error}"));
        let bare = |name: &str| {
            let part = parts.iter().find_map(|part| name.strip_suffix(&format!("_{part}")));
            part.unwrap_or(name).to_string()
        };
        let mut inputs = Inputs::default();
        for resource in &linked.resources {
            match &resource.holds {
                Use::Block(block) => {
                    let values: BTreeMap<String, Vec<f32>> = block
                        .members
                        .iter()
                        .map(|member| {
                            let parameter = parameters.get(&member.name).map(|default| match default {
                                ParameterKind::Number(number, _) => vec![*number],
                                ParameterKind::Color(rgb) => {
                                    let [r, g, b] = rgb.map(|code| f32::from(code) / 255.0);
                                    vec![r * r, g * g, b * b, 1.0]
                                }
                            });
                            (
                                member.name.clone(),
                                parameter.unwrap_or_else(|| value(&bare(&member.name), member.floats)),
                            )
                        })
                        .collect();
                    let bytes = block.fill(|name| values.get(name).map(Vec::as_slice)).unwrap();
                    inputs.blocks.insert(resource.binding, bytes);
                }
                Use::Image => {
                    inputs.images.insert(resource.binding, image(&bare(&resource.name)));
                }
                Use::Sampler => {
                    let repeats = ["repeat_sampler", "block_sampler"].contains(&resource.name.as_str());
                    let wrap = if repeats { Wrap::Repeat } else { Wrap::Clamp };
                    inputs.samplers.insert(resource.binding, wrap);
                }
            }
        }
        Some(Probe { linked, inputs })
    }

    pub fn program(&self) -> Program {
        Program::read(&self.linked.fragment, &[]).unwrap_or_else(|error| panic!("{error}"))
    }

    /// A picture of the program on a device, as many pixels on each side.
    pub fn draw(&self, gpu: &Gpu, side: u32) -> Vec<[f32; 4]> {
        self.draw_by(gpu, &self.pipeline(gpu), side)
    }

    /// The program, compiled by a device.
    pub fn pipeline(&self, gpu: &Gpu) -> Pipeline {
        let kind = |holds: &Use| match holds {
            Use::Block(_) => BindingKind::Uniform,
            Use::Image => BindingKind::Image,
            Use::Sampler => BindingKind::Sampler,
        };
        let bindings: Vec<Binding> = self
            .linked
            .resources
            .iter()
            .map(|r| Binding { index: r.binding, kind: kind(&r.holds), vertex: r.vertex, fragment: r.fragment })
            .collect();
        let description = PipelineDescription {
            vertex: &self.linked.vertex,
            fragment: &self.linked.fragment,
            constants: &[],
            bindings: &bindings,
            attributes: &[],
            format: Format::Rgba32Float,
            samples: 1,
            blend: Blend::Replace,
            marks: Marks::None,
            covered: true,
        };
        Pipeline::new(gpu, &description).unwrap()
    }

    /// A picture by the program's pipeline.
    pub fn draw_by(&self, gpu: &Gpu, pipeline: &Pipeline, side: u32) -> Vec<[f32; 4]> {
        let blocks = self.inputs.blocks.iter();
        let blocks = blocks.map(|(at, bytes)| {
            let block = Buffer::new(gpu, "probe", BufferUse::Uniform, bytes).unwrap();
            (*at, Resource::Uniform(Arc::new(block)))
        });
        let images = self.inputs.images.iter().map(|(at, texture)| {
            let [x, y, z] = texture.size;
            let size = match self.dimension(*at) {
                1 => Dimension::Line(x),
                2 => Dimension::Plane(x, y),
                _ => Dimension::Volume(x, y, z),
            };
            let bytes: Vec<u8> = texture.texels.iter().flatten().flat_map(|value| value.to_le_bytes()).collect();
            let image = Image::sampled(gpu, "probe", size, Format::Rgba32Float, &bytes).unwrap();
            (*at, Resource::Image(Arc::new(image)))
        });
        let samplers = self.inputs.samplers.iter().map(|(at, wrap)| {
            let address = if *wrap == Wrap::Repeat { Address::Repeat } else { Address::Clamp };
            (*at, Resource::Sampler(Arc::new(Sampler::new(gpu, address, 1.0).unwrap())))
        });
        let set = pipeline.bind(&blocks.chain(images).chain(samplers).collect::<Vec<_>>()).unwrap();
        let plane = Dimension::Plane(side, side);
        let color = Image::new(gpu, "probe", plane, Format::Rgba32Float, ImageUse::Target(1)).unwrap();
        let target = Target::of(&color);
        gpu.submit("probe", |commands| {
            commands.render(target, Load::Clear([0.0; 4]), |draw| draw.triangles(pipeline, &set, None, 0..3));
        })
        .unwrap();
        color.read().unwrap()
    }

    /// Axes of an image, by its name.
    fn dimension(&self, binding: u32) -> u32 {
        let resource = self.linked.resources.iter().find(|resource| resource.binding == binding).unwrap();
        match resource.name.as_str() {
            "permutation_image" | "gradient_image" => 1,
            name if name.starts_with("transfer_image") || name.starts_with("index_image") => 1,
            name if name.starts_with("segment_image") || name == "phase_image" => 2,
            name if name.starts_with("light_be") => 2,
            _ => 3,
        }
    }
}

/// A member of a block: an object of unit size four units before the eye, and a light beside it.
fn value(name: &str, floats: usize) -> Vec<f32> {
    let moved = |z: f32| {
        let mut matrix = vec![0.0; 16];
        [0, 5, 10, 15].into_iter().for_each(|at| matrix[at] = 1.0);
        matrix[14] = z;
        matrix
    };
    match (name, floats) {
        ("texture_matrix", _) => moved(4.0),
        ("object_matrix", _) => moved(-4.0),
        ("shadow_matrix", _) => moved(8.0),
        (_, 16) => moved(0.0),
        ("box_min" | "own_min", _) => vec![-1.5, -1.5, -1.5, 0.0],
        ("box_max" | "own_max", _) => vec![1.5, 1.5, 1.5, 0.0],
        ("clip_plane", _) => vec![0.0, 0.0, 1.0, 0.25],
        ("picture_scale", _) => vec![0.0078125, 0.0078125, 0.0, 0.0],
        ("ray_scale", _) => vec![0.5, 0.5, 0.0, 0.0],
        ("light_position", _) => vec![3.0, 4.0, 1.0, 1.0],
        ("volume_scale", _) => vec![0.25, 0.25, 0.25, 0.0],
        ("volume_offset", _) => vec![0.5, 0.5, 0.5, 0.0],
        ("volume_texel", _) => vec![0.0625, 0.0625, 0.0625, 0.0],
        ("distance_decode", _) => vec![-2.0, 4.0, 0.0, 0.0],
        (_, 4) => vec![0.75, 0.5, 0.25, 1.0],
        ("step_size", _) => vec![0.015625],
        ("first_depth", _) => vec![2.0],
        ("slice_count", _) => vec![256.0],
        ("full_opacity", _) => vec![0.999],
        ("sample_reach", _) => vec![0.0078125],
        ("jitter_seed", _) => vec![12345.0],
        ("time", _) => vec![1.5],
        ("noise_cells", _) => vec![8.0],
        ("turbulence_cells", _) => vec![4.0],
        ("channel_cells" | "low_octaves" | "turbulence_octaves", _) => vec![2.0],
        ("noise_period" | "turbulence_period", _) => vec![16.0],
        ("turbulence_growth" | "turbulence_cycle", _) => vec![1.0],
        ("shadow_rim", _) => vec![0.5],
        ("shadow_near", _) => vec![2.0],
        ("shadow_far", _) => vec![6.0],
        ("shadow_side", _) => vec![8.0],
        ("shadow_steps", _) => vec![2.0],
        ("shadow_bias", _) => vec![0.0625],
        ("specular_power", _) => vec![24.0],
        ("specular_strength", _) => vec![0.25],
        ("iso_value", _) => vec![0.0],
        ("outer_iso_value", _) => vec![0.4],
        ("opacity_rate", _) => vec![20.0],
        ("place_scale", _) => vec![1.0],
        ("skip_slack", _) => vec![0.03125],
        ("closest_range", _) => vec![2.0],
        _ => vec![0.5],
    }
}

/// An image by its name: the noise of the renderer, and smooth values for the others.
fn image(name: &str) -> Texture {
    const SIDE: u32 = 16;
    let bake = |size, cells, octaves, absolute| Bake { weights: Weights::Quintic, size, cells, octaves, absolute };
    let rows = |floats: &[f32]| floats.as_chunks::<4>().0.to_vec();
    let codes = |bytes: Vec<u8>| {
        let values: Vec<f32> =
            bytes.as_chunks().0.iter().map(|code| f32::from(u16::from_ne_bytes(*code)) / 65535.0).collect();
        rows(&values)
    };
    let values = |bake: Bake| {
        let stored = block_values(&bake.values(&|_| ()), bake.absolute, Depth::Sixteen);
        let texel = |code: &[u8; 2]| [f32::from(u16::from_ne_bytes(*code)) / 65535.0, 0.0, 0.0, 1.0];
        Texture { size: [bake.size; 3], texels: stored.as_chunks().0.iter().map(texel).collect() }
    };
    let gradients = |bake: Bake| {
        let stored = block_gradients(&bake.values_and_gradients(&|_| ()), bake.absolute, Depth::Sixteen);
        Texture { size: [bake.size; 3], texels: codes(stored) }
    };
    let [permutation, pointed] = table_rows(&Noise::new(1989, Weights::Quintic));
    let filled = |size: [u32; 3], f: &dyn Fn([f32; 3]) -> [f32; 4]| {
        let [x, y, z] = size;
        let places = (0..z).flat_map(|k| (0..y).flat_map(move |j| (0..x).map(move |i| [i, j, k])));
        let at = |place: [u32; 3]| [0, 1, 2].map(|axis| (place[axis] as f32 + 0.5) / size[axis] as f32);
        Texture { size, texels: places.map(|place| f(at(place))).collect() }
    };
    match name {
        "noise_image" => gradients(bake(2 * SIDE, 8, 1, false)),
        "noise_value_image" => values(bake(2 * SIDE, 8, 1, false)),
        "turbulence_image" => gradients(bake(SIDE, 4, 2, true)),
        "turbulence_value_image" | "low_octaves_image" => values(bake(SIDE, 4, 2, true)),
        "channel_image" => {
            let octave = |octave: u32| bake(2 * SIDE, 2 << octave, 1, false).values(&|_| ());
            let stored = block_channels(&[0, 1, 2, 3].map(octave), Depth::Sixteen);
            Texture { size: [2 * SIDE; 3], texels: codes(stored) }
        }
        "permutation_image" => Texture { size: [256, 1, 1], texels: rows(&permutation) },
        "gradient_image" => Texture { size: [256, 1, 1], texels: rows(&pointed) },
        "random_image" => Texture { size: [SIDE; 3], texels: random_block(7, SIDE, 0.7) },
        "transfer_image" => filled([SIDE, 1, 1], &|[t, ..]| [t, 1.0 - t, 0.5, t * t]),
        "index_image" => filled([SIDE, 1, 1], &|[t, ..]| [1.0 + 0.5 * t, 0.5, (4.0 * t).floor(), t]),
        "segment_image" => filled([SIDE, SIDE, 1], &|[s, t, _]| [s, t, 0.5, 0.9 * s * t]),
        "light_before_image" => filled([SIDE, SIDE, 1], &|[x, y, _]| [x, y, 0.5, 0.5 + 0.5 * x * y]),
        "light_behind_image" => filled([SIDE, SIDE, 1], &|[x, y, _]| [0.5 * x, y, 0.25, 0.5 * x * y]),
        "phase_image" => filled([SIDE, SIDE, 1], &|[x, y, _]| [(37.0 * x + 17.0 * y).fract(), 0.0, 0.0, 1.0]),
        "cell_image" => filled([8; 3], &|[x, y, _]| [(5.0 * x * y).floor() / 255.0, 0.0, 0.0, 1.0]),
        "shadow_image" => filled([8, 8, 9], &|[x, y, z]| [1.0 - z * (0.5 + 0.25 * x * y); 4]),
        // A ball in a volume that spans [-2, 2]: the way out in RGB, (distance + 2) / 4 in A and R of a lean one.
        "volume_image" => filled([SIDE; 3], &|at| {
            let p = at.map(|t| 4.0 * t - 2.0);
            let length = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt().max(1e-3);
            let [r, g, b] = p.map(|axis| 0.5 + 0.5 * axis / length);
            [r, g, b, (length - 1.0 + 2.0) / 4.0]
        }),
        // Every other brick of the volume, each wherever it may be, and a texel for the others.
        "brick_image" => {
            let entry = |n: u32| {
                if n.is_multiple_of(2) { [(n % 7) as f32, n as f32 % 3.0, 2.0, 2.0] } else { [0.25, 0.5, 0.75, 0.5] }
            };
            Texture { size: [2; 3], texels: (0..8).map(entry).collect() }
        }
        "closest_image" => filled([SIDE; 3], &|at| {
            let p = at.map(|t| 4.0 * t - 2.0);
            let length = (p[0] * p[0] + p[1] * p[1] + p[2] * p[2]).sqrt().max(1e-3);
            let [r, g, b] = p.map(|axis| 0.5 + 0.5 * (axis / length - axis) / 2.0);
            [r, g, b, 1.0]
        }),
        _ => filled([SIDE; 3], &|[x, y, z]| [x, y, z, 0.5 * x * y]),
    }
}
