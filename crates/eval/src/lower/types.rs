//! Types and values during lowering: lists of scalar registers.

use crate::code::{File, Reg};
use naga::{AddressSpace, Handle, ImageDimension, Module, ScalarKind, Type, TypeInner};
use std::rc::Rc;

/// Kinds of scalars.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ScalarType {
    Float,
    Sint,
    Uint,
    Bool,
}

impl ScalarType {
    pub(crate) fn file(self) -> File {
        match self {
            ScalarType::Float => File::Float,
            ScalarType::Sint | ScalarType::Uint => File::Int,
            ScalarType::Bool => File::Bool,
        }
    }

    pub(crate) fn signed(self) -> bool {
        self == ScalarType::Sint
    }

    pub(crate) fn of(scalar: naga::Scalar) -> Option<ScalarType> {
        match (scalar.kind, scalar.width) {
            (ScalarKind::Float, 4) => Some(ScalarType::Float),
            (ScalarKind::Sint, 4) => Some(ScalarType::Sint),
            (ScalarKind::Uint, 4) => Some(ScalarType::Uint),
            (ScalarKind::Bool, _) => Some(ScalarType::Bool),
            _ => None,
        }
    }
}

/// Types of values.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Ty {
    Scalar(ScalarType),
    Vector(ScalarType, usize),
    /// Columns and rows; of floats, column by column.
    Matrix(usize, usize),
    Array(Rc<Ty>, usize),
    Struct(Rc<[Ty]>),
}

impl Ty {
    /// Converts a type of naga, or names the uncovered construct.
    pub(crate) fn of(module: &Module, ty: Handle<Type>) -> Result<Ty, String> {
        let scalar = |scalar| ScalarType::of(scalar).ok_or_else(|| format!("the scalar type {scalar:?}"));
        match &module.types[ty].inner {
            TypeInner::Scalar(kind) => Ok(Ty::Scalar(scalar(*kind)?)),
            TypeInner::Vector { size, scalar: kind } => Ok(Ty::Vector(scalar(*kind)?, *size as usize)),
            TypeInner::Matrix { columns, rows, .. } => Ok(Ty::Matrix(*columns as usize, *rows as usize)),
            TypeInner::Array { base, size: naga::ArraySize::Constant(size), .. } => {
                Ok(Ty::Array(Rc::new(Ty::of(module, *base)?), size.get() as usize))
            }
            TypeInner::Struct { members, .. } => {
                members.iter().map(|member| Ty::of(module, member.ty)).collect::<Result<_, _>>().map(Ty::Struct)
            }
            TypeInner::Array { .. } => Err("an array without a fixed size".into()),
            TypeInner::Image { .. } | TypeInner::Sampler { .. } => Err("an image or sampler as a value".into()),
            _ => Err("a type other than numbers, matrices, arrays and structures".into()),
        }
    }

    /// Number of scalars.
    pub(crate) fn size(&self) -> usize {
        match self {
            Ty::Scalar(_) => 1,
            Ty::Vector(_, size) => *size,
            Ty::Matrix(columns, rows) => columns * rows,
            Ty::Array(base, count) => base.size() * count,
            Ty::Struct(members) => members.iter().map(Ty::size).sum(),
        }
    }

    /// The kinds of all scalars.
    pub(crate) fn kinds(&self) -> Vec<ScalarType> {
        match self {
            Ty::Scalar(kind) => vec![*kind],
            Ty::Vector(kind, size) => vec![*kind; *size],
            Ty::Matrix(columns, rows) => vec![ScalarType::Float; columns * rows],
            Ty::Array(base, count) => base.kinds().repeat(*count),
            Ty::Struct(members) => members.iter().flat_map(Ty::kinds).collect(),
        }
    }

    /// Type and first scalar of an element.
    pub(crate) fn element(&self, index: usize) -> Option<(Ty, usize)> {
        match self {
            Ty::Vector(kind, size) if index < *size => Some((Ty::Scalar(*kind), index)),
            Ty::Matrix(columns, rows) if index < *columns => Some((Ty::Vector(ScalarType::Float, *rows), index * rows)),
            Ty::Array(base, count) if index < *count => Some(((**base).clone(), index * base.size())),
            Ty::Struct(members) if index < members.len() => {
                Some((members[index].clone(), members[..index].iter().map(Ty::size).sum()))
            }
            _ => None,
        }
    }

    /// Number of elements.
    pub(crate) fn count(&self) -> usize {
        match self {
            Ty::Scalar(_) => 0,
            Ty::Vector(_, size) => *size,
            Ty::Matrix(columns, _) => *columns,
            Ty::Array(_, count) => *count,
            Ty::Struct(members) => members.len(),
        }
    }

