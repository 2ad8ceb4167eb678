//! Evaluates SPIR-V on the CPU: in f64, in intervals, in affine forms and with slopes.
//!
//! A fragment shader is the text that a GPU runs. Here the very same words give its true value (f64), a range that holds
//! its value anywhere in a box ([`Interval`]) or along a segment ([`Affine`], [`Sloped`]), or a range that holds whatever a
//! device may round it to ([`Device`]). So a formula is written once, in the shader, and its error, its bounds and its
//! empty regions follow from it.
//!
//! # Order
//! 1. [`Program::read`]: specialization constants are replaced, naga parses the words, and functions are lowered to scalar
//!    instructions over registers. What no output depends on goes; calls are put in place; loops and branches stay.
//! 2. [`Program::bind`]: uniform blocks, images and samplers are given to it. What depends on uniforms alone is computed once.
//! 3. [`BoundProgram::run`]: each instruction is one loop over a block of lanes, which the compiler vectorizes. Lanes that
//!    branch apart run one after another and are joined where control flow meets.
//!
//! # Guarantees
//! - f64: correctly rounded elementary operations; functions of GLSL as the platform's library has them.
//! - An [`Interval`] holds everything that any point of its box gives, outward rounded; an [`Affine`] form everything that any
//!   place of its segment gives, but for numbers below the normal ones. A comparison that is undecided goes both ways; a loop
//!   without a bound gives the whole line.
//! - Evaluation is pure, and the result does not depend on how lanes are grouped. What is not covered is an error that names
//!   the construct, its file and its line.
//!
//! # Example
//! ```
//! use glsl::{Library, Linker, Slots, Stage};
//! use hypertexture_eval::{Inputs, Interval, Lanes, Program};
//!
//! let text = "#version 450
//!     layout(location = 0) in vec4 place;
//!     layout(location = 0) out vec4 value;
//!     void main() { float r = dot(place.xy, place.xy); value = vec4(r < 1.0 ? 1.0 - r : 0.0); }";
//! let library = Library::new([("hill.frag".to_string(), text.to_string())]);
//! let spirv = Linker::new()?.link(&library, "hill.frag", Stage::Fragment, &["hill.frag"], &Slots::new())?;
//!
//! let program = Program::read(&spirv, &[])?;
//! let inputs = Inputs::default();
//! let bound = program.bind(&inputs)?;
//! fn at<N: Copy>(x: N, y: N) -> Lanes<N> {
//!     Lanes { fragment_coordinates: vec![], varyings: [(0, vec![[x, y, x, y]])].into() }
//! }
//! assert_eq!(bound.run(&at(0.5, 0.0))?[&0][0][0], 0.75);
//!
//! let hill = bound.run(&at(Interval::of(0.0, 0.5), Interval::of(0.0, 0.5)))?[&0][0][0];
//! assert!(hill.contains(1.0) && hill.contains(0.5) && !hill.contains(0.4));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod affine;
mod allocate;
mod case;
mod cases;
mod code;
mod device;
mod express;
mod flatten;
mod floats;
mod functions;
pub mod interval;
mod lanes;
mod lower;
pub mod number;
mod operators;
mod optimizer;
mod outline;
mod ports;
mod prepass;
mod pyramid;
mod range;
mod run;
mod segment;
mod single;
mod sloped;
mod state;
mod step;
pub mod texture;
mod truths;
mod uniforms;
mod value;

pub use affine::Affine;
pub use device::Device;
pub use interval::Interval;
pub use number::Number;
pub use outline::Outline;
pub use segment::SegmentBounds;
pub use single::Overflow;
pub use sloped::Sloped;
pub use texture::{Texture, Wrap};

use naga::front::spv::Error as SpirvError;
use noise::Lattice;

use case::Case;
use code::{Code, File, Input, Source};
use number::Truth;
use run::Machine;
use single::Singles;
use std::collections::BTreeMap;
use texture::Image;
use uniforms::Known;

