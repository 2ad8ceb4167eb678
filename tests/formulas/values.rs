//! Random parameters and points: all over what is allowed, and at its ends.

use glam::{DMat3, DMat4, DQuat, DVec3};
use hypertexture::eval::{Texture, Wrap};
use hypertexture::noise::{Noise, Weights};
use hypertexture::render::texture::table_rows;
use hypertexture::shader::{Parameter, ParameterKind};
use hypertexture_support::random::SplitMix;
use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

/// A number as GLSL has it: a literal, and every constant, is rounded to f32.
pub fn c(value: f64) -> f64 {
    f64::from(value as f32)
}

pub struct Random(SplitMix);

impl Random {
    /// A sequence of its own for each index and name.
    pub fn new(index: u64, name: &str) -> Random {
        let name =
            name.bytes().fold(0xcbf2_9ce4_8422_2325, |h: u64, b| (h ^ u64::from(b)).wrapping_mul(0x100_0000_01b3));
        Random(SplitMix(name ^ index.wrapping_mul(0x9e37_79b9_7f4a_7c15)))
    }

    /// Uniform in [0, 1).
    pub fn unit(&mut self) -> f64 {
        self.0.unit()
    }

    /// Uniform between two numbers.
    pub fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Between two numbers, one time in five one of them.
    pub fn ranged(&mut self, low: f64, high: f64) -> f64 {
        match self.unit() {
            u if u < 0.1 => low,
            u if u < 0.2 => high,
            _ => self.within(low, high),
        }
    }

    /// A density: mostly in [0, 1], now and then at its ends, next to them or beyond.
    pub fn density(&mut self) -> f64 {
        match self.unit() {
            u if u < 0.04 => 0.0,
            u if u < 0.08 => 1.0,
            u if u < 0.12 => 1e-6 * self.unit(),
            u if u < 0.16 => 1.0 - 1e-6 * self.unit(),
            u if u < 0.20 => self.within(-0.5, 1.5),
            _ => self.unit(),
        }
    }

    /// A coordinate: mostly in [-2, 2], now and then very small or large.
    pub fn coordinate(&mut self) -> f64 {
        let near = self.within(-2.0, 2.0);
        match self.unit() {
            u if u < 0.05 => near * 10f64.powf(-6.0 * self.unit()),
            u if u < 0.10 => near * 10f64.powf(1.5 * self.unit()),
            _ => near,
        }
    }

    pub fn vector(&mut self) -> DVec3 {
        DVec3::from_array([0; 3].map(|_| self.coordinate()))
    }

    /// Uniform in a cube around the origin.
    pub fn in_cube(&mut self, half: f64) -> DVec3 {
        DVec3::from_array([0; 3].map(|_| self.within(-half, half)))
    }

    /// Uniform on the unit sphere.
    pub fn direction(&mut self) -> DVec3 {
        let (z, turn) = (self.within(-1.0, 1.0), self.within(0.0, TAU));
        let across = (1.0 - z * z).sqrt();
        DVec3::new(across * turn.cos(), across * turn.sin(), z)
    }

    pub fn rotation(&mut self) -> DMat3 {
        DMat3::from_quat(DQuat::from_axis_angle(self.direction(), self.within(0.0, PI)))
    }

    /// A place before the eye, eye space.
    pub fn eye(&mut self) -> DVec3 {
        DVec3::new(self.within(-2.0, 2.0), self.within(-2.0, 2.0), self.within(-6.0, -1.0))
    }

    /// Inputs of a point: three of any numbers, and a place before the eye.
    pub fn point(&mut self) -> [[f64; 4]; 4] {
        let any = [0; 3].map(|_| self.vector().extend(self.coordinate()).to_array());
        [any[0], any[1], any[2], self.eye().extend(self.unit()).to_array()]
    }
}

/// A choice of all parameters, of which each knows its own.
#[derive(Clone)]
pub struct Setting {
    index: u64,
    parameters: Vec<Parameter>,
    fixed: BTreeMap<String, Vec<f64>>,
    /// Whether noise and turbulence repeat, each setting after another number of cells.
    pub repeats: bool,
}

impl Setting {
    pub fn new(parameters: Vec<Parameter>) -> Setting {
        Setting { index: 0, parameters, fixed: BTreeMap::new(), repeats: false }
    }

    /// Whether a parameter of this name is declared.
    pub fn declares(&self, name: &str) -> bool {
        self.parameters.iter().any(|own| own.name == name)
    }

    pub fn numbered(self, index: u64) -> Setting {
        Setting { index, ..self }
    }

