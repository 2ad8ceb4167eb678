//! Colors and textures of materials, beside closed forms in f64, and refusals.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use hypertexture_shape::{Mesh, Shape, open, open_painted, read, read_painted};
use serde_json::{Value, json};
use std::fs;
use std::path::Path;

/// A JPEG of 8 x 8 pixels of the code 180.
const JPEG: &str = "/9j/4AAQSkZJRgABAQAAAQABAAD/2wBDAAEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQEBAQH/wAALCAAIAAgBAREA/8QAHwAAAQUBAQEBAQEAAAAAAAAAAAECAwQFBgcICQoL/8QAtRAAAgEDAwIEAwUFBAQAAAF9AQIDAAQRBRIhMUEGE1FhByJxFDKBkaEII0KxwRVS0fAkM2JyggkKFhcYGRolJicoKSo0NTY3ODk6Q0RFRkdISUpTVFVWV1hZWmNkZWZnaGlqc3R1dnd4eXqDhIWGh4iJipKTlJWWl5iZmqKjpKWmp6ipqrKztLW2t7i5usLDxMXGx8jJytLT1NXW19jZ2uHi4+Tl5ufo6erx8vP09fb3+Pn6/9oACAEBAAA/AP2gr//Z";
/// Pixels of the texture across and down.
const SIZE: [i64; 2] = [4, 3];

/// The code of a pixel of the texture.
fn code(x: i64, y: i64, channel: i64) -> u8 {
    ((x * 67 + y * 41 + channel * 90) % 256) as u8
}

fn png(size: [u32; 2], color: png::ColorType, pixels: &[u8]) -> Vec<u8> {
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, size[0], size[1]);
    encoder.set_color(color);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.write_header().unwrap().write_image_data(pixels).unwrap();
    bytes
}

fn picture() -> Vec<u8> {
    let at = (0..SIZE[1]).flat_map(|y| (0..SIZE[0]).map(move |x| [x, y]));
    let pixels: Vec<u8> = at.flat_map(|[x, y]| [0, 1, 2].map(|channel| code(x, y, channel))).collect();
    png([4, 3], png::ColorType::Rgb, &pixels)
}

/// Linear light of a code of sRGB, IEC 61966-2-1.
fn linear(code: f64) -> f64 {
    if code <= 0.04045 { code / 12.92 } else { ((code + 0.055) / 1.055).powf(2.4) }
}

/// The texture between its pixels; `pixel` places coordinates beyond its edges.
fn bilinear([u, v]: [f64; 2], channel: i64, pixel: [fn(i64, i64) -> i64; 2]) -> f64 {
    let [x, y] = [u * SIZE[0] as f64 - 0.5, v * SIZE[1] as f64 - 0.5];
    let light = |x: f64, y: f64| {
        let [x, y] = [pixel[0](x as i64, SIZE[0]), pixel[1](y as i64, SIZE[1])];
        linear(f64::from(code(x, y, channel)) / 255.0)
    };
    let mix = |a: f64, b: f64, t: f64| a * (1.0 - t) + b * t;
    let [left, top] = [x.floor(), y.floor()];
    let row = |y: f64| mix(light(left, y), light(left + 1.0, y), x - left);
    mix(row(top), row(top + 1.0), y - top)
}

fn repeat(at: i64, count: i64) -> i64 {
    (at + 100 * count) % count
}

fn mirror(at: i64, count: i64) -> i64 {
    let at = repeat(at, 2 * count);
    if at < count { at } else { 2 * count - 1 - at }
}

fn clamp(at: i64, count: i64) -> i64 {
    at.max(0).min(count - 1)
}

/// Asserts the colors of a square with corners at 0 and 1: at x, y those that `expected` gives for a channel.
fn assert_colors(mesh: &Mesh, expected: impl Fn(f64, f64, i64) -> f64) {
    let points: Vec<_> = mesh.colored_points(0.05).collect();
    assert!(points.len() > 400, "{}", points.len());
    for (place, color) in points {
        for (channel, found) in color.into_iter().enumerate() {
            let expected = expected(place.x.into(), place.y.into(), channel as i64);
            let error = (f64::from(found) - expected).abs();
            assert!(error < 1e-3, "{place}, channel {channel}: {found}, not {expected}");
        }
    }
}

fn mesh(shape: Shape) -> Mesh {
    match shape {
        Shape::Mesh(mesh) => mesh,
        other => panic!("{other:?}"),
    }
}

