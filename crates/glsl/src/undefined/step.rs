//! The effect of one instruction on the values and variables of a function.

use super::flow::{Flow, Here, Origin, Run};
use super::model::{Instruction, Line};
use super::scalar::{Scalar, computed};
use super::state::{Code, Codes, DEFINED, Pointer, State, UNWRITTEN, join, tidy};
use crate::spirv::Op;
use std::ops::Range;

/// Largest variable that is followed, in scalars: beyond the largest array of a module.
const MOST_SCALARS: usize = 1 << 14;
/// Name that glslang gives to copies of arguments.
const ARGUMENT: &str = "param";

impl<'m, 'a> Flow<'m, 'a> {
    /// Follows an instruction within a block; false if the path ends there.
    pub(super) fn step(
        &mut self,
        run: &mut Run<'m, 'a>,
        here: &mut Here,
        state: &mut State,
        (op, words, line): Instruction<'_>,
    ) -> bool {
        match (op, words) {
            (Op::Line | Op::NoLine | Op::LoopMerge | Op::SelectionMerge | Op::Nop, _) => {}
            (Op::Variable, &[_, _, id, _, ref initial @ ..]) => {
                let code = if initial.is_empty() { UNWRITTEN } else { DEFINED };
                if self.model.size(self.model.kind(id)) <= MOST_SCALARS {
                    state.variables.insert(id, self.codes(id, code));
                }
            }
            (Op::AccessChain | Op::InBoundsAccessChain, &[_, _, id, base, ref indices @ ..]) => {
                indices.iter().for_each(|index| self.used(&run.codes(here, *index), line));
                if let Some(pointer) = self.accessed(run, here, (base, indices), line) {
                    run.pointers.insert(id, pointer);
                }
            }
            (Op::Load, &[_, _, id, from, ..]) => self.load(run, here, state, (id, from, line)),
            (Op::Store, &[_, to, value, ..]) => {
                let given = run.codes(here, value);
                match self.pointer(run, to).filter(|to| state.variables.contains_key(&to.variable)) {
                    None => self.used(&given, line),
                    Some(to) => {
                        let scalar = self.scalar(here, value);
                        self.store(state, &to, (&given, scalar), line);
                    }
                }
            }
            (Op::FunctionCall, &[_, _, id, callee, ref arguments @ ..]) => {
                return self.called(run, here, state, (id, callee, arguments));
            }
            (Op::Undef, &[_, _, id]) => drop(run.undefined.insert(id)),
            (Op::Return, _) => run.leave(state, Vec::new()),
            (Op::ReturnValue, &[_, value]) => {
                if run.undefined.contains(&value) {
                    self.no_return(run);
                }
                let given = run.codes(here, value);
                let is_moved = self.model.is_structure(self.model.kind(value));
                if !is_moved {
                    self.used(&given, line);
                }
                run.leave(state, if is_moved { given } else { Vec::new() });
            }
            (Op::Unreachable, _) => {
                if self.model.is_known(run.function.result) {
                    self.no_return(run);
                }
                return false;
            }
            (Op::Kill | Op::TerminateInvocation, _) => {
                self.note(
                    line,
                    "a module may not `discard`: slices and rays would drop other matter; give density 0 instead",
                );
                return false;
            }
            (Op::DemoteToHelperInvocation, _) => {
                self.note(
                    line,
                    "a module may not `demote`: slices and rays would drop other matter; give density 0 instead",
                );
            }
            (Op::Phi, [_, _, id, pairs @ ..]) => {
                let mut all = Vec::new();
                pairs.chunks_exact(2).for_each(|pair| _ = join(&mut all, &run.codes(here, pair[0])));
                here.values.insert(*id, all);
            }
            (Op::Select, &[_, _, id, condition, yes, no]) => {
                self.used(&run.codes(here, condition), line);
                let mut all = run.codes(here, yes);
                join(&mut all, &run.codes(here, no));
                here.values.insert(id, all);
                self.compute(here, op, words);
            }
            (Op::CopyObject | Op::CopyLogical, &[_, _, id, from]) => {
                here.values.insert(id, run.codes(here, from));
                self.compute(here, op, words);
            }
            (Op::CompositeConstruct, [_, _, id, parts @ ..]) => {
                let parts: Vec<Codes> = parts.iter().map(|part| self.whole(run, here, *part)).collect();
                here.values.insert(*id, tidy(parts.concat()));
            }
            (Op::CompositeExtract, &[_, _, id, from, ref indices @ ..]) => {
                let given = run.codes(here, from);
                let (start, kind) = self.offset(from, indices);
                let part = given.get(start..start + self.model.size(kind)).unwrap_or_default();
                here.values.insert(id, tidy(part.to_vec()));
            }
            (Op::CompositeInsert, &[_, _, id, part, into, ref indices @ ..]) => {
                let (mut all, part) = (self.whole(run, here, into), self.whole(run, here, part));
                let (start, _) = self.offset(into, indices);
                all.iter_mut().skip(start).zip(part).for_each(|(into, code)| *into = code);
                here.values.insert(id, tidy(all));
            }
            (Op::VectorShuffle, [_, _, id, a, b, picks @ ..]) => {
                let both = [self.whole(run, here, *a), self.whole(run, here, *b)].concat();
                let picked = picks.iter().map(|pick| both.get(*pick as usize).copied().unwrap_or(DEFINED));
                here.values.insert(*id, tidy(picked.collect()));
            }
            (_, &[_, _, _, ..]) => {
                self.operands(run, here, (op, words, line));
                self.compute(here, op, words);
                // Functions such as `modf` write through their last operand.
                if let Some(to) = words.last().and_then(|last| self.pointer(run, *last)).filter(|_| op == Op::ExtInst) {
                    self.store(state, &to, (&[], None), line);
                }
            }
            _ => {}
        }
        true
    }

