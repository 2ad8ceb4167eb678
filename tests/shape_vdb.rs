//! OpenVDB.
#![allow(clippy::unwrap_used)] // clippy sees a test only in `#[test]`, not in what it calls
use glam::Vec3;
use hypertexture::shape::{Content, Shape, Volume, open};

fn volume(shape: Result<Shape, hypertexture::shape::ShapeError>) -> Volume {
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
    assert!((sphere.spacing - Vec3::splat(0.05)).abs().max_element() < 1e-7, "{}", sphere.spacing);
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
