//! Bad input is refused in one line, and nothing is written.

use super::desk::{Desk, refused, text};
use std::fs;

#[test]
fn arguments_that_make_no_sense_are_refused_in_one_line() {
    refused(
        |_| {},
        &[
            ("", &["error:", "command", "hypertexture --help"]),
            ("completions tcsh", &["'tcsh'", "zsh", "hypertexture --help"]),
            ("man rendr", &["no command `rendr`", "did you mean `render`?", "render, "]),
            ("man --all out.png", &["out.png: it is a file", "name a folder"]),
            ("man render --all man1", &["'--all <FOLDER>'", "cannot be used with"]),
            ("frobnicate", &["unrecognized subcommand 'frobnicate'", "hypertexture --help"]),
            ("render", &["not provided: <INPUT>; see"]),
            ("render torus --jitter blue", &["'blue'", "--jitter=blue"]),
            ("render torus --shadows maybe", &["'maybe'", "--shadows=maybe"]),
            ("render x", &["is called `x`; built in: "]),
            ("render torus --set quality.sampels=3", &["quality.sampels = 3", "did you mean `samples`?"]),
            ("render torus --set qualty.samples=3", &["qualty.samples = 3", "did you mean `quality`?"]),
            ("render torus --wrong", &["unexpected argument '--wrong' found; see"]),
            ("render torus --effect furr", &["no effect `furr`", "did you mean `fur`?", "melting"]),
            ("render torus --effect fur --set finenes=60", &["no parameter `finenes`", "did you mean `fineness`?"]),
            ("render torus --effect fur --set fineness=1e9", &["parameters.fineness = 1000000000", "from 2 to 200"]),
            ("render torus --effect fur --set fineness=nan", &["parameters.fineness = NaN", "from 2 to 200"]),
            ("render torus --effect fur --set fineness=#102030", &["parameters.fineness", "must be a number"]),
            ("render torus --effect fur --set fineness", &["--set = fineness", "PARAMETER=NUMBER"]),
            ("render torus --set fineness=60", &["no parameter `fineness`", "this effect has none"]),
            ("render torus --size 0x5", &["image.size = 0", "from 1 to 16384"]),
            ("render torus --size axb", &["image.size = axb", "2 numbers", "an x between", "(--size)"]),
            ("render torus --size 64", &["image.size = 64", "2 numbers", "an x between", "(--size)"]),
            ("render torus --samples 0", &["quality.samples = 0", "from 1 to 100000"]),
            ("render torus --samples -3", &["quality.samples = -3", "from 1 to 100000", "(--samples)"]),
            ("render torus --msaa 3", &["quality.msaa = 3: must be 1, 2, 4 or 8"]),
            (
                "render ensemble --set effect.weights=cubic",
                &["all objects share it", "--set parts.bite.effect.weights=cubic"],
            ),
            ("render torus --anisotropy 99", &["quality.anisotropy = 99", "from 1 to 16"]),
            ("render torus --clip 1,0,0", &["camera.clip = 1,0,0", "4 numbers", "commas", "(--clip)"]),
            ("render torus --clip 0,0,0,1", &["camera.clip", "normal of the plane"]),
            ("render torus --clip 1,x,0,0", &["camera.clip = 1,x,0,0", "4 numbers", "commas", "(--clip)"]),
            ("render torus --camera 30", &["--camera = 30", "azimuth,elevation[,zoom]"]),
            ("render torus --camera 30,100", &["camera.elevation = 100", "from -90 to 90"]),
            ("render torus --camera 30,20,nan", &["camera.zoom = NaN"]),
            ("render torus --light 1,2", &["light.position = 1,2", "3 numbers", "commas", "(--light)"]),
            ("render torus --time inf", &["camera.time = inf"]),
            ("render torus --background blue", &["image.background = blue", "#rrggbb", "(--background)"]),
            ("render torus --target float23", &["'float23'", "--target", "float32"]),
            ("render torus --module classify=sof", &["effect.classify `sof`", "did you mean `soft`?"]),
            ("render torus --module clasify=soft", &["clasify", "classify"]),
            ("render torus --module soft", &["--module = soft", "SLOT=MODULE"]),
            ("render torus --debug-view outline", &["'outline'", "slice-stack"]),
            ("render torus --depth 12", &["'12'", "16"]),
            ("render torus --iso nan", &["object.iso = NaN"]),
            ("render torus --grid smoke", &["torus: no grid is called `smoke`", "files of OpenVDB have grids"]),
            ("mesh torus --set object.grid=smoke", &["torus: no grid is called `smoke`"]),
            ("info pawn --grid smoke", &["pawn: no grid is called `smoke`"]),
            ("convert pawn --grid smoke -o a.stl", &["pawn: no grid is called `smoke`"]),
            ("render torus --resolution 4", &["object.resolution = 4", "from 8 to 1024"]),
            ("render torus -o picture.jpg", &["picture.jpg", ".png or .exr"]),
            ("render torus -o picture", &["picture", ".png or .exr"]),
            ("render torus -o missing/x.png", &["missing/x.png", "there is no folder missing"]),
            ("render torus --save-scene missing/s.toml", &["missing/s.toml", "there is no folder missing"]),
            (
                "bench nothing_of_that_name",
                &["nothing_of_that_name", "no row has such a name", "growth, encodings or proxies"],
            ),
            ("bench lit --repeat 0", &["--repeat 0", "from 1 to 1000"]),
            ("bench lit --json missing/b.json", &["missing/b.json", "there is no folder missing"]),
            ("bench lit --baseline missing.json", &["missing.json"]),
            ("bench lit --baseline /dev/zero", &["/dev/zero", "not a file"]),
            ("render torus --frames 9..3", &["'9..3'", "--frames", "A..B", "such as 1..100"]),
            ("render torus --frames 5", &["'5'", "--frames", "A..B"]),
            ("render torus --frames 0..9 --fps 0", &["--fps 0", "from 0.001 to 1000"]),
            ("render torus --frames 0..9 --fps nan", &["--fps NaN", "from 0.001 to 1000"]),
            ("render torus --frames 0..9 -o frames.jpg", &["frames.jpg", ".png or .exr"]),
            ("render torus --fps 10", &["--frames <A..B>"]),
            ("render torus --turntable", &["--frames <A..B>"]),
            ("render torus --shard 3/3", &["3/3", "K from 0 to N - 1", "such as 0/4"]),
            ("render torus --shard half", &["half", "write K/N"]),
            ("render torus --shard", &["--shard auto", "SLURM_ARRAY_TASK_ID", "JOB_COMPLETION_INDEX", "--shard K/N"]),
            ("render torus --predict --shard 0/2", &["--predict", "--shard"]),
            ("merge out.png", &["<SHARD>"]),
            ("merge new.png out.png", &["out.png", "not a shard of hypertexture", "--shard"]),
            ("merge new.png gone.shard-0-of-2", &["gone.shard-0-of-2"]),
            ("merge new.jpg out.png", &["new.jpg", ".png or .exr"]),
            ("field torus -o missing/f.nrrd", &["missing/f.nrrd", "there is no folder missing"]),
            ("field torus -o field.stl", &["field.stl", ".nrrd"]),
            ("field torus --margin -1", &["--margin", "-1"]),
            ("field torus --margin nan", &["--margin NaN", "from 0 to 4"]),
            ("field torus --resolution 2", &["object.resolution = 2", "8 to 1024", "(--resolution)"]),
            ("gallery torus --size 0x0", &["image.size = 0"]),
            ("compare", &["<SCENE>"]),
            ("compare fire --strategies lokups8", &["no strategy `lokups8`", "choose one of: "]),
            ("compare fire --samples 0", &["quality.samples = 0", "from 1 to"]),
            ("compare fire --sweep 16,x", &["'x'", "--sweep"]),
            ("compare fire --samples 2000000", &["quality.samples = 2000000", "from 1 to"]),
            ("compare fire --repeat 0", &["--repeat 0", "from 1 to 1000"]),
            ("compare fire --repeat many", &["'many'", "--repeat"]),
            ("compare fire --size 0x5", &["image.size = 0", "from 1 to 16384"]),
            ("compare fir", &["`fir`", "did you mean `fire`?"]),
            ("gallery -o out.png", &["out.png: it is a file; name a folder"]),
            ("compare torus --effect fir", &["no effect `fir`", "did you mean `fire`?"]),
            (
                "compare sphere --effect fire -o out.png",
                &["out.png: it is a file; name a folder", "nothing was written"],
            ),
            ("compare sphere --effect fire -o /proc/none", &["/proc/none", "nothing was written"]),
        ],
    );
}

