//! Values that are undefined on some path, found by following every path of a program from its entry.
//!
//! A function is followed once for each set of undefined parts that it is called with. Parts without a value may be copied, as
//! in structures that are passed on, but not computed with. A loop whose first test is known to hold runs at least once. A
//! store by an index that is not known fills the whole array.

use super::model::{Block, Function, Line, Model};
use super::scalar::Scalar;
use super::state::{Code, Codes, DEFINED, FIRST_ORIGIN, Pointer, State, UNWRITTEN, join};
use crate::spirv::Op;
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};
use std::rc::Rc;

/// Instructions that are followed at most. Programs of shipped modules have some 10^5.
const MOST_STEPS: usize = 1 << 25;
/// Nested calls that are followed; GLSL has no recursion.
const DEEPEST: usize = 256;

/// Where a scalar without a value comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Origin {
    /// A variable is read.
    Read(Line, u32),
    /// A function leaves a parameter unwritten.
    Unset(u32, u32),
    /// A global variable is as the last call left it.
    Kept(u32),
}

/// State and result at the exits of a function; `None` if it never returns.
type Exit = Option<(State, Codes)>;
/// A call: function, codes of arguments, codes of global variables.
type Call = (u32, Vec<Codes>, BTreeMap<u32, Codes>);

/// The paths of a program.
pub(super) struct Flow<'m, 'a> {
    pub(super) model: &'m Model<'a>,
    is_own: &'m dyn Fn(&str) -> bool,
    /// Global variables that own files alone use; true if a function writes them.
    pub(super) globals: BTreeMap<u32, bool>,
    origins: Vec<Origin>,
    calls: HashMap<Call, Rc<Exit>>,
    /// Findings: file, line and text.
    pub(super) found: BTreeSet<(String, u32, String)>,
    /// Arrays that are taken to be filled: file, line and name.
    pub(super) filled: BTreeSet<(String, u32, String)>,
    steps: usize,
}

/// A function that is being followed.
pub(super) struct Run<'m, 'a> {
    pub(super) id: u32,
    pub(super) function: &'m Function<'a>,
    pub(super) is_own: bool,
    pub(super) depth: usize,
    /// Number of edges into each block.
    entries: Vec<usize>,
    /// Codes of values of other blocks.
    values: HashMap<u32, Codes>,
    pub(super) pointers: HashMap<u32, Pointer>,
    /// Results of paths without `return`.
    pub(super) undefined: HashSet<u32>,
    exit: Exit,
}

/// Values computed since the last branch.
#[derive(Default)]
pub(super) struct Here {
    pub(super) values: HashMap<u32, Codes>,
    pub(super) scalars: HashMap<u32, Scalar>,
}

impl<'m, 'a> Flow<'m, 'a> {
    pub(super) fn new(
        model: &'m Model<'a>,
        is_own: &'m dyn Fn(&str) -> bool,
        keeps: &dyn Fn(&str) -> bool,
    ) -> Flow<'m, 'a> {
        let globals = own_globals(model, &|file| is_own(file) && !keeps(file));
        let (origins, calls, found, filled) = Default::default();
        Flow { model, is_own, globals, origins, calls, found, filled, steps: 0 }
    }

    /// Follows the program from its entry; false if it is too large.
    pub(super) fn follow(&mut self) -> bool {
        let defined = self.globals.keys().map(|global| (*global, self.codes(*global, DEFINED))).collect();
        self.call((self.model.entry, Vec::new(), defined), 0);
        self.steps < MOST_STEPS
    }

    pub(super) fn is_own(&self, line: Line) -> bool {
        (self.is_own)(self.model.file(line))
    }

    /// Codes of a variable whose scalars all have the same one.
    pub(super) fn codes(&self, variable: u32, code: Code) -> Codes {
        vec![code; self.model.size(self.model.kind(variable))]
    }

    /// The code of an origin.
    pub(super) fn code(&mut self, origin: Origin) -> Code {
        let known = self.origins.iter().position(|known| *known == origin);
        let number = known.unwrap_or_else(|| {
            self.origins.push(origin);
            self.origins.len() - 1
        });
        FIRST_ORIGIN + number as Code
    }