    pub fn fix(&mut self, name: &str, value: &[f64]) {
        self.fixed.insert(name.into(), value.to_vec());
    }

    pub fn number(&self, name: &str) -> f64 {
        c(self.floats(name, 1)[0].into())
    }

    pub fn vector(&self, name: &str) -> DVec3 {
        DVec3::from_array([0, 1, 2].map(|axis| f64::from(self.floats(name, 4)[axis])))
    }

    pub fn fourth(&self, name: &str) -> f64 {
        f64::from(self.floats(name, 4)[3])
    }

    pub fn matrix(&self, name: &str) -> DMat4 {
        let floats = self.floats(name, 16);
        DMat4::from_cols_array(&std::array::from_fn(|at| f64::from(floats[at])))
    }

    /// The value of a member of a block, as the program reads it.
    pub fn floats(&self, name: &str, count: usize) -> Vec<f32> {
        if let Some(value) = self.fixed.get(name) {
            return (0..count).map(|at| value.get(at).copied().unwrap_or_default() as f32).collect();
        }
        let mut random = Random::new(self.index, name);
        let parameter =
            self.parameters.iter().find(|parameter| parameter.name == name).map(|parameter| &parameter.kind);
        let values = match (parameter, count) {
            (Some(ParameterKind::Number(_, [low, high])), _) => vec![random.ranged(f64::from(*low), f64::from(*high))],
            (Some(ParameterKind::Color(_)), _) => vec![random.unit(), random.unit(), random.unit(), 1.0],
            (None, 16) => self.of_matrix(name).to_cols_array().to_vec(),
            (None, 4) => self.of_vector(name, &mut random),
            (None, _) if ENDLESS.contains(&name) && !self.repeats => vec![2f64.powi(20)],
            (None, _) if name == "turbulence_growth" && !self.repeats => vec![0.0],
            (None, _) => vec![of_number(name, &mut random)],
        };
        values.into_iter().map(|value| value as f32).collect()
    }

    fn of_matrix(&self, name: &str) -> DMat4 {
        let random = &mut Random::new(self.index, "place of the object");
        let stretch = DVec3::from_array([0; 3].map(|_| random.within(0.5, 2.0)));
        let away = DVec3::new(random.within(-0.5, 0.5), random.within(-0.5, 0.5), -4.0);
        let object = DMat4::from_mat3_translation(random.rotation() * DMat3::from_diagonal(stretch), away);
        match name {
            "object_matrix" => object,
            "texture_matrix" => object.inverse(),
            "normal_matrix" => DMat4::from_mat3(DMat3::from_mat4(object).inverse().transpose()),
            "shadow_matrix" => DMat4::from_mat3_translation(random.rotation(), random.in_cube(4.0)),
            "place_matrix" | "place_matrix_b" => {
                let scale = 1.0 / self.number("place_scale");
                DMat4::from_mat3_translation(random.rotation() * scale, random.in_cube(0.3))
            }
            _ => DMat4::IDENTITY,
        }
    }

    fn of_vector(&self, name: &str, random: &mut Random) -> Vec<f64> {
        let one = |random: &mut Random, low, high| [0; 3].map(|_| random.within(low, high));
        let three = match name {
            "box_min" | "own_min" | "own_min_b" => one(random, -2.0, -0.5),
            "box_max" | "own_max" | "own_max_b" => one(random, 0.5, 2.0),
            "clip_plane" | "slice_axis" => random.direction().to_array(),
            "light_position" => one(random, -5.0, 5.0),
            "volume_scale" => one(random, 0.2, 0.5),
            "volume_offset" => one(random, 0.4, 0.6),
            "volume_texel" => [1.0 / f64::from(SIDE); 3],
            "distance_decode" => [random.within(0.5, 2.0), random.within(-4.0, -1.0), 0.0],
            "picture_scale" => [0.0078125, 0.0078125, random.within(-0.004, 0.004)],
            "ray_scale" => one(random, 0.2, 1.5),
            _ => one(random, 0.0, 1.0),
        };
        let last = match name {
            "clip_plane" => random.within(-0.5, 0.5),
            "own_min" => random.within(-0.6, -0.2),
            "own_max" => random.within(0.2, 0.6),
            _ => 1.0,
        };
        [three.as_slice(), &[last]].concat()
    }
}

/// Cells after which noise and turbulence repeat.
const ENDLESS: [&str; 2] = ["noise_period", "turbulence_period"];

