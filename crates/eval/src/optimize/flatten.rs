//! If-conversion: computes both sides of a short branch and selects the results.
//!
//! Role: compilers write `bit ? -x : x` as a branch, of which a sum of noise has hundreds. Diverging costs more than the few
//! instructions of both sides. Invariant: no value changes in any number type. Branches stay that are long, that narrow the
//! operands of a comparison, or that contain crossings of integers.

use crate::code::{Code, Instr, Node, Op, Reg};
use crate::lower::function::Class;
use crate::number::{Binary, Comparison, IntBinary, Unary};
use std::collections::{BTreeMap, BTreeSet, HashMap, HashSet};

/// Most instructions of both sides together. Higher: unneeded instructions. Lower: more branches.
const MAX_INSTRUCTIONS: usize = 16;

/// Converts the short branches of a program.
pub(crate) fn flatten(code: &mut Code, classes: &mut [Vec<Class>; 3]) {
    let before = std::mem::take(&mut code.instrs);
    let comparisons = comparisons(&before);
    let mut flat = Flatten { before, instrs: Vec::new(), classes, comparisons };
    code.body = flat.nodes(std::mem::take(&mut code.body));
    code.instrs = flat.instrs;
}

/// The registers that may hold the result of a comparison of floats.
fn comparisons(instrs: &[Instr]) -> HashSet<Reg> {
    let mut copies: HashMap<Reg, Vec<Reg>> = HashMap::new();
    let mut rest = Vec::new();
    for instr in instrs {
        match instr.op {
            Op::Copy => copies.entry(instr.sources[0]).or_default().push(instr.dst),
            Op::Compare(Comparison::Less | Comparison::LessEqual) => rest.push(instr.dst),
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

struct Flatten<'a> {
    before: Vec<Instr>,
    instrs: Vec<Instr>,
    classes: &'a mut [Vec<Class>; 3],
    comparisons: HashSet<Reg>,
}

impl Flatten<'_> {
    fn nodes(&mut self, nodes: Vec<Node>) -> Vec<Node> {
        let mut found = Vec::new();
        for node in nodes {
            let start = self.instrs.len();
            match node {
                Node::Run(from, to) => {
                    let needed = self.before[from..to].iter().filter(|instr| instr.op != Op::Nop);
                    self.instrs.extend(needed);
                    add_block(&mut found, start, self.instrs.len());
                }
                Node::If { condition, accept, reject, written, compared } => {
                    let accept = self.nodes(accept);
                    let middle = self.instrs.len();
                    let reject = self.nodes(reject);
                    if self.is_short(condition, start, [&accept, &reject]) {
                        let mut accepted = self.instrs.split_off(start);
                        let rejected = accepted.split_off(middle - start);
                        self.select(condition, [accepted, rejected]);
                        add_block(&mut found, start, self.instrs.len());
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

    /// Whether both sides of a branch, the last instructions so far, are short basic blocks.
    fn is_short(&self, condition: Reg, start: usize, sides: [&[Node]; 2]) -> bool {
        let instrs = &self.instrs[start..];
        !condition.uniform
            && !self.comparisons.contains(&condition)
            && sides.iter().all(|side| matches!(side, [] | [Node::Run(..)]))
            && instrs.len() <= MAX_INSTRUCTIONS
            && instrs.iter().all(|instr| is_cheap(instr.op) && instr.dst != condition)
    }

    /// Emits both sides of a branch, then a select for each variable that they write.
    fn select(&mut self, condition: Reg, sides: [Vec<Instr>; 2]) {
        let values = sides.map(|side| self.computed(side));
        let written: BTreeSet<Reg> = values.iter().flat_map(BTreeMap::keys).copied().collect();
        for dst in written {
            let [a, b] = values.each_ref().map(|values| values.get(&dst).copied().unwrap_or(dst));
            self.instrs.push(Instr { masked: true, ..Instr::new(Op::Select, dst, &[condition, a, b]) });
        }
    }

    /// Emits one side without writes to variables. Returns their values at its end.
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

    /// Whether a register never changes.
    fn is_fixed(&self, reg: Reg) -> bool {
        reg.uniform || self.classes[reg.file as usize][reg.index as usize] == Class::Temporary
    }

    /// A new temporary in the file of a register.
    fn temporary(&mut self, like: Reg) -> Reg {
        let classes = &mut self.classes[like.file as usize];
        classes.push(Class::Temporary);
        Reg { index: classes.len() as u32 - 1, ..like }
    }
}

/// Appends a basic block to nodes.
fn add_block(nodes: &mut Vec<Node>, start: usize, end: usize) {
    match nodes.last_mut() {
        Some(Node::Run(_, last)) => *last = end,
        _ if start < end => nodes.push(Node::Run(start, end)),
        _ => {}
    }
}

/// Whether an operation is faster than divergence and crosses no integers.
fn is_cheap(op: Op) -> bool {
    match op {
        Op::Unary(function) => {
            matches!(
                function,
                Unary::Negate | Unary::Abs | Unary::Sign | Unary::Saturate | Unary::Square | Unary::Hermite
            )
        }
        Op::Int(function) => !matches!(function, IntBinary::Div | IntBinary::Rem),
        Op::Binary(function) => {
            !matches!(function, Binary::Div | Binary::Unit | Binary::Pow | Binary::Atan2 | Binary::Rem)
        }
        Op::Copy | Op::MulAdd | Op::Mix | Op::Compare(_) | Op::IntLess | Op::IntEqual => true,
        Op::ToInt | Op::FromInt | Op::Bitcast | Op::Select | Op::And | Op::Or | Op::Not | Op::BoolEqual => true,
        _ => false,
    }
}
