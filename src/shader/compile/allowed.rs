//! What a program with text of a user may not hold: arrays that a driver works on for minutes (a compiler takes one of
//! 400 MB in a blink), and what reaches beyond the bindings, such as addresses of buffers.

use crate::shader::instructions;
use std::collections::HashMap;

/// The largest array of a program, in bytes: larger ones keep a driver busy for minutes when it makes the pipeline.
const MAX_ARRAY: u64 = 64 << 10;
/// The capabilities of SPIR-V that programs may ask for: Matrix, Shader, Sampled1D, ImageQuery, DerivativeControl.
const CAPABILITIES: [u32; 5] = [0, 1, 43, 50, 51];

const CAPABILITY: u32 = 17;
const TYPE_INT: u32 = 21;
const TYPE_FLOAT: u32 = 22;
const TYPE_VECTOR: u32 = 23;
const TYPE_MATRIX: u32 = 24;
const TYPE_ARRAY: u32 = 28;
const TYPE_STRUCT: u32 = 30;
const CONSTANT: u32 = 43;

/// Why a SPIR-V module is not for a driver, if it is not.
pub(crate) fn refusal(module: &[u32]) -> Option<String> {
    let foreign = |(op, operands): (u32, &[u32])| match operands {
        [capability] if op == CAPABILITY => Some(*capability).filter(|number| !CAPABILITIES.contains(number)),
        _ => None,
    };
    if let Some(number) = instructions(module).find_map(foreign) {
        return Some(format!(
            "it asks for capability {number} of SPIR-V, which a module may not have: leave its `#extension` out"
        ));
    }
    let largest = largest(module);
    (largest > MAX_ARRAY).then(|| {
        format!(
            "an array of {largest} bytes; one may have at most {MAX_ARRAY}, since a driver makes a pipeline of more for minutes"
        )
    })
}

/// Bytes of the largest array type in a SPIR-V module; 0 where there is none.
fn largest(module: &[u32]) -> u64 {
    let mut bytes: HashMap<u32, u64> = HashMap::new();
    let mut constants: HashMap<u32, u64> = HashMap::new();
    let mut largest = 0;
    for instruction in instructions(module) {
        let of = |id: u32| bytes.get(&id).copied().unwrap_or_default();
        match instruction {
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

    fn linked(body: &str) -> Vec<u32> {
        let text = format!("#version 450\n{body}");
        let library = Library::new([("a.frag".to_string(), text)]);
        Linker::new().unwrap().link(&library, "a.frag", Stage::Fragment, &["a.frag"], &Slots::new()).unwrap()
    }

    #[test]
    fn an_address_of_a_buffer_is_refused() {
        let address = "#extension GL_EXT_buffer_reference : require\nlayout(buffer_reference) buffer B { vec4 v; };\n\
                       layout(push_constant) uniform P { B b; };\nlayout(location = 0) out vec4 o;\n\
                       void main() { o = b.v; }";
        let refused = refusal(&linked(address)).unwrap();
        assert!(refused.contains("capability 5347 of SPIR-V"), "{refused}");
    }

    #[test]
    fn the_largest_array_is_found_whatever_holds_it() {
        let bytes = |body: &str| largest(&linked(&format!("layout(location = 0) out vec4 o;\n{body}")));
        assert_eq!(bytes("void main() { o = vec4(1.0); }"), 0);
        let loops = "{ S s; for (int i = 0; i < 30; i++) s.t[i][int(gl_FragCoord.x)] = vec3(gl_FragCoord.y); o = s.t[2][int(gl_FragCoord.y)].xyzz; }";
        assert_eq!(bytes(&format!("struct S {{ float a; vec3 t[30][7]; }};\nvoid main() {loops}")), 30 * 7 * 12);
        assert_eq!(largest(&[1, 2]), 0);
    }
}
