//! The command line, run as a person runs it: what it writes, what it says, and how it refuses.
#![expect(clippy::unwrap_used, reason = "a test fails where a file or a process is not as described")]

use hypertexture::scene::ParameterValue;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

const SMALL: &str = "--size 64x64 --samples 32";

/// A working folder with a cache beside it; both vanish with the test.
struct Desk {
    root: tempfile::TempDir,
}

impl Desk {
    fn new() -> Desk {
        let root = tempfile::tempdir().unwrap();
        fs::create_dir(root.path().join("work")).unwrap();
        Desk { root }
    }

    fn work(&self) -> PathBuf {
        self.root.path().join("work")
    }

    fn file(&self, name: &str) -> PathBuf {
        self.work().join(name)
    }

    fn command(&self, arguments: &str) -> Command {
        let mut command = Command::new(env!("CARGO_BIN_EXE_hypertexture"));
        command.args(arguments.split_whitespace()).current_dir(self.work());
        command.env("HYPERTEXTURE_CACHE", self.root.path().join("cache"));
        command.env_remove("SLURM_ARRAY_TASK_ID").env_remove("JOB_COMPLETION_INDEX");
        command.env_remove("HYPERTEXTURE_LOG").env_remove("HYPERTEXTURE_VALIDATION");
        command.stdin(Stdio::null());
        command
    }

    fn run(&self, arguments: &str) -> Output {
        self.command(arguments).output().unwrap()
    }

    /// Runs what must succeed without a word on standard error; gives standard output.
    fn good(&self, arguments: &str) -> String {
        let output = self.run(arguments);
        let (out, err) = (text(&output.stdout), text(&output.stderr));
        assert!(output.status.success() && err.is_empty(), "`{arguments}`: {}\n{out}\n{err}", output.status);
        out
    }

    /// Every file below the working folder with its content.
    fn files(&self) -> BTreeMap<PathBuf, Vec<u8>> {
        let mut folders = vec![self.work()];
        let mut files = BTreeMap::new();
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                match path.is_dir() {
                    true => folders.push(path),
                    false => drop(files.insert(path.clone(), fs::read(&path).unwrap())),
                }
            }
        }
        files
    }

    fn write(&self, name: &str, content: impl AsRef<[u8]>) {
        fs::write(self.file(name), content).unwrap();
    }
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

/// Checks rows of arguments and what the one line on standard error must hold, on a desk that `prepare` has laid out.
/// A `DEVICE=name` before the arguments chooses a device.
fn refused(prepare: impl Fn(&Desk), rows: &[(&str, &[&str])]) {
    let mut failures = Vec::new();
    for (arguments, parts) in rows {
        let desk = Desk::new();
        desk.write("out.png", "an older picture");
        prepare(&desk);
        let before = desk.files();
        let output = match arguments.strip_prefix("DEVICE=").and_then(|rest| rest.split_once(' ')) {
            Some((device, rest)) => desk.command(rest).env("HYPERTEXTURE_DEVICE", device).output().unwrap(),
            None => desk.run(arguments),
        };
        let err = text(&output.stderr);
        let mut fail = |what: String| failures.push(format!("`{arguments}`: {what}\n    {}", err.trim_end()));
        if output.status.code() != Some(2) {
            fail(format!("{}, expected exit status 2", output.status));
        }
        if err.lines().count() != 1 || err.contains("panicked") {
            fail(format!("{} lines on standard error, expected 1", err.lines().count()));
        }
        for part in parts.iter().filter(|part| !err.contains(**part)) {
            fail(format!("the line does not say `{part}`"));
        }
        if !output.stdout.is_empty() {
            fail(format!("standard output is not empty: {}", text(&output.stdout)));
        }
        if desk.files() != before {
            fail("files were written or changed".into());
        }
    }
    assert!(failures.is_empty(), "{} failures\n{}", failures.len(), failures.join("\n"));
}

