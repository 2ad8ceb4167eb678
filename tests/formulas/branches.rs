//! No program branches on what its parameters alone decide.
//!
//! lavapipe puts the values of such parameters into a copy of the program and compiles that for every draw: a scene with one
//! such branch took 1.4 times as long, and 7 MB more of memory with each submission.

use hypertexture::render::variant::Variant;
use hypertexture::scene::{self, Scene};
use hypertexture::shader::{self, Linker};
use std::collections::{BTreeSet, HashMap};

const EXTENDED: u32 = 12;
const LOAD: u32 = 61;
const ACCESS: u32 = 65;
const VARIABLE: u32 = 59;
const CONSTANTS: std::ops::RangeInclusive<u32> = 41..=52;
const SHUFFLE: u32 = 79;
const CONSTRUCT: u32 = 80;
const EXTRACT: u32 = 81;
/// Conversions, arithmetic, comparisons and choices.
const OPERATIONS: std::ops::RangeInclusive<u32> = 109..=200;
const BRANCH: u32 = 250;
const SWITCH: u32 = 251;
const MEMBER_NAME: u32 = 6;
const IN_BLOCK: u32 = 2;

/// The instructions that give a value, by its number, and all instructions.
struct Words<'a> {
    values: HashMap<u32, (u32, &'a [u32])>,
    all: Vec<(u32, &'a [u32])>,
}

impl<'a> Words<'a> {
    fn of(words: &'a [u32]) -> Words<'a> {
        let (mut all, mut at) = (Vec::new(), 5);
        while at < words.len() {
            let length = (words[at] >> 16) as usize;
            all.push((words[at] & 0xffff, &words[at + 1..at + length]));
            at += length;
        }
        let gives =
            |opcode: u32| CONSTANTS.contains(&opcode) || (54..=61).contains(&opcode) || (65..=245).contains(&opcode);
        let values = all.iter().filter(|(opcode, rest)| (gives(*opcode) || *opcode == EXTENDED) && rest.len() > 1);
        Words { values: values.map(|(opcode, rest)| (rest[1], (*opcode, &rest[2..]))).collect(), all }
    }

    /// The members of blocks that decide a value, where nothing else does.
    fn members(&self, value: u32) -> Option<BTreeSet<String>> {
        let &(opcode, rest) = self.values.get(&value)?;
        let from: &[u32] = match opcode {
            opcode if CONSTANTS.contains(&opcode) => &[],
            LOAD => return self.member(rest[0]),
            EXTENDED => &rest[2..],
            SHUFFLE => &rest[..2],
            EXTRACT => &rest[..1],
            CONSTRUCT => rest,
            opcode if OPERATIONS.contains(&opcode) => rest,
            _ => return None,
        };
        from.iter().try_fold(BTreeSet::new(), |mut all, from| {
            all.extend(self.members(*from)?);
            Some(all)
        })
    }

    /// The member of a block that a pointer is to.
    fn member(&self, pointer: u32) -> Option<BTreeSet<String>> {
        let &(_, rest) = self.values.get(&pointer).filter(|(opcode, _)| *opcode == ACCESS)?;
        let &(VARIABLE, &[IN_BLOCK, ..]) = self.values.get(&rest[0])? else { return None };
        let &(_, index) = self.values.get(&rest[1])?;
        let names = self.all.iter().filter(|(opcode, named)| *opcode == MEMBER_NAME && named[1] == index[0]);
        let name = |named: &[u32]| {
            let bytes = named[2..].iter().flat_map(|word| word.to_le_bytes()).take_while(|byte| *byte != 0);
            String::from_utf8_lossy(&bytes.collect::<Vec<u8>>()).into_owned()
        };
        Some([names.map(|(_, named)| name(named)).collect::<Vec<_>>().join(" or ")].into())
    }

    /// The members that decide branches.
    fn deciding(&self) -> BTreeSet<String> {
        let conditions = self.all.iter().filter(|(opcode, _)| [BRANCH, SWITCH].contains(opcode));
        conditions.filter_map(|(_, rest)| self.members(rest[0])).flatten().collect()
    }
}

#[test]
fn a_branch_on_a_parameter_is_found_and_one_on_a_sample_is_not() {
    let found = |condition: &str| {
        let text = format!(
            "// Own.\n// Source: -\n// @param steep = 1 in [0, 2]: Steepness.\nfloat own(float density, Sample s) {{\n    \
             if ({condition}) return pow(density, 1.5);\n    return sin(density) * steep;\n}}\n"
        );
        let library = shader::shipped().with_module("dmf", "own", &text);
        let mut scene = scene::preset("fire_ball").unwrap();
        scene.effect.dmf = vec!["own".into()];
        scene.check(&library).unwrap();
        Words::of(&Variant::of(&scene, &library).unwrap().program(&library, Linker::new).unwrap().fragment).deciding()
    };
    let parameter = found("2.0 * steep > 1.0");
    assert!(parameter.iter().any(|name| name.contains("steep")), "{parameter:?}");
    assert!(found("density * steep > 0.5").is_empty());
}

#[test]
fn no_program_branches_on_its_parameters_alone() {
    let library = shader::shipped();
    let mut scenes: Vec<(String, Scene)> =
        scene::names().map(|name| (name.into(), scene::preset(name).unwrap())).collect();
    for slot in ["warp", "dmf", "surface", "medium", "softness", "turbulence", "noise"] {
        for name in library.modules(slot) {
            let mut scene = scene::preset("fire_ball").unwrap();
            match slot {
                "warp" => scene.effect.warp = vec![name.into()],
                "dmf" => scene.effect.dmf = vec![name.into()],
                _ => {
                    let own = scene.effect.modules_mut().into_iter().find(|(known, _)| *known == slot);
                    *own.unwrap().1 = name.into();
                }
            }
            if scene.check(&library).is_ok() {
                scenes.push((format!("{slot} {name}"), scene));
            }
        }
    }
    assert!(scenes.len() > 60, "{}", scenes.len());
    let program = |scene| Variant::of(scene, &library).unwrap().program(&library, Linker::new).unwrap();
    let found = scenes.iter().map(|(name, scene)| (name, Words::of(&program(scene).fragment).deciding()));
    let found: Vec<String> = found
        .filter(|(_, members)| !members.is_empty())
        .map(|(name, members)| format!("{name}: {members:?}"))
        .collect();
    assert!(found.is_empty(), "{}", found.join("\n"));
}
