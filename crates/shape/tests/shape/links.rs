//! Data files that are links: read if they lead into the folder of the header.
#![cfg(unix)]

use hypertexture_shape::open;
use std::fs;
use std::os::unix::fs::symlink;

/// Headers with the 36 bytes of `deep/data`.
const HEADERS: [(&str, &str); 3] = [
    ("a.nhdr", "NRRD0004\ntype: uchar\ndimension: 3\nsizes: 4 3 3\nencoding: raw\ndata file: deep/data\n"),
    ("a.mhd", "ObjectType = Image\nNDims = 3\nDimSize = 4 3 3\nElementType = MET_UCHAR\nElementDataFile = deep/data\n"),
    (
        "a.gltf",
        r#"{"asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": [0]}], "nodes": [{"mesh": 0}],
            "meshes": [{"primitives": [{"attributes": {"POSITION": 0}}]}],
            "accessors": [{"bufferView": 0, "componentType": 5126, "count": 3, "type": "VEC3"}],
            "bufferViews": [{"buffer": 0, "byteLength": 36}], "buffers": [{"byteLength": 36, "uri": "deep/data"}]}"#,
    ),
];

#[test]
fn links_to_data_are_followed_within_the_folder_only() {
    let corners = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0f32].map(f32::to_le_bytes);
    // Targets of `deep` and `deep/data`, relative to their folders; an empty one means a plain folder or file.
    for (folder, data, is_within) in [
        ("", "", true),
        ("", "../data", true),
        ("near", "", true),
        ("", "../../away/data", false),
        ("../away", "", false),
        ("near", "../../away/data", false),
    ] {
        for (name, text) in HEADERS {
            let root = tempfile::tempdir().unwrap();
            let [home, away] = ["home", "away"].map(|name| root.path().join(name));
            for own in [&home, &away, &home.join("near")] {
                fs::create_dir(own).unwrap();
                fs::write(own.join("data"), corners.as_flattened()).unwrap();
            }
            let (deep, header) = (home.join("deep"), home.join(name));
            match folder {
                "" => fs::create_dir(&deep).unwrap(),
                folder => symlink(folder, &deep).unwrap(),
            }
            if !data.is_empty() {
                let _ = fs::remove_file(deep.join("data"));
                symlink(data, deep.join("data")).unwrap();
            } else if folder.is_empty() {
                fs::write(deep.join("data"), corners.as_flattened()).unwrap();
            }
            fs::write(&header, text).unwrap();
            let found = open(&header.display().to_string()).map(drop).map_err(|error| error.to_string());
            let said = found.clone().err().unwrap_or_default();
            assert_eq!(found.is_ok(), is_within, "{name}, {folder}, {data}: {said}");
            let end = "the link `deep/data` is not supported; it leads out of the folder, and out of the current one: ";
            assert!(is_within || said.contains(end) && said.contains(name), "{said}");
        }
    }
}