/// A number other than a parameter.
fn of_number(name: &str, random: &mut Random) -> f64 {
    let (low, high) = match name {
        "iso_value" | "iso_value_b" => (-0.3, 0.1),
        "outer_iso_value" | "outer_iso_value_b" => (0.15, 0.6),
        "opacity_rate" | "opacity_rate_b" => (0.1, 200.0),
        "step_size" | "sample_reach" => (0.004, 0.1),
        "first_depth" => (1.0, 3.0),
        "slice_count" => (10.0, 500.0),
        "full_opacity" => (0.9, 1.0),
        "time" => (-2.0, 10.0),
        "specular_power" => (1.0, 80.0),
        "shadow_rim" => (0.3, 8f64.sqrt()),
        "shadow_near" => (0.5, 2.0),
        "shadow_far" => (4.0, 8.0),
        "shadow_bias" => (0.01, 0.1),
        "shadow_steps" => (1.0, 4.0),
        "own_radius" | "hold_radius" => (1.0, 2.0),
        "scatter" => (0.1, 1.0),
        "closest_range" | "place_scale" => (0.5, 2.0),
        "noise_cells" => return 8.0,
        "turbulence_cells" => return 4.0,
        "channel_cells" => return 2.0,
        "shadow_side" => return 8.0,
        "turbulence_octaves" => return random.within(1.0, 9.0).floor(),
        "low_octaves" => return random.within(1.0, 4.0).floor(),
        "jitter_seed" => return random.within(0.0, 16_777_216.0).floor(),
        "noise_period" | "turbulence_period" => return 2f64.powf(random.within(2.0, 13.0).floor()),
        "turbulence_growth" => return f64::from(random.unit() < 0.5),
        "turbulence_cycle" => return if random.unit() < 0.5 { 4.0 } else { 16.0 },
        _ => (0.0, 1.0),
    };
    random.within(low, high)
}

/// Texels along each side of an image, unless its module knows another.
pub const SIDE: u32 = 6;

/// An image full of random numbers, or of Perlin's tables.
pub fn texture(name: &str) -> Texture {
    let tables = || table_rows(&Noise::new(1989, Weights::Quintic)).map(|row| row.as_chunks::<4>().0.to_vec());
    let size = match name {
        "permutation_image" => return Texture { size: [256, 1, 1], texels: tables()[0].clone() },
        "gradient_image" => return Texture { size: [256, 1, 1], texels: tables()[1].clone() },
        "transfer_image" | "index_image" => [16, 1, 1],
        "phase_image" => [8, 8, 1],
        "light_before_image" | "light_behind_image" => [64, 8, 1],
        "segment_image" => [9, 9, 1],
        "noise_image" | "noise_value_image" => [16; 3],
        "shadow_image" => [8, 8, 9],
        name if name.starts_with("transfer_image") => [16, 1, 1],
        _ => [SIDE; 3],
    };
    let mut random = Random::new(0, name);
    let texels = (0..size.iter().product()).map(|_| [0; 4].map(|_| random.unit() as f32)).collect();
    Texture { size, texels }
}

/// An image of which each texel is made from its center, in [0, 1]^3.
pub fn image(size: [u32; 3], of: impl Fn(DVec3) -> [f64; 4]) -> Texture {
    let [nx, ny, nz] = size.map(f64::from);
    let texels = (0..size.iter().product()).map(|at: u32| {
        let place = [at % size[0], at / size[0] % size[1], at / (size[0] * size[1])].map(|i| f64::from(i) + 0.5);
        of(DVec3::from(place) / DVec3::new(nx, ny, nz)).map(|value| value as f32)
    });
    Texture { size, texels: texels.collect() }
}

/// The linear filter: each texel weighs as much as a tent of two texels' width around its center says.
pub fn filtered(texture: &Texture, at: &[f64], wrap: Wrap) -> [f64; 4] {
    let mut sum = [0.0; 4];
    for corner in 0..1usize << at.len() {
        let (mut weight, mut index, mut stride) = (1.0, 0, 1);
        for (axis, coordinate) in at.iter().enumerate() {
            let n = i64::from(texture.size[axis]);
            let center = coordinate * n as f64 - 0.5;
            let texel = center.floor() + (corner >> axis & 1) as f64;
            weight *= 1.0 - (center - texel).abs();
            let texel = match wrap {
                Wrap::Clamp => (texel as i64).clamp(0, n - 1),
                Wrap::Repeat => (texel as i64).rem_euclid(n),
                Wrap::Mirror => (texel as i64).rem_euclid(2 * n).min((-1 - texel as i64).rem_euclid(2 * n)),
            };
            index += texel * stride;
            stride *= n;
        }
        let texel = texture.texels[index as usize];
        (0..4).for_each(|channel| sum[channel] += weight * f64::from(texel[channel]));
    }
    sum
}
