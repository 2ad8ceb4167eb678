//! The library: its pictures against formulas, closed forms and other ways to draw them, its formulas in f64, and the
//! papers of the project. One program, so that long tests run beside short ones.
#![allow(clippy::unwrap_used, reason = "a test fails where a value, a file or a picture is not as described")]

mod common;
#[path = "common/lattice.rs"]
mod lattice;
#[path = "common/probe.rs"]
mod probe;
#[path = "common/random_scene.rs"]
mod random_scene;
#[path = "common/seen.rs"]
mod seen;

mod along;
mod areas;
mod docs;
mod field_data;
mod formulas;
mod fuzz;
mod golden;
mod march;
mod pictures;
mod polygons;
mod slices;
mod solids;
mod turned;
