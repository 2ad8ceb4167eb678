//! Links the static archives of glslang and SPIRV-Tools if shaderc-sys finds Debian 12's libshaderc.so, which leaves their symbols
//! undefined.

use std::env;
use std::path::Path;
use std::process::Command;

const ARCHIVES: [&str; 11] = [
    "shaderc_combined",
    "glslang",
    "MachineIndependent",
    "GenericCodeGen",
    "OSDependent",
    "OGLCompiler",
    "HLSL",
    "SPIRV",
    "SPVRemapper",
    "SPIRV-Tools-opt",
    "SPIRV-Tools",
];

fn main() {
    println!("cargo::rerun-if-env-changed=SHADERC_LIB_DIR");
    println!("cargo::rerun-if-env-changed=VULKAN_SDK");
    println!("cargo::rerun-if-changed=build.rs");
    if env::var_os("CARGO_FEATURE_COMPILER").is_none() {
        return;
    }
    let is_custom = ["SHADERC_LIB_DIR", "VULKAN_SDK"].iter().any(|variable| env::var_os(variable).is_some());
    let machine = env::var("CARGO_CFG_TARGET_ARCH").unwrap_or_default();
    let folder = Path::new("/usr/lib").join(format!("{machine}-linux-gnu"));
    let undefined = Command::new("nm").args(["-D", "--undefined-only"]).arg(folder.join("libshaderc.so")).output();
    if is_custom || !undefined.is_ok_and(|nm| String::from_utf8_lossy(&nm.stdout).contains("7glslang")) {
        return;
    }
    println!("cargo::rustc-link-search=native={}", folder.display());
    for archive in ARCHIVES.iter().filter(|name| folder.join(format!("lib{name}.a")).exists()) {
        println!("cargo::rustc-link-lib=static:-bundle={archive}");
    }
}
