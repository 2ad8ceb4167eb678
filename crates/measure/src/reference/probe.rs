//! The program of a scene that gives one sample of a ray, on the CPU.

use super::transport::Matter;
use super::{ReferenceError, Stop, go_on};
use hypertexture::eval;
use hypertexture::noise::Lattice;
use hypertexture::render::variant::{Program, Purpose, Variant, VariantError};
use hypertexture::render::{Blocks, CpuInputs, LOOKED_UP, OCTAVES_ID, Subject, bounded};
use hypertexture::shader::{Library, Linker};
use rayon::prelude::*;
use std::collections::BTreeMap;
use std::sync::Mutex;

/// The path of a sample, in depths of the scene: so short that only the hard region is opaque.
const PROBE: f64 = 1e-7;
/// Side of the squares of rays from the light that are computed together.
const TILE: usize = 16;

/// Rays of one beam are the neighbors of this part of a picture's side, and no more than [`MAX_BEAM`] across: bounds of a beam
/// are about as narrow as those of a ray while it is thinner than its parts are long. More: their bounds say less.
const BEAM: u32 = 32;
const MAX_BEAM: u32 = 8;

/// The program of a scene that gives one sample of a ray, ready to be evaluated.
pub(super) struct Probe {
    pub(super) program: eval::Program,
    /// The part of the program that the opacity depends on.
    pub(super) opacity: eval::Program,
    pub(super) cpu_inputs: CpuInputs,
    pub(super) moments: Vec<Moment>,
    /// Rays through squares of so many pixels a side share their first bounds.
    pub(super) beam: u32,
    /// Side of these squares, in that of the picture.
    pub(super) width: f64,
    /// The pass of the shadow volume, for programs that read one.
    caster: Option<Caster>,
}

/// The programs of a probe, linked.
pub(super) struct Linked {
    variant: Variant,
    program: Program,
    /// The program for bounds, with computed noise replaced by a lookup of known range.
    bounded: Program,
    /// That noise, and the binding it is looked up in.
    noise: Option<(u32, Lattice)>,
}

impl Linked {
    /// Those of a scene.
    pub(super) fn of(own: &Variant, library: &Library) -> Result<Linked, VariantError> {
        let variant = own.for_purpose(Purpose::Probe, library)?;
        let drawn = || variant.program(library, Linker::new);
        let (program, bounded) = rayon::join(drawn, || bounded(&variant, library));
        let program = program?;
        let Some((bounded, noise)) = bounded else {
            return Ok(Linked { variant, bounded: program.clone(), program, noise: None });
        };
        let noise = bounded.image(LOOKED_UP).map(|image| (image, noise));
        Ok(Linked { variant, program, bounded, noise })
    }
}

/// The pass that computes the shadow volume.
struct Caster {
    /// Where the probe reads it.
    binding: u32,
    program: eval::Program,
    linked: Program,
    octaves: u32,
}

/// The last shadow volume, and of what it is: pixels of one scene are often asked for again, or in another size.
static LAST: Mutex<Option<(blake3::Hash, eval::Texture)>> = Mutex::new(None);

impl Caster {
    /// Hash of the inputs of the volume.
    fn key(&self, blocks: &Blocks, inputs: &eval::Inputs) -> blake3::Hash {
        let mut hash = blake3::Hasher::new();
        hash.update(bytemuck::cast_slice(&self.linked.fragment)).update(&self.octaves.to_le_bytes());
        hash.update(&self.linked.parts_read(&self.linked.members_read(), blocks));
        for resource in &self.linked.resources {
            if let Some(image) = inputs.images.get(&resource.binding) {
                hash.update(bytemuck::cast_slice(&image.size)).update(bytemuck::cast_slice(&image.texels));
            }
            if let Some(wrap) = inputs.samplers.get(&resource.binding) {
                hash.update(format!("{wrap:?}").as_bytes());
            }
        }
        hash.finalize()
    }
}

/// The blocks of one sub-frame, by binding.
pub(super) struct Moment {
    blocks: Blocks,
    /// Those of the program that bounds are computed of.
    pub(super) opacity: Blocks,
    /// Those of the program that makes the shadow volume.
    caster: Blocks,
}

