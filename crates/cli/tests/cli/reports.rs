//! Output of the commands that write words: `info`, `convert`, `explain` and `bench`.

use super::desk::{Desk, text};
use std::fs;

#[test]
fn what_a_mesh_and_a_volume_hold_is_told_in_words_and_as_json() {
    let desk = Desk::new();
    // A tetrahedron, one face of it wound the other way, and a triangle apart.
    let corners = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 2\nv 5 0 0\nv 6 0 0\nv 5 1 0\n";
    desk.write("parts.obj", format!("{corners}f 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 3 4\nf 5 6 7\n"));
    let said = desk.good("info parts.obj");
    for words in ["5, 7 vertices", "bodies     2", "3 open, 0 crowded, 3 turned", "(0, 0, 0) to (6, 1, 2)"] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let known: serde_json::Value = serde_json::from_str(&desk.good("info parts.obj --json")).unwrap();
    assert_eq!((&known["triangles"], &known["edges"]), (&5.into(), &serde_json::json!([3, 0, 3])));
    // Two halves, one of 10 and one of 200, and a blurred wall between them.
    let values = (0..16 * 16 * 16).map(|at| match at % 16 {
        0..7 => 10u8,
        7 => 70,
        8 => 140,
        _ => 200,
    });
    let mut volume =
        b"NRRD0004\ntype: uchar\ndimension: 3\nsizes: 16 16 16\nspacings: 1 2 3\nencoding: raw\n\n".to_vec();
    volume.extend(values);
    desk.write("wall.nrrd", volume);
    let known: serde_json::Value = serde_json::from_str(&desk.good("info wall.nrrd --json")).unwrap();
    assert_eq!(
        (&known["voxels"], &known["values"]),
        (&serde_json::json!([16, 16, 16]), &serde_json::json!([10.0, 200.0]))
    );
    assert!(known["slope"].is_null(), "{known}");
    // Distances of another program.
    let far = |at: i32| ((at % 33 - 16).pow(2) + (at / 33 % 33 - 16).pow(2) + (at / 1089 - 16).pow(2)) as f32;
    let mut ball = b"NRRD0004\ntype: float\ndimension: 3\nsizes: 33 33 33\nendian: little\nencoding: raw\n\n".to_vec();
    ball.extend((0..35_937).flat_map(|at| (far(at).sqrt() - 12.1).to_le_bytes()));
    desk.write("ball.nrrd", ball);
    let said = desk.good("info ball.nrrd");
    assert!(
        said.contains("if they are, say --distance") && said.contains("render ball.nrrd -o picture.png --distance")
    );
    let isos = known["iso-values"].as_array().unwrap();
    assert!(isos.len() == 1 && (70.0..=140.0).contains(&isos[0].as_f64().unwrap()), "{isos:?}");
    assert!(desk.good("info wall.nrrd").contains(&format!("--iso {}", isos[0].as_f64().unwrap())));
}

