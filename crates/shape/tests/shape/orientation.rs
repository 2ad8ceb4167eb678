//! One scan in four formats and all orientations, always at the same place in the world.

use crate::dicom::files::{Desk, File, LITTLE, decimals};
use glam::{DMat3, DVec3, Mat3, Vec3};
use hypertexture_shape::{Content, Shape, ShapeError, Volume, VolumeFormat, open, read};

/// Samples along x, y and z of the world, and the distances between them.
const SIZE: [usize; 3] = [4, 3, 5];
const SPACING: [f64; 3] = [0.5, 1.5, 2.0];
/// Position of the leftmost, rearmost, lowest sample.
const ORIGIN: [f64; 3] = [-10.0, 4.25, 100.0];

/// Scan without symmetry: every voxel has another value.
fn scan() -> Volume {
    Volume {
        size: SIZE.map(|n| n as u32),
        origin: DVec3::from(ORIGIN).as_vec3(),
        steps: Mat3::from_diagonal(DVec3::from(SPACING).as_vec3()),
        values: (0..60).map(|value| value as f32).collect(),
        content: Content::Scalar,
    }
}

/// Storage order: the world axis along each axis of the file, and whether it is reversed.
type Way = [(usize, bool); 3];

fn ways() -> impl Iterator<Item = Way> {
    let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
    let signs = (0..8).map(|bits| [0, 1, 2].map(|axis| bits >> axis & 1 == 1));
    orders.into_iter().flat_map(move |order| signs.clone().map(move |signs| [0, 1, 2].map(|i| (order[i], signs[i]))))
}

/// The scan in file order, in RAS.
struct Stored {
    size: [usize; 3],
    origin: DVec3,
    steps: DMat3,
    data: Vec<u8>,
}

fn stored(way: Way) -> Stored {
    let size = way.map(|(axis, _)| SIZE[axis]);
    let (mut origin, mut columns) = (DVec3::from(ORIGIN), [DVec3::ZERO; 3]);
    for (column, (axis, is_back)) in columns.iter_mut().zip(way) {
        *column = DVec3::AXES[axis] * SPACING[axis] * if is_back { -1.0 } else { 1.0 };
        if is_back {
            origin[axis] += SPACING[axis] * (SIZE[axis] - 1) as f64;
        }
    }
    let mut data = Vec::new();
    for index in 0..60 {
        let own = [index % size[0], index / size[0] % size[1], index / (size[0] * size[1])];
        let mut at = [0; 3];
        for (i, (axis, is_back)) in way.into_iter().enumerate() {
            at[axis] = if is_back { SIZE[axis] - 1 - own[i] } else { own[i] };
        }
        data.push(((at[2] * SIZE[1] + at[1]) * SIZE[0] + at[0]) as u8);
    }
    Stored { size, origin, steps: DMat3::from_cols(columns[0], columns[1], columns[2]), data }
}

/// Reversed world axes in a space, by its letters.
fn turn(space: &str) -> DVec3 {
    let letters = space.as_bytes();
    DVec3::new(if letters[0] == b'L' { -1.0 } else { 1.0 }, if letters[1] == b'P' { -1.0 } else { 1.0 }, 1.0)
}

fn words(numbers: &[f64], between: &str) -> String {
    numbers.iter().map(|number| number.to_string()).collect::<Vec<_>>().join(between)
}

fn nrrd(stored: &Stored, space: &str, name: &str) -> Vec<u8> {
    let vector = |vector: DVec3| format!("({})", words(&(turn(space) * vector).to_array(), ","));
    let [x, y, z] = stored.size;
    let directions = [0, 1, 2].map(|axis| vector(stored.steps.col(axis))).join(" ");
    let header = format!(
        "NRRD0005\ntype: uchar\ndimension: 3\nsizes: {x} {y} {z}\nencoding: raw\nspace: {name}\n\
        space directions: {directions}\nspace origin: {}\n\n",
        vector(stored.origin)
    );
    [header.as_bytes(), &stored.data].concat()
}

/// MetaImage as ITK writes it: lengths, unit directions, and the first position in LPS.
fn meta(stored: &Stored) -> Vec<u8> {
    let [x, y, z] = stored.size;
    let (mut lengths, mut directions) = ([0.0; 3], Vec::new());
    for (axis, length) in lengths.iter_mut().enumerate() {
        let step = turn("LPS") * stored.steps.col(axis);
        *length = step.length();
        directions.extend((step / *length).to_array());
    }
    let header = format!(
        "ObjectType = Image\nNDims = 3\nBinaryData = True\nTransformMatrix = {}\nOffset = {}\nElementSpacing = {}\n\
        DimSize = {x} {y} {z}\nElementType = MET_UCHAR\nElementDataFile = LOCAL\n",
        words(&directions, " "),
        words(&(turn("LPS") * stored.origin).to_array(), " "),
        words(&lengths, " ")
    );
    [header.as_bytes(), &stored.data].concat()
}

