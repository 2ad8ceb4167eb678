//! Level sets and fog volumes of OpenVDB: reading and refusals.

use crate::packed::zlib;
use glam::{IVec3, Vec3};
use hypertexture_shape::{Content, Facts, Opened, Shape, Volume, open, read, read_noted};

fn volume(shape: Result<Shape, hypertexture_shape::ShapeError>) -> Volume {
    match shape {
        Ok(Shape::Volume(volume)) => volume,
        other => panic!("{other:?}"),
    }
}

#[test]
#[cfg_attr(not(test_data), ignore = "needs HYPERTEXTURE_DATA")]
fn the_sphere_has_its_known_distances() {
    let folder = std::env::var("HYPERTEXTURE_DATA").unwrap();
    let sphere = volume(open(&format!("{folder}/sphere_levelset.vdb")));
    assert_eq!((sphere.size, sphere.content), ([127; 3], Content::LevelSet));
    assert!((sphere.spacing() - Vec3::splat(0.05)).abs().max_element() < 1e-7, "{}", sphere.spacing());
    assert!((sphere.origin + Vec3::splat(63.0 * 0.05)).abs().max_element() < 1e-6, "{}", sphere.origin);
    let background = sphere.values[0];
    assert!((background - 0.150024).abs() < 1e-6, "{background}");
    let band: Vec<usize> = (0..sphere.values.len()).filter(|&at| sphere.values[at].abs() != background).collect();
    let (low, high) = band
        .iter()
        .fold((9.0_f32, -9.0_f32), |(low, high), &at| (low.min(sphere.values[at]), high.max(sphere.values[at])));
    assert_eq!(band.len(), 270_638);
    assert!((low + 0.149536).abs() < 1e-6 && (high - 0.149658).abs() < 1e-6, "{low} {high}");
    for (at, value) in sphere.values.iter().enumerate() {
        let at = at as u32;
        let exact = sphere.position([at % 127, at / 127 % 127, at / 127 / 127]).length() - 3.0;
        let found = if value.abs() == background { exact.clamp(-background, background) } else { exact };
        assert!((found - value).abs() < 6.2e-5, "{at}: {exact} {value}");
    }
}

/// Compression of the values of a file.
#[derive(Clone, Copy, PartialEq)]
enum Packing {
    Plain,
    Mask,
    Zip,
}

fn text(bytes: &mut Vec<u8>, text: &str) {
    bytes.extend((text.len() as u32).to_le_bytes());
    bytes.extend(text.as_bytes());
}

/// Encoded values of a node.
fn values(bytes: &mut Vec<u8>, packing: Packing, all: &[f32], active: &[bool]) {
    bytes.push(0); // what is not active is background
    let kept = all.iter().zip(active).filter(|(_, active)| packing != Packing::Mask || **active);
    let raw: Vec<u8> = kept.flat_map(|(value, _)| value.to_le_bytes()).collect();
    if packing == Packing::Zip {
        let packed = zlib(&raw);
        bytes.extend((packed.len() as i64).to_le_bytes());
        bytes.extend(packed);
    } else {
        bytes.extend(raw);
    }
}

/// Mask of `places` bits.
fn mask(places: usize, on: impl Fn(usize) -> bool) -> Vec<u8> {
    (0..places / 8).map(|byte| (0..8).map(|bit| u8::from(on(8 * byte + bit)) << bit).sum()).collect()
}

/// File of version 224 with voxels from -8 to 7 on each axis, spacing 0.5, active where they have a value: each octant has nodes
/// of its own.
fn file(packing: Packing, class: &str, value: impl Fn(IVec3) -> Option<f32>) -> Vec<u8> {
    let mut bytes = start(1);
    grid(&mut bytes, packing, ("ball", "Tree_float_5_4_3", class), 9.0, value);
    bytes
}