    /// Notes the result of an operation on known scalars.
    fn compute(&self, here: &mut Here, op: Op, words: &[u32]) {
        let known: Option<Vec<Scalar>> = words[3..].iter().map(|operand| self.scalar(here, *operand)).collect();
        if let Some(scalar) = known.and_then(|known| computed(op, &known)) {
            here.scalars.insert(words[2], scalar);
        }
    }

    /// Notes a way through a function that gives no result.
    fn no_return(&mut self, run: &Run<'_, '_>) {
        let name = self.model.function_name(run.id);
        self.note(run.function.line, &format!("`{name}` can end without `return`; return a value on every path"));
    }

    /// Notes undefined operands of an operation, and operations that a module may not use.
    fn operands(&mut self, run: &Run<'_, '_>, here: &Here, (op, words, line): Instruction<'_>) {
        if let Some(name) = between_pixels(op) {
            self.note(
                line,
                &format!(
                    "`{name}` needs the neighboring pixels, which slices, rays and compute shaders do not have alike; take \
                     differences of your own"
                ),
            );
        } else if chooses_level(op) {
            let text = "`texture` chooses a level by the neighboring pixels, which slices, rays and compute shaders do not have \
                        alike; use `textureLod` with level 0.0";
            self.note(line, text);
        }
        let is_image = (Op::ImageSampleImplicitLod..=Op::ImageWrite).contains(&op);
        // Literals: the set and number of a function, and the mask of an image's operands.
        let is_literal = |at: usize| match op {
            Op::ExtInst => at < 5,
            _ => is_image && at == 5,
        };
        for (at, operand) in words.iter().enumerate().skip(3) {
            if !is_literal(at) {
                self.used(&run.codes(here, *operand), line);
            }
        }
    }

    /// Codes of a value, one for each scalar.
    fn whole(&self, run: &Run<'_, '_>, here: &Here, id: u32) -> Codes {
        let mut found = run.codes(here, id);
        found.resize(self.model.size(self.model.kind(id)), DEFINED);
        found
    }

    /// First scalar and type of a part of a value, by constant indices.
    fn offset(&self, id: u32, indices: &[u32]) -> (usize, u32) {
        indices.iter().fold((0, self.model.kind(id)), |(start, kind), index| {
            self.model.part(kind, *index as usize).map_or((start, kind), |(part, before)| (start + before, part))
        })
    }

    /// A pointer of a function, or a whole variable.
    pub(super) fn pointer(&self, run: &Run<'_, '_>, id: u32) -> Option<Pointer> {
        let whole = || Pointer { variable: id, starts: vec![0], stored: vec![0], kind: self.model.kind(id) };
        run.pointers.get(&id).cloned().or_else(|| self.model.is_pointer(id).then(whole))
    }

    /// The part of a variable by indices; notes one that is out of range.
    fn accessed(
        &mut self,
        run: &Run<'_, '_>,
        here: &Here,
        (base, indices): (u32, &[u32]),
        line: Line,
    ) -> Option<Pointer> {
        let mut found = self.pointer(run, base)?;
        for index in indices {
            let count = self.model.count(found.kind)?;
            let picks = match self.scalar(here, *index).and_then(Scalar::integer) {
                None => 0..count,
                Some(known) => match usize::try_from(known).ok().filter(|known| *known < count) {
                    Some(known) => known..known + 1,
                    None => {
                        if self.model.is_of_known_length(found.kind) {
                            let name = self.model.name(found.variable);
                            let text =
                                format!("index {known} of `{name}`, which has {count} elements: 0 to {}", count - 1);
                            self.note(line, &text);
                        }
                        return None;
                    }
                },
            };
            let is_constant = self.model.constants.contains_key(index);
            let stored = if is_constant { picks.clone() } else { 0..count };
            let (kind, model, first) = (found.kind, self.model, picks.start);
            let within = |starts: &[usize], picks: Range<usize>| -> Vec<usize> {
                let before = picks.filter_map(|pick| model.part(kind, pick)).map(|(_, before)| before);
                let before: Vec<usize> = before.collect();
                starts.iter().flat_map(|start| before.iter().map(move |before| start + before)).collect()
            };
            (found.starts, found.stored) = (within(&found.starts, picks), within(&found.stored, stored));
            found.kind = model.part(kind, first)?.0;
        }
        Some(found)
    }

