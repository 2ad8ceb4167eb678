//! Settings reported as ignored change no bit of the picture; the others do.

use crate::common::{is_whole, picture, subject, with_gpu};
use crate::pictures::engine::{projection, view};
use hypertexture::gpu::Gpu;
use hypertexture::render::{unused_overrides, unused_settings};
use hypertexture::scene::{Pass, Scene, preset};
use hypertexture::shader;
use hypertexture::shape::Groom;
use std::path::Path;

/// The device that made the goldens.
const MADE_ON: &str = include_str!("../golden/made_on.txt");

/// Every field that a hand may set, with a value that no scene here has.
const FIELDS: [(&str, &str); 68] = [
    ("quality.seed", "7"),
    ("quality.jitter", "hash"),
    ("quality.order", "back_to_front"),
    ("quality.target", "unorm8"),
    ("quality.fold_zero_terms", "false"),
    ("quality.integration", "segment"),
    ("quality.anisotropy", "4"),
    ("quality.filter", "exact"),
    ("quality.block_size", "32"),
    ("quality.turbulence_cells", "2"),
    ("quality.block_format", "unorm8"),
    ("quality.block_blur", "2"),
    ("quality.wrap", "mirror"),
    ("quality.early_termination", "0.4"),
    ("quality.msaa", "4"),
    ("quality.supersampling", "2"),
    ("quality.samples", "17"),
    ("effect.gradient", "central"),
    ("effect.gradient", "three"),
    ("effect.bandlimit", "clamp"),
    ("effect.octaves", "1"),
    ("effect.octaves", "7"),
    ("effect.noise", "procedural"),
    ("effect.turbulence", "procedural"),
    ("effect.noise_repeat", "noise_block"),
    ("effect.turbulence_repeat", "turbulence_block"),
    ("effect.weights", "cubic"),
    ("effect.opacity", "beer"),
    ("effect.opacity_rate", "3"),
    ("effect.medium", "material"),
    ("effect.surface", "unlit"),
    ("effect.softness", "quadratic"),
    ("effect.project", "gradient"),
    ("effect.absorption", "tinted"),
    ("effect.environment", "studio"),
    ("light.shadows", "true"),
    ("light.shadow_resolution", "64"),
    ("light.position", "[2, 1, 5]"),
    ("light.color", "#ff0000"),
    ("light.intensity", "0.3"),
    ("light.ambient", "#ff00ff"),
    ("material.color", "#00ff00"),
    ("material.specular", "0.9"),
    ("material.specular_power", "3"),
    ("transfer.curve", "steps"),
    ("transfer.stops", "[{ at = 0.0, color = '#000000' }, { at = 1.0, color = '#00ff00', density = 0.7 }]"),
    ("camera.projection", "parallel"),
    ("camera.azimuth", "77"),
    ("camera.elevation", "-20"),
    ("camera.zoom", "1.3"),
    ("camera.pan", "[0.1, 0.2]"),
    ("camera.field_of_view", "45"),
    ("camera.time", "3"),
    ("camera.shutter", "0.5"),
    ("camera.clip", "[1, 0, 0, 0]"),
    ("object.resolution", "48"),
    ("object.iso", "0.01"),
    ("object.up", "z"),
    ("object.distance", "true"),
    ("object.stretch", "[1, 0.7, 1]"),
    ("object.shell", "0.1"),
    ("object.inner_iso", "-0.1"),
    ("object.outer_iso", "0.2"),
    ("object.field_encoding", "distance32"),
    ("light.method", "half_angle"),
    ("light.translucency", "0.3"),
    ("light.transport", "#204060"),
    ("light.scatter", "0.7"),
];

/// Settings that are ignored without a report: a highlight of strength 0 that is kept is another program. What cannot be
/// decided is not said.
const UNDECIDED: [(&str, &str); 1] = [("fur, blurred", "quality.fold_zero_terms = false")];