#[test]
fn scene_files_that_are_wrong_are_refused_with_their_line() {
    let scenes: &[(&str, &str)] = &[
        ("broken.toml", "[quality]\nsamples = 64\n[image\n"),
        ("field.toml", "[quality]\nsample = 64\n"),
        ("table.toml", "[qualities]\nsamples = 64\n"),
        ("type.toml", "[quality]\n\nsamples = \"many\"\n"),
        ("name.toml", "[object]\ninput = \"torus\"\nfield_encoding = \"normals17\"\n"),
        ("color.toml", "[material]\ncolor = \"red\"\n"),
        ("preset.toml", "preset = \"fire_bal\"\n"),
        ("parameter.toml", "preset = \"fur\"\n[parameters]\nfinenes = 60\n"),
        ("range.toml", "[quality]\nsamples = 0\n"),
        ("module.toml", "[effect]\nsurface = \"litt\"\n"),
        ("stops.toml", "[transfer]\nstops = []\n"),
        ("object.toml", "[object]\ninput = \"missing.obj\"\n"),
    ];
    refused(
        |desk| {
            scenes.iter().for_each(|(name, content)| desk.write(name, content));
            desk.write("binary.toml", [0xff, 0xfe, 0x00]);
            fs::create_dir(desk.file("folder.toml")).unwrap();
        },
        &[
            ("render broken.toml", &["broken.toml:3:"]),
            ("render field.toml", &["field.toml:2:", "unknown field `sample`", "did you mean `samples`?"]),
            ("render table.toml", &["table.toml:1:", "unknown field `qualities`", "did you mean `quality`?"]),
            ("render type.toml", &["type.toml:3:", "many"]),
            ("render name.toml", &["name.toml:3:", "normals17", "did you mean `normals16`?"]),
            ("render color.toml", &["color.toml:2:", "`red` is not a color"]),
            ("render preset.toml", &["no effect `fire_bal`", "did you mean `fire_ball`?"]),
            ("render parameter.toml", &["no parameter `finenes`", "did you mean `fineness`?"]),
            ("render range.toml", &["quality.samples = 0", "from 1 to 100000"]),
            ("render module.toml", &["effect.surface `litt`", "did you mean `lit`?"]),
            ("render stops.toml", &["transfer.stops = 0 stops"]),
            ("render object.toml", &["missing.obj"]),
            ("render missing.toml", &["missing.toml"]),
            ("render folder.toml", &["folder.toml"]),
            ("render binary.toml", &["binary.toml"]),
        ],
    );
}

