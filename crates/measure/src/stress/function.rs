//! A function of GLSL at 4096 places, drawn on the device.

use super::{Lab, StressError};
use hypertexture::gpu::{
    Binding, BindingKind, Blend, Buffer, BufferUse, Dimension, Format, Gpu, Image, ImageUse, Load, Marks, Pipeline,
    PipelineDescription, Resource, Target,
};
use hypertexture::shader::{Linker, Slots, Stage};
use std::sync::Arc;

/// Pixels along a side; what a function is asked at them is between two ends of its setting.
const SIDE: u32 = 64;

/// A function, ready to be asked. Its text is a fragment of which `places.glsl` is the beginning.
pub(super) struct Function<'a> {
    gpu: &'a Gpu,
    pipeline: Pipeline,
}

impl<'a> Function<'a> {
    /// Links it, with modules in the slots that it includes.
    pub fn new(lab: &Lab<'a>, text: &str, slots: &[(&str, &str)]) -> Result<Function<'a>, StressError> {
        Function::linked(lab, &lab.linker, text, slots)
    }

    /// The same by another linker.
    pub fn linked(
        lab: &Lab<'a>,
        linker: &Linker,
        text: &str,
        slots: &[(&str, &str)],
    ) -> Result<Function<'a>, StressError> {
        const VERTEX: &str = "doctor/cover.vert";
        const FRAGMENT: &str = "stress/function.glsl";
        let text = format!("{}{text}", include_str!("places.glsl"));
        let library = lab.bench.library.clone().with_module("stress", "function", &text);
        let slots: Slots = slots.iter().map(|(slot, module)| (slot.to_string(), vec![module.to_string()])).collect();
        let link = |entry, stage| linker.link(&library, entry, stage, &[VERTEX, FRAGMENT], &slots);
        let pipeline = Pipeline::new(
            lab.bench.gpu,
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
            },
        )?;
        Ok(Function { gpu: lab.bench.gpu, pipeline })
    }

    /// What it gives at each place, with a setting; `places.glsl` tells how.
    pub fn at(&self, setting: [f32; 4]) -> Result<Vec<[f64; 4]>, StressError> {
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