fn nifti(stored: &Stored) -> Vec<u8> {
    let mut header = vec![0; 352];
    let mut put = |at: usize, bytes: &[u8]| header[at..at + bytes.len()].copy_from_slice(bytes);
    put(0, &348i32.to_le_bytes());
    put(40, &[3, stored.size[0] as i16, stored.size[1] as i16, stored.size[2] as i16].map(i16::to_le_bytes).concat());
    put(70, &[2, 8].map(i16::to_le_bytes).concat());
    put(108, &352f32.to_le_bytes());
    put(254, &1i16.to_le_bytes());
    for row in 0..3 {
        let parts = [0, 1, 2].map(|axis| stored.steps.col(axis)[row]);
        let parts = [parts[0], parts[1], parts[2], stored.origin[row]].map(|part| (part as f32).to_le_bytes());
        put(280 + 16 * row, &parts.concat());
    }
    put(344, b"n+1\0");
    [header, stored.data.clone()].concat()
}

fn dicom(stored: &Stored) -> Desk {
    let [columns, rows, slices] = stored.size;
    let axes = [0, 1, 2].map(|axis| turn("LPS") * stored.steps.col(axis));
    let file = |z: usize| {
        let mut file = File::slice(LITTLE, 0, turn("LPS") * stored.origin + axes[2] * z as f64);
        let [x, y] = [axes[0], axes[1]].map(|axis| axis.normalize().to_array());
        file.text(0x0020_0037, b"DS", &decimals(&[x, y].concat()));
        file.short(0x0028_0010, rows as u16);
        file.short(0x0028_0011, columns as u16);
        file.text(0x0028_0030, b"DS", &decimals(&[axes[1].length(), axes[0].length()]));
        file.text(0x0028_1052, b"DS", "0");
        file.text(0x0028_1053, b"DS", "1");
        let own = &stored.data[z * columns * rows..][..columns * rows];
        file.pixels((8, 8, 7, false), &own.iter().map(|value| i64::from(*value)).collect::<Vec<_>>());
        file.bytes()
    };
    let files: Vec<(String, Vec<u8>)> = (0..slices).map(|z| (format!("{z}"), file(z))).collect();
    Desk::new(&files.iter().map(|(name, bytes)| (&**name, bytes.clone())).collect::<Vec<_>>())
}

fn assert_stands(found: Result<Shape, ShapeError>, what: &str) {
    let Ok(Shape::Volume(found)) = found else { panic!("{what}: {:?}", found.err()) };
    let expected = scan();
    assert_eq!((found.size, found.origin, found.steps), (expected.size, expected.origin, expected.steps), "{what}");
    assert_eq!(found.values, expected.values, "{what}");
}

#[test]
fn a_scan_has_the_same_orientation_in_every_format() {
    assert_eq!(ways().count(), 48);
    for way in ways() {
        let stored = stored(way);
        for (space, names) in [
            ("RAS", ["RAS", "right-anterior-superior", "Right-Anterior-Superior-Time"]),
            ("LAS", ["LAS", "left-anterior-superior", "las"]),
            ("LPS", ["LPS", "left-posterior-superior", "LPST"]),
        ] {
            for name in names {
                assert_stands(read("a.nrrd", &nrrd(&stored, space, name)), &format!("{way:?} {name}"));
            }
        }
        assert_stands(read("a.mha", &meta(&stored)), &format!("{way:?} MetaImage"));
        assert_stands(read("a.nii", &nifti(&stored)), &format!("{way:?} NIfTI"));
        assert_stands(open(&dicom(&stored).folder()), &format!("{way:?} DICOM"));
    }
}

#[test]
fn spaces_of_headers_map_to_the_world_or_are_refused() {
    let stored = stored([(0, false), (1, false), (2, false)]);
    for name in ["scanner-xyz", "3D-right-handed", "3d-right-handed-time"] {
        assert_stands(read("a.nrrd", &nrrd(&stored, "RAS", name)), name);
    }
    let Ok(Shape::Volume(found)) = read("a.nrrd", &nrrd(&stored, "RAS", "3D-left-handed")) else { panic!("refused") };
    assert_eq!(found.origin, Vec3::new(-10.0, 4.25, -108.0));
    assert_eq!(found.values[0], 48.0); // the last slice is now the lowest
    for name in ["RRS", "right-back-superior", "left-left-superior", "space", "", "RASX"] {
        let line = read("a.nrrd", &nrrd(&stored, "RAS", name)).unwrap_err().to_string();
        assert!(line.contains("line 6: space") && line.contains("as right-anterior-superior or RAS"), "{line}");
    }
}

#[test]
fn what_is_written_says_where_its_axes_point() {
    let text = |format: VolumeFormat| {
        let mut bytes = Vec::new();
        format.write(&scan(), &mut bytes).unwrap();
        String::from_utf8_lossy(&bytes).into_owned()
    };
    let meta = text(VolumeFormat::MetaImage);
    assert!(meta.contains("TransformMatrix = -1 0 0 0 -1 0 0 0 1\nOffset = 10 -4.25 100\n"), "{meta}");
    let nrrd = text(VolumeFormat::Nrrd);
    assert!(
        nrrd.contains("space: right-anterior-superior\n") && nrrd.contains("(0.5,0,0) (0,1.5,0) (0,0,2)"),
        "{nrrd}"
    );
}
