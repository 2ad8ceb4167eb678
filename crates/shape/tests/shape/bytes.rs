//! Damaged and random files: every reader returns a shape or an error of one line, within bounds of memory. On good files the
//! readers agree with the crates `tobj` and `stl_io`.

use glam::{Mat3, Vec3};
use hypertexture_shape::{Content, Shape, Volume, VolumeFormat, read};
use proptest::prelude::*;
use std::io::Cursor;

const NAMES: [&str; 8] = ["a.obj", "a.stl", "a.nrrd", "a.nhdr", "a.mha", "a.nii.gz", "a.hdr", "a"];

/// Good files to damage.
fn seeds() -> Vec<(&'static str, Vec<u8>)> {
    let values = (0..60).map(|i| i as f32 * 0.1 - 2.0).collect();
    let volume =
        Volume { size: [3, 4, 5], origin: Vec3::ZERO, steps: Mat3::IDENTITY, values, content: Content::SignedDistance };
    let mut compressed = Vec::new();
    VolumeFormat::Nrrd.write(&volume, &mut compressed).unwrap();
    let oblique = Volume { steps: Mat3::from_rotation_x(0.3), content: Content::Scalar, ..volume };
    let others = [
        (VolumeFormat::MetaImage, "a.mha"),
        (VolumeFormat::Nifti, "a.nii"),
        (VolumeFormat::NiftiGzip, "a.nii.gz"),
        (VolumeFormat::Nifti, "a"),
    ];
    let others = others.map(|(format, name)| {
        let mut bytes = Vec::new();
        format.write(&oblique, &mut bytes).unwrap();
        (name, bytes)
    });
    let mut raw = b"NRRD0004\ntype: short\ndimension: 3\nsizes: 2 2 2\nendian: big\nencoding: raw\n\
        space directions: (-1,0,0) (0,2,0) (0,0,1)\nspace origin: (1,2,3)\n\n"
        .to_vec();
    raw.extend(0..16);
    let mut stl = Vec::new();
    stl_io::write_stl(&mut stl, triangles().iter()).unwrap();
    let own = [
        ("a.nrrd", compressed),
        ("a.nrrd", raw),
        ("a.stl", stl),
        ("a.stl", text_stl()),
        ("a.obj", OBJ.as_bytes().to_vec()),
    ];
    own.into_iter().chain(others).collect()
}

const OBJ: &str = "# a tent and a concave face\nmtllib none.mtl\no tent\nv 0 0 0\nv 1 0 0.5 \nv 1 1e0 0\nv -0 1 .5\n\
    vt 0 0\nvn 0 0 1\nusemtl red\nf 1/1/1 2/1/1 3/1/1\ng other\ns off\nf -4//1 -2//1 -1//1\nv 0.2 0.5 0\nf 1 2 3 5\n";

fn triangles() -> Vec<stl_io::Triangle> {
    let corner = |i: usize| stl_io::Vertex::new([i as f32 * 0.5, (i * i % 7) as f32, (i % 3) as f32]);
    let triangle =
        |i| stl_io::Triangle { normal: stl_io::Normal::new([0.0; 3]), vertices: [i, i + 1, i + 2].map(corner) };
    (0..5).map(triangle).collect()
}

fn text_stl() -> Vec<u8> {
    let mut text = String::from("solid strip\n");
    for triangle in triangles() {
        text += "facet normal 0 0 0\nouter loop\n";
        for [x, y, z] in triangle.vertices.map(|vertex| vertex.0) {
            text += &format!("vertex {x} {y} {z}\n");
        }
        text += "endloop\nendfacet\n";
    }
    (text + "endsolid strip\n").into_bytes()
}

/// Invariants for any bytes.
fn check(name: &str, bytes: &[u8]) -> Result<(), TestCaseError> {
    match read(name, bytes) {
        Err(error) => prop_assert_eq!(error.to_string().lines().count(), 1, "{}", error),
        Ok(Shape::Mesh(mesh)) => {
            prop_assert!(!mesh.triangles.is_empty() && mesh.positions.iter().all(|p| p.is_finite()));
            prop_assert!(mesh.triangles.iter().flatten().all(|&corner| (corner as usize) < mesh.positions.len()));
            prop_assert!(mesh.triangles.len() <= bytes.len());
        }
        Ok(Shape::Volume(volume)) => {
            let voxels: u64 = volume.size.iter().map(|&n| u64::from(n)).product();
            prop_assert_eq!(voxels, volume.values.len() as u64);
            prop_assert!(volume.values.iter().all(|v| v.is_finite()) && volume.spacing().min_element() > 0.0);
            prop_assert!(volume.sample(volume.bounds().center()).is_some());
            prop_assert!(volume.values.capacity() <= 1032 * bytes.len());
        }
        Ok(Shape::Solid(solid)) => prop_assert!(false, "{solid:?} from bytes"),
    }
    Ok(())
}

