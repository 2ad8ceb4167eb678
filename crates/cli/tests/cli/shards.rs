//! Shards: any split of a picture is the picture, bit for bit, and no other set of files becomes one.

use crate::common::{picture, subject, with_gpu};
use crate::program::command;
use hypertexture::output::shard::{Shard, Whole, encode, merge};
use hypertexture::output::{Depth, Provenance, identity, identity_of_texts};
use hypertexture::render::{Frame, Measurements, Renderer};
use hypertexture::scene::{Color, Pass, Scene, TargetFormat, preset};
use hypertexture::shader;
use std::fs;
use std::path::{Path, PathBuf};

fn bits(frame: &Frame) -> Vec<[u32; 4]> {
    frame.pixels.iter().map(|pixel| pixel.map(f32::to_bits)).collect()
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p52_any_split_into_shards_is_the_whole_bit_for_bit() {
    let library = shader::shipped();
    with_gpu(|gpu| {
        for effect in ["lit", "fur"] {
            let mut scene = preset(effect).unwrap();
            scene.object.input = "torus".into();
            scene.image.size = [97, 61];
            scene.quality.samples = 64;
            let subject = subject(&scene, &library);
            let mut renderer = Renderer::new(gpu, &library, &subject);
            for (pass, msaa, target) in [
                (Pass::Slices, 1, TargetFormat::Float32),
                (Pass::Slices, 4, TargetFormat::Float32),
                (Pass::Slices, 1, TargetFormat::Unorm8),
                (Pass::March, 1, TargetFormat::Float16),
                (Pass::March, 4, TargetFormat::Float32),
            ] {
                (scene.quality.pass, scene.quality.msaa, scene.quality.target) = (pass, msaa, target);
                let whole = picture(gpu, &library, &scene, &subject);
                for count in [1, 2, 3, 5, 8] {
                    let mut union = vec![[0.0; 4]; whole.pixels.len()];
                    for index in (0..count).rev() {
                        let bands = Shard::new(index, count).unwrap().bands(61);
                        let part = renderer.render_bands(&scene, &bands).unwrap();
                        for at in bands.iter().map(|band| band.start as usize * 97..band.end as usize * 97) {
                            union[at.clone()].copy_from_slice(&part.pixels[at]);
                        }
                    }
                    let union = Frame { pixels: union, ..whole.clone() };
                    assert!(bits(&union) == bits(&whole), "{effect}, {pass:?}, msaa {msaa}, {target:?}: {count} parts");
                }
            }
        }
    });
}

/// Settings shared by the shards of the tests.
fn whole(size: [u32; 2]) -> Whole {
    Whole {
        identity: blake3::hash(b"a scene"),
        size,
        background: Some(Color([1, 2, 3])),
        depth: Depth::Sixteen,
        provenance: Provenance::of(&Scene::default(), "this one", &Measurements::default()).unwrap(),
    }
}

/// A picture in which every pixel is another one.
fn ramp(size: [u32; 2]) -> Frame {
    let pixels = (0..size[0] * size[1]).map(|i| [i as f32, 0.5, f32::MIN_POSITIVE / 4.0, 1.0]).collect();
    Frame { size, pixels, measurements: Measurements::default() }
}

fn write(folder: &Path, name: &str, bytes: &[u8]) -> PathBuf {
    let path = folder.join(name);
    fs::write(&path, bytes).unwrap();
    path
}

#[test]
fn p53_files_of_shards_join_in_any_order_and_keep_every_bit() {
    let folder = tempfile::tempdir().unwrap();
    for (size, count) in [([7, 61], 3), ([5, 3], 5), ([1, 1], 1), ([9, 700], 4)] {
        let (whole, frame) = (whole(size), ramp(size));
        let shards = (0..count).rev().map(|index| Shard::new(index, count).unwrap());
        let mut files: Vec<PathBuf> =
            shards.map(|shard| write(folder.path(), &shard.suffix(), &encode(&whole, shard, &frame))).collect();
        files.push(files[0].clone()); // the same twice does no harm
        let (joined, about, others) = merge(&files).unwrap();
        assert!(bits(&joined) == bits(&frame), "{size:?} of {count}");
        assert_eq!((about, others.len()), (whole, 0));
    }
}

#[test]
fn p53_what_is_no_full_set_of_shards_is_refused_with_its_reason() {
    let folder = tempfile::tempdir().unwrap();
    let size = [5, 64];
    let [zero, one] = [0, 1].map(|index| Shard::new(index, 2).unwrap());
    let good = encode(&whole(size), zero, &ramp(size));
    let file = |name: &str, bytes: &[u8]| write(folder.path(), name, bytes);
    let first = file("first", &good);
    let mut other = ramp(size);
    other.pixels[0][0] = 9.0;
    let mut turned = good.clone();
    turned[200] ^= 1;
    let foreign = Whole { identity: blake3::hash(b"another"), ..whole(size) };
    let rows: &[(&str, Vec<u8>, &str)] = &[
        ("missing", good.clone(), "1 of 2 shards missing: 1; render with --shard 1/2"),
        ("twice", encode(&whole(size), zero, &other), "both hold shard 0/2"),
        ("damaged", turned, "its checksum does not hold; render this shard again"),
        ("cut", good[..good.len() - 1].to_vec(), "its checksum does not hold"),
        ("short", good[..20].to_vec(), "ends early"),
        ("foreign", encode(&foreign, one, &ramp(size)), "they differ in the scene"),
        ("size", encode(&whole([64, 5]), one, &ramp([64, 5])), "they differ in the size"),
        ("count", encode(&whole(size), Shard::new(1, 3).unwrap(), &ramp(size)), "they differ in the number of shards"),
        ("picture", b"\x89PNG and so on".to_vec(), "not a shard of hypertexture"),
    ];
    for (name, bytes, expected) in rows {
        let said = merge(&[first.clone(), file(name, bytes)]).unwrap_err().to_string();
        assert!(said.contains(expected) && !said.contains('\n'), "{name}: {said}");
    }
    assert!(merge(&[folder.path().join("none")]).unwrap_err().to_string().contains("none: "));
    // A header that lies, under a checksum that holds.
    for (at, value) in [(40, 0u32), (44, 65), (48, 2), (52, 0), (64, u32::MAX)] {
        let mut lie = good[..good.len() - 32].to_vec();
        lie[at..at + 4].copy_from_slice(&value.to_le_bytes());
        let hash = blake3::hash(&lie);
        lie.extend(hash.as_bytes());
        let said = merge(&[file("lie", &lie)]).unwrap_err().to_string();
        assert!(said.contains("does not hold what its header says"), "byte {at}: {said}");
    }
}

#[test]
fn the_identity_of_a_scene_is_its_content_and_not_its_path() {
    let library = shader::shipped();
    let mut scene = preset("lit").unwrap();
    (scene.object.input, scene.object.resolution) = ("knot".into(), 32);
    let subject = subject(&scene, &library);
    for identity in [identity, identity_of_texts] {
        let of = |scene: &_| identity(scene, &library, &subject).unwrap();
        let own = of(&scene);
        let mut moved = scene.clone();
        moved.object.input = "./elsewhere/knot.obj".into();
        assert_eq!(of(&moved), own);
        moved.camera.azimuth += 1.0;
        assert_ne!(of(&moved), own);
        let mut changed = subject.clone();
        std::sync::Arc::make_mut(changed.field.as_mut().unwrap()).values[0] += 1.0;
        assert_ne!(identity(&scene, &library, &changed).unwrap(), own);
    }
    let edited =
        library.clone().with_module("dmf", "other", "float other(float density, Sample s) { return density; }");
    let by = |identity: fn(&_, &_, &_) -> Result<_, _>| {
        [&library, &edited].map(|library| identity(&scene, library, &subject).unwrap())
    };
    let [[own, same], [texts, other]] = [by(identity), by(identity_of_texts)];
    assert!(own == same && texts != other && own != texts);
}

/// Arguments of `render` in `docs/cluster.md` after these words, and the first `merge` after it.
fn commands(words: &str) -> [Vec<String>; 2] {
    let rest = include_str!("../../../../docs/cluster.md").split_once(words).unwrap().1;
    ["render", "merge"].map(|name| {
        let start = rest.find(name).unwrap();
        let line = rest[start..].lines().next().unwrap();
        let line = line.split_once('#').map_or(line, |(line, _)| line).trim().trim_end_matches(']');
        line.split_whitespace().map(|word| word.trim_end_matches(',').to_owned()).collect()
    })
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p53_cluster_scripts_give_the_file_of_one_process() {
    for (words, index) in [("#SBATCH", "SLURM_ARRAY_TASK_ID"), ("args: [", "JOB_COMPLETION_INDEX")] {
        let folder = tempfile::tempdir().unwrap();
        let run = |arguments: &[String], variables: &[(&str, &str)]| {
            let mut command = command(folder.path(), "");
            let output = command.args(arguments).envs(variables.iter().copied()).output().unwrap();
            assert!(output.status.success(), "{arguments:?}: {}", String::from_utf8_lossy(&output.stderr));
        };
        let [render, merge] = commands(words);
        let render: Vec<String> = render.into_iter().map(|word| word.replace("2048x2048", "64x96")).collect();
        for part in 0..8 {
            let part = part.to_string();
            run(&render, &[(index, &part), ("SLURM_ARRAY_TASK_COUNT", "8"), ("HYPERTEXTURE_SHARD_COUNT", "8")]);
        }
        let shards =
            fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
        let shards = shards.filter(|name| name.contains(".shard-"));
        let merge: Vec<String> = merge.into_iter().filter(|word| !word.contains('*')).chain(shards).collect();
        assert_eq!(merge.len(), 2 + 8, "{merge:?}");
        run(&merge, &[]);
        let joined = fs::read(folder.path().join(&merge[1])).unwrap();
        run(&render.into_iter().filter(|word| word != "--shard").collect::<Vec<_>>(), &[]);
        assert!(fs::read(folder.path().join(&merge[1])).unwrap() == joined, "{words} another file");
    }
}
