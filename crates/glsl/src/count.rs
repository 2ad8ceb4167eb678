//! Counts of the operations and fetches that a program executes, in place of its picture.
//!
//! Role: adds the cost of each block to counters where it ends, so that loops and branches count as they run. An operation
//! has one component: `fma` counts two, a dot product of n components 2 n - 1, other built-in functions one, and moves,
//! branches and memory none. A fetch is a trilinear one, of eight texels; others count by their texels.

use super::library::Library;
use super::spirv::{HEADER, Op, StorageClass, encode, instructions};
use std::collections::{HashMap, HashSet};

/// `march.frag` with the number of samples that hold matter in place of blue.
const RAY: &str = "\
#version 450
#include \"interface.glsl\"
#include \"vector.glsl\"
#include \"trace.glsl\"
vec3 position_eye;
float held = 0.0;
#define MEETS(matter, k) { vec4 met = matter; held += float(met.a > 0.0); sum += (1.0 - sum.a) * met; }
#define ENDS sum.a >= full_opacity
#define GIVES vec4(sum.r, sum.g + sum.b, held, sum.a)
#include \"march.glsl\"
";
/// Built-in functions with more than one operation: numbers in the extended set, operations for each component of the
/// first operand. They are clamp, mix, smoothstep, fma, length, distance, cross, normalize and reflect.
const FUNCTIONS: [(u32, u32); 9] = [(43, 2), (46, 3), (49, 9), (50, 2), (66, 2), (67, 3), (68, 3), (69, 3), (71, 4)];
/// Texels of a filtered fetch from an image of one, two and three dimensions.
const TEXELS: [u32; 3] = [2, 4, 8];

impl Library {
    /// A library by which a renderer draws counts: see [`counting`].
    pub fn of_counts(mut self) -> Library {
        self.counts = true;
        self
    }

    /// Whether renderers draw counts.
    pub fn is_of_counts(&self) -> bool {
        self.counts
    }

    /// Rays that give the number of their samples that hold matter in place of blue.
    pub fn noting_matter(&self) -> Library {
        self.clone().with_file("march.frag", RAY)
    }
}

/// A fragment or compute shader that gives its operations in place of red and its fetches in place of green. Blended
/// fragments give 1 in place of blue, 0 where they are discarded, and alpha 0, so that they add up.
pub fn counting(module: &[u32], is_blended: bool) -> Vec<u32> {
    let mut own = Counting::of(module, is_blended);
    let (mut head, mut is_head) = (module.get(..HEADER).unwrap_or_default().to_vec(), true);
    for (op, words) in instructions(module) {
        is_head &= op != Op::Function;
        if is_head {
            head.extend_from_slice(words);
            continue;
        }
        let mut words = words.to_vec();
        match (op, &mut words[..]) {
            (Op::Store, [_, to, value]) if Some(*to) == own.output => *value = own.counts(Some(*value)),
            (Op::ImageWrite, [_, _, _, value, ..]) => *value = own.counts(Some(*value)),
            (Op::Kill, _) => {
                let value = own.counts(None);
                own.body.extend(own.output.into_iter().flat_map(|output| encode(Op::Store, &[output, value])));
                words = encode(Op::Return, &[]);
            }
            (Op::LoopMerge | Op::SelectionMerge | Op::Branch | Op::BranchConditional | Op::Switch, _)
            | (Op::Return | Op::ReturnValue, _) => own.add(),
            _ => own.cost(op, &words),
        }
        own.body.extend(words);
    }
    if let Some(bound) = head.get_mut(3) {
        *bound = own.next;
    }
    [head, own.declared, own.body].concat()
}

