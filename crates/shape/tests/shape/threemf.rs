//! 3MF: written and read back, made by hand, and damaged.

use glam::{DVec3, Vec3};
use hypertexture_shape::{Looks, Mesh, Opened, PrintBody, PrintFile, Shape, Unit, read_noted};
use std::io::{Cursor, Write};
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

const RELATIONSHIPS: &str = r#"<Relationships xmlns="http://schemas.openxmlformats.org/package/2006/relationships"><Relationship Target="/3D/a.model" Id="a" Type="http://schemas.microsoft.com/3dmanufacturing/2013/01/3dmodel"/></Relationships>"#;
/// A tetrahedron.
const SOLID: &str = r#"<mesh><vertices><vertex x="0" y="0" z="0"/><vertex x="1" y="0" z="0"/><vertex x="0" y="1" z="0"/><vertex x="0" y="0" z="1"/></vertices><triangles><triangle v1="0" v2="2" v3="1"/><triangle v1="0" v2="1" v3="3"/><triangle v1="0" v2="3" v3="2"/><triangle v1="1" v2="2" v3="3"/></triangles></mesh>"#;

fn package(parts: &[(&str, &str)]) -> Vec<u8> {
    let mut zip = ZipWriter::new(Cursor::new(Vec::new()));
    for (name, text) in [("_rels/.rels", RELATIONSHIPS)].iter().chain(parts) {
        zip.start_file(*name, SimpleFileOptions::default()).unwrap();
        zip.write_all(text.as_bytes()).unwrap();
    }
    zip.finish().unwrap().into_inner()
}

/// A package with one model: attributes, resources, and items of the build.
fn model(attributes: &str, resources: &str, items: &str) -> Vec<u8> {
    let text = format!("<model {attributes}><resources>{resources}</resources><build>{items}</build></model>");
    package(&[("3D/a.model", &text)])
}

fn opened(bytes: &[u8]) -> (Mesh, Opened) {
    let opened = read_noted("a.3mf", bytes).unwrap();
    match &opened.shape {
        Shape::Mesh(mesh) => (mesh.clone(), opened),
        other => panic!("{other:?}"),
    }
}

fn refusal(bytes: &[u8]) -> String {
    let line = read_noted("a.3mf", bytes).unwrap_err().to_string();
    assert!(line.starts_with("a.3mf: ") && line.lines().count() == 1 && line.len() < 400, "{line}");
    line
}

fn tetrahedron(at: Vec3) -> Mesh {
    let positions = vec![at, at + Vec3::X * 0.1, at + Vec3::Y / 3.0, at + Vec3::Z * 1e-7];
    Mesh { positions, triangles: vec![[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]], ..Mesh::default() }
}

#[test]
fn bodies_come_back_with_bits_names_and_colors() {
    let [one, two] = [tetrahedron(Vec3::ZERO), tetrahedron(Vec3::new(0.7, -3.25, 1e-3))];
    let colors = vec![[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]];
    let looks = Looks { normals: Vec::new(), colors: colors.clone() };
    let bodies = [
        PrintBody { name: "a <\"body\"> & more\u{1}", mesh: &one, looks: None },
        PrintBody { name: "größe", mesh: &two, looks: Some(&looks) },
    ];
    let metadata = [("Title".into(), "A & B".into()), ("tolerance".into(), "0.05 mm".into())];
    let file = PrintFile { unit: Unit::Inch, bodies: &bodies, metadata: &metadata, thumbnail: Some(b"png") };
    let [mut bytes, mut again] = [Vec::new(), Vec::new()];
    file.write(&mut bytes).unwrap();
    file.write(&mut again).unwrap();
    assert!(bytes == again);
    let (mesh, opened) = opened(&bytes);
    assert_eq!((opened.unit, opened.notes), (Some(Unit::Inch), Vec::<String>::new()));
    assert_eq!(opened.names, ["a <\"body\"> & more ", "größe"]);
    let bits = |mesh: &Mesh| -> Vec<[u32; 9]> {
        let corners = |index| mesh.corners(index).map(|corner| corner.to_array().map(f32::to_bits));
        (0..mesh.triangles.len()).map(|index| corners(index).as_flattened().try_into().unwrap()).collect()
    };
    assert_eq!(bits(&mesh), [bits(&one), bits(&two)].concat());
    assert_eq!(mesh.positions.len(), 8);
    let color = |triangle: usize, corner: usize| mesh.colors[mesh.triangles[triangle][corner] as usize];
    for (index, corners) in two.triangles.iter().enumerate() {
        (0..3).for_each(|corner| assert_eq!(color(4 + index, corner), colors[corners[corner] as usize]));
        (0..3).for_each(|corner| assert_eq!(color(index, corner), [1.0; 3]));
    }
}

