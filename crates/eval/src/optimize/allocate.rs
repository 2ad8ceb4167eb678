//! Register allocation, so that a block of lanes fits in the cache.
//! Source: linear scan, Poletto and Sarkar 1999.

use super::tidy::Occurrences;
use crate::code::{Code, Instr, Node, Op, Reg};
use crate::lower::function::Class;
use crate::number::Comparison;
use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap, HashSet};

/// Live ranges. Instruction n is at time n + 1, inputs are at 0.
type Spans = HashMap<Reg, (usize, usize)>;

/// Renumbers the registers, and notes the registers that each node writes.
pub(crate) fn allocate(code: &mut Code, classes: &[Vec<Class>; 3]) {
    let found = Occurrences::of(code);
    let inputs: HashSet<Reg> = code.inputs.iter().map(|(_, _, reg)| *reg).collect();
    let all = found.reads.keys().chain(found.writes.keys()).chain(&inputs).filter(|reg| !reg.uniform);
    let spans: Spans = all.map(|reg| (*reg, span(*reg, &found, classes, inputs.contains(reg)))).collect();
    let mut body = std::mem::take(&mut code.body);
    mark(&mut body, code, &spans, 0);
    code.body = body;
    let places = scan(&spans, &mut code.registers);
    let swap = |reg: &mut Reg| {
        if let Some(place) = places.get(reg) {
            reg.index = *place;
        }
    };
    code.each_read(&swap);
    code.instrs.iter_mut().for_each(|instr| swap(&mut instr.dst));
    code.lookups.iter_mut().flat_map(|lookup| lookup.channels.iter_mut().flatten()).for_each(swap);
    code.inputs.iter_mut().for_each(|(_, _, reg)| swap(reg));
    finish(&mut code.body, &code.instrs, &swap);
}

/// Renames written registers, and notes the operands of comparisons that are still in their registers at the branch.
fn finish(nodes: &mut [Node], instrs: &[Instr], swap: &dyn Fn(&mut Reg)) {
    let mut before = 0..0;
    for node in nodes {
        if let Node::If { condition, compared, .. } = node {
            let last = before.clone().rev().find(|&at| instrs[at].dst == *condition && instrs[at].has_dst());
            *compared = last.and_then(|at| {
                let [a, b, _] = instrs[at].sources;
                let kept = |reg: Reg| {
                    !instrs[at..before.end]
                        .iter()
                        .any(|instr| instr.dst == reg || matches!(instr.op, Op::Sample | Op::Fetch))
                };
                (matches!(instrs[at].op, Op::Compare(Comparison::Less | Comparison::LessEqual)) && kept(a) && kept(b))
                    .then_some([a, b])
            });
        }
        before = match node {
            Node::Run(start, end) => *start..*end,
            _ => 0..0,
        };
        if let Some(written) = node.written() {
            written.iter_mut().for_each(swap);
            written.sort_unstable();
            written.dedup();
        }
        node.children().into_iter().for_each(|part| finish(part, instrs, swap));
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
            // A register that each iteration writes before it is read does not live across iterations.
            let own = class == Class::Merged && all().all(inside) && !reads.contains(&first) && !input;
            if !own {
                (start, end) = (start.min(from + 1), end.max(to + 1));
            }
        }
    }
    (if input { 0 } else { start }, end)
}

/// Assigns registers to live ranges, and counts those of each file.
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

/// Notes the live variables that nodes write. Returns the end of the nodes, and all that they write.
fn mark(nodes: &mut [Node], code: &Code, spans: &Spans, mut at: usize) -> (usize, HashSet<Reg>) {
    let mut all = HashSet::new();
    for node in nodes {
        if let Node::Run(start, end) = node {
            all.extend(code.instrs[*start..*end].iter().filter(|instr| instr.masked).map(|instr| instr.dst));
            at = *end;
        }
        let (mut own, mut ends) = (HashSet::new(), Vec::new());
        for part in node.children() {
            let (end, written) = mark(part, code, spans, at);
            at = end;
            ends.push(end);
            own.extend(written);
        }
        // Live after the first branch, anywhere, or after the node.
        let live_after = match node {
            Node::If { .. } => ends[0],
            Node::Scope { .. } => at,
            _ => 0,
        };
        if let Some(written) = node.written() {
            *written = own.iter().copied().filter(|reg| spans[reg].1 > live_after).collect();
        }
        all.extend(own);
    }
    (at, all)
}
