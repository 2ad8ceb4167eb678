//! Density, color and extinction at voxels, on the device.
//!
//! Invariant: the density is that of [`polygonize`](crate::render::polygonize), in f32.

use super::bind::{self, BoundInputs, PipelineShape};
use super::filters::suited;
use super::submission_budget::SubmissionBudget;
use crate::gpu::{self, Area, BindSet, Buffer, BufferUse, Dimension, Format, Gpu, Image, ImageUse, Load, Target};
use crate::render::camera::{FrameContext, SubFrame};
use crate::render::error::RenderError;
use crate::render::inputs::Inputs;
use crate::render::subject::Subject;
use crate::render::variant::{Purpose, Variant};
use crate::shader::{Library, Linker};
use glam::{DMat3, DVec3};
use std::borrow::Cow;
use std::sync::Arc;

/// Pixels along a side of the target. Higher: more memory. Lower: more submissions.
const TARGET: u32 = 512;
/// Vertices of a cube's rectangle, and floats of each attribute.
const VERTICES: u32 = 6;
const ATTRIBUTES: [u32; 5] = [4, 4, 3, 3, 3];

/// Program of a scene's voxels with its inputs.
pub(crate) struct VoxelProgram {
    gpu: Gpu,
    pipeline: gpu::Pipeline,
    set: BindSet,
    target: Arc<Image>,
    budget: SubmissionBudget,
    /// Time on the device, milliseconds.
    pub gpu_ms: f64,
}

impl VoxelProgram {
    /// Links the program of a scene and uploads its inputs, at the first moment of the scene. `as_value` puts the value of alpha in
    /// place of the opacity.
    pub fn new(
        gpu: &Gpu,
        library: &Library,
        drawn: &Variant,
        subject: &Subject,
        as_value: fn(&Library, &Variant) -> (Library, Variant),
    ) -> Result<VoxelProgram, RenderError> {
        let drawn = suited(gpu.info(), Cow::Borrowed(drawn));
        let (library, variant) = as_value(library, &drawn.for_purpose(Purpose::Voxels, library)?);
        let program = variant.program(&library, Linker::new)?;
        let frame = FrameContext::of(drawn.into_owned(), subject);
        let inputs = Inputs::new(&library, &frame, &program, &|_| ())?;
        let mut bound = BoundInputs::new(gpu, &library, &program, &inputs, false, false, &|_| ())?;
        for moment in SubFrame::all(&frame.variant.scene).take(1) {
            bound.fill(gpu, &program, &frame, &moment, &|| false)?;
        }
        let shape = PipelineShape { attributes: &ATTRIBUTES, ..PipelineShape::of(Format::Rgba32Float) };
        let pipeline = bind::pipeline(gpu, &program, &variant.scene, shape)?;
        let set = pipeline.bind(&bound.resources())?;
        let plane = Dimension::Plane(TARGET, TARGET);
        let target = Arc::new(Image::new(gpu, "voxels", plane, Format::Rgba32Float, ImageUse::Target(1))?);
        Ok(VoxelProgram { gpu: gpu.clone(), pipeline, set, target, budget: SubmissionBudget::default(), gpu_ms: 0.0 })
    }

    /// Most cubes of `side`^3 voxels at a time.
    pub const fn most(side: u32) -> usize {
        (TARGET / (side * side) * (TARGET / side)) as usize
    }

    /// Evaluates cubes of `side`^3 voxels by their first voxels and the steps between voxels, object space. Gives `take` the
    /// texels of [`TexelsOfCube`].
    pub fn cubes<T>(
        &mut self,
        side: u32,
        first: &[DVec3],
        steps: &DMat3,
        take: impl FnOnce(&[[f32; 4]], TexelsOfCube) -> T,
    ) -> Result<T, RenderError> {
        let texels = TexelsOfCube { side, in_row: TARGET / (side * side) };
        let vertices = texels.vertices(first, steps);
        let vertices = Buffer::new(&self.gpu, "voxels", BufferUse::Vertices, bytemuck::cast_slice(&vertices))?;
        let (mut done, mut load, of_cube) = (0, Load::Clear([0.0; 4]), f64::from(side.pow(3)));
        self.budget.begin();
        while done < first.len() {
            let end = first.len().min(done + (self.budget.samples() / of_cube).max(1.0) as usize);
            let cost = self.gpu.submit("voxels", |commands| {
                commands.render(Target::of(&self.target), load, |draw| {
                    let range = VERTICES * done as u32..VERTICES * end as u32;
                    draw.triangles(&self.pipeline, &self.set, Some(&vertices), range);
                });
            })?;
            self.budget.took((end - done) as f64 * of_cube, cost.gpu_ms);
            self.gpu_ms += cost.gpu_ms;
            (done, load) = (end, Load::Keep);
        }
        Ok(self.target.read_with(|all| take(all, texels))?)
    }
}

/// Places of the voxels of cubes in the texels of a target.
#[derive(Clone, Copy)]
pub(crate) struct TexelsOfCube {
    side: u32,
    /// Cubes in a row.
    in_row: u32,
}

impl TexelsOfCube {
    /// Pixels of a cube.
    fn area(&self, cube: u32) -> Area {
        let [x, y] = [cube % self.in_row * self.side * self.side, cube / self.in_row * self.side];
        Area { columns: x..x + self.side * self.side, rows: y..y + self.side }
    }

    /// Index of the texel of a voxel.
    pub fn index(&self, cube: usize, [x, y, z]: [u32; 3]) -> usize {
        let Area { columns, rows } = self.area(cube as u32);
        ((rows.start + y) * TARGET + columns.start + z * self.side + x) as usize
    }

    fn vertices(&self, first: &[DVec3], steps: &DMat3) -> Vec<f32> {
        let clip = |pixel: u32| pixel as f32 * (2.0 / TARGET as f32) - 1.0;
        let steps = steps.as_mat3().to_cols_array();
        let cube = |(number, first): (u32, &DVec3)| {
            let Area { columns, rows } = self.area(number);
            let corner = move |[right, down]: [bool; 2]| {
                let at = [if right { columns.end } else { columns.start }, if down { rows.end } else { rows.start }];
                [clip(at[0]), clip(at[1]), columns.start as f32, rows.start as f32]
            };
            let first = first.as_vec3().extend(self.side as f32).to_array();
            let [a, b, c, d] = [[false, false], [true, false], [true, true], [false, true]];
            [a, b, c, a, c, d]
                .map(corner)
                .into_iter()
                .flat_map(move |corner| corner.into_iter().chain(first).chain(steps))
        };
        (0..).zip(first).flat_map(cube).collect()
    }
}
