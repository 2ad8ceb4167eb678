//! Volumes with missing or odd fields that other programs accept: the assumption and its note.

use crate::dicom::files::{Desk, LITTLE, at, expected, series};
use crate::packed::{bzip2, gzip, zlib};
use glam::{DVec3, Vec3};
use hypertexture_shape::{Opened, Shape, Volume, read, read_noted};
use std::fs;

/// The volume, and its only note.
fn noted(opened: Opened) -> (Volume, String) {
    let Shape::Volume(volume) = opened.shape else { panic!("no volume") };
    (volume, opened.notes.join("; "))
}

fn volume(name: &str, bytes: &[u8]) -> (Volume, String) {
    noted(read_noted(name, bytes).unwrap_or_else(|error| panic!("{error}")))
}

fn nrrd(header: &str, data: &[u8]) -> Vec<u8> {
    [format!("NRRD0004\nendian: little\n{header}\n\n").as_bytes(), data].concat()
}

fn meta(header: &str, data: &[u8]) -> Vec<u8> {
    [format!("ObjectType = Image\n{header}\nElementDataFile = LOCAL\n").as_bytes(), data].concat()
}

/// Header of 4 x 5 x 3 bytes from byte `offset` on, with further fields as offsets and bytes.
fn nifti(offset: f32, fields: &[(usize, &[u8])], data: &[u8]) -> Vec<u8> {
    let mut header = vec![0; 352];
    let numbers = [1.0f32, 0.5, 1.0, 2.0].map(f32::to_le_bytes).concat();
    let all: [(usize, &[u8]); 6] = [
        (0, &348i32.to_le_bytes()),
        (40, &[3, 0, 4, 0, 5, 0, 3, 0]),
        (70, &[2, 0, 8, 0]),
        (76, &numbers),
        (108, &offset.to_le_bytes()),
        (344, b"n+1\0"),
    ];
    all.iter().chain(fields).for_each(|(at, bytes)| header[*at..at + bytes.len()].copy_from_slice(bytes));
    [&header, data].concat()
}

fn data() -> Vec<u8> {
    (0..60).collect()
}

fn values() -> Vec<f32> {
    (0..60).map(|value| value as f32).collect()
}

fn floats(values: &[f32]) -> Vec<u8> {
    values.iter().flat_map(|value| value.to_le_bytes()).collect()
}

const NRRD: &str = "type: uchar\ndimension: 3\nsizes: 4 5 3";
const META: &str = "NDims = 3\nDimSize = 4 5 3\nElementType = MET_UCHAR";

#[test]
fn voxels_that_are_nan_are_outside() {
    let mut known = vec![7.0, -3.0, 900.0, 12.0, 0.5, 1.0];
    let mut holes = known.clone();
    (holes[0], holes[4]) = (f32::NAN, f32::NEG_INFINITY);
    (known[0], known[4]) = (-3.0, -3.0); // the lowest that is known
    let fields: [(usize, &[u8]); 3] =
        [(40, &[3, 0, 3, 0, 2, 0, 1, 0]), (70, &[16, 0, 32, 0]), (108, &352f32.to_le_bytes())];
    for (name, bytes) in [
        ("a.nrrd", nrrd("type: float\ndimension: 3\nsizes: 3 2 1\nencoding: raw", &floats(&holes))),
        ("t.nrrd", nrrd("type: float\ndimension: 3\nsizes: 3 2 1\nencoding: text", b"NaN -3 900 12 -inf 1")),
        ("a.nii", nifti(352.0, &fields, &floats(&holes))),
        ("a.mha", meta("NDims = 3\nDimSize = 3 2 1\nElementType = MET_FLOAT", &floats(&holes))),
    ] {
        let (found, note) = volume(name, &bytes);
        assert_eq!(found.values, known, "{name}");
        assert_eq!(note, "2 of 6 voxels are NaN or infinite: they are outside of the object, -3");
    }
    // A distance is outside where it is large.
    let marked = "type: float\ndimension: 3\nsizes: 3 2 1\nencoding: raw\nhypertexture content:=signed distance";
    let holes = [7.0, f32::NAN, f32::INFINITY, -1.0, 2.0, 3.0];
    assert_eq!(volume("a.nrrd", &nrrd(marked, &floats(&holes))).0.values, [7.0, 7.0, 7.0, -1.0, 2.0, 3.0]);
    for bad in [[f32::NAN; 6], [0.0, 1.0, f32::INFINITY, 0.0, 0.0, f32::NAN]] {
        let line = read("a.nrrd", &nrrd("type: float\ndimension: 3\nsizes: 3 2 1\nencoding: raw", &floats(&bad)));
        assert!(line.unwrap_err().to_string().contains("of 6 voxels are NaN, infinite or beyond 32-bit floats"));
    }
}