    /// Notes a finding in an own file.
    pub(super) fn note(&mut self, line: Line, text: &str) {
        if self.is_own(line) {
            self.found.insert((self.model.file(line).into(), line.1, text.into()));
        }
    }

    /// Notes a computation with a value of these codes.
    pub(super) fn used(&mut self, codes: &[Code], line: Line) {
        let Some(&code) = codes.iter().filter(|code| **code != DEFINED).min() else { return };
        let model = self.model;
        let read =
            |name: &str| format!("`{name}` is read, but not on every path written before; set it where it is declared");
        match code.checked_sub(FIRST_ORIGIN).map(|origin| self.origins[origin as usize]) {
            None => self.note(line, &read("an argument")),
            Some(Origin::Read(at, variable)) => {
                let at = if self.is_own(at) { at } else { line };
                self.note(at, &read(model.name(variable)));
            }
            Some(Origin::Unset(function, parameter)) => {
                let (at, name) = (model.functions[&function].line, model.function_name(function));
                let parameter = model.name(parameter);
                self.note(
                    at,
                    &format!("`{name}` can end with nothing written to `{parameter}`; write it on every path"),
                );
            }
            Some(Origin::Kept(global)) => {
                let name = model.name(global);
                let text = format!(
                    "the global variable `{name}` is read as the last call left it, and slices and rays call in another order; \
                     write it before, or pass it as a parameter"
                );
                self.note(line, &text);
            }
        }
    }

    /// The exit of a call.
    pub(super) fn call(&mut self, call: Call, depth: usize) -> Rc<Exit> {
        if let Some(known) = self.calls.get(&call) {
            return known.clone();
        }
        let Some(function) = self.model.functions.get(&call.0).filter(|_| depth < DEEPEST) else {
            return Rc::new(Some(Default::default()));
        };
        let mut run = Run::new(call.0, function, self.is_own(function.line), depth);
        let mut state = State { variables: call.2.clone(), ..State::default() };
        for (parameter, codes) in function.parameters.iter().zip(&call.1) {
            if self.model.is_pointer(*parameter) {
                drop(state.variables.insert(*parameter, codes.clone()))
            } else {
                drop(run.values.insert(*parameter, codes.clone()))
            }
        }
        // The state at the entry of each block; of a loop also that of its further turns.
        let mut states = BTreeMap::from([((0, false), state)]);
        let mut waiting = BTreeSet::from([(0, false)]);
        while let Some(next) = waiting.pop_first().filter(|_| self.steps < MOST_STEPS) {
            for (from, to, state) in self.block(&mut run, next.0, states[&next].clone()) {
                let key = (to, function.blocks[to].is_loop && to <= from);
                let changed = match states.get_mut(&key) {
                    Some(known) => known.join(&state),
                    None => states.insert(key, state).is_none(),
                };
                if changed {
                    waiting.insert(key);
                }
            }
        }
        let mut exit = run.exit;
        if let Some((state, _)) = exit.as_mut().filter(|_| run.is_own) {
            for (parameter, given) in function.parameters.iter().zip(&call.1) {
                let unset = self.code(Origin::Unset(run.id, *parameter));
                let codes = state.variables.get_mut(parameter).into_iter().flatten().zip(given);
                let left = codes.filter(|(code, given)| [**code, **given] == [UNWRITTEN; 2]);
                left.for_each(|(code, _)| *code = unset);
            }
        }
        let exit = Rc::new(exit);
        self.calls.insert(call, exit.clone());
        exit
    }

