//! Files that are read.

use super::*;

#[test]
fn all_versions_types_and_packings_give_the_same_voxels() {
    for version in 220..=225 {
        let flags: &[u32] = if version < 222 { &[0, ZIP] } else { &[0, ZIP, MASK, MASK | ZIP, BLOSC, BLOSC | MASK] };
        for &flags in flags {
            for (is_double, is_half) in [(false, false), (false, true), (true, false), (true, true)] {
                let kind = Kind { version, is_double, is_half, flags, code: 6 };
                let read = volume(read("test.vdb", &file(kind, "level set").bytes));
                assert_eq!(read.content, Content::LevelSet);
                assert_truth(&read, 6, kind);
            }
        }
    }
}

#[test]
fn every_code_of_a_node_gives_its_inactive_voxels() {
    for code in 0..=6 {
        for is_double in [false, true] {
            let kind = Kind { code, is_double, ..PLAIN };
            let read = volume(read("test.vdb", &file(kind, "fog volume").bytes));
            assert_eq!(read.content, Content::Scalar);
            assert_truth(&read, code, kind);
        }
    }
}

/// Writer of a transform, its origin and its spacing.
type Map<'a> = (&'a dyn Fn(&mut File), Vec3, Vec3);

#[test]
fn linear_transforms_place_the_voxels() {
    let affine = |rows: [f64; 16]| {
        move |file: &mut File| {
            file.text("map", "AffineMap");
            file.floats("scale", &rows);
        }
    };
    let scale = |name: &'static str, before: &'static [f64], scale: [f64; 3]| {
        move |file: &mut File| {
            file.text("map", name);
            file.floats("", before);
            file.floats("", &scale);
            file.floats("", &[1.0; 12]);
        }
    };
    let maps: [Map; 6] = [
        (&scale("UniformScaleTranslateMap", &[1.0, 2.0, 3.0], [2.0; 3]), Vec3::new(1.0, 2.0, 3.0), Vec3::splat(2.0)),
        (
            &scale("ScaleTranslateMap", &[1.0, 2.0, 3.0], [1.0, 2.0, 4.0]),
            Vec3::new(1.0, 2.0, 3.0),
            Vec3::new(1.0, 2.0, 4.0),
        ),
        (&scale("ScaleMap", &[], [1.0, 2.0, 4.0]), Vec3::ZERO, Vec3::new(1.0, 2.0, 4.0)),
        (&scale("UniformScaleMap", &[], [0.25; 3]), Vec3::ZERO, Vec3::splat(0.25)),
        (
            &|file| {
                file.text("map", "TranslationMap");
                file.floats("", &[5.0, 6.0, 7.0]);
            },
            Vec3::new(5.0, 6.0, 7.0),
            Vec3::ONE,
        ),
        (
            &affine([2.0, 0.0, 0.0, 0.0, 0.0, 3.0, 0.0, 0.0, 0.0, 0.0, 4.0, 0.0, 7.0, 8.0, 9.0, 1.0]),
            Vec3::new(7.0, 8.0, 9.0),
            Vec3::new(2.0, 3.0, 4.0),
        ),
    ];
    for (map, origin, scale) in maps {
        let mut file = header(224, 1);
        head(&mut file, PLAIN, "fog volume", map);
        tree(&mut file, PLAIN);
        let volume = volume(read("test.vdb", &file.bytes));
        for index in [[0, 0, 0], [9, 0, 0], [0, 17, 0], [3, 4, 129]] {
            let voxel = Vec3::from([4087.0, -1.0, -1.0]) + Vec3::from(index.map(|n| n as f32));
            assert_eq!(volume.position(index), origin + scale * voxel, "{index:?}");
        }
    }
    let refused = |map: &dyn Fn(&mut File)| {
        let mut file = header(224, 1);
        head(&mut file, PLAIN, "fog volume", map);
        tree(&mut file, PLAIN);
        error(&file.bytes)
    };
    let flat = refused(&affine([2.0, 0.0, 0.0, 0.0, 4.0, 0.0, 0.0, 0.0, 0.0, 0.0, 4.0, 0.0, 7.0, 8.0, 9.0, 1.0]));
    assert!(flat.contains("its axes lie in a plane"), "{flat}");
    let projective = refused(&affine([2.0, 0.0, 0.0, 0.5, 0.0, 3.0, 0.0, 0.0, 0.0, 0.0, 4.0, 0.0, 7.0, 8.0, 9.0, 1.0]));
    assert!(projective.contains("0, 0, 0, 1 in its last column, found [0.5, 0.0, 0.0, 1.0]"), "{projective}");
    let frustum = refused(&|file| file.text("map", "NonlinearFrustumMap"));
    assert!(frustum.contains("the transform `NonlinearFrustumMap` is not supported"), "{frustum}");
    let far = refused(&scale("ScaleTranslateMap", &[1e9, 0.0, 0.0], [1.0; 3]));
    assert!(far.contains("voxels from the origin"), "{far}");
    let nothing = refused(&scale("ScaleMap", &[], [1.0, 0.0, 1.0]));
    assert!(nothing.contains("expected distances between samples"), "{nothing}");
}