/// Header of a file with this number of grids.
fn start(grids: u32) -> Vec<u8> {
    let mut bytes = b" BDV\0\0\0\0".to_vec();
    bytes.extend([224u32, 9, 0].map(u32::to_le_bytes).concat());
    bytes.push(1);
    bytes.extend([b'0'; 36]);
    bytes.extend([0, grids].map(u32::to_le_bytes).concat()); // no metadata
    bytes
}

/// Appends a grid of this name, type and class.
fn grid(
    bytes: &mut Vec<u8>,
    packing: Packing,
    (name, kind, class): (&str, &str, &str),
    background: f32,
    value: impl Fn(IVec3) -> Option<f32>,
) {
    text(bytes, name);
    text(bytes, kind);
    text(bytes, "");
    let offsets = bytes.len();
    bytes.extend([0; 24]);
    bytes.extend(match packing {
        Packing::Plain => 0u32.to_le_bytes(),
        Packing::Mask => 2u32.to_le_bytes(),
        Packing::Zip => 1u32.to_le_bytes(),
    });
    bytes.extend(1u32.to_le_bytes());
    ["class", "string", class].iter().for_each(|word| text(bytes, word));
    text(bytes, "UniformScaleTranslateMap");
    [10.0f64, 20.0, 30.0, 0.5, 0.5, 0.5].iter().for_each(|part| bytes.extend(part.to_le_bytes()));
    bytes.extend([0; 96]);
    bytes.extend(1u32.to_le_bytes());
    bytes.extend(background.to_le_bytes());
    bytes.extend([0u32, 8].map(u32::to_le_bytes).concat());
    let octants: Vec<IVec3> = (0..8).map(|at| IVec3::new(at & 1, at >> 1 & 1, at >> 2) * 8 - 8).collect();
    let voxels = |corner: IVec3| (0..512).map(move |at| corner + IVec3::new(at >> 6, at >> 3 & 7, at & 7));
    let of_leaf = |corner| -> Vec<Option<f32>> { voxels(corner).map(&value).collect() };
    for corner in &octants {
        corner
            .to_array()
            .map(|part| part.div_euclid(4096) * 4096)
            .iter()
            .for_each(|key| bytes.extend(key.to_le_bytes()));
        for (log, step) in [(5, 128), (4, 8)] {
            let places = 1usize << (3 * log);
            let part = |at: i32| at.div_euclid(step) as usize & ((1 << log) - 1);
            let own = part(corner.x) << (2 * log) | part(corner.y) << log | part(corner.z);
            bytes.extend(mask(places, |place| place == own));
            bytes.extend(mask(places, |_| false));
            values(bytes, packing, &vec![background; places], &vec![false; places]);
        }
        let leaf = of_leaf(*corner);
        bytes.extend(mask(512, |place| leaf[place].is_some()));
    }
    let blocks = bytes.len() as u64;
    for corner in &octants {
        let leaf = of_leaf(*corner);
        bytes.extend(mask(512, |place| leaf[place].is_some()));
        let all: Vec<f32> = leaf.iter().map(|value| value.unwrap_or(background)).collect();
        let active: Vec<bool> = leaf.iter().map(Option::is_some).collect();
        values(bytes, packing, &all, &active);
    }
    let end = bytes.len() as u64;
    bytes[offsets + 8..offsets + 16].copy_from_slice(&blocks.to_le_bytes());
    bytes[offsets + 16..offsets + 24].copy_from_slice(&end.to_le_bytes());
}

/// A ball of 5 voxels beside the origin, in a band of 2 voxels.
fn ball(at: IVec3) -> Option<f32> {
    let distance = 0.5 * ((at - IVec3::new(1, 0, -1)).as_vec3().length() - 5.0);
    (distance.abs() <= 1.0).then_some(distance)
}

