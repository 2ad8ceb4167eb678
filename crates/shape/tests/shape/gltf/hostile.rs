//! Bounds of time and memory for hostile files.

use super::*;
use hypertexture_shape::read_noted;
use proptest::prelude::*;

/// Processor time of this thread.
fn processor_seconds() -> f64 {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    time.tv_sec as f64 + 1e-9 * time.tv_nsec as f64
}

#[test]
fn a_binary_file_that_is_cut_or_whose_lengths_lie_is_refused() {
    let good = glb(&document(), &data());
    for cut in 4..good.len() {
        let _ = error(&good[..cut]);
        // And where its header knows of the cut.
        if cut >= 12 {
            let mut short = good[..cut].to_vec();
            short[8..12].copy_from_slice(&(cut as u32).to_le_bytes());
            let _ = error(&short);
        }
    }
    let json = u32::from_le_bytes(good[12..16].try_into().unwrap()) as usize;
    let second = 20 + json;
    for (at, bytes, said) in [
        (4, 1_u32.to_le_bytes(), "byte 4: version `1` is not supported; export it as glTF 2.0"),
        (4, 3_u32.to_le_bytes(), "byte 4: version `3` is not supported"),
        (8, 99_u32.to_le_bytes(), "byte 20: the header declares"),
        (8, [255; 4], "byte 0: the header declares 4294967295 bytes of data"),
        (12, 0_u32.to_le_bytes(), "byte 20: expected the length of a chunk"),
        (12, 2_u32.to_le_bytes(), "byte 12: expected the length of a chunk as a multiple of 4, found 2"),
        (12, [252, 255, 255, 255], "byte 20: the header declares 4294967292 bytes of data (a chunk), the file holds"),
        (16, *b"BIN\0", "byte 16: expected the chunk `JSON` first, found `BIN\\0`"),
        (16, [0xff; 4], "byte 16: expected the chunk `JSON` first"),
        (second, 76_u32.to_le_bytes(), "the header declares 76 bytes of data (a chunk), the file holds 72"),
        (second, 68_u32.to_le_bytes(), "buffers[0].byteLength: expected a part of its data, found 72 of 68"),
        (second, 71_u32.to_le_bytes(), "expected the length of a chunk as a multiple of 4, found 71"),
        (second + 4, *b"JSON", "buffers[0].uri: expected the location of its data, found none, and no binary chunk"),
    ] {
        let mut bad = good.clone();
        bad[at..at + 4].copy_from_slice(&bytes);
        let line = error(&bad);
        assert!(line.contains(said), "{at}: {line}");
    }
    assert!(error(&glb(&document(), &[])).contains("buffers[0].uri: expected the location of its data"));
    let tailed = read_noted("a.glb", &[&good[..], b"some more"].concat()).unwrap();
    assert_eq!(tailed.notes, ["bytes after the declared end of the file are left out: 9"]);
    assert!(matches!(tailed.shape, Shape::Mesh(mesh) if mesh.triangles.len() == 4));
}

#[test]
fn what_a_document_only_declares_takes_neither_time_nor_memory() {
    let start = processor_seconds();
    let huge = |change: fn(&mut Value)| {
        let mut document = document();
        change(&mut document);
        error(&glb(&document, &data()))
    };
    for (line, said) in [
        (
            // 4 billion vertices at zero.
            huge(|document| {
                document["accessors"][0] = json!({ "componentType": 5126, "count": 1_u64 << 32, "type": "VEC3" })
            }),
            "4294967296 elements of accessors without a view, the limit is 1048576",
        ),
        (
            huge(|document| {
                document["accessors"][1] =
                    json!({ "componentType": 5125, "count": 3_000_000_000_u64, "type": "SCALAR" })
            }),
            "3000000000 elements of accessors without a view, the limit is 1048576",
        ),
        (
            huge(|document| {
                document["accessors"][1] = json!({ "componentType": 5125, "count": 600_000, "type": "SCALAR" });
                let primitive = document["meshes"][0]["primitives"][0].clone();
                document["meshes"][0]["primitives"] = json!([primitive, primitive]);
            }),
            "1200000 elements of accessors without a view",
        ),
        (
            huge(|document| {
                document["accessors"][0] = json!({ "componentType": 5126, "count": 4, "type": "VEC3" });
            }),
            "no triangles (4 of zero area were dropped)",
        ),
        (
            // One node more than a tree of doublings would need for more triangles than there may be.
            huge(|document| document["nodes"] = json!([{ "mesh": 0, "children": vec![1; 100_000] }, { "mesh": 0 }])),
            "nodes[0].children[1]: expected each node once",
        ),
    ] {
        assert!(line.contains(said), "{said}: {line}");
    }
    let many = format!("{{ \"asset\": {{ \"version\": \"2.0\" }}, \"nodes\": [{}{{}}] }}", "{},".repeat(1 << 20));
    let line = error(many.as_bytes());
    assert!(line.contains("more than 1048576 entries in a list of the JSON, the limit is 1048576"), "{line}");
    assert!(processor_seconds() - start < 2.0, "{}", processor_seconds() - start);
}

