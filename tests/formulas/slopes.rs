//! Slopes in boxes against closed derivatives, and what bounds know of two truths.

use crate::exact::{both, points, program};
use hypertexture::eval::{Inputs, Interval, Lanes, Sloped};
use std::collections::BTreeMap;

#[test]
fn slopes_in_a_box_hold_those_of_all_its_parallel_segments_and_are_derivatives_where_it_is_small() {
    type Slope = fn([f64; 4]) -> f64;
    // Along (1, -2, 0.5, 0), of numbers from 0.2 to 0.9.
    const ALONG: [f64; 4] = [1.0, -2.0, 0.5, 0.0];
    let bodies: [(&str, Slope); 9] = [
        ("x.x * x.y", |x| x[1] - 2.0 * x[0]),
        ("x.x / x.y", |x| (x[1] + 2.0 * x[0]) / (x[1] * x[1])),
        ("length(x.xyz)", |x| (x[0] - 2.0 * x[1] + 0.5 * x[2]) / (x[0] * x[0] + x[1] * x[1] + x[2] * x[2]).sqrt()),
        ("sin(3.0 * x.x) + exp(x.y)", |x| 3.0 * (3.0 * x[0]).cos() - 2.0 * x[1].exp()),
        ("smoothstep(0.0, 1.0, x.x)", |x| 6.0 * x[0] * (1.0 - x[0])),
        ("mix(x.x, x.y, x.z)", |x| 1.0 - x[2] - 2.0 * x[2] + 0.5 * (x[1] - x[0])),
        ("pow(x.x, 2.5)", |x| 2.5 * x[0].powf(1.5)),
        ("atan(x.x, x.y)", |x| (x[1] + 2.0 * x[0]) / (x[0] * x[0] + x[1] * x[1])),
        ("max(x.x, x.z - 1.0) * clamp(x.w, 0.0, 1.0)", |x| x[3]),
    ];
    let centers: Vec<[f64; 4]> = points(40).into_iter().map(|p| p.map(|t| 0.25 + 0.6 * t)).collect();
    for (text, slope) in bodies {
        let (program, inputs) = (program("", &format!("result = vec4({text});")), Inputs::default());
        let bound = program.bind(&inputs).unwrap_or_else(|error| panic!("{error}"));
        for half in [0.05, 1e-6] {
            let range = |center: f64, half: f64| Interval { lo: center - half, hi: center + half };
            let boxes = centers.iter().map(|center| {
                let along = |k: usize| Sloped { all: range(center[k], half), slope: Interval::of(ALONG[k], ALONG[k]) };
                [0, 1, 2, 3].map(along)
            });
            let lanes = Lanes { fragment_coordinates: Vec::new(), varyings: BTreeMap::from([(0, boxes.collect())]) };
            let found = &bound.run(&lanes).unwrap_or_else(|error| panic!("{error}"))[&0];
            for (center, [Sloped { slope: found, .. }, ..]) in centers.iter().zip(found) {
                for place in points(50) {
                    let at = [0, 1, 2, 3].map(|k| center[k] + half * (2.0 * place[k] - 1.0));
                    assert!(found.contains(slope(at)), "{text}: {} at {at:?} is not in {found:?}", slope(at));
                }
                assert!(half > 0.01 || found.hi - found.lo < 1e-3, "{text}: {found:?}");
            }
        }
    }
}

#[test]
fn one_of_two_truths_holds_where_the_second_is_known() {
    // Whether x.x is at least 1 is not known, but which of the two is true or false does not depend on it.
    let before = "";
    for (text, expected) in [
        ("bool h = !(x.x < 1.0), near = x.y < 10.0; result = vec4((h ? near : !h) ? x.z : 9.0);", [0.25, 0.5]),
        ("bool h = !(x.x < 1.0), near = x.y < 10.0; result = vec4((h ? h : near) ? x.z : 9.0);", [0.25, 0.5]),
        ("bool h = !(x.x < 1.0), far = x.y > 10.0; result = vec4((h ? !h : far) ? 9.0 : x.z);", [0.25, 0.5]),
        ("bool h = !(x.x < 1.0), far = x.y > 10.0; result = vec4((h ? far : h) ? 9.0 : x.z);", [0.25, 0.5]),
        ("bool h = !(x.x < 1.0), near = x.y < 10.0; result = vec4((h ? near : h) ? x.z : 9.0);", [0.25, 9.0]),
    ] {
        let program = program(before, text);
        let inputs = Inputs::default();
        let bound = program.bind(&inputs).unwrap_or_else(|error| panic!("{error}"));
        let place = [[0.5, 1.5], [0.0, 1.0], [0.25, 0.5], [0.0, 0.0]].map(|[lo, hi]| Interval { lo, hi });
        let lanes = Lanes { fragment_coordinates: Vec::new(), varyings: BTreeMap::from([(0, vec![place])]) };
        let [found, ..] = bound.run(&lanes).unwrap_or_else(|error| panic!("{error}"))[&0][0];
        assert_eq!([found.lo, found.hi], expected, "{text}");
        both(before, text, &inputs, &points(60).into_iter().map(|p| p.map(|t| 3.0 * t - 1.0)).collect::<Vec<_>>());
    }
}