/// Why a program cannot be evaluated.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ExactError {
    /// The SPIR-V cannot be read.
    #[error("the SPIR-V cannot be read: {0}")]
    Spirv(String),
    /// The program uses something that the evaluator does not know.
    #[error("the exact evaluator does not cover {construct} ({place})")]
    Uncovered {
        /// What it is.
        construct: String,
        /// File and line.
        place: String,
    },
    /// A binding for which the inputs have nothing.
    #[error("binding {binding} needs {what}, and the inputs have none; add it to `Inputs`")]
    Missing {
        /// Its number.
        binding: u32,
        /// A block, an image or a sampler.
        what: &'static str,
    },
    /// A binding whose input is too small, or not of its shape.
    #[error("binding {binding} has {found}, but the program needs {needed}")]
    Unfit {
        /// Its number.
        binding: u32,
        /// What the inputs have.
        found: String,
        /// What they should have.
        needed: String,
    },
    /// The lanes lack something.
    #[error("{0}")]
    Lanes(String),
    /// A loop that does not end.
    #[error("a loop has not ended after {turns} turns ({place})")]
    Endless {
        /// Turns that it made, and those around it.
        turns: u64,
        /// File and line.
        place: String,
    },
}

/// A program that has been read and lowered.
#[derive(Debug)]
pub struct Program {
    code: Code,
}

/// What a program reads, by binding of set 0.
#[derive(Clone, Debug, Default)]
pub struct Inputs {
    /// Uniform blocks, laid out as on the GPU.
    pub blocks: BTreeMap<u32, Vec<u8>>,
    /// The same blocks of which every float is known to be between: bounds hold for all of them. Empty: the blocks as they are.
    pub until: BTreeMap<u32, Vec<u8>>,
    /// Images.
    pub images: BTreeMap<u32, Texture>,
    /// Samplers.
    pub samplers: BTreeMap<u32, Wrap>,
    /// Noise in the place of images: looked up in lattice cells, at the level of its [`Knots`](noise::Knots); gradient
    /// in RGB, value in A.
    pub noises: BTreeMap<u32, Lattice>,
}

/// A program with its inputs.
#[derive(Debug)]
pub struct BoundProgram<'a> {
    code: &'a Code,
    images: Vec<Image<'a>>,
    /// What uniform registers start with, in the order of [`Code::sources`].
    values: Vec<Start>,
    known: Known,
}

#[derive(Clone, Copy, Debug)]
enum Start {
    Float(f64),
    Between(f64, f64),
    Int(u32, bool),
    Truth(bool),
}

/// Points at which a program is evaluated; all lists have one length.
#[derive(Clone, Debug)]
pub struct Lanes<N> {
    /// `gl_FragCoord` of each point. A program with derivatives takes four lanes for a quad: the pixels (x, y),
    /// (x + 1, y), (x, y + 1) and (x + 1, y + 1).
    pub fragment_coordinates: Vec<[N; 4]>,
    /// What comes from the vertex stage, by location.
    pub varyings: BTreeMap<u32, Vec<[N; 4]>>,
}

/// Functions of GLSL that naga does not read, by their numbers in GLSL.std.450.
const FUNCTIONS: [(u32, &str); 5] = [
    (35, "modf"),
    (51, "frexp"),
    (76, "interpolateAtCentroid"),
    (77, "interpolateAtSample"),
    (78, "interpolateAtOffset"),
];

/// Outputs of every lane by location, and the number of scalar operations that it took.
pub type Measured<N> = (BTreeMap<u32, Vec<[N; 4]>>, u64);

impl Program {
    /// Reads the fragment stage of a SPIR-V module. `constants` are specialization constants: their numbers, and their
    /// values as bits; others keep their defaults.
    ///
    /// # Errors
    /// [`ExactError::Spirv`] and [`ExactError::Uncovered`], which names the construct, and file and line if the SPIR-V
    /// has them.
    pub fn read(spirv: &[u32], constants: &[(u32, u32)]) -> Result<Program, ExactError> {
        Program::read_with(spirv, constants, |_| ())
    }

    /// The part of a program that one channel of an output depends on: the others are 0, and it is the first one.
    ///
    /// # Errors
    /// As [`Program::read`].
    pub fn read_channel(
        spirv: &[u32],
        constants: &[(u32, u32)],
        (output, channel): (u32, usize),
    ) -> Result<Program, ExactError> {
        Program::read_with(spirv, constants, |code| {
            code.outputs.retain(|(location, _)| *location == output);
            code.outputs.iter_mut().for_each(|(_, regs)| *regs = regs.get(channel).copied().into_iter().collect());
        })
    }

