//! Modules of a person, tried before a picture is drawn with them: what they give that is no number, and loops that
//! devices cut.
//!
//! Role: scene -> its own program in f64, at some places of the picture, with modules that note their faults
//! (`watch.glsl`). Invariant: a scene whose modules all ship costs nothing.

use super::cpu_inputs::CpuInputs;
use super::inputs::CELLS;
use super::{OCTAVES_ID, RenderError, Subject};
use crate::exact::{ExactError, Inputs, Lanes, Program, Texture};
use crate::render::variant::{self, Use, Variant};
use crate::scene::{ParameterValue, Pass, Scene};
use crate::shader::{FAULT, Library, changed};
use std::collections::BTreeMap;
use std::fmt;

/// Turns of all the loops of a fragment after which a device may end it in silence: lavapipe does.
const MOST_TURNS: u64 = 65_535;
/// Quads of places that are tried, if they are cheap. Fewer: a fault in a small part of the picture is not met.
const QUADS: u32 = 1024;
/// Scalar operations of what is tried, but for the last quads: a sixth of a second.
const OPERATIONS: u64 = 1 << 25;
/// Quads that are evaluated together: few at first, where a loop may have no end, then as many as a block of lanes has.
const TOGETHER: [u32; 2] = [2, 16];
/// Parameters that are named.
const NAMED: usize = 8;

/// What to do about a [`Fault`].
pub const FINITE: &str = "keep what it computes finite, such as log(max(x, 1e-6))";

/// What a custom module gives that is no finite number.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// The module: `dmf/ripples.glsl`.
    pub module: String,
    /// `NaN` or `an infinity`.
    pub what: &'static str,
    /// The values of its parameters: ` with rings = 6`; empty where it has none.
    pub with: String,
    /// At how many of the rays, or places, that were tried.
    pub count: usize,
    /// How many were tried.
    pub tried: usize,
    /// What was tried: `rays` or `places`.
    pub of: &'static str,
    /// The pixel in which the first of them is.
    pub pixel: [u32; 2],
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Fault { module, what, with, count, tried, of, pixel: [x, y] } = self;
        write!(f, "{module} gives {what}{with}, for {count} of {tried} {of}, the first in pixel {x}, {y}")
    }
}

/// Tries the custom modules of a scene; what they give that is no number, if they do at a place that was tried. A scene
/// that cannot be evaluated is not tried.
///
/// # Errors
/// The scene has no program, or a device would cut the loops of one.
pub fn watch(library: &Library, scene: &Scene, subject: &Subject) -> Result<Option<Fault>, RenderError> {
    let variant = Variant::of(scene, library)?;
    let own = own_modules(library, &variant);
    if own.is_empty() {
        return Ok(None);
    }
    let trial = Trial { library: library.watched(own.iter().map(String::as_str)), scene, subject, variant, own };
    match trial.run() {
        Ok(fault) => Ok(fault),
        Err(error @ RenderError::Loop { .. }) => Err(error),
        Err(error) => {
            log::debug!("custom modules are not tried: {error}");
            Ok(None)
        }
    }
}

/// An error of a picture, with the custom module that is the cause of it.
pub(super) fn explained(error: RenderError, library: &Library, scene: &Scene, subject: &Subject) -> RenderError {
    let (RenderError::NotFinite { count, x, y, .. }, Ok(variant)) = (&error, Variant::of(scene, library)) else {
        return error;
    };
    let own = own_modules(library, &variant);
    let cause = match watch(library, scene, subject) {
        Err(error) => return error,
        _ if own.is_empty() => return error,
        Ok(Some(fault)) => format!("{fault}; {FINITE}"),
        Ok(None) => {
            let all: Vec<String> = own.iter().map(|path| path.clone() + &with(library, &variant, path)).collect();
            format!("no module that ships gives them; look for what is too large for f32 in {}", all.join(" and in "))
        }
    };
    RenderError::NotFinite { count: *count, x: *x, y: *y, cause }
}

/// The files of the program that do not ship.
fn own_modules(library: &Library, variant: &Variant) -> Vec<String> {
    changed(library).into_keys().filter(|path| variant.reaches(library, path)).collect()
}

/// The values of the parameters of a module, in words.
fn with(library: &Library, variant: &Variant, path: &str) -> String {
    let (slot, name) = path.trim_end_matches(".glsl").split_once('/').unwrap_or_default();
    let declared = library.header(slot, name).unwrap_or_default().parameters;
    let is_own = |name: &str| {
        let copy = |rest: &str| rest.chars().all(|c| c == '_' || c.is_ascii_digit());
        declared.iter().any(|parameter| name.strip_prefix(&parameter.name).is_some_and(copy))
    };
    let values: Vec<String> = variant
        .all_parameters()
        .filter(|(_, parameter, _)| is_own(&parameter.name))
        .map(|(name, _, value)| match value {
            ParameterValue::Number(number) => format!("{name} = {number}"),
            ParameterValue::Color(color) => format!("{name} = {}", String::from(*color)),
        })
        .collect();
    match values.len() {
        0 => String::new(),
        count => format!(" with {}{}", values[..count.min(NAMED)].join(", "), if count > NAMED { ", ..." } else { "" }),
    }
}

/// A scene with custom modules.
struct Trial<'a> {
    /// With modules that note their faults.
    library: Library,
    scene: &'a Scene,
    subject: &'a Subject,
    variant: Variant,
    /// Those modules, in the order of their numbers.
    own: Vec<String>,
}

