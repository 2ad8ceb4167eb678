//! Dead-code elimination, copy propagation and multiply-add fusion.

use crate::code::{Code, Instr, Node, Op, Reg};
use crate::lower::function::Class;
use crate::number::Binary;
use std::collections::{BTreeSet, HashMap, HashSet};

/// Instructions that read and write each register; a condition counts as a read by the next instruction.
#[derive(Default)]
pub(crate) struct Occurrences {
    pub reads: HashMap<Reg, Vec<usize>>,
    pub writes: HashMap<Reg, Vec<usize>>,
    /// Ranges of instructions of the loops.
    pub loops: Vec<(usize, usize)>,
}

impl Occurrences {
    pub(crate) fn of(code: &Code) -> Occurrences {
        let mut found = Occurrences::default();
        for (at, instr) in code.instrs.iter().enumerate() {
            code.reads(instr, |reg| found.reads.entry(reg).or_default().push(at));
            code.writes(instr, |reg| found.writes.entry(reg).or_default().push(at));
        }
        found.walk(&code.body, 0);
        for reg in code.outputs.iter().flat_map(|(_, regs)| regs) {
            found.reads.entry(*reg).or_default().push(code.instrs.len());
        }
        found.reads.values_mut().for_each(|reads| reads.sort_unstable());
        found
    }

    /// Adds the loops and conditions of nodes that start at an instruction. Returns their end.
    fn walk(&mut self, nodes: &[Node], mut at: usize) -> usize {
        for node in nodes {
            match node {
                Node::Run(_, end) => at = *end,
                Node::If { condition, accept, reject, .. } => {
                    self.reads.entry(*condition).or_default().push(at);
                    at = self.walk(accept, at);
                    at = self.walk(reject, at);
                }
                Node::Loop(node) => {
                    let start = at;
                    at = self.walk(&node.body, at);
                    at = self.walk(&node.continuing, at);
                    if let Some(condition) = node.break_if {
                        self.reads.entry(condition).or_default().push(at);
                    }
                    self.loops.push((start, at));
                }
                Node::Switch { selector, cases, .. } => {
                    self.reads.entry(*selector).or_default().push(at);
                    for case in cases {
                        at = self.walk(&case.body, at);
                    }
                }
                Node::Scope { body, .. } => at = self.walk(body, at),
                Node::Break | Node::Continue | Node::Return | Node::Kill => {}
            }
        }
        at
    }

    /// The last instruction that needs a temporary: its last read, or the end of a loop around a read but not `defined`.
    pub(crate) fn last_use(&self, reg: Reg, defined: usize) -> usize {
        let reads = self.reads.get(&reg).map(Vec::as_slice).unwrap_or_default();
        let last = |read: &usize| {
            let around = self
                .loops
                .iter()
                .filter(|(start, end)| (*start..*end).contains(read) && !(*start..*end).contains(&defined));
            around.map(|(_, end)| *end).fold(*read, usize::max)
        };
        reads.iter().map(last).max().unwrap_or(defined)
    }
}

/// Runs all passes.
pub(crate) fn tidy(code: &mut Code, classes: &[Vec<Class>; 3]) {
    drop_unread(code);
    propagate_copies(code, classes);
    let blocks = basic_blocks(&code.body);
    fuse_stores(code, classes, &blocks);
    fuse_sums(code, classes, &blocks);
    drop_unread(code);
    drop_images(code);
    drop_uniforms(code);
    drop_nops(code);
}

/// Removes unread uniform registers.
fn drop_uniforms(code: &mut Code) {
    let mut read: HashSet<Reg> = Occurrences::of(code).reads.into_keys().collect();
    let mut prelude = std::mem::take(&mut code.prelude);
    prelude.reverse();
    prelude.retain(|instr| {
        let needed = read.contains(&instr.dst);
        if needed {
            code.reads(instr, |reg| {
                read.insert(reg);
            });
        }
        needed
    });
    prelude.reverse();
    code.prelude = prelude;
    code.sources.retain(|(reg, _)| read.contains(reg));
}

/// Removes images without lookups.
fn drop_images(code: &mut Code) {
    let looks_up = |instr: &&Instr| matches!(instr.op, Op::Sample | Op::Fetch);
    let read: BTreeSet<usize> =
        code.instrs.iter().filter(looks_up).map(|instr| code.lookups[instr.table as usize].image).collect();
    code.images = read.iter().map(|&image| code.images[image]).collect();
    for lookup in &mut code.lookups {
        lookup.image = read.range(..lookup.image).count();
    }
}

/// Removes instructions whose results nothing reads, transitively.
pub(crate) fn drop_unread(code: &mut Code) {
    let found = Occurrences::of(code);
    let mut reads: HashMap<Reg, usize> = found.reads.iter().map(|(reg, reads)| (*reg, reads.len())).collect();
    let mut unread: Vec<Reg> = found.writes.keys().copied().filter(|reg| !reads.contains_key(reg)).collect();
    while let Some(reg) = unread.pop() {
        for &at in found.writes.get(&reg).into_iter().flatten() {
            let instr = code.instrs[at];
            if matches!(instr.op, Op::Sample | Op::Fetch) {
                let channels = &mut code.lookups[instr.table as usize].channels;
                channels.iter_mut().filter(|channel| **channel == Some(reg)).for_each(|channel| *channel = None);
                if channels.iter().any(Option::is_some) {
                    continue;
                }
            }
            code.reads(&instr, |operand| {
                let left = reads.get_mut(&operand).expect("it was counted with the others");
                *left -= 1;
                if *left == 0 {
                    unread.push(operand);
                }
            });
            code.instrs[at].op = Op::Nop;
        }
    }
}