/// A file in a folder, and what it is refused for.
fn refusal(folder: &Path, name: &str) -> String {
    let line = open_painted(folder.join(name).to_str().unwrap()).unwrap_err().to_string();
    assert_eq!(line.lines().count(), 1, "{line}");
    line
}

const SQUARE: &str = "mtllib my materials.mtl\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt -1 -1\nvt 2 -1 0\nvt 2 2\nvt -1 2\n\
    usemtl wood\nf 1/1 2/2 3/3 4/-1\n";

#[test]
fn an_obj_has_the_texture_of_its_material() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).unwrap();
    let painted = |obj: &str, mtl: &str| {
        write("a.obj", obj.as_bytes());
        write("my materials.mtl", mtl.as_bytes());
        mesh(open_painted(folder.path().join("a.obj").to_str().unwrap()).unwrap())
    };
    fs::create_dir(folder.path().join("maps")).unwrap();
    write("maps/a b.png", &picture());
    write("a.jpg", &STANDARD.decode(JPEG).unwrap());
    write("gray.png", &png([1, 1], png::ColorType::GrayscaleAlpha, &[90, 7]));
    let map = "newmtl none\nmap_Kd missing.png\nnewmtl wood\nKd 0 0 0\nmap_Kd";
    let spread = |x: f64, y: f64| [3.0 * x - 1.0, 1.0 - (3.0 * y - 1.0)];
    let wood = painted(SQUARE, &format!("{map} maps\\a b.png\r\n"));
    assert_colors(&wood, |x, y, channel| bilinear(spread(x, y), channel, [repeat; 2]));
    let wood = painted(SQUARE, &format!("{map} -clamp on -bm 1 maps/a b.png"));
    assert_colors(&wood, |x, y, channel| bilinear(spread(x, y), channel, [clamp; 2]));
    let wood = painted(SQUARE, &format!("{map} -s 2 0.5 1 -o 0.25 maps/a b.png"));
    let moved = |x: f64, y: f64| [2.0 * (3.0 * x - 1.0) + 0.25, 1.0 - 0.5 * (3.0 * y - 1.0)];
    assert_colors(&wood, |x, y, channel| bilinear(moved(x, y), channel, [repeat; 2]));
    assert_colors(&painted(SQUARE, &format!("{map} a.jpg")), |_, _, _| linear(180.0 / 255.0));
    assert_colors(&painted(SQUARE, &format!("{map} gray.png")), |_, _, _| linear(90.0 / 255.0));
    // Without a texture, the color of the material; those of vertices come before it.
    let wood = "newmtl wood\nKd 0.2 0.5 0.7";
    assert_colors(&painted(SQUARE, wood), |_, _, channel| linear([0.2, 0.5, 0.7][channel as usize]));
    let colored = SQUARE.replace(" 0\nv", " 0 0.5 0.5 0.5\nv").replace("0 1 0\n", "0 1 0 0.5 0.5 0.5\n");
    assert_colors(&painted(&colored, wood), |_, _, _| linear(0.5));
    assert!(!painted(SQUARE, "newmtl other\nKd 1 1 1\n").is_colored());
    // Faces of other materials stay unpainted.
    let more = format!("{SQUARE}usemtl other\nv 0 0 9\nv 1 0 9\nv 0 1 9\nf 5 6 7\n");
    assert!(painted(&more, wood).colored_points(0.1).all(|(place, _)| place.z == 0.0));
    // Nothing of it is read without being asked for.
    write("my materials.mtl", b"newmtl wood\nmap_Kd missing.png\n");
    let plain = mesh(open(folder.path().join("a.obj").to_str().unwrap()).unwrap());
    assert!(!plain.is_colored() && plain.positions.len() == 7);
}

#[test]
fn a_large_picture_is_averaged() {
    let folder = tempfile::tempdir().unwrap();
    let pixels: Vec<u8> = (0..3000 * 2).map(|at| if at % 3000 % 2 == 0 { 0 } else { 255 }).collect();
    fs::write(folder.path().join("a.png"), png([3000, 2], png::ColorType::Grayscale, &pixels)).unwrap();
    fs::write(folder.path().join("my materials.mtl"), "newmtl wood\nmap_Kd a.png").unwrap();
    fs::write(folder.path().join("a.obj"), SQUARE).unwrap();
    let found = mesh(open_painted(folder.path().join("a.obj").to_str().unwrap()).unwrap());
    let points: Vec<f64> = found.colored_points(0.002).map(|(_, color)| color[0].into()).collect();
    // Half of the light on the mean, and no texel of a single pixel's value beside a mean of three.
    let mean = points.iter().sum::<f64>() / points.len() as f64;
    assert!((mean - 0.5).abs() < 0.01 && points.iter().all(|value| (0.3..0.7).contains(value)), "{mean}");
}

