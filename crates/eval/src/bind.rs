//! Programs with their inputs.

use crate::code::{Code, File, Source};
use crate::error::ExactError;
use crate::program::{Inputs, Program};
use crate::texture::{Image, Texture, Wrap, count, halved};
use std::any::{Any, TypeId};
use std::collections::{BTreeMap, HashMap};
use std::sync::{Arc, Mutex};

/// A program with its inputs.
#[derive(Debug)]
pub struct BoundProgram<'a> {
    pub(crate) code: &'a Code,
    pub(crate) images: Vec<Image<'a>>,
    /// Values of [`Code::sources`], in order.
    pub(crate) values: Vec<Constant>,
    pub(crate) uniforms: UniformCache,
}

/// Value of a uniform register.
#[derive(Clone, Copy, Debug)]
pub(crate) enum Constant {
    Float(f64),
    Between(f64, f64),
    Int(u32, bool),
    Bool(bool),
}

/// Values of all uniform registers, by number type.
#[derive(Debug, Default)]
pub(crate) struct UniformCache(pub(crate) Mutex<HashMap<TypeId, Arc<dyn Any + Send + Sync>>>);

impl Program {
    /// Binds a program to its inputs.
    ///
    /// # Errors
    /// [`ExactError::Missing`] and [`ExactError::Unfit`].
    pub fn bind<'a>(&'a self, inputs: &'a Inputs) -> Result<BoundProgram<'a>, ExactError> {
        self.bind_with(inputs, &inputs.blocks)
    }

    /// [`Program::bind`] with other uniform blocks than those of the inputs.
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
            let slack = inputs.inexact.get(&pair.image).copied().unwrap_or(0.0);
            images.push(Image::new(texture.size, &texture.texels, wrap, pair.axes, slack.into()));
        }
        let values = code.sources.iter().map(|(reg, source)| constant(inputs, blocks, reg.file, *source));
        Ok(BoundProgram { code, images, values: values.collect::<Result<_, _>>()?, uniforms: UniformCache::default() })
    }
}

/// The image of a binding, whose number of texels fits its levels.
fn image(inputs: &Inputs, binding: u32) -> Result<&Texture, ExactError> {
    let texture = inputs.images.get(&binding).ok_or(ExactError::Missing { binding, what: "an image" })?;
    let (mut size, mut needed) = (texture.size, count(texture.size));
    while needed > 0 && needed < texture.texels.len() && size != [1; 3] {
        size = halved(size);
        needed += count(size);
    }
    if needed == 0 || texture.texels.len() != needed {
        let found = format!("{} texels for a size of {:?}", texture.texels.len(), texture.size);
        return Err(ExactError::Unfit { binding, found, needed: format!("{needed} and at least one") });
    }
    Ok(texture)
}

/// Looks up the value of a source.
pub(crate) fn constant(
    inputs: &Inputs,
    blocks: &BTreeMap<u32, Vec<u8>>,
    file: File,
    source: Source,
) -> Result<Constant, ExactError> {
    Ok(match source {
        Source::Float(bits) => Constant::Float(f64::from_bits(bits)),
        Source::Int(bits, signed) => Constant::Int(bits, signed),
        Source::Bool(truth) => Constant::Bool(truth),
        Source::Size { image: binding, axis, signed } => Constant::Int(image(inputs, binding)?.size[axis], signed),
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
                    Some(until) if until != bits => Constant::Between(float(bits), float(until)),
                    _ => Constant::Float(float(bits)),
                },
                File::Int => Constant::Int(bits, signed),
                File::Bool => Constant::Bool(bits != 0),
            }
        }
    })
}
