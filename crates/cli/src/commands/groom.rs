//! `groom`: what is painted on an object, from expressions and from files.

use crate::arguments::{ObjectFlags, SceneArguments, files_read};
use crate::session::checked;
use crate::terminal::{absolute, say, with_progress};
use clap::Args;
use hypertexture::field::Progress;
use hypertexture::glam::Vec3;
use hypertexture::output;
use hypertexture::render::{Channel, Subject, fade_flat, fill_channel};
use hypertexture::scene::{Scene, linear_to_srgb};
use hypertexture::shape::{Groom, Opened, Shape};
use hypertexture_support::{significant, write_whole_by};
use std::cell::OnceCell;
use std::error::Error;
use std::path::{Path, PathBuf};

/// Arguments of `groom`.
#[derive(Args)]
pub(crate) struct GroomArguments {
    /// An object, a scene file or an example scene.
    ///
    /// Channels that are not given are those of its groom.
    pub input: String,
    /// Output.
    #[arg(long, short, default_value = "groom.nrrd", value_name = "FILE")]
    pub output: PathBuf,
    /// Factor of the length, 0 to 2.
    ///
    /// An expression in GLSL of x, y, z and p in object space, such as "y > 0.2 ? 0.3 : 1.0", or a volume.
    #[arg(long, value_name = "EXPRESSION", allow_hyphen_values = true)]
    pub length: Option<String>,
    /// Factor of the density, 0 to 2.
    #[arg(long, value_name = "EXPRESSION", allow_hyphen_values = true)]
    pub density: Option<String>,
    /// Color: 0 is black, 1 the effect's own, 2 full.
    ///
    /// Such as "vec3(2, 1, 1)", or a mesh with colors of its vertices or materials.
    #[arg(long, value_name = "EXPRESSION", allow_hyphen_values = true)]
    pub color: Option<String>,
    /// Tangent along which strands are combed, -1 to 1 along each axis.
    #[arg(long, value_name = "EXPRESSION", allow_hyphen_values = true)]
    pub direction: Option<String>,
    /// Amount of warps and DMFs: 0 is no effect, 1 all of it, 2 twice.
    ///
    /// Such as "z < 0.2 ? 0.0 : 1.0", a volume, or a mesh with colors, of which red (sRGB, 0 to 1) is the amount.
    #[arg(long, value_name = "EXPRESSION", allow_hyphen_values = true)]
    pub amount: Option<String>,
    /// No effect where the surface is flat within this angle, 0 to 90.
    ///
    /// Multiplies the amount by 0 where the surface faces up or down within these degrees, and by factors that rise to 1 over
    /// the next 15 degrees.
    #[arg(long, value_name = "DEGREES")]
    pub amount_by_angle: Option<f32>,
    /// Voxels along a side, 32 to 256.
    ///
    /// [default: 96, or those of the scene's groom]
    #[arg(long, value_name = "NUMBER")]
    pub side: Option<u32>,
    /// The object.
    #[command(flatten)]
    pub object: ObjectFlags,
}

/// Fills the channels and writes the groom.
pub(crate) fn run(command: &GroomArguments, quiet: bool) -> Result<(), Box<dyn Error>> {
    let path = &command.output;
    if !path.extension().is_some_and(|end| end.eq_ignore_ascii_case("nrrd")) {
        return Err(format!("--output {}: end the name in .nrrd", path.display()).into());
    }
    if let Some(degrees) = command.amount_by_angle.filter(|degrees| !(0.0..=90.0).contains(degrees)) {
        return Err(format!("--amount-by-angle {degrees}: must be from 0 to 90 degrees").into());
    }
    let scene = SceneArguments::default().scene(&command.input, &command.object)?;
    // A groom that is changed may be written over itself.
    let bare = Scene { groom: None, ..scene.clone() };
    output::check_all([("--output", path.clone())], files_read(&command.input, &bare))?;
    let mut groom = match (&scene.groom, command.side) {
        (Some(file), None) => Groom::read(Path::new(file))?,
        (Some(_), Some(side)) => {
            return Err(format!("--side {side}: the scene already has a groom; its side cannot be changed").into());
        }
        (None, side) => {
            let side = side.unwrap_or(96);
            if !Groom::SIDES.contains(&side) {
                return Err(
                    format!("--side {side}: must be from {} to {}", Groom::SIDES.start(), Groom::SIDES.end()).into()
                );
            }
            Groom::unpainted(&scene.object.input, side)
        }
    };
    let (program, texts) = (
        std::env::current_exe()?,
        [&command.length, &command.density, &command.color, &command.direction, &command.amount],
    );
    let (mut notes, loaded) = (Vec::new(), OnceCell::new());
    let subject = || -> Result<&Subject, Box<dyn Error>> {
        if let Some(subject) = loaded.get() {
            return Ok(subject);
        }
        let (variant, library) = checked(&bare)?;
        let load = |progress: Progress<'_>| Subject::load(&variant, &library, progress);
        let subject = with_progress(quiet, "distance field", load)?;
        Ok(loaded.get_or_init(|| subject))
    };
    for (channel, text) in Channel::ALL.into_iter().zip(texts) {
        let Some(text) = text else { continue };
        let found = if Path::new(text).is_file() {
            fill_from_file(&mut groom, channel, text, subject()?, &scene)?
        } else {
            fill_channel(&program, &mut groom, channel, text)
                .map_err(|error| format!("--{}: {error}", channel.name()))?
        };
        notes.extend(cut(channel, found));
    }
    if let Some(degrees) = command.amount_by_angle
        && !fade_flat(&mut groom, subject()?, degrees)
    {
        return Err(
            format!("--amount-by-angle {degrees}: a custom formula has no normals here; paint by --amount").into()
        );
    }
    notes.extend(groom.odd_values());
    write_whole_by(path, |file| groom.write(file))
        .map_err(|error| format!("{}: {error}; nothing was written", path.display()))?;
    if !quiet {
        let painted = (0..groom.voxels()).filter(|index| groom.at(*index) != Groom::NEUTRAL).count();
        let (side, all) = (groom.side(), groom.voxels());
        say(&format!(
            "groom {side} x {side} x {side} voxels, {} % of them painted\n{}wrote {}\n",
            100 * painted / all,
            notes.iter().map(|line| format!("note       {line}\n")).collect::<String>(),
            absolute(path)
        ));
    }
    Ok(())
}