#[test]
fn unreadable_obj_materials_are_refused_with_their_place() {
    let folder = tempfile::tempdir().unwrap();
    let write = |name: &str, bytes: &[u8]| fs::write(folder.path().join(name), bytes).unwrap();
    write("good.png", &picture());
    write("torn.png", &picture()[..60]);
    write("web.png", b"RIFF\x10\0\0\0WEBPVP8 ");
    write("torn.jpg", &STANDARD.decode(JPEG).unwrap()[..200]);
    let mut huge = picture();
    huge[16..24].copy_from_slice(&[0, 0, 0x40, 0, 0, 0, 0x40, 0]);
    let mut checksum = flate2::Crc::new();
    checksum.update(&huge[12..29]);
    huge[29..33].copy_from_slice(&checksum.sum().to_be_bytes());
    write("huge.png", &huge);
    for (map, said) in [
        ("none.png", "its data file"),
        ("none.png", "there is no such file; copy it there, or correct its name"),
        ("../a.png", "material `wood`: the data file `../a.png` is not supported; put the file of the data beside"),
        ("/etc/passwd", "material `wood`: the data file `/etc/passwd` is not supported"),
        ("torn.png", "torn.png: material `wood`: expected a whole picture in PNG or JPEG, found"),
        ("torn.jpg", "torn.jpg: material `wood`: expected a whole picture in PNG or JPEG, found"),
        ("web.png", "web.png: material `wood`: the format of a picture that begins with `RIFF"),
        ("web.png", "WEBP` is not supported; save it as PNG or JPEG"),
        ("huge.png", "a picture of 16384 x 16384 pixels is not supported; scale it to at most 8192 x 8192"),
        ("-x 1 good.png", "my materials.mtl: line 2: expected an option of MTL, or the name of a texture, found `-x`"),
        ("-s 1 1", "line 2: expected the name of a texture after `map_Kd`"),
    ] {
        write("my materials.mtl", format!("newmtl wood\nmap_Kd {map}\n").as_bytes());
        write("a.obj", SQUARE.as_bytes());
        let line = refusal(folder.path(), "a.obj");
        assert!(line.contains(said), "{map}: {line}");
    }
    write("my materials.mtl", b"newmtl wood\nmap_Kd good.png\n");
    for (from, to, said) in [
        ("1/1", "1/5", "line 11: expected the index of texture coordinates above this line (2 in 7/2), found `1/5`"),
        ("1/1", "1/0", "found `1/0`"),
        ("1/1", "1/-9223372036854775808", "found `1/-9223372036854775808`"),
        ("vt -1 -1", "vt nan 0", "1 of 4 texture coordinates are NaN, infinite or beyond 32-bit floats"),
        ("vt -1 -1", "vt 1e39 0", "1 of 4 texture coordinates"),
        ("vt -1 -1", "vt", "line 6: expected texture coordinates (1 to 3 numbers after `vt`)"),
        ("my materials", "../my", "line 1: the data file `../my.mtl` is not supported"),
        ("my materials", "none", "there is no such file; copy it there"),
    ] {
        write("a.obj", SQUARE.replacen(from, to, 1).as_bytes());
        let line = refusal(folder.path(), "a.obj");
        assert!(line.contains(said), "{to}: {line}");
        if !to.contains("vt") && !to.starts_with('1') {
            open(folder.path().join("a.obj").to_str().unwrap()).unwrap();
        }
    }
    write("my materials.mtl", b"newmtl wood\nKd red\n");
    write("a.obj", SQUARE.as_bytes());
    assert!(refusal(folder.path(), "a.obj").contains("line 2: expected a color (3 numbers after `Kd`), found `red`"));
    // Far beyond the texture, it repeats still.
    write("my materials.mtl", b"newmtl wood\nmap_Kd good.png\n");
    write("a.obj", SQUARE.replace("vt -1 -1", "vt 3e38 -3e38").as_bytes());
    mesh(open_painted(folder.path().join("a.obj").to_str().unwrap()).unwrap()).colored_points(0.1).for_each(drop);
}

