//! A SPIR-V module as types, constants and functions of blocks.

use super::scalar::Scalar;
use crate::spirv::{Op, StorageClass, instructions};
use std::collections::{HashMap, HashSet};

/// File (the ID of its name) and line of an instruction.
pub(super) type Line = (u32, u32);

/// A type, by what it holds.
#[derive(Clone, Debug)]
pub(super) enum Type {
    /// A number or a truth; also an image, a sampler or a pointer.
    Scalar,
    /// Equal parts: vectors, matrices and arrays; type and number.
    Parts(u32, usize),
    /// A structure.
    Struct(Vec<u32>),
}

/// An instruction: opcode, words and line.
pub(super) type Instruction<'a> = (Op, &'a [u32], Line);

/// A basic block; the last instruction ends it.
#[derive(Default)]
pub(super) struct Block<'a> {
    pub(super) instructions: Vec<Instruction<'a>>,
    pub(super) is_loop: bool,
}

/// A function.
pub(super) struct Function<'a> {
    /// Type of the result.
    pub(super) result: u32,
    pub(super) parameters: Vec<u32>,
    pub(super) blocks: Vec<Block<'a>>,
    /// Position of each block by its label.
    pub(super) labels: HashMap<u32, usize>,
    /// Line of its head, else of its first instruction.
    pub(super) line: Line,
}

/// A module.
#[derive(Default)]
pub(super) struct Model<'a> {
    pub(super) files: HashMap<u32, String>,
    pub(super) names: HashMap<u32, String>,
    pub(super) constants: HashMap<u32, Scalar>,
    pub(super) functions: HashMap<u32, Function<'a>>,
    pub(super) entry: u32,
    /// Global variables.
    pub(super) globals: HashSet<u32>,
    types: HashMap<u32, Type>,
    /// Arrays whose length is chosen later.
    adjustable: HashSet<u32>,
    /// Types that pointers point to.
    targets: HashMap<u32, u32>,
    /// Type of each value.
    kinds: HashMap<u32, u32>,
}

/// Text of a literal.
fn text(words: &[u32]) -> String {
    let bytes = words.iter().flat_map(|word| word.to_le_bytes()).take_while(|byte| *byte != 0);
    String::from_utf8_lossy(&bytes.collect::<Vec<u8>>()).into_owned()
}

