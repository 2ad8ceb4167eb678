//! SPIR-V to WGSL.

use crate::ExportError;
use hypertexture::eval::specialized;
use hypertexture::render::{OCTAVES_ID, Portable, PortableProgram};
use hypertexture::shader::spirv::{Op, instructions};
use naga::back::wgsl::{WriterFlags, write_string};
use naga::front::spv::{Frontend, Options};
use naga::valid::{Capabilities, ValidationFlags, Validator};
use std::collections::HashMap;

/// Words before the instructions of SPIR-V, and the one of them that bounds its IDs.
const HEADER: usize = 5;
const BOUND: usize = 3;

/// Bent rays read derivatives, and samplers are read where rays part: the levels are explicit.
const DIAGNOSTIC: &str = "diagnostic(off, derivative_uniformity);\n";

/// SPIR-V of a program without debug lines and with its constants set.
///
/// # Errors
/// [`ExportError::Wgsl`] for malformed SPIR-V.
pub(crate) fn constant(portable: &Portable, own: &PortableProgram) -> Result<Vec<u32>, ExportError> {
    let octaves = [(OCTAVES_ID, portable.variant.scene.effect.octaves)];
    let fails = |error: hypertexture::eval::ExactError| refused(own.name, error.to_string());
    specialized(&own.program.fragment, &octaves).map_err(fails)
}

/// The words with products in place of outer products, which WGSL lacks.
fn without_outer_products(spirv: &[u32]) -> Vec<u32> {
    let mut parts = HashMap::new();
    for instruction in instructions(spirv) {
        if let (Op::TypeMatrix | Op::TypeVector, &[_, result, part, count]) = instruction {
            parts.insert(result, (part, count));
        }
    }
    let mut words = spirv[..spirv.len().min(HEADER)].to_vec();
    let mut bound = words.get(BOUND).copied().unwrap_or_default();
    let encode = |op: Op, operands: &[u32]| [&[(operands.len() as u32 + 1) << 16 | op as u32], operands].concat();
    for (op, instruction) in instructions(spirv) {
        let outer = match *instruction {
            [_, matrix, result, a, b] if op == Op::OuterProduct => Some((matrix, result, a, b)),
            _ => None,
        };
        let types = outer.and_then(|(matrix, ..)| parts.get(&matrix).and_then(|own| Some((own, parts.get(&own.0)?))));
        let (Some((matrix, result, a, b)), Some((&(column, count), &(scalar, _)))) = (outer, types) else {
            words.extend_from_slice(instruction);
            continue;
        };
        let mut composed = vec![matrix, result];
        for part in 0..count {
            words.extend(encode(Op::CompositeExtract, &[scalar, bound, b, part]));
            words.extend(encode(Op::VectorTimesScalar, &[column, bound + 1, a, bound]));
            composed.push(bound + 1);
            bound += 2;
        }
        words.extend(encode(Op::CompositeConstruct, &composed));
    }
    words.iter_mut().skip(BOUND).take(1).for_each(|word| *word = bound);
    words
}

/// WGSL of such SPIR-V.
///
/// # Errors
/// [`ExportError::Wgsl`] for what WGSL lacks.
pub(crate) fn wgsl(program: &'static str, spirv: &[u32]) -> Result<String, ExportError> {
    let options = Options { adjust_coordinate_space: false, strict_capabilities: false, block_ctx_dump_prefix: None };
    let fails = |error: &dyn std::error::Error| {
        let deepest = std::iter::successors(Some(error), |error| error.source()).last().map(ToString::to_string);
        refused(program, deepest.unwrap_or_default())
    };
    let module =
        Frontend::new(without_outer_products(spirv).into_iter(), &options).parse().map_err(|error| fails(&error))?;
    let mut validator = Validator::new(ValidationFlags::all(), Capabilities::all());
    let info = validator.validate(&module).map_err(|error| fails(error.as_inner()))?;
    let text = write_string(&module, &info, WriterFlags::empty()).map_err(|error| fails(&error))?;
    Ok(DIAGNOSTIC.to_string() + &text)
}

fn refused(program: &'static str, reason: String) -> ExportError {
    ExportError::Wgsl { program, reason: reason.lines().collect::<Vec<_>>().join(" ") }
}
