//! The largest array of a program: a compiler takes one of 400 MB in a blink, and the driver then works on it for minutes.

use std::collections::HashMap;

const TYPE_INT: u32 = 21;
const TYPE_FLOAT: u32 = 22;
const TYPE_VECTOR: u32 = 23;
const TYPE_MATRIX: u32 = 24;
const TYPE_ARRAY: u32 = 28;
const TYPE_STRUCT: u32 = 30;
const CONSTANT: u32 = 43;
/// Words of SPIR-V before its first instruction.
const HEADER: usize = 5;

/// Bytes of the largest array type in a SPIR-V module; 0 where there is none.
pub(super) fn largest(module: &[u32]) -> u64 {
    let mut bytes: HashMap<u32, u64> = HashMap::new();
    let mut constants: HashMap<u32, u64> = HashMap::new();
    let mut largest = 0;
    let mut rest = module.get(HEADER..).unwrap_or_default();
    while let Some(&first) = rest.first() {
        let Some((words, after)) = rest.split_at_checked((first >> 16).max(1) as usize) else { break };
        rest = after;
        let of = |id: u32| bytes.get(&id).copied().unwrap_or_default();
        match (first & 0xffff, &words[1..]) {
            (TYPE_INT | TYPE_FLOAT, &[id, width, ..]) => drop(bytes.insert(id, u64::from(width / 8))),
            (TYPE_VECTOR | TYPE_MATRIX, &[id, part, count]) => {
                let size = of(part).saturating_mul(u64::from(count));
                bytes.insert(id, size);
            }
            (TYPE_STRUCT, [id, parts @ ..]) => {
                let size = parts.iter().fold(0_u64, |sum, part| sum.saturating_add(of(*part)));
                bytes.insert(*id, size);
            }
            (CONSTANT, &[_, id, value]) => drop(constants.insert(id, u64::from(value))),
            (TYPE_ARRAY, &[id, part, length]) => {
                let size = of(part).saturating_mul(constants.get(&length).copied().unwrap_or(1));
                largest = largest.max(size);
                bytes.insert(id, size);
            }
            _ => {}
        }
    }
    largest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shader::{Library, Linker, Slots, Stage};

    #[test]
    fn the_largest_array_is_found_whatever_holds_it() {
        let bytes = |body: &str| {
            let text = format!("#version 450\nlayout(location = 0) out vec4 o;\n{body}");
            let library = Library::new([("a.frag".to_string(), text)]);
            largest(
                &Linker::new().unwrap().link(&library, "a.frag", Stage::Fragment, &["a.frag"], &Slots::new()).unwrap(),
            )
        };
        assert_eq!(bytes("void main() { o = vec4(1.0); }"), 0);
        let loops = "{ S s; for (int i = 0; i < 30; i++) s.t[i][int(gl_FragCoord.x)] = vec3(gl_FragCoord.y); o = s.t[2][int(gl_FragCoord.y)].xyzz; }";
        assert_eq!(bytes(&format!("struct S {{ float a; vec3 t[30][7]; }};\nvoid main() {loops}")), 30 * 7 * 12);
        assert_eq!(largest(&[1, 2]), 0);
    }
}
