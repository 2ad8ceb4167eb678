//! `volume`: the density, extinction and color of a hypertextured object, as a fog volume.

use crate::arguments::{ObjectFlags, SceneArguments, Times};
use crate::session::{CheckedScene, FrameObject, Outputs, Preparation, Prepared, say_fault, with_device};
use crate::terminal::{absolute, say, say_json, with_progress};
use clap::Args;
use glam::{DMat3, DVec3, Mat3};
use hypertexture::gpu::{Gpu, Options};
use hypertexture::output::PROGRAM;
use hypertexture::render::variant::Variant;
use hypertexture::render::{
    Subject, VoxelError, VoxelExtinction, VoxelFit, VoxelGrids, VoxelLeaf, VoxelPlan, VoxelReport, lit_media, voxelize,
};
use hypertexture::scene::{Axis, Scene};
use hypertexture::shader::Library;
use hypertexture::shape::{self, Fog, FogGrid, FogLeaf, VolumeFormat};
use hypertexture_support::{free_space, memory, significant, write_whole_by};
use serde_json::{Value, json};
use std::collections::BTreeMap;
use std::error::Error;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Instant;

/// RMS error of the density beyond which a volume is called coarse.
const COARSE_RMS: f64 = 0.02;

/// Arguments of `volume`.
#[derive(Args)]
pub struct Volume {
    /// An object, a scene file, an example scene, or a picture of this program.
    pub input: String,
    /// Output: .vdb, .nrrd or .npy.
    ///
    /// The last two hold the density alone.
    #[arg(long, short, default_value = "volume.vdb", value_name = "FILE")]
    pub output: PathBuf,
    /// Voxels along the longest side, 8 to 2048.
    #[arg(long, default_value_t = 128)]
    pub grid: u32,
    /// Store 16-bit floats.
    #[arg(long)]
    pub half: bool,
    /// Print JSON.
    #[arg(long)]
    pub json: bool,
    /// The frames.
    #[command(flatten)]
    pub times: Times,
    /// The object.
    #[command(flatten)]
    pub object: ObjectFlags,
    /// The scene.
    #[command(flatten)]
    pub arguments: SceneArguments,
}

/// Evaluates the voxels of each frame and writes them.
pub(crate) fn run(command: &Volume, options: &Options, quiet: bool) -> Result<(), Box<dyn Error>> {
    command.format()?;
    let scene = command.arguments.scene_and_base(&command.input, &command.object)?;
    export(command, options, CheckedScene::of(scene)?, quiet)
}

impl Volume {
    fn format(&self) -> Result<VolumeFormat, String> {
        let path = &self.output;
        match VolumeFormat::from_path(path) {
            Some(VolumeFormat::OpenVdb) => Ok(VolumeFormat::OpenVdb),
            Some(VolumeFormat::Nrrd | VolumeFormat::Npy) if self.half => {
                Err(format!("--half: {} holds 32-bit floats; write a .vdb", path.display()))
            }
            Some(format @ (VolumeFormat::Nrrd | VolumeFormat::Npy)) => Ok(format),
            _ => Err(format!("--output {}: end the name in .vdb, .nrrd or .npy", path.display())),
        }
    }
}

/// Evaluates the voxels of a checked scene and writes them.
pub(crate) fn export(
    command: &Volume,
    options: &Options,
    scene: CheckedScene,
    quiet: bool,
) -> Result<(), Box<dyn Error>> {
    let format = command.format()?;
    let scenes = command.times.scenes(&scene.moving, &command.output)?;
    let outputs = &Outputs::Files(scenes.iter().map(|(_, path)| ("--output", path.clone())).collect());
    let input = command.input.as_str();
    let preparation = Preparation { input, outputs, device: Some(options), serves_all_moments: false, quiet };
    let Prepared { moving, variant, library, subject, fault, .. } = scene.prepare(&preparation)?;
    if moving.camera.clip.is_some() {
        ::log::warn!("camera.clip cuts pictures; the volume is whole");
    }
    let quiet_lines = quiet || command.json;
    let (device, written) = with_device(options, |gpu| {
        let mut object = FrameObject::of(&variant, &subject);
        let written = scenes.iter().map(|(scene, path)| {
            object.serve(&Variant::of(scene, &library)?, &library)?;
            let maker = Maker { gpu, library: &library, subject: &object.subject, format, command, quiet };
            maker.write(scene, path, quiet_lines)
        });
        Ok((gpu.info().title(), written.collect::<Result<Vec<_>, _>>()?))
    })?;
    if command.json {
        return Ok(say_json(&json!({ "program": PROGRAM, "device": device, "volumes": written }))?);
    }
    if !quiet {
        say_fault(fault);
    }
    Ok(())
}

