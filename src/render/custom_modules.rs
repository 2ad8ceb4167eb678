//! Trial of custom modules before a picture: NaN, infinities, overflows of f32, and loops that devices cut.
//!
//! Role: the scene's program is evaluated in f64 and with the range of f32 at sampled places of the picture; the evaluator
//! notes faults of own modules. Invariants: a module that cannot be tried is refused; a scene of shipped modules costs
//! nothing.

use crate::eval::{ExactError, FAULTS, Fault, Inputs, Invocations, Overflow, Program, Texture, Watch};
use crate::render::error::RenderError;
use crate::render::inputs::CpuInputs;
use crate::render::subject::Subject;
use crate::render::variant::{self, Checkable, OCTAVES_ID, PassImage, Purpose, Use, Variant};
use crate::scene::{ParameterValue, Pass};
use crate::shader::{Library, changed, undefined};
use std::collections::BTreeMap;

/// Loop iterations of a fragment after which lavapipe silently ends it.
const MOST_TURNS: u64 = 65_535;
/// Sampled quads, if cheap. Lower: a fault in a small part of the picture is missed.
const QUADS: u32 = 1024;
/// Budget of scalar operations in f64, checked between batches: a sixth of a second.
const OPERATIONS: u64 = 1 << 25;
/// Budget of scalar operations with the range of f32, which are several times slower.
const SINGLE_OPERATIONS: u64 = OPERATIONS / 8;
/// Visible difference between f32 and f64, linear light.
const VISIBLE_DIFFERENCE: f64 = 0.01;
/// Quads in a batch: few at first, in case a loop is endless, then the lanes of a block.
const BATCH: [u32; 2] = [2, 16];
/// A second initial value of variables without one, in place of 0: it shows where an unwritten element is read.
const OTHER_FILL: f64 = 1013.0;
/// Largest number of parameters in a message.
const MAX_NAMED: usize = 8;

/// Advice for a [`ModuleFault`].
pub const FINITE: &str = "keep what it computes finite, such as log(max(x, 1e-6))";

/// A non-finite result of a custom module, or an overflow of f32 on the way to it.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("{module} gives {what}{with}, for {count} of {tried} {of}, the first in pixel {}, {}", .pixel[0], .pixel[1])]
pub struct ModuleFault {
    /// Module, such as `dmf/ripples.glsl`; for an overflow, with its line.
    pub module: String,
    /// `NaN`, `an infinity`, or the overflowing operation.
    pub what: String,
    /// Values of its parameters, such as ` with rings = 6`; may be empty.
    pub with: String,
    /// Number of faulty rays or places.
    pub count: usize,
    /// Number of tested rays or places.
    pub tried: usize,
    /// `rays` or `places`.
    pub of: &'static str,
    /// Pixel of the first fault.
    pub pixel: [u32; 2],
}

/// Tests the custom modules of a scene.
///
/// # Errors
/// The scene has no program, the program cannot be evaluated, a device would cut one of its loops, or a module computes with
/// an undefined value.
pub fn find_module_fault(
    library: &Library,
    scene: &impl Checkable,
    subject: &Subject,
) -> Result<Option<ModuleFault>, RenderError> {
    let variant = scene.checked(library)?;
    let own = own_modules(library, &variant);
    if own.is_empty() {
        return Ok(None);
    }
    let modules = own.join(", ");
    (Trial { library, subject, variant: &variant, own }).run().map_err(|error| match error {
        RenderError::Exact(reason) => RenderError::Untried { modules, reason: Box::new(reason) },
        error => error,
    })
}

/// Adds the responsible custom module to an error of non-finite pixels.
pub(crate) fn with_module_cause(
    error: RenderError,
    library: &Library,
    variant: &Variant,
    subject: &Subject,
) -> RenderError {
    let RenderError::NotFinite { count, x, y, .. } = &error else { return error };
    let own = own_modules(library, variant);
    let cause = match find_module_fault(library, variant, subject) {
        Err(error) => return error,
        _ if own.is_empty() => return error,
        Ok(Some(fault)) => format!("{fault}; {FINITE}"),
        Ok(None) => {
            let all: Vec<String> = own.iter().map(|path| path.clone() + &with(library, variant, path)).collect();
            format!(
                "shipped modules are not the cause; look for values beyond the range of f32 in {}",
                all.join(" and in ")
            )
        }
    };
    RenderError::NotFinite { count: *count, x: *x, y: *y, cause }
}

