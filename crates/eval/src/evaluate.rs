//! Evaluation of a program at many points.

use crate::bind::BoundProgram;
use crate::code::Input;
use crate::error::ExactError;
use crate::integer_splits::IntegerSplits;
use crate::number::{Binary, Bool, Comparison, Number};
use crate::numbers::affine::Affine;
use crate::numbers::f32_interval::F32Interval;
use crate::numbers::interval::Interval;
use crate::run::control_flow::Machine;
use crate::run::lanes::{LANES, put};
use crate::run::single::{Overflow, Singles};
use std::collections::BTreeMap;

/// Points at which a program is evaluated; all lists have the same length.
#[derive(Clone, Debug)]
pub struct Invocations<N> {
    /// `gl_FragCoord` of each point. A program with derivatives needs quads of four points: the pixels (x, y),
    /// (x + 1, y), (x, y + 1) and (x + 1, y + 1).
    pub fragment_coordinates: Vec<[N; 4]>,
    /// Varyings from the vertex stage, by location.
    pub varyings: BTreeMap<u32, Vec<[N; 4]>>,
}

/// Outputs of every point by location, and the number of scalar operations.
pub type Measured<N> = (BTreeMap<u32, Vec<[N; 4]>>, u64);

/// A number type that programs are evaluated in. Its code is compiled in this crate only, not in each caller.
pub trait Evaluate: Number {
    /// Implements [`BoundProgram::measure`].
    ///
    /// # Errors
    /// [`ExactError::Invocations`] and [`ExactError::Endless`].
    fn measure(program: &BoundProgram<'_>, lanes: &Invocations<Self>) -> Result<Measured<Self>, ExactError>;
}

macro_rules! evaluate {
    ($($number:ty),*) => {$(
        impl Evaluate for $number {
            fn measure(program: &BoundProgram<'_>, lanes: &Invocations<Self>) -> Result<Measured<Self>, ExactError> {
                program.evaluate(lanes, &mut [], None)
            }
        }
    )*};
}
evaluate!(f64, Interval, F32Interval, Affine);

impl BoundProgram<'_> {
    /// Evaluates the program at every point. Returns the outputs by location, padded with zeros to four components; zeros
    /// for discarded fragments.
    ///
    /// # Errors
    /// [`ExactError::Invocations`] and [`ExactError::Endless`].
    pub fn run<N: Evaluate>(&self, lanes: &Invocations<N>) -> Result<BTreeMap<u32, Vec<[N; 4]>>, ExactError> {
        self.measure(lanes).map(|(outputs, _)| outputs)
    }

    /// [`BoundProgram::run`], with the number of scalar operations; copies and branches do not count.
    ///
    /// # Errors
    /// [`ExactError::Invocations`] and [`ExactError::Endless`].
    pub fn measure<N: Evaluate>(&self, lanes: &Invocations<N>) -> Result<Measured<N>, ExactError> {
        N::measure(self, lanes)
    }

    /// [`BoundProgram::measure`] with a limit on the iterations of all loops of a point.
    ///
    /// # Errors
    /// [`ExactError::Invocations`] and [`ExactError::Endless`], the latter also beyond the limit.
    pub fn measure_within(&self, lanes: &Invocations<f64>, most_turns: u64) -> Result<Measured<f64>, ExactError> {
        self.evaluate(lanes, &mut [], Some(most_turns))
    }

    /// Evaluates a program with results rounded to f32. Returns the outputs, the number of operations and, for each point,
    /// the first overflow of f32 at a watched place (file and line). `most_turns` limits the iterations of all loops of a
    /// point.
    ///
    /// # Errors
    /// As [`BoundProgram::measure_within`].
    pub fn measure_single(
        &self,
        lanes: &Invocations<f64>,
        most_turns: u64,
        is_watched: &dyn Fn(&str) -> bool, // dyn: generic callers would compile the evaluator again
    ) -> Result<(Measured<f64>, Vec<Option<Overflow>>), ExactError> {
        let watched = self.code.places.iter().map(|place| is_watched(place)).collect();
        let (uniforms, known) = self.computed_uniforms::<f64>(Some(Singles::new(watched)));
        let start = known.map(|known| known.start());
        let mut machine = Machine::new(self.code, &self.images, uniforms);
        (machine.most_turns, machine.singles) = (Some(most_turns), start.clone());
        let mut found = Vec::new();
        let measured = self.fill(&mut machine, lanes, &mut [], &mut |machine, here| {
            let singles = std::mem::replace(&mut machine.singles, start.clone());
            found.extend(singles.iter().flat_map(|singles| singles.overflows(here, &self.code.places)));
        })?;
        Ok((measured, found))
    }