#[test]
fn components_are_placed_by_their_transforms_in_inches() {
    let resources = format!(
        r#"<object id="1">{SOLID}</object><object id="2"><components><component objectid="1" transform="0 2 0 -2 0 0 0 0 2 10 20 30"/></components></object>"#
    );
    let item = r#"<item objectid="2" transform="1 0 0 0 1 0 0 0 -1 0 0 5"/><item objectid="1" printable="0"/>"#;
    let (mesh, opened) = opened(&model("unit=\"inch\"", &resources, item));
    assert_eq!(opened.unit.map(Unit::millimeters), Some(25.4));
    assert_eq!(opened.notes, ["items that are not printable are left out"]);
    let bounds = mesh.bounds();
    assert_eq!((bounds.min, bounds.max), (Vec3::new(8.0, 20.0, -27.0), Vec3::new(10.0, 22.0, -25.0)));
    assert!((mesh.signed_volume() - 8.0 / 6.0).abs() < 1e-5, "{}", mesh.signed_volume());
}

#[test]
fn a_vertex_is_split_where_colors_of_corners_differ() {
    let solid = SOLID.replace(r#"v3="1"/>"#, r#"v3="1" pid="7" p1="1"/>"#).replacen(
        r#"v3="3"/>"#,
        r#"v3="3" pid="8" p1="0" p2="1" p3="0"/>"#,
        1,
    );
    let resources = format!(
        "<basematerials id=\"7\"><base name=\"a\" displaycolor=\"#000000\"/><base name=\"b\" displaycolor=\"#FF0000\"/>\
         </basematerials><m:colorgroup id=\"8\"><m:color color=\"#00FF00FF\"/><m:color color=\"#0000FF\"/></m:colorgroup>\
         <object id=\"1\" pid=\"7\" pindex=\"0\">{solid}</object>"
    );
    let (mesh, _) = opened(&model("xmlns:m=\"m\"", &resources, "<item objectid=\"1\"/>"));
    let colors: Vec<[[f32; 3]; 3]> =
        mesh.triangles.iter().map(|corners| corners.map(|corner| mesh.colors[corner as usize])).collect();
    let [red, green, blue] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    assert_eq!(colors, [[red; 3], [green, blue, green], [[0.0; 3]; 3], [[0.0; 3]; 3]]);
    assert_eq!((mesh.positions.len(), mesh.edges().vertices), (10, 4));
}

#[test]
fn parts_of_other_files_are_read_as_slicers_write_them() {
    let root = r#"<model unit="millimeter" requiredextensions="p" xmlns:p="http://schemas.microsoft.com/3dmanufacturing/production/2015/06"><resources><object id="2" type="model"><components><component p:path="/3D/Objects/object_1.model" objectid="1" transform="1 0 0 0 1 0 0 0 1 5 0 0"/></components></object></resources><build><item objectid="2" transform="1 0 0 0 1 0 0 0 1 0 7 0"/></build></model>"#;
    let part = format!("<model unit=\"millimeter\"><resources><object id=\"1\">{SOLID}</object></resources></model>");
    let (mesh, _) = opened(&package(&[("3D/Objects/object_1.model", &part), ("3D/a.model", root)]));
    assert_eq!(mesh.bounds().min, Vec3::new(5.0, 7.0, 0.0));
    let line = refusal(&package(&[("3D/a.model", root)]));
    assert!(line.contains("3D/Objects/object_1.model"), "{line}");
}

