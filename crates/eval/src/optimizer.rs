//! Makes lowered code shorter: what nothing reads goes, copies and sums of products are merged with what they are of.

use super::code::{Code, Instr, Node, Op, Reg};
use super::lower::Class;
use std::collections::{BTreeSet, HashMap, HashSet};

/// Where registers are read and written, as numbers of instructions; conditions count as reads of the next one.
#[derive(Default)]
pub(super) struct Occurrences {
    pub(super) reads: HashMap<Reg, Vec<usize>>,
    pub(super) writes: HashMap<Reg, Vec<usize>>,
    /// First instruction of each loop, and the first behind it.
    pub(super) loops: Vec<(usize, usize)>,
}

impl Occurrences {
    pub(super) fn of(code: &Code) -> Occurrences {
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

    /// Loops and conditions of nodes that start at an instruction; where they end.
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

    /// The last time that a temporary of `defined` is needed: a loop that it is defined before needs it in every turn.
    pub(super) fn last_use(&self, reg: Reg, defined: usize) -> usize {
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

/// Removes, merges, and closes the gaps.
pub(super) fn tidy(code: &mut Code, classes: &[Vec<Class>; 3]) {
    drop_unread(code);
    merge_loads(code, classes);
    let runs = runs(&code.body);
    merge_stores(code, classes, &runs);
    merge_sums(code, classes, &runs);
    drop_unread(code);
    drop_images(code);
    drop_uniforms(code);
    close_gaps(code);
}

/// What is the same for all lanes and is read by none.
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

/// Images that nothing looks up any more.
fn drop_images(code: &mut Code) {
    let looks_up = |instr: &&Instr| matches!(instr.op, Op::Sample | Op::Fetch);
    let read: BTreeSet<usize> =
        code.instrs.iter().filter(looks_up).map(|instr| code.lookups[instr.table as usize].image).collect();
    code.images = read.iter().map(|&image| code.images[image]).collect();
    for lookup in &mut code.lookups {
        lookup.image = read.range(..lookup.image).count();
    }
}

/// Instructions whose results nothing reads, and those that only such read.
pub(super) fn drop_unread(code: &mut Code) {
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

/// A loaded value is the variable itself, where that does not change as long as the value is needed.
fn merge_loads(code: &mut Code, classes: &[Vec<Class>; 3]) {
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
    let swap = |reg: &mut Reg| {
        if let Some(other) = same.get(reg) {
            *reg = *other;
        }
    };
    code.instrs.iter_mut().flat_map(|instr| &mut instr.sources).for_each(swap);
    code.tables.iter_mut().flatten().for_each(swap);
    code.lookups.iter_mut().flat_map(|lookup| &mut lookup.at).for_each(swap);
    code.outputs.iter_mut().flat_map(|(_, regs)| regs).for_each(swap);
    each_condition(&mut code.body, &swap);
}

/// Calls `on` with every register that decides where lanes go.
pub(super) fn each_condition(nodes: &mut [Node], on: &dyn Fn(&mut Reg)) {
    for node in nodes {
        match node {
            Node::If { condition, accept, reject, .. } => {
                on(condition);
                each_condition(accept, on);
                each_condition(reject, on);
            }
            Node::Loop(node) => {
                node.break_if.iter_mut().for_each(on);
                each_condition(&mut node.body, on);
                each_condition(&mut node.continuing, on);
            }
            Node::Switch { selector, cases, .. } => {
                on(selector);
                cases.iter_mut().for_each(|case| each_condition(&mut case.body, on));
            }
            Node::Scope { body, .. } => each_condition(body, on),
            Node::Run(..) | Node::Break | Node::Continue | Node::Return | Node::Kill => {}
        }
    }
}

/// The parts of a node.
pub(super) fn parts(node: &mut Node) -> Vec<&mut Vec<Node>> {
    match node {
        Node::If { accept, reject, .. } => vec![accept, reject],
        Node::Loop(node) => vec![&mut node.body, &mut node.continuing],
        Node::Switch { cases, .. } => cases.iter_mut().map(|case| &mut case.body).collect(),
        Node::Scope { body, .. } => vec![body],
        Node::Run(..) | Node::Break | Node::Continue | Node::Return | Node::Kill => Vec::new(),
    }
}

/// Every straight run.
pub(super) fn runs(nodes: &[Node]) -> Vec<(usize, usize)> {
    let mut found = Vec::new();
    let mut nodes = nodes.to_vec();
    let mut rest: Vec<&mut Node> = nodes.iter_mut().collect();
    while let Some(node) = rest.pop() {
        if let Node::Run(start, end) = node {
            found.push((*start, *end));
        }
        rest.extend(parts(node).into_iter().flatten());
    }
    found
}

/// A value that is only computed to be stored is computed into its variable.
fn merge_stores(code: &mut Code, classes: &[Vec<Class>; 3], runs: &[(usize, usize)]) {
    let found = Occurrences::of(code);
    let mut writes = found.writes.clone();
    let touched = |writes: &HashMap<Reg, Vec<usize>>, reg: &Reg, from: usize, to: usize| {
        [&found.reads, writes]
            .iter()
            .any(|map| map.get(reg).is_some_and(|at| at.iter().any(|at| (from..to).contains(at))))
    };
    for &(start, end) in runs {
        for at in start..end {
            let store = code.instrs[at];
            let value = store.sources[0];
            if store.op != Op::Copy || !store.masked || !is_temporary(classes, value) {
                continue;
            }
            let [defined] = found.writes.get(&value).map(Vec::as_slice).unwrap_or_default() else { continue };
            let once = found.reads.get(&value).is_some_and(|reads| reads.len() == 1);
            let defined = *defined;
            let here = (start..at).contains(&defined) && code.instrs[defined].single();
            if once && here && !touched(&writes, &store.dst, defined + 1, at) {
                code.instrs[defined].dst = store.dst;
                code.instrs[defined].masked = true;
                code.instrs[at].op = Op::Nop;
                writes.entry(store.dst).or_default().push(defined);
            }
        }
    }
}

/// A product that is only needed in one sum.
fn merge_sums(code: &mut Code, classes: &[Vec<Class>; 3], runs: &[(usize, usize)]) {
    let found = Occurrences::of(code);
    for &(start, end) in runs {
        for at in start..end {
            let sum = code.instrs[at];
            if sum.op != Op::Add {
                continue;
            }
            for (product, other) in [(sum.sources[0], sum.sources[1]), (sum.sources[1], sum.sources[0])] {
                let [defined] = found.writes.get(&product).map(Vec::as_slice).unwrap_or_default() else { continue };
                let once = found.reads.get(&product).is_some_and(|reads| reads.len() == 1);
                let multiply = code.instrs[*defined];
                let fits = (start..at).contains(defined) && multiply.op == Op::Mul && !multiply.masked;
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

/// Removes what has become nothing.
fn close_gaps(code: &mut Code) {
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
        parts(node).into_iter().for_each(|part| renumber(part, before));
    }
    nodes.retain(|node| !matches!(node, Node::Run(start, end) if start == end));
}