#[test]
fn too_many_instances_are_refused_before_allocation() {
    // 100 x 100 squares.
    let side = 100_u32;
    let mut data: Vec<u8> = Vec::new();
    for corner in 0..(side + 1) * (side + 1) {
        let at = [corner % (side + 1), corner / (side + 1), 0].map(|x| x as f32);
        data.extend(at.iter().flat_map(|x| x.to_le_bytes()));
    }
    let positions = data.len();
    for square in 0..side * side {
        let a = square / side * (side + 1) + square % side;
        data.extend([a, a + 1, a + side + 1, a + 1, a + side + 2, a + side + 1].iter().flat_map(|x| x.to_le_bytes()));
    }
    let shown = |shown: u32| {
        let mut document = document();
        document["nodes"] = (0..shown).map(|at| json!({ "mesh": 0, "translation": [0, 0, at] })).collect();
        document["scenes"][0]["nodes"] = (0..shown).collect();
        document["accessors"][0]["count"] = json!((side + 1) * (side + 1));
        document["accessors"][1] =
            json!({ "bufferView": 1, "componentType": 5125, "count": 6 * side * side, "type": "SCALAR" });
        document["bufferViews"] = json!([
            { "buffer": 0, "byteLength": positions },
            { "buffer": 0, "byteOffset": positions, "byteLength": data.len() - positions },
        ]);
        document["buffers"][0]["byteLength"] = json!(data.len());
        glb(&document, &data)
    };
    assert_eq!(mesh(&shown(15)).triangles.len(), 300_000);
    let start = processor_seconds();
    assert!(error(&shown(2501)).contains("50020000 triangles, the limit is 50000000"));
    assert!(processor_seconds() - start < 1.0, "{}", processor_seconds() - start);
}

/// Any bytes give a valid mesh or an error of one line.
fn check(name: &str, bytes: &[u8]) -> Result<(), TestCaseError> {
    match read(name, bytes) {
        Err(error) => prop_assert_eq!(error.to_string().lines().count(), 1, "{}", error),
        Ok(Shape::Mesh(mesh)) => {
            prop_assert!(!mesh.triangles.is_empty() && mesh.positions.iter().all(|p| p.is_finite()));
            prop_assert!(mesh.triangles.as_flattened().iter().all(|&corner| (corner as usize) < mesh.positions.len()));
        }
        Ok(other) => prop_assert!(false, "{other:?}"),
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1_000, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn damaged_files_give_a_mesh_or_one_line(
        changes in prop::collection::vec((0.0..1.0, 0..3_u8, any::<u8>()), 1..6), binary in any::<bool>()
    ) {
        let mut bytes = if binary { glb(&document(), &data()) } else { gltf(document(), &data()) };
        for (place, kind, byte) in changes {
            let at = (place * bytes.len() as f64) as usize;
            match kind {
                0 => bytes[at] = b'0' + byte % 10,
                1 => bytes[at] ^= 1 << (byte % 8),
                _ => bytes[at] = byte,
            }
        }
        check("a.glb", &bytes)?;
    }

    #[test]
    fn numbers_anywhere_in_a_document_give_a_mesh_or_one_line(
        changes in prop::collection::vec((any::<prop::sample::Index>(), prop_oneof![0..80_u64, any::<u64>()]), 1..4)
    ) {
        let text = document().to_string();
        let mut words: Vec<String> = Vec::new(); // numbers, and what is between them
        for digit in text.chars() {
            match words.last_mut() {
                Some(word) if word.ends_with(|last: char| last.is_ascii_digit()) == digit.is_ascii_digit() => word.push(digit),
                _ => words.push(digit.into()),
            }
        }
        let numbers: Vec<usize> = (0..words.len()).filter(|at| words[*at].ends_with(|c: char| c.is_ascii_digit())).collect();
        for (at, value) in changes {
            words[numbers[at.index(numbers.len())]] = value.to_string();
        }
        let json = chunk(b"JSON", words.concat().into_bytes(), b' ');
        let chunks = [json, chunk(b"BIN\0", data(), 0)].concat();
        check("a.glb", &[b"glTF\x02\0\0\0", &(chunks.len() as u32 + 12).to_le_bytes()[..], &chunks].concat())?;
    }
}
