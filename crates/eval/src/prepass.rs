//! SPIR-V before it is read: lines are taken out and remembered, specialization constants get their values.

use super::ExactError;
use std::collections::HashMap;

const HEADER: usize = 5;
const STRING: u32 = 7;
const EXTENDED: u32 = 12;
const LINE: u32 = 8;
const NO_LINE: u32 = 317;
const MODULE_PROCESSED: u32 = 330;
const ENTRY_POINT: u32 = 15;
const EXECUTION_MODE: u32 = 16;
const TYPE_FUNCTION: u32 = 33;
const DECORATE: u32 = 71;
const SPEC_ID: u32 = 1;
const CONSTANT_TRUE: u32 = 41;
const CONSTANT_FALSE: u32 = 42;
const CONSTANT: u32 = 43;
const SPEC_TRUE: u32 = 48;
const SPEC_FALSE: u32 = 49;
const SPEC_CONSTANT: u32 = 50;
const SPEC_COMPOSITE: u32 = 51;
const COMPOSITE: u32 = 44;

/// SPIR-V without lines, and where each of its words comes from.
pub(super) struct Words {
    pub(super) words: Vec<u32>,
    files: HashMap<u32, String>,
    /// First word, file and line of what follows; in order.
    lines: Vec<(usize, u32, u32)>,
    /// Words before the functions that naga does not count where it says where an expression is: lists at the ends of instructions.
    uncounted: usize,
}

impl Words {
    pub(super) fn read(spirv: &[u32], constants: &[(u32, u32)]) -> Result<Words, ExactError> {
        if spirv.len() < HEADER || spirv[0] != 0x0723_0203 {
            return Err(ExactError::Spirv("it does not start as SPIR-V does".into()));
        }
        let mut found =
            Words { words: spirv[..HEADER].to_vec(), files: HashMap::new(), lines: Vec::new(), uncounted: 0 };
        let mut specialized = HashMap::new();
        let mut at = HEADER;
        while at < spirv.len() {
            let (op, count) = (spirv[at] & 0xffff, (spirv[at] >> 16) as usize);
            let instruction = spirv.get(at..at + count).filter(|_| count > 0);
            let instruction = instruction.ok_or_else(|| ExactError::Spirv("an instruction is cut off".into()))?;
            at += count;
            let renamed = |op: u32| (count as u32) << 16 | op;
            let id = |index: usize| instruction.get(index).copied().unwrap_or_default();
            found.uncounted += match op {
                ENTRY_POINT => {
                    let behind_name = instruction.iter().skip(3).skip_while(|word| **word >> 24 != 0);
                    behind_name.count().saturating_sub(1)
                }
                EXECUTION_MODE | TYPE_FUNCTION => count.saturating_sub(3),
                _ => 0,
            };
            match op {
                STRING => {
                    found.files.insert(id(1), text(&instruction[2..]));
                    found.words.extend(instruction);
                }
                LINE => found.lines.push((found.words.len(), id(1), id(2))),
                NO_LINE => found.lines.push((found.words.len(), 0, 0)),
                MODULE_PROCESSED => {}
                DECORATE if id(2) == SPEC_ID => {
                    let value = constants.iter().find(|(number, _)| *number == id(3)).map(|(_, value)| *value);
                    specialized.extend(value.map(|value| (id(1), value)));
                }
                SPEC_CONSTANT => {
                    let value = specialized.get(&id(2)).copied().unwrap_or(id(3));
                    found.words.extend([renamed(CONSTANT), id(1), id(2), value]);
                }
                SPEC_TRUE | SPEC_FALSE => {
                    let truth = specialized.get(&id(2)).map_or(op == SPEC_TRUE, |value| *value != 0);
                    found.words.extend([renamed(if truth { CONSTANT_TRUE } else { CONSTANT_FALSE }), id(1), id(2)]);
                }
                SPEC_COMPOSITE => {
                    found.words.push(renamed(COMPOSITE));
                    found.words.extend(&instruction[1..]);
                }
                _ => found.words.extend(instruction),
            }
        }
        Ok(found)
    }

    /// File and line of a byte of the words.
    fn place(&self, byte: usize) -> Option<String> {
        let after = self.lines.partition_point(|(word, _, _)| 4 * word <= byte);
        let (_, file, line) = self.lines[..after].last()?;
        self.files.get(file).map(|file| format!("{file}:{line}"))
    }

    /// File and line of an expression of a function, by its first byte as naga counts.
    pub(super) fn place_of_expression(&self, byte: usize) -> Option<String> {
        self.place(byte + 4 * self.uncounted)
    }

    /// File and line of the first instruction of which this holds.
    pub(super) fn place_of(&self, is: impl Fn(&[u32]) -> bool) -> String {
        let mut at = HEADER;
        while at < self.words.len() {
            let end = at + ((self.words[at] >> 16) as usize).max(1);
            if is(&self.words[at..end]) {
                return self.place(4 * at).unwrap_or_else(unknown);
            }
            at = end;
        }
        unknown()
    }

    /// The same of an instruction by its number.
    pub(super) fn place_of_op(&self, op: u32) -> String {
        self.place_of(|instruction| instruction[0] & 0xffff == op)
    }

    /// The same of a function of GLSL by its number.
    pub(super) fn place_of_function(&self, number: u32) -> String {
        self.place_of(|instruction| instruction[0] & 0xffff == EXTENDED && instruction.get(4) == Some(&number))
    }
}

/// What is said of a place in SPIR-V that has no lines.
pub(super) fn unknown() -> String {
    "its line is not known".into()
}

fn text(words: &[u32]) -> String {
    let bytes = words.iter().flat_map(|word| word.to_le_bytes()).take_while(|byte| *byte != 0);
    String::from_utf8_lossy(&bytes.collect::<Vec<u8>>()).into_owned()
}