#[test]
fn plain_masked_and_zipped_values_are_where_the_file_has_them() {
    for (packing, class, content) in [
        (Packing::Plain, "level set", Content::LevelSet),
        (Packing::Mask, "fog volume", Content::Scalar),
        (Packing::Zip, "level set", Content::LevelSet),
    ] {
        let found = volume(read("a.vdb", &file(packing, class, ball)));
        // The band reaches 7 voxels from its middle, but for the one that is in no leaf; the border is one more.
        assert_eq!((found.size, found.content), ([16, 17, 17], content));
        let low = IVec3::new(1, 0, -1) - 8;
        assert_eq!(found.origin, Vec3::new(10.0, 20.0, 30.0) + 0.5 * low.as_vec3());
        assert_eq!(found.spacing(), Vec3::splat(0.5));
        for (index, value) in found.values.iter().enumerate() {
            let place = low + IVec3::new(index as i32 % 16, index as i32 / 16 % 17, index as i32 / 272);
            let inside = place.cmpge(IVec3::splat(-8)).all() && place.cmplt(IVec3::splat(8)).all();
            assert_eq!(*value, ball(place).filter(|_| inside).unwrap_or(9.0), "{place}");
        }
    }
}

#[test]
fn files_that_are_cut_or_bent_are_refused_by_one_line_or_read() {
    let good = file(Packing::Zip, "level set", ball);
    let mut state = 7u64;
    let mut random = |end: usize| {
        state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (state >> 33) as usize % end
    };
    let mut refused = 0;
    for round in 0..1500 {
        let mut bad = good.clone();
        match round % 3 {
            0 => bad.truncate(random(good.len())),
            1 => (0..4).for_each(|_| bad[random(400)] ^= 1 << random(8)), // the header is where lies hurt
            _ => (0..4).for_each(|_| bad[random(good.len())] ^= 1 << random(8)),
        }
        if let Err(error) = read("bad.vdb", &bad) {
            let line = error.to_string();
            assert!(line.lines().count() == 1 && line.len() < 600 && line.contains("bad.vdb"), "{line}");
            refused += 1;
        } else {
            assert!(round % 3 > 0, "a file that is cut is not whole");
        }
    }
    assert!(refused > 600, "{refused}");
}

#[test]
fn two_far_leaves_and_other_classes_are_refused_by_name() {
    let refusal = |bytes: Vec<u8>| read("a.vdb", &bytes).unwrap_err().to_string();
    assert!(refusal(file(Packing::Mask, "staggered", ball)).contains("`staggered`"));
    assert!(refusal(file(Packing::Mask, "level set", |_| None)).contains("active voxels"));
    let mut far = file(Packing::Mask, "level set", ball);
    let tree = far.windows(8).position(|part| part == [0, 0, 0, 0, 8, 0, 0, 0]).unwrap() + 8;
    far[tree..tree + 4].copy_from_slice(&(-1_073_741_824i32).to_le_bytes());
    let line = refusal(far);
    assert!(line.contains("voxels in the box around the active ones") && line.contains("the limit is"), "{line}");
}

/// File of fog volumes: the voxels of [`ball`] with the index of the grid as their value.
fn fog(grids: &[(&str, &str, &str)]) -> Vec<u8> {
    let mut bytes = start(grids.len() as u32);
    for (about, number) in grids.iter().zip(1u8..) {
        grid(&mut bytes, Packing::Zip, *about, 0.0, |at| ball(at).map(|_| f32::from(number)));
    }
    bytes
}

const FLOATS: &str = "Tree_float_5_4_3";

