//! A GLSL function, evaluated at 4096 places on the device.

use super::lab::{CaseError, Lab};
use hypertexture::gpu::{
    Binding, BindingKind, Blend, Buffer, BufferUse, Dimension, Format, Gpu, Image, ImageUse, Load, Marks, Pipeline,
    PipelineDescription, Resource, Target,
};
use hypertexture::shader::{Linker, Slots, Stage};
use std::sync::Arc;

/// Pixels along a side.
const SIDE: u32 = 64;

/// A fragment program that begins with `places.glsl`.
pub(super) struct Function<'a> {
    gpu: &'a Gpu,
    pipeline: Pipeline,
}

impl<'a> Function<'a> {
    /// Links a function with modules in the slots that it includes.
    pub fn new(lab: &Lab<'a>, text: &str, slots: &[(&str, &str)]) -> Result<Function<'a>, CaseError> {
        Function::linked(lab, &lab.linker, text, slots)
    }

    /// Links a function by another linker.
    pub fn linked(
        lab: &Lab<'a>,
        linker: &Linker,
        text: &str,
        slots: &[(&str, &str)],
    ) -> Result<Function<'a>, CaseError> {
        const VERTEX: &str = "doctor/cover.vert";
        const FRAGMENT: &str = "cases/function.glsl";
        let text = format!("{}{text}", include_str!("places.glsl"));
        let library = lab.library.clone().with_module("cases", "function", &text);
        let slots: Slots = slots.iter().map(|(slot, module)| (slot.to_string(), vec![module.to_string()])).collect();
        let link = |entry, stage| linker.link(&library, entry, stage, &[VERTEX, FRAGMENT], &slots);
        let pipeline = Pipeline::new(
            lab.gpu,
            &PipelineDescription {
                vertex: &link(VERTEX, Stage::Vertex)?,
                fragment: &link(FRAGMENT, Stage::Fragment)?,
                constants: &[],
                bindings: &[Binding { index: 0, kind: BindingKind::Uniform, vertex: false, fragment: true }],
                attributes: &[],
                format: Format::Rgba32Float,
                samples: 1,
                blend: Blend::Replace,
                marks: Marks::None,
                covered: true,
            },
        )?;
        Ok(Function { gpu: lab.gpu, pipeline })
    }

    /// Values at each place for a setting of `places.glsl`.
    pub fn at(&self, setting: [f32; 4]) -> Result<Vec<[f64; 4]>, CaseError> {
        let bytes: Vec<u8> = setting.iter().flat_map(|value| value.to_le_bytes()).collect();
        let block = Buffer::new(self.gpu, "setting", BufferUse::Uniform, &bytes)?;
        let set = self.pipeline.bind(&[(0, Resource::Uniform(Arc::new(block)))])?;
        let plane = Dimension::Plane(SIDE, SIDE);
        let color = Image::new(self.gpu, "function", plane, Format::Rgba32Float, ImageUse::Target(1))?;
        self.gpu.submit("function", |commands| {
            let target = Target::of(&color);
            commands.render(target, Load::Clear([0.0; 4]), |draw| draw.triangles(&self.pipeline, &set, None, 0..3));
        })?;
        Ok(color.read()?.into_iter().map(|texel| texel.map(f64::from)).collect())
    }
}
