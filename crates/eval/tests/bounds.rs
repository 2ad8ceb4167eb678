//! Bounds of conversions and of noise.

use hypertexture_eval::{Affine, Evaluate, F32Interval, Inputs, Interval, Invocations, Program};
use hypertexture_glsl::{Library, Linker, Slots, Stage};
use hypertexture_noise::{Lattice, NOISE_BOUND};

/// Compiles a fragment shader that sets `value` from `place`.
fn program(body: &str) -> Program {
    let text = format!(
        "#version 450
        layout(location = 0) in vec4 place;
        layout(location = 0) out vec4 value;
        layout(binding = 3) uniform texture3D noise;
        layout(binding = 4) uniform sampler trilinear;
        void main() {{ value = {body}; }}"
    );
    let library = Library::new([("test.frag".to_string(), text)]);
    let linker = Linker::new().expect("compiler");
    let spirv = linker.link(&library, "test.frag", Stage::Fragment, &["test.frag"], &Slots::new()).expect("link");
    Program::read(&spirv, &[]).expect("read")
}

/// Evaluates a program at one place.
fn run<N: Evaluate>(program: &Program, place: [N; 4]) -> [N; 4] {
    let noises = [(3, Lattice::default())].into();
    let samplers = [(4, hypertexture_eval::Wrap::Repeat)].into();
    let inputs = Inputs { noises, samplers, ..Inputs::default() };
    let points = Invocations { fragment_coordinates: vec![], varyings: [(0, vec![place])].into() };
    program.bind(&inputs).expect("bind").run(&points).expect("run")[&0][0]
}

#[test]
fn integers_that_f32_represents_stay_exact() {
    const EXACT: i64 = 1 << 24;
    let converted = program("vec4(float(int(place.x)))");
    let convert = |lo: i64, hi: i64| {
        let place = F32Interval(Interval::of(lo as f64, hi as f64));
        let [F32Interval(all), ..] = run(&converted, [place; 4]);
        all
    };
    for (lo, hi) in [(0, EXACT), (-EXACT, 7), (5, 5)] {
        let all = convert(lo, hi);
        assert_eq!((all.lo, all.hi), (lo as f64, hi as f64));
    }
    for int in [EXACT + 1, -EXACT - 1] {
        let all = convert(int, int);
        assert!(all.contains(f64::from(int as f32)) && all.lo < all.hi, "{int}: {all:?}");
    }
}

#[test]
fn noise_at_an_unknown_position_stays_within_its_bound() {
    let noise = program("vec4(textureLod(sampler3D(noise, trilinear), place.xyz, 256.0).a)");
    let known = Interval { lo: 0.5, hi: 0.5 };
    for unknown in [Interval::WHOLE, Interval { lo: 0.0, hi: f64::INFINITY }] {
        let place = [unknown, known, known, known];
        let bounds = [
            run(&noise, place)[0],
            run(&noise, place.map(F32Interval))[0].0,
            run(&noise, place.map(Affine::bounded))[0].all,
        ];
        for bounds in bounds {
            assert!(bounds.lo > -1.001 * NOISE_BOUND && bounds.hi < 1.001 * NOISE_BOUND, "{bounds:?} at {unknown:?}");
        }
    }
}