/// A binary STL that declares `declared` triangles and holds one.
fn stl(declared: u32, x: f32) -> Vec<u8> {
    let mut bytes = vec![0; 80];
    bytes.extend(declared.to_le_bytes());
    for number in [0.0, 0.0, 1.0, x, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0f32] {
        bytes.extend(number.to_le_bytes());
    }
    bytes.extend([0; 2]);
    bytes
}

/// A raw NRRD volume of `side`^3 floats as declared, with `values` in it.
fn nrrd(side: u32, values: &[f32]) -> Vec<u8> {
    let header = format!(
        "NRRD0004\ntype: float\ndimension: 3\nsizes: {side} {side} {side}\nspacings: 1 1 1\n\
         encoding: raw\nendian: little\n\n"
    );
    let mut bytes = header.into_bytes();
    bytes.extend(values.iter().flat_map(|value| value.to_le_bytes()));
    bytes
}

#[test]
fn object_files_that_are_wrong_are_refused_in_one_line() {
    let ramp: Vec<f32> = (0..512u16).map(f32::from).collect();
    let files: &[(&str, Vec<u8>)] = &[
        ("empty.stl", vec![]),
        ("empty.obj", vec![]),
        ("empty.nrrd", vec![]),
        ("points.xyz", b"0 0 0\n1 1 1\n".to_vec()),
        ("cut.stl", stl(12, 0.0)),
        ("cut.obj", b"v 0 0 0\nv 1 0 0\nv 0 1".to_vec()),
        ("cut.nrrd", nrrd(8, &ramp[..100])),
        ("huge.stl", stl(u32::MAX, 0.0)),
        ("huge.nrrd", nrrd(4_000_000_000, &ramp)),
        ("nan.stl", stl(1, f32::NAN)),
        ("nan.obj", b"v nan 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".to_vec()),
        ("corner.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n".to_vec()),
        ("points.obj", b"v 0 0 0\nv 1 0 0\nv 0 1 0\n".to_vec()),
        ("line.obj", b"v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n".to_vec()),
        ("flat.nrrd", nrrd(8, &[3.0; 512])),
        ("ramp.nrrd", nrrd(8, &ramp)),
    ];
    refused(
        |desk| {
            files.iter().for_each(|(name, content)| desk.write(name, content));
            fs::create_dir(desk.file("folder.stl")).unwrap();
        },
        &[
            ("render tors", &["`tors`", "did you mean `torus`?"]),
            ("render missing.stl", &["missing.stl"]),
            ("field missing.stl", &["missing.stl"]),
            ("render folder.stl", &["folder.stl"]),
            ("render empty.stl", &["empty.stl", "empty"]),
            ("render empty.obj", &["empty.obj", "empty"]),
            ("render empty.nrrd", &["empty.nrrd", "empty"]),
            ("render points.xyz", &["points.xyz", "format", "obj"]),
            ("render cut.stl", &["cut.stl", "byte", "declares"]),
            ("render cut.obj", &["cut.obj", "line 3"]),
            ("render cut.nrrd", &["cut.nrrd", "2048", "400"]),
            ("render huge.stl", &["huge.stl"]),
            ("render huge.nrrd", &["huge.nrrd"]),
            ("render nan.stl", &["nan.stl", "NaN"]),
            ("render nan.obj", &["nan.obj", "NaN"]),
            ("render corner.obj", &["corner.obj", "line 4", "9"]),
            ("render points.obj", &["points.obj", "no triangles"]),
            ("render line.obj", &["line.obj", "no triangles"]),
            ("render flat.nrrd", &["no surface at iso-value 3: all values are 3"]),
            ("render ramp.nrrd --iso 1000", &["no surface at iso-value 1000", "range from 0 to 511"]),
            ("field ramp.nrrd --iso nan", &["iso", "NaN"]),
        ],
    );
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn an_unknown_device_is_refused_with_the_known_ones() {
    let found: &[&str] = &["`nonsense`", "found: ", "HYPERTEXTURE_DEVICE"];
    refused(
        |_| {},
        &[
            ("DEVICE=nonsense render torus", found),
            ("render torus --device nonsense", found),
            ("gallery torus --device nonsense", found),
        ],
    );
}

/// A DMF in a file of that name, with that body and text before it.
fn dmf(desk: &Desk, name: &str, before: &str, body: &str) {
    let text = format!(
        "// A trial.\n// Source: a test.\n// Result: density.\n{before}\nfloat {name}(float density, Sample s) {{ {body} }}\n"
    );
    desk.write(&format!("{name}.glsl"), text);
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn harmful_glsl_is_refused_in_one_line() {
    let terms = format!("return density{};", "+density".repeat(20_000));
    let growing: String =
        (1..10).map(|k| format!("#define A{k} {}\n", vec![format!("A{}", k - 1); 10].join("+"))).collect();
    let address = "#extension GL_EXT_buffer_reference : require\nlayout(buffer_reference) buffer B { float v; };\n\
                   layout(push_constant) uniform P { B b; };";
    let prepare = |desk: &Desk| {
        dmf(desk, "nul", "", "return density; /* \0 */");
        dmf(desk, "terms", "", &terms);
        dmf(desk, "growing", &format!("#define A0 density+density\n{growing}"), "return A9;");
        dmf(desk, "huge", "", "float a[100000000]; a[int(s.density)] = density; return a[int(density)];");
        dmf(desk, "address", address, "return b.v;");
        dmf(desk, "outer", "// @outer zz", "return density;");
        dmf(desk, "long", &" ".repeat(300_000), "return density;");
    };
    refused(
        prepare,
        &[
            ("render torus --effect fire --dmf nul.glsl", &["dmf/nul.glsl:5: error: a NUL byte"]),
            ("render torus --effect fire --dmf terms.glsl", &["dmf/terms.glsl: the GLSL compiler crashed"]),
            ("explain torus --effect fire --dmf terms.glsl", &["dmf/terms.glsl: the GLSL compiler crashed"]),
            ("compare torus --effect fire --dmf terms.glsl -o report", &["dmf/terms.glsl: the GLSL compiler"]),
            ("render torus --effect fire --dmf growing.glsl", &["dmf/growing.glsl: the GLSL compiler", "without end"]),
            ("render torus --effect fire --dmf huge.glsl", &["dmf/huge.glsl: an array of 400000000 bytes", "4096"]),
            ("render torus --effect fire --dmf address.glsl", &["dmf/address.glsl: ", "capability 5347", "#extension"]),
            ("render torus --effect fire --dmf long.glsl", &["error: dmf/long.glsl: 300", "has at most 262144"]),
            ("render torus --effect fire --dmf outer.glsl", &["dmf/outer.glsl:4: ", "@outer zz", "@param"]),
        ],
    );
}

#[cfg(unix)]
#[test]
fn what_never_ends_is_not_read() {
    let prepare = |desk: &Desk| {
        // Beside the folder whose files are read before and after.
        for name in ["pipe.toml", "pipe.glsl", "pipe.obj", "pipe.png", "pipe.exr", "pipe.json"] {
            let made = std::process::Command::new("mkfifo").arg(desk.file(&format!("../{name}"))).status().unwrap();
            assert!(made.success());
        }
        std::os::unix::fs::symlink("/dev/zero", desk.file("../zero.toml")).unwrap();
        let line = vec![b'1'; (1 << 20) + 1];
        desk.write("line.obj", [b"v ", &*line].concat());
        desk.write("line.stl", [b"solid a\nfacet normal 0 0 ", &*line].concat());
        desk.write("line.nrrd", [b"NRRD0004\nsizes: ", &*line].concat());
        desk.write("lines.obj", [&*b"v 1 1 \\\n".repeat(200_000)].concat());
        desk.write("text.toml", b"about = \"a\"\n# \xff\n");
    };
    let pipe: &[&str] = &["a device, pipe or socket, not a file"];
    refused(
        prepare,
        &[
            ("render ../pipe.toml", pipe),
            ("render ../zero.toml", pipe),
            ("render ../pipe.obj", pipe),
            ("render ../pipe.png", pipe),
            ("render torus --dmf ../pipe.glsl", pipe),
            ("verify ../pipe.png", pipe),
            ("verify ../pipe.exr", pipe),
            ("merge x.png ../pipe.png", pipe),
            ("render line.obj", &["line.obj", "line 1", "a line of at most 1 MiB"]),
            ("render lines.obj", &["lines.obj", "a statement of at most 1 MiB"]),
            ("render line.stl", &["line.stl", "line 2", "a line of at most 1 MiB"]),
            ("render line.nrrd", &["line.nrrd", "line 2", "a line of at most 1 MiB"]),
            ("render text.toml", &["text.toml: line 2 is not text in UTF-8"]),
        ],
    );
}

#[test]
fn outputs_never_overwrite_inputs_or_each_other() {
    let read = "this command reads that file; give it a name of its own";
    let goes = "--output goes there; give it a name of its own";
    refused(
        |desk| {
            let face = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n";
            desk.write("a.obj", face);
            desk.write("s.toml", "[object]\ninput = \"a.obj\"\n");
            desk.write(
                "a.nhdr",
                "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 2 2 2\nencoding: raw\ndata file: a.npy\n",
            );
            desk.write("a.npy", [0, 0, 0, 0, 9, 9, 9, 9]);
            desk.write("a.nrrd", "NRRD0004\ntype: uint8\ndimension: 3\nsizes: 1 1 2\nencoding: ascii\n\n1 2\n");
            desk.write("b.json", "{}");
        },
        &[
            ("render torus -o x.png --save-scene x.png", &["--save-scene x.png: ", goes]),
            ("render torus -o x.png --save-scene ../work/x.png", &["--save-scene ../work/x.png: ", goes]),
            ("render torus -o x.png --error-map ./x.png", &["--error-map ./x.png: ", goes]),
            ("render torus --error-map y.png --validity y.png", &["--validity y.png: --error-map goes there"]),
            ("render torus --error-map y.exr --depth-map y.exr", &["--depth-map y.exr: --error-map goes there"]),
            ("render torus --validity y.png --save-scene y.png", &["--validity y.png: --save-scene goes there"]),
            ("render torus --frames 0..3 -o f_#.png --save-scene f_2.png", &["--save-scene f_2.png: ", goes]),
            ("render torus --frames 0..3 -o f.png --save-scene f.png.frames", &["--save-scene f.png.frames: ", goes]),
            ("render torus --shard 0/2 -o f.png --save-scene f.shard-0-of-2", &["f.shard-0-of-2: ", goes]),
            ("render s.toml --save-scene s.toml", &["--save-scene s.toml: ", read]),
            ("render s.toml --save-scene a.obj", &["--save-scene a.obj: ", read]),
            ("mesh a.obj -o a.obj", &["--output a.obj: ", read]),
            ("mesh s.toml -o a.obj", &["--output a.obj: ", read]),
            ("convert a.obj -o ./a.obj", &["--output ./a.obj: ", read]),
            ("convert a.nhdr -o a.npy", &["--output a.npy: ", read]),
            ("field a.nrrd -o a.nrrd", &["--output a.nrrd: ", read]),
            ("merge out.png out.png", &["OUTPUT out.png: ", read]),
            ("stress --json a.x --html a.x", &["--html a.x: --json goes there"]),
            ("bench lit --baseline b.json --json b.json", &["--json b.json: ", read]),
        ],
    );
}

#[cfg(unix)]
#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn names_are_written_as_they_are_or_refused_before_the_work() {
    use std::ffi::OsStr;
    use std::os::unix::ffi::OsStrExt;
    let desk = Desk::new();
    let small = "--size 16x16 --samples 8";
    let long = |count: usize, end: &str| "n".repeat(count - end.len()) + end;
    for (arguments, says) in [
        (format!("render torus -o {}", long(256, ".png")), "256 bytes"),
        (format!("render torus --frames 0..9 -o {}", long(251, ".png")), "256 bytes"),
        (format!("render torus --frames 0..9 -o {}", long(249, ".png")), "256 bytes"), // with `.frames`
        (format!("render torus --save-scene {}", long(256, ".toml")), "256 bytes"),
        (format!("mesh torus -o {}", long(256, ".stl")), "256 bytes"),
        (format!("field torus -o {}", long(300, ".nrrd")), "300 bytes"),
        (format!("gallery torus -o {}", long(260, "/x")), "too long"),
    ] {
        let output = desk.run(&arguments);
        let err = text(&output.stderr);
        assert!(
            output.status.code() == Some(2) && err.lines().count() == 1 && err.contains(says),
            "{arguments}: {err}"
        );
    }
    assert!(desk.files().is_empty());
    for count in [241, 255] {
        let name = long(count, ".png");
        desk.good(&format!("render torus {small} -o {name}"));
        assert_eq!(image::image_dimensions(desk.file(&name)).unwrap(), (16, 16));
    }
    let name = OsStr::from_bytes(b"\xe9t\xe9.png");
    let output = desk.command(&format!("render torus {small} --frames 0..1 -o")).arg(name).output().unwrap();
    let err = text(&output.stderr);
    assert!(output.status.code() == Some(2) && err.lines().count() == 1 && err.contains("must be UTF-8"), "{err}");
    assert_eq!(desk.files().len(), 2);
    assert!(desk.command(&format!("render torus {small} -o")).arg(name).status().unwrap().success());
    assert!(desk.work().join(name).exists());
}

#[cfg(unix)]
#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn no_file_takes_the_place_of_a_device_or_a_link() {
    use std::os::unix::fs::{PermissionsExt, symlink};
    let desk = Desk::new();
    symlink("/dev/full", desk.file("full.png")).unwrap();
    symlink("/dev/full", desk.file("full.toml")).unwrap();
    symlink("loop.png", desk.file("loop.png")).unwrap();
    desk.write("real.png", "an older picture");
    fs::set_permissions(desk.file("real.png"), fs::Permissions::from_mode(0o640)).unwrap();
    symlink("real.png", desk.file("link.png")).unwrap();
    for (arguments, reason) in [
        ("render torus -o full.png", "full.png: it is a device, pipe or socket, which no file may replace"),
        ("render torus --save-scene full.toml", "full.toml: it is a device"),
        ("render torus -o loop.png", "loop.png: it is a link that leads to itself"),
        ("render torus -o /proc/x.png", "/proc/x.png: "),
        ("gallery torus -o /proc/x", "/proc/x: "),
    ] {
        let output = desk.run(arguments);
        let err = text(&output.stderr);
        assert!(
            output.status.code() == Some(2) && err.lines().count() == 1 && err.contains(reason),
            "{arguments}: {err}"
        );
    }
    assert!(fs::symlink_metadata(desk.file("full.png")).unwrap().is_symlink());
    desk.good("render torus -o link.png --size 16x16 --samples 8");
    assert!(fs::symlink_metadata(desk.file("link.png")).unwrap().is_symlink());
    assert_eq!(image::image_dimensions(desk.file("real.png")).unwrap(), (16, 16));
    assert_eq!(fs::metadata(desk.file("real.png")).unwrap().permissions().mode() & 0o777, 0o640);
}

#[cfg(target_os = "linux")]
#[test]
fn output_that_is_full_is_no_success_and_no_panic() {
    let desk = Desk::new();
    let full = || fs::File::options().write(true).open("/dev/full").unwrap();
    let output = desk.command("settings").stdout(full()).output().unwrap();
    let err = text(&output.stderr);
    assert!(output.status.code() == Some(2) && err.starts_with("error: cannot write to standard output: "), "{err}");
    let output = desk.command("render nosuch").stderr(full()).output().unwrap();
    assert_eq!(output.status.code(), Some(2));
}
