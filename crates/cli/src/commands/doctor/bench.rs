//! The device of the self-tests, and the runs of their programs.

use hypertexture::gpu::{
    Address, Binding, BindingKind, Blend, Buffer, BufferUse, Dimension, Format, Gpu, GpuError, Image, ImageUse, Load,
    Marks, Pipeline, PipelineDescription, Resource, Sampler, Submitted, Target,
};
use hypertexture::shader::{Library, LinkError, Linker, Slots, Stage};
use std::sync::Arc;

/// Bindings of `part.glsl` and `interface.glsl`.
const VOLUME: u32 = 17;
const CLAMP_SAMPLER: u32 = 5;
/// Binding of the block of `crossing.frag`.
const SETTING: u32 = 0;

/// Error of a test that could not run.
#[derive(Debug, thiserror::Error)]
pub(super) enum ProbeError {
    #[error(transparent)]
    Link(#[from] LinkError),
    #[error(transparent)]
    Gpu(#[from] GpuError),
}

/// Result of a test: `PASS`, `NOTE` or `FAIL`, and a sentence.
pub(super) type Outcome = (&'static str, String);

/// Device, library and linker of the tests.
pub(super) struct Bench<'a> {
    pub(super) gpu: &'a Gpu,
    pub(super) library: Library,
    pub(super) linker: Linker,
}

/// A run of a program of `glsl/doctor`.
pub(super) struct Run<'a> {
    pub(super) fragment: &'a str,
    pub(super) format: Format,
    pub(super) size: [u32; 2],
    pub(super) layers: u32,
    pub(super) volume: Option<Arc<Image>>,
    /// Every number of the block that the program has in place of a volume.
    pub(super) setting: Option<f32>,
}

impl Bench<'_> {
    /// Draws layers over a cleared target, each behind the ones before it, and returns the target's texels.
    pub(super) fn draw(&self, run: &Run<'_>) -> Result<(Vec<[f32; 4]>, Submitted), ProbeError> {
        const VERTEX: &str = "doctor/cover.vert";
        let link = |entry, stage| self.linker.link(&self.library, entry, stage, &[VERTEX, run.fragment], &Slots::new());
        let binding = |index, kind| Binding { index, kind, vertex: false, fragment: true };
        let volume = [binding(VOLUME, BindingKind::Image), binding(CLAMP_SAMPLER, BindingKind::Sampler)];
        let setting = [binding(SETTING, BindingKind::Uniform)];
        let pipeline = Pipeline::new(
            self.gpu,
            &PipelineDescription {
                vertex: &link(VERTEX, Stage::Vertex)?,
                fragment: &link(run.fragment, Stage::Fragment)?,
                constants: &[],
                bindings: match (&run.volume, run.setting) {
                    (Some(_), _) => &volume,
                    (None, Some(_)) => &setting,
                    (None, None) => &[],
                },
                attributes: &[],
                format: run.format,
                samples: 1,
                blend: Blend::Under,
                marks: Marks::None,
                covered: true,
            },
        )?;
        let sampler = Arc::new(Sampler::new(self.gpu, Address::Clamp, 1.0)?);
        let mut resources = vec![(CLAMP_SAMPLER, Resource::Sampler(sampler))];
        resources.extend(run.volume.clone().map(|volume| (VOLUME, Resource::Image(volume))));
        if let Some(value) = run.setting {
            let bytes: Vec<u8> = [value; 4].iter().flat_map(|value| value.to_le_bytes()).collect();
            let block = Buffer::new(self.gpu, "self-test", BufferUse::Uniform, &bytes)?;
            resources.push((SETTING, Resource::Uniform(Arc::new(block))));
        }
        let set = pipeline.bind(&resources)?;
        let [width, height] = run.size;
        let plane = Dimension::Plane(width, height);
        let color = Image::new(self.gpu, "self-test", plane, run.format, ImageUse::Target(1))?;
        let target = Target::of(&color);
        let took = self.gpu.submit("self-test", |commands| {
            commands
                .render(target, Load::Clear([0.0; 4]), |draw| draw.triangles(&pipeline, &set, None, 0..3 * run.layers));
        })?;
        Ok((color.read()?, took))
    }
}
