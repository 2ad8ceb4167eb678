//! Grooms: the lines of `groom` on what it paints, and of `info` on what is painted.

use super::desk::{Desk, text};
use serde_json::{Value, json};

/// A tetrahedron with a color of bytes at each vertex.
const CODES: &str = "v 0 0 0 255 0 0\nv 1 0 0 0 255 0\nv 0 1 0 0 0 255\nv 0 0 1 255 255 255
f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";

#[test]
fn values_beyond_the_limits_of_a_channel_are_told() {
    let desk = Desk::new();
    for (arguments, line) in [
        ("--length 5", "note       --length: 5 is cut to the limit 2\nnote       lengths reach 2, and hair ends"),
        ("--length -1.0", "--length: -1 is cut to the limit 0\nnote       lengths are 0 everywhere: there is no hair"),
        ("--direction vec3(-3.0,0.0,2.5)", "--direction: 2.5 is cut to the limit 1, -3 is cut to the limit -1\n"),
        ("--amount 3", "note       --amount: 3 is cut to the limit 2\n"),
        (
            "--amount -1.0",
            "--amount: -1 is cut to the limit 0\nnote       amounts are 0 everywhere: warps and DMFs do nothing",
        ),
        ("--density 1.0+p.x", ""), // beyond 2 only where no skin is
    ] {
        let said = desk.good(&format!("groom torus --side 32 {arguments}"));
        assert!(said.contains(line) && said.contains("is cut") != line.is_empty(), "{arguments}: {said}");
    }
}

#[test]
fn notes_on_a_file_that_is_object_and_color_are_said_once() {
    let desk = Desk::new();
    desk.write("codes.obj", CODES);
    for object in ["codes.obj", "torus"] {
        let output = desk.run(&format!("groom {object} --side 32 --color codes.obj"));
        let said = text(&output.stderr);
        assert!(output.status.success(), "{said}");
        assert_eq!(said.matches("read as codes of 0 to 255").count(), 1, "{object}: {said}");
    }
}

#[test]
fn a_groom_is_described_by_its_channels() {
    let desk = Desk::new();
    desk.good("groom torus --side 32 --length 0.5 --color vec3(2.0,1.0,0.5)");
    let said = desk.good("info groom.nrrd");
    for words in [
        "kind       a groom",
        "object     torus\n",
        "voxels     32 x 32 x 32\n",
        "painted    100 % of the voxels\n",
        "length     0.5 to 0.5\n",
        "color      0.5 to 2\n",
        "direction  0 to 0\n",
        "amount     1 to 1\n",
        "render torus -o picture.png --effect fur --groom groom.nrrd\n",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
    let known: Value = serde_json::from_str(&desk.good("info groom.nrrd --json")).unwrap();
    assert_eq!((&known["kind"], &known["color"]), (&json!("groom"), &json!([0.5, 2.0])));
    // Other files of four dimensions are refused as before.
    let file = String::from_utf8_lossy(&std::fs::read(desk.file("groom.nrrd")).unwrap()).into_owned();
    desk.write("other.nrrd", file.replace("hypertexture groom", "another groom"));
    assert!(text(&desk.run("info other.nrrd").stderr).contains("dimension `4` is not supported"));
}

#[test]
fn amounts_come_from_red_of_a_mesh_and_from_the_slope() {
    let desk = Desk::new();
    desk.write("codes.obj", CODES);
    let output = desk.run("groom codes.obj --side 32 --amount codes.obj"); // it warns of codes
    assert!(output.status.success(), "{}", text(&output.stderr));
    let known: Value = serde_json::from_str(&desk.good("info groom.nrrd --json")).unwrap();
    let [low, high] = [0, 1].map(|end| known["amount"][end].as_f64().unwrap());
    assert!(low < 0.3 && (high - 1.0).abs() < 1e-3, "{low} {high}");
    assert_eq!(known["color"], json!([1.0, 1.0]));
    desk.good("groom cube --side 32 --amount 2.0 --amount-by-angle 60");
    let known: Value = serde_json::from_str(&desk.good("info groom.nrrd --json")).unwrap();
    assert_eq!(known["amount"], json!([0.0, 2.0]), "none on top, all of it on the sides");
    let said = text(&desk.run("groom cube --amount-by-angle 91").stderr);
    assert!(said.contains("--amount-by-angle 91: must be from 0 to 90 degrees"), "{said}");
}

#[test]
fn a_base_that_is_the_whole_object_or_of_several_is_told() {
    let desk = Desk::new();
    let draw = "render sphere --effect noisy_sphere --size 16x16 --samples 8 -o a.png --keep-base";
    let said = desk.good(&format!("{draw} 2"));
    assert!(said.contains("effect.keep_base = 2 is the whole height of the object, 2.000"), "{said}");
    assert!(!desk.good(&format!("{draw} 0.2")).contains("keep_base"));
    let said = text(&desk.run("render eroded_cube -o a.png --keep-base 0.2").stderr);
    assert!(said.contains("effect.keep_base") && said.contains("needs a scene of one object"), "{said}");
}
