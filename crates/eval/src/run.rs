//! Control flow: blocks of lanes go through a program together.
//!
//! Invariant: a lane of a number type whose comparisons are decided goes one way; the lanes that do not go it are masked
//! out. A lane whose comparison is not decided goes both ways, and where they meet its registers hold what is either.

use super::ExactError;
use super::code::{Case, Code, File, Instr, Loop, Node, Op, Reg};
use super::lanes::{Bank, Banks, LANES, Operand, Row, each, get, put};
use super::number::{GROUP, Integer, Number, Packed, Truth};
use super::single::Singles;
use super::state::State;
use super::texture::Image;

/// Turns of all loops of a block of lanes after which a program does not end: 200 times as many as any device makes.
const ENDLESS: u64 = 1 << 24;
/// Turns of a loop after which nothing is known about what it gives, where it is not decided how many there are; and of all
/// loops of a block of lanes.
const UNBOUNDED: [u64; 2] = [1 << 16, 1 << 20];

/// A part of the program that can be left early.
struct Construct<'a, N: Number> {
    kind: Kind,
    written: &'a [Reg],
    /// Lanes that left it, and lanes that go on with the next turn.
    left: u64,
    again: u64,
    exit: State<N>,
    next: State<N>,
}

#[derive(Clone, Copy, PartialEq, Eq)]
enum Kind {
    Loop,
    Switch,
    Scope,
}

/// Instructions one after the other, for the lanes of a mask.
struct Straight<'a, 'b, N: Number> {
    banks: &'b mut Banks<N>,
    instrs: &'a [Instr],
    code: &'a Code,
    images: &'a [Image<'a>],
    mask: u64,
    whole: u64,
}

impl<N: Number> pulp::NullaryFnOnce for Straight<'_, '_, N> {
    type Output = ();

    #[inline(always)] // into code for the vectors of this processor
    fn call(self) {
        for instr in self.instrs {
            self.banks.run(instr, self.code, self.images, self.mask, self.whole);
        }
    }
}

/// The lanes in which a truth may hold, and those in which it may fail.
struct Answers<'a, T: Packed>(&'a Row<T>);

impl<T: Truth> pulp::NullaryFnOnce for Answers<'_, T> {
    type Output = (u64, u64);

    #[inline(always)] // as above
    fn call(self) -> (u64, u64) {
        let (mut holds, mut fails) = (0, 0);
        for group in self.0.iter().rev() {
            let (mut hold, mut fail) = (0, 0);
            for place in 0..GROUP {
                let truth = T::get(group, place);
                hold |= u64::from(truth.may_hold()) << place;
                fail |= u64::from(truth.may_fail()) << place;
            }
            (holds, fails) = (holds << GROUP | hold, fails << GROUP | fail);
        }
        (holds, fails)
    }
}

/// A program in work, for one block of lanes after another.
pub(super) struct Machine<'a, N: Number> {
    code: &'a Code,
    images: &'a [Image<'a>],
    /// The widest vectors that this processor has.
    arch: pulp::Arch,
    pub(super) banks: Banks<N>,
    frames: Vec<Construct<'a, N>>,
    whole: u64,
    /// Lanes that are discarded, or may be.
    killed: u64,
    /// Scalar operations up to each instruction.
    work: Vec<u64>,
    /// Scalar operations in active lanes.
    pub(super) operations: u64,
    /// How many turns all the loops of a lane may make together, where they are counted.
    pub(super) most_turns: Option<u64>,
    turns: [u64; LANES],
    /// Turns of all loops in this run.
    all_turns: u64,
    /// Where results are rounded to f32: what is beyond it.
    pub(super) singles: Option<Singles>,
}