    /// Follows a block and those that only it leads to. Returns block, next block and state of each branch.
    fn block(&mut self, run: &mut Run<'m, 'a>, first: usize, mut state: State) -> Vec<(usize, usize, State)> {
        let (mut index, mut here, mut next) = (first, Here::default(), Vec::new());
        let function = run.function;
        let to = |label: u32| function.labels.get(&label).copied();
        'blocks: loop {
            for &(op, words, line) in &function.blocks[index].instructions {
                self.steps += 1;
                match (op, words) {
                    (Op::Branch, &[_, label]) => {
                        let is_alone = |to: usize| run.entries[to] == 1 && !function.blocks[to].is_loop;
                        match to(label) {
                            Some(only) if is_alone(only) => {
                                index = only;
                                continue 'blocks;
                            }
                            other => next.extend(other),
                        }
                    }
                    (Op::BranchConditional, &[_, condition, yes, no, ..]) => {
                        self.used(&run.codes(&here, condition), line);
                        let known = self.scalar(&here, condition).and_then(Scalar::truth);
                        next.extend([(yes, true), (no, false)].into_iter().filter_map(|(label, truth)| {
                            to(label).filter(|_| known.is_none_or(|known| known == truth))
                        }));
                    }
                    (Op::Switch, &[_, selector, ..]) => {
                        self.used(&run.codes(&here, selector), line);
                        next.extend(targets(op, words).into_iter().filter_map(to));
                    }
                    _ if !self.step(run, &mut here, &mut state, (op, words, line)) => break 'blocks,
                    _ => {}
                }
            }
            break;
        }
        for (id, codes) in here.values {
            join(run.values.entry(id).or_default(), &codes);
        }
        next.into_iter().map(|to| (index, to, state.clone())).collect()
    }

    /// The value of a scalar, if it is known.
    pub(super) fn scalar(&self, here: &Here, id: u32) -> Option<Scalar> {
        here.scalars.get(&id).or(self.model.constants.get(&id)).copied()
    }
}

impl<'m, 'a> Run<'m, 'a> {
    fn new(id: u32, function: &'m Function<'a>, is_own: bool, depth: usize) -> Run<'m, 'a> {
        let mut entries = vec![0; function.blocks.len()];
        let ends = function.blocks.iter().filter_map(Block::end);
        for index in ends.flat_map(|(op, words, _)| targets(op, words)).filter_map(|label| function.labels.get(&label))
        {
            entries[*index] += 1;
        }
        let (values, pointers, undefined, exit) = Default::default();
        Run { id, function, is_own, depth, entries, values, pointers, undefined, exit }
    }

    /// Codes of a value.
    pub(super) fn codes(&self, here: &Here, id: u32) -> Codes {
        here.values.get(&id).or(self.values.get(&id)).cloned().unwrap_or_default()
    }

    /// Joins the state at a `return`.
    pub(super) fn leave(&mut self, state: &State, result: Codes) {
        match &mut self.exit {
            Some((known, codes)) => {
                known.join(state);
                join(codes, &result);
            }
            None => self.exit = Some((state.clone(), result)),
        }
    }
}

/// The labels that an instruction branches to.
fn targets(op: Op, words: &[u32]) -> Vec<u32> {
    match (op, words) {
        (Op::Branch, &[_, to]) => vec![to],
        (Op::BranchConditional, &[_, _, yes, no, ..]) => vec![yes, no],
        (Op::Switch, [_, _, default, cases @ ..]) => {
            [*default].into_iter().chain(cases.chunks_exact(2).map(|case| case[1])).collect()
        }
        _ => Vec::new(),
    }
}

/// The global variables that own files alone use; true if a function writes them. The entry function initializes them.
fn own_globals(model: &Model<'_>, is_own: &dyn Fn(&str) -> bool) -> BTreeMap<u32, bool> {
    let (mut own, mut foreign) = (BTreeMap::new(), BTreeSet::new());
    for (id, function) in &model.functions {
        let mut parts = HashMap::new(); // pointers to parts of global variables
        for (op, words, line) in function.blocks.iter().flat_map(|block| &block.instructions) {
            let root = |id: &u32| parts.get(id).copied().or(model.globals.contains(id).then_some(*id));
            let (used, writes) = match (op, *words) {
                (Op::AccessChain | Op::InBoundsAccessChain, [_, _, result, base, ..]) => {
                    let root = root(base);
                    parts.extend(root.map(|root| (*result, root)));
                    (root, false)
                }
                (Op::Load, [_, _, _, from, ..]) => (root(from), false),
                (Op::Store, [_, to, ..]) => (root(to), *id != model.entry),
                _ => (None, false),
            };
            let Some(global) = used else { continue };
            if is_own(model.file(*line)) {
                *own.entry(global).or_default() |= writes;
            } else {
                foreign.insert(global);
            }
        }
    }
    own.retain(|global, _| !foreign.contains(global));
    own
}
