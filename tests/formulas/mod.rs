//! Every shipped GLSL module against its formula, written here in f64 from the papers and from the module's header; and the
//! exact evaluator, by which that is done.
//!
//! The linked SPIR-V is run by the exact evaluator (`exact_modules.rs` holds that to a device) at 10^4 points with
//! parameters all over their ranges; no device is needed. A row of `rows!` names the check, its function, and what a
//! wrong module would have in its text: `"file": "from" => "to"`. With that text the check must fail, so that no check
//! can be one that always passes. A file of `glsl/` that no row makes wrong fails `every_module_has_a_check`.

mod branches;
mod cells;
mod classify;
mod density;
mod draws;
mod dual;
mod exact;
mod exact_modules;
mod figures;
mod glass;
mod groom;
mod hairy;
mod harness;
mod knots;
mod light;
mod loops;
mod means;
mod medium;
mod noise;
mod object;
mod parts;
mod phases;
mod proofs;
mod rays;
mod relief;
mod segments;
mod surface;
mod transport;
mod values;
mod warp;

use std::collections::BTreeSet;

/// Files with nothing to be wrong about: declarations alone.
const DECLARATIONS: [&str; 9] = [
    "distance_bound.glsl",
    "index_point.glsl",
    "interface.glsl",
    "part.glsl",
    "phases/one.glsl",
    "sample_point.glsl",
    "sampling/pixel.glsl",
    "sampling/sample.glsl",
    "surface_point.glsl",
];

#[test]
fn every_module_has_a_check() {
    let rows = [
        cells::ROWS,
        classify::ROWS,
        density::ROWS,
        glass::ROWS,
        groom::ROWS,
        hairy::ROWS,
        light::ROWS,
        means::ROWS,
        medium::ROWS,
        noise::ROWS,
        object::ROWS,
        parts::ROWS,
        phases::ROWS,
        rays::ROWS,
        relief::ROWS,
        segments::ROWS,
        surface::ROWS,
        transport::ROWS,
        warp::ROWS,
    ];
    let checked: BTreeSet<&str> = rows.into_iter().flatten().copied().collect();
    let library = harness::shipped();
    // Programs of their own, and the rays that several of them share, are tested by their pictures.
    let shared = ["march.glsl", "matter.glsl", "pixel.glsl", "trace.glsl"];
    let is_other = |path: &str| path.starts_with("doctor/") || shared.contains(&path);
    let modules = library.sources().filter(|(path, _)| path.ends_with(".glsl") && !is_other(path));
    let modules: BTreeSet<&str> = modules.map(|(path, _)| path).collect();
    for module in &modules {
        let declares = DECLARATIONS.contains(module);
        assert_ne!(checked.contains(module), declares, "glsl/{module}: no row of tests/formulas makes it wrong");
    }
    let gone: Vec<_> = checked.iter().chain(&DECLARATIONS).filter(|path| !modules.contains(*path)).collect();
    assert!(gone.is_empty(), "there is no glsl/{gone:?}");
}