/// A square with texture coordinates of -1 to 2, v downward, and a texture in its data.
fn document() -> (Value, Vec<u8>) {
    let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0f32]];
    let spots = [[-1.0, 2.0], [2.0, 2.0], [2.0, -1.0], [-1.0, -1.0f32]];
    let floats = corners.as_flattened().iter().chain(spots.as_flattened());
    let mut data: Vec<u8> = floats.flat_map(|number| number.to_le_bytes()).collect();
    data.extend([0, 1, 2, 0, 2, 3u8]);
    data.extend([0; 2]);
    let picture = picture();
    let length = picture.len();
    data.extend(picture);
    let document = json!({
        "asset": { "version": "2.0" },
        "nodes": [{ "mesh": 0 }],
        "meshes": [{ "primitives": [{
            "attributes": { "POSITION": 0, "TEXCOORD_0": 1, "TEXCOORD_3": 1 }, "indices": 2, "material": 1,
        }] }],
        "materials": [{}, { "pbrMetallicRoughness": {
            "baseColorFactor": [0.5, 1.0, 0.25, 1.0], "baseColorTexture": { "index": 0 },
        } }],
        "textures": [{ "source": 0, "sampler": 0 }],
        "samplers": [{ "wrapS": 33648, "wrapT": 33071 }],
        "images": [{ "bufferView": 3, "mimeType": "image/png" }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2" },
            { "bufferView": 2, "componentType": 5121, "count": 6, "type": "SCALAR" },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 32 },
            { "buffer": 0, "byteOffset": 80, "byteLength": 6 },
            { "buffer": 0, "byteOffset": 88, "byteLength": length },
        ],
    });
    (document, data)
}

/// Bytes of a changed document.
fn changed(change: impl Fn(&mut Value)) -> Vec<u8> {
    let (mut document, data) = document();
    let uri = format!("data:;base64,{}", STANDARD.encode(&data));
    document["buffers"] = json!([{ "byteLength": data.len(), "uri": uri }]);
    change(&mut document);
    document.to_string().into_bytes()
}

#[test]
fn a_gltf_has_the_texture_of_its_material() {
    let painted = |change: &dyn Fn(&mut Value)| mesh(read_painted("a.gltf", &changed(change)).unwrap());
    let factor = |channel: i64| [0.5, 1.0, 0.25][channel as usize];
    let spread = |x: f64, y: f64| [3.0 * x - 1.0, 2.0 - 3.0 * y];
    let with = |u: [f64; 2], channel, wraps| factor(channel) * bilinear(u, channel, wraps);
    let base = "/materials/1/pbrMetallicRoughness";
    let found = painted(&|_| {});
    assert_colors(&found, |x, y, channel| with(spread(x, y), channel, [mirror, clamp]));
    assert!(!mesh(read("a.gltf", &changed(|_| {})).unwrap()).is_colored());
    let found = painted(&|document| document["textures"][0]["sampler"] = Value::Null);
    assert_colors(&found, |x, y, channel| with(spread(x, y), channel, [repeat; 2]));
    // A quarter turn, half the size: the example of the extension, which shows the lower left quarter.
    let found = painted(&|document| {
        let texture = &mut document.pointer_mut(base).unwrap()["baseColorTexture"];
        let transform =
            json!({ "offset": [0, 1], "rotation": std::f64::consts::FRAC_PI_2, "scale": [0.5, 0.25], "texCoord": 3 });
        *texture = json!({ "index": 0, "texCoord": 7, "extensions": { "KHR_texture_transform": transform } });
        document["textures"][0]["sampler"] = Value::Null;
    });
    let turned = |x: f64, y: f64| [0.25 * (2.0 - 3.0 * y), 1.0 - 0.5 * (3.0 * x - 1.0)];
    assert_colors(&found, |x, y, channel| with(turned(x, y), channel, [repeat; 2]));
    let found = painted(&|document| {
        document["images"][0] = json!({ "uri": format!("data:image/jpeg;base64,{JPEG}") });
    });
    assert_colors(&found, |_, _, channel| factor(channel) * linear(180.0 / 255.0));
    let found = painted(&|document| document.pointer_mut(base).unwrap()["baseColorTexture"] = Value::Null);
    assert_colors(&found, |_, _, channel| factor(channel));
    // Colors of vertices are factors too.
    let found = painted(&|document| document["meshes"][0]["primitives"][0]["attributes"]["COLOR_0"] = json!(0));
    assert_colors(&found, |x, y, channel| [x, y, 0.0][channel as usize] * with(spread(x, y), channel, [mirror, clamp]));
    assert!(!painted(&|document| document["meshes"][0]["primitives"][0]["material"] = json!(0)).is_colored());
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("a b.png"), picture()).unwrap();
    let bytes = changed(|document| document["images"][0] = json!({ "uri": "a%20b.png" }));
    fs::write(folder.path().join("a.gltf"), bytes).unwrap();
    let found = mesh(open_painted(folder.path().join("a.gltf").to_str().unwrap()).unwrap());
    assert_colors(&found, |x, y, channel| with(spread(x, y), channel, [mirror, clamp]));
}