impl<'a> Model<'a> {
    /// Reads the words of a module, whose functions have structured control flow.
    pub(super) fn read(module: &'a [u32]) -> Model<'a> {
        const PRIVATE: u32 = StorageClass::Private as u32;
        let mut model = Model::default();
        let (mut line, mut current) = ((0, 0), None::<(u32, Function<'a>)>);
        // Types of floats, and defaults of specialization constants.
        let (mut floats, mut defaults) = (HashSet::new(), HashMap::new());
        for (op, words) in instructions(module) {
            match (op, words) {
                (Op::String, [_, id, rest @ ..]) => drop(model.files.insert(*id, text(rest))),
                (Op::Name, [_, id, rest @ ..]) => drop(model.names.insert(*id, text(rest))),
                (Op::EntryPoint, &[_, _, function, ..]) => model.entry = function,
                (Op::Line, &[_, file, number, ..]) => line = (file, number),
                (Op::NoLine, _) => line = (0, 0),
                (Op::TypeInt | Op::TypeBool, &[_, id, ..]) => drop(model.types.insert(id, Type::Scalar)),
                (Op::TypeFloat, &[_, id, ..]) => {
                    model.types.insert(id, Type::Scalar);
                    floats.insert(id);
                }
                (Op::TypeVector | Op::TypeMatrix, &[_, id, part, count]) => {
                    model.types.insert(id, Type::Parts(part, count as usize));
                }
                (Op::TypeArray, &[_, id, part, length]) => {
                    let known =
                        model.constants.get(&length).or(defaults.get(&length)).and_then(|length| length.integer());
                    model.types.insert(id, Type::Parts(part, known.unwrap_or(1).max(1) as usize));
                    if !model.constants.contains_key(&length) {
                        model.adjustable.insert(id);
                    }
                }
                (Op::TypeStruct, [_, id, parts @ ..]) => drop(model.types.insert(*id, Type::Struct(parts.to_vec()))),
                (Op::TypePointer, &[_, id, _, to]) => drop(model.targets.insert(id, to)),
                (Op::ConstantTrue | Op::ConstantFalse, &[_, _, id]) => {
                    model.constants.insert(id, Scalar::Bool(op == Op::ConstantTrue));
                }
                (Op::Constant, &[_, kind, id, bits]) => {
                    let is_float = floats.contains(&kind);
                    model
                        .constants
                        .insert(id, if is_float { Scalar::Float(f32::from_bits(bits)) } else { Scalar::Int(bits) });
                }
                (Op::SpecConstant, &[_, _, id, bits]) => drop(defaults.insert(id, Scalar::Int(bits))),
                (Op::Variable, &[_, _, id, PRIVATE, ..]) => drop(model.globals.insert(id)),
                (Op::Function, &[_, result, id, ..]) => {
                    let (parameters, blocks, labels) = Default::default();
                    current = Some((id, Function { result, parameters, blocks, labels, line }));
                }
                (Op::FunctionEnd, _) => {
                    model.functions.extend(current.take());
                    line = (0, 0);
                }
                (_, words) => {
                    if let Some((_, function)) = &mut current {
                        function.take(op, words, line);
                    }
                }
            }
            if let &[_, kind, id, ..] = words
                && (model.types.contains_key(&kind) || model.targets.contains_key(&kind))
                && op != Op::TypePointer
            {
                model.kinds.insert(id, kind);
            }
        }
        model
    }

    /// Type of a value; of a pointer, what it points to.
    pub(super) fn kind(&self, id: u32) -> u32 {
        let kind = self.kinds.get(&id).copied().unwrap_or_default();
        self.targets.get(&kind).copied().unwrap_or(kind)
    }

    /// Whether a value is a pointer.
    pub(super) fn is_pointer(&self, id: u32) -> bool {
        self.kinds.get(&id).is_some_and(|kind| self.targets.contains_key(kind))
    }

    /// Number of scalars in a value of a type.
    pub(super) fn size(&self, kind: u32) -> usize {
        match self.types.get(&kind) {
            Some(Type::Parts(part, count)) => self.size(*part).saturating_mul(*count),
            Some(Type::Struct(parts)) => parts.iter().map(|part| self.size(*part)).sum(),
            Some(Type::Scalar) | None => 1,
        }
    }

    /// Number of parts of a type; `None` for a scalar.
    pub(super) fn count(&self, kind: u32) -> Option<usize> {
        match self.types.get(&kind)? {
            Type::Scalar => None,
            Type::Parts(_, count) => Some(*count),
            Type::Struct(parts) => Some(parts.len()),
        }
    }

    /// Type of a part, and number of scalars before it.
    pub(super) fn part(&self, kind: u32, index: usize) -> Option<(u32, usize)> {
        match self.types.get(&kind)? {
            Type::Scalar => None,
            Type::Parts(part, _) => Some((*part, self.size(*part).saturating_mul(index))),
            Type::Struct(parts) => {
                let before = parts.iter().take(index).map(|part| self.size(*part)).sum();
                parts.get(index).map(|part| (*part, before))
            }
        }
    }

    /// Whether the number of parts of a type is that of the source.
    pub(super) fn is_of_known_length(&self, kind: u32) -> bool {
        !self.adjustable.contains(&kind)
    }

    /// Whether a type has values: `void` has none.
    pub(super) fn is_known(&self, kind: u32) -> bool {
        self.types.contains_key(&kind)
    }

    /// Whether a type is a structure.
    pub(super) fn is_structure(&self, kind: u32) -> bool {
        matches!(self.types.get(&kind), Some(Type::Struct(_)))
    }

    /// Name of a value in the source; empty for a value of the compiler.
    pub(super) fn name(&self, id: u32) -> &str {
        self.names.get(&id).map_or("", String::as_str)
    }

    /// Name of a function without its mangled parameters.
    pub(super) fn function_name(&self, id: u32) -> &str {
        self.name(id).split('(').next().unwrap_or_default()
    }

    /// File of a line.
    pub(super) fn file(&self, line: Line) -> &str {
        self.files.get(&line.0).map_or("", String::as_str)
    }
}

impl<'a> Block<'a> {
    /// The last instruction.
    pub(super) fn end(&self) -> Option<Instruction<'a>> {
        self.instructions.last().copied()
    }
}

impl<'a> Function<'a> {
    fn take(&mut self, op: Op, words: &'a [u32], line: Line) {
        match (op, words) {
            (Op::FunctionParameter, &[_, _, id]) => self.parameters.push(id),
            (Op::Label, &[_, label]) => {
                self.labels.insert(label, self.blocks.len());
                self.blocks.push(Block::default());
            }
            _ => {
                let Some(block) = self.blocks.last_mut() else { return };
                block.is_loop |= op == Op::LoopMerge;
                if self.line.1 == 0 {
                    self.line = line;
                }
                block.instructions.push((op, words, line));
            }
        }
    }
}