#[test]
fn axes_of_one_sample_are_left_out_until_three_are_left() {
    let body = "type: uchar\nencoding: raw\nspace: RAS\ndimension: ";
    let directions = "space directions: none (0.5,0,0) (0,1,0) (0,0,2)";
    for (header, said) in [
        (
            format!("{body}4\nsizes: 1 4 5 3\nkinds: list domain domain domain\n{directions}"),
            "of its 4 dimensions, number 1",
        ),
        (format!("{body}4\nsizes: 4 5 3 1\nspacings: 0.5 1 2 NaN"), "of its 4 dimensions, number 4"),
        (
            format!("{body}5\nsizes: 1 4 5 3 1\nkinds: vector space space space time\nspacings: nan 0.5 1 2 9"),
            "of its 5 dimensions, number 1, 5",
        ),
    ] {
        let (found, note) = volume("a.nrrd", &nrrd(&header, &data()));
        assert_eq!(
            (found.size, found.spacing(), found.values),
            ([4, 5, 3], Vec3::new(0.5, 1.0, 2.0), values()),
            "{header}"
        );
        assert_eq!(note, format!("{said} has one sample and is left out"));
    }
    let header = "NDims = 4\nTransformMatrix = -1 0 0 0 0 -1 0 0 0 0 1 0 0 0 0 1\nOffset = -1 -2 3 9\n\
        ElementSpacing = 0.5 1 2 1\nDimSize = 4 5 3 1\nElementType = MET_UCHAR";
    let (found, note) = volume("a.mha", &meta(header, &data()));
    assert_eq!((found.size, found.origin, found.values), ([4, 5, 3], Vec3::new(1.0, 2.0, 3.0), values()));
    assert_eq!(note, "of its 4 dimensions, number 4 has one sample and is left out");
    for (name, bytes) in [
        ("a.nrrd", nrrd("type: uchar\nencoding: raw\ndimension: 4\nsizes: 2 4 5 3", &data())),
        ("a.nrrd", nrrd("type: uchar\nencoding: raw\ndimension: 2\nsizes: 12 5", &data())),
        ("a.mha", meta("NDims = 4\nDimSize = 2 4 5 3\nElementType = MET_UCHAR", &data())),
    ] {
        assert!(read(name, &bytes).unwrap_err().to_string().contains("one volume of 3 dimensions"));
    }
}