#[test]
fn damaged_files_are_refused_by_a_line() {
    let object = format!("<object id=\"1\">{SOLID}</object>");
    let item = "<item objectid=\"1\"/>";
    let circle = "<object id=\"1\"><components><component objectid=\"1\"/></components></object>";
    let doubled = |id: usize| {
        let below = format!("<component objectid=\"{}\"/>", id + 1).repeat(2);
        format!("<object id=\"{id}\"><components>{below}</components></object>")
    };
    let doubling: String = (1..30).map(doubled).collect::<String>() + "<object id=\"30\"/>";
    for (bytes, said) in [
        (model("unit=\"furlong\"", &object, item), "`furlong`"),
        (model("requiredextensions=\"b\" xmlns:b=\"urn/beam/\"", &object, item), "b urn/beam/"),
        (model("", &object.replace("v1=\"1\"", "v1=\"9\""), item), "vertex 9 of 4"),
        (model("", &object.replace("x=\"1\"", "x=\"one\""), item), "x=one"),
        (model("", &object.replace("x=\"1\"", "x=\"1e99\""), item), "infinite"),
        (model("", &object.replace("x=\"1\"", ""), item), "vertex without x"),
        (model("", &object, "<item objectid=\"3\"/>"), "no object 3"),
        (model("", &object, "<item objectid=\"1\" transform=\"1 2\"/>"), "12 numbers"),
        (model("", circle, item), "circle"),
        (model("", &doubling, item), "circle"),
        (model("", "", ""), "no triangles"),
        (
            model("", &format!("<basematerials id=\"2\"><base displaycolor=\"red\"/></basematerials>{object}"), item),
            "`red`",
        ),
        (package(&[("3D/a.model", "<!DOCTYPE a [<!ENTITY b \"c\">]><model/>")]), "document type"),
        (package(&[("3D/a.model", "<model><resources></model>")]), "byte 18"),
        (package(&[("3D/a.model", &format!("<model {}/>", "a".repeat(70_000)))]), "64 KiB"),
        (package(&[]), "3D/a.model"),
        (b"PK\x03\x04 no more".to_vec(), "ZIP"),
    ] {
        let line = refusal(&bytes);
        assert!(line.contains(said), "{said}: {line}");
    }
    let good = model("", &object, item);
    (0..good.len()).step_by(7).for_each(|end| drop(read_noted("a.3mf", &good[..end])));
}

#[test]
fn a_file_that_unpacks_to_too_much_is_refused() {
    let vertices = "<vertex x=\"0\" y=\"0\" z=\"0\"/>".repeat(200_000);
    let line =
        refusal(&model("", &format!("<object id=\"1\"><mesh><vertices>{vertices}</vertices></mesh></object>"), ""));
    assert!(line.contains("bytes of XML"), "{line}");
}

#[test]
fn far_bodies_keep_their_doubles() {
    let mesh = Mesh { offset: DVec3::new(1e6, 0.0, -3e5), ..tetrahedron(Vec3::ZERO) };
    let mut bytes = Vec::new();
    PrintFile { bodies: &[PrintBody { name: "", mesh: &mesh, looks: None }], ..PrintFile::default() }
        .write(&mut bytes)
        .unwrap();
    let (again, _) = opened(&bytes);
    let place = |mesh: &Mesh| mesh.corners(0).map(|corner| corner.as_dvec3() + mesh.offset);
    let (own, found) = (place(&mesh), place(&again));
    assert!(own.iter().zip(found).all(|(own, found)| (*own - found).abs().max_element() < 1e-8), "{own:?} {found:?}");
}

#[test]
fn units_of_formats_are_told() {
    let unit = |name: &str, bytes: &[u8]| read_noted(name, bytes).unwrap().unit;
    let nrrd = |units: &str| {
        format!(
            "NRRD0004\ntype: uint8\ndimension: 3\nspace: right-anterior-superior\nsizes: 2 2 2\nspace directions: (1,0,0) (0,1,0) (0,0,1)\n{units}encoding: raw\n\n01234567"
        )
    };
    assert_eq!(unit("a.nrrd", nrrd("space units: \"um\" \"um\" \"um\"\n").as_bytes()), Some(Unit::Micron));
    assert_eq!(unit("a.nrrd", nrrd("space units: \"um\" \"mm\" \"um\"\n").as_bytes()), None);
    assert_eq!(unit("a.nrrd", nrrd("").as_bytes()), None);
    let meta = b"ObjectType = Image\nNDims = 3\nBinaryData = True\nDimSize = 2 2 2\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n01234567";
    assert_eq!(unit("a.mha", meta), Some(Unit::Millimeter));
    let obj = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    assert_eq!(unit("a.obj", obj), None);
    let (mut glb, mesh) = (Vec::new(), tetrahedron(Vec3::ZERO));
    hypertexture_shape::MeshFormat::Glb.write(&mesh, &mut glb).unwrap();
    assert_eq!(unit("a.glb", &glb), Some(Unit::Meter));
    for (code, expected) in [(0, None), (1, Some(Unit::Meter)), (10, Some(Unit::Millimeter)), (3, Some(Unit::Micron))] {
        let volume = hypertexture_shape::Volume {
            size: [2; 3],
            origin: Vec3::ZERO,
            steps: glam::Mat3::IDENTITY,
            values: vec![0.5; 8],
            content: hypertexture_shape::Content::Scalar,
        };
        let mut bytes = Vec::new();
        hypertexture_shape::VolumeFormat::Nifti.write(&volume, &mut bytes).unwrap();
        bytes[123] = code;
        assert_eq!(unit("a.nii", &bytes), expected);
    }
    assert_eq!(
        Unit::ALL.map(|(unit, name, symbol)| [unit.name() == name, Unit::named(symbol) == Some(unit)]),
        [[true; 2]; 6]
    );
}
