//! The exact evaluator: operations against Rust's f64, control flow, images, and every program that ships.

use hypertexture::exact::{Bound, Inputs, Interval, Lanes, Number, Program, Texture, Wrap};
use hypertexture::glsl::{self, Library, Linker, Slots, Stage};
use hypertexture::scene;
use hypertexture::variant::Variant;
use std::collections::BTreeMap;

/// A fragment stage whose output is computed by `body` from `x`, a vec4 that comes from the vertex stage.
fn program(before: &str, body: &str) -> Program {
    read(before, body).unwrap_or_else(|error| panic!("{error}"))
}

fn read(before: &str, body: &str) -> Result<Program, hypertexture::exact::ExactError> {
    let text = format!(
        "#version 450\nlayout(location = 0) in vec4 x;\nlayout(location = 0) out vec4 result;\n{before}\n\
         void main() {{\n{body}\n}}\n"
    );
    let library = Library::new([("test.frag".to_string(), text)]);
    let linker = Linker::new().unwrap_or_else(|error| panic!("{error}"));
    let spirv = linker.link(&library, ("test.frag", Stage::Fragment), &["test.frag"], &Slots::new());
    Program::read(&spirv.unwrap_or_else(|error| panic!("{error}")), &[])
}

fn lanes<N: Number>(values: &[[f64; 4]]) -> Lanes<N> {
    let values = values.iter().map(|value| value.map(N::new)).collect();
    Lanes { fragment_coordinates: Vec::new(), varyings: BTreeMap::from([(0, values)]) }
}

fn evaluate<N: Number>(bound: &Bound<'_>, values: &[[f64; 4]]) -> Vec<[N; 4]> {
    bound.run(&lanes(values)).unwrap_or_else(|error| panic!("{error}"))[&0].clone()
}

/// Points of the unit cube of four dimensions, evenly spread.
fn points(count: usize) -> Vec<[f64; 4]> {
    // Additive recurrence with the roots of x^5 = x + 1 (Roberts 2018).
    let root = 1.167_303_978_261_418_7_f64;
    (0..count).map(|n| [1, 2, 3, 4].map(|axis| ((n + 1) as f64 * root.powi(-axis)).fract())).collect()
}

#[test]
fn every_preset_lowers() {
    let library = glsl::shipped();
    for name in scene::names() {
        let scene = scene::preset(name).unwrap();
        let variant = Variant::of(&scene, &library).unwrap();
        let linked = variant.program(&library, Linker::new).unwrap();
        let start = std::time::Instant::now();
        let program = Program::read(&linked.fragment, &[]).unwrap_or_else(|error| panic!("{name}: {error}"));
        println!("{name}: {:.1} ms, {}", start.elapsed().as_secs_f64() * 1e3, program.summary());
        let shadow = variant.shadow(&scene, &library).unwrap().program(&library, Linker::new).unwrap();
        Program::read(&shadow.fragment, &[]).unwrap_or_else(|error| panic!("shadow of {name}: {error}"));
    }
}
