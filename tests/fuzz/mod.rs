//! Bytes that nobody wrote, for every parser: thousands in each run of the tests, as many as `HYPERTEXTURE_FUZZ` says in a
//! long one:
//!
//! ```sh
//! HYPERTEXTURE_FUZZ=1000000 cargo test --release --test library fuzz:: -- --nocapture
//! ```

mod targets;

use std::panic::{AssertUnwindSafe, catch_unwind};
use targets::{TARGETS, Target};

/// The generator of Steele, Lea and Flood 2014.
struct SplitMix(u64);

impl SplitMix {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ z >> 31
    }
}

/// Inputs for each parser, unless the environment says how many.
const INPUTS: u64 = 3000;
/// Changes of a text, at most.
const CHANGES: u64 = 6;
/// Bytes of an input, at most.
const MAX_BYTES: usize = 4096;
/// Inputs that break parsers.
const WORDS: [&[u8]; 28] = [
    b"0",
    b"-1",
    b"1e39",
    b"-1e-46",
    b"nan",
    b"inf",
    b"99999999999999999999",
    b"4294967296",
    b"2147483648",
    b"0x10",
    b"\0",
    b"\n",
    b"\r\n",
    b"\xff\xfe",
    b"\xc3\x28",
    b"[",
    b"]",
    b"{",
    b"}",
    b"\"",
    b"/",
    b"//",
    b"#",
    b"=",
    b"*",
    b" ",
    b"..",
    b"[[",
];

/// The input with this number: a text that is right, changed a few times.
fn input(seeds: &[Vec<u8>], random: &mut SplitMix) -> Vec<u8> {
    let mut below = |end: usize| (random.next() % end.max(1) as u64) as usize;
    let mut bytes = seeds[below(seeds.len())].clone();
    for _ in 0..=below(CHANGES as usize) {
        let at = below(bytes.len() + 1);
        let end = (at + below(24)).min(bytes.len());
        match below(7) {
            0 if at < bytes.len() => bytes[at] ^= 1 << below(8),
            1 => drop(bytes.drain(at..end)),
            2 => {
                let part = bytes[at..end].to_vec();
                let to = below(bytes.len() + 1);
                drop(bytes.splice(to..to, part));
            }
            3 => drop(bytes.splice(at..at, WORDS[below(WORDS.len())].to_vec())),
            4 => drop(bytes.splice(at..end, WORDS[below(WORDS.len())].to_vec())),
            5 => bytes.truncate(at),
            _ => {
                let part = bytes[at..end].repeat(below(40));
                drop(bytes.splice(at..at, part));
            }
        }
        bytes.truncate(MAX_BYTES);
    }
    bytes
}

fn fuzz(Target { name, seeds, run }: &Target, count: u64) {
    let seeds = seeds();
    for number in 0..count {
        let bytes = input(&seeds, &mut SplitMix(number << 8 | name.len() as u64));
        if catch_unwind(AssertUnwindSafe(|| run(&bytes))).is_err() {
            panic!("{name}, input {number}: {}", String::from_utf8_lossy(&bytes).escape_debug());
        }
    }
    println!("{name}: {count} inputs");
}

#[test]
fn no_bytes_break_a_parser() {
    let count = std::env::var("HYPERTEXTURE_FUZZ").ok().map_or(INPUTS, |count| count.parse().expect("a number"));
    std::thread::scope(|scope| {
        for target in &TARGETS {
            scope.spawn(move || fuzz(target, count));
        }
    });
}

#[test]
fn what_the_targets_start_from_is_taken() {
    for Target { name, seeds, run } in &TARGETS {
        for seed in seeds() {
            println!("{name}");
            run(&seed);
        }
    }
}