#[test]
fn unknown_spacings_are_1_and_negative_ones_run_backwards() {
    let (found, note) =
        volume("a.nrrd", &nrrd(&format!("{NRRD}\nencoding: raw\nspacings: NaN 2 nan\naxis mins: NaN 1 0"), &data()));
    assert_eq!((found.spacing(), found.origin), (Vec3::new(1.0, 2.0, 1.0), Vec3::new(0.0, 1.0, 0.0)));
    assert!(note.contains("spacings is NaN 2 NaN: 1 is used where it is unknown"), "{note}");
    let (found, note) = volume("a.nrrd", &nrrd(&format!("{NRRD}\nencoding: raw\nspacings: 1 2 -3"), &data()));
    assert_eq!((found.origin, found.values[0], found.values[40]), (Vec3::new(0.0, 0.0, -6.0), 40.0, 0.0));
    assert!(note.contains("run backwards"), "{note}");
    let (found, note) = volume("a.mha", &meta(&format!("{META}\nElementSpacing = 1 1 -1"), &data()));
    assert_eq!((found.origin, found.values[40]), (Vec3::new(0.0, 0.0, -2.0), 0.0));
    assert_eq!(note, "ElementSpacing is below 0: these axes run backwards, as ITK reads it");
    let (found, note) = volume("a.mha", &meta(&format!("{META}\nElementSpacing = 1 nan 2"), &data()));
    assert_eq!(found.spacing(), Vec3::new(1.0, 1.0, 2.0));
    assert_eq!(note, "ElementSpacing is 1 NaN 2: 1 is used where it is unknown");
    for (pixdim, spacing, said) in [
        ([1.0, 0.0, f32::NAN, 2.0], Vec3::new(1.0, 1.0, 2.0), "pixdim is 0 NaN 2: 1 is used where it is unknown"),
        ([0.0; 4], Vec3::ONE, "pixdim is 0 0 0: 1 is used where it is unknown"),
        ([1.0, 0.5, -1.0, 2.0], Vec3::new(0.5, 1.0, 2.0), "pixdim is 0.5 -1 2: their magnitudes are used"),
    ] {
        let bytes = nifti(352.0, &[(76, &pixdim.map(f32::to_le_bytes).concat())], &data());
        let (found, note) = volume("a.nii", &bytes);
        assert_eq!((found.spacing(), found.values), (spacing, values()));
        assert!(note.starts_with(said), "{note}");
    }
}

#[test]
fn an_orientation_that_its_matrix_does_not_have_is_left_out() {
    let of = |code: &str, matrix: &str| {
        volume("a.mha", &meta(&format!("{META}\nAnatomicalOrientation = {code}\nTransformMatrix = {matrix}"), &data()))
            .1
    };
    // The sides that the axes come from, as ITK has it, and those that they point to, as others have it.
    for (code, matrix) in [
        ("RAI", "1 0 0 0 1 0 0 0 1"),
        ("LPS", "1 0 0 0 1 0 0 0 1"),
        ("LPI", "-1 0 0 0 -1 0 0 0 1"),
        ("AIR", "0 1 0 0 0 1 1 0 0"),
        ("???", "-1 0 0 0 -1 0 0 0 1"),
    ] {
        assert_eq!(of(code, matrix), "", "{code}");
    }
    let note = of("RAI", "-1 0 0 0 -1 0 0 0 1");
    assert_eq!(note, "AnatomicalOrientation `RAI` is left out: by its matrix the axes come from LPI");
}

#[test]
fn hexadecimal_digits_are_bytes() {
    let digits = |bytes: &[u8]| bytes.iter().map(|byte| format!("{byte:02x}")).collect::<Vec<_>>().join("\n");
    let header = format!("{NRRD}\nencoding: hex");
    for text in
        [digits(&data()), digits(&data()).to_uppercase().replace('\n', ""), format!("{} \r\n\n", digits(&data()))]
    {
        assert_eq!(volume("a.nrrd", &nrrd(&header, text.as_bytes())).0.values, values());
    }
    let short = "type: short\ndimension: 3\nsizes: 2 1 1\nencoding: hex";
    assert_eq!(volume("a.nrrd", &nrrd(short, b"0102 feff")).0.values, [513.0, -2.0]);
    let whole = digits(&data());
    for (text, said) in [
        (whole[..whole.len() - 1].to_string(), "an odd number of digits"),
        (whole.replace("0a", "0g"), "a character that is not a hexadecimal digit"),
        (
            whole[..whole.len() - 2].to_string(),
            "declares 60 bytes of data (4 x 5 x 3 voxels of 1 bytes), the file holds 59",
        ),
        ("00".into(), "the file holds at most 1"),
    ] {
        let line = read("a.nrrd", &nrrd(&header, text.as_bytes())).unwrap_err().to_string();
        assert!(line.contains(said), "{said}: {line}");
    }
}

