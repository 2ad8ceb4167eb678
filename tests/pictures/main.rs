//! Pictures by a device: what each part of the program makes of one, against formulas and against other ways to it.

#[path = "../common/mod.rs"]
mod common;
#[path = "../common/lattice.rs"]
mod lattice;
#[path = "../common/random_scene.rs"]
mod random_scene;
#[path = "../common/seen.rs"]
mod seen;

mod anisotropy;
mod bandlimit;
mod classification;
mod custom;
mod debug_views;
mod depth;
mod dmf;
mod edges;
mod engine;
mod extremes;
mod figures;
mod functions;
mod gradients;
mod groom;
mod half_angle;
mod host;
mod ignored;
mod neutral;
mod objects;
mod pick;
mod project;
mod reference;
mod refraction;
mod sampling;
mod segment;
mod shadows;
mod stages;
mod storage;
mod strategies;
mod stress;
mod toolkit;
mod voxels;
