//! Reflection of optimized SPIR-V: the live bindings of a program.

use super::bindings::{ImageInput, SamplerInput};
use crate::shader::spirv::{Decoration, ExecutionModel, Op, instructions};
use spirq::ReflectConfig;
use spirq::ty::{DescriptorType, Type};
use spirq::var::Variable;
use std::collections::{BTreeSet, HashMap};

/// Binding of the picture that a compute shader writes: see `glsl/trace.glsl`.
pub(crate) const PICTURE_BINDING: u32 = 61;
/// Push constants of a compute shader: see `glsl/pixel.glsl`.
const AREA_BLOCK: &str = "Area";

/// A binding of set 0.
#[derive(Clone, Debug, PartialEq)]
pub struct Resource {
    /// Name in `interface.glsl`; of a block, the block's.
    pub name: String,
    /// Number of the binding.
    pub binding: u32,
    /// Kind of the resource.
    pub holds: Use,
    /// Whether the vertex stage reads it.
    pub vertex: bool,
    /// Whether the fragment stage reads it.
    pub fragment: bool,
}

impl Resource {
    /// The image, and its object: `""` for an image of the scene or of its main object. `None` for blocks, samplers and
    /// images of no known name.
    pub fn image(&self) -> Option<(ImageInput, &str)> {
        if self.holds == Use::Image { ImageInput::of(&self.name) } else { None }
    }

    /// The sampler; `None` for blocks, images and samplers of no known name.
    pub fn sampler(&self) -> Option<SamplerInput> {
        if self.holds == Use::Sampler { SamplerInput::of(&self.name) } else { None }
    }
}

/// Kind of a resource.
#[derive(Clone, Debug, PartialEq)]
pub enum Use {
    /// A uniform block.
    Block(Block),
    /// A sampled image.
    Image,
    /// A sampler.
    Sampler,
}

/// A uniform block in std140 layout.
#[derive(Clone, Debug, PartialEq)]
pub struct Block {
    /// Size in bytes.
    pub bytes: usize,
    /// Members by offset.
    pub members: Vec<Member>,
}

/// A member of a block: consecutive floats from its offset.
#[derive(Clone, Debug, PartialEq)]
pub struct Member {
    /// Name in GLSL.
    pub name: String,
    /// Offset in bytes.
    pub offset: usize,
    /// Number of floats: 1, 4 (a vec4) or 16 (a mat4, column by column).
    pub floats: usize,
}

/// Error of reflection.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum ReflectError {
    /// The SPIR-V is malformed.
    #[error("the linked program cannot be reflected: {0}")]
    Spirv(String),
    /// The renderer does not provide resources of this kind.
    #[error(
        "`{0}` is not a uniform block of floats, an image or a sampler of set 0; declare resources in interface.glsl only"
    )]
    Foreign(String),
}

impl Block {
    /// Fills the block, each member from `value`.
    ///
    /// # Errors
    /// The name of a member for which `value` has nothing, or another number of floats.
    pub fn fill<'a>(&self, value: impl Fn(&str) -> Option<&'a [f32]>) -> Result<Vec<u8>, String> {
        let mut bytes = vec![0; self.bytes];
        for member in &self.members {
            let floats = value(&member.name).filter(|floats| floats.len() == member.floats);
            let floats = floats.ok_or_else(|| member.name.clone())?;
            bytes[member.offset..][..4 * floats.len()].copy_from_slice(bytemuck::cast_slice(floats));
        }
        Ok(bytes)
    }
}

/// Bindings of both stages, by number.
pub(super) fn resources(vertex: &[u32], fragment: &[u32]) -> Result<Vec<Resource>, ReflectError> {
    let mut all: Vec<Resource> = Vec::new();
    for (code, is_vertex) in [(vertex, true), (fragment, false)] {
        for mut resource in stage(code)? {
            match all.iter_mut().find(|known| known.binding == resource.binding) {
                Some(known) => {
                    known.vertex |= is_vertex;
                    known.fragment |= !is_vertex;
                }
                None => {
                    resource.vertex = is_vertex;
                    resource.fragment = !is_vertex;
                    all.push(resource);
                }
            }
        }
    }
    all.sort_by_key(|resource| resource.binding);
    Ok(all)
}

