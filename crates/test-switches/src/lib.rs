//! Leaves out tests that the machine cannot run, for build scripts.

use std::env;

/// Environment variables, and the `cfg` that each sets.
const SWITCHES: [(&str, &str); 3] =
    [("HYPERTEXTURE_NO_GPU", "no_gpu"), ("HYPERTEXTURE_NO_DISPLAY", "no_display"), ("HYPERTEXTURE_DATA", "test_data")];

/// Sets a `cfg` for each of these environment variables that is set, so that a test that cannot run counts as ignored, never
/// as passed.
pub fn set() {
    for (variable, cfg) in SWITCHES {
        println!("cargo::rerun-if-env-changed={variable}");
        println!("cargo::rustc-check-cfg=cfg({cfg})");
        if env::var_os(variable).is_some_and(|value| !value.is_empty() && value != "0") {
            println!("cargo::rustc-cfg={cfg}");
        }
    }
}