/// File written by OpenVDB 10.0.1.
fn written(text: &str) -> Vec<u8> {
    let mut bytes = Vec::new();
    ZlibDecoder::new(&STANDARD.decode(text).unwrap()[..]).read_to_end(&mut bytes).unwrap();
    bytes
}

#[test]
fn a_ball_that_openvdb_wrote_has_its_distances() {
    let ball = volume(read("ball.vdb", &written(BALL)));
    assert_eq!((ball.size, ball.content), ([13; 3], Content::LevelSet));
    let center = Vec3::new(0.25, -0.5, 1.0);
    assert_eq!(ball.bounds().center(), center);
    let mut near = 0;
    for (index, &value) in ball.values.iter().enumerate() {
        let index = index as u32;
        let distance = ball.position([index % 13, index / 13 % 13, index / 169]).distance(center) - 1.0;
        if value.abs() < 0.5 {
            assert!((value - distance).abs() < 1e-6, "{index}: {value} {distance}");
            near += 1;
        } else {
            assert!(value == 0.5_f32.copysign(distance), "{index}: {value} {distance}");
        }
    }
    assert_eq!(near, 862);
}

#[test]
fn fog_that_openvdb_wrote_behind_a_grid_of_vectors_is_read() {
    let fog = volume(read("fog.vdb", &written(FOG)));
    assert_eq!((fog.size, fog.content), ([10, 11, 6], Content::Scalar));
    assert_eq!(fog.position([0; 3]), Vec3::new(-4.0, -1.0, -3.0) * 0.5);
    for (index, &value) in fog.values.iter().enumerate() {
        let [x, y, z] = [index % 10, index / 10 % 11, index / 110].map(|n| n as f32);
        let (x, y, z) = (x - 4.0, y - 1.0, z - 3.0);
        let is_in = (-3.0..5.0).contains(&x) && (0.0..9.0).contains(&y) && (-2.0..2.0).contains(&z);
        assert_eq!(value, if is_in { x * 0.125 + y * 3.0 + z * 0.5 } else { 0.0 }, "{x} {y} {z}");
    }
}

#[test]
fn the_first_suitable_grid_is_read_or_all_are_named() {
    let grid = |file: &mut File, class: &str| {
        let start = file.bytes.len();
        head(file, PLAIN, class, &scaled);
        tree(file, PLAIN);
        start
    };
    let mut file = header(224, 2);
    grid(&mut file, "staggered");
    grid(&mut file, "fog volume");
    assert_truth(&volume(read("test.vdb", &file.bytes)), 0, PLAIN);

    let mut file = header(224, 2);
    let first = grid(&mut file, "staggered");
    let at = file.at["type"];
    grid(&mut file, "LEVEL SET");
    let line = error(&file.bytes);
    assert!(
        line.contains("a file of `a grid[2]` (class `staggered`), `a grid[2]` (class `LEVEL SET`) is not supported"),
        "{line}"
    );
    file.bytes[at + 4..at + 20].copy_from_slice(b"Tree_vec3s_5_4_3");
    assert!(
        error(&file.bytes).contains("`a grid[2]` (`Tree_vec3s_5_4_3`), `a grid[2]` (class"),
        "{}",
        error(&file.bytes)
    );
    // Without offsets nothing is behind a grid that cannot be read.
    let at = file.at["has offsets"];
    file.bytes[at] = 0;
    assert!(error(&file.bytes).contains("the offset of the end of a grid"), "{first}");
    // But one that can be read needs none.
    let mut file = self::file(PLAIN, "fog volume");
    let at = file.at["has offsets"];
    file.bytes[at] = 0;
    let at = file.at["start"];
    file.bytes[at..at + 24].fill(0);
    assert_truth(&volume(read("test.vdb", &file.bytes)), 0, PLAIN);
}

