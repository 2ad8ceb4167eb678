//! Restrictions on programs with user text: no arrays that keep a driver busy for minutes (glslang compiles one of 400 MB at
//! once), and no access beyond the bindings, such as buffer addresses.

use super::error::names;
use crate::shader::find_word;
use crate::shader::library::own_names;
use crate::shader::spirv::{Capability, Op, StorageClass, instructions};
use std::collections::{BTreeMap, HashMap};

/// Largest array in bytes. The time of lavapipe for a pipeline grows with the square: 2 s for 4 KiB, 20 s for 16 KiB.
const MAX_ARRAY: u64 = 4 << 10;
/// Total size of all local and private arrays in bytes, counted once per inlined call.
const MAX_ARRAYS: u64 = 256 << 10;
/// The capabilities that programs may declare.
const CAPABILITIES: [Capability; 5] = [
    Capability::Matrix,
    Capability::Shader,
    Capability::Sampled1D,
    Capability::ImageQuery,
    Capability::DerivativeControl,
];

/// Features of GLSL that need a capability: its number, the beginnings of their words, and what to do.
const FEATURES: [(Capability, &[&str], &str); 4] = [
    (Capability::Float64, &["double", "dvec", "dmat"], "use float"),
    (Capability::ImageGatherExtended, &["textureGather"], "use textureLod"),
    (Capability::SampleRateShading, &["gl_Sample"], "leave it out"),
    (Capability::InterpolationFunction, &["interpolateAt"], "leave it out"),
];

/// The reason why a SPIR-V module must not reach a driver, if any; with the changed file and its line, or all of them.
pub fn refusal(module: &[u32], changed: &BTreeMap<String, String>) -> Option<String> {
    let foreign = |instruction: (Op, &[u32])| match instruction {
        (Op::Capability, &[_, number]) => {
            Some(number).filter(|n| !CAPABILITIES.iter().any(|known| *known as u32 == *n))
        }
        _ => None,
    };
    if let Some(number) = instructions(module).find_map(foreign) {
        return Some(required(number, changed));
    }
    let names = names(changed);
    let Arrays { largest: (bytes, kind), all } = Arrays::of(module);
    let why = "since drivers take minutes to compile more; compute its elements, or use fewer";
    if bytes > MAX_ARRAY {
        return Some(format!("{names}: {kind} of {bytes} bytes; one may have at most {MAX_ARRAY}, {why}"));
    }
    (all > MAX_ARRAYS).then(|| {
        format!(
            "{names}: arrays of {all} bytes in all its functions together; they may have at most {MAX_ARRAYS}, {why}"
        )
    })
}

/// Text for a capability that modules may not use.
fn required(number: u32, changed: &BTreeMap<String, String>) -> String {
    let feature = FEATURES.iter().find(|(capability, ..)| *capability as u32 == number);
    let named = feature.and_then(|(_, words, remedy)| {
        let found = changed.iter().find_map(|(path, text)| {
            let own = own_names(path, text);
            let is_of = |word: &str| words.iter().any(|start| word.starts_with(start)) && !own.contains(word);
            Some((path, find_word(text, is_of)?))
        });
        let (path, (line, word)) = found?;
        Some(format!("{path}:{line}: `{word}` is a feature that devices may lack; {remedy}"))
    });
    named.unwrap_or_else(|| {
        let has_extension = |text: &String| text.contains("#extension");
        let remedy = if changed.values().any(has_extension) { ": remove its `#extension`" } else { "" };
        format!("{}: it requires capability {number} of SPIR-V, which modules may not use{remedy}", names(changed))
    })
}