/// Change of a good file: overwrite, insert or cut at fractions of its length.
fn damage(mut bytes: Vec<u8>, changes: &[(f64, u8, u8)]) -> Vec<u8> {
    for &(place, kind, byte) in changes {
        let at = (place * bytes.len() as f64) as usize;
        match kind {
            0 => bytes.truncate(at),
            1 => bytes.insert(at, byte),
            2 if at < bytes.len() => drop(bytes.remove(at)),
            // Digits are the bytes that matter most in a header.
            3 if at < bytes.len() => bytes[at] = b'0' + byte % 10,
            _ if at < bytes.len() => bytes[at] ^= byte,
            _ => {}
        }
    }
    bytes
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 2_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn arbitrary_bytes_give_a_shape_or_one_line(
        bytes in prop::collection::vec(any::<u8>(), 1..400), name in 0..NAMES.len()
    ) {
        check(NAMES[name], &bytes)?;
    }

    #[test]
    fn arbitrary_bytes_behind_a_good_start_give_a_shape_or_one_line(
        bytes in prop::collection::vec(any::<u8>(), 0..200), seed in 0..9_usize, cut in 0.0..1.0
    ) {
        let (name, good) = seeds().swap_remove(seed);
        let start = &good[..(cut * good.len() as f64) as usize];
        check(name, &[start, &bytes, b"\n"].concat())?;
    }

    #[test]
    fn damaged_files_give_a_shape_or_one_line(
        changes in prop::collection::vec((0.0..1.0, 0..6_u8, any::<u8>()), 1..8), seed in 0..9_usize
    ) {
        let (name, good) = seeds().swap_remove(seed);
        check(name, &damage(good, &changes))?;
    }

    #[test]
    fn obj_statements_in_any_order_give_a_shape_or_one_line(
        lines in prop::collection::vec(
            "(v|f|vn|surf|l|#)( -?[0-9]{1,2}(\\.[0-9])?(/[0-9]?){0,2}| nan| 1e39){0,7} ?\\\\?",
            1..30,
        )
    ) {
        check("a.obj", lines.join("\n").as_bytes())?;
    }

    #[test]
    fn nrrd_fields_of_any_value_give_a_shape_or_one_line(
        sizes in "[0-9]{1,12} [0-9]{1,3} [0-9]{1,3}", kind in "uchar|float|double|int", encoding in "raw|gzip|ascii|bzip2",
        extra in "(spacings: |axis mins: |space origin: |space directions: |centers: )[-0-9e(), ]{0,20}",
        data in 0..300_usize
    ) {
        let header = format!(
            "NRRD0005\ntype: {kind}\ndimension: 3\nsizes: {sizes}\nendian: little\nencoding: {encoding}\n{extra}\n\n"
        );
        check("a.nrrd", &[header.as_bytes(), &vec![0; data]].concat())?;
    }
}

#[test]
fn the_undamaged_files_are_read() {
    for (name, bytes) in seeds() {
        assert!(read(name, &bytes).is_ok(), "{name}: {:?}", read(name, &bytes).err());
    }
}

/// Peak address space of this process in bytes, with reserved but untouched memory.
#[cfg(target_os = "linux")]
fn peak_address_space() -> u64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap();
    let line = status.lines().find(|line| line.starts_with("VmPeak:")).unwrap();
    line.split_whitespace().nth(1).unwrap().parse::<u64>().unwrap() * 1024
}

#[cfg(target_os = "linux")]
#[test]
fn headers_that_promise_gigabytes_take_no_memory() {
    let before = peak_address_space();
    let mut stl = vec![b'x'; 84 + 50];
    stl[80..84].copy_from_slice(&40_000_000_u32.to_le_bytes());
    assert!(read("a.stl", &stl).is_err());
    for encoding in ["raw", "gzip", "bzip2", "ascii"] {
        let header = format!(
            "NRRD0005\ntype: float\ndimension: 3\nsizes: 1024 1024 2000\nendian: little\nencoding: {encoding}\n\n"
        );
        let mut bytes = header.into_bytes();
        // Enough bytes that gzip data could hold the declared size, were it no damaged data.
        bytes.resize(9 << 20, 7);
        assert!(read("a.nrrd", &bytes).is_err());
    }
    let taken = peak_address_space() - before;
    // 9 MiB for the bytes, 16 for the first values; the rest is room for the arenas of the other tests' threads.
    assert!(taken < 1 << 30, "{} MiB", taken >> 20);
}

#[test]
fn our_obj_reader_agrees_with_tobj() {
    let options = tobj::LoadOptions { single_index: true, triangulate: true, ..Default::default() };
    // Without the concave face, which tobj cuts as a fan.
    let text = &OBJ[..OBJ.rfind("v 0.2").unwrap()];
    let no_materials = |_: &std::path::Path| Err(tobj::LoadError::OpenFileFailed);
    let (models, _) = tobj::load_obj_buf(&mut text.as_bytes(), &options, no_materials).unwrap();
    let theirs: Vec<Vec3> = models
        .iter()
        .flat_map(|model| model.mesh.indices.iter().map(|&i| Vec3::from_slice(&model.mesh.positions[3 * i as usize..])))
        .collect();
    assert_eq!(corners("a.obj", text.as_bytes()), theirs);
}

#[test]
fn our_stl_reader_agrees_with_stl_io() {
    for (name, bytes) in seeds().into_iter().filter(|(name, _)| *name == "a.stl") {
        let mesh = stl_io::read_stl(&mut Cursor::new(&bytes)).unwrap();
        let theirs: Vec<Vec3> =
            mesh.faces.iter().flat_map(|face| face.vertices.map(|i| Vec3::from(mesh.vertices[i].0))).collect();
        assert_eq!(corners(name, &bytes), theirs);
    }
}

fn corners(name: &str, bytes: &[u8]) -> Vec<Vec3> {
    match read(name, bytes) {
        Ok(Shape::Mesh(mesh)) => (0..mesh.triangles.len()).flat_map(|triangle| mesh.corners(triangle)).collect(),
        other => panic!("{other:?}"),
    }
}
