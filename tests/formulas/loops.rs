//! Loop iterations that headers declare, against those of the exact evaluator.

use crate::formulas::harness::{Check, OCTAVES, shipped};

/// Noise that loops over the corners of a cell.
const LOOPING: &str = "wavelet";
/// Iterations of a noise without `@loops`, as in `src/scene/rules/loops.rs`.
const UNKNOWN: u32 = 9;

#[test]
fn noises_loop_as_their_headers_say() {
    let library = shipped();
    for noise in library.modules("noise") {
        let text = "#include <noise>\nvoid check() { out0.x = noise(p0.xyz); }";
        let turns = Check::new(&library, &[("noise", noise)], text).turns();
        let declared = library.header("noise", noise).unwrap().loops.unwrap_or(UNKNOWN);
        println!("{noise}: {turns} of {declared}");
        assert!(turns <= u64::from(declared), "{noise}: {turns}");
        assert!(noise != LOOPING || turns >= 8, "{turns}");
    }
}

#[test]
fn octaves_loop_as_their_headers_say() {
    let library = shipped();
    for turbulence in library.modules("turbulence") {
        let text = "#include <turbulence>\nvoid check() { out0.x = turbulence(p0.xyz); }";
        let turns = Check::new(&library, &[("turbulence", turbulence), ("noise", LOOPING)], text).turns();
        let declared = library.header("turbulence", turbulence).unwrap().loops.unwrap_or(1 + UNKNOWN);
        println!("{turbulence}: {turns} of {declared} for each of {OCTAVES} octaves");
        // The last iteration ends the sum.
        assert!(turns <= u64::from(OCTAVES * declared + 1), "{turbulence}: {turns}");
    }
}