/// A scene of few pixels on a formula, whose object looks different from every side.
fn scene(effect: &str, object: &str, change: impl FnOnce(&mut Scene)) -> Scene {
    let mut scene = preset(effect).unwrap();
    scene.object.input = object.into();
    (scene.image.size, scene.quality.samples, scene.light.shadow_resolution) = ([20, 20], 24, 32);
    scene.object.resolution = 32;
    scene.light.position = [-5.0, 2.0, 1.0]; // so that the object shades itself
    change(&mut scene);
    scene
}

/// Whether pictures with and without each field are equal, against what is said.
fn check(gpu: &Gpu, name: &str, base: &Scene) {
    check_fields(gpu, name, base, &FIELDS);
}

fn check_fields(gpu: &Gpu, name: &str, base: &Scene, fields: &[(&str, &str)]) {
    let library = shader::shipped();
    let plain = picture(gpu, &library, base, &subject(base, &library));
    let (mut said, mut wrong) = (Vec::new(), Vec::new());
    for &(field, value) in fields {
        let mut set = base.clone();
        set.set_field(field, value).unwrap();
        if set == *base || set.check(&library).is_err() {
            continue; // what is refused is told
        }
        let subject = subject(&set, &library);
        let is_said = !unused_overrides(&library, &subject, base, &set).is_empty();
        let is_same = picture(gpu, &library, &set, &subject).pixels == plain.pixels;
        said.extend(is_said.then_some(field));
        let undecided = UNDECIDED.contains(&(name, format!("{field} = {value}").as_str()));
        // Another driver than the goldens' may filter with anisotropy as it does without.
        let by_driver = field == "quality.anisotropy" && is_same && !MADE_ON.contains(&gpu.info().driver);
        if is_said != (is_same && !undecided) && !by_driver {
            wrong.push(format!("{field} = {value}: said {is_said}, the pictures are the same: {is_same}"));
        }
    }
    println!("{name}: ignored are {}", said.join(", "));
    assert!(wrong.is_empty(), "{name}:\n{}", wrong.join("\n"));
    assert!(!said.is_empty() && said.len() < fields.len() / 2 + 5);
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn what_is_ignored_is_what_changes_no_bit() {
    let blurred = |s: &mut Scene| (s.quality.pass, s.quality.supersampling) = (Pass::Slices, 3);
    with_gpu(|gpu| {
        check(gpu, "lit, slices", &scene("lit", "torus", |s| s.quality.pass = Pass::Slices));
        check(gpu, "fire, rays", &scene("fire", "torus", |_| ()));
        if !is_whole() {
            return;
        }
        check(gpu, "solid, rays", &scene("solid", "torus", |_| ()));
        check(gpu, "fire, slices", &scene("fire", "torus", |s| s.quality.pass = Pass::Slices));
        check(gpu, "shells, rays", &scene("shells", "torus", |_| ()));
        check(gpu, "fur, blurred", &scene("fur", "torus", blurred));
    });
}

/// A ball in a volume of 12 x 14 x 16 voxels, brighter within, as NRRD.
fn scan(folder: &Path) -> String {
    let [nx, ny, nz] = [12, 14, 16];
    let mut bytes =
        format!("NRRD0004\ntype: uint8\ndimension: 3\nsizes: {nx} {ny} {nz}\nencoding: raw\n\n").into_bytes();
    for place in (0..nx * ny * nz).map(|index| [index % nx, index / nx % ny, index / (nx * ny)]) {
        let off = [0, 1, 2].map(|axis| f64::from(place[axis]) - 0.5 * f64::from([nx, ny, nz][axis] - 1));
        let distance = off.iter().map(|off| off * off).sum::<f64>().sqrt();
        bytes.push((200.0 - 30.0 * distance).clamp(0.0, 200.0) as u8);
    }
    let path = folder.join("scan.nrrd");
    std::fs::write(&path, bytes).unwrap();
    path.to_str().unwrap().into()
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn ignored_settings_of_objects_change_no_bit() {
    let folder = tempfile::tempdir().unwrap();
    let scan = scan(folder.path());
    with_gpu(|gpu| {
        let objects = FIELDS.into_iter().filter(|(field, _)| field.starts_with("object."));
        let objects: Vec<(&str, &str)> = objects.chain([("quality.seed", "7")]).collect();
        check_fields(gpu, "lit mesh", &scene("lit", "knot", |_| ()), &objects);
        check_fields(gpu, "fire on a mesh", &scene("fire", "knot", |_| ()), &objects);
        check_fields(gpu, "lit scan", &scene("lit", &scan, |_| ()), &objects);
        let light = [
            ("light.scatter", "0.7"),
            ("light.transport", "#204060"),
            ("light.translucency", "0.3"),
            ("light.shadow_resolution", "64"),
            ("light.ambient", "#ff00ff"),
            ("quality.seed", "7"),
        ];
        check_fields(gpu, "wax, half angle", &scene("wax", "dodecahedron", |_| ()), &light);
        let parts = [
            ("object.shell", "0.1"),
            ("parts.b.object.shell", "0.1"),
            ("parts.b.object.iso", "3"),
            ("parts.b.object.distance", "true"),
            ("parts.b.object.resolution", "40"),
            ("parts.b.object.up", "z"),
            ("parts.b.material.color", "#00ff00"),
            ("parts.b.transform.at", "[1, 0.3, 0]"),
            ("parts.b.transform.aligned", "true"),
        ];
        let with_part = |s: &mut Scene| {
            s.set_field("parts.b.object.input", "pawn").unwrap();
            s.set_field("parts.b.object.resolution", "24").unwrap();
            s.set_field("parts.b.transform.at", "[0.8, 0.3, 0]").unwrap();
        };
        check_fields(gpu, "two meshes", &scene("lit", "dodecahedron", with_part), &parts);
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn what_is_ignored_in_glass_and_in_sums_of_noise() {
    with_gpu(|gpu| {
        let library = shader::shipped();
        let said = |base: &Scene, field: &str, value: &str| {
            let mut set = base.clone();
            set.set_field(field, value).unwrap();
            set.check(&library).unwrap();
            let subject = subject(&set, &library);
            let same = picture(gpu, &library, base, &subject).pixels == picture(gpu, &library, &set, &subject).pixels;
            let said = !unused_overrides(&library, &subject, base, &set).is_empty();
            assert_eq!(said, same, "{field} = {value}");
            said
        };
        let glass = scene("blue_glass", "sphere", |_| ());
        for field in ["quality.order=back_to_front", "quality.seed=3", "light.shadows=true", "effect.opacity=beer"] {
            let (field, value) = field.split_once('=').unwrap();
            assert!(said(&glass, field, value), "{field}");
        }
        assert!(!said(&glass, "quality.samples", "30") && !said(&glass, "effect.environment", "none"));
        let fractal = scene("fractal_sphere", "sphere", |_| ());
        assert!(!said(&fractal, "effect.octaves", "1") && said(&fractal, "effect.turbulence", "procedural"));
    });
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_groom_is_ignored_where_nothing_that_is_read_is_painted() {
    let (library, folder) = (shader::shipped(), tempfile::tempdir().unwrap());
    let painted = |name: &str, voxel: [f32; 9]| {
        let mut groom = Groom::unpainted("torus", 32);
        (0..groom.voxels()).for_each(|index| groom.set(index, voxel));
        let (path, mut bytes) = (folder.path().join(name), Vec::new());
        groom.write(&mut bytes).unwrap();
        std::fs::write(&path, bytes).unwrap();
        Some(path.display().to_string())
    };
    let bald = painted("bald.nrrd", [0.0, 1.0, 1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 1.0]);
    let red = painted("red.nrrd", [1.0, 1.0, 2.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0]);
    with_gpu(|gpu| {
        for (effect, before, after, is_same) in [
            ("lit", &None, &bald, true),
            ("lit", &None, &red, false),
            ("lit", &red, &bald, false),
            ("fur", &None, &bald, false),
        ] {
            let [base, set] = [before, after].map(|groom| scene(effect, "torus", |s| s.groom.clone_from(groom)));
            let [old, new] = [&base, &set].map(|scene| subject(scene, &library));
            let same = picture(gpu, &library, &base, &old).pixels == picture(gpu, &library, &set, &new).pixels;
            let said = !unused_overrides(&library, &new, &base, &set).is_empty();
            assert_eq!((said, same), (is_same, is_same), "{effect}: {before:?} to {after:?}");
        }
    });
}

#[test]
fn nothing_is_said_of_what_was_not_set_or_only_makes_it_sooner() {
    let library = shader::shipped();
    let base = scene("fire", "sphere", |s| s.quality.pass = Pass::March);
    let subject = subject(&base, &library);
    assert!(unused_overrides(&library, &subject, &base, &base).is_empty());
    let mut fixed = base.clone();
    fixed.set_field("quality.empty_space", "sample").unwrap();
    assert!(unused_overrides(&library, &subject, &base, &fixed).is_empty(), "the same picture, later");
    let mut several = base.clone();
    for (field, value) in [("quality.seed", "9"), ("quality.wrap", "mirror"), ("effect.octaves", "6"), ("about", "me")]
    {
        several.set_field(field, value).unwrap();
    }
    assert_eq!(unused_overrides(&library, &subject, &base, &several), ["effect.octaves = 6", "quality.seed = 9"]);
}

#[test]
fn a_camera_of_matrices_reads_no_orbit() {
    let library = shader::shipped();
    let mut base = scene("lit", "sphere", |_| ());
    base.camera.look_through(view(), projection(base.camera.projection, 1.0)).unwrap();
    let (subject, mut set) = (subject(&base, &library), base.clone());
    let orbit = ["camera.azimuth", "camera.elevation", "camera.zoom", "camera.pan", "camera.field_of_view"];
    for (field, value) in FIELDS.into_iter().filter(|(field, _)| orbit.contains(field)) {
        set.set_field(field, value).unwrap();
    }
    set.set_field("camera.rotation", "[1, 0, 0, 0]").unwrap();
    assert_eq!(unused_overrides(&library, &subject, &base, &set).len(), orbit.len() + 1);
    let idle = unused_settings(&library, &subject, &base, &|| false);
    assert!(orbit.iter().chain(&["camera.rotation"]).all(|field| idle.iter().any(|own| own == field)), "{idle:?}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn settings_that_are_idle_change_no_bit_whatever_they_are() {
    with_gpu(|gpu| {
        let library = shader::shipped();
        let scenes = [
            (
                "lit",
                scene("lit", "cube", |_| ()),
                "effect.turbulence effect.octaves effect.project effect.absorption effect.index",
                "light.color",
            ),
            (
                "fire",
                scene("fire", "torus", |_| ()),
                "effect.absorption effect.noise light.scatter",
                "effect.turbulence effect.medium",
            ),
            (
                "lit mesh",
                scene("lit", "dodecahedron", |_| ()),
                "effect.turbulence object.distance object.iso",
                "object.shell object.resolution object.up object.field_encoding",
            ),
            (
                "fur",
                scene("fur", "torus", |s| s.quality.pass = Pass::Slices),
                "effect.absorption",
                "light.intensity effect.noise",
            ),
        ];
        for (name, base, idles, live) in scenes {
            let subject = subject(&base, &library);
            let found = unused_settings(&library, &subject, &base, &|| false);
            println!("{name}: {}", found.join(", "));
            let is_idle = |field: &str| found.iter().any(|idle| idle == field);
            for field in idles.split(' ') {
                assert!(is_idle(field), "{name}: {field} is read");
            }
            for field in live.split(' ').chain(["camera.azimuth", "effect.surface"]) {
                assert!(!is_idle(field), "{name}: {field} is idle");
            }
            let plain = picture(gpu, &library, &base, &subject);
            for (field, value) in FIELDS.into_iter().filter(|(field, _)| is_idle(field)) {
                let mut set = base.clone();
                set.set_field(field, value).unwrap();
                set.drop_foreign_parameters(&library).unwrap();
                let same =
                    set.check(&library).is_err() || picture(gpu, &library, &set, &subject).pixels == plain.pixels;
                assert!(same, "{name}: {field} = {value} changes the picture");
            }
            assert!(unused_settings(&library, &subject, &base, &|| true).is_empty(), "nobody waits for it");
        }
    });
}