/// Custom files that the program reaches.
fn own_modules(library: &Library, variant: &Variant) -> Vec<String> {
    changed(library).into_keys().filter(|path| variant.reaches(library, path)).collect()
}

/// Values of a module's parameters, in words.
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
        count => format!(
            " with {}{}",
            values[..count.min(MAX_NAMED)].join(", "),
            if count > MAX_NAMED { ", ..." } else { "" }
        ),
    }
}

/// Test of a scene with custom modules.
struct Trial<'a> {
    library: &'a Library,
    subject: &'a Subject,
    variant: &'a Variant,
    /// Custom modules, in the order of their numbers.
    own: Vec<String>,
}

/// Faults of the tested lanes.
#[derive(Default)]
struct Found {
    /// Number of lanes tested in f64, and with the range of f32.
    tried: [usize; 2],
    /// Number of non-finite lanes; of the first, module number, whether NaN, and pixel.
    wrong: (usize, Option<(usize, bool, [u32; 2])>),
    /// Number of lanes with undefined values; of the first, the text and its place.
    undefined: (usize, Option<(String, String, [u32; 2])>),
    /// Number of overflowing lanes; the first overflow and its pixel.
    beyond: (usize, Option<(Overflow, [u32; 2])>),
}

/// A target: size, and the input of its program at a depth in [0, 1].
type Target<'a> = ([u32; 2], &'a dyn Fn(f64) -> [f64; 4]);

