//! Control flow: blocks of lanes run through a program together.
//!
//! Invariant: a lane with decided comparisons takes one path; lanes off the path are masked out. A lane with an undecided
//! comparison takes both branches, and its registers are joined where they meet.

use super::lanes::{Bank, Banks, LANES, Row, each, get, put};
use super::single::Singles;
use super::snapshot::Snapshot;
use crate::code::{Case, Code, Loop, Node, Op, Reg};
use crate::error::ExactError;
use crate::number::{Bool, Integer, Number, Unary};
use crate::texture::Image;

/// Iterations of all loops of a block after which a program counts as endless: 200 times the limit of any device.
const ENDLESS: u64 = 1 << 24;
/// Iterations of one loop, and of all loops of a block, after which a loop without a decided end may give any value.
const UNBOUNDED: [u64; 2] = [1 << 16, 1 << 20];

/// A part of the program with an early exit.
struct Construct<'a, N: Number> {
    kind: ConstructKind,
    written: &'a [Reg],
    /// Lanes that left, and lanes that continue with the next iteration.
    left: u64,
    again: u64,
    exit: Snapshot<N>,
    next: Snapshot<N>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum ConstructKind {
    Loop,
    Switch,
    Scope,
}

/// A program being run, for one block of lanes after another.
pub(crate) struct Machine<'a, N: Number> {
    pub code: &'a Code,
    pub images: &'a [Image<'a>],
    pub arch: pulp::Arch,
    pub banks: Banks<N>,
    frames: Vec<Construct<'a, N>>,
    /// Lanes in use.
    pub block: u64,
    /// Lanes that are or may be discarded.
    killed: u64,
    /// Scalar operations before each instruction.
    work: Vec<u64>,
    /// Scalar operations in active lanes.
    pub operations: u64,
    /// Limit on the iterations of all loops of a lane.
    pub most_turns: Option<u64>,
    /// Iterations of each lane and of the block.
    turns: [u64; LANES],
    all_turns: u64,
    /// Overflows of f32; `None` if results are not rounded to it.
    pub singles: Option<Singles>,
}