    /// Evaluates all points, those of a segment with their integer splits if there are any.
    pub(crate) fn evaluate<N: Number>(
        &self,
        lanes: &Invocations<N>,
        splits: &mut [IntegerSplits],
        most_turns: Option<u64>,
    ) -> Result<Measured<N>, ExactError> {
        let mut machine = Machine::new(self.code, &self.images, self.uniforms());
        machine.most_turns = most_turns;
        self.fill(&mut machine, lanes, splits, &mut |_, _| ())
    }

    /// Runs all points through a machine in blocks. Calls `each` after each block, with its number of points.
    fn fill<N: Number>(
        &self,
        machine: &mut Machine<'_, N>,
        lanes: &Invocations<N>,
        splits: &mut [IntegerSplits],
        each: &mut dyn FnMut(&mut Machine<'_, N>, usize),
    ) -> Result<Measured<N>, ExactError> {
        let count = self.check(lanes)?;
        let mut outputs: BTreeMap<u32, Vec<[N; 4]>> =
            self.code.outputs.iter().map(|(location, _)| (*location, Vec::with_capacity(count))).collect();
        for first in (0..count).step_by(LANES) {
            let here = (count - first).min(LANES);
            for (input, component, reg) in &self.code.inputs {
                let values = match input {
                    Input::Fragment => &lanes.fragment_coordinates,
                    Input::Varying(location) => &lanes.varyings[location],
                };
                let row = machine.banks.floats.row(*reg);
                for lane in 0..here {
                    put(row, lane, values[first + lane][*component]);
                }
            }
            if let Some(splits) = splits.get(first..first + here) {
                machine.banks.splits = splits.to_vec();
                machine.banks.splits.resize(LANES, IntegerSplits::default());
            }
            let (ended, killed) = machine.run(u64::MAX >> (LANES - here))?;
            if let Some(splits) = splits.get_mut(first..first + here) {
                splits.copy_from_slice(&machine.banks.splits[..here]);
            }
            for (location, regs) in &self.code.outputs {
                let Some(out) = outputs.get_mut(location) else { continue };
                out.extend((0..here).map(|lane| {
                    let mut pixel = [N::new(0.0); 4];
                    for (value, reg) in pixel.iter_mut().zip(regs) {
                        let computed = machine.banks.floats.rows.read(*reg).at(lane);
                        *value = match (ended >> lane & 1 == 1, killed >> lane & 1 == 1) {
                            (true, false) => computed,
                            (true, true) => computed.join(*value),
                            (false, _) => *value,
                        };
                    }
                    pixel
                }));
            }
            each(machine, here);
        }
        Ok((outputs, machine.operations))
    }

    /// Checks the points and returns their number.
    fn check<N: Number>(&self, lanes: &Invocations<N>) -> Result<usize, ExactError> {
        let fragment = self.code.inputs.iter().any(|(input, ..)| *input == Input::Fragment);
        let needed = self.code.inputs.iter().filter_map(|(input, ..)| match input {
            Input::Varying(location) => Some(*location),
            Input::Fragment => None,
        });
        let mut count =
            (fragment || !lanes.fragment_coordinates.is_empty()).then_some(lanes.fragment_coordinates.len());
        for location in needed {
            let missing = || {
                ExactError::Invocations(format!("the program reads location {location}, but the invocations have none"))
            };
            let found = lanes.varyings.get(&location).ok_or_else(missing)?.len();
            if found != *count.get_or_insert(found) {
                let text =
                    format!("location {location} has {found} invocations, others have {}", count.unwrap_or_default());
                return Err(ExactError::Invocations(text));
            }
        }
        let count = count.unwrap_or_default();
        if self.code.derivatives && !are_quads(&lanes.fragment_coordinates) {
            let text = "the program has derivatives (dFdx): invocations 4 i to 4 i + 3 must be the pixels (x, y), (x + 1, y), \
                        (x, y + 1) and (x + 1, y + 1)";
            return Err(ExactError::Invocations(text.into()));
        }
        Ok(count)
    }
}

/// Whether every four points form a quad.
fn are_quads<N: Number>(at: &[[N; 4]]) -> bool {
    let near = |a: N, b: f64, c: N| a.binary(Binary::Sub, c).compare(Comparison::Equal, N::new(b)).may_hold();
    at.len().is_multiple_of(4)
        && at.chunks_exact(4).all(|quad| {
            (0..4).all(|pixel| {
                near(quad[pixel][0], f64::from(pixel as u32 % 2), quad[0][0])
                    && near(quad[pixel][1], f64::from(pixel as u32 / 2), quad[0][1])
            })
        })
}