#[test]
fn zeros_after_packed_data_are_ignored_other_bytes_refused() {
    let whole = nifti(352.0, &[], &data());
    type Make = Box<dyn Fn(&[u8]) -> Vec<u8>>;
    let makes: [(&str, Make); 3] = [
        ("a.nii.gz", Box::new(move |behind| [&gzip(&whole), behind].concat())),
        ("a.nrrd", Box::new(|behind| nrrd(&format!("{NRRD}\nencoding: gzip"), &[&gzip(&data()), behind].concat()))),
        ("a.nrrd", Box::new(|behind| nrrd(&format!("{NRRD}\nencoding: bzip2"), &[&bzip2(&data()), behind].concat()))),
    ];
    for (name, make) in &makes {
        for zeros in [0, 1, 512, 100_000] {
            let (found, note) = volume(name, &make(&vec![0; zeros]));
            assert_eq!(found.values, values());
            let said = format!("{zeros} zeros after the compressed data are left out");
            assert_eq!(note, if zeros == 0 { String::new() } else { said });
        }
        for behind in [&b"junk"[..], &[0, 0, 0, 1], &gzip(&[0; 10])[..5], &bzip2(&[0; 10])[..5]] {
            let line = read(name, &make(behind)).unwrap_err().to_string();
            assert!(line.contains("compressed data damaged after"), "{line}");
        }
    }
    let header = format!("{META}\nCompressedData = True");
    let (found, note) = volume("a.mha", &meta(&header, &[zlib(&data()), vec![0; 9]].concat()));
    assert_eq!((found.values, &*note), (values(), "9 zeros after the compressed data are left out"));
}

#[test]
fn gzip_and_zlib_stand_for_each_other() {
    let header = format!("{META}\nCompressedData = True");
    let (found, note) = volume("a.mha", &meta(&header, &gzip(&data())));
    assert_eq!(found.values, values());
    assert_eq!(note, "its data is compressed by gzip, contrary to the header");
    let (found, note) = volume("a.nrrd", &nrrd(&format!("{NRRD}\nencoding: gzip"), &zlib(&data())));
    assert_eq!(found.values, values());
    assert_eq!(note, "its data is compressed by zlib, contrary to the header");
}

#[test]
fn a_slope_that_is_no_number_and_an_offset_of_0_are_none() {
    let nan = f32::NAN.to_le_bytes();
    let (found, note) = volume("a.nii", &nifti(352.0, &[(112, &nan)], &data()));
    assert_eq!((found.values, &*note), (values(), "scl_slope is NaN: its values are read unscaled"));
    let (found, note) = volume("a.nii", &nifti(352.0, &[(112, &2f32.to_le_bytes()), (116, &nan)], &data()));
    assert_eq!((found.values[59], &*note), (118.0, "scl_inter is NaN: 0 is used"));
    for text in ["nan", ""] {
        let desk = series(LITTLE, |file, _| file.text(0x0028_1053, b"DS", text));
        let (found, note) = noted(Opened::of(&desk.folder()).unwrap());
        assert_eq!(found.values, expected(|value, _| value as f64 - 1024.0));
        assert_eq!(note.contains("RescaleSlope is NaN"), text == "nan", "{note}");
    }
    let (found, note) = volume("a.nii", &nifti(0.0, &[], &data()));
    assert_eq!(found.values, values());
    assert_eq!(note, "vox_offset is 0: its data is read right after the header, from byte 352");
}