    /// The kind of a scalar, vector or matrix.
    pub(crate) fn kind(&self) -> Option<ScalarType> {
        match self {
            Ty::Scalar(kind) | Ty::Vector(kind, _) => Some(*kind),
            Ty::Matrix(..) => Some(ScalarType::Float),
            _ => None,
        }
    }

    /// The shape with another kind of scalar.
    pub(crate) fn with(&self, kind: ScalarType) -> Ty {
        match self {
            Ty::Vector(_, size) => Ty::Vector(kind, *size),
            _ => Ty::Scalar(kind),
        }
    }
}

/// Appends the kind and offset in bytes of each scalar of a uniform block.
pub(crate) fn layout(
    module: &Module,
    ty: Handle<Type>,
    start: u32,
    out: &mut Vec<(ScalarType, u32)>,
) -> Result<(), String> {
    let kind = |scalar| ScalarType::of(scalar).ok_or_else(|| format!("the scalar type {scalar:?}"));
    match &module.types[ty].inner {
        TypeInner::Scalar(scalar) => out.push((kind(*scalar)?, start)),
        TypeInner::Vector { size, scalar } => {
            let kind = kind(*scalar)?;
            out.extend((0..*size as u32).map(|index| (kind, start + 4 * index)));
        }
        TypeInner::Matrix { columns, rows, .. } => {
            let stride = if *rows as u32 == 2 { 8 } else { 16 };
            for column in 0..*columns as u32 {
                out.extend((0..*rows as u32).map(|row| (ScalarType::Float, start + stride * column + 4 * row)));
            }
        }
        TypeInner::Array { base, size: naga::ArraySize::Constant(size), stride } => {
            for index in 0..size.get() {
                layout(module, *base, start + stride * index, out)?;
            }
        }
        TypeInner::Struct { members, .. } => {
            for member in members {
                layout(module, member.ty, start + member.offset, out)?;
            }
        }
        _ => return Err("a block with members other than numbers".into()),
    }
    Ok(())
}

#[derive(Clone, Debug)]
pub(crate) struct Value {
    pub ty: Ty,
    pub regs: Rc<[Reg]>,
}

impl Value {
    pub(crate) fn new(ty: Ty, regs: Vec<Reg>) -> Value {
        Value { ty, regs: regs.into() }
    }

    pub(crate) fn element(&self, index: usize) -> Option<Value> {
        let (ty, first) = self.ty.element(index)?;
        let regs = self.regs[first..first + ty.size()].into();
        Some(Value { ty, regs })
    }
}

/// Target of a pointer: one of `choices`, each with a register for every scalar of the type.
#[derive(Clone, Debug)]
pub(crate) struct Variable {
    pub ty: Ty,
    pub choices: Vec<Rc<[Reg]>>,
    /// Index of the choice; `None` if there is one.
    pub index: Option<Reg>,
}

impl Variable {
    pub(crate) fn element(&self, index: usize) -> Option<Variable> {
        let (ty, first) = self.ty.element(index)?;
        let part = |regs: &Rc<[Reg]>| regs[first..first + ty.size()].into();
        Some(Variable { choices: self.choices.iter().map(part).collect(), index: self.index, ty })
    }
}

/// A lowered expression.
#[derive(Clone, Debug)]
pub(crate) enum Lowered {
    Value(Value),
    Variable(Variable),
    /// Binding, axes, whether its texels are floats.
    Image(u32, usize, bool),
    /// Binding.
    Sampler(u32),
}

/// The image or sampler of a binding.
pub(crate) fn image(inner: &TypeInner, binding: u32) -> Result<Lowered, String> {
    match inner {
        TypeInner::Sampler { comparison: false } => Ok(Lowered::Sampler(binding)),
        TypeInner::Image { dim, arrayed: false, class: naga::ImageClass::Sampled { kind, multi: false } } => {
            let axes = match dim {
                ImageDimension::D1 => 1,
                ImageDimension::D2 => 2,
                ImageDimension::D3 => 3,
                ImageDimension::Cube => return Err("a cube map".into()),
            };
            Ok(Lowered::Image(binding, axes, *kind == ScalarKind::Float))
        }
        TypeInner::Image { .. } => Err("an image other than a plain sampled 1D, 2D or 3D image".into()),
        _ => Err("a resource other than a uniform block, image or sampler".into()),
    }
}

/// Whether variables of an address space belong to one invocation.
pub(crate) fn is_private(space: AddressSpace) -> bool {
    matches!(space, AddressSpace::Private | AddressSpace::Function)
}