#[test]
fn arguments_that_make_no_sense_are_refused_in_one_line() {
    refused(
        |_| {},
        &[
            ("", &["error:", "command", "hypertexture --help"]),
            ("completions tcsh", &["'tcsh'", "zsh", "hypertexture --help"]),
            ("man rendr", &["man rendr", "unknown command", "render, "]),
            ("frobnicate", &["unrecognized subcommand 'frobnicate'", "hypertexture --help"]),
            ("render", &["<INPUT>"]),
            ("render torus --wrong", &["unexpected argument '--wrong'"]),
            ("render torus --effect furr", &["no effect `furr`", "did you mean `fur`?", "melting"]),
            ("render torus --effect fur --set finenes=60", &["no parameter `finenes`", "did you mean `fineness`?"]),
            ("render torus --effect fur --set fineness=1e9", &["parameters.fineness = 1000000000", "from 2 to 200"]),
            ("render torus --effect fur --set fineness=nan", &["parameters.fineness = NaN", "from 2 to 200"]),
            ("render torus --effect fur --set fineness=#102030", &["parameters.fineness", "must be a number"]),
            ("render torus --effect fur --set fineness", &["--set = fineness", "PARAMETER=NUMBER"]),
            ("render torus --set fineness=60", &["no parameter `fineness`", "this effect has none"]),
            ("render torus --size 0x5", &["image.size = 0", "from 1 to 16384"]),
            ("render torus --size axb", &["'axb'", "--size", "640x480"]),
            ("render torus --size 64", &["'64'", "--size", "640x480"]),
            ("render torus --samples 0", &["quality.samples = 0", "from 1 to 100000"]),
            ("render torus --samples -3", &["'-3'"]),
            ("render torus --msaa 3", &["quality.msaa = 3", "1, 2, 4 or 8"]),
            ("render torus --anisotropy 99", &["quality.anisotropy = 99", "from 1 to 16"]),
            ("render torus --clip 1,0,0", &["--clip = 3 numbers", "4 numbers: a,b,c,d"]),
            ("render torus --clip 0,0,0,1", &["camera.clip", "normal of the plane"]),
            ("render torus --clip 1,x,0,0", &["'1,x,0,0'", "--clip", "numbers with commas"]),
            ("render torus --camera 30", &["--camera = 1 numbers", "azimuth,elevation[,zoom]"]),
            ("render torus --camera 30,100", &["camera.elevation = 100", "from -90 to 90"]),
            ("render torus --camera 30,20,nan", &["camera.zoom = NaN"]),
            ("render torus --light 1,2", &["--light = 2 numbers", "3 numbers: x,y,z"]),
            ("render torus --time inf", &["camera.time = inf"]),
            ("render torus --background blue", &["--background = blue", "#rrggbb"]),
            ("render torus --target float23", &["--target = float23", "float32"]),
            ("render torus --module classify=sof", &["effect.classify `sof`", "did you mean `soft`?"]),
            ("render torus --module clasify=soft", &["clasify", "classify"]),
            ("render torus --module soft", &["--module = soft", "SLOT=MODULE"]),
            ("render torus --debug-view outline", &["'outline'", "slice-stack"]),
            ("render torus --depth 12", &["'12'", "16"]),
            ("render torus --iso nan", &["object.iso = NaN"]),
            ("render torus --resolution 4", &["object.resolution = 4", "from 8 to 1024"]),
            ("render torus -o picture.jpg", &["picture.jpg", ".png or .exr"]),
            ("render torus -o picture", &["picture", ".png or .exr"]),
            ("render torus -o missing/x.png", &["missing/x.png", "there is no folder missing"]),
            ("render torus --save-scene missing/s.toml", &["missing/s.toml", "there is no folder missing"]),
            ("render torus --frames 9..3", &["'9..3'", "--frames", "A..B", "such as 1..100"]),
            ("render torus --frames 5", &["'5'", "--frames", "A..B"]),
            ("render torus --frames 0..9 --fps 0", &["--fps 0", "from 0.001 to 1000"]),
            ("render torus --frames 0..9 --fps nan", &["--fps NaN", "from 0.001 to 1000"]),
            ("render torus --frames 0..9 -o frames.gif", &["frames.gif", ".png or .exr"]),
            ("render torus --fps 10", &["--frames <A..B>"]),
            ("render torus --turntable", &["--frames <A..B>"]),
            ("render torus --shard 3/3", &["3/3", "K from 0 to N - 1", "such as 0/4"]),
            ("render torus --shard half", &["half", "write K/N"]),
            ("render torus --shard", &["--shard auto", "SLURM_ARRAY_TASK_ID", "JOB_COMPLETION_INDEX", "--shard K/N"]),
            ("render torus --predict --shard 0/2", &["--predict", "--shard"]),
            ("merge out.png", &["<SHARD>"]),
            ("merge new.png out.png", &["out.png", "no shard of hypertexture", "render this shard again"]),
            ("merge new.png gone.shard-0-of-2", &["gone.shard-0-of-2"]),
            ("merge new.jpg out.png", &["new.jpg", ".png or .exr"]),
            ("field torus -o missing/f.nrrd", &["missing/f.nrrd", "there is no folder missing"]),
            ("field torus -o field.stl", &["field.stl", ".nrrd"]),
            ("field torus --margin -1", &["--margin", "-1"]),
            ("field torus --margin nan", &["--margin NaN", "from 0 to 4"]),
            ("field torus --resolution 2", &["resolution 2", "8 to 1024"]),
            ("gallery torus --size 0x0", &["image.size = 0"]),
            ("compare", &["<SCENE>"]),
            ("compare fire --strategies lokups8", &["no strategy `lokups8`", "choose one of: "]),
            ("compare fire --samples 0", &["quality.samples = 0", "from 1 to"]),
            ("compare fire --sweep 16,x", &["'x'", "--sweep"]),
            ("compare fire --samples 2000000", &["quality.samples = 2000000", "from 1 to"]),
            ("compare fire --repeat 0", &["--repeat 0", "from 1 to 1000"]),
            ("compare fire --repeat many", &["'many'", "--repeat"]),
            ("compare fire --size 0x5", &["image.size = 0", "from 1 to 16384"]),
            ("compare fir", &["fir"]),
            ("compare torus --effect fir", &["no effect `fir`", "did you mean `fire`?"]),
            ("compare sphere --effect fire -o out.png", &["out.png", "nothing was written"]),
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
        ("name.toml", "[object]\ninput = \"torus\"\nsource = \"normals17\"\n"),
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
    let mut hole = ramp.clone();
    hole[77] = f32::NAN;
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
        ("nan.nrrd", nrrd(8, &hole)),
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
            ("render nan.nrrd", &["nan.nrrd", "NaN", "77"]),
            ("render corner.obj", &["corner.obj", "line 4", "9"]),
            ("render points.obj", &["points.obj", "no triangles"]),
            ("render line.obj", &["line.obj", "no triangles"]),
            ("render flat.nrrd", &["no surface at iso-value 3"]),
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

fn size_of(path: &Path) -> (u32, u32) {
    image::image_dimensions(path).unwrap()
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_render_writes_the_picture_and_says_what_it_took() {
    let desk = Desk::new();
    let said = desk.good(&format!("render torus --effect fur -o x.png {SMALL}"));
    for start in ["device ", "program ", "left out ", "slices ", "time ", "memory ", "wrote "] {
        assert!(said.lines().any(|line| line.starts_with(start)), "no line `{start}`: {said}");
    }
    assert!(said.contains("dmf=fur") && said.contains("x.png"), "{said}");
    assert_eq!(size_of(&desk.file("x.png")), (64, 64));
    let bytes = fs::read(desk.file("x.png")).unwrap();
    assert!(bytes.windows(4).any(|window| window == b"sRGB"), "no sRGB chunk");
    assert_eq!(desk.files().len(), 1, "a render writes its picture and nothing else");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn what_changes_nothing_is_said_in_one_line() {
    let desk = Desk::new();
    let ignored = |arguments: &str| {
        let out = desk.good(&format!("render {arguments} --size 24x24 --samples 16"));
        let line = out.lines().find(|line| line.starts_with("ignored ")).unwrap_or_default();
        line.trim_start_matches("ignored").split(": the picture").next().unwrap_or_default().trim().to_string()
    };
    assert_eq!(ignored("torus --gradient central --seed 3"), "effect.gradient = \"central\", quality.seed = 3");
    assert_eq!(ignored("torus --effect fire --set effect.octaves=6 --time 2"), "effect.octaves = 6");
    assert_eq!(
        ignored("torus --pass march --order back_to_front --target unorm8"),
        "quality.order = \"back_to_front\""
    );
    assert_eq!(ignored("torus --effect shells --shadows"), "light.shadows = true");
    assert_eq!(ignored("fire_ball"), "", "what a preset sets is not said");
    assert_eq!(ignored("torus --depth 16 -o a.exr"), "--depth 16");
    let out = desk.good("render torus --module dmf=biased --set density_bias=0.7 --size 24x24 --samples 16");
    assert!(out.contains("dmf=biased") && !out.contains("ignored"), "a DMF makes a hard object soft: {out}");
    fs::write(desk.file("scene.toml"), "preset = \"fire\"\nobject.input = \"torus\"\nquality.seed = 4\n").unwrap();
    assert_eq!(ignored("scene.toml"), "quality.seed = 4");
    let out = desk.good("render torus --effect fire --size 24x24 --samples 16");
    assert!(out.contains("octaves    4 of 8: a block of 64 texels and 4 cells along a side holds no more"), "{out}");
    let out = desk.good("render torus --effect fire --set quality.turbulence_cells=1 --size 24x24 --samples 16");
    assert!(out.contains("octaves    6 of 8: "), "{out}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_quiet_render_says_nothing() {
    let desk = Desk::new();
    assert_eq!(desk.good(&format!("render torus --quiet -o x.png {SMALL}")), "");
    assert_eq!(size_of(&desk.file("x.png")), (64, 64));
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_closed_standard_output_is_no_error() {
    let desk = Desk::new();
    for arguments in ["effects", "--help", &format!("render torus -o x.png {SMALL}")] {
        let mut child = desk.command(arguments).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().unwrap();
        drop(child.stdout.take());
        let output = child.wait_with_output().unwrap();
        assert!(output.status.success(), "`{arguments}`: {}", output.status);
        assert_eq!(text(&output.stderr), "", "`{arguments}`");
    }
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_saved_scene_gives_the_same_picture() {
    let desk = Desk::new();
    let look = "--effect fire --set fury=1.5 --camera 10,20,1.2 --clip 0,0,1,0.4 --background #203040";
    desk.good(&format!("render torus {look} {SMALL} -o first.png --save-scene s.toml"));
    desk.good("render s.toml -o second.png");
    assert_eq!(fs::read(desk.file("first.png")).unwrap(), fs::read(desk.file("second.png")).unwrap());
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_module_of_a_preset_can_be_exchanged_although_the_preset_sets_its_parameters() {
    let said = Desk::new().good(&format!("render torus --effect fire --module medium=lit --set fury=1 {SMALL}"));
    assert!(said.contains("medium=lit"), "{said}");
}

const SWELL: &str = "// A power of the density.
// Source: none.
// density: in [0, 1]; result in [0, 1].
// @outer swell_width
// @param swell_width = 0.3 in [0.01, 1]: Width of the soft region, object units.
// @param swell_power = 0.5 in [0.1, 4]: The power.
float swell(float density, Sample s) { return pow(density, swell_power); }
";

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_module_of_ones_own_is_used_as_one_that_ships() {
    let desk = Desk::new();
    desk.write("swell.glsl", SWELL);
    let look = SMALL;
    desk.good(&format!("render sphere {look} -o plain.png"));
    let said =
        desk.good(&format!("render sphere --dmf swell.glsl --set swell_power=3 {look} -o own.png --save-scene s.toml"));
    assert!(said.contains("dmf=swell") && said.contains("linked now"), "{said}");
    desk.good("render s.toml -o again.png");
    let [plain, own, again] = ["plain.png", "own.png", "again.png"].map(|name| fs::read(desk.file(name)).unwrap());
    assert!(plain != own && own == again);
    let said = desk.good(&format!("render sphere --dmf swell.glsl {look} -o bound.png --max-error 0.05"));
    assert!(said.contains("dmf=swell") && said.contains("f64 reference"), "{said}");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_module_of_ones_own_that_is_wrong_is_refused_at_its_line() {
    let broken = |desk: &Desk| {
        desk.write("swell.glsl", SWELL.replace("pow(density, swell_power)", "pow(density, swell_powr)"));
        desk.write("other.glsl", SWELL);
    };
    refused(
        broken,
        &[
            ("render sphere -o out.png --dmf swell.glsl", &["swell", "7", "swell_powr"]),
            ("render sphere -o out.png --dmf other.glsl", &["other"]),
            ("render sphere -o out.png --dmf absent.glsl", &["absent.glsl"]),
        ],
    );
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn the_fastest_settings_within_an_error_is_drawn_and_remembered() {
    let desk = Desk::new();
    let first = desk.good(&format!("render lit -o a.png --max-error 0.03 --metric p999 {SMALL}"));
    assert!(first.contains("asked for 3.0e-2") && !first.contains("remembered"), "{first}");
    let second = desk.good(&format!("render lit -o b.png --max-error 0.03 --metric p999 {SMALL}"));
    assert!(second.contains("remembered"), "{second}");
    assert_eq!(fs::read(desk.file("a.png")).unwrap(), fs::read(desk.file("b.png")).unwrap());
    let rows: [(&str, &[&str]); 3] = [
        ("render lit -o out.png --max-error 1e-12 --size 16x16", &["no settings", "1e-12", "the nearest"]),
        ("render lit -o out.png --max-error 0", &["must be above 0"]),
        ("render lit -o out.png --max-error 0.1 --metric beauty", &["beauty", "rmse"]),
    ];
    refused(|_| (), &rows);
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_parameter_of_one_object_is_set_by_its_name() {
    let desk = Desk::new();
    let small = "--size 32x32 --samples 32";
    for (set, name) in [("", "as_is.png"), ("--set parts.stone.distortion=4", "stone.png")] {
        desk.good(&format!("render ensemble {set} {small} -o {name}"));
    }
    assert!(fs::read(desk.file("as_is.png")).unwrap() != fs::read(desk.file("stone.png")).unwrap());
    refused(
        |_| (),
        &[
            ("render ensemble -o out.png --set parts.ston.distortion=4", &["ston", "stone"]),
            ("render ensemble -o out.png --set parts.stone.distorsion=4", &["distorsion", "distortion"]),
        ],
    );
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn an_exr_and_a_png_of_16_bits_are_written_by_their_names() {
    let desk = Desk::new();
    desk.good(&format!("render sphere -o x.exr {SMALL}"));
    desk.good(&format!("render sphere -o x.png --depth 16 {SMALL}"));
    let exr = image::open(desk.file("x.exr")).unwrap();
    assert_eq!((exr.width(), exr.height(), exr.color()), (64, 64, image::ColorType::Rgba32F));
    assert_eq!(image::open(desk.file("x.png")).unwrap().color(), image::ColorType::Rgba16);
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn the_field_of_a_torus_renders_as_the_torus() {
    let desk = Desk::new();
    desk.good("field torus -o f.nrrd --resolution 64");
    desk.good(&format!("render f.nrrd -o field.png {SMALL}"));
    desk.good(&format!("render torus -o formula.png {SMALL}"));
    let [field, formula] = ["field.png", "formula.png"].map(|name| image::open(desk.file(name)).unwrap().to_rgba8());
    let differs = |(a, b): &(&image::Rgba<u8>, &image::Rgba<u8>)| a.0.iter().zip(b.0).any(|(a, b)| a.abs_diff(b) > 40);
    let different = field.pixels().zip(formula.pixels()).filter(differs).count();
    // The outline is found to half a voxel, 1/64 of the object: at most the pixels along it differ.
    assert!(different < 64 * 64 / 10, "{different} pixels differ");
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn a_gallery_has_six_pictures_and_a_page_that_names_them() {
    let desk = Desk::new();
    desk.good(&format!("gallery torus -o dir {SMALL}"));
    let page = fs::read_to_string(desk.file("dir/index.html")).unwrap();
    for effect in ["lit", "solid", "bump", "fur", "melting", "fire"] {
        assert_eq!(size_of(&desk.file(&format!("dir/{effect}.png"))), (64, 64));
        assert!(page.contains(&format!("{effect}.png")), "the page does not show {effect}");
    }
    assert_eq!(desk.files().len(), 7);
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn p58_a_gallery_without_an_object_has_every_figure_under_its_paper() {
    let desk = Desk::new();
    desk.good("gallery -o dir --size 16x16 --samples 16 --resolution 24");
    let page = fs::read_to_string(desk.file("dir/index.html")).unwrap();
    for name in hypertexture::scene::names() {
        assert_eq!(size_of(&desk.file(&format!("dir/{name}.png"))), (16, 16));
        assert!(page.contains(&format!("hypertexture render {name} -o {name}.png")), "no command for {name}");
    }
    let place = |text: &str| page.find(text).unwrap_or_else(|| panic!("`{text}` is not on the page"));
    assert!(place("<h2>Miller and Jones 2005") < place("id=\"fur\""));
    assert!(place("id=\"fur\"") < place("<h2>Perlin and Hoffert 1989"));
    assert!(place("<h2>Perlin and Hoffert 1989") < place("id=\"noisy_sphere\""));
}

#[test]
#[cfg_attr(no_gpu, ignore = "HYPERTEXTURE_NO_GPU is set")]
fn the_name_of_a_figure_renders_it_whole_and_an_effect_goes_over_it() {
    let desk = Desk::new();
    desk.good(&format!("render noisy_sphere -o x.png --save-scene s.toml {SMALL}"));
    let saved = hypertexture::scene::load(&desk.file("s.toml")).unwrap();
    let preset = hypertexture::scene::preset("noisy_sphere").unwrap();
    assert_eq!((saved.object, saved.effect, saved.camera), (preset.object, preset.effect, preset.camera));
    desk.good(&format!("render furry_donut --effect lit -o y.png --save-scene t.toml {SMALL}"));
    let saved = hypertexture::scene::load(&desk.file("t.toml")).unwrap();
    assert_eq!((saved.object.input.as_str(), saved.effect.surface.as_str()), ("torus", "lit"));
    assert!(saved.effect.dmf.is_empty());
}

#[test]
fn every_effect_is_listed_with_its_parameters() {
    let said = Desk::new().good("effects");
    for name in hypertexture::scene::names() {
        let scene = hypertexture::scene::preset(name).unwrap();
        assert!(said.contains(&format!("{name}: {}", scene.about)), "{name} is not listed");
        let about = said.split_once(&format!("{name}: ")).unwrap_or_default().1;
        for (parameter, value) in scene.check(&hypertexture::shader::shipped()).unwrap().iter() {
            let line = about.lines().find(|line| line.trim_start().starts_with(&format!("{} ", parameter.name)));
            let line = line.unwrap_or_else(|| panic!("{} of {name} is not listed", parameter.name));
            let value = match value {
                ParameterValue::Number(number) => number.to_string(),
                ParameterValue::Color(color) => String::from(*color),
            };
            assert!(line.contains(&format!(" {value} ")) && line.ends_with(&parameter.doc), "{line}: expected {value}");
        }
    }
}

#[test]
fn help_and_version_succeed() {
    let desk = Desk::new();
    for arguments in ["--help", "render --help", "field --help", "gallery --help", "help"] {
        assert!(desk.good(arguments).contains("Usage: hypertexture"), "{arguments}");
    }
    assert_eq!(desk.good("--version"), format!("hypertexture {}\n", env!("CARGO_PKG_VERSION")));
}

#[test]
fn completions_and_manual_pages_know_commands_and_arguments() {
    let desk = Desk::new();
    for shell in ["bash", "elvish", "fish", "powershell", "zsh"] {
        let script = desk.good(&format!("completions {shell}"));
        assert!(["gallery", "max-error"].iter().all(|word| script.contains(word)), "{shell}");
        assert!(!script.contains("memory-mib"), "{shell} completes a hidden command");
    }
    let program = desk.good("man");
    assert!(program.contains(".TH hypertexture 1") && program.contains("hypertexture\\-render(1)"), "{program}");
    let render = desk.good("man render");
    assert!(render.contains(".TH hypertexture-render 1") && render.contains("\\-\\-turntable"), "{render}");
    let hidden = ["draw", "rays"].map(|name| format!("hypertexture\\-{name}(1)"));
    assert!(hidden.iter().all(|name| !program.contains(name)), "{program}");
}
