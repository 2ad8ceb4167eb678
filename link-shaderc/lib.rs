//! Links what the packaged shaderc of Debian 12 leaves open, into programs and build scripts that use shaderc: see `build.rs`.