#[test]
fn values_without_a_header_become_a_volume_of_any_format() {
    let desk = Desk::new();
    // 4 x 3 x 2 numbers of 16 bits, the highest byte first, behind 5 bytes.
    let values = (0..24u16).flat_map(|at| (at * 100).to_be_bytes());
    desk.write("scan.raw", b"head:".iter().copied().chain(values).collect::<Vec<u8>>());
    for name in ["a.nrrd", "a.mha", "a.nii", "a.nii.gz"] {
        let layout = "--dims 4,3,2 --type uint16 --endian big --spacing 0.5,1,2 --skip 5";
        desk.good(&format!("convert scan.raw {layout} -o {name}"));
        let known: serde_json::Value = serde_json::from_str(&desk.good(&format!("info {name} --json"))).unwrap();
        assert_eq!(known["voxels"], serde_json::json!([4, 3, 2]), "{name}");
        assert_eq!(known["values"], serde_json::json!([0.0, 2300.0]), "{name}");
        assert_eq!(known["box"][1], serde_json::json!([1.5, 2.0, 2.0]), "{name}");
    }
    desk.good("convert a.nii -o b.nrrd");
    assert_eq!(fs::read(desk.file("a.nrrd")).unwrap(), fs::read(desk.file("b.nrrd")).unwrap());
    desk.good("convert a.mha -o a.npy");
    let array = fs::read(desk.file("a.npy")).unwrap();
    assert!(array.len() == 128 + 96 && text(&array).contains("(2, 3, 4)"), "{}", array.len());
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn explain_lists_modules_and_the_savings_without_them() {
    let desk = Desk::new();
    let said = desk.good("explain torus --effect clouds --pass march --size 96x96 --samples 256");
    let line =
        |start: &str| said.lines().find(|line| line.starts_with(start)).unwrap_or_else(|| panic!("{start}: {said}"));
    assert!(line("modules ").contains("warp=fractal"), "{said}");
    assert!(line("reads      noise block: 64 x 64 x 64, ").ends_with(" MiB"), "{said}");
    line("left out   volume: the object is a formula");
    line("left out   shadow volume: light.shadows is off");
    assert!(line("cells ").contains("% proven to be empty in "), "{said}");
    assert!(said.contains(") with every sample (--empty-space sample): skipping saves "), "{said}");
    assert!(
        said.contains(", no pixel differs\n") && said.contains(") by slices (--pass slices): rays save "),
        "{said}"
    );
    let said = desk.good("explain cube --effect lit --size 32x32");
    assert!(!said.contains("cells ") && said.contains("left out   noise block: no module looks noise up"), "{said}");
    assert!(desk.files().is_empty(), "it writes no picture");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_bench_is_a_table_and_says_what_got_slower_than_a_saved_one() {
    let desk = Desk::new();
    let row = "effects/lit, 300 x 300, rays";
    let bench = |arguments: &str| {
        let output = desk.command("bench").arg(row).args(arguments.split(' ')).output().unwrap();
        (output.status.code(), text(&output.stdout), text(&output.stderr))
    };
    let (code, said, _) = bench("--quick --repeat 2 --json own.json");
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("| lit, 300 x 300, rays | ") && said.contains(" slices | 13.8 |"), "{said}");
    let saved = fs::read_to_string(desk.file("own.json")).unwrap();
    let scaled = |factor: f64, name: &str| {
        let mut json: serde_json::Value = serde_json::from_str(&saved).unwrap();
        for row in json["rows"].as_array_mut().unwrap() {
            for time in ["device_ms", "processor_ms", "wall_ms"] {
                let spread = &mut row[time];
                spread["median"] = (spread["median"].as_f64().unwrap() * factor).into();
                for end in 0..2 {
                    spread["interval"][end] = (spread["interval"][end].as_f64().unwrap() * factor).into();
                }
            }
        }
        desk.write(name, json.to_string());
    };
    scaled(1e3, "slow.json");
    scaled(1e-3, "fast.json");
    let (code, said, _) = bench("--quick --repeat 2 --baseline slow.json");
    assert_eq!(code, Some(0), "{said}");
    assert!(said.contains("faster     ") && said.contains(&format!(" times: {row}\n")), "{said}");
    let (code, said, error) = bench("--quick --repeat 2 --baseline fast.json");
    assert_eq!(code, Some(1), "{said}");
    assert!(said.contains("slower     ") && error.contains("rows are slower than the baseline"), "{said} {error}");
    let mut other: serde_json::Value = serde_json::from_str(&saved).unwrap();
    other["environment"]["device"] = "another".into();
    desk.write("other.json", other.to_string());
    let (code, said, error) = bench("--quick --repeat 1 --baseline other.json");
    assert!(code == Some(2) && error.contains("other.json: it was measured on another"), "{error}");
    assert!(said.is_empty(), "it is refused before anything is timed: {said}");
}