    fn read_with(
        spirv: &[u32],
        constants: &[(u32, u32)],
        change: impl FnOnce(&mut Code),
    ) -> Result<Program, ExactError> {
        let words = prepass::Words::read(spirv, constants)?;
        let options = naga::front::spv::Options {
            adjust_coordinate_space: false,
            strict_capabilities: false,
            block_ctx_dump_prefix: None,
        };
        let module = naga::front::spv::Frontend::new(words.words.iter().copied(), &options).parse();
        let uncovered = |construct, place| ExactError::Uncovered { construct, place };
        let module = module.map_err(|error| match error {
            SpirvError::UnsupportedInstruction(_, op) => {
                uncovered(format!("the instruction {op:?}"), words.place_of_op(op as u32))
            }
            SpirvError::UnsupportedExtInst(number) => {
                let name = FUNCTIONS.iter().find(|(known, _)| *known == number);
                let name =
                    name.map_or_else(|| format!("number {number} of GLSL.std.450"), |(_, name)| name.to_string());
                uncovered(format!("the function {name}"), words.place_of_function(number))
            }
            other => ExactError::Spirv(other.to_string()),
        })?;
        let (mut code, mut classes) = lower::lower(&module, &words)?;
        change(&mut code);
        optimizer::drop_unread(&mut code);
        flatten::flatten(&mut code, &mut classes);
        truths::simplify(&mut code);
        optimizer::tidy(&mut code, &classes);
        allocate::allocate(&mut code, &classes);
        Ok(Program { code })
    }

    /// Number of scalar instructions; what functions and loops repeat counts as often as it is in the text.
    pub fn instructions(&self) -> usize {
        self.code.instrs.len()
    }

    /// Puts a program and its inputs together.
    ///
    /// # Errors
    /// [`ExactError::Missing`] and [`ExactError::Unfit`].
    pub fn bind<'a>(&'a self, inputs: &'a Inputs) -> Result<BoundProgram<'a>, ExactError> {
        self.bind_with(inputs, &inputs.blocks)
    }

    /// The same with other blocks than those of the inputs.
    ///
    /// # Errors
    /// As [`Program::bind`].
    pub fn bind_with<'a>(
        &'a self,
        inputs: &'a Inputs,
        blocks: &BTreeMap<u32, Vec<u8>>,
    ) -> Result<BoundProgram<'a>, ExactError> {
        let code = &self.code;
        let mut images = Vec::new();
        for pair in &code.images {
            if let Some(noise) = inputs.noises.get(&pair.image) {
                images.push(Image::of_noise(*noise));
                continue;
            }
            let texture = image(inputs, pair.image)?;
            let wrap = match pair.sampler {
                None => Wrap::Clamp,
                Some(binding) => {
                    *inputs.samplers.get(&binding).ok_or(ExactError::Missing { binding, what: "a sampler" })?
                }
            };
            if texture.size[pair.axes..].iter().any(|side| *side != 1) {
                let found = format!("an image of {:?} texels", texture.size);
                let needed = format!("one with {} axes", pair.axes);
                return Err(ExactError::Unfit { binding: pair.image, found, needed });
            }
            images.push(Image::new(texture.size, &texture.texels, wrap, pair.axes));
        }
        let values = code.sources.iter().map(|(reg, source)| start((inputs, blocks), reg.file, *source));
        Ok(BoundProgram { code, images, values: values.collect::<Result<_, _>>()?, known: Known::default() })
    }
}

fn image(inputs: &Inputs, binding: u32) -> Result<&Texture, ExactError> {
    let texture = inputs.images.get(&binding).ok_or(ExactError::Missing { binding, what: "an image" })?;
    let (mut size, mut needed) = (texture.size, texture::count(texture.size));
    while needed > 0 && needed < texture.texels.len() && size != [1; 3] {
        size = texture::halved(size);
        needed += texture::count(size);
    }
    if needed == 0 || texture.texels.len() != needed {
        let found = format!("{} texels for a size of {:?}", texture.texels.len(), texture.size);
        return Err(ExactError::Unfit { binding, found, needed: format!("{needed} and at least one") });
    }
    Ok(texture)
}

type Filled<'a> = (&'a Inputs, &'a BTreeMap<u32, Vec<u8>>);