/// Content of a file: names of grids, and the color of all matter if it is not a grid.
struct Content {
    names: Vec<&'static str>,
    color: Option<[f32; 3]>,
}

type Written = (VoxelReport, Content);

/// Inputs of all frames.
struct Maker<'a> {
    gpu: &'a Gpu,
    library: &'a Library,
    subject: &'a Subject,
    format: VolumeFormat,
    command: &'a Volume,
    quiet: bool,
}

impl Maker<'_> {
    /// Writes the volume of a frame. Result: a summary as JSON.
    fn write(&self, scene: &Scene, path: &Path, quiet: bool) -> Result<Value, Box<dyn Error>> {
        let (began, variant) = (Instant::now(), Variant::of(scene, self.library)?);
        let mut plan =
            VoxelPlan::of(self.library, &variant, self.subject, self.command.grid).map_err(|error| match error {
                VoxelError::Grid(_) => format!("--{error}").into(),
                error => Box::<dyn Error>::from(error),
            })?;
        if self.format != VolumeFormat::OpenVdb {
            self.check_size(plan.voxels(), path)?;
        }
        with_progress(self.quiet, "empty space", |progress| plan.prove(progress))?;
        if self.format == VolumeFormat::OpenVdb {
            self.check_size(plan.leaves.len() as u64 * u64::from(FogLeaf::SIDE.pow(3)) * VoxelGrids::CHANNELS, path)?;
        }
        let (report, grids) = match self.format {
            VolumeFormat::OpenVdb => self.write_fog(&plan, path, VoxelGrids::of(&variant, self.subject))?,
            _ => self.write_dense(&plan, path)?,
        };
        let seconds = began.elapsed().as_secs_f64();
        let VoxelReport { leaves, evaluated, gpu_ms, fit, extinction } = report;
        let floats = if self.command.half { "16-bit floats" } else { "32-bit floats" };
        let media = lit_media(self.library, &variant);
        if !quiet {
            let [x, y, z] = plan.size;
            let place = self.format.lost_place(plan.origin.as_vec3(), steps(&plan));
            let place = place.map_or(String::new(), |place| format!("place      {place}\n"));
            say(&format!(
                "volume     {x} x {y} x {z} voxels of {} world units; {leaves} leaves of 8 x 8 x 8 hold matter\n\
                 grids      {}: {floats}{}\n\
                 error      {}\n\
                 extinction {}\n\
                 color      {}\n\
                 axes       {}\n{place}\
                 time       {:.1} s on the device for {evaluated} voxels, {seconds:.1} s in all\nwrote {}\n",
                significant(plan.step, 3),
                grids.names.join(", "),
                grids.color.map_or(String::new(), |color| format!("; all of the color {color:?}, linear")),
                error_line(&fit),
                extinction_line(&extinction),
                color_line(&media),
                axes_line(scene.object.up),
                1e-3 * gpu_ms,
                absolute(path)
            ));
        }
        Ok(json!({
            "file": absolute(path), "size": plan.size, "voxel": plan.step, "origin": plan.origin.to_array(), "grids": grids.names, "color": grids.color,
            "leaves": leaves, "evaluated": evaluated, "error": fit, "extinction": extinction.constant_factor(),
            "extinction_range": extinction.factor, "largest_extinction": extinction.largest, "extinction_limit": extinction.limit,
            "limited_voxels": extinction.limited, "lit_media": media, "gpu_ms": gpu_ms, "all_ms": 1e3 * seconds,
        }))
    }

    /// Refuses a number of values that memory or disk may not hold.
    fn check_size(&self, values: u64, path: &Path) -> Result<(), String> {
        let bytes = values * if self.command.half { 2 } else { 4 };
        for (place, free) in [("memory", memory::available()), ("on the disk", free_space(path))] {
            if let Some(free) = free.filter(|free| *free < bytes) {
                let [bytes, free] = [bytes, free].map(|bytes| bytes >> 20);
                return Err(format!(
                    "--grid {}: {} may take {bytes} MiB, and {free} MiB are free {place}; lower it",
                    self.command.grid,
                    path.display()
                ));
            }
        }
        Ok(())
    }

    /// Evaluates the voxels; `take` receives the leaves.
    fn voxelize(
        &self,
        plan: &VoxelPlan,
        take: &mut dyn FnMut(Vec<VoxelLeaf>) -> io::Result<()>,
    ) -> Result<VoxelReport, VoxelError> {
        with_progress(self.quiet, "voxels", |progress| {
            voxelize(self.gpu, self.library, plan, self.subject, self.command.half, take, progress)
        })
    }

    fn write_fog(&self, plan: &VoxelPlan, path: &Path, mut grids: VoxelGrids) -> Result<Written, Box<dyn Error>> {
        let is_half = self.command.half;
        let mut fog = Fog { origin: plan.origin, step: plan.step, is_half, grids: grids.list(), leaves: Vec::new() };
        let report = self.voxelize(plan, &mut |leaves| grids.add(&leaves, &mut fog))?;
        let keep = |grid: &FogGrid| grids.keeps(grid);
        write_whole_by(path, |file| fog.write(keep, file)).map_err(|error| unwritten(path, error))?;
        let names = fog.grids.iter().filter(|grid| keep(grid)).map(|grid| grid.name).collect();
        Ok((report, Content { names, color: grids.flat_color() }))
    }

    fn write_dense(&self, plan: &VoxelPlan, path: &Path) -> Result<Written, Box<dyn Error>> {
        let size = plan.size.map(|side| side as usize);
        let mut values = vec![0.0_f32; size.iter().product()];
        let report = self.voxelize(plan, &mut |leaves| {
            for VoxelLeaf { corner, voxels, .. } in leaves {
                for (index, [.., density]) in voxels.into_iter().enumerate() {
                    let within = FogLeaf::at(index);
                    let at = [0, 1, 2].map(|axis| (corner[axis] + within[axis]) as usize);
                    if at.iter().zip(size).all(|(at, side)| *at < side) {
                        values[(at[2] * size[1] + at[1]) * size[0] + at[0]] = density;
                    }
                }
            }
            Ok(())
        })?;
        let (origin, content) = (plan.origin.as_vec3(), shape::Content::Scalar);
        let volume = shape::Volume { size: plan.size, origin, steps: steps(plan), values, content };
        write_whole_by(path, |file| self.format.write(&volume, file)).map_err(|error| unwritten(path, error))?;
        Ok((report, Content { names: vec!["density"], color: None }))
    }
}