impl<'a, N: Number> Machine<'a, N> {
    pub(super) fn new(code: &'a Code, images: &'a [Image<'a>], ones: (Vec<N>, Vec<N::Int>, Vec<N::Truth>)) -> Self {
        let counts = code.registers;
        let banks = Banks {
            floats: Bank::new(counts[0], ones.0, N::new(0.0)),
            ints: Bank::new(counts[1], ones.1, N::Int::new(0, true)),
            truths: Bank::new(counts[2], ones.2, N::Truth::new(false)),
            cases: Vec::new(),
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
            whole: 0,
            killed: 0,
            work,
            operations: 0,
            most_turns: None,
            turns: [0; LANES],
            all_turns: 0,
            singles: None,
        }
    }

    /// Runs the program; the lanes that come to its end, and those that are discarded or may be.
    pub(super) fn run(&mut self, whole: u64) -> Result<(u64, u64), ExactError> {
        (self.whole, self.killed, self.turns, self.all_turns) = (whole, 0, [0; LANES], 0);
        let code = self.code;
        let ended = self.block(&code.body, whole)?;
        Ok((ended, self.killed))
    }

    /// Runs instructions one after the other for some lanes.
    fn run_straight(&mut self, start: usize, end: usize, mask: u64) {
        let (banks, code, images) = (&mut self.banks, self.code, self.images);
        let instrs = &code.instrs[start..end];
        self.arch.dispatch(Straight { banks, instrs, code, images, mask, whole: self.whole });
    }

    /// Runs instructions one after the other, each with a result of f32.
    fn run_single(&mut self, instrs: (usize, usize), mask: u64) {
        for index in instrs.0..instrs.1 {
            let instr = self.code.instrs[index];
            let has_result = instr.single() && instr.dst.file == File::Float && instr.op != Op::Copy;
            let operands = has_result.then(|| self.operands(&instr));
            self.run_straight(index, index + 1, mask);
            let (Some(operands), Some(singles)) = (operands, &mut self.singles) else { continue };
            let row = self.banks.floats.row(instr.dst);
            each(mask, |lane| {
                let operands = operands.each_ref().map(|row| row.as_ref().map(|row| get::<N>(row, lane).as_f64()));
                let operands = operands.map(|operand| operand.unwrap_or_default());
                let Some(held) = singles.held(&instr, operands, get::<N>(row, lane).as_f64(), lane) else { return };
                put(row, lane, N::new(held));
            });
        }
    }

    /// What the instruction reads of floats.
    fn operands(&self, instr: &Instr) -> [Option<Row<N>>; 3] {
        [0, 1, 2].map(|source| {
            let reg = instr.sources[source];
            let is_read = source < usize::from(instr.count) && reg.file == File::Float;
            is_read.then(|| self.banks.floats.rows.read(reg).row())
        })
    }

    /// Runs nodes for some lanes; those that come to their end.
    fn block(&mut self, nodes: &'a [Node], mut mask: u64) -> Result<u64, ExactError> {
        for node in nodes {
            if mask == 0 {
                break;
            }
            mask = match node {
                Node::Run(start, end) => {
                    match self.singles {
                        None => self.run_straight(*start, *end, mask),
                        Some(_) => self.run_single((*start, *end), mask),
                    }
                    self.operations += u64::from(mask.count_ones()) * (self.work[*end] - self.work[*start]);
                    mask
                }
                Node::If { condition, accept, reject, written, compared } => {
                    let (holds, fails) = self.split(*condition, mask);
                    self.branch((accept, reject), (holds, fails), written, *compared)?
                }
                Node::Loop(node) => self.turns(node, mask)?,
                Node::Switch { selector, cases, written } => self.switch(*selector, cases, written, mask)?,
                Node::Scope { body, written } => {
                    self.enter(Kind::Scope, written);
                    let ended = self.block(body, mask)?;
                    self.leave(ended)
                }
                Node::Break => self.quit(|kind| kind != Kind::Scope, mask),
                Node::Return => self.quit(|kind| kind == Kind::Scope, mask),
                Node::Continue => {
                    if let Some(frame) = self.frames.iter_mut().rev().find(|frame| frame.kind == Kind::Loop) {
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

    /// The lanes in which a condition may hold, and those in which it may fail.
    fn split(&self, condition: Reg, mask: u64) -> (u64, u64) {
        match self.banks.truths.rows.read(condition) {
            Operand::One(truth) => (if truth.may_hold() { mask } else { 0 }, if truth.may_fail() { mask } else { 0 }),
            Operand::Lanes(row) => {
                let (holds, fails) = self.arch.dispatch(Answers::<N::Truth>(row));
                (holds & mask, fails & mask)
            }
        }
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
            return Ok(self.block(accept, holds)? | self.block(reject, fails)?);
        }
        let (mut before, mut after) = (State::new(), State::new());
        before.add(&self.banks, written, both);
        let held = self.narrow(compared, written, both);
        let accepted = self.block(accept, holds)?;
        after.add(&self.banks, written, accepted & both);
        before.take(&mut self.banks, written, both, 0);
        self.widen(&held, both);
        self.narrow(compared.map(|[a, b]| [b, a]), written, both);
        let rejected = self.block(reject, fails)?;
        after.take(&mut self.banks, written, both, rejected);
        // Where only the rejected come on, what was compared stays as narrow.
        self.widen(&held, both & accepted);
        Ok(accepted | rejected)
    }

    /// Makes two numbers narrower, in lanes in which the first is at most the second; what they were. Numbers that a
    /// branch writes are left alone.
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
            each(lanes, |lane| put(row, lane, get::<N>(&old_b, lane).at_least(get(&old_a, lane))));
        }
        [(a, old_a), (b, old_b)].into_iter().filter(|(reg, _)| free(*reg)).collect()
    }

    /// Makes numbers what they were.
    fn widen(&mut self, held: &[(Reg, Row<N>)], lanes: u64) {
        for (reg, old) in held {
            let row = self.banks.floats.row(*reg);
            each(lanes, |lane| put(row, lane, get::<N>(old, lane)));
        }
    }

    fn enter(&mut self, kind: Kind, written: &'a [Reg]) {
        self.frames.push(Construct { kind, written, left: 0, again: 0, exit: State::new(), next: State::new() });
    }

    /// Ends a frame, to whose end some lanes came; the lanes that go on behind it.
    fn leave(&mut self, ended: u64) -> u64 {
        let Some(frame) = self.frames.pop() else { return ended };
        if !N::DECIDED {
            frame.exit.take(&mut self.banks, frame.written, frame.left, ended);
        }
        ended | frame.left
    }

    /// Lanes leave the innermost frame of a kind.
    fn quit(&mut self, is: impl Fn(Kind) -> bool, mask: u64) -> u64 {
        if let Some(frame) = self.frames.iter_mut().rev().find(|frame| is(frame.kind)) {
            frame.left |= mask;
            if !N::DECIDED {
                frame.exit.add(&self.banks, frame.written, mask);
            }
        }
        0
    }

    fn turns(&mut self, node: &'a Loop, mask: u64) -> Result<u64, ExactError> {
        self.enter(Kind::Loop, &node.written);
        let index = self.frames.len() - 1;
        let (mut live, mut turn) = (mask, 0u64);
        let mut seen = State::new();
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
                live = self.bound(node, live, turn, &mut seen);
            }
            let ended = self.block(&node.body, live)?;
            let frame = &mut self.frames[index];
            let again = std::mem::take(&mut frame.again);
            if !N::DECIDED {
                let next = std::mem::replace(&mut frame.next, State::new());
                next.take(&mut self.banks, &node.written, again, ended);
            }
            live = self.block(&node.continuing, ended | again)?;
            if let Some(condition) = node.break_if {
                let (holds, fails) = self.split(condition, live);
                self.quit(|kind| kind != Kind::Scope, holds);
                live = fails;
            }
        }
        Ok(self.leave(0))
    }

    /// The lanes that need another turn: those in which something is new. What never ends may give anything.
    fn bound(&mut self, node: &'a Loop, live: u64, turn: u64, seen: &mut State<N>) -> u64 {
        let old = seen.covers(&self.banks, &node.written, live);
        let left = self.frames.last().map_or(0, |frame| frame.left);
        // A turn from here on gives nothing that an earlier one did not: the ways out that it found are all.
        let done = old & left;
        let [most, most_of_all] = UNBOUNDED;
        let lost = if turn > most || self.all_turns > most_of_all { live & !done } else { old & !left };
        if lost != 0 {
            self.banks.forget(&node.written, lost);
            self.quit(|kind| kind == Kind::Loop, lost);
            if node.returns {
                self.quit(|kind| kind == Kind::Scope, lost);
            }
            if node.kills {
                self.killed |= lost;
            }
        }
        let live = live & !done & !lost;
        if turn.is_power_of_two() {
            *seen = State::new();
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
            let value = row.at(lane).reread(true);
            // Whether the value may be none of the cases'.
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
        self.enter(Kind::Switch, written);
        let mut before = State::new();
        if !N::DECIDED {
            before.add(&self.banks, written, mask);
            self.quit(|kind| kind == Kind::Switch, past);
        }
        let mut falling = 0;
        for (case, lanes) in cases.iter().zip(enters) {
            if !N::DECIDED {
                before.take(&mut self.banks, written, lanes, falling);
            }
            let ended = self.block(&case.body, lanes | falling)?;
            falling = if case.falls { ended } else { 0 };
            if !case.falls {
                self.quit(|kind| kind == Kind::Switch, ended);
            }
        }
        if N::DECIDED {
            return Ok(self.leave(falling | past));
        }
        Ok(self.leave(falling))
    }
}