/// Fog volume of single voxels in leaves of their own.
pub(super) fn voxels(origins: &[[i32; 3]]) -> Vec<u8> {
    let mut file = header(224, 1);
    head(&mut file, PLAIN, "fog volume", &scaled);
    file.number("buffers", 1);
    file.value(PLAIN, "background", 0.0);
    file.number("tiles", 0);
    file.number("children", origins.len() as u32);
    for origin in origins {
        let local = origin.map(|n| n.rem_euclid(4096) as usize);
        let place = |shift: u32, side: usize| local.iter().fold(0, |place, n| place * side + (n >> shift & (side - 1)));
        let (of_32, of_16) = (place(7, 32), place(3, 16));
        file.put("child", &origin.map(|n| (n - n.rem_euclid(4096)).to_le_bytes()).concat());
        file.mask("", 32_768, |place| place == of_32);
        file.mask("", 32_768, |_| false);
        file.bytes.push(0);
        file.mask("", 4096, |place| place == of_16);
        file.mask("", 4096, |_| false);
        file.bytes.push(0);
        file.mask("leaf", 512, |place| place == 0);
    }
    let blocks = file.bytes.len() as u64;
    for _ in origins {
        file.mask("", 512, |place| place == 0);
        file.bytes.push(0);
        file.bytes.extend(1.0_f32.to_le_bytes());
    }
    let offsets = [blocks, file.bytes.len() as u64].map(u64::to_le_bytes);
    let at = file.at["blocks"];
    file.bytes[at..at + 16].copy_from_slice(offsets.as_flattened());
    file.bytes
}

#[test]
fn two_distant_voxels_are_refused_with_their_box_size() {
    let near = volume(read("test.vdb", &voxels(&[[-8, 8, 16], [0, 0, 4088]])));
    assert_eq!(near.size, [11, 11, 4075]);
    assert_eq!(near.values.iter().filter(|value| **value == 1.0).count(), 2);
    assert_eq!(near.sample(Vec3::new(-8.0, 8.0, 16.0) * 0.5), Some(1.0));
    assert_eq!(near.sample(Vec3::new(0.0, 0.0, 4088.0) * 0.5), Some(1.0));
    for (other, size) in
        [([1 << 20, 1 << 20, 1 << 20], "1048579 x 1048579 x 1048579"), ([4096, 4096, 8], "4099 x 4099 x 11")]
    {
        let line = error(&voxels(&[[0; 3], other]));
        assert!(
            line.contains(&format!("{size} voxels in the box around the active ones, the limit is 67108864")),
            "{line}"
        );
    }
    let line = error(&voxels(&[[i32::MIN; 3], [i32::MAX - 4095; 3]]));
    assert!(line.contains("multiples of 4096 up to 2^30"), "{line}");
}

