//! The words of a SPIR-V module, prepared for naga: without lines, and with specialization constants replaced.

use crate::error::ExactError;
use spirv::Op;
use std::collections::HashMap;

/// Words before the first instruction.
const HEADER: usize = 5;

/// The words, and the lines that were taken out.
pub(crate) struct Words {
    pub words: Vec<u32>,
    files: HashMap<u32, String>,
    names: HashMap<u32, String>,
    /// File of each function, by the ID of the function.
    functions: HashMap<u32, u32>,
    /// First word, file and line of each range of words, in order.
    lines: Vec<(usize, u32, u32)>,
    /// Words before the functions that naga leaves out of the spans of expressions: lists at the ends of instructions.
    uncounted: usize,
}

/// The opcode of an instruction by its first word.
fn op(word: u32) -> Option<Op> {
    Op::from_u32(word & 0xffff)
}

/// The words of a module without lines, with these specialization constants (IDs and bits) in place.
///
/// # Errors
/// [`ExactError::Spirv`].
pub fn specialized(spirv: &[u32], constants: &[(u32, u32)]) -> Result<Vec<u32>, ExactError> {
    Words::read(spirv, constants).map(|words| words.words)
}

impl Words {
    pub(crate) fn read(spirv: &[u32], constants: &[(u32, u32)]) -> Result<Words, ExactError> {
        if spirv.len() < HEADER || spirv[0] != spirv::MAGIC_NUMBER {
            return Err(ExactError::Spirv("it does not start with the magic number of SPIR-V".into()));
        }
        let mut found = Words {
            words: spirv[..HEADER].to_vec(),
            files: HashMap::new(),
            names: HashMap::new(),
            functions: HashMap::new(),
            lines: Vec::new(),
            uncounted: 0,
        };
        let mut function = None; // before its first line
        let mut specialized = HashMap::new();
        let mut at = HEADER;
        while at < spirv.len() {
            let (op, count) = (op(spirv[at]), (spirv[at] >> 16) as usize);
            let instruction = spirv.get(at..at + count).filter(|_| count > 0);
            let instruction = instruction.ok_or_else(|| ExactError::Spirv("an instruction is cut off".into()))?;
            at += count;
            let renamed = |op: Op| (count as u32) << 16 | op as u32;
            let id = |index: usize| instruction.get(index).copied().unwrap_or_default();
            found.uncounted += match op {
                Some(Op::EntryPoint) => {
                    let behind_name = instruction.iter().skip(3).skip_while(|word| **word >> 24 != 0);
                    behind_name.count().saturating_sub(1)
                }
                Some(Op::ExecutionMode | Op::TypeFunction) => count.saturating_sub(3),
                _ => 0,
            };
            match op {
                Some(Op::String) => {
                    found.files.insert(id(1), text(&instruction[2..]));
                    found.words.extend(instruction);
                }
                Some(Op::Line) => {
                    found.functions.extend(function.take().map(|function| (function, id(1))));
                    found.lines.push((found.words.len(), id(1), id(2)));
                }
                Some(Op::Name) => {
                    found.names.insert(id(1), text(&instruction[2..]));
                    found.words.extend(instruction);
                }
                Some(Op::Function) => {
                    function = Some(id(2));
                    found.words.extend(instruction);
                }
                Some(Op::NoLine) => found.lines.push((found.words.len(), 0, 0)),
                Some(Op::ModuleProcessed) => {}
                Some(Op::Decorate) if id(2) == spirv::Decoration::SpecId as u32 => {
                    let value = constants.iter().find(|(number, _)| *number == id(3)).map(|(_, value)| *value);
                    specialized.extend(value.map(|value| (id(1), value)));
                }
                Some(Op::SpecConstant) => {
                    let value = specialized.get(&id(2)).copied().unwrap_or(id(3));
                    found.words.extend([renamed(Op::Constant), id(1), id(2), value]);
                }
                Some(default @ (Op::SpecConstantTrue | Op::SpecConstantFalse)) => {
                    let truth = specialized.get(&id(2)).map_or(default == Op::SpecConstantTrue, |value| *value != 0);
                    let constant = if truth { Op::ConstantTrue } else { Op::ConstantFalse };
                    found.words.extend([renamed(constant), id(1), id(2)]);
                }
                Some(Op::SpecConstantComposite) => {
                    found.words.push(renamed(Op::ConstantComposite));
                    found.words.extend(&instruction[1..]);
                }
                _ => found.words.extend(instruction),
            }
        }
        Ok(found)
    }

    /// Name and file of each function.
    pub(crate) fn functions(&self) -> impl Iterator<Item = (&String, &String)> {
        self.functions.iter().filter_map(|(function, file)| Some((self.names.get(function)?, self.files.get(file)?)))
    }

    /// File and line of a byte of the words.
    fn place(&self, byte: usize) -> Option<String> {
        let after = self.lines.partition_point(|(word, _, _)| 4 * word <= byte);
        let (_, file, line) = self.lines[..after].last()?;
        self.files.get(file).map(|file| format!("{file}:{line}"))
    }

    /// File and line of an expression of a function, by the first byte of its span in naga.
    pub(crate) fn place_of_expression(&self, byte: usize) -> Option<String> {
        self.place(byte + 4 * self.uncounted)
    }

    /// File and line of the first instruction that satisfies a predicate.
    fn place_of(&self, is: impl Fn(&[u32]) -> bool) -> String {
        let mut at = HEADER;
        while at < self.words.len() {
            let end = at + ((self.words[at] >> 16) as usize).max(1);
            if is(&self.words[at..end]) {
                return self.place(4 * at).unwrap_or_else(unknown_place);
            }
            at = end;
        }
        unknown_place()
    }

    /// File and line of the first instruction with an opcode.
    pub(crate) fn place_of_op(&self, wanted: Op) -> String {
        self.place_of(|instruction| op(instruction[0]) == Some(wanted))
    }

    /// File and line of the first call of a function of GLSL.std.450.
    pub(crate) fn place_of_function(&self, number: u32) -> String {
        self.place_of(|instruction| op(instruction[0]) == Some(Op::ExtInst) && instruction.get(4) == Some(&number))
    }
}

/// Text in place of file and line, for SPIR-V without debug information.
pub(crate) fn unknown_place() -> String {
    "its line is not known".into()
}

fn text(words: &[u32]) -> String {
    let bytes = words.iter().flat_map(|word| word.to_le_bytes()).take_while(|byte| *byte != 0);
    String::from_utf8_lossy(&bytes.collect::<Vec<u8>>()).into_owned()
}