/// Whether a module is a compute shader.
pub(super) fn is_compute(code: &[u32]) -> bool {
    const COMPUTE: u32 = ExecutionModel::GLCompute as u32;
    instructions(code).any(|instruction| matches!(instruction, (Op::EntryPoint, &[_, COMPUTE, ..])))
}

/// Block members that a stage reads: pairs of a binding and a member index.
pub(super) fn members_read(code: &[u32]) -> BTreeSet<(u32, u32)> {
    const BINDING: u32 = Decoration::Binding as u32;
    let (mut bindings, mut constants, mut read) = (HashMap::new(), HashMap::new(), BTreeSet::new());
    for instruction in instructions(code) {
        match instruction {
            (Op::Decorate, &[_, target, BINDING, number]) => drop(bindings.insert(target, number)),
            (Op::Constant, &[_, _, result, value]) => drop(constants.insert(result, value)),
            (Op::AccessChain | Op::InBoundsAccessChain, &[_, _, _, base, first, ..]) => {
                let found = bindings.get(&base).zip(constants.get(&first));
                read.extend(found.map(|(binding, member)| (*binding, *member)));
            }
            _ => {}
        }
    }
    read
}

fn stage(code: &[u32]) -> Result<Vec<Resource>, ReflectError> {
    let entries = ReflectConfig::new()
        .spv(code)
        .ref_all_rscs(false)
        .reflect()
        .map_err(|error| ReflectError::Spirv(error.to_string()))?;
    let variables = entries.into_iter().flat_map(|entry| entry.vars);
    variables
        .filter_map(|variable| match variable {
            Variable::Descriptor { desc_bind, .. } if desc_bind.bind() == PICTURE_BINDING => None,
            Variable::Descriptor { name, desc_bind, desc_ty, ty, .. } => {
                let name = name.filter(|name| !name.is_empty()).or_else(|| type_name(&ty)).unwrap_or_default();
                let holds = match (&desc_ty, &ty, desc_bind.set()) {
                    (DescriptorType::UniformBuffer(), Type::Struct(block), 0) => Some(block_of(block).map(Use::Block)),
                    (DescriptorType::SampledImage(), _, 0) => Some(Ok(Use::Image)),
                    (DescriptorType::Sampler(), _, 0) => Some(Ok(Use::Sampler)),
                    _ => None,
                };
                let holds = holds.unwrap_or_else(|| Err(ReflectError::Foreign(name.clone())));
                let binding = desc_bind.bind();
                Some(holds.map(|holds| Resource { name, binding, holds, vertex: false, fragment: false }))
            }
            Variable::PushConstant { name, ty, .. } if type_name(&ty).is_none_or(|block| block != AREA_BLOCK) => {
                Some(Err(ReflectError::Foreign(name.unwrap_or_default())))
            }
            _ => None,
        })
        .collect()
}

fn type_name(ty: &Type) -> Option<String> {
    match ty {
        Type::Struct(block) => block.name.clone(),
        _ => None,
    }
}

fn block_of(block: &spirq::ty::StructType) -> Result<Block, ReflectError> {
    let mut members = Vec::new();
    for member in &block.members {
        let name = member.name.clone().unwrap_or_default();
        let floats = match &member.ty {
            Type::Scalar(spirq::ty::ScalarType::Float { bits: 32 }) => 1,
            Type::Vector(vector) if vector.nscalar == 4 => 4,
            Type::Matrix(matrix) if matrix.nvector == 4 && matrix.vector_ty.nscalar == 4 => 16,
            _ => return Err(ReflectError::Foreign(name)),
        };
        let offset = member.offset.ok_or_else(|| ReflectError::Foreign(name.clone()))?;
        members.push(Member { name, offset, floats });
    }
    let end = members.last().map_or(0, |member| member.offset + 4 * member.floats);
    Ok(Block { bytes: end.next_multiple_of(16), members })
}