#[test]
fn a_pair_of_analyze_stands_as_its_orientation_says() {
    // Where the first, second and third axis point, by the orientation: R is +x, A is +y, S is +z.
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    for (code, axes) in [
        (0, [DVec3::NEG_X, DVec3::Y, DVec3::Z]),
        (1, [DVec3::NEG_X, DVec3::Z, DVec3::Y]),
        (2, [DVec3::Y, DVec3::Z, DVec3::NEG_X]),
        (3, [DVec3::NEG_X, DVec3::NEG_Y, DVec3::Z]),
        (4, [DVec3::NEG_X, DVec3::NEG_Z, DVec3::Y]),
        (5, [DVec3::Y, DVec3::NEG_Z, DVec3::NEG_X]),
    ] {
        for packed in [false, true] {
            let header = &nifti(0.0, &[(344, &[0; 4]), (252, &[code])], &[])[..348];
            let end = if packed { ".gz" } else { "" };
            let pack = |bytes: &[u8]| if packed { gzip(bytes) } else { bytes.to_vec() };
            fs::write(at(&format!("v.hdr{end}")), pack(header)).unwrap();
            fs::write(at(&format!("v.img{end}")), pack(&data())).unwrap();
            let name = at(&format!("v.hdr{end}")).display().to_string();
            let (found, note) = noted(Opened::of(&name).unwrap());
            // Sample (3, 1, 2) of the file.
            let place = axes[0] * 3.0 * 0.5 + axes[1] + axes[2] * 2.0 * 2.0;
            assert_eq!(found.sample(place.as_vec3()), Some(3.0 + 4.0 + 40.0), "{code}");
            assert!(
                note.starts_with("Analyze 7.5 has no origin") && note.ends_with(&format!("(orientation {code})")),
                "{note}"
            );
        }
    }
    let scaled = &nifti(0.0, &[(344, &[0; 4]), (112, &2f32.to_le_bytes()), (116, &9f32.to_le_bytes())], &[])[..348];
    fs::write(at("v.hdr"), scaled).unwrap();
    assert_eq!(noted(Opened::of(&at("v.hdr").display().to_string()).unwrap()).0.range(), (0.0, 118.0));
    fs::write(at("v.hdr"), &nifti(0.0, &[(344, &[0; 4]), (252, &[6])], &[])[..348]).unwrap();
    let line = Opened::of(&at("v.hdr").display().to_string()).unwrap_err().to_string();
    assert!(line.contains("byte 252: expected an orientation of Analyze 7.5 from 0 to 5, found 6"), "{line}");
}

#[test]
fn slices_whose_positions_are_rounded_stand_at_even_distances() {
    // 0.625 mm apart, each rounded to a tenth.
    let rounded = |z: usize| ((5.0 + 0.625 * z as f64) * 10.0).round() / 10.0;
    let desk = Desk::new(&[]);
    let file = |z: usize| crate::dicom::files::File::slice(LITTLE, z, DVec3::new(10.0, -20.0, rounded(z))).bytes();
    (0..28).for_each(|z| fs::write(desk.path(&format!("{z:02}")), file(z)).unwrap());
    let (found, note) = noted(Opened::of(&desk.folder()).unwrap());
    assert_eq!(found.size, [4, 3, 28]);
    assert!((found.spacing().z - 0.625).abs() < 5e-4 && (found.origin.z - 5.0).abs() < 0.05, "{}", found.spacing());
    assert!(note.starts_with("the positions of its slices are rounded, by up to 0.0"), "{note}");
    // A missing slice exceeds rounding.
    fs::remove_file(desk.path("14")).unwrap();
    let line = desk.error("");
    assert!(line.contains("none missing, found 1.3 mm between `13` and `15`, others are 0.6 mm apart"), "{line}");
}

#[test]
fn a_localizer_among_the_slices_is_left_out() {
    let with = |edit: &dyn Fn(&mut crate::dicom::files::File)| {
        let desk = series(LITTLE, |_, _| {});
        let mut other = crate::dicom::files::File::slice(LITTLE, 0, at(7));
        edit(&mut other);
        fs::write(desk.path("scout"), other.bytes()).unwrap();
        noted(Opened::of(&desk.folder()).unwrap())
    };
    let worth = |value: i64, _| 0.5 * value as f64 - 1024.0;
    type Edit = fn(&mut crate::dicom::files::File);
    let edits: [Edit; 4] = [
        |file| file.text(0x0020_0037, b"DS", "0\\1\\0\\0\\0\\-1"),
        |file| file.text(0x0028_0030, b"DS", "2\\2"),
        |file| {
            file.short(0x0028_0010, 1);
            file.pixels((16, 16, 15, true), &[5; 4]);
        },
        |file| {
            file.elements.remove(&0x0020_0032);
            file.text(0x0028_0004, b"CS", "RGB");
        },
    ];
    for edit in edits {
        let (found, note) = with(&edit);
        assert_eq!((found.size, found.values), ([4, 3, 3], expected(worth)));
        let text = "of another size or orientation than the other slices, and left out";
        assert_eq!(note, format!("1 of its 4 pictures (`scout`): {text}"));
    }
}