impl Trial<'_> {
    fn run(&self) -> Result<Option<ModuleFault>, RenderError> {
        let Trial { library, subject, variant, .. } = self;
        let scene = &variant.scene;
        // A fragment of rays takes all samples of a ray; one of slices takes a single sample.
        let rays = scene.quality.pass == Pass::March;
        let try_as = |tried: &Variant, whose| -> Result<(Found, CpuInputs), RenderError> {
            let program = tried.unoptimized(library)?;
            let cpu_inputs = CpuInputs::new(library, tried, subject, &program)?;
            Ok((self.found(&cpu_inputs, &program, scene.image.size, whose)?, cpu_inputs))
        };
        let samples = || try_as(&variant.for_purpose(Purpose::Probe, library)?, "sample");
        let (found, of) = match if rays { try_as(variant, "ray") } else { samples() } {
            // Rays of shipped modules that the evaluator does not cover.
            Err(RenderError::Exact(ExactError::Uncovered { place, .. })) if rays && !self.is_own(&place) => {
                (samples()?, "places")
            }
            found => (found?, if rays { "rays" } else { "places" }),
        };
        let (Found { tried, wrong, beyond, .. }, cpu_inputs) = found;
        if scene.light.shadows {
            let caster = variant.for_purpose(Purpose::Shadow, library)?.unoptimized(library)?;
            self.found(&cpu_inputs, &caster, cpu_inputs.shadow_target(), "ray of the light")?;
        }
        Ok(match (wrong, beyond) {
            ((count, Some((module, is_nan, pixel))), _) => {
                let module = self.own[module - 1].clone();
                let what = if is_nan { "NaN" } else { "an infinity" }.into();
                let with = with(library, variant, &module);
                Some(ModuleFault { module, what, with, count, tried: tried[0], of, pixel })
            }
            (_, (count, Some((Overflow { place, operation, .. }, pixel)))) => {
                let with = self.with(&place);
                let what = format!("{operation}, which is beyond f32 (3.4e38)");
                Some(ModuleFault { module: place, what, with, count, tried: tried[1], of, pixel })
            }
            _ => None,
        })
    }

    /// Tests a program at places of a target.
    fn found(
        &self,
        cpu_inputs: &CpuInputs,
        program: &variant::Program,
        size: [u32; 2],
        whose: &'static str,
    ) -> Result<Found, RenderError> {
        let text_of = |file: &str| {
            let path = self.own.iter().find(|path| is_in(path, &format!("{file}:")))?;
            self.library.source(path)
        };
        let undefined = undefined(&program.fragment, &text_of);
        let undefined =
            undefined.map_err(|reason| RenderError::Undefined(format!("{}: {reason}", self.own.join(", "))))?;
        if let Some(first) = undefined.found.into_iter().next() {
            return Err(RenderError::Undefined(first));
        }
        let mut inputs = cpu_inputs.exact();
        inputs.blocks = cpu_inputs.moments(program)?.into_iter().next().unwrap_or_default();
        for image in program.resources.iter().filter(|resource| matches!(resource.holds, Use::Image)) {
            // Images that are rendered with the picture: full light, and no empty cells.
            let value = if image.image() == Some((PassImage::Cells.into(), "")) { 0.0 } else { 1.0 };
            let plain = || Texture { size: [1; 3], texels: vec![[value; 4]] };
            inputs.images.entry(image.binding).or_insert_with(plain);
        }
        let (scene, [near, far]) = (&self.variant.scene, cpu_inputs.depths);
        let place = |depth| [near + (far - near) * depth, (far - near) / f64::from(scene.quality.samples), 0.0, 0.0];
        let target: Target<'_> = (size, &place);
        let read = |fill| {
            let number = |file: &str| self.number(&format!("{file}:"));
            Program::read_watched(
                &program.fragment,
                &[(OCTAVES_ID, scene.effect.octaves)],
                &Watch { number: &number, fill },
            )
        };
        let exact = read(0.0)?;
        let found = evaluate(&exact, &inputs, target, &|place| self.is_own(place)).map_err(|error| match error {
            ExactError::Endless { turns, place } => {
                let with = self.with(&place);
                RenderError::Loop { place, whose, turns, with }
            }
            error => error.into(),
        })?;
        if let (count, Some((place, text, [x, y]))) = &found.undefined {
            let with = self.with(place);
            let tried = found.tried[0];
            let text = format!("{place}: {text}{with}, for {count} of {tried} {whose}s, the first in pixel {x}, {y}");
            return Err(RenderError::Undefined(text));
        }
        // Arrays that are filled by an index: whether all that is read was written.
        if let Some(first) = undefined.filled.first()
            && let Some([x, y]) = differing([&exact, &read(OTHER_FILL)?], &inputs, target)?
        {
            let text = format!(
                "{first} is read where nothing was written before, as in pixel {x}, {y}; fill all its elements"
            );
            return Err(RenderError::Undefined(text));
        }
        Ok(found)
    }

    /// Number of the custom module of a source location, from 1; 0 for a shipped one.
    fn number(&self, place: &str) -> u32 {
        (1..).zip(&self.own).find(|(_, path)| is_in(path, place)).map_or(0, |(number, _)| number)
    }

    /// Whether a source location is in a custom module.
    fn is_own(&self, place: &str) -> bool {
        self.number(place) > 0
    }

    /// Values of the parameters of the module of a source location, else of the first one.
    fn with(&self, place: &str) -> String {
        let path = self.own.iter().find(|path| is_in(path, place)).or(self.own.first());
        path.map(|path| with(self.library, self.variant, path)).unwrap_or_default()
    }
}

/// Whether a source location is in a file; `place` may belong to an additional object or to a second copy.
fn is_in(path: &str, place: &str) -> bool {
    place
        .rsplit_once(':')
        .is_some_and(|(file, _)| file.split('#').next().unwrap_or_default().rsplit(':').next() == Some(path))
}

/// Lanes of some quads, which are scattered over a target.
fn lanes_of(quads: std::ops::Range<u32>, (size, place): Target<'_>) -> Invocations<f64> {
    let mut lanes = Invocations { fragment_coordinates: Vec::new(), varyings: BTreeMap::from([(0, Vec::new())]) };
    for quad in quads {
        let [x, y, depth] = scattered(quad);
        let corner = [(x, size[0]), (y, size[1])].map(|(at, side)| 2.0 * (at * f64::from(side.div_ceil(2))).floor());
        let pixels = [[0.5, 0.5], [1.5, 0.5], [0.5, 1.5], [1.5, 1.5]];
        lanes.fragment_coordinates.extend(pixels.map(|[x, y]| [corner[0] + x, corner[1] + y, 0.5, 1.0]));
        lanes.varyings.entry(0).or_default().extend([place(depth); 4]);
    }
    lanes
}

