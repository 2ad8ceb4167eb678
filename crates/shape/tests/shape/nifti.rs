//! NIfTI: reading, placement, refusals and their messages.

use crate::packed::{gzip, thread_seconds};
use glam::{Mat3, Vec3};
use hypertexture_shape::{Content, Shape, Volume, open, read};
use std::fs;

/// Byte order and version of a file.
#[derive(Clone, Copy, PartialEq)]
struct Order {
    is_big: bool,
    is_second: bool,
}

const LITTLE: Order = Order { is_big: false, is_second: false };
const ORDERS: [Order; 4] = [
    LITTLE,
    Order { is_big: true, is_second: false },
    Order { is_big: false, is_second: true },
    Order { is_big: true, is_second: true },
];

/// Field: its offsets in NIfTI-1 and NIfTI-2 after `nifti1.h` and `nifti2.h`, and its value.
#[derive(Clone, Copy)]
enum Field {
    Sizeof(i32),
    /// `dim[i]`.
    Dim(usize, i64),
    Datatype(i16),
    Bitpix(i16),
    /// `pixdim[i]`.
    Pixdim(usize, f64),
    Offset(f64),
    Slope(f64),
    Intercept(f64),
    Qform(i32),
    Sform(i32),
    /// Quaternion and shift.
    Quatern(usize, f64),
    /// Rows of the sform.
    Srow(usize, f64),
    Magic(&'static [u8]),
    Descrip(&'static [u8]),
}
use Field::*;

impl Order {
    fn bytes<const N: usize>(self, mut little: [u8; N]) -> Vec<u8> {
        if self.is_big {
            little.reverse();
        }
        little.to_vec()
    }

    fn put(self, header: &mut [u8], field: Field) {
        let pick = |first: usize, second: usize| if self.is_second { second } else { first };
        let number = |value: f64| match self.is_second {
            true => self.bytes(value.to_le_bytes()),
            false => self.bytes((value as f32).to_le_bytes()),
        };
        let code = |value: i32| match self.is_second {
            true => self.bytes(value.to_le_bytes()),
            false => self.bytes((value as i16).to_le_bytes()),
        };
        let size = |value: i64| match self.is_second {
            true => self.bytes(value.to_le_bytes()),
            false => self.bytes((value as i16).to_le_bytes()),
        };
        let (at, bytes) = match field {
            Sizeof(value) => (0, self.bytes(value.to_le_bytes())),
            Dim(i, value) => (pick(40 + 2 * i, 16 + 8 * i), size(value)),
            Datatype(value) => (pick(70, 12), self.bytes(value.to_le_bytes())),
            Bitpix(value) => (pick(72, 14), self.bytes(value.to_le_bytes())),
            Pixdim(i, value) => (pick(76 + 4 * i, 104 + 8 * i), number(value)),
            Offset(value) if self.is_second => (168, self.bytes((value as i64).to_le_bytes())),
            Offset(value) => (108, number(value)),
            Slope(value) => (pick(112, 176), number(value)),
            Intercept(value) => (pick(116, 184), number(value)),
            Descrip(value) => (pick(148, 240), value.to_vec()),
            Qform(value) => (pick(252, 344), code(value)),
            Sform(value) => (pick(254, 348), code(value)),
            Quatern(i, value) => (pick(256 + 4 * i, 352 + 8 * i), number(value)),
            Srow(i, value) => (pick(280 + 4 * i, 400 + 8 * i), number(value)),
            Magic(value) => (pick(344, 4), value.to_vec()),
        };
        header[at..at + bytes.len()].copy_from_slice(&bytes);
    }

    /// Header of 4 x 5 x 3 bytes with spacings 0.5, 1 and 2, and the extension word.
    fn header(self, fields: &[Field]) -> Vec<u8> {
        let length = if self.is_second { 540 } else { 348 };
        let mut header = vec![0; length + 4];
        let magic: &[u8] = if self.is_second { b"n+2\0\r\n\x1a\n" } else { b"n+1\0" };
        let own = [
            Sizeof(length as i32),
            Magic(magic),
            Dim(0, 3),
            Dim(1, 4),
            Dim(2, 5),
            Dim(3, 3),
            Datatype(2),
            Bitpix(8),
            Pixdim(1, 0.5),
            Pixdim(2, 1.0),
            Pixdim(3, 2.0),
            Offset(length as f64 + 4.0),
        ];
        own.iter().chain(fields).for_each(|field| self.put(&mut header, *field));
        header
    }

    fn file(self, fields: &[Field], data: &[u8]) -> Vec<u8> {
        [&self.header(fields), data].concat()
    }
}

/// Numbers 0 to 59.
fn data() -> Vec<u8> {
    (0..60).collect()
}

fn volume(name: &str, bytes: &[u8]) -> Volume {
    match read(name, bytes) {
        Ok(Shape::Volume(volume)) => volume,
        other => panic!("{:?}", other.map(|shape| shape.bounds())),
    }
}

/// Error of a file.
fn error(bytes: &[u8]) -> String {
    let line = read("test.nii", bytes).unwrap_err().to_string();
    assert!(line.starts_with("test.nii: ") && !line.contains('\n') && line.len() < 400, "{line}");
    for foreign in ["Some(", "None", "Err", "os error", "invalid digit", "failed to fill"] {
        assert!(!line.contains(foreign), "{line}");
    }
    line
}

/// The fields of a sform.
fn sform(rows: [[f64; 4]; 3]) -> Vec<Field> {
    let numbers = rows.as_flattened().iter().enumerate().map(|(i, number)| Srow(i, *number));
    numbers.chain([Sform(2)]).collect()
}

#[test]
fn types_orders_versions_and_packings_give_the_same_values() {
    /// Code, encoder of numbers from 0 to 59 in little endian, and their values.
    type Type = (i16, fn(f32) -> Vec<u8>, fn(f32) -> f32);
    const TYPES: [Type; 10] = [
        (2, |x| vec![x as u8], |x| x),
        (256, |x| (x as i8 - 50).to_le_bytes().into(), |x| x - 50.0),
        (4, |x| (x as i16 * 300 - 5000).to_le_bytes().into(), |x| x * 300.0 - 5000.0),
        (512, |x| (x as u16 * 1000).to_le_bytes().into(), |x| x * 1000.0),
        (8, |x| (x as i32 * 100_000 - 7).to_le_bytes().into(), |x| x * 100_000.0 - 7.0),
        (768, |x| (x as u32 * 70_000_000).to_le_bytes().into(), |x| x * 70_000_000.0),
        (1024, |x| (x as i64 * -(1 << 40)).to_le_bytes().into(), |x| x * -(40f32.exp2())),
        (1280, |x| (x as u64 * (1 << 58)).to_le_bytes().into(), |x| x * 58f32.exp2()),
        (16, |x| (x * 0.37 - 1.0).to_le_bytes().into(), |x| x * 0.37 - 1.0),
        (64, |x| f64::from(x * 0.5).to_le_bytes().into(), |x| x * 0.5),
    ];
    for order in ORDERS {
        for (code, write, worth) in TYPES {
            let bits = 8 * write(0.0).len() as i16;
            let data: Vec<u8> = (0..60)
                .flat_map(|x| {
                    let mut bytes = write(x as f32);
                    if order.is_big {
                        bytes.reverse();
                    }
                    bytes
                })
                .collect();
            let plain = order.file(&[Datatype(code), Bitpix(bits)], &data);
            for bytes in [plain.clone(), gzip(&plain)] {
                let read = volume("anything", &bytes);
                let found = (read.size, read.origin, read.spacing(), read.is_aligned(), read.content);
                assert_eq!(found, ([4, 5, 3], Vec3::ZERO, Vec3::new(0.5, 1.0, 2.0), true, Content::Scalar));
                let expected: Vec<f32> = (0..60).map(|x| worth(x as f32)).collect();
                assert_eq!(read.values, expected, "{code}");
            }
        }
    }
}

#[test]
fn values_are_scaled_before_rounding_and_slope_0_is_ignored() {
    for order in ORDERS {
        let scaled = |slope: f64, intercept: f64| {
            volume("a.nii", &order.file(&[Slope(slope), Intercept(intercept)], &data())).values[59]
        };
        assert_eq!(scaled(0.0, 7.0), 59.0);
        assert_eq!(scaled(0.0, f64::NAN), 59.0);
        assert_eq!(scaled(1.0, 0.0), 59.0);
        assert_eq!(scaled(2.5, -1000.0), 59.0 * 2.5 - 1000.0);
        assert_eq!(scaled(-1.0, 0.5), -58.5);
    }
    // A float holds no odd number so large, the sum is even.
    let large = LITTLE.file(&[Datatype(8), Bitpix(32), Slope(1.0), Intercept(1.0)], &[1, 0, 0, 1].repeat(60));
    assert_eq!(volume("a.nii", &large).values[0], 16_777_218.0);
}

#[test]
fn the_sform_comes_before_the_qform_and_that_before_distances() {
    for order in ORDERS {
        let rows = sform([[0.0, -2.0, 0.0, 7.0], [3.0, 0.5, 0.25, 8.0], [0.0, 0.0, 4.0, 9.0]]);
        // A third of a turn around (1, 1, 1): x to y, y to z, z to x.
        let turn = [Qform(1), Quatern(0, 0.5), Quatern(1, 0.5), Quatern(2, 0.5), Quatern(3, -1.0), Quatern(5, 6.0)];
        let read = volume("a.nii", &order.file(&[&rows[..], &turn].concat(), &data()));
        let columns = [Vec3::new(0.0, 3.0, 0.0), Vec3::new(-2.0, 0.5, 0.0), Vec3::new(0.0, 0.25, 4.0)];
        assert_eq!(read.steps, Mat3::from_cols(columns[0], columns[1], columns[2]));
        assert_eq!((read.origin, read.position([1, 2, 2])), (Vec3::new(7.0, 8.0, 9.0), Vec3::new(3.0, 12.5, 17.0)));
        assert_eq!(read.sample(read.position([1, 2, 2])), Some(2.0 * 20.0 + 2.0 * 4.0 + 1.0));

        // Its axes are those of the world in another order: the samples are in that order, each in its place.
        let read = volume("a.nii", &order.file(&[&turn[..], &[Sform(0)]].concat(), &data()));
        assert_eq!((read.size, read.spacing()), ([3, 4, 5], Vec3::new(2.0, 0.5, 1.0)));
        assert!(read.is_aligned() && read.origin == Vec3::new(-1.0, 0.0, 6.0));
        // Sample (1, 2, 2) of the file: 1 step of 0.5 along y, 2 of 1 along z, 2 of 2 along x.
        assert_eq!(read.sample(Vec3::new(-1.0 + 4.0, 0.5, 6.0 + 2.0)), Some(49.0));
        // From the other side: the third axis runs backwards.
        let other = volume("a.nii", &order.file(&[&turn[..], &[Pixdim(0, -1.0)]].concat(), &data()));
        assert_eq!((other.origin, other.is_aligned()), (Vec3::new(-5.0, 0.0, 6.0), true));
        assert_eq!(other.sample(Vec3::new(-1.0 - 4.0, 0.5, 6.0 + 2.0)), Some(49.0));
    }
}

#[test]
fn a_half_turn_of_a_rounded_qform_is_exact() {
    // Around an axis in the plane of x and y: rounded to f32, the squares of its parts are less than 1 together.
    let (x, y) = (0.6f64, 0.8f64);
    let fields = [Qform(1), Quatern(0, x), Quatern(1, y), Pixdim(1, 1.0), Pixdim(2, 1.0), Pixdim(3, 1.0)];
    let read = volume("a.nii", &LITTLE.file(&fields, &data()));
    let [c, s] = [x * x - y * y, 2.0 * x * y].map(|x| x as f32);
    let expected = Mat3::from_cols(Vec3::new(c, s, 0.0), Vec3::new(s, -c, 0.0), Vec3::NEG_Z);
    assert!(read.steps.abs_diff_eq(expected, 1e-6), "{}", read.steps);
}

#[test]
fn extensions_and_dimensions_of_size_1_are_skipped() {
    for order in ORDERS {
        let mut plain = order.file(&[Dim(0, 5), Dim(4, 1), Dim(5, 1), Dim(6, 9)], &[]);
        let length = plain.len();
        plain[length - 4] = 1;
        plain.extend([0xab; 48]);
        order.put(&mut plain, Offset(length as f64 + 48.0));
        let plain = [plain, data()].concat();
        for bytes in [plain.clone(), gzip(&plain)] {
            assert_eq!(volume("a.nii.gz", &bytes).values[59], 59.0);
        }
    }
}

#[test]
fn a_signed_distance_is_known_by_its_description() {
    let of = |text: &'static [u8]| volume("a.nii", &LITTLE.file(&[Descrip(text)], &data())).content;
    assert_eq!(of(b"hypertexture signed distance"), Content::SignedDistance);
    assert_eq!(of(b"hypertexture signed distances"), Content::Scalar);
    assert_eq!(of(b"signed distance"), Content::Scalar);
}

#[test]
fn a_pair_is_read_by_its_header() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name).display().to_string();
    for order in ORDERS {
        let magic: &[u8] = if order.is_second { b"ni2\0\r\n\x1a\n" } else { b"ni1\0" };
        for offset in [0, 17] {
            let header = order.header(&[Magic(magic), Offset(offset as f64)]);
            let image = [vec![9; offset], data()].concat();
            fs::write(at("v.hdr"), &header[..header.len() - 4]).unwrap();
            fs::write(at("v.img"), &image).unwrap();
            fs::write(at("w.hdr.gz"), gzip(&header)).unwrap();
            fs::write(at("w.img.gz"), gzip(&image)).unwrap();
            for name in ["v.hdr", "w.hdr.gz"] {
                let Ok(Shape::Volume(read)) = open(&at(name)) else { panic!("{name}: {:?}", open(&at(name)).err()) };
                assert_eq!((read.size, read.values[59]), ([4, 5, 3], 59.0));
            }
        }
    }
    fs::write(at("v.img"), [0; 59]).unwrap();
    let line = open(&at("v.hdr")).unwrap_err().to_string();
    assert!(line.contains("v.img") && line.contains("declares 60 bytes"), "{line}");
    fs::remove_file(at("v.img")).unwrap();
    let line = open(&at("v.hdr")).unwrap_err().to_string();
    assert!(line.contains("its data file") && line.contains("v.img"), "{line}");
    let alone = read("v.hdr", &LITTLE.header(&[Magic(b"ni1\0"), Offset(0.0)])).unwrap_err().to_string();
    assert!(alone.contains("put the file of the data beside this one"), "{alone}");
}