fn is_temporary(classes: &[Vec<Class>; 3], reg: Reg) -> bool {
    !reg.uniform && classes[reg.file as usize][reg.index as usize] == Class::Temporary
}

/// Replaces a copy of a variable by the variable, if the variable does not change while the copy is needed.
fn propagate_copies(code: &mut Code, classes: &[Vec<Class>; 3]) {
    let found = Occurrences::of(code);
    let mut same: HashMap<Reg, Reg> = HashMap::new();
    for at in 0..code.instrs.len() {
        let instr = code.instrs[at];
        if instr.op != Op::Copy || instr.masked || is_temporary(classes, instr.sources[0]) {
            continue;
        }
        let last = found.last_use(instr.dst, at);
        let writes = found.writes.get(&instr.sources[0]);
        if !writes.is_some_and(|writes| writes.iter().any(|write| (at + 1..last).contains(write))) {
            same.insert(instr.dst, instr.sources[0]);
            code.instrs[at].op = Op::Nop;
        }
    }
    code.each_read(&|reg| {
        if let Some(other) = same.get(reg) {
            *reg = *other;
        }
    });
}

/// Ranges of instructions of all basic blocks.
pub(crate) fn basic_blocks(nodes: &[Node]) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut nodes = nodes.to_vec();
    let mut rest: Vec<&mut Node> = nodes.iter_mut().collect();
    while let Some(node) = rest.pop() {
        if let Node::Run(start, end) = node {
            found.push((*start, *end));
        }
        rest.extend(node.children().into_iter().flatten());
    }
    found
}

/// Computes a value that is only stored directly into its variable.
fn fuse_stores(code: &mut Code, classes: &[Vec<Class>; 3], blocks: &[(usize, usize)]) {
    let found = Occurrences::of(code);
    let mut writes = found.writes.clone();
    let touched = |writes: &HashMap<Reg, Vec<usize>>, reg: &Reg, from: usize, to: usize| {
        [&found.reads, writes]
            .iter()
            .any(|map| map.get(reg).is_some_and(|at| at.iter().any(|at| (from..to).contains(at))))
    };
    for &(start, end) in blocks {
        for at in start..end {
            let store = code.instrs[at];
            let value = store.sources[0];
            if store.op != Op::Copy || !store.masked || !is_temporary(classes, value) {
                continue;
            }
            let [defined] = found.writes.get(&value).map(Vec::as_slice).unwrap_or_default() else { continue };
            let once = found.reads.get(&value).is_some_and(|reads| reads.len() == 1);
            let defined = *defined;
            let here = (start..at).contains(&defined) && code.instrs[defined].has_dst();
            if once && here && !touched(&writes, &store.dst, defined + 1, at) {
                code.instrs[defined].dst = store.dst;
                code.instrs[defined].masked = true;
                code.instrs[at].op = Op::Nop;
                writes.entry(store.dst).or_default().push(defined);
            }
        }
    }
}

/// Fuses a product that only one sum needs into a multiply-add.
fn fuse_sums(code: &mut Code, classes: &[Vec<Class>; 3], blocks: &[(usize, usize)]) {
    let found = Occurrences::of(code);
    for &(start, end) in blocks {
        for at in start..end {
            let sum = code.instrs[at];
            if sum.op != Op::Binary(Binary::Add) {
                continue;
            }
            for (product, other) in [(sum.sources[0], sum.sources[1]), (sum.sources[1], sum.sources[0])] {
                let [defined] = found.writes.get(&product).map(Vec::as_slice).unwrap_or_default() else { continue };
                let once = found.reads.get(&product).is_some_and(|reads| reads.len() == 1);
                let multiply = code.instrs[*defined];
                let fits = (start..at).contains(defined) && multiply.op == Op::Binary(Binary::Mul) && !multiply.masked;
                let [a, b, _] = multiply.sources;
                let kept = |reg: Reg| {
                    let writes = found.writes.get(&reg).map(Vec::as_slice).unwrap_or_default();
                    reg.uniform || is_temporary(classes, reg) || !writes.iter().any(|w| (defined + 1..at).contains(w))
                };
                if once && fits && is_temporary(classes, product) && kept(a) && kept(b) {
                    code.instrs[at].op = Op::MulAdd;
                    code.instrs[at].sources = [a, b, other];
                    code.instrs[at].count = 3;
                    code.instrs[*defined].op = Op::Nop;
                    break;
                }
            }
        }
    }
}

/// Removes [`Op::Nop`].
fn drop_nops(code: &mut Code) {
    let mut before = vec![0];
    for instr in &code.instrs {
        before.push(before[before.len() - 1] + usize::from(instr.op != Op::Nop));
    }
    code.instrs.retain(|instr| instr.op != Op::Nop);
    renumber(&mut code.body, &before);
}

fn renumber(nodes: &mut Vec<Node>, before: &[usize]) {
    for node in nodes.iter_mut() {
        if let Node::Run(start, end) = node {
            (*start, *end) = (before[*start], before[*end]);
        }
        node.children().into_iter().for_each(|part| renumber(part, before));
    }
    nodes.retain(|node| !matches!(node, Node::Run(start, end) if start == end));
}