/// A ball of radius 1 around (0.25, -0.5, 1), voxels of 0.25, Blosc and active mask.
const BALL: &str = "eNrtnV1oW8kVx8/Vlb/ysZY3khtso3VWm3Y/Eq8cO1lnK6nF1C+lgpBNTVpMvbIjd73IH8SKooAfLrUIoYg2C92CH0r1sI8X1oZC\
    Hmw5CrSxAyn4Qe/evBqWRDTKZsFInbl3jqLYMdvYSdiu/78wPvdOxldn5p7zn3GYjNt7f9FPgq9E2Uc22omhyPDQiRMnj0eiPdHj\
    3T2dw8eHPhg6fTzaPdTd0xXpOn2qq9NqKIpTlKFILOYS9tzFaHRwJDYRiQ+eHOwe7JJtrqiHfvkTzbKTp2xbK0q9KDWiDMciU1Oy\
    Yip+cXT89w3iKhZNRGPtU9H4QXEzMhqLDg4NTSQHxyJJ+Q2J6HDX6AH1FF0U+S2bWo6OP9Vyo1wuf1u2cXHL4YmxyYvRqanRifEn\
    H++RPYpNTA23v9ceGY6PJqLtiUjsUnSqib/tQjQWuRK9MCh6ekF+6iDXyIoLouKA6rTlm/VVp1+JC4fW6TSElUXeu0XpFuVRQze9\
    Q59Qm+jEMZqkb2lV1NeKGo2aHPupSaslxwFy1FKjgzrOWA99jb0Zi44NDl2JR6dkf0fH46e65bie/+NRq1mlr4mJZDQmenxpPP5U\
    w9/ZPlovcjwyFn0yEPxqG4X99fjoyMTFsY+GI7FoODJpf8vqz57Pun7+bOvfxtIWa8cOWc+TztODcrlSAAAAAAAAAAAA8EPHwBAA\
    AAAAAAAAAAB7AJeyDq1Lbl2wtqe4MCx7HQNDAGF4ccJgGIYyBnYeAQAAAAAAAAAAewcNQwAAAAAAAAAAAOwNsPsIbEXHEEAYdiwM\
    PdOlUkmYUqlcLgtjnV5F09Lef75dR5qmWV91XUakNHpl5xJ2MAEAAAAAAAAAAK8KA0MAAAAAAAAAAACAlwp2L+1RDAwBeIXCUIk3\
    7DoCAAAAAAAAAABeKTi/CAAAAAAAAAAAAC8d7D7am+B0JPBShGG6x7alkn1RLtsXwk7vxA9N/ROpXv1Ppd+P3/5mIEoAAAAAAAAA\
    AAAAAAAAAAAAAACAF8AONykYGDkA9qYwGJJnWGJLbLfje3B+Ev7fKAAAAAAAAAAAAAAAAAAAAAAAAPCC2NnuI5y8A8DeFIZSuVxe\
    Xl6W9v7yzHLlflpe3C9Tj7Ryd1FPqWRZ6pkulUpPnqzpkq3WvpBWs6282n6TkL2DycCbAgAAAAAAAAAAAAAAAAAAAAAAAP7P2XaT\
    goGxAQDCsEkY+FSkLXYHn4HziwAAAAAAAAAAAAAAAAAAAAAAAIAfANttMsDpSABAGLYIQ7lcts5Buq9suWJL08r2SFuyDU33PP1c\
    XdeebdVWJO1lbEmq/s1yx6o61iasLLKurbcYygysh6TNh9dCi55syB2et+z/8BHqgCh1YBQfIKUOlNLL383yjKZpwlgDIIz11PKM\
    bY842OkjTlNcyyLr3KLuT6L8p64t05ZfdC/m2xZTZmqxLeM2yXRnXqOu/N18Ez2sd1+bW5275s6bc7lcbs68S6s5yq2KV/pWW+ZD\
    etiUSR3O5DKHU+7DuaQ/mTtsZpLmYzOZoZz/MT3251ykXSK9n5zH6IHrWu4LaqEvcnNJ8l71UnLV33L1aoufb22Pegd6wx7xp9fT\
    arZ6egfCwqPwgPAofCgsPQr7fAs+Xzhs+hLehM88RAte8i5Ij3oHpEcDrTdvJW7dbA3f9PYV+7w3zVt9hXih7xYlinGKFxOWR85+\
    0qVHPq+fHpHf6+ujyyuXqW+h+Ghl5VGRb22PiuvFtex8dq2YnU3PZovr82kjPb8uPFrLr0mP5kc8Bc/I/Frak9xIetJ5o7BBGwVD\
    eFRclx6tz/pvJG/4Z+f9G6k7qQ1/+kaqo78jdcNI3uk3+u8knxqjkY0G43OjYcOTMm7fu22kCnc+v3fv8zt8+5Hw6I2QRs2vB9+l\
    I8FAA3UHA9RAmovqHKIi+Dp9Hchms4FQKJhdWlrKButJ7yRHg+xve2BJE19CXUQnSaun69mQbCNaPVda2EeT8VFl9tFlH1elxxlh\
    ZZF1MiXuHspbqSHTRKaGaaatdBGZZdXxvfy7a74Rq+2cz2Ol0OpCISjr+X7HqcwX7ipHpUI5VZ380O96CIsSixSLFosY1Wj88E5n\
    QFzLIuvkB3wtY6nFTrZMm8orlW8i2TiBOKFa6B+iGWfMm6T/lLRfigfYuSFyxE4DlR4iNzjeOf7FA0QzDvAnD7BDeb2oolZFswhl\
    Dk8OV/EA0YzjkR/QLIMvuJ80B52xAm0fvRsMttqxdTjwpniniud9RSzhLOn0VtWrcqvXJOtkPMi44ViR97Tb3wz6SdWHnRf2vKqT\
    gSkDL9U6awWqtNWBLIOYA3hzu83zQfVcsdvDBPWyGqYtVml/ZS7guaEyV9gUquaGFZEFshTU3HBTlEKLmhNY+1naWa5zptdr5h5f\
    vfp4HxUaVSTzBMH6ryT+beoUj6ynxt9Q68ODVhKoDOC450hPkz5CzkbqEtH/Z0pxOpwm57/I+Xdyuqyp6QTpn5LzETlXZU2naPsZ\
    6f8k/SRNKq/tLqhJhCcLngtY3xOFy5cL3vjKSlx2QeUSzyg8Yag54ekuWGnIU5HKPM61ShdE/okucEJWd0Hk6wlyfkq63YVarVO0\
    rXRBeW13Qc06PLvw5METQrLj9u2Ojf579/plF1Q28xTEM4yaRGQXDIO7YAmBUgHOfc72SheEAogusCRUd0Eoxqa3INpWuqC8vi66\
    4BGK8VUwEAxVpqRQHYkpi2rJFaghV7CG6o6L+ft90jtIq6MjS9m36RD5qeY96WkLzdBnoZCa1M7Q0aVAmrS/kDvbSPQO1Viz3oek\
    nybtOh3NBv8tfal5n+ivpNWS/jc1wI0Ocp5RurTLYzhX6InK5+XUoepk5syJ8k1d3mybW8ylcmYudZcyq+6cKRLCbKZvWt3X8nOL\
    q+65RZEvbZQx20Qwh81enyfR6jUTrYdoYCHsFa29VuuwL+zzLIgiQrOXBsxeETdr6aInm5zdSCdn88Z6YV68K2Mj3UwPaudH1jzZ\
    wrwnK6KgaKyni+IVibE/FwwFQsEGMaChwH6qaybaL8f+Out0aNf/M2C7tTFrHgs230td3PUPBPLl2AK52Wozyi5Lq9mmPLP89MK5\
    pG1dG5fUXP0H6UAHCx0LHwuhUhglbax0rHxKCIN04OFBFjUWOV5NW/pHMyxuZy21+zHpTTQn4oHXCLYXrFWsXaxlSiSUOrFYsXgp\
    LbO8YF1inWLZkhImvGB9OmsJlu2FXE+ohYbtBcsNyw/LkcpzJTCsN6w/So4sL1haWGp41SxVSHjBEnPW0hzbCxG/vFo5J7zwi9Wq\
    Rv6sDObJrKUngVpyOEhrpnovfSAWwm8QdVNjkOraQwEvXV8KKOE4S7W/pTo3/SjYLFcuB1z0sR37u/65cruFLy9YeW0gY54Xs7zw\
    lQvjZ7WrXthw7vwX/NPVlA==";