#[test]
fn what_is_wrong_is_said_with_its_place() {
    let rows = |row: usize, numbers: [f64; 3]| {
        let mut rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
        rows[row][..3].copy_from_slice(&numbers);
        sform(rows)
    };
    let plane = |near| sform([[1.0, near, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);
    let nan_origin = {
        let mut fields = rows(0, [1.0, 0.0, 0.0]);
        fields[3] = Srow(3, f64::NAN);
        fields
    };
    let bad: Vec<(Vec<Field>, &str)> = vec![
        (vec![Sizeof(349)], "byte 0: expected 348 or 540, the size of a NIfTI header"),
        (vec![Sizeof(0)], "byte 0: expected 348 or 540"),
        (vec![Magic(b"ni3\0")], "byte 344: expected `n+1` or `ni1`"),
        (vec![Magic(b"\0\0\0\0")], "byte 344: expected `n+1` or `ni1`"), // as Analyze 7.5 has it
        (vec![Magic(b"n+1x")], "byte 344: expected"),
        (vec![Dim(0, 0)], "byte 40: expected 1 to 7 dimensions, found 0"),
        (vec![Dim(0, 8)], "byte 40: expected 1 to 7 dimensions, found 8"),
        (vec![Dim(0, -3)], "byte 40: expected 1 to 7 dimensions, found -3"),
        (vec![Dim(0, 2)], "an image of 4 x 5 is not supported; extract one volume"),
        (vec![Dim(0, 1)], "an image of 4 is not supported"),
        (vec![Dim(0, 4), Dim(4, 20)], "an image of 4 x 5 x 3 x 20 is not supported; extract one volume"),
        (vec![Dim(0, 5), Dim(4, 1), Dim(5, 3)], "an image of 4 x 5 x 3 x 1 x 3 is not supported"),
        (vec![Dim(0, 4), Dim(4, -1)], "byte 42: expected sizes of at least 1, found 4 x 5 x 3 x -1"),
        (vec![Dim(0, 5), Dim(4, 0), Dim(5, 2)], "an image of 4 x 5 x 3 x 1 x 2 is not supported; extract one volume"),
        (vec![Dim(1, 0)], "byte 42: expected sizes of at least 1, found 0 x 5 x 3"),
        (vec![Dim(2, -5)], "byte 42: expected sizes of at least 1, found 4 x -5 x 3"),
        (vec![Dim(1, 32767), Dim(2, 32767), Dim(3, 32767)], "32767 x 32767 x 32767 voxels, the limit is 2147483648"),
        (vec![Dim(3, 4)], "the header declares 80 bytes of data (4 x 5 x 4 voxels of 1 bytes), the file holds 60"),
        (vec![Datatype(0)], "byte 70: the datatype 0 is not supported"),
        (vec![Datatype(1)], "byte 70: the datatype bits, 1 is not supported"),
        (vec![Datatype(32)], "the datatype complex64, 32 is not supported; convert it to one number for each voxel"),
        (vec![Datatype(128)], "the datatype RGB24, 128 is not supported"),
        (vec![Datatype(1536)], "the datatype float128, 1536 is not supported"),
        (vec![Datatype(1792)], "the datatype complex128, 1792 is not supported"),
        (vec![Datatype(2048)], "the datatype complex256, 2048 is not supported"),
        (vec![Datatype(2304)], "the datatype RGBA32, 2304 is not supported"),
        (vec![Datatype(-2)], "the datatype -2 is not supported"),
        (vec![Datatype(16)], "the header declares 240 bytes of data (4 x 5 x 3 voxels of 4 bytes), the file holds 60"),
        (vec![Offset(351.0)], "byte 108: expected a vox_offset of whole bytes after the header"),
        (vec![Offset(352.5)], "found 352.5"),
        (vec![Offset(-352.0)], "byte 108: expected a vox_offset"),
        (vec![Offset(f64::NAN)], "byte 108: expected a vox_offset"),
        (vec![Offset(f64::INFINITY)], "byte 108: expected a vox_offset"),
        (vec![Offset(1e30)], "byte 108: expected a vox_offset"),
        (vec![Offset(368.0)], "declares 60 bytes of data (4 x 5 x 3 voxels of 1 bytes), the file holds 44"),
        (vec![Offset(1000.0)], "after 652 bytes), the file holds 64"),
        (vec![Slope(f64::INFINITY)], "byte 112: expected a finite scl_slope"),
        (vec![Slope(1.0), Intercept(f64::INFINITY)], "byte 112: expected a finite scl_slope"),
        (vec![Slope(1e37)], "25 of 60 voxels are NaN, infinite or beyond 32-bit floats, the first has index 35"),
        (vec![Pixdim(3, f64::INFINITY)], "expected distances between samples from 1.2e-38 to 1e18"),
        (vec![Pixdim(1, 1e-40)], "byte 76: expected distances between samples"),
        (vec![Pixdim(1, 1e19)], "expected distances between samples"),
        (vec![Qform(1), Pixdim(2, 1e-40)], "byte 76: expected distances between samples"),
        (vec![Qform(1), Quatern(0, 1.0), Quatern(1, 0.5)], "byte 256: expected a quaternion"),
        (vec![Qform(1), Quatern(2, f64::NAN)], "byte 256: expected a quaternion"),
        (vec![Qform(1), Quatern(0, f64::INFINITY)], "byte 256: expected a quaternion"),
        (vec![Qform(1), Quatern(3, f64::NAN)], "expected a finite place of the first sample"),
        (vec![Qform(1), Quatern(4, 1e9)], "voxels from the origin is not supported; move it nearer"),
        (rows(0, [0.0, 0.0, 0.0]), "byte 280: expected distances between samples"),
        (plane(1.0), "a grid whose unit axes have the determinant 0.0e0 (the limit is 1e-6)"),
        (plane(1.0 + 5e-7), "is not supported; its axes lie in a plane: correct its directions"),
        (rows(2, [0.0, 0.0, f64::NAN]), "byte 280: expected distances between samples"),
        (rows(2, [f64::INFINITY, 0.0, 1.0]), "byte 280: expected distances between samples"),
        (rows(2, [0.0, 0.0, 1e30]), "byte 280: expected distances between samples"),
        (nan_origin, "expected a finite place of the first sample"),
        (
            [rows(0, [1.0, 0.5, 0.0]), vec![Descrip(b"hypertexture signed distance")]].concat(),
            "a signed distance on a grid that is not along the axes of the world is not supported; resample it",
        ),
    ];
    assert!(bad.len() > 55);
    for (fields, said) in bad {
        let file = LITTLE.file(&fields, &data());
        let line = error(&file);
        assert!(line.contains(said), "{said}: {line}");
        error(&gzip(&file));
    }
}

#[test]
fn damaged_headers_give_one_line() {
    for order in ORDERS {
        let whole = order.file(&sform([[1.0, 0.1, 0.0, 3.0], [0.0, 1.0, 0.2, 4.0], [0.0, 0.0, 1.0, 5.0]]), &data());
        for length in 1..whole.len() {
            error(&whole[..length]);
        }
        let packed = gzip(&whole);
        for length in 1..packed.len() {
            error(&packed[..length]);
        }
        for at in 0..whole.len() {
            for bits in [1, 0x80, 0xff] {
                let mut bytes = whole.clone();
                bytes[at] ^= bits;
                if let Ok(shape) = read("a.nii", &bytes) {
                    let Shape::Volume(volume) = shape else { panic!("{at}: no volume") };
                    assert!(volume.values.iter().all(|value| value.is_finite()) && volume.origin.is_finite());
                }
            }
        }
    }
}

#[test]
fn bombs_and_promises_are_refused_at_once() {
    let zeros = gzip(&vec![0; 50 << 20]);
    let bomb = |fields: &[Field]| [gzip(&LITTLE.header(fields)), zeros.clone()].concat();
    let start = thread_seconds();
    for (fields, said) in [
        (vec![Dim(1, 32767), Dim(2, 32767), Dim(3, 2)], "the header declares 2147352578 bytes"),
        (vec![Offset(268435456.0)], "(4 x 5 x 3 voxels of 1 bytes"),
    ] {
        let line = error(&bomb(&fields));
        assert!(line.contains(said), "{line}");
    }
    let wide = Order { is_second: true, ..LITTLE };
    for sizes in [[1 << 62, 1 << 62, 1 << 62], [i64::MAX, 1, 1], [1 << 31, 2, 1]] {
        let fields: Vec<Field> = (0..3).map(|i| Dim(i + 1, sizes[i])).collect();
        assert!(error(&wide.file(&fields, &data())).contains("voxels, the limit is 2147483648"));
    }
    let fields: Vec<Field> = (0..3).map(|i| Dim(i + 1, 1200)).collect();
    assert!(error(&wide.file(&fields, &data())).contains("the header declares 1728000000 bytes"));
    assert!(error(&gzip(&wide.file(&fields, &data()))).contains("at most"));
    assert!(thread_seconds() - start < 4.0);
}

#[test]
#[cfg_attr(not(test_data), ignore = "needs HYPERTEXTURE_DATA")]
fn the_engine_and_the_brain_have_their_known_voxels() {
    let folder = std::env::var("HYPERTEXTURE_DATA").unwrap();
    let open = |name: &str| match open(&format!("{folder}/{name}")) {
        Ok(Shape::Volume(volume)) => volume,
        other => panic!("{:?}", other.err()),
    };
    let facts = |volume: &Volume, iso: f32| {
        let mean = volume.values.iter().map(|value| f64::from(*value)).sum::<f64>() / volume.values.len() as f64;
        (mean, volume.values.iter().filter(|value| **value >= iso).count())
    };
    let engine = open("ct_engine.nii.gz");
    assert_eq!((engine.size, engine.steps, engine.range()), ([256, 256, 128], Mat3::IDENTITY, (0.0, 255.0)));
    let (mean, count) = facts(&engine, 80.0);
    assert!((mean - 20.694).abs() < 5e-4 && count == 1_131_002, "{mean} {count}");
    assert_eq!(facts(&engine, 180.0).1, 69_847);

    let brain = open("mri_brain_t1.nii.gz");
    assert_eq!((brain.size, brain.range(), brain.is_aligned()), ([124, 160, 140], (0.0, 252.0), false));
    let (mean, count) = facts(&brain, 50.0);
    assert!((mean - 44.438).abs() < 5e-4 && count == 929_181, "{mean} {count}");
    assert!((brain.spacing() - 1.0).abs().max_element() < 1e-3, "{}", brain.spacing());
    let tilt = brain.steps.z_axis.angle_between(Vec3::Z).to_degrees();
    assert!((18.0..20.0).contains(&tilt), "{tilt}");
}