/// A module that is rewritten.
struct Counting {
    is_blended: bool,
    /// Rows and columns of types.
    sizes: HashMap<u32, [u32; 2]>,
    /// Texels of a filtered fetch, by the type of the image.
    texels: HashMap<u32, u32>,
    /// Types of values.
    types: HashMap<u32, u32>,
    float: u32,
    vec4: u32,
    /// Output of a fragment shader.
    output: Option<u32>,
    /// Variables with the operations and texels so far, and those to be added.
    counters: [u32; 2],
    costs: [u32; 2],
    /// The next free number.
    next: u32,
    /// Declarations, and functions.
    declared: Vec<u32>,
    body: Vec<u32>,
}

impl Counting {
    fn of(module: &[u32], is_blended: bool) -> Counting {
        const OUTPUT: u32 = StorageClass::Output as u32;
        let next = module.get(3).copied().unwrap_or_default();
        let (mut sizes, mut texels, mut types) = (HashMap::new(), HashMap::new(), HashMap::new());
        let (mut known, mut float, mut vec4, mut output) = (HashSet::new(), 0, 0, None);
        for (op, words) in instructions(module) {
            match *words {
                [_, id, ..] if is_type(op) => drop(known.insert(id)),
                [_, kind, id, ..] if known.contains(&kind) => drop(types.insert(id, kind)),
                _ => {}
            }
            match (op, words) {
                (Op::TypeFloat, &[_, id, 32]) => float = id,
                (Op::TypeVector, &[_, id, of, rows]) => {
                    sizes.insert(id, [rows, 1]);
                    vec4 = if of == float && rows == 4 { id } else { vec4 };
                }
                (Op::TypeMatrix, &[_, id, column, columns]) => {
                    sizes.insert(id, [sizes.get(&column).map_or(1, |size| size[0]), columns]);
                }
                (Op::TypeImage, &[_, id, _, dimension, ..]) => {
                    texels.insert(id, TEXELS.get(dimension as usize).copied().unwrap_or(TEXELS[1]));
                }
                (Op::TypeSampledImage, &[_, id, image]) => {
                    texels.insert(id, texels.get(&image).copied().unwrap_or_default());
                }
                (Op::Variable, &[_, _, id, OUTPUT, ..]) => output = Some(id),
                _ => {}
            }
        }
        let mut own = Counting {
            is_blended,
            sizes,
            texels,
            types,
            float,
            vec4,
            output,
            counters: [0; 2],
            costs: [0; 2],
            next,
            declared: Vec::new(),
            body: Vec::new(),
        };
        let (zero, private) = (own.constant(0.0), StorageClass::Private as u32);
        let pointer = own.id();
        own.declared.extend(encode(Op::TypePointer, &[pointer, private, float]));
        own.counters = [0; 2].map(|_| {
            let id = own.id();
            own.declared.extend(encode(Op::Variable, &[pointer, id, private, zero]));
            id
        });
        own
    }

    fn id(&mut self) -> u32 {
        self.next += 1;
        self.next - 1
    }

    fn constant(&mut self, value: f32) -> u32 {
        let id = self.id();
        self.declared.extend(encode(Op::Constant, &[self.float, id, value.to_bits()]));
        id
    }

    fn put(&mut self, op: Op, kind: u32, operands: &[u32]) -> u32 {
        let id = self.id();
        self.body.extend(encode(op, &[&[kind, id], operands].concat()));
        id
    }

    /// Adds what the instructions since the latest addition cost.
    fn add(&mut self) {
        for (counter, cost) in self.counters.into_iter().zip(std::mem::take(&mut self.costs)) {
            if cost > 0 {
                let (before, more) = (self.put(Op::Load, self.float, &[counter]), self.constant(cost as f32));
                let sum = self.put(Op::FAdd, self.float, &[before, more]);
                self.body.extend(encode(Op::Store, &[counter, sum]));
            }
        }
    }