/// Box of doubles, Blosc without a mask, after a grid of vectors.
const FOG: &str = "eNrtnN9PHFUUx88M2+U3u7W/gNUuBe0PW+guLIVpbZYaE2MibROrabTpsixDu+3CEpYSGhOdhD42qW998EESffChiT74aOwk/gM8\
    khgTTNq0MVgb02iiFTz33tkfwA5sS1Ep3w+Zc2fPnLk/zjl7uW1OaHr9jfeImeWrihRaqCtkdHWbXa1xwwy1Rtr7I63dg4nB1o7B\
    zo640RkeDHcbwlAXxnyN+1mcGTXN2LiZ6MjEOmORWIcwGHd69LSp9nun9fBVzlctX4PJlBnr709PxIbiE1vES9xHssbpWgxRttwy\
    Oexq6c9aJtJDI6NmJpNMD3tZlxkbTQ5fEK/1p9KZxNas2YCZil81B2KpdHxAjBLLaoRih9N5jo+cti77+pA5FOu/OmZmRM/J4bEj\
    kQq+mTpRKc1ykxlPT5gpntKV4bFFhtnOhUeG40NmfqbSsT4W7w4nB9OjQ+8k4imzNz6i7B9G17edXdYuckM2U1b5DAAAAAAAAAAA\
    AAAAAAAAAAAAAICNh/eMV93o2h4PfxQqErrtfHddIwqSRgvgv+XiaRkjxAPxAIjHRokHissA2MSHS79WcLi0+YYvoROHy2P0dJv1\
    LrW3bOjX81Ss0cVP9743W+YtA1PPN/Wq9FsExl+4tjk14WK6Bkd3N2pZ1l9016eLx38sfcgsfSgKyQfM4Uxy7Koo6pZ16APpK/0p\
    M1+IvuAUngdnVPvtT6r1OIsWNdmJVDyTyddfi2r4wfSFpvF06sqQuXKlerYbkaArV6r/zfMWA89z+0wr1U8WCd9RGZOwx+LWcj6L\
    mDTz9Vjz0XWq4utL+oaS9BlPPqB5iF3brfy6Son7RP22XDBXLHFv0vK+XlziXhA510L32eiTtdRTvPW7tMsL4JeeMzxSrcKWawEA\
    AAAAAAAAALDeWHABAAAAAAAAAAAA1hPvaY+6UUXu4oOHhE6UVlSjaFRyT9WQwB1wB9xRojvAc46F/7gGKxwspqngYGHJhCGhEweL\
    g1TaXlmu9pL/lXmp2C6U/L5Li6pNAAAAAAAAAADg3wV/xQEAAAAAAAAAAADrDao3UZ8Hd8AdqN4ET4SG/7oGKx0sNnv1ZpkLJb/v\
    0uZQVZwWUg0AAAAAAAAAAAAAAAAAAAAAAADY2KB6E/V5cAfc8eyrN/G3GQHYvAeL57V60y4RN8fYJbalgAJqAAAAAAAAAAAAAAAA\
    AAAAAAAAYOOD6k3U58EdcMczdwf+NiMAm/hg8bxWb5aViJtjykps14pbVam3XCsIjJ9v+BI6EZi6vC9+Vss9ldN8alhkfaWz7PFT\
    kK8aY4qaQlTjJ59OwZpPyOen6oA95Whq6/qowe6goM2mXbPUFyLuktuBXJcfGr/T3A3d+JM0Pxkv0HaWu6mJ5Su0l+VBOsQyRGGW\
    HRRh+Yjus3xMOstttIMnErToNeM3utNHxjyV8cgWHeNx2Ly5YJzbdJvHiWan/jZb/cBWPfxTqj9dWu81Wu7Pa+Tmz4JJRdl9N/RL\
    UZt6LLoUZc9YdFZZ1RdYHaEutnImvOQZz3/Rs1JxS1qvXiQ59BKS44ZIjs91MSE/NRYmxksqMWoD9tfZxKjhWNnEqSH0hswMr59U\
    l4lcl2ljhuxJ3dhClRzsnVTPcg81s9xH+1m2UhvLMLWzjFAny2maZumlKpa7qEHmwnEeaYbHK6dq+flNNczugmFuU3TSmfn7bPGE\
    fzzc7fv71HmRFnkxuSQvBpbGPh3tou5JGft7y5/xYhY9W2vJuXeqSF5MuebFRUfzQcBKO0GvDlghMnheYRX1JppamiH81E4U5EjA\
    Pq30fTSb1fdWfafVybuFc2qsH+XSNep+SLM+OiH+Aeslj06R7bSzmjSdwk20p0Jq9tI+pTlErUoTprDSRCiiNHM0ozQabZEadmJv\
    5D5NX5ZanbzKbgftknY+0o6H75B9VmrLqFxp+aW6eW1rxYRUc/KqTjl/1eucwkrDWZydSnt2Kp0VcoFOzA9kF8h7mI+/crlEXRip\
    /FXzkX6+wBv2KruVvdqv7VtFsvaWa9YafDWyptHyiSmfi3JYR+lclU5HOZhblY7Dp3S+ee2ymOt59XJLdmFd1CVfPy8XFex+pMkl\
    Xcx/VaUZLzxv9qBg0Wv9leyNF8nu+KrZfSpgJdYtu53Ff8HXWRK/NtkBFVTjo7fYGY28wTVTC8v9dIBlGx1m2S63wk65Fdp0h2Ul\
    1cpNr5e3xvsjZFQR9240UMAv85Y32DneGqvFPKTVLD1kqxrys1UjvciyhV5meYBeZXmYQnKUDjnKkUXzbHHmGc0Hyk8ng1GO1C8F\
    Zms9/HhvFknPm67p2cZXTB49NUqK3PyYkuILZIt9lf3OTTYnL+WTLUbd/MNvqHQ0FrSksEgqiwZpIQ4OjsWDgvX9A/yll2E=";
