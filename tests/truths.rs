//! The truths of `hypertexture verify`, on the device of the tests.
//!
//! The expected values are computed in f64 and share nothing with the GLSL. `--nocapture` prints the table.

mod common;

use common::{rays, with_gpu};
use hypertexture::scene::{Pass, Projection};
use measure::verify::{self, AnalyticCase, Bench, Measure, Row, SLANTED, TRUTHS, Truth};
use std::collections::BTreeSet;
use std::time::Instant;

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn every_truth_holds_on_this_device_in_both_passes() {
    with_gpu(|gpu| {
        let start = Instant::now();
        let report = verify::run(gpu, TRUTHS, &|_| ()).unwrap_or_else(|error| panic!("{error}"));
        println!("{}{:.1} s", report.text(), start.elapsed().as_secs_f64());
        let missed: Vec<String> = report.missed().map(Row::failure).collect();
        assert!(missed.is_empty(), "{missed:?}");
        for truth in TRUTHS {
            let passes: BTreeSet<&str> =
                report.rows.iter().filter(|row| row.truth == truth.name).map(|row| row.pass).collect();
            // Slices alone are blended into a target, a picture for each of them.
            let both = passes.contains("slices") && (passes.contains("march") || truth.name == "10 thin layers");
            assert!(both, "{}: {passes:?}", truth.name);
        }
        // The control of the last truth: 8 bits lose most of what is there.
        let unorm8 = report.rows.iter().find(|row| row.what == "unorm8 target").expect("a row of it");
        assert!(unorm8.mean > 0.4, "{unorm8:?}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_wrong_formula_a_wrong_bound_and_a_wrong_order_are_found_and_named() {
    let soft = verify::SOFT_BALLS[0];
    let planted = |name, case: AnalyticCase| Truth { name, measure: Measure::Analytic(Box::leak(Box::new([case]))) };
    let truths = [
        // A thousandth of the opacity too much.
        planted("the formula", AnalyticCase { truth: |ray| Some(1.001 * (verify::SOFT_BALLS[0].truth)(ray)?), ..soft }),
        planted("the bound", AnalyticCase { bound: |_| 1e-9, ..soft }),
        planted("the order", AnalyticCase { order: Some([3.5, 4.5]), ..soft }),
        planted("nothing is known", AnalyticCase { truth: |_| None, ..soft }),
        planted("nothing", soft),
    ];
    with_gpu(|gpu| {
        let report = verify::run(gpu, &truths, &|_| ()).unwrap_or_else(|error| panic!("{error}"));
        let missed: Vec<String> = report.missed().map(Row::failure).collect();
        let both = |name: &str| ["slices", "march"].map(|pass| format!("{name} (parallel, {pass})"));
        let told: Vec<_> = missed.iter().filter_map(|failure| failure.split_once(": ")).collect();
        let titles: Vec<_> = told.iter().map(|(title, _)| *title).collect();
        assert_eq!(titles, ["the formula", "the bound", "the order", "nothing is known"].map(both).concat());
        assert!(told[2].1.ends_with(" samples, at most 1.0e-9"), "{missed:?}");
        assert!(told[4].1.ends_with(", between 3.5 and 4.5"), "{missed:?}");
        let text = report.text();
        assert!(text.lines().filter(|line| line.ends_with("NO")).count() == 8, "{text}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_slab_across_a_view_of_90_degrees_has_the_path_of_every_ray() {
    // Effect of the correction: without it, the corner would have the optical depth of the middle.
    let (scene, subject) = SLANTED[0].in_pass(Pass::Slices);
    let rays = rays(&scene, &subject);
    let middle = rays.iter().min_by(|a, b| a.slant().total_cmp(&b.slant())).expect("a picture has rays");
    let [found, short] = [&rays[0], middle].map(|ray| (SLANTED[0].truth)(ray).expect("known everywhere"));
    println!("corner: opacity {found:.4}, without the slant of {:.3} it is {short:.4}", rays[0].slant());
    assert!(1.0 - 1.0 / rays[0].slant() > 0.41 && found - short > 0.18);
    with_gpu(|gpu| {
        let levels = SLANTED[0].levels(&Bench::new(gpu), Pass::Slices).unwrap_or_else(|error| panic!("{error}"));
        assert!(levels.len() == 2 && levels.iter().all(|level| level.max < 2e-5), "{levels:?}");
    });
}

#[test]
fn the_table_shows_both_projections_of_every_picture_but_the_wide_one() {
    for truth in TRUTHS {
        if let Measure::Analytic(cases) = truth.measure {
            let of = |projection| cases.iter().filter(|case| case.projection == projection).count();
            let [parallel, perspective] = [Projection::Parallel, Projection::Perspective].map(of);
            assert!(parallel == perspective || cases.len() == 1, "{}", truth.name);
        }
    }
}