/// Array sizes of a SPIR-V module, in bytes.
#[derive(Debug, PartialEq)]
struct Arrays {
    /// The largest type that contains an array, and its description.
    largest: (u64, &'static str),
    /// All private and function variables that contain arrays.
    all: u64,
}

impl Arrays {
    fn of(module: &[u32]) -> Arrays {
        const PRIVATE: u32 = StorageClass::Private as u32;
        const FUNCTION: u32 = StorageClass::Function as u32;
        // Size of each type, and whether it contains an array.
        let mut types: HashMap<u32, (u64, bool)> = HashMap::new();
        let mut constants: HashMap<u32, u64> = HashMap::new();
        let mut found = Arrays { largest: (0, "an array"), all: 0 };
        for instruction in instructions(module) {
            let of = |id: u32| types.get(&id).copied().unwrap_or_default();
            let (id, size, kind) = match instruction {
                (Op::TypeInt | Op::TypeFloat, &[_, id, width, ..]) => (id, (u64::from(width / 8), false), ""),
                (Op::TypeBool, &[_, id]) => (id, (4, false), ""),
                (Op::TypeVector | Op::TypeMatrix, &[_, id, part, count]) => {
                    (id, (of(part).0.saturating_mul(u64::from(count)), false), "")
                }
                (Op::TypePointer, &[_, id, _, to]) => (id, of(to), ""),
                (Op::TypeStruct, [_, id, parts @ ..]) => {
                    let add = |sum: (u64, bool), part: &u32| (sum.0.saturating_add(of(*part).0), sum.1 | of(*part).1);
                    (*id, parts.iter().fold((0, false), add), "a struct with arrays")
                }
                (Op::TypeArray, &[_, id, part, length]) => {
                    let length = constants.get(&length).copied().unwrap_or(1);
                    (id, (of(part).0.saturating_mul(length), true), "an array")
                }
                (Op::Constant, &[_, _, id, value]) => {
                    constants.insert(id, u64::from(value));
                    continue;
                }
                (Op::Variable, &[_, pointer, _, PRIVATE | FUNCTION, ..]) => {
                    let (bytes, has_array) = of(pointer);
                    found.all = found.all.saturating_add(if has_array { bytes } else { 0 });
                    continue;
                }
                _ => continue,
            };
            types.insert(id, size);
            if size.1 && !kind.is_empty() && size.0 > found.largest.0 {
                found.largest = (size.0, kind);
            }
        }
        found
    }
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
        let changed = |text: &str| BTreeMap::from([("dmf/a.glsl".to_string(), text.to_string())]);
        let refused = refusal(&linked(address), &changed(address)).unwrap();
        assert!(
            refused.contains("capability 5347 of SPIR-V, which modules may not use: remove its `#ext"),
            "{refused}"
        );
        let double =
            "layout(location = 0) out vec4 o;\nvoid main() { double x = double(gl_FragCoord.x);\no = vec4(x); }";
        let refused = refusal(&linked(double), &changed(double)).unwrap();
        assert!(
            refused.starts_with("dmf/a.glsl:2: `double` is a feature") && refused.ends_with("use float"),
            "{refused}"
        );
    }

    #[test]
    fn arrays_are_found_whatever_holds_them() {
        let found = |body: &str| Arrays::of(&linked(&format!("layout(location = 0) out vec4 o;\n{body}")));
        assert_eq!(found("void main() { o = vec4(1.0); }"), Arrays { largest: (0, "an array"), all: 0 });
        let loops = "for (int i = 0; i < 30; i++) s.t[i][int(gl_FragCoord.x)] = vec3(gl_FragCoord.y); \
                     o = s.t[2][int(gl_FragCoord.y)].xyzz;";
        let of_struct = format!("struct S {{ float a; vec3 t[30][7]; bool b; }};\nvoid main() {{ S s; {loops} }}");
        let bytes = 30 * 7 * 12; // the optimizer drops the members that nothing reads
        assert_eq!(found(&of_struct), Arrays { largest: (bytes, "an array"), all: bytes });
        let of_structs = "struct S { float a; vec3 t[7]; };\nvoid main() { S s[30]; int at = int(gl_FragCoord.x); \
                          s[at].t[at] = vec3(1.0); s[at].a = 2.0; o = s[at / 2].t[at / 3].xyzz + s[at / 3].a; }";
        assert_eq!(found(of_structs).all, 30 * (4 + 7 * 12));
        let several = "float f(float x[9]) { float y[5]; y[int(x[1])] = x[2]; return y[int(x[3])]; }\n\
                       float z[7];\nvoid main() { float x[9]; x[int(gl_FragCoord.x)] = 1.0; z[int(x[0])] = f(x); o = vec4(z[3]); }";
        let Arrays { largest, all } = found(several);
        assert!(largest == (36, "an array") && all >= 4 * (9 + 5 + 7), "{largest:?} {all}");
        assert_eq!(Arrays::of(&[1, 2]).all, 0);
    }
}