fn start((inputs, blocks): Filled<'_>, file: File, source: Source) -> Result<Start, ExactError> {
    Ok(match source {
        Source::Float(bits) => Start::Float(f64::from_bits(bits)),
        Source::Int(bits, signed) => Start::Int(bits, signed),
        Source::Truth(truth) => Start::Truth(truth),
        Source::Size { image: binding, axis, signed } => Start::Int(image(inputs, binding)?.size[axis], signed),
        Source::Block { binding, offset, signed } => {
            let bytes = blocks.get(&binding).ok_or(ExactError::Missing { binding, what: "a uniform block" })?;
            let bits = |bytes: &[u8]| {
                let word = bytes.get(offset as usize..).and_then(|rest| rest.first_chunk().copied());
                word.map(u32::from_le_bytes).ok_or_else(|| ExactError::Unfit {
                    binding,
                    found: format!("a block of {} bytes", bytes.len()),
                    needed: format!("at least {}", offset + 4),
                })
            };
            let float = |bits| f64::from(f32::from_bits(bits));
            let (bits, until) = (bits(bytes)?, inputs.until.get(&binding).map(|bytes| bits(bytes)).transpose()?);
            match file {
                File::Float => match until {
                    Some(until) if until != bits => Start::Between(float(bits), float(until)),
                    _ => Start::Float(float(bits)),
                },
                File::Int => Start::Int(bits, signed),
                File::Truth => Start::Truth(bits != 0),
            }
        }
    })
}