/// Pixel of a lane.
fn pixel_of(lanes: &Invocations<f64>, lane: usize) -> [u32; 2] {
    [0, 1].map(|axis| lanes.fragment_coordinates[lane][axis] as u32)
}

/// Evaluates a program in quads across a target; `is_own` tells custom source locations.
fn evaluate(
    program: &Program,
    inputs: &Inputs,
    target: Target<'_>,
    is_own: &dyn Fn(&str) -> bool,
) -> Result<Found, ExactError> {
    let bound = program.bind(inputs)?;
    let mut found = Found::default();
    let ([mut operations, mut singles], mut done, mut together) = ([0; 2], 0, BATCH[0]);
    while done < QUADS && operations < OPERATIONS {
        let lanes = lanes_of(done..QUADS.min(done + together), target);
        let (outputs, spent) = bound.measure_within(&lanes, MOST_TURNS)?;
        let pixel = |lane: usize| pixel_of(&lanes, lane);
        for (lane, [module, kind, place, value]) in outputs.get(&FAULTS).into_iter().flatten().enumerate() {
            let place = || program.place(*place as usize).to_string();
            let text = match Fault::of(*kind) {
                None => continue,
                Some(Fault::Nan | Fault::Infinite) => {
                    found.wrong.0 += 1;
                    found.wrong.1.get_or_insert((*module as usize, Fault::of(*kind) == Some(Fault::Nan), pixel(lane)));
                    continue;
                }
                Some(Fault::Index) => format!("the index {value} is outside of its array, vector or matrix"),
                Some(Fault::Divisor) => "an integer is divided by 0".into(),
            };
            found.undefined.0 += 1;
            found.undefined.1.get_or_insert_with(|| (place(), text, pixel(lane)));
        }
        found.tried[0] += lanes.fragment_coordinates.len();
        if singles < SINGLE_OPERATIONS {
            let ((of_singles, spent), beyond) = bound.measure_single(&lanes, MOST_TURNS, is_own)?;
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
        (operations, done, together) = (operations + spent, done + together, BATCH[1]);
    }
    Ok(found)
}

/// The first pixel where two programs differ.
fn differing(programs: [&Program; 2], inputs: &Inputs, target: Target<'_>) -> Result<Option<[u32; 2]>, ExactError> {
    let [one, other] = [programs[0].bind(inputs)?, programs[1].bind(inputs)?];
    let (mut operations, mut done) = (0, 0);
    while done < QUADS && operations < OPERATIONS {
        let lanes = lanes_of(done..QUADS.min(done + BATCH[1]), target);
        let [(a, spent), (b, _)] = [one.measure_within(&lanes, MOST_TURNS)?, other.measure_within(&lanes, MOST_TURNS)?];
        let bits = |outputs: &Outputs, lane: usize| -> Vec<u64> {
            let drawn = outputs.iter().filter(|(location, _)| **location != FAULTS);
            drawn.flat_map(|(_, all)| all[lane].map(f64::to_bits)).collect()
        };
        if let Some(lane) = (0..lanes.fragment_coordinates.len()).find(|lane| bits(&a, *lane) != bits(&b, *lane)) {
            return Ok(Some(pixel_of(&lanes, lane)));
        }
        (operations, done) = (operations + spent, done + BATCH[1]);
    }
    Ok(None)
}

/// Outputs of lanes, by location.
type Outputs = BTreeMap<u32, Vec<[f64; 4]>>;

/// Whether the results of a lane with the range of f32 differ visibly from those in f64.
fn shows(outputs: &Outputs, singles: &Outputs, lane: usize) -> bool {
    outputs.iter().filter(|(location, _)| **location != FAULTS).any(|(location, all)| {
        let pairs = all[lane].iter().zip(&singles[location][lane]);
        pairs.map(|(known, found)| (known - found).abs()).any(|off| off.is_nan() || off > VISIBLE_DIFFERENCE)
    }) || singles.get(&FAULTS).is_some_and(|faults| faults[lane][0] > 0.0)
}

/// Low-discrepancy sequence in the unit cube (Roberts 2018).
pub(super) fn scattered(index: u32) -> [f64; 3] {
    const ROOT: f64 = 1.220_744_084_605_759_5; // of x^4 = x + 1
    [1, 2, 3].map(|axis| (0.5 + f64::from(index) * ROOT.powi(-axis)).fract())
}