/// How many lanes gave what is no number, of how many; of the first, the module, what it gave, and the pixel.
type Found = (usize, usize, Option<(usize, bool, [u32; 2])>);

impl Trial<'_> {
    fn run(&self) -> Result<Option<Fault>, RenderError> {
        let Trial { library, scene, subject, variant, .. } = self;
        // A ray is one fragment with all its samples; of slices, each sample is one.
        let rays = scene.quality.pass == Pass::March;
        let tried = if rays { variant.clone() } else { variant.probe(scene, library)? };
        let program = tried.unoptimized(library)?;
        let cpu_inputs = CpuInputs::new(library, scene, subject, &tried, &program)?;
        let whose = if rays { "ray" } else { "sample" };
        let (count, tried, first) = self.found(&cpu_inputs, &program, scene.image.size, whose)?;
        if scene.light.shadows {
            let caster = variant.shadow(scene, library)?.unoptimized(library)?;
            self.found(&cpu_inputs, &caster, cpu_inputs.shadow_target(), "ray of the light")?;
        }
        let Some((module, is_nan, pixel)) = first else { return Ok(None) };
        let module = self.own[module - 1].clone();
        let what = if is_nan { "NaN" } else { "an infinity" };
        let (with, of) = (with(library, variant, &module), if rays { "rays" } else { "places" });
        Ok(Some(Fault { module, what, with, count, tried, of, pixel }))
    }

    /// What a program gives at places of a target.
    fn found(
        &self,
        cpu_inputs: &CpuInputs,
        program: &variant::Program,
        size: [u32; 2],
        whose: &'static str,
    ) -> Result<Found, RenderError> {
        let mut inputs = cpu_inputs.exact();
        inputs.blocks = cpu_inputs.moments(program)?.into_iter().next().unwrap_or_default();
        for image in program.resources.iter().filter(|resource| matches!(resource.holds, Use::Image)) {
            // What is made with the picture: light, and all of it arrives; or cells, and no one is empty.
            let value = if image.name == CELLS { 0.0 } else { 1.0 };
            let plain = || Texture { size: [1; 3], texels: vec![[value; 4]] };
            inputs.images.entry(image.binding).or_insert_with(plain);
        }
        let exact = Program::read(&program.fragment, &[(OCTAVES_ID, self.scene.effect.octaves)])?;
        let [near, far] = cpu_inputs.depths;
        let place =
            |depth| [near + (far - near) * depth, (far - near) / f64::from(self.scene.quality.samples), 0.0, 0.0];
        evaluate(&exact, &inputs, size, place).map_err(|error| match error {
            ExactError::Endless { turns, place } => {
                let own = |path: &&String| place.contains(path.as_str());
                let with = |path: &String| with(&self.library, &self.variant, path);
                let with = self.own.iter().find(own).or(self.own.first()).map(with).unwrap_or_default();
                RenderError::Loop { place, whose, turns, with }
            }
            error => error.into(),
        })
    }
}

/// Evaluates a program in quads all over a target; `place` is what it reads at a depth, from 0 to 1.
fn evaluate(
    program: &Program,
    inputs: &Inputs,
    size: [u32; 2],
    place: impl Fn(f64) -> [f64; 4],
) -> Result<Found, ExactError> {
    let bound = program.bind(inputs)?;
    let (mut count, mut tried, mut first) = (0, 0, None);
    let (mut operations, mut done, mut together) = (0, 0, TOGETHER[0]);
    while done < QUADS && operations < OPERATIONS {
        let mut lanes = Lanes { fragment_coordinates: Vec::new(), varyings: BTreeMap::from([(0, Vec::new())]) };
        for quad in done..QUADS.min(done + together) {
            let [x, y, depth] = scattered(quad);
            let corner =
                [(x, size[0]), (y, size[1])].map(|(at, side)| 2.0 * (at * f64::from(side.div_ceil(2))).floor());
            let pixels = [[0.5, 0.5], [1.5, 0.5], [0.5, 1.5], [1.5, 1.5]];
            lanes.fragment_coordinates.extend(pixels.map(|[x, y]| [corner[0] + x, corner[1] + y, 0.5, 1.0]));
            lanes.varyings.entry(0).or_default().extend([place(depth); 4]);
        }
        let (outputs, spent) = bound.measure_within(&lanes, MOST_TURNS)?;
        let faults = outputs.get(&FAULT).into_iter().flatten();
        for ([module, kind, ..], [x, y, ..]) in
            faults.zip(&lanes.fragment_coordinates).filter(|(fault, _)| fault[0] > 0.0)
        {
            count += 1;
            first.get_or_insert((*module as usize, *kind == 1.0, [*x as u32, *y as u32]));
        }
        tried += lanes.fragment_coordinates.len();
        (operations, done, together) = (operations + spent, done + together, TOGETHER[1]);
    }
    Ok((count, tried, first))
}

/// The points of a sequence that fills a cube evenly, however many there are (Roberts 2018).
fn scattered(index: u32) -> [f64; 3] {
    const ROOT: f64 = 1.220_744_084_605_759_5; // of x^4 = x + 1
    [1, 2, 3].map(|axis| (0.5 + f64::from(index) * ROOT.powi(-axis)).fract())
}