/// A line about values of a channel that were cut to its limits, if any. `found` has the least and the greatest value.
fn cut(channel: Channel, found: [f64; 2]) -> Option<String> {
    let [least, greatest] = Groom::limits(channel.place().0);
    let over = (found[1] as f32 > greatest).then_some((found[1], greatest));
    let under = ((found[0] as f32) < least).then_some((found[0], least));
    let cut = |(value, limit): (f64, f32)| format!("{} is cut to the limit {limit}", significant(value, 4));
    let cuts: Vec<String> = over.into_iter().chain(under).map(cut).collect();
    (!cuts.is_empty()).then(|| format!("--{}: {}", channel.name(), cuts.join(", ")))
}

/// Voxels around painted points that get their color: more than filters read.
const COLOR_MARGIN: u32 = 4;

/// Fills a channel from a file in the axes and units of the object: color from a mesh, length and density from a volume, the
/// amount from either.
/// Returns the least and the greatest value where skin may be.
fn fill_from_file(
    groom: &mut Groom,
    channel: Channel,
    file: &str,
    subject: &Subject,
    scene: &Scene,
) -> Result<[f64; 2], Box<dyn Error>> {
    let (up, flag, (first, _)) = (scene.object.up, channel.name(), channel.place());
    let mut opened = if matches!(channel, Channel::Color | Channel::Amount) {
        Opened::with_paint(file, None)?
    } else {
        Opened::of(file)?
    };
    if file == scene.object.input && !opened.notes.is_empty() {
        let said = Opened::of(file)?.notes;
        opened.notes.retain(|note| !said.contains(note));
    }
    match (channel, opened.warned(file)) {
        (Channel::Color | Channel::Amount, Shape::Mesh(mesh)) if mesh.is_colored() => {
            let moved = mesh.offset - subject.offset;
            let place = |p: Vec3| (up.turned(p.as_dvec3() + moved).as_vec3() - subject.center) * subject.scale;
            // Textures vary within a voxel.
            let spacing = if mesh.paint.is_textured() { 0.25 } else { 0.5 } * groom.step() / subject.scale;
            let points = mesh.colored_points(spacing).map(|(point, color)| (place(point), color));
            if channel == Channel::Color {
                groom.color(points, COLOR_MARGIN);
            } else {
                let red = |(point, color): (Vec3, [f32; 3])| (point, [linear_to_srgb(color[0]); 3]);
                groom.weight(points.map(red), COLOR_MARGIN);
            }
            Ok(Groom::limits(first).map(f64::from))
        }
        (Channel::Color, _) | (Channel::Amount, Shape::Mesh(_)) => {
            Err(format!("--{flag} {file}: the mesh has no vertex colors or materials").into())
        }
        (Channel::Length | Channel::Density | Channel::Amount, Shape::Volume(volume)) => {
            let mut found = [f64::INFINITY, f64::NEG_INFINITY];
            for index in 0..groom.voxels() {
                let place = subject.center + groom.place(index) / subject.scale;
                let mut voxel = groom.at(index);
                let value = volume.sample(up.turned_back(place.as_dvec3()).as_vec3());
                voxel[first] = value.unwrap_or(Groom::NEUTRAL[first]);
                if groom.may_hold_skin(index) {
                    found = [found[0].min(voxel[first].into()), found[1].max(voxel[first].into())];
                }
                groom.set(index, voxel);
            }
            Ok(found)
        }
        _ => Err(format!("--{flag} {file}: not a volume or expression; write an expression, or name a volume").into()),
    }
}