impl<'a, N: Number> Machine<'a, N> {
    pub(crate) fn new(code: &'a Code, images: &'a [Image<'a>], uniforms: (Vec<N>, Vec<N::Int>, Vec<N::Bool>)) -> Self {
        let counts = code.registers;
        let banks = Banks {
            floats: Bank::new(counts[0], uniforms.0, N::new(0.0)),
            ints: Bank::new(counts[1], uniforms.1, N::Int::new(0, true)),
            bools: Bank::new(counts[2], uniforms.2, N::Bool::new(false)),
            splits: Vec::new(),
        };
        let mut work = vec![0];
        for instr in &code.instrs {
            work.push(work[work.len() - 1] + u64::from(instr.op != Op::Copy));
        }
        Machine {
            code,
            images,
            arch: pulp::Arch::new(),
            banks,
            frames: Vec::new(),
            block: 0,
            killed: 0,
            work,
            operations: 0,
            most_turns: None,
            turns: [0; LANES],
            all_turns: 0,
            singles: None,
        }
    }

    /// Runs the program. Returns the lanes that reach its end, and those that are or may be discarded.
    pub(crate) fn run(&mut self, block: u64) -> Result<(u64, u64), ExactError> {
        (self.block, self.killed, self.turns, self.all_turns) = (block, 0, [0; LANES], 0);
        let code = self.code;
        let ended = self.nodes(&code.body, block)?;
        Ok((ended, self.killed))
    }

    /// Runs nodes for some lanes. Returns those that reach their end.
    fn nodes(&mut self, nodes: &'a [Node], mut mask: u64) -> Result<u64, ExactError> {
        for node in nodes {
            if mask == 0 {
                break;
            }
            mask = match node {
                Node::Run(start, end) => {
                    match self.singles {
                        None => self.basic_block(*start, *end, mask),
                        Some(_) => self.basic_block_single((*start, *end), mask),
                    }
                    self.operations += u64::from(mask.count_ones()) * (self.work[*end] - self.work[*start]);
                    mask
                }
                Node::If { condition, accept, reject, written, compared } => {
                    let (holds, fails) = self.split(*condition, mask);
                    self.branch((accept, reject), (holds, fails), written, *compared)?
                }
                Node::Loop(node) => self.run_loop(node, mask)?,
                Node::Switch { selector, cases, written } => self.switch(*selector, cases, written, mask)?,
                Node::Scope { body, written } => {
                    self.enter(ConstructKind::Scope, written);
                    let ended = self.nodes(body, mask)?;
                    self.leave(ended)
                }
                Node::Break => self.quit(|kind| kind != ConstructKind::Scope, mask),
                Node::Return => self.quit(|kind| kind == ConstructKind::Scope, mask),
                Node::Continue => {
                    if let Some(frame) = self.frames.iter_mut().rev().find(|frame| frame.kind == ConstructKind::Loop) {
                        frame.again |= mask;
                        if !N::DECIDED {
                            frame.next.add(&self.banks, frame.written, mask);
                        }
                    }
                    0
                }
                Node::Kill => {
                    self.killed |= mask;
                    0
                }
            };
        }
        Ok(mask)
    }

    fn branch(
        &mut self,
        (accept, reject): (&'a [Node], &'a [Node]),
        (holds, fails): (u64, u64),
        written: &'a [Reg],
        compared: Option<[Reg; 2]>,
    ) -> Result<u64, ExactError> {
        let both = holds & fails;
        if both == 0 {
            return Ok(self.nodes(accept, holds)? | self.nodes(reject, fails)?);
        }
        let (mut before, mut after) = (Snapshot::new(), Snapshot::new());
        before.add(&self.banks, written, both);
        let saved = self.narrow(compared, written, both);
        let accepted = self.nodes(accept, holds)?;
        after.add(&self.banks, written, accepted & both);
        before.restore(&mut self.banks, written, both, 0);
        self.widen(&saved, both);
        self.narrow(compared.map(|[a, b]| [b, a]), written, both);
        let rejected = self.nodes(reject, fails)?;
        after.restore(&mut self.banks, written, both, rejected);
        // Lanes that only the rejected branch continues keep its narrowed operands.
        self.widen(&saved, both & accepted);
        Ok(accepted | rejected)
    }

    /// Narrows two numbers in lanes in which the first is at most the second, except those that the branch writes. Returns
    /// the old rows.
    fn narrow(&mut self, compared: Option<[Reg; 2]>, written: &[Reg], lanes: u64) -> Vec<(Reg, Row<N>)> {
        let Some([a, b]) = compared else { return Vec::new() };
        let floats = &mut self.banks.floats;
        let [old_a, old_b] = [a, b].map(|reg| floats.rows.read(reg).row());
        let free = |reg: Reg| !reg.uniform && !written.contains(&reg);
        if free(a) {
            let row = floats.row(a);
            each(lanes, |lane| put(row, lane, get::<N>(&old_a, lane).at_most(get(&old_b, lane))));
        }
        if free(b) {
            let row = floats.row(b);
            each(lanes, |lane| {
                put(row, lane, {
                    let [a, b] = [&old_a, &old_b].map(|row| get::<N>(row, lane).unary(Unary::Negate));
                    b.at_most(a).unary(Unary::Negate)
                })
            });
        }
        [(a, old_a), (b, old_b)].into_iter().filter(|(reg, _)| free(*reg)).collect()
    }

    /// Restores narrowed numbers.
    fn widen(&mut self, saved: &[(Reg, Row<N>)], lanes: u64) {
        for (reg, old) in saved {
            let row = self.banks.floats.row(*reg);
            each(lanes, |lane| put(row, lane, get::<N>(old, lane)));
        }
    }

    fn enter(&mut self, kind: ConstructKind, written: &'a [Reg]) {
        self.frames.push(Construct { kind, written, left: 0, again: 0, exit: Snapshot::new(), next: Snapshot::new() });
    }

    /// Leaves the innermost frame, whose end some lanes reached. Returns the lanes that continue behind it.
    fn leave(&mut self, ended: u64) -> u64 {
        let Some(frame) = self.frames.pop() else { return ended };
        if !N::DECIDED {
            frame.exit.restore(&mut self.banks, frame.written, frame.left, ended);
        }
        ended | frame.left
    }

    /// Exits the innermost frame of a kind early.
    fn quit(&mut self, is: impl Fn(ConstructKind) -> bool, mask: u64) -> u64 {
        if let Some(frame) = self.frames.iter_mut().rev().find(|frame| is(frame.kind)) {
            frame.left |= mask;
            if !N::DECIDED {
                frame.exit.add(&self.banks, frame.written, mask);
            }
        }
        0
    }

    fn run_loop(&mut self, node: &'a Loop, mask: u64) -> Result<u64, ExactError> {
        self.enter(ConstructKind::Loop, &node.written);
        let index = self.frames.len() - 1;
        let (mut live, mut turn) = (mask, 0u64);
        let mut seen = Snapshot::new();
        while live != 0 {
            turn += 1;
            self.all_turns += 1;
            if N::DECIDED && self.all_turns > ENDLESS {
                return Err(ExactError::Endless { turns: ENDLESS, place: node.place.0.clone() });
            }
            if let Some(turns) = self.most_turns {
                let (made, mut most) = (&mut self.turns, 0);
                each(live, |lane| {
                    made[lane] += 1;
                    most = most.max(made[lane]);
                });
                if most > turns {
                    return Err(ExactError::Endless { turns, place: node.place.0.clone() });
                }
            }
            if !N::DECIDED {
                live = self.fixpoint(node, live, turn, &mut seen);
            }
            let ended = self.nodes(&node.body, live)?;
            let frame = &mut self.frames[index];
            let again = std::mem::take(&mut frame.again);
            if !N::DECIDED {
                let next = std::mem::replace(&mut frame.next, Snapshot::new());
                next.restore(&mut self.banks, &node.written, again, ended);
            }
            live = self.nodes(&node.continuing, ended | again)?;
            if let Some(condition) = node.break_if {
                let (holds, fails) = self.split(condition, live);
                self.quit(|kind| kind != ConstructKind::Scope, holds);
                live = fails;
            }
        }
        Ok(self.leave(0))
    }

    /// The lanes that need another iteration: those with new values. A loop without an end may give any value.
    fn fixpoint(&mut self, node: &'a Loop, live: u64, turn: u64, seen: &mut Snapshot<N>) -> u64 {
        let old = seen.covers(&self.banks, &node.written, live);
        let left = self.frames.last().map_or(0, |frame| frame.left);
        // Fixpoint: further iterations add no exits.
        let done = old & left;
        let [most, most_of_all] = UNBOUNDED;
        let lost = if turn > most || self.all_turns > most_of_all { live & !done } else { old & !left };
        if lost != 0 {
            self.banks.forget(&node.written, lost);
            self.quit(|kind| kind == ConstructKind::Loop, lost);
            if node.returns {
                self.quit(|kind| kind == ConstructKind::Scope, lost);
            }
            if node.kills {
                self.killed |= lost;
            }
        }
        let live = live & !done & !lost;
        if turn.is_power_of_two() {
            *seen = Snapshot::new();
            seen.add(&self.banks, &node.written, live);
        }
        live
    }

    fn switch(&mut self, selector: Reg, cases: &'a [Case], written: &'a [Reg], mask: u64) -> Result<u64, ExactError> {
        let row = self.banks.ints.rows.read(selector);
        let chosen: Vec<Vec<N::Int>> =
            cases.iter().map(|case| case.values.iter().map(|value| N::Int::new(*value, true)).collect()).collect();
        let mut enters = vec![0u64; cases.len()];
        each(mask, |lane| {
            let value = row.at(lane).bitcast(true);
            // Whether the value may differ from all cases.
            let mut other = true;
            for (case, values) in chosen.iter().enumerate() {
                for same in values.iter().map(|number| value.equal(*number)) {
                    enters[case] |= u64::from(same.may_hold()) << lane;
                    other &= same.may_fail();
                }
            }
            if let Some(default) = cases.iter().position(|case| case.default).filter(|_| other) {
                enters[default] |= 1 << lane;
            }
        });
        let entered = enters.iter().fold(0, |all, lanes| all | lanes);
        let past = if cases.iter().any(|case| case.default) { 0 } else { mask & !entered };
        self.enter(ConstructKind::Switch, written);
        let mut before = Snapshot::new();
        if !N::DECIDED {
            before.add(&self.banks, written, mask);
            self.quit(|kind| kind == ConstructKind::Switch, past);
        }
        let mut falling = 0;
        for (case, lanes) in cases.iter().zip(enters) {
            if !N::DECIDED {
                before.restore(&mut self.banks, written, lanes, falling);
            }
            let ended = self.nodes(&case.body, lanes | falling)?;
            falling = if case.falls { ended } else { 0 };
            if !case.falls {
                self.quit(|kind| kind == ConstructKind::Switch, ended);
            }
        }
        if N::DECIDED {
            return Ok(self.leave(falling | past));
        }
        Ok(self.leave(falling))
    }
}