#[test]
fn the_grid_that_is_matter_is_read_and_the_others_are_named() {
    let (fog_of, set) = (|name| (name, FLOATS, "fog volume"), |name| (name, FLOATS, "level set"));
    let vectors = ("v", "Tree_vec3s_5_4_3", "fog volume");
    for (grids, number, left) in [
        (vec![fog_of("temperature"), fog_of("density")], 2.0, "`temperature` (fog volume, floats)"),
        (vec![set("collision"), fog_of("Density"), fog_of("heat")], 2.0, "`collision` (level set, floats), `heat`"),
        (vec![fog_of("density"), fog_of("temperature")], 1.0, "`temperature` (fog volume, floats)"),
        (vec![vectors, fog_of("smoke"), fog_of("heat")], 2.0, "`v` (`Tree_vec3s_5_4_3`), `heat`"),
        (vec![("a", FLOATS, ""), fog_of("b")], 2.0, "`a` (no class, floats)"),
        (vec![("a", FLOATS, "unknown"), vectors], 1.0, "`v` (`Tree_vec3s_5_4_3`)"),
        (vec![fog_of("a"), ("density", FLOATS, "")], 2.0, "`a` (fog volume, floats)"),
        (vec![fog_of("density\u{1e}0"), fog_of("density\u{1e}1")], 1.0, "`density[1]` (fog volume, floats)"),
        (vec![("x", FLOATS, "staggered"), fog_of("b"), vectors], 2.0, "`x` (class `staggered`), `v`"),
    ] {
        let opened = read_noted("a.vdb", &fog(&grids)).unwrap();
        assert_eq!(volume(Ok(opened.shape)).range(), (0.0, number), "{grids:?}");
        assert_eq!(opened.grids.len(), grids.len());
        let notes = opened.notes.join("; ");
        assert!(
            notes.contains(&format!("is read, left out: {left}")) && notes.contains("--grid NAME or object.grid"),
            "{notes}"
        );
    }
    let alone = read_noted("a.vdb", &fog(&[fog_of("temperature")])).unwrap();
    assert_eq!((alone.notes.len(), &*alone.grids), (0, &["`temperature` (fog volume, floats)".to_string()][..]));
}

#[test]
fn a_grid_is_read_by_its_name() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.vdb").display().to_string();
    let kinds = [("density", FLOATS, "fog volume"), ("heat", FLOATS, "fog volume"), ("v", "Tree_vec3s_5_4_3", "")];
    std::fs::write(&path, fog(&kinds)).unwrap();
    for (name, number) in [("density", 1.0), ("heat", 2.0)] {
        assert_eq!(volume(Opened::with_grid(&path, Some(name)).map(|opened| opened.shape)).range(), (0.0, number));
    }
    let facts = Facts::of(&path, Some("heat")).unwrap();
    let grids = facts.lines.iter().find(|line| line.name == "grids").unwrap();
    assert_eq!(grids.words, "`density` (fog volume, floats), `heat` (fog volume, floats), `v` (`Tree_vec3s_5_4_3`)");
    assert!(facts.lines.iter().any(|line| line.words.contains("its grid `heat` is read, left out: `density`")));
    let refusal = |path: &str, name: &str| Opened::with_grid(path, Some(name)).unwrap_err().to_string();
    let line = refusal(&path, "hea\u{1b}[1m");
    assert!(
        line.contains("no grid is called `hea\\u{1b}[1m`; it has `density` (fog volume, floats), `heat`"),
        "{line}"
    );
    assert!(
        refusal(&path, "v").contains("the grid `v` (`Tree_vec3s_5_4_3`) is not supported"),
        "{}",
        refusal(&path, "v")
    );
    for other in ["torus", "head"] {
        assert_eq!(
            refusal(other, "a"),
            format!("{other}: no grid is called `a`; it has none: files of OpenVDB have grids")
        );
    }
}

#[test]
fn values_without_a_class_are_a_density_or_distances() {
    let of = |background, value: &dyn Fn(IVec3) -> Option<f32>| {
        let mut bytes = start(1);
        grid(&mut bytes, Packing::Mask, ("a", FLOATS, "unknown"), background, value);
        let opened = read_noted("a.vdb", &bytes).unwrap();
        (volume(Ok(opened.shape)).content, opened.notes.join("; "))
    };
    let (content, note) = of(0.0, &|at| ball(at).map(f32::abs));
    assert_eq!((content, &*note), (Content::Scalar, "its grid `a` has no class: its values are read as a density"));
    let (content, note) = of(9.0, &ball);
    assert_eq!(content, Content::LevelSet);
    assert!(note.contains("are read as distances, negative inside"), "{note}");
}