    /// The counts in place of a result; `None` where it is discarded.
    fn counts(&mut self, value: Option<u32>) -> u32 {
        self.add();
        let [operations, texels] = self.counters.map(|counter| self.put(Op::Load, self.float, &[counter]));
        let texel = self.constant(1.0 / TEXELS[2] as f32);
        let fetches = self.put(Op::FMul, self.float, &[texels, texel]);
        match value {
            Some(value) if !self.is_blended => {
                let first = self.put(Op::CompositeInsert, self.vec4, &[operations, value, 0]);
                self.put(Op::CompositeInsert, self.vec4, &[fetches, first, 1])
            }
            _ => {
                let (held, zero) = (self.constant(f32::from(value.is_some())), self.constant(0.0));
                self.put(Op::CompositeConstruct, self.vec4, &[operations, fetches, held, zero])
            }
        }
    }

    /// Adds the operations and texels of an instruction to the costs.
    fn cost(&mut self, op: Op, words: &[u32]) {
        let size = |id: Option<&u32>| id.and_then(|kind| self.sizes.get(kind)).copied().unwrap_or([1; 2]);
        let of = |at: usize| size(words.get(at).and_then(|value| self.types.get(value)));
        let [rows, columns] = size(words.get(1));
        let texels = || words.get(3).and_then(|image| self.texels.get(self.types.get(image)?)).copied();
        let [operations, texels] = match (op as u32, op, words) {
            (_, Op::Dot, _) => [2 * of(3)[0] - 1, 0],
            (_, Op::MatrixTimesVector, _) => [rows * (2 * of(4)[0] - 1), 0],
            (_, Op::VectorTimesMatrix, _) => [rows * (2 * of(3)[0] - 1), 0],
            (_, Op::MatrixTimesMatrix, _) => [rows * columns * (2 * of(3)[1] - 1), 0],
            (_, Op::ExtInst, [_, _, _, _, number, ..]) => {
                match FUNCTIONS.iter().find(|(function, _)| function == number) {
                    Some((_, each)) => [each * of(5)[0], 0],
                    None => [rows * columns, 0],
                }
            }
            // Conversions, arithmetic, comparisons and choices, bits, derivatives.
            (109..=116 | 126..=191 | 194..=205 | 207..=215, ..) => [rows * columns, 0],
            (87..=94, ..) => [0, texels().unwrap_or(TEXELS[2])], // filtered
            (95 | 98, ..) => [0, 1],
            (96 | 97, ..) => [0, 4], // four texels of a plane
            _ => [0; 2],
        };
        self.costs = [self.costs[0] + operations, self.costs[1] + texels];
    }
}

fn is_type(op: Op) -> bool {
    (Op::TypeVoid as u32..=Op::TypeFunction as u32).contains(&(op as u32))
}

#[cfg(all(test, feature = "compiler"))]
mod tests {
    use super::super::{Linker, Slots, Stage};
    use super::*;

    #[test]
    fn operations_and_texels_of_a_block_are_those_counted_by_hand() {
        let text = "#version 450\nlayout(location = 0) in vec4 v;\nlayout(location = 0) out vec4 fragment;\n\
                    layout(set = 0, binding = 0) uniform M { mat4 m; };\nlayout(set = 0, binding = 1) uniform sampler2D plane;\n\
                    void main() { fragment = m * v + normalize(v) * dot(v.xyz, v.yzx) + textureLod(plane, v.xy, 0.0); }\n";
        let library = Library::new([("a.frag".to_string(), text.to_string())]);
        let module =
            Linker::new().unwrap().link(&library, "a.frag", Stage::Fragment, &["a.frag"], &Slots::new()).unwrap();
        let counted = counting(&module, false);
        let constants: Vec<u32> = instructions(&counted)
            .filter(|(op, _)| *op == Op::Constant)
            .map(|(_, words)| *words.last().unwrap())
            .collect();
        // A row of the matrix, four times; squares, their sum, its root, quotients; the dot product; its multiple; two sums.
        let operations = 4 * 7 + (4 + 3 + 1 + 4) + 5 + 4 + 2 * 4;
        for cost in [operations as f32, 4.0, 1.0 / 8.0] {
            assert!(constants.contains(&cost.to_bits()), "{cost}");
        }
    }
}