    fn load(&mut self, run: &mut Run<'m, 'a>, here: &mut Here, state: &State, (id, from, line): (u32, u32, Line)) {
        let Some(from) = self.pointer(run, from) else { return };
        let Some(variable) = state.variables.get(&from.variable) else { return };
        let size = self.model.size(from.kind);
        let mut all = vec![DEFINED; size];
        for start in &from.starts {
            join(&mut all, variable.get(*start..start + size).unwrap_or_default());
        }
        // An argument that a function has not written is passed on to the variable that receives it.
        if all.contains(&UNWRITTEN) && self.model.name(from.variable) != ARGUMENT {
            let code = self.code(Origin::Read(line, from.variable));
            all.iter_mut().filter(|code| **code == UNWRITTEN).for_each(|own| *own = code);
        }
        here.values.insert(id, tidy(all));
        if let Some(scalar) = state.scalars.get(&from.variable).filter(|_| variable.len() == 1) {
            here.scalars.insert(id, *scalar);
        }
    }

    fn store(&mut self, state: &mut State, to: &Pointer, (given, scalar): (&[Code], Option<Scalar>), line: Line) {
        let size = self.model.size(to.kind);
        let Some(variable) = state.variables.get_mut(&to.variable) else { return };
        if to.stored.len() > 1 && variable.iter().any(|code| *code != DEFINED) && self.is_own(line) {
            self.filled.insert((self.model.file(line).into(), line.1, self.model.name(to.variable).into()));
        }
        for start in &to.stored {
            for (at, own) in variable.iter_mut().skip(*start).take(size).enumerate() {
                *own = given.get(at).copied().unwrap_or(DEFINED);
            }
        }
        match scalar.filter(|_| variable.len() == 1) {
            Some(scalar) => drop(state.scalars.insert(to.variable, scalar)),
            None => drop(state.scalars.remove(&to.variable)),
        }
    }

    /// Follows a call; false if it never returns.
    fn called(
        &mut self,
        run: &mut Run<'m, 'a>,
        here: &mut Here,
        state: &mut State,
        (id, callee, arguments): (u32, u32, &[u32]),
    ) -> bool {
        let function = self.model.functions.get(&callee);
        let enters = !run.is_own && function.is_some_and(|function| self.is_own(function.line));
        let (mut given, mut variables) = (Vec::new(), Vec::new());
        for argument in arguments {
            let to = self.pointer(run, *argument).map(|to| to.variable);
            let known = to.and_then(|to| state.variables.get(&to).cloned());
            given.push(known.unwrap_or_else(|| self.whole(run, here, *argument)));
            variables.push(to);
        }
        let mut globals = state.variables.clone();
        globals.retain(|variable, _| self.globals.contains_key(variable));
        if enters {
            for (global, codes) in &mut globals {
                if self.globals[global] {
                    let kept = self.code(Origin::Kept(*global));
                    codes.fill(kept);
                }
            }
        }
        let exit = self.call((callee, given, globals), run.depth + 1);
        let Some((end, result)) = &*exit else { return false };
        let parameters = function.map_or(&[][..], |function| &function.parameters);
        let changed =
            parameters.iter().zip(variables).filter_map(|(parameter, variable)| Some((*parameter, variable?)));
        for (parameter, variable) in changed.chain(self.globals.keys().map(|global| (*global, *global))) {
            if let Some(codes) = end.variables.get(&parameter) {
                state.variables.insert(variable, codes.clone());
                state.scalars.remove(&variable);
            }
        }
        here.values.insert(id, result.clone());
        true
    }
}

/// Name of a function that compares neighboring pixels.
fn between_pixels(op: Op) -> Option<&'static str> {
    Some(match op {
        Op::DPdx => "dFdx",
        Op::DPdy => "dFdy",
        Op::Fwidth => "fwidth",
        Op::DPdxFine => "dFdxFine",
        Op::DPdyFine => "dFdyFine",
        Op::FwidthFine => "fwidthFine",
        Op::DPdxCoarse => "dFdxCoarse",
        Op::DPdyCoarse => "dFdyCoarse",
        Op::FwidthCoarse => "fwidthCoarse",
        Op::ImageQueryLod => "textureQueryLod",
        _ => return None,
    })
}

/// Whether a texture lookup chooses its level by derivatives.
fn chooses_level(op: Op) -> bool {
    use Op::*;
    matches!(
        op,
        ImageSampleImplicitLod
            | ImageSampleDrefImplicitLod
            | ImageSampleProjImplicitLod
            | ImageSampleProjDrefImplicitLod
            | ImageSparseSampleImplicitLod
    )
}