/// Steps between the voxels of a plan.
fn steps(plan: &VoxelPlan) -> Mat3 {
    DMat3::from_diagonal(DVec3::splat(plan.step)).as_mat3()
}

fn error_line(fit: &VoxelFit) -> String {
    let [rms, largest] = [fit.rms, fit.largest].map(|number| significant(number, 3));
    let halved = match fit.halved_by {
        Some(grid) => format!("half of it at --grid {grid}"),
        None => "its detail is finer than voxels".into(),
    };
    let coarse = if fit.rms > COARSE_RMS { "coarse: " } else { "" };
    format!(
        "{coarse}RMS {rms}, largest {largest} of a density of 0 to 1, at {} places in these leaves; {halved} (order {:.2})",
        fit.places, fit.order
    )
}

fn extinction_line(extinction: &VoxelExtinction) -> String {
    let [largest, limit] = [extinction.largest, extinction.limit].map(|number| significant(number, 3));
    let largest = match extinction.limited {
        0 => format!("the largest is {largest}"),
        count => {
            format!("{count} voxels, of hard or almost hard matter, have the limit {limit}, an optical depth of 16")
        }
    };
    let factor = match (extinction.constant_factor(), extinction.factor) {
        (Some(factor), _) => format!("{} times -ln(1 - density) per world unit; ", significant(factor, 3)),
        (None, Some(ends)) => {
            let [low, high] = ends.map(|number| significant(number, 3));
            format!("{low} to {high} times -ln(1 - density) per world unit, by the place; ")
        }
        (None, None) => "per world unit; ".into(),
    };
    factor + &largest
}

/// The role of the color in other renderers.
fn color_line(media: &BTreeMap<String, bool>) -> String {
    let named =
        |lit: bool| media.iter().filter(|(_, is)| **is == lit).map(|(name, _)| name.as_str()).collect::<Vec<_>>();
    let (lit, shining) = (named(true).join(", "), named(false).join(", "));
    let emission = "emission, times the extinction";
    match (lit.is_empty(), shining.is_empty()) {
        (false, true) => format!("albedo of {lit}: lit by the lights of the other program"),
        (true, _) => format!("{emission} ({shining})"),
        (false, false) => format!("albedo of {lit}; {emission}, of {shining}"),
    }
}

/// The turn from the axes of the file to Blender's, whose z axis points up.
fn axes_line(up: Axis) -> String {
    let turn = match up {
        Axis::Z => "as in Blender",
        Axis::Y => "turn it in Blender by 90 degrees about x",
        Axis::MinusY => "turn it in Blender by -90 degrees about x",
        Axis::MinusZ => "turn it in Blender by 180 degrees about x",
        Axis::X => "turn it in Blender by -90 degrees about y",
        Axis::MinusX => "turn it in Blender by 90 degrees about y",
    };
    format!("those of the input, where {} points up: {turn}", up.name())
}

fn unwritten(path: &Path, error: io::Error) -> String {
    format!("{}: {error}; nothing was written", path.display())
}