impl BoundProgram<'_> {
    /// Evaluates every lane; the outputs by location, zeros where the fragment is discarded. An output of fewer than
    /// four components has zeros behind them.
    ///
    /// # Errors
    /// [`ExactError::Lanes`] and [`ExactError::Endless`].
    pub fn run<N: Number>(&self, lanes: &Lanes<N>) -> Result<BTreeMap<u32, Vec<[N; 4]>>, ExactError> {
        self.measure(lanes).map(|(outputs, _)| outputs)
    }

    /// The same, with the number of scalar operations of GLSL that it took; copies and branches do not count.
    ///
    /// # Errors
    /// [`ExactError::Lanes`] and [`ExactError::Endless`].
    pub fn measure<N: Number>(&self, lanes: &Lanes<N>) -> Result<Measured<N>, ExactError> {
        N::measure(self, lanes)
    }

    /// The same; all the loops of a lane together make `most_turns` at most.
    ///
    /// # Errors
    /// [`ExactError::Lanes`], and [`ExactError::Endless`] where a lane needs more.
    pub fn measure_within(&self, lanes: &Lanes<f64>, most_turns: u64) -> Result<Measured<f64>, ExactError> {
        self.evaluate(lanes, &mut [], Some(most_turns))
    }

    /// Evaluates a program as f32 does: outputs, the operations that it took, and of each lane the first result in a watched
    /// file and line that is beyond f32. All the loops of a lane together make `most_turns` at most.
    ///
    /// # Errors
    /// As [`BoundProgram::measure_within`].
    pub fn measure_single(
        &self,
        lanes: &Lanes<f64>,
        most_turns: u64,
        is_watched: &dyn Fn(&str) -> bool, // not generic: callers would compile the machine again
    ) -> Result<(Measured<f64>, Vec<Option<Overflow>>), ExactError> {
        let watched = self.code.places.iter().map(|place| is_watched(place)).collect();
        let (uniforms, known) = self.computed_uniforms::<f64>(Some(Singles::new(watched)));
        let start = known.map(|known| known.start());
        let mut machine = Machine::new(self.code, &self.images, uniforms);
        (machine.most_turns, machine.singles) = (Some(most_turns), start.clone());
        let mut found = Vec::new();
        let measured = self.fill(&mut machine, lanes, &mut [], &mut |machine, here| {
            let singles = std::mem::replace(&mut machine.singles, start.clone());
            found.extend(singles.iter().flat_map(|singles| singles.overflows(here, &self.code.places)));
        })?;
        Ok((measured, found))
    }

    /// [`BoundProgram::measure`], compiled here for each kind of number, and not in every crate that calls it.
    fn evaluate<N: Number>(
        &self,
        lanes: &Lanes<N>,
        cases: &mut [Case],
        most_turns: Option<u64>,
    ) -> Result<Measured<N>, ExactError> {
        let mut machine = Machine::new(self.code, &self.images, self.uniforms());
        machine.most_turns = most_turns;
        self.fill(&mut machine, lanes, cases, &mut |_, _| ())
    }

    /// Runs all lanes through a machine; after each block of them, and with how many there are, `each` is called.
    fn fill<N: Number>(
        &self,
        machine: &mut Machine<'_, N>,
        lanes: &Lanes<N>,
        cases: &mut [Case],
        each: &mut dyn FnMut(&mut Machine<'_, N>, usize),
    ) -> Result<Measured<N>, ExactError> {
        let count = self.check(lanes)?;
        let mut outputs: BTreeMap<u32, Vec<[N; 4]>> =
            self.code.outputs.iter().map(|(location, _)| (*location, Vec::with_capacity(count))).collect();
        for first in (0..count).step_by(lanes::LANES) {
            let here = (count - first).min(lanes::LANES);
            for (input, component, reg) in &self.code.inputs {
                let values = match input {
                    Input::Fragment => &lanes.fragment_coordinates,
                    Input::Varying(location) => &lanes.varyings[location],
                };
                let row = machine.banks.floats.row(*reg);
                for lane in 0..here {
                    lanes::put(row, lane, values[first + lane][*component]);
                }
            }
            if let Some(cases) = cases.get(first..first + here) {
                machine.banks.cases = cases.to_vec();
                machine.banks.cases.resize(lanes::LANES, Case::default());
            }
            let (ended, killed) = machine.run(u64::MAX >> (lanes::LANES - here))?;
            if let Some(cases) = cases.get_mut(first..first + here) {
                cases.copy_from_slice(&machine.banks.cases[..here]);
            }
            for (location, regs) in &self.code.outputs {
                let Some(out) = outputs.get_mut(location) else { continue };
                out.extend((0..here).map(|lane| {
                    let mut pixel = [N::new(0.0); 4];
                    for (value, reg) in pixel.iter_mut().zip(regs) {
                        let computed = machine.banks.floats.rows.read(*reg).at(lane);
                        *value = match (ended >> lane & 1 == 1, killed >> lane & 1 == 1) {
                            (true, false) => computed,
                            (true, true) => computed.join(*value),
                            (false, _) => *value,
                        };
                    }
                    pixel
                }));
            }
            each(machine, here);
        }
        Ok((outputs, machine.operations))
    }

    /// The number of lanes.
    fn check<N: Number>(&self, lanes: &Lanes<N>) -> Result<usize, ExactError> {
        let fragment = self.code.inputs.iter().any(|(input, ..)| *input == Input::Fragment);
        let needed = self.code.inputs.iter().filter_map(|(input, ..)| match input {
            Input::Varying(location) => Some(*location),
            Input::Fragment => None,
        });
        let mut count =
            (fragment || !lanes.fragment_coordinates.is_empty()).then_some(lanes.fragment_coordinates.len());
        for location in needed {
            let missing = || ExactError::Lanes(format!("the program reads location {location}, and the lanes lack it"));
            let found = lanes.varyings.get(&location).ok_or_else(missing)?.len();
            if found != *count.get_or_insert(found) {
                let text = format!("location {location} has {found} lanes, others have {}", count.unwrap_or_default());
                return Err(ExactError::Lanes(text));
            }
        }
        let count = count.unwrap_or_default();
        if self.code.derivatives && !quads(&lanes.fragment_coordinates) {
            let text = "the program has derivatives (dFdx): lanes 4 i to 4 i + 3 must be the pixels (x, y), (x + 1, y), \
                        (x, y + 1) and (x + 1, y + 1)";
            return Err(ExactError::Lanes(text.into()));
        }
        Ok(count)
    }
}

/// Whether every four lanes are a quad.
fn quads<N: Number>(at: &[[N; 4]]) -> bool {
    let near = |a: N, b: f64, c: N| a.sub(c).equal(N::new(b)).may_hold();
    at.len().is_multiple_of(4)
        && at.chunks_exact(4).all(|quad| {
            (0..4).all(|pixel| {
                near(quad[pixel][0], f64::from(pixel as u32 % 2), quad[0][0])
                    && near(quad[pixel][1], f64::from(pixel as u32 / 2), quad[0][1])
            })
        })
}
