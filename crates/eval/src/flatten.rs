//! Makes straight code of short branches: both sides are computed, and of each variable the side that counts is taken.
//!
//! Role: a compiler writes `bit ? -x : x` as a branch, and a sum of noise has hundreds of them. Lanes that part and meet cost
//! more than the few instructions of both sides. Invariant: no value changes, in no kind of numbers. What a branch makes
//! narrower by its comparison, what passes integers and what is long stays a branch.

use super::code::{At, Code, Instr, Node, Op, Reg};
use super::lower::Class;
use super::number::{IntBinary, Unary};
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

/// Instructions of both sides together. More: lanes compute what none of them needs. Fewer: more branches.
const MOST: usize = 16;

/// Straightens the branches of a program.
pub(super) fn flatten(code: &mut Code, classes: &mut [Vec<Class>; 3]) {
    let before = std::mem::take(&mut code.instrs);
    let comparisons = comparisons(&before);
    let mut flat = Flat { before, instrs: Vec::new(), classes, comparisons };
    code.body = flat.nodes(std::mem::take(&mut code.body));
    code.instrs = flat.instrs;
}

/// The registers that hold whether one number is less than another, or may.
fn comparisons(instrs: &[Instr]) -> HashSet<Reg> {
    let mut copies: HashMap<Reg, Vec<Reg>> = HashMap::new();
    let mut rest = Vec::new();
    for instr in instrs {
        match instr.op {
            Op::Copy => copies.entry(instr.sources[0]).or_default().push(instr.dst),
            Op::Less | Op::LessEqual => rest.push(instr.dst),
            _ => {}
        }
    }
    let mut found = HashSet::new();
    while let Some(reg) = rest.pop() {
        if found.insert(reg) {
            rest.extend(copies.get(&reg).into_iter().flatten());
        }
    }
    found
}

struct Flat<'a> {
    before: Vec<Instr>,
    instrs: Vec<Instr>,
    classes: &'a mut [Vec<Class>; 3],
    comparisons: HashSet<Reg>,
}

impl Flat<'_> {
    fn nodes(&mut self, nodes: Vec<Node>) -> Vec<Node> {
        let mut found = Vec::new();
        for node in nodes {
            let start = self.instrs.len();
            match node {
                Node::Run(from, to) => {
                    let needed = self.before[from..to].iter().filter(|instr| instr.op != Op::Nop);
                    self.instrs.extend(needed);
                    add_run(&mut found, start, self.instrs.len());
                }
                Node::If { condition, accept, reject, written, compared } => {
                    let accept = self.nodes(accept);
                    let middle = self.instrs.len();
                    let reject = self.nodes(reject);
                    if self.is_short(condition, start, [&accept, &reject]) {
                        let mut accepted = self.instrs.split_off(start);
                        let rejected = accepted.split_off(middle - start);
                        self.choose(condition, [accepted, rejected]);
                        add_run(&mut found, start, self.instrs.len());
                    } else {
                        found.push(Node::If { condition, accept, reject, written, compared });
                    }
                }
                Node::Loop(mut node) => {
                    node.body = self.nodes(node.body);
                    node.continuing = self.nodes(node.continuing);
                    found.push(Node::Loop(node));
                }
                Node::Switch { selector, mut cases, written } => {
                    for case in &mut cases {
                        case.body = self.nodes(std::mem::take(&mut case.body));
                    }
                    found.push(Node::Switch { selector, cases, written });
                }
                Node::Scope { body, written } => found.push(Node::Scope { body: self.nodes(body), written }),
                Node::Break | Node::Continue | Node::Return | Node::Kill => found.push(node),
            }
        }
        found
    }

    /// Whether both sides of a branch, which are the last instructions, are straight, and not worth a branch.
    fn is_short(&self, condition: Reg, start: usize, sides: [&[Node]; 2]) -> bool {
        let instrs = &self.instrs[start..];
        !condition.uniform
            && !self.comparisons.contains(&condition)
            && sides.iter().all(|side| matches!(side, [] | [Node::Run(..)]))
            && instrs.len() <= MOST
            && instrs.iter().all(|instr| is_cheap(instr.op) && instr.dst != condition)
    }

    /// Both sides of a branch, one after the other, and then of each variable that they write what it becomes.
    fn choose(&mut self, condition: Reg, sides: [Vec<Instr>; 2]) {
        let values = sides.map(|side| self.computed(side));
        let written: BTreeSet<Reg> = values.iter().flat_map(BTreeMap::keys).copied().collect();
        for dst in written {
            let [a, b] = values.each_ref().map(|values| values.get(&dst).copied().unwrap_or(dst));
            let sources = [condition, a, b];
            let (op, at) = (Op::Select, At::default());
            self.instrs.push(Instr { op, signed: false, masked: true, dst, sources, count: 3, table: 0, at });
        }
    }

    /// Computes one side without writing a variable; the values that its variables would have.
    fn computed(&mut self, side: Vec<Instr>) -> BTreeMap<Reg, Reg> {
        let mut values: BTreeMap<Reg, Reg> = BTreeMap::new();
        for mut instr in side {
            for source in &mut instr.sources {
                *source = values.get(source).copied().unwrap_or(*source);
            }
            if instr.masked {
                let [value, ..] = instr.sources;
                if instr.op == Op::Copy && self.is_fixed(value) {
                    values.insert(instr.dst, value);
                    continue;
                }
                let own = self.temporary(instr.dst);
                values.insert(instr.dst, own);
                (instr.dst, instr.masked) = (own, false);
            }
            self.instrs.push(instr);
        }
        values
    }

    /// Whether a register keeps its value.
    fn is_fixed(&self, reg: Reg) -> bool {
        reg.uniform || self.classes[reg.file as usize][reg.index as usize] == Class::Temporary
    }

    /// A register like that of a variable.
    fn temporary(&mut self, like: Reg) -> Reg {
        let classes = &mut self.classes[like.file as usize];
        classes.push(Class::Temporary);
        Reg { index: classes.len() as u32 - 1, ..like }
    }
}

/// Adds straight code behind nodes.
fn add_run(nodes: &mut Vec<Node>, start: usize, end: usize) {
    match nodes.last_mut() {
        Some(Node::Run(_, last)) => *last = end,
        _ if start < end => nodes.push(Node::Run(start, end)),
        _ => {}
    }
}

/// Whether an operation takes no longer than lanes take to part and meet, and says nothing of where integers are passed.
fn is_cheap(op: Op) -> bool {
    match op {
        Op::Unary(function) => {
            matches!(
                function,
                Unary::Negate | Unary::Abs | Unary::Sign | Unary::Saturate | Unary::Square | Unary::Hermite
            )
        }
        Op::Int(function) => !matches!(function, IntBinary::Div | IntBinary::Rem),
        Op::Copy | Op::Add | Op::Sub | Op::Mul | Op::Min | Op::Max | Op::MulAdd | Op::Mix => true,
        Op::Less | Op::LessEqual | Op::Equal | Op::IntLess | Op::IntEqual => true,
        Op::ToInt | Op::FromInt | Op::Reread | Op::Select | Op::And | Op::Or | Op::Not | Op::Same => true,
        _ => false,
    }
}
