//! Gives registers places: few, used again as soon as what they held is no longer needed, so that a block of lanes
//! stays in the cache.
//! Source: linear scan, Poletto and Sarkar 1999.

use super::code::{Code, Instr, Node, Op, Reg};
use super::lower::Class;
use super::optimizer::{Occurrences, each_condition, parts};
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap, HashSet};

/// From when to when a register is needed; the instruction of number n happens at n + 1, inputs are there at 0.
type Spans = HashMap<Reg, (usize, usize)>;

/// Numbers the registers anew, and says what each part of the control flow writes.
pub(super) fn allocate(code: &mut Code, classes: &[Vec<Class>; 3]) {
    let found = Occurrences::of(code);
    let inputs: HashSet<Reg> = code.inputs.iter().map(|(_, _, reg)| *reg).collect();
    let all = found.reads.keys().chain(found.writes.keys()).chain(&inputs).filter(|reg| !reg.uniform);
    let spans: Spans = all.map(|reg| (*reg, span(*reg, &found, classes, inputs.contains(reg)))).collect();
    let mut body = std::mem::take(&mut code.body);
    mark(&mut body, code, &spans, 0);
    let places = scan(&spans, &mut code.registers);
    let swap = |reg: &mut Reg| {
        if let Some(place) = places.get(reg) {
            reg.index = *place;
        }
    };
    for instr in &mut code.instrs {
        instr.sources.iter_mut().for_each(swap);
        swap(&mut instr.dst);
    }
    code.tables.iter_mut().flatten().for_each(swap);
    for lookup in &mut code.lookups {
        lookup.at.iter_mut().chain(lookup.channels.iter_mut().flatten()).for_each(swap);
    }
    code.inputs.iter_mut().map(|(_, _, reg)| reg).for_each(swap);
    code.outputs.iter_mut().flat_map(|(_, regs)| regs).for_each(swap);
    each_condition(&mut body, &swap);
    each_written(&mut body, &mut |written| {
        written.iter_mut().for_each(swap);
        written.sort_unstable();
        written.dedup();
    });
    compare(&mut body, &code.instrs);
    code.body = body;
}

/// Says what conditions compare, where the numbers are still there when the branch is entered.
fn compare(nodes: &mut [Node], instrs: &[Instr]) {
    let mut before = 0..0;
    for node in nodes {
        if let Node::If { condition, compared, .. } = node {
            let last = before.clone().rev().find(|&at| instrs[at].dst == *condition && instrs[at].single());
            *compared = last.and_then(|at| {
                let [a, b, _] = instrs[at].sources;
                let kept = |reg: Reg| {
                    !instrs[at..before.end]
                        .iter()
                        .any(|instr| instr.dst == reg || matches!(instr.op, Op::Sample | Op::Fetch))
                };
                (matches!(instrs[at].op, Op::Less | Op::LessEqual) && kept(a) && kept(b)).then_some([a, b])
            });
        }
        before = match node {
            Node::Run(start, end) => *start..*end,
            _ => 0..0,
        };
        parts(node).into_iter().for_each(|part| compare(part, instrs));
    }
}

fn span(reg: Reg, found: &Occurrences, classes: &[Vec<Class>; 3], input: bool) -> (usize, usize) {
    let of = |map: &HashMap<Reg, Vec<usize>>| map.get(&reg).cloned().unwrap_or_default();
    let (reads, writes) = (of(&found.reads), of(&found.writes));
    let all = || reads.iter().chain(&writes).copied();
    let (first, last) = (all().min().unwrap_or(0), all().max().unwrap_or(0));
    let class = classes[reg.file as usize][reg.index as usize];
    let (mut start, mut end) = (first + 1, last + 1);
    if class == Class::Temporary {
        end = found.last_use(reg, first) + 1;
    } else {
        for (from, to) in &found.loops {
            let inside = |at: usize| (*from..*to).contains(&at);
            if !all().any(inside) {
                continue;
            }
            // What every turn writes before it is read does not live from turn to turn.
            let own = class == Class::Merged && all().all(inside) && !reads.contains(&first) && !input;
            if !own {
                (start, end) = (start.min(from + 1), end.max(to + 1));
            }
        }
    }
    (if input { 0 } else { start }, end)
}

/// Registers for spans; how many of each file it took.
fn scan(spans: &Spans, counts: &mut [u32; 3]) -> HashMap<Reg, u32> {
    let mut order: Vec<(usize, usize, Reg)> = spans.iter().map(|(reg, (start, end))| (*start, *end, *reg)).collect();
    order.sort_unstable();
    let mut places = HashMap::new();
    let mut taken: [BinaryHeap<Reverse<(usize, u32)>>; 3] = Default::default();
    let mut free: [Vec<u32>; 3] = Default::default();
    for (start, end, reg) in order {
        let file = reg.file as usize;
        while let Some(Reverse((until, place))) =
            taken[file].peek().copied().filter(|Reverse((until, _))| *until <= start)
        {
            let _ = until;
            taken[file].pop();
            free[file].push(place);
        }
        let place = free[file].pop().unwrap_or_else(|| {
            counts[file] += 1;
            counts[file] - 1
        });
        taken[file].push(Reverse((end, place)));
        places.insert(reg, place);
    }
    places
}

fn each_written(nodes: &mut [Node], on: &mut dyn FnMut(&mut Vec<Reg>)) {
    for node in nodes {
        match node {
            Node::If { written, .. } | Node::Switch { written, .. } | Node::Scope { written, .. } => on(written),
            Node::Loop(node) => on(&mut node.written),
            Node::Run(..) | Node::Break | Node::Continue | Node::Return | Node::Kill => {}
        }
        parts(node).into_iter().for_each(|part| each_written(part, on));
    }
}

/// Notes the variables that parts of the control flow write; the end of the nodes, and all that they write.
fn mark(nodes: &mut [Node], code: &Code, spans: &Spans, mut at: usize) -> (usize, HashSet<Reg>) {
    let mut all = HashSet::new();
    for node in nodes {
        if let Node::Run(start, end) = node {
            all.extend(code.instrs[*start..*end].iter().filter(|instr| instr.masked).map(|instr| instr.dst));
            at = *end;
        }
        let (mut own, mut ends) = (HashSet::new(), Vec::new());
        for part in parts(node) {
            let (end, written) = mark(part, code, spans, at);
            at = end;
            ends.push(end);
            own.extend(written);
        }
        // What is needed where ways part or meet: behind the first branch, anywhere, or behind it all.
        let needed_after = |at: usize| own.iter().copied().filter(|reg| spans[reg].1 > at).collect();
        match node {
            Node::If { written, .. } => *written = needed_after(ends[0]),
            Node::Switch { written, .. } => *written = needed_after(0),
            Node::Scope { written, .. } => *written = needed_after(at),
            Node::Loop(node) => node.written = needed_after(0),
            Node::Run(..) | Node::Break | Node::Continue | Node::Return | Node::Kill => {}
        }
        all.extend(own);
    }
    (at, all)
}
