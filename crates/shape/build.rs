//! Leaves out tests that the machine cannot run.

fn main() {
    println!("cargo::rerun-if-changed=build.rs");
    hypertexture_test_switches::set();
}