impl Probe {
    /// The probe of a scene, and its images and samplers.
    pub(super) fn new(
        library: &Library,
        own: &Variant,
        subject: &Subject,
    ) -> Result<(Probe, eval::Inputs), ReferenceError> {
        let truth = &own.scene;
        if truth.effect.classify == "stack" {
            return Err(ReferenceError::NoLimit("effect.classify = \"stack\" shows the slices themselves"));
        }
        if truth.is_half_angle() {
            return Err(ReferenceError::NoLimit("light.translucency is blurred from slice to slice"));
        }
        let Linked { variant, program, bounded, noise } = Linked::of(own, library)?;
        let cpu_inputs = CpuInputs::new(library, &variant, subject, &program)?;
        let octaves = [(OCTAVES_ID, truth.effect.octaves)];
        let shadow = match CpuInputs::shadow_binding(&program) {
            None => None,
            Some(binding) => Some((binding, own.for_purpose(Purpose::Shadow, library)?.program(library, Linker::new)?)),
        };
        let blocks = cpu_inputs.moments(&program)?.into_iter().zip(cpu_inputs.moments(&bounded)?);
        let mut moments: Vec<Moment> =
            blocks.map(|(blocks, opacity)| Moment { blocks, opacity, caster: Blocks::new() }).collect();
        if let Some((_, caster)) = &shadow {
            for (moment, blocks) in moments.iter_mut().zip(cpu_inputs.moments(caster)?) {
                moment.caster = blocks;
            }
        }
        let mut inputs = cpu_inputs.exact();
        inputs.noises = noise.into_iter().collect();
        let read = |linked: &Program| eval::Program::read(&linked.fragment, &octaves);
        let own = || {
            let opacity = || eval::Program::read_channel(&bounded.fragment, &octaves, (0, 3));
            rayon::join(|| read(&program), opacity)
        };
        let of_shadow = || shadow.as_ref().map(|(_, linked)| read(linked)).transpose();
        let ((program, opacity), of_shadow) = rayon::join(own, of_shadow);
        let (program, opacity) = (program?, opacity?);
        let caster = (shadow.zip(of_shadow?)).map(|((binding, linked), program)| Caster {
            binding,
            program,
            linked,
            octaves: truth.effect.octaves,
        });
        let side = truth.image.size[0].min(truth.image.size[1]);
        let beam = (side / BEAM).clamp(1, MAX_BEAM);
        let width = f64::from(beam) / f64::from(side);
        Ok((Probe { program, opacity, cpu_inputs, moments, beam, width, caster }, inputs))
    }

    /// Makes the inputs those of a sub-frame.
    pub(super) fn set(&self, moment: &Moment, inputs: &mut eval::Inputs, stop: Stop<'_>) -> Result<(), ReferenceError> {
        if let Some(caster) = &self.caster {
            let key = caster.key(&moment.caster, inputs);
            let last = |last: &Option<(blake3::Hash, eval::Texture)>| {
                last.as_ref().filter(|(own, _)| *own == key).map(|(_, volume)| volume.clone())
            };
            let known = LAST.lock().ok().and_then(|kept| last(&kept));
            let volume = match known {
                Some(volume) => volume,
                None => self.shadow_volume(&caster.program, moment, inputs, stop)?,
            };
            if let Ok(mut last) = LAST.lock() {
                *last = Some((key, volume.clone()));
            }
            inputs.images.insert(caster.binding, volume);
        }
        inputs.blocks.clone_from(&moment.blocks);
        Ok(())
    }

