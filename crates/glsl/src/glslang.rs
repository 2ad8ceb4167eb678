//! The GLSL compiler: glslang through shaderc.

use super::error::LinkError;
use super::stage::Stage;
use std::sync::OnceLock;

/// Kept alive, since glslang takes 50 to 90 ms to set up its tables of built-ins.
static COMPILER: OnceLock<shaderc::Compiler> = OnceLock::new();

/// Source text of a shader.
pub(super) struct Text<'a> {
    /// Name in errors.
    pub(super) name: &'a str,
    pub(super) text: &'a str,
    pub(super) stage: Stage,
    pub(super) is_optimized: bool,
}

/// Resolves an include, by name and whether it is a slot, to path and text.
type Include<'a> = dyn Fn(&str, bool) -> Result<(String, String), String> + 'a;

/// Starts the compiler if needed.
///
/// # Errors
/// [`LinkError::Compiler`] if shaderc cannot be initialized.
pub(super) fn started() -> Result<&'static shaderc::Compiler, LinkError> {
    match COMPILER.get() {
        Some(compiler) => Ok(compiler),
        None => {
            let new = shaderc::Compiler::new().map_err(|error| LinkError::Compiler(error.to_string()))?;
            Ok(COMPILER.get_or_init(|| new))
        }
    }
}

/// Compiles a text to SPIR-V 1.3 with names.
///
/// # Errors
/// Errors of glslang.
pub(super) fn compiled(text: &Text<'_>, include: &Include<'_>) -> Result<Vec<u32>, LinkError> {
    let compiler = |error: shaderc::Error| LinkError::Compiler(error.to_string());
    let mut options = shaderc::CompileOptions::new().map_err(compiler)?;
    options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_1 as u32);
    options.set_optimization_level(if text.is_optimized {
        shaderc::OptimizationLevel::Performance
    } else {
        shaderc::OptimizationLevel::Zero
    });
    options.set_generate_debug_info();
    options.set_warnings_as_errors();
    options.set_include_callback(|name, kind, _, _| {
        let (resolved_name, content) = include(name, kind == shaderc::IncludeType::Standard)?;
        Ok(shaderc::ResolvedInclude { resolved_name, content })
    });
    if text.stage == Stage::Compute {
        options.add_macro_definition("COMPUTE", None);
    }
    let kind = match text.stage {
        Stage::Vertex => shaderc::ShaderKind::Vertex,
        Stage::Fragment => shaderc::ShaderKind::Fragment,
        Stage::Compute => shaderc::ShaderKind::Compute,
    };
    match started()?.compile_into_spirv(text.text, kind, text.name, "main", Some(&options)) {
        Ok(artifact) => Ok(artifact.as_binary().to_vec()),
        Err(shaderc::Error::CompilationError(_, message)) => Err(LinkError::Compile(message.trim_end().to_string())),
        // shaderc's message for an exception in glslang, which has run out of memory.
        Err(error) if error.to_string() == "internal error" => Err(LinkError::Memory),
        Err(error) => Err(LinkError::Compile(error.to_string())),
    }
}
