//! The words of a SPIR-V module.

/// Words before the first instruction.
const HEADER: usize = 5;

/// The instructions of a module: their numbers, and their operands.
pub fn instructions(module: &[u32]) -> impl Iterator<Item = (u32, &[u32])> {
    let mut rest = module.get(HEADER..).unwrap_or_default();
    std::iter::from_fn(move || {
        let &first = rest.first()?;
        let (words, after) = rest.split_at_checked((first >> 16).max(1) as usize)?;
        rest = after;
        Some((first & 0xffff, &words[1..]))
    })
}
