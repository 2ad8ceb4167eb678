//! The cases of `stress` and the sweeps of scenes: each case holds on this device, and detects a planted mistake.

use crate::common::{with_gpu, with_gpus};
use hypertexture::scene::{ParameterValue, preset};
use hypertexture::shader::{self, Library};
use hypertexture_measure::cases::{self, CASES, Case, Report, Row, Suite, chart_page, library, suite, table};
use hypertexture_measure::sweep::sweep;

fn of(numbers: &[u32]) -> Vec<Case> {
    suite(Suite::Stress).filter(|case| numbers.contains(&case.number)).collect()
}

/// The library with another text for one of its files.
fn with(path: &str, change: impl Fn(&str) -> String) -> Library {
    let library = library();
    assert!(library.source(path).is_some(), "{path}");
    let files =
        library.sources().map(|(own, text)| (own.to_string(), if own == path { change(text) } else { text.into() }));
    Library::new(files.collect::<Vec<_>>())
}

#[test]
fn the_cases_are_numbered_without_a_gap() {
    for command in [Suite::Verify, Suite::Stress] {
        let numbers: Vec<u32> = suite(command).map(|case| case.number).collect();
        assert!(numbers.iter().copied().eq(1..=numbers.len() as u32), "{command:?}: {numbers:?}");
    }
    assert_eq!(CASES.len(), suite(Suite::Verify).chain(suite(Suite::Stress)).count());
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn every_case_holds() {
    with_gpus(|gpus| {
        let all: Vec<Case> = suite(Suite::Stress).collect();
        let found = cases::run(gpus, &library(), &all, &|_| ()).unwrap();
        println!("{}", table(&found));
        let failed: Vec<String> = found.failed().map(Row::title).collect();
        assert_eq!(failed, Vec::<String>::new());
        assert!(found.rows.len() >= 400, "{} rows", found.rows.len());
        for case in all {
            let rows = found.rows.iter().filter(|row| row.case == case.number).count();
            assert!(rows >= 3, "case {}, {}: {rows} rows", case.number, case.name);
        }
        // Curves of error against stiffness: of opacity alone 16 decades, by two modules, of points and segments.
        let page = chart_page(&found);
        assert!(page.matches("<svg").count() >= 20);
        let json = serde_json::to_string(&found).unwrap();
        assert_eq!(json.matches("\"bound\"").count(), found.rows.len());
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn formulas_of_the_papers_fail_where_they_are_known_to() {
    const PAPER: &str = "float opacity(float density, float amount) { return 1.0 - pow(1.0 - density, amount); }\n\
                         float segment_opacity(float a, float b, float amount) { return opacity(0.5 * (a + b), amount); }\n";
    type Wrong = (&'static str, fn(&str) -> String, &'static [u32]);
    let wrong: [Wrong; 6] = [
        // The opacity of the seeds: thin matter loses its digits, and an empty step of full density is opaque.
        ("opacity/perlin.glsl", |_| PAPER.into(), &[10, 12]),
        // Bias as it is written: its ends are 0 to the power of 0, and beyond [0, 1] it is NaN.
        ("shaping.glsl", |text| text.replace("if (t <= 0.0) return 0.0;", ""), &[5]),
        // A union that adds up.
        ("boolean/algebraic.glsl", |text| text.replace("(1.0 - a.density) * b.density", "b.density"), &[13]),
        // An index of the lattice that is rounded toward 0.
        ("lattice_noise.glsl", |text| text.replace("base = floor(inside)", "base = trunc(inside)"), &[25]),
        // A highlight that asks for no mirror.
        ("refract.frag", |text| text.replace("min(head_on * head_on / GLASS, 1.0)", "1.0"), &[33]),
        // Time as f32 has it.
        ("dmf/fire.glsl", |text| text.replace("// @drift", "// drift"), &[41]),
    ];
    with_gpus(|gpus| {
        for (path, change, numbers) in wrong {
            let found = cases::run(gpus, &with(path, change), &of(numbers), &|_| ()).unwrap();
            for number in numbers {
                let failed = found.failed().filter(|row| row.case == *number).count();
                assert!(failed > 0, "{path}: case {number} does not see it:\n{}", table(&found));
            }
        }
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_case_that_cannot_be_drawn_is_a_row_that_fails() {
    with_gpus(|gpus| {
        let broken = with("opacity/perlin.glsl", |_| "no GLSL".into());
        let found: Report = cases::run(gpus, &broken, &of(&[10, 24]), &|_| ()).unwrap();
        let failed: Vec<&Row> = found.failed().collect();
        assert_eq!(failed.len(), 1);
        assert!(failed[0].found.contains("opacity/perlin.glsl"), "{}", failed[0].found);
        assert!(found.rows.len() > 10, "the other case has its rows");
        assert!(table(&found).contains("FAIL") && chart_page(&found).contains("<b>FAIL</b>"));
    });
}

/// A DMF that is right where its parameters are 0: one makes the picture finer than samples, one is NaN above 3 / 4.
const PLANTED: &str = "// Planted.\n// Source: -\n// density: any; result: in [0, 1].\n\
    // @param ripples = 0 in [0, 4]: Ripples, hundreds for each object unit.\n\
    // @param dose = 0 in [0, 1]: No number above 3 / 4.\n\
    // @param tint = 0 in [0, 1]: Nothing.\n\
    float planted(float density, Sample s) {\n\
        float wave = 0.5 + 0.5 * cos(100.0 * ripples * s.x.z + tint);\n\
        return density * wave * wave * sqrt(0.75 - dose);\n\
    }\n";

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_sweep_finds_the_worst_corner_and_what_is_no_number() {
    with_gpu(|gpu| {
        let library = shader::shipped().with_module("dmf", "planted", PLANTED);
        let mut scene = preset("lit").unwrap();
        scene.object.input = "sphere".into();
        (scene.effect.dmf, scene.effect.classify) = (vec!["planted".into()], "soft".into());
        scene.quality.samples = 32;
        (scene.object.inner_iso, scene.object.outer_iso) = (-0.5, 0.3);
        let found = sweep(gpu, &library, &scene, &|_| ()).unwrap();
        assert!(found.accepted.is_empty(), "{:?}", found.accepted);
        assert!(!found.ok(), "{:#?}", found.corners);
        let faults: Vec<_> = found.corners.iter().filter(|corner| !corner.ok).collect();
        assert_eq!(faults.len(), 1, "{faults:?}");
        assert_eq!(faults[0].changes, [("dose".to_string(), 1.0)]);
        assert!(faults[0].why.contains("NaN with"), "{}", faults[0].why);
        let worst = found.worst.unwrap();
        assert!(worst.changes.iter().any(|(name, value)| name == "ripples" && *value > 0.0), "{worst:?}");
        let own = found.corners[0].error.unwrap();
        assert!(worst.error.unwrap() > 2.0 * own, "{worst:?} against {own}");
        // A scene whose values are all as they should be.
        scene.effect.dmf.clear();
        scene.parameters.insert("ripples".into(), ParameterValue::Number(0.0));
        assert!(sweep(gpu, &library, &scene, &|_| ()).is_err(), "a parameter that nothing declares");
        scene.parameters.clear();
        assert!(sweep(gpu, &library, &scene, &|_| ()).unwrap().ok());
    });
}
