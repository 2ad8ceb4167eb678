//! Modules of a person, tried before a picture is drawn with them: what they give that is no number, what f32 does not hold,
//! and loops that devices cut.
//!
//! Role: scene -> its own program in f64, and as f32 rounds, at some places of the picture, with modules that note their
//! faults (`watch.glsl`). Invariant: a scene whose modules all ship costs nothing.

use super::cpu_inputs::CpuInputs;
use super::inputs::CELLS;
use super::{OCTAVES_ID, RenderError, Subject};
use crate::eval::{ExactError, Inputs, Invocations, Overflow, Program, Texture};
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
/// The same of what is evaluated as f32 does, which takes some times as long.
const SINGLE_OPERATIONS: u64 = OPERATIONS / 8;
/// How far what f32 gives is off, of linear light, where what it does not hold shows.
const SHOWS: f64 = 0.01;
/// Quads that are evaluated together: few at first, where a loop may have no end, then as many as a block of lanes has.
const TOGETHER: [u32; 2] = [2, 16];
/// Parameters that are named.
const NAMED: usize = 8;

/// What to do about a [`Fault`].
pub const FINITE: &str = "keep what it computes finite, such as log(max(x, 1e-6))";

/// What a custom module gives that is no finite number, or is beyond f32 on the way to what it gives.
#[derive(Clone, Debug, PartialEq)]
pub struct Fault {
    /// The module, `dmf/ripples.glsl`; with the line of what is beyond f32.
    pub module: String,
    /// `NaN`, `an infinity`, or what is beyond f32.
    pub what: String,
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

/// Tries the custom modules of a scene: what they give that is no number, or is beyond f32, at a place that was tried. A scene
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

/// What lanes gave that is wrong.
#[derive(Default)]
struct Found {
    /// How many were tried in f64, and as f32 does.
    tried: [usize; 2],
    /// How many gave what is no number; of the first, the number of the module, whether it is NaN, and the pixel.
    wrong: (usize, Option<(usize, bool, [u32; 2])>),
    /// How many lost something beyond f32; the first, and its pixel.
    beyond: (usize, Option<(Overflow, [u32; 2])>),
}

impl Trial<'_> {
    fn run(&self) -> Result<Option<Fault>, RenderError> {
        let Trial { library, scene, subject, variant, .. } = self;
        // A ray is one fragment with all its samples; of slices, each sample is one.
        let rays = scene.quality.pass == Pass::March;
        let tried = if rays { variant.clone() } else { variant.probe(scene, library)? };
        let program = tried.unoptimized(library)?;
        let cpu_inputs = CpuInputs::new(library, scene, subject, &tried, &program)?;
        let whose = if rays { "ray" } else { "sample" };
        let Found { tried, wrong, beyond } = self.found(&cpu_inputs, &program, scene.image.size, whose)?;
        if scene.light.shadows {
            let caster = variant.shadow(scene, library)?.unoptimized(library)?;
            self.found(&cpu_inputs, &caster, cpu_inputs.shadow_target(), "ray of the light")?;
        }
        let of = if rays { "rays" } else { "places" };
        Ok(match (wrong, beyond) {
            ((count, Some((module, is_nan, pixel))), _) => {
                let module = self.own[module - 1].clone();
                let what = if is_nan { "NaN" } else { "an infinity" }.into();
                let with = with(library, variant, &module);
                Some(Fault { module, what, with, count, tried: tried[0], of, pixel })
            }
            (_, (count, Some((Overflow { place, operation, .. }, pixel)))) => {
                let path = self.own.iter().find(|path| is_in(path, &place));
                let with = path.map(|path| with(library, variant, path)).unwrap_or_default();
                let what = format!("{operation}, which is beyond f32 (3.4e38)");
                Some(Fault { module: place, what, with, count, tried: tried[1], of, pixel })
            }
            _ => None,
        })
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
        let is_own = |place: &str| self.own.iter().any(|path| is_in(path, place));
        evaluate(&exact, &inputs, size, place, is_own).map_err(|error| match error {
            ExactError::Endless { turns, place } => {
                let own = |path: &&String| is_in(path, &place);
                let with = |path: &String| with(&self.library, &self.variant, path);
                let with = self.own.iter().find(own).or(self.own.first()).map(with).unwrap_or_default();
                RenderError::Loop { place, whose, turns, with }
            }
            error => error.into(),
        })
    }
}

