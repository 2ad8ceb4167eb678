//! The cases of `hypertexture verify`, on the device of the tests; `--nocapture` prints the table.

use crate::common::{rays, with_gpu, with_gpus};
use hypertexture::scene::{Pass, Projection};
use hypertexture_measure::cases::{
    self, AnalyticCase, Case, Lab, Measure, Report, Row, SLANTED, SOFT_BALLS, Suite, suite,
};
use std::time::Instant;

fn run(gpus: &[hypertexture::gpu::Gpu], chosen: &[Case]) -> Report {
    cases::run(gpus, &cases::library(), chosen, &|_| ()).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn every_case_holds_on_this_device_in_both_passes() {
    with_gpus(|gpus| {
        let start = Instant::now();
        let all: Vec<Case> = suite(Suite::Verify).collect();
        let report = run(gpus, &all);
        println!("{}{:.1} s", cases::table(&report), start.elapsed().as_secs_f64());
        let failed: Vec<String> = report.failed().map(Row::title).collect();
        assert!(failed.is_empty(), "{failed:?}");
        // Slices bend no rays, rays are not blended into a target, and rows on drivers hold passes against each other.
        let others = ["lenses", "thin layers", "drivers"];
        for case in all.iter().filter(|case| !others.contains(&case.name)) {
            let rows = || report.rows.iter().filter(|row| row.case == case.number);
            let both = ["slices", "rays"].iter().all(|pass| rows().any(|row| row.what.ends_with(pass)));
            assert!(both, "{}", case.name);
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn wrong_formulas_bounds_and_orders_are_named() {
    let soft = SOFT_BALLS[0];
    let planted = |name, case: AnalyticCase| {
        let measure = Measure::Analytic(Box::leak(Box::new([case])));
        Case { suite: Suite::Verify, number: 1, name, measure }
    };
    let planted = [
        // 0.1 % too much opacity.
        planted("formula", AnalyticCase { truth: |ray| Some(1.001 * (SOFT_BALLS[0].truth)(ray)?), ..soft }),
        planted("bound", AnalyticCase { bound: |_| 1e-9, ..soft }),
        planted("order", AnalyticCase { order: Some([3.5, 4.5]), ..soft }),
        planted("unknown", AnalyticCase { truth: |_| None, ..soft }),
        planted("none", soft),
    ];
    with_gpus(|gpus| {
        let report = run(gpus, &planted);
        let failed: Vec<&Row> = report.failed().collect();
        let names: Vec<_> = failed.iter().map(|row| (row.name, row.what.as_str())).collect();
        let both = |name| ["slices", "rays"].map(|pass| (name, pass));
        let expected = ["formula", "bound", "order", "unknown"].map(both).concat();
        assert!(names.iter().zip(&expected).all(|(found, (name, pass))| found.0 == *name && found.1.ends_with(pass)));
        assert_eq!(names.len(), expected.len());
        assert!(failed[2].bound == 1e-9 && failed[4].error <= failed[4].bound, "{failed:?}");
        let text = cases::table(&report);
        assert!(text.lines().filter(|line| line.ends_with("FAIL")).count() == 8, "{text}");
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_slab_across_a_view_of_90_degrees_has_the_path_of_every_ray() {
    // Without the correction the corner would have the optical depth of the middle.
    let (scene, subject) = SLANTED[0].in_pass(Pass::Slices);
    let rays = rays(&scene, &subject);
    let middle = rays.iter().min_by(|a, b| a.slant().total_cmp(&b.slant())).expect("a picture has rays");
    let [found, short] = [&rays[0], middle].map(|ray| (SLANTED[0].truth)(ray).expect("known everywhere"));
    println!("corner: opacity {found:.4}, without the slant of {:.3} it is {short:.4}", rays[0].slant());
    assert!(1.0 - 1.0 / rays[0].slant() > 0.41 && found - short > 0.18);
    with_gpu(|gpu| {
        let lab = Lab::new(gpu, cases::library()).expect("a GLSL compiler");
        let levels = SLANTED[0].levels(&lab, Pass::Slices).unwrap_or_else(|error| panic!("{error}"));
        assert!(levels.len() == 2 && levels.iter().all(|level| level.max < 2e-5), "{levels:?}");
    });
}

#[test]
fn the_table_shows_both_projections_except_for_the_wide_one() {
    for case in suite(Suite::Verify) {
        if let Measure::Analytic(cases) = case.measure {
            let of = |projection| cases.iter().filter(|case| case.projection == projection).count();
            let [parallel, perspective] = [Projection::Parallel, Projection::Perspective].map(of);
            assert!(parallel == perspective || cases.len() == 1, "{}", case.name);
        }
    }
}