    /// The shadow volume of a sub-frame.
    fn shadow_volume(
        &self,
        caster: &eval::Program,
        moment: &Moment,
        inputs: &mut eval::Inputs,
        stop: Stop<'_>,
    ) -> Result<eval::Texture, ReferenceError> {
        inputs.blocks.clone_from(&moment.caster);
        let bound = caster.bind(inputs)?;
        let [width, height] = self.cpu_inputs.shadow_target();
        let (side, squares) = self.cpu_inputs.shadow_squares();
        // Lanes that are computed together are neighbors: they take the same way through the program.
        let firsts = (0..side).step_by(TILE).flat_map(|y| (0..side).step_by(TILE).map(move |x| [x, y]));
        let tiles: Vec<Vec<([u32; 2], [f32; 4])>> = (firsts.collect::<Vec<_>>().into_par_iter().with_max_len(1))
            .map(|[x, y]| {
                let [columns, rows] = [x, y].map(|first| first..side.min(first + TILE as u32));
                let mut lit: Vec<([u32; 2], f32)> =
                    rows.flat_map(|y| columns.clone().map(move |x| ([x, y], 1.0))).collect();
                let mut found = Vec::new();
                for [left, top] in squares.clone() {
                    go_on(stop)?;
                    let places: Vec<[u32; 2]> = lit.iter().map(|([x, y], _)| [left + x, top + y]).collect();
                    let at = |[x, y]: &[u32; 2]| [f64::from(*x) + 0.5, f64::from(*y) + 0.5, 0.5, 1.0];
                    let lanes = eval::Invocations {
                        fragment_coordinates: places.iter().map(at).collect(),
                        varyings: BTreeMap::new(),
                    };
                    let segments = bound.run::<f64>(&lanes)?.remove(&0).unwrap_or_default();
                    let segments: Vec<[f32; 4]> =
                        segments.into_iter().map(|four| four.map(|value| value as f32)).collect();
                    lit.iter_mut().zip(&segments).for_each(|(ray, four)| ray.1 *= four.iter().product::<f32>());
                    lit.retain(|(_, light)| *light > 0.0); // behind that it is dark whatever there is
                    found.extend(places.into_iter().zip(segments));
                }
                Ok(found)
            })
            .collect::<Result<_, ReferenceError>>()?;
        let mut segments = vec![[0.0; 4]; (width * height) as usize];
        for ([x, y], four) in tiles.into_iter().flatten() {
            segments[(y * width + x) as usize] = four;
        }
        let (size, values) = self.cpu_inputs.shadow_volume(&segments);
        let texels = values.into_iter().map(|value| [value, 0.0, 0.0, 1.0]).collect();
        Ok(eval::Texture { size, texels })
    }

    /// The path of a sample.
    pub(super) fn path(&self) -> f64 {
        PROBE * (self.cpu_inputs.depths[1] - self.cpu_inputs.depths[0])
    }

    /// Inputs of the program at depths of rays.
    pub(super) fn lanes(&self, pixels: &[[u32; 2]], wanted: &[(usize, f64)]) -> eval::Invocations<f64> {
        let lanes = wanted.iter().map(|&(ray, depth)| {
            let [x, y] = pixels[ray].map(|at| f64::from(at) + 0.5);
            ([x, y, 0.5, 1.0], [depth, self.path(), 0.0, 0.0])
        });
        let (fragment_coordinates, places) = lanes.unzip();
        eval::Invocations { fragment_coordinates, varyings: [(0, places)].into() }
    }

    /// Samples of rays at depths.
    pub(super) fn sample(
        &self,
        bound: &eval::BoundProgram<'_>,
        pixels: &[[u32; 2]],
        wanted: &[(usize, f64)],
    ) -> Result<Vec<Sampled>, ReferenceError> {
        if wanted.is_empty() {
            return Ok(Vec::new());
        }
        let path = self.path();
        let lanes = self.lanes(pixels, wanted);
        let outputs = bound.run::<f64>(&lanes)?;
        let (fragments, spaces) = (&outputs[&0], &outputs[&1]);
        Ok(fragments.iter().zip(spaces).map(|(fragment, space)| Sampled::new(*fragment, *space, path)).collect())
    }
}

/// A sample and what it says about its ray.
#[derive(Clone, Copy)]
pub(super) struct Sampled {
    pub(super) matter: Matter,
    /// Depths at which the ray enters and leaves the box and the ball around the soft region.
    pub(super) span: [f64; 2],
}

impl Sampled {
    fn new([r, g, b, alpha]: [f64; 4], [enters, leaves, ..]: [f64; 4], path: f64) -> Sampled {
        let color = if alpha > 0.0 { [r, g, b].map(|channel| channel / alpha.min(1.0)) } else { [0.0; 3] };
        Sampled { matter: Matter { color, extinction: extinction(alpha, path) }, span: [enters, leaves] }
    }
}

/// Extinction per depth by the opacity of a path.
pub(super) fn extinction(alpha: f64, path: f64) -> f64 {
    match alpha {
        alpha if alpha >= 1.0 => f64::INFINITY,
        alpha if alpha > 0.0 => -(-alpha).ln_1p() / path,
        _ => 0.0,
    }
}