/// Whether a place in the text is in a file; `place` may be of a further object, or of a second copy.
fn is_in(path: &str, place: &str) -> bool {
    place
        .rsplit_once(':')
        .is_some_and(|(file, _)| file.split('#').next().unwrap_or_default().rsplit(':').next() == Some(path))
}

/// Evaluates a program in quads all over a target; `place` is what it reads at a depth, from 0 to 1, and `is_own` says whether
/// a file and line are a person's.
fn evaluate(
    program: &Program,
    inputs: &Inputs,
    size: [u32; 2],
    place: impl Fn(f64) -> [f64; 4],
    is_own: impl Fn(&str) -> bool,
) -> Result<Found, ExactError> {
    let bound = program.bind(inputs)?;
    let mut found = Found::default();
    let ([mut operations, mut singles], mut done, mut together) = ([0; 2], 0, TOGETHER[0]);
    while done < QUADS && operations < OPERATIONS {
        let mut lanes = Invocations { fragment_coordinates: Vec::new(), varyings: BTreeMap::from([(0, Vec::new())]) };
        for quad in done..QUADS.min(done + together) {
            let [x, y, depth] = scattered(quad);
            let corner =
                [(x, size[0]), (y, size[1])].map(|(at, side)| 2.0 * (at * f64::from(side.div_ceil(2))).floor());
            let pixels = [[0.5, 0.5], [1.5, 0.5], [0.5, 1.5], [1.5, 1.5]];
            lanes.fragment_coordinates.extend(pixels.map(|[x, y]| [corner[0] + x, corner[1] + y, 0.5, 1.0]));
            lanes.varyings.entry(0).or_default().extend([place(depth); 4]);
        }
        let (outputs, spent) = bound.measure_within(&lanes, MOST_TURNS)?;
        let pixel = |lane: usize| [0, 1].map(|axis| lanes.fragment_coordinates[lane][axis] as u32);
        for (lane, [module, kind, ..]) in outputs.get(&FAULT).into_iter().flatten().enumerate() {
            if *module > 0.0 {
                found.wrong.0 += 1;
                found.wrong.1.get_or_insert((*module as usize, *kind == 1.0, pixel(lane)));
            }
        }
        found.tried[0] += lanes.fragment_coordinates.len();
        if singles < SINGLE_OPERATIONS {
            let ((of_singles, spent), beyond) = bound.measure_single(&lanes, MOST_TURNS, &is_own)?;
            for (lane, overflow) in beyond.into_iter().enumerate() {
                let Some(overflow) = overflow.filter(|own| own.is_lost || shows(&outputs, &of_singles, lane)) else {
                    continue;
                };
                found.beyond.0 += 1;
                found.beyond.1.get_or_insert((overflow, pixel(lane)));
            }
            found.tried[1] += lanes.fragment_coordinates.len();
            singles += spent;
        }
        (operations, done, together) = (operations + spent, done + together, TOGETHER[1]);
    }
    Ok(found)
}

/// The outputs of lanes, by location.
type Outputs = BTreeMap<u32, Vec<[f64; 4]>>;

/// Whether what a lane gives as f32 does is not what it gives in f64.
fn shows(outputs: &Outputs, singles: &Outputs, lane: usize) -> bool {
    outputs.iter().filter(|(location, _)| **location != FAULT).any(|(location, all)| {
        let pairs = all[lane].iter().zip(&singles[location][lane]);
        pairs.map(|(known, found)| (known - found).abs()).any(|off| off.is_nan() || off > SHOWS)
    }) || singles.get(&FAULT).is_some_and(|faults| faults[lane][0] > 0.0)
}

/// The points of a sequence that fills a cube evenly, however many there are (Roberts 2018).
fn scattered(index: u32) -> [f64; 3] {
    const ROOT: f64 = 1.220_744_084_605_759_5; // of x^4 = x + 1
    [1, 2, 3].map(|axis| (0.5 + f64::from(index) * ROOT.powi(-axis)).fract())
}