#[test]
fn unreadable_gltf_materials_are_refused_with_their_place() {
    let (folder, dds) = (tempfile::tempdir().unwrap(), STANDARD.encode(b"DDS |\0\0\0"));
    for (place, value, said) in [
        ("/images/0", json!({ "uri": "none.png" }), "there is no such file; copy it there, or correct its name"),
        ("/images/0", json!({ "uri": "../a.png" }), "images[0].uri: the data file `../a.png` is not supported"),
        ("/images/0", json!({ "uri": "http://a/b.png" }), "images[0].uri: the address `http://a/b.png`"),
        ("/images/0", json!({ "bufferView": 9 }), "images[0].bufferView: expected the index of an existing entry"),
        ("/images/0", json!({ "bufferView": 0 }), "images[0]: the format of a picture that begins with"),
        ("/images/0", json!({ "uri": format!("data:;base64,{dds}") }), "begins with `DDS |\\0\\0\\0` is not supported"),
        ("/images/0", json!({}), "images[0]: expected a picture in a file or a view, found none"),
        ("/bufferViews/3/byteLength", json!(60), "images[0]: expected a whole picture in PNG or JPEG, found"),
        ("/textures/0/source", json!(5), "textures[0].source: expected the index of an existing entry, found 5 of 1"),
        ("/textures/0/source", Value::Null, "textures[0]: a picture of an extension only is not supported; export"),
        ("/textures/0/sampler", json!(1), "textures[0].sampler: expected the index of an existing entry"),
        ("/samplers/0/wrapT", json!(7), "samplers[0]: expected 10497, 33648 or 33071 as its wrapping, found 7"),
        ("/materials/1/pbrMetallicRoughness/baseColorTexture/index", json!(2), "baseColorTexture.index: expected the"),
        ("/materials/1/pbrMetallicRoughness/baseColorTexture/texCoord", json!(1), "found no TEXCOORD_1"),
        ("/materials/1/pbrMetallicRoughness/baseColorFactor", json!([1]), "expected a value of the glTF 2.0 schema"),
        ("/meshes/0/primitives/0/material", json!(4), "meshes[0].primitives[0].material: expected the index"),
        ("/meshes/0/primitives/0/attributes/TEXCOORD_0", json!(0), "accessors[0].type: expected `VEC2`"),
        ("/accessors/1/count", json!(3), "expected texture coordinates of every vertex, found 3 for 4 vertices"),
    ] {
        let bytes = changed(|document| {
            let (parent, key) = place.rsplit_once('/').unwrap();
            match document.pointer_mut(parent).unwrap() {
                Value::Array(list) => list[key.parse::<usize>().unwrap()] = value.clone(),
                parent => parent[key] = value.clone(),
            }
        });
        fs::write(folder.path().join("a.gltf"), &bytes).unwrap();
        let line = refusal(folder.path(), "a.gltf");
        assert!(line.contains(said), "{place}: {line}");
    }
    for value in [f32::NAN, f32::INFINITY] {
        let bytes = changed(|document| {
            let (_, mut data) = self::document();
            data[48..52].copy_from_slice(&value.to_le_bytes());
            document["buffers"][0]["uri"] = json!(format!("data:;base64,{}", STANDARD.encode(data)));
        });
        let line = read_painted("a.gltf", &bytes).unwrap_err().to_string();
        assert!(line.contains("1 of 4 texture coordinates are NaN, infinite"), "{line}");
    }
}
