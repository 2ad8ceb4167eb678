//! Programs: SPIR-V that has been read, lowered and optimized.

use crate::code::Code;
use crate::error::ExactError;
use crate::lower::faults::Watch;
use crate::lower::function::lower;
use crate::lower::words::Words;
use crate::optimize::allocate::allocate;
use crate::optimize::bool_fold::fold_bools;
use crate::optimize::flatten::flatten;
use crate::optimize::tidy::{drop_unread, tidy};
use crate::texture::{Texture, Wrap};
use hypertexture_noise::Lattice;
use naga::front::spv::Error as SpirvError;
use std::collections::BTreeMap;

/// A program that has been read and lowered.
#[derive(Debug)]
pub struct Program {
    pub(crate) code: Code,
}

/// Inputs of a program, by binding of set 0.
#[derive(Clone, Debug, Default)]
pub struct Inputs {
    /// Uniform blocks, laid out as on the GPU.
    pub blocks: BTreeMap<u32, Vec<u8>>,
    /// The other ends of ranges of floats in `blocks`: bounds hold for every block in between. Empty: single values.
    pub until: BTreeMap<u32, Vec<u8>>,
    /// Images.
    pub images: BTreeMap<u32, Texture>,
    /// Samplers.
    pub samplers: BTreeMap<u32, Wrap>,
    /// Noise in place of images: coordinates are in lattice cells, the level selects the [`Knots`](hypertexture_noise::Knots). The
    /// gradient is in RGB, the value in A.
    pub noises: BTreeMap<u32, Lattice>,
    /// Bounds of the differences between the texels of images and those that a device reads.
    pub inexact: BTreeMap<u32, f32>,
}

impl Program {
    /// Reads the fragment stage of a SPIR-V module. `constants` are IDs and bits of specialization constants; others keep
    /// their defaults.
    ///
    /// # Errors
    /// [`ExactError::Spirv`] and [`ExactError::Uncovered`].
    pub fn read(spirv: &[u32], constants: &[(u32, u32)]) -> Result<Program, ExactError> {
        Program::read_with(spirv, constants, None, |_| ())
    }

    /// [`Program::read`] with an output at [`FAULTS`](crate::FAULTS) that holds the first fault in the watched files.
    ///
    /// # Errors
    /// As [`Program::read`].
    pub fn read_watched(spirv: &[u32], constants: &[(u32, u32)], watch: &Watch<'_>) -> Result<Program, ExactError> {
        Program::read_with(spirv, constants, Some(watch), |_| ())
    }

    /// Reads the part of a program that one channel of an output depends on. The result has it as its first channel; the
    /// others are 0.
    ///
    /// # Errors
    /// As [`Program::read`].
    pub fn read_channel(
        spirv: &[u32],
        constants: &[(u32, u32)],
        (output, channel): (u32, usize),
    ) -> Result<Program, ExactError> {
        Program::read_with(spirv, constants, None, |code| {
            code.outputs.retain(|(location, _)| *location == output);
            code.outputs.iter_mut().for_each(|(_, regs)| *regs = regs.get(channel).copied().into_iter().collect());
        })
    }

    fn read_with(
        spirv: &[u32],
        constants: &[(u32, u32)],
        watch: Option<&Watch<'_>>,
        change: impl FnOnce(&mut Code),
    ) -> Result<Program, ExactError> {
        let words = Words::read(spirv, constants)?;
        let options = naga::front::spv::Options {
            adjust_coordinate_space: false,
            strict_capabilities: false,
            block_ctx_dump_prefix: None,
        };
        let module = naga::front::spv::Frontend::new(words.words.iter().copied(), &options).parse();
        let uncovered = |construct, place| ExactError::Uncovered { construct, place };
        let module = module.map_err(|error| match error {
            SpirvError::UnsupportedInstruction(_, op) => {
                uncovered(format!("the instruction {op:?}"), words.place_of_op(op))
            }
            SpirvError::UnsupportedExtInst(number) => {
                let unknown = || format!("number {number} of GLSL.std.450");
                let name = spirv::GlslStd450Op::from_u32(number).map_or_else(unknown, |name| format!("{name:?}"));
                uncovered(format!("the function {name}"), words.place_of_function(number))
            }
            other => ExactError::Spirv(other.to_string()),
        })?;
        let (mut code, mut classes) = lower(&module, &words, watch)?;
        change(&mut code);
        drop_unread(&mut code);
        flatten(&mut code, &mut classes);
        fold_bools(&mut code);
        tidy(&mut code, &classes);
        allocate(&mut code, &classes);
        Ok(Program { code })
    }

    /// File and line of a place, by its number in [`FAULTS`](crate::FAULTS).
    pub fn place(&self, number: usize) -> &str {
        self.code.places.get(number).map_or("", String::as_str)
    }

    /// Number of scalar instructions, once for each inlined call and loop body.
    pub fn instructions(&self) -> usize {
        self.code.instrs.len()
    }
}
